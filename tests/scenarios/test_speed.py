"""Speed figures: what a bar means, and that each figure measures what its name says."""

from types import SimpleNamespace

import numpy as np
import pytest
from torquebench.scenarios import speed
from torquebench.scenarios.result import RunResult
from torquebench.scenarios.speed import Figure, Holding, call_time, end_to_end, measure_speed, plant_time, wrench_time


@pytest.mark.parametrize(
    ("value", "bar", "at_least", "met"),
    [
        (5.0, None, False, True),
        (5.0, 5.0, False, True),
        (5.1, 5.0, False, False),
        (5.0, 5.0, True, True),
        (4.9, 5.0, True, False),
        (float("nan"), 5.0, False, False),
        (float("nan"), 5.0, True, False),
    ],
)
def test_a_bar_is_a_ceiling_or_a_floor_and_what_was_not_measured_misses_it(value, bar, at_least, met):
    """A controller whose runs fail has no time: nobody may read that as fast."""
    assert Figure(name="tick", value=value, unit="us", bar=bar, at_least=at_least).met is met


def test_a_controller_that_costs_nothing_gives_one_buffer():
    """A copy of seven numbers would be measured as the harness's own cost."""
    torque = np.arange(7.0)
    holding = Holding(torque)
    assert holding.compute(None, None) is holding.compute(None, None) is torque


class Clocked:
    """A plant whose calls take a known time, by a clock of its own that no other load of the machine moves."""

    def __init__(self, *, step, wrench):
        self.times, self.calls, self.now = {"step": step, "wrench": wrench}, 0, 0.0

    def perf_counter(self):
        return self.now

    def gravity(self):
        return np.ones(7)

    def step(self, torque):
        assert torque.tolist() == [1.0] * 7
        self._spend("step")

    def measure_wrench(self):
        self._spend("wrench")

    def _spend(self, name):
        self.calls += 1
        self.now += self.times[name]


@pytest.fixture
def quickly(monkeypatch):
    """One repeat of few calls: the law of a figure is the same, its noise is not."""
    best = speed._best
    monkeypatch.setattr(speed, "_best", lambda call: best(call, number=20))
    monkeypatch.setattr(speed, "REPEATS", 2)


def test_the_time_of_a_step_is_that_of_one_call_in_microseconds(quickly, monkeypatch):
    """Not of five hundred, not in seconds; the warm-up is not in it."""
    plant = Clocked(step=200e-6, wrench=100e-6)
    monkeypatch.setattr(speed, "time", plant)
    world = SimpleNamespace(plant=plant)
    assert plant_time(world) == pytest.approx(200.0)
    assert plant.calls == 1 + 2 * 20
    assert wrench_time(world) == pytest.approx(100.0)


def rows(monkeypatch, *timings, status="ok"):
    """Let runs take known times, one after the other."""
    waiting = iter(timings)
    monkeypatch.setattr(speed, "REPEATS", len(timings))

    def run(specification, **options):
        assert specification.tier == "ideal"
        return (RunResult(role="run", status=status, timing=next(waiting)),)

    monkeypatch.setattr(speed, "execute", run)


def test_the_best_of_the_repeats_counts_whichever_way_is_better(monkeypatch):
    """The least disturbed repeat: the shortest call, the largest factor."""
    rows(monkeypatch, *({"call_us_median": value} for value in (9.0, 7.0, 8.0)))
    assert call_time("computed_torque", "pinocchio") == 7.0
    rows(monkeypatch, *({"simulated_s": 11.0, "total_s": value} for value in (0.5, 0.25, 1.0)))
    assert end_to_end("computed_torque", "pinocchio", lambda log: None) == 44.0


def test_a_controller_whose_run_fails_has_no_time(monkeypatch):
    """The few calls before it fell are no measure of what it costs."""
    rows(monkeypatch, {"call_us_median": 1.0}, {"call_us_median": 1.0}, status="failed")
    assert np.isnan(call_time("computed_torque", "pinocchio"))


def test_figures_that_are_differences_and_quotients_are_those_of_the_others(monkeypatch):
    """Recomputed from what was measured: ticks of 10 and 15 us, a step of 6 us with a reading of 1 us in it."""
    ticks = {"ideal": 10.0, "actuated": 15.0, "elastic": 61.0}
    monkeypatch.setattr(speed, "tick_time", lambda plant, tier: ticks[tier])
    monkeypatch.setattr(speed, "plant_time", lambda world: 6.0)
    monkeypatch.setattr(speed, "wrench_time", lambda world: 1.0)
    monkeypatch.setattr(speed, "end_to_end", lambda *_: 41.0)
    monkeypatch.setattr(speed, "call_time", lambda controller, plant: {"flexiv_factory": 50.0}.get(controller, 3.0))
    monkeypatch.setattr(speed, "spiking_figures", lambda plant: [])
    figures = {figure.name: figure for figure in measure_speed("pinocchio", evaluate=lambda log: None)}
    assert figures["actuated over ideal"].value == 1.5
    assert not figures["tick without a controller, elastic"].met
    assert figures["harness: sensors, target, limiter, log, wrench"].value == 10.0 - 6.0 + 1.0
    assert figures["plant step"].value == 6.0
    assert figures["computed torque, end to end"].met
    assert not figures["flexiv_factory tick"].met
    assert {name: figures[f"{name} tick"].bar for name in speed.TICK_BARS} == speed.TICK_BARS
    assert not [name for name in figures if "PyBullet" in name]


def test_pybullets_own_cost_is_measured_on_its_own_plant(monkeypatch, has_pybullet):
    """What a plain script would pay is the yardstick of the harness on top of it."""
    monkeypatch.setattr(speed, "tick_time", lambda plant, tier: 20.0)
    monkeypatch.setattr(speed, "plant_time", lambda world: 15.0)
    monkeypatch.setattr(speed, "wrench_time", lambda world: 1.0)
    monkeypatch.setattr(speed, "bullet_time", lambda plant: 12.0)
    monkeypatch.setattr(speed, "end_to_end", lambda *_: 41.0)
    monkeypatch.setattr(speed, "call_time", lambda *_: 3.0)
    monkeypatch.setattr(speed, "spiking_figures", lambda plant: [])
    figures = {figure.name: figure.value for figure in measure_speed("pybullet", evaluate=lambda log: None)}
    assert figures["harness over PyBullet's own"] == pytest.approx((20.0 - 15.0 + 1.0) / 12.0)


def test_holding_ends_at_a_second_and_needs_no_knowledge(run_of):
    """The tick is measured on an arm that stands: nothing but the harness moves."""
    from torquebench.scenarios.speed import LOAD, _hold
    from torquebench.scenarios.world import World

    world = World(run_of(schedule=LOAD, lead_in=1.0), LOAD)
    outcome = _hold(world)
    world.plant.close()
    assert outcome.failure is None
    assert len(outcome.log) == 1000
    assert np.abs(outcome.log["dq"]).max() < 1e-9


def test_a_controller_that_is_not_installed_is_left_out(monkeypatch):
    """The harness without the classical side still measures itself."""
    for name in ("tick_time", "plant_time", "wrench_time", "bullet_time", "end_to_end", "call_time"):
        monkeypatch.setattr(speed, name, lambda *_: 1.0)
    monkeypatch.setattr(speed.discovery, "names", lambda kind: ("computed_torque",))
    figures = measure_speed("pinocchio", evaluate=lambda log: None)
    assert [figure.name for figure in figures if figure.name.endswith(" tick")] == ["computed_torque tick"]
