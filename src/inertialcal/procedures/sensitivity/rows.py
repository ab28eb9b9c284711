"""Rows of a sensitivity result: each term that was asked for as estimated, as an upper limit, as stated, or refused."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from ...core.key import NO_REASON, Key, Reason
from ...core.results import Interval, Row, WrittenRow, not_estimated
from ...core.show.rows import Cited, Quoted, Sentence, estimated, largest, quantity_name
from ...core.show.wording import words
from ...statistics.intervals import t_interval, t_quantile
from .plan import OF_LEVELS, RESIDUALS
from .warm_up import warm_up_rows

if TYPE_CHECKING:
    from .fit import SensorFit
    from .reduction import Result

P, POWER = 0.95, 0.9  # of intervals; chance that a term of the size told would have been seen
NO_TERMS = ("scatter_level", *RESIDUALS, *OF_LEVELS)
ALONE = Reason("few_runs", "one power-up: the scatter between levels alone")


def rows(result: Result) -> list[Row]:
    """Return a row a term, sensor by sensor, SI."""
    found: list[Row] = []
    for axis, fit in result.sensors.items():
        found += _of_sensor(result, fit)
        if fit.own is not None:
            u = math.sqrt(fit.own.mean_square)
            key = Key("scatter_level", axis)
            dof = fit.own.spare
            found.append(Row(key, u, u / math.sqrt(2.0 * dof), result.readings.unit, dof))
    found += () if result.warm_up is None else warm_up_rows(result.warm_up)
    return [*found, *(() if result.levels is None else result.levels.rows())]


def _of_sensor(result: Result, fit: SensorFit) -> Iterator[Row]:
    estimate = result.estimate
    for column in fit.design.columns:
        key = column.key
        if key is not None and key not in fit.design.refused and estimate is not None and key in estimate.keys:
            yield _row(result, key, alone=fit.runs < 2)
    for key, (unit, reason) in fit.design.refused.items():
        yield not_estimated(key, unit, reason)


def _row(result: Result, key: Key, *, alone: bool) -> Row:
    """Return a term as estimated; as a limit where its interval holds zero; as it was stated."""
    estimate = result.estimate
    assert estimate is not None  # noqa: S101 - the key is one of it
    i = estimate.index(key)
    value, u, dof, unit = float(estimate.values[i]), float(estimate.u[i]), float(estimate.dof[i]), estimate.units[i]
    shared = estimate.shared(key)
    freedom = dof if math.isfinite(dof) else None
    if (said := result.by_key.get(key)) is not None:
        reason = Reason("stated", f"Type B as stated, not measured: {said.source}")
        return Row(key, value, u, unit, freedom, t_interval(value, u, dof), reason=reason, shared=shared)
    interval = t_interval(value, u, dof, P)
    assert interval.lo is not None and interval.hi is not None  # noqa: S101, PT018 - two-sided
    if interval.lo > 0.0 or interval.hi < 0.0 or key.quantity == "scale_factor_error":
        return Row(key, value, u, unit, freedom, interval, reason=ALONE if alone else NO_REASON, shared=shared)
    limit = max(-interval.lo, interval.hi)
    least = (t_quantile(dof, 0.5 * (1.0 + P)) + t_quantile(dof, POWER)) * u
    share, left, seen = (f"{one / limit:.2f}" for one in (value, u, least))
    text = (f"not seen: the estimate is {share} ± {left} of the limit; {seen} times the limit would be seen in "
            f"{100.0 * POWER:.0f} % of such tests{'; one power-up' if alone else ''}")  # fmt: skip
    return Row(key, limit, None, unit, freedom, Interval(-limit, limit, P), "upper_limit", Reason("not_seen", text))


def finding(rows: Sequence[WrittenRow]) -> Sentence:
    """Say the terms that were seen, each for the axis where it is largest, and how many were not."""
    terms = [row for row in rows if row["quantity"] not in NO_TERMS]
    said: Sentence = ()
    for quantity in dict.fromkeys(str(row["quantity"]) for row in terms):
        row = largest(estimated(terms, quantity))
        if row is not None:
            name = words(quantity_name(row))
            axis = (" on ", Quoted(row["axis"])) if row["axis"] else ()
            said = (*said, *(("; ",) if said else ()), f"{name if said else name.capitalize()}: ", Cited(row), *axis)
    limits = sum(row["status"] == "upper_limit" for row in terms)
    missing = sum(row["status"] == "not_estimated" for row in terms)
    counts = [f"{limits} not seen, with an upper limit"] if limits else []
    counts += [f"{missing} not estimated"] if missing else []
    return (*(said or ("No sensitivity seen",)), *(f"; {one}" for one in counts))


__all__ = ["finding", "rows"]
