"""Gains by rule: one number places every pole."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from torquebench.baselines.gains import double_integrator_gains, smallest_effective_inertia, triple_integrator_gains

H = 1e-3


def chain(states):
    """Return the semi-implicit chain of integrators."""
    step = np.eye(states) + H * np.eye(states, k=1)
    drive = np.zeros((states, 1))
    drive[-2:, 0] = H * H, H
    return step, drive


@pytest.mark.parametrize(
    ("bandwidth", "k_p", "k_d"), [(20.0, 392.1, 39.21), (40.0, 1537.0, 76.9), (60.0, 3390.0, 113.0)]
)
def test_double_integrator_gains_at_one_kilohertz(bandwidth, k_p, k_d):
    """Sampling costs a few per cent of w^2 and 2 w."""
    assert double_integrator_gains(bandwidth, H) == pytest.approx((k_p, k_d), rel=6e-4)


def test_triple_integrator_gains_at_one_kilohertz():
    """The PID at w = 15."""
    assert triple_integrator_gains(15.0, H) == pytest.approx((3300.0, 662.0, 44.0), rel=6e-4)


@pytest.mark.parametrize("bandwidth", [5.0, 20.0, 40.0])
def test_fast_sampling_gives_critical_damping(bandwidth):
    """As h goes to 0: k_p = w^2, k_d = 2 w."""
    assert double_integrator_gains(bandwidth, 1e-5) == pytest.approx((bandwidth**2, 2.0 * bandwidth), rel=1e-3)


@pytest.mark.parametrize("bandwidth", [10.0, 20.0, 40.0])
def test_all_poles_of_the_pd_law_lie_at_the_bandwidth(bandwidth):
    """One double pole at exp(-w h): nothing rings."""
    step, drive = chain(2)
    poles = np.linalg.eigvals(step - drive @ [double_integrator_gains(bandwidth, H)])
    assert poles == pytest.approx(np.exp(-bandwidth * H), abs=2e-4)


@pytest.mark.parametrize("bandwidth", [10.0, 15.0, 20.0])
def test_all_poles_of_the_pid_law_lie_at_the_bandwidth(bandwidth):
    """One triple pole at exp(-w h)."""
    step, drive = chain(3)
    poles = np.linalg.eigvals(step - drive @ [triple_integrator_gains(bandwidth, H)])
    assert poles == pytest.approx(np.exp(-bandwidth * H), abs=2e-4)


def test_the_pid_is_three_times_as_stiff_as_the_pd_law():
    """Readers compare bandwidths; the stiffness behind them differs."""
    _, stiffness, _ = triple_integrator_gains(10.0, 1e-5)
    assert stiffness == pytest.approx(3.0 * double_integrator_gains(10.0, 1e-5)[0], rel=2e-3)


def test_effective_inertia_of_a_double_pendulum(bench):
    """With joint 2 free, joint 1 shows M11 - M12^2 / M22: less than the diagonal."""
    model = bench("planar").model
    plan = SimpleNamespace(q=np.array([[0.2, 0.4, 0.1], [0.2, 1.4, -0.7], [0.2, -0.9, 2.0]]))
    shown = []
    for q in plan.q:
        mass = model.mass_matrix(q)
        rest = mass[1:, 1:]
        shown.append(mass[0, 0] - mass[0, 1:] @ np.linalg.solve(rest, mass[1:, 0]))
    assert smallest_effective_inertia(model, plan)[0] == pytest.approx(min(shown), rel=1e-12)


def test_effective_inertia_never_exceeds_the_diagonal(rizon):
    """Joints 1, 3, 5 and 7 of a straight wrist share their axis: mean diag(M) overdrives them."""
    model = rizon.model()
    plan = SimpleNamespace(q=rizon.home + 0.1 * np.random.default_rng(3).standard_normal((20, 7)))
    diagonal = np.min([np.diag(model.mass_matrix(q)) for q in plan.q], axis=0)
    inertia = smallest_effective_inertia(model, plan)
    assert np.all(inertia < diagonal)
    coupling = np.linalg.eigvals(np.linalg.solve(model.mass_matrix(rizon.home), np.diag(inertia))).real.max()
    assert coupling < 2.0


def test_importing_the_presets_does_not_import_control():
    """It takes more than a second, and only a reset needs it."""
    code = "import sys, torquebench.baselines.presets; sys.exit('control' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
