"""Settings are refused with a sentence that names the field and what is valid."""

import pytest
from torquebench.baselines.cartesian_impedance import CartesianImpedance
from torquebench.baselines.computed_torque import ComputedTorque
from torquebench.baselines.computed_torque_feedforward import ComputedTorqueFeedforward
from torquebench.baselines.computed_torque_pid import ComputedTorquePid
from torquebench.controllers import InvalidInput


@pytest.mark.parametrize("law", [ComputedTorque, ComputedTorqueFeedforward, ComputedTorquePid])
@pytest.mark.parametrize("bandwidth", [0.0, -5.0, float("nan"), float("inf"), "fast", None, True])
def test_a_bandwidth_must_be_a_positive_number(law, bandwidth):
    """Also where the value comes from a command line as text."""
    with pytest.raises(InvalidInput, match="'bandwidth'"):
        law(bandwidth=bandwidth)


def test_a_misspelt_damping_design_names_the_nearest():
    """One letter off is the usual mistake."""
    with pytest.raises(InvalidInput, match="did you mean 'square_root'"):
        CartesianImpedance(damping_design="square_rot")


def test_a_foreign_damping_design_lists_the_known():
    """Nothing is near: say what exists."""
    with pytest.raises(InvalidInput, match="known: square_root, double_diagonalisation"):
        CartesianImpedance(damping_design="xyz")


@pytest.mark.parametrize(
    "settings",
    [
        {"linear_stiffness": 0.0},
        {"angular_stiffness": -1.0},
        {"damping_ratio": 0.0},
        {"posture_stiffness": -1.0},
        {"posture_damping": "soft"},
        {"force_limit": 0.0},
        {"moment_limit": -2.0},
        {"velocity_feedforward": "false"},
        {"acceleration_feedforward": 1},
        {"damping_design": ["square_root"]},
    ],
    ids=lambda settings: next(iter(settings)),
)
def test_each_setting_of_the_impedance_is_checked(settings):
    """The message names the setting."""
    (name,) = settings
    with pytest.raises(InvalidInput, match=f"'{name}'"):
        CartesianImpedance(**settings)


def test_an_integral_limit_must_be_positive():
    """Zero would be the PD law under another name."""
    with pytest.raises(InvalidInput, match="'integral_limit'"):
        ComputedTorquePid(integral_limit=0.0)


def test_no_posture_stiffness_and_whole_numbers_are_fine():
    """A free posture is a legitimate choice, and 25 is as good as 25.0."""
    CartesianImpedance(posture_stiffness=0, posture_damping=5)
    ComputedTorque(bandwidth=25)
