"""The guard: where the sampled velocity loop of a light joint ends, and what it does to the gains."""

import numpy as np
import pytest
from torquebench.cbmc.controller import capped_range
from torquebench.cbmc.guard import MARGIN, STIFFNESS_RATIO, damping_limit, gain_caps
from torquebench.controllers import Actuation
from torquebench.scenarios.tiers import build_tier


def drives(*, delay=0, lag=0.0, filter_hz=None):
    """Return the published facts of a one-joint drive."""
    return Actuation(
        tier="bench",
        delay_ticks=delay,
        torque_lag=lag,
        velocity_filter_hz=filter_hz,
        effort=np.ones(1),
        torque_rate=None,
        rotor_inertia=np.zeros(1),
    )


@pytest.mark.parametrize("inertia", [0.0035, 0.05, 3.0])
def test_without_delay_the_limit_is_six_times_the_inertia_over_the_period(inertia):
    """Closed form of z^2 - (3/2 - a/2) z + 1/2 with a = k_v h / M: stable below a = 6."""
    assert damping_limit(inertia, drives(), period=1e-3, membrane=2.0) == pytest.approx(6.0 * inertia / 1e-3, rel=1e-5)


def test_every_delay_in_the_loop_lowers_the_limit():
    """A guard that does not see the drive would pass gains that oscillate on it."""
    loops = [drives(), drives(filter_hz=150.0), drives(delay=1), drives(delay=1, lag=1.5e-3, filter_hz=150.0)]
    limits = [damping_limit(0.05, loop, period=1e-3, membrane=2.0) for loop in loops]
    assert limits == sorted(limits, reverse=True)
    assert limits[-1] < 0.2 * limits[0]


def simulated_growth(damping, inertia, *, steps=4000):
    """Return how much one joint's velocity grows behind delay, lag, filter and membrane, stepped one by one."""
    gain_f, gain_l = 1.0 - np.exp(-2.0 * np.pi * 150.0 * 1e-3), 1.0 - np.exp(-1.0 / 1.5)
    v, f, u, acting = 1.0, 0.0, 0.0, 0.0
    peaks = []
    for _ in range(steps):
        f += gain_f * (v - f)
        command = u
        u += (-damping * f - u) / 2.0
        acting += gain_l * (command - acting)
        v += 1e-3 * acting / inertia
        peaks.append(abs(v))
    return max(peaks[-500:]) / max(peaks[:500])


def test_the_limit_separates_decay_from_growth_in_an_independent_simulation():
    """The matrix must be the loop that runs."""
    limit = damping_limit(0.05, drives(delay=1, lag=1.5e-3, filter_hz=150.0), period=1e-3, membrane=2.0)
    assert simulated_growth(0.98 * limit, 0.05) < 1.0
    assert simulated_growth(1.02 * limit, 0.05) > 1.0


@pytest.mark.parametrize(
    ("tier", "capped"), [("ideal", []), ("actuated", []), ("tight_rate", []), ("paper_bullet", [6])]
)
def test_only_the_last_joint_without_rotor_inertia_is_capped(rizon, tier, capped):
    """Caps are for joints that could not run otherwise; they must not shape the comparison on the usual tiers."""
    constants = build_tier(tier, rizon.tiers, rizon.rotor_inertia)
    model = rizon.model(rotor_inertia=constants.rotor_inertia)
    caps = gain_caps(model, rizon.home, constants.actuation(rizon.effort), period=1e-3, membrane=2.0)
    assert np.flatnonzero(np.isfinite(caps.damping)).tolist() == capped
    for joint in capped:
        assert caps.damping[joint] == pytest.approx(MARGIN * caps.limit[joint])
        assert caps.stiffness[joint] == pytest.approx(STIFFNESS_RATIO * caps.damping[joint])
        assert caps.damping[joint] == pytest.approx(10.0, abs=1.5)


def test_the_cap_wins_over_the_clamp_at_its_floor_too():
    """A floor above the cap would hold the gain where the guard forbids it."""
    low, high = capped_range((50.0, 2000.0), np.array([np.inf, 100.0, 20.0]))
    assert low.tolist() == [50.0, 50.0, 20.0]
    assert high.tolist() == [2000.0, 100.0, 20.0]
