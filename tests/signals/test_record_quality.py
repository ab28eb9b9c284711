"""Bad segments and drift of a record at rest: found where they were put, not where they were not."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.signals.record_quality import record_quality

N, INTERVAL = 8_000, 0.01


def test_a_bump_is_placed_and_taken_out() -> None:
    x = np.random.default_rng(1).normal(size=(N, 2))
    x[3_000:3_100, 1] += 8.0
    x[100:110] = np.nan
    found = record_quality(x, INTERVAL)
    (bad,) = found.bad
    assert bad.axis == 1
    assert bad.start == pytest.approx(30.0, abs=0.05)
    assert bad.stop == pytest.approx(31.0, abs=0.05)
    assert [one.code for one in found.remarks] == ["disturbed"]
    cleaned = found.cleaned()
    assert np.nanmax(np.abs(cleaned)) < 8.0
    assert np.count_nonzero(np.isnan(cleaned[:, 0])) == 10
    assert np.count_nonzero(np.isnan(x)) == 20


def test_quiet_white_noise_is_left_alone() -> None:
    rng = np.random.default_rng(2)
    found = [record_quality(rng.normal(size=N), INTERVAL) for _ in range(60)]
    assert not any(one.remarks for one in found)
    assert all(len(one.drifts) == 1 for one in found)


def test_warm_up_and_drift_are_told_apart() -> None:
    rng, t = np.random.default_rng(3), np.linspace(0.0, 1.0, N)
    x = 0.3 * rng.normal(size=(N, 2)) + np.stack((3.0 * np.exp(-t / 0.15), 2.0 * t), axis=1)
    found = record_quality(x, INTERVAL)
    assert [one.code for one in found.remarks if one.code in {"warm_up", "drift"}] == ["warm_up", "drift"]
    assert found.drifts[1].rise == pytest.approx(2.0 * 63 / 64, abs=5.0 * found.drifts[1].u)


def test_a_sensor_that_turns_is_not_at_rest() -> None:
    rng = np.random.default_rng(4)
    x = np.repeat(rng.normal(0.0, 100.0, 40), N // 40) + rng.normal(size=N)
    assert "not_at_rest" in {one.code for one in record_quality(x, INTERVAL).remarks}


def test_constant_and_short_records_say_nothing_and_bad_ones_are_refused() -> None:
    assert not record_quality(np.ones(N), INTERVAL).remarks
    assert not record_quality(np.arange(20.0), INTERVAL).remarks
    with pytest.raises(DataError, match=r"a signal of shape \(2, 2, 2\)"):
        record_quality(np.ones((2, 2, 2)), INTERVAL)
    with pytest.raises(DataError, match=r"a sample interval of 0\.0 s"):
        record_quality(np.ones(N), 0.0)


def test_real_warm_up_and_real_disturbance(shared: Path) -> None:
    """A gyro whose mean falls from 0.98 to 0.64 deg/s; an "unmoved" one that was turned (8.9 deg/s)."""
    gyro = np.loadtxt(shared / "data/noise/l3g_gyro_x/gyro2_x.txt")
    found = record_quality(gyro, INTERVAL, floor=0.00875)
    assert [one.code for one in found.remarks] == ["warm_up"]
    assert found.drifts[0].rise == pytest.approx(0.640 - 0.977, abs=0.12)
    with h5py.File(shared / "data/sunsided_mpu6050_static/set-1__unmoved-x-pointing-up/mpu6050_gyroscope.mat") as file:
        turned = np.asarray(file["gyroBuffer"]).T
    found = record_quality(turned[:, 1:], INTERVAL)
    assert {one.code for one in found.remarks} & {"disturbed", "not_at_rest"}
