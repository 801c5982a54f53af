"""What stands in for a module: fixed answers that stay fixed, and arithmetic that can be done by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.cbmc.pathways import Ascending, Descending
from torquebench.cbmc.stand_ins import (
    FILTER_MEMBRANE,
    STANDARD_GRAVITY,
    FixedGains,
    FixedWeights,
    ForceMass,
    HeldCompensation,
    ModelPatterns,
    WeightIntegrator,
)
from torquebench.cbmc.thalamus import ThalamusTable

LIGHT, HEAVY = np.arange(1.0, 8.0), np.arange(1.0, 8.0) * 3.0
GRIPPER = 1.186


@pytest.fixture
def at_rest():
    """Pathways of a seven-joint arm that is where it should be, with a light and a heavy pattern."""
    up, down = Ascending.of(7), Descending.of(7, 2)
    down.compensation[:] = LIGHT, HEAVY
    return up, down


@pytest.mark.parametrize("weights", [(1.0, 0.0), (0.5, 0.5), (0.25, 0.75)])
def test_fixed_weights_stay_whatever_happens(at_rest, weights):
    """An ablation that learnt a little would be no ablation."""
    _, down = at_rest
    thalamus = FixedWeights(down, np.array(weights))
    for _ in range(50):
        thalamus.weigh()
        thalamus.combine()
        thalamus.learn(np.full(2, 1e3))
    assert down.weights.tolist() == list(weights)


def test_the_filter_charges_towards_the_mixture_as_its_membrane_says(at_rest):
    """The same low-pass as behind the thalamus: what is left after k steps is (1 - 1/tau)^k of the way."""
    _, down = at_rest
    assert ThalamusTable().filter.tau_mb == FILTER_MEMBRANE
    thalamus = FixedWeights(down, np.array([0.25, 0.75]))
    mixture = 0.25 * LIGHT + 0.75 * HEAVY
    for step in range(1, 30):
        thalamus.combine()
        left = (1.0 - 1.0 / FILTER_MEMBRANE) ** step
        assert down.gravity_torque == pytest.approx((1.0 - left) * mixture)


def test_a_settled_filter_is_where_it_would_end(at_rest):
    """A warm start: another step changes nothing."""
    _, down = at_rest
    thalamus = FixedWeights(down, np.array([0.5, 0.5]))
    thalamus.settle()
    assert down.gravity_torque == pytest.approx(0.5 * (LIGHT + HEAVY))
    before = down.gravity_torque.copy()
    thalamus.combine()
    assert down.gravity_torque == pytest.approx(before, abs=1e-12)


def test_the_integrator_does_not_move_without_an_error(at_rest):
    """At rest on the plan there is nothing to learn from; both weights stay one half."""
    thalamus = WeightIntegrator(*at_rest)
    for _ in range(100):
        thalamus.weigh()
    assert at_rest[1].weights.tolist() == [0.5, 0.5]


def test_the_integrator_takes_the_step_that_is_printed(at_rest):
    """1e-4 times the error along the patterns' difference, position counted a hundredfold, velocity hardly."""
    up, down = at_rest
    thalamus = WeightIntegrator(up, down)
    up.q_desired[2], up.dq_desired[4] = 0.01, 2.0
    thalamus.weigh()
    along = 100.0 * 0.01 * (HEAVY - LIGHT)[2] + 1e-4 * 2.0 * (HEAVY - LIGHT)[4]
    assert down.weights[1] == pytest.approx(0.5 + 1e-4 * along)
    assert down.weights.sum() == pytest.approx(1.0)


@given(st.lists(st.floats(-0.5, 0.5), min_size=7, max_size=7))
def test_the_integrator_turns_towards_the_pattern_that_helps(error):
    """An arm that sags along the heavy pattern's torque gets more of it; the weight never leaves its range."""
    up, down = Ascending.of(7), Descending.of(7, 2)
    down.compensation[:] = LIGHT, HEAVY
    thalamus = WeightIntegrator(up, down)
    up.q_desired[:] = error
    thalamus.weigh()
    assert 0.0 <= down.weights[1] <= 1.0
    assert (down.weights[1] - 0.5) * (np.array(error) @ (HEAVY - LIGHT)) >= 0.0


@pytest.mark.parametrize(("sign", "end"), [(1.0, 1.0), (-1.0, 0.0)])
def test_the_integrator_ends_at_one_pattern_alone_and_comes_back(at_rest, sign, end):
    """It is clamped, not wound up: the first error the other way moves it at once."""
    up, down = at_rest
    thalamus = WeightIntegrator(up, down)
    up.q_desired[:] = sign * 0.5
    for _ in range(200):
        thalamus.weigh()
    assert down.weights[1] == end
    up.q_desired[:] = -sign * 0.5
    thalamus.weigh()
    assert down.weights[1] != end


@pytest.mark.parametrize(
    ("load", "share"), [(0.0, 0.0), (1.0, 1.0 / 3.0), (1.5, 0.5), (3.0, 1.0), (5.0, 1.0), (-1.0, 0.0)]
)
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_force_sensor_reads_the_load_off_in_any_attitude(at_rest, load, share, axis):
    """A still arm feels gripper and load times g, whichever way its flange points; beyond the patterns, the nearest."""
    up, down = at_rest
    thalamus = ForceMass(up, down, tool_mass=GRIPPER, loads=(0.0, 3.0))
    up.wrench[axis] = -(GRIPPER + load) * STANDARD_GRAVITY
    thalamus.weigh()
    assert down.weights == pytest.approx([1.0 - share, share], abs=1e-12)


def test_the_torque_of_the_sensor_says_nothing_of_the_mass(at_rest):
    """A long lever is no heavy load."""
    up, down = at_rest
    thalamus = ForceMass(up, down, tool_mass=GRIPPER, loads=(0.0, 3.0))
    up.wrench[2] = -(GRIPPER + 1.5) * STANDARD_GRAVITY
    up.wrench[3:] = 99.0
    thalamus.weigh()
    assert down.weights == pytest.approx([0.5, 0.5])


def test_patterns_of_other_loads_have_their_own_scale(at_rest):
    """Between 1 and 2 kg, a load of 1.25 kg is a quarter of the way."""
    up, down = at_rest
    thalamus = ForceMass(up, down, tool_mass=GRIPPER, loads=(1.0, 2.0))
    up.wrench[2] = -(GRIPPER + 1.25) * STANDARD_GRAVITY
    thalamus.weigh()
    assert down.weights[1] == pytest.approx(0.25)


def test_fixed_gains_stay_whatever_happens(at_rest):
    """And they are copies: what was handed over may change afterwards."""
    _, down = at_rest
    stiffness, damping = np.full(7, 200.0), np.full(7, 20.0)
    brainstem = FixedGains(down, stiffness, damping)
    stiffness[:] = damping[:] = 0.0
    brainstem.gains()
    brainstem.learn(np.full(14, 1e3))
    assert down.stiffness.tolist() == [200.0] * 7
    assert down.damping.tolist() == [20.0] * 7


class Counts:
    """A cerebellum that counts how often it was asked."""

    def __init__(self, down):
        self.down, self.calls = down, 0

    def compensate(self):
        self.calls += 1
        self.down.compensation[:] = self.calls


def test_a_held_compensation_is_the_first_answer_for_ever(at_rest):
    """Asked once at the start, as the ablation says; the cerebellum behind it is not kept running."""
    _, down = at_rest
    behind = Counts(down)
    held = HeldCompensation(behind)
    for _ in range(5):
        held.compensate()
    assert behind.calls == 1
    assert np.all(down.compensation == 1.0)


def test_exact_patterns_are_the_gravity_of_their_models(rizon, rng):
    """A row for each load, at the posture that ascends, recomputed with one model for each."""
    up, down = Ascending.of(7), Descending.of(7, 3)
    masses, centre = (0.0, 1.0, 3.0), 0.26
    models = []
    for mass in masses:
        model = rizon.model()
        model.set_payload(
            np.array([mass, 0.0, 0.0, mass * centre, *(mass * centre**2,), 0.0, mass * centre**2, 0, 0, 0])
        )
        models.append(model)
    patterns = ModelPatterns(up, down, tuple(models))
    for _ in range(3):
        up.q[:] = rng.uniform(-1.0, 1.0, 7)
        patterns.compensate()
        for row, model in zip(down.compensation, models, strict=True):
            assert row == pytest.approx(model.gravity(up.q).copy())
        # Gravity is linear in the load: the middle one lies a third of the way.
        third = down.compensation[0] + (down.compensation[2] - down.compensation[0]) / 3.0
        assert down.compensation[1] == pytest.approx(third, abs=1e-9)
