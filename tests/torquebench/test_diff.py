"""``torquebench diff``: one address is one result, and what moved is told from what noise moves."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from torquebench.controllers import InvalidInput
from torquebench.differing import Difference, difference
from torquebench.run_difference import run_difference
from torquebench.scenarios.result import RunResult
from torquebench.scenarios.store import Store

from .conftest import EMPTY, FULL, fill, run_of

PATHS = ("T1", "T2", "T3", "T4", "T5", "T6", "T7", "T8")


def metrics_of(position):
    """Return a row's metrics with one mean error of everything that is compared."""
    entry = {"value": position, "unit": "m", "status": "ok", "n": 100}
    names = ("tcp_position_error_mean", "tcp_orientation_error_mean", "joint_error_mean", "tcp_position_error_last_lap")
    return {"run": {name: dict(entry) for name in names}}


def shelf(folder, sizes, *, digest="code", **record):
    """Fill a store with made-up errors: controller to its error on each of eight motions [m]."""
    with Store.write(folder) as store:
        for controller, errors in sizes.items():
            for path, error in zip(PATHS, errors, strict=True):
                run = run_of(controller, path)
                store.put(run.address(digest), run, [RunResult(role="run", status="ok", metrics=metrics_of(error))])
        benchmark = {"name": "small", "reference": "pid / none"}
        store.put_campaign("2026-05-04T10:00:00+00:00", {"benchmark": benchmark, **record})
    return folder


@pytest.fixture
def errors(rng):
    """The errors of two laws on eight motions; the second is about twice the first."""
    sizes = 0.01 * np.exp(rng.normal(0.0, 0.2, 8))
    return {"pid": sizes, "pd_gravity": 2.0 * sizes}


def test_two_runs_of_one_campaign_are_equal_to_the_bit(kept, tmp_path, line):
    """Running again is the check that a user makes of a claim: nothing may be left to say."""
    shutil.copytree(kept.folder, tmp_path / "copy")
    run = run_of("flexiv_factory", tier="actuated")
    fill(tmp_path / "copy", run)
    found = difference(kept.folder, tmp_path / "copy")
    assert (found.same, found.unequal, found.only, found.shifts, found.orders) == (8, (), ((), ()), (), ())
    result = line("diff", kept.folder, tmp_path / "copy")
    assert result.return_value == 0 and "8 rows under the same address: all the same to the bit" in result.output


def test_one_address_with_two_results_is_status_1(kept, tmp_path, line):
    """Nothing else may hide that a run does not reproduce; times of the machine are no part of it."""
    folder = tmp_path / "copy"
    shutil.copytree(kept.folder, folder)
    with Store.write(folder) as store:
        row, other, *_ = store.runs()
        laps = {name: [np.nextafter(value, 1.0) for value in values] for name, values in row.result.laps.items()}
        store.put(row.address, row.specification, [replace(row.result, laps=laps)])
        store.put(other.address, other.specification, [replace(other.result, timing={"loop_s": 99.0})])
    (unequal,) = difference(kept.folder, folder).unequal
    assert (unequal.address, unequal.fields) == (row.address, ("laps",))
    result = line("diff", kept.folder, folder)
    assert result.return_value == 1 and "8 rows under the same address: 1 not the same" in result.output
    assert line("diff", kept.folder, folder, "--json").return_value == 1
    address = row.address[:12]
    assert line("diff", f"{kept.folder}:{address}", f"{folder}:{address}").return_value == 1


def test_what_only_one_folder_has_is_listed_with_what_tells_it_apart(tmp_path):
    """A seed, a tier: two lists of the same words would say nothing."""
    run = run_of()
    fill(tmp_path / "a", run)
    fill(tmp_path / "b", run, replace(run, campaign=2), run_of(load=FULL))
    first, second = difference(tmp_path / "a", tmp_path / "b").only
    assert first == ()
    assert [("seed 2" in text, "2.5 kg sand" in text) for text in second] == [(True, False), (False, True)]


def test_a_change_on_every_motion_is_beyond_the_noise_and_says_how_large(tmp_path, errors, rng):
    """A ratio of 0.8 with a scatter of 2 % over eight motions leaves no doubt; one law that did not change has none."""
    changed = {**errors, "pid": 0.8 * errors["pid"] * np.exp(rng.normal(0.0, 0.02, 8))}
    folders = shelf(tmp_path / "a", errors), shelf(tmp_path / "b", changed, digest="newer code")
    found = difference(*folders)
    assert (found.same, found.other_code) == (0, 16)
    assert {shift.comparison.controller for shift in found.shifts} == {"pid / none"}
    for shift in found.shifts:
        assert shift.beyond_noise and shift.comparison.verdict == "better"
        assert shift.comparison.gmr == pytest.approx(0.8, rel=0.03)


def test_a_change_that_the_motions_do_not_agree_on_is_not_beyond_the_noise(tmp_path, errors, line):
    """Half of them got better and half worse: that is what noise does."""
    scatter = np.exp(np.array([0.1, -0.1, 0.2, -0.15, 0.12, -0.18, 0.05, -0.08]))
    folders = (
        shelf(tmp_path / "a", errors),
        shelf(tmp_path / "b", {**errors, "pid": errors["pid"] * scatter}, digest="x"),
    )
    found = difference(*folders)
    assert len(found.shifts) == 4 and not any(shift.beyond_noise for shift in found.shifts)
    assert "4 means moved, but not enough to decide" in line("diff", *folders).output


def test_controllers_that_change_places_are_named(tmp_path, errors, line):
    """Who comes first is what a reader remembers."""
    folders = shelf(tmp_path / "a", errors), shelf(tmp_path / "b", {**errors, "pid": 3.0 * errors["pid"]}, digest="x")
    orders = {order.metric: (order.first, order.second) for order in difference(*folders).orders}
    two = ("pid / none", "pd_gravity / none")
    assert orders["tcp_position_error_mean"] == (two, two[::-1])
    assert "order by tcp_position_error_mean changed: pid / none, pd_gravity / none | " in line("diff", *folders).output
    assert difference(folders[0], folders[0]).orders == ()


def test_another_seed_is_the_same_world_drawn_again(tmp_path):
    """A claim is checked with fresh draws too, and then no address is shared."""
    run = run_of("cbmc_v3", tier="actuated")
    for name, seed in (("a", 1), ("b", 2)):
        fill(tmp_path / name, replace(run, campaign=seed), seed=seed)
    found = difference(tmp_path / "a", tmp_path / "b")
    assert found.same == 0 and {shift.comparison.controller for shift in found.shifts} == {"cbmc_v3 / none"}
    assert ("seed", 1, 2) in found.set_up


def test_versions_and_machines_are_compared_entry_by_entry(tmp_path, errors, line):
    """What changed besides the code; a campaign's time of day is none of it."""
    first = {"versions": {"numpy": "2.1.0", "scipy": "1.14"}, "machine": {"cores": 2}, "commit": "aa", "workers": 1}
    second = {"versions": {"numpy": "2.2.0", "scipy": "1.14"}, "machine": {"cores": 8}, "commit": "aa", "workers": 4}
    folders = shelf(tmp_path / "a", errors, **first), shelf(tmp_path / "b", errors, **second)
    assert difference(*folders).set_up == (("versions.numpy", "2.1.0", "2.2.0"), ("machine.cores", 2, 8))
    assert "versions.numpy: 2.1.0 | 2.2.0" in line("diff", *folders).output


def test_two_runs_are_set_side_by_side(kept, line):
    """What was asked for, what came out; equal things are left out."""
    with Store.read(kept.folder) as store:
        rows = {row.address: row for row in store.runs()}
    pair = [rows[kept.addresses["flexiv_factory", "T6", mass]] for mass in (1.5, 2.5)]
    found = run_difference(*pair)
    assert [name for name, *_ in found.specification] == ["schedule"]
    values = {moved.metric: (moved.first, moved.second) for moved in found.metrics if moved.window == "run"}
    stored = [row.result.metrics["run"]["joint_error_mean"]["value"] for row in pair]
    assert values["joint_error_mean"] == tuple(stored)
    names = [f"{kept.folder}:{row.address[:12]}" for row in pair]
    result = line("diff", *names)
    assert result.return_value == 0 and "schedule: " in result.output and "run.joint_error_mean [rad]" in result.output
    assert json.loads(line("diff", *names, "--json").output)["addresses"] == [row.address for row in pair]
    assert line("diff", names[0], names[0]).output.strip().endswith("the same to the bit")


def test_a_folder_with_a_colon_is_a_folder(tmp_path, line):
    """What exists is taken as it is named."""
    fill(tmp_path / "runs:2026", run_of(load=EMPTY))
    assert line("diff", tmp_path / "runs:2026", tmp_path / "runs:2026").return_value == 0


def test_json_has_the_verdicts_too(tmp_path, errors, line):
    """A program needs the word as much as a person."""
    folders = shelf(tmp_path / "a", errors), shelf(tmp_path / "b", {**errors, "pid": 0.5 * errors["pid"]}, digest="x")
    table = json.loads(line("diff", *folders, "--json").output)
    assert {(shift["verdict"], shift["beyond_noise"]) for shift in table["shifts"]} == {("better", True)}


@pytest.mark.parametrize("names", [("{kept}", "{kept}:abcdef12"), ("{kept}", "nowhere"), ("{kept}:abcdef12",) * 2])
def test_what_cannot_be_compared_ends_in_one_line(kept, line, names):
    """A folder with a run, a folder that is not there, an address that nobody has."""
    assert isinstance(line("diff", *(name.format(kept=kept.folder) for name in names)).exception, InvalidInput)


def test_a_folder_against_itself_differs_in_nothing(tmp_path, errors, line):
    """Every row is there twice, none moved: a script may ask for exactly this."""
    folder = shelf(tmp_path / "a", errors, versions={"numpy": "2"})
    found = difference(folder, folder)
    assert found == Difference(same=16, unequal=(), other_code=0, only=((), ()), set_up=(), shifts=(), orders=())
    shown = line("diff", folder, folder)
    assert shown.return_value == 0
    assert shown.output == "16 rows under the same address: all the same to the bit\nno mean and no order changed\n"


def test_the_other_way_round_every_ratio_is_the_inverse(tmp_path, errors):
    """What is 20 % better from A to B is worse from B to A by its inverse, with its interval turned over."""
    changed = {"pid": 3.0 * errors["pid"], "pd_gravity": errors["pd_gravity"], "computed_torque": errors["pid"]}
    first, second = shelf(tmp_path / "a", errors), shelf(tmp_path / "b", changed, digest="x", commit="b")
    there, back = difference(first, second), difference(second, first)
    assert there.only == back.only[::-1] and len(there.only[1]) == 8
    assert there.set_up == tuple((name, two, one) for name, one, two in back.set_up)
    assert [(order.first, order.second) for order in there.orders] == [(o.second, o.first) for o in back.orders]
    pairs = list(zip(there.shifts, back.shifts, strict=True))
    assert len(pairs) == 4 and {one.comparison.controller for one, _ in pairs} == {"pid / none"}
    for one, other in pairs:
        assert one.comparison.gmr * other.comparison.gmr == pytest.approx(1.0)
        forth, again = one.comparison.interval_new_motions, other.comparison.interval_new_motions
        assert (forth.low * again.high, forth.high * again.low) == pytest.approx((1.0, 1.0))
        assert {one.comparison.verdict, other.comparison.verdict} == {"better", "worse"}


def test_long_lists_are_cut_for_people_and_whole_in_json(tmp_path, errors, line):
    """A hundred runs that only one folder has are one number and twenty names."""
    laws = [f"law_{number}" for number in range(5)]
    more = {**errors, **dict.fromkeys(laws, errors["pid"])}
    folders = shelf(tmp_path / "a", errors), shelf(tmp_path / "b", more)
    shown = line("diff", *folders).output.splitlines()
    (start,) = (place for place, text in enumerate(shown) if text == "40 runs only in B")
    assert all(text.startswith("  law_") for text in shown[start + 1 : start + 21])
    assert shown[start + 21] == "  and 20 more: --json lists all"
    assert len(json.loads(line("diff", *folders, "--json").output)["only"][1]) == 40


def test_what_one_run_has_more_than_the_other_is_none_on_the_other_side(kept):
    """Set side by side in either order, the same things are named, with their values changed over."""
    with Store.read(kept.folder) as store:
        first, second = store.runs()[:2]
    metrics = {window: dict(entries) for window, entries in second.result.metrics.items()}
    del metrics["run"]["joint_error_mean"]
    second = replace(second, result=replace(second.result, metrics=metrics))
    there, back = run_difference(first, second), run_difference(second, first)
    assert there.specification == tuple((name, two, one) for name, one, two in back.specification)
    assert [(m.metric, m.first, m.second) for m in there.metrics] == [
        (m.metric, m.second, m.first) for m in back.metrics
    ]
    (lost,) = (m for m in there.metrics if (m.window, m.metric) == ("run", "joint_error_mean"))
    assert lost.first is not None and lost.second is None and lost.unit == "rad"
    assert not run_difference(first, first).metrics and not run_difference(first, first).broken
