"""Laws that every registered metric obeys, and the record that a metric is."""

import copy
import inspect
import pickle

import numpy as np
import pytest
from torquebench.evaluation import EmptyWindow, UnequalLengths, metrics
from torquebench.evaluation.metrics import CONSTANTS, METRICS, Censored, Metric, Value, evaluate, metric
from torquebench.evaluation.metrics.shared import shared, sharing

LOG_METRICS = {name: found for name, found in METRICS.items() if found.kind == "log"}

every_metric = pytest.mark.parametrize("metric_id", LOG_METRICS)
registered = pytest.mark.parametrize("metric_id", METRICS)


def fields(log, found):
    """Return what a metric needs, cut to the first two laps."""
    return {name: getattr(log, name) if name in CONSTANTS else getattr(log, name)[1000:3000] for name in found.needs}


def meant(metric_id):
    """Return the status that a metric has on an arm that flies a circle."""
    return "undefined" if metric_id == "iso_corner_overshoot" else "ok"


def series(found):
    """Return the names of a metric's arrays with a row for each tick."""
    return [name for name in found.needs if name not in CONSTANTS]


@registered
def test_a_metric_is_importable_under_its_id(metric_id):
    """An id is the function's name, so a table's column leads to its definition."""
    assert getattr(metrics, metric_id) is METRICS[metric_id]


@registered
def test_a_metric_says_what_it_is(metric_id):
    """Reports and documentation are made of these words; none may be missing."""
    found = METRICS[metric_id]
    assert found.unit
    assert found.label
    assert found.source
    assert found.better in ("lower", "higher", "none")
    for section in ("Args:", "Returns:", "Raises:"):
        assert section in found.__doc__
    for name in found.needs:
        assert f"{name}: " in found.__doc__


@every_metric
def test_a_metric_has_a_value_on_a_normal_log(metric_id, arm):
    """What never computes is no metric; the log is one of an arm that tracks, late and a little short."""
    value = METRICS[metric_id].value_of(fields(arm(), METRICS[metric_id]))
    assert value.status == meant(metric_id)
    assert np.isfinite(value.value) == (value.status == "ok")
    assert value.n == 2000


@every_metric
def test_an_empty_window_is_an_error(metric_id, arm):
    """A mean of nothing is no number, and NaN means something else."""
    found = METRICS[metric_id]
    empty = {name: f if name in CONSTANTS else f[:0] for name, f in fields(arm(), found).items()}
    with pytest.raises(EmptyWindow) as caught:
        found(**empty)
    assert caught.value.metric == metric_id
    assert isinstance(caught.value, ValueError)


@every_metric
@pytest.mark.parametrize("poison", [np.nan, np.inf, -np.inf])
def test_one_sample_that_is_not_finite_makes_the_value_nan(metric_id, poison, arm):
    """Never a mean over the finite rest: that would reward a run for diverging early."""
    found = METRICS[metric_id]
    for name in series(found):
        poisoned = fields(arm(), found)
        poisoned[name] = poisoned[name].copy()
        poisoned[name][500, 0] = poison
        assert np.isnan(found(**poisoned))
        assert found.value_of(poisoned).status == "failed"


@every_metric
def test_no_metric_changes_its_arguments(metric_id, arm):
    """Read-only arrays pass, and come out as they went in."""
    found = METRICS[metric_id]
    given = {name: np.array(f) if np.ndim(f) else f for name, f in fields(arm(), found).items()}
    before = copy.deepcopy(given)
    for value in given.values():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    found(**given)
    for name, value in given.items():
        assert np.array_equal(value, before[name])


@every_metric
@pytest.mark.parametrize("joints", [1, 6, 9])
def test_the_number_of_joints_is_free(metric_id, joints, arm):
    """Seven is one arm's number."""
    assert METRICS[metric_id].value_of(fields(arm(joints=joints), METRICS[metric_id])).status == meant(metric_id)


@every_metric
def test_one_tick_gives_a_mean_or_nothing(metric_id, arm):
    """A mean of one is defined, a rate of one is not; neither may raise."""
    found = METRICS[metric_id]
    one = {name: f if name in CONSTANTS else f[:1] for name, f in fields(arm(), found).items()}
    value = found.value_of(one)
    assert value.status in ("ok", "undefined")
    assert np.isnan(value.value) == (value.status == "undefined")


@every_metric
def test_lists_are_as_good_as_arrays(metric_id, arm):
    """An analyst's log need not come as arrays."""
    given = fields(arm(), METRICS[metric_id])
    lists = {name: f.tolist() if isinstance(f, np.ndarray) else f for name, f in given.items()}
    assert METRICS[metric_id](**lists) == pytest.approx(METRICS[metric_id](**given), rel=0.0, abs=0.0, nan_ok=True)


@pytest.mark.parametrize("metric_id", [m.id for m in LOG_METRICS.values() if len(series(m)) > 1])
def test_arrays_of_unequal_length_are_an_error(metric_id, arm):
    """A missing tick pairs every later sample with the wrong reference."""
    found = METRICS[metric_id]
    uneven = fields(arm(), found)
    short = series(found)[0]
    uneven[short] = uneven[short][:-1]
    with pytest.raises(UnequalLengths, match="1999") as caught:
        found(**uneven)
    assert caught.value.lengths[short] == 1999


REFERENCES = {"q": "q_ref", "p": "p_ref", "quat": "quat_ref"}


@pytest.mark.parametrize("metric_id", [m.id for m in METRICS.values() if m.family in ("precision", "lag")])
def test_the_reference_against_itself_has_no_error(metric_id, arm):
    """Exactly zero, also the lag; only the share of an error that is not there is undefined."""
    found = METRICS[metric_id]
    perfect = fields(arm(), found)
    perfect.update({name: perfect[reference] for name, reference in REFERENCES.items() if name in perfect})
    value = found.value_of(perfect)
    if metric_id == "lag_share":
        assert value.status == "undefined"
    else:
        assert value == Value(0.0, found.unit, "ok", 2000)


def test_the_order_of_metrics_is_that_of_the_families():
    """Columns of tables must not move between runs of a program."""
    families = [m.family for m in METRICS.values()]
    tracking = ["precision", "lag", "iso", "velocity", "smoothness", "saturation", "effort"]
    others = ["resilience", "modules", "adaptation", "computing", "operations"]
    assert list(dict.fromkeys(families)) == tracking + others
    assert next(iter(METRICS)) == "joint_error_mean"


def test_failed_runs_count_as_errors_in_the_metrics_own_unit():
    """Joints 3 rad, position 0.5 m, orientation pi: no run that tracks comes near."""
    assert METRICS["joint_error_mean"].fail_value == 3.0
    assert METRICS["tcp_position_error_mean"].fail_value == 0.5
    assert METRICS["tcp_orientation_error_mean"].fail_value == pytest.approx(np.pi)
    assert METRICS["torque_rate_rms"].fail_value is None


def test_a_metric_of_ones_own_takes_ten_lines():
    """The decorator brings the checks; the formula stays bare."""

    @metric(unit="m", better="lower", family="own", needs=("p",), source="here", label="height", fail_value=1.0)
    def height_max(p: np.ndarray) -> float:
        """Largest height."""
        return float(p[:, 2].max())

    assert isinstance(height_max, Metric)
    assert (height_max.id, height_max.version, height_max.__doc__) == ("height_max", 1, "Largest height.")
    assert height_max(np.array([[0.0, 0.0, 0.3]])) == 0.3
    assert np.isnan(height_max(np.array([[0.0, 0.0, np.nan]])))
    assert list(inspect.signature(height_max).parameters) == ["p"]


def test_needs_that_are_no_arguments_are_refused_at_once():
    """A typing error must show at import, not as a metric that is silently left out."""
    with pytest.raises(TypeError, match="p_reff"):

        @metric(unit="m", better="lower", family="own", needs=("p", "p_reff"), source="here", label="own")
        def own(p: np.ndarray, p_ref: np.ndarray) -> float:
            """Nothing."""
            return 0.0


def test_a_metric_travels_to_worker_processes_by_name():
    """Pickled like a function, it is the same object on arrival."""
    found = METRICS["time_lag"]
    assert pickle.loads(pickle.dumps(found)) is found
    assert copy.deepcopy(found) is found


def test_a_bound_is_a_number_that_knows_it_is_one():
    """Direct callers compute with it; tables print it apart."""

    @metric(unit="s", better="lower", family="own", needs=("p",), source="here", label="own")
    def bounded(p: np.ndarray) -> float:
        """Always at its bound."""
        return Censored(0.2)

    value = bounded.value_of({"p": np.zeros((3, 3))})
    assert value == Value(0.2, "s", "censored", 3)
    assert bounded(np.zeros((3, 3))) + 0.1 == pytest.approx(0.3)
    assert isinstance(bounded(np.zeros((3, 3))), Censored)


def test_a_value_is_plain_data():
    """Stored as JSON, read by anyone."""
    assert Value(0.018, "m", "ok", 12000).as_dict() == {"value": 0.018, "unit": "m", "status": "ok", "n": 12000}


def test_a_shared_series_is_computed_once_in_a_window_and_never_remembered_outside():
    """Three contour metrics cost one search; a function of bare arrays keeps no state."""
    calls = []

    @shared
    def series_of(x):
        calls.append(x)
        return x + 1.0

    x = np.zeros(3)
    with sharing():
        assert series_of(x) is series_of(x)
        assert not series_of(x).flags.writeable
        series_of(x.copy())
    assert len(calls) == 2
    series_of(x)
    series_of(x)
    assert len(calls) == 4


def test_sharing_changes_no_value(arm):
    """A memory that mixed two windows or two arrays would show here."""
    log = arm()
    together = evaluate(log, windows=("run",))["run"]
    for name, value in together.items():
        found = METRICS[name]
        alone = {n: getattr(log, n) if n in CONSTANTS else getattr(log, n)[1000:] for n in found.needs}
        assert found.value_of(alone) == value
