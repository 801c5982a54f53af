"""What a report says of the machine: enough to judge a timing, nothing that names a person."""

import getpass
import os
import platform
import socket
import subprocess
from importlib.metadata import version
from pathlib import Path

import pytest
from torquebench.scenarios import machine as place
from torquebench.scenarios.machine import commit, machine, machine_label, versions


def test_a_machine_is_told_by_its_processor_cores_system_and_python():
    """These four decide how long a tick takes; two machines that differ in one are never pooled."""
    facts = machine()
    assert list(facts) == ["processor", "cores", "system", "python"]
    assert facts["python"] == platform.python_version()
    assert facts["system"] == f"{platform.system()} {platform.machine()}"
    assert facts["cores"] == len(os.sched_getaffinity(0)) >= 1


def test_no_name_of_host_or_user_is_even_asked_for(monkeypatch):
    """A store is made to be shared: whose computer it was is nobody's business."""

    def asked(*_):
        raise AssertionError("a name was asked for")

    for module, name in ((socket, "gethostname"), (platform, "node"), (getpass, "getuser")):
        monkeypatch.setattr(module, name, asked)
    machine.cache_clear()
    assert machine_label() and versions()


def test_the_label_is_the_facts_in_one_line():
    """It is the key by which timings are pooled: every fact must be in it."""
    label = machine_label()
    assert "\n" not in label
    assert all(str(fact) in label for fact in machine().values())


@pytest.mark.parametrize(
    ("cpuinfo", "processor"),
    [
        ("processor\t: 0\nmodel name\t: Fast  Chip 9\nprocessor\t: 1\nmodel name\t: Fast  Chip 9\n", "Fast  Chip 9"),
        ("processor\t: 0\nBogoMIPS\t: 50.00\n", "an arm"),
        (None, "an arm"),
    ],
)
def test_a_processor_without_a_name_has_that_of_the_system(monkeypatch, cpuinfo, processor):
    """Arm boards list no model name, other systems no such file."""

    def read(file, **_):
        assert str(file) == "/proc/cpuinfo"
        if cpuinfo is None:
            raise FileNotFoundError(file)
        return cpuinfo

    monkeypatch.setattr(place.Path, "read_text", read)
    monkeypatch.setattr(place.platform, "processor", lambda: "an arm")
    machine.cache_clear()
    try:
        assert machine()["processor"] == processor
    finally:
        machine.cache_clear()


def test_a_processor_that_nobody_names_is_still_a_word(monkeypatch):
    """An empty label would pool the timings of all machines without a name."""
    monkeypatch.setattr(place.Path, "read_text", lambda *_, **__: "")
    monkeypatch.setattr(place.platform, "processor", lambda: "")
    machine.cache_clear()
    try:
        assert machine_label().startswith("unknown processor, ")
    finally:
        machine.cache_clear()


def test_versions_are_those_of_the_metadata_and_our_own_comes_first():
    """A result depends on these and on nothing else that is installed."""
    found = versions()
    assert next(iter(found)) == "torquebench"
    for name in ("numpy", "scipy", "numba", "pin"):
        assert found[name] == version(name)


class Git:
    """Answers git's questions from a table, or fails as git does."""

    def __init__(self, answers):
        self.answers, self.asked = answers, []

    def __call__(self, command, **options):
        assert options["timeout"] and options["check"]
        self.asked.append(command[3])
        answer = self.answers[command[3]] if command[4:5] != ["--short=12"] else self.answers["commit"]
        if isinstance(answer, Exception):
            raise answer
        return subprocess.CompletedProcess(command, 0, stdout=f"{answer}\n", stderr="")


HERE = str(Path(place.__file__).resolve().parent.parent)
"""The source tree that these tests run from."""


@pytest.mark.parametrize(("changes", "mark"), [("", ""), (" M scenarios/tick.py", "+")])
def test_a_changed_tree_is_marked(monkeypatch, changes, mark):
    """A commit that does not hold the code that ran would be a false witness."""
    git = Git({"rev-parse": HERE, "commit": "0123456789ab", "status": changes})
    monkeypatch.setattr(place.subprocess, "run", git)
    assert commit() == f"0123456789ab{mark}"


@pytest.mark.parametrize(
    "answers",
    [
        {"rev-parse": "/somebody/elses/project"},
        {"rev-parse": FileNotFoundError("git")},
        {"rev-parse": subprocess.CalledProcessError(128, "git")},
        {"rev-parse": subprocess.TimeoutExpired("git", 10.0)},
    ],
)
def test_outside_our_own_checkout_there_is_no_commit(monkeypatch, answers):
    """An installation within another project's checkout must not claim that project's commit as its own."""
    monkeypatch.setattr(place.subprocess, "run", Git(answers))
    assert commit() == ""
