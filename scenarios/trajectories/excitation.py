"""The motion that makes all ten parameters of a load visible: the tool turns about every axis while it moves.

On T1 to T8 the tool's orientation is constant, and a force sensor sees mass and first moments only. The coefficients
come from ``examples/find_excitation.py``: random closed motions ranked by what a sensor sees in one lap, the first that
the Rizon 4s can follow with 3.5 kg within 0.6 of its velocity limits and 0.8 of its torque limits.
"""

from .turning import TurningPath


def excitation() -> TurningPath:
    """Return the motion, five seconds a lap; a group of its own, so that no mean over motions holds it."""
    return TurningPath(
        name="excitation",
        group="excitation",
        period=5.0,
        centre=(0.54, 0.0, 0.45),
        cosine=((0.0328, 0.0243, 0.0891), (-0.0317, 0.0006, -0.0116)),
        sine=((0.0746, 0.0404, -0.0841), (0.026, -0.0054, 0.0174)),
        turn_cosine=((-0.1684, 0.1576, 0.3913), (-0.0371, 0.042, 0.0078), (-0.0018, 0.0133, 0.3461)),
        turn_sine=((-0.0424, 0.1623, -0.0354), (-0.1111, -0.0902, 0.2111), (0.0332, -0.0602, 0.0953)),
    )
