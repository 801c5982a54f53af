"""Laws of performance profiles: what counts, against whom, and what a failure costs."""

import numpy as np
import pytest
from torquebench.evaluation import NothingToCompare
from torquebench.evaluation.profiles import MULTIPLES, score_profile

ERROR = "tcp_position_error_mean"


def half(trajectory, mass, repetition):
    return 0.005


def whole(trajectory, mass, repetition):
    return 0.01


def failing_on_t1(trajectory, mass, repetition):
    return "failed" if trajectory == "T1" else 0.005


def test_a_controller_that_halves_every_error_steps_at_one_half(grid):
    """All of its runs are within half of the reference, none within less; the reference steps at one."""
    rows = grid.of("a", half).of("b", whole).rows
    ours, own = score_profile(rows, "a", "b", ERROR), score_profile(rows, "b", "b", ERROR)
    assert np.array_equal(ours.share, (MULTIPLES >= 0.5).astype(float))
    assert np.array_equal(own.share, (MULTIPLES >= 1.0).astype(float))
    assert np.array_equal(ours.band, np.tile(ours.share, (2, 1)))
    assert (ours.runs, ours.trajectories) == (32, 8)


def test_a_failed_run_is_within_no_multiple(grid):
    """An eighth of the runs failed: the profile ends at seven eighths, however large the multiple."""
    found = score_profile(grid.of("a", failing_on_t1).of("b", whole).rows, "a", "b", ERROR)
    assert found.share[-1] == pytest.approx(7.0 / 8.0)
    assert found.band[0, -1] < 7.0 / 8.0 < found.band[1, -1] <= 1.0


def test_a_profile_only_grows(grid):
    """A share within more is a share within less and something; the limits lie around it."""
    rng = np.random.default_rng(2)
    rows = grid.of("a", lambda *_: 0.01 * rng.lognormal(0.0, 0.5)).of("b", whole).rows
    found = score_profile(rows, "a", "b", ERROR)
    assert np.all(np.diff(found.share) >= 0.0)
    assert np.all(found.band[0] <= found.share + 1e-12) and np.all(found.share <= found.band[1] + 1e-12)


def test_few_trajectories_have_no_band(grid):
    """Below five nothing is resampled."""
    rows = [row for row in grid.of("a", half).of("b", whole).rows if row.trajectory in ("T1", "T2", "T3", "T4")]
    assert score_profile(rows, "a", "b", ERROR).band is None


def test_a_reference_without_values_is_no_unit(grid):
    """If it always failed there is nothing to be a multiple of."""
    with pytest.raises(NothingToCompare, match="no common cell"):
        score_profile(grid.of("a", half).of("b", lambda *_: "failed").rows, "a", "b", ERROR)
