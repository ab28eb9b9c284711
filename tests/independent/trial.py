"""What the commands make of each fault: exit, remarks, whether a model was written, whether intervals hold the truth.

::

    PYTHONPATH=src:tests python -m independent.trial [--n 5] [--fault NAME] [--on PROCEDURE] [--out FILE]

Seeds are 1 to n, never chosen. Each spoiled case is compared with the clean one of the same seed. A line counts, of n:

named
    a remark or refusal with one of the fault's codes, which names a spoiled recording;
other
    refused with another code, or another warning that the clean case does not have;
silent
    nothing that the clean case does not say;
model
    a model was written; ``held``: the part of the stated 95 % intervals that hold the truth, clean and spoiled;
    ``shift``: largest change of a figure in its clean standard uncertainties, ``width``: largest ratio of its
    uncertainty to the clean one, medians over the seeds. Among the new codes, ``+`` marks a quantity that the clean
    case does not show.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import shlex
import statistics
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import flip, moved_mass, positions, rate_table, static, thermal
from .case import Case
from .faults import FAULTS, PROPOSED, Fault, spoiled

BASES: dict[str, Callable[[int], Case]] = {
    "allan": lambda seed: static.still(
        seed, {"x": static.Noise(white=0.004), "y": static.Noise(white=0.004, bias=0.01)}, 72_000, 20.0, step=1e-4
    ),
    "allan:pad": lambda seed: static.still(seed, static.Noise(white=1e-6), 60_000, 142.0, sensor="acc", pad=True),
    "rate_table": lambda seed: rate_table.recorded(
        seed,
        rate_table.Gyros(turn_on=0.003, limit=100.0),
        rate_table.Protocol(axes="xy", samples=150),
        held_out=1,
    ),
    "rate_table:means": lambda seed: rate_table.reduced(seed, rate_table.Gyros(turn_on=0.003, dwell=0.002)),
    "rate_table:fast": lambda seed: rate_table.reduced(
        seed,
        rate_table.Gyros(turn_on=0.003),
        rate_table.Protocol(rates=(-2000.0, -1000.0, -500.0, 500.0, 1000.0, 2000.0)),
    ),
    "rate_table:unlabelled": lambda seed: rate_table.reduced(
        seed, rate_table.Gyros(dwell=0.002), rate_table.Protocol(runs=1, labelled=False)
    ),
    "positions": positions.by_hand,
    "thermal": thermal.ramped,
    "mass_attraction": moved_mass.moved,
    "flip": lambda seed: flip.turned(seed, programme=flip.Programme(dwells=4, before=300.0)),
}


@dataclass
class Outcome:
    """What one command did."""

    exit: int
    codes: Counter[str]  # of errors and of remarks that are no information
    said: list[tuple[str, str]]  # code and text of everything that was said
    model: bool
    errors: int = 0
    rows: list[dict[str, Any]] = field(default_factory=list)
    printed: str = ""


def called(words: Sequence[str], folder: Path) -> Outcome:
    """Run the command in this process, and return what it did."""
    from inertialcal.cli.__main__ import main

    out, err = io.StringIO(), io.StringIO()
    status = 0
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main([*words, "--json"])
        except SystemExit as left:
            status = int(left.code or 0)
    try:
        found = json.loads(out.getvalue())
    except ValueError:
        found = {"remarks": [], "errors": [], "results": []}
    said = [(one["code"], f"{one['where']} {one['what']}") for one in (*found["errors"], *found["remarks"])]
    loud = [one["code"] for one in found["errors"]]
    loud += [one["code"] for one in found["remarks"] if one["severity"] != "info"]
    model = any(path.name.startswith("model") for path in folder.rglob("model*.json"))
    return Outcome(
        status, Counter(loud), said, model, len(found["errors"]), found["results"], out.getvalue() + err.getvalue()
    )


def tried(case: Case) -> Outcome:
    """Write the case, run its command, and return what it did."""
    with tempfile.TemporaryDirectory(prefix="independent_") as name:
        folder = Path(name)
        return called(case.write(folder), folder)


def estimates(outcome: Outcome, test: str = "") -> dict[str, dict[str, Any]]:
    """Return the rows of main results by ``quantity axis [sensor] [at]``, as cases name their truth."""
    found: dict[str, dict[str, Any]] = {}
    for row in outcome.rows:
        if row.get("method") != "result" or row.get("member") or row["status"] == "not_estimated":
            continue
        if row["test"] not in ("", None, test) and test:
            continue
        name = row["quantity"] + (f"_{row['power']}" if row.get("power") else "")
        key = f"{name} {row['axis']}" + (f" {row['sensor']}" if row.get("sensor") else "")
        if row.get("at"):
            key += f" {row['at']['value']:g} {row['at']['unit']}"
        found.setdefault(key, row)
    return found


def holds(row: dict[str, Any], truth: float) -> bool | None:
    """Whether the stated interval of an estimate holds the truth; None where it states none."""
    interval = row.get("interval")
    if row["status"] != "estimated" or not interval or interval["lo"] is None or interval["hi"] is None:
        return None
    return bool(interval["lo"] <= truth <= interval["hi"])


def hits(case: Case, outcome: Outcome) -> tuple[int, int]:
    """Return how many stated intervals hold the truth, and how many there are."""
    rows = estimates(outcome, {"rate_table": "rates"}.get(case.procedure, ""))
    held = [holds(rows[key], truth) for key, truth in case.truth.items() if key in rows]
    return sum(one is True for one in held), sum(one is not None for one in held)


def verdict(fault: Fault, case: Case, outcome: Outcome, clean: Outcome) -> str:
    """Return named, other or silent; for a false finding absent or false."""
    if fault.expects == "absent":
        return "false" if any(row["quantity"] in fault.codes for row in outcome.rows) else "absent"
    stems = [name.removesuffix(".csv") for name in case.spoiled]
    anywhere = len(case.spoiled) != 1 or len(case.tables) == 1
    new = Counter(code for code, _ in outcome.said) - Counter(code for code, _ in clean.said)
    for code, text in outcome.said:
        if code in fault.codes and (code in new or outcome.exit == 3) and (anywhere or any(s in text for s in stems)):
            return "named"
    if outcome.exit in (2, 3, 70) or outcome.codes - clean.codes:
        return "other"
    return "silent"


@dataclass
class Line:
    """A row of the table."""

    fault: str
    on: str
    n: int
    verdicts: Counter[str]
    exits: Counter[int]
    models: int
    codes: Counter[str]
    held: tuple[int, int]
    clean_held: tuple[int, int]
    shifts: list[float] = field(default_factory=list)  # largest shift of a figure, in clean standard uncertainties
    widths: list[float] = field(default_factory=list)  # largest ratio of its stated uncertainty to the clean one


def measured(fault: Fault, on: str, n: int, clean: dict[tuple[str, int], tuple[Case, Outcome]]) -> Line:
    """Try one fault on one procedure, seeds 1 to n."""
    line = Line(fault.name, on, n, Counter(), Counter(), 0, Counter(), (0, 0), (0, 0))
    for seed in range(1, n + 1):
        if (on, seed) not in clean:
            case = BASES[on](seed)
            clean[on, seed] = case, tried(case)
        case, before = clean[on, seed]
        bad = spoiled(case, fault.name)
        after = tried(bad)
        line.verdicts[verdict(fault, bad, after, before)] += 1
        line.exits[after.exit] += 1
        line.models += after.model
        line.codes.update(set(after.codes) - set(before.codes))
        line.codes.update(f"+{quantity}" for quantity in found_quantities(after) - found_quantities(before))
        for name, one in (("held", after), ("clean_held", before)):
            pair = tuple(a + b for a, b in zip(getattr(line, name), hits(case, one), strict=True))
            setattr(line, name, pair)
        shift, width = changed(case, before, after)
        line.shifts.append(shift)
        line.widths.append(width)
    return line


def found_quantities(outcome: Outcome) -> set[str]:
    """Return the quantities of which something was estimated."""
    return {row["quantity"] for row in estimates(outcome).values() if row["status"] == "estimated"}


def changed(case: Case, before: Outcome, after: Outcome) -> tuple[float, float]:
    """Return the largest shift of a figure in clean standard uncertainties, and the largest ratio of uncertainties."""
    test = {"rate_table": "rates"}.get(case.procedure, "")
    first, second = estimates(before, test), estimates(after, test)
    both = [(first[key], second[key]) for key in case.truth if key in first and key in second]
    pairs = [(a, b) for a, b in both if a["status"] == b["status"] == "estimated" and a["u"] and b["u"]]
    if not pairs:
        return float("nan"), float("nan")
    return max(abs(b["value"] - a["value"]) / a["u"] for a, b in pairs), max(b["u"] / a["u"] for a, b in pairs)


def shown(lines: Sequence[Line]) -> str:
    """Return the table in Markdown."""
    rows = [
        "| fault | on | expected | named | other | silent | model | exits | held | shift | width | new codes |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for line in lines:
        fault = FAULTS[line.fault]
        expected = fault.expects if fault.expects != "named" else "/".join(fault.codes[:2])
        if fault.expects == "named" and fault.codes[0] in PROPOSED:
            expected += " (proposed)"
        told = [f"{line.verdicts[word]}" for word in ("named", "other", "silent")]
        if fault.expects == "absent":
            told = [f"absent {line.verdicts['absent']}", f"false {line.verdicts['false']}", ""]
        exits = " ".join(f"{code}x{count}" for code, count in sorted(line.exits.items()))
        held = " -> ".join(f"{a}/{b}" for a, b in (line.clean_held, line.held))
        codes = " ".join(f"{code}x{count}" for code, count in line.codes.most_common(4))
        shift, width = (f"{statistics.median(one):.3g}" for one in (line.shifts, line.widths))
        cells = [line.fault, line.on, expected, *told, str(line.models), exits, held, shift, width, codes]
        rows.append("| " + " | ".join(cells) + " |")
    return "\n".join(rows)


def kept(folder: Path, names: Sequence[str], procedures: Sequence[str]) -> int:
    """Write the files of seed 1, clean or with each of these faults, and print the command of each."""
    for on in procedures:
        case = BASES[on](1)
        cases = {"clean": case} | {name: spoiled(case, name) for name in names if on in FAULTS[name].on}
        for name, one in cases.items():
            print(shlex.join(["inertialcal", *one.write(folder / on.replace(":", "_") / name)]))
    return 0


def main(words: Sequence[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=5)
    parser.add_argument("--fault", nargs="*", default=[])
    parser.add_argument("--on", nargs="*", default=[])
    parser.add_argument("--out", type=Path)
    parser.add_argument("--write", type=Path, metavar="FOLDER", help="only write the files, and print their commands")
    given = parser.parse_args(words)
    if given.write:
        return kept(given.write, given.fault, given.on or list(BASES))
    clean: dict[tuple[str, int], tuple[Case, Outcome]] = {}
    lines = []
    for on in given.on or BASES:
        for fault in FAULTS.values():
            if on in fault.on and (not given.fault or fault.name in given.fault):
                lines.append(measured(fault, on, given.n, clean))
                print(shown(lines[-1:]).splitlines()[-1], file=sys.stderr, flush=True)
        clean = {}
    table = f"Seeds 1 to {given.n}.\n\n{shown(lines)}"
    print(table)
    if given.out:
        given.out.write_text(table + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
