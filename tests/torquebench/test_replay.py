"""``torquebench replay``: back to a run, again to the bit, and into another controller."""

import json
from dataclasses import replace

import numpy as np
import pytest
from torquebench.controllers import InvalidInput, Refusal, UnknownName
from torquebench.repeating import differing_fields, repeat, rows_at
from torquebench.replaying import feed_into, place_on_page, stored_rows
from torquebench.scenarios.loads import LoadSchedule
from torquebench.scenarios.perturbation import Perturbation
from torquebench.scenarios.result import RunResult
from torquebench.scenarios.store import Store

from .conftest import EMPTY, FULL, fill, run_of

STEP = LoadSchedule(entries=((0.0, EMPTY), (1.0, FULL)))


def row_of(tmp_path, run, **options):
    """Run a specification into a store and return its row."""
    (address,) = fill(tmp_path / "store", run, **options)
    return stored_rows(tmp_path / "store", address)[0]


@pytest.mark.parametrize(
    "run",
    [
        run_of("cbmc_v3", tier="actuated"),
        run_of("computed_torque", tier="actuated", knowledge="oracle", schedule=STEP),
        run_of("computed_torque", tier="actuated", knowledge="ft_estimate", schedule=STEP, latency=3, tare=True),
        run_of("flexiv_factory", tier="actuated", draws=True, load=FULL),
        run_of("computed_torque", perturbation=Perturbation(velocity_noise=0.02, gain=1.1)),
        run_of("computed_torque", settings={"bandwidth": 30.0}),
    ],
    ids=["spiking", "oracle, step", "estimate, late, tared", "draws", "noise, gain", "settings"],
)
def test_a_controller_fed_with_its_own_run_answers_every_torque_to_the_bit(tmp_path, run):
    """Sensors, plan, seeds, knowledge and the previous command: one that is off by a tick would show here."""
    answers = feed_into(row_of(tmp_path, run), run.controller, {})
    assert (answers.ticks, answers.of, answers.first, answers.failure) == (2100, 2100, None, "")
    assert answers.rms == answers.peak == (0.0,) * 7


def test_another_controller_answers_what_its_law_says(tmp_path):
    """Two laws that differ by their bandwidth differ from the first error on, and by less with a smaller change."""
    row = row_of(tmp_path, run_of("computed_torque"))
    near, far = (feed_into(row, "computed_torque", {"bandwidth": width}) for width in (20.2, 30.0))
    assert near.first is not None and near.ticks == near.of
    assert 0.0 < np.linalg.norm(near.rms) < 0.1 * np.linalg.norm(far.rms)
    assert all(rms <= peak for rms, peak in zip(far.rms, far.peak, strict=True))


def test_a_law_that_fails_on_the_way_is_compared_up_to_there(kept, laws, line):
    """What it answered is still an answer; the status says that it did not finish."""
    address = kept.addresses["flexiv_factory", "T6", 1.5]
    result = line("replay", kept.folder, address[:12], "--into", f"{laws}:Late")
    assert result.return_value == 1
    assert "answered 100 of 2100 ticks" in result.output and "RuntimeError: too late" in result.output
    nothing = feed_into(stored_rows(kept.folder, address)[0], f"{laws}:Scalar", {})
    assert nothing.ticks == 0 and "expected an array of shape (7,)" in nothing.failure and nothing.rms == ()


def test_a_run_that_does_not_come_out_the_same_is_not_fed(tmp_path):
    """Answers to another run than the stored one would be figures about nothing."""
    row = row_of(tmp_path, run_of())
    wrong = replace(row, result=replace(row.result, laps={"tcp_position_error_mean": [0.0]}))
    with pytest.raises(InvalidInput, match="does not come out the same again"):
        feed_into(wrong, "computed_torque", {})


def test_what_is_no_single_run_is_refused_in_one_line(tmp_path):
    """A chain learns from repetition to repetition; a wall time does not come again; a refused run has no tick."""
    chain = row_of(tmp_path / "a", run_of(protocol="carried", repetitions=2))
    with pytest.raises(InvalidInput, match="chain of protocol 'carried' is not one run"):
        feed_into(chain, "computed_torque", {})
    with pytest.raises(InvalidInput, match="measured latency"):
        feed_into(replace(chain, specification=run_of(latency="measured")), "computed_torque", {})
    with pytest.raises(UnknownName, match="did you mean 'computed_torque'"):
        feed_into(row_of(tmp_path / "b", run_of()), "computed_torqu", {})


def test_a_controller_that_refuses_the_task_refuses_here_too(tmp_path, laws):
    """Its reason is the line."""
    laws.with_name("picky.py").write_text(laws.read_text() + "\nclass Picky(Late):\n    supports = lambda s, t: 'no'\n")
    with pytest.raises(Refusal, match="no"):
        feed_into(row_of(tmp_path, run_of()), f"{laws.with_name('picky.py')}:Picky", {})


def test_a_run_with_twins_repeats_with_all_its_rows(tmp_path):
    """Events are judged again too: every row, every field but times and traces."""
    run = run_of(schedule=STEP, twins=True)
    fill(tmp_path / "store", run)
    with Store.read(tmp_path / "store") as store:
        rows = store.runs()
    repeated = repeat(rows)
    assert (repeated.rows, repeated.differences) == (3, ())
    assert feed_into(rows[0], "flexiv_factory", {}).first is None


def test_a_chain_repeats_with_all_its_rows(tmp_path):
    """What is learnt on the way is part of it."""
    fill(tmp_path / "store", run_of("no_thalamus_learning", protocol="carried", repetitions=2, laps=1))
    with Store.read(tmp_path / "store") as store:
        assert (repeat(store.runs()).rows, repeat(store.runs()).differences) == (2, ())


def test_a_figure_that_moved_in_its_last_bit_is_named(tmp_path, line):
    """The row's field and no other; the status is 1."""
    (address,) = fill(tmp_path / "store", run_of())
    with Store.write(tmp_path / "store") as store:
        (row,) = store.runs()
        moved = json.loads(json.dumps(dict(row.result.metrics)))
        entry = moved["run"]["joint_error_mean"]
        entry["value"] = float(np.nextafter(entry["value"], 1.0))
        store.put(address, row.specification, [replace(row.result, metrics=moved)])
    result = line("replay", tmp_path / "store", address, "--again")
    assert result.return_value == 1
    assert "run, repetition 0: metrics" in result.output and "laps" not in result.output


def test_nan_is_the_same_as_nan_and_a_machine_is_no_part_of_a_result():
    """Undefined metrics are stored as NaN, which is not equal to itself."""
    one = RunResult(
        role="run", status="ok", metrics={"run": {"a": {"value": float("nan")}}}, provenance={"machine": "x"}
    )
    assert differing_fields(one, replace(one, provenance={"machine": "y"})) == []
    assert differing_fields(one, replace(one, status="failed", failed_at=1.0)) == ["status", "failed_at"]


def test_a_run_is_found_on_the_page_by_its_first_digits(kept, line):
    """The fragment is that of the run's own row; a report that is not there is written."""
    address = kept.addresses["cbmc_v3", "T7", 2.5]
    url = place_on_page(kept.folder, address[:8])
    page = kept.folder / "report" / "index.html"
    assert url == f"{page.resolve().as_uri()}#run-{address[:12]}"
    assert f'id="run-{address[:12]}"' in page.read_text()
    assert line("replay", kept.folder, address[:8]).output.strip() == url
    assert json.loads(line("replay", kept.folder, address[:8], "--json").output) == {"url": url}


def test_an_address_must_be_known_and_told_apart(kept):
    """A slip of one digit names the right one; few digits are no address."""
    with Store.read(kept.folder) as store:
        rows = store.runs()
    address = rows[0].address
    slip = address[:11] + ("0" if address[11] != "0" else "1")
    with pytest.raises(InvalidInput, match=f"did you mean '{address[:12]}'"):
        rows_at(rows, slip)
    with pytest.raises(InvalidInput, match="6 digits or more"):
        rows_at(rows, address[:5])
    with pytest.raises(InvalidInput, match="begins 2 addresses"):
        rows_at([rows[0], replace(rows[1], address=address[:20] + "f" * 44)], address[:12])


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (("--again", "--into", "cbmc_v3"), "one of them at a time"),
        (("--set", "gain=3"), "--set without --into"),
        (("--into", "computed_torque", "--set", "bandwidth"), "expected key=value"),
        (("--into", "computed_torque", "--set", "bandwith=3"), "bandwidth"),
    ],
)
def test_flags_that_do_not_fit_end_in_one_line(kept, line, flags, words):
    """Nothing is run for a question that has no meaning."""
    error = line("replay", kept.folder, kept.addresses["flexiv_factory", "T6", 1.5], *flags).exception
    assert isinstance(error, InvalidInput) and words in str(error)


def test_settings_are_numbers_or_words(kept, line):
    """As everywhere on the command line: TOML, and a word needs no quotes."""
    address = kept.addresses["flexiv_factory", "T6", 1.5]
    done = line("replay", kept.folder, address, "--into", "computed_torque", "--set", "bandwidth=25", "--json")
    table = json.loads(done.output)
    assert table["controller"] == "computed_torque" and len(table["rms"]) == 7 and table["first"][0] == 0
