"""Formats of loggers: values, units, time, topics, and what is not whole."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from logger_files import WRITERS, Written

import inertialcal as ic
from inertialcal.core.recording import Recording

ROUNDING = 2e-7  # of numbers with seven digits


def read(path: Path, written: Written) -> Recording:
    return ic.read(path, topics=[] if written.topic is None else [written.topic])


@pytest.mark.parametrize("name", WRITERS)
def test_what_was_written_comes_back(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    written = WRITERS[name](path)
    found = read(path, written)
    for column, values in written.columns.items():
        data = found.channel(column).data
        if written.exact:
            np.testing.assert_array_equal(data, values, err_msg=column)
        else:
            np.testing.assert_allclose(data, values, rtol=ROUNDING, atol=ROUNDING, err_msg=column)
    for column, unit in written.units.items():
        assert found.channel(column).unit == unit, column
    if written.time_ns is not None:
        assert found.time_ns is not None
        np.testing.assert_array_equal(found.time_ns, written.time_ns)
        assert found.epoch == ("utc" if written.time_ns[0] > 10**17 else "elapsed")
    assert found.sample_rate == pytest.approx(written.sample_rate, rel=1e-6)
    assert {one.code for one in found.remarks} >= set(written.remarks)
