"""What a sample is the mean of: refused where it cannot be, the hint computed from the record."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.core.errors import DataError

AMPLITUDE, PERIOD = 23.0, 4.0
LOSS = 1.0 - np.sin(np.pi / 4.0) / (np.pi / 4.0)  # of means over a quarter of the period


def record(path: Path, *, means: bool, every: float = 1.0, noise: float = 1.0) -> Path:
    """Write a sine of 4 s in white noise, as points or as means over the interval, stamped in their middle."""
    rng, t = np.random.default_rng(5), every * np.arange(1000)
    seen = AMPLITUDE * (float(np.sinc(every / PERIOD)) if means else 1.0)
    values = seen * np.sin(2.0 * np.pi * t / PERIOD) + noise * rng.standard_normal(len(t))
    np.savetxt(path, np.column_stack([t, values]), "%.6f", ",", header="time [s],acc_x [ng]", comments="")
    return path


@pytest.mark.parametrize("averaging", ["10 s", "4 s", "1.5 s"])
def test_more_than_the_interval_is_refused(tmp_path: Path, averaging: str) -> None:
    file = record(tmp_path / "driven.csv", means=False)
    with pytest.raises(DataError, match=r'samples are 1 s apart.*--averaging "1 s"') as caught:
        ic.sine(file, period="4 s", phase="0 deg", averaging=averaging)
    assert caught.value.problems[0].code == "averaging_time"


def test_more_than_the_period_is_refused_where_stamps_are_uneven(tmp_path: Path) -> None:
    rng = np.random.default_rng(6)
    t = np.cumsum(rng.uniform(2.0, 12.0, 300))
    np.savetxt(tmp_path / "uneven.csv", np.column_stack([t, np.sin(2.0 * np.pi * t / PERIOD)]), "%.6f", ",",
               header="time [s],acc_x [ng]", comments="")  # fmt: skip
    with pytest.raises(DataError, match="averaging over 5 s"):
        ic.sine(tmp_path / "uneven.csv", period="4 s", phase="0 deg", averaging="5 s")


@pytest.mark.parametrize("every", [1.0, 0.5])
def test_the_hint_obeyed_is_right(tmp_path: Path, every: float) -> None:
    file = record(tmp_path / "driven.csv", means=True, every=every)
    found = ic.sine(file, period="4 s", phase="0 deg")
    remark = next(one for one in found.remarks if one.code == "averaging")
    assert remark.severity == "warning"  # more than u
    averaging = re.search(r'--averaging "([^"]+)" for means', remark.do)
    assert averaging
    assert averaging[1] == f"{every:g} s"
    row = ic.sine(file, period="4 s", phase="0 deg", averaging=averaging[1]).rows[0]
    assert row.interval
    assert row.interval.lo is not None
    assert row.interval.hi is not None
    assert row.interval.lo < AMPLITUDE < row.interval.hi


def test_points_said_leave_the_amplitude(tmp_path: Path) -> None:
    file = record(tmp_path / "driven.csv", means=False)
    unsaid = ic.sine(file, period="4 s", phase="0 deg")
    said = ic.sine(file, period="4 s", phase="0 deg", averaging="0 s")
    assert said.rows[0].value == unsaid.rows[0].value
    assert not [one for one in said.remarks if one.code == "averaging"]
    what = next(one.what for one in unsaid.remarks if one.code == "averaging")
    assert f"{100.0 * LOSS / (1.0 - LOSS):.3g} % larger" in what


def test_a_loss_below_u_is_no_warning(tmp_path: Path) -> None:
    file = record(tmp_path / "driven.csv", means=False, noise=200.0)
    remark = next(one for one in ic.sine(file, period="4 s", phase="0 deg").remarks if one.code == "averaging")
    assert remark.severity == "info"
