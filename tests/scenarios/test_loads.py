"""Loads: what hangs on the flange, to the printed digits of the arm's data, and when it changes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.controllers import InvalidInput, UnknownName
from torquebench.scenarios.container import Container
from torquebench.scenarios.loads import LoadSchedule, Payload, combine
from torquebench.scenarios.materials import SAND_DENSITY, sand

# Content, total and moments of the payload table: z of the centres [m], moments about them, xx = yy and zz [kg m^2].
SAND = [
    (2.0, 0.291158, (0.000716, 0.001406), 0.145806, (0.028417, 0.004035)),
    (2.5, 0.282316, (0.001510, 0.002812), 0.171339, (0.035652, 0.005441)),
    (3.0, 0.273474, (0.002461, 0.004219), 0.185414, (0.039340, 0.006847)),
    (3.5, 0.264632, (0.003646, 0.005625), 0.192942, (0.041246, 0.008254)),
]
LIGHT, HEAVY = Payload(mass=1.5), Payload(mass=3.5, material="sand")


def moments(xx, zz):
    """Return the tensor of a body of revolution about z."""
    return np.diag([xx, xx, zz])


@pytest.mark.parametrize(("mass", "com_z", "inertia", "total_z", "total"), SAND)
def test_sand_has_the_printed_figures(rizon, mass, com_z, inertia, total_z, total):
    """A solid cylinder on the container's bottom; the totals by the parallel-axis theorem."""
    container, content = Payload(mass=mass, material="sand").bodies(rizon)
    assert content.mass == pytest.approx(mass - 1.5, abs=1e-12)
    assert content.com[2] == pytest.approx(com_z, abs=5e-7)
    assert np.allclose(content.inertia, moments(*inertia), rtol=0, atol=6e-7)
    union = combine([*rizon.gripper_bodies, container, content])
    assert union.mass == pytest.approx(mass, abs=1e-12)
    assert union.com[2] == pytest.approx(total_z, abs=1e-6)
    assert np.allclose(union.inertia, moments(*total), rtol=0, atol=2e-6)


def test_gripper_and_empty_container_have_the_printed_figures(rizon):
    """The paper's 1.5 kg."""
    union = combine([*rizon.gripper_bodies, *LIGHT.bodies(rizon)])
    assert union.mass == pytest.approx(1.5, abs=1e-12)
    assert union.com[2] == pytest.approx(0.097355, abs=1e-6)
    assert np.allclose(union.inertia, moments(0.013616, 0.002629), rtol=0, atol=2e-6)


def test_the_gripper_is_the_arms_own(rizon):
    """Every controller knows it; a load of its mass adds nothing."""
    assert rizon.gripper_mass == 1.186
    assert Payload(mass=1.186).bodies(rizon) == ()


def test_between_gripper_and_empty_container_the_container_is_scaled(rizon):
    """A sweep over the load starts at the gripper without a jump at either end."""
    (half,) = Payload(mass=1.186 + 0.157).bodies(rizon)
    assert half.mass == pytest.approx(0.157, abs=1e-12)
    assert np.array_equal(half.com, rizon.container.body.com)
    assert np.allclose(half.inertia, 0.5 * rizon.container.body.inertia, rtol=1e-9, atol=0)


@given(st.floats(0.001, 3.67))
def test_sand_stands_on_the_bottom_and_fills_no_more_than_its_volume(mass):
    """Twice its depth below its centre is where the container ends; density times volume is its mass."""
    container = Container(
        mass=0.3, com_z=0.25, inertia_diag=(0.001, 0.001, 0.002), inner_radius=0.075, inner_height=0.13, bottom_z=0.3
    )
    body = sand(mass, container)
    depth = 2 * (container.bottom_z - body.com[2])
    assert depth * np.pi * container.inner_radius**2 * SAND_DENSITY == pytest.approx(mass, rel=1e-9)
    assert depth <= container.inner_height
    assert body.inertia[2, 2] == pytest.approx(mass * container.inner_radius**2 / 2, rel=1e-12)


def test_a_container_further_out_moves_with_its_content(rizon):
    """The whole load hangs lower by the same distance."""
    near, far = sand(1.0, rizon.container), sand(1.0, rizon.container.moved(0.1))
    assert far.com[2] - near.com[2] == pytest.approx(0.1, abs=1e-12)
    assert rizon.container.moved(0.1).body.com[2] - rizon.container.body.com[2] == pytest.approx(0.1, abs=1e-12)


@pytest.mark.parametrize("mass", [0.0, -1.0, float("nan"), float("inf")])
def test_a_load_without_a_mass_is_refused(mass):
    """Whatever it is made of."""
    with pytest.raises(InvalidInput, match=r"load: mass .* kg; masses are positive"):
        Payload(mass=mass, material="sand")


def test_an_unknown_material_names_the_nearest():
    """Materials are plug-ins; none is one of the answers."""
    with pytest.raises(UnknownName, match="unknown load 'snad'; did you mean 'sand'"):
        Payload(mass=2.0, material="snad")


def test_below_the_gripper_there_is_no_load(rizon):
    """The paper's 1.0 kg does not exist on this arm."""
    with pytest.raises(InvalidInput, match=r"1 kg is below the gripper's own mass; at least 1.186 kg"):
        Payload(mass=1.0).bodies(rizon)


def test_beyond_the_empty_container_a_material_is_needed(rizon):
    """2 kg of what."""
    with pytest.raises(InvalidInput, match=r"2 kg without a material; beyond 1.5 kg .* name one of: .*sand"):
        Payload(mass=2.0).bodies(rizon)


def test_more_sand_than_the_container_holds_is_refused(rizon):
    """Its volume times the density, 3.676 kg."""
    with pytest.raises(InvalidInput, match=r"4.5 kg of sand in the container; .* up to 3.676 kg"):
        Payload(mass=6.0, material="sand").bodies(rizon)


def test_an_empty_container_has_one_spelling(rizon):
    """1.5 kg of gripper and container with 'sand' is the same run as without: one address."""
    assert Payload(mass=1.5, material="sand").canonical(rizon) == LIGHT
    assert HEAVY.canonical(rizon) is HEAVY


def test_an_arm_without_a_gripper_may_carry_nothing(planar_robot):
    """0 kg is a load there, and only there."""
    assert Payload(mass=0.0).bodies(planar_robot) == ()
    with pytest.raises(InvalidInput):
        Payload(mass=0.0, material="sand")


def test_the_first_load_acts_whatever_its_time_and_is_no_event():
    """Its time is a formality; later ones act from the tick at their time."""
    step = LoadSchedule(entries=((0.0, LIGHT), (12.0, HEAVY), (24.0, LIGHT)))
    assert step.events == (12.0, 24.0)
    assert [step.at(t) for t in (-1.0, 0.0, 11.999, 12.0, 23.999, 24.0, 99.0)] == [
        LIGHT,
        LIGHT,
        LIGHT,
        HEAVY,
        HEAVY,
        LIGHT,
        LIGHT,
    ]


def test_a_constant_load_has_no_event():
    """One entry."""
    assert LoadSchedule.constant(HEAVY).events == ()
    assert LoadSchedule.constant(HEAVY).at(1e6) == HEAVY


@pytest.mark.parametrize("times", [(0.0, 5.0, 5.0), (0.0, 5.0, 4.0), (0.0, float("nan")), (0.0, float("inf"))])
def test_times_must_increase(times):
    """An order that cannot be followed is refused with the times that came."""
    with pytest.raises(InvalidInput, match=r"load schedule: times 0, .*expected finite, increasing times"):
        LoadSchedule(entries=tuple((time, LIGHT) for time in times))


def test_a_schedule_needs_a_load():
    """At least the first."""
    with pytest.raises(InvalidInput, match="without entries"):
        LoadSchedule(entries=())


def test_each_distinct_body_gets_one_slot(rizon):
    """A simulator switches bodies on and off; 1.5, 3.5 and 1.5 kg are two of them, the container throughout."""
    bodies, switches = LoadSchedule(entries=((0.0, LIGHT), (12.0, HEAVY), (24.0, LIGHT))).slots(rizon)
    assert len(bodies) == 2
    assert switches == ((0.0, (True, False)), (12.0, (True, True)), (24.0, (True, False)))


def test_the_slots_that_are_on_are_the_load(rizon):
    """At every stage, whatever the order."""
    stages = [HEAVY, Payload(mass=2.0, material="sand"), Payload(mass=1.3), Payload(mass=1.186)]
    schedule = LoadSchedule(entries=tuple(enumerate(stages)))
    bodies, switches = schedule.slots(rizon)
    for (_, active), payload in zip(switches, stages, strict=True):
        carried = [body for body, on in zip(bodies, active, strict=True) if on]
        assert carried == list(payload.bodies(rizon))
