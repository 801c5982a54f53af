"""The plan of a run: a quintic start from rest, whole laps without end, one clock."""

import numpy as np
import pytest
from torquebench.scenarios.loads import Payload
from torquebench.scenarios.trajectories import Plan, load_path

LEAD = 1.0


@pytest.fixture(scope="module")
def plan(rizon):
    """T6 after a second of lead-in."""
    return Plan.build(rizon, load_path("T6"), lead_in=LEAD)


def quintic(t):
    """Return phase, its rate and the rate's growth of the lead-in that ends at 0."""
    u = (t + LEAD) / LEAD
    phase = LEAD * (2.5 * u**4 - 3 * u**5 + u**6) - LEAD / 2
    return phase, 10 * u**3 - 15 * u**4 + 6 * u**5, (30 * u**2 - 60 * u**3 + 30 * u**4) / LEAD


def test_the_run_starts_at_rest(plan):
    """No velocity, no acceleration, in joints and tool alike."""
    row = plan.rows(np.array([-LEAD]))[0]
    for name in ("dq", "ddq", "twist", "acceleration"):
        assert not row[name].any(), name


def test_it_starts_half_a_lead_in_before_the_lap(plan):
    """The quintic covers half the distance that full speed would."""
    row = plan.rows(np.array([-LEAD]))[0]
    assert np.array_equal(row["pose"], load_path("T6").pose(np.array([-LEAD / 2]))[0])


def test_the_tool_follows_the_path_by_the_quintic_through_the_lead_in(plan):
    """Pose, twist and acceleration by the chain rule, at ticks and between, to a nanometre."""
    t = np.linspace(-LEAD, -1e-9, 777)
    phase, rate, growth = quintic(t)
    path, rows = load_path("T6"), plan.rows(t)
    by_phase, by_phase_twice = path.twist(phase), path.acceleration(phase)
    assert np.allclose(rows["pose"], path.pose(phase), rtol=0, atol=1e-9)
    assert np.allclose(rows["twist"], by_phase * rate[:, None], rtol=0, atol=2e-9)
    expected = by_phase_twice * rate[:, None] ** 2 + by_phase * growth[:, None]
    assert np.allclose(rows["acceleration"], expected, rtol=0, atol=1e-8)


def test_joints_and_tool_go_together_through_the_lead_in(plan, rizon):
    """J dq = dx and J ddq + dJ dq = ddx at every tenth tick: one motion, told twice."""
    model = rizon.model()
    for row in plan.rows(np.arange(-LEAD, 0, 0.01)):
        state = model.at(row["q"], row["dq"])
        assert np.abs(state.pose - row["pose"]).max() < 1e-9
        assert np.abs(state.jacobian @ row["dq"] - row["twist"]).max() < 1e-8
        assert np.abs(state.jacobian @ row["ddq"] + state.jacobian_bias - row["acceleration"]).max() < 1e-5


def test_the_lap_begins_at_zero_at_full_speed(plan):
    """Sample 0 to the bit."""
    row = plan.rows(np.array([0.0]))[0]
    for name in ("q", "dq", "ddq", "pose", "twist", "acceleration"):
        assert np.array_equal(row[name], getattr(plan, name)[0]), name


def test_position_velocity_and_acceleration_are_continuous_where_the_lap_begins(plan):
    """A jump there would be in every run's first event window."""
    before, after = plan.rows(np.array([-1e-7, 1e-7]))
    for name, bound in (("q", 1e-6), ("dq", 1e-5), ("ddq", 1e-4), ("twist", 1e-5), ("acceleration", 1e-4)):
        assert np.abs(after[name] - before[name]).max() < bound, name


def test_every_tick_is_a_sample_to_the_bit(plan):
    """Times carry the rounding of their decimal digits; the plan must not interpolate because of it."""
    ticks = np.round(np.arange(5000) * 0.001, 9)
    rows = plan.rows(ticks)
    for name in ("q", "dq", "ddq", "twist"):
        assert np.array_equal(rows[name], np.tile(getattr(plan, name).T, 3).T[:5000]), name


def test_whole_laps_go_on_beyond_any_end(plan):
    """A planner looks past the last tick and sees the next lap."""
    near, far = plan.rows(np.array([0.3217])), plan.rows(np.array([0.3217 + 50 * plan.period]))
    assert np.allclose(near["q"], far["q"], rtol=0, atol=1e-11)


def test_between_samples_the_path_is_followed_to_a_nanometre(plan):
    """Cubic Hermite on a millisecond."""
    t = np.random.default_rng(3).uniform(0, plan.period, 500)
    path, rows = load_path("T6"), plan.rows(t)
    assert np.abs(rows["pose"] - path.pose(t)).max() < 1e-12
    assert np.abs(rows["twist"] - path.twist(t)).max() < 1e-11
    assert np.abs(rows["acceleration"] - path.acceleration(t)).max() < 1e-9


def test_between_samples_velocity_is_the_derivative_of_position(plan):
    """By central differences of the interpolated plan itself."""
    t, h = np.random.default_rng(4).uniform(0.1, plan.period - 0.1, 50), 2e-4
    slope = (plan.rows(t + h)["q"] - plan.rows(t - h)["q"]) / (2 * h)
    assert np.abs(slope - plan.rows(t)["dq"]).max() < 1e-6


def test_a_preview_is_the_plan_at_those_times(plan):
    """Same numbers as the harness's own table, before and after zero."""
    t = np.array([-0.5, -0.0005, 0.0, 0.25, 7.1234])
    preview, rows = plan.preview(t), plan.rows(t)
    for name in ("q", "dq", "ddq", "pose", "twist", "acceleration"):
        assert np.array_equal(getattr(preview, name), rows[name]), name


def test_a_preview_fills_the_same_arrays_until_its_length_changes(plan):
    """Preallocated; valid until the next call, as documented."""
    first = plan.preview(np.linspace(0, 1, 20))
    kept = first.q.copy()
    second = plan.preview(np.linspace(1, 2, 20))
    assert np.shares_memory(first.q, second.q)
    assert not np.array_equal(first.q, kept)
    assert plan.preview(np.linspace(0, 1, 5)).q.shape == (5, 7)


def test_a_preview_leaves_the_harnesss_table_alone(plan):
    """A controller must not be able to move its own target."""
    rows = plan.rows(np.linspace(0, 1, 20))
    kept = rows.copy()
    plan.preview(np.linspace(1, 2, 20)).q[:] = 0.0
    assert np.array_equal(rows, kept)


def test_the_samples_of_a_plan_are_read_only(plan):
    """They are shared by all runs of a process."""
    for name in ("q", "dq", "ddq", "pose", "twist", "acceleration"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(plan, name)[0] = 0.0


def test_without_a_lead_in_the_lap_runs_before_zero_too(rizon):
    """Cold starts: the reference is moving already."""
    moving = Plan.build(rizon, load_path("T6"), lead_in=0.0)
    row, wrapped = moving.rows(np.array([-0.25, moving.period - 0.25]))
    assert np.allclose(row["q"], wrapped["q"], rtol=0, atol=1e-12)
    assert row["dq"].any()


@pytest.mark.parametrize("name", ["T2", "T5", "T6", "T7"])
def test_the_lead_in_asks_for_hardly_more_torque_than_the_laps(rizon, name):
    """With 3.5 kg and all rotor inertia, in shares of the limit: a second is long enough for the fastest paths."""
    plan = Plan.build(rizon, load_path(name), lead_in=LEAD)
    model = rizon.model(rotor_inertia=rizon.rotor_inertia)
    model.set_payload(sum(body.parameters for body in Payload(mass=3.5, material="sand").bodies(rizon)))

    def peak(rows):
        return max(np.abs(model.inverse_dynamics(r["q"], r["dq"], r["ddq"]) / rizon.effort).max() for r in rows)

    start, laps = peak(plan.rows(np.arange(-LEAD, 0, 0.005))), peak(plan.rows(np.arange(0, plan.period, 0.005)))
    assert start < laps + 0.02
    assert start < 0.85
