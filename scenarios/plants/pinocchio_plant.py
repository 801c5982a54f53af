"""The plant on Pinocchio alone: the same equations, integrated here; cross-check and stand-in for PyBullet."""

from .plant import Plant


class PinocchioPlant(Plant):
    """Semi-implicit Euler on Pinocchio's accelerations."""

    name = "pinocchio"

    def _integrate(self) -> None:
        self.velocities += self._step * self._ddq
        self.positions += self._step * self.velocities
