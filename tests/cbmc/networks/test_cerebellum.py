"""The cerebellum: golden numbers, the folded readout, and single against double precision."""

import numpy as np
import pytest
from torquebench.cbmc import reference
from torquebench.cbmc.cerebellum import Cerebellum, CerebellumTable
from torquebench.cbmc.patterns import Patterns

POSTURE = np.array([0.1, -0.7, 0.05, 1.6, -0.02, 0.7, 0.1])
GOLDEN = [-0.005089248, -0.006833152, 0.007536768, -0.005494592, 0.004471104, 0.001487968, -0.004545376]


@pytest.fixture
def cerebellum(golden_cerebellum, pathways):
    cerebellum = Cerebellum(golden_cerebellum.folded(copies=2))
    cerebellum.connect(*pathways)
    return cerebellum


def test_the_kernel_gives_the_golden_torque_and_spikes(cerebellum, pathways):
    """Single precision, both patterns in one call."""
    up, down = pathways
    up.q[:] = POSTURE
    cerebellum.compensate()
    for p in range(2):
        assert down.compensation[p] == pytest.approx(GOLDEN, abs=2e-6)
    assert cerebellum.granule_spikes.tolist() == [414, 414]
    assert cerebellum.purkinje_spikes.tolist() == [44, 44]


def test_the_plain_form_gives_the_golden_torque_and_spikes(golden_cerebellum):
    """Double precision on single precision weights."""
    answer = reference.compensate(golden_cerebellum.folded(), CerebellumTable(), POSTURE)
    assert answer.torque[0] == pytest.approx(GOLDEN, abs=1e-7)
    assert (answer.granule.sum(), answer.purkinje.sum()) == (414, 44)


def test_the_folded_readout_equals_all_140_nuclei(golden_cerebellum, peers):
    """Groups of 20 averaged; the golden gradients are SpikingJelly's autograd."""
    torque, granule, purkinje, first, second = golden_cerebellum.run(*peers, POSTURE)
    assert torque == pytest.approx(GOLDEN, abs=1e-9)
    assert (granule, purkinje) == (414, 44)
    assert np.abs(first).sum() == pytest.approx(5.039632080295, abs=1e-9)
    assert np.abs(second).sum() == pytest.approx(88.529827557534, abs=1e-8)


def random_patterns(rng):
    """Return two patterns with torch's default weights: no sum sits on a threshold, as a formula's does."""

    def draw(inputs, *shape):
        return rng.uniform(-1.0, 1.0, shape).astype(np.float32) / np.float32(np.sqrt(inputs))

    return Patterns(
        granule=draw(7, 2, 300, 7),
        granule_bias=draw(7, 2, 300),
        purkinje=4.0 * draw(600, 2, 300, 400),
        purkinje_bias=draw(600, 2, 200),
        readout=10.0 * draw(200, 2, 7, 200),
        readout_bias=draw(200, 2, 7),
        loads=(0.0, 3.0),
    )


def test_single_precision_equals_double_over_postures(pathways):
    """Every spike the same, torques within 1e-4 N m; a spike may flip in principle, on these seeds none does."""
    up, down = pathways
    rng = np.random.default_rng(2)
    cerebellum = Cerebellum(random_patterns(rng))
    cerebellum.connect(up, down)
    for _ in range(30):
        up.q[:] = rng.uniform(-2.0, 2.0, 7)
        cerebellum.compensate()
        plain = reference.compensate(cerebellum.patterns, cerebellum.table, up.q)
        assert cerebellum.granule_spikes.tolist() == plain.granule.sum(axis=(1, 2)).tolist()
        assert cerebellum.purkinje_spikes.tolist() == plain.purkinje.sum(axis=(1, 2)).tolist()
        assert down.compensation == pytest.approx(plain.torque, abs=1e-4)


def test_a_window_forgets_the_one_before(cerebellum, pathways):
    """Networks are reset for each call."""
    up, down = pathways
    up.q[:] = POSTURE
    cerebellum.compensate()
    first = down.compensation.copy()
    up.q[:] = -POSTURE
    cerebellum.compensate()
    assert not np.array_equal(first, down.compensation)
    up.q[:] = POSTURE
    cerebellum.compensate()
    assert down.compensation.tolist() == first.tolist()
