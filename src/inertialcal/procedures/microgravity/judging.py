"""Verdicts on the curve: all bands of a test together, by intervals that hold for all of them.

PASS where the interval of the highest ratio lies below the limit, FAIL where it lies wholly above, else INCONCLUSIVE.
Blocks that are shorter than the curve is stated for carry no verdict: INCONCLUSIVE.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...core.judging import Asked, Verdict
from ...core.show.rounding import number
from ...statistics.decision import decide_by
from ..protocol import Tested
from .plan import RATIO, RSS, Plan
from .readings import Readings
from .reduction import Result
from .rows import ratio_interval


def judge_curve(asked: Asked, tests: Sequence[Tested[Plan, Readings, Result]]) -> list[Verdict]:
    """Return a verdict a test."""
    return [_judged(asked, one) for one in tests if asked.axis in (None, RSS)]


def _judged(asked: Asked, test: Tested[Plan, Readings, Result]) -> Verdict:
    result = test.result
    lower, upper = asked.limits("1", size=True)
    nothing = Verdict(asked.id, test.id, RSS, None, "", None, None, "1", None, lower, upper, "INCONCLUSIVE")
    row = next((row for row in result.rows() if row.key.quantity == RATIO), None)
    if row is None or row.value is None:
        return replace(nothing, reason="no curve was given" if row is None else str(row.reason))
    found = decide_by(lambda p: ratio_interval(result, p), row.value, row.u, lower, upper, rule=asked.rule)
    judged = replace(nothing, value=row.value, u=row.u, interval=found.interval)
    if result.shortened:
        length = number(result.cut.block * result.cut.interval, 3)
        why = f"levels are over {length} s, the curve is for {number(test.plan.block)} s"
        return replace(judged, reason=why)
    return replace(judged, verdict=found.status, reason=found.reason, basis=found.basis)
