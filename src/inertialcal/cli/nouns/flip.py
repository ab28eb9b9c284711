"""flip: bias and ambient acceleration of a head that was turned."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .. import figures
from ..options import Frame, Json, MissionStart, Quiet, Start, Stop
from ..shown.output import clean, json_out

if TYPE_CHECKING:
    from ...procedures.flip.files.call import FlipFile

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
    output: figures.FigureFile = None,
    campaign: Annotated[
        bool, typer.Option("--campaign", help="Write campaign.toml beside the files: run then writes the report.")
    ] = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run the command; its help stands in the declaration of the procedure."""
    from ...procedures.flip.files.call import flip as reduce_files
    from ..pairs import pairs

    figures.check_figure(output)
    if campaign:
        _check_campaign(paths, start, stop)
    found = reduce_files(
        list(paths), axis=axis, unit=unit, positions=pairs(position or [], "--position", '"reverse=180 deg"'),
        columns=pairs(column or [], "--column", "x=ax"),
        windows=_windows(window or []), angle=angle, settle=settle, corrected=corrected,
        start=start, stop=stop, mission_start=mission_start, frame=frame,
    )  # fmt: skip
    line = "" if output is None else figures.write(output, found, paths, {}, most=2)
    path = _write_campaign(found) if campaign else None
    if as_json:
        inputs = [{"path": name, "sha256": digest} for name, digest in found.inputs.items()]
        content: dict[str, Any] = {"inputs": inputs, "results": [row.to_dict() for row in found.rows]}
        content["remarks"] = [remark.to_dict() for remark in found.remarks]
        content |= {"written": str(output)} if line else {}
        json_out("flip", content | ({} if path is None else {"campaign": str(path)}))
    elif not quiet:
        _print(found, line, path)
    return 0


def _print(found: FlipFile, line: str, path: Path | None) -> None:
    """Print the figures, what there is to say of them, and what was written."""
    from ..shown.summary import remarks_text, results_text

    print(results_text({"results": [row.to_dict() for row in found.rows]}))
    for text in remarks_text([remark.to_dict() for remark in found.remarks]):
        print(text)
    if line:
        print(line)
    if path is not None:
        print(f"written: {clean(str(path))}\nNext: inertialcal run {shlex.quote(str(path.parent))}")


def _check_campaign(paths: list[Path], start: str | None, stop: str | None) -> None:
    """Refuse, before anything is computed, what cannot become a campaign.

    Raises
    ------
    UsageError, PlanError
        If only a part of the files is asked for, they lie in several folders, or there is a campaign already.
    """
    from ...core.errors import UsageError
    from ...procedures.flip.files.campaign import new_campaign

    if start is not None or stop is not None:
        do = "Write the part first: inertialcal convert IN OUT.parquet --from ... --to ..."
        raise UsageError("--campaign: a campaign takes whole files, not a part (--from, --to)", do=do)
    new_campaign(paths)


def _write_campaign(found: FlipFile) -> Path:
    from ...procedures.flip.files.campaign import write_flip_campaign

    return write_flip_campaign(found.sources, found.result.plan, found.unit)


def _windows(given: list[str]) -> list[tuple[str, str, str]]:
    """Return start, stop and angle of each window.

    Raises
    ------
    UsageError
        If a text does not have the form.
    """
    from ...core.errors import UsageError

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
