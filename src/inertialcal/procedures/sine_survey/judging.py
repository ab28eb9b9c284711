"""Requirements on modes: each mode of each response is a place of its own, and all of them must lie inside.

"It did not change" is the interval of the change inside the limits. A change that could not be told, as of a mode that
is gone, is INCONCLUSIVE: nothing shows that the item is as it was.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from ...core.errors import DataError
from ...core.judging import Asked, Verdict
from ...core.results import Row
from ...statistics.decision import decide
from ..protocol import Tested
from .against import CHANGES, change_rows
from .reduction import FREQUENCY, OF_MODE

if TYPE_CHECKING:
    from .plan import Plan
    from .readings import Readings
    from .reduction import Result

JUDGED = (*OF_MODE, *CHANGES.values())


def judge(asked: Asked, tests: Sequence[Tested[Plan, Readings, Result]]) -> list[Verdict]:
    """Return a verdict a mode, of every test that knows the quantity."""
    return [_verdict(asked, test, row) for test in tests for row in _rows(asked, test)]


def _rows(asked: Asked, test: Tested[Plan, Readings, Result]) -> Iterator[Row]:
    rows = list(test.result.rows())
    if test.against is not None:
        rows += change_rows(test.result, test.against.result, test.against.id, (test.occasion, test.against.occasion))
    seen = set()
    for row in rows:
        if row.member is not None:  # of one sweep alone
            continue
        if row.key.quantity == asked.quantity and asked.axis in (None, row.axis) and row.key not in seen:
            seen.add(row.key)
            yield row


def _verdict(asked: Asked, test: Tested[Plan, Readings, Result], row: Row) -> Verdict:
    head = (asked.id, test.id, row.axis, _frequency(test.result, row), "", row.value, row.u, row.unit)
    try:
        lower, upper = asked.limits(row.unit)
    except DataError as error:
        return Verdict(*head, row.interval, None, None, "INCONCLUSIVE", error.problems[0].what, at_unit="Hz")
    if row.status != "estimated":
        return Verdict(*head, row.interval, lower, upper, "INCONCLUSIVE", row.reason.text, at_unit="Hz")
    dof = math.inf if row.dof is None else row.dof
    found = decide(row.value, row.u, dof, lower, upper, rule=asked.rule.within(row.unit, lower, upper))
    return Verdict(*head, found.interval, lower, upper, found.status, found.reason, at_unit="Hz", basis=found.basis)


def _frequency(result: Result, row: Row) -> float | None:
    """Return the frequency of the mode that a row is of, as people know it; None of one that is not estimated."""
    alike = row.key._replace(quantity=FREQUENCY)
    return next((one.value for one in result.rows() if one.key == alike), None)


__all__ = ["JUDGED", "judge"]
