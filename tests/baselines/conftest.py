"""Arms, plans and an exact plant: what the laws of this room are tried on."""

from types import SimpleNamespace

import numpy as np
import pytest
from torquebench.controllers import Actuation, NoKnowledge, Observation, Preview, RobotModel, Target, Task, discovery
from torquebench.scenarios.episode import run_episode
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.robots import load_robot
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.world import World

PERIOD = 1e-3
BENT = np.array([0.3, 0.7, -0.4, 1.1, 0.5, 0.8, -0.2])


def chain_urdf(axes: str) -> str:
    """Return an arm of tapering rods, one revolute joint per letter, its tool 0.1 m beyond the flange."""
    parts = ['<robot name="chain"><link name="link0"/>']
    for i, axis in enumerate(axes):
        mass, length = 4.0 / (i + 1), 0.25
        vector = " ".join("1" if axis == letter else "0" for letter in "xyz")
        inertia = mass * length**2 / 12
        parts.append(
            f'<joint name="joint{i + 1}" type="revolute"><parent link="link{i}"/><child link="link{i + 1}"/>'
            f'<origin xyz="0 0 {length if i else 0.3}"/><axis xyz="{vector}"/>'
            f'<limit lower="-3" upper="3" velocity="3" effort="150"/></joint>'
            f'<link name="link{i + 1}"><inertial><origin xyz="0.01 0.02 {length / 2}"/><mass value="{mass}"/>'
            f'<inertia ixx="{inertia}" iyy="{inertia}" izz="{0.2 * inertia}" ixy="0" ixz="0" iyz="0"/></inertial>'
            f"</link>"
        )
    for child, parent, z in (("flange", f"link{len(axes)}", 0.1), ("tool", "flange", 0.1)):
        parts.append(
            f'<link name="{child}"/><joint name="{child}_joint" type="fixed"><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="0 0 {z}"/></joint>'
        )
    return "".join([*parts, "</robot>"])


def arm_model(axes: str, *, rotor: float = 0.3) -> RobotModel:
    """Return the model of a chain with equal rotor inertias."""
    inertia = np.full(len(axes), rotor)
    return RobotModel(chain_urdf(axes), tool_frame="tool", flange_frame="flange", rotor_inertia=inertia)


def point_load(mass: float, *, z: float) -> np.ndarray:
    """Return a point mass on the flange's z axis as inertial parameters."""
    square = mass * z * z
    return np.array([mass, 0.0, 0.0, mass * z, square, 0.0, square, 0.0, 0.0, 0.0])


def read_only(array: np.ndarray) -> np.ndarray:
    """Return a copy as the harness hands it out."""
    copy = np.array(array, dtype=float)
    copy.flags.writeable = False
    return copy


class Sway:
    """A plan that sways every joint about a posture; no sway is a hold."""

    period, lead_in = 2.0, 0.0

    def __init__(self, model: RobotModel, centre: np.ndarray, amplitude: float) -> None:
        self.model, self.centre, self.amplitude = model.copy(), centre, amplitude
        self.q = np.stack([self.joints(t)[0] for t in np.arange(0.0, self.period, 0.02)])

    def joints(self, time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return positions, velocities and accelerations."""
        rate = 2.0 * np.pi / self.period
        phase = rate * time + np.arange(len(self.centre))
        a = self.amplitude
        return self.centre + a * np.sin(phase), a * rate * np.cos(phase), -a * rate**2 * np.sin(phase)

    def target(self, time: float) -> Target:
        """Return the plan of joints and tool."""
        q, dq, ddq = self.joints(time)
        state = self.model.at(q, dq)
        twist, acceleration = state.jacobian @ dq, state.jacobian @ ddq + state.jacobian_bias
        plan = {"q": q, "dq": dq, "ddq": ddq, "pose": state.pose, "twist": twist, "acceleration": acceleration}
        return Target(**{name: read_only(array) for name, array in plan.items()}, reference=self)

    def preview(self, times: np.ndarray) -> Preview:
        """Return the plan at several times."""
        targets = [self.target(time) for time in times]
        names = ("q", "dq", "ddq", "pose", "twist", "acceleration")
        return Preview(**{name: np.stack([getattr(target, name) for target in targets]) for name in names})


class Bench:
    """An arm on an exact plant: rigid bodies, 1 kHz semi-implicit steps, no delay, nothing unmodelled but the load."""

    def __init__(self, model: RobotModel, centre: np.ndarray, *, sway: float = 0.0, effort: float = np.inf) -> None:
        self.model, self.plant, self.plan = model, model.copy(), Sway(model, centre, sway)
        self.effort = self.told_effort = np.full(model.n, effort)

    def task(self) -> Task:
        """Return the episode."""
        actuation = Actuation(
            tier="exact",
            delay_ticks=0,
            torque_lag=0.0,
            velocity_filter_hz=None,
            effort=self.told_effort,
            torque_rate=None,
            rotor_inertia=self.model.rotor_inertia,
        )
        facts = {"period": PERIOD, "duration": 1.0, "initial_q": self.plan.joints(0.0)[0], "seed": 0}
        return Task(robot=self.model, reference=self.plan, actuation=actuation, knowledge="none", **facts)

    def observe(self, time: float, q: np.ndarray, dq: np.ndarray, command: np.ndarray | None = None) -> Observation:
        """Return exact measurements."""
        command = read_only(self.plant.gravity(q) if command is None else command)
        arrays = {"q": read_only(q), "dq": read_only(dq), "wrench": read_only(np.zeros(6))}
        return Observation(time=time, **arrays, command=command, torque=command)

    def run(self, controller: object, seconds: float, *, offset: float = 0.0) -> SimpleNamespace:
        """Run an episode from a joint offset; returns joint errors and torques by tick, and the last state."""
        controller.reset(self.task())
        q, dq, _ = self.plan.joints(0.0)
        q = q - offset
        ticks = round(seconds / PERIOD)
        errors, torques = np.empty((ticks, self.model.n)), np.empty((ticks, self.model.n))
        command = None
        for k in range(ticks):
            target = self.plan.target(k * PERIOD)
            torques[k] = controller.compute(self.observe(k * PERIOD, q, dq, command), target)
            command = np.clip(torques[k], -self.effort, self.effort)
            errors[k] = target.q - q
            state = self.plant.at(q, dq)
            dq = dq + PERIOD * np.linalg.solve(state.mass_matrix, command - state.bias)
            q = q + PERIOD * dq
        return SimpleNamespace(error=errors, torque=torques, q=q, dq=dq, target=target)


AXES = {"planar": "yyy", "planar4": "yyyy", "six": "zyzyzy", "seven": "zyzyzyz"}


@pytest.fixture
def bench():
    """Builds a bench with one of the arms, away from singularities."""

    def build(arm: str = "seven", *, sway: float = 0.0, effort: float = np.inf, rotor: float = 0.3) -> Bench:
        model = arm_model(AXES[arm], rotor=rotor)
        return Bench(model, BENT[: model.n], sway=sway, effort=effort)

    return build


@pytest.fixture
def load():
    """Builds a point mass on the flange's z axis."""
    return point_load


@pytest.fixture
def on_t3():
    """Runs a named controller on T3, tier ideal, with 2 kg that it is not told of; 12 s after the lead-in.

    Returns it, the load's mass [kg] and the mean distance of the tool point in every second from 0 [m].
    """

    def run(name: str, **settings: float) -> SimpleNamespace:
        load = LoadSchedule.constant(Payload(mass=3.186, material="sand"))
        specification = RunSpecification(
            controller=name, trajectory="T3", schedule=load, robot="rizon4s", plant="pinocchio", tier="ideal"
        )
        world, provider = World(specification, load), NoKnowledge()
        task, controller = world.task(), discovery.load("controllers", name)(**settings)
        provider.reset(task.robot, task.actuation, world.truth)
        controller.reset(task)
        log = world.run_log(run_episode(world.episode(controller, provider)))
        distance = np.linalg.norm(log.p - log.p_ref, axis=1)[log.t >= 0.0]
        by_second = distance.reshape(-1, 1000).mean(axis=1)
        return SimpleNamespace(controller=controller, mass=world.truth.parameters[0], error=by_second)

    return run


@pytest.fixture(scope="session")
def rizon():
    """The Rizon 4s with its gripper."""
    return load_robot("rizon4s")
