"""From a benchmark to its runs: which plant, which levels, which cells, and what the reader is told of it."""

import importlib.util

import pytest
from torquebench.controllers import Controller, InvalidInput, UnknownName, discovery
from torquebench.scenarios import expansion as place
from torquebench.scenarios.benchmark import load_benchmark
from torquebench.scenarios.expansion import expand

HEAD = """
schema = 1
name = "small"
plant = "pinocchio"
trajectories = ["T6"]
loads = [{ mass = 1.5 }]
laps = 1
"""


class Law(Controller):
    """A law without a word of its own on knowledge."""

    def __init__(self, *, gain=1.0):
        self.gain = gain

    def reset(self, task):
        pass

    def compute(self, observation, target):
        pass


class Blind(Law):
    """Never looks at its model."""

    uses_model = False


class Estimates(Law):
    """Finds the load out itself."""

    estimates_load = True


class Informed(Law):
    """Makes no sense without the truth."""

    knowledge_levels = ("oracle",)


class Learns(Law):
    """Keeps what it has learnt."""

    carry_over = True


class Weighs(Law):
    """Says itself which levels make a difference, one that no benchmark runs unasked among them."""

    knowledge_levels = ("none", "ft_estimate_full")


LAWS = {law.__name__: law for law in (Law, Blind, Estimates, Informed, Learns, Weighs)}


@pytest.fixture
def expanded(tmp_path):
    """Expands a benchmark file of a few lines, with the laws of this file behind their names."""

    def build(text, head=HEAD, changes=()):
        file = tmp_path / "small.toml"
        file.write_text(head + text)
        return expand(load_benchmark(str(file), changes=changes), plug_ins=LAWS)

    return build


def without(monkeypatch, module):
    """Let a library be missing."""
    found = importlib.util.find_spec
    monkeypatch.setattr(place.importlib.util, "find_spec", lambda name: None if name == module else found(name))


@pytest.mark.parametrize(
    ("law", "levels"),
    [
        ("Law", ["ft_estimate", "momentum_observer", "none", "oracle"]),
        ("Blind", ["none"]),
        ("Estimates", ["none", "oracle"]),
        ("Informed", ["oracle"]),
        ("Weighs", ["ft_estimate_full", "none"]),
    ],
)
def test_a_law_runs_at_the_levels_at_which_it_can_differ(expanded, law, levels):
    """A run that must repeat another to the bit costs time and says nothing."""
    assert [run.knowledge for run in expanded(f'controllers = ["{law}"]').specifications] == levels


def test_a_level_that_a_law_cannot_take_is_left_out_not_refused(expanded):
    """One file asks for 'none'; whoever has only 'oracle' is absent from it without a failure."""
    runs = expanded('controllers = ["Law", "Informed"]\nknowledge = ["none"]').specifications
    assert [(run.controller, run.knowledge) for run in runs] == [("Law", "none")]


def test_a_level_beyond_the_standard_ones_runs_where_it_is_named(expanded):
    """One more estimator, installed by whom ever, must not make every benchmark longer."""
    assert "ft_estimate_full" in discovery.names("knowledge")
    assert not any(run.knowledge == "ft_estimate_full" for run in expanded('controllers = ["Law"]').specifications)
    runs = expanded('controllers = ["Law"]\nknowledge = ["none", "ft_estimate_full"]').specifications
    assert [run.knowledge for run in runs] == ["ft_estimate_full", "none"]


def test_a_benchmark_that_leaves_nothing_to_run_says_so(expanded):
    """Zero runs that finish at once would look like success."""
    with pytest.raises(InvalidInput, match="has no runs; give controllers a knowledge level they take"):
        expanded('controllers = ["Informed"]\nknowledge = ["none"]')


def test_a_level_that_does_not_exist_is_named(expanded):
    """Before anything runs, with the nearest that does."""
    with pytest.raises(UnknownName, match="did you mean 'oracle'"):
        expanded('controllers = ["Law"]\nknowledge = ["orcale"]')


def test_cells_are_motions_by_loads_by_repetitions_in_the_order_of_the_file(expanded):
    """A campaign that is stopped half-way has whole controllers, and rows stand as they were written."""
    text = 'controllers = ["Blind", "Law"]\nknowledge = ["none"]\nrepetitions = 2\n'
    changes = ['trajectories=["T6","T1"]', 'loads=[{mass=1.5},{mass=2.5,material="sand"}]']
    runs = expanded(text, changes=changes).specifications
    assert [(r.controller, r.trajectory, r.schedule.entries[0][1].mass, r.repetition) for r in runs] == [
        (law, path, mass, repetition)
        for law in ("Blind", "Law")
        for path in ("T6", "T1")
        for mass in (1.5, 2.5)
        for repetition in (0, 1)
    ]


def test_a_chain_is_one_run_of_its_repetitions(expanded):
    """What was learnt in the first is there in the second: they cannot go to two workers."""
    (run,) = expanded(
        'controllers = ["Learns"]\nknowledge = ["none"]\nprotocol = "carried"\nrepetitions = 5'
    ).specifications
    assert (run.repetitions, run.repetition, run.protocol) == (5, 0, "carried")


def test_a_law_that_forgets_is_not_chained(expanded):
    """Its repetitions would be equal, under a label that says it had learnt."""
    with pytest.raises(InvalidInput, match="'Law' in protocol 'carried': has no carry_over"):
        expanded('controllers = ["Law"]\nprotocol = "carried"\nrepetitions = 5')


def test_a_history_without_events_has_no_twins(expanded):
    """Twins cost three runs; a constant load has nothing to be compared with."""
    runs = expanded('controllers = ["Law"]\ntwins = true').specifications
    assert not any(run.twins for run in runs)


def test_settings_of_a_law_that_does_not_run_are_an_error(expanded):
    """A gain that was set for nobody was meant for somebody."""
    with pytest.raises(UnknownName, match="controller in settings 'Lav'; did you mean 'Law'"):
        expanded('controllers = ["Law"]\nsettings.Lav = { gain = 2.0 }')


def test_a_setting_that_a_law_does_not_take_is_found_before_the_first_run(expanded):
    """Not in the middle of a night."""
    with pytest.raises(InvalidInput, match="did you mean 'gain'"):
        expanded('controllers = ["Law"]\nsettings.Law = { gian = 2.0 }')


def test_every_run_has_its_own_settings(expanded):
    """A shared table would let one law's change reach the runs of another."""
    text = 'controllers = ["Law"]\nknowledge = ["none", "oracle"]\nsettings.Law = { gain = 2.0 }'
    runs = expanded(text).specifications
    assert [dict(run.settings) for run in runs] == [{"gain": 2.0}] * 2
    assert runs[0].settings is not runs[1].settings


def test_the_world_of_a_benchmark_is_that_of_all_its_runs(expanded):
    """Tier, tool, latency and seed belong to the comparison, not to a controller."""
    text = 'controllers = ["Law"]\ntier = "ideal"\ntool = "flange"\nlatency = 2\ntare = true\nseed = 7\n'
    for run in expanded(text).specifications:
        assert (run.tier, run.tool, run.latency, run.campaign, run.tare) == ("ideal", "flange", 2, 7, True)


def test_the_first_tool_of_a_robot_has_its_name_in_every_run(expanded):
    """Left out or written down, it is one tool point and one address."""
    named, silent = (
        [run.address("code") for run in expanded(f'controllers = ["Law"]\n{tool}').specifications]
        for tool in ('tool = "gripper"', "")
    )
    assert named == silent


def test_without_pybullet_the_other_plant_takes_over_and_the_reader_is_told(expanded, monkeypatch):
    """The same equations, but a reader who compares with another's PyBullet figures has to know."""
    without(monkeypatch, "pybullet")
    found = expanded('controllers = ["Law"]', head=HEAD.replace('plant = "pinocchio"\n', ""))
    assert {run.plant for run in found.specifications} == {"pinocchio"}
    assert any("the Pinocchio plant computes the same equations" in note for note in found.notes)


def test_a_plant_that_was_asked_for_by_name_is_never_replaced(expanded, monkeypatch):
    """Who names PyBullet gets PyBullet or a reason."""
    without(monkeypatch, "pybullet")
    with pytest.raises(InvalidInput, match="PyBullet is not installed; it has wheels"):
        expanded('controllers = ["Law"]', head=HEAD.replace("pinocchio", "pybullet"))


def test_where_pybullet_is_installed_it_is_the_plant(expanded, has_pybullet):
    """The default of every benchmark, without a note."""
    found = expanded('controllers = ["Law"]', head=HEAD.replace('plant = "pinocchio"\n', ""))
    assert {run.plant for run in found.specifications} == {"pybullet"}
    assert not any("PyBullet" in note for note in found.notes)


def test_the_declared_reference_stays_where_it_runs(expanded):
    """And nothing is noted."""
    found = expanded('controllers = ["Blind", "Law"]\nreference = "Law / oracle"')
    assert (found.reference, found.notes) == ("Law / oracle", ())


def test_without_a_declared_reference_the_first_run_is_it(expanded):
    """Nobody declared one, so nobody is told that it was replaced."""
    found = expanded('controllers = ["Blind", "Law"]')
    assert (found.reference, found.notes) == ("Blind / none", ())


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ('trajectories=["T9x"]', "unknown trajectory 'T9x'"),
        ('loads=[{mass=9.0,material="sand"}]', "sand"),
        ("loads=[{mass=0.5}]", "below the gripper's own mass"),
        ("tier=actuatd", "did you mean 'actuated'"),
        ("robot=rizon", "did you mean 'rizon4s'"),
        ("tool=gripperr", "gripper"),
        ("plant=mujoko", "known: pinocchio, pybullet"),
    ],
)
def test_whatever_a_run_would_stumble_over_is_found_before_the_first(expanded, change, says):
    """One line now instead of a failed row for every controller later."""
    with pytest.raises((InvalidInput, UnknownName)) as error:
        expanded('controllers = ["Law"]', changes=[change])
    assert says in str(error.value) and "\n" not in str(error.value)


def test_springs_too_hard_for_their_step_are_found_before_the_first_run(expanded, tmp_path, urdf_of):
    """Every run would grow by itself and blame its controller."""
    file = tmp_path / "arm.urdf"
    file.write_text(urdf_of("zyzyzyz"))
    with pytest.raises(InvalidInput, match="springs grow unstable with substeps = 4"):
        expanded('controllers = ["Law"]', changes=[f"robot={file}", "tier=elastic"])


def test_a_run_table_may_have_a_world_of_its_own(tmp_path):
    """One benchmark asks whether an order holds with another rotor inertia, tier, plant or tool."""
    table = """controllers = ["pid"]
[[run]]
[[run]]
tier = "ideal"
tool = "flange"
[[run]]
tier_constants.armature_scale = 0.5
"""
    file = tmp_path / "worlds.toml"
    file.write_text(HEAD + table)
    usual, exact, lighter = expand(load_benchmark(str(file))).specifications
    assert (usual.tier, usual.tool, dict(usual.tier_constants)) == ("actuated", "gripper", {})
    assert (exact.tier, exact.tool) == ("ideal", "flange")
    assert (lighter.tier, dict(lighter.tier_constants)) == ("actuated", {"armature_scale": 0.5})


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ("tier_constants={armatur_scale=1}", "did you mean 'armature_scale'?"),
        ("tier_constants={coulomb=[1, 2]}", "tier_constants: coulomb has 2 values; expected 7"),
        ("tier_constants={ft_bias_sigma=[1]}", "expected 6"),
        ("tier=rigid", "unknown tier 'rigid'"),
    ],
)
def test_a_tier_that_cannot_be_is_one_line(change, line):
    """Before anything runs."""
    with pytest.raises((InvalidInput, UnknownName)) as caught:
        expand(load_benchmark("quick", changes=[change]))
    assert line in str(caught.value)
