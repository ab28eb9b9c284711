"""Requirements on an alignment: each position is judged; a heading as an angle, so that 359 deg is near 1 deg."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...core.errors import DataError
from ...core.judging import Asked, Verdict
from ...core.results import Row
from ...core.units import factor
from ...statistics.decision import decide
from ..protocol import Tested
from .keys import HEADING

if TYPE_CHECKING:
    from .plan import Plan
    from .readings import Readings
    from .reduction import Result


def judge(asked: Asked, tests: Sequence[Tested[Plan, Readings, Result]]) -> list[Verdict]:
    """Return a verdict a position, or axis."""
    return [_verdict(asked, test.id, row) for test in tests for row in test.result.rows()
            if row.key.quantity == asked.quantity and asked.axis in (None, row.axis)]  # fmt: skip


def _verdict(asked: Asked, test: str, row: Row) -> Verdict:
    place = "" if row.key.at is None else f"position {row.key.at.number}"
    said = (asked.id, test, row.axis, None, "", row.value, row.u, row.unit)
    try:
        lower, upper = asked.limits(row.unit)
    except DataError as error:
        return Verdict(*said, row.interval, None, None, "INCONCLUSIVE", error.problems[0].what)
    if row.status != "estimated" or row.value is None or row.u is None:
        why = ": ".join(one for one in (place, row.reason.text) if one)
        return Verdict(*said, row.interval, lower, upper, "INCONCLUSIVE", why)
    value = row.value
    if row.key.quantity == HEADING and lower is not None and upper is not None:
        middle, turn = 0.5 * (lower + upper), 2.0 * math.pi * factor("rad", row.unit)
        value = middle + math.remainder(value - middle, turn)
    dof = math.inf if row.dof is None else row.dof
    found = decide(value, row.u, dof, lower, upper, rule=asked.rule.within(row.unit, lower, upper))
    reason = ": ".join(one for one in (place, found.reason) if one)
    return Verdict(*said, found.interval, lower, upper, found.status, reason, basis=found.basis)
