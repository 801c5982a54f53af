"""The contract's checks find what they are for, and pass what is sound."""

import itertools

import numpy as np
import pytest
from torquebench.controllers import Actuation, LedgerEntry, Observation, Target, Task, check_controller

TICKS = 30


class Sound:
    """A damped spring with an integrator and its own copy of everything: as good as a law can be."""

    def reset(self, task):
        self.robot, self.sum = task.robot, np.zeros(task.robot.n)
        self.shown = np.zeros(task.robot.n)

    def compute(self, observation, target):
        error = target.q - observation.q
        self.sum += 0.001 * error
        self.shown[:] = error
        return 100.0 * error + 50.0 * self.sum - 5.0 * observation.dq + self.robot.gravity(observation.q)

    def diagnostics(self):
        return {"error": (self.shown, 1)}

    def operations(self):
        return {"multiplications": 21}

    def ledger(self):
        return (LedgerEntry(setting="stiffness", value=100.0, source="chosen"),)


class KeepsAnInput(Sound):
    """Differentiates the position it kept by reference: in the harness the difference is always zero."""

    def reset(self, task):
        super().reset(task)
        self.last = None

    def compute(self, observation, target):
        moved = observation.q - (observation.q if self.last is None else self.last)
        self.last = observation.q
        return super().compute(observation, target) - 3.0 * moved


class Unseeded(Sound):
    """Draws from a source that nobody seeds."""

    def compute(self, observation, target):
        return super().compute(observation, target) + 1e-9 * np.random.default_rng().normal(size=2)


class Remembers(Sound):
    """Keeps its integral over a reset."""

    def __init__(self):
        self.kept = np.zeros(2)

    def reset(self, task):
        super().reset(task)
        self.sum = self.kept


class Counts(Sound):
    """Numbers its instances: the second of them is another controller."""

    numbers = itertools.count()

    def __init__(self):
        self.number = next(Counts.numbers)

    def compute(self, observation, target):
        return super().compute(observation, target) + self.number


class Shares(Sound):
    """Holds its state in the class: alone it repeats itself, beside another it does not."""

    last = np.zeros(2)

    def reset(self, task):
        super().reset(task)
        Shares.last = np.zeros(2)

    def compute(self, observation, target):
        torque = super().compute(observation, target) + 0.1 * Shares.last
        Shares.last = torque.copy()
        return torque


class WritesTarget(Sound):
    """Wraps its error in place, in the harness's own array."""

    def compute(self, observation, target):
        target.q -= observation.q
        return super().compute(observation, target)


class ForcesTarget(Sound):
    """The same, after it took the lock off."""

    def compute(self, observation, target):
        target.q.flags.writeable = True
        target.q[:] = 0.0
        return super().compute(observation, target)


class Returns(Sound):
    """Returns the same thing whatever happens."""

    def __init__(self, answer):
        self.answer = answer

    def compute(self, observation, target):
        return self.answer


class Raises(Sound):
    """Divides by what is zero in the first tick."""

    def compute(self, observation, target):
        return np.zeros(2) * (1 // int(observation.time > 1e9))


class MovesDiagnostics(Sound):
    """Binds a new array each tick: the harness goes on copying the first."""

    def compute(self, observation, target):
        torque = super().compute(observation, target)
        self.shown = torque.copy()
        return torque


class WrongLedger(Sound):
    """Writes its ledger as plain text."""

    def ledger(self):
        return ("stiffness 100",)


class ArrayInLedger(Sound):
    """Writes an array where JSON needs a list."""

    def ledger(self):
        return (LedgerEntry(setting="gains", value=np.ones(2), source="rule"),)


class NegativeCount(Sound):
    """Counts backwards."""

    def operations(self):
        return {"spikes": -1}


class Refuses(Sound):
    """Is made for arms of seven joints."""

    def supports(self, task):
        return None if task.robot.n == 7 else f"needs seven joints, the arm has {task.robot.n}"


class CarriesOver(Remembers):
    """Keeps its integral and says so."""

    carry_over = True


@pytest.fixture
def recorded(arm_of, rng):
    """A task on the two-joint arm, with thirty ticks of a wavering motion."""
    arm = arm_of(2)
    drives = Actuation(
        tier="ideal",
        delay_ticks=0,
        torque_lag=0.0,
        velocity_filter_hz=None,
        effort=arm.effort,
        torque_rate=None,
        rotor_inertia=arm.rotor_inertia,
    )
    task = Task(
        robot=arm,
        reference=None,
        actuation=drives,
        period=0.001,
        duration=1.0,
        initial_q=np.zeros(2),
        seed=1,
        knowledge="none",
    )
    observations = [
        Observation(
            time=k * 0.001,
            q=rng.normal(size=2),
            dq=rng.normal(size=2),
            wrench=rng.normal(size=6),
            command=rng.normal(size=2),
            torque=rng.normal(size=2),
        )
        for k in range(TICKS)
    ]
    targets = [
        Target(
            q=rng.normal(size=2),
            dq=rng.normal(size=2),
            ddq=rng.normal(size=2),
            pose=np.eye(4),
            twist=rng.normal(size=6),
            acceleration=rng.normal(size=6),
            reference=None,
        )
        for _ in range(TICKS)
    ]
    return task, observations, targets


def broken(findings):
    """Return the laws that do not hold."""
    return {finding.check for finding in findings if not finding.passed}


def test_a_sound_controller_passes_every_check(recorded):
    """Eleven laws, each by name."""
    findings = check_controller(Sound, *recorded)
    assert not broken(findings)
    assert len({finding.check for finding in findings}) == len(findings) == 11


@pytest.mark.parametrize(
    ("law", "check"),
    [
        (KeepsAnInput, "keeps no input"),
        (Unseeded, "repeats after reset"),
        (Unseeded, "repeats in a fresh instance"),
        (Remembers, "repeats after reset"),
        (Counts, "repeats in a fresh instance"),
        (Shares, "repeats beside another instance"),
        (WritesTarget, "runs"),
        (ForcesTarget, "changes no input"),
        (lambda: Returns(np.zeros(3)), "shape"),
        (lambda: Returns(np.zeros((2, 1))), "shape"),
        (lambda: Returns([0.0, 0.0]), "shape"),
        (lambda: Returns(None), "shape"),
        (lambda: Returns(np.array([0.0, np.nan])), "finite"),
        (lambda: Returns(np.array([0.0, np.inf])), "finite"),
        (lambda: Returns(np.array([1j, 0.0])), "finite"),
        (lambda: Returns(np.array(["0", "1"])), "finite"),
        (Raises, "runs"),
        (MovesDiagnostics, "diagnostics"),
        (WrongLedger, "ledger"),
        (ArrayInLedger, "ledger"),
        (NegativeCount, "operations"),
    ],
)
def test_each_broken_controller_is_found_out(recorded, law, check):
    """Deliberately broken in one way each; the finding has a line for its author."""
    findings = check_controller(law, *recorded)
    assert check in broken(findings)
    assert all(finding.detail and "\n" not in finding.detail for finding in findings if not finding.passed)


def test_one_fault_does_not_hide_as_another(recorded):
    """Who keeps an input repeats himself perfectly in the same buffers."""
    assert broken(check_controller(KeepsAnInput, *recorded)) == {"keeps no input"}
    assert broken(check_controller(Shares, *recorded)) == {"repeats beside another instance"}


def test_the_first_differing_tick_is_named(recorded):
    """Where to start looking."""
    found = {finding.check: finding.detail for finding in check_controller(Remembers, *recorded)}
    assert found["repeats after reset"].startswith("differs from tick 0 on, by up to")


def test_a_declared_carry_over_is_not_held_against_a_controller(recorded):
    """It forgets only what it does not declare; fresh instances still agree."""
    findings = check_controller(CarriesOver, *recorded)
    assert not broken(findings)
    assert "repeats after reset" not in {finding.check for finding in findings}


def test_a_refusal_is_no_fault(recorded):
    """A controller may say what it is not made for."""
    (finding,) = check_controller(Refuses, *recorded)
    assert finding.passed
    assert "needs seven joints, the arm has 2" in finding.detail


def test_an_object_from_code_is_checked_alone(recorded):
    """There is no second one to put beside it."""
    only = Sound()
    checks = {finding.check for finding in check_controller(lambda: only, *recorded)}
    assert "repeats after reset" in checks
    assert "repeats beside another instance" not in checks


def test_what_was_recorded_is_left_as_it_was(recorded):
    """The checks themselves change no input either, and hand out no array of the recording."""
    task, observations, targets = recorded
    before = [observation.q.copy() for observation in observations]
    check_controller(ForcesTarget, task, observations, targets)
    assert all(np.array_equal(kept, now.q) for kept, now in zip(before, observations, strict=True))
    assert all(target.q.any() for target in targets)


def test_every_instance_is_closed(recorded):
    """Also one whose closing fails."""
    opened = []

    class Holds(Sound):
        def __init__(self):
            opened.append(self)

        def close(self):
            opened.remove(self)
            raise RuntimeError("late")

    check_controller(Holds, *recorded)
    assert not opened
