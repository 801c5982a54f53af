"""``torquebench evaluate``: the log of the examples, its figures, and one line for what cannot be read."""

import json
import re
import runpy
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from torquebench import cli
from torquebench.controllers import InvalidInput
from torquebench.evaluation import EvaluationError
from torquebench.own_log import read_log

EXAMPLES = Path(__file__).parents[2] / "examples"
LOG, MAP = EXAMPLES / "own_log.csv", EXAMPLES / "own_log.toml"


def call(*arguments):
    return CliRunner().invoke(cli.group, ["evaluate", *map(str, arguments)], standalone_mode=False)


def test_the_examples_log_is_what_its_script_makes(tmp_path):
    """Who reads the script knows what the figures must be."""
    runpy.run_path(str(EXAMPLES / "make_own_log.py"))["main"](tmp_path / "again.csv")
    again, kept = (np.loadtxt(file, delimiter=",", skiprows=1) for file in (tmp_path / "again.csv", LOG))
    assert again == pytest.approx(kept, abs=2e-4)
    assert (tmp_path / "again.csv").read_text().splitlines()[0] == LOG.read_text().splitlines()[0]


def test_the_examples_tool_is_25_ms_late_and_2_mm_off_its_circle():
    """As it was made: 2 % of a radius of 0.1 m, noise of 0.1 mm; its units are converted."""
    found = json.loads(call(LOG, "--map", MAP, "--json").output)
    run = found["windows"]["run"]
    assert run["time_lag"]["value"] == pytest.approx(0.025, abs=2e-4)
    assert run["contour_error_mean"]["value"] == pytest.approx(0.002, abs=5e-5)
    assert run["joint_error_mean"]["value"] < 0.05
    assert run["tcp_position_error_mean"]["n"] == 600
    assert run["iso_corner_overshoot"]["value"] is None
    assert found["left_out"]["joint_velocity_error_mean"] == ["dq", "dq_ref"]
    assert found["notes"] == []


def test_the_table_names_units_and_what_the_log_lacks():
    lines = call(LOG, "--map", MAP).output.splitlines()
    (lag,) = [line.split() for line in lines if line.startswith("time_lag ")]
    assert lag[0] == "time_lag" and float(lag[1]) == pytest.approx(0.025, abs=2e-4) and lag[-1] == "s"
    assert any(line.startswith("without quat, quat_ref: no tcp_orientation_error_mean") for line in lines)


def test_metrics_may_be_chosen_and_one_that_cannot_be_had_is_an_error():
    lines = call(LOG, "--map", MAP, "--metrics", "time_lag").output.splitlines()
    assert len(lines) == 2
    for asked, says in (("torque_rate_clip_fraction", "needs tau_cmd, tau_lim, torque_rate"), ("time_lak", "time_lag")):
        error = call(LOG, "--map", MAP, "--metrics", asked).exception
        assert isinstance(error, EvaluationError) and says in str(error)


@pytest.mark.parametrize(
    ("asked", "says"),
    [("recovery_time_settled", "a run with load events and its twins"), ("tick_time_p99", "wall times"),
     ("time_lag,mass_slope_position", "values or curves of several runs")],
)  # fmt: skip
def test_a_metric_of_more_than_a_log_is_no_empty_table(asked, says):
    """Status 0 and no line would read as if nothing had been asked."""
    error = call(LOG, "--map", MAP, "--metrics", asked).exception
    assert isinstance(error, InvalidInput) and f"is computed from {says}" in str(error)


TIME_ONLY = 't = "time"'


@pytest.mark.parametrize(
    ("mapping", "says"),
    [
        ("columns = 3", "columns is no table"),
        ("[columns", "TOML"),
        ("[columns]\nq = 'a'", "no column for t"),
        (f"[columns]\n{TIME_ONLY}\nq_reff = 'a'", "unknown field in [columns]: 'q_reff'; did you mean 'q_ref'?"),
        (f"lapp = 1.0\n[columns]\n{TIME_ONLY}", "unknown key: 'lapp'; did you mean 'lap'?"),
        ("[columns]\nt = 'tme'", "t names the column 'tme', which is not there; did you mean 'time'?"),
        (f"[columns]\n{TIME_ONLY}\nq = 'x{{}}'", "names the column 'x1'"),
        (f"[columns]\n{TIME_ONLY}\n[units]\nt = 'hours'", "unknown unit of t: 'hours'"),
        (f"[columns]\n{TIME_ONLY}\nq = 'q1'\n[units]\nq = 'mm'", "unknown unit of q: 'mm'; valid are rad, deg"),
        (f"[columns]\n{TIME_ONLY}\np = 'q1'\n[units]\np = 'deg'", "unknown unit of p: 'deg'; valid are m, mm"),
        (f"[columns]\n{TIME_ONLY}\n[units]\nquat = 'rad'", "unknown field in [units]: 'quat'"),
        ("[columns]\nt = []", "t names 0 columns"),
        ("[columns]\nt = ['time', 'q1']", "t names 2 columns"),
        (f"[columns]\n{TIME_ONLY}\nq = []", "q names 0 columns"),
        (f"lap = 'long'\n[columns]\n{TIME_ONLY}", "lap is 'long'; valid is a number"),
        (f"effort = 'strong'\n[columns]\n{TIME_ONLY}", "log, effort"),
        (f"quat_order = 'zyxw'\n[columns]\n{TIME_ONLY}", "valid are xyzw and wxyz"),
        (f"delimiter = ''\n[columns]\n{TIME_ONLY}", "valid is one character"),
        (f"[columns]\n{TIME_ONLY}\np = ['q1']", "log, p: shape (3, 1); valid is (3, 3)"),
    ],
)
def test_a_wrong_mapping_is_one_line(tmp_path, mapping, says):
    """What came, where, what would be valid."""
    (tmp_path / "log.csv").write_text("time,q1,q2\n0,1,2\n0.1,1,2\n0.2,1,2\n", encoding="utf-8")
    (tmp_path / "map.toml").write_text(mapping, encoding="utf-8")
    with pytest.raises((InvalidInput, EvaluationError)) as caught:
        read_log(tmp_path / "log.csv", tmp_path / "map.toml")
    assert says in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text", ["", "time,q1\n0,1\n0.1,one\n", "time,q1\n0,1\n0.1\n", "time,q1\n", "time,q1\n0,1,2\n1,1,2\n"]
)
def test_a_wrong_table_is_one_line(tmp_path, text):
    (tmp_path / "log.csv").write_text(text, encoding="utf-8")
    (tmp_path / "map.toml").write_text(f"[columns]\n{TIME_ONLY}\nq = 'q1'", encoding="utf-8")
    with pytest.raises((InvalidInput, EvaluationError)) as caught:
        read_log(tmp_path / "log.csv", tmp_path / "map.toml")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("line", ["start = 1e6", "lap = 60.0"])
def test_a_log_without_a_whole_lap_says_so(tmp_path, line):
    """A slip in start or lap leaves no window: an empty table with status 0 would look like a log without metrics."""
    (tmp_path / "map.toml").write_text(re.sub(rf"(?m)^{line.split()[0]} .*$", line, MAP.read_text()), encoding="utf-8")
    error = call(LOG, "--map", tmp_path / "map.toml").exception
    assert isinstance(error, InvalidInput) and "hold no whole lap from 0 on; check start and lap" in str(error)


def test_uneven_logs_are_resampled_and_quaternions_reordered(tmp_path):
    """Semicolons, scalar first, a row missing: as recorders write it."""
    rows = [f"{0.01 * k:.2f};1;0;0;0" for k in range(50) if k != 7]
    (tmp_path / "log.csv").write_text("\n".join(["time;w;x;y;z", *rows]), encoding="utf-8")
    text = f"delimiter = ';'\nquat_order = 'wxyz'\nperiod = 0.01\nstart = 0.1\n[columns]\n{TIME_ONLY}\n"
    (tmp_path / "map.toml").write_text(text + "quat = ['w', 'x', 'y', 'z']", encoding="utf-8")
    log = read_log(tmp_path / "log.csv", tmp_path / "map.toml")
    assert (len(log.t), log.t[0], log.dt) == (50, pytest.approx(-0.1), pytest.approx(0.01))
    assert log.quat == pytest.approx(np.tile([0.0, 0.0, 0.0, 1.0], (50, 1)))
