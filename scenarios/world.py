"""The world of one run: arm, plant, plan and load, built from a specification, at its first tick."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ..controllers import InvalidInput, PayloadTruth, Task, discovery
from .body import Body
from .disturbance import Disturbance
from .draws import draw
from .episode import Episode, Outcome
from .loads import LoadSchedule
from .log import RunLog, quaternions
from .margins import HOLD
from .plants.plant import Plant
from .robots import Robot, load_robot
from .specification import RunSpecification
from .streams import controller_seed, scenario_stream
from .tare import TARE_TICKS, gripper_wrench, tare_offset
from .tick import run_constants
from .tiers import Tier, build_tier
from .trajectories import Plan, load_path


class World:
    """Arm, plant, plan and load of one run.

    Attributes:
        robot: The nominal arm, which controllers know.
        tier: Nominal constants of drives and sensors.
        draws: How arm, friction, load and start of the plant differ from the nominal.
        plant: The simulated arm at the plan's first tick, at rest, with the first load.
        plan: What the arm should do.
        times: Time of every tick, shape (ticks,) [s].
        table: The plan of every tick, shape (ticks,).
        initial_q: Joint positions at the first tick, shape (n,) [rad].
        loads: Tick to the slots' switches, for every change after the first.
        truth: The payload beyond the gripper, as ``oracle`` may see it.
        injection: Torque added to the command of every tick, shape (ticks, n), None for none [N m].
    """

    def __init__(self, specification: RunSpecification, schedule: LoadSchedule) -> None:
        """Build the world of a specification under one load history.

        Raises:
            TorquebenchError: If robot, trajectory, load, plant or tier cannot be had.
        """
        self.specification = specification
        self.robot = cached_robot(specification.robot, specification.tool)
        self.tier: Tier = tier_of(specification, self.robot)
        self.plan = cached_plan(self.robot, specification.trajectory, specification.lead_in)
        self.draws = draw(specification, self.robot.n)
        slots, switches = schedule.slots(self.robot)
        untold = specification.perturbation.bodies(self.robot)
        self.plant = self._plant((*(self.draws.carried(body) for body in slots), *untold))
        self._untold = sum((body.parameters for body in untold), np.zeros(10))
        self._set_clock(schedule)
        carried = [(when, (*active, *(True for _ in untold))) for when, active in switches]
        self.loads = {self._tick(when): active for when, active in carried[1:]}
        self._place(carried[0][1])
        self.truth = PayloadTruth(parameters=self.plant.payload - self._untold)
        self.injection: np.ndarray | None = None
        self._mass = None if schedule.events else schedule.entries[0][1].mass
        self._model = self.robot.model(rotor_inertia=self.tier.rotor_inertia)

    def _plant(self, bodies: tuple[Body, ...]) -> Plant:
        """Return the plant, with nothing on the gripper yet: the drawn arm, with what is wrong with its drives."""
        specification, drawn = self.specification, self.draws
        build = discovery.load("plants", specification.plant)
        drives = specification.perturbation.drives(drawn.drives(self.tier))
        plant: Plant = build(drawn.arm(self.robot), drives, bodies)  # type: ignore[operator]
        return plant

    def _set_clock(self, schedule: LoadSchedule) -> None:
        """Lay out the ticks and the plan at each."""
        lead_in = self.specification.lead_in
        early = [when for when in schedule.events if when <= -lead_in]
        if early:
            came = f"a load change at {early[0]:g} s, the run starts at {-lead_in:g} s"
            raise InvalidInput(came, "load schedule", "make it the first entry")
        ticks = self._tick(self.specification.laps * self.plan.period)
        self.times = np.round(np.arange(ticks) * self.tier.period - lead_in, 9)
        self.table = self.plan.rows(self.times)

    def _tick(self, when: float) -> int:
        """Return the number of the tick at a time."""
        return round((when + self.specification.lead_in) / self.tier.period)

    def _place(self, load: Sequence[bool]) -> None:
        """Put the arm at rest where the run starts, and its load on it; a liquid that is there swings as drawn."""
        plant, n, still = self.plant, self.robot.n, np.zeros(self.robot.n)
        perturbed = self.specification.perturbation.offset / np.sqrt(n)
        self.initial_q = self.table["q"][0] + self.draws.initial_offset + perturbed
        plant.reset(self.initial_q, still)
        self._unloaded = plant.wrench.copy()
        plant.set_load(load)
        plant.reset(self.initial_q, still)
        if self.specification.draws and plant.pendulums:
            plant.reset(self.initial_q, still, slosh=self._drawn_slosh())

    def _drawn_slosh(self) -> tuple[np.ndarray, np.ndarray]:
        """Return angles and rates of all pendulums, those of liquids that are there as drawn [rad, rad/s]."""
        plant, n = self.plant, self.robot.n
        angles, rates = plant.positions[n:].copy(), plant.velocities[n:].copy()
        for pendulum in plant.pendulums:
            if pendulum.active:
                here = slice(pendulum.joints.start - n, pendulum.joints.stop - n)
                swing, rates[here] = self.draws.slosh(pendulum.liquid)
                angles[here] += swing
        return angles, rates

    def task(self) -> Task:
        """Return what the controller is told before the run; the model is its own."""
        return Task(
            robot=self._model.copy(),
            reference=self.plan,
            actuation=self.tier.actuation(self.robot.effort),
            period=self.tier.period,
            duration=self.specification.laps * self.plan.period,
            initial_q=self.initial_q.copy(),
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
            self.plant.tier,
            effort=robot.effort,
            velocity=robot.velocity,
            lower=robot.lower,
            upper=robot.upper,
            bias=bias,
            latency=self.specification.latency,
            gain=self.specification.perturbation.gain,
        )
        if self.specification.tare:
            constants["wrench_bias"] -= self._tare(constants)
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
            untold=self._untold,
            disturbance=self._disturbance(),
        )

    def _tare(self, constants: np.ndarray) -> np.ndarray:
        """Return what a tare before the run takes from every reading, its noise from a stream of its own."""
        stream = scenario_stream("tare", self.specification)
        return tare_offset(
            self.plant.q,
            self._unloaded,
            known=gripper_wrench(self._model, self.plant.q),
            constants=constants,
            noise=self.tier.wrench_noise * stream.standard_normal((TARE_TICKS, 6)),
        )

    def _disturbance(self) -> Disturbance | None:
        """Return what disturbs sensors and commands, None where nothing does; the noise has a stream of its own."""
        perturbation = self.specification.perturbation
        if perturbation.velocity_noise == 0.0 and self.injection is None:
            return None
        shape = (self.times.size, self.robot.n)
        noise = scenario_stream("velocity noise", self.specification).standard_normal(shape)
        return Disturbance(
            velocity=perturbation.velocity_noise * noise,
            torque=np.zeros(shape) if self.injection is None else self.injection,
        )

    def run_log(self, outcome: Outcome) -> RunLog:
        """Return the log of an outcome, with tool poses and the plan beside it."""
        # Metrics read these arrays many times: packed, not as columns of wide records.
        rows, table = _packed(outcome.log), _packed(self.table[: len(outcome.log)])
        robot = self.robot
        position, rotation, twist = self._model.tool_motion(rows["q"], rows["dq"])
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
            twist=twist,
            twist_ref=table["twist"],
            wrench=rows["wrench"],
            call_time=rows["call_time"] * 1e-9,
            dt=self.tier.period,
            lap=self.plan.period,
            effort=robot.effort,
            torque_rate=self.tier.torque_rate if limited else None,
            velocity=robot.velocity,
            lower=robot.lower,
            upper=robot.upper,
            mass=self._mass,
        )


def _packed(records: np.ndarray) -> dict[str, np.ndarray]:
    """Return the fields of records as arrays of their own."""
    return {name: np.ascontiguousarray(records[name]) for name in records.dtype.names or ()}


def tier_of(specification: RunSpecification, robot: Robot) -> Tier:
    """Return the tier of a run, with the constants that the run changes."""
    return build_tier(specification.tier, robot.tiers, robot.rotor_inertia, specification.tier_constants)


@lru_cache(maxsize=8)
def cached_robot(name: str, tool: str) -> Robot:
    """Return a robot, read once a process."""
    return load_robot(name, tool=tool)


@lru_cache(maxsize=64)
def cached_plan(robot: Robot, trajectory: str, lead_in: float) -> Plan:
    """Return a plan, built once a process; of the motion at rest it is the robot's home."""
    if trajectory == HOLD:
        return Plan.hold(robot, lead_in=lead_in)
    return Plan.build(robot, load_path(trajectory), lead_in=lead_in)
