"""Errors of standards that many figures share: each is taken off the figures, and counts once.

A campaign draws the error of a standard once, and all figures that it enters miss together: 15 scale factors of one
table are one error, not 15. The truth holds that error, rows say what one standard uncertainty of it changes
(``shared``): what is left of a figure is judged with what is left of its uncertainty.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ...rigs.twin import DrawnError
from ...statistics.difference import Figure, taken_off
from ...statistics.intervals import coverage_factor

NOTHING = 1e-6  # of an uncertainty: figures that the standards alone make uncertain


def apart(row: Mapping[str, Any], truth: float, errors: Mapping[str, DrawnError]) -> bool | None:
    """Whether the interval of a figure holds the truth once the errors of its standards are taken off.

    Parameters
    ----------
    row : mapping
        Of ``results.json``, with an interval.
    truth : float
        In its unit.
    errors : mapping of str to DrawnError
        By influence.

    Returns
    -------
    bool or None
        None where nothing but the standards makes the figure uncertain.
    """
    changes = {name: change for name, change in row["shared"].items() if name in errors}
    lo, hi, value, u = row["interval"]["lo"], row["interval"]["hi"], row["value"], row["u"]
    if not changes or not u or lo is None or hi is None:
        return bool((lo is None or lo <= truth) and (hi is None or truth <= hi))
    whole = Figure(value, u, row["dof"] or math.inf, changes)
    left = taken_off(whole, {name: one.error for name, one in errors.items()})
    if left.u <= NOTHING * u:
        return None
    wider = left.u / u * coverage_factor(max(left.dof, 1.0)) / coverage_factor(max(whole.dof, 1.0))
    return bool(left.value - (value - lo) * wider <= truth <= left.value + (hi - value) * wider)


def entering(rows: Iterable[Mapping[str, Any]], errors: Sequence[DrawnError]) -> dict[DrawnError, int]:
    """Return the errors of standards that enter rows, with how many rows each enters."""
    names = [name for row in rows if row["inside"] is not None for name in row["shared"]]
    return {one: names.count(one.influence) for one in errors if one.influence in names}


def standards_text(found: Mapping[DrawnError, int]) -> str:
    """Return a line on the errors of the standards, each counted once."""
    outside = [one for one in found if not one.inside]
    if not outside:
        return f"errors drawn for the standards: each inside its 95 % interval ({len(found)} of {len(found)})"
    drawn = ", ".join(f"{one.influence} drawn at {abs(one.error):.1f} u" for one in outside)
    return f"errors drawn for the standards: {drawn}: outside its 95 % interval ({len(outside)} of {len(found)})"
