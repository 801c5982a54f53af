"""Time means of CBMC-V3's gains: what its null controls are given, so that only the arithmetic differs."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np

from ..controllers import InvalidInput

FILE = "mean_gains.json"
LEARNT = "time mean of cbmc_v3 over the run window of T1 to T8 at 1.5, 2.5 and 3.5 kg; `torquebench train gains`"


@dataclass(frozen=True, kw_only=True, eq=False)
class MeanGains:
    """Mean gains on one tier.

    Attributes:
        stiffness: Shape (n,) [N m/rad].
        damping: Shape (n,) [N m s/rad].
    """

    stiffness: np.ndarray
    damping: np.ndarray


def mean_gains(tier: str, joints: int) -> MeanGains:
    """Return the mean gains on a tier.

    Args:
        tier: Name of the tier.
        joints: Number of joints of the arm.

    Raises:
        InvalidInput: If the file has none for the tier or the arm.
    """
    table = _tables().get(tier)
    if table is None or len(table["stiffness"]) != joints:
        valid = f"run `torquebench train gains --tier {tier}` for tiers: {', '.join(_tables())} are there, for 7 joints"
        raise InvalidInput(f"no mean gains for {joints} joints on tier {tier!r}", FILE, valid)
    return MeanGains(stiffness=np.array(table["stiffness"]), damping=np.array(table["damping"]))


@cache
def _tables() -> Mapping[str, Mapping[str, list[float]]]:
    text = (files(__package__) / "data" / FILE).read_text(encoding="utf-8")
    tiers: Mapping[str, Mapping[str, list[float]]] = json.loads(text)["tiers"]
    return tiers
