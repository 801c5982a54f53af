"""Operation counts: closed formulas at the paper's sizes, and what forced spikes make of them."""

from dataclasses import replace

import numpy as np
import pytest
from torquebench.cbmc.brainstem import Brainstem, BrainstemTable
from torquebench.cbmc.cerebellum import Cerebellum, CerebellumTable
from torquebench.cbmc.neuron import Lif
from torquebench.cbmc.operations import count_operations
from torquebench.cbmc.reference import compensate
from torquebench.cbmc.spinal_cord import ExactEncoder, RateEncoder, SpinalCord, SpinalCordTable
from torquebench.cbmc.thalamus import Thalamus, ThalamusTable

ALWAYS = -1e30
"""A threshold that every neuron reaches at every step."""


@pytest.fixture
def make(pathways, golden_cerebellum):
    """Return a builder of all modules that have each run once."""

    def build(*, fire=None):
        def forced(lif):
            return lif if fire is None else Lif(u_reset=lif.u_reset, u_fire=fire, tau_mb=lif.tau_mb)

        rng = np.random.default_rng(0)
        first, second, third, spinal = ThalamusTable(), BrainstemTable(), CerebellumTable(), SpinalCordTable()
        third = replace(third, granule=forced(third.granule), purkinje=forced(third.purkinje))
        modules = (
            Cerebellum(golden_cerebellum.folded(copies=2), third),
            Thalamus(7, 2, replace(first, hidden=forced(first.hidden)), rng),
            Brainstem(7, replace(second, hidden=forced(second.hidden)), rng),
            SpinalCord(7, spinal, RateEncoder(7, spinal, rng)),
        )
        for module in modules:
            module.connect(*pathways)
        cerebellum, thalamus, brainstem, spinal_cord = modules
        cerebellum.compensate()
        thalamus.weigh()
        thalamus.combine()
        brainstem.gains()
        spinal_cord.act()
        return modules

    return build


def test_counts_at_the_papers_sizes_follow_the_closed_formulas(make):
    """One call of each module, two patterns."""
    counts = count_operations(*make())
    dense = [counts[f"{name}_dense"] for name in ("cerebellum", "thalamus", "brainstem", "spinal_cord")]
    assert dense == [3_002_000, 400, 6_300, 1_400]
    macs = [counts[f"{name}_effective_macs"] for name in ("cerebellum", "thalamus", "brainstem", "spinal_cord")]
    assert macs == [42_000, 300, 4_200, 0]
    membrane = [counts[f"{name}_membrane_dense"] for name in ("cerebellum", "thalamus", "brainstem", "spinal_cord")]
    assert membrane == [12_800, 77, 360, 7]
    assert counts["spinal_cord_other"] == 14 and counts["spinal_cord_random_draws"] == 700


def test_effective_counts_follow_the_spikes(make, pathways):
    """200 (n_GC + n_GC without the last step) + 140 n_PC; outputs times hidden spikes; single spinal spikes."""
    up, _ = pathways
    modules = make()
    counts, (cerebellum, thalamus, brainstem, spinal_cord) = count_operations(*modules), modules
    plain = compensate(cerebellum.patterns, cerebellum.table, up.q)
    gc, pc = plain.granule, plain.purkinje
    assert counts["cerebellum_effective_acs"] == 200 * (gc.sum() + gc[:, :-1].sum()) + 140 * pc.sum()
    pairs = sum((layer[:, 1:] * layer[:, :-1]).sum() for layer in (gc, pc))
    assert counts["cerebellum_membrane_updates"] == 12_800 - pairs
    assert counts["thalamus_effective_acs"] == 2 * thalamus.network.hidden_spikes.sum()
    assert counts["brainstem_effective_acs"] == 14 * brainstem.network.hidden_spikes.sum()
    assert counts["spinal_cord_effective_acs"] == np.abs(spinal_cord.spikes).sum()


@pytest.mark.parametrize("name", ["cerebellum", "thalamus", "brainstem", "spinal_cord"])
def test_effective_is_never_more_than_dense(make, name):
    """Operations and membrane updates alike."""
    counts = count_operations(*make())
    assert counts[f"{name}_effective_macs"] + counts[f"{name}_effective_acs"] <= counts[f"{name}_dense"]
    assert counts[f"{name}_membrane_updates"] <= counts[f"{name}_membrane_dense"]


def test_forced_spikes_make_effective_equal_dense(make):
    """Except that the first step of a cerebellum window has no previous GC step: 300 x 200 a pattern."""
    counts = count_operations(*make(fire=ALWAYS))
    for name, missing in (("thalamus", 0), ("brainstem", 0), ("cerebellum", 2 * 300 * 200)):
        effective = counts[f"{name}_effective_macs"] + counts[f"{name}_effective_acs"]
        assert effective == counts[f"{name}_dense"] - missing
    # A neuron that fires at every step moves its potential on the first only.
    assert counts["thalamus_membrane_updates"] == 77 - 5 * 9
    assert counts["cerebellum_membrane_updates"] == 12_800 - 2 * 500 * 9


def test_saturated_errors_fire_one_half_of_all_fibres(pathways):
    """The other half of an agonist-antagonist pair is always silent."""
    up, _ = pathways
    up.q_desired[:], up.dq_desired[:] = up.q + 1.0, up.dq - 1.0
    table = SpinalCordTable()
    spinal_cord = SpinalCord(7, table, RateEncoder(7, table, np.random.default_rng(0)))
    spinal_cord.connect(*pathways)
    spinal_cord.act()
    counts = count_operations(spinal_cord)
    assert counts["spinal_cord_effective_acs"] == counts["spinal_cord_dense"] // 2 == 700


def test_counts_grow_with_calls_and_learning_stands_apart(make):
    """Ten more windows and three updates; a skipped update costs its backward pass, and moves nothing."""
    *_, brainstem, _ = make()
    for _ in range(10):
        brainstem.gains()
    for gradient in (np.zeros(14), np.ones(14) * 1e-6, np.full(14, np.nan)):
        brainstem.learn(gradient)
    counts = count_operations(brainstem)
    assert counts["brainstem_calls"] == 11 and counts["brainstem_dense"] == 11 * 6_300
    assert counts["brainstem_learning_macs"] == 3 * 2 * 6_300
    assert counts["brainstem_parameter_updates"] == 2 * 444


def test_whatever_has_no_spikes_counts_none(pathways):
    """Stand-ins have no neurons, the exact encoder no fibres."""
    spinal_cord = SpinalCord(7, SpinalCordTable(), ExactEncoder(7))
    spinal_cord.connect(*pathways)
    spinal_cord.act()
    counts = count_operations(object(), spinal_cord)
    assert counts["spinal_cord_dense"] == counts["spinal_cord_random_draws"] == 0
    assert counts["spinal_cord_membrane_updates"] == 7
    assert all(isinstance(value, int) for value in counts.values())
