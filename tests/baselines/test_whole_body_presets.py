"""The named whole-body controllers: settings as promised, the contract held, and whole episodes on the arm."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from torquebench.baselines import presets, whole_body_presets
from torquebench.controllers import InvalidInput, build_controller, check_controller, knowledge_levels
from torquebench.scenarios.execution import execute
from torquebench.scenarios.loads import LoadSchedule, Payload
from torquebench.scenarios.result import Scores
from torquebench.scenarios.specification import RunSpecification

NAMES = ("whole_body_qp", "whole_body_qp_stiff", "whole_body_qp_force", "whole_body_qp_strict")
DIFFERENCES = {
    "whole_body_qp": {},
    "whole_body_qp_stiff": {"bandwidth": 40.0},
    "whole_body_qp_force": {"gain_form": "force", "effort_weight": 0.0},
    "whole_body_qp_strict": {},
}
SHARED = {
    "gain_form": "acceleration",
    "bandwidth": 20.0,
    "linear_stiffness": 10000.0,
    "angular_stiffness": 1500.0,
    "damping_ratio": 0.7,
    "damping_design": "square_root",
    "posture_stiffness": 25.0,
    "posture_damping": 10.0,
    "pose_weight": 1e4,
    "effort_weight": 1e-4,
    "slack_weight": 1e6,
    "position_margin": 0.02,
    "velocity_share": 0.98,
    "acceleration_share": 0.5,
    "tolerance": 1e-6,
    "outer_iterations": 20,
    "inner_iterations": 20,
    "warm_start": True,
}


def preset(name):
    """Return a preset as the harness builds it."""
    return build_controller(getattr(whole_body_presets, name), {}, name=name)


def episode(name, *, mass, tier, trajectory="T6", knowledge="none"):
    """Return the row of a lap on the Pinocchio plant."""
    load = Payload(mass=mass, material="sand") if mass > 1.5 else Payload(mass=mass)
    spec = RunSpecification(
        controller="it",
        schedule=LoadSchedule.constant(load),
        trajectory=trajectory,
        laps=1,
        tier=tier,
        plant="pinocchio",
        robot="rizon4s",
        knowledge=knowledge,
    )
    plug_ins = {"it": getattr(whole_body_presets, name)}
    (row,) = execute(spec, evaluate=lambda _: Scores(metrics={}), traces="none", plug_ins=plug_ins)
    return row


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_has_the_settings_that_its_name_promises(name):
    """Changing one changes what every stored figure means."""
    assert asdict(preset(name)) == SHARED | DIFFERENCES[name]


def test_the_force_preset_shares_stiffness_and_damping_with_the_impedance():
    """So that the two differ by constraints only."""
    law, impedance = preset("whole_body_qp_force"), presets.flexiv_full_ff()
    for setting in ("linear_stiffness", "angular_stiffness", "damping_ratio", "damping_design"):
        assert getattr(law, setting) == getattr(impedance, setting)
    assert (law.posture_stiffness, law.posture_damping) == (impedance.posture_stiffness, impedance.posture_damping)


@pytest.mark.parametrize("name", NAMES)
def test_an_unknown_setting_is_named(name):
    """One line for the user, no traceback."""
    with pytest.raises(InvalidInput, match="wobble"):
        build_controller(getattr(whole_body_presets, name), {"wobble": 1.0}, name=name)


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_can_differ_at_every_knowledge_level(name):
    """Model-based, with no load estimate of its own."""
    levels = ("none", "ft_estimate", "momentum_observer", "oracle")
    assert knowledge_levels(preset(name), levels) == levels


@pytest.mark.parametrize("name", NAMES)
def test_the_ledger_names_the_origin_of_every_setting(bench, name):
    """Published, chosen, or by rule from model and plan; what has no effect in a form says so."""
    law = preset(name)
    law.reset(bench(effort=150.0).task())
    entries = {entry.setting: entry for entry in law.ledger()}
    assert set(entries) == set(SHARED) | {"acceleration_limit", "braking_acceleration"}
    assert all(entry.note for entry in entries.values())
    assert entries["braking_acceleration"].source == "rule"
    is_force = name == "whole_body_qp_force"
    assert ("without effect" in entries["bandwidth"].note) == is_force
    assert (entries["linear_stiffness"].source == "published") == is_force
    json.dumps([asdict(entry) for entry in entries.values()])


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("arm", ["six", "seven"])
def test_a_preset_holds_the_contract(bench, name, arm):
    """Repeats after reset, in a fresh instance and beside another; keeps and changes no input."""
    arm = bench(arm, sway=0.2, effort=60.0)
    times = 1e-3 * np.arange(30)
    rng = np.random.default_rng(0)
    observations, targets = [], []
    for time in times:
        q, dq, _ = arm.plan.joints(time)
        observations.append(arm.observe(time, q + 0.01 * rng.standard_normal(len(q)), dq))
        targets.append(replace(arm.plan.target(time)))
    findings = check_controller(lambda: preset(name), arm.task(), observations, targets)
    assert len(findings) > 5
    assert [finding for finding in findings if not finding.passed] == []


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("tier", "mass"), [("ideal", 1.5), ("ideal", 3.5), ("actuated", 1.5), ("actuated", 3.5)])
def test_every_preset_finishes_the_fast_path_without_a_fallback(name, tier, mass):
    """One program a tick, two with strict priorities, none of them unsolved."""
    row = episode(name, mass=mass, tier=tier, knowledge="oracle" if mass > 1.5 else "none")
    assert row.status == "ok", row.reason
    counts = row.counts["operations"]
    levels = 2 if name == "whole_body_qp_strict" else 1
    assert counts["qp_solves"] == levels * row.counts["ticks"]
    assert counts["qp_fallbacks"] == 0
    assert "iterations" in row.diagnostics
