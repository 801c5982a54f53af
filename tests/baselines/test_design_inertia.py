"""What the laws declare about their inertia, and what the harness's check makes of it."""

import numpy as np
import pytest
from scipy.linalg import eigh
from torquebench.baselines import presets
from torquebench.baselines.cartesian_impedance import CartesianImpedance
from torquebench.baselines.computed_torque import ComputedTorque
from torquebench.baselines.gains import double_integrator_gains
from torquebench.controllers import Refusal, check_inertia

H = 1e-3
CONTAINER = np.array([0.314, 0.0, 0.0, 0.0784, 0.0210, 0.0, 0.0210, 0.0, 0.0, 0.00163])
LAWS = ("computed_torque", "computed_torque_feedforward", "computed_torque_pid", "flexiv_factory", "flexiv_factory_dd")


def declared(law, arm):
    """Return what a law declares after reset."""
    law.reset(arm.task())
    return law.design_inertia()


@pytest.fixture
def on_rizon(rizon, bench):
    """A bench with the Rizon at home, its model with a share of the full rotor inertia."""

    def build(share):
        arm = bench()
        arm.model = rizon.model(rotor_inertia=share * rizon.rotor_inertia)
        arm.plan.model, arm.plan.centre, arm.plan.q = arm.model.copy(), rizon.home, rizon.home[None, :]
        return arm

    return build


def test_rotors_in_the_model_alone_are_refused_at_forty_and_accepted_at_twenty(rizon, on_rizon):
    """The wrist's own inertia is tiny: a model with rotors overdrives it 17 times, k_d rho h = 0.67 and 1.31."""
    links = rizon.model().mass_matrix(rizon.home)
    check_inertia(declared(ComputedTorque(bandwidth=20.0), on_rizon(1 / 3)), links, H)
    with pytest.raises(Refusal, match=r"1\.31"):
        check_inertia(declared(ComputedTorque(bandwidth=40.0), on_rizon(1 / 3)), links, H)


def test_full_rotors_in_the_model_alone_are_refused_at_twenty_too(rizon, on_rizon):
    """Stable without delay, not with one tick of it; the check is on the safe side."""
    with pytest.raises(Refusal):
        check_inertia(declared(ComputedTorque(bandwidth=20.0), on_rizon(1.0)), rizon.model().mass_matrix(rizon.home), H)


def test_links_in_the_model_alone_are_only_soft(rizon, on_rizon):
    """Too little inertia in the law never destabilises it."""
    plant = rizon.model(rotor_inertia=rizon.rotor_inertia).mass_matrix(rizon.home)
    check_inertia(declared(ComputedTorque(bandwidth=40.0), on_rizon(0.0)), plant, H)


def test_the_factory_damping_with_rotors_is_refused_on_links(rizon, on_rizon):
    """Measured without the check: torque steps of 40 N m per ms with an unchanged path error."""
    with pytest.raises(Refusal):
        check_inertia(declared(presets.flexiv_factory(), on_rizon(1.0)), rizon.model().mass_matrix(rizon.home), H)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("share", [0.0, 1 / 3, 1.0])
def test_every_law_is_accepted_on_the_plant_it_was_designed_for(rizon, on_rizon, name, share):
    """All presets, with and without rotors, with an empty container that the law does not know of."""
    arm = on_rizon(share)
    plant = arm.model.copy()
    plant.set_payload(CONTAINER)
    check_inertia(declared(getattr(presets, name)(), arm), plant.mass_matrix(rizon.home), H)


def test_the_linearising_law_declares_its_mass_matrix_and_its_damping(bench):
    """tau = M k_d de + ...: nothing to convert."""
    arm = bench()
    design = declared(ComputedTorque(bandwidth=20.0), arm)
    assert design.mass_matrix == pytest.approx(arm.model.mass_matrix(arm.plan.centre))
    assert design.damping == double_integrator_gains(20.0, H)[1]


def test_the_impedance_declares_the_rate_of_its_fastest_mode(bench):
    """With one ratio for all modes it is 2 zeta omega_max, and the product is the joint damping."""
    arm, law = bench(), CartesianImpedance(damping_design="double_diagonalisation", damping_ratio=0.6)
    design = declared(law, arm)
    state = arm.model.at(arm.plan.centre, np.zeros(7))
    stiffness = np.diag(np.repeat([10000.0, 1500.0], 3))
    squares = eigh(state.jacobian.T @ stiffness @ state.jacobian, state.mass_matrix, eigvals_only=True)
    assert design.damping == pytest.approx(1.2 * np.sqrt(squares.max()), rel=1e-9)
    q, still, push = arm.plan.centre, np.zeros(7), 0.01 * np.arange(7.0)
    target = arm.plan.target(0.0)
    arm.model.set_disturbance(arm.model.gravity(q))
    rest = law.compute(arm.observe(0.0, q, still), target).copy()
    bias = arm.model.at(q, push).bias.copy()
    moving = law.compute(arm.observe(0.0, q, push), target) - bias
    assert moving - rest == pytest.approx(-design.damping * design.mass_matrix @ push, abs=1e-9)
