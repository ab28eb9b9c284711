"""The three numbers that matter, each picked by a rule that the page states beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..core.results import case_of
from ..core.show.names import quantity_name
from ..core.show.sentence import estimated, largest
from ..core.units import factor
from .findings import Figure, Finding, of_row, worst_axis
from .numbers import Branch, clean

ERRORS = ("scale_factor_error", "misalignment")
FALLBACKS = ("bias", "residual_bias", "ambient_acceleration", "scale_factor", "scatter_run", "scatter_dwell",
             "angle_random_walk", "velocity_random_walk", "bias_instability")  # fmt: skip


@dataclass(frozen=True)
class Highlight:
    """One of the three.

    Parameters
    ----------
    label : Finding
        What it is.
    figure : Finding
        The number, with uncertainty and unit.
    rule : str
        How it was picked.
    """

    label: Finding
    figure: Finding
    rule: str


def highlights(results: Branch) -> list[Highlight]:
    """Return up to three highlights, from what the campaign has.

    Parameters
    ----------
    results : Branch
        Content of results.json.
    """
    rows = [row for row in results["results"] if not case_of(row).beside]
    tests = {str(step["test"]) for step in results["sequence"]}
    delivered = [row for row in rows if str(row["test"]) not in tests] or rows  # of the models
    found = [_closed_loop(results["closed_loop"]), _largest_error(delivered), _least_margin(results["verdicts"])]
    chosen = [one for one in found if one is not None]
    others = () if chosen else dict.fromkeys(str(row["quantity"]) for row in delivered)  # of whatever was tested
    for quantity in dict.fromkeys([*FALLBACKS, *others]):
        every = estimated(delivered, quantity, any_case=True)
        row = largest(every)
        if len(chosen) < 3 and row is not None:
            several = len({str(one["test"]) for one in every}) > 1
            of = f" and tests (here: {clean(str(row['test']))})" if several else ""
            chosen.append(_of_row(row, f"largest {quantity.replace('_', ' ')} of all axes{of}"))
    return chosen


def _closed_loop(loop: Branch) -> Highlight | None:
    axis = worst_axis(loop)
    if axis is None:
        return None
    figure = (Figure(axis["raw_rms"]), " → ", Figure(axis["compensated_rms"], None, axis["unit"]))
    label = ("rms error of ", axis["axis"], ", raw → compensated")
    several = len({str(one["unit"]) for one in loop["axes"]}) > 1
    return Highlight(label, figure, f"hold-out readings, worst axis{' relative to raw' if several else ''}")


def _largest_error(rows: Sequence[Branch]) -> Highlight | None:
    """Return the largest relative error or angle: 1 % counts as much as 0.01 rad."""
    known = [row for quantity in ERRORS for row in estimated(rows, quantity, any_case=True)]
    row = max(known, key=_relative, default=None)
    return None if row is None else _of_row(row, "largest of all scale factor errors and misalignments")


def _relative(row: Branch) -> float:
    unit = str(row["unit"])
    return abs(float(row["value"].raw)) * (1.0 if unit == "rad" else factor(unit, "1"))


def _least_margin(verdicts: Sequence[Branch]) -> Highlight | None:
    """Return the verdict with the smallest margin relative to its limits; negative = outside."""
    known = [one for one in verdicts if one["margin"] is not None]
    one = min(known, key=_margin, default=None)
    if one is None:
        return None
    at: Finding = () if one["at"] is None else (" at ", Figure(one["at"], None, one["at_unit"]))
    label = ("margin of ", one["requirement"], ", ", one["test"], " ", one["axis"], *at, ": ", one["verdict"],
             *_limits(one))  # fmt: skip
    rule = "smallest margin to a limit; negative = outside"
    return Highlight(label, (Figure(one["margin"], None, one["unit"]),), rule)


def _limits(one: Branch) -> Finding:
    """Return the limits that the margin is to."""
    lower, upper, unit = one["lower"], one["upper"], one["unit"]
    if lower is not None and upper is not None:
        return ("; limits ", Figure(lower), " to ", Figure(upper, None, unit))
    end = upper if lower is None else lower
    return () if end is None else ("; limit ", Figure(end, None, unit))


def _margin(one: Branch) -> float:
    limits = [abs(float(end.raw)) for end in (one["lower"], one["upper"]) if end is not None and end.raw]
    return float(one["margin"].raw) / (min(limits) if limits else 1.0)


def _of_row(row: Branch, rule: str) -> Highlight:
    return Highlight((quantity_name(row).replace("_", " "), " ", row["axis"]), (of_row(row),), rule)
