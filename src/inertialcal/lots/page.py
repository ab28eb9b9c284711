"""Report of a lot: one page that stands by itself, with every unit a serial number away.

It has the looks and the policy of ``report.html``: nothing is loaded from anywhere. A second script of ours shows the
unit that is asked for, from the figures in the page; without it the page works but for that.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from ..core.show.rounding import number, settled, uncertainty
from ..core.show.tables import Table as Shown
from ..report import drawings
from ..report.page import COPY, MOST_FIGURES, ZOOM, environment, policy, script
from ..statistics.population.risks import Wrong
from .drawn import content_of_lot
from .study import (
    FigureStudy,
    Judged,
    Study,
    capability_text,
    conforming_text,
    mean_text,
    scatter_text,
    share_text,
)

FIND = "find.js"
MOST_ROWS, MOST_FINDINGS = 500, 40  # of tables of units, of findings
MOST_CELLS = 400_000  # of units that the page holds
LEAST = 0.01  # of an expected number of units that is told
DIGITS = 6  # of a value there
JUDGED = ("requirement", "test", "figure", "PASS", "mean", "scatter of units", "u of one", "unit", "Cpk", "outside")
RISKS = ("requirement", "test", "figure", "PASS", "FAIL", "accepted though outside", "not accepted though inside")
PARAMETERS = ("test", "figure", "units", "mean", "seen", "scatter of units", "u of one", "unit", "along the lot")
GAUGE = (
    "test", "figure", "repeat", "between stations", "gauge", "stated", "unit", "of what is seen", "distinct", "units",
)  # fmt: skip
UNITS = ("serial", "verdict", "why")


def lot_page(found: Study, lot: str, title: str = "") -> str:
    """Return the page.

    Parameters
    ----------
    found : Study
        Of the lot.
    lot, title : str
        Its name, and what it is.
    """
    every = drawings.of_campaign(content_of_lot(found))
    drawn = every[:MOST_FIGURES]
    blocks = {one.key: Markup(one.svg()) + ZOOM for one in drawn}  # noqa: S704 - an XML writer escaped it
    template = environment().get_template("data.html")
    for one in drawn:
        blocks[f"data-{one.key}"] = Markup(template.render(key=one.key, tables=one.data()))  # noqa: S704 - a template did
    findings = list(found.findings())
    more = len(findings) - MOST_FINDINGS
    data, embedded = _data(found)
    judged = [(one, each) for one in found.figures for each in one.limits]
    shown = {
        "lot": lot, "title": title,
        "about": f"{len(set(found.table.serials))} units, {len(found.table)} tests",
        "share": f"{100.0 * found.passed.value:.1f} %" if found.passed.of else "-",
        "passed": f"{share_text(found.passed)} of all units PASS; the 95 % interval is for lots like this one.",
        "findings": findings[:MOST_FINDINGS],
        "more_findings": f"{more} more: see lot.json" if more > 0 else "",
        "drawn": drawn, "blocks": blocks,
        "left": str(len(every) - len(drawn)) if len(every) > len(drawn) else "",
        "tables": {
            "verdicts": [Shown(("verdict", "units"), [(name or "none", str(n)) for name, n in found.verdicts.items()],
                               "units by their overall verdict", (1,))],
            "quarantined": [Shown(("reason", "tests"), [(code, str(n)) for code, n in found.quarantined.items()],
                                  "tests in quarantine, by reason", (1,))] if found.quarantined else [],
            "judged": [Shown(JUDGED, [_judged(*pair) for pair in judged], "figures with limits", (3, 4, 5, 6, 8, 9))]
            if judged else [],
            "risks": [Shown(RISKS, [_risk(*pair) for pair in judged],
                            "decisions, and how many are wrong as far as the figures tell, 95 %", (3, 4, 5, 6))],
            "parameters": [Shown(PARAMETERS, [_parameter(one) for one in found.figures],
                                 "every figure over the lot; scatter with the tests' own taken off, 95 %",
                                 (2, 3, 4, 5, 6, 8))],
            "gauge": _gauge(found),
            "units": [_units(found)],
        },
        "embedded": embedded, "data": data, "find": script(FIND), "policy": policy(COPY, FIND),
        "remarks": [{"severity": one.severity, "what": one.what, "do": one.do, "where": one.where,
                     "count": f" ({one.count} ×)" if one.count > 1 else ""} for one in found.remarks],
    }  # fmt: skip
    return environment().get_template("lot.html").render(shown)


def _judged(one: FigureStudy, each: Judged) -> list[str]:
    return [
        each.limits.requirement, one.figure.test, one.figure.name, share_text(each.yields), mean_text(one.found),
        scatter_text(one.found), uncertainty(one.u), one.figure.unit, capability_text(each.capability),
        conforming_text(each.capability),
    ]  # fmt: skip


def _risk(one: FigureStudy, each: Judged) -> list[str]:
    sides = () if each.risks is None else (each.risks.consumer, each.risks.producer)
    wrong = [_wrong(one) for one in sides] or ["-", "-"]
    return [each.limits.requirement, one.figure.test, one.figure.name, str(each.yields.count), str(each.failed), *wrong]


def _wrong(one: Wrong) -> str:
    low, high = (number(end or 0.0, 4) for end in (one.interval.lo, one.interval.hi))
    expected = number(one.expected, 2) if one.expected >= LEAST else f"below {LEAST:g}" if one.expected else "0"
    return f"{expected} ({low} to {high})"


def _parameter(one: FigureStudy) -> list[str]:
    found, way = one.found, one.along
    word = "-" if way is None else "wanders" if way.wanders else "drifts" if way.drifts else "no drift"
    seen = "-" if found is None else number(found.observed, 3)
    return [one.figure.test, one.figure.name, str(one.n), mean_text(found), seen, scatter_text(found),
            uncertainty(one.u), one.figure.unit, word]  # fmt: skip


def _gauge(found: Study) -> list[Shown]:
    rows = []
    for one in found.figures:
        tested = one.gauge
        if tested is None:
            continue
        between = "-" if tested.reproducibility is None else number(tested.reproducibility.value, 3)
        parts = tested.part if one.found is None else one.found.scatter
        rows.append([
            one.figure.test, one.figure.name,
            f"{number(tested.repeatability.value, 3)} ({number(tested.repeatability.interval.lo or 0.0, 2)} to "
            f"{number(tested.repeatability.interval.hi or 0.0, 2)})",
            between, number(tested.gauge.value, 3), number(tested.stated, 3), one.figure.unit,
            f"{100.0 * tested.share_of(parts):.0f} %", str(tested.distinct), str(tested.units),
        ])  # fmt: skip
    caption = "repeated tests, standard deviations; stated: what the tests say of their own scatter"
    return [Shown(GAUGE, rows, caption, (2, 3, 4, 5, 7, 8, 9))] if rows else []


def _units(found: Study) -> Shown:
    """Return the units that need a look: in quarantine, not passed, with errors, of another kind."""
    table, odd = found.table, {one.serial for one in found.odd}
    wrong: dict[int, list[str]] = {}
    for one in table.wrong:
        wrong.setdefault(one.row, []).append(f"{one.test} {one.code.replace('_', ' ')}".strip())
    rows = []
    for row, (serial, state, verdict) in enumerate(zip(table.serials, table.statuses, table.verdicts, strict=True)):
        why = [table.reasons[row].replace("_", " ")] if state != "done" else []
        why += wrong.get(row, [])
        why += ["of another kind"] * (serial in odd)
        why += [
            f"{each.requirement} {one.figure.name} {settled(table.told[row, k], table.u[row, k])} {one.figure.unit}"
            for one in found.figures for each in (judged.limits for judged in one.limits)
            if each.verdicts[row] > 0 and math.isfinite(table.told[row, k := table.figures.index(one.figure)])
        ]  # fmt: skip
        if why:
            rows.append((state != "done", verdict == "FAIL", [serial, verdict if state == "done" else "quarantined",
                                                              "; ".join(why)]))  # fmt: skip
    rows.sort(key=lambda one: (not one[0], not one[1]))
    more = f"; {MOST_ROWS} of {len(rows)}" if len(rows) > MOST_ROWS else ""
    return Shown(UNITS, [row for *_, row in rows[:MOST_ROWS]], f"units that need a look{more}")


def _data(found: Study) -> tuple[Markup, str]:
    """Return the figures of units as JSON that stands in a page, and what is said of those that have no room."""
    table = found.table
    chosen = [
        (k, one) for one in found.figures
        if (k := table.figures.index(one.figure)) in table.limits or one.figure.parameter in table.parameters
    ]  # fmt: skip
    figures = [
        {"name": one.figure.name, "test": one.figure.test, "unit": one.figure.unit,
         "mean": None if one.found is None else one.found.mean,
         "sd": None if one.found is None else one.found.observed, "limits": _limits_text(one)}
        for _, one in chosen
    ]  # fmt: skip
    columns = [k for k, _ in chosen]
    most = MOST_CELLS // max(len(columns), 1)
    flagged = [not ok for ok in (state == "done" and verdict == "PASS"
                                 for state, verdict in zip(table.statuses, table.verdicts, strict=True))]  # fmt: skip
    order = sorted(range(len(table)), key=lambda row: not flagged[row])[:most]
    station = table.levels(found.columns.station) if found.columns.station else None
    units = []
    for row in sorted(order):
        about = table.verdicts[row] or "no verdict" if table.statuses[row] == "done" else \
            f"quarantined: {table.reasons[row].replace('_', ' ')}"  # fmt: skip
        if station is not None:
            about += f", {found.columns.station} {station[1][station[0][row]]}"
        units.append({"serial": table.serials[row], "about": about, "values": _cells(table.told[row, columns]),
                      "u": _cells(table.u[row, columns], 2)})  # fmt: skip
    content = json.dumps({"figures": figures, "units": units}, separators=(",", ":"))
    for sign in "<>&":
        content = content.replace(sign, f"\\u{ord(sign):04x}")
    left = len(table) - len(units)
    said = f"{left} tests that passed have no room in this page: they are in units/*.parquet." if left else ""
    return Markup(content), said  # noqa: S704 - no sign of markup is left in it


def _limits_text(one: FigureStudy) -> str:
    ends = [(each.limits.lower, each.limits.upper) for each in one.limits]
    return "; ".join(
        " .. ".join("-" if end is None else number(end, 6) for end in pair) for pair in dict.fromkeys(ends)
    )


def _cells(values: Any, digits: int = DIGITS) -> Sequence[float | None]:
    return [None if not np.isfinite(one) else float(f"{one:.{digits}g}") for one in values]
