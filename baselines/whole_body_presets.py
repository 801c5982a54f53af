"""Named whole-body QP controllers; every setting can be overridden by keyword."""

from functools import partial

from .whole_body_qp import WholeBodyQp
from .whole_body_qp_strict import WholeBodyQpStrict

whole_body_qp = partial(WholeBodyQp, gain_form="acceleration")
"""Pose, posture and effort by weight within the limits, with the same error dynamics everywhere."""

whole_body_qp_stiff = partial(whole_body_qp, bandwidth=40.0)
"""The same at twice the bandwidth."""

whole_body_qp_force = partial(WholeBodyQp, gain_form="force", effort_weight=0.0)
"""The impedance with full feed-forward, stiffness and damping shared: the two differ by constraints only."""

whole_body_qp_strict = partial(WholeBodyQpStrict, gain_form="acceleration")
"""The same with strict priorities: the pose first, then posture and effort in what it leaves."""
