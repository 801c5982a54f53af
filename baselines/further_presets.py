"""Further named controllers: from no model at all to models that learn; every setting can be overridden."""

from functools import partial

from .joint_impedance import JointImpedance
from .joint_pid import JointPid
from .pd_gravity import PdGravity
from .slotine_li import SlotineLi
from .spiking_adaptive import SpikingAdaptive

pd_gravity = partial(PdGravity)
"""The RDK's joint torque control example: springs, damping of the absolute velocity, gravity compensation."""

pid = partial(JointPid)
"""Independent joint PID without a model."""

joint_impedance = partial(JointImpedance)
"""Joint springs around the plan with the arm's own inertia, damping ratio 0.7."""

slotine_li = partial(SlotineLi, bandwidth=20.0)
"""Passivity-based adaptive control that learns the inertial parameters of the load."""

pes_adaptive = partial(SpikingAdaptive, bandwidth=20.0)
"""Computed torque with a spiking ensemble that learns online by the PES rule."""
