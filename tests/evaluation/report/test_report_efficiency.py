"""The section on efficiency: three kinds of figures apart, fronts that are fronts, and no word that says more."""

import re
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.controllers.operations import OperationCosts, OperationCounts
from torquebench.evaluation.report import write_report
from torquebench.evaluation.report.drawing import draw
from torquebench.evaluation.report.efficiency import efficiency_of, front
from torquebench.evaluation.report.efficiency_panel import pareto_charts
from torquebench.evaluation.report.efficiency_tables import (
    COUNTED,
    MECHANICAL,
    count_table,
    estimate_table,
    host_table,
    mechanical_table,
)
from torquebench.evaluation.report.findings import find_all
from torquebench.evaluation.report.worlds import worlds_of
from torquebench.scenarios.store import Store

PRICES = {"flexiv_factory": 400.0, "flexiv_full_ff": 800.0, "computed_torque": 100.0, "computed_torque_pid": 200.0}
"""Multiplications of a tick; :func:`counted` knows no other controller."""


def counted(run):
    name = run.specification.controller
    if name not in PRICES:
        return None
    events = {
        "ticks": OperationCounts(multiplications=PRICES[name], touched=10.0),
        "spikes": OperationCounts(acs=2.0, learning_macs=1.0),
    }
    return OperationCosts(by_event=events, parameters=100, state=10, how="by hand")


@pytest.fixture
def grid(shelf):
    shelf.grid(trajectories=("T1", "T6"), masses=(1.5,))
    for trajectory in ("T1", "T6"):
        run = shelf.specification("mine", "none", trajectory, 1.5)
        shelf.put(run, shelf.result(run, 1e-3, "slow"))
    return shelf.campaign()


def findings_of(shelf):
    shelf.store.close()
    with Store.read(shelf.folder) as store:
        return find_all(worlds_of(store.runs(), store.campaigns()))[0]


points = st.dictionaries(
    st.sampled_from("abcdefgh"), st.tuples(st.integers(0, 4), st.integers(0, 4)), min_size=1, max_size=8
)


@given(points, st.fixed_dictionaries({name: st.sampled_from(["none", "oracle"]) for name in "abcdefgh"}))
def test_who_is_off_the_front_is_beaten_by_one_of_the_same_knowledge_on_it(found, group):
    """An oracle may not push the uninformed off; and no group is without a front."""
    ahead = front(found, group)
    assert {group[name] for name in ahead} == {group[name] for name in found}
    for name, (error, energy) in found.items():
        beaten = [
            other
            for other in ahead
            if group[other] == group[name]
            and found[other] != (error, energy)
            and found[other][0] <= error
            and found[other][1] <= energy
        ]
        assert bool(beaten) == (name not in ahead)


def test_events_are_counted_by_simulated_second(grid):
    """13 000 ticks in 13 s are a thousand a second."""
    efficiency = efficiency_of(findings_of(grid), counted)
    computing = efficiency.found["computed_torque / none"]
    assert computing.counts == OperationCounts(multiplications=100e3, touched=10e3)
    assert computing.estimate.inference == pytest.approx(100e3 * 3.7e-6)


def test_a_controllers_own_counters_are_events_too(shelf):
    run = shelf.specification("computed_torque", "none")
    result = shelf.result(run, 1e-3, "slow")
    shelf.put(run, replace(result, counts={**result.counts, "operations": {"spikes": 26_000}}))
    (computing,) = efficiency_of(findings_of(shelf.campaign()), counted).found.values()
    assert computing.counts.acs == 2.0 * 2000.0
    assert computing.counts.learning_macs == 2000.0
    assert computing.estimate.learning == pytest.approx(2000.0 * 4.6e-6)


def test_the_cheapest_of_each_knowledge_is_on_the_front(grid):
    efficiency = efficiency_of(findings_of(grid), counted)
    assert efficiency.fronts[0] == {"computed_torque / none", "computed_torque / oracle", "computed_torque_pid / none"}


def test_the_page_keeps_three_kinds_of_figures_apart(grid):
    """Each has a table of its own; the estimates are called so where they stand; who is not counted is named."""
    grid.store.close()
    files = write_report(grid.folder, costs_of=counted)
    page = files.index.read_text(encoding="utf-8")
    for table in ("counts", "estimates", "host"):
        assert f'id="w1-{table}"' in page
    captions = re.findall(r'id="w1-(?:counts|estimates|host)">\s*<caption><span>(.*?)</span></caption>', page)
    assert captions[0] == "Operations for a second of simulated time"
    assert captions[1].startswith("Estimates, not measurements")
    assert captions[2].startswith("Measured on the host") and "x86-64, 8 cores" in captions[2]
    assert "Not counted: mine / none." in page
    assert "Nothing was measured on neuromorphic hardware" in page
    assert "No metric of mechanical energy" in page
    assert {f"w1-pareto-{name}.svg" for name in ("arithmetic", "memory")} <= {f.name for f in files.figures.iterdir()}


def test_programs_get_what_the_page_shows(grid):
    grid.store.close()
    text = write_report(grid.folder, costs_of=counted).summary.read_text(encoding="utf-8")
    assert '"estimates_measured": false' in text
    assert '"estimate_with_memory_uW"' in text


def test_without_counts_there_is_no_such_section(quick):
    """A plug-in's own campaign must not show an empty chapter."""
    assert "-efficiency" not in quick.html
    assert "efficiency" not in quick.summary["worlds"][0]


def test_dominated_marks_differ_in_shape_and_not_in_colour_alone(grid):
    found = findings_of(grid)
    charts = pareto_charts(found, efficiency_of(found, counted))
    assert [chart.id for chart in charts] == ["w1-pareto-arithmetic", "w1-pareto-memory"]
    shapes = {point.title.partition(":")[0]: point.shape for point in charts[0].points}
    assert shapes["computed_torque_pid / none"] == "circle"
    assert shapes["flexiv_factory / none"] == "diamond"
    drawn = draw(charts[0])
    assert drawn.count("<circle") == 3 and drawn.count("l5 5-5 5-5-5Z") == 2


def test_marks_on_one_spot_do_not_print_their_numbers_over_each_other(grid):
    found = findings_of(grid)
    chart = pareto_charts(found, efficiency_of(found, counted))[0]
    piled = replace(chart, points=[replace(chart.points[0], key=str(number)) for number in range(20)])
    places = [tuple(map(float, place)) for place in re.findall(r'"end" x="([\d.]+)" y="([\d.]+)"', draw(piled))]
    assert 0 < len(places) < 20
    assert all(abs(x - u) >= 14 or abs(y - v) >= 11 for k, (x, y) in enumerate(places) for u, v in places[:k])


def test_one_controller_alone_has_no_front_to_draw(shelf):
    run = shelf.specification("computed_torque", "none")
    shelf.put(run, shelf.result(run, 1e-3, "slow"))
    found = findings_of(shelf.campaign())
    assert pareto_charts(found, efficiency_of(found, counted)) == []


def test_mechanical_energy_fills_itself_from_the_registry(grid, monkeypatch):
    """Its metrics come from a family of their own: whichever of them is registered and computed is shown."""
    from torquebench.evaluation.metrics import METRICS
    from torquebench.evaluation.report import efficiency_tables

    monkeypatch.setattr(efficiency_tables, "MECHANICAL", ("torque_rate_rms",))
    found = findings_of(grid)
    assert [column.text for column in mechanical_table(found).columns][1:] == [METRICS["torque_rate_rms"].label]
    monkeypatch.setattr(efficiency_tables, "MECHANICAL", ("no_such_metric",))
    assert mechanical_table(found).rows == []
    assert "energy_positive" in MECHANICAL


def test_every_count_has_its_column():
    """A count that no table shows would be in the estimate and nowhere else."""
    from torquebench.controllers.operations import COUNTS

    assert {name for name, *_ in COUNTED} == {*COUNTS, "arithmetic"} - {"touched"}


def put(shelf, controller, *, knowledge="none", trajectory="T1", ticks=13000, simulated=13.0, **timing):
    """Put a run with its own ticks and seconds on the shelf."""
    run = shelf.specification(controller, knowledge, trajectory)
    result = shelf.result(run, 1e-3, "slow")
    counts = {**result.counts, "ticks": ticks}
    shelf.put(run, replace(result, counts=counts, timing={**result.timing, "simulated_s": simulated, **timing}))


def test_long_runs_weigh_by_their_seconds(shelf):
    """Ticks of all runs by seconds of all runs: 1000 in 1 s and 9000 in 3 s are 2500 a second, not 2000."""
    put(shelf, "computed_torque", trajectory="T1", ticks=1000, simulated=1.0)
    put(shelf, "computed_torque", trajectory="T6", ticks=9000, simulated=3.0)
    (computing,) = efficiency_of(findings_of(shelf.campaign()), counted).found.values()
    assert computing.counts.multiplications == pytest.approx(100.0 * 2500.0)


def test_a_run_that_failed_or_noted_no_time_buys_nothing(shelf):
    """A controller whose runs all fell over computes little: its cost is no bargain, it is not there."""
    shelf.fail(shelf.specification("flexiv_factory", "none"))
    put(shelf, "computed_torque")
    put(shelf, "computed_torque_pid", simulated=0.0)
    found = efficiency_of(findings_of(shelf.campaign()), counted)
    assert set(found.found) == {"computed_torque / none"}
    assert list(found.uncounted) == ["computed_torque_pid / none"]


def test_a_counter_without_a_price_changes_nothing_and_a_price_without_a_counter_is_zero(shelf):
    """Counters of a newer version must not stop an old page; an event that never came costs nothing."""
    run = shelf.specification("computed_torque", "none")
    result = shelf.result(run, 1e-3, "slow")
    shelf.put(run, replace(result, counts={**result.counts, "operations": {"newer": 1e9}}))
    (computing,) = efficiency_of(findings_of(shelf.campaign()), counted).found.values()
    assert computing.counts == OperationCounts(multiplications=100e3, touched=10e3)


def column(table, title):
    """Return the numbers of a column."""
    (place,) = [k for k, c in enumerate(table.columns) if c.title == title]
    return [row[place].value for row in table.rows]


def test_the_table_of_counts_is_the_counts_in_millions_and_bytes(grid):
    """100 parameters and 10 numbers of state at 4 bytes; 400 products a thousand times a second are 0.4 million."""
    found = findings_of(grid)
    efficiency = efficiency_of(found, counted)
    table = count_table(found, efficiency)
    expected = [found_.counts.multiplications * 1e-6 for found_ in efficiency.found.values()]
    assert column(table, "As carried out: \N{MULTIPLICATION SIGN} [10\N{SUPERSCRIPT SIX}/s]") == pytest.approx(expected)
    assert column(table, "Memory: Parameters [kB]") == pytest.approx([0.4] * len(table.rows))
    assert column(table, "Memory: State [kB]") == pytest.approx([0.04] * len(table.rows))
    assert column(table, "Memory: Touched [MB/s]") == pytest.approx([10 * 1000 * 4e-6] * len(table.rows))


def test_the_table_of_estimates_adds_up_and_says_who_is_not_compared(grid):
    """Inference and learning make up both; without the whole grid there is no error to set an estimate beside."""
    put(grid, "computed_torque", knowledge="ft_estimate")
    found = findings_of(grid)
    table = estimate_table(found, efficiency_of(found, counted))
    parts = [
        column(table, f"Estimate, arithmetic: {name} [\N{MICRO SIGN}W]") for name in ("Inference", "Learning", "Both")
    ]
    assert [one + two for one, two in zip(*parts[:2], strict=True)] == pytest.approx(parts[2])
    traffic = column(table, "Estimate, with memory: Arithmetic and traffic [\N{MICRO SIGN}W]")
    assert all(whole > part for whole, part in zip(traffic, parts[2], strict=True))
    words = {row[0].text: (row[2].value, row[-1].text) for row in table.rows}
    assert words["computed_torque / ft_estimate"] == (None, "not compared")
    assert words["flexiv_factory / none"][1] == "dominated"
    assert words["computed_torque / none"][1] == "arithmetic, with memory"


def test_the_hosts_time_is_that_of_the_calls_by_simulated_time(shelf):
    """26 ms of calls in 13 s are 2 ms a second; who noted no time has no number, and the machine is named."""
    put(shelf, "computed_torque", call_s=0.026)
    put(shelf, "computed_torque_pid")
    table = host_table(findings_of(shelf.campaign()), ["x, 8 cores", "y, 2 cores"])
    shares = dict(zip([row[0].text for row in table.rows], column(table, "Time [ms/s]"), strict=True))
    assert shares == {"computed_torque / none": pytest.approx(2.0), "computed_torque_pid / none": None}
    assert table.caption == "Measured on the host, one thread: x, 8 cores; y, 2 cores"
    assert "an unknown machine" in host_table(findings_of(shelf), []).caption


def test_the_hosts_time_is_pooled_over_runs_of_different_length(shelf):
    """Calls of all runs by seconds of all runs: a median by a median is the time of no run, and of no mean of runs."""
    for trajectory, called, simulated in (("T1", 0.010, 10.0), ("T2", 0.050, 10.0), ("T6", 0.060, 2.0)):
        put(shelf, "computed_torque", trajectory=trajectory, simulated=simulated, call_s=called)
    table = host_table(findings_of(shelf.campaign()), [])
    assert column(table, "Time [ms/s]") == [pytest.approx(120.0 / 22.0)]


@given(points, st.sampled_from("abcdefgh"))
def test_a_front_is_blind_to_who_is_not_on_it(found, name):
    """Taking away a dominated controller moves nobody; so it does not matter which losers a campaign includes."""
    group = dict.fromkeys("abcdefgh", "none")
    ahead = front(found, group)
    if name in found and name not in ahead:
        assert front({other: point for other, point in found.items() if other != name}, group) == ahead
