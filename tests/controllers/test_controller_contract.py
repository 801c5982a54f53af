"""The contract: two methods are enough, hooks are optional, settings are checked once."""

import functools

import numpy as np
import pytest
from torquebench.controllers import (
    Controller,
    DesignInertia,
    InvalidInput,
    Refusal,
    build_controller,
    check_inertia,
    hook,
    knowledge_levels,
)

KNOWN = ("none", "ft_estimate", "momentum_observer", "oracle")


class Duck:
    """A controller by its methods alone."""

    def __init__(self, *, gain=1.0):
        self.gain = gain

    def reset(self, task):
        pass

    def compute(self, observation, target):
        return self.gain * observation.q


class Heir(Controller):
    """A controller by inheritance."""

    def reset(self, task):
        pass

    def compute(self, observation, target):
        return observation.q


@pytest.mark.parametrize("controller", [Duck(), Heir()], ids=["duck", "heir"])
def test_every_hook_has_a_default(controller):
    """A controller of two methods runs everywhere."""
    assert hook(controller, "supports")(None) is None
    assert hook(controller, "diagnostics")() == {}
    assert hook(controller, "operations")() == {}
    assert hook(controller, "ledger")() == ()
    assert hook(controller, "design_inertia")() is None
    assert hook(controller, "close")() is None


def test_a_hook_of_ones_own_comes_first():
    """Inheriting or not."""

    class Counting(Duck):
        def operations(self):
            return {"spikes": 7}

    assert hook(Counting(), "operations")() == {"spikes": 7}


def test_the_two_methods_are_not_optional():
    """An heir without a law cannot be made."""
    with pytest.raises(TypeError, match="abstract"):
        Controller()


@pytest.mark.parametrize(
    ("declared", "levels"),
    [
        ({}, KNOWN),
        ({"uses_model": False}, ("none",)),
        ({"estimates_load": True}, ("none", "oracle")),
        ({"knowledge_levels": ("oracle",)}, ("oracle",)),
        ({"knowledge_levels": ("oracle", "none")}, ("none", "oracle")),
        ({"uses_model": False, "knowledge_levels": ("oracle",)}, ("oracle",)),
        ({"knowledge_levels": ("unheard_of",)}, ()),
    ],
)
def test_only_levels_that_can_differ_are_run(declared, levels):
    """A law without a model runs once, one that estimates the load twice, its own word counts before both."""
    assert knowledge_levels(type("Law", (Heir,), declared)(), KNOWN) == levels
    assert knowledge_levels(type("Law", (Duck,), declared)(), KNOWN) == levels


def test_a_class_a_preset_and_an_object_are_built_alike():
    """Three things stand behind doors."""
    assert build_controller(Duck, {"gain": 3.0}, name="duck").gain == 3.0
    preset = functools.partial(Duck, gain=2.0)
    assert build_controller(preset, {}, name="duck").gain == 2.0
    assert build_controller(preset, {"gain": 5.0}, name="duck").gain == 5.0
    made = Duck()
    assert build_controller(made, {}, name="duck") is made


def test_an_unknown_setting_names_the_nearest():
    """``--set gian=3`` is a typing error like any other."""
    with pytest.raises(InvalidInput, match="controller 'duck': unknown setting 'gian'; did you mean 'gain'"):
        build_controller(Duck, {"gian": 3.0}, name="duck")


def test_a_foreign_setting_lists_the_known():
    """Nothing is near."""
    with pytest.raises(InvalidInput, match="unknown setting 'xyz'; settings: gain"):
        build_controller(functools.partial(Duck, gain=1.0), {"xyz": 3.0}, name="duck")


def test_a_factory_that_takes_anything_is_not_second_guessed():
    """A wrapper passes its settings on."""
    assert build_controller(lambda **settings: Duck(**settings), {"gain": 4.0}, name="duck").gain == 4.0


@pytest.mark.parametrize("error", [TypeError, ValueError, KeyError, RuntimeError])
def test_whatever_a_constructor_raises_is_a_refused_setting(error):
    """One line with the settings, no traceback."""

    class Picky(Duck):
        def __init__(self, *, gain=1.0):
            raise error("gain is\nwrong")

    with pytest.raises(InvalidInput, match=f"controller 'picky': {error.__name__}.*settings: gain") as caught:
        build_controller(Picky, {"gain": -1.0}, name="picky")
    assert "\n" not in str(caught.value)


def test_a_sentence_of_the_controllers_own_is_kept():
    """A baseline says itself what is valid."""

    def strict():
        raise InvalidInput("gain = 0", "setting 'gain'", "positive")

    with pytest.raises(InvalidInput, match=r"^setting 'gain': gain = 0; positive$"):
        build_controller(strict, {}, name="strict")


@pytest.mark.parametrize("thing", [42, object()])
def test_what_is_no_controller_is_refused(thing):
    """The message says what is missing."""
    with pytest.raises(InvalidInput, match=r"neither a class nor a controller.*reset and compute"):
        build_controller(thing, {}, name="thing")


def test_a_class_without_a_law_is_refused():
    """Before the run, not in its first tick."""
    with pytest.raises(InvalidInput, match="controller 'dict': has no method 'reset'"):
        build_controller(dict, {}, name="dict")


def test_settings_for_a_finished_object_are_refused():
    """They would be ignored, and the ledger would lie."""
    with pytest.raises(InvalidInput, match=r"built already.*pass its class"):
        build_controller(Duck(), {"gain": 2.0}, name="duck")


def test_a_design_with_the_plants_inertia_is_stable_below_one_over_the_period():
    """k_d h = 0.5 at 500 / s and 1 ms."""
    inertia = np.diag([2.0, 0.5])
    check_inertia(DesignInertia(mass_matrix=inertia, damping=500.0), inertia, 0.001)


def test_a_design_with_too_much_inertia_is_refused_with_the_figure():
    """Sixty times the inertia of the lightest joint: 60 x 40 x 0.001 = 2.4."""
    design = DesignInertia(mass_matrix=np.diag([2.0, 0.6]), damping=40.0)
    with pytest.raises(Refusal, match=r"60 times the plant's inertia.* = 2.4, stable below about 1"):
        check_inertia(design, np.diag([2.0, 0.01]), 0.001)


def test_coupled_joints_are_judged_by_their_worst_mode():
    """The diagonals agree here; the difference of the two joints moves almost nothing."""
    plant = np.array([[1.0, 0.999], [0.999, 1.0]])
    with pytest.raises(Refusal):
        check_inertia(DesignInertia(mass_matrix=np.eye(2), damping=40.0), plant, 0.001)


def test_a_design_that_is_not_a_number_is_refused():
    """NaN compares as false with everything and must not slip through."""
    with pytest.raises((Refusal, np.linalg.LinAlgError)):
        check_inertia(DesignInertia(mass_matrix=np.eye(2), damping=float("nan")), np.eye(2), 0.001)


def test_no_declared_design_is_no_objection():
    """The check is for laws that carry an inertia."""
    check_inertia(None, np.eye(2), 0.001)
