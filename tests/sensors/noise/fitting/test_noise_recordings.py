"""Terms of real sensors: recordings and curves of others, with what was published with them."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest

from inertialcal.core.units import factor
from inertialcal.sensors.noise.fitting.estimator import fit
from inertialcal.sensors.noise.fitting.noise_fit import NoiseFit
from inertialcal.sensors.noise.fitting.problem import Run
from inertialcal.sensors.noise.terms import GaussMarkov, RandomWalk
from inertialcal.signals.allan import allan
from inertialcal.signals.allan.deviations import KINDS
from inertialcal.signals.allan.edf import degrees_of_freedom

CURVES = "data/noise/imu_utils_curves"
RECORD_OVER_LAST = 9.0  # record over longest averaging time of those curves, as their program makes them
MPU6050 = {"gyro": factor("deg/s/sqrt(Hz)", "rad/sqrt(s)") * 0.005, "accelerometer": 400e-6 * 9.80665}  # data sheet


def curve_of(folder: Path, imu: str, axis: str) -> Run:
    tau, deviation = (np.loadtxt(folder / f"data_{imu}_gyr_{column}.txt") for column in ("t", axis))
    interval, m = float(tau[0]), np.round(tau / tau[0])
    n = RECORD_OVER_LAST * m[-1] - 2.0 * m + 1.0
    sizes = zip(m.astype(int).tolist(), n.astype(int).tolist(), strict=True)
    edf = np.array([degrees_of_freedom(KINDS["overlapping"], *size, 0) for size in sizes])
    return Run(m, (factor("deg/h", "rad/s") * deviation) ** 2, n, edf, interval, interval, np.ones(len(m)))


def random_walk_of(found: NoiseFit) -> float:
    """With what a filter of the sensor takes off it."""
    white = next(term.coefficient for term in found.terms if isinstance(term, RandomWalk))
    markov = [term for term in found.terms if isinstance(term, GaussMarkov)]
    filtered = [one.sigma * np.sqrt(2.0 * one.correlation_time) for one in markov if one.correlation_time < 0.05]
    return float(np.hypot(white, sum(filtered)))


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("imu", ["16448", "A3", "N3"])
def test_terms_agree_with_what_was_published_with_the_curve(shared: Path, imu: str, axis: str) -> None:
    """gyr_n is the Allan deviation near 1 s, gyr_w its minimum (not the random walk that its name says)."""
    text = (shared / CURVES / f"{imu}_imu_param.yaml").read_text()
    at = 1 + "xyz".index(axis)
    white, least = (float(re.findall(rf"{name}: (\S+)", text)[at]) for name in ("gyr_n", "gyr_w"))
    found = fit(curve_of(shared / CURVES, imu, axis), "gyro")
    expected = np.sqrt(found.expected[0])
    assert random_walk_of(found) == pytest.approx(white, rel=0.2)
    assert np.interp(1.0, found.tau[0], expected) == pytest.approx(white, rel=0.1)
    assert np.min(expected) == pytest.approx(least, rel=0.25)
    assert 0.01 < found.misfit < 0.2  # no sensor is a sum of terms to 0.1 %
    assert "terms_do_not_explain" in {remark.code for remark in found.remarks}


def test_a_gyro_warming_up_has_white_noise_and_a_walk(shared: Path) -> None:
    """Steps of 8.75 mdps tell an L3G gyro: its data sheet says 0.03 deg/s/sqrt(Hz). The sample rate is not stated."""
    y = np.loadtxt(shared / "data/noise/l3g_gyro_x/gyro2_x.txt")
    curve = allan(y, 0.01, quantity="rate", unit="deg/s")
    found = fit(curve, "gyro")
    assert {"random_walk", "rate_random_walk"} <= {term.name for term in found.terms}
    white = found.estimate.value("angle_random_walk") * factor("rad/sqrt(s)", "deg/s/sqrt(Hz)")
    near = np.argmin(np.abs(curve.tau - 1.0))
    assert white == pytest.approx(curve.deviation[near, 0] * np.sqrt(curve.tau[near]), rel=0.03)
    assert 0.5 < white / 0.03 < 2.0
    assert 0.0 < found.misfit < 0.03
    ratio = found.variance[0][:12] / found.expected[0][:12]
    assert np.all(np.abs(np.sqrt(ratio) - 1.0) < 0.1)


@pytest.mark.parametrize(
    ("kind", "file", "unit"), [("gyro", "gyroscope", "deg/s"), ("accelerometer", "accelerometer", "g")]
)
def test_a_sensor_at_rest_has_the_noise_of_its_data_sheet(shared: Path, kind: str, file: str, unit: str) -> None:
    folder = shared / "data/sunsided_mpu6050_static/set-2__unmoved-with-x-pointing-forward-10min"
    with h5py.File(folder / f"mpu6050_{file}.mat") as content:
        y = np.asarray(next(iter(content.values())))[1:].T
    curve = allan(y, 0.01, quantity="rate", unit=unit)
    for axis in range(3):
        found = fit(curve, kind, axis=axis)  # type: ignore[arg-type]
        assert 0.5 < random_walk_of(found) / MPU6050[kind] < 3.0
        limits = [term for term in found.found if term.status == "not_identified"]
        assert limits
        for term in limits:
            assert term.upper_limit is not None
            assert term.reason
            assert term.record_needed is None or term.record_needed < 86400.0
