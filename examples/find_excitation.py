"""Finds the coefficients of the motion `excitation`: `python examples/find_excitation.py` prints them.

Draws smooth closed motions of the tool, ranks them by how well a force sensor would see the ten parameters of a load
in one lap, and takes the first that an arm can follow within its limits. No controller and no estimator takes part.
"""

import numpy as np
from torquebench.scenarios.loads import Payload
from torquebench.scenarios.robots import load_robot
from torquebench.scenarios.trajectories.kinematics import solve_lap
from torquebench.scenarios.trajectories.turning import TurningPath

SEED, DRAWS, PERIOD = 1, 2000, 5.0
CENTRE = (0.54, 0.0, 0.45)
REACH = np.array([[0.05], [0.03]]) * np.ones(3)
"""Spread of the point's harmonics [m]."""
TURN = np.array([1.0, 0.5, 0.35])[:, None] * np.array([0.12, 0.12, 0.3])
"""Spread of the harmonics of roll, pitch and yaw [rad]."""
LIMITS = {"margin": 0.2, "speed": 0.6, "torque": 0.8}
"""Least distance to a position limit [rad]; largest shares of the velocity and of the torque limits."""
NOISE = np.array([0.2] * 3 + [0.02] * 3)
"""What a reading is worth [N, N m]."""
SPREAD = np.array([2.0] + [0.2] * 3 + [0.02] * 6)
"""What is not known of a load: mass, first moments, inertia [kg, kg m, kg m^2]."""


def drawn(rng):
    """Return a random motion, rounded to what is printed."""

    def coefficients(spread):
        return tuple(tuple(np.round(row, 4).tolist()) for row in rng.normal(scale=spread))

    harmonics = {"cosine": coefficients(REACH), "sine": coefficients(REACH)}
    turns = {"turn_cosine": coefficients(TURN), "turn_sine": coefficients(TURN)}
    return TurningPath(name="excitation", group="excitation", period=PERIOD, centre=CENTRE, **harmonics, **turns)


def worst_deviation(path, flange):
    """Return the largest standard deviation of a parameter after one lap, in its spreads, bias unknown.

    Args:
        path: The motion.
        flange: The flange's place in tool axes, whose axes are parallel, shape (3,) [m].
    """
    t = np.linspace(0.0, PERIOD, 200, endpoint=False)
    axes, twist, growth = path.pose(t)[:, :3, :3], path.twist(t), path.acceleration(t)
    w, alpha = (np.einsum("kji,kj->ki", axes, part[:, 3:]) for part in (twist, growth))
    a = np.einsum("kji,kj->ki", axes, growth[:, :3] + [0.0, 0.0, 9.81])
    a = a + np.cross(alpha, flange) + np.cross(w, np.cross(w, flange))
    rows = np.concatenate([regressor(*each) for each in zip(a, w, alpha, strict=True)])
    rows = rows * np.tile(1.0 / NOISE, len(t))[:, None] * np.concatenate([SPREAD, NOISE])
    information = rows.T @ rows * (PERIOD * 1000.0 / len(t))
    return np.sqrt(np.linalg.inv(information)[:10, :10].diagonal().max())


def regressor(a, w, alpha):
    """Return what a unit of each parameter and of the bias adds to a reading, shape (6, 16)."""
    out = np.zeros((6, 16))
    out[:3, 0] = a
    out[:3, 1:4] = cross_matrix(alpha) + cross_matrix(w) @ cross_matrix(w)
    out[3:, 1:4] = -cross_matrix(a)
    for column, (i, j) in enumerate([(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)]):
        unit = np.zeros((3, 3))
        unit[i, j] = unit[j, i] = 1.0
        out[3:, 4 + column] = unit @ alpha + np.cross(w, unit @ w)
    out[:, 10:] = np.eye(6)
    return out


def cross_matrix(v):
    """Return the matrix of a cross product from the left."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def shares(robot, lap):
    """Return margin to the position limits [rad] and the largest shares of speed and torque, 3.5 kg carried."""
    model = robot.model(rotor_inertia=robot.rotor_inertia)
    model.set_payload(sum(body.parameters for body in Payload(mass=3.5, material="sand").bodies(robot)))
    torque = np.array([model.inverse_dynamics(*row).copy() for row in zip(lap.q, lap.dq, lap.ddq, strict=True)])
    return {
        "margin": np.minimum(lap.q - robot.lower, robot.upper - lap.q).min(),
        "speed": np.abs(lap.dq / robot.velocity).max(),
        "torque": np.abs(torque / robot.effort).max(),
    }


def main():
    """Print the best motion that can be followed."""
    robot, rng = load_robot("rizon4s"), np.random.default_rng(SEED)
    model = robot.model()
    pose, flange = model.forward_kinematics(robot.home), model.flange_pose(robot.home)
    offset = pose[:3, :3].T @ (flange[:3, 3] - pose[:3, 3])
    paths = [drawn(rng) for _ in range(DRAWS)]
    ranked = sorted((worst_deviation(path, offset), number) for number, path in enumerate(paths))
    for deviation, number in ranked:
        found = shares(robot, solve_lap(model, paths[number], home=robot.home, step=0.005))
        fits = found["margin"] >= LIMITS["margin"] and all(found[key] <= LIMITS[key] for key in ("speed", "torque"))
        print(f"draw {number}: deviation {deviation:.2g}, " + ", ".join(f"{k} {v:.2f}" for k, v in found.items()))
        if fits:
            print(paths[number])
            return


if __name__ == "__main__":
    main()
