"""Closed paths of the tool, the joint motion that follows them, and the plan of a run."""

from .paths import HarmonicPath, Path, circle, eight, fourier, rotated_circle, yz_circle
from .reference import Plan
from .suite import further_suite, load_path, suite, suite_path

__all__ = [
    "HarmonicPath",
    "Path",
    "Plan",
    "circle",
    "eight",
    "fourier",
    "further_suite",
    "load_path",
    "rotated_circle",
    "suite",
    "suite_path",
    "yz_circle",
]
