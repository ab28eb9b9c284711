"""lot: one campaign for many units."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..options import Json, Quiet
from ..shown.output import found, json_out
from ..shown.progress import progress


def lot(
    lot: Annotated[
        Path,
        typer.Argument(
            metavar="LOT",
            help="LOT.toml or its folder, or a folder with campaign.toml and a folder a unit.",
            show_default=False,
        ),
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="New folder for what is made.", show_default=False)
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the lot in that folder: redo what is missing or has changed.")
    ] = False,
    workers: Annotated[
        int | None,
        typer.Option("--workers", metavar="N", help="Processes; one for each core if not given.", show_default=False),
    ] = None,
    scheduler: Annotated[
        str,
        typer.Option("--scheduler", metavar="URL", help="Work on a dask cluster: tcp://HOST:8786.", show_default=False),
    ] = "",
    archive: Annotated[
        str, typer.Option("--archive", metavar="URL", help="Add each unit to this archive: lab.db.", show_default=False)
    ] = "",
    report: Annotated[
        bool, typer.Option("--report/--no-report", help="Write report.html, the page of the lot.")
    ] = True,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Reduce every unit of a lot by one campaign: figures, model and verdict of each as a row of Parquet files."""
    from ..process import without_pandas

    without_pandas()  # first: what is loaded next asks for it
    from ...core.errors import UsageError
    from ...core.show.tables import text
    from ...lots.lot import lot as reduce_lot
    from ..shown.screen import say, screen
    from ..shown.summary import remarks_part

    if output is None:
        raise UsageError("lot needs a folder", do="Name the folder after -o", code="missing_option")
    with progress(quiet or as_json) as tell:
        outcome = reduce_lot(lot, output, resume, workers, scheduler, archive, tell, report)
    found(outcome.exit_status)
    remarks = [one.to_dict() for one in outcome.remarks]
    if as_json:
        done = {"redone": outcome.redone, "kept": outcome.kept, "archived": outcome.archived, "written": str(output)}
        json_out("lot", {**outcome.content, **done, "remarks": remarks}, outcome.exit_status)
    elif not quiet:
        kept = f"{outcome.redone} reduced now, {outcome.kept} kept"
        kept += f", {outcome.archived} added to the archive" * bool(archive)
        say(screen([text(outcome.parts()), remarks_part(remarks), kept]))
    return outcome.exit_status
