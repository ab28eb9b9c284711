"""flip: bias and ambient acceleration of a head that was turned."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .options import Frame, Json, MissionStart, Quiet, Start, Stop
from .output import json_out

Paths = Annotated[list[Path], typer.Argument(help="A table of means, or recordings of the head.", show_default=False)]


def flip(
    paths: Paths,
    axis: Annotated[str, typer.Option(help="Head axis about which it was turned: x, y or z.")] = "x",
    unit: Annotated[str | None, typer.Option(help="Unit of the readings, where the files do not say it.")] = None,
    position: Annotated[
        list[str] | None, typer.Option(help='Angle of a position of a table: "reverse=180 deg"; may be repeated.')
    ] = None,
    window: Annotated[
        list[str] | None, typer.Option(help='When the head stood still: "START..STOP=180 deg"; may be repeated.')
    ] = None,
    angle: Annotated[str, typer.Option(help="Of the turns, where windows are not given but found.")] = "180 deg",
    column: Annotated[list[str] | None, typer.Option(help="Channel of an axis: x=COLUMN; may be repeated.")] = None,
    settle: Annotated[str, typer.Option(help="Left out at the start of each window.")] = "0 s",
    corrected: Annotated[bool, typer.Option("--corrected", help="The bias of a model was taken off before.")] = False,
    start: Start = None,
    stop: Stop = None,
    mission_start: MissionStart = None,
    frame: Frame = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Bias and ambient acceleration of a triaxial accelerometer head, from turning it in orbit."""
    from ..campaign.single_flip import flip as reduce_files
    from .pairs import pairs

    found = reduce_files(
        list(paths), axis=axis, unit=unit, positions=pairs(position or [], "--position", '"reverse=180 deg"'),
        columns=pairs(column or [], "--column", "x=ax"),
        windows=_windows(window or []), angle=angle, settle=settle, corrected=corrected,
        start=start, stop=stop, mission_start=mission_start, frame=frame,
    )  # fmt: skip
    rows = [row.to_dict() for row in found.rows]
    remarks = [remark.to_dict() for remark in found.remarks]
    if as_json:
        inputs = [{"path": path, "sha256": digest} for path, digest in found.inputs.items()]
        json_out("flip", {"inputs": inputs, "results": rows, "remarks": remarks})
    elif not quiet:
        from .summary import remarks_text, results_text

        print(results_text({"results": rows}))
        for text in remarks_text(remarks):
            print(text)
    return 0


def _windows(given: list[str]) -> list[tuple[str, str, str]]:
    """Return start, stop and angle of each window.

    Raises
    ------
    UsageError
        If a text does not have the form.
    """
    from ..core.errors import UsageError

    found = []
    for text in given:
        span, _, angle = text.rpartition("=")
        start, dots, stop = span.partition("..")
        if not (dots and start and stop and angle):
            raise UsageError(
                f"--window {text!r}: write START..STOP=ANGLE", do='Like "006/00:47:00..006/00:55:00=0 deg"'
            )
        found.append((start.strip(), stop.strip(), angle.strip()))
    return found
