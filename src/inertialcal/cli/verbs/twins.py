"""simulate, score: campaigns whose truth is known."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...rigs import RIGS
from ..options import Json, Quiet, faults_beginning, rigs_beginning
from ..shown.output import clean, json_out, table
from ..shown.progress import progress

if TYPE_CHECKING:
    from ...campaign.twins.score import Coverage, Score


def simulate(
    rig: Annotated[
        str,
        typer.Argument(
            help=f"Of a rig: {', '.join(RIGS)}.",
            autocompletion=rigs_beginning,
            show_default=False,
        ),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="New folder for the campaign.", show_default=False)],
    seed: Annotated[int, typer.Option(help="Everything that is drawn follows from it.")] = 1,
    fault: Annotated[
        str,
        typer.Option(help="A mistake to put in, like wrong_sign.", autocompletion=faults_beginning, show_default=False),
    ] = "",
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Write the campaign of a simulated rig: recordings, campaign.toml, and the truth for `score`."""
    from ...campaign.twins.twin import simulate as write

    written = write(rig, output, seed, fault)
    if as_json:
        content = {"written": str(written.folder), "recordings": list(written.recordings), "truth_sha256": written.seal}
        json_out("simulate", content | {"rig": rig, "seed": seed, "fault": fault})
    elif not quiet:
        print(clean(f"written: {written.folder} ({len(written.recordings)} recordings)"))
        print(clean(f"truth sealed in {written.folder / '.truth'}, SHA-256 {written.seal}"))
        folder = shlex.quote(str(written.folder))
        print(clean(f"Next: inertialcal run {folder}, then inertialcal score {folder}"))
    return 0


def score(
    folder: Annotated[Path | None, typer.Argument(help="Folder of a simulated campaign.", show_default=False)] = None,
    rig: Annotated[
        str | None,
        typer.Option(
            help="Score a rig over many seeds, in memory, instead.",
            autocompletion=rigs_beginning,
            show_default=False,
        ),
    ] = None,
    n: Annotated[int, typer.Option("--n", help="With --rig: how many campaigns.")] = 300,
    seed_from: Annotated[int, typer.Option(help="With --rig: the first seed.")] = 1,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Compare the estimates of a simulated campaign with its truth, or count how often a rig's intervals hold it."""
    from ...core.errors import UsageError

    if (folder is None) == (rig is None):
        raise UsageError("score needs a folder or --rig, one of them", do="Try: inertialcal score --help")
    if folder is not None:
        return _campaign(folder, as_json, quiet)
    return _rig(str(rig), n, seed_from, as_json, quiet)


def _campaign(folder: Path, as_json: bool, quiet: bool) -> int:
    from ...campaign.twins.score import score as score_campaign

    found = score_campaign(folder)
    if as_json:
        truth = {"rig": found.truth.rig, "seed": found.truth.seed, "fault": found.truth.fault,
                 "truth_sha256": found.truth.seal}  # fmt: skip
        counts = {"inside": found.inside, "estimated": found.estimated, "known": len(found.rows)}
        json_out("score", {"results": list(found.rows)} | truth | counts)
    elif not quiet:
        print(truth_table(found.rows))
        print(f"\n{held_text(found)}")
    return 0


def truth_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return estimates beside the truth, a line each."""
    from ...campaign.twins.score import truth_grid

    grid = truth_grid(rows)
    return table(grid.rows, grid.heads)


def held_text(found: Score) -> str:
    """Say how many of the stated intervals hold the truth."""
    missing = len(found.rows) - found.estimated
    said = f"{found.inside} of {found.estimated} stated 95 % intervals hold the truth"
    return f"{said}\n{missing} not estimated" if missing else said


def _rig(rig: str, n: int, first: int, as_json: bool, quiet: bool) -> int:
    from ...campaign.twins.score import RULE, score_rig

    with progress(quiet or as_json) as tell:
        found = score_rig(rig, n, first, tell)
    status = 1 if any(one.verdict == "FAIL" for one in found) else 0
    if as_json:
        rows = [one.to_dict() for one in found]
        verdicts = [
            {name: row[name] for name in ("quantity", "axis", "sensor", "power", "at", "test", "verdict")}
            for row in rows
        ]
        seeds = {"rig": rig, "n": n, "seed_from": first, "rule": RULE}
        json_out("score", {"results": rows, "verdicts": verdicts} | seeds, status)
    elif not quiet:
        cells = [_coverage_cells(one) for one in found]
        heads = ["quantity", "axis", "held", "rate", "99.9 % interval", "verdict"]
        print(table(cells, heads, right=(2, 3)))
        print(f"\nseeds {first} to {first + n - 1}; PASS where {RULE}")
    return status


def _coverage_cells(one: Coverage) -> list[str]:
    ends = "-" if one.interval is None else f"{one.interval[0]:.1%} .. {one.interval[1]:.1%}"
    rate = "-" if one.rate is None else f"{one.rate:.1%}"
    missing = f" ({one.missing} without an interval)" if one.missing else ""
    where = ", ".join(word for word in (one.test, one.sensor, str(one.at or "")) if word)
    quantity = f"{one.key.name} ({where})" if where else one.key.name
    return [quantity, one.axis, f"{one.hits} of {one.n}", rate, ends, one.verdict + missing]
