"""What a motion may ask of an arm: refused in one line that says which joint, when and by how much."""

from dataclasses import replace

import pytest
from torquebench.controllers import InvalidInput
from torquebench.scenarios.benchmark import Benchmark
from torquebench.scenarios.expansion import expand
from torquebench.scenarios.loads import Payload
from torquebench.scenarios.trajectories import Plan, load_path
from torquebench.scenarios.trajectories.feasibility import Allowance, Motion, check_motion
from torquebench.scenarios.trajectories.kinematics import Lap


@pytest.fixture(scope="module")
def t6(rizon):
    """T6 at 1 ms with 3.5 kg of sand and all rotor inertia."""
    plan = Plan.build(rizon, load_path("T6"), lead_in=1.0)
    return Motion(
        name="T6",
        lap=Lap(q=plan.q, dq=plan.dq, ddq=plan.ddq),
        step=1e-3,
        robot=rizon,
        load=Payload(mass=3.5, material="sand"),
        rotor_inertia=rizon.rotor_inertia,
    )


def changed(motion, name, sample, joint, value):
    """Return a motion with one number of its lap replaced."""
    array = getattr(motion.lap, name).copy()
    array[sample, joint] = value
    return replace(motion, lap=replace(motion.lap, **{name: array}))


def test_shares_are_those_of_the_measured_table(t6):
    """0.924 rad, 0.52 of the speed, 0.80 of the torque, 0.156: another computation's figures for T6."""
    assert t6.room().min() == pytest.approx(0.924, abs=6e-4)
    assert t6.speed().max() == pytest.approx(0.52, abs=6e-3)
    assert t6.torque().max() == pytest.approx(0.80, abs=6e-3)
    assert t6.singular_values().min() == pytest.approx(0.156, abs=6e-4)
    check_motion(t6)


@pytest.mark.parametrize(("side", "limit"), [(1.0, "2.775"), (-1.0, "-1.955")])
def test_a_joint_beyond_its_range_is_named_with_time_and_distance(t6, rizon, side, limit):
    """By exactly what was added."""
    bound = rizon.upper[3] if side > 0 else rizon.lower[3]
    wrong = changed(t6, "q", 1234, 3, bound + 0.125 * side)
    line = f"trajectory 'T6': joint 4 is 0.125 rad beyond its limit of {limit} rad at 1.234 s of the lap"
    with pytest.raises(InvalidInput, match=line):
        check_motion(wrong)


def test_a_joint_too_fast_is_named_with_time_and_share(t6, rizon):
    """A quarter above the limit."""
    wrong = changed(t6, "dq", 777, 4, -1.25 * rizon.velocity[4])
    with pytest.raises(InvalidInput, match=r"joint 5 moves at 6.11 rad/s at 0.777 s of the lap, 1.25 times its limit"):
        check_motion(wrong)


def test_a_joint_too_weak_is_named_with_load_time_and_share(t6, rizon):
    """An acceleration about joint 7 alone, whose rotor it has to turn; everything else stays far from its limit."""
    wrong = changed(t6, "ddq", 500, 6, 1.2 * rizon.effort[6] / rizon.rotor_inertia[6])
    with pytest.raises(InvalidInput, match=r"joint 7 needs \S+ N m with 3.5 kg at 0.500 s of the lap, 1.\d\d times"):
        check_motion(wrong)


def test_a_stretched_arm_is_singular(t6, rizon):
    """Elbow straight: one direction of the tool is lost."""
    q = t6.lap.q.copy()
    q[200] = 0.0
    line = r"nearly singular at 0.200 s of the lap: smallest singular value \S+; at least 0.01"
    with pytest.raises(InvalidInput, match=line):
        check_motion(replace(t6, lap=replace(t6.lap, q=q), load=Payload(mass=1.186)))


@pytest.mark.parametrize(
    ("allowance", "line"),
    [
        ({"room": 1.0}, "joint 4 is 0.924 rad from its limit of 2.775 rad .*; leave 1"),
        ({"share": 0.5}, "joint 2 moves at .* 0.52 times its limit; at most 0.5 of it"),
        ({"share": 0.7}, "joint 2 needs .* 0.80 times its limit; at most 0.7 of it"),
        ({"singular": 0.2}, "smallest singular value 0.156; at least 0.2"),
    ],
)
def test_less_than_the_whole_arm_can_be_allowed(t6, allowance, line):
    """The rule that draws motions keeps a reserve, by the same check."""
    with pytest.raises(InvalidInput, match=line):
        check_motion(t6, Allowance(**allowance))


def small(**changes):
    """Return a benchmark of one controller on one motion with one load."""
    plain = {
        "schema": 1,
        "name": "small",
        "plant": "pinocchio",
        "controllers": ("computed_torque",),
        "knowledge": ("none",),
        "trajectories": ("T1",),
        "loads": ({"mass": 1.5},),
    }
    return Benchmark.model_validate(plain | changes)


def test_a_users_motion_is_refused_before_anything_runs(tmp_path):
    """Not after a campaign in which every controller failed for the motion's fault."""
    file = tmp_path / "mine.py"
    file.write_text(
        "from torquebench.scenarios.trajectories import circle\n"
        "def hasty(): return circle(name='hasty', period=0.6, centre=(0.54, 0.0, 0.45), radius=0.14)\n"
    )
    with pytest.raises(InvalidInput, match=r"mine.py:hasty': joint 2 moves at 3.61 rad/s at .* 1.72 times its limit"):
        expand(small(trajectories=(f"{file}:hasty",)))


def test_the_heaviest_load_of_a_run_decides(tmp_path):
    """Far out and fast the arm moves 1.5 kg and not 5 kg; which of the loads comes first is no matter."""
    file = tmp_path / "mine.py"
    file.write_text(
        "from torquebench.scenarios.trajectories import circle\n"
        "def far(): return circle(name='far', period=1.0, centre=(0.8, 0.0, 0.3), radius=0.05)\n"
    )
    loads = ({"mass": 1.5}, {"mass": 5.0, "material": "sand"}, {"mass": 2.0, "material": "sand"})
    assert len(expand(small(trajectories=(f"{file}:far",), loads=loads[:1])).specifications) == 1
    with pytest.raises(InvalidInput, match=r"far': joint 2 needs \d+ N m with 5 kg at .* of the lap, 1.\d\d times"):
        expand(small(trajectories=(f"{file}:far",), loads=loads))


def test_every_motion_of_the_benchmark_is_within_the_limits(rizon):
    """With the paper's heaviest load and all rotor inertia: what is refused is never the project's own."""
    for name in (*(f"T{i}" for i in range(1, 9)), "S1", "S2", "S3", *(f"M{i}" for i in range(1, 17))):
        plan = Plan.build(rizon, load_path(name), lead_in=1.0)
        check_motion(
            Motion(
                name=name,
                lap=Lap(q=plan.q, dq=plan.dq, ddq=plan.ddq),
                step=1e-3,
                robot=rizon,
                load=Payload(mass=3.5, material="sand"),
                rotor_inertia=rizon.rotor_inertia,
            )
        )
