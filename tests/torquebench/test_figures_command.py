"""``torquebench figures``: with matplotlib it writes files and names them, without it says what to install."""

import importlib.util

import pytest
from torquebench.controllers import InvalidInput


def test_without_matplotlib_one_line_says_what_to_install(kept, line, monkeypatch):
    """It is an extra: nothing else of the package needs it."""
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    error = line("figures", kept.folder).exception
    assert isinstance(error, InvalidInput) and "pip install 'torquebench[figures]'" in str(error)


def test_the_files_of_real_runs_are_named_and_there(kept, line, tmp_path):
    """Two controllers, two loads: intervals, errors by trajectory and mass, modules, gains."""
    pytest.importorskip("matplotlib")
    out = tmp_path / "print"
    printed = line("figures", kept.folder, "--out", out).output.split()
    assert sorted(printed) == sorted(str(file) for file in out.iterdir())
    names = {file.stem for file in out.iterdir()}
    assert {"w1-intervals", "w1-errors-by-trajectory", "w1-errors-by-mass", "w1-modules", "w1-gains"} == names
