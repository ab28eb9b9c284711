"""Rig of the rate table: a three-axis gyro stepped through known rates about each of its axes.

In every power-up run the unit is turned about each axis in turn; each turn is one recording. The fixture that
carries the unit is the same throughout, so its angles, like the errors of the other standards, are one unknown for
the whole campaign. Each recording begins with the table at its index mark; where that points, for each axis that is
set up, is not known. The first runs are for the fit, the others are held out.

Sizes follow the flight unit of [1]_: 12 bit over 5 V, averages of 1 s saved every 2 s, some not saved, 0.5 V/(deg/s)
above a reference of 2.5 V, two of the three sensors mounted inverted, a table tilted so that its axis is across that
of the earth.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011, sections III and IV.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording
from ..parts.gyro_bench import (
    REFERENCE,
    STEP,
    Gyro,
    Motion,
    World,
    averaged_codes,
    draw_world,
    motion,
    powered_up,
    readings,
    table_errors,
)
from ..parts.noise import random_walk
from ..protocol import Rig, on_bench
from ..twin import Fault, TrueValue, Twin
from . import TITLE
from .campaign import APPLIED, campaign_text, recording_file, reference_column, validity_column
from .setup import Bench, chain, draw_gyro

__all__ = ["FAULTS", "RIG", "Bench", "build", "true_values"]

BEGIN = 1_272_467_400  # 2010-04-28 15:10:00 UTC [s]
RUN, SET_UP = 86_400, 7_200  # from run to run, and from axis to axis [s]
AS_DELIVERED = 0.003  # least error of a scale factor, of the unit that is demonstrated: it is there to be calibrated
DIGITS = 6  # of the commanded rate [deg/s]
REFERENCE_WALK = 5e-5  # of a reference voltage [V/sqrt(s)]
FAULTS: dict[str, Fault] = {
    "swapped_axis": Fault("columns x and y are exchanged", "axes_disagree", {"wiring": ("y", "x", "z")}),
    "wrong_sign": Fault(
        "the z sensor is not mounted inverted, though the campaign says so", "sign_disagrees", {"inverted": (-1, 1, 1)}
    ),
    "saturated_step": Fault(
        "the highest rate saturates the converter",
        "rail",
        {"rates_deg_s": (0.0, 0.5, -0.5, 1.5, -1.5, 0.0, 3.0, -3.0, 6.0, -4.5, 0.0)},
    ),
    "missing_reference": Fault("the reference voltages are missing", "missing_reference", {"reference_saved": False}),
    "bit_low": Fault("the built-in test is low throughout", "never_valid", {"built_in_test": 0.4}),
    "only_positive": Fault(
        "the table turned in one direction only",
        "few_rates",
        {"rates_deg_s": (0.0, 0.5, 1.0, 1.5, 2.0, 0.0, 3.0, 3.5, 4.0, 4.5, 0.0)},
    ),
    "axis_not_turned": Fault("the unit was not turned about z", "not_turned", {"turned": ("x", "y")}),
    "never_still": Fault(
        "no dwell at rest",
        "never_still",
        {"rates_deg_s": (0.5, -0.5, 1.5, -1.5, 2.5, -2.5, 3.0, -3.0, 4.5, -4.5)},
    ),
    "rate_off": Fault("the table turns 15 % slower than commanded", "gain_disagrees", {"table_gain": 0.85}),
}


def build(bench: Bench, seed: int, gyro: Gyro | None = None) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The test as it is made.
    seed : int
        Of all draws.
    gyro : Gyro, optional
        The unit; drawn by default.
    """
    of_unit, of_bench, of_runs = np.random.default_rng(seed).spawn(3)
    unit = gyro or draw_gyro(bench.inverted, of_unit, bench.curvature, bench.as_delivered)
    stands = {"table": (bench.tilt_deg, bench.u_tilt_deg, bench.azimuth_deg, bench.u_azimuth_deg)}
    world, drawn = draw_world(bench.standards, bench.latitude_deg, bench.table_gain, stands, of_bench)
    recordings = {}
    for run in range(1, bench.runs + 1):
        powered = powered_up(unit, of_runs)
        for axis in bench.turned:
            recordings[recording_file(axis, run)] = _recording(bench, world, powered, axis, run, of_runs)
    errors = table_errors(bench.standards, drawn, bench.latitude_deg)
    return Twin(campaign_text(bench), recordings, true_values(unit), drawn, errors=errors)


def true_values(gyro: Gyro) -> tuple[TrueValue, ...]:
    """Return the quantities of a unit as the results name them, SI."""
    model, found = gyro.model, []
    asymmetry, second, third = (
        np.zeros(3) if term is None else term
        for term in (model.scale_factor_asymmetry, model.second_order, model.third_order)
    )
    matrix = model.matrix[0]
    for i, axis in enumerate(model.axes):
        own = float(matrix[i, i])
        found += [
            TrueValue("bias", axis, float(model.bias[i]), "rad/s"),
            TrueValue("scale_factor", axis, float(model.scale_factor[i]) * own, "V/(rad/s)"),
            TrueValue("scale_factor_error", axis, own - 1.0, "1"),
            TrueValue("scale_factor_asymmetry", axis, float(asymmetry[i]), "1"),
            TrueValue("second_order", axis, float(second[i]), "1/(rad/s)"),
            TrueValue("third_order", axis, float(third[i]), "1/(rad/s)^2"),
        ]
        for j, other in enumerate(model.axes):
            if j != i:
                cross = float(matrix[i, j])
                found.append(TrueValue("cross_axis_sensitivity", axis + other, cross, "1"))
                found.append(TrueValue("misalignment", axis + other, cross / own, "rad"))
    return tuple(found)


def _recording(bench: Bench, world: World, gyro: Gyro, axis: str, run: int, rng: np.random.Generator) -> Recording:
    """Return what the logger saves while one axis is turned in one run."""
    ramps = bench.interval * rng.integers(1, bench.longest_ramp + 1, len(bench.rates_deg_s) - 1)
    turning = motion(np.radians(bench.rates_deg_s), bench.dwell, ramps, bench.interval, bench.averaging)
    rate = world.body_rate(turning, axis)
    read = readings(gyro, rate, turning, bench.interval, bench.averaging, rng)
    signals = _signals(bench, read @ gyro.mounting.T * world.converter_gain, rng)
    signals[APPLIED] = np.asarray(np.round(np.degrees(turning.rate), DIGITS) + 0.0, dtype=np.float64)  # no -0.0
    saved = rng.random(len(turning.start)) >= bench.skipped
    return _saved(bench, turning, signals, saved, BEGIN + (run - 1) * RUN + AXES.index(axis) * SET_UP)


def _signals(bench: Bench, sensed: Array, rng: np.random.Generator) -> dict[str, Array]:
    """Mean codes of all columns, of readings along the sensor axes."""
    n, k = sensed.shape
    volts = (
        REFERENCE + rng.normal(0.0, 0.005, k) + random_walk(REFERENCE_WALK, n, k, bench.interval, bench.averaging, rng)
    )
    codes, reference = averaged_codes(chain(), sensed, volts, bench.averaged)
    signals = {column: codes[:, AXES.index(sensor)] for column, sensor in zip(AXES, bench.wiring, strict=True)}
    if bench.reference_saved:
        signals |= {reference_column(axis): reference[:, i] for i, axis in enumerate(AXES)}
    return signals | {validity_column(axis): np.full(n, np.rint(bench.built_in_test / STEP)) for axis in AXES}


def _saved(bench: Bench, turning: Motion, signals: dict[str, Array], saved: NDArray[np.bool_], begin: int) -> Recording:
    """Return the recording of the saved averages, each stamped at its end; the rate comes first."""
    stamps = np.rint((begin + turning.start[saved] + bench.averaging) * SECOND).astype(np.int64)
    columns = [APPLIED, *(name for name in signals if name != APPLIED)]
    channels = tuple(Channel(name, signals[name][saved]) for name in columns)
    return Recording(channels, stamps, bench.interval, bench.averaging, epoch="utc")


RIG = Rig("rate_table", TITLE, on_bench(build, Bench(as_delivered=AS_DELIVERED)), FAULTS, tests=("rate_table",))
