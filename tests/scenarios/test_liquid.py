"""Water in the container: its first slosh mode to the printed digits, its limits, and what is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import jvp
from torquebench.controllers import InvalidInput
from torquebench.scenarios.axes import parallel_axis
from torquebench.scenarios.body import Body, combine
from torquebench.scenarios.container import Container
from torquebench.scenarios.liquid import GRAVITY, LEAST_DAMPING, MODE, viscous_damping
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.materials import WATER_DENSITY, sand, water

# The payload table, frozen: z and moments of content and total.
WATER = [
    (2.0, 0.285853, (0.000736, 0.001406), 0.144479, (0.027676, 0.004035)),
    (2.5, 0.271706, (0.001673, 0.002812), 0.167095, (0.033528, 0.005441)),
    (3.0, 0.257559, (0.003010, 0.004219), 0.177457, (0.035875, 0.006847)),
    (3.5, 0.243412, (0.004947, 0.005625), 0.180816, (0.036848, 0.008254)),
]
# The pendulum: omega, L, m1, bob z, hinge z; the rigid part's z and moments; viscous damping.
SLOSH = [
    (0.5, 12.029942, 0.067786, 0.361992, 0.298915, 0.231128, 0.251592, (0.000513, 0.001406), 0.005088),
    (1.0, 14.582476, 0.046132, 0.531905, 0.292369, 0.246236, 0.248226, (0.001188, 0.002812), 0.003702),
    (1.5, 15.280053, 0.042016, 0.584011, 0.278552, 0.236536, 0.244174, (0.002589, 0.004219), 0.003357),
    (2.0, 15.458792, 0.041050, 0.597754, 0.258760, 0.217710, 0.236869, (0.004746, 0.005625), 0.003230),
]
BOX = Container(
    mass=0.3, com_z=0.25, inertia_diag=(0.001, 0.001, 0.002), inner_radius=0.075, inner_height=0.13, bottom_z=0.3
)
contents = st.floats(0.001, 0.999 * WATER_DENSITY * BOX.volume)


@pytest.mark.parametrize(("mass", "com_z", "inertia", "total_z", "total"), WATER)
def test_frozen_water_has_the_printed_figures(rizon, mass, com_z, inertia, total_z, total):
    """What the oracle is told; equal masses of sand stand lower."""
    container, content = Payload(mass=mass, material="water").bodies(rizon)
    assert content.mass == pytest.approx(mass - 1.5, abs=1e-12)
    assert content.com[2] == pytest.approx(com_z, abs=5e-7)
    assert np.diag(content.inertia)[[0, 2]] == pytest.approx(inertia, abs=6e-7)
    union = combine([*rizon.gripper_bodies, container, content])
    assert union.com[2] == pytest.approx(total_z, abs=1e-6)
    assert np.diag(union.inertia)[[0, 2]] == pytest.approx(total, abs=2e-6)


@pytest.mark.parametrize(
    ("mass", "omega", "length", "bob", "bob_z", "hinge_z", "rigid_z", "rigid_inertia", "damping"), SLOSH
)
def test_the_pendulum_has_the_printed_figures(
    rizon, mass, omega, length, bob, bob_z, hinge_z, rigid_z, rigid_inertia, damping
):
    """Two litres slosh with 0.6 kg at 2.46 Hz."""
    content = water(mass, rizon.container)
    assert content.frequency == pytest.approx(omega, abs=5e-7)
    assert (content.length, content.bob_mass) == pytest.approx((length, bob), abs=5e-7)
    assert (content.hinge_z, content.hinge_z + content.length) == pytest.approx((hinge_z, bob_z), abs=6e-7)
    assert content.rigid.com[2] == pytest.approx(rigid_z, abs=5e-7)
    assert np.diag(content.rigid.inertia)[[0, 2]] == pytest.approx(rigid_inertia, abs=6e-7)
    depth = mass / (WATER_DENSITY * math.pi * rizon.container.inner_radius**2)
    found = viscous_damping(depth=depth, radius=rizon.container.inner_radius, viscosity=1e-6)
    assert found == pytest.approx(damping, abs=5e-7)
    assert content.damping_ratio == LEAST_DAMPING


def test_the_mode_is_the_first_that_a_wall_allows():
    """No flow through the wall: J1' is zero at the radius."""
    assert abs(jvp(1, MODE)) < 1e-15
    assert np.all(jvp(1, np.linspace(0.01, MODE - 0.01, 50)) > 0)


@given(contents)
def test_mass_and_payload_at_rest_are_those_of_the_frozen_cylinder(mass):
    """A pendulum at rest is the frozen liquid: mass, centre and inertia add up, whatever the fill."""
    content = water(mass, BOX)
    bob_place = np.array([0.0, 0.0, content.hinge_z + content.length])
    bob = Body(mass=content.bob_mass, com=bob_place, inertia=np.zeros((3, 3)))
    assert np.allclose(content.rigid.parameters + bob.parameters, content.parameters, rtol=0, atol=1e-12)
    assert content.mass == pytest.approx(sand(mass, BOX).mass, abs=1e-12)
    assert content.rigid.mass > 0 and np.all(np.diag(content.rigid.inertia) > 0)


@given(contents)
def test_the_hinge_carries_the_weight_moment_of_the_surface(mass):
    """A tilted surface moves the liquid's centre by R^2/4h times the slope: the mode's share of it is m1 L / m h."""
    content = water(mass, BOX)
    share = content.bob_mass * content.length / content.mass
    depth = 2 * (BOX.bottom_z - content.com[2])
    # All modes together make R^2/4h; the first alone has 2 / (xi^2 (xi^2 - 1)) of R^2/h, the most of it.
    assert share * depth / BOX.inner_radius**2 == pytest.approx(2 / (MODE**2 * (MODE**2 - 1)), rel=1e-9)
    assert 0.95 < 4 * 2 / (MODE**2 * (MODE**2 - 1)) < 1.0


def test_a_shallow_liquid_is_a_wave_and_a_deep_one_forgets_the_bottom(rizon):
    """omega R = xi sqrt(g h) in the one limit, omega^2 = g xi / R in the other."""
    radius = rizon.container.inner_radius
    drop = water(1e-4, rizon.container)
    depth = 2 * (rizon.container.bottom_z - drop.com[2])
    assert drop.frequency * radius == pytest.approx(MODE * math.sqrt(GRAVITY * depth), rel=1e-6)
    tall = Container(
        mass=1.0, com_z=2.0, inertia_diag=(1.0, 1.0, 1.0), inner_radius=0.05, inner_height=30.0, bottom_z=31.0
    )
    deep = water(WATER_DENSITY * tall.volume, tall)
    assert deep.frequency**2 == pytest.approx(GRAVITY * MODE / 0.05, rel=1e-12)
    assert deep.damping_ratio == LEAST_DAMPING


def test_a_film_is_damped_beyond_what_any_vessel_is():
    """The bottom's boundary layer: the formula takes over from the floor."""
    film = water(0.001, BOX)
    assert film.damping_ratio > 1.0
    assert film.damping == pytest.approx(2 * film.damping_ratio * film.frequency * film.bob_mass * film.length**2)


def test_equal_masses_of_sand_and_water_differ_in_the_height_of_their_centre(rizon):
    """By up to 16 mm in the total: the material changes the rigid part too."""
    totals = [
        combine([*rizon.gripper_bodies, *Payload(mass=3.0, material=name).bodies(rizon)]) for name in ("sand", "water")
    ]
    assert totals[0].mass == pytest.approx(totals[1].mass, abs=1e-12)
    assert totals[0].com[2] - totals[1].com[2] == pytest.approx(0.008, abs=0.001)


def test_what_does_not_slosh_keeps_the_moments_about_its_own_centre(rizon):
    """The parallel-axis theorem backwards: what the point mass brings is taken from the rigid part."""
    content = water(1.0, rizon.container)
    bob = np.array([0.0, 0.0, content.hinge_z + content.length])
    about = parallel_axis(content.bob_mass, bob - content.com) + parallel_axis(
        content.rigid.mass, content.rigid.com - content.com
    )
    assert np.allclose(content.rigid.inertia + about, content.inertia, rtol=0, atol=1e-15)


def test_water_is_not_the_body_that_it_freezes_to(rizon):
    """A simulator that took one for the other would lose the pendulum."""
    content, again = water(1.0, rizon.container), water(1.0, rizon.container)
    frozen = Body(mass=content.mass, com=content.com, inertia=content.inertia)
    assert content == again and hash(content) == hash(again)
    assert content != frozen and frozen != content
    assert content != water(1.0, rizon.container.moved(0.01))


def test_each_fill_level_gets_a_slot_of_its_own(rizon):
    """Water, more water, sand of the same mass, and the first again."""
    stages = [
        Payload(mass=2.5, material="water"),
        Payload(mass=3.5, material="water"),
        Payload(mass=3.5, material="sand"),
    ]
    bodies, switches = LoadSchedule(entries=tuple(enumerate([*stages, stages[0]]))).slots(rizon)
    assert len(bodies) == 4
    assert [active for _, active in switches] == [
        (True, True, False, False),
        (True, False, True, False),
        (True, False, False, True),
        (True, True, False, False),
    ]


@pytest.mark.parametrize("mass", [0.0, -1.0, 2.4, float("nan")])
def test_a_fill_level_that_is_not_physical_is_refused(rizon, mass):
    """The container holds 2.297 kg of water, less than of sand."""
    with pytest.raises(InvalidInput, match=r"kg of water in the container; it holds more than 0 and up to 2.297 kg"):
        water(mass, rizon.container)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"inner_radius": 0.0}, "container: inner radius 0; mass, inner radius and height are positive"),
        ({"inner_height": -0.1}, "container: inner height -0.1"),
        ({"mass": math.inf}, "container: mass inf"),
        ({"inertia_diag": (0.001, 0.001, 0.01)}, "principal moments of 0.001, 0.001, 0.01 .*; no body has one above"),
        ({"inertia_diag": (0.001, -0.001, 0.001)}, "container: principal moments"),
        ({"inertia_diag": (0.001, 0.001, math.nan)}, "container: principal moments"),
    ],
)
def test_a_container_that_is_not_physical_is_refused(change, message):
    """In one line, before water is poured into it."""
    with pytest.raises(InvalidInput, match=message) as caught:
        replace(BOX, **change)
    assert "\n" not in str(caught.value)


def test_an_empty_container_has_one_spelling(rizon):
    """1.5 kg with 'water' is the run without it."""
    assert Payload(mass=1.5, material="water").canonical(rizon) == Payload(mass=1.5)


@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (0.004, -0.003, 0.005)])
def test_a_displaced_liquid_at_rest_is_its_displaced_frozen_body(shift):
    """Repetitions draw where a load hangs: a liquid must hang where a rigid content would."""
    liquid = water(1.2, BOX)
    moved = liquid.displaced(1.01, np.array(shift))
    bob = Body(mass=moved.bob_mass, com=np.array([0.0, 0.0, moved.hinge_z + moved.length]), inertia=np.zeros((3, 3)))
    frozen = Body(mass=liquid.mass, com=liquid.com, inertia=liquid.inertia).displaced(1.01, np.array(shift))
    assert combine([moved.rigid, bob]).parameters == pytest.approx(frozen.parameters, rel=1e-12, abs=1e-15)
    assert moved.parameters == pytest.approx(frozen.parameters, rel=1e-12, abs=1e-15)
    assert (moved.frequency, moved.damping_ratio) == (liquid.frequency, liquid.damping_ratio)
