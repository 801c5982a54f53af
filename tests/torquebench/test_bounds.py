"""``run --gate``: a bound is held against the page's figures, never against survivors; its status is for scripts."""

import json
import math

import numpy as np
import pytest
from torquebench import running
from torquebench.bounds import check_bounds, read_bounds
from torquebench.controllers import InvalidInput, UnknownName
from torquebench.evaluation.comparison import compare
from torquebench.evaluation.errors import UnknownMetric
from torquebench.evaluation.report.worlds import worlds_of
from torquebench.running import RunReport
from torquebench.scenarios.store import Store

from .conftest import FULL, fill, run_of

POSITION = "tcp_position_error_mean"


def bounds_of(folder, *tables):
    """Write bounds as a user would, and read them."""
    file = folder / "gate.toml"
    lines = ["schema = 1"]
    for table in tables:
        lines.append("[[bound]]")
        lines += [f"{key} = {json.dumps(value)}" for key, value in {"metric": POSITION, **table}.items()]
    file.write_text("\n".join(lines))
    return read_bounds(file)


def rows_of(folder):
    """Return the only world of a store."""
    with Store.read(folder) as store:
        (world,) = worlds_of(store.runs(), store.campaigns())
    return world.rows


def errors_of(folder, controller, **fields):
    """Return a controller's errors, run by run, from the rows themselves."""
    return [
        row.metrics["run"][POSITION]["value"]
        for row in rows_of(folder)
        if row.controller == f"{controller} / none" and all(getattr(row, k) == v for k, v in fields.items())
    ]


@pytest.mark.parametrize(
    ("conditions", "expected"),
    [
        ({"at_most": 1.0}, lambda errors: np.mean(errors())),
        ({"at_most": 1.0, "of": "worst"}, lambda errors: max(errors())),
        ({"at_least": 0.0, "of": "worst"}, lambda errors: min(errors())),
        ({"at_most": 1.0, "mass": 2.5}, lambda errors: np.mean(errors(mass=2.5))),
        ({"at_most": 1.0, "trajectories": ["T7"], "material": "none"}, lambda e: e(trajectory="T7", mass=1.5)[0]),
    ],
)
def test_a_figure_is_that_of_the_rows(kept, tmp_path, conditions, expected):
    """Mean, worst, one load, one cell."""
    (checked,) = check_bounds(bounds_of(tmp_path, {"controller": "cbmc_v3", **conditions}), kept.folder)
    assert checked.value == pytest.approx(expected(lambda **f: errors_of(kept.folder, "cbmc_v3", **f)), rel=1e-12)
    assert checked.passed and checked.unit == "m"


def test_a_limit_itself_passes_and_what_is_beyond_it_does_not(kept, tmp_path):
    """At most means at most, on either side."""
    (found,) = check_bounds(bounds_of(tmp_path, {"controller": "cbmc_v3", "at_most": 1.0}), kept.folder)
    limits = [("at_most", 0.0), ("at_most", -1e-9), ("at_least", 0.0), ("at_least", 1e-9)]
    tables = [{"controller": "cbmc_v3", key: found.value + shift} for key, shift in limits]
    passed = [checked.passed for checked in check_bounds(bounds_of(tmp_path, *tables), kept.folder)]
    assert passed == [True, False, True, False]


def test_the_worst_run_between_two_limits_is_the_one_nearest_to_either(kept, tmp_path):
    """A floor under the figure must not be held against the largest of the runs."""
    low, *_, high = sorted(errors_of(kept.folder, "cbmc_v3"))
    between = {"controller": "cbmc_v3", "of": "worst", "at_least": low + 1e-9, "at_most": high + 1.0}
    around = {"controller": "cbmc_v3", "of": "worst", "at_least": low - 1e-9, "at_most": high + 1.0}
    broken, held = check_bounds(bounds_of(tmp_path, between, around), kept.folder)
    assert (broken.value, broken.passed) == (pytest.approx(low, rel=1e-12), False)
    assert (held.value, held.passed) == (pytest.approx(low, rel=1e-12), True)


def test_a_ratio_is_the_one_of_the_page(kept, tmp_path):
    """The geometric mean over motions of paired runs, not a ratio of means."""
    table = {"controller": "cbmc_v3", "against": "flexiv_factory", "at_most": 1e3}
    (checked,) = check_bounds(bounds_of(tmp_path, table), kept.folder)
    expected = compare(rows_of(kept.folder), "cbmc_v3 / none", "flexiv_factory / none", POSITION).gmr
    assert checked.value == pytest.approx(expected, rel=1e-12) and checked.unit == ""


@pytest.mark.parametrize("against", [{}, {"against": "flexiv_factory"}])
def test_a_run_without_a_value_breaks_its_bound(tmp_path, laws, against):
    """A law that fails the hard runs must not pass by the easy ones."""
    fill(tmp_path / "store", run_of(), run_of(f"{laws}:Late"))
    tables = {"controller": "Late", "at_most": 1e9, **against}, {"controller": "flexiv_factory", "at_most": 1e9}
    late, factory = check_bounds(bounds_of(tmp_path, *tables), tmp_path / "store")
    assert not late.passed and late.value is None and "1 of 1 runs of Late / none have no value" in late.reason
    assert factory.passed


def test_a_reference_that_failed_breaks_a_ratio_too(tmp_path, laws):
    """A ratio to a failed run would be flattering."""
    fill(tmp_path / "store", run_of(), run_of(f"{laws}:Late"))
    table = {"controller": "flexiv_factory", "against": "Late", "at_most": 1e9}
    (checked,) = check_bounds(bounds_of(tmp_path, table), tmp_path / "store")
    assert not checked.passed and "of Late / none have no value" in checked.reason


def test_a_bound_must_hold_in_every_world(tmp_path):
    """Two tiers are two answers; a gate that took one of them would pass by luck."""
    fill(tmp_path / "store", run_of(), run_of(tier="actuated", load=FULL), run_of(tier="actuated"))
    found = check_bounds(bounds_of(tmp_path, {"controller": "flexiv_factory", "at_most": 1.0}), tmp_path / "store")
    assert [checked.bound.partition(" in ")[2][:2] or checked.bound[-2:] for checked in found] == ["w1", "w2"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "key 'bound' is missing"),
        ("[[bound", "malformed TOML"),
        ("bound = []", "bound"),
        ("[[bound]]\nmetric = 'time_lag'\ncontroller = 'a'", "give at_most, at_least, or both"),
        ("[[bound]]\nmetric = 'time_lag'\nat_most = 1", "'bound.0.controller' is missing"),
        ("[[bound]]\nmetric = 'time_lag'\ncontroller = 'a'\nat_mots = 1", "did you mean 'at_most'"),
        ("[[bound]]\nmetric = 'time_lag'\ncontroller = 'a'\nat_most = 'low'", "at_most = 'low'"),
        ("[[bound]]\nmetric = 'time_lag'\ncontroller = 'a'\nat_most = 1\nagainst = 'b'\nof = 'worst'", "leave out of"),
        ("schema = 2\n[[bound]]\nmetric = 'time_lag'\ncontroller = 'a'\nat_most = 1", "schema"),
    ],
)
def test_a_bad_file_ends_in_one_line(tmp_path, text, words):
    """The file, the key, what would be valid."""
    file = tmp_path / "gate.toml"
    file.write_text(text)
    with pytest.raises(InvalidInput) as caught:
        read_bounds(file)
    assert str(file) in str(caught.value) and words in str(caught.value)


def test_names_that_nobody_has_are_no_failed_bounds(kept, tmp_path):
    """A gate with a slip in it must not look like a controller that got worse, nor like one that passed."""
    with pytest.raises(UnknownMetric, match="did you mean 'time_lag'"):
        bounds_of(tmp_path, {"metric": "time_lagg", "controller": "cbmc_v3", "at_most": 1.0})
    with pytest.raises(UnknownName, match="did you mean 'cbmc_v3'"):
        check_bounds(bounds_of(tmp_path, {"controller": "cbmc_v33", "at_most": 1.0}), kept.folder)
    slip = {"controller": "cbmc_v3", "against": "flexiv_fac", "at_most": 1.0}
    with pytest.raises(UnknownName, match="did you mean 'flexiv_factory'"):
        check_bounds(bounds_of(tmp_path, slip), kept.folder)


@pytest.mark.parametrize("metric", ["tick_time_median", "mass_slope_position"])
def test_a_metric_that_no_run_has_is_found_before_the_runs(tmp_path, metric):
    """Its bound would always be broken, and read as a controller without values."""
    with pytest.raises(InvalidInput, match=f"{metric} is computed from"):
        bounds_of(tmp_path, {"metric": metric, "controller": "cbmc_v3", "at_most": 1.0})


@pytest.fixture
def done(kept, monkeypatch):
    """Lets a run do nothing but name the kept store; counts how often it was asked."""
    calls = []

    def run(benchmark, **options):
        calls.append(options)
        page = kept.folder / "report" / "index.html"
        return RunReport(folder=kept.folder, total=8, done=8, failed=0, refused=0, simulated=20.0, predicted=0.0,
                         page=page, notes=())  # fmt: skip

    monkeypatch.setattr(running, "run", run)
    return calls


def test_the_status_of_a_run_is_that_of_its_gate(done, line, tmp_path):
    """0 lets a pipeline go on, 1 stops it; every bound is printed with what was found."""
    bounds_of(tmp_path, {"controller": "cbmc_v3", "at_most": 1.0})
    passed = line("run", "--gate", tmp_path / "gate.toml")
    assert passed.return_value == 0 and "pass: mean tcp_position_error_mean, controller cbmc_v3" in passed.output
    bounds_of(tmp_path, {"controller": "cbmc_v3", "at_most": 1.0}, {"controller": "cbmc_v3", "at_most": 1e-9})
    broken = line("run", "--gate", tmp_path / "gate.toml")
    assert broken.return_value == 1 and broken.output.count("pass: ") == broken.output.count("FAIL: ") == 1
    table = json.loads(line("run", "--gate", tmp_path / "gate.toml", "--json").output)
    assert [check["passed"] for check in table["gate"]] == [True, False]
    assert all(math.isfinite(check["value"]) for check in table["gate"])


def test_a_gate_that_cannot_be_read_runs_nothing(done, line, tmp_path):
    """Found before hours of runs, not after."""
    assert isinstance(line("run", "--gate", tmp_path / "none.toml").exception, InvalidInput)
    assert done == []


def test_a_dry_run_holds_nothing_against_the_gate(done, line, tmp_path):
    """Its file is read, its bounds have nothing to be held against."""
    bounds_of(tmp_path, {"controller": "cbmc_v3", "at_most": 1e-9})
    assert line("run", "--gate", tmp_path / "gate.toml", "--dry-run").return_value == 0
