"""positions: accelerometers and gyros from static positions and the rotations between them, without a turntable."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .. import figures
from ..options import Json, Quiet, Start, Stop, Units
from ..shown.output import clean, json_out

if TYPE_CHECKING:
    from ...procedures.positions.files.call import PositionsFile

FIGURES = ("positions_residuals", "positions_sphere", "transitions")
Files = Annotated[
    list[str],
    typer.Argument(
        help="A recording, or acc=FILE gyro=FILE of one clock, or a file a position: x+=FILE x-=FILE ... x_rot=FILE; "
        "or a table, a row a position.",
        show_default=False,
    ),
]
Outputs = Annotated[
    list[Path],
    typer.Option(
        "--output",
        "-o",
        help="Write a figure (.png, .svg, .pdf) or the models (.json), by the ending; may be repeated.",
        show_default=False,
    ),
]


def positions(
    files: Files,
    unit: Units = [],  # noqa: B006 - typer copies it
    column: Annotated[list[str] | None, typer.Option(help="Channel: acc_x=COLUMN, gyro_z=COLUMN; repeatable.")] = None,
    sample_rate: Annotated[
        float | None, typer.Option("--sample-rate", help="Samples per second, where the file has no time.")
    ] = None,
    time_column: Annotated[
        str | None, typer.Option("--time-column", help="Name, or number from 1, of the column with the time.")
    ] = None,
    sections: Annotated[
        str | None, typer.Option(help="Labelled parts: JSON or table of label, start, end; or the column of labels.")
    ] = None,
    orientations: Annotated[
        str | None,
        typer.Option(help="Which axis was up in each position: x+,x-,y+,...; faces (the nearest); or a file."),
    ] = None,
    turn: Annotated[str, typer.Option(help="Angle of each turn that is named (x_rot, ...).")] = "360 deg",
    gravity: Annotated[str | None, typer.Option(help='Local gravity: "9.8123 m/s2".')] = None,
    latitude: Annotated[str | None, typer.Option(help='Where gravity is not known: "48 deg".')] = None,
    height: Annotated[str | None, typer.Option(help='Above the sea, with the latitude: "300 m".')] = None,
    zero: Annotated[
        list[str] | None, typer.Option(help="Reading that stands for no input: acc=32768, gyro=32768; repeatable.")
    ] = None,
    shortest: Annotated[str | None, typer.Option(help='Shortest rest that counts: "2 s"; found if not said.')] = None,
    g_sensitivity: Annotated[
        bool, typer.Option("--g-sensitivity/--no-g-sensitivity", help="Estimate what gyros read of specific force.")
    ] = True,
    hold_out: Annotated[
        str | None, typer.Option(help="Fit without the last positions and judge by them: half, or how many.")
    ] = None,
    standard: Annotated[
        list[str] | None,
        typer.Option(help="Standard uncertainty: turn.angle='1 deg', gravity.value='0.001 m/s2', ...; repeatable."),
    ] = None,
    start: Start = None,
    stop: Stop = None,
    output: Outputs = [],  # noqa: B006 - typer copies it
    figure: Annotated[str | None, typer.Option("--figure", help="Which: sphere, residuals or transitions.")] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run the command; its help stands in the declaration of the procedure."""
    from ...procedures.positions.files.call import positions as reduce_files
    from ..pairs import pairs
    from ..shown.summary import print_reduced
    from ..units import units_of

    drawn, models = _outputs(output, figure)
    found = reduce_files(
        files, columns=pairs(column or [], "--column", "acc_x=ax"), units=units_of(unit), sample_rate=sample_rate,
        time_column=time_column, sections=sections, orientations=orientations, turn=turn, gravity=gravity,
        latitude=latitude, height=height, zero=pairs(zero or [], "--zero", "acc=32768"), shortest=shortest,
        g_sensitivity=g_sensitivity, hold_out=hold_out, start=start, stop=stop,
        standards=pairs(standard or [], "--standard", "turn.angle='1 deg'"),
    )  # fmt: skip
    lines = [figures.write(one, found, list(found.inputs), {"figure": _named(figure)}) for one in drawn]
    written = [path for one in models for path in found.write_models(one)]
    if as_json:
        json_out("positions", _content(found, [*drawn, *written]))
    elif not quiet:
        rows, remarks = ([one.to_dict() for one in every] for every in (found.rows, found.remarks))
        said = "\n".join([*lines, *(clean(f"written: {path}") for path in written)])
        print_reduced(found.columns, rows, remarks, said, found.summary)
    return 0


def _outputs(given: Sequence[Path], figure: str | None) -> tuple[list[Path], list[Path]]:
    """Return the files of figures and those of models; refuse an ending that is neither, before anything is computed.

    Raises
    ------
    UsageError
        With the endings that there are, or the option that is missing.
    """
    from ...core.errors import UsageError

    models = [one for one in given if one.suffix.lower() == ".json"]
    drawn = [one for one in given if one not in models]
    for one in drawn:
        figures.check_figure(one)
    if figure is not None and _named(figure) not in FIGURES:
        raise UsageError(f"--figure {figure}", do="There are: residuals, sphere, transitions", code="unknown_name")
    if figure is not None and not drawn:
        raise UsageError(f"--figure {figure}: no file for the figure is named", do="Say it: -o figure.png")
    return drawn, models


def _named(figure: str | None) -> str | None:
    """Return the name of a figure by the short word for it."""
    return {"sphere": "positions_sphere", "residuals": "positions_residuals"}.get(figure or "", figure)


def _content(found: PositionsFile, written: Sequence[Path]) -> dict[str, Any]:
    inputs = [{"path": name, "sha256": digest} for name, digest in found.inputs.items()]
    content: dict[str, Any] = {"inputs": inputs, "results": [row.to_dict() for row in found.rows]}
    content |= {"curves": found.content()["curves"]}
    content |= {"remarks": [one.to_dict() for one in found.remarks], "columns": dict(found.columns)}
    return content | ({"written": [str(path) for path in written]} if written else {})
