"""The predictive controllers: plans used when they are ready, limits kept, and no offset from an unknown load."""

from dataclasses import replace

import numpy as np
import pytest
from torquebench.baselines.mpc import Mpc
from torquebench.baselines.mpc_offset_free import MpcOffsetFree
from torquebench.baselines.mpc_presets import mpc, mpc_offset_free, mpc_tool
from torquebench.baselines.presets import computed_torque_stiff
from torquebench.controllers import InvalidInput, knowledge_levels
from torquebench.scenarios.conformance import check
from torquebench.scenarios.execution import execute
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification
from torquebench.scoring import score

LEVELS = ("none", "ft_estimate", "momentum_observer", "oracle")
PRESETS = {"mpc": mpc, "mpc_tool": mpc_tool, "mpc_offset_free": mpc_offset_free}
KINDS = pytest.mark.parametrize("name", PRESETS)


def lap(name, *, tier="ideal", mass=3.5, **settings):
    """Return the row of a lap of T6 with a load that nobody knows, on the Pinocchio plant."""
    load = Payload(mass=mass, material="sand") if mass > 1.5 else Payload(mass=mass)
    specification = RunSpecification(
        controller=name,
        settings=settings,
        schedule=LoadSchedule.constant(load),
        trajectory="T6",
        laps=1,
        tier=tier,
        plant="pinocchio",
        robot="rizon4s",
    )
    (row,) = execute(specification, evaluate=score, traces="none")
    return row


def error(row):
    """Return the mean distance of the tool from its path [mm]."""
    return 1e3 * row.metrics["run"]["tcp_position_error_mean"]["value"]


@KINDS
def test_the_contract_holds(name):
    """As for any controller from outside."""
    findings = check(f"torquebench.baselines.mpc_presets:{name}")
    assert [finding for finding in findings if not finding.passed] == []
    assert len(findings) > 8


@KINDS
@pytest.mark.parametrize("arm", ["planar4", "six", "seven"])
def test_every_arm_is_held_and_moved(bench, name, arm):
    """The equations are those of the arm that came, whatever its axes."""
    run = bench(arm, sway=0.3).run(PRESETS[name](), 0.4)
    assert np.linalg.norm(run.error[-50:], axis=1).max() < 2e-3


def test_a_start_beside_the_path_is_left_at_the_regulators_pace(bench):
    """The last block's cost stands for all that follows: no plan may lag behind what it promised."""
    run = bench("seven").run(mpc(), 0.25, offset=0.05)
    norm = np.linalg.norm(run.error, axis=1)
    assert norm[0] == pytest.approx(0.05 * np.sqrt(7))
    assert norm[-1] < 0.02 * norm[0]


def test_with_a_plan_every_tick_it_is_the_discrete_regulator(bench):
    """Solved at once and at each tick, the first acceleration is the regulator's of a 20 ms double integrator."""
    import control

    law, arm = mpc(blocks=(1,) * 10, solve_every=1, solve_latency=0), bench("six")
    law.reset(arm.task())
    q = arm.plan.joints(0.0)[0] - 0.01
    law.compute(arm.observe(0.0, q, np.zeros(6)), arm.plan.target(0.0))
    chain, drive = np.array([[1.0, 0.02], [0.0, 1.0]]), np.array([[0.0002], [0.02]])
    gain, _, _ = control.dlqr(chain, drive, np.diag([40.0**4, 2 * 40.0**2]), np.eye(1))
    assert law.problem.ddq[0] == pytest.approx(np.full(6, gain[0, 0] * 0.01), rel=1e-9)


def test_a_plan_waits_for_its_time(bench):
    """With a latency of three ticks the reference is followed for three ticks, and the plan from where it begins."""
    law, arm = mpc(solve_every=10, solve_latency=3), bench("six", sway=0.3)
    law.reset(arm.task())
    started = []
    for k in range(25):
        q, dq, _ = arm.plan.joints(k * 1e-3)
        law.compute(arm.observe(k * 1e-3, q, dq), arm.plan.target(k * 1e-3))
        started.append(law._started)
    assert max(started[:3]) < 0.0
    assert started[3:13] == pytest.approx([0.003] * 10)
    assert started[13:23] == pytest.approx([0.013] * 10)


def test_limits_are_planned_around_and_not_run_into(bench):
    """At limits that the motion just needs, clipping what the same gains ask for is late: a plan starts early."""
    worlds = [bench("seven", sway=0.6) for _ in range(2)]
    times = np.arange(0.0, 2.0, 0.01)
    motions = [worlds[0].plan.joints(time) for time in times]
    peak = np.abs([worlds[0].model.inverse_dynamics(*motion).copy() for motion in motions]).max(axis=0)
    results = []
    for world, law in zip(worlds, (mpc(), computed_torque_stiff()), strict=True):
        world.effort = world.told_effort = 0.9 * peak
        results.append(world.run(law, 2.0))
    errors = [np.linalg.norm(run.error, axis=1).mean() for run in results]
    assert errors[0] < errors[1]


def test_a_solve_that_finds_nothing_is_counted_and_survived(bench):
    """Told limits below gravity no plan exists: the inner law follows the reference."""
    arm = bench("six", sway=0.3)
    arm.told_effort = np.full(6, 1e-3)
    law = mpc()
    run = arm.run(law, 0.1)
    assert law.operations()["mpc_fallbacks"] == law.operations()["mpc_solves"] == 20
    assert np.abs(run.error).max() < 1e-3


def test_an_unknown_load_leaves_no_offset():
    """The bar: 2 kg of sand that nobody was told of, T6, exact drives, below 0.3 mm."""
    free, plain = lap("mpc_offset_free"), lap("mpc")
    assert error(free) < 0.3
    assert error(plain) > 10.0 * error(free)


@pytest.mark.parametrize("mass", [1.5, 3.5])
@KINDS
def test_a_lap_on_real_drives_is_followed(name, mass):
    """Delay, lag, friction and encoder noise; the coarsest figures of the docs."""
    row = lap(name, tier="actuated", mass=mass)
    assert (row.status, row.counts["operations"]["mpc_fallbacks"]) == ("ok", 0)
    assert error(row) < 10.0


def test_the_disturbance_state_is_no_second_opinion_on_the_load():
    """It estimates the load itself; beside an estimator it would count it twice."""
    assert knowledge_levels(mpc_offset_free(), LEVELS) == ("none", "oracle")
    assert knowledge_levels(mpc(), LEVELS) == LEVELS


def test_a_known_disturbance_enters_the_plan(bench):
    """What the momentum observer tells the model must count in the torque rows, too."""
    arm = bench("six", sway=0.3)
    law = mpc()
    law.reset(arm.task())
    arm.model.set_disturbance(np.full(6, 1e6))
    law.compute(arm.observe(0.0, *arm.plan.joints(0.0)[:2]), arm.plan.target(0.0))
    assert law.operations()["mpc_fallbacks"] == 0  # no limit on this arm
    arm.model.set_disturbance(np.zeros(6))
    arm.told_effort = np.full(6, 1e3)
    law.reset(arm.task())
    arm.model.set_disturbance(np.full(6, 1e6))
    law.compute(arm.observe(0.0, *arm.plan.joints(0.0)[:2]), arm.plan.target(0.0))
    assert law.operations()["mpc_fallbacks"] == 1


def test_one_instance_runs_one_episode_after_another(bench):
    """Nothing of the last episode may be left in plan, solver, observer or counters."""
    law, fresh = mpc_offset_free(), mpc_offset_free()
    bench("six", sway=0.5).run(law, 0.05)
    again, first = bench("six", sway=0.3).run(law, 0.05), bench("six", sway=0.3).run(fresh, 0.05)
    assert np.array_equal(again.torque, first.torque)
    assert law.operations() == fresh.operations()


def test_blocks_from_a_file_are_blocks_from_code():
    """TOML has lists, code has tuples: one setting, one address."""
    assert Mpc(blocks=[1, 1, 2]) == Mpc(blocks=(1, 1, 2))


@pytest.mark.parametrize(
    "settings",
    [
        {"blocks": []},
        {"blocks": [1, 0]},
        {"blocks": "1,1"},
        {"blocks": 20},
        {"solve_every": 0},
        {"solve_every": 2.5},
        {"solve_latency": -1},
        {"solve_latency": 6},
        {"interval": 0.0},
        {"bandwidth": "fast"},
        {"effort_share": -1.0},
    ],
)
def test_a_wrong_setting_is_refused(settings):
    """In one line that names it."""
    with pytest.raises(InvalidInput, match=next(iter(settings))):
        Mpc(**settings)


def test_the_observer_gain_is_checked():
    """As all settings are."""
    with pytest.raises(InvalidInput, match="observer_gain"):
        MpcOffsetFree(observer_gain=0.0)


@KINDS
def test_the_ledger_names_every_setting(bench, name):
    """And whether the equations ran as machine code."""
    law = PRESETS[name]()
    law.reset(bench("six").task())
    entries = {entry.setting: entry.value for entry in law.ledger()}
    assert set(vars(replace(law))) & set(entries) >= {"bandwidth", "blocks", "interval", "solve_every"}
    assert entries["equations"]
