"""The benchmark's motions against the paper's formulas, written out again here."""

import numpy as np
import pytest
from torquebench.controllers import InvalidInput, UnknownName, discovery
from torquebench.scenarios.trajectories import HarmonicPath, circle, load_path, rotated_circle, suite, yz_circle

SIN, COS = np.sin, np.cos
TILT, TURN = np.pi / 6, np.pi / 3


def turned(x, y, angle):
    """Return plane coordinates turned about the origin."""
    return x * COS(angle) - y * SIN(angle), x * SIN(angle) + y * COS(angle)


def t8(w):
    """Return T7's circle turned by 60 degrees about the vertical through its centre."""
    x, y = turned(0.2 * COS(w) * COS(TILT), 0.2 * SIN(w), TURN)
    return 0.53 + x, -0.11 + y, 0.4 + 0.2 * COS(w) * SIN(TILT)


def slanted(w):
    """Return the circle of T3, T6 and S2, its plane falling away from the base by 30 degrees."""
    return 0.63 + 0.14 * COS(w) * COS(TILT), -0.11 + 0.14 * SIN(w), 0.3 - 0.14 * COS(w) * SIN(TILT)


def level(w):
    """Return the horizontal circle of T1 and S1."""
    return 0.54 + 0.14 * COS(w), 0.14 * SIN(w), 0.45 + 0.0 * w


def eight(x, y):
    """Return the figure of eight about a point at 0.3 m."""
    return lambda w: (x + 0.07 * SIN(2 * w), y + 0.14 * COS(w), 0.3 + 0.08 * SIN(w))


FORMULAS = {
    "T1": (4.0, level),
    "T2": (4.0, lambda w: (0.6 + 0.0 * w, 0.35 + 0.2 * SIN(w), 0.2 * COS(w))),
    "T3": (4.0, slanted),
    "T4": (4.0, eight(0.0, 0.61)),
    "T5": (3.0, eight(0.0, 0.61)),
    "T6": (2.0, slanted),
    "T7": (3.0, lambda w: (0.53 + 0.2 * COS(w) * COS(TILT), -0.11 + 0.2 * SIN(w), 0.4 + 0.2 * COS(w) * SIN(TILT))),
    "T8": (3.0, t8),
    "S1": (3.0, level),
    "S2": (3.0, slanted),
    "S3": (3.0, eight(0.61, 0.0)),
}
SPEED = {
    "T1": 0.220,
    "T2": 0.314,
    "T3": 0.220,
    "T4": 0.311,
    "T5": 0.415,
    "T6": 0.440,
    "T7": 0.419,
    "T8": 0.419,
    "S1": 0.293,
    "S2": 0.293,
    "S3": 0.415,
}
NAMES = pytest.mark.parametrize("name", FORMULAS)


@NAMES
def test_a_path_is_the_papers_formula(name):
    """Position by position, from the setting's symbols and not from the data file."""
    period, formula = FORMULAS[name]
    path = load_path(name)
    t = np.linspace(-period, 2 * period, 97)
    expected = np.stack(formula(2 * np.pi * t / period), axis=1)
    assert path.period == period
    assert np.allclose(path.pose(t)[:, :3, 3], expected, rtol=0, atol=1e-14)


@NAMES
def test_the_tool_points_down_at_a_fixed_yaw(name):
    """Home's orientation, throughout."""
    t = np.linspace(0, 4, 50)
    path = load_path(name)
    assert np.array_equal(path.pose(t)[:, :3, :3], np.tile(np.diag([-1.0, 1.0, -1.0]), (50, 1, 1)))
    assert not path.twist(t)[:, 3:].any()
    assert not path.acceleration(t)[:, 3:].any()


@NAMES
def test_twist_and_acceleration_are_the_derivatives_of_the_pose(name):
    """Central differences, fourth order: a slip in a sign or a factor would be a controller's error."""
    path, h = load_path(name), 1e-3
    t = np.linspace(0, path.period, 41)

    def slope(function):
        return (8 * (function(t + h) - function(t - h)) - (function(t + 2 * h) - function(t - 2 * h))) / (12 * h)

    assert np.allclose(path.twist(t)[:, :3], slope(lambda s: path.pose(s)[:, :3, 3]), rtol=0, atol=1e-9)
    assert np.allclose(path.acceleration(t), slope(path.twist), rtol=0, atol=1e-9)


@NAMES
def test_the_highest_speed_is_the_measured_one(name):
    """Three digits, so that slow and fast groups are what the report says."""
    path = load_path(name)
    speeds = np.linalg.norm(path.twist(np.arange(0, path.period, 1e-3))[:, :3], axis=1)
    assert speeds.max() == pytest.approx(SPEED[name], abs=6e-4)


def test_one_path_at_two_speeds_twice():
    """T3 and T6, T4 and T5: the clean contrast."""
    phase = np.linspace(0, 1, 30)
    for slow, fast in (("T3", "T6"), ("T4", "T5")):
        one, two = load_path(slow), load_path(fast)
        assert np.allclose(one.pose(phase * one.period), two.pose(phase * two.period), rtol=0, atol=1e-15)


def test_groups_follow_the_periods_of_the_setting():
    """T1 to T5 are slow, T6 to T8 fast; a figure of the paper says otherwise and contradicts its text."""
    groups = {name: load_path(name).group for name in FORMULAS}
    assert [groups[f"T{i}"] for i in range(1, 9)] == ["slow"] * 5 + ["fast"] * 3
    assert {groups[name] for name in ("S1", "S2", "S3")} == {"simulation"}


def test_every_path_of_the_suite_is_registered():
    """The data file, the functions and the entry points list the same eleven."""
    assert set(suite()) == set(FORMULAS)
    assert set(FORMULAS) <= set(discovery.names("trajectories"))
    assert list(suite()) == [f"T{i}" for i in range(1, 9)] + ["S1", "S2", "S3"]


def test_an_unknown_trajectory_is_named():
    """One line."""
    with pytest.raises(UnknownName, match="unknown trajectory 'T9'"):
        load_path("T9")


def test_a_path_comes_through_every_door(tmp_path):
    """A name, a file, an object, a function that returns one."""
    file = tmp_path / "mine.py"
    file.write_text(
        "from torquebench.scenarios.trajectories import circle\n"
        "def ring(): return circle(name='ring', period=2.0, centre=(0.5, 0.0, 0.4), radius=0.1)\n"
        "made = ring()\n"
    )
    ring = circle(name="ring", period=2.0, centre=(0.5, 0.0, 0.4), radius=0.1)
    assert load_path(ring) is ring
    assert load_path(f"{file}:ring") == ring
    assert load_path(f"{file}:made") == ring


class Ring(HarmonicPath):
    """A path to break."""


def ring(**changes):
    """Return a sound ring, or one with a slip."""
    settings = {"name": "ring", "period": 2.0, "centre": (0.5, 0.0, 0.4)}
    return Ring(**settings, cosine=((0.1, 0.0, 0.0),), sine=((0.0, 0.1, 0.0),), **changes)


@pytest.mark.parametrize(
    ("slip", "message"),
    [
        (
            {"twist": lambda path, t: 2.0 * HarmonicPath.twist(path, t)},
            r"twist\(t\) differs from the derivative of pose",
        ),
        (
            {"acceleration": lambda path, t: -HarmonicPath.acceleration(path, t)},
            r"acceleration\(t\) differs from the derivative of twist",
        ),
        ({"pose": lambda path, t: HarmonicPath.pose(path, 0.9 * t)}, r"pose\(t\) differs by .* after one period"),
        ({"pose": lambda path, t: HarmonicPath.pose(path, t)[:, :3]}, r"pose\(t\) gives shape \(512, 3, 4\)"),
        ({"twist": lambda path, t: np.full((len(t), 6), np.nan)}, r"twist\(t\) is not finite"),
        ({"pose": lambda path, t: 2.0 * HarmonicPath.pose(path, t)}, r"pose\(t\) holds a rotation that is none"),
    ],
)
def test_a_path_that_contradicts_itself_is_refused(slip, message):
    """A wrong derivative would pass as a controller's error for weeks."""
    wrong = type("Wrong", (Ring,), slip)
    path = wrong(**{name: getattr(ring(), name) for name in ("name", "period", "centre", "cosine", "sine")})
    with pytest.raises(InvalidInput, match=f"trajectory .*ring.*: {message}"):
        load_path(path)


def test_a_mirrored_tool_is_no_rotation():
    """Left-handed axes pass every test of length."""
    with pytest.raises(InvalidInput, match="right-handed"):
        load_path(ring(rotation=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0))))


@pytest.mark.parametrize("period", [0.0, -1.0, float("nan"), float("inf")])
def test_a_period_is_a_positive_time(period):
    """Before anything is divided by it."""
    with pytest.raises(InvalidInput, match="its period is"), np.errstate(all="ignore"):
        load_path(
            HarmonicPath(name="ring", period=period, centre=(0.5, 0, 0.4), cosine=((0.1, 0, 0),), sine=((0, 0, 0),))
        )


def test_what_is_no_path_is_refused():
    """With the members that it would need."""
    with pytest.raises(InvalidInput, match="is a dict, no path; a path has name, period"):
        load_path("builtins:dict")


def test_a_path_that_cannot_be_built_says_why():
    """Its own words, in one line."""

    def broken():
        raise ValueError("no radius")

    with pytest.raises(InvalidInput, match="could not be built: ValueError: no radius"):
        load_path(broken)


def test_a_circle_turned_by_nothing_is_a_circle():
    """The special case is the general one."""
    settings = {"name": "c", "period": 2.0, "centre": (0.5, 0.1, 0.3), "radius": 0.1, "tilt": 0.2}
    assert rotated_circle(**settings, turn=0.0) == circle(**settings)


def test_a_standing_circle_starts_at_its_top():
    """In the plane of y and z."""
    path = yz_circle(name="wheel", period=4.0, centre=(0.6, 0.35, 0.0), radius=0.2)
    poses = path.pose(np.array([0.0, 1.0, 2.0]))[:, :3, 3]
    assert np.allclose(poses, [[0.6, 0.35, 0.2], [0.6, 0.55, 0.0], [0.6, 0.35, -0.2]], rtol=0, atol=1e-15)
