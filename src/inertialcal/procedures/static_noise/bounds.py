"""Intervals of other probabilities than that of the rows: a requirement with one limit takes a one-sided bound."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...core.errors import DataError
from ...core.results import Interval, Row
from ...sensors.noise.fitting.estimator import fit
from ...sensors.noise.terms import Sinusoid
from .scale import widened

if TYPE_CHECKING:
    from .reduction import Result


def interval_at(result: Result, row: Row, p: float) -> Interval | None:
    """Return the interval of probability ``p`` of an estimated row, by the same profile of the fit.

    Parameters
    ----------
    result : Result
        Of the test.
    row : Row
        One of its estimated rows without a condition.
    p : float
        Probability between both ends.
    """
    if row.interval is not None and row.interval.p == p:
        return row.interval
    one = next((axis for axis in result.axes if axis.axis == row.axis), None)
    if one is None or one.fit is None:
        return None
    names = tuple(dict.fromkeys(term.name for term in one.fit.terms if not isinstance(term, Sinusoid)))
    curves = [record.curve for record in one.records]
    try:
        again = fit(curves, result.plan.kind, terms=names, lines=one.lines, axis=0, unit=result.plan.unit, p=p)
    except DataError:
        return None
    found = next((other for other in again.rows(row.axis) if other.quantity == row.quantity), None)
    return None if found is None else widened(found, result.plan.standards).interval
