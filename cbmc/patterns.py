"""Motor patterns of the cerebellum: trained weights, one set for each load, with how they were made.

A file of patterns is two: ``NAME.safetensors`` with the arrays, and ``NAME.json`` beside it that says whose they are,
how they were made and how well they do. Neither holds a date, so that the same training gives the same bytes.
"""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load, save

from ..controllers import InvalidInput, RobotModel

ARRAYS = ("granule", "granule_bias", "purkinje", "purkinje_bias", "readout", "readout_bias")
"""The arrays of :class:`Patterns`, by their names in a file."""
SCHEMA = 1
"""Layout of the notes that this version reads."""
KEY_POSTURES = 4
"""Postures at which an arm's gravity is looked at."""
KEY_RESOLUTION = 1e-6
"""Gravity torques nearer than this are the same arm's [N m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Patterns:
    """Trained patterns of one robot; arrays are float32, folded for inference.

    The input scaling is folded into the first layer and the DCN's groups of neurons into one row a joint, so that a
    window's answer is ``readout @ z + offset`` with z the PC spikes weighted by the DCN's leak (see ``cerebellum``).

    Attributes:
        granule: Weights from joint angles to GC, raw radians, shape (P, GC, n).
        granule_bias: Shape (P, GC).
        purkinje: Weights from GC to PC, for each GC row the current step's PC weights before the previous step's,
            shape (P, GC, 2 PC).
        purkinje_bias: Shape (P, PC).
        readout: Folded DCN weights, mean over each group, shape (P, n, PC) [N m].
        readout_bias: Folded DCN offsets, the window's leak included, shape (P, n) [N m].
        loads: Load beyond the gripper of each pattern, shape (P,) [kg].
        notes: How they were made: robot, recipe, seed, evaluation.
    """

    granule: np.ndarray
    granule_bias: np.ndarray
    purkinje: np.ndarray
    purkinje_bias: np.ndarray
    readout: np.ndarray
    readout_bias: np.ndarray
    loads: tuple[float, ...]
    notes: Mapping[str, object] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of patterns."""
        return int(self.granule.shape[0])

    @property
    def joints(self) -> int:
        """Number of joints."""
        return int(self.granule.shape[2])


def robot_key(model: RobotModel) -> str:
    """Return what an arm is to its patterns: a digest of its gravity, with nothing and with a load on the flange.

    Rotor inertia, limits, tool point, and a payload that knowledge has set make no difference.

    Args:
        model: The arm; it is copied.
    """
    bare = model.copy()
    torques = []
    for payload in (np.zeros(10), _probe()):
        bare.set_payload(payload)
        # Fixed, without pattern, and far apart in every joint.
        angles = 2.0 * np.sin(1.0 + np.arange(KEY_POSTURES * bare.n) ** 2.0).reshape(KEY_POSTURES, bare.n)
        torques += [bare.gravity(q) for q in angles]
    rounded = np.rint(np.array(torques) / KEY_RESOLUTION).astype(np.int64)
    return hashlib.sha256(rounded.astype("<i8").tobytes()).hexdigest()[:16]


def save_patterns(file: Path, patterns: Patterns) -> None:
    """Write patterns: arrays to a file, notes to a JSON beside it.

    Args:
        file: A path that ends in ``.safetensors``; missing folders are made.
        patterns: The patterns.

    Raises:
        InvalidInput: If the name ends in something else or the file cannot be written.
    """
    if file.suffix != ".safetensors":
        raise InvalidInput(f"patterns cannot be written to {file.name}", str(file), "give a name in .safetensors")
    content = save({name: np.ascontiguousarray(getattr(patterns, name), dtype=np.float32) for name in ARRAYS})
    notes = {
        "schema": SCHEMA,
        "loads": list(patterns.loads),
        **patterns.notes,
        "sha256": hashlib.sha256(content).hexdigest(),
    }
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
        file.with_suffix(".json").write_text(json.dumps(notes, indent=1) + "\n", encoding="utf-8")
    except OSError as cause:
        raise InvalidInput(f"cannot be written ({cause.strerror})", str(file)) from cause


def load_patterns(file: Path) -> Patterns:
    """Read patterns that :func:`save_patterns` wrote; all arrays are read-only.

    Args:
        file: The file of the arrays; its JSON stands beside it.

    Raises:
        InvalidInput: If a file is missing, damaged, or belongs to other arrays.
    """
    try:
        content = file.read_bytes()
        arrays = load(content)
    except (OSError, SafetensorError) as cause:
        raise InvalidInput(f"cannot be read ({_reason(cause)})", str(file), "expected patterns") from cause
    notes = _read_notes(file.with_suffix(".json"))
    if hashlib.sha256(content).hexdigest() != notes.get("sha256"):
        raise InvalidInput("differs from what its JSON was written for", str(file), "train or copy both files anew")
    loads = notes.get("loads")
    if set(arrays) != set(ARRAYS) or not isinstance(loads, list) or len(loads) != len(arrays["granule"]):
        raise InvalidInput("holds no complete patterns", str(file), f"expected arrays {', '.join(ARRAYS)} and loads")
    for array in arrays.values():
        array.flags.writeable = False
    return Patterns(**arrays, loads=tuple(map(float, loads)), notes=notes)


def find_patterns(model: RobotModel, source: str = "") -> Patterns:
    """Return the patterns that were trained for an arm.

    Args:
        model: The arm, whatever its tool point, rotor inertia or payload.
        source: A file of patterns, or a folder of them. Empty for those that ship, then the user's own folder
            (:func:`user_folder`).

    Raises:
        InvalidInput: If there are none, or the file is another arm's or damaged.
    """
    key, place = robot_key(model), Path(source).expanduser()
    if source and not place.is_dir():
        patterns = load_patterns(place.with_suffix(".safetensors") if place.suffix == ".json" else place)
        if _key_of(patterns.notes) != key:
            owner = _robot_of(patterns.notes).get("name", "")
            raise InvalidInput(f"holds patterns of another arm ({owner})", source, _ADVICE)
        return patterns
    with as_file(files(__package__) / "data" / "patterns") as shipped:
        for file in _candidates((place,) if source else (shipped, user_folder())):
            if _key_of(_read_notes(file)) == key:
                return load_patterns(file.with_suffix(".safetensors"))
    where = f"the patterns in {source}" if source else "the cerebellum's patterns"
    raise InvalidInput(f"none was trained for this arm of {model.n} joints", where, _ADVICE)


_ADVICE = "make them with: torquebench train cerebellum --robot FILE"


def user_folder() -> Path:
    """Return where a user's own patterns are kept; it need not exist."""
    data = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(data) / "torquebench" / "patterns"


def _candidates(folders: tuple[Path, ...]) -> Iterator[Path]:
    for folder in folders:
        yield from sorted(folder.glob("*.json"))


def _read_notes(file: Path) -> Mapping[str, object]:
    try:
        notes = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as cause:
        raise InvalidInput(f"cannot be read ({_reason(cause)})", str(file), "expected notes of patterns") from cause
    if not isinstance(notes, dict) or notes.get("schema") != SCHEMA:
        raise InvalidInput("holds no notes of patterns", str(file), f"expected schema {SCHEMA}")
    return notes


def _reason(cause: Exception) -> str:
    """Return why a file cannot be read, without its name."""
    return (cause.strerror or str(cause)) if isinstance(cause, OSError) else str(cause)


def _robot_of(notes: Mapping[str, object]) -> Mapping[str, object]:
    robot = notes.get("robot")
    return robot if isinstance(robot, Mapping) else {}


def _key_of(notes: Mapping[str, object]) -> object:
    return _robot_of(notes).get("key")


def _probe() -> np.ndarray:
    """Return 1 kg off every axis of the flange: where the load hangs is part of the arm."""
    x, y, z = 0.11, 0.07, 0.23
    inertia = (y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y)
    return np.array([1.0, x, y, z, *inertia])
