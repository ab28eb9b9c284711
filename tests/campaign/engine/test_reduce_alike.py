"""One test of many units: each has the result, or the refusal, that it has alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from inertialcal.campaign.engine.engine import Prepared, prepare, reduce_alike, reduce_test
from inertialcal.campaign.file.load import load
from inertialcal.core.errors import DataError, InertialcalError
from inertialcal.procedures import procedure_of
from inertialcal.procedures.protocol import Procedure

RATE_TABLE = type(procedure_of("rate_table"))


def values(result: Any) -> list[float]:
    return list(result.estimate.values)


@pytest.fixture
def units(campaign: Callable[..., Path], monkeypatch: pytest.MonkeyPatch) -> list[Prepared]:
    """Three preparations of one test; the readings of the second are refused."""
    made = [prepare(load(campaign()), 0) for _ in range(3)]
    alone = RATE_TABLE.reduce

    def reduce(self: Any, plan: Any, readings: Any) -> Any:
        if readings is made[1].readings:
            raise DataError("no line", code="no_line")
        return alone(self, plan, readings)

    monkeypatch.setattr(RATE_TABLE, "reduce", reduce)
    return made


def check(found: Sequence[Any], units: Sequence[Prepared]) -> None:
    assert values(found[0]) == values(reduce_test(units[0])) == values(found[2])
    assert isinstance(found[1], InertialcalError)
    assert found[1].problems[0].code == "no_line"


def test_a_refused_unit_leaves_the_others(units: list[Prepared], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(RATE_TABLE, "reduce_many", Procedure.reduce_many)
    check(reduce_alike(units), units)


def test_where_a_batch_breaks_down_each_is_reduced_alone(
    units: list[Prepared], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(self: object, tests: object) -> list[Any]:
        raise ZeroDivisionError

    monkeypatch.setattr(RATE_TABLE, "reduce_many", broken)
    check(reduce_alike(units), units)


def test_a_fault_of_the_program_stays_with_its_unit(units: list[Prepared], monkeypatch: pytest.MonkeyPatch) -> None:
    before = RATE_TABLE.reduce

    def faulty(self: Any, plan: Any, readings: Any) -> Any:
        if readings is units[0].readings:
            raise KeyError("fault")
        return before(self, plan, readings)

    monkeypatch.setattr(RATE_TABLE, "reduce", faulty)
    monkeypatch.setattr(RATE_TABLE, "reduce_many", Procedure.reduce_many)
    first, second, third = reduce_alike(units)
    assert isinstance(first, KeyError)
    assert isinstance(second, DataError)
    assert values(third) == values(reduce_test(units[2]))
