"""How well the cerebellum knows gravity, on postures that training did not see."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ...controllers import RobotModel
from ..cerebellum import Cerebellum
from ..pathways import Ascending, Descending
from ..patterns import Patterns


@dataclass(frozen=True, kw_only=True)
class GravityError:
    """Error of one pattern on one group of postures.

    Attributes:
        group: Name of a path, or of another group.
        load: Load beyond the gripper [kg].
        rmse: Root of the mean square over postures and joints [N m].
        worst_joint: The joint with the largest root mean square, counted from 1.
        worst_rmse: Its root mean square over postures [N m].
    """

    group: str
    load: float
    rmse: float
    worst_joint: int
    worst_rmse: float


def gravity_heldout(
    patterns: Patterns, model: RobotModel, payloads: np.ndarray, groups: Mapping[str, np.ndarray]
) -> tuple[GravityError, ...]:
    """Compare the cerebellum with the model's gravity, for each group of postures and each pattern.

    Args:
        patterns: The patterns.
        model: Arm and gripper; it is copied.
        payloads: Parameters of each pattern's load (see :attr:`RobotModel.payload`), shape (P, 10).
        groups: Postures by name, each of shape (N, n) [rad]: paths, random postures.

    Returns:
        A row for each group and pattern.
    """
    rows = []
    for name, q in groups.items():
        said = answers(patterns, q)
        for index, (load, payload) in enumerate(zip(patterns.loads, payloads, strict=True)):
            square = np.mean((said[:, index] - gravity_torques(model, q, payload)) ** 2, axis=0)
            worst = int(square.argmax())
            rows.append(
                GravityError(
                    group=name,
                    load=load,
                    rmse=float(np.sqrt(square.mean())),
                    worst_joint=worst + 1,
                    worst_rmse=float(np.sqrt(square[worst])),
                )
            )
    return tuple(rows)


def gravity_torques(model: RobotModel, q: Iterable[np.ndarray], payload: np.ndarray) -> np.ndarray:
    """Return the gravity torque of many postures under a load, shape (N, n) [N m].

    Args:
        model: Arm and gripper; it is copied.
        q: Joint positions, shape (N, n) [rad].
        payload: Parameters of the load, shape (10,).
    """
    loaded = model.copy()
    loaded.set_payload(payload)
    return np.array([loaded.gravity(row) for row in q])


def answers(patterns: Patterns, q: np.ndarray) -> np.ndarray:
    """Return what the cerebellum answers to many postures, shape (N, P, n) [N m].

    Args:
        patterns: What it learnt.
        q: Joint positions, shape (N, n) [rad].
    """
    up, down = Ascending.of(patterns.joints), Descending.of(patterns.joints, patterns.count)
    cerebellum = Cerebellum(patterns)
    cerebellum.connect(up, down)
    said = np.empty((len(q), patterns.count, patterns.joints))
    for row, posture in zip(said, q, strict=True):
        np.copyto(up.q, posture)
        cerebellum.compensate()
        np.copyto(row, down.compensation)
    return said
