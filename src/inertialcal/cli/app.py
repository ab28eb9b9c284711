"""The command line: its name, its help, its version; the commands stand in ``commands``."""

from __future__ import annotations

from typing import Annotated

import typer

from .commands import Root
from .shown.output import package_version

app = typer.Typer(
    name="inertialcal",
    cls=Root,
    help="From raw counts to a calibration that can be trusted: low-g accelerometers and rate gyros.\n\n"
    "Start with: inertialcal info FILE, or inertialcal demo.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"inertialcal {package_version()}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and leave.")
    ] = False,
) -> None:
    """Options of all commands."""
