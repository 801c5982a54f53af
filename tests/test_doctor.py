"""The doctor names what is wrong in one line and never falls ill itself."""

import json
import subprocess
import sys
from dataclasses import replace

import pytest
from click.testing import CliRunner
from torquebench.commands.doctor import command
from torquebench.controllers import discovery
from torquebench.doctor import LIBRARIES, PROBE_TIMEOUT, Diagnosis, Library, Machine, PlugInState, diagnose, probe

ABSENT = Library(module="torquebench_no_such_module", distribution="torquebench-no-such", cost="nothing")


@pytest.fixture(scope="module")
def diagnosis() -> Diagnosis:
    """This very installation, with one library that nobody has."""
    return diagnose((*LIBRARIES, replace(ABSENT, required=False)))


@pytest.fixture
def module(tmp_path, monkeypatch):
    """Write a module that another process can import."""
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))

    def write(name: str, text: str) -> str:
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
        return name

    return write


def test_everything_required_works_here(diagnosis):
    """The tests run in an installation that the doctor finds healthy."""
    ill = [
        f"{found.library.module}: {found.problem}"
        for found in diagnosis.libraries
        if found.library.required and found.problem
    ]
    assert not ill
    assert diagnosis.healthy == (not any(kind.broken for kind in diagnosis.plug_ins))


def test_origin_and_version_are_those_of_the_module_that_is_imported(diagnosis):
    """The question behind most reports of strange errors: which NumPy is this?"""
    import numpy

    found = next(state for state in diagnosis.libraries if state.library.module == "numpy")
    assert found.version == numpy.__version__
    assert numpy.__file__.startswith(found.origin)


def test_the_distribution_of_pinocchio_is_pin():
    """The name pinocchio belongs to another package."""
    assert {library.module: library.distribution for library in LIBRARIES}["pinocchio"] == "pin"


def test_a_missing_library_says_what_that_costs(diagnosis):
    found = next(state for state in diagnosis.libraries if state.library.module == ABSENT.module)
    assert (found.state, found.version, found.origin) == ("missing", "", "")
    assert found.library.cost


@pytest.mark.parametrize("module", ["casadi", "proxsuite", "control", "matplotlib"])
def test_nothing_runs_without_a_library_only_where_the_doctor_says_so(module):
    """Who is told that some controllers are missing must not find that no campaign starts."""
    program = "import sys; sys.modules[sys.argv[1]] = None; import torquebench.running"
    started = subprocess.run([sys.executable, "-P", "-c", program, module], capture_output=True).returncode == 0
    (library,) = (library for library in LIBRARIES if library.module == module)
    assert started != library.cost.startswith("nothing runs")


def test_pybullet_is_required_only_where_it_has_a_wheel():
    bullet = next(library for library in LIBRARIES if library.module == "pybullet")
    assert bullet.required == (sys.version_info < (3, 12))


def test_a_required_library_that_is_missing_is_unhealthy():
    assert not diagnose((ABSENT,)).healthy


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            "raise ImportError('libfoo.so.1: cannot open\\n shared object')",
            "ImportError: libfoo.so.1: cannot open shared object",
        ),
        ("import sys; sys.exit(3)", "SystemExit: 3"),
        ("print('greeting')", ""),
    ],
)
def test_a_failing_import_is_one_line(module, text, problem):
    """A broken shared library is a finding, not a traceback."""
    name = module("torquebench_patient", text)
    assert probe([name]) == {name: problem}


def test_an_import_that_kills_its_process_hides_no_other(module):
    """A library built for another processor ends the process at import."""
    name = module("torquebench_patient", "import os; os._exit(7)")
    answers = probe(["json", name, "csv"])
    assert answers == {"json": "", "csv": "", name: "its import ended the process (status 7)"}


def test_an_import_that_does_not_return_is_given_up(module, monkeypatch):
    name = module("torquebench_patient", "import time; time.sleep(60)")
    assert PROBE_TIMEOUT > 10.0
    monkeypatch.setattr("torquebench.doctor.PROBE_TIMEOUT", 1.5)
    assert probe(["json", name]) == {"json": "", name: "its import took more than 1.5 s"}


def test_every_kind_of_plug_in_is_counted(diagnosis):
    counted = {kind.kind: kind.count for kind in diagnosis.plug_ins}
    assert counted == {kind: len(discovery.names(kind)) for kind in discovery.KINDS}


def test_an_unknown_plug_in_is_broken_by_name():
    answers = probe([], [("controllers", "torquebench_no_such_law")])
    assert "unknown controller" in answers["controllers/torquebench_no_such_law"]


def patient(*, healthy: bool) -> Diagnosis:
    """Return a diagnosis without looking at anything."""
    machine = Machine(
        python="3.11", executable="python", platform="Linux", cores=2, threads={}, kernel_cache="cache", compiler=""
    )
    broken = () if healthy else ("law: ImportError: no",)
    plug_ins = (PlugInState(kind="controllers", count=1, broken=broken),)
    return Diagnosis(version="1", origin="here", machine=machine, libraries=(), plug_ins=plug_ins, warnings=("a trap",))


@pytest.mark.parametrize("healthy", [True, False])
@pytest.mark.parametrize("arguments", [[], ["--json"]])
def test_the_exit_status_is_the_verdict(monkeypatch, healthy, arguments):
    monkeypatch.setattr("torquebench.commands.doctor.diagnose", lambda: patient(healthy=healthy))
    assert CliRunner().invoke(command, arguments).exit_code == (0 if healthy else 1)


def test_the_json_says_what_the_table_says(monkeypatch):
    monkeypatch.setattr("torquebench.commands.doctor.diagnose", lambda: patient(healthy=False))
    table = json.loads(CliRunner().invoke(command, ["--json"]).output)
    text = CliRunner().invoke(command, []).output
    assert table["healthy"] is False
    assert table["plug_ins"][0]["broken"][0] in text
    assert table["warnings"][0] in text


def test_the_namesake_of_pinocchio_is_named(monkeypatch):
    """Installing pinocchio in place of pin is the classic wrong turn."""

    class Namesake:
        version = "0.4.3"

    monkeypatch.setattr("torquebench.doctor._distribution", lambda name: Namesake() if name == "pinocchio" else None)
    monkeypatch.setattr("torquebench.doctor.probe", lambda *_: {})
    assert any("uninstall pinocchio" in warning for warning in diagnose(()).warnings)
