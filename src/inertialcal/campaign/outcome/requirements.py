"""Requirements: which result each one asks about, and what the decision rule says.

By default PASS if the 95 % interval lies inside the limits, FAIL if wholly outside, else INCONCLUSIVE (JCGM 106); or by
the rule that the campaign names (``statistics.guard_band``). A procedure may judge its own figures, such as those over
a range, where a band has to hold for all places together; every other figure is judged here. A requirement that no test
speaks to is OPEN and counts as INCONCLUSIVE.

References
----------
.. [1] JCGM 106:2012, Evaluation of measurement data - The role of measurement uncertainty in conformity
   assessment, clauses 7 and 8.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...core.errors import DataError
from ...core.judging import LEVEL, Asked, Rule, Verdict
from ...core.key import Method
from ...core.results import Interval, Row, changed, finite
from ...core.units import parse_quantity
from ...procedures import all_quantities, procedure_of
from ...procedures.protocol import Quantity
from ...procedures.recorded import COUNTED
from ...procedures.recorded import QUANTITIES as RECORDED
from ...statistics.decision import Verdict as Decision
from ...statistics.decision import decide, decide_by, no_change
from ...statistics.guard_band import INTERVAL
from ..compare.allowed_change import Allowed, allowed_for
from ..compare.differences import ratio_interval_of
from ..engine.engine import Change, ReducedTest
from ..file.schema import Requirement
from .compensated import Compensation, compensated_verdicts

TOGETHER = "over several rates the 95 % hold for all together"
OPEN = "OPEN"
BELOW = "not found; its 95 % upper limit lies inside the limit"
ONLY = "not found; it has a 95 % upper limit alone, the rule asks for more"


def rule_text(rule: Rule) -> str:
    """Return a rule in words, with what its interval, or U, means."""
    if rule.name in ("guard_factor", "test_uncertainty_ratio"):
        return f"{rule}; U is half of the 95 % interval, {TOGETHER}"
    return f"{rule}; {TOGETHER}" if rule.name == "interval" else str(rule)


def judge(
    requirement: Requirement,
    tested: Sequence[ReducedTest],
    general: Rule = INTERVAL,
    compensation: Compensation | None = None,
) -> tuple[list[Verdict], list[Row]]:
    """Return the verdicts of a requirement, and rows that follow from it (the resolution).

    They are INCONCLUSIVE for a test that has a remark that is an error.

    Parameters
    ----------
    requirement : Requirement
        As the campaign states it.
    tested : sequence of ReducedTest
        All tests that were run; those that the requirement is about are chosen here.
    general : Rule
        Decision rule of the campaign, for a requirement that names none.
    compensation : Compensation, optional
        Models that are delivered, for a requirement on compensated readings.
    """
    rule = general if requirement.decision is None else requirement.decision.made()
    asked = Asked(
        requirement.id, requirement.quantity, requirement.axis, requirement.of, requirement.limit, requirement.lower,
        requirement.upper, requirement.where, rule,
    )  # fmt: skip
    about = [one for one in tested if _is_about(requirement, one)]
    if requirement.readings == "compensated":
        left = list(compensated_verdicts(asked, about, compensation or Compensation()))
        left = left or [replace(_open(asked), readings="compensated")]
        return _worded(left, rule), []
    if asked.quantity in RECORDED:
        recorded, given = _recorded(asked, about)
        return _worded(recorded or [_open(asked)], rule), given
    if asked.of == "change":
        return _worded(_in_doubt(list(_changes(asked, about)), about) or [_open(asked)], rule), []
    verdicts: list[Verdict] = []
    rows: list[Row] = []
    others: set[str] = set()
    for name in dict.fromkeys(one.test.procedure for one in about):
        found = procedure_of(name).judge(asked, [one.tested for one in about if one.test.procedure == name])
        if found is None:
            others.add(name)
        else:
            verdicts, rows = verdicts + found[0], rows + found[1]
    if not asked.where:
        verdicts += _figures(asked, [one for one in about if one.test.procedure in others])
    return _worded(_in_doubt(verdicts, about) or [_open(asked)], rule), rows


def _worded(verdicts: Sequence[Verdict], rule: Rule) -> list[Verdict]:
    """Return verdicts with their rule in words."""
    words = rule_text(rule)
    return [changed(one, basis=changed(one.basis, rule=words)) for one in verdicts]


def _in_doubt(verdicts: Sequence[Verdict], about: Sequence[ReducedTest]) -> list[Verdict]:
    """Return verdicts, INCONCLUSIVE where a test has a remark that is an error."""
    errors = {one.test.id: one.errors[0].what for one in about if one.errors}
    return [
        replace(one, verdict="INCONCLUSIVE", reason=f"in doubt: {errors[one.test]}",
                basis=replace(one.basis, in_doubt=True, risk=None))
        if one.test in errors else one
        for one in verdicts
    ]  # fmt: skip


def worst(verdicts: Sequence[Verdict]) -> str:
    """Return FAIL before INCONCLUSIVE before PASS; OPEN counts as INCONCLUSIVE."""
    found = {one.verdict for one in verdicts}
    if "FAIL" in found:
        return "FAIL"
    return "PASS" if found == {"PASS"} else "INCONCLUSIVE"


def _is_about(requirement: Requirement, one: ReducedTest) -> bool:
    if requirement.tests is not None and one.test.id not in requirement.tests:
        return False
    return requirement.condition is None or one.test.condition == requirement.condition


def _open(asked: Asked) -> Verdict:
    unit = all_quantities().get(asked.quantity, Quantity()).unit
    limits = asked.limits(unit) if unit and asked.of != "change" else (None, None)
    return Verdict(asked.id, "", asked.axis or "", None, "", None, None, "", None, *limits, OPEN,
                   "no test speaks to it")  # fmt: skip


def _figures(asked: Asked, about: Sequence[ReducedTest]) -> Iterator[Verdict]:
    for one in about:
        rows = [row for row in one.plain_rows.get(asked.quantity, ()) if asked.axis in (None, row.axis)]
        comparable = [row for row in rows if asked.comparable(row.unit)] if len(one.parts) > 1 else []
        yield from (_figure(asked, one, row) for row in comparable or rows)


def _changes(asked: Asked, about: Sequence[ReducedTest]) -> Iterator[Verdict]:
    """Yield a verdict on each change since another test: PASS only inside what is allowed, of a ratio about 1."""
    stated = () if asked.limit is None else (Allowed(asked.quantity, parse_quantity(asked.limit)),)
    for one in about:
        for change in one.changes:
            row = change.row
            if row.quantity != asked.quantity or asked.axis not in (None, row.axis):
                continue
            ratio = row.method is Method.RATIO
            head = (asked.id, one.test.id, row.axis, None, "change", row.value, row.u, row.unit)
            try:
                limit = allowed_for(change.first, stated)
            except DataError as error:
                what = error.problems[0].what
                yield Verdict(*head, row.interval, None, None, "INCONCLUSIVE", what, sensor=row.key.sensor)
                continue
            found = no_change(None, None, None, None, rule=asked.rule) if limit is None else None
            part = None if limit is None or not ratio else limit / abs(change.first.value or math.nan)
            lower, upper = (None, None) if limit is None else (-limit, limit) if part is None else (1 - part, 1 + part)
            if row.status != "estimated":
                reason = row.reason.text
                yield Verdict(*head, row.interval, lower, upper, "INCONCLUSIVE", reason, sensor=row.key.sensor)
                continue
            if found is None and ratio:
                found = decide_by(_ratio_interval(change), row.value, row.u, lower, upper, rule=asked.rule)
            elif found is None:
                within = asked.rule.within(row.unit, lower, upper)
                found = no_change(row.value, row.u, row.dof, limit, rule=within)
            doubt = one.procedure.doubt(one.result, row.axis)
            yield Verdict(
                *head, found.interval or row.interval, lower, upper, *_doubted(found.status, found.reason, doubt),
                sensor=row.key.sensor,
                basis=replace(found.basis, in_doubt=True, risk=None) if doubt else found.basis,
            )  # fmt: skip


def _ratio_interval(change: Change) -> Callable[[float], Interval | None]:
    """Return the interval of a ratio by its probability."""

    def at(p: float) -> Interval | None:
        own = change.row.interval
        return own if own is not None and own.p == p else ratio_interval_of(change.first, change.second, p)

    return at


def _decided(one: ReducedTest, row: Row, size: bool, lower: float | None, upper: float | None, rule: Rule) -> Decision:
    """Compare a size, as of a term of noise, by its own interval: that is no t-interval about the value."""
    if size:

        def interval_at(p: float) -> Interval | None:
            return one.procedure.interval_at(one.result, row, p)

        return decide_by(interval_at, row.value, row.u, lower, upper, rule=rule)
    value, u = (np.nan if number is None else number for number in (row.value, row.u))
    dof = np.inf if row.dof is None else row.dof
    return decide(value, u, dof, lower, upper, rule=rule.within(row.unit, lower, upper))


def _figure(asked: Asked, one: ReducedTest, row: Row) -> Verdict:
    head = (asked.id, one.test.id, row.axis, None, "", row.value, row.u, row.unit)
    size = one.procedure.quantities().get(row.quantity, Quantity()).size
    try:
        lower, upper = asked.limits(row.unit, size)
    except DataError as error:
        return Verdict(*head, row.interval, None, None, "INCONCLUSIVE", error.problems[0].what, sensor=row.key.sensor)
    doubt = one.procedure.doubt(one.result, row.axis)
    below = row.status == "upper_limit" and row.value is not None and upper is not None and row.value <= upper
    if below and (lower is None or lower <= 0.0) and not _enough(asked.rule):
        return Verdict(*head, row.interval, lower, upper, "INCONCLUSIVE", ONLY, sensor=row.key.sensor)
    if below and (lower is None or lower <= 0.0):
        return Verdict(
            *head,
            row.interval,
            lower,
            upper,
            *_doubted("PASS", BELOW if size else row.reason.text, doubt),
            sensor=row.key.sensor,
        )
    if row.status != "estimated":
        return Verdict(*head, row.interval, lower, upper, "INCONCLUSIVE", row.reason.text, sensor=row.key.sensor)
    found = _decided(one, row, size, lower, upper, asked.rule)
    return Verdict(
        *head, found.interval, lower, upper, *_doubted(found.status, found.reason, doubt), sensor=row.key.sensor,
        basis=replace(found.basis, in_doubt=True, risk=None) if doubt else found.basis,
    )  # fmt: skip


def _recorded(asked: Asked, about: Sequence[ReducedTest]) -> tuple[list[Verdict], list[Row]]:
    """Return a verdict a test and axis, by its recording that does worst, and the rows of all recordings."""
    verdicts: list[Verdict] = []
    rows = [row for one in about for row in one.recorded if row.quantity == asked.quantity]
    rows = [row for row in rows if asked.axis in (None, row.axis)]
    for test, axis in dict.fromkeys((row.test, row.axis) for row in rows):
        mine = [row for row in rows if (row.test, row.axis) == (test, axis)]
        verdicts.append(min((_of_recording(asked, row) for row in mine), key=_how_bad))
    return verdicts, rows


def _of_recording(asked: Asked, row: Row) -> Verdict:
    """Judge a figure of a recording: a count as it is, others by their interval."""
    head = (asked.id, row.test, row.axis, None, "", row.value, row.u, row.unit)
    lower, upper = asked.limits(row.unit, all_quantities()[row.quantity].size)
    place = f"recording {row.member.label}" if row.member is not None else ""
    if row.status != "estimated" or row.value is None:
        reason = f"{place}: {row.reason.text}"
        return Verdict(*head, row.interval, lower, upper, "INCONCLUSIVE", reason)
    if row.quantity in COUNTED:
        inside = (lower is None or row.value >= lower) and (upper is None or row.value <= upper)
        exact = Interval(row.value, row.value)
        return Verdict(*head, exact, lower, upper, "PASS" if inside else "FAIL", f"{place}: {row.reason.text}, counted")
    dof = np.inf if row.dof is None else row.dof
    found = decide(row.value, row.u, dof, lower, upper, rule=asked.rule.within(row.unit, lower, upper))
    reason = "; ".join(text for text in (place, found.reason, row.reason.text) if text)
    return Verdict(*head, found.interval, lower, upper, found.status, reason, basis=found.basis)


def _how_bad(one: Verdict) -> tuple[int, float]:
    """Return what sorts the worst verdict first: FAIL, INCONCLUSIVE, PASS, each by its margin."""
    left = margin(one.interval, one.lower, one.upper)
    return ("FAIL", "INCONCLUSIVE", "PASS").index(one.verdict), -math.inf if left is None else left


def _enough(rule: Rule) -> bool:
    """Return whether a 95 % upper limit inside the limits is enough to PASS."""
    if rule.name == "false_accept_risk":
        return rule.risk >= round(1.0 - LEVEL, 12) and rule.process is None
    return rule.name != "guard_factor" or rule.factor <= 1.0


def _doubted(status: str, reason: str, doubt: str) -> tuple[str, str]:
    """Return verdict and reason: no PASS by a figure that may not hold."""
    if not doubt:
        return status, reason
    said = f"in doubt: {doubt}"
    return ("INCONCLUSIVE", said) if status == "PASS" else (status, f"{reason}; {said}" if reason else said)


def margin(interval: Interval | None, lower: float | None, upper: float | None) -> float | None:
    """Return the distance from the nearer end of an interval to the nearer limit, positive inside.

    Wholly inside, it is what is left to the limit; wholly outside, what the nearest end is beyond it, negative;
    across a limit, what the farthest end is beyond it, negative too.

    Parameters
    ----------
    interval : Interval or None
        An open end is at infinity.
    lower, upper : float or None
        Limits, in the unit of the interval.

    Returns
    -------
    float or None
        In that unit; None where there is no interval or no limit, or only an open end stands against a limit.

    Examples
    --------
    >>> margin(Interval(1.0, 2.0), None, 5.0), margin(Interval(6.0, 8.0), None, 5.0)
    (3.0, -1.0)
    >>> margin(Interval(4.0, 7.0), 0.0, 5.0)
    -2.0
    """
    if interval is None:
        return None
    lo, hi = (-math.inf if interval.lo is None else interval.lo), (math.inf if interval.hi is None else interval.hi)
    below, above = (-math.inf if lower is None else lower), (math.inf if upper is None else upper)
    if lo > above:
        return finite(above - lo)
    if hi < below:
        return finite(hi - below)
    to_lower = math.inf if lower is None else lo - lower
    to_upper = math.inf if upper is None else upper - hi
    return finite(min(to_lower, to_upper))
