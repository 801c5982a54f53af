"""The page of metrics: its tables are the registry's, its quotations real, its Python runs."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from torquebench import cli
from torquebench.evaluation.metrics import METRICS, Metric
from torquebench.evaluation.metrics.catalogue import MARKER, catalogue, main, page_with

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "metrics.md"
TEXT = PAGE.read_text(encoding="utf-8")


def quoted(language):
    """Return the page's blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)


def test_the_tables_are_what_the_registry_says_today():
    """Who adds a metric renews the page: `python -m torquebench.evaluation.metrics.catalogue docs/metrics.md`."""
    assert page_with(TEXT, catalogue()) == TEXT


def test_every_metric_has_one_row_with_all_cells():
    """A bar in a formula must not make a cell of its own."""
    rows = [line for line in catalogue().splitlines() if line.startswith("| `")]
    assert [re.match(r"\| `(\w+)`", row).group(1) for row in rows] == list(METRICS)
    assert {len(re.split(r"(?<!\\)\|", row)) for row in rows} == {7 + 2}


def test_renewing_a_page_keeps_its_words(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(f"# Words\n{MARKER}\nold tables\n", encoding="utf-8")
    main(page)
    assert page.read_text(encoding="utf-8") == f"# Words\n{MARKER}\n{catalogue()}"


def test_the_metrics_that_are_registered_are_those_that_are_built_in():
    """One list for plug-ins and one for the library: neither may fall behind."""
    points = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
    registered = {name: path.rpartition(":") for name, path in points["torquebench.metrics"].items()}
    assert set(registered) == set(METRICS)
    for name, (module, _, attribute) in registered.items():
        assert (module, attribute) == (METRICS[name].__module__, name)


def test_the_mapping_and_the_output_that_are_shown_are_the_examples_own():
    """The walk-through is a log of the examples; last digits may differ by machine, words may not."""
    assert (ROOT / "examples" / "own_log.toml").read_text(encoding="utf-8") == quoted("toml")[0]
    log, mapping = (str(ROOT / "examples" / f"own_log.{kind}") for kind in ("csv", "toml"))
    printed = CliRunner().invoke(cli.group, ["evaluate", log, "--map", mapping], standalone_mode=False).output
    found = {words[0]: words for line in printed.splitlines() if (words := line.split())}
    head, *rows, without = quoted("text")[0].splitlines()
    assert head.split() == found["run"] and without in printed.splitlines()
    for name, run, steady, *unit in map(str.split, rows):
        assert unit == found[name][3:]
        shown = [float(run), float(steady)]
        assert shown == pytest.approx([float(value) for value in found[name][1:3]], rel=1e-3)


def test_the_python_that_is_shown_runs(capsys):
    """A reader copies it: the log of arrays is 25 ms late and lacks the torque; the metric of one's own is one."""
    arrays, own = quoted("python")
    exec(compile(arrays, PAGE.name, "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert any(re.match(r"time_lag +0\.025 s ok", line) for line in lines)
    assert lines[-1] == "('tau',)"
    names = {"__name__": "page"}
    exec(compile(own, PAGE.name, "exec"), names)
    assert isinstance(names["height_max"], Metric)
    assert names["height_max"](np.array([[0.0, 0.0, 0.3]])) == 0.3


HEAVY = ("pybullet", "torch", "casadi", "pinocchio", "plotly", "numba", "control", "proxsuite", "matplotlib", "click")


def loaded_after(program):
    """Return which of the heavy modules, and of SciPy, a fresh interpreter holds after a program."""
    report = f"import sys; print(*[name for name in {(*HEAVY, 'scipy')!r} if name in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-P", "-c", f"{program}\n{report}"], capture_output=True, text=True, check=True
    )
    return done.stdout.split()


def test_importing_evaluation_loads_numpy_and_nothing_heavy():
    """An analyst imports one metric: no simulator, no solver, no plots, SciPy only once a function needs it."""
    assert loaded_after("import torquebench.evaluation") == []


def test_evaluating_a_log_of_ones_own_loads_scipy_and_no_more():
    """All that the page's arrays allow is computed, in an interpreter that never saw the harness."""
    program = quoted("python")[0].replace("print(", "str(")
    assert loaded_after(program) == ["scipy"]
