"""Gyro on the fixture, beside the first control accelerometer: shaken with it, and at rest before and after.

Vibration adds to its rate a part in proportion with the acceleration and one with its square (rectification); the bias
settles anew with each power-up. A vibration that does no harm leaves the bias where it was.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array
from ...core.recording import SECOND, Channel, Recording
from ...core.units import factor
from ..twin import TrueValue
from .setup import GYRO, RESTS, Bench

STEP = 1e-5  # of what is saved [deg/s]
HOUR = 3600.0  # [s]
LAST = {"before": -7200, "after": 3600}  # start of the first record at rest, from that of the random run [s]
APART = 300  # from record to record [s]


@dataclass(frozen=True)
class Sensitivity:
    """What vibration adds to the reading of an axis: with the acceleration, with its square; and its bias."""

    linear: float  # [deg/h/g]
    square: float  # [deg/h/g^2]
    bias: float  # [deg/s]


def rest_names(bench: Bench, when: str) -> list[str]:
    """Return the names of the records at rest before or after the vibration, one a power-up."""
    return [f"rest_{when}_{number}" for number in range(1, bench.power_ups + 1)]


def draw_gyro(bench: Bench, rng: np.random.Generator) -> dict[str, Sensitivity]:
    """Return the gyro: sensitivities of each axis within a third of those of the bench, of either sign."""
    return {
        axis: Sensitivity(bench.sensitivity * size[0] * sign[0], bench.rectification * size[1] * sign[1], bias)
        for axis, size, sign, bias in (
            (axis, 1.0 + rng.uniform(-1.0, 1.0, 2) / 3.0, rng.choice([-1.0, 1.0], 2), 0.1 * rng.standard_normal())
            for axis in GYRO
        )
    }


def shaken(bench: Bench, gyro: Mapping[str, Sensitivity], table: Array, rng: np.random.Generator) -> dict[str, Array]:
    """Return what the axes of the gyro read in the random run [deg/s]."""
    noise = bench.gyro_noise * np.sqrt(bench.sample_rate)
    turned_on = bench.turn_on * rng.standard_normal(len(gyro))
    return {
        axis: _saved(own.bias + on + (own.linear * table + own.square * table**2) / HOUR
                     + noise * rng.standard_normal(len(table)))
        for (axis, own), on in zip(gyro.items(), turned_on.tolist(), strict=True)
    }  # fmt: skip


def at_rest(
    bench: Bench, gyro: Mapping[str, Sensitivity], begin: int, rng: np.random.Generator
) -> Iterator[tuple[str, Recording]]:
    """Yield name and recording of each power-up at rest, before the vibration and after it.

    Parameters
    ----------
    bench : Bench
        How often, how long.
    gyro : mapping
        Axis -> sensitivities and bias.
    begin : int
        Of the random run, POSIX [s].
    rng : numpy.random.Generator
        For noise and turn-ons.
    """
    n = round(bench.rest_seconds * bench.rest_rate)
    noise = bench.gyro_noise * np.sqrt(bench.rest_rate)
    elapsed = np.rint(np.arange(n) * (SECOND / bench.rest_rate)).astype(np.int64)
    for when in RESTS:
        for number, name in enumerate(rest_names(bench, when)):
            channels = []
            for axis, own in gyro.items():
                moved = bench.bias_shift if (when, axis) == ("after", "x") else 0.0
                level = own.bias + moved + bench.turn_on * rng.standard_normal()
                data = _saved(level + noise * rng.standard_normal(n))
                channels.append(Channel(GYRO[axis], data, "deg/s", "campaign", axis, "gyro"))
            stamps = (begin + LAST[when] + number * APART) * SECOND + elapsed
            yield (
                name,
                Recording(
                    tuple(channels),
                    stamps,
                    1.0 / bench.rest_rate,
                    1.0 / bench.rest_rate,
                    "utc",
                    "column",
                    time_column="unix_s",
                ),
            )


def gyro_truth(bench: Bench, gyro: Mapping[str, Sensitivity], control_gain: float) -> Iterator[TrueValue]:
    """Yield noise and rectification of each axis, the latter against the control as it reads."""
    rate, g = factor("deg/s", "rad/s"), factor("g", "m/s^2")
    for axis, own in gyro.items():
        yield TrueValue("angle_random_walk", axis, bench.gyro_noise * rate, "rad/sqrt(s)")
        value = own.square / HOUR * rate / (g * (1.0 + control_gain)) ** 2
        yield TrueValue("vibration_rectification", f"{axis}x", value, "rad/s/(m/s^2)^2")


def _saved(rate: Array) -> Array:
    return np.asarray(np.round(np.round(rate / STEP) * STEP, 6))
