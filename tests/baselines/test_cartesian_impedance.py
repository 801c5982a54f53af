"""Cartesian impedance: a spring with a known deflection, a damper with a known lag, a posture that nobody feels."""

import numpy as np
import pytest
from scipy.linalg import sqrtm
from scipy.spatial.transform import Rotation
from torquebench.baselines.cartesian_impedance import CartesianImpedance
from torquebench.baselines.damping import DAMPING_DESIGNS

GRAVITY = 9.81
FULL_FEEDFORWARD = {"velocity_feedforward": True, "acceleration_feedforward": True}


def spring(law):
    """Return the diagonal of K."""
    return np.repeat([law.linear_stiffness, law.angular_stiffness], 3)


def tool_damping(law, inertia):
    """Return D by dense linear algebra."""
    root = np.diag(np.sqrt(spring(law)))
    if law.damping_design == "square_root":
        mass = sqrtm(inertia).real
        return law.damping_ratio * (mass @ root + root @ mass)
    squares, vectors = np.linalg.eigh(root @ np.linalg.inv(inertia) @ root)
    return 2.0 * law.damping_ratio * root @ vectors @ np.diag(1.0 / np.sqrt(squares)) @ vectors.T @ root


def textbook_torque(law, model, observation, target):
    """Return the law as it is written, with the projector in full."""
    state = model.at(observation.q, observation.dq)
    mass, jacobian = state.mass_matrix, state.jacobian
    inertia = np.linalg.inv(jacobian @ np.linalg.solve(mass, jacobian.T))
    damping = tool_damping(law, inertia)
    rotation, desired = Rotation.from_matrix(state.rotation), Rotation.from_matrix(target.pose[:3, :3])
    turn = rotation.apply((rotation.inv() * desired).as_rotvec())
    error = np.concatenate([target.pose[:3, 3] - state.position, turn])
    twist = jacobian @ observation.dq
    limit = np.repeat([law.force_limit or np.inf, law.moment_limit or np.inf], 3)
    wrench = np.clip(spring(law) * error, -limit, limit) - damping @ twist
    if law.velocity_feedforward:
        wrench = wrench + damping @ target.twist
    if law.acceleration_feedforward:
        wrench = wrench + inertia @ (target.acceleration - state.jacobian_bias)
    posture = law.posture_stiffness * (target.q - observation.q) + law.posture_damping * (target.dq - observation.dq)
    projector = np.eye(model.n) - jacobian.T @ inertia @ jacobian @ np.linalg.inv(mass)
    return jacobian.T @ wrench + state.bias + projector @ mass @ (target.ddq + posture)


def perturbed(arm, *, time=0.3, seed=0):
    """Return a measured state off the plan, and the plan."""
    rng = np.random.default_rng(seed)
    q, dq, _ = arm.plan.joints(time)
    shift, push = 0.1 * rng.standard_normal(len(q)), 0.5 * rng.standard_normal(len(q))
    return arm.observe(time, q + shift, dq + push), arm.plan.target(time)


def torque_of(law, arm, observation, target):
    """Return one tick of a freshly reset law."""
    law.reset(arm.task())
    return law.compute(observation, target).copy()


@pytest.mark.parametrize("design", DAMPING_DESIGNS)
@pytest.mark.parametrize("arm", ["six", "seven"])
@pytest.mark.parametrize("feedforward", [{}, FULL_FEEDFORWARD, {"velocity_feedforward": True}])
def test_the_compiled_law_is_the_textbook_law(bench, design, arm, feedforward):
    """The tick never forms the projector or the inverse of M, and agrees to rounding."""
    arm = bench(arm, sway=0.2)
    for seed in range(3):
        observation, target = perturbed(arm, seed=seed)
        law = CartesianImpedance(damping_design=design, force_limit=800.0, **feedforward)
        expected = textbook_torque(law, arm.model, observation, target)
        assert torque_of(law, arm, observation, target) == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("arm", ["planar", "seven"])
@pytest.mark.parametrize("mass", [1.0, 2.0])
def test_an_unknown_load_deflects_the_spring(bench, load, arm, mass):
    """m g / K: 0.98 mm for each kilogram at 10 kN/m, straight down, with no turn of the tool."""
    arm = bench(arm)
    arm.plant.set_payload(load(mass, z=0.1))
    log = arm.run(CartesianImpedance(), 2.0)
    tool = arm.plant.forward_kinematics(log.q)
    deflection = log.target.pose[:3, 3] - tool[:3, 3]
    assert deflection == pytest.approx([0.0, 0.0, mass * GRAVITY / 10000.0], abs=2e-6)
    assert tool[:3, :3] == pytest.approx(log.target.pose[:3, :3], abs=1e-5)


def test_full_feedforward_follows_a_known_arm(bench):
    """The lag of the factory preset is no limit of impedance control."""
    arm = bench(sway=0.2)
    log = arm.run(CartesianImpedance(**FULL_FEEDFORWARD), 0.5)
    assert np.abs(log.error).max() < 1e-3


def test_without_velocity_feedforward_the_tool_lags(bench):
    """K e = D v in slow motion: a lag of about 2 zeta / omega along each eigendirection."""
    arm, law = bench(sway=0.02), CartesianImpedance(damping_design="double_diagonalisation")
    log = arm.run(law, 0.5)
    state = arm.plant.at(log.q, log.dq)
    inertia = np.linalg.inv(state.jacobian @ np.linalg.solve(state.mass_matrix, state.jacobian.T))
    expected = (tool_damping(law, inertia) @ state.jacobian @ log.dq) / spring(law)
    lag = log.target.pose[:3, 3] - state.position
    assert lag == pytest.approx(expected[:3], abs=0.1 * np.linalg.norm(expected[:3]))


@pytest.mark.parametrize("arm", ["planar4", "seven"])
def test_the_posture_does_not_accelerate_the_tool(bench, arm):
    """J M^-1 N^T = 0: what the null space does, the tool never feels."""
    arm = bench(arm, sway=0.2)
    observation, target = perturbed(arm)
    stiff, free = (CartesianImpedance(posture_stiffness=k) for k in (100.0, 0.0))
    change = torque_of(stiff, arm, observation, target) - torque_of(free, arm, observation, target)
    state = arm.model.at(observation.q, observation.dq)
    acceleration = np.linalg.solve(state.mass_matrix, change)
    assert np.linalg.norm(acceleration) > 0.1
    assert state.jacobian @ acceleration == pytest.approx(np.zeros(6), abs=1e-9)


@pytest.mark.parametrize("arm", ["planar", "six"])
def test_an_arm_without_redundancy_has_no_posture(bench, arm):
    """The projector is zero: the tool's pose says it all."""
    arm = bench(arm, sway=0.2)
    observation, target = perturbed(arm)
    stiff, free = (CartesianImpedance(posture_stiffness=k) for k in (100.0, 0.0))
    change = torque_of(stiff, arm, observation, target) - torque_of(free, arm, observation, target)
    assert change == pytest.approx(np.zeros(arm.model.n), abs=1e-7)


def test_the_elbow_follows_the_planned_posture(bench):
    """A fixed posture would show joint errors of 100 mrad at no error of the tool."""
    arm = bench(sway=0.2)
    log = arm.run(CartesianImpedance(**FULL_FEEDFORWARD), 2.0, offset=0.05)
    assert np.abs(log.error[-1]).max() < 2e-3


def test_a_limited_spring_keeps_its_damper(bench):
    """The limit is on K e per axis, not on the sum: far away the law still brakes."""
    arm = bench()
    q, dq, _ = arm.plan.joints(0.0)
    moving = 0.3 * np.ones(7)
    law = CartesianImpedance(force_limit=20.0, moment_limit=2.0, posture_stiffness=0.0)
    target = arm.plan.target(0.0)
    away = torque_of(law, arm, arm.observe(0.0, q + 0.3, dq), target)
    braked = torque_of(law, arm, arm.observe(0.0, q + 0.3, dq + moving), target)
    state = arm.model.at(q + 0.3, dq)
    bound = np.abs(state.jacobian.T) @ np.repeat([20.0, 2.0], 3)
    assert np.all(np.abs(away - arm.model.gravity(q + 0.3)) <= bound + 1e-9)
    assert (braked - away) @ moving < -1.0


def test_a_tool_turned_by_half_a_revolution_is_pulled_back_with_a_finite_torque(bench):
    """Near pi the error's direction may flip, its size may not."""
    arm = bench()
    q, dq, _ = arm.plan.joints(0.0)
    turned = q + np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, np.pi])
    state = arm.model.at(turned, dq)
    law = CartesianImpedance()
    torque = torque_of(law, arm, arm.observe(0.0, turned, dq), arm.plan.target(0.0))
    axis_torque = torque[6] - arm.model.gravity(turned)[6]
    assert abs(axis_torque) == pytest.approx(law.angular_stiffness * np.pi, rel=0.2)
    assert state.jacobian[3:, 6] @ state.jacobian[3:, 6] == pytest.approx(1.0)


@pytest.mark.parametrize("design", DAMPING_DESIGNS)
def test_the_torque_goes_smoothly_through_a_singularity(bench, design):
    """Lost directions carry neither damping nor posture torque: stretched feels like nearly stretched."""
    arm, law = bench(), CartesianImpedance(damping_design=design, velocity_feedforward=True)
    push, torques = 0.1 * np.ones(7), []
    for bend in (0.0, 1e-9, 1e-6, 1e-3):
        q = bend * np.ones(7)
        arm.plan.centre = q + 0.01
        torques.append(torque_of(law, arm, arm.observe(0.0, q, push), arm.plan.target(0.0)))
    assert np.ptp(torques, axis=0).max() < 0.01 * np.abs(torques).max()
