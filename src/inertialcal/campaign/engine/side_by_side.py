"""Tests of one campaign set side by side: flips after one ground model and another, bias in air and in vacuum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...core.errors import InertialcalError
from ...core.results import Row
from ..file.load import Campaign
from ..outcome.requirements import Tested
from .prepared import placed


def beside_others(campaign: Campaign, tested: Sequence[Tested]) -> list[Tested]:
    """Return the tests, those ``against`` another with the rows of what the two differ by.

    Raises
    ------
    PlanError
        If the two cannot be set side by side.
    """
    by_name = {one.test.id: one for one in tested}
    return [one if one.test.against is None else _beside(campaign, one, by_name[one.test.against]) for one in tested]


def _beside(campaign: Campaign, one: Tested, other: Tested) -> Tested:
    try:
        rows = _rows(one, other)
    except InertialcalError as error:
        number = campaign.file.tests.index(one.test)
        raise type(error)([placed(problem, campaign, number) for problem in error.problems]) from None
    return replace(one, rows=[*one.rows, *(replace(row, test=one.test.id) for row in rows)])


def _rows(one: Tested, other: Tested) -> Sequence[Row]:
    return one.procedure.against(one.result, other.reduced, one.test.condition) or ()
