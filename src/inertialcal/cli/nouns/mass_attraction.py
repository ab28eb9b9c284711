"""mass-attraction: scale factor of an accelerometer from records of a moved mass."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from .. import figures
from ..options import Json, Quiet, Units
from ..shown.output import json_out

Files = Annotated[list[Path], typer.Argument(help="Records with the mass moved, each a run.", show_default=False)]


def mass_attraction(
    files: Files,
    schedule: Annotated[Path, typer.Option(help="CSV of the dwells of the mass.", show_default=False)],
    null: Annotated[
        list[Path] | None, typer.Option(help="Record of the schedule with the mass at rest; may be repeated.")
    ] = None,
    column: Annotated[
        str | None, typer.Option(help="Of the pulses; the one in pulses or pulses/s if not said.")
    ] = None,
    tilt: Annotated[str | None, typer.Option(help="Column of the tilt meter.")] = None,
    tilt_is: Annotated[
        str, typer.Option("--tilt-is", help="What becomes of the tilt: regressed, known or ignored.")
    ] = "regressed",
    mercury: Annotated[str, typer.Option(help="Amplitude by which the mass tilts the mercury of the meter.")] = "0 rad",
    gate: Annotated[str | None, typer.Option(help='For how long pulses are counted: "100 s".')] = None,
    begin: Annotated[
        str | None, typer.Option(help="When the schedule starts, on the clock of the file; else with its first sample.")
    ] = None,
    stamp: Annotated[
        str, typer.Option(help="With --begin, what stamps are: start, middle or end of a gate.")
    ] = "middle",
    nominal: Annotated[str | None, typer.Option(help='Scale factor of the data sheet: "10.21 count/s/ug".')] = None,
    high_g: Annotated[
        str | None, typer.Option("--high-g", help="Scale factor at high g that the result is compared with.")
    ] = None,
    u_high_g: Annotated[str | None, typer.Option("--u-high-g", help="Standard uncertainty of it.")] = None,
    scatter: Annotated[
        str, typer.Option(help="Where the uncertainty comes from: between_runs or within_runs.")
    ] = "between_runs",
    in_unit: Annotated[str, typer.Option("--in", help="Unit of accelerations in the result.")] = "ug",
    unit: Units = [],  # noqa: B006 - typer copies it
    time_column: Annotated[
        str | None, typer.Option("--time-column", help="Name, or number from 1, of the column with the time.")
    ] = None,
    output: figures.FigureFile = None,
    figure: figures.FigureName = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run the command; its help stands in the declaration of the procedure."""
    from ...procedures.mass_attraction.files import mass_attraction as reduce_files
    from ..shown.summary import print_reduced
    from ..units import units_of

    figures.check_figure(output, {"--figure": figure})
    found = reduce_files(
        list(files), schedule, null=null or [], column=column, tilt=tilt, tilt_is=tilt_is,  # type: ignore[arg-type]
        mercury=mercury, gate=gate, begin=begin, stamp=stamp, nominal=nominal, high_g=high_g, u_high_g=u_high_g,
        scatter=scatter,  # type: ignore[arg-type]
        unit=in_unit, units=units_of(unit), time_column=time_column,
    )  # fmt: skip
    line = ""
    if output is not None:
        line = figures.write(output, found, [*files, *(null or []), schedule], {"figure": figure}, most=3)
    if as_json:
        inputs = [{"path": name, "sha256": digest} for name, digest in found.inputs.items()]
        content: dict[str, Any] = {"inputs": inputs, "results": [row.to_dict() for row in found.rows]}
        content |= {"remarks": [one.to_dict() for one in found.remarks], "columns": dict(found.columns)}
        json_out("mass-attraction", content | ({"written": str(output)} if line else {}))
    elif not quiet:
        rows, remarks = ([one.to_dict() for one in every] for every in (found.rows, found.remarks))
        print_reduced(found.columns, rows, remarks, line)
    return 0
