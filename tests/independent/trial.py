"""One case: its command is called in this process, as from a shell, and what it says is judged.

named
    a remark or refusal with one of the fault's codes, which names a spoiled recording: by its file in ``where``, or by
    its name in the text;
other
    refused with another code, or another warning that the clean case does not have;
silent
    nothing that the clean case does not say.
"""

from __future__ import annotations

import contextlib
import io
import json
import re
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

from .case import Case
from .faults import Fault

KEPT = 3e-3  # of a figure of the clean record, relative


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
    """Run the command in this process, and return what it did; no report is drawn, which takes most of the time."""
    from inertialcal.cli.__main__ import main

    out, err = io.StringIO(), io.StringIO()
    status = 0
    undrawn = mock.patch("inertialcal.report.page.report_html", return_value="")
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), undrawn:
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
    archived = any(table.kind == "pad" for table in case.tables.values())  # files have names of their own
    names = r"\w+" if archived else "|".join(re.escape(name.rsplit(".", 1)[0]) for name in case.spoiled)
    new = Counter(code for code, _ in outcome.said) - Counter(code for code, _ in clean.said)
    for code, text in outcome.said:
        if code in fault.codes and (code in new or outcome.exit == 3) and re.search(rf"(?<!\w)({names})(?!\w)", text):
            return "named"
    if outcome.exit in (2, 3, 70) or outcome.codes - clean.codes:
        return "other"
    return "silent"


def kept(fault: Fault, before: Outcome, after: Outcome) -> bool:
    """Whether the figures that a fault may not move are those of the clean record."""
    first, second = (
        {k: r["value"] for k, r in estimates(one).items() if k.startswith(fault.keeps)} for one in (before, after)
    )
    return first.keys() == second.keys() and all(abs(second[k] - first[k]) <= KEPT * abs(first[k]) for k in first)


def changed(case: Case, before: Outcome, after: Outcome) -> tuple[float, float]:
    """Return the largest shift of a figure in clean standard uncertainties, and the largest ratio of uncertainties."""
    test = {"rate_table": "rates"}.get(case.procedure, "")
    first, second = estimates(before, test), estimates(after, test)
    both = [(first[key], second[key]) for key in case.truth if key in first and key in second]
    pairs = [(a, b) for a, b in both if a["status"] == b["status"] == "estimated" and a["u"] and b["u"]]
    if not pairs:
        return float("nan"), float("nan")
    return max(abs(b["value"] - a["value"]) / a["u"] for a, b in pairs), max(b["u"] / a["u"] for a, b in pairs)
