"""Named model predictive controllers; every setting can be overridden by keyword."""

from functools import partial

from .mpc import Mpc
from .mpc_offset_free import MpcOffsetFree
from .mpc_tool import MpcTool

mpc = partial(Mpc, bandwidth=40.0)
"""Plans that track the joints, with every torque within its limits."""

mpc_tool = partial(MpcTool, bandwidth=40.0)
"""Plans that track the tool, the joints weakly."""

mpc_offset_free = partial(MpcOffsetFree, bandwidth=40.0)
"""Plans that track the joints, with a disturbance state."""
