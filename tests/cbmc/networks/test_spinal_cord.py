"""The spinal cord: the law of the encoder, and the membrane behind it."""

import numpy as np
import pytest
from torquebench.cbmc.pathways import Ascending, Descending
from torquebench.cbmc.spinal_cord import ExactEncoder, RateEncoder, SpinalCord, SpinalCordTable

JOINTS = 7


class Bench:
    """A spinal cord alone: the test sets errors and gains."""

    def __init__(self, *, seed=0, exact=False, **settings):
        table = SpinalCordTable(**settings)
        encoder = ExactEncoder(JOINTS) if exact else RateEncoder(JOINTS, table, np.random.default_rng(seed))
        self.up, self.down = Ascending.of(JOINTS), Descending.of(JOINTS, 2)
        self.spinal_cord = SpinalCord(JOINTS, table, encoder)
        self.spinal_cord.connect(self.up, self.down)

    def set_error(self, position, velocity=0.0):
        self.up.q_desired[:], self.up.dq_desired[:] = position, velocity

    def spikes(self, ticks):
        """Return signed spikes, shape (ticks, 2, n)."""
        rows = []
        for _ in range(ticks):
            self.spinal_cord.act()
            rows.append(self.spinal_cord.spikes.copy())
        return np.array(rows)


@pytest.mark.parametrize("share", [0.02, 0.2, 0.5, 0.8, 0.97])
def test_spikes_of_one_half_are_binomial(share):
    """Mean 50 p and variance 50 p (1 - p), within five standard errors, both signals."""
    bench = Bench(seed=int(1000 * share))
    bench.set_error(0.5 * share, -0.5 * share)
    spikes = bench.spikes(3000)
    counts, number = np.abs(spikes), spikes.size
    variance = 50 * share * (1 - share)
    kurtosis = (1 - 6 * share * (1 - share)) / variance
    assert abs(counts.mean() - 50 * share) < 5 * np.sqrt(variance / number)
    assert abs(counts.var() - variance) < 5 * variance * np.sqrt((2 + kurtosis) / number)
    assert (spikes[:, 0] >= 0).all() and (spikes[:, 1] <= 0).all()


def test_joints_signals_and_ticks_are_independent():
    """Shared draws would make the torque noise of all joints one."""
    bench = Bench()
    bench.set_error(0.2, 0.3)
    spikes = bench.spikes(4000).reshape(4000, -1)
    correlation = np.corrcoef(np.hstack([spikes[1:], spikes[:-1]]).T) - np.eye(4 * JOINTS)
    assert np.abs(correlation).max() < 5 / np.sqrt(4000) * 1.2


def test_an_error_beyond_its_width_fires_all_of_one_half():
    """Saturation at 50 of 100 fibres."""
    bench = Bench()
    bench.set_error(0.7, -3.0)
    spikes = bench.spikes(20)
    assert (spikes[:, 0] == 50).all() and (spikes[:, 1] == -50).all()


def test_no_error_fires_nothing():
    """Neither half answers to zero."""
    bench = Bench()
    assert not bench.spikes(200).any()


def test_every_spike_is_a_draw_that_the_error_reaches():
    """The paper's threshold rule, draw by draw: a generator with the same seed foretells 40 ticks."""
    bench, rng = Bench(seed=9), np.random.default_rng(9)
    bench.set_error(np.linspace(-0.6, 0.6, JOINTS), np.linspace(0.4, -0.4, JOINTS))
    error = np.array([bench.up.q_desired, bench.up.dq_desired])
    draws = np.concatenate([rng.random((16, 2, JOINTS, 50), dtype=np.float32) for _ in range(3)])[:40]
    expected = np.sign(error) * (draws <= np.abs(error / 0.5).astype(np.float32)[..., None]).sum(axis=-1)
    assert np.array_equal(bench.spikes(40), expected)


def test_the_opposite_error_gives_the_opposite_spikes():
    """With the same draws, sign symmetry is exact."""
    one, other = Bench(seed=3), Bench(seed=3)
    one.set_error(0.11, -0.23)
    other.set_error(-0.11, 0.23)
    assert np.array_equal(one.spikes(50), -other.spikes(50))


def test_a_seed_decides_every_spike():
    """Same seed, same run; another seed, another."""
    runs = []
    for seed in (5, 5, 6):
        bench = Bench(seed=seed)
        bench.set_error(0.2, 0.2)
        runs.append(bench.spikes(40))
    assert np.array_equal(runs[0], runs[1]) and not np.array_equal(runs[0], runs[2])


def test_the_mean_decodes_the_error_itself():
    """2 Delta / k times the sum: rad and rad/s, whatever the width."""
    bench = Bench(position_width=0.25)
    bench.set_error(0.1, -0.3)
    bench.spinal_cord.act()
    sums = bench.spinal_cord.spikes
    assert bench.spinal_cord.encoded_position == pytest.approx(sums[0] * 0.005)
    assert bench.spinal_cord.encoded_velocity == pytest.approx(sums[1] * 0.01)
    decoded = []
    for _ in range(2000):
        bench.spinal_cord.act()
        decoded.append(bench.spinal_cord.encoded_position.mean())
    assert np.mean(decoded) == pytest.approx(0.1, abs=1e-3)


def test_the_printed_sum_is_a_hundred_times_stiffer():
    """A gain of 1 is the sum as printed."""
    printed, mean = Bench(spike_gain=1.0), Bench()
    for bench in (printed, mean):
        bench.set_error(0.05, 0.05)
        bench.spinal_cord.act()
    assert printed.spinal_cord.encoded_position == pytest.approx(100.0 * mean.spinal_cord.encoded_position)


@pytest.mark.parametrize("exact", [False, True])
def test_the_membrane_averages_feedback_and_gravity_torque(exact):
    """u += (tau_g + k_p s_q + k_v s_dq - u) / 2."""
    bench = Bench(exact=exact)
    bench.set_error(0.1, -0.2)
    down, torque = bench.down, np.zeros(JOINTS)
    down.gravity_torque[:], down.stiffness[:], down.damping[:] = np.arange(JOINTS), 200.0, 20.0
    for _ in range(5):
        bench.spinal_cord.act()
        cord = bench.spinal_cord
        increment = down.gravity_torque + 200.0 * cord.encoded_position + 20.0 * cord.encoded_velocity
        torque += (increment - torque) / 2.0
        assert down.torque == pytest.approx(torque, abs=1e-12)


def test_the_exact_encoder_gives_the_mean_of_the_spikes():
    """Saturation is part of the code, noise is not."""
    bench = Bench(exact=True)
    bench.set_error(np.linspace(-0.9, 0.9, JOINTS), 0.3)
    bench.spinal_cord.act()
    expected = np.clip(np.linspace(-0.9, 0.9, JOINTS), -0.5, 0.5)
    assert bench.spinal_cord.encoded_position == pytest.approx(expected, abs=1e-15)
    assert bench.spinal_cord.encoded_velocity == pytest.approx(0.3)
    assert not bench.spinal_cord.spikes.any()


def test_settling_puts_the_membrane_at_a_torque():
    """The warm start."""
    bench = Bench()
    bench.spinal_cord.settle(np.arange(7.0))
    bench.down.gravity_torque[:] = np.arange(7.0)
    bench.spinal_cord.act()
    assert bench.down.torque == pytest.approx(np.arange(7.0))
