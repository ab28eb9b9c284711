"""Rig of the in-orbit flip: a triaxial head turned by half a turn about its x axis, and back, within a record.

Sizes follow the head of [1]_: biases of the order of 1000 ug under a few ug of ambient acceleration, 10 V over 65536
counts, gains of 1, 10, 100 and 1000, filters of one and seven poles, scale factor and bias as polynomials of fourth
order in temperature. ``sams_tsh_record`` says what the truth means.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording
from ...sensors.chain.conversion import to_counts, to_temperature_counts
from ..parts.campaign import drawn_errors
from ..protocol import Rig, on_bench
from ..twin import Drawn, Fault, TrueValue, Twin
from . import TITLE
from .campaign import BEGIN, FILE, campaign_text
from .record import Record, polynomial, record
from .setup import REFERENCE_TEMPERATURE, SCALE_FACTOR_V_PER_G, UG, Bench, Drawing, G, Head, chain, draw_head

__all__ = ["FAULTS", "RIG", "Bench", "build", "saved"]

THERMOMETER_NOISE = 0.002  # [degC]
UNIT = "m/s^2"
FAULTS: dict[str, Fault] = {
    "not_turned": Fault("the turn back stops 60 deg short", "not_turned_by_angle", {"stopped_deg": (0.0, 60.0)}),
    "other_axis": Fault("the head was turned about z, not x", "turned_about_other_axis", {"turn_axis": "z"}),
    "gain_changed": Fault("the gain of y changes during a window", "gain_changed", {"gain_change": (1350.0, "y", 0.1)}),
    "too_short": Fault(
        "the head is turned back before it has settled",
        "shorter_than_settling",
        {"turn_starts": (1200.0, 1215.0)},
    ),
    "missing_position": Fault(
        "the recording of the turned position is lost", "missing_position", {"lost": (1202.0, 2404.0)}
    ),
    "at_rails": Fault("x saturates the converter at gain 1000", "rail", {"gains": (1000.0, 100.0, 10.0)}),
    "magnitude": Fault("recorded in g, stated as ug", "magnitude", {"saved": "g", "said": "ug"}),
    "robot_arm": Fault("the robot arm moves during a flip", "disturbed", {"arm": (2250.0, 2600.0)}),
    "wrong_sign": Fault(
        "y has the wrong sign: half turns do not show it, a quarter turn does",
        "not_turned_by_angle",
        {
            "signs": (1, -1, 1),
            "turn_starts": (900.0, 1800.0, 2700.0),
            "positions_deg": (90.0, 180.0, 0.0),
            "stopped_deg": (0.0, 0.0, 0.0),
        },
    ),
}


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The flip as it is made.
    seed : int
        Of all draws.
    """
    root = np.random.default_rng(seed)
    of_head, of_record, of_files = root.spawn(3)
    (of_model,) = root.spawn(1)
    head = draw_head(bench, of_head)
    made = record(bench, head, of_record)
    model = draw_model(bench, head, of_model) if bench.ground else None
    if model is None:
        truth = [TrueValue("bias", axis, float(made.bias[i]), "m/s^2") for i, axis in enumerate(AXES)]
        truth.append(TrueValue("reading", "x", float(made.bias[0] + made.ambient[0]), "m/s^2"))
    else:
        truth = true_values(bench, head, model, made)
    truth += [TrueValue("ambient_acceleration", axis, float(made.ambient[i]), "m/s^2") for i, axis in enumerate(AXES)]
    truth.append(TrueValue("control_error", "x", 0.0, "m/s^2"))
    drawn: Drawn = {
        "turn_angle_error": made.errors.angle,
        "turn_axis_error": made.errors.axis.tolist(),
        "converter_zero_error": made.errors.zero.tolist(),
        "scale_factor_error": made.errors.scale.tolist(),
        "temperature_start": made.temperature[0].tolist(),
        "bias_at_reference_temperature": head.bias[0].tolist(),
        "bias_temperature": head.bias[1:].tolist(),
        "matrix": head.matrix[0].tolist(),
        "zero_of_electronics": np.asarray(chain(bench, head).zero).tolist(),
    }
    files = {FILE: saved(bench, head, made, of_files)}
    off = {
        "turn.angle": made.errors.angle,
        **{f"converter.zero[{axis}]": float(one) for axis, one in zip(AXES, made.errors.zero, strict=True)},
        **{f"sensor.scale_factor[{axis}]": float(one) for axis, one in zip(AXES, made.errors.scale, strict=True)},
    }
    errors = drawn_errors(bench.standards, off)
    return Twin(campaign_text(bench, head, model), files, tuple(truth), drawn, errors=errors)


def saved(bench: Bench, head: Head, made: Record, rng: np.random.Generator) -> Recording:
    """Return the recording of a record: counts of the axes and of their thermometers, or readings in g and degC."""
    stamps = BEGIN * SECOND + np.rint(made.seconds * SECOND).astype(np.int64)
    warm = made.temperature + rng.normal(0.0, THERMOMETER_NOISE, made.readings.shape)
    read = made.readings * np.array(bench.signs)
    table = np.hstack(_counts(bench, head, made.seconds, read, warm) if bench.saved == "count" else (read / G, warm))
    lost = bench.lost or (np.inf, np.inf)
    kept = (made.seconds < lost[0]) | (made.seconds >= lost[1])
    names = [*AXES, *(f"temperature_{axis}" for axis in AXES)]
    channels = tuple(Channel(name, table[kept, i]) for i, name in enumerate(names))
    if bench.gain_recorded:
        over_time = _gains(bench, made.seconds)[kept]
        channels += tuple(Channel(f"gain_{axis}", over_time[:, i].copy()) for i, axis in enumerate(AXES))
    return Recording(channels, stamps[kept], 1.0 / bench.rate, epoch="utc")


def _counts(
    bench: Bench, head: Head, seconds: Array, read: Array, warm: Array
) -> tuple[NDArray[np.int16], NDArray[np.int16]]:
    """Return counts of readings and of temperatures, shape (n, 3) each, as the converter has them: 16 bits."""
    known = chain(bench, head)
    gain = None if bench.gain_change is None else _gains(bench, seconds)
    return to_counts(known, read, gain=gain).astype(np.int16), to_temperature_counts(known, warm).astype(np.int16)


def _gains(bench: Bench, seconds: Array) -> Array:
    """Return the gain of each axis over time, shape (n, 3)."""
    gain = np.tile(np.array(bench.gains), (len(seconds), 1))
    if bench.gain_change is not None:
        when, axis, factor = bench.gain_change
        gain[seconds >= when, AXES.index(axis)] *= factor
    return gain


def draw_model(bench: Bench, head: Head, rng: np.random.Generator) -> Drawing:
    """Return the ground model of a head, errors of bias, of its slope and of the misalignment drawn."""
    own = np.diagonal(head.matrix[0])
    bias = head.bias / own
    bias[0] += rng.normal(0.0, bench.model_ug * UG, 3)
    bias[1] += rng.normal(0.0, bench.model_slope_ug * UG, 3)
    scale = head.scale * own * np.array(SCALE_FACTOR_V_PER_G)
    cross = head.matrix / own[:, None]
    cross[0] += rng.normal(0.0, bench.model_misalignment, (3, 3))
    cross[:, range(3), range(3)] = 0.0
    return Drawing(bias, scale, cross)


def true_values(bench: Bench, head: Head, model: Drawing, made: Record) -> list[TrueValue]:
    """Return what a flip of the corrected head is measured by."""
    away = made.temperature - REFERENCE_TEMPERATURE
    cross = model.cross[0] + model.cross[1] * away.mean(axis=0)[:, None]
    back = np.linalg.inv(np.eye(3) + cross) if bench.ground == "jointly" else np.eye(3) - cross
    bias = back @ (made.bias / np.diagonal(head.matrix[0]))
    error = bias - back @ polynomial(model.bias, away).mean(axis=0)
    found = []
    for names, values in ((("bias", "corrected_bias"), bias), (("model_bias_error", "bias_shift"), error)):
        found += [TrueValue(name, axis, float(values[i]), UNIT) for name in names for i, axis in enumerate(AXES)]
    return found


RIG = Rig("sams_tsh", TITLE, on_bench(build, Bench()), FAULTS, tests=("flip",))
