"""The metrics that come with the library, collected from their families."""

from . import (
    contour,
    excess,
    gains,
    lag,
    modules,
    orientation,
    peaks,
    precision,
    recovery,
    resilience,
    saturation,
    series,
    smoothness,
)
from .registry import Metric

FAMILIES = (
    *(precision, orientation, lag, contour, smoothness, saturation),
    *(resilience, recovery, excess, peaks, series, modules, gains),
)

METRICS: dict[str, Metric[...]] = {
    found.id: found
    for family in FAMILIES
    for found in vars(family).values()
    if isinstance(found, Metric) and found.function.__module__ == family.__name__
}
"""Every built-in metric by id, in the order of tables: family by family, as the files have them."""
