"""What is written reads back: bits, time, gaps, units, missing values, in every format."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from inertialcal.core.errors import DataError, InertialcalError, StoreError, UsageError
from inertialcal.core.recording import SECOND, Channel, Recording, Source
from inertialcal.files import read
from inertialcal.files.survey import survey, survey_recording
from inertialcal.files.time_column import numbers, time_column, time_name
from inertialcal.files.write import WRITERS, write

FORMATS = [".csv", ".parquet", ".npz"]
DTYPES = ["u1", "i1", "u2", "i2", "u4", "i4", "i8", "f2", "f4", "f8", "bool", ">f8", ">i4"]
UNITS = [None, "deg/s", "rad/s", "g", "ug", "m/s^2", "V", "count", "degC", "Pa", "%", "V/(deg/s)", "ug/sqrt(Hz)"]
NAMES = ["gyro_x", "gyro_y [rad/s]", "acc_z", "wx", "x", "temp", "temperature [degC]", "volts", "slope_volt_per_dps",
         "acc_mps2", "status", "a,b", 'say "x"', "ä°", "  padded", "line\nbreak", "u (V)"]  # fmt: skip
UTC = np.int64(1_272_467_400 * SECOND)  # 2010-04-28T15:10:00Z
FAST = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def recording(*channels: Channel, **rest: Any) -> Recording:
    return Recording(tuple(channels), **rest)


def there_and_back(folder: Path, ending: str, one: Recording, **how: Any) -> Recording:
    path = folder / f"out{ending}"
    write(path, one)
    return read(path, **how)


def same_bits(a: NDArray[Any], b: NDArray[Any]) -> bool:
    """Whether numbers are the same in the type of the first, missing ones alike."""
    return np.array_equal(a, b.astype(a.dtype), equal_nan=a.dtype.kind == "f")


@st.composite
def recordings(draw: st.DrawFn) -> Recording:
    n = draw(st.integers(2, 30))
    names = draw(st.lists(st.sampled_from(NAMES), min_size=1, max_size=5, unique=True))
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    channels = []
    for name in names:
        kind = np.dtype(draw(st.sampled_from(DTYPES)))
        bits = rng.integers(0, 256, n * kind.itemsize, dtype=np.uint8)
        data = bits.view(kind) if kind.kind != "b" else bits > 127
        if kind.kind == "f":
            data = np.where(np.isfinite(data), data, np.nan).astype(kind)
            data[draw(st.integers(0, n - 1))] = draw(st.sampled_from([np.nan, 0.0, -0.0, 1.0, 0.1]))
        if draw(st.booleans()) and kind.kind == "f":
            data = np.rint(data)
        channels.append(Channel(name, data, draw(st.sampled_from(UNITS)), "flag"))
    return Recording(tuple(channels), **draw(times(n)))


@st.composite
def times(draw: st.DrawFn, n: int) -> dict[str, Any]:
    """Time with gaps, in any step, elapsed or UTC, from columns of any name; or a stated rate; or nothing."""
    if not draw(st.booleans()):
        rate = draw(st.one_of(st.none(), st.floats(1e-3, 1e5)))
        return {} if rate is None else {"sample_interval": 1.0 / rate, "interval_from": "flag"}
    step = draw(st.sampled_from([1, 1000, 7_812_500, 10_000_000, SECOND, 33_333_333]))
    steps = draw(st.lists(st.sampled_from([1, 1, 1, 1, 5, 1000]), min_size=n, max_size=n))
    epoch = draw(st.sampled_from(["utc", "elapsed"]))
    start = UTC if epoch == "utc" else np.int64(draw(st.sampled_from([0, 5 * SECOND, -3 * SECOND, 123_456_789])))
    name = draw(
        st.sampled_from(["t", "time", "Time (s)", "t_ms", "unix_s", "timestamp", "millis", "column_1", "x [V]"])
    )
    time_ns = start + np.cumsum(np.array(steps, dtype=np.int64) * step)
    return {"time_ns": time_ns, "epoch": epoch, "interval_from": f"time column {name!r}"}


@pytest.mark.parametrize("ending", FORMATS)
@FAST
@given(one=recordings())
def test_a_recording_reads_back(tmp_path: Path, ending: str, one: Recording) -> None:
    again = there_and_back(tmp_path, ending, one)
    assert len(again.channels) == len(one.channels)
    for was, now in zip(one.channels, again.channels, strict=True):
        assert same_bits(was.data, now.data), was
        assert now.unit == was.unit
        if ending != ".csv" and was.data.dtype.kind != "b":
            assert now.data.dtype == was.data.dtype.newbyteorder("=")
        assert (now.data.dtype.kind == "f") == (was.data.dtype.kind == "f")
    if one.time_ns is None:
        assert again.time_ns is None
        assert again.sample_interval == (one.sample_interval or None)
    else:
        np.testing.assert_array_equal(again.time_ns, one.time_ns)
        assert again.epoch == one.epoch
