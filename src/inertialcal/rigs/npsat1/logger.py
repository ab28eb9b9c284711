"""What the logger of the simulated unit saves: means of 200 conversions over 1 s, every 2 s, some of them late.

For each sensor there are five columns: rate, temperature, built-in test, and the reference voltages that the rate and
the temperature are measured against. The built-in test is low until the sensor has started.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...core.axes import AXES
from ...core.estimate import Array
from ...core.recording import SECOND, Channel, Recording
from ...sensors.chain.conversion import to_temperature_counts
from ..parts.gyro_bench import averaged_codes
from .setup import AVERAGED, AVERAGING, CODES, INTERVAL, STEP, Bench, chain, thermometer
from .unit import Unit, reference_volts
from .world import World

APPLIED, PRESSURE = "rate_dps", "pressure_torr"  # columns beside the sensors' own
BEGIN = 1_272_412_800  # 2010-04-28 00:00:00 UTC [s]
DAY = 86_400
TESTED_VOLTS = 4.2  # of the built-in test when all is well
STARTED = 0.6  # [s] after power-up; Table 14: less than 1 s


def column(what: str, axis: str) -> str:
    """Return the name of a column: rate, temperature, built-in test or one of the references of a sensor."""
    return axis if what == "rate" else f"{axis}_{what}"


def save_starts(bench: Bench, duration: float, rng: np.random.Generator) -> Array:
    """Return where the averaging windows of a recording begin, whole seconds, shape (n,) [s]."""
    n = int(duration / INTERVAL) + 1
    steps = np.full(n, INTERVAL)
    pick = rng.random(n)
    for step, share in bench.steps.items():
        steps[(pick >= 0.0) & (pick < share)] = step
        pick -= share
    starts = np.concatenate([[0], np.cumsum(steps)])
    return np.asarray(starts[starts <= duration - AVERAGING], dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Sensed:
    """What there is to be saved.

    Parameters
    ----------
    starts : ndarray, shape (n,)
        Of the averaging windows, from the begin of the recording [s].
    readings : ndarray, shape (n, 3)
        Along the body axes [rad/s].
    temperature : ndarray, shape (n, 3)
        Of the sensors [degC].
    powered : float
        From power-up to the begin of the recording [s].
    begin : int
        Of the recording, UNIX time [s].
    """

    starts: Array
    readings: Array
    temperature: Array
    powered: float
    begin: int


def saved(
    bench: Bench, unit: Unit, world: World, sensed: Sensed, others: dict[str, Array], rng: np.random.Generator
) -> Recording:
    """Return the recording, each average stamped at its end.

    Parameters
    ----------
    bench, unit, world : Bench, Unit, World
        As they are.
    sensed : Sensed
        Readings and temperatures.
    others : dict of str to ndarray, shape (n,)
        Columns that are not of a sensor; they come first.
    rng : numpy.random.Generator
        All draws come from it.
    """
    codes = _codes(bench, unit, world, sensed, rng)
    if not bench.reference_saved:
        del codes["ref"]
    real = {axis: AXES.index(sensor) for axis, sensor in zip(AXES, bench.wiring, strict=True)}
    columns = others | {column(what, axis): table[:, real[axis]] for what, table in codes.items() for axis in AXES}
    stamps = (sensed.begin + np.rint(sensed.starts + AVERAGING).astype(np.int64)) * SECOND
    channels = tuple(Channel(name, np.ascontiguousarray(values)) for name, values in columns.items())
    return Recording(channels, stamps, float(INTERVAL), AVERAGING, epoch="utc")


def _codes(bench: Bench, unit: Unit, world: World, sensed: Sensed, rng: np.random.Generator) -> dict[str, Array]:
    """Return mean codes of the five columns, shape (n, 3) each; the error of the converter is in all of them."""
    known, channel, gain = chain(bench), thermometer(bench), world.converter_gain
    references = gain * _references(unit, sensed.temperature, rng)
    along_sensors = sensed.readings * np.array(bench.inverted)
    rate, reference = averaged_codes(known, gain * along_sensors, references[0], AVERAGED)
    fine = replace(known, step=STEP / AVERAGED, codes=(CODES[0] * AVERAGED, CODES[1] * AVERAGED))
    beside = np.clip(np.rint(references[1] / fine.step), CODES[0] * AVERAGED, CODES[1] * AVERAGED)
    volts = gain * channel.volts(sensed.temperature + world.thermometer)
    volts += rng.normal(0.0, unit.temperature_std, volts.shape)
    warm = to_temperature_counts(fine, channel.degrees(volts), reference=beside)
    on = np.clip(sensed.powered + sensed.starts + AVERAGING - STARTED, 0.0, AVERAGING) / AVERAGING
    tested = np.rint(TESTED_VOLTS / STEP * on * AVERAGED) / AVERAGED
    return {
        "rate": rate,
        "temp": warm / AVERAGED,
        "bit": np.repeat(tested[:, None], 3, axis=1),
        "ref": reference,
        "temp_ref": beside / AVERAGED,
    }


def _references(unit: Unit, temperature: Array, rng: np.random.Generator) -> Array:
    """Return the reference voltages of rate and temperature, shape (2, n, 3) [V]."""
    exact = np.stack([reference_volts(unit, which, temperature) for which in (0, 1)])
    return np.asarray(exact + rng.normal(0.0, unit.reference_std, exact.shape))
