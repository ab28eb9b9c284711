"""Gyro on the fixture, beside the first control accelerometer: shaken with it; at rest, and turned, before and after.

Vibration adds to its rate a part in proportion with the acceleration and one with its square (rectification); the bias
settles anew with each power-up, its scale factor too. A vibration that does no harm leaves both, and the noise, as they
were. On the rate table each axis is turned upright in each power-up; the rate of the table has one unknown error for
the campaign, each laying of the unit a mounting of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording
from ...core.units import factor
from ...physics.earth import level_to_table
from ..parts.gyro_bench import body_rate, motion, mounted
from ..twin import TrueValue
from .setup import GYRO, LATITUDE, RESTS, Bench

STEP = 1e-5  # of what is saved [deg/s]
HOUR = 3600.0  # [s]
LAST = {"before": -7200, "after": 3600}  # start of the first record at rest, from that of the random run [s]
APART = 300  # from record to record [s]
TURNED = {"before": -21_600, "after": 7200}  # start of the first record on the rate table, as LAST
RAMP = 1.0  # from rate to rate [s]
APPLIED = "rate_dps"


@dataclass(frozen=True)
class Sensitivity:
    """What vibration adds to the reading of an axis: with the acceleration, with its square; and its bias."""

    linear: float  # [deg/h/g]
    square: float  # [deg/h/g^2]
    bias: float  # [deg/s]
    scale: float = 0.0  # error of its scale factor before the vibration (1)


def rest_names(bench: Bench, when: str) -> list[str]:
    """Return the names of the records at rest before or after the vibration, one a power-up."""
    return [f"rest_{when}_{number}" for number in range(1, bench.power_ups + 1)]


def rate_names(bench: Bench, when: str) -> dict[str, tuple[str, int]]:
    """Return the records on the rate table before or after the vibration: name -> axis that is turned, power-up."""
    return {f"rate_{when}_{axis}{run}": (axis, run) for run in range(1, bench.power_ups + 1) for axis in GYRO}


def draw_gyro(bench: Bench, rng: np.random.Generator) -> dict[str, Sensitivity]:
    """Return the gyro: sensitivities of each axis within a third of those of the bench, of either sign."""
    scales = bench.scale_error * rng.spawn(1)[0].standard_normal(len(GYRO))
    drawn = {
        axis: Sensitivity(bench.sensitivity * size[0] * sign[0], bench.rectification * size[1] * sign[1], bias)
        for axis, size, sign, bias in (
            (axis, 1.0 + rng.uniform(-1.0, 1.0, 2) / 3.0, rng.choice([-1.0, 1.0], 2), 0.1 * rng.standard_normal())
            for axis in GYRO
        )
    }
    return {name: replace(one, scale=scale) for (name, one), scale in zip(drawn.items(), scales.tolist(), strict=True)}


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
                louder = bench.noisier if (when, axis) == ("after", "x") else 1.0
                data = _saved(level + louder * noise * rng.standard_normal(n))
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


def turned(
    bench: Bench, gyro: Mapping[str, Sensitivity], begin: int, gain: float, rng: np.random.Generator
) -> Iterator[tuple[str, Recording]]:
    """Yield name and recording of each turn on the rate table, before the vibration and after it.

    Parameters
    ----------
    bench : Bench
        How often, how fast, how long.
    gyro : mapping
        Axis -> bias and scale factor.
    begin : int
        Of the random run, POSIX [s].
    gain : float
        True over commanded rate of the table.
    rng : numpy.random.Generator
        For the mountings, turn-ons and noise.
    """
    upright = level_to_table(*np.radians([bench.tilt * rng.standard_normal(), 360.0 * rng.random()]).tolist())
    ramps = np.full(len(bench.rates_deg_s) - 1, RAMP)
    step = bench.rate_interval
    moving = motion(np.radians(bench.rates_deg_s), bench.dwell, ramps, step, step)
    stamps = np.rint((moving.start + 0.5 * step) * SECOND).astype(np.int64)
    mounting = bench.standards["rate_table.mounting"].u
    settled = dict[tuple[str, int], Array]()  # bias and scale factor of both axes in a power-up
    for when in RESTS:
        places = {axis: mounted(AXES.index(axis), tuple(mounting * rng.standard_normal(2))) for axis in GYRO}
        for number, (name, (about, run)) in enumerate(rate_names(bench, when).items()):
            on = settled.setdefault((when, run), rng.standard_normal((2, len(GYRO))))
            phase = 2.0 * np.pi * rng.random()
            rate = np.degrees(body_rate(moving, gain, places[about], np.radians(LATITUDE), upright, phase))
            channels = [Channel(APPLIED, np.round(np.degrees(moving.rate), 6) + 0.0, "deg/s", "campaign")]
            for i, (axis, own) in enumerate(gyro.items()):
                harmed = (when, axis) == ("after", "x")
                scale = 1.0 + own.scale + bench.scale_turn_on * on[1, i] + bench.scale_shift * harmed
                bias = own.bias + bench.turn_on * on[0, i] + bench.bias_shift * harmed
                noise = bench.gyro_noise / np.sqrt(step) * (bench.noisier if harmed else 1.0)
                data = _saved(bias + scale * rate[:, AXES.index(axis)] + noise * rng.standard_normal(len(rate)))
                channels.append(Channel(GYRO[axis], data, "deg/s", "campaign", axis, "gyro"))
            first = (begin + TURNED[when] + number * APART) * SECOND
            yield name, Recording(tuple(channels), first + stamps, step, step, "utc", "column", time_column="unix_s")


def gyro_truth(bench: Bench, gyro: Mapping[str, Sensitivity], control_gain: float) -> Iterator[TrueValue]:
    """Yield noise, bias, scale factor and rectification of each axis, the last against the control as it reads."""
    rate, g = factor("deg/s", "rad/s"), factor("g", "m/s^2")
    for axis, own in gyro.items():
        for when in RESTS if bench.power_ups else ():
            harmed = (when, axis) == ("after", "x")
            louder, shift, scale = (bench.noisier, bench.bias_shift, bench.scale_shift) if harmed else (1.0, 0.0, 0.0)
            noise = bench.gyro_noise * louder * rate
            yield TrueValue("angle_random_walk", axis, noise, "rad/sqrt(s)", f"rest_{when}")
            yield TrueValue("bias", axis, (own.bias + shift) * rate, "rad/s", f"rate_{when}")
            yield TrueValue("scale_factor_error", axis, own.scale + scale, "1", f"rate_{when}")
        if not bench.full_level:
            continue
        value = own.square / HOUR * rate / (g * (1.0 + control_gain)) ** 2
        yield TrueValue("vibration_rectification", f"{axis}x", value, "rad/s/(m/s^2)^2")


def _saved(rate: Array) -> Array:
    return np.asarray(np.round(np.round(rate / STEP) * STEP, 6))
