"""Rows as ``results.json`` holds them, for tests of tables and sentences; files with the checksum of their content."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from inertialcal.core.schema.checksum import CHECKSUM, checksum

METHODS = ("all_readings", "median", "low_pass", "as_published", "within_runs", "between_runs")


def fields(case: str = "", reason: str = "") -> dict[str, Any]:
    """Return the fields of a row that tests write short: ``"flip 1"``, ``"run a alone"``, ``"-20 degC"``, a method."""
    found: dict[str, Any] = {
        "sensor": "", "power": 0, "at": None, "condition": "", "method": "result", "member": None, "shared": {},
        "curvature": {},
        "reason": {"code": "", "text": reason} if reason else None,
    }  # fmt: skip
    method, _, part = case.partition(", ") if case.startswith(METHODS) else ("result", "", case)
    found["method"] = method
    if part.startswith("flip "):
        found["member"] = {"kind": "flip", "label": part.removeprefix("flip ")}
    elif part.endswith(" alone"):
        found["member"] = {"kind": "run", "label": part.removeprefix("run ").removesuffix(" alone")}
    elif part.endswith((" degC", " Hz")):
        value, unit = part.removeprefix("line at ").split()
        what = "line" if unit == "Hz" else "temperature"
        found["at"] = {"what": what, "value": float(value), "unit": unit}
    else:
        found["condition"] = part
    return found


def results_text(**members: Any) -> str:
    """Return a ``results.json`` with some members, the others without anything."""
    objects = ("campaign", "item", "site", "sensors", "influences", "occasions")
    lists = ("standards", "sequence", "exclusions", "results", "covariances", "budgets", "remarks", "verdicts")
    blank: dict[str, Any] = {name: {} for name in objects} | {name: [] for name in (*lists, "verification")}
    loop = {"verdict": "not run", "reason": "", "axes": [], "over_temperature": []}
    rest = {"schema": 2, "decision_rule": "", "closed_loop": loop, "verdict": None, "curves_sha256": ""}
    return sealed_text(blank | rest | members)


def sealed_text(content: Mapping[str, Any]) -> str:
    """Return a JSON file of a content, changed or made by a test, with the checksum that fits."""
    own = {name: part for name, part in content.items() if name != CHECKSUM}
    return json.dumps(own | {CHECKSUM: checksum(own)})
