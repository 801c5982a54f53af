"""What the stack shows of itself: arrays that stay where they are, and a ledger that hides nothing."""

import json
from dataclasses import asdict, replace
from types import SimpleNamespace

import numpy as np
import pytest
from torquebench.cbmc.configurations import NoBrainstemLearning, NoEncoder, NoLearning, NoThalamusLearning
from torquebench.cbmc.controller import CbmcV3
from torquebench.cbmc.diagnostics import ledger, live_arrays
from torquebench.cbmc.guard import Caps
from torquebench.cbmc.literal import CbmcV3Literal
from torquebench.cbmc.stack import Schedule
from torquebench.controllers import NoKnowledge
from torquebench.scenarios.episode import run_episode
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.specification import RunSpecification
from torquebench.scenarios.world import World

LOAD = LoadSchedule.constant(Payload(mass=2.5, material="sand"))
ALWAYS = ("weights", "stiffness", "damping", "gravity_torque", "compensation", "losses")
NETWORKS = {"thalamus", "brainstem"}


@pytest.fixture(scope="module")
def world():
    """The Rizon on the fast circle with a kilogram of sand."""
    specification = RunSpecification(
        controller="cbmc_v3",
        trajectory="T6",
        schedule=LOAD,
        robot="rizon4s",
        plant="pinocchio",
        tier="actuated",
        laps=1,
        lead_in=0.2,
    )
    built = World(specification, LOAD)
    yield built
    built.plant.close()


@pytest.fixture
def awake(world):
    """Builds a controller that is reset for the run."""

    def build(law=CbmcV3, **settings):
        controller = law(**settings)
        controller.reset(world.task())
        return controller

    return build


def shown_networks(controller):
    """Return the modules of which a controller shows hidden spikes."""
    return {name for name in NETWORKS if f"spikes_{name}" in controller.diagnostics()}


@pytest.mark.parametrize(
    ("law", "networks"),
    [
        (CbmcV3, {"thalamus", "brainstem"}),
        (NoBrainstemLearning, {"thalamus"}),
        (NoThalamusLearning, {"brainstem"}),
        (NoLearning, set()),
        (NoEncoder, {"thalamus", "brainstem"}),
    ],
)
def test_a_module_that_is_not_there_shows_nothing(awake, law, networks):
    """An ablation's silence is the absence of a layer, not a rate of zero."""
    controller = awake(law)
    assert shown_networks(controller) == networks
    assert set(ALWAYS) <= set(controller.diagnostics())
    assert {name for name in NETWORKS if f"skipped_updates_{name}" in controller.diagnostics()} == networks
    assert ("clamp_hits" in controller.diagnostics()) == ("brainstem" in networks)


def test_every_level_shows_at_its_own_period(awake):
    """A row for each of its answers: the cerebellum's every 50 ticks, all others every 10."""
    shown = awake().diagnostics()
    third = {"compensation", "spikes_granule", "spikes_purkinje"}
    assert {name for name, (_, period) in shown.items() if period == Schedule().third} == third
    assert {period for name, (_, period) in shown.items() if name not in third} == {Schedule().second}


def test_another_schedule_has_other_periods(awake):
    """The periods are those of the levels, not numbers of their own."""
    shown = live_arrays(awake().stack, Schedule(second=5, third=20))
    assert {period for _, period in shown.values()} == {5, 20}


def test_what_is_shown_is_alive(world):
    """The harness takes the arrays once and reads them for the whole run: they must be refilled, never replaced."""
    fresh = World(world.specification, LOAD)
    controller = CbmcV3()
    controller.reset(fresh.task())
    before = {name: (array, array.copy()) for name, (array, _) in controller.diagnostics().items()}
    fresh.times, fresh.table = fresh.times[:200], fresh.table[:200]
    run_episode(fresh.episode(controller, NoKnowledge()))
    fresh.plant.close()
    after = {name: array for name, (array, _) in controller.diagnostics().items()}
    moved = set()
    for name, (array, copy) in before.items():
        assert np.shares_memory(array, after[name]), name
        moved |= {name} if not np.array_equal(array, copy) else set()
    assert {"weights", "stiffness", "damping", "gravity_torque", "compensation", "losses"} <= moved


def test_shapes_are_those_of_the_arm_and_its_patterns(awake):
    """Seven joints, two patterns, the paper's layers of 300 and 200 neurons."""
    shapes = {name: array.shape for name, (array, _) in awake().diagnostics().items()}
    assert shapes["weights"] == (2,) and shapes["compensation"] == (2, 7)
    assert shapes["stiffness"] == shapes["damping"] == shapes["gravity_torque"] == (7,)
    assert shapes["losses"] == (2,)


def test_the_ledger_survives_json_and_names_every_source(awake):
    """It is stored with the run: text and numbers only, each with where it comes from."""
    entries = [asdict(entry) for entry in awake().ledger()]
    assert json.loads(json.dumps(entries)) == entries
    assert {entry["source"] for entry in entries} == {"published", "tuned", "chosen", "rule"}
    assert all(entry["note"] for entry in entries)


def test_what_was_tuned_says_with_how_many_trials(awake):
    """The one constant that was fitted is the first thing that a reader has to know."""
    tuned = [entry for entry in awake(sensitivity=0.5).ledger() if entry.source == "tuned"]
    assert [(entry.setting, entry.value) for entry in tuned] == [("sensitivity", 0.5)]
    assert tuned[0].trials > 0


def test_settings_in_the_ledger_are_those_of_the_controller(awake):
    """A ledger that shows defaults while other numbers run is worse than none."""
    entries = {entry.setting: entry.value for entry in awake(start="cold", damping_range=(1.0, 40.0)).ledger()}
    assert entries["start"] == "cold"
    assert entries["damping_range"] == [1.0, 40.0]


def test_the_literal_form_claims_neither_a_decoding_gain_nor_a_fitted_constant(awake):
    """It sums raw spikes and its losses hold no sensitivity: its ledger may not copy the other reading's."""
    entries = {entry.setting: entry for entry in awake(CbmcV3Literal, literal_learning="none").ledger()}
    assert (entries["spike gain"].value, entries["literal_learning"].value) == (1.0, "none")
    assert "sensitivity" not in entries
    assert {entries[name].source for name in ("stiffness_range", "damping_range", "gain caps")} == {"published"}


def test_what_was_learnt_before_the_run_is_told(awake):
    """The cerebellum comes trained: on what, with which recipe and seed."""
    (entry,) = [entry for entry in awake().ledger() if entry.learnt_before]
    assert entry.setting == "patterns" and entry.value == [0.0, 3.0]
    assert entry.learnt_before.startswith("cerebellum patterns: set ")
    assert "unknown" not in entry.learnt_before


@pytest.mark.parametrize("notes", [{}, {"training_set": "workspace"}, {"training_set": {}}])
def test_patterns_that_do_not_say_where_they_come_from_are_unknown(awake, notes):
    """Somebody's own file without notes still runs; the ledger invents nothing."""
    controller = awake()
    (entry,) = [entry for entry in ledger(controller, controller.caps, notes) if entry.setting == "patterns"]
    assert entry.learnt_before == "cerebellum patterns: set unknown, preset unknown, seed unknown"


def test_caps_are_listed_joint_by_joint_and_those_below_the_clamp_stand_out(awake):
    """A cap below the clamp's floor means that the guard, not the network, set that gain."""
    controller = awake(damping_range=(10.0, 40.0))
    caps = Caps(
        limit=np.array([90.0, 20.0, 12.0]),
        stiffness=np.full(3, np.inf),
        damping=np.array([np.inf, 12.0, 7.2]),
    )
    (entry,) = [entry for entry in ledger(controller, caps, {}) if entry.setting == "gain caps"]
    assert entry.value == {"joint 2": {"limit": 20.0, "cap": 12.0}, "joint 3": {"limit": 12.0, "cap": 7.2}}
    assert entry.note.endswith("; below the clamp's floor: joint 3")
    loose = replace(caps, damping=np.full(3, np.inf))
    (entry,) = [entry for entry in ledger(controller, loose, {}) if entry.setting == "gain caps"]
    assert entry.value == {} and "floor" not in entry.note


def test_a_stack_of_stand_ins_shows_the_pathways(awake):
    """Whatever stands in for a module, what travels between them is there to be seen."""
    stack = awake().stack
    bare = SimpleNamespace(
        descending=stack.descending,
        gradients=stack.gradients,
        spinal_cord=object(),
        cerebellum=object(),
        thalamus=object(),
        brainstem=object(),
    )
    assert set(live_arrays(bare, Schedule())) == set(ALWAYS)
