"""The world of one run: arm, plant, plan and load, built from a specification, at its first tick."""

from functools import lru_cache

import numpy as np

from ..controllers import InvalidInput, PayloadTruth, Task, discovery
from .episode import Episode, Outcome
from .loads import LoadSchedule
from .log import RunLog, quaternions
from .plants.plant import Plant
from .robots import Robot, load_robot
from .specification import RunSpecification
from .streams import controller_seed, scenario_stream
from .tick import run_constants
from .tiers import Tier, build_tier
from .trajectories import Plan, load_path


class World:
    """Arm, plant, plan and load of one run.

    Attributes:
        robot: The arm.
        tier: Constants of drives and sensors.
        plant: The simulated arm at the plan's first tick, at rest, with the first load.
        plan: What the arm should do.
        times: Time of every tick, shape (ticks,) [s].
        table: The plan of every tick, shape (ticks,).
        loads: Tick to the slots' switches, for every change after the first.
        truth: The payload beyond the gripper, as ``oracle`` may see it.
    """

    def __init__(self, specification: RunSpecification, schedule: LoadSchedule) -> None:
        """Build the world of a specification under one load history.

        Raises:
            TorquebenchError: If robot, trajectory, load, plant or tier cannot be had.
        """
        self.specification = specification
        self.robot = cached_robot(specification.robot, specification.tool)
        self.tier: Tier = build_tier(specification.tier, self.robot.tiers, self.robot.rotor_inertia)
        self.plan = cached_plan(self.robot, specification.trajectory, specification.lead_in)
        slots, switches = schedule.slots(self.robot)
        plant = discovery.load("plants", specification.plant)
        self.plant: Plant = plant(self.robot, self.tier, slots)  # type: ignore[operator]
        period, lead_in = self.tier.period, specification.lead_in
        early = [when for when in schedule.events if when <= -lead_in]
        if early:
            came = f"a load change at {early[0]:g} s, the run starts at {-lead_in:g} s"
            raise InvalidInput(came, "load schedule", "make it the first entry")
        ticks = round((lead_in + specification.laps * self.plan.period) / period)
        self.times = np.round(np.arange(ticks) * period - lead_in, 9)
        self.table = self.plan.rows(self.times)
        self.loads = {round((when + lead_in) / period): active for when, active in switches[1:]}
        self.plant.set_load(switches[0][1])
        self.plant.reset(self.table["q"][0], np.zeros(self.robot.n))
        self.truth = PayloadTruth(parameters=self.plant.payload.copy())
        self._model = self.robot.model(rotor_inertia=self.tier.rotor_inertia)

    def task(self) -> Task:
        """Return what the controller is told before the run; the model is its own."""
        return Task(
            robot=self._model.copy(),
            reference=self.plan,
            actuation=self.tier.actuation(self.robot.effort),
            period=self.tier.period,
            duration=self.specification.laps * self.plan.period,
            initial_q=self.table["q"][0].copy(),
            seed=controller_seed(self.specification),
            knowledge=self.specification.knowledge,
            repetition=self.specification.repetition,
        )

    def episode(self, controller: object, provider: object) -> Episode:
        """Return the episode of a controller that is reset, its sensor noise drawn from the scenario's own stream."""
        sensor = scenario_stream("sensor", self.specification)
        bias = self.tier.wrench_bias * sensor.standard_normal(6)
        noisy = bool(self.tier.wrench_noise.any())
        noise = self.tier.wrench_noise * sensor.standard_normal((self.times.size, 6)) if noisy else np.zeros((1, 6))
        robot = self.robot
        constants = run_constants(
            self.tier,
            effort=robot.effort,
            velocity=robot.velocity,
            lower=robot.lower,
            upper=robot.upper,
            bias=bias,
        )
        return Episode(
            controller=controller,  # type: ignore[arg-type]
            provider=provider,  # type: ignore[arg-type]
            plant=self.plant,
            reference=self.plan,
            table=self.table,
            times=self.times,
            constants=constants,
            nominal_gravity=self._model.gravity(self.plant.q),
            noise=noise,
            loads=self.loads,
            truth=self.truth,
            latency=self.specification.latency,
        )

    def run_log(self, outcome: Outcome) -> RunLog:
        """Return the log of an outcome, with tool poses and the plan beside it."""
        # Metrics read these arrays many times: packed, not as columns of wide records.
        rows, table = _packed(outcome.log), _packed(self.table[: len(outcome.log)])
        robot = self.robot
        position, rotation = self._model.tool_path(rows["q"])
        limited = bool(np.isfinite(self.tier.torque_rate).any())
        return RunLog(
            t=rows["time"],
            q=rows["q"],
            dq=rows["dq"],
            q_ref=table["q"],
            dq_ref=table["dq"],
            ddq_ref=table["ddq"],
            tau_cmd=rows["command"],
            tau_lim=rows["limited"],
            tau=rows["torque"],
            p=position,
            p_ref=table["pose"][:, :3, 3],
            quat=quaternions(rotation),
            quat_ref=quaternions(table["pose"][:, :3, :3]),
            twist_ref=table["twist"],
            wrench=rows["wrench"],
            dt=self.tier.period,
            lap=self.plan.period,
            effort=robot.effort,
            torque_rate=self.tier.torque_rate if limited else None,
            velocity=robot.velocity,
            lower=robot.lower,
            upper=robot.upper,
        )


def _packed(records: np.ndarray) -> dict[str, np.ndarray]:
    """Return the fields of records as arrays of their own."""
    return {name: np.ascontiguousarray(records[name]) for name in records.dtype.names or ()}


@lru_cache(maxsize=8)
def cached_robot(name: str, tool: str) -> Robot:
    """Return a robot, read once a process."""
    return load_robot(name, tool=tool)


@lru_cache(maxsize=64)
def cached_plan(robot: Robot, trajectory: str, lead_in: float) -> Plan:
    """Return a plan, built once a process."""
    return Plan.build(robot, load_path(trajectory), lead_in=lead_in)
