"""The plant on PyBullet, with every trap closed that makes its arm differ from the equations.

Bullet recomputes inertia from shapes, damps every body, clamps joint speeds, keeps velocity motors on and lends a
bare link one kilogram unless told otherwise; the robot's simulator URDF and :func:`_disarm` tell it. It has no rotor
inertia: the torque sent is ``tau - A a`` with a from Pinocchio, which makes ``M a + h = tau - A a`` exact.
"""

import ctypes
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import numba
import numpy as np

from ...controllers import InvalidInput
from ...controllers.kernels import bind
from ..axes import principal_axes
from ..body import Body
from ..liquid import Liquid
from ..robots import Robot, slosh_names, slot_name
from ..tiers import Tier
from .plant import Plant


class PyBulletPlant(Plant):
    """The arm in PyBullet, direct mode, torque controlled."""

    name = "pybullet"

    def __init__(self, robot: Robot, tier: Tier, slots: Sequence[Body] = ()) -> None:
        """Load the arm into a simulator of its own.

        Raises:
            InvalidInput: If PyBullet is not installed; it has no wheel for Python 3.12 and later.
        """
        self.bullet = load_pybullet()
        self.client = self.bullet.connect(self.bullet.DIRECT)
        self._load(robot, tier, slots)
        super().__init__(robot, tier, slots)
        self._sent = np.zeros(self.model.nv)
        self._shape = bind(_less_rotor_torque, self._drive, self._armature, self._ddq, self._sent)

    def _load(self, robot: Robot, tier: Tier, slots: Sequence[Body]) -> None:
        """Set up the world and find the links of the moving joints and of the slots."""
        bullet, client = self.bullet, self.client
        bullet.resetSimulation(physicsClientId=client)
        bullet.setGravity(0.0, 0.0, -9.81, physicsClientId=client)
        bullet.setTimeStep(tier.step, physicsClientId=client)
        # Bullet caches URDF files by name: the folder's unique name keeps two robots of one process apart.
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "arm.urdf"
            path.write_text(robot.simulator_urdf(slots), encoding="utf-8")
            with _quiet():
                self.body = bullet.loadURDF(
                    str(path), useFixedBase=True, flags=bullet.URDF_USE_INERTIA_FROM_FILE, physicsClientId=client
                )
        count = bullet.getNumJoints(self.body, physicsClientId=client)
        infos = [bullet.getJointInfo(self.body, i, physicsClientId=client) for i in range(count)]
        links = {info[1].decode(): i for i, info in enumerate(infos)}
        sloshing = [slosh_names(i) for i, body in enumerate(slots) if isinstance(body, Liquid)]
        self.joints = [links[name] for name in (*robot.joint_names, *(name for pair in sloshing for name in pair))]
        slot_links = {info[12].decode(): i for i, info in enumerate(infos)}
        self._slot_links = [slot_links[slot_name(i)] for i in range(len(slots))]
        # Not read back: Bullet loads a liquid's core, which is no body by itself, with moments of zero.
        self._slot_inertias = [(body.rigid.mass, principal_axes(body.rigid.inertia)[0].tolist()) for body in slots]
        self._disarm(count)

    def _disarm(self, count: int) -> None:
        """Switch off motors, damping and speed clamps."""
        bullet, client = self.bullet, self.client
        bullet.setJointMotorControlArray(
            self.body, self.joints, bullet.VELOCITY_CONTROL, forces=[0.0] * len(self.joints), physicsClientId=client
        )
        for link in range(-1, count):
            bullet.changeDynamics(self.body, link, linearDamping=0.0, angularDamping=0.0, physicsClientId=client)
        for joint in self.joints:
            bullet.changeDynamics(self.body, joint, jointDamping=0.0, maxJointVelocity=1e4, physicsClientId=client)

    def set_load(self, active: Sequence[bool]) -> None:
        """Switch the slots in both models; Bullet needs mass and inertia in one call."""
        super().set_load(active)
        for on, link, (mass, inertia) in zip(active, self._slot_links, self._slot_inertias, strict=True):
            self._weigh(link, mass if on else 0.0, inertia if on else [0.0, 0.0, 0.0])
        for pendulum in self.pendulums:
            # Bullet holds a joint that carries nothing, so an idle pendulum needs no inertia of its own here.
            link = self.joints[pendulum.joints.stop - 1]
            self._weigh(link, pendulum.liquid.bob_mass if pendulum.active else 0.0, [0.0, 0.0, 0.0])
            self._place(pendulum.joints)

    def _weigh(self, link: int, mass: float, inertia: list[float]) -> None:
        """Give a link a mass and principal moments."""
        self.bullet.changeDynamics(
            self.body, link, mass=mass, localInertiaDiagonal=inertia, physicsClientId=self.client
        )

    def reset(self, q: np.ndarray, dq: np.ndarray, *, slosh: tuple[np.ndarray, np.ndarray] | None = None) -> None:
        """Place the arm; position and velocity are its complete state."""
        super().reset(q, dq, slosh=slosh)
        self._place(slice(None))

    def _place(self, which: slice) -> None:
        """Place joints where the model has them."""
        states = (self.joints[which], self.positions[which].tolist(), self.velocities[which].tolist())
        for joint, position, velocity in zip(*states, strict=True):
            self.bullet.resetJointState(
                self.body, joint, targetValue=position, targetVelocity=velocity, physicsClientId=self.client
            )

    def _integrate(self) -> None:
        bullet, client, body, joints = self.bullet, self.client, self.body, self.joints
        self._shape()
        # A torque lasts one step only, so it is sent every step.
        bullet.setJointMotorControlArray(
            body, joints, bullet.TORQUE_CONTROL, forces=self._sent.tolist(), physicsClientId=client
        )
        bullet.stepSimulation(physicsClientId=client)
        q, dq = self.positions, self.velocities
        for i, joint in enumerate(bullet.getJointStates(body, joints, physicsClientId=client)):
            q[i], dq[i] = joint[0], joint[1]

    def close(self) -> None:
        """Disconnect the simulator."""
        if self.bullet.isConnected(self.client):
            self.bullet.disconnect(self.client)


@numba.njit(cache=True)
def _less_rotor_torque(drive, armature, ddq, sent):  # type: ignore[no-untyped-def]
    """Take from the torque what accelerates rotors and friction's slope, which Bullet does not know of."""
    for i in range(drive.shape[0]):
        sent[i] = drive[i] - armature[i] * ddq[i]


def load_pybullet() -> ModuleType:
    """Import PyBullet without its greeting.

    Raises:
        InvalidInput: If it is not installed.
    """
    if "pybullet" in sys.modules:
        return sys.modules["pybullet"]
    try:
        with _quiet():
            import pybullet
    except ImportError as cause:
        raise InvalidInput(
            f"PyBullet is not installed (Python {sys.version_info.major}.{sys.version_info.minor})",
            "plant 'pybullet'",
            "it has wheels up to Python 3.11; use --plant pinocchio, which computes the same equations",
        ) from cause
    module: ModuleType = pybullet
    return module


@contextmanager
def _quiet() -> Iterator[None]:
    """Send what C code prints to nowhere: Bullet greets on import and comments on every file."""
    flush = ctypes.CDLL(None).fflush
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [(descriptor, os.dup(descriptor)) for descriptor in (1, 2)]
    with open(os.devnull, "w", encoding="utf-8") as nowhere:
        for descriptor, _ in kept:
            os.dup2(nowhere.fileno(), descriptor)
        try:
            yield
        finally:
            # C buffers on its own: what it still holds would come out at the end of the process.
            flush(None)
            for descriptor, copy in kept:
                os.dup2(copy, descriptor)
                os.close(copy)
