"""The mean gains of the null controls: what is averaged over what, and what the file says of it."""

import json
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from torquebench import gains
from torquebench.commands.train import command
from torquebench.controllers import TorquebenchError
from torquebench.gains import SECOND_LEVEL, measure_mean_gains, write_mean_gains
from torquebench.scenarios.benchmark import load_benchmark

JOINTS = 3


def row(*, lead_in=1.0, rows=400, stiffness=200.0, damping=20.0, status="ok", trace="kept"):
    """Return a row of a store whose gains are wild in the lead-in and steady after it."""
    start = round(lead_in * 1e3 / SECOND_LEVEL)
    shown = {}
    for name, size in (("stiffness", stiffness), ("damping", damping)):
        shown[f"diagnostics/{name}"] = np.full((start + rows, JOINTS), 1e6)
        shown[f"diagnostics/{name}"][start:] = size * np.arange(1.0, JOINTS + 1.0)
    specification = SimpleNamespace(lead_in=lead_in)
    return SimpleNamespace(
        specification=specification, result=SimpleNamespace(status=status), trace=trace, arrays=shown
    )


@pytest.fixture
def campaign(monkeypatch):
    """Lets a campaign have been run: its rows are what a test puts there, its calls are kept."""
    kept = SimpleNamespace(rows=[row()], calls=[])

    def run(benchmark, **options):
        kept.calls.append((benchmark, options))

    class Shelf:
        @staticmethod
        @contextmanager
        def read(folder):
            yield SimpleNamespace(
                runs=lambda: kept.rows, trace=lambda address: next(r for r in kept.rows if r.trace == address).arrays
            )

    monkeypatch.setattr(gains, "run", run)
    monkeypatch.setattr(gains, "Store", Shelf)
    return kept


def test_the_lead_in_is_no_part_of_a_mean(campaign):
    """Gains rise from their birth while the arm starts; the null is given what they settle at."""
    campaign.rows = [row(lead_in=lead_in, trace=str(lead_in)) for lead_in in (0.0, 1.0, 0.25)]
    assert measure_mean_gains("ideal") == {"stiffness": [200.0, 400.0, 600.0], "damping": [20.0, 40.0, 60.0]}


def test_every_run_weighs_the_same_however_long_it_is(campaign):
    """A mean over samples would count the slow motions thrice: 100 rows at 100, 300 rows at 300 make 200."""
    campaign.rows = [
        row(rows=100, stiffness=100.0, damping=10.0, trace="short"),
        row(rows=300, stiffness=300.0, damping=30.0, trace="long"),
    ]
    assert measure_mean_gains("ideal") == {"stiffness": [200.0, 400.0, 600.0], "damping": [20.0, 40.0, 60.0]}


def test_a_run_that_failed_is_no_part_of_a_mean(campaign):
    """Its gains are those of an arm on its way out."""
    campaign.rows = [row(), row(stiffness=9999.0, status="failed", trace="fallen")]
    assert measure_mean_gains("ideal")["stiffness"] == [200.0, 400.0, 600.0]


def test_what_is_run_is_what_the_ledger_says(campaign):
    """T1 to T8 at 1.5, 2.5 and 3.5 kg, of one controller, on the tier that was asked for."""
    from torquebench.cbmc.mean_gains import LEARNT

    measure_mean_gains("tight_rate")
    ((name, options),) = campaign.calls
    assert (options["controllers"], options["tier"]) == (["cbmc_v3"], "tight_rate")
    changed = load_benchmark(name, overrides={"controllers": ["cbmc_v3"]}, changes=options["changes"])
    assert [load.mass for load in changed.loads] == [1.5, 2.5, 3.5]
    assert {path for sweep in changed.sweeps() for path in sweep.trajectories} == {f"T{i}" for i in range(1, 9)}
    assert "T1 to T8 at 1.5, 2.5 and 3.5 kg" in LEARNT


def test_the_file_holds_a_table_for_each_tier_and_the_command_that_makes_it_again(campaign, tmp_path):
    """Numbers in a repository that nobody can reproduce are folklore."""
    file = tmp_path / "mean_gains.json"
    write_mean_gains(file, ["ideal", "actuated"])
    table = json.loads(file.read_text())
    assert list(table["tiers"]) == ["ideal", "actuated"]
    assert table["tiers"]["ideal"]["stiffness"] == [200.0, 400.0, 600.0]
    assert table["made_by"] == "torquebench train gains --tier ideal,actuated"
    assert [options["tier"] for _, options in campaign.calls] == ["ideal", "actuated"]


def test_the_file_is_read_by_the_nulls_as_it_was_written(campaign, tmp_path, monkeypatch):
    """One form on both sides, to the hundredth of a newton metre."""
    from torquebench.cbmc import mean_gains as reader

    campaign.rows = [row(stiffness=200.126, damping=20.004)]
    (tmp_path / "data").mkdir()
    write_mean_gains(tmp_path / "data" / reader.FILE, ["ideal"])
    monkeypatch.setattr(reader, "files", lambda package: tmp_path)
    reader._tables.cache_clear()
    try:
        found = reader.mean_gains("ideal", JOINTS)
    finally:
        reader._tables.cache_clear()
    assert found.stiffness.tolist() == [200.13, 400.25, 600.38]
    assert found.damping.tolist() == [20.0, 40.01, 60.01]


def test_the_command_takes_tiers_between_commas_and_says_where_it_wrote(campaign, tmp_path):
    """Blanks after a comma are typed by everyone."""
    file = tmp_path / "gains.json"
    done = CliRunner().invoke(command, ["gains", "--tier", "ideal, actuated", "--out", str(file)])
    assert done.output == f"wrote {file}\n"
    assert list(json.loads(file.read_text())["tiers"]) == ["ideal", "actuated"]


def test_the_command_has_no_default_target():
    """The shipped file must not be overwritten by a word too few."""
    done = CliRunner().invoke(command, ["gains"])
    assert done.exit_code == 2 and "--out" in done.output


@pytest.mark.parametrize(
    ("tiers", "folder", "says"),
    [
        ("ideal,actuted", "", "did you mean 'actuated'"),
        (" , ", "", "no tier"),
        ("ideal", "nowhere", "is no folder"),
    ],
)
def test_a_slip_is_found_before_the_first_run(campaign, tmp_path, tiers, folder, says):
    """A second tier misspelt, or a folder that is not there, after hours of the first: nothing would be kept."""
    file = tmp_path / folder / "gains.json"
    error = CliRunner().invoke(command, ["gains", "--tier", tiers, "--out", str(file)]).exception
    assert isinstance(error, TorquebenchError) and says in str(error)
    assert campaign.calls == [] and not file.exists()
