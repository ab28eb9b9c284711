"""What the polynomial of one thermal test leaves of the bias on power-ups that another one holds out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..core.errors import InertialcalError
from ..procedures.thermal import reduction as thermal
from ..procedures.thermal.closed_loop import Left, held_out, residual_rows
from .load import Campaign
from .prepared import placed
from .requirements import Tested
from .schema import Test

LeftOver = dict[str, tuple[str, tuple[Left, ...]]]


def against_of(tests: Sequence[Test], held: Test) -> str | None:
    """Return the thermal test for a fit that one held out is judged against: the first in the same condition."""
    fits = [one for one in tests if one.procedure == "thermal" and one.use == "fit"]
    same = [one.id for one in fits if one.condition == held.condition]
    return same[0] if same else None


def left_over(campaign: Campaign, tested: Sequence[Tested]) -> tuple[list[Tested], LeftOver]:
    """Return the tests, thermal ones held out with rows of what is left, and that by test, with the test of the fit.

    Raises
    ------
    DataError
        As ``thermal.closed_loop.held_out``.
    """
    by_name = {one.test.id: one for one in tested}
    rows: list[Tested] = []
    found: LeftOver = {}
    for number, one in enumerate(tested):
        other = against_of(campaign.file.tests, one.test)
        if one.test.use != "hold_out" or not isinstance(one.result, thermal.Result) or other is None:
            rows.append(one)
            continue
        try:
            left = held_out(by_name[other].result, one.result)
        except InertialcalError as error:
            raise type(error)([placed(problem, campaign, number) for problem in error.problems]) from None
        found[one.test.id] = other, left
        more = residual_rows({each.axis: each for each in left}, one.result.readings.unit, other)
        rows.append(replace(one, rows=[*one.rows, *(replace(row, test=one.test.id) for row in more)]))
    return rows, found
