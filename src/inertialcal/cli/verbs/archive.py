"""archive: every test of every unit in one database."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..options import Folder, Json, Quiet
from ..shown.output import json_out, wrapped

if TYPE_CHECKING:
    from ...archive.archive import Added, Archive

VARIABLE = "INERTIALCAL_ARCHIVE"
Where = Annotated[
    str | None,
    typer.Option(
        "--archive",
        metavar="URL",
        help=f"File (lab.db) or postgresql://USER@HOST/DATABASE; {VARIABLE} if not given.",
        show_default=False,
    ),
]
Serial = Annotated[str, typer.Argument(metavar="SERIAL", help="Serial number of the unit.", show_default=False)]


def opened(where: str | None) -> Archive:
    """Return the archive that is named.

    Raises
    ------
    UsageError
        If none is; as ``open_archive``.
    """
    from ...archive import open_archive
    from ...core.errors import UsageError

    said = where or os.environ.get(VARIABLE, "")
    if not said:
        do = f"Add --archive lab.db, or set {VARIABLE}"
        raise UsageError("no archive is named", do=do, code="missing_option")
    return open_archive(said)


def archive_add(folder: Folder, archive: Where = None, as_json: Json = False, quiet: Quiet = False) -> int:
    """Add a campaign that was run: once, and a changed one as a new version."""
    added = opened(archive).add(folder)
    if as_json:
        json_out("archive add", {"archived": added.to_dict()})
    elif not quiet:
        print(wrapped(str(added)))
    return 0


def archive_list(
    serial: Annotated[str | None, typer.Option(help="Of this unit alone.", show_default=False)] = None,
    archive: Where = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """List the campaigns of an archive, by unit."""
    found = opened(archive).list(serial)
    if as_json:
        json_out("archive list", {"campaigns": [one.to_dict() for one in found.campaigns]})
    elif not quiet:
        _say(found)
    return 0


def archive_history(
    serial: Serial,
    archive: Where = None,
    part: Annotated[str | None, typer.Option(help="Part number, where several units have the serial number.")] = None,
    quantity: Annotated[str | None, typer.Option(help="Of this quantity alone: bias.", show_default=False)] = None,
    axis: Annotated[str | None, typer.Option(help="Of this axis alone.", show_default=False)] = None,
    test: Annotated[str | None, typer.Option(help="Of this test alone.", show_default=False)] = None,
    limit: Annotated[
        list[str],
        typer.Option(
            "--limit",
            help='How far a figure may change: "0.01 deg/s", bias="0.01 deg/s". Says when to calibrate again. '
            "May be repeated.",
        ),
    ] = [],  # noqa: B006 - typer copies it
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Show each figure of a unit over its tests: drift with uncertainty, and when to calibrate again."""
    found = opened(archive).history(serial, part, quantity, axis, test, limit)
    if as_json:
        content: dict[str, Any] = {"item": found.item, "results": found.results}
        content["series"] = [one.to_dict() for one in found.series]
        content["remarks"] = [one.to_dict() for one in found.remarks]
        json_out("archive history", content)
    elif not quiet:
        _say(found)
    return 0


def _say(found: object) -> None:
    """Print what is shown of it; on a terminal a screen of it."""
    from ..shown.screen import folded, say

    say(folded(str(found)))


def archived(archive: str, folder: Path) -> Added:
    """Add what a campaign just gave.

    Raises
    ------
    InertialcalError
        As ``Archive.add``; it says where the results are.
    """
    from dataclasses import replace

    from ...core.errors import InertialcalError

    try:
        return opened(archive).add(folder)
    except InertialcalError as error:
        why = f"the results are in {folder / 'out'}, and not in the archive"
        raise type(error)([replace(one, why=one.why or why) for one in error.problems]) from None
