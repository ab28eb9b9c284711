"""A requirement on the error of rate: judged at every rate that its condition takes in.

The band holds 95 % for all of these rates together (Sidak): k rates get intervals of 0.95^(1/k) each. So a unit that is
right at all k rates FAILs at any of them with at most 5 %, and a PASS at all means the whole range.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...core.judging import LEVEL, Asked, Verdict
from ...core.key import Key, Member, Method, Reason
from ...core.results import Interval, Row, not_estimated
from ...statistics.decision import decide
from ..protocol import Tested
from .exclusions import Mask
from .fit.rate_error import RateError, Resolution, rate_errors, resolution
from .plan import Plan
from .readings import Readings
from .reduction import Result

RateTableTest = Tested[Plan, Readings, Result]


def judge_rate_errors(asked: Asked, tests: Sequence[RateTableTest]) -> tuple[list[Verdict], list[Row]]:
    """Return the verdicts on the error of rate, and the lowest rate from which the requirement holds."""
    verdicts: list[Verdict] = []
    rows: list[Row] = []
    if asked.of == "change":  # the general rule judges changes
        return verdicts, rows
    for one in tests:
        for sensor, line in one.result.lines.items():
            if asked.axis in (None, sensor) and sensor in line.axes:
                errors = rate_errors(one.result.plan, one.result.readings, line, asked.of)
                inside = [asked.condition.holds({"rate": error.applied}) for error in errors]
                p = LEVEL ** (1.0 / max(sum(inside), 1))
                judged = [_rate_verdict(asked, one.id, error, p) for error in errors]
                verdicts += [verdict for verdict, use in zip(judged, inside, strict=True) if use]
                verdicts += _untested_sense(asked, one.id, sensor, [e.applied for e in errors])
                rows += _resolution_rows(asked, one.id, sensor, errors, judged)
    return [*verdicts, *_unturned(asked, tests, {verdict.axis for verdict in verdicts})], rows


def _unturned(asked: Asked, tests: Sequence[RateTableTest], judged: set[str]) -> list[Verdict]:
    """Return INCONCLUSIVE for each axis of the unit that the requirement is about and no test has turned."""
    sensors = dict.fromkeys(s for one in tests for s in one.result.readings.sensors)
    limits = asked.limits("1")
    return [
        Verdict(asked.id, "", axis, None, asked.of, None, None, "1", None, *limits, "INCONCLUSIVE", reason)
        for axis in sensors
        if axis not in judged and asked.axis in (None, axis)
        for reason in [f"the unit was not turned about {axis}"]
    ]


def _untested_sense(asked: Asked, test: str, sensor: str, rates: list[float]) -> list[Verdict]:
    """Return INCONCLUSIVE for a sense of rotation that the condition takes in and the test does not."""
    found = []
    for sign, word in ((1.0, "positive"), (-1.0, "negative")):
        if any(sign * rate > 0.0 for rate in rates):
            continue
        if any(asked.condition.holds({"rate": -rate}) for rate in rates):
            reason = f"{word} rates were not turned"
            nothing = (None, asked.of, None, None, "1", None)
            limits = asked.limits("1")
            found.append(Verdict(asked.id, test, sensor, *nothing, *limits, "INCONCLUSIVE", reason))
    return found


def _rate_verdict(asked: Asked, test: str, error: RateError, p: float) -> Verdict:
    lower, upper = asked.limits("1")
    found = decide(_nan(error.error), _nan(error.u), error.dof, lower, upper, p, asked.rule)
    return Verdict(
        asked.id, test, error.sensor, error.applied, asked.of, error.error, error.u, "1", found.interval,
        lower, upper, found.status, error.reason or found.reason, basis=found.basis,
    )  # fmt: skip


def _nan(number: float | None) -> float:
    return np.nan if number is None else number


def _resolution_rows(
    asked: Asked,
    test: str,
    sensor: str,
    errors: Sequence[RateError],
    judged: Sequence[Verdict],
) -> Iterator[Row]:
    """Lowest rate from which the requirement holds: by verdict, and as published by every dwell being inside."""
    rates = np.array([error.applied for error in errors])
    known = np.array([error.dwells > 0 for error in errors])
    lower, upper = asked.limits("1")
    size = max(abs(limit) for limit in (lower, upper) if limit is not None)
    ways: dict[Member | None, Mask] = {
        Member("requirement", asked.id): np.array([verdict.verdict == "PASS" for verdict in judged]),
        None: np.array([error.largest <= size for error in errors]),
    }
    for member, holds in ways.items():  # without one: as published
        keep = known if member is not None else np.ones_like(known)
        row = _resolution_row(resolution(rates[keep], holds[keep]), sensor, asked)
        method = Method.RESULT if member is not None else Method.TEXTBOOK
        yield replace(row, member=member, method=method, test=test)


def _resolution_row(found: Resolution, sensor: str, asked: Asked) -> Row:
    text = f"lowest rate tested from which {asked.id} holds ({asked.limit or 'its limits'})"
    key = Key("resolution", sensor)
    if found.value is None:
        return not_estimated(key, "rad/s", Reason("fails", f"{text}: it does not hold at the highest rate"))
    if found.below is None:
        interval = Interval(0.0, found.value)
        reason = Reason("limits", f"{text}: it holds at the lowest rate tested")
        return Row(key, found.value, None, "rad/s", None, interval, "upper_limit", reason)
    interval = Interval(found.below, found.value)
    return Row(key, found.value, found.u, "rad/s", None, interval, reason=Reason("limits", text))
