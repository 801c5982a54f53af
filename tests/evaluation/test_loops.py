"""Margins of loops from data: closed forms, python-control on the same loop, and a single loop as the limit of many."""

import control
import numpy as np
import pytest
from torquebench.evaluation.loops import (
    broken_loops,
    closed_loop,
    disk_margin,
    linear_disk_margin,
    loop_margins,
    multiloop_disk_margin,
    scatter,
)

S = control.tf("s")
TEXTBOOK = 1 / (S * (S + 1) * (S + 2))
OMEGA = np.geomspace(0.05, 50.0, 45)


def response(loop, omega):
    """Return a loop's response on the imaginary axis, or the unit circle."""
    at = 1j * omega if loop.isctime() else np.exp(1j * omega * loop.dt)
    return np.asarray(loop(at))


def mass_with_velocity_loop(gain):
    """Return a damped mass under a PD law as a continuous state space of one channel."""
    return control.ss([[0.0, 1.0], [0.0, -0.4]], [[0.0], [1.0]], [[gain, 0.2 * gain]], [[0.0]])


def test_a_textbook_loop_has_its_textbook_margins():
    """1 / (s (s + 1) (s + 2)): gain 6, phase 53.411 deg, modulus 0.63760."""
    omega = np.geomspace(0.05, 50.0, 300)
    found = loop_margins(response(TEXTBOOK, omega), omega)
    assert found.gain == pytest.approx(6.0, rel=1e-5)
    assert found.phase == pytest.approx(53.411, rel=1e-5)
    assert found.modulus == pytest.approx(0.63760, rel=1e-5)
    assert found.crossover == pytest.approx(0.44575, rel=1e-5)
    assert found.delay == pytest.approx(np.radians(53.411) / 0.44575, rel=1e-4)


def test_the_gain_of_the_textbook_loop_may_rise_until_it_passes_the_critical_point_at_the_root_of_two():
    """Six times the response is -1 at 1.41421 rad/s: the margin is a factor on the loop, no number of decibels."""
    found = loop_margins(response(TEXTBOOK, OMEGA), OMEGA)
    assert found.gain * response(TEXTBOOK, np.array([1.41421]))[0] == pytest.approx(-1.0, abs=1e-3)


def test_the_modulus_is_the_smallest_distance_between_the_lines_too():
    """A minimum between two frequencies that were measured must not be missed: only the spline sees it."""
    coarse = np.array([0.05, 0.2, 0.5, 0.8, 1.3, 2.0, 5.0, 50.0])
    found = loop_margins(response(TEXTBOOK, coarse), coarse).modulus
    assert found == pytest.approx(0.63760, rel=2e-2)
    assert found < np.abs(1.0 + response(TEXTBOOK, coarse)).min()


def test_the_lines_of_a_multisine_are_enough():
    """45 lines over the band and a spline between them: a thousandth of a margin."""
    found = loop_margins(response(TEXTBOOK, OMEGA), OMEGA)
    assert (found.gain, found.phase) == pytest.approx((6.0, 53.411), rel=1e-3)
    assert found.modulus == pytest.approx(0.63760, rel=1e-3)


def test_a_delay_of_the_delay_margin_is_the_edge_of_stability():
    """The response delayed by it passes through -1."""
    found = loop_margins(response(TEXTBOOK, OMEGA), OMEGA)
    late = response(TEXTBOOK, np.array([found.crossover])) * np.exp(-1j * found.crossover * found.delay)
    assert late[0] == pytest.approx(-1.0, abs=1e-3)


def test_a_loop_that_never_crosses_has_infinite_margins():
    """Half a gain at every frequency: no delay and no doubling of the gain moves it to -1."""
    found = loop_margins(np.full(len(OMEGA), 0.5 + 0j), OMEGA)
    assert found.gain == found.phase == found.delay == np.inf
    assert found.modulus == pytest.approx(1.5)


@pytest.mark.parametrize("gain", [0.5, 3.0, 40.0])
def test_the_disk_margin_of_data_is_that_of_python_control(gain):
    """It takes no data; on a loop that both can have they must agree."""
    loop = mass_with_velocity_loop(gain)
    ours = disk_margin(response(loop, OMEGA), OMEGA)
    alpha, gain_db, phase = control.disk_margins(loop, OMEGA)
    assert ours.alpha == pytest.approx(alpha, rel=1e-9)
    assert 20.0 * np.log10(ours.gain) == pytest.approx(gain_db, rel=1e-9)
    assert ours.phase == pytest.approx(phase, rel=1e-9)


@pytest.mark.parametrize("period", [0.0, 1e-3])
def test_a_linearised_loop_goes_through_python_control(period):
    """Continuous and sampled, with the frequency of the worst case."""
    loop = mass_with_velocity_loop(3.0)
    sampled = control.sample_system(loop, period) if period else loop
    found = linear_disk_margin(sampled.A, sampled.B, sampled.C, sampled.D, omega=OMEGA, period=period)
    assert found.alpha == pytest.approx(disk_margin(response(sampled, OMEGA), OMEGA).alpha, rel=1e-9)
    assert found.omega in OMEGA


def test_alpha_beyond_two_bounds_no_gain():
    """The disk then holds every positive gain."""
    assert disk_margin(np.full(4, 0.999 + 0j), np.arange(1.0, 5.0)).gain > 1e3
    assert disk_margin(np.array([1.0 + 1e-12j]), np.array([1.0])).gain == np.inf


def closed_of(loops):
    """Return T of loops L, shape (F, n, n)."""
    return np.linalg.solve(np.eye(loops.shape[1]) + loops, loops)


def test_a_single_loop_makes_the_bound_of_many_its_own_disk_margin():
    """One channel has no other to go wrong with."""
    loop = response(mass_with_velocity_loop(3.0), OMEGA)
    many = multiloop_disk_margin(closed_of(loop[:, None, None]), OMEGA)
    single = disk_margin(loop, OMEGA)
    assert (many.alpha, many.gain, many.omega) == pytest.approx((single.alpha, single.gain, single.omega))


def test_loops_without_coupling_are_as_safe_as_the_worst_of_them():
    """A diagonal matrix has its entries for singular values."""
    loops = [response(mass_with_velocity_loop(gain), OMEGA) for gain in (0.5, 3.0)]
    diagonal = np.einsum("fi,ij->fij", np.stack(loops, axis=1), np.eye(2))
    worst = min(disk_margin(loop, OMEGA).alpha for loop in loops)
    assert multiloop_disk_margin(closed_of(diagonal), OMEGA).alpha == pytest.approx(worst)


def test_the_bound_of_many_loops_is_a_guarantee(rng):
    """No simultaneous error of the disk's size takes a coupled loop to the edge, and no single loop promises more."""
    loops = rng.normal(size=(1, 3, 3)) + 1j * rng.normal(size=(1, 3, 3))
    closed, omega = closed_of(loops), np.array([1.0])
    alpha = multiloop_disk_margin(closed, omega).alpha
    singles = [disk_margin(broken_loops(closed)[:, j], omega).alpha for j in range(3)]
    assert alpha <= min(singles) + 1e-12
    for _ in range(2000):
        delta = 0.999 * alpha * rng.uniform(size=3) * np.exp(2j * np.pi * rng.uniform(size=3))
        error = np.diag((1.0 + 0.5 * delta) / (1.0 - 0.5 * delta))
        assert abs(np.linalg.det(np.eye(3) + loops[0] @ error)) > 1e-9


def test_scaling_a_channel_does_not_loosen_the_bound_below_a_single_loop(rng):
    """Units of channels mean nothing: one-way coupling of any size costs no margin."""
    loop = response(mass_with_velocity_loop(3.0), OMEGA)
    chain = np.zeros((len(OMEGA), 2, 2), complex)
    chain[:, 0, 0] = chain[:, 1, 1] = loop
    chain[:, 0, 1] = 1e3
    assert multiloop_disk_margin(closed_of(chain), OMEGA).alpha == pytest.approx(disk_margin(loop, OMEGA).alpha)


def records(loops, lines, samples, periods, rng, noise=0.0):
    """Return what a linear controller puts out while one channel after the other is excited, in steady state."""
    n = loops.shape[1]
    injection = rng.normal(size=(n, samples))
    spectrum = np.fft.rfft(injection, axis=1)
    outputs = np.zeros((n, samples // 2 + 1, n), complex)
    outputs[:, lines] = -np.einsum("fij,jf->jfi", closed_of(loops), spectrum[:, lines])
    commands = np.repeat(np.fft.irfft(outputs, n=samples, axis=1)[:, None], periods, axis=1)
    return commands + noise * rng.normal(size=commands.shape), injection


def test_the_loop_is_found_in_its_records(rng):
    """Matrix and broken loops, from the outputs of a coupled loop alone."""
    lines = np.array([3, 5, 9, 17])
    loops = rng.normal(size=(4, 2, 2)) + 1j * rng.normal(size=(4, 2, 2))
    commands, injection = records(loops, lines, 64, 2, rng)
    closed = closed_loop(commands, injection, lines)
    assert closed[1] == pytest.approx(closed_of(loops))
    # Broken at channel 0 with the other closed: l00 - l01 l10 / (1 + l11).
    expected = loops[:, 0, 0] - loops[:, 0, 1] * loops[:, 1, 0] / (1.0 + loops[:, 1, 1])
    assert broken_loops(closed[1])[:, 0] == pytest.approx(expected)


def test_what_repeats_has_no_scatter_and_noise_has(rng):
    """Nobody may trust a response that another period would not give, and noise must be seen in proportion."""
    lines = np.array([3, 5, 9, 17])
    loops = 0.5 * (rng.normal(size=(4, 2, 2)) + 1j * rng.normal(size=(4, 2, 2)))
    found = [scatter(closed_loop(*records(loops, lines, 64, 4, rng, noise), lines)) for noise in (0.0, 0.01, 0.1)]
    assert found[0].max() < 1e-12
    assert np.all(found[2] > 3.0 * found[1]) and np.all(found[1] > 0.0)
