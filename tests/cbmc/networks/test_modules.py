"""Thalamus, brainstem and cortex: what they make of their networks, and what learning changes."""

import tracemalloc
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from torquebench.cbmc import reference
from torquebench.cbmc.brainstem import Brainstem, BrainstemTable
from torquebench.cbmc.cerebellum import Cerebellum
from torquebench.cbmc.cerebral_cortex import CerebralCortex
from torquebench.cbmc.neuron import Lif
from torquebench.cbmc.pathways import Ascending, Descending
from torquebench.cbmc.spinal_cord import RateEncoder, SpinalCord, SpinalCordTable
from torquebench.cbmc.thalamus import Thalamus, ThalamusTable


@pytest.fixture
def thalamus(pathways):
    return make_thalamus(pathways)


def make_thalamus(pathways, *, table=None, seed=0, **settings):
    thalamus = Thalamus(7, 2, table or ThalamusTable(), np.random.default_rng(seed), **settings)
    thalamus.connect(*pathways)
    return thalamus


@pytest.fixture
def brainstem(pathways):
    brainstem = Brainstem(7, BrainstemTable(), np.random.default_rng(0))
    brainstem.connect(*pathways)
    return brainstem


def plain_form(module):
    """Return the NumPy form of a module's network with its parameters."""
    network = module.network
    blocks = (network.hidden_weights, network.hidden_biases, network.output_weights, network.output_biases)
    return reference.TwoLayers(
        parameters=[block.copy() for block in blocks],
        hidden=network.hidden,
        output=network.output,
        window=network.window,
        surrogate_slope=network.surrogate_slope,
    )


def test_weights_are_the_softmax_of_the_potentials_for_scaled_forces(thalamus, pathways):
    """Forces over 50 N, torques over 10 N m."""
    up, down = pathways
    thalamus.weigh()
    potentials = plain_form(thalamus).forward(up.wrench / np.repeat([50.0, 10.0], 3))
    expected = np.exp(potentials) / np.exp(potentials).sum()
    assert down.weights == pytest.approx(expected, abs=1e-14)


def test_raw_forces_are_an_option(pathways):
    """A scale of one leaves newtons."""
    up, down = pathways
    thalamus = make_thalamus(pathways, force_scale=(1.0, 1.0))
    thalamus.weigh()
    assert thalamus.network.inputs.tolist() == up.wrench.tolist()
    assert down.weights.sum() == pytest.approx(1.0)


@pytest.mark.parametrize("reset", [0.0, 10.0, 700.0])
def test_the_output_reset_has_no_effect_on_weights_or_learning(pathways, reset):
    """Softmax does not see a shift: the table's 10 is kept, and is no tuning number."""
    _, down = pathways
    shifted = replace(ThalamusTable(), output=Lif(u_reset=reset, tau_mb=5.0))
    answers = []
    for table in (ThalamusTable(), shifted):
        thalamus = make_thalamus(pathways, table=table)
        thalamus.weigh()
        thalamus.learn(np.array([0.3, -1.0]))
        answers.append((down.weights.copy(), thalamus.network.parameters.copy()))
    assert answers[0][0] == pytest.approx(answers[1][0], abs=1e-12)
    assert answers[0][1] == pytest.approx(answers[1][1], abs=1e-12)


def test_the_filter_layer_is_a_low_pass_of_the_mixture_with_unit_gain(thalamus, pathways):
    """Step response 1 - 0.8^k; settling puts it at the end."""
    _, down = pathways
    down.weights[:] = (0.25, 0.75)
    mixture = 0.25 * down.compensation[0] + 0.75 * down.compensation[1]
    for k in range(1, 6):
        thalamus.combine()
        assert down.gravity_torque == pytest.approx((1.0 - 0.8**k) * mixture, abs=1e-12)
    thalamus.settle()
    assert down.gravity_torque == pytest.approx(mixture, abs=1e-12)


def test_the_thalamus_descends_along_the_softmax(thalamus, pathways):
    """dL/du_p = w_p (dL/dw_p - sum_r w_r dL/dw_r), then the network's own gradient."""
    up, down = pathways
    thalamus.weigh()
    plain, weights, gradient = plain_form(thalamus), down.weights.copy(), np.array([2.0, -1.0])
    plain.forward(up.wrench / np.repeat([50.0, 10.0], 3))
    expected = plain.backward(weights * (gradient - weights @ gradient))
    reference.descend(plain.parameters, [0 * p for p in plain.parameters], expected, thalamus.table.descent)
    thalamus.learn(gradient)
    assert thalamus.network.parameters == pytest.approx(
        np.concatenate([p.ravel() for p in plain.parameters]), abs=1e-13
    )
    thalamus.weigh()
    assert down.weights[1] > weights[1]


def test_gains_are_scaled_potentials_of_the_raw_signals(brainstem, pathways):
    """k_p = 20 u, k_v = 2 u; without a range nothing is clamped."""
    up, down = pathways
    brainstem.gains()
    u = plain_form(brainstem).forward(np.concatenate([up.q_desired, up.dq_desired, up.q, up.dq]))
    assert down.stiffness == pytest.approx(20.0 * u[:7], abs=1e-11)
    assert down.damping == pytest.approx(2.0 * u[7:], abs=1e-11)
    assert not brainstem.clamped.any()


def test_gains_at_birth_are_about_200_and_20(pathways):
    """The output neurons' reset of 10 is the bias of the gains."""
    _, down = pathways
    drawn = []
    for seed in range(50):
        brainstem = Brainstem(7, BrainstemTable(), np.random.default_rng(seed))
        brainstem.connect(*pathways)
        brainstem.gains()
        drawn.append([*down.stiffness, *(10.0 * down.damping)])
    assert np.mean(drawn) == pytest.approx(200.0, abs=5.0)
    assert 5.0 < np.std(drawn) < 12.0


def test_a_gain_out_of_range_takes_the_end_and_is_counted(brainstem, pathways):
    """Rows low and high, for k_p and k_v apart."""
    _, down = pathways
    brainstem.stiffness_range[:, 2] = (300.0, 400.0)
    brainstem.damping_range[:, 5] = (1.0, 3.0)
    for _ in range(4):
        brainstem.gains()
    assert (down.stiffness[2], down.damping[5]) == (300.0, 3.0)
    assert brainstem.clamped[0, 0, 2] == 4 and brainstem.clamped[1, 1, 5] == 4
    assert brainstem.clamped.sum() == 8


@pytest.mark.parametrize(("pull", "learns"), [(-1.0, True), (1.0, False)])
def test_a_gain_at_its_floor_learns_only_upwards(brainstem, pathways, pull, learns):
    """What pushes a clamped gain further out is left out, so that it can come back at once."""
    brainstem.stiffness_range[:, 0] = (300.0, 400.0)
    brainstem.gains()
    gradient = np.zeros(14)
    gradient[0] = pull
    before = brainstem.network.parameters.copy()
    brainstem.learn(gradient)
    assert (brainstem.network.parameters.tolist() != before.tolist()) == learns


def test_the_brainstem_descends_along_its_scales(brainstem, pathways):
    """dL/du = (20 dL/dk_p, 2 dL/dk_v)."""
    up, _ = pathways
    brainstem.gains()
    plain, gradient = plain_form(brainstem), np.linspace(-1e-3, 1e-3, 14)
    plain.forward(np.concatenate([up.q_desired, up.dq_desired, up.q, up.dq]))
    brainstem.learn(gradient)
    expected = np.concatenate([g.ravel() for g in plain.backward(gradient * np.repeat([20.0, 2.0], 7))])
    assert brainstem.network.gradient == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(("joints", "patterns"), [(1, 1), (3, 4)])
def test_any_number_of_joints_and_patterns_will_do(joints, patterns):
    """Seven and two are the paper's numbers, not the library's."""
    rng, up, down = np.random.default_rng(0), Ascending.of(joints), Descending.of(joints, patterns)
    down.compensation[:] = rng.normal(size=(patterns, joints))
    thalamus = Thalamus(joints, patterns, ThalamusTable(), rng)
    brainstem = Brainstem(joints, BrainstemTable(), rng)
    thalamus.connect(up, down)
    brainstem.connect(up, down)
    thalamus.weigh()
    thalamus.settle()
    brainstem.gains()
    assert down.weights.sum() == pytest.approx(1.0)
    assert down.gravity_torque == pytest.approx(down.weights @ down.compensation)
    assert down.stiffness == pytest.approx(20.0 * plain_form(brainstem).forward(np.zeros(4 * joints))[:joints])


def test_the_cortex_replays_the_plan(pathways):
    """Positions and velocities, copied."""
    up, _ = pathways
    cortex, target = CerebralCortex(), SimpleNamespace(q=np.arange(7.0), dq=-np.arange(7.0))
    cortex.connect(up)
    cortex.replay(target)
    assert up.q_desired.tolist() == target.q.tolist() and up.dq_desired.tolist() == target.dq.tolist()


def test_a_tick_of_all_modules_allocates_nothing(pathways, thalamus, brainstem, golden_cerebellum):
    """A garbage collection in the loop would be a late tick."""
    table = SpinalCordTable()
    cerebellum = Cerebellum(golden_cerebellum.folded(copies=2))
    spinal_cord = SpinalCord(7, table, RateEncoder(7, table, np.random.default_rng(0)))
    cerebellum.connect(*pathways)
    spinal_cord.connect(*pathways)
    weight_gradient, gain_gradient = np.zeros(2), np.zeros(14)

    def tick():
        spinal_cord.act()
        brainstem.gains()
        brainstem.learn(gain_gradient)
        thalamus.weigh()
        thalamus.combine()
        thalamus.learn(weight_gradient)
        cerebellum.compensate()

    tick()
    tracemalloc.start()
    try:
        for _ in range(40):
            tick()
        before, _ = tracemalloc.get_traced_memory()
        tracemalloc.reset_peak()
        for _ in range(400):
            tick()
        after, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # What peaks are the frames and tuples of a call; the smallest buffer of a tick would be ten times that.
    assert after - before < 256 and peak - before < 4096
