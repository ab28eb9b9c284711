"""Disturbances and drift of a channel at rest: found where they were put, not where they were not."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from inertialcal.core.errors import DataError
from inertialcal.core.estimate import Array
from inertialcal.signals.codes import coarse_steps, surely_fine
from inertialcal.signals.record_quality import RecordQuality, qualities_alike, record_quality
from inertialcal.signals.screening.screen import screen

N, INTERVAL = 8_000, 0.01


def remarks(found: RecordQuality) -> list[str]:
    return [one.remark("x").code for one in found.drifts if one.significant]


def screened(x: Array) -> Array:
    return np.where(screen(x).screened(x), np.nan, x)


def test_a_bump_is_placed_and_taken_out() -> None:
    x = np.random.default_rng(1).normal(size=N)
    x[3_000:3_100] += 8.0
    x[100:110] = np.nan
    found = record_quality(x, INTERVAL)
    (bad,) = found.disturbances
    assert bad.first == pytest.approx(3_000, abs=5)
    assert bad.last == pytest.approx(3_099, abs=5)
    assert found.at_rest
    cleaned = found.cleaned()
    assert np.nanmax(np.abs(cleaned)) < 8.0
    assert np.count_nonzero(np.isnan(x)) == 10


def test_quiet_white_noise_is_left_alone() -> None:
    rng = np.random.default_rng(2)
    found = [record_quality(rng.normal(size=N), INTERVAL) for _ in range(60)]
    assert all(one.at_rest and not one.disturbances and not remarks(one) for one in found)
    assert all(len(one.drifts) == 1 for one in found)


def test_warm_up_and_drift_are_told_apart() -> None:
    rng, t = np.random.default_rng(3), np.linspace(0.0, 1.0, N)
    assert remarks(record_quality(0.3 * rng.normal(size=N) + 3.0 * np.exp(-t / 0.15), INTERVAL)) == ["warm_up"]
    found = record_quality(0.3 * rng.normal(size=N) + 2.0 * t, INTERVAL)
    assert remarks(found) == ["drift"]
    assert found.drifts[0].rise == pytest.approx(2.0 * 63 / 64, abs=5.0 * found.drifts[0].u)


def test_a_sensor_that_turns_is_not_at_rest() -> None:
    rng = np.random.default_rng(4)
    x = np.repeat(rng.normal(0.0, 100.0, 40), N // 40) + rng.normal(size=N)
    assert not record_quality(x, INTERVAL).at_rest


def test_short_records_say_nothing_and_bad_ones_are_refused() -> None:
    for x in (np.arange(20.0), np.full(20, np.nan)):
        found = record_quality(x, INTERVAL)
        assert (found.disturbances, found.at_rest, found.drifts) == ((), True, ())
    with pytest.raises(DataError, match=r"a channel of shape \(2, 2\)"):
        record_quality(np.ones((2, 2)), INTERVAL)
    with pytest.raises(DataError, match=r"a sample interval of 0\.0 s"):
        record_quality(np.ones(N), 0.0)


def test_real_warm_up_and_real_disturbance(shared: Path) -> None:
    """A gyro whose mean falls from 0.98 to 0.64 deg/s; an "unmoved" one that was turned (8.9 deg/s)."""
    gyro = np.loadtxt(shared / "data/noise/l3g_gyro_x/gyro2_x.txt")
    found = record_quality(screened(gyro), INTERVAL, floor=0.00875)
    assert remarks(found) == ["warm_up"]
    assert found.drifts[0].rise == pytest.approx(0.640 - 0.977, abs=0.12)
    turned = mpu6050(shared, "set-1__unmoved-x-pointing-up")
    assert any(record_quality(screened(x), INTERVAL).disturbances for x in turned.T)


def test_real_buffer_that_was_not_filled(shared: Path) -> None:
    """Its last 720 samples are zero: they are no drift, and no end of the range."""
    for x in mpu6050(shared, "set-1__unmoved-z-pointing-left").T:
        found = screen(x)
        assert found.codes == ("stuck",)
        assert found["stuck"].places.tolist() == [[6_280, 6_999]]
        assert remarks(record_quality(screened(x), INTERVAL)) == []


def test_real_rest(shared: Path) -> None:
    for name in ("set-1__unmoved-x-pointing-forward", "set-2__unmoved-with-x-pointing-forward-10min"):
        for x in mpu6050(shared, name).T:
            found = record_quality(screened(x), INTERVAL)
            assert (screen(x).codes, found.at_rest, found.disturbances, remarks(found)) == ((), True, (), [])


def mpu6050(shared: Path, name: str) -> Array:
    with h5py.File(shared / "data/sunsided_mpu6050_static" / name / "mpu6050_gyroscope.mat") as file:
        return np.asarray(file["gyroBuffer"]).T[:, 1:]


def test_records_alike_are_judged_as_each_by_itself() -> None:
    rng, t = np.random.default_rng(8), np.arange(N)
    series = [
        *(0.3 * rng.normal(size=N) + slope * t / N for slope in (0.0, 0.1, 3.0)),
        rng.normal(size=N) + 40.0 * (t // 50 == 7),
        np.where(t == 5, np.nan, rng.normal(size=N)),
        np.full(N, 2.0),
        np.rint(0.4 * rng.normal(size=N)),
    ]
    for some in (series, series[:4], series[5:], [x[:40] for x in series]):
        for x, found in zip(some, qualities_alike(some, INTERVAL), strict=True):
            own = record_quality(x, INTERVAL)
            assert (found.disturbances, found.at_rest, found.drifts) == (own.disturbances, own.at_rest, own.drifts)
            assert found.values is x
    assert [surely_fine(x) for x in series] == [True] * 4 + [False] * 3
    assert all(coarse_steps(x, "x") == () for x in series if surely_fine(x))
