"""The equations that the predictive controllers linearise: those of Pinocchio, for any arm and any payload."""

import numpy as np
import pinocchio as pin
import pytest
from torquebench.baselines.symbolic_dynamics import tool_function, torque_function
from torquebench.controllers import RobotModel

TOLERANCE = 1e-10

CRANE = """<robot name="crane"><link name="base"/>
<joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><origin xyz="0 0 0.4" rpy="0.2 0 0.1"/>
<axis xyz="0.6 0 0.8"/><limit lower="-1" upper="1" velocity="1" effort="100"/></joint>
<link name="cart"><inertial><origin xyz="0.1 0 0"/><mass value="3"/>
<inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0.001" ixz="0" iyz="0"/></inertial></link>
<joint name="turn" type="revolute"><parent link="cart"/><child link="arm"/><origin xyz="0 0.1 0.2" rpy="0 0.3 0"/>
<axis xyz="0 0.6 0.8"/><limit lower="-3" upper="3" velocity="1" effort="100"/></joint>
<link name="arm"><inertial><origin xyz="0 0 0.2"/><mass value="2"/>
<inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="mount" type="fixed"><parent link="arm"/><child link="flange"/><origin xyz="0 0.02 0.3" rpy="0.4 0 0.2"/>
</joint><link name="flange"/></robot>"""


@pytest.fixture(params=["planar", "six", "seven", "crane", "rizon"])
def arm(request, bench, rizon):
    """Arms whose joints turn about coordinate axes or oblique ones, or slide."""
    if request.param == "rizon":
        return rizon.model(rotor_inertia=rizon.rotor_inertia)
    if request.param == "crane":
        return RobotModel(CRANE, tool_frame="flange", flange_frame="flange", rotor_inertia=np.array([0.5, 0.2]))
    return bench(request.param).model


@pytest.mark.parametrize("seed", range(10))
def test_torque_and_derivatives_are_pinocchios(arm, seed):
    """A wrong sign in a Coriolis term would show only where limits bind: every entry is compared."""
    rng = np.random.default_rng(seed)
    pin.seed(seed)
    arm.set_payload(pin.Inertia.Random().toDynamicParameters())
    q, dq, ddq = rng.uniform(-1.5, 1.5, (3, arm.n))
    torque, derivatives = torque_function(arm)(q, dq, ddq, arm.payload, arm.rotor_inertia)
    pin.computeRNEADerivatives(arm.model, arm.data, q, dq, ddq)
    expected = np.hstack([arm.data.dtau_dq, arm.data.dtau_dv, arm.mass_matrix(q)])
    assert derivatives.full() == pytest.approx(expected, abs=TOLERANCE)
    assert torque.full().ravel() == pytest.approx(arm.inverse_dynamics(q, dq, ddq), abs=TOLERANCE)


def test_pose_and_jacobian_of_the_tool_are_the_models(arm):
    """The tool's cost and the law's own kinematics must speak of one point."""
    q = np.random.default_rng(1).uniform(-1.0, 1.0, arm.n)
    position, rotation, jacobian = tool_function(arm)(q)
    pose = arm.forward_kinematics(q)
    assert position.full().ravel() == pytest.approx(pose[:3, 3], abs=TOLERANCE)
    assert rotation.full() == pytest.approx(pose[:3, :3], abs=TOLERANCE)
    assert jacobian.full() == pytest.approx(arm.jacobian(q), abs=TOLERANCE)


def test_what_the_model_carries_is_an_argument_and_no_constant(arm):
    """One compilation serves every payload: the expression must not depend on the payload of the day."""
    q, dq, ddq = np.random.default_rng(2).uniform(-1.0, 1.0, (3, arm.n))
    bare = torque_function(arm)(q, dq, ddq, np.zeros(10), arm.rotor_inertia)[0].full()
    arm.set_payload(pin.Inertia(2.0, np.array([0.0, 0.0, 0.1]), 0.01 * np.eye(3)).toDynamicParameters())
    loaded = torque_function(arm)(q, dq, ddq, np.zeros(10), arm.rotor_inertia)[0].full()
    assert np.array_equal(bare, loaded)
