"""The command line: thin, and quick to answer; a command's libraries are imported when it runs."""

import importlib
import sys

import click

from .nearest import NearestGroup

COMMANDS = {
    "run": "Run a benchmark and write its report.",
    "report": "Write the report of a results folder again.",
    "explain": "Print the runs behind a cell of the report, the worst of them and how to repeat it.",
    "replay": "Show a stored run, run it again, or feed what it saw to another controller.",
    "diff": "Print in what two results folders, or two runs, differ.",
    "figures": "Draw the figures for print as SVG and PDF.",
    "evaluate": "Compute the metrics of a log of your own, a CSV file.",
    "list": "List what can be named: controllers, trajectories, benchmarks and so on.",
    "ledger": "Print where every setting of every controller comes from.",
    "speed": "Measure how fast harness, plants and controllers are on this machine.",
    "merge": "Join results folders.",
    "train": "Train the cerebellum's patterns for an arm.",
    "doctor": "Print every library's version and origin, what is missing and what that costs.",
}


class LazyGroup(NearestGroup):
    """A group whose commands are imported when they are called; their one line of help is known before."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order of :data:`COMMANDS`."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a command's module and return its command."""
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = importlib.import_module(f".commands.{cmd_name}", __package__).command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.command(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="torquebench")
def group() -> None:
    """Honest side-by-side comparison of joint-torque controllers for robot arms."""


def main() -> None:
    """Run the command line; anything that a user can cause ends in one line and a status."""
    try:
        status = group.main(prog_name="torquebench", standalone_mode=False)
    except click.ClickException as error:
        _end(error.format_message(), 2)
    except (KeyboardInterrupt, click.Abort):
        _end("interrupted; finished runs are kept, the same command goes on with the rest", 130)
    except BrokenPipeError:
        sys.exit(1)
    except Exception as error:
        _end_of(error)
    else:
        sys.exit(status if isinstance(status, int) else 0)


def _end_of(error: Exception) -> None:
    """End with one line for an error that says what a user can do, and re-raise any other."""
    from .controllers.errors import TorquebenchError
    from .evaluation.errors import EvaluationError

    if not isinstance(error, TorquebenchError | EvaluationError):
        raise error
    _end(str(error), int(getattr(error, "exit_status", 2)))


def _end(message: str, status: int) -> None:
    click.echo(f"torquebench: {' '.join(message.split())}", err=True)
    sys.exit(status)
