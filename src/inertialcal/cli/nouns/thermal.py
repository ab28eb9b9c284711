"""thermal: bias over temperature from recordings of a unit at rest."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .. import figures
from ..options import Json, Quiet, Start, Stop, Units
from ..shown.output import json_out

Files = Annotated[list[Path], typer.Argument(help="Recordings, each of a power-up of its own.", show_default=False)]


def thermal(
    files: Files,
    column: Annotated[
        list[str] | None, typer.Option(help="Channel: x=COLUMN, temperature=COLUMN, temperature_x=COLUMN; repeatable.")
    ] = None,
    unit: Units = [],  # noqa: B006 - typer copies it
    sensor: Annotated[str | None, typer.Option(help="Which sensors: gyro or acc.")] = None,
    sample_rate: Annotated[
        float | None, typer.Option("--sample-rate", help="Samples per second, where the file has no time.")
    ] = None,
    time_column: Annotated[
        str | None, typer.Option("--time-column", help="Name, or number from 1, of the column with the time.")
    ] = None,
    at: Annotated[
        list[str] | None, typer.Option(help='Temperature at which the bias is told too: "-20 degC"; may be repeated.')
    ] = None,
    reference_temperature: Annotated[str, typer.Option(help="Powers are of the temperature less this.")] = "20 degC",
    order: Annotated[
        int | None, typer.Option(help="Of the polynomial; chosen on what is held out if not said.")
    ] = None,
    warm_up: Annotated[
        str | None, typer.Option(help='Left out after each power-up: "300 s"; found if not said.')
    ] = None,
    one_run: Annotated[bool, typer.Option("--one-run", help="All files are of one power-up.")] = False,
    start: Start = None,
    stop: Stop = None,
    output: figures.FigureFile = None,
    figure: figures.FigureName = None,
    axis: Annotated[str | None, typer.Option(help="Axis of the figure: x, y or z.")] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run the command; its help stands in the declaration of the procedure."""
    from ...procedures.thermal.files import thermal as reduce_files
    from ..pairs import pairs
    from ..shown.summary import print_reduced
    from ..units import units_of

    figures.check_figure(output, {"--figure": figure, "--axis": axis})
    found = reduce_files(
        list(files), columns=pairs(column or [], "--column", "temperature=temp"), units=units_of(unit),
        sensor=sensor, sample_rate=sample_rate, time_column=time_column, at=at or [],  # type: ignore[arg-type]
        reference_temperature=reference_temperature, order=order, warm_up=warm_up, one_run=one_run,
        start=start, stop=stop,
    )  # fmt: skip
    line = ""
    if output is not None:
        line = figures.write(output, found, files, {"figure": figure, "axis": axis}, most=3)
    if as_json:
        inputs = [{"path": name, "sha256": digest} for name, digest in found.inputs.items()]
        content: dict[str, Any] = {"inputs": inputs, "results": [row.to_dict() for row in found.rows]}
        content |= {"remarks": [one.to_dict() for one in found.remarks], "columns": dict(found.columns)}
        json_out("thermal", content | ({"written": str(output)} if line else {}))
    elif not quiet:
        rows, remarks = ([one.to_dict() for one in every] for every in (found.rows, found.remarks))
        print_reduced(found.columns, rows, remarks, line)
    return 0
