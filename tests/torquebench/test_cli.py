"""The command line as a user meets it: real processes, exit statuses, one line for anything that is wrong."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from torquebench.scenarios.store import DATABASE, Store

EXAMPLE = Path(__file__).parents[2] / "examples" / "mine.py"
SMALL = """
schema = 1
name = "small"
plant = "pinocchio"
reference = "Mine / none"
controllers = ["DOOR:Mine"]
trajectories = ["T6"]
loads = [{ mass = 1.5 }]
laps = 1
knowledge = ["none", "oracle"]
"""


def torquebench(*arguments, cwd):
    """Run the command line."""
    return subprocess.run(
        [sys.executable, "-m", "torquebench", *map(str, arguments)],
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=120,
    )


@pytest.fixture
def small(tmp_path):
    """A benchmark file of two short runs."""
    file = tmp_path / "small.toml"
    file.write_text(SMALL.replace("DOOR", str(EXAMPLE)))
    return file


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A results folder of the example controller beside one of ours."""
    folder = tmp_path_factory.mktemp("finished")
    doors = f"{EXAMPLE}:Mine,computed_torque_feedforward"
    changes = ("--set", 'trajectories=["T6"]', "--set", "laps=1", "--set", "loads=[{mass=1.5}]")
    done = torquebench("run", "quick", "--controllers", doors, *changes, "--out", "results", cwd=folder)
    assert done.returncode == 0, done.stderr
    return folder / "results"


def test_help_is_quick_because_it_imports_nothing_heavy(tmp_path):
    """Half of all calls of a command line ask for help."""
    code = (
        "import sys; sys.argv = ['torquebench', '--help']\nfrom torquebench.cli import main\n"
        "try: main()\nfinally: print(sorted(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    for heavy in ("torch", "casadi", "control", "plotly", "pybullet", "numpy", "scipy", "numba", "pinocchio"):
        assert f"'{heavy}'" not in done.stdout
    assert "Run a benchmark" in done.stdout


def test_a_controller_in_a_file_outside_the_project_appears_in_the_report(finished):
    """Twenty lines and one flag are all that an author needs."""
    page = (finished / "report" / "index.html").read_text()
    assert "Mine / none" in page and "Mine / oracle" in page
    assert "computed_torque_feedforward / oracle" in page


def test_json_and_the_list_name_what_can_be_run(tmp_path):
    """Scripts read the same names as people."""
    done = torquebench("list", "--json", cwd=tmp_path)
    names = json.loads(done.stdout)
    assert "quick" in names["benchmarks"] and "flexiv_factory" in names["controllers"] and "T8" in names["trajectories"]


def test_running_again_does_nothing_and_says_so(small, tmp_path):
    """A user who repeats a command must not wait for it again."""
    first = torquebench("run", small, "--out", "runs", cwd=tmp_path)
    again = torquebench("run", small, "--out", "runs", cwd=tmp_path)
    assert first.returncode == again.returncode == 0
    assert "2 runs done" in first.stdout
    assert "nothing to do" in again.stdout


def test_a_dry_run_writes_nothing(small, tmp_path):
    """Asking for the price is free."""
    done = torquebench("run", small, "--out", "runs", "--dry-run", cwd=tmp_path)
    assert done.returncode == 0 and "2 runs" in done.stdout
    assert not (tmp_path / "runs").exists()


def test_failed_runs_end_in_status_1_and_the_report_is_written(tmp_path, small):
    """A script sees that something failed; a person sees what."""
    bad = tmp_path / "bad.py"
    bad.write_text("class Bad:\n    def reset(self, task): pass\n    def compute(self, o, t): raise ValueError('no')\n")
    done = torquebench("run", small, "--controllers", f"{bad}:Bad", "--out", "runs", cwd=tmp_path)
    assert done.returncode == 1
    assert "2 failed" in done.stdout
    assert "ValueError: no" in (tmp_path / "runs" / "report" / "index.html").read_text()


WRONG = {
    "command": (("rnu",), "did you mean 'run'"),
    "command of a group": (("train", "cerebelum"), "did you mean 'cerebellum'"),
    "benchmark": (("run", "quikc"), "did you mean 'quick'"),
    "benchmark file": (("run", "missing.toml"), "missing.toml"),
    "controller": (("run", "quick", "--controllers", "flexiv_factry"), "did you mean 'flexiv_factory'"),
    "controller file": (("run", "quick", "--controllers", "./none.py:Mine"), "no such file './none.py'"),
    "controller in a file": (("run", "quick", "--controllers", f"{EXAMPLE}:Mime"), "did you mean 'Mine'"),
    "controller module": (("run", "quick", "--controllers", "nowhere.at_all:Mine"), "nowhere"),
    "trajectory": (("run", "quick", "--set", 'trajectories=["T11"]'), "did you mean 'T1'"),
    "robot": (("run", "quick", "--robot", "rizon4"), "did you mean 'rizon4s'"),
    "robot file": (("run", "quick", "--robot", "arm.urdf"), "arm.urdf"),
    "tier": (("run", "quick", "--tier", "ideel"), "did you mean 'ideal'"),
    "plant": (("run", "quick", "--plant", "mujoko"), "known: pinocchio, pybullet"),
    "key": (("run", "quick", "--set", "lapps=3"), "did you mean 'laps'"),
    "value": (("run", "quick", "--set", "laps=0"), "laps = 0"),
    "mass": (("run", "quick", "--set", "loads=[{mass=-2.0}]"), "mass -2 kg"),
    "option": (("run", "quick", "--ot", "x"), "--out"),
    "shard": (("run", "quick", "--shard", "3/2"), "expected i/n"),
    "traces": (("run", "quick", "--traces", "all"), "plot, full, none"),
    "report of nothing": (("report", "nowhere"), "holds no run store"),
    "merge of nothing": (("merge", "nowhere", "--out", "joined"), "holds no run store"),
    "kind": (("list", "controler"), "did you mean 'controllers'"),
}


@pytest.mark.parametrize(("arguments", "says"), WRONG.values(), ids=WRONG.keys())
def test_wrong_input_is_one_line_and_status_2(tmp_path, arguments, says):
    """What came, where, and what would be valid; never a traceback, never a folder half made."""
    done = torquebench(*arguments, cwd=tmp_path)
    assert done.returncode == 2, done.stderr
    assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert says in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_foreign_folder_is_not_touched(small, tmp_path):
    """A results folder that holds somebody's thesis is somebody's thesis."""
    foreign = tmp_path / "thesis"
    foreign.mkdir()
    (foreign / "chapter.tex").write_text("x")
    done = torquebench("run", small, "--out", foreign, cwd=tmp_path)
    assert done.returncode == 2 and "chapter.tex" in done.stderr
    assert [entry.name for entry in foreign.iterdir()] == ["chapter.tex"]


def test_a_folder_in_use_is_refused(small, tmp_path):
    """Two campaigns in one folder would each do the other's runs."""
    with Store.write(tmp_path / "runs"):
        done = torquebench("run", small, "--out", "runs", cwd=tmp_path)
    assert done.returncode == 2 and "in use by another campaign" in done.stderr


def test_an_interrupted_campaign_keeps_its_runs_and_ends_in_130(small, tmp_path):
    """Ctrl-C is not a failure: one line, and the same command goes on."""
    process = _start(small, tmp_path)
    _wait_for_rows(tmp_path / "runs", 1)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert len(errors.strip().splitlines()) == 1 and "interrupted" in errors
    kept = _metrics(tmp_path / "runs")
    assert kept and torquebench("run", small, "--out", "runs", *SLOW, cwd=tmp_path).returncode == 0
    assert kept.items() <= _metrics(tmp_path / "runs").items()


def test_a_killed_campaign_ends_in_the_same_bits(small, tmp_path):
    """SIGKILL at any moment loses only the runs in flight."""
    process = _start(small, tmp_path)
    _wait_for_rows(tmp_path / "runs", 2)
    process.kill()
    process.communicate(timeout=60)
    assert torquebench("run", small, "--out", "runs", *SLOW, cwd=tmp_path).returncode == 0
    assert torquebench("run", small, "--out", "whole", *SLOW, cwd=tmp_path).returncode == 0
    assert _metrics(tmp_path / "runs") == _metrics(tmp_path / "whole")


SLOW = ("--set", "repetitions=6", "--set", 'trajectories=["T6", "T7"]', "--workers", "1")


def _heed_interrupts():
    """Undo what a job in the background inherits: there, an interrupt is ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def _start(small, folder):
    command = [sys.executable, "-m", "torquebench", "run", str(small), "--out", "runs", *SLOW]
    return subprocess.Popen(
        command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ
    )


def _wait_for_rows(folder, count):
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        if (folder / DATABASE).is_file() and len(_metrics(folder)) >= count:
            return
        time.sleep(0.05)
    raise TimeoutError(f"fewer than {count} runs after a minute")


def _metrics(folder):
    try:
        with Store.read(folder) as store:
            return {run.address: (run.result.status, str(run.result.metrics)) for run in store.runs()}
    except Exception:
        return {}
