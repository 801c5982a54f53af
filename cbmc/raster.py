"""A spike raster on request: which neuron of which layer fired at which step of which window, up to a bound.

The compiled networks count spikes and keep no times. A listener stands before a module, lets it answer, and runs the
plain form of the same window beside it, before anything is learnt from the answer.
"""

from collections.abc import Callable, Mapping

import numpy as np

from .cerebellum import Cerebellum
from .neuron import run_window
from .online_network import OnlineNetwork
from .pathways import Ascending
from .reference import compensate

FIELDS = ("window", "step", "neuron")


class Raster:
    """Bounded buffers of spikes, one for each layer."""

    def __init__(self, capacity: int) -> None:
        """Allocate nothing yet.

        Args:
            capacity: Most spikes that a layer's buffer holds; later ones are dropped.
        """
        self._capacity = capacity
        self._buffers: dict[str, np.ndarray] = {}
        self._used: dict[str, int] = {}
        self._windows: dict[str, int] = {}

    def note(self, layer: str, spikes: np.ndarray) -> None:
        """Take one window of a layer.

        Args:
            layer: Name of the layer.
            spikes: 0 or 1, shape (T, neurons).
        """
        buffer = self._buffers.setdefault(layer, np.zeros((self._capacity, len(FIELDS)), dtype=np.int32))
        used, window = self._used.get(layer, 0), self._windows.get(layer, 0)
        steps, neurons = np.nonzero(spikes)
        fits = min(len(steps), self._capacity - used)
        buffer[used : used + fits, 0] = window
        buffer[used : used + fits, 1] = steps[:fits]
        buffer[used : used + fits, 2] = neurons[:fits]
        self._used[layer], self._windows[layer] = used + fits, window + 1

    def events(self) -> Mapping[str, np.ndarray]:
        """Return layer to rows of window, step, neuron, shape (spikes, 3), int32."""
        return {f"spikes_{layer}": buffer[: self._used[layer]] for layer, buffer in self._buffers.items()}


def listen_to_network(
    raster: Raster, layer: str, network: OnlineNetwork, answer: Callable[[], None]
) -> Callable[[], None]:
    """Return a module's answer that also notes its hidden spikes.

    Args:
        raster: Takes the spikes.
        layer: Name of the layer.
        network: The module's network.
        answer: What fills its outputs.
    """

    def listened() -> None:
        answer()
        current = network.hidden_weights @ network.inputs + network.hidden_biases
        raster.note(layer, run_window(np.broadcast_to(current, (network.window, current.size)), network.hidden).spikes)

    return listened


def listen_to_cerebellum(raster: Raster, module: Cerebellum, ascending: Ascending) -> Callable[[], None]:
    """Return a cerebellum's answer that also notes the GC and PC spikes of every pattern."""
    answer = module.compensate

    def listened() -> None:
        answer()
        told = compensate(module.patterns, module.table, ascending.q)
        for p, (granule, purkinje) in enumerate(zip(told.granule, told.purkinje, strict=True)):
            raster.note(f"granule_{p}", granule)
            raster.note(f"purkinje_{p}", purkinje)

    return listened
