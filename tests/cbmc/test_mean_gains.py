"""The null controls' gains: data that a command made, for every tier of the arm."""

import json
from importlib.resources import files

import numpy as np
import pytest
from torquebench.cbmc.mean_gains import mean_gains
from torquebench.controllers import InvalidInput


def test_every_tier_of_the_arm_has_mean_gains_near_what_the_brainstem_gives_at_rest(rizon):
    """A null control must run wherever CBMC-V3 does; stiffness only rises from 200, damping stays near 20."""
    for tier in rizon.tiers:
        gains = mean_gains(tier, 7)
        capped = 6 if tier == "paper_bullet" else None
        free = [joint for joint in range(7) if joint != capped]
        assert np.all(gains.stiffness[free] > 190.0)
        assert np.all(np.abs(gains.damping[free] - 20.0) < 2.0)


def test_the_guard_s_caps_show_in_the_gains_of_the_tier_without_rotor_inertia():
    """The means are those of the runs, caps included."""
    gains = mean_gains("paper_bullet", 7)
    assert gains.damping[6] < 10.5
    assert gains.stiffness[6] < 105.0


def test_an_unmeasured_tier_or_arm_names_the_command():
    """One line says how to get them."""
    for tier, joints in (("no_such_tier", 7), ("actuated", 6)):
        with pytest.raises(InvalidInput, match="torquebench train gains"):
            mean_gains(tier, joints)


def test_the_file_says_how_it_was_made():
    """Learnt before the run, and on what, stands in the ledger and in the data."""
    table = json.loads((files("torquebench.cbmc") / "data" / "mean_gains.json").read_text())
    assert table["made_by"].startswith("torquebench train gains")
