"""Named random streams: adding one moves no other, and all controllers share all but their own."""

import hashlib
from collections.abc import Sequence

import numpy as np

from .specification import RunSpecification, canonical_json


def scenario_stream(name: str, specification: RunSpecification) -> np.random.Generator:
    """Return a generator that every controller, plant, tier and load history of a motion and repetition shares.

    Args:
        name: Name of the stream, for example ``"sensor"``.
        specification: The run; only robot, trajectory, campaign seed and repetition count.
    """
    return np.random.default_rng(_sequence(name, specification, ()))


def controller_seed(specification: RunSpecification) -> int:
    """Return the seed of a controller's own stream; it depends on its name and settings, not on its knowledge."""
    own = (specification.controller, canonical_json(dict(specification.settings)))
    return int(_sequence("controller", specification, own).generate_state(1, np.uint64)[0])


def _sequence(name: str, specification: RunSpecification, extra: Sequence[str]) -> np.random.SeedSequence:
    words = (_word(name), *_words(specification.robot, specification.trajectory), specification.repetition)
    return np.random.SeedSequence(specification.campaign, spawn_key=(*words, *_words(*extra)))


def _words(*texts: str) -> tuple[int, ...]:
    return tuple(_word(text) for text in texts)


def _word(text: str) -> int:
    """Return the first 32 bits of a text's SHA-256; Python's own hash differs from process to process."""
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "big")
