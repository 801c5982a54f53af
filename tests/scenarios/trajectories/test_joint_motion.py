"""The joint motion of a path: on it, closed, closest to home, within every limit (F10)."""

import os

import numpy as np
import pytest
from torquebench.controllers import InvalidInput
from torquebench.scenarios.loads import Payload
from torquebench.scenarios.robots import read_robot, rizon4s
from torquebench.scenarios.trajectories import HarmonicPath, Plan, circle, kinematics, lap_cache, load_path
from torquebench.scenarios.trajectories.kinematics import facing_posture, lap_samples, solve_lap, spectral_derivative
from torquebench.scenarios.trajectories.lap_cache import cached_lap

# Margin to a limit [rad] and its joint, highest speed / limit and its joint, highest acceleration [rad/s^2],
# static and dynamic torque / limit with 3.5 kg and all rotor inertia, smallest singular value.
E3 = {
    "T1": (0.856, 4, 0.26, 2, 1.2, 0.68, 0.71, 0.150),
    "T2": (0.935, 4, 0.35, 2, 1.3, 0.74, 0.76, 0.131),
    "T3": (0.924, 4, 0.26, 2, 1.1, 0.66, 0.70, 0.156),
    "T4": (0.651, 4, 0.34, 4, 1.6, 0.67, 0.67, 0.145),
    "T5": (0.651, 4, 0.46, 4, 2.8, 0.67, 0.69, 0.145),
    "T6": (0.924, 4, 0.52, 2, 4.2, 0.66, 0.80, 0.156),
    "T7": (0.463, 4, 0.61, 4, 4.9, 0.68, 0.76, 0.106),
    "T8": (0.514, 4, 0.57, 4, 4.1, 0.68, 0.77, 0.116),
    "S1": (0.856, 4, 0.34, 2, 2.1, 0.68, 0.73, 0.150),
    "S2": (0.924, 4, 0.35, 2, 1.9, 0.66, 0.72, 0.156),
    "S3": (0.798, 4, 0.48, 4, 5.1, 0.68, 0.75, 0.173),
}
FLANGE_MARGIN = {"T1": 0.529, "T4": 0.460, "T7": 0.226, "T8": 0.251}
NAMES = pytest.mark.parametrize("name", E3)


@pytest.fixture(scope="module")
def plan_of(rizon):
    """Builds the plan of a path of the suite."""
    plans = {}

    def build(name):
        if name not in plans:
            plans[name] = Plan.build(rizon, load_path(name), lead_in=1.0)
        return plans[name]

    return build


@pytest.fixture(scope="module")
def arm(rizon):
    """The Rizon's model without a load."""
    return rizon.model()


@NAMES
def test_the_tool_is_on_the_path_at_every_millisecond(arm, plan_of, name):
    """Position and attitude to 1e-11."""
    plan = plan_of(name)
    position, rotation = arm.tool_path(plan.q)
    assert np.abs(position - plan.pose[:, :3, 3]).max() < 1e-11
    assert np.abs(rotation - plan.pose[:, :3, :3]).max() < 1e-11


@NAMES
def test_joint_velocities_move_the_tool_as_the_path_says(arm, plan_of, name):
    """J dq = dx to 1e-8, and J ddq + dJ dq = ddx: the spectral derivatives are those of the motion."""
    plan = plan_of(name)
    for k in range(0, len(plan.q), 37):
        state = arm.at(plan.q[k], plan.dq[k])
        assert np.abs(state.jacobian @ plan.dq[k] - plan.twist[k]).max() < 1e-8
        assert np.abs(state.jacobian @ plan.ddq[k] + state.jacobian_bias - plan.acceleration[k]).max() < 1e-5


@NAMES
def test_the_lap_closes(plan_of, name):
    """The step from the last sample to the first is one like its neighbours: to 1e-9, by the cubic through them."""
    q = plan_of(name).q
    ring = np.concatenate([q[-4:], q[:4]])
    # The eighth difference of a smooth motion at 1 ms is rounding; a jump at the seam would show in full.
    seam = np.abs(np.diff(ring, n=7, axis=0)).max()
    assert seam < 1e-9


@NAMES
def test_each_sample_is_the_closest_to_the_facing_posture(arm, rizon, plan_of, name):
    """No motion within the redundancy would bring it closer: cyclic because it depends on the pose alone."""
    plan = plan_of(name)
    posture = facing_posture(arm, rizon.home, load_path(name).centre)
    for q in plan.q[::101]:
        jacobian = arm.jacobian(q)
        wish = posture - q
        assert np.abs(wish - np.linalg.pinv(jacobian) @ (jacobian @ wish)).max() < 1e-9


@NAMES
def test_margins_and_loads_are_the_measured_ones(rizon, plan_of, name):
    """Every figure of the table to its printed digits: the paths are feasible with 3.5 kg, by this much."""
    margin, joint, speed, fastest, acceleration, static, dynamic, singular = E3[name]
    plan = plan_of(name)
    room = np.minimum(plan.q - rizon.lower, rizon.upper - plan.q).min(axis=0)
    share = np.abs(plan.dq / rizon.velocity).max(axis=0)
    assert (room.min(), int(room.argmin()) + 1) == (pytest.approx(margin, abs=6e-4), joint)
    assert (share.max(), int(share.argmax()) + 1) == (pytest.approx(speed, abs=6e-3), fastest)
    assert np.abs(plan.ddq).max() == pytest.approx(acceleration, abs=0.06)
    model = rizon.model(rotor_inertia=rizon.rotor_inertia)
    model.set_payload(sum(body.parameters for body in Payload(mass=3.5, material="sand").bodies(rizon)))
    rows = range(0, len(plan.q), 10)
    held = max(np.abs(model.gravity(plan.q[k]) / rizon.effort).max() for k in rows)
    moved = max(np.abs(model.inverse_dynamics(plan.q[k], plan.dq[k], plan.ddq[k]) / rizon.effort).max() for k in rows)
    assert held == pytest.approx(static, abs=6e-3)
    assert moved == pytest.approx(dynamic, abs=1.1e-2)
    smallest = min(np.linalg.svd(model.jacobian(plan.q[k]), compute_uv=False)[-1] for k in rows)
    assert smallest == pytest.approx(singular, abs=6e-4)


@pytest.mark.parametrize("name", FLANGE_MARGIN)
def test_with_the_flange_as_tool_the_margins_are_the_measured_ones(name):
    """The option stays feasible, nearer to the limits."""
    robot = rizon4s(tool="flange")
    q = Plan.build(robot, load_path(name), lead_in=0.0).q
    assert np.minimum(q - robot.lower, robot.upper - q).min() == pytest.approx(FLANGE_MARGIN[name], abs=1e-3)


@pytest.mark.parametrize(
    ("centre", "turn"), [((0.5, 0.0, 0.4), 0.0), ((0.0, 0.61, 0.3), 90.0), ((0.0, -0.5, 0.3), -90.0), ((0, 0, 0.9), 0)]
)
def test_the_arm_faces_the_centre_with_its_first_joint(arm, rizon, centre, turn):
    """atan2(y, x); straight above the base there is nothing to face."""
    posture = facing_posture(arm, rizon.home, centre)
    assert np.rad2deg(posture[0]) == pytest.approx(turn, abs=1e-9)
    assert np.array_equal(posture[1:], rizon.home[1:])


def test_an_arm_without_a_vertical_axis_stays_at_home(planar_robot):
    """Turning its shoulder would lift it."""
    home = np.array([0.3, 0.5])
    assert np.array_equal(facing_posture(planar_robot.model(), home, (0.0, 0.5, 0.3)), home)


@pytest.mark.parametrize("count", [16, 17])
def test_the_spectral_derivative_of_a_harmonic_is_exact(count):
    """Even and odd numbers of samples; the period's length enters."""
    period = 2.5
    w, t = 2 * np.pi / period, np.arange(count) * period / count
    wave = np.stack([np.sin(w * t), np.cos(3 * w * t)], axis=1)
    slope = np.stack([w * np.cos(w * t), -3 * w * np.sin(3 * w * t)], axis=1)
    assert np.allclose(spectral_derivative(wave, period, order=1), slope, rtol=0, atol=1e-12)
    curve = np.stack([-(w**2) * np.sin(w * t), -9 * w**2 * np.cos(3 * w * t)], axis=1)
    assert np.allclose(spectral_derivative(wave, period, order=2), curve, rtol=0, atol=1e-11)


def test_a_path_out_of_reach_is_refused_with_place_and_distance(arm, rizon):
    """Where of the lap, how far away, and what to do."""
    far = circle(name="far", period=2.0, centre=(2.0, 0.0, 0.4), radius=0.1)
    with pytest.raises(InvalidInput, match=r"trajectory 'far': the tool cannot reach \(2.1.* m at 0.000 s.*mm.*reach"):
        solve_lap(arm, far, home=rizon.home)


def test_a_period_of_no_whole_milliseconds_is_refused():
    """A lap is a whole number of ticks."""
    with pytest.raises(InvalidInput, match=r"period 2.0005 s is no whole number of 1 ms samples"):
        lap_samples(circle(name="odd", period=2.0005, centre=(0.5, 0.0, 0.4), radius=0.1), 0.001)
    with pytest.raises(InvalidInput, match="at least eight"):
        lap_samples(circle(name="short", period=0.004, centre=(0.5, 0.0, 0.4), radius=0.1), 0.001)


def test_a_prime_number_of_samples_is_solved_too(arm, rizon):
    """No coarse grid divides 1009 ms."""
    path = circle(name="prime", period=1.009, centre=(0.54, 0.0, 0.45), radius=0.05)
    lap = solve_lap(arm, path, home=rizon.home)
    position, _ = arm.tool_path(lap.q)
    assert np.abs(position - path.pose(np.arange(1009) * 0.001)[:, :3, 3]).max() < 1e-11


@pytest.fixture
def laps(monkeypatch, tmp_path):
    """An empty cache, and how often something had to be solved."""
    solved = []

    def counted(*args, **options):
        solved.append(args[1].name)
        return solve_lap(*args, **options)

    monkeypatch.setattr(lap_cache, "cache_folder", lambda purpose: tmp_path)
    monkeypatch.setattr(lap_cache, "solve_lap", counted)
    return tmp_path, solved


RING = {"name": "ring", "period": 0.512, "centre": (0.54, 0.0, 0.45), "radius": 0.02}


def test_a_lap_is_solved_once_and_read_back_to_the_bit(rizon, laps):
    """Every worker of a campaign needs the same plan."""
    folder, solved = laps
    first, second = (cached_lap(rizon, circle(**RING), step=0.001) for _ in range(2))
    assert solved == ["ring"]
    assert len(list(folder.iterdir())) == 1
    for name in ("q", "dq", "ddq"):
        assert np.array_equal(getattr(first, name), getattr(second, name))


def test_whatever_changes_the_solution_is_in_the_caches_key(rizon, laps):
    """Another radius, another tool point, and another centre to face for the same poses."""
    _, solved = laps
    shifted = HarmonicPath(
        name="same poses",
        period=0.512,
        centre=(0.44, 0.0, 0.45),
        cosine=((0.02, 0.0, 0.0),),
        sine=((0.0, 0.02, 0.0),),
    )

    class Moved(HarmonicPath):
        def pose(self, t):
            return circle(**RING).pose(t)

    moved = Moved(**{name: getattr(shifted, name) for name in ("name", "period", "centre", "cosine", "sine")})
    cached_lap(rizon, circle(**RING), step=0.001)
    cached_lap(rizon, circle(**RING | {"radius": 0.03}), step=0.001)
    cached_lap(rizon4s(tool="flange"), circle(**RING), step=0.001)
    cached_lap(rizon, moved, step=0.001)
    assert len(solved) == 4


@pytest.mark.parametrize("damage", [b"", b"not an array", None])
def test_a_damaged_cache_costs_a_solution_and_nothing_else(rizon, laps, damage):
    """Half a file, a text, an array of another shape."""
    folder, solved = laps
    expected = cached_lap(rizon, circle(**RING), step=0.001).q
    (file,) = folder.iterdir()
    if damage is None:
        np.save(file, np.zeros((3, 7)))
    else:
        file.write_bytes(damage)
    assert np.array_equal(cached_lap(rizon, circle(**RING), step=0.001).q, expected)
    assert len(solved) == 2


def test_a_full_disk_costs_the_next_solution_only(rizon, laps, monkeypatch):
    """A cache that cannot be written is no reason to stop."""

    def full(*_):
        raise OSError("No space left on device")

    monkeypatch.setattr(os, "replace", full)
    assert cached_lap(rizon, circle(**RING), step=0.001).q.shape == (512, 7)


def test_the_cached_solution_does_not_depend_on_the_cache(rizon, plan_of):
    """Solved anew on the spot: the same bits as what lies on the disk."""
    fresh = solve_lap(rizon.model(), load_path("T6"), home=rizon.home)
    assert np.array_equal(fresh.q, plan_of("T6").q)


def test_an_arm_of_too_few_joints_is_told_so_in_one_line(planar_robot):
    """Two joints cannot hold six coordinates."""
    model = planar_robot.model()
    with pytest.raises(InvalidInput, match="the tool cannot reach"):
        solve_lap(model, circle(name="ring", period=0.5, centre=(0.3, 0.0, 0.4), radius=0.05), home=planar_robot.home)


def test_a_six_joint_arm_follows_a_circle(tmp_path, urdf_of):
    """No redundancy: the posture has no say, the path is followed all the same."""
    file = tmp_path / "six.urdf"
    file.write_text(urdf_of("zyyzyz"))
    robot = read_robot(file)
    model = robot.model()
    home = np.array([0.2, 0.5, 1.1, 0.1, 1.0, 0.3])
    start = model.forward_kinematics(home)
    ring = HarmonicPath(
        name="ring",
        period=0.8,
        centre=tuple(start[:3, 3]),
        cosine=((0.03, 0.0, 0.0),),
        sine=((0.0, 0.02, 0.03),),
        rotation=tuple(tuple(row) for row in start[:3, :3]),
    )
    lap = solve_lap(model, ring, home=home)
    position, _ = model.tool_path(lap.q)
    assert np.abs(position - ring.pose(np.arange(800) * 0.001)[:, :3, 3]).max() < 1e-11
    assert kinematics.COARSE_SPACING < 0.02
