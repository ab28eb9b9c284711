"""Requirements: which result each one asks about, and what the decision rule says.

The rule (JCGM 106, and DESIGN): PASS if the 95 % interval lies inside the limits, FAIL if wholly outside, else
INCONCLUSIVE. A requirement on the bias over a range of temperatures is judged as ``over_temperature`` says.
A requirement on ``rate_error`` is judged at every rate that its condition takes in, with a band that
holds 95 % for all of these rates together (Sidak): k rates get intervals of 0.95^(1/k) each. So a unit that is right
at all k rates FAILs at any of them with at most 5 %, and a PASS at all means the whole range. A requirement that no
test speaks to is OPEN and counts as INCONCLUSIVE.

References
----------
.. [1] JCGM 106:2012, Evaluation of measurement data - The role of measurement uncertainty in conformity
   assessment, clauses 7 and 8.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.errors import DataError
from ..core.key import Key, Member, Method, Reason
from ..core.results import Interval, Row, not_estimated
from ..core.units import parse_quantity
from ..procedures.rate_table import reduction as rate_table
from ..procedures.static_noise import reduction as static_noise
from ..procedures.thermal import reduction as thermal
from ..statistics.decision import Verdict as Decision
from ..statistics.decision import decide, decide_by
from .conditions import Condition, parse_condition
from .over_temperature import judged_over
from .schema import Requirement, Test

LEVEL = 0.95
RULE = (
    "PASS if the 95 % interval lies inside the limits, FAIL if wholly outside, else INCONCLUSIVE;"
    " over several rates the 95 % hold for all together"
)
OPEN = "OPEN"
BELOW = "not found; its 95 % upper limit lies inside the limit"


@dataclass(frozen=True)
class Verdict:
    """A requirement judged at one place.

    Parameters
    ----------
    requirement, test, axis : str
        Which.
    at : float or None
        Rate [rad/s] or temperature [degC] that it is judged at; None where it is about a single figure.
    of : str
        What of it: ``expected``, ``dwell_mean``, ``reading``; empty for a single figure.
    value, u : float or None
        In ``unit``.
    lower, upper : float or None
        Limits in ``unit``.
    verdict : {"PASS", "FAIL", "INCONCLUSIVE", "OPEN"}
        By the rule.
    reason : str
        Why not PASS or FAIL.
    """

    requirement: str
    test: str
    axis: str
    at: float | None
    of: str
    value: float | None
    u: float | None
    unit: str
    interval: Interval | None
    lower: float | None
    upper: float | None
    verdict: str
    reason: str = ""
    at_unit: str = "rad/s"


@dataclass(frozen=True, eq=False)
class Tested:
    """A test that was run: its entry, its result and its rows, SI."""

    test: Test
    result: Any
    rows: Sequence[Row]


def judge(requirement: Requirement, tested: Sequence[Tested]) -> tuple[list[Verdict], list[Row]]:
    """Return the verdicts of a requirement, and rows that follow from it (the resolution).

    Parameters
    ----------
    requirement : Requirement
        As the campaign states it.
    tested : sequence of Tested
        All tests that were run; those that the requirement is about are chosen here.
    """
    about = [one for one in tested if _is_about(requirement, one)]
    if requirement.quantity == "rate_error":
        verdicts, rows = _rate_errors(requirement, about)
    elif requirement.where:
        verdicts, rows = list(_over_temperature(requirement, about)), []
    else:
        verdicts, rows = list(_figures(requirement, about)), []
    return (verdicts or [_open(requirement)]), rows


def worst(verdicts: Sequence[Verdict]) -> str:
    """Return FAIL before INCONCLUSIVE before PASS; OPEN counts as INCONCLUSIVE."""
    found = {one.verdict for one in verdicts}
    if "FAIL" in found:
        return "FAIL"
    return "PASS" if found == {"PASS"} else "INCONCLUSIVE"


def _is_about(requirement: Requirement, one: Tested) -> bool:
    if requirement.tests is not None and one.test.id not in requirement.tests:
        return False
    if requirement.condition is not None and one.test.condition != requirement.condition:
        return False
    plan = getattr(one.result, "plan", None)
    wanted = requirement.zero_reference
    return wanted is None or getattr(plan, "zero_reference", None) == wanted


def _open(requirement: Requirement) -> Verdict:
    limits = _limits(requirement, "1") if requirement.quantity == "rate_error" else (None, None)
    return Verdict(
        requirement.id,
        "",
        requirement.axis or "",
        None,
        "",
        None,
        None,
        "",
        None,
        *limits,
        OPEN,
        "no test speaks to it",
    )


def _limits(requirement: Requirement, unit: str, of_size: bool = False) -> tuple[float | None, float | None]:
    """Return the limits in a unit; a limit on either side is one above for a size, which is never negative."""
    if requirement.limit is not None:
        size = abs(parse_quantity(requirement.limit).to(unit, difference=True))
        return (None if of_size else -size), size
    lower = None if requirement.lower is None else parse_quantity(requirement.lower).to(unit)
    upper = None if requirement.upper is None else parse_quantity(requirement.upper).to(unit)
    return lower, upper


def _rate_errors(requirement: Requirement, about: Sequence[Tested]) -> tuple[list[Verdict], list[Row]]:
    condition = parse_condition(requirement.where)
    verdicts: list[Verdict] = []
    rows: list[Row] = []
    for one in about:
        if not isinstance(one.result, rate_table.Result):
            continue
        for sensor, line in one.result.lines.items():
            if requirement.axis in (None, sensor) and sensor in line.axes:
                errors = rate_table.rate_errors(one.result.plan, one.result.readings, line, requirement.of)
                inside = [condition.holds({"rate": error.applied}) for error in errors]
                p = LEVEL ** (1.0 / max(sum(inside), 1))
                judged = [_rate_verdict(requirement, one.test.id, error, p) for error in errors]
                verdicts += [verdict for verdict, use in zip(judged, inside, strict=True) if use]
                verdicts += _untested_sense(requirement, one.test.id, sensor, [e.applied for e in errors], condition)
                rows += _resolution_rows(requirement, one.test, sensor, errors, judged)
    return [*verdicts, *_unturned(requirement, about, {verdict.axis for verdict in verdicts})], rows


def _unturned(requirement: Requirement, about: Sequence[Tested], judged: set[str]) -> list[Verdict]:
    """Return INCONCLUSIVE for each axis of the unit that the requirement is about and no test has turned."""
    sensors = dict.fromkeys(
        s for one in about if isinstance(one.result, rate_table.Result) for s in one.result.readings.sensors
    )
    limits = _limits(requirement, "1")
    return [
        Verdict(requirement.id, "", axis, None, requirement.of, None, None, "1", None, *limits, "INCONCLUSIVE", reason)
        for axis in sensors
        if axis not in judged and requirement.axis in (None, axis)
        for reason in [f"the unit was not turned about {axis}"]
    ]


def _untested_sense(
    requirement: Requirement, test: str, sensor: str, rates: list[float], condition: Condition
) -> list[Verdict]:
    """Return INCONCLUSIVE for a sense of rotation that the condition takes in and the test does not."""
    found = []
    for sign, word in ((1.0, "positive"), (-1.0, "negative")):
        if any(sign * rate > 0.0 for rate in rates):
            continue
        if any(condition.holds({"rate": -rate}) for rate in rates):
            reason = f"{word} rates were not turned"
            nothing = (None, requirement.of, None, None, "1", None)
            limits = _limits(requirement, "1")
            found.append(Verdict(requirement.id, test, sensor, *nothing, *limits, "INCONCLUSIVE", reason))
    return found


def _rate_verdict(requirement: Requirement, test: str, error: rate_table.RateError, p: float) -> Verdict:
    lower, upper = _limits(requirement, "1")
    found = decide(_nan(error.error), _nan(error.u), error.dof, lower, upper, p)
    return Verdict(
        requirement.id, test, error.sensor, error.applied, requirement.of, error.error, error.u, "1", found.interval,
        lower, upper, found.status, error.reason or found.reason,
    )  # fmt: skip


def _nan(number: float | None) -> float:
    return np.nan if number is None else number


def _resolution_rows(
    requirement: Requirement,
    test: Test,
    sensor: str,
    errors: Sequence[rate_table.RateError],
    judged: Sequence[Verdict],
) -> Iterator[Row]:
    """Lowest rate from which the requirement holds: by verdict, and as published by every dwell being inside."""
    rates = np.array([error.applied for error in errors])
    known = np.array([error.dwells > 0 for error in errors])
    lower, upper = _limits(requirement, "1")
    size = max(abs(limit) for limit in (lower, upper) if limit is not None)
    ways: dict[Member | None, NDArray[np.bool_]] = {
        Member("requirement", requirement.id): np.array([verdict.verdict == "PASS" for verdict in judged]),
        None: np.array([error.largest <= size for error in errors]),
    }
    for member, holds in ways.items():  # without one: as published
        keep = known if member is not None else np.ones_like(known)
        found = rate_table.resolution(rates[keep], holds[keep])
        row = _resolution_row(found, sensor, requirement)
        row = replace(row, member=member, method=Method.RESULT if member is not None else Method.TEXTBOOK)
        yield replace(row, test=test.id)


def _resolution_row(found: rate_table.Resolution, sensor: str, requirement: Requirement) -> Row:
    text = f"lowest rate tested from which {requirement.id} holds ({requirement.limit or 'its limits'})"
    key = Key("resolution", sensor)
    if found.value is None:
        return not_estimated(key, "rad/s", Reason("fails", f"{text}: it does not hold at the highest rate"))
    if found.below is None:
        interval = Interval(0.0, found.value)
        reason = Reason("limits", f"{text}: it holds at the lowest rate tested")
        return Row(key, found.value, None, "rad/s", None, interval, "upper_limit", reason)
    interval = Interval(found.below, found.value)
    return Row(key, found.value, found.u, "rad/s", None, interval, reason=Reason("limits", text))


def _over_temperature(requirement: Requirement, about: Sequence[Tested]) -> Iterator[Verdict]:
    """Yield the verdicts on the bias at temperatures that the condition takes in, with a band that holds for all."""
    condition = parse_condition(requirement.where)
    for one in about:
        if not isinstance(one.result, thermal.Result) or requirement.quantity != "bias":
            continue
        unit = one.result.readings.unit
        try:
            lower, upper = _limits(requirement, unit)
        except DataError:  # a limit of another kind, which the checks of the campaign file name
            continue
        for axis, sensor in one.result.sensors.items():
            if requirement.axis in (None, axis):
                for place in judged_over(one.result.plan, sensor.law, axis, unit, condition, lower, upper):
                    yield Verdict(
                        requirement.id, one.test.id, axis, place.at, "expected", place.value, place.u, unit,
                        place.interval, lower, upper, place.status, place.reason, "degC",
                    )  # fmt: skip


def _figures(requirement: Requirement, about: Sequence[Tested]) -> Iterator[Verdict]:
    for one in about:
        for row in one.rows:
            if row.quantity != requirement.quantity or not row.case.plain or requirement.axis not in (None, row.axis):
                continue
            yield _figure(requirement, one, row)


def _decided(one: Tested, row: Row, lower: float | None, upper: float | None) -> Decision:
    """Compare a figure by its own interval where that is no t-interval about the value, as of a term of noise."""
    if isinstance(one.result, static_noise.Result):
        p = LEVEL if lower is not None and upper is not None else round(2.0 * LEVEL - 1.0, 12)
        return decide_by(one.result.interval_at(row, p), row.value, row.u, lower, upper)
    return decide(_nan(row.value), _nan(row.u), np.inf if row.dof is None else row.dof, lower, upper)


def _figure(requirement: Requirement, one: Tested, row: Row) -> Verdict:
    test = one.test.id
    try:
        lower, upper = _limits(requirement, row.unit, isinstance(one.result, static_noise.Result))
    except DataError as error:
        reason = error.problems[0].what
        return Verdict(requirement.id, test, row.axis, None, "", row.value, row.u, row.unit, row.interval, None, None,
                       "INCONCLUSIVE", reason)  # fmt: skip
    doubt = one.result.doubt(row.axis) if isinstance(one.result, static_noise.Result) else ""
    below = row.status == "upper_limit" and row.value is not None and upper is not None and row.value <= upper
    if below and (lower is None or lower <= 0.0):
        reason = BELOW if isinstance(one.result, static_noise.Result) else row.reason.text
        return Verdict(requirement.id, test, row.axis, None, "", row.value, row.u, row.unit, row.interval, lower, upper,
                       *_doubted("PASS", reason, doubt))  # fmt: skip
    if row.status != "estimated":
        return Verdict(requirement.id, test, row.axis, None, "", row.value, row.u, row.unit, row.interval, lower, upper,
                       "INCONCLUSIVE", row.reason.text)  # fmt: skip
    found = _decided(one, row, lower, upper)
    return Verdict(
        requirement.id, test, row.axis, None, "", row.value, row.u, row.unit, found.interval, lower, upper,
        *_doubted(found.status, found.reason, doubt),
    )  # fmt: skip


def _doubted(status: str, reason: str, doubt: str) -> tuple[str, str]:
    """Return verdict and reason: no PASS by a figure that may not hold."""
    if not doubt:
        return status, reason
    said = f"in doubt: {doubt}"
    return ("INCONCLUSIVE", said) if status == "PASS" else (status, f"{reason}; {said}" if reason else said)
