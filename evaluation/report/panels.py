"""Parts of a world's section that only some stores have: load events, modules, errors by lap."""

from collections.abc import Sequence
from dataclasses import dataclass

from ...scenarios.store import Store
from ..metrics import EVENT_METRICS, METRICS
from .charts import Chart
from .efficiency import CostsOf, no_costs
from .efficiency_panel import EfficiencyPanel, efficiency_panel
from .findings import Findings
from .gravity import GRAVITY, GravityErrors, GravityOf, gravity_errors, gravity_table, no_gravity
from .lap_figures import lap_charts
from .module_figures import gain_charts, load_charts
from .module_tables import correlation_table, module_operation_table, operation_table, spike_table
from .modules import Modules, modules_of
from .paths import PathsPanel, paths_panel
from .profile_figures import profile_charts
from .resilience import SERIES, Event, Resilience, resilience_of
from .resilience_figures import MOST_CHARTS, curve_charts, zoom_charts
from .resilience_tables import event_table, peak_table, rate_table, unjudged_table
from .robustness import Robustness, robustness_of
from .robustness_tables import loop_table, margin_table, without_table, worst_loop_table
from .table import Table
from .timing import TimingPanel, timing_panel


@dataclass(frozen=True, kw_only=True)
class ResiliencePanel:
    """The load events of a world on the page.

    Attributes:
        resilience: What the tables and charts show.
        events: Table of recovery of each event; its table of peaks, None for the start.
        curves: Error over time, a chart for each controller.
        zooms: The time after each event.
        unjudged: Table of events without a verdict of the twins.
        rates: Table of improvement from event to event.
        notes: What a reader must know of the curves.
    """

    resilience: Resilience
    events: Sequence[tuple[Event, Table, Table | None]]
    curves: Sequence[Chart]
    zooms: Sequence[Chart]
    unjudged: Table
    rates: Table
    notes: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class ModulesPanel:
    """What the modules of spiking controllers did, on the page.

    Attributes:
        modules: What the tables and charts show.
        loads: Error and weight by load.
        gains: Gains over time and their correlations, for each controller that learns them.
        spikes: Table of spike rates.
        operations: Tables of operations, of all controllers and module by module.
        slope: Sentence about the weight by load, empty without one.
        known: How well the patterns know gravity, None if nobody knows.
        gravity: Tables of it, none or one.
    """

    modules: Modules
    loads: Sequence[Chart]
    gains: Sequence[tuple[str, Sequence[Chart], Table]]
    spikes: Table
    operations: Sequence[Table]
    slope: str
    known: GravityErrors | None
    gravity: Sequence[Table]


@dataclass(frozen=True, kw_only=True)
class RobustnessPanel:
    """The margins of a world on the page.

    Attributes:
        robustness: What the tables show.
        margins: Table of margins by bisection.
        worst: Table of loop margins, each of its worst joint.
        joints: Table of loop margins, joint by joint.
        without: Table of what could not be measured.
    """

    robustness: Robustness
    margins: Table
    worst: Table
    joints: Table
    without: Table


@dataclass(frozen=True, kw_only=True)
class Panels:
    """What a world's section has besides the comparison.

    Attributes:
        resilience: Its load events; None if its load never changes.
        modules: What its controllers' modules did; None if none shows any.
        robustness: Its margins; None if nobody measured any.
        laps: Errors by lap.
        profiles: Shares of runs within multiples of the reference's error.
        efficiency: What computing and moving cost; None if nothing was counted.
        timing: How long its controllers' calls took; None if nobody noted it.
        paths: Its motions with the error along them; None without traces.
    """

    resilience: ResiliencePanel | None = None
    modules: ModulesPanel | None = None
    robustness: RobustnessPanel | None = None
    laps: Sequence[Chart] = ()
    profiles: Sequence[Chart] = ()
    efficiency: EfficiencyPanel | None = None
    timing: TimingPanel | None = None
    paths: PathsPanel | None = None

    @property
    def metrics(self) -> list[str]:
        """Ids of the metrics that the panels show, in the registry's order."""
        shown: set[str] = set()
        if self.modules is not None:
            shown |= {"thalamus_weight_slope", "gain_correlation", "gain_variation", "spike_rate"}
            shown |= {GRAVITY} if self.modules.known else set()
        if self.resilience is not None:
            shown |= {*SERIES, *EVENT_METRICS}
            shown |= {"improvement_rate"} if self.resilience.rates.rows else set()
        if self.efficiency is not None:
            shown |= set(self.efficiency.metrics)
        return [name for name in METRICS if name in shown]

    @property
    def charts(self) -> list[Chart]:
        """All charts, in the order of the page."""
        found = [*self.laps, *self.profiles]
        if self.resilience is not None:
            found += [*self.resilience.curves, *self.resilience.zooms]
        if self.modules is not None:
            found += [*self.modules.loads, *(chart for _, charts, _ in self.modules.gains for chart in charts)]
        if self.efficiency is not None:
            found += self.efficiency.charts
        return found


def panels_of(
    findings: Findings, store: Store, costs_of: CostsOf = no_costs, gravity_of: GravityOf = no_gravity
) -> Panels:
    """Return what a world's section has besides the comparison.

    Args:
        findings: The world's findings.
        store: The open store that it comes from.
        costs_of: Knows what controllers compute.
        gravity_of: Knows how well their patterns know gravity.
    """
    return Panels(
        resilience=_resilience(findings, store),
        modules=_modules(findings, store, gravity_of),
        robustness=_robustness(findings),
        laps=lap_charts(findings),
        profiles=profile_charts(findings),
        efficiency=efficiency_panel(findings, store.campaigns(), costs_of),
        timing=timing_panel(findings, store.campaigns()),
        paths=paths_panel(findings, store),
    )


def _resilience(findings: Findings, store: Store) -> ResiliencePanel | None:
    found = resilience_of(findings.world, store)
    if found is None:
        return None
    judged = any(spreads.get("recovery_time_settled") for spreads in found.found.values()) and findings.world.twins
    events = [
        (event, event_table(findings, found, event), peak_table(findings, found, event) if event.window else None)
        for event in found.events
    ]
    return ResiliencePanel(
        resilience=found,
        events=events,
        curves=curve_charts(findings, found),
        zooms=zoom_charts(findings, found),
        unjudged=unjudged_table(findings, found),
        rates=rate_table(findings, found),
        notes=_notes(found, judged=bool(judged)),
    )


def _notes(found: Resilience, *, judged: bool) -> list[str]:
    """Say what the curves were made of, and who has none."""
    notes = [] if judged else ["No twins ran: recovery can be read from the curves only."]
    if found.dt is not None:
        curve = next(iter(found.curves.values()))
        paths = f"{curve.paths} {'trajectory' if curve.paths == 1 else 'trajectories'}"
        notes.append(
            f"Curves are the joint error averaged over {paths}, from traces with a sample every {1e3 * found.dt:g} ms; "
            f"what is computed from them has that resolution. What the twins judge is computed at the full rate."
        )
    notes += [f"{label} has no curve: {reason}." for label, reason in found.without.items()]
    if len(found.curves) > MOST_CHARTS:
        notes.append(f"Charts of the first {MOST_CHARTS} controllers; the tables have all.")
    return notes


def _robustness(findings: Findings) -> RobustnessPanel | None:
    found = robustness_of(findings)
    if found is None:
        return None
    return RobustnessPanel(
        robustness=found,
        margins=margin_table(findings, found),
        worst=worst_loop_table(findings, found),
        joints=loop_table(findings, found),
        without=without_table(findings, found),
    )


def _modules(findings: Findings, store: Store, gravity_of: GravityOf) -> ModulesPanel | None:
    found = modules_of(findings.world, store)
    if found is None:
        return None
    known = gravity_errors(findings.world, gravity_of)
    named = {run.row.controller: run.stored.specification.controller for run in findings.world.runs}
    labels = [label for label in findings.order if label in found.gains]
    drawn = [label for label in labels if named[label] == "cbmc_v3"] or labels[:1]
    gains = [
        (
            label,
            gain_charts(findings, label, found.gains[label]) if label in drawn else [],
            correlation_table(findings, label, found.gains[label]),
        )
        for label in sorted(labels, key=lambda label: label not in drawn)
    ]
    counted = operation_table(findings, found)
    single = [module_operation_table(findings, label, found) for label in drawn if label in found.operations]
    return ModulesPanel(
        modules=found,
        loads=load_charts(findings, found),
        gains=gains,
        spikes=spike_table(findings, found),
        operations=[table for table in (counted, *single) if table.rows],
        slope=_slope(found),
        known=known,
        gravity=[gravity_table(findings.world, known)] if known else [],
    )


def _slope(found: Modules) -> str:
    """Say how the weight grows with the load."""
    slopes = found.slopes
    if not slopes.values:
        return ""
    low, high = min(slopes.values), max(slopes.values)
    return (
        f"The heavy pattern's mean weight grows by {slopes.median:.3f} per kg (median over trajectories and seeds, "
        f"{low:.3f} to {high:.3f}); right is 1/3 per kg."
    )
