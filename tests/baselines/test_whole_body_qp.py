"""Whole-body QP: without limits the impedance law, with them the best that the drives allow."""

from types import SimpleNamespace

import numpy as np
import pytest
from torquebench.baselines import presets
from torquebench.baselines import whole_body_presets as qp
from torquebench.baselines.active_set import ATTEMPTS
from torquebench.baselines.gains import double_integrator_gains
from torquebench.baselines.whole_body_qp import WholeBodyQp
from torquebench.baselines.whole_body_qp_strict import WholeBodyQpStrict
from torquebench.controllers import InvalidInput, Observation, Target, check_inertia
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.world import World

NAMES = ("whole_body_qp", "whole_body_qp_stiff", "whole_body_qp_force", "whole_body_qp_strict")


def roomy(arm):
    """Return an arm that no limit touches."""
    arm.model.lower, arm.model.upper = np.full(arm.model.n, -1e3), np.full(arm.model.n, 1e3)
    arm.told_effort, arm.model.velocity = np.full(arm.model.n, 1e7), np.full(arm.model.n, 1e6)
    return arm


def started(law, arm, *, step=np.inf):
    """Return a law after reset, with a torque step limit."""
    law.reset(arm.task())
    law._step[:] = step
    return law


def states(arm, count, *, spread=0.1, seed=0):
    """Yield measured states off the plan, and the plan."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        q, dq, _ = arm.plan.joints(0.01 * k)
        shift, push = spread * rng.standard_normal(len(q)), 5.0 * spread * rng.standard_normal(len(q))
        observation = arm.observe(0.01 * k, q + shift, dq + push)
        observation.command = np.clip(observation.command, -arm.told_effort, arm.told_effort)
        yield observation, arm.plan.target(0.01 * k)


def textbook(law, arm, observation, target):
    """Return objective, limits and matrices in the joint acceleration, as the docstring writes them; force form."""
    state = arm.model.at(observation.q, observation.dq)
    mass, jacobian, bias = state.mass_matrix.copy(), state.jacobian.copy(), state.bias.copy()
    drift = state.jacobian_bias.copy()
    reference = presets.flexiv_full_ff()
    reference.reset(arm.task())
    impedance = reference.compute(observation, target).copy()
    inertia = np.linalg.inv(jacobian @ np.linalg.solve(mass, jacobian.T))
    posture = target.ddq + law.posture_stiffness * (target.q - observation.q)
    posture = posture + law.posture_damping * (target.dq - observation.dq)
    # The tool acceleration of the impedance law is A F + drift: the posture does not reach the tool.
    driven = jacobian @ np.linalg.solve(mass, impedance - bias)
    w, effort = law.pose_weight, law.effort_weight
    goal = ((1.0 + w) * driven - jacobian @ posture) / w
    hessian = mass + w * jacobian.T @ inertia @ jacobian + effort * mass @ mass
    slope = -(mass @ posture + w * jacobian.T @ inertia @ goal) + effort * mass @ bias
    facts = {"mass": mass, "bias": bias, "impedance": impedance, "drift": drift, "jacobian": jacobian}
    return SimpleNamespace(hessian=hessian, slope=slope, **facts)


@pytest.mark.parametrize("factory", [qp.whole_body_qp_force, WholeBodyQpStrict])
@pytest.mark.parametrize("arm", ["six", "seven", "planar4"])
def test_without_active_limits_it_is_the_impedance_law(bench, arm, factory):
    """Same stiffness, same damping, same torque: the two differ by constraints only."""
    arm = roomy(bench(arm, sway=0.2))
    law = started(factory(gain_form="force", effort_weight=0.0), arm)
    impedance = presets.flexiv_full_ff()
    impedance.reset(arm.task())
    law._reach[:] = 1e9
    for observation, target in states(arm, 200):
        assert law.compute(observation, target) == pytest.approx(impedance.compute(observation, target), abs=1e-8)
    assert law.operations()["qp_fallbacks"] == 0


def test_on_the_rizon_with_its_own_limits_it_is_the_impedance_law(rizon):
    """The arm of the comparison, tier and plan as in a campaign: near the plan no limit is active, and none shows."""
    schedule = LoadSchedule.constant(Payload(mass=1.5))
    facts = {"controller": "", "trajectory": "T6", "robot": "rizon4s", "plant": "pinocchio", "tier": "actuated"}
    world = World(RunSpecification(schedule=schedule, **facts), schedule)
    law, impedance = qp.whole_body_qp_force(effort_weight=0.0), presets.flexiv_full_ff()
    for either in (law, impedance):
        either.reset(world.task())
    rng, still = np.random.default_rng(0), np.zeros(6)
    for row in world.plan.rows(np.linspace(0.0, world.plan.period, 200)):
        q, dq = row["q"] + 1e-4 * rng.standard_normal(7), row["dq"] + 1e-3 * rng.standard_normal(7)
        names = ("q", "dq", "ddq", "pose", "twist", "acceleration")
        target = Target(**{name: row[name] for name in names}, reference=world.plan)
        torque = impedance.compute(Observation(0.0, q, dq, still, still, still), target)
        # The command of the tick before: what the plan asks for a millisecond earlier is within the torque rate.
        observation = Observation(0.0, q, dq, still, torque + 1.0, torque)
        assert law.compute(observation, target) == pytest.approx(torque, abs=1e-8)
    assert (law.operations()["qp_solves"], law.operations()["qp_fallbacks"]) == (200, 0)


@pytest.mark.parametrize("weight", [1.0, 1e2, 1e4])
def test_the_impedance_is_the_textbook_optimum_for_every_weight(bench, weight):
    """The pose's goal is freed of the posture's pull, so that the weights do not blur the law."""
    arm = roomy(bench(sway=0.2))
    law = started(qp.whole_body_qp_force(pose_weight=weight), arm)
    for observation, target in states(arm, 20):
        book = textbook(law, arm, observation, target)
        optimum = np.linalg.solve(book.hessian, -book.slope)
        assert book.mass @ optimum + book.bias == pytest.approx(book.impedance, rel=1e-7, abs=1e-6)


@pytest.mark.parametrize("effort", [0.0, 1e-3])
def test_a_solution_satisfies_the_optimality_conditions_of_the_textbook_program(bench, effort):
    """Stationary but for the forces of active rows, which push inwards; in the joint acceleration, unscaled."""
    arm = bench(sway=0.2)
    arm.told_effort = np.full(7, 60.0)
    law = started(qp.whole_body_qp_force(effort_weight=effort, tolerance=1e-9), arm)
    active_rows = 0
    for observation, target in states(arm, 50, spread=0.01):
        torque = law.compute(observation, target).copy()
        book = textbook(law, arm, observation, target)
        acceleration = np.linalg.solve(book.mass, torque - book.bias)
        least, most = law._acceleration_bounds
        slack = np.clip(acceleration, least, most) - acceleration
        pull = book.hessian @ acceleration + book.slope - law.slack_weight * np.diag(book.mass) * slack
        # What remains is held by the torque rows: M^T z, z of one sign at each end and zero in between.
        multiplier = np.linalg.solve(book.mass, -pull)
        scale = np.abs(book.slope).max() / np.abs(book.mass).max()
        low, high = torque <= -60.0 + 1e-6, torque >= 60.0 - 1e-6
        assert np.all(np.abs(multiplier[~low & ~high]) <= 1e-5 * scale)
        assert np.all(multiplier[high] >= -1e-5 * scale) and np.all(multiplier[low] <= 1e-5 * scale)
        active_rows += int(np.sum(low | high))
    assert active_rows > 20
    assert law.operations()["qp_fallbacks"] == 0


@pytest.mark.parametrize(
    ("arm", "sway", "share", "gain"), [("seven", 0.2, 0.9, 0.5), ("seven", 0.1, 0.85, 0.6), ("six", 0.2, 0.85, 0.5)]
)
def test_a_torque_limit_is_never_exceeded_and_better_used_than_by_clipping(bench, arm, sway, share, gain):
    """A tenth or more below what the plan needs: clipping loses direction, the program gives up posture instead."""
    clipped, clipped_error, effort = run_short_of_torque(presets.flexiv_full_ff(), bench(arm, sway=sway), share=share)
    limited, limited_error, _ = run_short_of_torque(qp.whole_body_qp_force(), bench(arm, sway=sway), share=share)
    assert np.any(np.abs(clipped.torque) > effort)
    assert np.all(np.abs(limited.torque) <= effort)
    assert limited_error < gain * clipped_error


def test_where_a_twentieth_is_missing_clipping_can_be_better(bench):
    """The docs say so: a wide sway needs accelerations that the program's own bounds forbid, besides the torque."""
    _, clipped_error, _ = run_short_of_torque(presets.flexiv_full_ff(), bench(sway=0.3), share=0.95)
    limited, limited_error, effort = run_short_of_torque(qp.whole_body_qp_force(), bench(sway=0.3), share=0.95)
    assert np.all(np.abs(limited.torque) <= effort)
    assert clipped_error < 0.5 * limited_error


def run_short_of_torque(law, arm, *, share):
    """Return the log, the mean tool error and the limits of a fast sway with too little torque for it."""
    arm.plan.period = 1.0
    times = np.arange(0.0, 1.0, 0.01)
    need = np.max([np.abs(arm.model.inverse_dynamics(*arm.plan.joints(t))) for t in times], axis=0)
    hold = np.max([np.abs(arm.model.gravity(arm.plan.joints(t)[0])) for t in times], axis=0)
    arm.effort = arm.told_effort = np.maximum(share * need, 1.02 * hold)
    log, errors = arm.run(law, 1.5), []
    for k, error in enumerate(log.error):
        goal = arm.plan.joints(1e-3 * k)[0]
        goal_pose, pose = arm.model.forward_kinematics(goal), arm.model.forward_kinematics(goal - error)
        errors.append(np.linalg.norm(goal_pose[:3, 3] - pose[:3, 3]))
    return log, float(np.mean(errors)), arm.effort


@pytest.mark.parametrize("name", NAMES)
def test_a_torque_rate_limit_is_never_exceeded(bench, name):
    """Counted from the last command after the limiter."""
    arm = bench(sway=0.2)
    arm.told_effort = np.full(7, 150.0)
    law = started(getattr(qp, name)(), arm, step=0.5)
    for observation, target in states(arm, 100, spread=0.03):
        torque = law.compute(observation, target)
        assert np.all(np.abs(torque - observation.command) <= 0.5 + 1e-12)
        assert np.all(np.abs(torque) <= 150.0)


def test_a_joint_stops_at_its_limit_where_the_plan_goes_beyond(bench):
    """The impedance alone would follow the plan through it."""
    arm = bench(effort=150.0)
    arm.model.upper = arm.plan.centre + np.where(np.arange(7) == 3, 0.1, 5.0)
    law = qp.whole_body_qp_force()
    law_start, goal = arm.plan.centre.copy(), arm.plan.centre + np.where(np.arange(7) == 3, 0.4, 0.0)
    law.reset(arm.task())
    arm.plan.centre = goal
    q, dq, target, furthest = law_start, np.zeros(7), arm.plan.target(0.0), -np.inf
    command = arm.model.gravity(q)
    for k in range(1500):
        command = law.compute(arm.observe(1e-3 * k, q, dq, command), target).copy()
        state = arm.plant.at(q, dq)
        dq = dq + 1e-3 * np.linalg.solve(state.mass_matrix, command - state.bias)
        q = q + 1e-3 * dq
        furthest = max(furthest, q[3] - arm.model.upper[3])
    assert -0.03 < furthest <= 0.0
    assert law.operations()["qp_fallbacks"] == 0


def test_in_acceleration_form_the_error_obeys_the_same_dynamics_everywhere(bench):
    """dde + k_d de + k_p e = 0 at the tool, whatever its inertia there."""
    arm = roomy(bench(sway=0.2))
    law = started(qp.whole_body_qp(effort_weight=0.0, bandwidth=15.0), arm)
    law._reach[:] = 1e9
    stiffness, damping = double_integrator_gains(15.0, 1e-3)
    for observation, target in states(arm, 20, spread=0.02):
        torque = law.compute(observation, target).copy()
        state = arm.model.at(observation.q, observation.dq)
        driven = state.jacobian @ np.linalg.solve(state.mass_matrix, torque - state.bias) + state.jacobian_bias
        error, rate = target.pose[:3, 3] - state.position, (target.twist - state.jacobian @ observation.dq)[:3]
        assert driven[:3] == pytest.approx(target.acceleration[:3] + damping * rate + stiffness * error, abs=1e-6)


@pytest.mark.parametrize(
    "name", ["whole_body_qp", "whole_body_qp_stiff", "whole_body_qp_force", "whole_body_qp_strict"]
)
@pytest.mark.parametrize("arm", ["planar", "planar4", "six", "seven"])
def test_every_preset_holds_any_arm(bench, name, arm):
    """From 0.02 rad off, with a perfect model, the arm comes back without one fallback."""
    law = getattr(qp, name)()
    log = bench(arm, effort=150.0).run(law, 1.0, offset=0.02)
    assert np.linalg.norm(log.error[-1]) < 0.5 * np.linalg.norm(log.error[0])
    assert law.operations()["qp_fallbacks"] == 0


def test_more_effort_weight_spends_less_torque(bench):
    """What the task is called after."""
    arm = roomy(bench(sway=0.2))
    ((observation, target),) = states(arm, 1)
    spent = [
        np.linalg.norm(started(qp.whole_body_qp(effort_weight=w, pose_weight=10.0), arm).compute(observation, target))
        for w in (0.0, 0.1, 10.0)
    ]
    assert spent[0] > spent[1] > spent[2]


def test_with_strict_priorities_the_pose_is_as_good_and_the_rest_is_not_bought_with_it(bench):
    """Under limits the tool's departure, in the metric of its inertia, is the smallest that any law could have."""
    arm = bench(sway=0.2)
    arm.told_effort = np.full(7, 60.0)
    soft = {"gain_form": "force", "effort_weight": 0.0, "tolerance": 1e-8}
    weighted, strict = (started(law(**soft), arm) for law in (WholeBodyQp, WholeBodyQpStrict))
    # A small pose weight makes the trade of the weighted version visible; without bounds there is no other price.
    weighted._weights[1] = 10.0
    weighted._reach[:] = strict._reach[:] = 1e9
    weighted._velocity[:] = strict._velocity[:] = 1e6

    def departure(law, observation, target, *, clip=False):
        torque = law.compute(observation, target).copy()
        if clip:
            torque = np.clip(law._free, -60.0, 60.0)
        state = arm.model.at(observation.q, observation.dq)
        lost = state.jacobian @ np.linalg.solve(state.mass_matrix, torque - law._free)
        return float(lost @ law._inertia @ lost)

    gained = []
    for observation, target in states(arm, 50, spread=0.005):
        traded, kept = departure(weighted, observation, target), departure(strict, observation, target)
        assert kept <= traded * (1.0 + 1e-3) + 1e-3
        assert kept <= departure(strict, observation, target, clip=True) + 1e-3
        gained.append(traded - kept)
    assert max(gained) > 1e-2


@pytest.mark.parametrize("factory", [qp.whole_body_qp, qp.whole_body_qp_strict])
def test_a_warm_start_changes_no_torque(bench, factory):
    """Only the time."""
    arm = bench(sway=0.2)
    arm.told_effort = np.full(7, 60.0)
    warm, cold = (started(factory(warm_start=flag), arm) for flag in (True, False))
    for observation, target in states(arm, 50, spread=0.005):
        assert warm.compute(observation, target) == pytest.approx(cold.compute(observation, target), abs=2e-2)


def test_contradictory_limits_fall_back_to_the_clipped_law_and_are_counted(bench):
    """Effort and rate cannot both be held from a command far outside: the rate wins, as in the limiter."""
    arm = bench(sway=0.2)
    arm.told_effort = np.full(7, 10.0)
    law = started(qp.whole_body_qp_force(), arm, step=1.0)
    ((observation, target),) = states(arm, 1)
    observation.command = np.full(7, 50.0)
    assert law.compute(observation, target) == pytest.approx(np.full(7, 49.0))
    assert law.operations()["qp_fallbacks"] == 1


def test_a_tick_beyond_the_iteration_cap_falls_back_to_the_clipped_law_and_is_counted(bench):
    """Neither a wrong torque nor a late one, where no guess of the active rows was right; the next tick is solved."""
    arm = bench(sway=0.2)
    arm.told_effort = np.full(7, 60.0)
    law = started(qp.whole_body_qp_force(outer_iterations=1, inner_iterations=1), arm)
    impedance = presets.flexiv_full_ff()
    impedance.reset(arm.task())
    for observation, target in states(arm, 200):
        torque = law.compute(observation, target)
        if law.fallbacks:
            break
    expected = np.clip(impedance.compute(observation, target), -60.0, 60.0)
    assert torque == pytest.approx(expected, abs=1e-9)
    assert law.operations()["qp_fallbacks"] == 1
    (iterations, period) = law.diagnostics()["iterations"]
    assert period == 1 and 1 <= iterations[0] <= ATTEMPTS + 2
    solved = law.operations()["qp_solves"]
    q, dq, _ = arm.plan.joints(0.0)
    law.compute(arm.observe(0.0, q, dq, np.clip(arm.plant.gravity(q), -60.0, 60.0)), arm.plan.target(0.0))
    assert (law.operations()["qp_solves"], law.operations()["qp_fallbacks"]) == (solved + 1, 1)


@pytest.mark.parametrize("name", NAMES)
def test_an_episode_repeats_to_the_bit_on_the_same_object(bench, name):
    """Reset builds a new solver: neither its warm start nor the counters survive."""
    law = getattr(qp, name)()
    runs, counts = [], []
    for _ in range(2):
        runs.append(bench(sway=0.1, effort=60.0).run(law, 0.05, offset=0.03).torque)
        counts.append(dict(law.operations()))
    assert np.array_equal(*runs)
    assert counts[0]["qp_solves"] == counts[1]["qp_solves"]
    assert counts[0]["qp_fallbacks"] == counts[1]["qp_fallbacks"]


@pytest.mark.parametrize("name", NAMES)
def test_a_tick_changes_neither_observation_nor_target(bench, name):
    """Even where the arrays could be written."""
    arm, law = bench(sway=0.1, effort=60.0), getattr(qp, name)()
    law.reset(arm.task())
    observation, target = arm.observe(0.0, arm.plan.centre + 0.01, 0.1 * np.ones(7)), arm.plan.target(0.0)
    copies = []
    for record in (observation, target):
        for field in type(record).__dataclass_fields__:
            if isinstance(value := getattr(record, field), np.ndarray):
                setattr(record, field, value.copy())
                copies.append((getattr(record, field), value))
    assert law.compute(observation, target).shape == (7,)
    assert all(np.array_equal(now, before) for now, before in copies)


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("gain_form", "forces"),
        ("bandwidth", 0.0),
        ("damping_design", "square"),
        ("pose_weight", -1.0),
        ("effort_weight", -1e-4),
        ("tolerance", 0.0),
        ("outer_iterations", 0),
        ("inner_iterations", 2.5),
        ("warm_start", "no"),
        ("velocity_share", float("nan")),
        ("acceleration_share", 1.5),
    ],
)
def test_a_bad_setting_is_refused_by_name(setting, value):
    """One line for the user."""
    with pytest.raises(InvalidInput, match=setting):
        WholeBodyQp(**{setting: value})


@pytest.mark.parametrize("name", ["whole_body_qp", "whole_body_qp_force"])
def test_its_inertia_is_accepted_on_its_own_plant(rizon, bench, name):
    """And the force form declares what the impedance declares."""
    arm = bench()
    arm.model = rizon.model(rotor_inertia=rizon.rotor_inertia / 3.0)
    arm.plan.model, arm.plan.centre, arm.plan.q = arm.model.copy(), rizon.home, rizon.home[None, :]
    arm.told_effort = arm.model.effort
    law, impedance = getattr(qp, name)(), presets.flexiv_full_ff()
    law.reset(arm.task())
    impedance.reset(arm.task())
    check_inertia(law.design_inertia(), arm.model.mass_matrix(rizon.home), 1e-3)
    if name == "whole_body_qp_force":
        assert law.design_inertia().damping == pytest.approx(impedance.design_inertia().damping)
