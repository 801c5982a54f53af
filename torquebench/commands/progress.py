"""A progress bar on a terminal, silence elsewhere."""

import sys
from types import TracebackType
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

if TYPE_CHECKING:
    from ..scenarios.campaign import Campaign, Finished


class Progress:
    """Shows done, failed and time left while a campaign runs."""

    def __init__(self, *, quiet: bool) -> None:
        """Prepare the bar.

        Args:
            quiet: Whether to show nothing even on a terminal.
        """
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        shown = sys.stderr.isatty() and not quiet
        self._bar = Bar(*columns, TextColumn("{task.fields[failed]}"), console=Console(stderr=True), disable=not shown)
        self._failed = 0

    def __enter__(self) -> "Progress":
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()

    def watch(self, campaign: "Campaign", finished: "Finished | None") -> None:
        """Take note of a campaign, or of a run that was written."""
        if finished is None:
            self._task = self._bar.add_task(campaign.benchmark.name, total=len(campaign.pending), failed="")
            return
        self._failed += finished.failed
        self._bar.update(self._task, advance=1, failed=f"{self._failed} failed" if self._failed else "")
