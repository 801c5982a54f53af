"""Laws between this room and its neighbours: the log it is handed, the values it hands on."""

import dataclasses
import json

import numpy as np
import pytest
from torquebench.evaluation import METRICS, RunRow, compare, evaluate, summary
from torquebench.evaluation.metrics import CONSTANTS
from torquebench.scenarios.log import RunLog

LOGGED = {field.name for field in dataclasses.fields(RunLog)}


@pytest.mark.parametrize("metric_id", [m.id for m in METRICS.values() if m.kind in ("log", "timing")])
def test_the_harness_logs_what_a_metric_needs(metric_id):
    """A need with another name than the log's field would silently leave the metric out."""
    assert set(METRICS[metric_id].needs) <= LOGGED


def test_what_is_constant_in_a_run_is_a_field_of_the_log():
    """A renamed limit would be cut like a series."""
    assert CONSTANTS <= LOGGED


def test_the_harnesss_own_log_is_evaluated(arm):
    """The record itself, not a look-alike, with every metric."""
    rest = {"ddq_ref": np.zeros((4000, 7)), "wrench": np.zeros((4000, 6)), "call_time": np.full(4000, 1e-5)}
    log = RunLog(**vars(arm()), **rest)
    values = evaluate(log)["run"]
    assert values.pop("iso_corner_overshoot").status == "undefined"
    assert {value.status for value in values.values()} == {"ok"}


def rows_of(controller, log, trajectory):
    """Return a row as a store would: its values as JSON and back."""
    stored = {
        window: {name: value.as_dict() for name, value in found.items()} for window, found in evaluate(log).items()
    }
    return RunRow(
        controller=controller,
        trajectory=trajectory,
        group="slow",
        mass=1.5,
        material="",
        repetition=0,
        status="ok",
        metrics=json.loads(json.dumps(stored)),
    )


def test_from_logs_to_a_verdict(arm):
    """The whole room in one line: a tool at half the distance from its path is better on every motion."""
    rows = []
    for number in range(8):
        log = arm(seed=number)
        rows.append(rows_of("plain", log, f"T{number}"))
        log.p = log.p_ref + (0.5 + 0.01 * number) * (log.p - log.p_ref)
        rows.append(rows_of("close", log, f"T{number}"))
    found = compare(rows, "close", "plain", "tcp_position_error_mean", window="steady")
    assert found.verdict == "better"
    assert found.gmr == pytest.approx(np.exp(np.mean(np.log(0.5 + 0.01 * np.arange(8)))), rel=1e-9)
    means = summary(rows, "tcp_position_error_mean", window="steady")
    assert means["close"].mean < means["plain"].mean
