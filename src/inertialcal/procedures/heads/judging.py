"""Requirements on several heads of one test: each head is judged."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...core.errors import DataError
from ...core.judging import Asked, Verdict
from ...core.results import Row
from ...statistics.decision import decide
from ..protocol import Tested

if TYPE_CHECKING:
    from .plan import Plan
    from .readings import Readings
    from .reduction import Result


def judge(asked: Asked, tests: Sequence[Tested[Plan, Readings, Result]]) -> list[Verdict]:
    """Return a verdict a head and axis."""
    return [
        _verdict(asked, test, row)
        for test in tests
        for row in test.result.rows()
        if row.key.quantity == asked.quantity and asked.axis in (None, row.axis)
    ]


def _verdict(asked: Asked, test: Tested[Plan, Readings, Result], row: Row) -> Verdict:
    result = test.result
    number = result.heads[0].number if row.key.at is None else int(row.key.at.value)
    head = f"head {result.readings.tracks[number - 1].mounted.name}"
    said = (asked.id, test.id, row.axis, None, "", row.value, row.u, row.unit)
    try:
        lower, upper = asked.limits(row.unit)
    except DataError as error:
        return Verdict(*said, row.interval, None, None, "INCONCLUSIVE", error.problems[0].what)
    if row.status != "estimated":
        return Verdict(*said, row.interval, lower, upper, "INCONCLUSIVE", f"{head}: {row.reason.text}")
    dof = math.inf if row.dof is None else row.dof
    found = decide(row.value, row.u, dof, lower, upper, rule=asked.rule.within(row.unit, lower, upper))
    reason = f"{head}: {found.reason}" if found.reason else head
    return Verdict(*said, found.interval, lower, upper, found.status, reason, basis=found.basis)
