"""Momentum observer: the torque that nobody commanded, as a first-order filter, with the sign that helps."""

import numpy as np
import pytest
from torquebench.baselines.computed_torque import ComputedTorque
from torquebench.baselines.momentum_observer import MomentumObserver
from torquebench.baselines.momentum_residual import MomentumResidual
from torquebench.controllers import Actuation, InvalidInput, discovery
from torquebench.scenarios.episode import run_episode
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.world import World

H = 1e-3
USUAL = {"controller": "computed_torque", "trajectory": "S1", "tier": "actuated", "plant": "pinocchio"} | {
    "robot": "rizon4s",
    "laps": 1,
}


class Poison:
    """The truth, which no estimator may look at."""

    def __getattribute__(self, name):
        raise AssertionError(f"an estimator read {name!r} of the truth")


def drives(velocity_filter_hz=None):
    """Return drives without limits."""
    return Actuation(
        tier="exact",
        delay_ticks=0,
        torque_lag=0.0,
        velocity_filter_hz=velocity_filter_hz,
        effort=np.full(7, 300.0),
        torque_rate=None,
        rotor_inertia=np.zeros(7),
    )


def observer(model, actuation=None, **settings):
    """Return an observer after its reset."""
    provider = MomentumObserver(**settings)
    provider.reset(model, actuation or drives(), Poison())
    return provider


def at_rest(arm, provider, ticks):
    """Hold an arm still under its true gravity torque; returns the residual of every tick."""
    q = arm.plan.centre
    observation = arm.observe(0.0, q, np.zeros(arm.model.n), arm.plant.gravity(q))
    residuals = []
    for _ in range(ticks):
        provider.refresh(observation)
        residuals.append(provider.residual)
    return np.array(residuals)


def swayed(arm, provider, seconds):
    """Move an exact plant by a law that knows it, and watch; returns the residual at the end."""
    law, knowing = ComputedTorque(), arm.plant.copy()
    task = arm.task()
    law.reset(task)
    law.robot = knowing
    q, dq, _ = arm.plan.joints(0.0)
    torque = None
    for k in range(round(seconds / H)):
        observation = arm.observe(k * H, q, dq, torque)
        provider.refresh(observation)
        torque = law.compute(observation, arm.plan.target(k * H)).copy()
        state = arm.plant.at(q, dq)
        dq = dq + H * np.linalg.solve(state.mass_matrix, torque - state.bias)
        q = q + H * dq
    return provider.residual


@pytest.mark.parametrize("arm_name", ["planar", "six", "seven"])
def test_at_rest_it_is_the_torque_of_the_unknown_load(bench, load, arm_name):
    """J^T f: with the sign of what acts on the arm, that is, minus the load's gravity torque."""
    arm = bench(arm_name)
    arm.plant.set_payload(load(2.0, z=0.1))
    q = arm.plan.centre
    wrench = np.concatenate([[0.0, 0.0, -2.0 * 9.81], np.zeros(3)])
    # The conftest's load is 0.1 m beyond the flange, where the tool point is.
    expected = arm.model.jacobian(q).T @ wrench
    assert at_rest(arm, observer(arm.model), 400)[-1] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("gain", [5.0, 50.0, 500.0, 1e6])
def test_it_converges_with_its_own_time_constant(bench, load, gain):
    """r = d (1 - exp(-K t)), exactly and for every gain: the discrete form cannot be unstable."""
    arm = bench()
    arm.plant.set_payload(load(2.0, z=0.1))
    residual = at_rest(arm, observer(arm.model, gain=gain), 100)
    constant = arm.model.copy()
    constant.set_disturbance(np.zeros(7))
    missing = constant.gravity(arm.plan.centre) - arm.plant.gravity(arm.plan.centre)
    expected = missing * (1.0 - np.exp(-gain * H * np.arange(100)))[:, None]
    assert residual == pytest.approx(expected, abs=1e-9)


def test_the_model_then_balances(bench, load):
    """M a + bias = tau: the told model asks for the torque that the loaded arm needs."""
    arm = bench()
    arm.plant.set_payload(load(2.0, z=0.1))
    at_rest(arm, observer(arm.model), 600)
    assert arm.model.gravity(arm.plan.centre) == pytest.approx(arm.plant.gravity(arm.plan.centre), abs=1e-6)


def test_payload_and_disturbance_are_never_both_told(bench, load):
    """A payload of an earlier run would count twice."""
    arm = bench()
    arm.model.set_payload(load(1.0, z=0.1))
    provider = observer(arm.model)
    at_rest(arm, provider, 10)
    assert not arm.model.payload.any()


def test_the_arms_own_motion_is_no_disturbance(bench):
    """Coriolis torque, gravity, inertia: all the model's. What is left is the half step of the integration."""
    arm = bench(sway=0.4)
    assert np.abs(swayed(arm, observer(arm.model), 1.3)).max() < 0.05


def test_in_motion_it_finds_the_torque_that_acts(bench):
    """Whatever its origin."""
    arm, unknown = bench(sway=0.4), np.linspace(-3.0, 3.0, 7)
    arm.plant.set_disturbance(unknown)
    assert swayed(arm, observer(arm.model), 1.3) == pytest.approx(unknown, abs=0.05)


def test_a_late_velocity_is_no_disturbance():
    """What is left of an unloaded arm is its friction through the filter, with noise but without a mean."""
    schedule = LoadSchedule.constant(Payload(mass=1.186))
    specification = RunSpecification(schedule=schedule, **USUAL)
    world = World(specification, schedule)
    task = world.task()
    provider = observer(task.robot, task.actuation)
    controller = discovery.load("controllers", "computed_torque")()
    controller.reset(task)
    residuals, refresh = [], provider.refresh

    def recorded(observation):
        refresh(observation)
        residuals.append(provider.residual)

    provider.refresh = recorded
    log = run_episode(world.episode(controller, provider)).log
    tier = world.tier
    friction = tier.coulomb * np.tanh(log["dq"] / tier.coulomb_velocity) + tier.viscous * log["dq"]
    seen = np.zeros_like(friction)
    for k in range(1, len(seen)):
        seen[k] = seen[k - 1] + (1.0 - np.exp(-50.0 * H)) * (-friction[k - 1] - seen[k - 1])
    difference = np.array(residuals) - seen
    settled = log["time"] > -0.5
    assert np.abs(difference[settled].mean(axis=0)).max() < 0.005
    assert np.sqrt(np.mean(difference[settled] ** 2, axis=0)).max() < 0.5


def mean_error(provider):
    """Return the mean joint error of computed torque with 2 kg that the model was not told [rad]."""
    schedule = LoadSchedule.constant(Payload(mass=3.5, material="sand"))
    specification = RunSpecification(schedule=schedule, **USUAL)
    world = World(specification, schedule)
    task = world.task()
    provider.reset(task.robot, task.actuation, Poison() if isinstance(provider, MomentumObserver) else world.truth)
    controller = discovery.load("controllers", "computed_torque")()
    controller.reset(task)
    outcome = run_episode(world.episode(controller, provider))
    assert outcome.failure is None
    late = outcome.log["time"] > 0.0
    return np.linalg.norm(outcome.log["q"][late] - world.table["q"][late], axis=1).mean()


def test_it_helps():
    """The sign: computed torque droops less than without knowledge, by more than half."""
    none = mean_error(discovery.load("knowledge", "none")())
    assert mean_error(MomentumObserver()) < 0.5 * none


def test_a_reset_forgets_everything(bench, load):
    """The same readings give the same bits."""
    arm = bench()
    arm.plant.set_payload(load(2.0, z=0.1))
    provider = observer(arm.model)
    first = at_rest(arm, provider, 30)
    provider.reset(arm.model, drives(), Poison())
    assert not arm.model.disturbance.any() and not provider.residual.any()
    assert np.array_equal(at_rest(arm, provider, 30), first)


@pytest.mark.parametrize("wrong", [{"gain": 0.0}, {"gain": "high"}, {"period": -1e-3}])
def test_settings_that_mean_nothing_are_refused(wrong):
    """With the setting's name."""
    with pytest.raises(InvalidInput, match=next(iter(wrong))):
        MomentumObserver(**wrong)


def test_another_payload_is_no_torque(bench, load):
    """A law with an observer of its own is told of a load in motion: the momentum jumps and nothing has pulled."""
    arm = bench("six", sway=0.5)
    residual = MomentumResidual(arm.model, drives(), gain=50.0, period=H)
    for k in range(100):
        if k == 50:
            arm.model.set_payload(load(2.0, z=0.1))
            arm.plant.set_payload(load(2.0, z=0.1))
        q, dq, _ = arm.plan.joints(k * H)
        # What acted between the last reading and this one.
        drive = arm.plant.inverse_dynamics(*arm.plan.joints((k - 0.5) * H)).copy()
        residual.update(arm.observe(k * H, q, dq, drive))
        assert np.abs(residual.torque).max() < 0.02


def test_settings_in_the_ledger_are_those_that_run():
    """A ledger that shows defaults while other numbers run is worse than none."""
    entries = {entry.setting: entry.value for entry in MomentumObserver(gain=20.0).ledger()}
    assert entries == {"gain": 20.0, "period": 1e-3}
