"""Physical things that the tests of this room measure: paths that a tool follows, an arm that moves, a grid of runs."""

from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest
from torquebench.evaluation import RunRow


@dataclass(frozen=True)
class Path:
    """A closed path flown at 1 kHz for whole laps, with the analytic velocity."""

    shape: str
    radius: float
    period: float
    laps: int = 1
    dt: float = 1e-3

    @property
    def t(self):
        return np.arange(round(self.laps * self.period / self.dt)) * self.dt

    def at(self, t):
        angle = 2.0 * np.pi * np.asarray(t) / self.period
        if self.shape == "circle":
            return self.radius * np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
        return self.radius * np.stack([np.sin(angle), 0.5 * np.sin(2.0 * angle), np.zeros_like(angle)], axis=1)

    def velocity(self, t):
        rate = 2.0 * np.pi / self.period
        angle = rate * np.asarray(t)
        if self.shape == "circle":
            return self.radius * rate * np.stack([-np.sin(angle), np.cos(angle), np.zeros_like(angle)], axis=1)
        return self.radius * rate * np.stack([np.cos(angle), np.cos(2.0 * angle), np.zeros_like(angle)], axis=1)

    def followed_with(self, *, delay=0.0, scale=1.0):
        """A tool that is late by ``delay`` and flies the path ``scale`` times as large."""
        velocity = self.velocity(self.t)
        return SimpleNamespace(
            t=self.t,
            dt=self.dt,
            lap=self.period,
            p=scale * self.at(self.t - delay),
            p_ref=self.at(self.t),
            twist_ref=np.hstack([velocity, np.zeros_like(velocity)]),
        )


@pytest.fixture(scope="session")
def circle():
    """The circle of the oracles: radius 0.14 m, one lap in 4 s."""
    return Path("circle", 0.14, 4.0)


@pytest.fixture(scope="session")
def fast_circle():
    """The paper's fast circle: radius 0.14 m, one lap in 2 s."""
    return Path("circle", 0.14, 2.0)


@pytest.fixture(scope="session")
def eight():
    """A figure that crosses itself at its middle."""
    return Path("eight", 0.14, 4.0)


@pytest.fixture(scope="session")
def arm():
    """Return a maker of complete logs: an arm of any number of joints, a second of lead-in, laps of 1 s."""

    def make(joints=7, laps=3, seed=0):
        rng = np.random.default_rng(seed)
        path = Path("circle", 0.14, 1.0)
        t = np.arange(-1000, 1000 * laps) * path.dt
        phase = rng.uniform(0.0, 6.0, joints)
        q_ref = 0.4 * np.sin(2.0 * np.pi * t[:, None] + phase)
        noise = rng.normal(size=(len(t), joints))
        tau = 20.0 * np.cos(2.0 * np.pi * t[:, None] + phase) + 0.1 * noise
        quat = rng.normal(size=(len(t), 4))
        quat /= np.linalg.norm(quat, axis=1, keepdims=True)
        velocity = path.velocity(t)
        return SimpleNamespace(
            t=t,
            q=0.4 * np.sin(2.0 * np.pi * (t[:, None] - 0.02) + phase) + 1e-4 * noise,
            dq=2.5 * np.cos(2.0 * np.pi * t[:, None] + phase),
            q_ref=q_ref,
            dq_ref=2.51 * np.cos(2.0 * np.pi * t[:, None] + phase),
            tau_cmd=tau,
            tau_lim=tau,
            tau=tau,
            p=0.99 * path.at(t - 0.02),
            p_ref=path.at(t),
            quat=quat,
            quat_ref=np.roll(quat, 1, axis=0),
            twist=np.hstack([(0.99 + 0.05 * np.sin(9.0 * t))[:, None] * path.velocity(t), np.zeros_like(velocity)]),
            twist_ref=np.hstack([velocity, np.zeros_like(velocity)]),
            dt=path.dt,
            lap=path.period,
            mass=2.5,
            effort=np.full(joints, 15.0),
            torque_rate=np.full(joints, 8000.0),
            velocity=np.full(joints, 2.0),
            lower=np.full(joints, -2.0),
            upper=np.full(joints, 2.0),
        )

    return make


@dataclass(frozen=True)
class Grid:
    """A run table in the making: every controller on the same trajectories, masses and repetitions."""

    trajectories: tuple[str, ...] = tuple(f"T{i}" for i in range(1, 9))
    masses: tuple[float, ...] = (1.5, 2.5)
    repetitions: int = 2
    metric: str = "tcp_position_error_mean"
    rows: tuple[RunRow, ...] = field(default=())

    def of(self, controller, error):
        """Add the runs of a controller; ``error(trajectory, mass, repetition)`` is a value, ``failed``, ``refused``."""
        new = [
            self.row(controller, trajectory, mass, repetition, error(trajectory, mass, repetition))
            for trajectory in self.trajectories
            for mass in self.masses
            for repetition in range(self.repetitions)
        ]
        return replace(self, rows=(*self.rows, *new))

    def row(self, controller, trajectory, mass, repetition, outcome, *, status="ok"):
        stopped = outcome in ("failed", "refused")
        value = {"value": float("nan") if stopped else outcome, "status": status, "unit": "m"}
        return RunRow(
            controller=controller,
            trajectory=trajectory,
            group="fast" if trajectory in ("T6", "T7", "T8") else "slow",
            mass=mass,
            material="sand" if mass > 1.5 else "",
            repetition=repetition,
            status=outcome if stopped else "ok",
            metrics={} if stopped else {"run": {self.metric: value}},
        )


@pytest.fixture(scope="session")
def grid():
    """An empty table over eight trajectories, two masses, two repetitions."""
    return Grid()
