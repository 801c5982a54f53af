"""What is wrong with a world: everyone meets it, nobody is told, and nothing else moves."""

import numpy as np
import pytest
from torquebench.controllers import InvalidInput, Oracle
from torquebench.scenarios.perturbation import NOMINAL, Perturbation

KINDS = (
    {"payload": 0.7},
    {"delay": 3},
    {"gain": 1.2},
    {"velocity_noise": 0.05},
    {"friction": 2.0},
    {"offset": 0.1},
)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: next(iter(kind)))
def test_a_perturbation_moves_no_other_stream(world_of, kind):
    """A margin would otherwise compare other noise: the force sensor's draws and the controller's seed stay."""
    nominal = world_of(tier="actuated")
    world = world_of(tier="actuated", perturbation=Perturbation(**kind))
    one, two = nominal.episode(None, None), world.episode(None, None)
    assert np.array_equal(one.noise, two.noise)
    assert np.array_equal(one.constants["wrench_bias"], two.constants["wrench_bias"])
    assert nominal.task().seed == world.task().seed


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: next(iter(kind)))
def test_nobody_is_told_of_a_perturbation(world_of, kind):
    """Delay and friction of the published facts, the payload of the oracle; where it stands, encoders say anyway."""
    told, nominal = world_of(tier="actuated", perturbation=Perturbation(**kind)), world_of(tier="actuated")
    one, two = told.task(), nominal.task()
    assert one.actuation.delay_ticks == two.actuation.delay_ticks
    assert np.linalg.norm(one.initial_q - two.initial_q) == pytest.approx(kind.get("offset", 0.0))
    assert told.truth.parameters == pytest.approx(nominal.truth.parameters, abs=1e-12)


def test_the_oracle_is_not_told_the_extra_load(world_of, play, follows):
    """It knows the drawn payload; a load margin of an omniscient law would be none."""
    world = world_of(seconds=0.02, perturbation=Perturbation(payload=2.0))
    play(world, follows, Oracle())
    assert world.plant.payload[0] == pytest.approx(0.314 + 2.0)
    assert follows.robot.payload[0] == pytest.approx(0.314)


def test_the_oracle_is_not_told_the_extra_load_when_the_load_changes_either(run_of):
    """The truth follows the plant at an event, less what nobody is told."""
    from torquebench.scenarios.episode import change_load
    from torquebench.scenarios.loads import LoadSchedule, Payload
    from torquebench.scenarios.world import World

    step = LoadSchedule(entries=((0.0, Payload(mass=1.5)), (0.5, Payload(mass=2.5, material="sand"))))
    world = World(run_of(schedule=step, perturbation=Perturbation(payload=1.0)), step)
    episode = world.episode(None, None)
    (active,) = world.loads.values()
    change_load(episode, active)
    assert world.plant.payload[0] == pytest.approx(2.5 - 1.186 + 1.0)
    assert episode.truth.parameters[0] == pytest.approx(2.5 - 1.186)


def test_a_nominal_run_is_not_disturbed(world_of):
    """No call, no table, no draw: a tick without a perturbation costs nothing more."""
    assert world_of(perturbation=NOMINAL).episode(None, None).disturbance is None


def test_extra_delay_is_a_shift_of_the_torque(world_of, play, says):
    """A step of the command arrives so many ticks later, whether or not the delay line is longer than the delay."""
    arrived = {}
    for delay in (0, 2, 5):
        world = world_of(seconds=0.03, perturbation=Perturbation(delay=delay))
        hold = world.plant.gravity()

        def answer(k, hold=hold):
            return hold + (1.0 if k >= 10 else 0.0)

        torque = play(world, says(answer)).log["torque"][:, 0]
        arrived[delay] = int(np.flatnonzero(torque > hold[0] + 0.5)[0])
    assert arrived == {0: 10, 2: 12, 5: 15}


def test_the_gain_is_on_the_command_and_the_log_keeps_what_was_returned(world_of, play, holds):
    """A controller's own figure must not carry the drive's error."""
    outcome = play(world_of(perturbation=Perturbation(gain=1.5)), holds)
    assert outcome.log["limited"] == pytest.approx(1.5 * outcome.log["command"])


@pytest.mark.parametrize("gain", [0.5, 1.25, 0.0])
def test_the_command_that_is_read_back_does_not_tell_the_gain(world_of, play, says, gain):
    """A drive with a wrong torque constant does not know of it; a law that limits its own rate would fight it."""
    world = world_of(tier="tight_rate", seconds=0.03, perturbation=Perturbation(gain=gain))
    hold = world.plant.gravity()
    log = play(world, says(lambda k: hold + (0.2 if k >= 10 else 0.0))).log
    assert np.abs(log["limited"][-1] - gain * log["command"][-1]).max() < 1e-9
    assert (gain * log["readback"] == pytest.approx(log["limited"])) if gain else not log["readback"].any()


def test_a_late_command_has_the_wrong_gain_too(world_of, play, says):
    """It was lost where a command came out of the log, as it does with latency."""
    world = world_of(seconds=0.03, latency=3, perturbation=Perturbation(gain=1.5))
    log = play(world, says(lambda k: np.full(7, 0.01 * k))).log
    assert log["limited"][3:] == pytest.approx(1.5 * log["command"][:-3])


def test_velocity_noise_is_on_the_measured_velocity_alone(world_of, play, holds):
    """Same draws for every level, so that a search over levels compares like with like."""
    loud = play(world_of(perturbation=Perturbation(velocity_noise=0.2)), holds).log
    quiet = play(world_of(perturbation=Perturbation(velocity_noise=0.1)), type(holds)()).log
    noise = loud["dq_measured"] - loud["dq"]
    assert noise.std() == pytest.approx(0.2, rel=0.1)
    assert noise == pytest.approx(2.0 * (quiet["dq_measured"] - quiet["dq"]))
    assert np.array_equal(loud["q"], quiet["q"])


def test_friction_is_scaled_in_the_plant_alone(world_of):
    """Coulomb and viscous, of every joint."""
    world = world_of(tier="actuated", perturbation=Perturbation(friction=3.0))
    assert world.plant.tier.coulomb == pytest.approx(3.0 * world.tier.coulomb)
    assert world.plant.tier.viscous == pytest.approx(3.0 * world.tier.viscous)


def test_the_offset_is_a_norm_over_the_joints(world_of):
    """The rule that ends a run looks at the norm too."""
    world = world_of(perturbation=Perturbation(offset=0.3))
    assert np.linalg.norm(world.plant.q - world.table["q"][0]) == pytest.approx(0.3)


@pytest.mark.parametrize(
    "kind", [{"payload": -1.0}, {"gain": float("nan")}, {"friction": -0.5}, {"delay": -1}, {"velocity_noise": -1e-3}]
)
def test_a_perturbation_that_is_none_is_refused(kind):
    """One line with the field and what came."""
    with pytest.raises(InvalidInput, match=next(iter(kind))):
        Perturbation(**kind)
