"""Damping laws on elastic joints, linearised: the matrix is the plant's, and it tells stable from unstable."""

import numpy as np
import pytest
from torquebench.controllers import DesignInertia, InvalidInput, Refusal, build_controller, discovery
from torquebench.scenarios.elastic_loop import check_springs, check_substeps, damping_loop
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.plants.pinocchio_plant import PinocchioPlant
from torquebench.scenarios.robots import read_robot
from torquebench.scenarios.tiers import build_tier

EMPTY, HEAVY = (LoadSchedule.constant(load) for load in (Payload(mass=1.5), Payload(mass=3.5, material="sand")))
JOINT = {
    "joint_stiffness": (300.0,),
    "joint_damping_time": 0.001,
    "motor_inertia": (0.5,),
    "torque_feedback_gain": 2.0,
    "torque_feedback_damping_ratio": 1.0,
    "current_loop_time_constant": 0.0005,
    "substeps": 4,
    "delay_ticks": 1,
    "velocity_filter_hz": 150.0,
}


@pytest.fixture
def turntable(tmp_path, urdf_of):
    """One joint on a vertical axis, whose equations are linear."""
    file = tmp_path / "turntable.urdf"
    file.write_text(urdf_of("z"))
    return read_robot(file)


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_the_loop_s_matrix_does_what_plant_filter_and_delay_do(turntable, delay):
    """Tick by tick for a damping law, state by state: no second model of the tier that could drift away."""
    tier = build_tier("joint", {"joint": JOINT | {"delay_ticks": delay}}, np.zeros(1))
    plant, damping = PinocchioPlant(turntable, tier), 6.0
    plant.reset(np.zeros(1), np.array([0.2]))
    links = plant.mass_matrix() - np.diag(tier.rotor_inertia)
    loop = damping_loop(tier, tier.elasticity, links, np.array([[damping]]))
    state = np.zeros(7 + delay)
    state[[1, 3]] = 0.2
    share, before, filtered, waiting = 1.0 - np.exp(-2.0 * np.pi * 0.15), 0.0, 0.0, [0.0] * delay
    for _ in range(60):
        filtered += share * ((plant.theta[0] - before) / 0.001 - filtered)
        before = plant.theta[0]
        waiting.append(-damping * filtered)
        plant.step(np.array([waiting.pop(0)]))
        state = loop @ state
        found = [plant.q[0], plant.dq[0], plant.theta[0], plant.dtheta[0]]
        assert np.allclose(found, state[:4], rtol=1e-9, atol=1e-12)
    assert abs(plant.q[0]) > 1e-3


def test_a_free_arm_without_damping_keeps_its_place_and_its_speed(rizon):
    """Fourteen eigenvalues of one, none above it: a motion that nothing drives must not look unstable."""
    tier = build_tier("elastic", rizon.tiers, rizon.rotor_inertia)
    links = rizon.model().mass_matrix(rizon.home)
    sizes = np.sort(np.abs(np.linalg.eigvals(damping_loop(tier, tier.elasticity, links, np.zeros((7, 7))))))
    assert np.allclose(sizes[-14:], 1.0, rtol=0, atol=1e-6)
    assert sizes[-15] < 0.999


def verdict_of(world, name):
    """Return the refusal of a controller in a world, None if there is none."""
    controller, task = build_controller(discovery.load("controllers", name), {}, name=name), world.task()
    discovery.load("knowledge", "oracle")().reset(task.robot, task.actuation, world.truth)
    controller.reset(task)
    try:
        check_springs(controller.design_inertia(), world.tier, world.plant.mass_matrix())
    except Refusal as refusal:
        return refusal.reason
    return None


@pytest.mark.parametrize("name", ["flexiv_factory", "computed_torque_stiff"])
def test_a_law_that_scales_its_damping_with_a_heavy_load_is_refused_with_its_frequency(world_of, name):
    """At 140 Hz the springs part the rotors from the load, and the damping meant for both acts on the rotors alone."""
    reason = verdict_of(world_of(tier="elastic", schedule=HEAVY), name)
    assert "a motion at 14" in reason and " Hz grows by a factor of 1.0" in reason
    assert verdict_of(world_of(tier="elastic", schedule=EMPTY), name) is None
    assert verdict_of(world_of(tier="actuated", schedule=HEAVY), name) is None


def test_a_softer_law_keeps_its_heavy_load(world_of):
    """Half the bandwidth, half the damping."""
    assert verdict_of(world_of(tier="elastic", schedule=HEAVY), "computed_torque") is None


@pytest.mark.parametrize("rate", [40.0, 80.0])
def test_a_refused_law_shakes_the_arm_and_an_allowed_one_does_not(world_of, play, rate):
    """The figure must mean something: the same damping in the loop of the harness, 3.5 kg on the flange and known."""
    world = world_of(tier="elastic", schedule=HEAVY, seconds=0.5)

    class Damps:
        def reset(self, task):
            self.robot, self.mass = task.robot, world.plant.mass_matrix()

        def compute(self, observation, target):
            return world.plant.gravity() - rate * self.mass @ observation.dq

    world.plant.reset(world.plant.q.copy(), np.full(7, 1e-3))
    design = DesignInertia(mass_matrix=world.plant.mass_matrix(), damping=rate)
    command = play(world, Damps()).log["command"]
    chatter = np.abs(np.diff(command[-50:], axis=0)).max()
    if rate > 60.0:
        with pytest.raises(Refusal, match="excites the elastic joints"):
            check_springs(design, world.tier, design.mass_matrix)
        assert chatter > 20.0
    else:
        check_springs(design, world.tier, design.mass_matrix)
        assert chatter < 5.0


def test_who_declares_no_inertia_is_not_judged(rizon):
    """Nor is anybody on a tier without springs."""
    elastic, rigid = (build_tier(name, rizon.tiers, rizon.rotor_inertia) for name in ("elastic", "actuated"))
    mass = rizon.model(rotor_inertia=rigid.rotor_inertia).mass_matrix(rizon.home)
    check_springs(None, elastic, mass)
    check_springs(DesignInertia(mass_matrix=mass, damping=1e4), rigid, mass)


def test_a_step_too_long_for_the_springs_is_the_tier_s_fault_and_said_so(turntable, rizon):
    """Semi-implicit Euler on a spring is stable below omega h = 2; no controller may be blamed for the rest."""
    inertia = float(turntable.model().mass_matrix(np.zeros(1))[0, 0])
    for share, stable in ((0.9, True), (1.1, False)):
        # omega^2 = K (1/J + 1/M), so that omega h is twice the share.
        stiffness = (2.0 * share / 0.001) ** 2 / (1.0 / 0.5 + 1.0 / inertia)
        constants = {"joint_stiffness": (stiffness,), "motor_inertia": (0.5,)}
        tier = build_tier("stiff", {"stiff": constants}, np.zeros(1))
        mass = np.array([[inertia]]) + np.diag(tier.rotor_inertia)
        if stable:
            check_substeps(tier, mass)
        else:
            with pytest.raises(InvalidInput, match=r"tier 'stiff': .* unstable with substeps = 1; give substeps = 2"):
                check_substeps(tier, mass)
    tier = build_tier("elastic", rizon.tiers, rizon.rotor_inertia)
    check_substeps(tier, rizon.model(rotor_inertia=tier.rotor_inertia).mass_matrix(rizon.home))


def test_an_arm_with_too_light_a_wrist_is_told_how_many_substeps_it_needs(tmp_path, urdf_of):
    """And with them it goes."""
    (tmp_path / "arm.urdf").write_text(urdf_of("zyzyzyz"))
    stiffness, inertia = [9e3] * 4 + [900.0] * 3, [1.0] * 7
    springs = f"joint_stiffness = {stiffness}\nmotor_inertia = {inertia}"
    file = tmp_path / "arm.toml"

    def check(substeps):
        head = 'schema = 1\nname = "arm"\nurdf = "arm.urdf"\n[tiers.elastic]\njoint_damping_time = 0.001\n'
        file.write_text(f"{head}{springs}\nsubsteps = {substeps}\n")
        robot = read_robot(file)
        tier = build_tier("elastic", robot.tiers, robot.rotor_inertia)
        check_substeps(tier, robot.model(rotor_inertia=tier.rotor_inertia).mass_matrix(robot.home))

    with pytest.raises(InvalidInput, match="give substeps = ") as caught:
        check(2)
    check(int(str(caught.value).rsplit(" ", 1)[1]))
