"""Sense of rotation, mounting and size: whether the unit reads what the table does.

A calibration corrects per cents. A slope near -1, an axis that answers for another, or a rate that is off by more
than ``plan.agreement`` is a mistake in the set-up or in the campaign file, and no model may be made of it.
"""

from __future__ import annotations

import numpy as np

from ....core.errors import DataError, Problem
from ..plan import Plan
from ..readings import Readings
from .regression import Line

CLEAR = 0.5  # a matrix entry of this size is no misalignment


def check_agreement(plan: Plan, readings: Readings, lines: dict[str, Line]) -> None:
    """Refuse readings that do not follow the table.

    Raises
    ------
    DataError
        With one problem for each axis: inverted sense (``inverted``), another axis answers (``axes_mixed``), or
        the rates disagree (``rate_disagrees``).
    """
    problems = []
    for axis in np.unique(readings.axis):
        entries = {s: one.coefficient(f"M_{s}{axis}") for s, one in lines.items() if axis in one.axes}
        problem = _problem(plan, str(axis), entries, _doubt(lines, str(axis)))
        if problem is not None:
            problems.append(problem)
    if problems:
        raise DataError(problems)


def _doubt(lines: dict[str, Line], axis: str) -> float:
    """Return two standard errors of the sensor's own entry: low rates alone tell little of it."""
    one = lines.get(axis)
    if one is None or one.covariance is None or axis not in one.axes:
        return 0.0
    at = one.names.index(f"M_{axis}{axis}")
    return 2.0 * float(np.sqrt(one.covariance[at, at]))


def _problem(plan: Plan, axis: str, entries: dict[str, float], doubt: float) -> Problem | None:
    own = entries.get(axis)
    if own is None or abs(own - 1.0) <= plan.agreement + doubt:
        return None
    others = [s for s, entry in entries.items() if s != axis and abs(abs(entry) - 1.0) <= plan.agreement]
    if abs(own) < CLEAR and others:
        seen = f"{entries[others[0]]:+.3f} of the rate; {axis}: {own:+.3f}"
        what = f"{axis} is turned, but the {others[0]} sensor reads it ({seen})"
        return Problem(
            what, "", "axes are mixed up", "Check the axes turned, the columns and the mounting", "axes_mixed"
        )
    if abs(own + 1.0) <= plan.agreement:
        what = f"{axis} sensor: reads {own:+.3f} of the rate: the sense is inverted"
        return Problem(
            what, "", "a model would turn the wrong way", "Check the sign of the rates and the mounting", "inverted"
        )
    what = (
        f"{axis} sensor: reads {own:+.4g} of the rate of the table, more than {plan.agreement:.0%} from what it should"
    )
    return Problem(what, "", "this is no calibration error", "Check units, scale factor and columns", "rate_disagrees")
