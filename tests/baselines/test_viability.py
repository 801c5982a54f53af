"""Bounds by viability: an arm that respects them now can respect them for ever."""

import numpy as np
import pytest
from torquebench.baselines.viability import LARGEST_ACCELERATION, acceleration_limits, viable_accelerations

H = 1e-3
LIMIT, SPEED, REACH = np.array([2.0, 1.0, 0.5]), np.array([2.0, 3.0, 4.0]), np.array([40.0, 60.0, 200.0])


def bounds(q, dq, *, brake=REACH):
    """Return lower and upper bounds."""
    least, most = np.empty_like(q), np.empty_like(q)
    viable_accelerations(q, dq, -LIMIT, LIMIT, SPEED, REACH, brake, H, least, most)
    return least, most


@pytest.mark.parametrize("share", [1.0, 0.3])
def test_a_bang_bang_demand_never_leaves_the_limits(share):
    """20 000 steps of full demand one way and the other: no overshoot, no excess of speed, no crossed bounds."""
    rng = np.random.default_rng(3)
    q, dq, demand = np.zeros(3), np.zeros(3), np.full(3, 1000.0)
    overshoot = excess = -np.inf
    for _ in range(20_000):
        demand = np.where(rng.random(3) < 0.002, -demand, demand)
        least, most = bounds(q, dq, brake=share * REACH)
        assert np.all(least <= most)
        assert np.all(np.abs([least, most]) <= REACH)
        dq = dq + H * np.clip(demand, least, most)
        q = q + H * dq
        overshoot, excess = max(overshoot, np.max(np.abs(q) - LIMIT)), max(excess, np.max(np.abs(dq) - SPEED))
    assert overshoot <= 1e-12 and excess <= 1e-12
    assert overshoot > -1e-3, "the limits were never reached"


def test_the_rizon_never_leaves_its_limits(rizon):
    """The same demand on the arm of the comparison, margins as the program has them: the overshoot is zero."""
    lower, upper, speed = rizon.lower + 0.02, rizon.upper - 0.02, 0.98 * rizon.velocity
    reach = np.array([40.0, 40.0, 60.0, 60.0, 150.0, 150.0, 200.0])
    rng, least, most = np.random.default_rng(0), np.empty(7), np.empty(7)
    q, dq, demand, closest = 0.5 * (lower + upper), np.zeros(7), np.full(7, 1000.0), np.full(7, np.inf)
    for _ in range(20_000):
        demand = np.where(rng.random(7) < 0.002, -demand, demand)
        viable_accelerations(q, dq, lower, upper, speed, reach, reach, H, least, most)
        assert np.all(least <= most)
        dq = dq + H * np.clip(demand, least, most)
        q = q + H * dq
        closest = np.minimum(closest, np.minimum(upper - q, q - lower))
        assert np.all(np.abs(dq) <= speed + 1e-12)
    assert np.all(closest >= -1e-12)
    assert np.all(closest < 1e-6), "the limits were never reached"


def test_the_one_step_bound_overshoots():
    """It brakes when it is too late: under the same limit of acceleration it passes the end by centimetres."""
    q, dq, furthest = 0.0, 0.0, 0.0
    for _ in range(5000):
        bound = min((LIMIT[0] - q - H * dq) / H**2, (SPEED[0] - dq) / H)
        dq += H * float(np.clip(min(1000.0, bound), -REACH[0], REACH[0]))
        q += H * dq
        furthest = max(furthest, q)
    assert furthest - LIMIT[0] > 0.03


def test_at_rest_in_the_middle_only_the_joint_itself_limits():
    """Far from every limit the bounds are the reach."""
    least, most = bounds(np.zeros(3), np.zeros(3))
    assert np.array_equal(most, REACH) and np.array_equal(least, -REACH)


def test_the_bounds_mirror():
    """What holds towards one limit holds towards the other."""
    rng = np.random.default_rng(0)
    for _ in range(200):
        q, dq = LIMIT * rng.uniform(-1.2, 1.2, 3), SPEED * rng.uniform(-1.5, 1.5, 3)
        least, most = bounds(q, dq)
        mirrored_least, mirrored_most = bounds(-q, -dq)
        assert np.all(least <= most)
        assert mirrored_least == pytest.approx(-most) and mirrored_most == pytest.approx(-least)


def test_beyond_a_limit_the_joint_is_sent_back():
    """Both bounds point inside, as hard as the joint can."""
    least, most = bounds(LIMIT + 0.1, np.zeros(3))
    assert most == pytest.approx(-REACH) and np.all(least <= most)


def test_braking_counts_on_what_gravity_leaves(bench):
    """The reach does not; a share of the rest is kept for the couplings."""
    arm = bench(sway=0.2)
    effort = np.full(7, 150.0)
    reach, brake = acceleration_limits(arm.model, arm.plan, effort, 0.5)
    poses = arm.plan.q
    inertia = np.array([np.diag(arm.model.mass_matrix(q)) for q in poses])
    left = effort - np.abs([arm.model.gravity(q) for q in poses])
    assert reach == pytest.approx((effort / inertia).min(axis=0))
    assert brake == pytest.approx(0.5 * (left / inertia).min(axis=0))
    unlimited, _ = acceleration_limits(arm.model, arm.plan, np.full(7, np.inf), 0.5)
    assert np.all(unlimited == LARGEST_ACCELERATION)
