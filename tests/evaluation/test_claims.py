"""The claims that ship resolve, and a run table gives each its word."""

import math
from dataclasses import replace

import numpy as np
import pytest
from torquebench.controllers import discovery
from torquebench.evaluation import METRICS
from torquebench.evaluation.claims import READINGS, Evidence, judge, judge_all, read_book
from torquebench.evaluation.claims.verdict import STAND_IN
from torquebench.scenarios.benchmark import benchmark_names, load_benchmark, schedules

BOOK = read_book()
CLAIMS = {claim.id: claim for claim in BOOK.claim}
JUDGED = [claim for claim in BOOK.claim if claim.testable != "no"]
SETS = {found.id: found for found in BOOK.set}
CBMC, FACTORY = "cbmc_v3 / none", "flexiv_factory / none"
POSITION, ORIENTATION = "tcp_position_error_mean", "tcp_orientation_error_mean"
TRAJECTORIES = tuple(f"T{i}" for i in range(1, 9))


def flat(claim):
    return [claim, *claim.parts]


def test_no_claim_of_the_paper_is_dropped():
    """55 claims and 23 inconsistencies, numbered without a gap."""
    assert [claim.id for claim in BOOK.claim] == [f"C{i}" for i in range(1, 56)]
    assert [found.id for found in BOOK.inconsistency] == [f"I{i}" for i in range(1, 24)]


@pytest.mark.parametrize("claim", JUDGED, ids=lambda claim: claim.id)
def test_every_metric_resolves(claim):
    """An id that nobody registered would be undecided for ever."""
    ids = {READINGS.get(name, name) for part in flat(claim) for name in part.metrics}
    assert ids <= set(METRICS)


@pytest.mark.parametrize("claim", JUDGED, ids=lambda claim: claim.id)
def test_every_contrast_resolves(claim):
    """A label is a registered controller and a registered level; sides of one controller are contents or windows."""
    for part in flat(claim):
        for label in (*part.a, *part.b, *part.nulls):
            controller, _, level = label.partition(" / ")
            assert controller in discovery.names("controllers"), label
            assert level in discovery.names("knowledge"), label
        times = SETS[part.runs].history.split("from ")[1:]
        windows = {"run", "event@0", *(f"event@{time.split()[0]}" for time in times)}
        assert {part.window} <= windows
        assert {part.a_is, part.b_is} <= {"", *SETS[part.runs].materials, *windows}
    assert set(claim.claims) <= set(CLAIMS)
    assert set(claim.see) <= {found.id for found in BOOK.inconsistency}


@pytest.mark.parametrize("claim", JUDGED, ids=lambda claim: claim.id)
def test_every_set_resolves(claim):
    """What a rule needs stands there, and every side is run by a benchmark of the set."""
    for part in flat(claim):
        runs = SETS[part.runs]
        ran = {label for name in runs.benchmarks for label in labels_of(name, runs)}
        if runs.benchmarks:
            assert set(part.a) | set(part.b) | set(part.nulls) <= ran
    assert claim.rule in ("agreement", "profile") or (claim.metrics and claim.a)


def labels_of(name, runs):
    """Return the labels that a benchmark runs of a set."""
    return {
        f"{controller} / {level}"
        for sweep in fitting(name, runs)
        for controller in sweep.controllers
        for level in sweep.knowledge or discovery.names("knowledge")
    }


def fitting(name, runs):
    """Return the run tables of a benchmark whose runs are of a set."""

    def fits(sweep):
        alike = (sweep.tier, sweep.laps, sweep.lead_in) == (runs.tier, runs.laps, runs.lead_in)
        histories = [schedule.entries for schedule in schedules(sweep)]
        if runs.history:
            loads = [in_words(history) for history in histories] == [runs.history]
        else:
            loads = all(len(history) == 1 and history[0][1].mass in runs.masses for history in histories)
        return alike and loads and set(sweep.trajectories) == set(runs.trajectories)

    return [sweep for sweep in load_benchmark(name).sweeps() if fits(sweep)]


def in_words(history):
    """Return a load history as sets write it."""
    parts = [f"{load.mass:g} kg{'' if load.material == 'none' else ' ' + load.material}" for _, load in history]
    times = ["", *(f"from {time:g} s " for time, _ in history[1:])]
    return ", ".join(time + part for time, part in zip(times, parts, strict=True))


@pytest.mark.parametrize("runs", [found for found in BOOK.set if found.benchmarks], ids=lambda runs: runs.id)
def test_a_set_is_what_its_benchmarks_run(runs):
    """Tier, laps, lead-in, trajectories, load history and loads: none of them is of the set alone."""
    assert set(runs.benchmarks) <= set(benchmark_names())
    assert all(fitting(name, runs) for name in runs.benchmarks)
    if not runs.history:
        loads = {
            (schedule.entries[0][1].mass, schedule.entries[0][1].material)
            for sweep in fitting("paper", runs)
            for schedule in schedules(sweep)
        }
        assert {mass for mass, _ in loads} == set(runs.masses)
        assert {material for _, material in loads} - {"none"} == set(runs.materials)


def test_one_benchmark_runs_every_set_that_is_run_at_all():
    """`torquebench run paper` is enough for a verdict on every claim that can be tested."""
    judged = {part.runs for claim in JUDGED for part in flat(claim)}
    assert judged == {runs.id for runs in BOOK.set if "paper" in runs.benchmarks} | {"gravity_heldout"}


def table(grid, ours, theirs, materials=("sand", "water"), repetitions=2):
    """The paper's grid with errors of two controllers: ``error(trajectory, mass, material)``."""
    rows = []
    for controller, error in ((CBMC, ours), (FACTORY, theirs)):
        for trajectory in TRAJECTORIES:
            for mass in (1.5, 2.0, 2.5, 3.0, 3.5):
                for material in materials if mass > 1.5 else ("",):
                    for repetition in range(repetitions):
                        value = error(trajectory, mass, material) * (1.0 + 0.01 * repetition)
                        row = grid.row(controller, trajectory, mass, repetition, value)
                        entry = row.metrics["run"][POSITION]
                        rows.append(
                            replace(row, material=material, metrics={"run": {POSITION: entry, ORIENTATION: entry}})
                        )
    return {"grid_paper": Evidence(runs=SETS["grid_paper"], rows=rows)}


def place(trajectory):
    return int(trajectory[1])


def plain(trajectory, mass, material):
    return 0.01 + 0.001 * place(trajectory)


def better(trajectory, mass, material):
    """About a quarter less, with some scatter over trajectories, and growing with the load."""
    return (0.72 + 0.01 * (place(trajectory) % 3)) * plain(trajectory, mass, material) * (1.0 + 0.02 * (mass - 2.5))


def word(name, evidence):
    return judge(CLAIMS[name], BOOK, evidence).word


def test_a_better_controller_reproduces_the_claims_of_precision(grid):
    """A quarter less on every path and load: more than the printed 20.6 and 18.9 %."""
    evidence = table(grid, better, plain)
    assert {word(name, evidence) for name in ("C1", "C2", "C3", "C5", "C13", "C21", "C19")} == {"reproduced"}
    found = judge(CLAIMS["C3"], BOOK, evidence)
    assert found.measured.value == pytest.approx(0.73, abs=0.01)
    assert found.measured.interval.high < 1.0
    assert (found.measured.n, found.measured.of) == (8, "trajectories")
    assert found.measured.test == "sign flips, p = 0.00781"


def test_the_other_way_round_is_the_opposite(grid):
    """Which controller is the better one changes the word, not the method."""
    evidence = table(grid, plain, better)
    assert {word(name, evidence) for name in ("C1", "C3", "C13", "C21")} == {"opposite"}


def test_three_fast_paths_never_decide(grid):
    """However large the effect."""
    found = judge(CLAIMS["C15"], BOOK, table(grid, better, plain))
    assert (found.word, found.measured.n) == ("not enough to decide", 3)
    assert "3" in found.reason


def test_a_claim_about_every_load_needs_every_load(grid):
    """Without water nine cells are five, and the reader is told which are missing."""
    evidence = table(grid, better, plain, materials=("sand",))
    found = judge(CLAIMS["C1"], BOOK, evidence)
    assert (found.word, found.reason) == (
        "not enough to decide",
        "missing: 2 kg water, 2.5 kg water, 3 kg water, 3.5 kg water",
    )
    assert word("C3", evidence) == "reproduced"
    assert judge(CLAIMS["C5"], BOOK, evidence).reason == f"no run of {CBMC} with water in grid_paper"
    assert "water" in judge(CLAIMS["C13"], BOOK, evidence).reason


def test_a_range_is_judged_by_repetitions(grid):
    """A range over paths cannot be resampled: one repetition has no interval, two have one for these paths."""
    flatter = lambda trajectory, mass, material: 0.014 + 0.0003 * place(trajectory)  # noqa: E731
    found = judge(CLAIMS["C9"], BOOK, table(grid, flatter, plain))
    assert found.word == "reproduced"
    assert found.measured.value == pytest.approx(0.3, abs=0.01)
    assert "for these trajectories" in found.sentence
    alone = judge(CLAIMS["C9"], BOOK, table(grid, flatter, plain, repetitions=1))
    assert (alone.word, alone.reason) == ("not enough to decide", "one repetition: no interval for these trajectories")
    assert word("C8", table(grid, flatter, plain)) == "reproduced"


def test_the_range_keeps_repetitions_paired():
    """Noise that both controllers share cancels in a ratio of ranges."""
    from torquebench.evaluation.claims.measures import log_ratio_of_ranges, range_interval

    rng = np.random.default_rng(0)
    shared = {(f"T{i}", 1.5, "", r): float(i + 0.1 * rng.normal()) for i in (1, 2, 3) for r in range(5)}
    alike = {key: (0.5 * value, value) for key, value in shared.items()}
    groups = {"T1": "slow", "T2": "slow", "T3": "slow"}
    estimate, interval = range_interval([log_ratio_of_ranges(alike, groups)])
    assert estimate == pytest.approx(math.log(0.5))
    assert interval.high - interval.low < 1e-9


def test_water_against_sand_is_one_controller_twice(grid):
    """5 % more with water: the printed 0.84 % and more."""
    wetter = lambda t, m, k: plain(t, m, k) * (1.05 + 0.001 * place(t) if k == "water" else 1.0)  # noqa: E731
    found = judge(CLAIMS["C22"], BOOK, table(grid, wetter, plain))
    assert (found.word, found.measured.value) == ("reproduced", pytest.approx(1.0545, abs=1e-3))
    assert word("C22", table(grid, plain, plain)) == "not reproduced"


def test_what_holds_for_sand_holds_for_water_if_every_word_is_the_same(grid):
    """Claims that stay open leave it open, and say which."""
    found = judge(CLAIMS["C23"], BOOK, table(grid, better, plain))
    assert found.word == "not enough to decide"
    assert "C14" in found.reason and "C1," not in found.reason


@pytest.mark.parametrize("claim", BOOK.claim, ids=lambda claim: claim.id)
def test_every_claim_has_a_verdict_and_a_proxy_says_so(grid, claim):
    """With a full grid, and with no run at all."""
    for evidence in (table(grid, better, plain), {}):
        found = judge(claim, BOOK, evidence)
        assert found.word
        assert found.reason or found.word == "reproduced"
        assert (STAND_IN in found.sentence) == (STAND_IN in found.statement) == (claim.testable == "proxy")


def test_a_claim_that_cannot_be_tested_says_why():
    """Runs or none."""
    found = judge(CLAIMS["C54"], BOOK, {})
    assert (found.word, found.reason) == ("cannot be tested here", CLAIMS["C54"].why)


def test_a_set_that_nobody_ran_names_its_benchmark():
    """The reader is told what to run."""
    found = {verdict.claim.id: verdict for verdict in judge_all(BOOK, {})}
    assert len(found) == 55
    assert found["C29"].reason.endswith("; paper and module-gains run it")
    assert found["C52"].word == "in parts"
    assert [part.word for part in found["C52"].parts] == ["not enough to decide"] * 3


def sweep(grid, controller, error):
    """Joint errors over the module experiment's loads."""
    rows = []
    for trajectory in ("S1", "S2", "S3"):
        for mass in (1.186, 1.5, 2.0, 2.5, 3.0, 3.5):
            row = grid.row(controller, trajectory, mass, 0, error(mass) * (1.0 + 0.01 * place(trajectory)))
            entry = row.metrics["run"][POSITION]
            weight = {"value": (mass - 1.186) / 3.0, "status": "ok"}
            metrics = {"run": {"joint_error_mean": entry, "heavy_weight": weight}}
            rows.append(replace(row, material="sand" if mass > 1.5 else "", metrics=metrics))
    return rows


def test_the_module_claims_follow_the_curves_over_load(grid):
    """One pattern rises, the other falls, both together lie below: the paper's figure, and each claim of it."""
    rows = [
        *sweep(grid, "light_only / none", lambda mass: 0.02 + 0.006 * (mass - 1.2)),
        *sweep(grid, "heavy_only / none", lambda mass: 0.035 - 0.006 * (mass - 1.2)),
        *sweep(grid, CBMC, lambda mass: 0.019 + 0.001 * mass),
    ]
    evidence = {"module_mass_sweep": Evidence(runs=SETS["module_mass_sweep"], rows=rows)}
    assert {name: word(name, evidence) for name in ("C24", "C25", "C26", "C28")} == dict.fromkeys(
        ("C24", "C25", "C26", "C28"), "reproduced"
    )
    assert judge(CLAIMS["C28"], BOOK, evidence).measured.value == pytest.approx(1.0 / 3.0)
    assert "best at 1.186 kg, the end of the sweep" in judge(CLAIMS["C26"], BOOK, evidence).measured.notes[0]
    assert word("C27", evidence) == "same direction but smaller"


def events(grid, controller, values, status="ok"):
    """Runs of the resilience experiment with values of single metrics at 12 s."""
    rows = []
    for trajectory in ("S1", "S2", "S3"):
        row = grid.row(controller, trajectory, 1.5, 0, 0.01)
        window = {name: {"value": value, "status": status} for name, value in values.items()}
        rows.append(replace(row, metrics={"event@12": window}))
    return rows


def test_a_ratio_that_is_one_for_every_purpose_says_so(grid):
    """Not enough to decide which is smaller, and enough to know that it does not matter: C51's torque term."""
    for trajectory_factor, said in ((0.002, True), (0.2, False)):

        def near(trajectory, mass, material, factor=trajectory_factor):
            return plain(trajectory, mass, material) * (1.0 + factor * (-1.0) ** place(trajectory))

        verdict = judge(CLAIMS["C3"], BOOK, table(grid, near, plain))
        assert ("practically equal" in verdict.measured.notes) is said


def test_peaks_are_counted_against_their_nulls(grid):
    """Three peaks that a plain controller shows as well are no hierarchy."""
    peaks = {"recovery_peaks_15": 3.0, "recovery_peaks_stable": 3.0, "recovery_peaks_raw_null": 1.0}
    runs = SETS["resilience_paper_warm"]
    for of_plain, expected in ((3.0, "same direction but smaller"), (2.0, "reproduced")):
        rows = [*events(grid, CBMC, peaks), *events(grid, "pd_oracle / oracle", {"recovery_peaks_15": of_plain})]
        assert word("C43", {"resilience_paper_warm": Evidence(runs=runs, rows=rows)}) == expected


def test_times_of_recovery_come_from_the_mean_curve(grid):
    """A median of 2.5 s is within 1.5 times the printed 2 s, never recovered is not."""
    runs = SETS["resilience_paper"]
    for value, status, expected in ((2.5, "ok", "reproduced"), (math.inf, "censored", "not reproduced")):
        rows = events(grid, CBMC, {"recovery_time_paper_style": value}, status)
        assert word("C35", {"resilience_paper": Evidence(runs=runs, rows=rows)}) == expected


def test_gains_are_judged_by_laps(grid):
    """Twenty laps of gains that run against each other at joint 4 and have nothing to do with each other at joint 6."""
    rng = np.random.default_rng(1)
    stiffness, noise = (np.repeat(rng.normal(size=(20, 7)), 30, axis=0) for _ in range(2))
    damping = -0.6 * stiffness + 0.8 * noise
    damping[:, 5] = noise[:, 5]
    rows = sweep(grid, CBMC, lambda mass: 0.01)
    evidence = {
        "module_gains": Evidence(runs=SETS["module_gains"], rows=rows, gains={CBMC: [(stiffness, damping, 30)] * 3})
    }
    assert word("C29", evidence) == "reproduced"
    assert word("C30", evidence) == "not reproduced"
    assert (
        "no trace" in judge(CLAIMS["C29"], BOOK, {"module_gains": replace(evidence["module_gains"], gains={})}).reason
    )
