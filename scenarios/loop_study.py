"""The loops of one controller at rest: a multisine at one joint after the other, every loop closed."""

from dataclasses import replace

import numpy as np

from .multisine import SHARE, log_lines, multisine
from .result import OK, RunResult
from .specification import RunSpecification
from .streams import scenario_stream
from .studies import Judges, LoopRecords, Play, study_timing
from .trace import encode_trace
from .world import World, cached_robot


def loop_study(specification: RunSpecification, play: Play, judges: Judges, *, keep: bool) -> RunResult:
    """Return the row of the loops of all joints; the first run that fails ends it.

    Args:
        specification: The study, on the motion at rest.
        play: Runs one specification.
        judges: Judge the records.
        keep: Whether the measured response is kept as a trace.
    """
    robot = cached_robot(specification.robot, specification.tool)
    run = replace(specification, study="")
    results: list[RunResult] = []
    injections, commands = [], []
    for joint, effort in enumerate(robot.effort):
        inject = _Injection(specification, joint, SHARE * float(effort))
        trial = play(run, inject)
        log = trial.log
        results.append(trial.result)
        if trial.result.status != OK or log is None:
            reason = f"while joint {joint + 1} was excited: {trial.result.reason}"
            return replace(trial.result, reason=reason, timing=study_timing(results), trace=None)
        scored = log.t >= -0.5 * log.dt
        # What arrives at the limiter from the controller, late and with a wrong gain if the run has either.
        loop = log.tau_lim[scored].reshape(specification.laps, -1, robot.n)
        loop[:, :, joint] -= inject.wave
        commands.append(loop)
        injections.append(inject.wave)
        lines, period = inject.lines, log.dt
    records = LoopRecords(commands=np.array(commands), injection=np.array(injections), lines=lines, period=period)
    scores = judges.loops(records)
    return replace(
        results[0],
        metrics=scores.metrics,
        timing=study_timing(results),
        provenance={**results[0].provenance, "amplitudes": (SHARE * robot.effort).tolist(), "lines": len(lines)},
        trace=encode_trace(scores.arrays) if keep else None,
    )


class _Injection:
    """Puts the multisine of one joint into a world, from time 0 on."""

    def __init__(self, specification: RunSpecification, joint: int, amplitude: float) -> None:
        self.specification, self.joint, self.amplitude = specification, joint, amplitude

    def __call__(self, world: World) -> None:
        period = world.tier.period
        samples = round(world.plan.period / period)
        generator = scenario_stream(f"multisine {self.joint + 1}", self.specification)
        self.lines = log_lines(samples, period)
        self.wave = self.amplitude * multisine(self.lines, samples, generator)
        started = world.times >= -0.5 * period
        world.injection = np.zeros((world.times.size, world.robot.n))
        world.injection[started, self.joint] = np.resize(self.wave, int(np.count_nonzero(started)))
