r"""What elastic joints do to a damping law, linearised: refuses an unstable pair before it runs.

At the frequency where a stiff damping loop would ring, the springs part the motors from links and load. A law that
scales its damping with the load's inertia then acts on the rotors alone, so the mass matrix of the whole arm, which
judges laws on a rigid one, says nothing here. What does is the loop itself: links, springs, rotors, torque loop, delay
and velocity filter, at one posture, without friction, Coriolis forces and gravity.
"""

import numpy as np

from ..controllers import InvalidInput, Refusal
from ..controllers.controller import DesignInertia
from .elasticity import Elasticity
from .tiers import Tier

ROUNDING = 1e-6
"""What a free position's eigenvalue, 1 exactly, may come out above it."""


def check_springs(design: DesignInertia | None, tier: Tier, mass_matrix: np.ndarray) -> None:
    """Refuse a law whose damping alone is unstable on elastic joints; on other tiers there is nothing to refuse.

    Args:
        design: What the controller declares, or None.
        tier: The tier.
        mass_matrix: Inertia of links, load and apparent rotors, shape (n, n) [kg m^2].

    Raises:
        Refusal: If the loop grows; names by how much a tick, and the frequency.
    """
    if design is None or tier.elasticity is None:
        return
    links = mass_matrix - np.diag(tier.rotor_inertia)
    loop = damping_loop(tier, tier.elasticity, links, design.damping * design.mass_matrix)
    modes = np.linalg.eigvals(loop)
    fastest = modes[np.argmax(np.abs(modes))]
    growth, frequency = abs(fastest), abs(np.angle(fastest)) / (2.0 * np.pi * tier.period)
    if not growth <= 1.0 + ROUNDING:
        raise Refusal(
            f"its damping excites the elastic joints: a motion at {frequency:.0f} Hz grows by a factor of "
            f"{growth:.3g} a tick, stable below 1"
        )


def check_substeps(tier: Tier, mass_matrix: np.ndarray) -> None:
    """Refuse a tier whose integration step is too long for its own springs.

    Args:
        tier: The tier; without elastic joints there is nothing to refuse.
        mass_matrix: Inertia of links, gripper and apparent rotors, shape (n, n) [kg m^2]; a load only steadies.

    Raises:
        InvalidInput: If links, springs and torque loop grow by themselves.
    """
    joints, links = tier.elasticity, mass_matrix - np.diag(tier.rotor_inertia)
    if joints is None or _is_steady(joints, tier.step, links):
        return
    counts = (joints.substeps * 2**doublings for doublings in range(1, 10))
    enough = next((count for count in counts if _is_steady(joints, tier.period / count, links)), None)
    valid = "give softer springs" if enough is None else f"give substeps = {enough}"
    raise InvalidInput(f"its springs grow unstable with substeps = {joints.substeps}", f"tier {tier.name!r}", valid)


def _is_steady(joints: Elasticity, step: float, links: np.ndarray) -> bool:
    """Return whether an arm left to itself does not grow from one integration step to the next."""
    n = links.shape[0]
    turn = np.vstack(_turn(np.split(np.eye(5 * n), 5), np.zeros((n, 5 * n)), joints, step, links))
    return bool(np.max(np.abs(np.linalg.eigvals(turn))) <= 1.0 + ROUNDING)


def damping_loop(tier: Tier, joints: Elasticity, links: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """Return the matrix that one tick of tau = -B dq multiplies the state with.

    The state: link positions and velocities, motor positions and velocities, currents, the motor positions of the tick
    before, filtered velocities, commands under way; n numbers each.

    Args:
        tier: Delay and velocity filter.
        joints: Its elastic joints.
        links: Inertia of links and load, shape (n, n) [kg m^2].
        damping: B, shape (n, n) [N m s/rad].

    Returns:
        Shape (m, m) with m = (7 + delay) n.
    """
    n, parts = links.shape[0], 7 + tier.delay_ticks
    state = np.split(np.eye(parts * n), parts)
    arm, (before, filtered), under_way = state[:5], state[5:7], state[7:]
    theta, corner = arm[2], tier.velocity_filter_hz
    share = 1.0 if corner is None else 1.0 - float(np.exp(-2.0 * np.pi * corner * tier.period))
    filtered = filtered + share * ((theta - before) / tier.period - filtered)
    *under_way, asked = [-damping @ filtered, *under_way]
    for _ in range(joints.substeps):
        arm = _turn(arm, asked, joints, tier.step, links)
    return np.vstack([*arm, theta, filtered, *under_way])


def _turn(
    state: list[np.ndarray], asked: np.ndarray, joints: Elasticity, step: float, links: np.ndarray
) -> list[np.ndarray]:
    """Return positions, velocities and currents after one integration step; columns are independent motions."""
    q, dq, theta, dtheta, current = state
    stiffness, damping, inertia = (row[:, None] for row in (joints.stiffness, joints.damping, joints.motor_inertia))
    slip = dtheta - dq
    spring = stiffness * (theta - q) + damping * slip
    wanted = asked + joints.torque_gain * (asked - spring) - (joints.rate_gain[:, None] * stiffness) * slip
    current = current + joints.current_share(step) * (wanted - current)
    dtheta = dtheta + step * (current - spring) / inertia
    dq = dq + step * np.linalg.solve(links, spring)
    return [q + step * dq, dq, theta + step * dtheta, dtheta, current]
