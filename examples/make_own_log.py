"""Makes own_log.csv: what a robot's recorder could have written, in its own names, units and clock.

A two-joint arm in a plane draws a circle three times, 25 ms late and 2 % too small, with a little noise; its clock
shows 2 s at the start.
"""

import sys
from pathlib import Path

import numpy as np

PERIOD, LAP, LAPS, START = 0.01, 2.0, 3, 2.0
RADIUS, CENTRE = 0.10, np.array([0.45, 0.10])
UPPER_ARM, FOREARM = 0.4, 0.3


def circle(time):
    """Return the tool's place in the plane, shape (N, 2) [m]."""
    angle = 2.0 * np.pi * time / LAP
    return CENTRE + RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def joints(place):
    """Return the joint positions, elbow up, shape (N, 2) [rad]."""
    x, y = place.T
    cosine = (x**2 + y**2 - UPPER_ARM**2 - FOREARM**2) / (2.0 * UPPER_ARM * FOREARM)
    elbow = np.arccos(cosine)
    shoulder = np.arctan2(y, x) - np.arctan2(FOREARM * np.sin(elbow), UPPER_ARM + FOREARM * np.cos(elbow))
    return np.stack([shoulder, elbow], axis=1)


def columns():
    """Return the columns by name, in the recorder's units: ms, degrees, millimetres, N m."""
    rng = np.random.default_rng(1)
    time = np.arange(round(LAPS * LAP / PERIOD) + 1) * PERIOD
    plan = circle(time)
    tool = CENTRE + 0.98 * (circle(time - 0.025) - CENTRE) + 1e-4 * rng.normal(size=plan.shape)
    found = {"clock_ms": 1e3 * (START + time)}
    for name, place in (("target", plan), ("actual", tool)):
        found |= {f"{name}_deg{i + 1}": column for i, column in enumerate(np.degrees(joints(place)).T)}
        found |= {f"{name}_{axis}_mm": column for axis, column in zip("xy", 1e3 * place.T, strict=True)}
        found[f"{name}_z_mm"] = np.full(len(time), 300.0)
    torque = 8.0 * np.cos(joints(tool)) + 0.05 * rng.normal(size=plan.shape)
    return found | {f"torque{i + 1}": column for i, column in enumerate(torque.T)}


def main(file):
    """Write the file."""
    found = columns()
    np.savetxt(file, np.column_stack(list(found.values())), "%.4f", ",", header=",".join(found), comments="")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_name("own_log.csv"))
