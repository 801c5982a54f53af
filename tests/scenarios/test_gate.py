"""The gate: what a plant must prove, and that it would find out one that cannot."""

import numpy as np
import pinocchio as pin
import pytest
from torquebench.controllers import TorquebenchError, UnknownName, discovery
from torquebench.scenarios.gate import CHECKS, GateCheck, GateFailure, require, run_gate
from torquebench.scenarios.gate_liquid import LIQUID_CHECKS
from torquebench.scenarios.plants.pinocchio_plant import PinocchioPlant

ALLOWED = {
    "mass matrix, kg m^2": 1e-12,
    "inverse dynamics, N m": 1e-11,
    "one step against forward dynamics, relative": 1e-12,
    "position update, rad": 1e-15,
    "load on and off against a rebuilt model, relative": 1e-12,
    "replay from reset, reload and (q, dq), bitwise": 0.0,
    "force reading at rest, N": 1e-9,
    "one step with water against forward dynamics, relative": 1e-12,
    "water held at rest against frozen water, N m": 1e-11,
    "water in and out against rebuilt models, relative": 1e-12,
    "replay with water from its whole state, bitwise": 0.0,
    "force reading of water at rest, N": 1e-9,
    "a period with elastic joints, relative": 1e-11,
}


def test_the_rizon_passes_on_every_plant_over_two_hundred_states(rizon, plant_name):
    """F1 to F6, F8 and F9 with the tolerances of the tests, none of them loosened."""
    checks = run_gate(rizon, plant_name, states=200)
    for check in checks:
        assert check.allowed == ALLOWED[check.name]
        assert check.deviation <= ALLOWED[check.name], check
    require(checks)


def test_pybullet_is_asked_for_its_own_mass_matrix_too(rizon, has_pybullet):
    """Two checks more; the Pinocchio plant has no second opinion on F1."""
    assert {check.name for check in run_gate(rizon, "pybullet", states=2)} == set(ALLOWED)
    assert len(run_gate(rizon, "pinocchio", states=2)) == len(CHECKS) + len(LIQUID_CHECKS)


def test_an_arm_of_two_joints_passes_as_well(planar_robot, plant_name):
    """The gate is for any arm, without gripper too."""
    require(run_gate(planar_robot, plant_name, states=10))


class Explicit(PinocchioPlant):
    """Moves with the old velocity."""

    def _integrate(self):
        self.positions += self.tier.period * self.velocities
        self.velocities += self.tier.period * self._ddq


class Lighter(PinocchioPlant):
    """Loses a part in ten thousand of gravity's work."""

    def _integrate(self):
        self._ddq *= 1.0 - 1e-4
        super()._integrate()


class Sticky(PinocchioPlant):
    """Keeps its first load."""

    loaded = False

    def set_load(self, active):
        if not self.loaded or not any(active):
            super().set_load(active)
        self.loaded = any(active)


class Frozen(PinocchioPlant):
    """Carries water as if it were ice."""

    def step(self, torque):
        for pendulum in self.pendulums:
            self.velocities[pendulum.joints] = 0.0
        super().step(torque)


class Adrift(PinocchioPlant):
    """Forgets how fast the water moved when it is placed again."""

    def reset(self, q, dq, *, slosh=None):
        super().reset(q, dq, slosh=slosh and (slosh[0], np.zeros_like(slosh[1])))


class Spilled(PinocchioPlant):
    """Keeps the bob of water that was taken away."""

    def set_load(self, active):
        super().set_load(active)
        for pendulum in self.pendulums:
            active = pendulum.active
            pendulum.switch(self.model, active=True, step=self.tier.period)
            pendulum.active = active


class Deaf(PinocchioPlant):
    """Does not feel the bob."""

    def measure_wrench(self):
        self._measure()


class TopHeavy(PinocchioPlant):
    """Hangs the bob a millimetre too high."""

    def set_load(self, active):
        super().set_load(active)
        if self.pendulums:
            bob = self.model.inertias[self.model.njoints - 1]
            self.model.inertias[self.model.njoints - 1] = pin.Inertia(bob.mass, bob.lever - [0, 0, 1e-3], bob.inertia)


class Drifting(PinocchioPlant):
    """Remembers how often it was used."""

    steps = 0

    def _integrate(self):
        Drifting.steps += 1
        super()._integrate()
        self.dq += 1e-16 * Drifting.steps


class Unhurried(PinocchioPlant):
    """Leaves out the last substep of a period."""

    def step(self, torque):
        self._is_last = (*(False,) * (self.tier.substeps - 2), True) if self.tier.substeps > 1 else (True,)
        super().step(torque)


class Upside(PinocchioPlant):
    """Reports what the arm exerts on the load, not what the load exerts on the arm."""

    def measure_wrench(self):
        super().measure_wrench()
        self.wrench *= -1.0


@pytest.mark.parametrize(
    ("wrong", "check"),
    [
        (Explicit, "position update, rad"),
        (Lighter, "one step against forward dynamics, relative"),
        (Sticky, "load on and off against a rebuilt model, relative"),
        (Drifting, "replay from reset, reload and (q, dq), bitwise"),
        (Upside, "force reading at rest, N"),
        (Frozen, "one step with water against forward dynamics, relative"),
        (TopHeavy, "water held at rest against frozen water, N m"),
        (Spilled, "water in and out against rebuilt models, relative"),
        (Adrift, "replay with water from its whole state, bitwise"),
        (Deaf, "force reading of water at rest, N"),
        (Unhurried, "a period with elastic joints, relative"),
    ],
)
def test_each_check_finds_the_plant_that_it_is_for(rizon, monkeypatch, wrong, check):
    """A gate that lets everything through is no gate; the failure carries the check and its figure."""
    load = discovery.load
    monkeypatch.setattr(discovery, "load", lambda kind, name: wrong if kind == "plants" else load(kind, name))
    checks = run_gate(rizon, "pinocchio", states=8)
    assert check in {found.name for found in checks if not found.passed}
    with pytest.raises(GateFailure, match="the plant fails its gate") as caught:
        require(checks)
    assert check in {found.name for found in caught.value.checks}
    assert "\n" not in str(caught.value)


def test_a_deviation_that_is_not_a_number_fails():
    """NaN is not small."""
    nothing = GateCheck(name="x", plant="p", deviation=float("nan"), allowed=1.0)
    assert not nothing.passed
    with pytest.raises(TorquebenchError):
        require((nothing,))


def test_a_deviation_at_the_limit_passes():
    """Zero allowed, zero found."""
    assert GateCheck(name="x", plant="p", deviation=0.0, allowed=0.0).passed


def test_an_unknown_plant_names_the_nearest(rizon):
    """Before anything is built."""
    with pytest.raises(UnknownName, match="did you mean 'pinocchio'"):
        run_gate(rizon, "pinochio")


def test_the_gate_gives_the_same_figures_every_time(rizon):
    """They are stored with the runs."""
    first, second = (np.array([check.deviation for check in run_gate(rizon, "pinocchio", states=3)]) for _ in range(2))
    assert np.array_equal(first, second)
