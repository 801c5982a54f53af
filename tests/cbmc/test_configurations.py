"""Ablations, null controls and the literal paper: each differs in what its name says, and only there."""

import numpy as np
import pytest
from torquebench.cbmc.configurations import ExactPatterns, single
from torquebench.cbmc.controller import CbmcV3
from torquebench.cbmc.nulls import ForceMassLoop, PdOracle
from torquebench.cbmc.patterns import find_patterns
from torquebench.cbmc.point_payload import point_payload
from torquebench.controllers import NoKnowledge, discovery
from torquebench.scenarios.episode import run_episode
from torquebench.scenarios.execution import execute
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.world import World
from torquebench.scoring import score

CONFIGURATIONS = tuple(
    name for name, point in discovery.registered("controllers").items() if point.value.startswith("torquebench.cbmc")
)


def specification(controller, **changes):
    """Return a short run on the Pinocchio plant."""
    load = changes.pop("load", Payload(mass=2.5, material="sand"))
    settings = {"trajectory": "S1", "laps": 1, "tier": "actuated", "plant": "pinocchio", "robot": "rizon4s", **changes}
    return RunSpecification(controller=controller, schedule=LoadSchedule.constant(load), **settings)


def run(controller, **changes):
    """Run a configuration."""
    plug_ins = {} if isinstance(controller, str) else {"it": controller}
    name = controller if isinstance(controller, str) else "it"
    (result,) = execute(specification(name, **changes), evaluate=score, plug_ins=plug_ins)
    return result


def built(factory, **settings):
    """Return a controller after its reset."""
    spec = specification("it", knowledge="none")
    controller = factory(**settings)
    controller.reset(World(spec, spec.schedule).task())
    return controller


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_every_configuration_says_in_one_line_what_it_is(name):
    """`torquebench list controllers` shows this line."""
    doc = discovery.load("controllers", name).__doc__
    assert doc and len(doc.strip().splitlines()[0]) <= 120
    assert "(" not in doc.strip().splitlines()[0] or "self" not in doc


@pytest.mark.parametrize("name", [name for name in CONFIGURATIONS if name not in ("cbmc_v3_literal", "pd_oracle")])
def test_every_configuration_finishes_a_lap_on_the_usual_tier(name):
    """An ablation that cannot run tells nothing about the module."""
    result = run(name)
    assert result.status == "ok", result.reason


def test_the_true_gravity_null_runs_only_where_the_load_is_known():
    """Its name says oracle; without the truth it would be another controller."""
    assert PdOracle.knowledge_levels == ("oracle",)
    assert run("pd_oracle", knowledge="oracle").status == "ok"


@pytest.mark.parametrize("learning", ["autograd", "constant_gradient"])
def test_the_paper_as_printed_fails_and_says_when(learning):
    """Reported as failed, with its time; never dropped."""
    result = run("cbmc_v3_literal", tier="ideal", lead_in=0.0, settings={"literal_learning": learning})
    assert result.status == "failed"
    assert result.failed_at is not None and result.failed_at < 3.0


def test_one_pattern_alone_takes_all_the_weight():
    """Softmax of one is one."""
    controller = built(discovery.load("controllers", "heavy_only"))
    assert controller.loads == (3.0,)
    controller.stack.settle()
    assert controller.down.weights.tolist() == [1.0]


def test_a_single_pattern_is_the_same_pattern(rizon):
    """Picking must not mix rows of different patterns."""
    both = find_patterns(rizon.model())
    for index in (0, -1):
        alone = single(both, index)
        assert alone.count == 1
        assert np.array_equal(alone.purkinje[0], both.purkinje[index])
        assert alone.loads == (both.loads[index],)


@pytest.mark.parametrize("name", ["no_brainstem_learning", "no_learning"])
def test_gains_that_must_not_change_do_not(name):
    """The gains that the brainstem gives at rest, exactly."""
    result = run(name)
    assert result.status == "ok"
    controller = built(discovery.load("controllers", name))
    for _ in range(200):
        controller.stack.tick()
    assert controller.down.stiffness.tolist() == [200.0] * 7
    assert controller.down.damping.tolist() == [20.0] * 7


def test_a_cut_pathway_brings_no_force():
    """Whatever hangs on the flange, the weights of a fresh network are those of a zero wrench."""
    for name, feels in (("cbmc_v3", True), ("no_force", False)):
        weights = []
        for force in (0.0, 35.0):
            controller = built(discovery.load("controllers", name))
            controller.up.wrench[2] = force
            controller.stack.thalamus.weigh()
            weights.append(controller.down.weights.copy())
        assert np.array_equal(*weights) is not feels


def test_without_its_filter_the_mixture_goes_down_at_once():
    """Five calls of the filter layer are what it takes otherwise to come near."""
    for name, at_once in (("cbmc_v3", False), ("no_filter", True)):
        controller = built(discovery.load("controllers", name))
        down = controller.down
        down.compensation[:], down.weights[:] = 7.0, 0.5
        controller.stack.thalamus.combine()
        assert np.allclose(down.gravity_torque, 7.0) is at_once


def test_at_one_rate_every_level_answers_every_ten_ticks_and_the_guard_knows():
    """A loop of a tenth of the rate is stable up to a lower damping only."""
    one, three = (built(discovery.load("controllers", name)) for name in ("one_rate", "cbmc_v3"))
    torques = []
    one.up.q_desired[:] = 0.1
    for _ in range(30):
        one.stack.tick()
        torques.append(one.down.torque.copy())
    changes = [k + 1 for k in range(1, 30) if not np.array_equal(torques[k], torques[k - 1])]
    assert changes == [10, 20, 30]
    assert (one.caps.limit < 0.5 * three.caps.limit).all()


def test_the_torque_penalty_is_the_only_thing_that_its_absence_changes():
    """Without error the loss's other terms say nothing: only the penalty moves a gain."""
    for name, pays in (("cbmc_v3", True), ("no_torque_penalty", False)):
        controller = built(discovery.load("controllers", name))
        controller.down.torque[:] = 10.0
        controller.stack.spinal_cord.encoded_position[:] = 0.01
        controller.stack._rule.evaluate()
        assert bool(controller.stack.gradients.gains.any()) is pays
        assert not controller.stack.gradients.weights.any()


def test_the_held_cerebellum_answers_once():
    """Whatever the arm does later, its torque is that of the start."""
    controller = built(discovery.load("controllers", "fixed_cerebellum_torque"))
    controller.up.q[:] = [0.0, -0.7, 0.0, 1.57, 0.0, 0.7, 0.0]
    controller.stack.settle()
    held = controller.down.compensation.copy()
    controller.up.q[:] += 0.5
    for _ in range(100):
        controller.stack.tick()
    assert np.array_equal(controller.down.compensation, held)


def test_the_force_sensor_null_reads_the_mass_at_rest():
    """(|F| / g - gripper) / 3: 1.5 kg of load is a weight of one half."""
    controller = built(ForceMassLoop)
    controller.up.wrench[2] = (1.186 + 1.5) * 9.81
    controller.stack.thalamus.weigh()
    assert controller.down.weights == pytest.approx([0.5, 0.5], abs=1e-6)


def test_a_point_load_weighs_on_the_joints_as_its_mass_at_its_place(rizon):
    """The exact patterns are the model's own gravity."""
    model = rizon.model()
    q = np.array([0.1, -0.6, 0.2, 1.4, -0.1, 0.8, 0.3])
    bare = model.gravity(q)
    model.set_payload(point_payload(3.0, 0.2646))
    step, slope = 1e-6, np.zeros(7)
    for i in range(7):
        above, below = q.copy(), q.copy()
        above[i] += step
        below[i] -= step
        height = [(model.flange_pose(x) @ np.array([0.0, 0.0, 0.2646, 1.0]))[2] for x in (above, below)]
        slope[i] = 3.0 * 9.81 * (height[0] - height[1]) / (2.0 * step)
    assert model.gravity(q) - bare == pytest.approx(slope, abs=1e-5)


@pytest.mark.parametrize("load", [0.814, 1.814])
def test_with_exact_patterns_the_heavy_weight_finds_a_third_of_the_load(load):
    """w_H = m/3 for m kg beyond the gripper: what the thalamus is for."""
    mass = round(1.186 + load, 3)
    spec = specification("it", tier="ideal", trajectory="S2", laps=6, load=Payload(mass=mass, material="sand"))
    world = World(spec, spec.schedule)
    controller = ExactPatterns()
    controller.reset(world.task())
    outcome = run_episode(world.episode(controller, NoKnowledge()))
    assert outcome.failure is None
    weights, period = outcome.diagnostics["weights"]
    last_lap = weights[-int(3000 / period) :, 1].mean()
    assert last_lap == pytest.approx(load / 3.0, abs=0.08)


def test_what_was_learnt_is_carried_only_by_the_configuration_that_says_so():
    """A controller forgets, unless it declares otherwise; dynamic state and momenta are forgotten always."""
    for name, carries in (("cbmc_v3", False), ("cbmc_v3_carried", True)):
        factory = discovery.load("controllers", name)
        assert factory.carry_over is carries
        controller = built(factory)
        controller.stack.brainstem.network.parameters[:] = 0.25
        spec = specification("it", repetition=1)
        controller.reset(World(spec, spec.schedule).task())
        kept = np.all(controller.stack.brainstem.network.parameters == 0.25)
        assert kept == carries
        assert not controller.stack.brainstem.network.momenta.any()


def test_the_feed_forward_ablation_adds_the_plan_s_inertial_torque():
    """M(q_d) ddq_d of arm and gripper and nothing else."""
    assert CbmcV3.uses_model is False
    assert discovery.load("controllers", "cbmc_v3_feedforward").uses_model is True


@pytest.mark.parametrize(
    ("name", "knowledge"), [("cbmc_v3", "none"), ("w_integrator", "none"), ("pd_oracle", "oracle")]
)
def test_an_arm_that_nothing_was_trained_for_is_refused_with_the_command(tmp_path, rizon, name, knowledge):
    """A refusal with its reason is no failed run: a comparison on another arm goes on with the others."""
    heavier = rizon.description.model_text().replace('mass value="2.31"', 'mass value="2.5"')
    arm = tmp_path / "arm.urdf"
    arm.write_text(heavier)
    (tmp_path / "arm.toml").write_text(
        'name = "heavier"\nurdf = "arm.urdf"\nflange_frame = "flange"\nhome = [0.0, -0.7, 0.0, 1.57, 0.0, 0.7, 0.0]\n'
        "[tools]\ntip = 0.15\n[tiers.bench]\n"
    )
    result = run(name, robot=str(tmp_path / "arm.toml"), knowledge=knowledge, load=Payload(mass=0.314), tier="bench")
    assert result.status == "refused"
    assert "torquebench train" in result.reason
