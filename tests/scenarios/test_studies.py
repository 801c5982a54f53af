"""Studies in the harness: against the exact linear loop, and back to the single runs they are made of."""

from dataclasses import replace

import numpy as np
import pytest
from torquebench.controllers import InvalidInput, UnknownName
from torquebench.evaluation.loops import closed_loop
from torquebench.scenarios.execution import execute
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.perturbation import Perturbation
from torquebench.scenarios.result import Scores
from torquebench.scenarios.studies import Judges, LoopScores
from torquebench.scenarios.trace import decode_trace
from torquebench.scenarios.world import World

GRIPPER = LoadSchedule.constant(Payload(mass=1.186))


def nothing(log):
    """Score nothing."""
    return Scores(metrics={})


def keep(records):
    """Return the records themselves as arrays."""
    arrays = {"commands": records.commands, "injection": records.injection, "lines": records.lines}
    return LoopScores(metrics={"loops": {}}, arrays=arrays)


def grows(log):
    """Object to an arm that is further from rest at the end than at the start: the edge of linear stability."""
    error = np.linalg.norm(log.q - log.q_ref, axis=1)
    return "grows" if error[-400:].max() > error[:100].max() else ""


JUDGES = Judges(objection=grows, loops=keep)


@pytest.fixture
def study_of(run_of):
    """Builds the specification of a study of computed torque at rest with the bare gripper."""

    def build(**changes):
        settings = {"controller": "computed_torque", "trajectory": "hold", "schedule": GRIPPER}
        return run_of(**settings | changes)

    return build


def do(specification, judges=JUDGES, **options):
    """Return the one row of a study."""
    (row,) = execute(specification, evaluate=nothing, judges=judges, **options)
    return row


class Linear:
    """Computed torque about rest: x = (dq, dv), semi-implicit steps, gravity's gradient in law and plant."""

    def __init__(self, specification, bandwidth):
        from torquebench.baselines.gains import double_integrator_gains

        world = World(specification, specification.schedule)
        h, q = world.tier.period, world.table["q"][0]
        stiffness, damping = double_integrator_gains(bandwidth, h)
        mass, model, step = world.plant.mass_matrix(), world.task().robot, 1e-5
        moved = [(model.gravity(q + step * e) - model.gravity(q - step * e)) / (2 * step) for e in np.eye(7)]
        gradient, eye = np.stack(moved, axis=1), np.eye(7)
        pull = np.linalg.solve(mass, gradient)
        self.a = np.block([[eye - h * h * pull, h * eye], [-h * pull, eye]])
        self.b = np.vstack((h * h * np.linalg.inv(mass), h * np.linalg.inv(mass)))
        self.k = np.hstack((gradient - stiffness * mass, -damping * mass))
        self.period = h
        world.plant.close()

    def complementary(self, omega):
        """Return -u / w for a torque w added to the command, shape (F, 7, 7)."""
        z = np.exp(1j * omega * self.period)
        loop = self.a + self.b @ self.k
        return np.array([-self.k @ np.linalg.solve(zi * np.eye(14) - loop, self.b) for zi in z])

    def is_stable(self, delay):
        """Return whether the closed loop with a shift register of commands has its poles within the unit circle."""
        if delay == 0:
            return np.abs(np.linalg.eigvals(self.a + self.b @ self.k)).max() < 1.0
        size = 14 + 7 * delay
        loop = np.zeros((size, size))
        loop[:14, :14], loop[:14, 14:21] = self.a, self.b
        loop[14 : size - 7, 21:] = np.eye(7 * (delay - 1))
        loop[size - 7 :, :14] = self.k
        return np.abs(np.linalg.eigvals(loop)).max() < 1.0


def test_the_measured_loops_are_those_of_the_exact_linear_loop(study_of):
    """All 49 responses at all lines: a tick too many in the record would turn the phase by a degree per 3 Hz."""
    specification = study_of(study="loop_response", laps=3)
    kept = decode_trace(do(specification).trace)
    measured = closed_loop(kept["commands"], kept["injection"], kept["lines"])[-1]
    omega = 2.0 * np.pi * kept["lines"] / 4.0
    exact = Linear(specification, 20.0).complementary(omega)
    assert np.abs(measured - exact).max() < 0.02 * np.abs(exact).max()
    own = np.abs(np.diagonal(measured - exact, axis1=1, axis2=2))
    assert own.max() < 2e-3
    assert own[:, 6].max() < 2e-4


def test_a_delay_margin_by_bisection_is_that_of_the_spectral_radius(study_of):
    """The last delay with all poles inside the unit circle, to the tick."""
    specification = study_of(
        study="delay_margin", settings={"bandwidth": 80.0}, perturbation=Perturbation(offset=1e-3), laps=1
    )
    linear = Linear(specification, 80.0)
    stable = [delay for delay in range(1, 20) if linear.is_stable(delay)]
    entry = do(specification).metrics["margin"]["delay_margin"]
    assert (entry["value"], entry["status"]) == (pytest.approx(1e-3 * max(stable)), "ok")
    assert max(stable) == 8


def test_every_run_behind_a_margin_can_be_run_again(study_of):
    """As an ordinary perturbed run, with the outcome that the margin's row tells of."""
    specification = study_of(study="load_margin", trajectory="T6", laps=1)
    judges = replace(JUDGES, objection=lambda log: "")
    row = do(specification, judges)
    assert row.metrics["margin"]["load_margin"]["status"] == "ok"
    failed = [probe for probe in row.provenance["probes"] if not probe["passed"]][-1]
    again = replace(specification, study="", perturbation=Perturbation(**failed["perturbation"]))
    (result,) = execute(again, evaluate=nothing)
    assert (result.status, result.failed_at, result.reason) == ("failed", failed["failed_at"], failed["reason"])


def test_a_margin_without_an_end_is_a_bound(study_of):
    """Nothing failed up to the end of the grid: at least that."""
    entry = do(study_of(study="init_offset_margin", laps=1), replace(JUDGES, objection=lambda log: ""))
    value = entry.metrics["margin"]["init_offset_margin"]
    assert (value["value"], value["status"]) == (0.98, "censored")


def test_friction_that_is_not_there_has_no_margin(study_of):
    """Scaling nothing proves nothing."""
    row = do(study_of(study="friction_margin", laps=1), replace(JUDGES, objection=lambda log: ""))
    assert row.metrics["margin"]["friction_margin"]["status"] == "undefined"


def test_a_nominal_world_that_is_not_come_through_has_no_margin(study_of):
    """And its row says why."""
    row = do(study_of(study="gain_margin_up", laps=1), replace(JUDGES, objection=lambda log: "too far off"))
    value = row.metrics["margin"]["gain_margin_up"]
    assert value["status"] == "undefined"
    assert "too far off" in value["reason"]
    assert len(row.provenance["probes"]) == 1


def test_a_margin_of_a_controller_that_fails_is_a_failed_row(study_of):
    """It is no margin of 0."""
    row = do(study_of(study="load_margin", settings={"bandwidth": 20.0, "wrong": 1}))
    assert (row.status, row.cause) == ("failed", "exception")


def test_a_loop_study_of_a_controller_that_fails_says_at_which_joint(study_of):
    """One column of the matrix is missing then, and no bound can be had."""
    row = do(study_of(study="loop_response", laps=3, controller="torquebench.baselines.nowhere:Law"))
    assert row.status == "failed"
    assert "while joint 1 was excited" in row.reason


def test_a_study_is_made_of_single_runs(study_of):
    """Twins, chains and moving references have no place in it; each message says what would be valid."""
    with pytest.raises(UnknownName, match="did you mean 'load_margin'"):
        study_of(study="load_margn")
    with pytest.raises(InvalidInput, match="carried"):
        study_of(study="load_margin", protocol="carried")
    with pytest.raises(InvalidInput, match="needs the motion 'hold'"):
        study_of(study="loop_response", trajectory="T6", laps=3)
    with pytest.raises(InvalidInput, match="judges"):
        execute(study_of(study="load_margin"), evaluate=nothing)


def test_the_motion_at_rest_is_home_at_every_time(study_of):
    """Of any robot, before and after the start of the clock."""
    specification = study_of()
    world = World(specification, specification.schedule)
    assert np.abs(world.table["q"] - world.robot.home).max() < 1e-14
    assert not world.table["dq"].any() and not world.table["twist"].any()
    preview = world.plan.preview(np.array([-0.1, 17.3]))
    assert preview.q == pytest.approx(np.tile(world.robot.home, (2, 1)))
    world.plant.close()
