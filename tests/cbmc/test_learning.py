"""The learning rules: what error, torque and spikes say to the second level."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.cbmc.learning import ConstantGradient, FeedbackError, Gradients, TorquePenalty
from torquebench.cbmc.pathways import Ascending, Descending

JOINTS, PATTERNS = 5, 3


class Bench:
    """Pathways with random content and a rule joined to them."""

    def __init__(self, rule, seed=0):
        rng = np.random.default_rng(seed)
        self.up, self.down = Ascending.of(JOINTS), Descending.of(JOINTS, PATTERNS)
        self.encoded = (0.1 * rng.normal(size=JOINTS), 0.1 * rng.normal(size=JOINTS))
        for array in (self.up.q, self.up.dq, self.up.q_desired, self.up.dq_desired):
            array[:] = 0.1 * rng.normal(size=JOINTS)
        self.down.compensation[:] = 30.0 * rng.normal(size=(PATTERNS, JOINTS))
        self.down.torque[:] = 20.0 * rng.normal(size=JOINTS)
        self.gradients = Gradients(weights=np.zeros(PATTERNS), gains=np.zeros(2 * JOINTS), losses=np.zeros(2))
        rule.connect(self.up, self.down, self.encoded, self.gradients)
        rule.evaluate()

    @property
    def error(self):
        return self.up.q_desired - self.up.q

    @property
    def error_rate(self):
        return self.up.dq_desired - self.up.dq


@given(st.integers(0, 2**31))
def test_feedback_error_is_the_gradient_of_half_the_squared_error_through_the_two_membranes(seed):
    """dL/dw and dL/dK recomputed from L = (c_q e^2 + c_v edot^2) / 2 with dq/dtau = sigma, by finite differences."""
    bench = Bench(FeedbackError(sensitivity=0.2), seed)
    error, error_rate, step = bench.error, bench.error_rate, 1e-6

    def loss(torque_change):
        moved, moved_rate = error - 0.2 * torque_change, error_rate - 0.2 * torque_change
        penalty = 1e-3 * 0.2 * (bench.down.torque + torque_change) ** 2
        return np.sum(50.0 * moved**2 + 0.5e-4 * moved_rate**2), np.sum(penalty)

    for p in range(PATTERNS):
        change = 0.5 * 0.2 * step * bench.down.compensation[p]
        slope = (loss(change)[0] - loss(-change)[0]) / (2.0 * step)
        assert bench.gradients.weights[p] == pytest.approx(slope, rel=1e-5, abs=1e-6)
    for i in range(JOINTS):
        change = np.zeros(JOINTS)
        change[i] = 0.5 * step * bench.encoded[0][i]
        slope = (sum(loss(change)) - sum(loss(-change))) / (2.0 * step)
        assert bench.gradients.gains[i] == pytest.approx(slope, rel=1e-4, abs=1e-6)


def test_feedback_error_turns_with_the_error_and_the_printed_loss_does_not():
    """The printed losses are linear in the signed error: their gradient would push the same way for ever."""
    for rule, turns in ((FeedbackError(), True), (ConstantGradient(), False)):
        bench = Bench(rule)
        bench.down.torque[:] = 0.0
        rule.evaluate()
        before = bench.gradients.weights.copy()
        bench.up.q_desired[:] = bench.up.q - bench.error
        bench.up.dq_desired[:] = bench.up.dq - bench.error_rate
        rule.evaluate()
        assert np.allclose(bench.gradients.weights, -before if turns else before)


def test_differentiated_as_printed_the_thalamus_gets_nothing_and_the_gains_only_the_torque_penalty():
    """The measured q has no graph to the weights."""
    bench = Bench(TorquePenalty())
    assert not bench.gradients.weights.any()
    expected = 0.5 * 2.0 * 1e-3 * bench.down.torque * bench.encoded[0]
    assert np.allclose(bench.gradients.gains[:JOINTS], expected)


@pytest.mark.parametrize("rule", [FeedbackError(), ConstantGradient(), TorquePenalty()])
def test_all_rules_record_the_printed_losses(rule):
    """The record is the paper's loss, whatever was learnt from."""
    bench = Bench(rule)
    linear = 100.0 * bench.error.sum() + 1e-4 * bench.error_rate.sum()
    assert bench.gradients.losses[0] == pytest.approx(linear)
    assert bench.gradients.losses[1] == pytest.approx(linear + 1e-3 * np.sum(bench.down.torque**2))
