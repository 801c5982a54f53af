"""Evaluation: metrics of logs, statistics, and comparisons of controllers."""

from .comparison import Comparison, compare, compare_all, decide
from .errors import (
    AmbiguousRuns,
    EmptyWindow,
    EvaluationError,
    InvalidLog,
    MissingFields,
    NothingToCompare,
    TooFewUnits,
    UnequalLengths,
    UnknownMetric,
    UnknownMotionSet,
    UnknownWindow,
)
from .intervals import Interval, ShapeRange
from .materials import MaterialContrast, contrast_all, contrast_materials
from .metrics import (
    METRICS,
    EventTwins,
    Log,
    Metric,
    Value,
    error_by_lap,
    evaluate,
    evaluate_events,
    metric,
    missing_fields,
    orientation_error_by_lap,
)
from .motion_sets import MOTION_SETS, rows_in
from .rows import RunRow
from .summary import Summary, summary

__all__ = [
    "METRICS",
    "MOTION_SETS",
    "AmbiguousRuns",
    "Comparison",
    "EmptyWindow",
    "EvaluationError",
    "EventTwins",
    "Interval",
    "InvalidLog",
    "Log",
    "MaterialContrast",
    "Metric",
    "MissingFields",
    "NothingToCompare",
    "RunRow",
    "ShapeRange",
    "Summary",
    "TooFewUnits",
    "UnequalLengths",
    "UnknownMetric",
    "UnknownMotionSet",
    "UnknownWindow",
    "Value",
    "compare",
    "compare_all",
    "contrast_all",
    "contrast_materials",
    "decide",
    "error_by_lap",
    "evaluate",
    "evaluate_events",
    "metric",
    "missing_fields",
    "orientation_error_by_lap",
    "rows_in",
    "summary",
]
