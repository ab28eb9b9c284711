"""The commands."""

from __future__ import annotations

from typing import Annotated

import typer

from .nouns import flips, mass_attractions, noise, plans, positions, recordings, sines, thermals
from .shown.output import package_version
from .verbs import campaigns, demos, models, twins

app = typer.Typer(
    name="inertialcal",
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


app.command("info")(recordings.info)
app.command("allan")(noise.allan)
app.command("psd")(noise.psd)
app.command("sine")(sines.sine)
app.command("rate-table")(recordings.rate_table)
app.command("flip")(flips.flip)
app.command("thermal")(thermals.thermal)
app.command("mass-attraction")(mass_attractions.mass_attraction)
app.add_typer(plans.plan, name="plan")
app.command("positions")(positions.positions)
app.command("init")(campaigns.init)
app.command("check")(campaigns.check)
app.command("run")(campaigns.run)
app.command("demo")(demos.demo)
app.command("show")(models.show)
app.command("compensate")(models.compensate)
app.command("convert")(models.convert)
app.command("export")(models.export)
app.command("compare")(models.compare)
app.command("simulate")(twins.simulate)
app.command("score")(twins.score)
