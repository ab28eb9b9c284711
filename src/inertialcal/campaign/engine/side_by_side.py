"""Tests of one campaign set side by side: what two tests of a procedure differ by stands with the first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ...core.errors import InertialcalError
from ...procedures.protocol import Tested
from ..file.load import Campaign
from .engine import ReducedTest
from .prepared import placed


def beside_others(campaign: Campaign, tested: Sequence[ReducedTest]) -> list[ReducedTest]:
    """Return the tests, those ``against`` another with the rows of what the two differ by.

    Raises
    ------
    PlanError
        If the two cannot be set side by side.
    """
    return [one if one.tested.against is None else _beside(campaign, one, one.tested.against) for one in tested]


def _beside(campaign: Campaign, one: ReducedTest, other: Tested[Any, Any, Any]) -> ReducedTest:
    try:
        rows = one.procedure.against(one.result, other, one.test.condition) or ()
    except InertialcalError as error:
        number = campaign.file.tests.index(one.test)
        raise type(error)([placed(problem, campaign, number) for problem in error.problems]) from None
    named = [replace(row, test=one.test.id) for row in rows]
    return replace(one, rows=[*one.rows, *named], against=named)
