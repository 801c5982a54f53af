"""What a repetition draws: within its bounds, the same for every controller, moved by nothing else, on both plants."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from torquebench.controllers import InvalidInput, Oracle, discovery
from torquebench.scenarios import draws as rule
from torquebench.scenarios.benchmark import Benchmark
from torquebench.scenarios.draws import draw
from torquebench.scenarios.execution import execute
from torquebench.scenarios.expansion import expand
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.result import Scores
from torquebench.scenarios.specification import twin_schedules
from torquebench.scenarios.streams import scenario_stream
from torquebench.scenarios.world import World

HEAVY = LoadSchedule.constant(Payload(mass=3.5, material="sand"))
STEP = LoadSchedule(entries=((0.0, Payload(mass=1.5)), (0.3, Payload(mass=3.5, material="sand"))))
STREAMS = {
    "friction": ("friction", 7),
    "payload_mass": ("payload mass", 1),
    "payload_centre": ("payload centre", 3),
    "link_mass": ("link masses", 7),
    "initial_offset": ("initial offset", 7),
    "slosh_phase": ("slosh phase", 2),
}
GOLDEN = {
    "friction": 0.9348498782884849,
    "payload_mass": 0.9987906008749939,
    "payload_centre": 0.002403941172226408,
    "link_mass": 0.9910061499999039,
    "initial_offset": -0.0030966897346229715,
    "slosh_phase": 2.6872272496329144,
}
"""First number of each, T6 on the Rizon, campaign 1, repetition 0."""


@pytest.fixture
def drawn_run(run_of):
    """Builds the specification of a run whose plant is drawn: tier ``actuated``, 3.5 kg."""

    def build(**changes):
        return run_of(**{"tier": "actuated", "draws": True, "schedule": HEAVY} | changes)

    return build


@pytest.fixture
def worlds(drawn_run):
    """Builds worlds of drawn runs."""
    opened = []

    def build(**changes):
        specification = drawn_run(**changes)
        opened.append(World(specification, specification.schedule))
        return opened[-1]

    yield build
    for world in opened:
        world.plant.close()


def unscored(_):
    """Score nothing."""
    return Scores(metrics={})


def campaign(**changes):
    """Return the runs of a small benchmark with draws."""
    plain = {
        "schema": 1,
        "name": "drawn",
        "plant": "pinocchio",
        "draws": True,
        "controllers": ("computed_torque", "flexiv_factory"),
        "trajectories": ("T6",),
        "loads": ({"mass": 1.5}, {"mass": 3.5, "material": "sand"}),
        "repetitions": 2,
        "laps": 1,
        "lead_in": 0.1,
    }
    return expand(Benchmark.model_validate(plain | changes)).specifications


def test_two_controllers_of_a_campaign_saw_the_same_draws():
    """Run for real, read from the rows: one draw for each repetition, whoever controlled and whatever hung there."""
    seen = {}
    for specification in campaign(knowledge=("none", "oracle")):
        (result,) = execute(specification, evaluate=unscored, traces="none")
        assert result.status == "ok"
        key = (specification.trajectory, specification.repetition)
        seen.setdefault(key, []).append((specification.label, result.provenance["draws"]))
    assert len(seen) == 2
    for runs in seen.values():
        assert {label for label, _ in runs} >= {"computed_torque / none", "flexiv_factory / none"}
        assert len(runs) >= 6
        assert all(drawn == runs[0][1] for _, drawn in runs)
    first, second = (runs[0][1] for runs in seen.values())
    assert all(first[name] != second[name] for name in first)


@pytest.mark.parametrize("name", STREAMS)
def test_every_quantity_has_the_stream_of_its_name(drawn_run, name):
    """Recomputed from the stream alone: so a quantity more, or more numbers of one, moves no other."""
    stream, size = STREAMS[name]
    unit = scenario_stream(stream, drawn_run()).uniform(-1.0, 1.0, size)
    found = np.ravel(getattr(draw(drawn_run(), 7), name))
    bound = {
        "friction": 0.2, "payload_mass": 0.01, "payload_centre": 5e-3, "link_mass": 0.02, "initial_offset": 5e-3,
        "slosh_phase": np.pi,
    }[name]  # fmt: skip
    nominal = 1.0 if name in ("friction", "payload_mass", "link_mass") else 0.0
    assert np.allclose(found, nominal + bound * unit, rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", GOLDEN)
def test_the_draws_are_these(drawn_run, name):
    """Golden values: whoever changes how draws are made changes every published result."""
    assert np.ravel(getattr(draw(drawn_run(), 7), name))[0] == GOLDEN[name]


def test_streams_differ_from_each_other_and_from_the_sensors(drawn_run):
    """Seven independent streams, not one by seven names."""
    names = [stream for stream, _ in STREAMS.values()]
    assert len({scenario_stream(name, drawn_run()).uniform() for name in (*names, "sensor")}) == 7


@pytest.mark.parametrize(
    "change",
    [
        {"controller": "other", "settings": {"gain": 2.0}}, {"knowledge": "oracle"}, {"plant": "pybullet"},
        {"tier": "tight_rate"}, {"schedule": STEP, "twins": True}, {"laps": 7}, {"latency": 3}, {"lead_in": 0.0},
    ],
)  # fmt: skip
def test_no_draw_depends_on_who_controls_or_what_hangs_there(drawn_run, change):
    """Robot, trajectory, repetition and campaign alone: variants are paired."""
    assert draw(drawn_run(**change), 7).as_table() == draw(drawn_run(), 7).as_table()


@pytest.mark.parametrize("change", [{"trajectory": "T1"}, {"repetition": 1}, {"campaign": 2}, {"robot": "other"}])
def test_another_motion_or_repetition_draws_anew(drawn_run, change):
    """In every quantity."""
    one, other = draw(drawn_run(), 7).as_table(), draw(drawn_run(**change), 7).as_table()
    assert all(one[name] != other[name] for name in one)


def test_over_many_repetitions_the_draws_fill_their_bounds(drawn_run):
    """Uniform: mean at the nominal value, standard deviation of the bound over the square root of three."""
    found = [draw(drawn_run(repetition=k), 7) for k in range(300)]
    for name, bound, nominal in (
        ("friction", rule.FRICTION, 1.0),
        ("payload_mass", rule.PAYLOAD_MASS, 1.0),
        ("payload_centre", rule.PAYLOAD_CENTRE, 0.0),
        ("link_mass", rule.LINK_MASS, 1.0),
        ("initial_offset", rule.INITIAL_OFFSET, 0.0),
    ):
        share = (np.array([np.ravel(getattr(one, name)) for one in found]) - nominal) / bound
        assert np.abs(share).max() <= 1.0 + 1e-12
        assert np.abs(share).max() > 0.98
        assert share.mean() == pytest.approx(0.0, abs=4.0 / np.sqrt(3.0 * share.size))
        assert share.std() == pytest.approx(1.0 / np.sqrt(3.0), rel=0.1)


def test_without_draws_the_plant_is_the_nominal_one_to_the_bit(worlds):
    """Factors of one and shifts of zero: every published figure stands."""
    world = worlds(draws=False)
    nominal = discovery.load("plants", "pinocchio")(world.robot, world.tier, world.plant.slots)
    nominal.set_load((True,) * len(nominal.slots))
    assert np.array_equal(world.plant.q, world.table["q"][0])
    assert np.array_equal(world.plant.payload, nominal.payload)
    for one, other in zip(world.plant.model.inertias, nominal.model.inertias, strict=True):
        assert np.array_equal(one.toDynamicParameters(), other.toDynamicParameters())
    assert np.array_equal(world.plant.tier.coulomb, world.tier.coulomb)


def test_the_plant_has_the_drawn_load_links_friction_and_start(worlds):
    """Each recomputed from the record."""
    world = worlds()
    drawn, plant, robot = world.draws, world.plant, world.robot
    assert np.array_equal(plant.q, world.table["q"][0] + drawn.initial_offset)
    assert not plant.dq.any()
    assert np.array_equal(plant.tier.coulomb, world.tier.coulomb * drawn.friction)
    assert np.array_equal(plant.tier.viscous, world.tier.viscous * drawn.friction)
    bodies = Payload(mass=3.5, material="sand").bodies(robot)
    mass = drawn.payload_mass * sum(body.mass for body in bodies)
    centre = sum(body.mass * body.com for body in bodies) / sum(body.mass for body in bodies) + drawn.payload_centre
    assert plant.payload[0] == pytest.approx(mass, rel=1e-12)
    assert np.allclose(plant.payload[1:4] / plant.payload[0], centre, rtol=0, atol=1e-12)
    nominal = pin.buildModelFromXML(robot.urdf)
    for joint in range(1, 7):
        factor = drawn.link_mass[joint - 1]
        expected = factor * nominal.inertias[joint].toDynamicParameters()
        assert np.allclose(plant.model.inertias[joint].toDynamicParameters(), expected, rtol=1e-9, atol=1e-12)
    # The last link carries the gripper too, which is known and stays.
    links = {link.name: link for link in robot.description.links}
    heavier = (drawn.link_mass[6] - 1.0) * links["link7"].mass
    carried = plant.model.inertias[7].mass - nominal.inertias[7].mass
    assert carried == pytest.approx(heavier + mass, abs=1e-12)


def test_controllers_are_told_the_nominal_arm_and_the_true_start(worlds):
    """The drawn links, friction and load are the plant's; where the arm stands its encoders say anyway."""
    drawn, nominal = worlds(), worlds(draws=False)
    one, other = drawn.task(), nominal.task()
    assert np.array_equal(one.initial_q, drawn.plant.q)
    q = nominal.table["q"][0]
    assert np.array_equal(one.robot.mass_matrix(q), other.robot.mass_matrix(q))
    for name in ("effort", "rotor_inertia", "torque_rate"):
        assert np.array_equal(getattr(one.actuation, name), getattr(other.actuation, name))


def test_the_oracle_knows_the_drawn_load_and_nothing_else(worlds):
    """Mass and centre as they hang there; links and friction stay nominal."""
    world = worlds(knowledge="oracle")
    task, provider = world.task(), Oracle()
    provider.reset(task.robot, task.actuation, world.truth)
    assert np.array_equal(task.robot.payload, world.plant.payload)
    q, dq = world.table["q"][0], np.zeros(7)
    expected = world.robot.model(rotor_inertia=world.tier.rotor_inertia)
    expected.set_payload(world.plant.payload)
    assert np.allclose(task.robot.at(q, dq).gravity, expected.gravity(q), rtol=0, atol=1e-12)
    assert np.abs(expected.gravity(q) - world.plant.gravity()).max() > 0.05


@pytest.mark.parametrize("history", [HEAVY, STEP])
def test_both_engines_agree_over_a_drawn_closed_loop_second(has_pybullet, worlds, play, follows, history):
    """The same draws by two ways into two engines, to 1e-9 rad."""
    paths = []
    for plant in ("pinocchio", "pybullet"):
        world = worlds(plant=plant, schedule=history)
        world.times, world.table = world.times[:1000], world.table[:1000]
        outcome = play(world, follows)
        assert outcome.failure is None
        paths.append(outcome.log["q"])
    assert len(paths[0]) == 1000
    assert np.abs(paths[0] - paths[1]).max() < 1e-9


def test_a_twin_shares_the_draws_of_its_run(drawn_run):
    """Until the event they are one simulation, so that the difference after it is the load's."""
    specification = drawn_run(controller="computed_torque", schedule=STEP, twins=True)
    results = execute(specification, evaluate=unscored, traces="none")
    assert len(results) == 1 + len(twin_schedules(STEP))
    assert all(result.provenance["draws"] == results[0].provenance["draws"] for result in results)


def test_each_link_of_a_chain_draws_as_its_repetition_would(drawn_run):
    """Learning on is over repetitions, each with an arm of its own."""
    chain = drawn_run(protocol="carried", repetitions=3)
    singles = [drawn_run(repetition=k) for k in range(3)]
    assert [draw(link, 7).as_table() for link in chain.links()] == [draw(one, 7).as_table() for one in singles]


def test_draws_in_the_tier_ideal_are_one_clear_line():
    """From the benchmark's key, before anything runs."""
    with pytest.raises(InvalidInput, match="draws = true in tier 'ideal'; it is the nominal arm with exact sensors"):
        campaign(tier="ideal")


def test_a_nominal_run_has_no_draws_in_its_row(drawn_run):
    """Nothing was drawn, and the row says nothing else."""
    specification = replace(drawn_run(controller="computed_torque"), draws=False)
    (result,) = execute(specification, evaluate=unscored, traces="none")
    assert "draws" not in result.provenance


def test_any_arm_draws_as_many_numbers_as_it_has_joints(drawn_run, planar_robot):
    """Two joints, two factors each, on the links that they move."""
    drawn = draw(drawn_run(), planar_robot.n)
    arm = drawn.arm(planar_robot)
    for joint, factor in zip(planar_robot.description.moving, drawn.link_mass, strict=True):
        before, after = (
            next(link for link in robot.description.links if link.name == joint.child) for robot in (planar_robot, arm)
        )
        assert after.mass == before.mass * factor


def test_drawn_water_swings_at_its_own_amplitude_and_phase(drawn_run):
    """The phase alone says nothing: angle and rate together are one point of the mode's circle."""
    wet = LoadSchedule.constant(Payload(mass=3.5, material="water"))
    world = World(drawn_run(controller="computed_torque", schedule=wet), wet)
    (pendulum,) = world.plant.pendulums
    angles, rates = world.draws.slosh(pendulum.liquid)
    assert world.plant.velocities[-2:] == pytest.approx(rates)
    assert world.plant.positions[-2:] - angles == pytest.approx(pendulum.rest(world.plant._down()))
    energy = np.square(angles) + np.square(rates / pendulum.liquid.frequency)
    assert np.sqrt(energy) == pytest.approx(np.full(2, rule.SLOSH_AMPLITUDE), rel=1e-12)
    world.plant.close()
