"""Every command's options and outputs: what reaches the library, what is printed, in which status it ends."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner
from torquebench import cli, reporting, running
from torquebench.cli import COMMANDS
from torquebench.commands.progress import Progress
from torquebench.controllers import InvalidInput, UnknownName, discovery
from torquebench.running import RunReport
from torquebench.scenarios import speed
from torquebench.scenarios.benchmark import benchmark_names
from torquebench.scenarios.speed import Figure
from torquebench.scenarios.store import Store


def outcome(**changes):
    """Return what a run of four would report."""
    report = {
        "folder": Path("results"),
        "total": 4,
        "done": 3,
        "failed": 0,
        "refused": 0,
        "simulated": 39.0,
        "predicted": 0.0,
        "page": Path("results/report/index.html"),
        "notes": (),
    }
    return RunReport(**report | changes)


@pytest.fixture
def call():
    """Calls the command line within this process and returns what it printed."""

    def invoke(*arguments):
        return CliRunner().invoke(cli.group, [str(argument) for argument in arguments], standalone_mode=False)

    return invoke


@pytest.fixture
def asked(monkeypatch):
    """Lets ``run`` do nothing but keep what it was asked for; ``answer`` is what it reports."""
    kept = SimpleNamespace(answer=outcome(), calls=[])

    def run(benchmark, **options):
        kept.calls.append({"benchmark": benchmark, **options})
        return kept.answer

    monkeypatch.setattr(running, "run", run)
    return kept


@pytest.fixture
def ended(monkeypatch, capsys):
    """Runs :func:`main` as the installed script would, and returns its status and its error line."""

    def end(*arguments):
        monkeypatch.setattr(sys, "argv", ["torquebench", *arguments])
        with pytest.raises(SystemExit) as end:
            cli.main()
        return end.value.code, capsys.readouterr()

    return end


def test_every_command_of_the_help_can_be_called(call):
    """The list of help is written apart from the commands, so that help need not import them: neither has more."""
    for name in COMMANDS:
        found = call(name, "--help")
        assert found.exit_code == 0, found.output
        assert found.output.startswith("Usage:")
    listed = call("--help").output
    first_words = [line.split()[0] for line in listed.partition("Commands:")[2].strip().splitlines()]
    assert [word for word in first_words if word in COMMANDS] == list(COMMANDS)


def test_run_without_a_word_runs_quick_into_results(call, asked):
    """The README's command: the defaults are the promise of its first screen."""
    assert call("run").return_value == 0
    (options,) = asked.calls
    assert (options.pop("benchmark"), options.pop("out")) == ("quick", "results")
    assert callable(options.pop("watch"))
    assert options == {
        "controllers": [],
        "robot": "",
        "plant": "",
        "tier": "",
        "latency": None,
        "changes": (),
        "shard": (1, 1),
        "workers": 0,
        "traces": "plot",
        "retry_failed": False,
        "dry_run": False,
    }


@pytest.mark.parametrize(
    ("words", "name", "value"),
    [
        (("--out", "here"), "out", "here"),
        (("--controllers", "a, ./b.py:B,,c "), "controllers", ["a", "./b.py:B", "c"]),
        (("--robot", "arm.urdf"), "robot", "arm.urdf"),
        (("--plant", "pinocchio"), "plant", "pinocchio"),
        (("--tier", "ideal"), "tier", "ideal"),
        (("--latency", "0"), "latency", 0),
        (("--latency", "measured"), "latency", "measured"),
        (("--set", "laps=2", "--set", "seed=3"), "changes", ("laps=2", "seed=3")),
        (("--shard", "2/8"), "shard", (2, 8)),
        (("--workers", "3"), "workers", 3),
        (("--traces", "full"), "traces", "full"),
        (("--retry-failed",), "retry_failed", True),
        (("--dry-run",), "dry_run", True),
    ],
)
def test_every_option_of_run_reaches_it(call, asked, words, name, value):
    """An option that is parsed and dropped is worse than none: the user believes it."""
    assert call("run", "robustness", *words).exception is None
    (options,) = asked.calls
    assert options["benchmark"] == "robustness"
    assert options[name] == value


@pytest.mark.parametrize(
    ("changes", "words", "status"),
    [
        ({}, (), 0),
        ({"failed": 2}, (), 1),
        ({"refused": 4}, (), 0),
        ({"failed": 2, "page": None}, ("--dry-run",), 0),
        ({"failed": 2}, ("--json",), 1),
    ],
)
def test_the_status_tells_a_script_of_failures_that_happened(call, asked, changes, words, status):
    """A plan that counts old failures has done nothing wrong; neither has a controller that refused."""
    asked.answer = outcome(**changes)
    assert call("run", *words).return_value == status


def test_a_person_reads_counts_and_what_to_do_next(call, asked):
    """Done, failed, refused, and where the page is, a line each."""
    asked.answer = outcome(failed=2, refused=1, notes=("Pinocchio took over",))
    found = call("run")
    assert found.stdout.splitlines() == [
        "3 runs done (39 s simulated), 4 in all",
        "2 failed; the report says why, --retry-failed tries them again",
        "1 refused; the report says why",
        "report: results/report/index.html",
    ]
    assert found.stderr == "note: Pinocchio took over\n"


@pytest.mark.parametrize(("seconds", "words"), [(119.4, "119 s"), (120.0, "2 min"), (5400.0, "90 min")])
def test_a_price_is_in_seconds_or_minutes(call, asked, seconds, words):
    """Whether to wait or to go for lunch."""
    asked.answer = outcome(done=0, page=None, simulated=52.0, predicted=seconds)
    assert call("run", "--dry-run").stdout == (
        f"4 runs asked for; 52 s of simulated time are missing in results, about {words} of wall time\n"
    )


def test_nothing_to_do_is_said(call, asked):
    """Not '0 runs done', which sounds like a mistake."""
    asked.answer = outcome(done=0)
    assert "nothing to do: all 4 runs are in results" in call("run").stdout


def test_json_is_the_whole_report_and_nothing_else(call, asked):
    """A program parses the output as it comes: no note, no bar, no greeting in it."""
    asked.answer = outcome(notes=("a note",), refused=1)
    found = call("run", "--json")
    assert json.loads(found.stdout) == {
        "folder": "results",
        "total": 4,
        "done": 3,
        "failed": 0,
        "refused": 1,
        "simulated": 39.0,
        "predicted": 0.0,
        "page": "results/report/index.html",
        "notes": ["a note"],
    }
    assert found.stderr == ""


@pytest.mark.parametrize("words", [("--workers", "-1"), ("--latency", "soon"), ("--shard", "0/2"), ("quick", "more")])
def test_a_word_that_run_cannot_read_starts_nothing(call, asked, words):
    """Found by the parser, before a library is loaded."""
    assert call("run", *words).exception is not None
    assert asked.calls == []


def test_the_list_of_one_kind_has_its_names_only(call):
    """Name, then what it is; as many as are registered."""
    lines = call("list", "trajectories").output.splitlines()
    assert lines[0] == "trajectories:"
    assert tuple(line.split()[0] for line in lines[1:]) == discovery.names("trajectories")


@pytest.mark.parametrize("kind", ["benchmarks", "controllers", "knowledge", "plants"])
def test_every_name_that_one_may_choose_says_what_it_is(call, kind):
    """Twenty names without a meaning help nobody to choose."""
    (found,) = json.loads(call("list", kind, "--json").output).values()
    ours = {name: about for name, about in found.items() if about["origin"].startswith(("torquebench.", "bundled"))}
    assert ours
    assert [name for name, about in ours.items() if not about["meaning"]] == []


def test_the_list_of_everything_has_every_kind(call):
    """What can be plugged in can be listed."""
    found = json.loads(call("list", "--json").output)
    assert set(found) == {"benchmarks", *discovery.KINDS}
    assert tuple(found["benchmarks"]) == benchmark_names()


def test_a_list_in_json_of_one_kind_has_one_key(call):
    """And the origin is what a door would be."""
    found = json.loads(call("list", "plants", "--json").output)
    assert list(found) == ["plants"]
    assert found["plants"]["pinocchio"]["origin"].endswith(":PinocchioPlant")


def test_the_report_command_names_its_page(call, monkeypatch):
    """The last line is what a person opens."""
    folders = []
    monkeypatch.setattr(reporting, "report", lambda folder: folders.append(folder) or Path("here/index.html"))
    assert call("report").output == call("report", "mine").output == "report: here/index.html\n"
    assert folders == [Path("results"), Path("mine")]


def test_a_report_that_the_disk_refuses_is_one_line(monkeypatch):
    """Runs are there, the old page is there; only the new page is not."""

    def full(folder, **_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(reporting, "write_report", full)
    with pytest.raises(InvalidInput, match=r"No space left on device.*runs and old report are kept"):
        reporting.report(Path("results"))


def test_merging_looks_at_every_source_before_it_writes(call, tmp_path):
    """A typo in the third folder must not leave a store of two."""
    with Store.write(tmp_path / "one"):
        pass
    found = call("merge", tmp_path / "one", tmp_path / "nowhere", "--out", tmp_path / "all")
    assert "holds no run store" in str(found.exception)
    assert not (tmp_path / "all").exists()


def test_merging_needs_sources_and_a_target(call, tmp_path):
    """Neither has a default: a wrong guess would write into somebody's results."""
    for words, missing in ((("--out", tmp_path / "all"), "folders"), ((tmp_path,), "out")):
        assert call("merge", *words).exception.param.name == missing


def test_merging_says_how_much_came_from_where(call, tmp_path):
    """An empty shard is a shard: none taken, and the report is written."""
    for name in ("one", "two"):
        with Store.write(tmp_path / name):
            pass
    lines = call("merge", tmp_path / "one", tmp_path / "two", "--out", tmp_path / "all").output.splitlines()
    assert lines[:2] == [f"{tmp_path / name}: 0 runs taken" for name in ("one", "two")]
    assert lines[2] == f"report: {tmp_path / 'all' / 'report' / 'index.html'}"


FIGURES = (
    Figure(name="plant step", value=6.25, unit="us"),
    Figure(name="computed torque, end to end", value=30.0, unit="x real time", bar=40.0, at_least=True),
    Figure(name="actuated over ideal", value=1.5, unit="1", bar=2.0),
)


@pytest.fixture
def measured(monkeypatch):
    """Lets the speed be known without measuring; keeps the plants that were asked for."""
    plants = []

    def measure(plant, *, evaluate):
        plants.append(plant)
        return FIGURES

    monkeypatch.setattr(speed, "measure_speed", measure)
    return plants


def test_a_figure_that_misses_its_bar_is_marked(call, measured):
    """At least and at most are different promises; what has no bar has no mark."""
    first, step, factor, share = call("speed", "--plant", "pinocchio").output.splitlines()
    assert first.endswith("; plant pinocchio")
    assert step.split()[-2:] == ["6.25", "us"]
    assert factor.endswith("at least 40  MISSED")
    assert share.endswith("at most 2")
    assert measured == ["pinocchio"]


def test_speed_in_json_carries_machine_and_verdicts(call, measured):
    """A figure without its machine is no figure."""
    found = json.loads(call("speed", "--json", "--plant", "pinocchio").output)
    assert found["plant"] == "pinocchio" and "Python" in found["machine"]
    assert [row["met"] for row in found["figures"]] == [True, False, True]
    assert found["figures"][0] == {
        "name": "plant step",
        "value": 6.25,
        "unit": "us",
        "bar": None,
        "at_least": False,
    } | {"met": True}


@pytest.mark.parametrize("installed", [True, False])
def test_speed_without_a_plant_takes_the_one_that_campaigns_take(call, measured, monkeypatch, installed):
    """PyBullet where it is installed, the same equations in Pinocchio where it is not."""
    import importlib.util

    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *rest: installed or None if name == "pybullet" else found(name, *rest)
    )
    call("speed")
    assert measured == ["pybullet" if installed else "pinocchio"]


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("rnu",), "did you mean 'run'"),
        (("run", "--latency", "soon"), "--latency: latency = 'soon'; whole ticks from 0, or 'measured'"),
        (("run", "--latency", "-1"), "--latency: latency = -1; whole ticks from 0, or 'measured'"),
        (("run", "--set", "latency=mesured"), "latency = 'mesured'"),
        (("run", "--ot", "x"), "--ot"),
        (("merge",), "FOLDERS"),
        (("train", "cerebelum"), "cerebelum"),
        (("list", "plant"), "did you mean 'plants'"),
    ],
)
def test_a_wrong_word_is_one_line_and_status_2(ended, words, says):
    """Whichever layer finds it: click, the group, or the library."""
    status, printed = ended(*words)
    assert status == 2
    assert printed.err.startswith("torquebench: ") and says in printed.err
    assert printed.err.count("\n") == 1 and printed.out == ""


def test_an_interrupt_is_no_failure(ended, monkeypatch):
    """Ctrl-C ends in 130 and says that nothing is lost."""

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(running, "run", interrupted)
    status, printed = ended("run")
    assert status == 130
    assert (
        printed.err.strip()
        == "torquebench: interrupted; finished runs are kept, the same command goes on with the rest"
    )


def test_a_reader_that_closes_early_is_no_traceback(ended, monkeypatch):
    """``torquebench list | head -1`` is an ordinary thing to type."""

    def closed(*_, **__):
        raise BrokenPipeError

    monkeypatch.setattr(running, "run", closed)
    assert ended("run")[0] == 1


def test_an_error_may_choose_its_status(ended, monkeypatch):
    """A plant that fails its gate is 1: the input was right, the result is not."""
    from torquebench.scenarios.gate import GateFailure

    class Off(UnknownName):
        exit_status = 1

    def off(*_, **__):
        raise Off("plant", "pybulet", ("pybullet",))

    monkeypatch.setattr(running, "run", off)
    assert ended("run")[0] == GateFailure.exit_status == 1


def test_a_slip_of_ours_keeps_its_traceback(monkeypatch):
    """What no user can cause must not be dressed up as a wrong input."""

    def slip(*_, **__):
        raise ZeroDivisionError("a slip")

    monkeypatch.setattr(running, "run", slip)
    monkeypatch.setattr(sys, "argv", ["torquebench", "run"])
    with pytest.raises(ZeroDivisionError):
        cli.main()


def test_the_version_is_that_of_the_metadata(call):
    """What a bug report quotes."""
    from importlib.metadata import version

    assert version("torquebench") in call("--version").output


def test_a_bar_counts_what_was_written_and_what_failed():
    """Off a terminal it shows nothing, and counts all the same."""
    campaign = SimpleNamespace(benchmark=SimpleNamespace(name="quick"), pending=(0, 1, 2))
    with Progress(quiet=True) as progress:
        progress.watch(campaign, None)
        for failed in (False, True, True):
            progress.watch(campaign, SimpleNamespace(failed=failed))
        (task,) = progress._bar.tasks
    assert (task.description, task.total, task.completed) == ("quick", 3, 3)
    assert task.fields["failed"] == "2 failed"
