"""The cerebral cortex: stores the plan and plays it back (the paper excludes it from its module design)."""

from ..controllers import Target
from .pathways import Ascending


class CerebralCortex:
    """Hands the plan to the modules below; it has no neurons and learns nothing."""

    def connect(self, ascending: Ascending) -> None:
        """Join the pathway that carries the plan."""
        self._ascending = ascending

    def replay(self, target: Target) -> None:
        """Put this tick's plan on the ascending pathway: q_d [rad] and its rate [rad/s]."""
        self._ascending.q_desired[:] = target.q
        self._ascending.dq_desired[:] = target.dq
