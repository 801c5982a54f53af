"""The model that every law is handed: the equations of motion, with a payload or a disturbance inside."""

import numpy as np
import pinocchio as pin
import pytest
from torquebench.controllers import InvalidInput, RobotModel, UnknownName

SIZES = pytest.mark.parametrize("n", [1, 2, 6, 7])
L1, L2, M1, M2, G = 0.5, 0.4, 3.0, 2.0, 9.81


def state(rng, n):
    """Return random positions, velocities and accelerations."""
    return rng.uniform(-2, 2, n), rng.normal(size=n), rng.normal(size=n)


def test_two_pendulums_have_the_mass_matrix_of_the_textbook(double_pendulum, rng):
    """Point masses on massless rods: the one arm whose inertia anybody can check by hand."""
    q, dq, _ = state(rng, 2)
    cosine = np.cos(q[1])
    outer = M2 * L2**2 + M2 * L1 * L2 * cosine
    inner = (M1 + M2) * L1**2 + M2 * L2**2 + 2 * M2 * L1 * L2 * cosine
    expected = np.array([[inner, outer], [outer, M2 * L2**2]])
    assert np.allclose(double_pendulum.at(q, dq).mass_matrix, expected, rtol=0, atol=1e-13)
    assert np.allclose(double_pendulum.mass_matrix(q), expected, rtol=0, atol=1e-13)


def test_two_pendulums_have_the_bias_of_the_textbook(double_pendulum, rng):
    """Centrifugal and Coriolis torque with their signs, and gravity."""
    q, dq, _ = state(rng, 2)
    swirl = M2 * L1 * L2 * np.sin(q[1])
    velocity = np.array([-swirl * (2 * dq[0] * dq[1] + dq[1] ** 2), swirl * dq[0] ** 2])
    hanging = M2 * G * L2 * np.sin(q[0] + q[1])
    gravity = np.array([(M1 + M2) * G * L1 * np.sin(q[0]) + hanging, hanging])
    found = double_pendulum.at(q, dq)
    assert np.allclose(found.gravity, gravity, rtol=0, atol=1e-13)
    assert np.allclose(found.bias, velocity + gravity, rtol=0, atol=1e-13)


def test_two_pendulums_have_the_pose_and_jacobian_of_the_textbook(double_pendulum, rng):
    """Base-aligned axes at the tool point, linear before angular."""
    q, dq, _ = state(rng, 2)
    total = q[0] + q[1]
    found = double_pendulum.at(q, dq)
    tip = [L1 * np.sin(q[0]) + L2 * np.sin(total), 0.0, -L1 * np.cos(q[0]) - L2 * np.cos(total)]
    across = np.array([L1 * np.cos(q[0]) + L2 * np.cos(total), L2 * np.cos(total)])
    along = np.array([L1 * np.sin(q[0]) + L2 * np.sin(total), L2 * np.sin(total)])
    zero, one = np.zeros(2), np.ones(2)
    assert np.allclose(found.position, tip, rtol=0, atol=1e-14)
    assert np.allclose(found.jacobian, [across, zero, along, zero, -one, zero], rtol=0, atol=1e-14)


@SIZES
def test_mass_times_acceleration_plus_bias_is_the_torque(arm_of, rng, n):
    """The equation every law inverts, rotor inertia included."""
    arm = arm_of(n)
    q, dq, ddq = state(rng, n)
    found = arm.at(q, dq)
    assert np.allclose(found.mass_matrix @ ddq + found.bias, arm.inverse_dynamics(q, dq, ddq), rtol=0, atol=1e-11)


@SIZES
def test_the_equation_holds_with_a_payload(arm_of, brick, rng, n):
    """The payload enters mass matrix, bias and inverse dynamics alike, or computed torque would fight itself."""
    arm = arm_of(n)
    arm.set_payload(brick.parameters)
    q, dq, ddq = state(rng, n)
    found = arm.at(q, dq)
    assert np.allclose(found.mass_matrix @ ddq + found.bias, arm.inverse_dynamics(q, dq, ddq), rtol=0, atol=1e-11)


@SIZES
def test_the_equation_holds_with_a_disturbance_already_subtracted(arm_of, rng, n):
    """M a + bias = tau with nothing to add; a law uses bias or gravity, never both."""
    arm = arm_of(n)
    q, dq, ddq = state(rng, n)
    plain, inverse = arm.at(q, dq).bias.copy(), arm.inverse_dynamics(q, dq, ddq).copy()
    resting = arm.gravity(q)
    disturbance = rng.normal(size=n)
    arm.set_disturbance(disturbance)
    found = arm.at(q, dq)
    assert np.allclose(found.bias, plain - disturbance, rtol=0, atol=1e-13)
    assert np.allclose(found.gravity, resting - disturbance, rtol=0, atol=1e-13)
    assert np.allclose(arm.gravity(q), resting - disturbance, rtol=0, atol=1e-13)
    assert np.allclose(arm.inverse_dynamics(q, dq, ddq), inverse - disturbance, rtol=0, atol=1e-12)


@SIZES
def test_a_payload_is_the_same_as_a_body_built_into_the_arm(arm_of, brick, rng, n):
    """Ten parameters about the flange against Pinocchio's own way of adding a body."""
    arm = arm_of(n)
    arm.set_payload(brick.parameters)
    built_in = arm_of(n)
    flange = built_in.model.frames[built_in.flange_id]
    body = pin.Inertia(brick.mass, np.array(brick.com), np.array(brick.inertia))
    built_in.model.appendBodyToJoint(flange.parentJoint, body, flange.placement)
    data = built_in.model.createData()
    for _ in range(10):
        q, dq, ddq = state(rng, n)
        expected = pin.rnea(built_in.model, data, q, dq, ddq)
        assert np.allclose(arm.inverse_dynamics(q, dq, ddq), expected, rtol=0, atol=1e-11)
        assert np.allclose(arm.mass_matrix(q), pin.crba(built_in.model, data, q), rtol=0, atol=1e-12)


def test_taking_the_payload_off_leaves_no_trace_of_it(arm_of, brick, rng):
    """Load steps go up and down; nothing may stick, to the bit."""
    arm, bare = arm_of(7), arm_of(7)
    bare.set_payload(np.zeros(10))
    q, dq, ddq = state(rng, 7)
    arm.set_payload(brick.parameters)
    arm.set_payload(np.zeros(10))
    assert np.array_equal(arm.inverse_dynamics(q, dq, ddq), bare.inverse_dynamics(q, dq, ddq))


@SIZES
def test_no_payload_leaves_no_nan(arm_of, rng, n):
    """A massless body has no centre of mass; dividing by its mass would poison every torque."""
    arm = arm_of(n)
    arm.set_payload(np.zeros(10))
    found = arm.at(*state(rng, n)[:2])
    assert np.all(np.isfinite(found.mass_matrix))
    assert np.all(np.isfinite(found.bias))


@SIZES
def test_the_jacobian_bias_is_the_derivative_of_the_jacobian_times_the_velocity(arm_of, rng, n):
    """Central differences along the motion; the tool is set off and turns, so that a wrong frame would show."""
    arm = arm_of(n)
    q, dq, _ = state(rng, n)
    h = 1e-5
    slope = (arm.jacobian(q + h * dq) - arm.jacobian(q - h * dq)) / (2 * h)
    assert np.linalg.norm(arm.at(q, dq).jacobian[3:] @ dq) > 0.1
    assert np.allclose(arm.at(q, dq).jacobian_bias, slope @ dq, rtol=0, atol=2e-8)


@SIZES
def test_the_jacobian_takes_joint_velocities_to_the_tools_twist(arm_of, rng, n):
    """Base-aligned axes at the tool point, by differences of the pose."""
    arm = arm_of(n)
    q, dq, _ = state(rng, n)
    h = 1e-6
    before, after = arm.forward_kinematics(q - h * dq), arm.forward_kinematics(q + h * dq)
    spin = (after[:3, :3] - before[:3, :3]) @ arm.forward_kinematics(q)[:3, :3].T / (2 * h)
    twist = [*((after[:3, 3] - before[:3, 3]) / (2 * h)), spin[2, 1], spin[0, 2], spin[1, 0]]
    assert np.allclose(arm.jacobian(q) @ dq, twist, rtol=0, atol=1e-8)
    assert np.allclose(arm.jacobian(q), arm.at(q, dq).jacobian, rtol=0, atol=1e-14)


@SIZES
def test_gravity_torque_is_the_slope_of_potential_energy(arm_of, brick, rng, n):
    """The payload's weight included."""
    arm = arm_of(n)
    arm.set_payload(brick.parameters)
    q = rng.uniform(-2, 2, n)
    data, h, slope = arm.model.createData(), 1e-5, np.empty(n)
    for i, step in enumerate(np.eye(n) * h):
        up = pin.computePotentialEnergy(arm.model, data, q + step)
        slope[i] = (up - pin.computePotentialEnergy(arm.model, data, q - step)) / (2 * h)
    assert np.allclose(arm.gravity(q), slope, rtol=0, atol=1e-7)


def test_rotor_inertia_stands_on_the_diagonal_alone(arm_of, rng):
    """Reflected rotors load their own joint and no other."""
    bare, geared = arm_of(7, rotor=0.0), arm_of(7, rotor=0.4)
    q = rng.uniform(-2, 2, 7)
    assert np.allclose(geared.mass_matrix(q) - bare.mass_matrix(q), 0.4 * np.eye(7), rtol=0, atol=1e-14)


@SIZES
def test_the_mass_matrix_is_symmetric_and_positive(arm_of, brick, rng, n):
    """Both triangles are filled: a law may use either."""
    arm = arm_of(n)
    arm.set_payload(brick.parameters)
    found = arm.at(*state(rng, n)[:2]).mass_matrix
    assert np.array_equal(found, found.T)
    assert np.linalg.eigvalsh(found).min() > 0


def test_payload_and_disturbance_are_never_both_set(arm_of, brick, rng):
    """A provider says either what hangs there or what pulls; both together would count a load twice."""
    arm = arm_of(7)
    arm.set_payload(brick.parameters)
    arm.set_disturbance(np.ones(7))
    assert not arm.payload.any()
    assert np.array_equal(arm.disturbance, np.ones(7))
    arm.set_payload(brick.parameters)
    assert not arm.disturbance.any()


def test_a_disturbance_after_a_payload_leaves_the_bare_arms_inertia(arm_of, brick, rng):
    """The mass matrix must not remember the payload that the disturbance replaced."""
    arm, bare = arm_of(7), arm_of(7)
    arm.set_payload(brick.parameters)
    arm.set_disturbance(np.ones(7))
    q = rng.uniform(-2, 2, 7)
    assert np.array_equal(arm.mass_matrix(q), bare.mass_matrix(q))


def test_payload_and_disturbance_are_read_only_to_a_law(arm_of):
    """Only knowledge may change what the model knows."""
    arm = arm_of(2)
    with pytest.raises(ValueError, match="read-only"):
        arm.payload[0] = 5.0
    with pytest.raises(ValueError, match="read-only"):
        arm.disturbance[0] = 5.0


def test_the_revision_grows_with_every_change(arm_of, brick):
    """A planner looks at it to know when its matrices are stale."""
    arm = arm_of(2)
    seen = [arm.revision]
    for change in (lambda: arm.set_payload(brick.parameters), lambda: arm.set_disturbance(np.ones(2))):
        change()
        seen.append(arm.revision)
    assert seen == sorted(set(seen))


def test_a_copy_knows_the_same_and_goes_its_own_way(arm_of, brick, rng):
    """Providers and planners work on copies of the controller's model."""
    arm = arm_of(7)
    q, dq, ddq = state(rng, 7)
    arm.set_payload(brick.parameters)
    other = arm.copy()
    expected = arm.inverse_dynamics(q, dq, ddq).copy()
    assert np.array_equal(other.inverse_dynamics(q, dq, ddq), expected)
    other.set_payload(np.zeros(10))
    assert np.array_equal(arm.inverse_dynamics(q, dq, ddq), expected)
    arm.set_disturbance(np.ones(7))
    assert np.array_equal(arm.copy().disturbance, np.ones(7))


def test_one_record_is_refilled_and_copies_are_not(arm_of, rng):
    """``at`` costs no allocation; what is documented as a new array must survive the next call."""
    arm = arm_of(7)
    first, second = state(rng, 7), state(rng, 7)
    record = arm.at(*first[:2])
    kept = {name: getattr(arm, name)(first[0]) for name in ("gravity", "mass_matrix", "jacobian", "forward_kinematics")}
    copies = {name: array.copy() for name, array in kept.items()}
    assert arm.at(*second[:2]) is record
    assert all(np.array_equal(kept[name], copies[name]) for name in kept)
    assert np.array_equal(record.pose, arm.forward_kinematics(second[0]))


def test_flange_and_tool_are_apart_by_the_hand(arm_of, rng):
    """The hand is fixed, wherever the arm is."""
    arm = arm_of(7)
    hands = [np.linalg.inv(arm.flange_pose(q)) @ arm.forward_kinematics(q) for q in rng.uniform(-2, 2, (2, 7))]
    assert np.allclose(hands[0], hands[1], rtol=0, atol=1e-14)
    assert np.allclose(hands[0][:3, 3], [0.05, 0.03, 0.12], rtol=0, atol=1e-14)


def test_a_tool_path_is_the_pose_of_every_row(arm_of, rng):
    """Logs are turned into tool poses at once, also from a slice with strides."""
    arm = arm_of(6)
    q = rng.uniform(-2, 2, (9, 12))[:, ::2]
    positions, rotations = arm.tool_path(q)
    for k, row in enumerate(q):
        pose = arm.forward_kinematics(np.ascontiguousarray(row))
        assert np.allclose(positions[k], pose[:3, 3], rtol=0, atol=1e-14)
        assert np.allclose(rotations[k], pose[:3, :3], rtol=0, atol=1e-14)


def test_a_tool_motion_is_jacobian_times_velocity_at_every_row(arm_of, rng):
    """What velocity metrics read; independent: the record that controllers see, and the slope of the poses."""
    arm = arm_of(6)
    q, dq = rng.uniform(-1.0, 1.0, (2, 20, 6))
    positions, rotations, twists = arm.tool_motion(q, dq)
    for k in range(20):
        assert np.allclose(twists[k], arm.at(q[k], dq[k]).jacobian @ dq[k], rtol=0, atol=1e-12)
    step = 1e-6
    ahead, behind = (arm.tool_path(q + sign * step * dq)[0] for sign in (1.0, -1.0))
    assert np.allclose(twists[:, :3], (ahead - behind) / (2.0 * step), rtol=0, atol=1e-7)
    assert np.array_equal(positions, arm.tool_path(q)[0])
    assert np.array_equal(rotations, arm.tool_path(q)[1])


def test_limits_come_from_the_urdf(arm_of):
    """The harness and every planner read them here."""
    arm = arm_of(6)
    assert (arm.n, arm.lower[0], arm.upper[5], arm.velocity[2], arm.effort[3]) == (6, -3.0, 3.0, 4.0, 80.0)


def test_an_unknown_frame_names_the_nearest(urdf_of):
    """A tool frame is typed by hand."""
    with pytest.raises(UnknownName, match="unknown frame 'flnge'; did you mean 'flange'"):
        RobotModel(urdf_of("yy"), tool_frame="tool", flange_frame="flnge", rotor_inertia=np.zeros(2))


def test_a_continuous_joint_is_refused_with_its_name(urdf_of):
    """Pinocchio gives it two coordinates; every law here counts on one."""
    text = urdf_of("yy").replace('name="joint2" type="revolute"', 'name="joint2" type="continuous"')
    with pytest.raises(InvalidInput, match="joint 'joint2' has 2 coordinates"):
        RobotModel(text, tool_frame="tool", flange_frame="flange", rotor_inertia=np.zeros(2))


def test_what_is_no_urdf_is_refused_in_one_line():
    """No parser's traceback reaches a person."""
    with pytest.raises(InvalidInput, match="is not a readable URDF") as caught:
        RobotModel("<robot><oops", tool_frame="tool", flange_frame="flange", rotor_inertia=np.zeros(2))
    assert "\n" not in str(caught.value)


def test_the_mass_beyond_the_flange_is_the_gripper(rizon):
    """A law that reads the load off the force sensor must know what is no load."""
    assert rizon.model().tool_mass == pytest.approx(1.186, abs=1e-12)
