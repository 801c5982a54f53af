"""The named controllers: every name works on any arm, forgets on reset, and touches nothing."""

import json
from dataclasses import asdict
from importlib.metadata import entry_points

import numpy as np
import pytest
from torquebench.baselines import presets
from torquebench.controllers import InvalidInput, build_controller, knowledge_levels

POINTS = [
    p for p in entry_points(group="torquebench.controllers") if p.value.startswith("torquebench.baselines.presets")
]
NAMES = sorted(point.name for point in POINTS)
SETTINGS = {
    "computed_torque": {"bandwidth": 20.0},
    "computed_torque_stiff": {"bandwidth": 40.0},
    "computed_torque_feedforward": {"bandwidth": 20.0},
    "computed_torque_feedforward_stiff": {"bandwidth": 40.0},
    "computed_torque_pid": {"bandwidth": 20.0, "integral_limit": 0.2},
    "flexiv_factory": {
        "linear_stiffness": 10000.0,
        "angular_stiffness": 1500.0,
        "damping_ratio": 0.7,
        "damping_design": "square_root",
        "velocity_feedforward": False,
        "acceleration_feedforward": False,
        "posture_stiffness": 25.0,
        "posture_damping": 10.0,
        "force_limit": None,
        "moment_limit": None,
    },
}
FULL = {"velocity_feedforward": True, "acceleration_feedforward": True}
SETTINGS["flexiv_factory_dd"] = SETTINGS["flexiv_factory"] | {"damping_design": "double_diagonalisation"}
SETTINGS["flexiv_full_ff"] = SETTINGS["flexiv_factory"] | FULL
SETTINGS["compliant"] = SETTINGS["flexiv_full_ff"] | {"linear_stiffness": 1000.0, "angular_stiffness": 60.0}


def preset(name):
    """Return a preset as the harness builds it."""
    return build_controller(getattr(presets, name), {}, name=name)


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_has_the_settings_that_its_name_promises(name):
    """Changing one changes what every stored figure means."""
    assert asdict(preset(name)) == SETTINGS[name]


@pytest.mark.parametrize("point", POINTS, ids=lambda point: point.name)
def test_a_registered_name_leads_to_its_preset(point):
    """By entry point, without another list."""
    assert point.load() is getattr(presets, point.name)


def test_a_setting_can_be_overridden():
    """The rest stays as named."""
    law = presets.flexiv_factory(damping_ratio=0.8)
    assert (law.damping_ratio, law.linear_stiffness) == (0.8, 10000.0)
    assert presets.computed_torque(bandwidth=25.0).bandwidth == 25.0


@pytest.mark.parametrize("name", NAMES)
def test_an_unknown_setting_is_named_and_the_valid_ones_are_listed(name):
    """One line for the user, no traceback."""
    factory = getattr(presets, name)
    with pytest.raises(TypeError, match="'wobble'"):
        factory(wobble=1.0)
    with pytest.raises(InvalidInput, match="wobble") as caught:
        build_controller(factory, {"wobble": 1.0}, name=name)
    assert set(caught.value.valid.removeprefix("settings: ").split(", ")) == set(SETTINGS[name])


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_can_differ_at_every_knowledge_level(name):
    """Model-based, with no load estimate of its own: integral action is none."""
    levels = ("none", "ft_estimate", "momentum_observer", "oracle")
    assert knowledge_levels(preset(name), levels) == levels


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("arm", ["planar", "planar4", "six", "seven"])
def test_every_law_holds_any_arm(bench, name, arm):
    """From 0.02 rad off, with a perfect model, the arm comes back."""
    log = bench(arm).run(preset(name), 2.0, offset=0.02)
    assert np.all(np.isfinite(log.torque))
    assert np.linalg.norm(log.error[-1]) < 0.5 * np.linalg.norm(log.error[0])


@pytest.mark.parametrize("name", NAMES)
def test_an_episode_repeats_to_the_bit_on_the_same_object(bench, name):
    """Reset forgets everything."""
    law = preset(name)
    first, second = (bench(sway=0.1).run(law, 0.05, offset=0.01).torque for _ in range(2))
    assert np.array_equal(first, second)


@pytest.mark.parametrize("name", NAMES)
def test_a_tick_changes_neither_observation_nor_target(bench, name):
    """Even where the arrays could be written."""
    arm, law = bench(sway=0.1), preset(name)
    law.reset(arm.task())
    observation, target = arm.observe(0.0, arm.plan.centre + 0.01, 0.1 * np.ones(7)), arm.plan.target(0.0)
    copies = []
    for record in (observation, target):
        for field in type(record).__dataclass_fields__:
            if isinstance(value := getattr(record, field), np.ndarray):
                setattr(record, field, value.copy())
                copies.append((getattr(record, field), value))
    assert law.compute(observation, target).shape == (7,)
    assert all(np.array_equal(now, before) for now, before in copies)


@pytest.mark.parametrize("name", NAMES)
def test_the_ledger_names_the_origin_of_every_setting(bench, name):
    """In words and numbers that JSON can hold."""
    law = preset(name)
    law.reset(bench().task())
    entries = {entry.setting: entry for entry in law.ledger()}
    assert set(entries) >= set(SETTINGS[name])
    assert all(entries[setting].value == value for setting, value in SETTINGS[name].items())
    assert all(entry.source in {"published", "rule", "chosen"} and entry.note for entry in entries.values())
    json.dumps([asdict(entry) for entry in entries.values()])


def test_only_published_values_count_as_published(bench):
    """The factory's stiffness has a source; a user's own has not."""
    law = presets.flexiv_factory(linear_stiffness=8000.0)
    law.reset(bench().task())
    sources = {entry.setting: entry.source for entry in law.ledger()}
    assert (sources["linear_stiffness"], sources["damping_ratio"]) == ("chosen", "published")
