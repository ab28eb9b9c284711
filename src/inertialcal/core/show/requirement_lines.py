"""Requirements at a glance: one line each, with the worst figure as read and compensated, limit, margin, verdict.

Lines are made of ``results.json``, the words as they are shown; numbers stand beside them for a picture. A line shows
the place that decides its requirement: that of the worst verdict, and of these the one with the smallest margin.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .rounding import number
from .tables import short
from .wording import VERDICTS

COMPENSATED = "compensated"  # of ``readings``: judged after compensation, on readings held out
CLOSED_LOOP = "closed loop"
DIGITS = 3  # of a figure in a line
HEADS = ("requirement", "raw", "compensated", "limit", "margin", "verdict")


@dataclass(frozen=True)
class RequirementLine:
    """A requirement with the figures that decide it; a figure that was not judged is empty text and None."""

    requirement: str  # Its id, or ``closed loop``
    text: str  # As the campaign words it
    raw: str  # Worst figure as read, with its unit
    compensated: str  # Worst figure after compensation, of readings held out
    limit: str  # In words: ``within 0.05 deg/s``
    margin: str  # In words: ``0.031 deg/s to spare``
    verdict: str  # PASS, FAIL, INCONCLUSIVE or OPEN
    place: str = ""  # Of the figure that decides: axis, temperature or rate, test
    raw_verdict: str = ""  # Of the figures as read, by the same rule; empty where they were not judged
    unit: str = ""  # Of all numbers below
    raw_value: float | None = None
    compensated_value: float | None = None
    lower: float | None = None
    upper: float | None = None
    margin_value: float | None = None  # Of the interval to the nearer limit; negative beyond it

    @property
    def cells(self) -> tuple[str, ...]:
        """What stands under ``HEADS``."""
        named = f"{self.requirement}: {self.text}" if self.text else self.requirement
        return named, self.raw, self.compensated, self.limit, self.margin, self.verdict


def requirement_lines(results: Mapping[str, Any]) -> tuple[RequirementLine, ...]:
    """Return a line a requirement of a campaign, and one of its closed loop where one was run.

    Parameters
    ----------
    results : mapping
        Content of ``results.json``.
    """
    return tuple(_lines(results))


def _lines(results: Mapping[str, Any]) -> Iterator[RequirementLine]:
    for row in results["verification"]:
        mine = [one for one in results["verdicts"] if one["requirement"] == row["requirement"]]
        if mine:
            yield _line(row, mine)
        elif row["requirement"] == CLOSED_LOOP:
            loop = results["closed_loop"]
            yield _loop_line(row, [*loop["axes"], *loop["over_temperature"]])
        else:
            yield RequirementLine(row["requirement"], row["text"], "", "", "", "no test", row["verdict"])


def _line(row: Mapping[str, Any], verdicts: Sequence[Mapping[str, Any]]) -> RequirementLine:
    one = min(verdicts, key=_order)
    after = one if one["readings"] == COMPENSATED else None
    raw = one if after is None else _worst_as_read(verdicts)
    of_raw, of_after = (None if each is None else each["value"] for each in (raw, after))
    return RequirementLine(
        row["requirement"],
        row["text"],
        "" if raw is None else _figure(of_raw, one["unit"]),
        "" if after is None else _figure(of_after, one["unit"]),
        _limit(one["lower"], one["upper"], one["unit"]),
        _margin(one),
        row["verdict"],
        _place(one),
        "" if raw is None else raw["verdict"],
        one["unit"],
        of_raw,
        of_after,
        one["lower"],
        one["upper"],
        one["margin"],
    )


def _worst_as_read(verdicts: Sequence[Mapping[str, Any]]) -> Mapping[str, Any] | None:
    """Return the worst of the figures as read that stand beside compensated ones; None where there are none."""
    found = [one["as_read"] for one in verdicts if one["as_read"] is not None]
    return min(found, key=_order, default=None)


def _order(one: Mapping[str, Any]) -> tuple[int, float]:
    """Return what sorts the worst verdict first, of alike ones that with the smallest margin; one without is last."""
    return VERDICTS.index(one["verdict"]), math.inf if one["margin"] is None else one["margin"]


def _figure(value: float | None, unit: str) -> str:
    return "-" if value is None else _with_unit(value, unit)


def _with_unit(value: float, unit: str) -> str:
    return f"{number(value, DIGITS)} {'' if unit == '1' else unit}".rstrip()


def _limit(lower: float | None, upper: float | None, unit: str) -> str:
    if lower is None or upper is None:
        known = upper if lower is None else lower
        word = "at most" if lower is None else "at least"
        return "" if known is None else f"{word} {_with_unit(known, unit)}"
    if lower == -upper:
        return f"within {_with_unit(upper, unit)}"
    return f"{number(lower, DIGITS)} to {_with_unit(upper, unit)}"


def _margin(one: Mapping[str, Any]) -> str:
    """Return the margin in words; why it is not decided, where no margin says so."""
    left = one["margin"]
    if left is None or (left >= 0.0 and one["verdict"] != "PASS"):
        return short(str(one["reason"]))
    size = _with_unit(abs(left), one["unit"])
    if one["verdict"] == "PASS":
        return f"{size} to spare" if left >= 0.0 else short(str(one["reason"]))
    return f"{size} beyond" if one["verdict"] == "FAIL" else f"interval {size} beyond"


def _place(one: Mapping[str, Any]) -> str:
    axis = f"{one['sensor']} {one['axis']}".strip()
    at = "" if one["at"] is None else f"at {number(one['at'], DIGITS)} {one['at_unit']}"
    return ", ".join(part for part in (axis, at, one["test"]) if part)


def _loop_line(row: Mapping[str, Any], loops: Sequence[Mapping[str, Any]]) -> RequirementLine:
    """Return the line of the closed loop: rms errors of the axis that does worst."""
    limit = "smaller than raw"
    if not loops:
        return RequirementLine(row["requirement"], row["text"], "", "", limit, "", row["verdict"])
    kept: Callable[[Mapping[str, Any]], float] = lambda one: (  # noqa: E731
        one["compensated_rms"] / one["raw_rms"] if one["raw_rms"] else math.inf
    )
    one = max(loops, key=lambda each: (-VERDICTS.index(each["verdict"]), kept(each)))
    change = 100.0 * (1.0 - kept(one))
    said = f"{number(abs(change), 2)} % {'smaller' if change >= 0.0 else 'larger'}" if math.isfinite(change) else ""
    shown = "" if one["verdict"] != "INCONCLUSIVE" else "not shown"
    axis = ", ".join(part for part in (one["axis"], one["condition"], one.get("test", "")) if part)
    return RequirementLine(
        row["requirement"],
        row["text"],
        f"rms {_with_unit(one['raw_rms'], one['unit'])}",
        f"rms {_with_unit(one['compensated_rms'], one['unit'])}",
        limit,
        ", ".join(part for part in (said, shown) if part),
        row["verdict"],
        axis,
        "",
        one["unit"],
        one["raw_rms"],
        one["compensated_rms"],
    )
