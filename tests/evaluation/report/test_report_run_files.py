"""The scripts of single runs: what the page loads when one is opened, whatever the run is called and has lost."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from torquebench.evaluation.report import write_report
from torquebench.evaluation.report.run_files import _angles
from torquebench.scenarios.trace import encode_trace

HOSTILE = ["<script>alert(1)</script>", "\"'&><b onclick=x>", "\u202eرجل\u2066", "\U0001f9be" * 40, "a/../../b"]


def trace_of(*, seconds=4.0, dt=1e-2, lead_in=1.0, error=3e-3):
    """Return a trace: seven joints that turn, a tool point that is off by a constant and once by 50 mm."""
    t = np.arange(round((lead_in + seconds) / dt)) * dt - lead_in
    q_ref = 0.1 * np.sin(np.outer(t, np.arange(1, 8)))
    p_ref = np.column_stack([np.cos(t), np.sin(t), 0 * t + 0.4])
    p = p_ref + np.array([error, 0.0, 0.0])
    p[len(t) // 2, 0] = p_ref[len(t) // 2, 0] + 0.05
    quat = np.tile([0.0, 0.0, 0.0, 1.0], (len(t), 1))
    arrays = {
        "t": t, "q": q_ref + 1e-3, "q_ref": q_ref, "p": p, "p_ref": p_ref, "quat": quat, "quat_ref": quat,
        "tau": 10.0 * q_ref,
    }  # fmt: skip
    return {name: array.astype(np.float32) for name, array in arrays.items()}


@pytest.fixture
def put(shelf):
    """Puts a run with a trace on the shelf and returns its address."""

    def place(controller="flexiv_factory", trace=None, **changes):
        run = shelf.specification(controller, "none", **changes)
        result = shelf.result(run, 1e-2, "slow")
        return shelf.put(run, replace(result, trace=None if trace is None else encode_trace(trace)))

    return place


def records(page):
    """Read every script of a report as the page would."""
    found = {}
    for file in sorted((page.files.index.parent / "runs").iterdir()):
        text = file.read_text(encoding="ascii")
        name, record = re.fullmatch(r'torquebench\.runs\["([0-9a-f-]+)"\]=(\{.*\});\n', text).groups()
        assert file.name == f"{name}.js"
        found[name] = json.loads(record)
    return found


def samples(series):
    whole = np.frombuffer(base64.b64decode(series["data"]), "<u2")
    return series["low"] + series["step"] * whole


def test_every_row_of_a_run_names_a_script_that_is_there(shelf, put):
    """A button that opens nothing is worse than none."""
    put(trace=trace_of())
    put("pid")
    page = shelf.campaign().report()
    named = re.findall(r'<tr id="[^"]+" data-run="([^"]+)"', page.html)
    assert sorted(named) == sorted(records(page))
    assert len(named) == 2


def test_a_script_holds_errors_in_the_units_of_the_page(shelf, put):
    """The peak of a single sample too: it is what somebody opens the run for."""
    put(trace=trace_of(seconds=36.0))
    (record,) = records(shelf.campaign().report()).values()
    trace = record["trace"]
    position = samples(trace["position"])
    assert position.max() == pytest.approx(50.0, abs=0.01)
    assert np.median(position) == pytest.approx(3.0, abs=0.01)
    assert np.median(samples(trace["joints"])) == pytest.approx(1.0 * np.sqrt(7), abs=0.01)
    assert samples(trace["orientation"]) == pytest.approx(0.0, abs=1e-6)
    assert (trace["start"], trace["dt"], trace["samples"]) == (-1.0, 0.01, 3700)
    assert trace["frame"] == pytest.approx(0.02)
    q = np.array([samples(column) for column in trace["q"]])
    times = trace["start"] + trace["frame"] * np.arange(q.shape[1])
    turned = 0.1 * np.sin(np.outer(times, np.arange(1, 8))) + 1e-3
    assert np.abs(q.T - turned).max() < 2e-5


def test_a_script_of_the_longest_run_stays_small(shelf, put):
    """Thousands of them lie beside the page."""
    put(trace=trace_of(seconds=36.0))
    page = shelf.campaign().report()
    (file,) = (page.files.index.parent / "runs").iterdir()
    assert file.stat().st_size < 120e3


@pytest.mark.parametrize("angle", [0.0, 1e-6, 1e-3, 0.5, 3.0])
def test_the_angle_between_attitudes_survives_single_precision(angle):
    """The arc cosine of a product near one loses everything below 0.3 mrad."""
    axis = np.array([0.6, 0.0, 0.8])
    base = np.array([[0.5, -0.5, 0.5, 0.5]])
    turn = np.append(np.sin(angle / 2) * axis, np.cos(angle / 2))
    x, y, z, w = turn
    left = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])
    turned = (left @ base[0])[None].astype(np.float32).astype(float)
    assert _angles(turned, base) == pytest.approx(angle, rel=1e-4, abs=3e-7)
    assert _angles(-turned, base) == pytest.approx(angle, rel=1e-4, abs=3e-7)


@pytest.mark.parametrize("lost", [{}, {"t": np.arange(3.0)}, {k: v[:1] for k, v in trace_of().items()}])
def test_a_trace_that_cannot_be_drawn_costs_its_drawing_only(shelf, put, lost):
    """The figures and the command of the run are still there."""
    put(trace=lost or None)
    (record,) = records(shelf.campaign().report()).values()
    assert record["trace"] is None
    assert record["command"].startswith("torquebench run quick --set ")
    assert any(row[0].startswith("mean position error") for row in record["metrics"])


def test_names_of_any_kind_stay_text(shelf, put):
    """A name reaches file names, attributes and scripts; in none of them may it end what it stands in."""
    for name in HOSTILE:
        put(name, trace=trace_of(seconds=1.0))
    page = shelf.campaign().report()
    found = records(page)
    assert sorted(record["label"] for record in found.values()) == sorted(
        f"{name} / none".rpartition(":")[2] for name in HOSTILE
    )
    assert "<script>alert" not in page.html
    assert not re.search(r"<b onclick", page.html)
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]+)"', page.html).group(1)
    assert "script-src 'sha256-" in policy
    assert "unsafe-inline" not in policy.partition("script-src")[2].partition(";")[0]


def test_scripts_are_the_same_to_the_byte_and_go_with_their_runs(shelf, put):
    """Reports are compared and kept under version control."""
    put(trace=trace_of())
    page = shelf.campaign().report()
    folder = page.files.index.parent / "runs"
    (file,) = folder.iterdir()
    before = file.read_bytes()
    (folder / "0123456789abcdef.js").write_text("of a run that is gone")
    file.unlink()
    write_report(shelf.folder)
    assert [(one.name, one.read_bytes()) for one in folder.iterdir()] == [(file.name, before)]


def test_an_arm_stands_once_in_the_page_however_many_runs_it_has(shelf, put):
    """The replay needs it; the runs only name it."""
    for number in range(3):
        put(trace=trace_of(seconds=1.0), repetition=number)
    page = shelf.campaign().report()
    asked = []
    write_report(
        shelf.folder, skeleton_of=lambda robot, tool: asked.append(robot) or {"frames": [], "note": "</script>"}
    )
    html = page.files.index.read_text(encoding="utf-8")
    embedded = re.search(r'<script type="application/json" id="robots">(.*?)</script>', html).group(1)
    (key,) = json.loads(embedded)
    assert asked == ["rizon4s"]
    assert {record["robot"] for record in records(page).values()} == {key}
