"""A group of commands that answers a misspelt one with the nearest there is."""

import click


class NearestGroup(click.Group):
    """A click group whose unknown commands are refused in one line, see :class:`~.controllers.UnknownName`."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find a command, or name the nearest one."""
        names = self.list_commands(ctx)
        if args and args[0] not in names and not args[0].startswith("-"):
            from .controllers.errors import UnknownName

            raise UnknownName("command", args[0], tuple(names))
        return super().resolve_command(ctx, args)
