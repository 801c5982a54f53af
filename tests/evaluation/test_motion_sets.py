"""Statements over named sets of motions: the paper's eight, the sixteen new ones, all twenty-four."""

import math

import pytest
from torquebench.controllers import discovery
from torquebench.evaluation import MOTION_SETS, RunRow, UnknownMotionSet, compare, rows_in
from torquebench.evaluation.motion_sets import sets_in
from torquebench.scenarios.trajectories import further_suite, suite

RATIO = {"paper": 0.5, "further": 2.0, "extended": 0.5 ** (8 / 24) * 2.0 ** (16 / 24)}


def row(controller, trajectory, value, repetition=0):
    """Return a run with one metric."""
    entry = {"value": value, "status": "ok", "unit": "m", "n": 1000}
    return RunRow(
        controller=controller,
        trajectory=trajectory,
        group="",
        mass=1.5,
        material="",
        repetition=repetition,
        status="ok",
        metrics={"run": {"tcp_position_error_mean": entry}},
    )


@pytest.fixture
def rows():
    """A controller that halves the error on the paper's motions and doubles it on new ones, a little unevenly."""
    found = [row("reference", name, 0.01) for name in (*MOTION_SETS["extended"], "S1", "mine.py:path")]
    for place, name in enumerate(MOTION_SETS["extended"]):
        uneven = math.exp(0.02 * (-1) ** place)
        found.append(row("mine", name, 0.01 * uneven * RATIO["paper" if name in MOTION_SETS["paper"] else "further"]))
    return [*found, row("mine", "S1", 1.0), row("mine", "mine.py:path", 1.0)]


def test_the_sets_are_the_benchmarks_own_motions():
    """Names are said twice, since evaluation knows no scenario; this holds the two together."""
    assert MOTION_SETS["further"] == tuple(further_suite())
    assert MOTION_SETS["paper"] == tuple(name for name in suite() if name.startswith("T"))
    assert set(MOTION_SETS["extended"]) <= set(discovery.names("trajectories"))


@pytest.mark.parametrize(("name", "n"), [("paper", 8), ("further", 16), ("extended", 24)])
def test_a_claim_holds_over_the_set_that_it_names(rows, name, n):
    """The trajectory is the unit: the same rows, three sets, three answers, each with its own n and interval."""
    found = compare(rows_in(rows, name), "mine", "reference", "tcp_position_error_mean")
    assert found.n_trajectories == n
    assert found.gmr == pytest.approx(RATIO[name], rel=1e-12)
    assert found.interval_new_motions.contains(RATIO[name])


def test_what_hurts_on_new_motions_is_not_hidden_by_the_old(rows):
    """Better on eight, worse on sixteen: the sets must not be merged into one word."""
    words = [
        compare(rows_in(rows, name), "mine", "reference", "tcp_position_error_mean").verdict
        for name in ("paper", "further")
    ]
    assert words == ["better", "worse"]


def test_a_path_of_ones_own_is_in_no_set(rows):
    """Neither the simulation's motions nor a file's."""
    kept = {found.trajectory for name in MOTION_SETS for found in rows_in(rows, name)}
    assert kept == set(MOTION_SETS["extended"])


def test_runs_are_split_where_old_and_new_motions_meet(rows):
    """A campaign on one of the two has nothing to split."""
    assert sets_in(rows) == ("paper", "further", "extended")
    assert sets_in(rows_in(rows, "paper")) == sets_in(rows_in(rows, "further")) == sets_in([]) == ()


def test_an_unknown_set_is_named():
    """With those that there are."""
    with pytest.raises(UnknownMotionSet, match="unknown set of motions 'new'; known: paper, further, extended"):
        rows_in([], "new")
