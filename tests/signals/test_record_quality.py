"""Bad segments and drift of a record at rest: found where they were put, not where they were not."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
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


def test_motion_that_never_stops_is_noise_that_is_not_white() -> None:
    rng = np.random.default_rng(5)
    slow = np.convolve(rng.normal(size=N + 49), np.ones(50), mode="valid")
    found = record_quality(np.stack((slow, rng.normal(size=N)), axis=1), INTERVAL, names=("a", "b"))
    (remark,) = found.remarks
    assert remark.code == "noise_not_white"
    assert remark.what.startswith("a: window means scatter ")
    assert found.widening[1] < 2.0


@pytest.mark.parametrize("value", [0.0, 2.0, 40.0])
def test_stuck_stretches_are_left_out(value: float) -> None:
    rng = np.random.default_rng(6)
    x = np.rint(3.0 * rng.normal(size=N))
    x[2_000:2_400], x[7_000:7_100] = value, value
    found = record_quality(x, INTERVAL)
    places = [place for one in found.stuck for place in (one.first, one.last)]
    assert places == pytest.approx([2_000, 2_399, 7_000, 7_099], abs=2)
    assert found.bad == ()
    assert not found.drifts[0].significant
    assert np.count_nonzero(np.isnan(found.cleaned())) == pytest.approx(500, abs=8)
    assert "stuck" in [one.code for one in found.remarks]


def test_saturated_codes_are_told() -> None:
    x = np.clip(np.rint(30.0 * np.random.default_rng(7).normal(size=N)), -45.0, 1_000.0)
    (remark,) = record_quality(x, INTERVAL, floor=1.0).remarks
    assert remark.code == "saturated"
    assert "x: saturated samples at the end of the range, -45" in remark.what


def test_constant_channel_is_told() -> None:
    x = np.stack((np.ones(N), np.random.default_rng(8).normal(size=N)), axis=1)
    found = record_quality(x, INTERVAL)
    assert [str(one) for one in found.remarks] == [
        "warning: x: all samples are equal. Check the wiring and the resolution"
    ]
    assert np.isnan(found.widening[0])
    assert found.stuck == ()


def test_short_records_say_nothing_and_bad_ones_are_refused() -> None:
    assert not record_quality(np.arange(20.0), INTERVAL).remarks
    assert not record_quality(np.full(20, np.nan), INTERVAL).remarks
    with pytest.raises(DataError, match=r"a signal of shape \(2, 2, 2\)"):
        record_quality(np.ones((2, 2, 2)), INTERVAL)
    with pytest.raises(DataError, match=r"a sample interval of 0\.0 s"):
        record_quality(np.ones(N), 0.0)
    with pytest.raises(PlanError, match=r"2 name\(s\) for 1 channel"):
        record_quality(np.ones(N), INTERVAL, names=("x", "y"))


def test_real_warm_up_and_real_disturbance(shared: Path) -> None:
    """A gyro whose mean falls from 0.98 to 0.64 deg/s; an "unmoved" one that was turned (8.9 deg/s)."""
    gyro = np.loadtxt(shared / "data/noise/l3g_gyro_x/gyro2_x.txt")
    found = record_quality(gyro, INTERVAL, floor=0.00875)
    assert [one.code for one in found.remarks] == ["warm_up"]
    assert found.drifts[0].rise == pytest.approx(0.640 - 0.977, abs=0.12)
    turned = mpu6050(shared, "set-1__unmoved-x-pointing-up")
    assert {one.code for one in record_quality(turned, INTERVAL).remarks} == {"disturbed"}


def test_real_buffer_that_was_not_filled(shared: Path) -> None:
    """Its last 720 samples are zero: they are no drift, and no end of the range."""
    found = record_quality(mpu6050(shared, "set-1__unmoved-z-pointing-left"), INTERVAL)
    assert [(one.axis, one.first, one.last) for one in found.stuck] == [
        (0, 6_280, 6_999),
        (1, 6_280, 6_999),
        (2, 6_280, 6_999),
    ]
    assert {one.code for one in found.remarks} == {"stuck"}


def test_real_rest_and_real_motion(shared: Path) -> None:
    """Two recordings at rest, and one about each axis by hand."""
    for name in ("set-1__unmoved-x-pointing-forward", "set-2__unmoved-with-x-pointing-forward-10min"):
        assert record_quality(mpu6050(shared, name), INTERVAL).remarks == ()
    for name in ("x-pointing-forward", "y-pointing-left", "z-pointing-up"):
        found = record_quality(mpu6050(shared, f"set-1__rotate-360ccw-around-{name}"), INTERVAL)
        told = {one.what[0] for one in found.remarks if one.code in {"not_at_rest", "noise_not_white"}}
        assert told == {"x", "y", "z"}


def mpu6050(shared: Path, name: str) -> Array:
    with h5py.File(shared / "data/sunsided_mpu6050_static" / name / "mpu6050_gyroscope.mat") as file:
        return np.asarray(file["gyroBuffer"]).T[:, 1:]
