"""Named controllers with their settings; every setting can be overridden by keyword.

The computed-torque laws come as delivered (20 rad/s) and stiff (40 rad/s). The impedance presets follow the public
documents of the Flexiv RDK; no constant in them was fitted.
"""

from functools import partial

from .cartesian_impedance import CartesianImpedance
from .computed_torque import ComputedTorque
from .computed_torque_feedforward import ComputedTorqueFeedforward
from .computed_torque_pid import ComputedTorquePid

computed_torque = partial(ComputedTorque, bandwidth=20.0)
"""Feedback linearisation, as delivered."""

computed_torque_stiff = partial(ComputedTorque, bandwidth=40.0)
"""Feedback linearisation, stiff."""

computed_torque_feedforward = partial(ComputedTorqueFeedforward, bandwidth=20.0)
"""Inverse dynamics of the plan with diagonal gains, as delivered."""

computed_torque_feedforward_stiff = partial(ComputedTorqueFeedforward, bandwidth=40.0)
"""Inverse dynamics of the plan with diagonal gains, stiff."""

computed_torque_pid = partial(ComputedTorquePid, bandwidth=20.0)
"""Feedback linearisation with integral action."""

flexiv_factory = partial(CartesianImpedance, linear_stiffness=10000.0, angular_stiffness=1500.0, damping_ratio=0.7)
"""The documented default call: pose alone is streamed, so the damping acts on the absolute velocity."""

flexiv_factory_dd = partial(flexiv_factory, damping_design="double_diagonalisation")
"""The same with double-diagonalised damping."""

flexiv_full_ff = partial(flexiv_factory, velocity_feedforward=True, acceleration_feedforward=True)
"""The same with velocity and acceleration streamed, which the interface accepts."""

compliant = partial(flexiv_full_ff, linear_stiffness=1000.0, angular_stiffness=60.0)
"""A soft spring with full feed-forward."""
