"""Which runs are meant: conditions narrow, commute, name the nearest, and never choose in silence."""

from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from torquebench.controllers import InvalidInput, UnknownName
from torquebench.evaluation.motion_sets import MOTION_SETS
from torquebench.selection import Selection, one_label, one_world

CONTROLLERS = ("pid", "./mine.py:Mine", "package.module:Mine")
MOTIONS, MASSES, LEVELS = ("T1", "T7", "M3"), (1.5, 2.5), ("none", "oracle")


def run_of(controller="pid", knowledge="none", trajectory="T1", mass=1.5, material=""):
    """Return a run as the page knows it: its label has the knowledge, its name may be a door."""
    row = SimpleNamespace(
        controller=f"{controller.rpartition(':')[2]} / {knowledge}", trajectory=trajectory, mass=mass, material=material
    )
    specification = SimpleNamespace(controller=controller, knowledge=knowledge)
    return SimpleNamespace(row=row, stored=SimpleNamespace(specification=specification))


GRID = [
    run_of(controller, level, motion, mass, "sand" if mass > 1.5 else "")
    for controller in CONTROLLERS
    for level in LEVELS
    for motion in MOTIONS
    for mass in MASSES
]

conditions = st.fixed_dictionaries(
    {},
    optional={
        "controller": st.sampled_from([*CONTROLLERS, "Mine", "pid / oracle"]),
        "knowledge": st.sampled_from(LEVELS),
        "trajectories": st.lists(st.sampled_from(MOTIONS), min_size=1, max_size=3).map(tuple),
        "motions": st.sampled_from(sorted(MOTION_SETS)),
        "mass": st.sampled_from(MASSES),
        "material": st.sampled_from(["sand", "none"]),
    },
)


def chosen(selection, runs=GRID):
    """Return the runs that are meant, none where no run has all of it."""
    try:
        return selection.of(runs)
    except InvalidInput:
        return []


@given(conditions)
def test_a_run_is_meant_if_it_meets_every_condition_by_itself(asked):
    """Each condition alone says which runs it lets pass; together they are the intersection, in the store's order."""
    alone = [chosen(Selection(**{name: value})) for name, value in asked.items()]
    expected = [run for run in GRID if all(any(run is other for other in passed) for passed in alone)]
    found = chosen(Selection(**asked))
    assert len(found) == len(expected) and all(one is other for one, other in zip(found, expected, strict=True))


@given(conditions)
def test_no_condition_adds_a_run(asked):
    """Narrowing never widens: a reader who adds a flag looks at part of what she saw."""
    everything = chosen(Selection(**asked))
    for name in asked:
        fewer = chosen(Selection(**{key: value for key, value in asked.items() if key != name}))
        assert {id(run) for run in everything} <= {id(run) for run in fewer}


@pytest.mark.parametrize("name", ["Mine", "./mine.py:Mine", "Mine / none", "package.module:Mine"])
def test_a_controller_goes_by_its_label_its_door_and_the_name_behind_it(name):
    """What the page prints, what was typed, and what a person would say."""
    assert chosen(Selection(controller=name))
    assert all("Mine" in run.row.controller for run in chosen(Selection(controller=name)))


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"controller": "pdi"}, "unknown controller in this store 'pdi'; did you mean 'pid'?"),
        ({"knowledge": "orcale"}, "did you mean 'oracle'?"),
        ({"trajectories": ("T1", "T77")}, "unknown trajectory in this store 'T77'"),
        ({"motions": "papr"}, "did you mean 'paper'?"),
        ({"mass": 9.0}, "unknown mass in this store '9'; known: 1.5, 2.5"),
        ({"material": "snad"}, "did you mean 'sand'?"),
    ],
)
def test_a_name_that_no_run_has_is_answered_with_those_that_there_are(asked, says):
    """A slip must not read as "no such runs"."""
    with pytest.raises(UnknownName) as caught:
        Selection(**asked).of(GRID)
    assert says in str(caught.value)


def test_names_that_never_meet_are_told_in_the_words_of_the_conditions():
    """Sand is in the store and so is 1.5 kg: which of them to leave out is the reader's choice."""
    with pytest.raises(InvalidInput, match=r"no run has mass 1\.5, material sand; leave out one"):
        Selection(mass=1.5, material="sand").of(GRID)


def test_a_selection_reads_as_it_was_asked():
    assert str(Selection()) == "any run"
    assert str(Selection(controller="pid", trajectories=("T1", "T7"))) == "controller pid, trajectory T1 or T7"


def test_a_name_that_several_controllers_share_is_no_label():
    """Two levels of one controller: a mean over both would be nobody's."""
    with pytest.raises(InvalidInput, match=r"runs of 2 controllers.*'Mine / none', 'Mine / oracle'"):
        one_label(Selection(controller="Mine").of(GRID), Selection(controller="Mine"))
    only = Selection(controller="pid", knowledge="oracle")
    assert one_label(only.of(GRID), only) == "pid / oracle"


WORLDS = [
    SimpleNamespace(id="w1", facts={"Tier": "ideal", "Seed": "1"}, runs=GRID[:12]),
    SimpleNamespace(id="w2", facts={"Tier": "actuated", "Seed": "1"}, runs=GRID[:6]),
]


def test_of_several_worlds_none_is_chosen_in_silence():
    """The message tells them apart by what differs, and by nothing else."""
    with pytest.raises(InvalidInput) as caught:
        one_world(WORLDS, "", Selection(trajectories=("T1",)))
    assert "--world w1: tier ideal; --world w2: tier actuated" in str(caught.value)
    assert "seed" not in str(caught.value)


def test_a_world_is_taken_by_name_or_because_it_is_the_only_one():
    named, runs = one_world(WORLDS, "w2", Selection(trajectories=("T1",)))
    assert named.id == "w2" and all(any(run is other for other in WORLDS[1].runs) for run in runs)
    alone, runs = one_world(WORLDS, "", Selection(knowledge="oracle"))
    assert alone.id == "w1" and len(runs) == 6


def test_a_world_that_is_not_there_or_has_no_such_run_says_so():
    with pytest.raises(UnknownName, match="unknown world 'w3'"):
        one_world(WORLDS, "w3", Selection())
    with pytest.raises(InvalidInput, match="world w2: no run has knowledge level oracle"):
        one_world(WORLDS, "w2", Selection(knowledge="oracle"))
