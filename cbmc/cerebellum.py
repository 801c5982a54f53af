"""The cerebellum: gravity torques by heart, one trained network for each load it was taught.

Source: the paper's section "Cerebellum module", its table of training and neuron parameters, and its algorithms.
Mossy fibres (joint angles) to granule cells (GC) to Purkinje cells (PC), which see GC now and one step ago, to deep
cerebellar nuclei (DCN), non-spiking, 20 neurons for each joint, averaged (the text; the printed sum differs by a
learning rate only). Angles are a constant current for the window. It learns before a run, never in it.
"""

from dataclasses import dataclass, field

import numba
import numpy as np

from ..controllers.kernels import bind
from .neuron import Lif
from .pathways import Ascending, Descending
from .patterns import Patterns

GRANULE, PURKINJE, GRANULE_LAST, GRANULE_PAIRS, PURKINJE_PAIRS = range(5)

LEAK = 6  # in the kernels' constants: tau, reset, threshold of GC and of PC, then the DCN's leak


@dataclass(frozen=True, kw_only=True)
class CerebellumTable:
    """The paper's table "Training and neuron parameters of the cerebellum module", its neurons.

    Numbers of neurons are the trained patterns' own.

    Attributes:
        granule: GC, LIF neurons.
        purkinje: PC, LIF neurons.
        nuclei: DCN, non-spiking neurons.
        nuclei_per_joint: DCN neurons that answer for one joint; folded into one row when patterns are saved.
        window: Steps of a window, T.
    """

    granule: Lif = field(default=Lif(u_reset=0.0, u_fire=0.1, tau_mb=10.0))
    purkinje: Lif = field(default=Lif(u_reset=0.0, u_fire=0.1, tau_mb=10.0))
    nuclei: Lif = field(default=Lif(u_reset=0.0, tau_mb=5.0))
    nuclei_per_joint: int = 20
    window: int = 10


PAPER = CerebellumTable()


class Cerebellum:
    r"""All patterns at once, in single precision.

    The DCN is linear in the PC spikes, so a pattern's answer is one product with their trace,
    :math:`\tau_\text{cb} = R \sum_t c_t s_\text{PC}(t) + r`, where c is the DCN's leak (``neuron.Lif.leak``).

    Attributes:
        patterns: The trained patterns.
        granule_spikes: GC spikes of each pattern in the last window, shape (P,), int64.
        purkinje_spikes: PC spikes, shape (P,), int64.
        tally: Calls so far, shape (1,), int64.
        counted: Sums over all calls, shape (5, P), int64: GC spikes, PC spikes, GC spikes in a window's last step,
            pairs of spikes in consecutive steps of GC, and of PC.
    """

    def __init__(self, patterns: Patterns, table: CerebellumTable = PAPER) -> None:
        """Take trained patterns."""
        self.patterns, self.table = patterns, table
        count, granule, _ = patterns.granule.shape
        purkinje = patterns.purkinje_bias.shape[1]
        cells = [value for layer in (self.table.granule, self.table.purkinje) for value in _numbers(layer)]
        self._constants = np.array([*cells, *self.table.nuclei.leak(self.table.window)], dtype=np.float32)
        self._potentials = np.zeros(2 * granule + 4 * purkinje, dtype=np.float32)
        self._fired = np.zeros(4 * granule + 3 * purkinje, dtype=np.int32)
        self._last = np.zeros((5, count), dtype=np.int64)
        self.granule_spikes, self.purkinje_spikes = self._last[GRANULE], self._last[PURKINJE]
        self.tally, self.counted = np.zeros(1, dtype=np.int64), np.zeros((5, count), dtype=np.int64)

    def connect(self, ascending: Ascending, descending: Descending) -> None:
        """Join the pathways; their arrays are the module's input and output from now on."""
        trained = self.patterns
        layers = (trained.granule, trained.granule_bias, trained.purkinje, trained.purkinje_bias)
        weights = tuple(
            np.ascontiguousarray(w, dtype=np.float32) for w in (*layers, trained.readout, trained.readout_bias)
        )
        scratch = (self._constants, self._potentials, self._fired, self._last, self.counted, self.tally)
        self._compensate = bind(_compensate, ascending.q, *weights, *scratch, descending.compensation)

    def compensate(self) -> None:
        """Fill ``descending.compensation`` with each pattern's gravity torque at ``ascending.q``: one window."""
        self._compensate()


def _numbers(layer: Lif) -> tuple[float, float, float]:
    return layer.tau_mb, layer.u_reset, layer.u_fire


@numba.njit(cache=True)
def _step(current, potential, fired, sums, pairs, tau, reset, fire):  # type: ignore[no-untyped-def]
    """Charge, fire and reset a layer; counts spikes and pairs of consecutive ones, each neuron its own."""
    for i in range(current.shape[0]):
        charged = potential[i] + (current[i] - (potential[i] - reset)) / tau
        spike = np.int32(charged >= fire)
        potential[i] = reset if charged >= fire else charged
        sums[i] += spike
        pairs[i] += spike & fired[i]
        fired[i] = spike


@numba.njit(cache=True)
def _excite(current, rows, fired, indices, width):  # type: ignore[no-untyped-def]
    """Add the weight row of every neuron that fired; four rows at once, in the order of one by one."""
    count = 0
    for g in range(fired.shape[0]):
        indices[count] = g
        count += fired[g]
    k = 0
    while k + 4 <= count:
        a, b, c, d = rows[indices[k]], rows[indices[k + 1]], rows[indices[k + 2]], rows[indices[k + 3]]
        for j in range(width):
            current[j] = (((current[j] + a[j]) + b[j]) + c[j]) + d[j]
        k += 4
    while k < count:
        a = rows[indices[k]]
        for j in range(width):
            current[j] += a[j]
        k += 1
    return count


@numba.njit(cache=True)
def _run_window(rows, offset, constants, potentials, fired, counts):  # type: ignore[no-untyped-def]
    """Run GC and PC for one window on the input current in ``potentials``; leaves the PC trace at its end.

    ``rows`` holds, for each GC, its weights to PC in this step before those in the next, so that a spike adds one
    contiguous row and the next step's half is already waiting.
    """
    gc, pc = rows.shape[0], offset.shape[0]
    constant, u_gc = potentials[:gc], potentials[gc : 2 * gc]
    current, waiting = potentials[2 * gc : 2 * gc + 2 * pc], potentials[2 * gc + pc : 2 * gc + 2 * pc]
    u_pc, trace = potentials[2 * gc + 2 * pc : 2 * gc + 3 * pc], potentials[2 * gc + 3 * pc :]
    fired_gc, pairs_gc, sums_gc, indices = (
        fired[:gc],
        fired[gc : 2 * gc],
        fired[2 * gc : 3 * gc],
        fired[3 * gc : 4 * gc],
    )
    fired_pc, pairs_pc, sums_pc = (
        fired[4 * gc : 4 * gc + pc],
        fired[4 * gc + pc : 4 * gc + 2 * pc],
        fired[4 * gc + 2 * pc :],
    )
    fired[:] = 0
    u_gc[:], u_pc[:], current[:], trace[:] = constants[1], constants[4], 0.0, 0.0
    steps, last = constants.shape[0] - LEAK, 0
    for t in range(steps):
        current[:pc] = offset + waiting
        waiting[:] = 0.0
        _step(constant, u_gc, fired_gc, sums_gc, pairs_gc, constants[0], constants[1], constants[2])
        # Nobody sees what the last step leaves for the next.
        last = _excite(current, rows, fired_gc, indices, 2 * pc if t + 1 < steps else pc)
        _step(current[:pc], u_pc, fired_pc, sums_pc, pairs_pc, constants[3], constants[4], constants[5])
        for j in range(pc):
            trace[j] += constants[LEAK + t] * np.float32(fired_pc[j])
    counts[GRANULE], counts[PURKINJE], counts[GRANULE_LAST] = sums_gc.sum(), sums_pc.sum(), last
    counts[GRANULE_PAIRS], counts[PURKINJE_PAIRS] = pairs_gc.sum(), pairs_pc.sum()


@numba.njit(cache=True)
def _compensate(  # type: ignore[no-untyped-def]
    q,
    granule,
    granule_bias,
    purkinje,
    purkinje_bias,
    readout,
    readout_bias,
    constants,
    potentials,
    fired,
    last,
    counted,
    tally,
    compensation,
):
    """Run every pattern: input current, window, readout."""
    tally[0] += 1
    gc, pc = granule.shape[1], purkinje_bias.shape[1]
    trace = potentials[2 * gc + 3 * pc :]
    for p in range(granule.shape[0]):
        for g in range(gc):
            current = granule_bias[p, g]
            for i in range(q.shape[0]):
                current += granule[p, g, i] * np.float32(q[i])
            potentials[g] = current
        _run_window(purkinje[p], purkinje_bias[p], constants, potentials, fired, last[:, p])
        for i in range(q.shape[0]):
            torque = readout_bias[p, i]
            for j in range(pc):
                torque += readout[p, i, j] * trace[j]
            compensation[p, i] = torque
    counted += last
