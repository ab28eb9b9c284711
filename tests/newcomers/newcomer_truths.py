"""What newcomers record: rates, temperatures and readings of sensors whose truth is known.

Own equations, nothing of the package: ``volts = reference + scale_factor (1 + error) (rate + bias)``.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
REFERENCE = 2.5  # V
SCALE_FACTOR = 0.02  # V/(deg/s): 100 deg/s are 2 V
LSB = 5.0 / 4095.0  # V
ERRORS = {"x": 0.012, "y": -0.008, "z": 0.004}  # of the scale factor
BIASES = {"x": 0.35, "y": -0.21, "z": 0.12}  # deg/s
SLOPES = {"x": 0.004, "y": -0.003, "z": 0.002}  # deg/s a degC
CROSS = 0.003  # of the turned axis, in the others
NOISE = 0.02  # deg/s


@dataclass(frozen=True)
class Log:
    """A recording of a gyro: time [s], what the table or the chamber did, readings in deg/s by axis, temperature."""

    time: Array
    readings: dict[str, Array]
    applied: Array = field(default_factory=lambda: np.empty(0))
    temperature: Array = field(default_factory=lambda: np.empty(0))

    def volts(self) -> dict[str, Array]:
        """Return what a voltmeter behind the sensor shows."""
        return {axis: REFERENCE + SCALE_FACTOR * values for axis, values in self.readings.items()}

    def counts(self) -> dict[str, NDArray[np.int64]]:
        """Return the codes of a converter of 12 bits over 5 V."""
        return {axis: np.rint(values / LSB).astype(np.int64) for axis, values in self.volts().items()}


def rate_table(seed: int = 1, dwell: float = 20.0, sample_rate: float = 10.0, turned: str = "x") -> Log:
    """Return a recording of a table that stands, turns at steps up to 80 deg/s both ways, and stands again."""
    rng = np.random.default_rng(seed)
    steps = (0.0, 20.0, 40.0, 60.0, 80.0, 0.0, -20.0, -40.0, -60.0, -80.0, 0.0)
    applied = np.repeat(steps, round(dwell * sample_rate))
    time = np.arange(len(applied)) / sample_rate
    readings = {}
    for axis in "xyz":
        felt = applied if axis == turned else CROSS * applied
        readings[axis] = (1.0 + ERRORS[axis]) * (felt + BIASES[axis]) + NOISE * rng.standard_normal(len(applied))
    return Log(time, readings, applied, np.full(len(applied), 23.0))


def chamber(seed: int = 2, sample_rate: float = 1.0, hours: float = 3.0) -> Log:
    """Return a recording of a gyro at rest in a chamber that goes from -20 to 60 degC and back."""
    rng = np.random.default_rng(seed)
    n = round(3600.0 * hours * sample_rate)
    time = np.arange(n) / sample_rate
    phase = time / time[-1]
    temperature = -20.0 + 80.0 * (1.0 - np.abs(2.0 * phase - 1.0))
    readings = {
        axis: (1.0 + ERRORS[axis]) * (BIASES[axis] + SLOPES[axis] * (temperature - 20.0))
        + NOISE * rng.standard_normal(n)
        for axis in "xyz"
    }
    return Log(time, readings, temperature=temperature)


def at_rest(seed: int = 3, sample_rate: float = 50.0, minutes: float = 10.0) -> Log:
    """Return a recording of a gyro that lies still: white noise beside its bias."""
    rng = np.random.default_rng(seed)
    n = round(60.0 * minutes * sample_rate)
    readings = {axis: BIASES[axis] + NOISE * rng.standard_normal(n) for axis in "xyz"}
    return Log(np.arange(n) / sample_rate, readings, temperature=np.full(n, 23.0))
