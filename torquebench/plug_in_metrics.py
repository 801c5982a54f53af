"""The metrics that come with the library, and those that other distributions register."""

from collections.abc import Mapping
from functools import cache

from .controllers import InvalidInput, discovery
from .evaluation.metrics import METRICS, Metric


@cache
def all_metrics() -> Mapping[str, Metric[...]]:
    """Return every metric by id: the built-in ones in their order, then those of plug-ins by name.

    Raises:
        PlugInFailure: If a registered metric cannot be imported.
        InvalidInput: If what is registered is no metric, or has another id than its name.
    """
    points = discovery.registered("metrics")
    return {**METRICS, **{name: _load(name, points[name].value) for name in sorted(set(points) - set(METRICS))}}


def _load(name: str, origin: str) -> Metric[...]:
    found = discovery.load("metrics", name)
    if not isinstance(found, Metric):
        came = f"a {type(found).__name__}"
        raise InvalidInput(came, f"metric {name!r} ({origin})", "decorate it with torquebench.evaluation.metric")
    if found.id != name:
        raise InvalidInput(f"registered as {name!r}", f"metric {found.id!r} ({origin})", "register it under its id")
    return found
