"""The metrics that come with the library, collected from their families."""

from . import (
    adaptation,
    cells,
    computing,
    contour,
    effort,
    excess,
    gains,
    iso_corner,
    iso_path,
    iso_speed,
    jerk,
    lag,
    modules,
    operations,
    orientation,
    peaks,
    precision,
    recovery,
    resilience,
    saturation,
    series,
    smoothness,
    velocity,
)
from .registry import Metric

FAMILIES = (
    *(precision, orientation, lag, contour, iso_path, iso_speed, iso_corner),
    *(velocity, smoothness, jerk, saturation, effort),
    *(resilience, recovery, excess, peaks, series, modules, gains),
    *(adaptation, cells, computing, operations),
)

METRICS: dict[str, Metric[...]] = {
    found.id: found
    for family in FAMILIES
    for found in vars(family).values()
    if isinstance(found, Metric) and found.function.__module__ == family.__name__
}
"""Every built-in metric by id, in the order of tables: family by family, as the files have them."""
