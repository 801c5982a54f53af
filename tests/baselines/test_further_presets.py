"""The further named controllers: conforming, on any arm, and through an episode with real drives."""

import json
from dataclasses import asdict
from importlib.metadata import entry_points

import numpy as np
import pytest
from torquebench.baselines import further_presets
from torquebench.controllers import InvalidInput, build_controller, check_inertia
from torquebench.scenarios.conformance import check
from torquebench.scenarios.execution import execute
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.result import OK, REFUSED
from torquebench.scenarios.specification import RunSpecification
from torquebench.scoring import score

SETTINGS = {
    "pd_gravity": {"stiffness": None, "damping": None, "bandwidth": None, "velocity_feedforward": False},
    "pid": {"stiffness": None, "damping": None, "reset_time": 0.25, "integral_limit": 0.9},
    "joint_impedance": {"stiffness": None, "damping_ratio": 0.7},
    "slotine_li": {"bandwidth": 20.0, "mass_gain": 20.0, "parameters": 10},
    "pes_adaptive": {"bandwidth": 20.0, "neurons": 1000, "learning_rate": 0.01},
}
NAMES = sorted(SETTINGS)
EFFORT = 150.0
LARGEST = {"pd_gravity": 0.05, "pid": 0.01, "joint_impedance": 0.03, "slotine_li": 0.01, "pes_adaptive": 0.01}
"""Largest mean distance from a slow and a fast path that each law may have with 2 kg that it does not know [m]."""


def preset(name):
    """Return a preset as the harness builds it."""
    return build_controller(getattr(further_presets, name), {}, name=name)


def episode(name, *, tier, mass, **settings):
    """Return the result of one lap of the fast path on the Rizon 4s."""
    load = Payload(mass=mass, material="sand" if mass > 1.5 else "none")
    specification = RunSpecification(
        controller=f"torquebench.baselines.further_presets:{name}",
        settings=settings,
        trajectory="T6",
        schedule=LoadSchedule.constant(load),
        robot="rizon4s",
        plant="pinocchio",
        tier=tier,
        laps=1,
    )
    (result,) = execute(specification, evaluate=score, traces="none")
    return result


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_has_the_settings_that_its_name_promises(name):
    """Changing one changes what every stored figure means."""
    assert asdict(preset(name)) == SETTINGS[name]


def test_a_registered_name_leads_to_its_preset():
    """By entry point, without another list."""
    room = "torquebench.baselines.further_presets"
    points = [p for p in entry_points(group="torquebench.controllers") if p.value.startswith(room)]
    assert all(point.load() is getattr(further_presets, point.name) for point in points)
    assert {point.name for point in points} <= set(SETTINGS)


@pytest.mark.parametrize("name", NAMES)
def test_an_unknown_setting_is_named_and_the_valid_ones_are_listed(name):
    """One line for the user, no traceback."""
    with pytest.raises(InvalidInput, match="wobble") as caught:
        build_controller(getattr(further_presets, name), {"wobble": 1.0}, name=name)
    assert set(caught.value.valid.removeprefix("settings: ").split(", ")) == set(SETTINGS[name])


@pytest.mark.parametrize("name", NAMES)
def test_the_contract_holds(name):
    """On a recorded episode: repeats, keeps nothing, changes nothing, hooks in order."""
    findings = check(f"torquebench.baselines.further_presets:{name}")
    assert [finding for finding in findings if not finding.passed] == []
    assert len(findings) > 8


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("arm", ["planar", "planar4", "six", "seven"])
def test_every_law_holds_any_arm(bench, name, arm):
    """From 0.02 rad off the arm comes back."""
    log = bench(arm, effort=EFFORT).run(preset(name), 2.0, offset=0.02)
    assert np.all(np.isfinite(log.torque))
    assert np.linalg.norm(log.error[-1]) < 0.5 * np.linalg.norm(log.error[0])


@pytest.mark.parametrize("name", NAMES)
def test_the_ledger_names_the_origin_of_every_setting(bench, name):
    """In words and numbers that JSON can hold."""
    law = preset(name)
    law.reset(bench(effort=EFFORT).task())
    entries = {entry.setting: entry for entry in law.ledger()}
    assert set(entries) >= set(SETTINGS[name])
    assert all(entries[setting].value == value for setting, value in SETTINGS[name].items())
    assert all(entry.source in {"published", "rule", "chosen", "tuned"} and entry.note for entry in entries.values())
    json.dumps([asdict(entry) for entry in entries.values()])


@pytest.mark.parametrize("name", NAMES)
def test_the_declared_inertia_is_accepted_on_the_arm_with_rotors(bench, name):
    """Damping times period stays clear of what one tick of delay allows."""
    arm, law = bench(effort=EFFORT), preset(name)
    law.reset(arm.task())
    check_inertia(law.design_inertia(), arm.plant.mass_matrix(arm.plan.centre), 1e-3)


@pytest.mark.parametrize("name", ["pd_gravity", "pid"])
def test_gains_for_rotors_are_refused_on_an_arm_without_them(name):
    """The published wrist damping would turn a bare wrist's velocity around within a tick."""
    result = episode(name, tier="paper_bullet", mass=1.5)
    assert result.status == REFUSED
    assert "stable below about 1" in result.reason


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("tier", ["ideal", "actuated"])
@pytest.mark.parametrize("mass", [1.5, 3.5])
def test_a_lap_with_an_unknown_load_is_followed(name, tier, mass):
    """Fast path, exact and real drives: within what the law's own stiffness explains."""
    result = episode(name, tier=tier, mass=mass)
    assert result.status == OK, result.reason
    assert result.metrics["run"]["tcp_position_error_mean"]["value"] < LARGEST[name]


def test_a_light_wrist_needs_all_parameters_of_its_load():
    """The load's rotational inertia is forty times the bare wrist's: four parameters ring, ten do not."""
    ten, four = (episode("slotine_li", tier="paper_bullet", mass=3.5, parameters=p).metrics["run"] for p in (10, 4))
    error = "tcp_orientation_error_mean"
    assert ten[error]["value"] < 0.2 * four[error]["value"]
    assert ten["torque_ripple"]["value"] < 0.2 * four["torque_ripple"]["value"]
