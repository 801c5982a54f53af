"""Scripts that the docs quote: they run, and their figures are what they say."""

import csv
import runpy
from pathlib import Path

import pytest
from torquebench.scenarios.benchmark import Sweep, load_benchmark
from torquebench.scenarios.expansion import expand

SCRIPT = Path(__file__).parents[1] / "examples" / "lag_table.py"


@pytest.fixture
def printed(tmp_path, capsys):
    """Runs the script on a report of given rows and returns what it printed, line by line."""
    names = runpy.run_path(str(SCRIPT))

    def run(*rows):
        columns = [column for column, _ in names["FIGURES"].values()]
        (tmp_path / "report").mkdir()
        with (tmp_path / "report" / "runs.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["label", "trajectory", "group", "status", *columns])
            writer.writerows([*row[:4], *[row[4]] * len(columns)] for row in rows)
        names["main"](str(tmp_path))
        return capsys.readouterr().out.splitlines()

    return run


def test_every_trajectory_weighs_the_same_and_ranges_are_of_their_means(printed):
    """T1 with two loads must not count twice: (2 + 6) / 2, not (1 + 3 + 6) / 3."""
    lines = printed(("a", "T1", "slow", "ok", 1.0), ("a", "T1", "slow", "ok", 3.0), ("a", "T2", "slow", "ok", 6.0))
    share = {line.split(" |")[0].strip("| "): line.split(" | ")[4] for line in lines if line.startswith("|")}
    assert (share["T1"], share["T2"]) == ("2.00", "6.00")
    assert (share["mean"], share["range, slow"]) == ("4.00", "4.00")


def test_a_run_that_failed_is_counted_and_not_averaged(printed):
    """Its error is that of an arm on its way out; leaving it out unseen would flatter the law."""
    fell = ("T1", "slow", "failed", 9.0)
    lines = printed(("a", "T1", "slow", "ok", 1.0), ("a", *fell), ("b", *fell))
    assert "a: 1 of 2 runs finished" in lines and "b: 0 of 1 runs finished" in lines
    assert not [line for line in lines if "9.00" in line]


def test_metres_become_millimetres_and_the_share_stays(printed):
    """A factor forgotten is a factor of a thousand."""
    (line,) = [line for line in printed(("a", "T1", "slow", "ok", 0.018)) if line.startswith("| T1")]
    cells = line.split(" | ")[1:]
    assert (cells[0], cells[1], cells[3]) == ("18.00", "18.00", "0.02")


def test_the_benchmark_that_a_page_quotes_is_the_example_and_asks_for_what_it_says():
    """A reader copies it: constant loads are drawn twice, the history runs with twins in two worlds."""
    root = SCRIPT.parents[1]
    example = root / "examples" / "lifting.toml"
    page = (root / "docs" / "writing-a-benchmark.md").read_text(encoding="utf-8")
    assert page.partition("```toml\n")[2].partition("```")[0] == example.read_text(encoding="utf-8")
    runs = expand(load_benchmark(str(example))).specifications
    drawn = [run for run in runs if run.draws]
    assert len(drawn) == 2 * 2 * 2 * 2 and not any(run.schedule.events for run in drawn)
    events = [run for run in runs if run.schedule.events]
    assert {run.tier for run in events} == {"actuated", "ideal"} and all(run.twins for run in events)
    assert len(runs) == len(drawn) + len(events) == 24


def test_every_key_of_a_run_table_is_on_the_page():
    """A key that nobody can read about does not exist."""
    page = (SCRIPT.parents[1] / "docs" / "writing-a-benchmark.md").read_text(encoding="utf-8")
    assert [name for name in Sweep.model_fields if f"`{name}" not in page and f"{name} =" not in page] == []
