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
from torquebench.evaluation.report.efficiency_tables import COUNTED, MECHANICAL, mechanical_table
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
    captions = re.findall(r'id="w1-(?:counts|estimates|host)">\s*<caption>(.*?)</caption>', page)
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
