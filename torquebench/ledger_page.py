"""The page of settings: for every controller and every knowledge level, what its ledger says after a reset."""

from collections.abc import Sequence
from dataclasses import dataclass

from .controllers import LedgerEntry, Task, TorquebenchError, build_controller, discovery, hook, knowledge_levels
from .scenarios.loads import LoadSchedule, Payload
from .scenarios.specification import RunSpecification
from .scenarios.world import World

TRAJECTORY, TIER, LOAD, LEVEL = "T1", "actuated", 1.5, "none"
LONGEST_LIST = 8
HEAD = f"""# Every setting and its source

Made by `torquebench ledger > docs/gains.md` from what each controller declares after its reset, here for
{TRAJECTORY} with {LOAD:g} kg in the tier `{TIER}` on the Pinocchio plant; a test holds page and code together. Rules
read the arm, its plan and its tier, so their values change with these. Why the settings are what they are:
[controllers](controllers.md).

Sources: *published*, a document gives the value; *rule*, it is computed from the model by the rule that stands
beside it; *tuned*, searched, with the number of trials; *chosen*, decided by hand.
"""
COLUMNS = ("Setting", "Value", "Source", "Note", "Trials", "Learnt before the run")


@dataclass(frozen=True, kw_only=True)
class Section:
    """What one registered object says of its settings.

    Attributes:
        name: Its name.
        meaning: The first line of its documentation.
        entries: Its ledger; empty if it declares none.
        missing: Why there is no ledger, empty if there is.
    """

    name: str
    meaning: str
    entries: Sequence[LedgerEntry] = ()
    missing: str = ""


def controller_sections() -> tuple[Section, ...]:
    """Return a section for each registered controller; what stops one is in its section."""
    return tuple(_section("controllers", name) for name in discovery.names("controllers"))


def knowledge_sections() -> tuple[Section, ...]:
    """Return a section for each registered knowledge level."""
    return tuple(_section("knowledge", name) for name in discovery.names("knowledge"))


def page(controllers: Sequence[Section], knowledge: Sequence[Section]) -> str:
    """Return the page as Markdown, ending with a new line."""
    parts = [HEAD, "## Controllers\n", *map(_markdown, controllers)]
    return "\n".join([*parts, "## Knowledge of the load\n", *map(_markdown, knowledge)])


def _section(kind: str, name: str) -> Section:
    meaning = discovery.meaning(discovery.registered(kind)[name])
    try:
        entries = _controller_ledger(name) if kind == "controllers" else _knowledge_ledger(name)
    except TorquebenchError as error:
        return Section(name=name, meaning=meaning, missing=str(error))
    return Section(name=name, meaning=meaning, entries=entries)


def _controller_ledger(name: str) -> Sequence[LedgerEntry]:
    """Return a controller's ledger after a reset.

    Raises:
        TorquebenchError: If something that it needs is missing.
    """
    controller = build_controller(discovery.load("controllers", name), {}, name=name)
    levels = knowledge_levels(controller, discovery.names("knowledge"))
    _, task = _reset_knowledge(LEVEL if LEVEL in levels else levels[0])
    reason = hook(controller, "supports")(task)  # type: ignore[operator]
    if reason:
        raise TorquebenchError(str(reason))
    controller.reset(task)  # type: ignore[attr-defined]
    entries: Sequence[LedgerEntry] = tuple(hook(controller, "ledger")())  # type: ignore[operator]
    hook(controller, "close")()  # type: ignore[operator]
    return entries


def _knowledge_ledger(name: str) -> Sequence[LedgerEntry]:
    """Return the ledger of a knowledge level; a provider need not have one."""
    provider, _ = _reset_knowledge(name)
    return tuple(getattr(provider, "ledger", tuple)())


def _reset_knowledge(level: str) -> tuple[object, Task]:
    """Return a knowledge level that was reset, and the task whose model it fills."""
    schedule = LoadSchedule.constant(Payload(mass=LOAD))
    world = World(
        RunSpecification(
            controller="",
            knowledge=level,
            trajectory=TRAJECTORY,
            schedule=schedule,
            robot="rizon4s",
            plant="pinocchio",
            tier=TIER,
        ),
        schedule,
    )
    task, provider = world.task(), discovery.load("knowledge", level)()  # type: ignore[operator]
    provider.reset(task.robot, task.actuation, world.truth)
    world.plant.close()
    return provider, task


def _markdown(section: Section) -> str:
    """Return a heading, a line on what it is, and a table, or the line that says why there is none."""
    head = f"### `{section.name}`\n\n{section.meaning}\n"
    if section.missing:
        return f"{head}\nNot here: {section.missing}\n"
    if not section.entries:
        return f"{head}\nNo settings.\n"
    rows = [COLUMNS, ("---",) * len(COLUMNS), *map(_cells, section.entries)]
    return "\n".join([head, *(f"| {' | '.join(cells)} |" for cells in rows), ""])


def _cells(entry: LedgerEntry) -> tuple[str, ...]:
    texts = (f"`{entry.setting}`", _short(entry.value), entry.source, entry.note, str(entry.trials or ""))
    return tuple(" ".join(text.replace("|", "\\|").split()) for text in (*texts, entry.learnt_before))


def _short(value: object) -> str:
    """Return a value for a table: numbers to four digits, long lists by their first."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return f"{float(f'{value:.4g}'):g}"
    if isinstance(value, dict):
        return "; ".join(f"{key}: {_short(item)}" for key, item in value.items()) or "none"
    if isinstance(value, list | tuple):
        shown = ", ".join(_short(item) for item in value[:LONGEST_LIST])
        return f"{shown}, ... ({len(value)})" if len(value) > LONGEST_LIST else shown or "none"
    return str("none" if value is None else value)
