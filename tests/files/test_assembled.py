"""Recordings of many units in one table: each is what its own rows alone make, however it was come by."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pyarrow as pa
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.recording import Recording, Source
from inertialcal.files.assemble import Assembled, assemble
from inertialcal.files.binary.parquet import contents_of
from inertialcal.files.columns import Content

Columns = dict[str, np.ndarray]
N = 50


def _unit(seed: int) -> Columns:
    rate = np.random.default_rng(seed).normal(size=(2, N))
    return {"time_s": 0.01 * np.arange(1.0, N + 1.0), "gyro_x_dps": rate[0], "gyro_y_dps": rate[1]}


def _contents(*units: Columns) -> list[Content | DataError]:
    table = pa.concat_tables([pa.table(one) for one in units]).combine_chunks()
    ends = np.cumsum([0, *(len(next(iter(one.values()))) for one in units)]).tolist()
    parts = [range(a, b) for a, b in pairwise(ends)]
    return list(contents_of(table, parts, [f"unit {k}" for k in range(len(units))]))


def _content(found: Content | DataError) -> Content:
    assert isinstance(found, Content)
    return found


def _equal(one: Recording, other: Recording) -> bool:
    return (
        [(c.name, c.unit, c.axis, c.quantity) for c in one.channels]
        == [(c.name, c.unit, c.axis, c.quantity) for c in other.channels]
        and all(np.array_equal(a.data, b.data) for a, b in zip(one.channels, other.channels, strict=True))
        and np.array_equal(one.time_ns, other.time_ns)  # type: ignore[arg-type]
        and (one.sample_interval, one.remarks) == (other.sample_interval, other.remarks)
    )


def test_a_unit_of_the_same_stamps_is_the_recording_of_its_own_rows() -> None:
    first, second = map(_content, _contents(_unit(1), _unit(2)))
    known = Assembled(first, assemble(first, Source("a", "", "Parquet", "parquet")))
    made = known.with_values(second, Source("b", "", "Parquet", "parquet"))
    assert made is not None
    assert made.source.path == "b"
    assert _equal(made, assemble(second, Source("b", "", "Parquet", "parquet")))


def _late(one: Columns) -> None:
    one["time_s"][-1] += 1.0


def _missing(one: Columns) -> None:
    one["gyro_x_dps"][7] = np.nan


def _unnamed(one: Columns) -> None:
    one["k"] = np.arange(0.0, N) ** 2


@pytest.mark.parametrize("changed", [_late, _missing, _unnamed])
def test_what_values_may_change_is_worked_out_anew(changed: Callable[[Columns], None]) -> None:
    one, other = _unit(1), _unit(2)
    if changed is _unnamed:
        one["k"] = np.arange(0.0, N)  # counts rows; that of the other does not
    changed(other)
    first, second = map(_content, _contents(one, other))
    known = Assembled(first, assemble(first, Source("a", "", "Parquet", "parquet")))
    assert known.with_values(second, Source("b", "", "Parquet", "parquet")) is None


def test_missing_values_are_those_of_the_own_rows() -> None:
    one, other = _unit(1), _unit(2)
    _missing(one)
    other["gyro_y_dps"][3] = np.nan
    first, second = map(_content, _contents(one, other))
    assert [c.not_a_number.tolist() for c in first.columns] == [[], [7], []]
    assert [c.not_a_number.tolist() for c in second.columns] == [[], [], [3]]


def test_text_among_numbers_refuses_its_own_unit_alone() -> None:
    units = [{"n": np.array([str(k) for k in range(20)])} for _ in range(3)]
    units[1]["n"][4] = "x"
    found = _contents(*units)
    assert [isinstance(one, DataError) for one in found] == [False, True, False]
