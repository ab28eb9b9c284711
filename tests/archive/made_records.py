"""Records of campaigns that nobody ran: contents of results, made by hand."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from typing import Any

from inertialcal.archive.archive import Added, Archive, add_record
from inertialcal.archive.record import Record, content_rows
from inertialcal.core.key import Key
from inertialcal.core.results import Row
from inertialcal.core.schema.checksum import CHECKSUM, checksum
from inertialcal.core.times import instant_text, read_instant
from inertialcal.statistics.intervals import t_interval

YEAR_NS = 31_557_600 * 10**9
START = read_instant("2015-06-01T08:00:00Z")
TABLE = {"standard": "rate_table", "quantity": "rate", "u": 0.03, "unit": "%", "valid": "2015 to 2030",
         "redrawn_by": "certificate"}  # fmt: skip


def figure(
    value: float,
    u: float,
    quantity: str = "scale_factor_error",
    axis: str = "x",
    unit: str = "%",
    dof: float | None = None,
    test: str = "rate",
    shared: Mapping[str, float] | None = None,
) -> dict[str, Any]:
    """A row of results."""
    interval = t_interval(value, u, dof or float("inf"))
    return Row(Key(quantity, axis), value, u, unit, dof, interval, test=test, shared=shared or {}).to_dict()


def content(
    serial: str,
    years: float,
    rows: Sequence[dict[str, Any]],
    certificate: str = "C-1",
    name: str | None = None,
    verdict: str = "PASS",
    lot: str = "",
    influences: Mapping[str, Mapping[str, Any]] | None = None,
) -> dict[str, Any]:
    """Content of a ``results.json``: one test of a unit, so many years after 2015-06-01."""
    start = START + round(years * YEAR_NS)
    tests = list(dict.fromkeys(row["test"] for row in rows))
    step: dict[str, Any] = {
        "procedure": "rate_table", "use": "fit", "condition": "", "sensors": ["suite"], "terms": {}, "source": "",
        "against": None, "after": [], "groups": None, "windows": None, "recordings": [], "dwells": None, "runs": None,
        "left_out": 0, "time": [instant_text(start), instant_text(start + 3_600 * 10**9)],
    }  # fmt: skip
    item = {"maker": "Maker", "part": "G1", "serial": serial} | ({"lot": lot} if lot else {})
    stated = {"rate_table.rate": TABLE | {"certificate": certificate}} if influences is None else influences
    occasion = {"mounting": "", "power_up": "", "day": "", "site": ""}
    results = {
        "schema": 2, "campaign": {"id": name or f"{serial}-{years:g}", "title": "Yearly", "source": ""},
        "item": item, "site": {"latitude": None, "height": None, "gravity": None}, "sensors": {}, "standards": [],
        "influences": {key: dict(one) for key, one in stated.items()},
        "occasions": {test: occasion | {"tests": [test]} for test in tests},
        "sequence": [{"test": test} | step for test in tests], "exclusions": [], "results": list(rows),
        "covariances": [], "budgets": [], "remarks": [], "decision_rule": "", "verdicts": [],
        "closed_loop": {"verdict": "not run", "reason": "", "axes": [], "over_temperature": []}, "verification": [],
        "verdict": verdict, "curves_sha256": "",
    }  # fmt: skip
    return results | {CHECKSUM: checksum(results)}


def record(of: Mapping[str, Any]) -> Record:
    """The record of such a content."""
    data = json.dumps(of, indent=1).encode()
    digest = hashlib.sha256(data).hexdigest()
    item, run, rows = content_rows(of)
    uses = [{"path": "out/results.json", "role": "output", "sha256": digest, "position": 0}]
    run |= {"program": "0.2.0", "folder": "/lab/x", "results_sha256": digest, "made_ns": START}
    return Record(item, run, rows | {"models": [], "uses": uses}, {digest: data}, {digest: len(data)})


def add(archive: Archive, *contents: Mapping[str, Any]) -> list[Added]:
    """Add contents in one transaction."""
    with archive.database.writing() as connection:
        return [add_record(connection, record(one), "made", START) for one in contents]


def yearly(serial: str, values: Sequence[float], u: float = 0.01, **more: Any) -> list[dict[str, Any]]:
    """Contents of one unit, a test a year, with the error of one table in all of them."""
    shared = {"rate_table.rate": 0.03}
    whole = float((u**2 + 0.03**2) ** 0.5)
    return [content(serial, float(i), [figure(value, whole, shared=shared)], **more) for i, value in enumerate(values)]
