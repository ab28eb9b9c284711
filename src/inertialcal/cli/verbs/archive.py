"""archive: every test of every unit in one database."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .. import figures
from ..options import Folder, Json, Quiet
from ..shown.output import json_out, wrapped

if TYPE_CHECKING:
    from ...archive.archive import Added, Archive
    from ...archive.history import History
    from ...archive.trend import Trend

PICTURES = 3  # in one file, side by side
PAGE = ".html"
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
HistoryFile = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        help="Write figures (.png, .svg or .pdf, by the ending), or a page with all of the unit (.html).",
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
    adjusted: Annotated[
        list[str],
        typer.Option(
            "--adjusted",
            metavar="DAY",
            help="Day of an adjustment: tests of that day are after it. May be repeated.",
        ),
    ] = [],  # noqa: B006 - typer copies it
    output: HistoryFile = None,
    plot: figures.Plot = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Show each figure of a unit over its tests: drift with uncertainty, and when to calibrate again."""
    is_page = output is not None and output.suffix.lower() == PAGE
    figures.check_figure(None if is_page else output, {}, plot, as_json)
    where = opened(archive)
    found = where.history(serial, part, quantity, axis, test, limit, adjusted)
    if as_json:
        content: dict[str, Any] = {"item": found.item, "results": found.results}
        content["series"] = [one.to_dict() for one in found.series]
        content["remarks"] = [one.to_dict() for one in found.remarks]
        json_out("archive history", content)
    elif not quiet:
        _say(found)
        for remark in found.remarks:
            if remark.severity == "warning":
                print(wrapped(str(remark)))
    if output is not None and is_page:
        from ...archive.page import history_page
        from ...files.write.atomic import atomic_write

        with atomic_write(output, []) as aside:
            aside.write_text(history_page(where, found), encoding="utf-8", errors="replace", newline="\n")
        if not (quiet or as_json):
            print(wrapped(f"written: {output}"))
    _draw(None if is_page else output, found, plot, quiet or as_json)
    return 0


def archive_trend(
    quantity: Annotated[str, typer.Argument(metavar="QUANTITY", help="Which: bias.", show_default=False)],
    archive: Where = None,
    axis: Annotated[str | None, typer.Option(help="Of this axis alone.", show_default=False)] = None,
    test: Annotated[str | None, typer.Option(help="Of this test alone.", show_default=False)] = None,
    part: Annotated[str | None, typer.Option(help="Of units of this part number alone.", show_default=False)] = None,
    by: Annotated[str, typer.Option("--by", help="A point for each unit, or for each lot: unit, lot.")] = "unit",
    every: Annotated[bool, typer.Option("--every", help="All tests of a unit, not the last alone.")] = False,
    output: figures.FigureFile = None,
    plot: figures.Plot = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Show a quantity over all units as a control chart, with the uncertainty of the tests in its limits."""
    from ...core.errors import UsageError

    if by not in ("unit", "lot"):
        raise UsageError(f"--by {by}", do="Say unit or lot", code="wrong_value")
    figures.check_figure(output, {}, plot, as_json)
    found = opened(archive).trend(quantity, axis, test, part, "lot" if by == "lot" else "unit", every)
    if as_json:
        content = {"charts": [one.to_dict() for one in found.groups]}
        json_out("archive trend", content | {"remarks": [one.to_dict() for one in found.remarks]})
    elif not quiet:
        _say(found)
    _draw(output, found, plot, quiet or as_json)
    return 0


Number = Annotated[int, typer.Argument(help="Number of a campaign, as archive list has it.", show_default=False)]


def archive_compare(
    first: Number,
    second: Number,
    archive: Where = None,
    allowed: Annotated[
        list[str],
        typer.Option("--allowed", help='Change that does not matter: "0.1 %", or bias="0.01 deg/s". May be repeated.'),
    ] = [],  # noqa: B006 - typer copies it
    shared: Annotated[
        list[str],
        typer.Option("--shared", help="Standard whose error is the same in both: rate_table.rate. May be repeated."),
    ] = [],  # noqa: B006 - typer copies it
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Compare two campaigns of an archive, figure by figure, with the uncertainty of each difference."""
    from .models import print_comparison

    found = opened(archive).compare(first, second, allowed, shared=shared)
    print_comparison("archive compare", found, as_json, quiet)
    return found.exit_status


def archive_export(
    output: Annotated[Path, typer.Argument(metavar="FILE.zip", help="File to write.", show_default=False)],
    archive: Where = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Write an archive into a zip file that other programs can read, with a hash of each part."""
    found = opened(archive).export(output)
    if as_json:
        json_out("archive export", {"written": str(output), "moved": found.to_dict()})
    elif not quiet:
        print(wrapped(f"written: {output} ({found.campaigns} campaigns, {found.files} documents)"))
        print(f"chain: {found.chain or 'none yet'}")
    return 0


def archive_import(
    source: Annotated[Path, typer.Argument(metavar="FILE.zip", help="An export of an archive.", show_default=False)],
    archive: Where = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Add the campaigns of an export that are not there: all of them, or none."""
    found = opened(archive).import_(source)
    if as_json:
        json_out("archive import", {"moved": found.to_dict()})
    elif not quiet:
        new = found.campaigns - found.there
        print(wrapped(f"added: {new} campaigns; {found.there} were there already"))
        print(f"chain: {found.chain or 'none yet'}")
    return 0


def archive_verify(
    archive: Where = None,
    receipt: Annotated[
        Path | None,
        typer.Option(
            "--receipt",
            metavar="FILE",
            help="Earlier output of archive verify --json: what it counted has to be there.",
            show_default=False,
        ),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Compare all that an archive holds with what was added, and name what is missing or changed."""
    from ...core.errors import DataError

    found = opened(archive).verify(receipt)
    if found.problems:
        raise DataError(list(found.problems))
    if as_json:
        json_out("archive verify", {"verified": found.to_dict()})
    elif not quiet:
        _say(found)
    return 0


def archive_migrate(
    archive: Where = None,
    to: Annotated[
        str | None, typer.Option("--to", help="Version; the newest if not given.", show_default=False)
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Bring the tables of an archive to those of this version of inertialcal, or back to earlier ones."""
    where = opened(archive)
    before, now = where.migrate() if to is None else where.migrate(to)
    if as_json:
        json_out("archive migrate", {"before": before, "now": now})
    elif not quiet:
        same = f"schema {now} already"
        print(wrapped(f"{where.database.name}: {same if before == now else f'schema {before} is now {now}'}"))
    return 0


def _draw(output: Path | None, found: History | Trend, plot: bool, quiet: bool) -> None:
    """Draw the first pictures in text, and into a file, side by side; say what was left out."""
    if plot:
        figures.print_plot(found, {}, PICTURES)
    if output is not None:
        from ...report.figure_file import write_figure
        from ...report.plot import pictures

        drawn = pictures(found)
        write_figure(output, drawn[:PICTURES])
        if not quiet:
            rest = len(drawn) - PICTURES
            more = f"; {rest} more are not drawn" if rest > 0 else ""
            print(wrapped(f"written: {output}{more}"))


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
