"""simulate, score: campaigns whose truth is known."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...core.show.rounding import items
from ...rigs import RIGS
from ..options import Json, Quiet, faults_beginning, rigs_beginning
from ..shown.output import clean, json_out, table, terminal_width, wrapped
from ..shown.progress import progress
from ..shown.screen import folded, say, screen

if TYPE_CHECKING:
    from ...campaign.twins.score import Coverage, FaultScore, Score

LOT = "lot"  # in place of a rig: many units
FAULT_HEADS = ["fault", "size", "what it does", "expected"]


def simulate(
    rig: Annotated[
        str,
        typer.Argument(
            help=f"lot (many units), or a rig: {', '.join(RIGS)}.",
            autocompletion=rigs_beginning,
            show_default=False,
        ),
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="New folder for the campaign.", show_default=False)
    ] = None,
    seed: Annotated[int, typer.Option(help="Everything that is drawn follows from it.")] = 1,
    fault: Annotated[
        str,
        typer.Option(
            help="A mistake to put in: NAME, or NAME=SIZE, like glitch or run_gain=5 %.",
            metavar="NAME[=SIZE]",
            autocompletion=faults_beginning,
            show_default=False,
        ),
    ] = "",
    lab: Annotated[
        bool,
        typer.Option(
            "--lab", help="In place of the recordings: a LAB.toml, with which `sequence` makes them on the rig."
        ),
    ] = False,
    n: Annotated[
        int | None, typer.Option("--n", help="Units of a lot: 100, where it is not said.", show_default=False)
    ] = None,
    faults: Annotated[bool, typer.Option("--faults", help="List the mistakes that the rig can simulate.")] = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Write the campaign of a simulated rig: recordings, campaign.toml, and the truth for `score`."""
    from ...core.errors import UsageError

    if faults:
        return _faults(rig, as_json, quiet)
    if n is not None and rig != LOT:
        raise UsageError(f"--n: {rig} is one unit", do="Leave it out, or simulate a lot", code="wrong_value")
    if output is None:
        raise UsageError("simulate needs a new folder", do=f"Say: inertialcal simulate {rig} -o DIR")
    if lab:
        return _rehearsal(rig, output, seed, fault, as_json, quiet)
    if rig == LOT:
        return _lot(output, 100 if n is None else n, seed, fault, as_json, quiet)
    from ...campaign.twins.twin import simulate as write

    written = write(rig, output, seed, fault)
    if as_json:
        content = {"written": str(written.folder), "recordings": list(written.recordings), "truth_sha256": written.seal}
        json_out("simulate", content | {"rig": rig, "seed": seed, "fault": written.fault, "size": written.size})
    elif not quiet:
        print(wrapped(f"written: {written.folder} ({items(len(written.recordings), 'recording')})"))
        print(wrapped(f"the true values are sealed in .truth there, SHA-256 {written.seal}"))
        folder = shlex.quote(str(written.folder))
        run_it, score_it = f"Next: inertialcal run {folder}", f"then inertialcal score {folder}"
        both = clean(f"{run_it}, {score_it}")
        print(both if len(both) <= terminal_width() else clean(run_it) + "\n" + clean(score_it))
    return 0


def _rehearsal(rig: str, output: Path, seed: int, fault: str, as_json: bool, quiet: bool) -> int:
    """Write what makes the campaign of a rig."""
    from ...core.errors import UsageError
    from ...lab.sequence.rehearsal import write_rehearsal

    if fault:
        raise UsageError("--lab: a bench has no mistakes", do="Leave out --fault", code="wrong_value")
    written = write_rehearsal(rig, output, seed)
    if as_json:
        json_out("simulate", {"written": str(output), "lab": str(written), "rig": rig, "seed": seed})
    elif not quiet:
        print(wrapped(f"written: {written}"))
        print(clean(f"Next: inertialcal sequence {shlex.quote(str(written))} -o {shlex.quote(str(output / 'made'))}"))
    return 0


def _lot(output: Path, n: int, seed: int, fault: str, as_json: bool, quiet: bool) -> int:
    """Write a lot."""
    from ...lots.twin import line_of, write_lot

    with progress(quiet or as_json) as tell:
        written = write_lot(output, line_of(n, fault), seed, lambda done, every: tell(done, every, "tests of units"))
    if as_json:
        content = {"written": str(written.folder), "units": written.units, "tests": written.tests}
        json_out(
            "simulate", content | {"truth_sha256": written.seal, "rig": LOT, "seed": seed, "faults": [*written.faults]}
        )
    elif not quiet:
        print(wrapped(f"written: {written.folder} ({items(written.units, 'unit')}, {items(written.tests, 'test')})"))
        for one in written.faults:
            print(wrapped(f"mistake put in: {one}"))
        print(wrapped(f"the true values are in .truth there, SHA-256 {written.seal}"))
        lot, out = shlex.quote(str(written.folder / "LOT.toml")), shlex.quote(f"{written.folder}-out")
        lot_it, score_it = f"Next: inertialcal lot {lot} -o {out}", f"then inertialcal score {out}"
        print(clean(f"{lot_it}, {score_it}"))
    return 0


def _faults_of_lots(as_json: bool, quiet: bool) -> int:
    """List the mistakes of a lot."""
    from ...lots.twin import FAULTS

    if as_json:
        rows = [{"fault": name, "size": one.size, "unit": one.unit, "what": one.what} for name, one in FAULTS.items()]
        json_out("simulate", {"rig": LOT, "faults": rows})
    elif not quiet:
        print(table([[name, f"{one.size:g} {one.unit}", one.what] for name, one in FAULTS.items()], FAULT_HEADS[:3]))
    return 0


def _faults(rig: str, as_json: bool, quiet: bool) -> int:
    """List the mistakes of a rig."""
    if rig == LOT:
        return _faults_of_lots(as_json, quiet)
    known = RIGS.named(rig).every_fault
    if as_json:
        rows = [
            {"fault": name, "size": one.size, "unit": one.unit, "what": one.what, "expects": one.expects,
             "codes": list(one.codes)}
            for name, one in known.items()
        ]  # fmt: skip
        json_out("simulate", {"rig": rig, "faults": rows})
    elif not quiet:
        print(table([[name, one.default, one.what, one.expected] for name, one in known.items()], FAULT_HEADS))
    return 0


def score(
    folder: Annotated[
        Path | None, typer.Argument(help="Folder of a simulated campaign, or of what `lot` wrote.", show_default=False)
    ] = None,
    rig: Annotated[
        str | None,
        typer.Option(
            help="Score a rig over many seeds, in memory, instead.",
            autocompletion=rigs_beginning,
            show_default=False,
        ),
    ] = None,
    fault: Annotated[
        str,
        typer.Option(
            help="With --rig: a mistake in every campaign; counts how often it is named, or covered.",
            metavar="NAME[=SIZE]",
            autocompletion=faults_beginning,
            show_default=False,
        ),
    ] = "",
    n: Annotated[
        int | None,
        typer.Option("--n", help="With --rig: how many campaigns.", show_default="300; 60 with --fault"),
    ] = None,
    seed_from: Annotated[int, typer.Option(help="With --rig: the first seed.")] = 1,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Compare estimates of a simulated campaign or lot with the truth, or count how often a rig's intervals hold it."""
    from ...core.errors import UsageError

    if (folder is None) == (rig is None):
        raise UsageError("score needs a folder or --rig, one of them", do="Try: inertialcal score --help")
    if folder is not None and fault:
        raise UsageError("score FOLDER takes no --fault", do="The campaign says which fault is in it")
    if folder is not None:
        return _campaign(folder, as_json, quiet)
    if fault:
        return _fault(str(rig), fault, 60 if n is None else n, seed_from, as_json, quiet)
    return _rig(str(rig), 300 if n is None else n, seed_from, as_json, quiet)


def _campaign(folder: Path, as_json: bool, quiet: bool) -> int:
    from ...campaign.twins.score import Score as OfCampaign
    from ...core.show.tables import text
    from ...lots.score import score as score_folder

    found = score_folder(folder)
    status = 1 if found.verdict == "FAIL" else 0
    if not isinstance(found, OfCampaign):
        if as_json:
            json_out("score", found.to_dict(), status)
        elif not quiet:
            say(screen([text(found.parts())]))
        return status
    if as_json:
        of = found.truth
        truth = {"rig": of.rig, "seed": of.seed, "fault": of.fault, "size": of.size, "truth_sha256": of.seal}
        counts = {
            "inside": found.inside, "estimated": found.estimated, "known": len(found.rows),
            "expected": {"lo": found.expected[0], "hi": found.expected[1], "p": 0.95},
            "inside_apart": found.inside_apart, "judged_apart": found.judged_apart,
        }  # fmt: skip
        standards = [
            {"influence": one.influence, "error_in_u": one.error, "inside": one.inside, "figures": figures}
            for one, figures in found.standards.items()
        ]
        content = {"results": list(found.rows), "standards": standards, "not_apart": list(found.unshared)}
        json_out("score", content | truth | counts | _judged(found), status)
    elif not quiet:
        if found.rows:
            print(f"{folded(truth_table(found.rows))}\n")
        say(held_text(found))
    return status


def _judged(found: Score) -> dict[str, Any]:
    """Return what ``--json`` says of a campaign with a fault."""
    if found.fault is None:
        return {}
    verdict = {
        "fault": found.truth.fault, "expects": found.fault.expects, "codes": list(found.fault.codes),
        "spoiled": list(found.truth.spoiled), "verdict": found.verdict,
    }  # fmt: skip
    problems = [one.to_dict() for one in found.brought.problems]
    return {"verdicts": [verdict], "refused": problems, "remarks": [one.to_dict() for one in found.brought.remarks]}


def truth_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return estimates beside the truth, a line each."""
    from ...campaign.twins.score import truth_grid

    grid = truth_grid(rows)
    return table(grid.rows, grid.heads)


def held_text(found: Score) -> str:
    """Say how many of the stated intervals hold the truth, also apart from the standards."""
    return "\n".join(map(wrapped, found.said))


def _fault(rig: str, fault: str, n: int, first: int, as_json: bool, quiet: bool) -> int:
    """Count how often a fault is named, or covered, as its entry expects."""
    from ...campaign.twins.score import score_fault

    with progress(quiet or as_json) as tell:
        found = score_fault(rig, fault, n, first, tell)
    status = 1 if found.verdict == "FAIL" else 0
    named, (lo, hi) = found.named, found.named.interval
    if as_json:
        verdict = {"fault": found.name, "size": found.size, "expects": found.fault.expects,
                   "codes": list(found.fault.codes), "verdict": found.verdict}  # fmt: skip
        counts = {"hits": named.hits, "interval": {"lo": lo, "hi": hi, "p": 0.95}, "others": dict(named.others)}
        content = {"results": [one.to_dict() for one in found.coverage], "verdicts": [verdict]} | counts
        json_out("score", content | {"rig": rig, "n": n, "seed_from": first}, status)
    elif not quiet:
        if found.coverage:
            heads = ["quantity", "axis", "held", "rate", "99.9 % interval", "verdict"]
            print(table([_coverage_cells(one) for one in found.coverage], heads, right=(2, 3)))
        print(_counted(found, lo, hi, first))
    return status


def _counted(found: FaultScore, lo: float, hi: float, first: int) -> str:
    """Return the lines below the table of a fault over many seeds."""
    named, size = found.named, f" = {found.size}" if found.size else ""
    did = {"covered": "did", "named": "named", "refused": "refused"}[found.fault.expects]
    others = [f"  {count} x {what}" for what, count in named.others.items()]
    lines = [
        f"fault {found.name}{size}: expected {found.fault.expected}",
        f"{named.hits} of {named.n} {did} as expected (95 % interval {lo:.1%} .. {hi:.1%}); at least 95 % needed",
        *others,
        f"seeds {first} to {first + named.n - 1}; verdict: {found.verdict}",
    ]
    return "\n".join(wrapped(line, "    ") for line in lines)


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
        print("\n" + wrapped(f"seeds {first} to {first + n - 1}; PASS where {RULE}"))
    return status


def _coverage_cells(one: Coverage) -> list[str]:
    ends = "-" if one.interval is None else f"{one.interval[0]:.1%} .. {one.interval[1]:.1%}"
    rate = "-" if one.rate is None else f"{one.rate:.1%}"
    missing = f" ({one.missing} without an interval)" if one.missing else ""
    where = ", ".join(word for word in (one.test, one.key.sensor, str(one.key.at or "")) if word)
    quantity = f"{one.key.name} ({where})" if where else one.key.name
    return [quantity, one.key.axis, f"{one.hits} of {one.n}", rate, ends, one.verdict + missing]
