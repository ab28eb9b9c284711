"""Rig of an IMU without a turntable: laid by hand into one position after another, and turned in between.

``tumble`` lays it into many positions whose orientation nobody knows; ``ferraris`` on its six faces, twice, and turns
it about each axis by a known angle, there and, laid anew, back. The unit has scale factors, misalignments, biases,
g-sensitivity and noise at two levels: of a sample, and between positions. The accelerometers' own axes are the body
where orientations are not known (M lower triangular); a fixture defines it where they are, and M is full.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...core.estimate import Array
from ...core.key import AXES
from ...core.labelled import labelled_csv
from ...core.recording import SECOND, Channel, Recording
from ...core.units import factor
from ..parts.campaign import drawn_error, drawn_errors
from ..protocol import Rig, on_bench
from ..twin import Extra, Fault, TrueValue, Twin
from . import TITLE
from .campaign import TEMPERATURE, campaign_text, protocol_file, recording_file
from .motion import FACES, Motion, Part, labelled_parts, moved, sequence
from .setup import Bench, Unit

__all__ = ["FAULTS", "RIG", "Bench", "Held", "Unit", "build", "draw_unit", "drawn_faces", "held"]

BEGIN = 1_272_467_400  # 2010-04-28 15:10:00 UTC [s]
APART = 3_600  # from record to record [s]
UNITS = {"acc": "m/s^2", "gyro": "rad/s"}
SENSOR_AXES = tuple((sensor, axis) for sensor in UNITS for axis in AXES)
THERMOMETER_NOISE = 0.02  # of a sample [degC]
CHANNELS = tuple(f"{sensor}_{axis}" for sensor, axis in SENSOR_AXES)


FAULTS: dict[str, Fault] = {
    "few_positions": Fault("three positions only", "too_few_positions", {"positions": 3}),
    "one_plane": Fault("the z axis was level in all positions", "one_plane", {"flat": True, "spread": 0.0}),
    "knocked": Fault("the table was knocked in one position", "disturbed_position", {"knocked": True}),
    "acc_in_g": Fault("accelerometers recorded in g, stated as m/s2", "unit_slip", {"said": {"acc": "g"}}),
    "gyro_in_deg": Fault("gyros recorded in deg/s, stated as rad/s", "unit_slip", {"said": {"gyro": "deg/s"}}),
    "swapped_axes": Fault("gyros x and y are exchanged", "axes_disagree", {"wiring": ("y", "x", "z")}),
    "inverted_axis": Fault("the z gyro has the wrong sign", "axes_disagree", {"sign": (1, 1, -1)}),
    "compressed_time": Fault("time stamps run at half speed", "sample_rate_suspect", {"pace": 0.5}),
    "identical": Fault("one recording is given twice", "duplicate_recording", {"copies": 2}),
}


@dataclass(frozen=True, eq=False)
class Held:
    """A record with what lies behind it."""

    recording: Recording  # channels ``acc_x`` ... ``gyro_z``.
    motion: Motion  # true inputs
    parts: tuple[Part, ...]  # content of a protocol: positions and turns as intended
    shift: Array  # shape (3,): what positions add to the bias of the gyros, as the mean over the rests [rad/s]


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The test as it is made.
    seed : int
        Of all draws.
    """
    of_unit, of_bench, of_records, of_heat = np.random.default_rng(seed).spawn(4)
    unit = draw_unit(bench, of_unit)
    if bench.temperatures:
        unit = _over_temperature(bench, unit, of_heat)
    gravity = bench.gravity + drawn_error(bench.gravity_error, of_bench)
    pace = bench.pace * (1.0 + drawn_error(bench.clock, of_bench))
    drawn: dict[str, float | list[float]] = {"gravity": gravity, "clock": pace}
    mounting, faces = np.zeros(3), np.zeros((6, 3))
    if bench.variant == "ferraris":
        mounting = np.array([drawn_error(bench.mounting, of_bench) for _ in AXES])
        drawn["mounting"] = mounting.tolist()
        faces = drawn_faces(bench, of_bench)
        drawn["faces"] = faces.ravel().tolist()
    offset = drawn_error(bench.thermometer, of_heat) if bench.temperatures else 0.0
    records = [
        held(bench, _unit_in(bench, unit, number), gravity, pace, number, of_records, mounting, faces)
        for number in range(bench.laid)
    ]
    if bench.temperatures:
        drawn["thermometer"] = offset
        records = [_read_by(one, T + offset, of_heat) for one, T in zip(records, bench.temperatures, strict=True)]
    lots = [one.recording for one in records for _ in range(bench.copies)]
    files = {recording_file(number): recording for number, recording in enumerate(lots, 1)}
    text = campaign_text(bench, len(lots))
    protocols = {}
    if bench.variant == "ferraris":
        named = [labelled_parts(one.parts) for one in records for _ in range(bench.copies)]
        protocols = {protocol_file(number): Extra(one, labelled_csv(one)) for number, one in enumerate(named, 1)}
    standards = {"gravity.value": bench.gravity_error, "clock.rate": bench.clock}
    off = {"gravity.value": bench.gravity - gravity, "clock.rate": pace / bench.pace - 1.0}
    if bench.temperatures:
        standards["thermometer.temperature"], off["thermometer.temperature"] = bench.thermometer, offset
    truth = tuple(one for true in true_values(bench, unit) for one in _of_tests(bench, true, records))
    return Twin(text, files, truth, drawn, protocols, drawn_errors(standards, off))


def _of_tests(bench: Bench, true: TrueValue, records: Sequence[Held]) -> list[TrueValue]:
    """Return the bias of the gyros in each test, that of a next record as the test held out has it, and all others."""
    if (true.sensor, true.quantity) != ("gyro", "bias"):
        return [true]
    k, apart = AXES.index(true.axis), bench.apart
    tests = {"imu": records[:-apart], "imu_held_out": records[-apart:]} if apart else {"imu": records}
    found = [
        replace(true, value=true.value + float(np.mean([one.shift[k] for one in own])), test=test)
        for test, own in tests.items()
    ]
    return [*found, replace(found[-1], quantity="bias_next_record", test="imu")] if apart else found


def drawn_faces(bench: Bench, rng: np.random.Generator) -> Array:
    """Return the rotations by which the faces are off at every use, shape (6, 3) [rad]."""
    return np.array([[drawn_error(bench.orientation, rng) for _ in AXES] for _ in FACES])


def draw_unit(bench: Bench, rng: np.random.Generator) -> Unit:
    """Return a unit with errors of the sizes of the bench."""

    def matrix() -> Array:
        scale = 1.0 + bench.scale * rng.normal(size=3)
        cross = bench.misalignment * rng.normal(size=(3, 3))
        np.fill_diagonal(cross, 1.0)
        return np.asarray(scale[:, np.newaxis] * cross)

    acc = matrix()
    return Unit(
        np.tril(acc) if bench.variant == "tumble" else acc,
        matrix(),
        bench.acc_bias * rng.normal(size=3),
        bench.gyro_bias * rng.normal(size=3),
        bench.g_sensitivity * rng.normal(size=(3, 3)),
    )


def _over_temperature(bench: Bench, unit: Unit, rng: np.random.Generator) -> Unit:
    """Return a unit whose accelerometers change with temperature."""
    matrix = bench.matrix_slope * rng.normal(size=(3, 3))
    return replace(unit, acc_matrix_slope=matrix, acc_bias_slope=bench.bias_slope * rng.normal(size=3))


def _unit_in(bench: Bench, unit: Unit, number: int) -> Unit:
    """Return the unit as it is at the temperature of a record, counted from 0."""
    if not bench.temperatures:
        return unit
    away = bench.temperatures[number] - bench.reference_temperature
    matrix = unit.acc_matrix + away * unit.acc_matrix_slope
    return replace(unit, acc_matrix=matrix, acc_bias=unit.acc_bias + away * unit.acc_bias_slope)


def _read_by(one: Held, level: float, rng: np.random.Generator) -> Held:
    """Return a record with the channel of a thermometer that reads a level [degC]."""
    data = np.round(level + THERMOMETER_NOISE * rng.normal(size=len(one.recording)), 3)
    channel = Channel(TEMPERATURE, data, "degC", "campaign")
    return replace(one, recording=replace(one.recording, channels=(*one.recording.channels, channel)))


def held(
    bench: Bench,
    unit: Unit,
    gravity: float,
    pace: float,
    number: int,
    rng: np.random.Generator,
    mounting: Array | None = None,
    faces: Array | None = None,
) -> Held:
    """Return one record.

    Parameters
    ----------
    gravity : float
        As it is [m/s2].
    pace : float
        Stamps over true time.
    number : int
        Of the record, from 0.
    mounting : ndarray, shape (3,), optional
        By which all faces and turns are off alike [rad]; absent: not at all.
    faces : ndarray, shape (6, 3), optional
        By which each face is off at every use [rad]; absent: drawn for this record.
    """
    off = faces
    if off is None:
        off = drawn_faces(bench, rng) if bench.variant == "ferraris" else np.zeros((len(FACES), 3))
    up, legs, meant = sequence(bench, np.zeros(3) if mounting is None else mounting, off, rng)
    lifts = bench.lift * rng.normal(size=(len(legs), 3)) / np.sqrt(3.0)
    motion = moved(legs, up, 1.0 / bench.sample_rate, gravity, bench.latitude, lifts)
    readings, shift = _readings(bench, unit, motion, rng)
    stamps = BEGIN + number * APART + np.arange(1, len(readings) + 1) * pace / bench.sample_rate
    interval = pace / bench.sample_rate
    channels = tuple(
        Channel(CHANNELS[k], np.ascontiguousarray(readings[:, k]), UNITS[sensor], "campaign", axis, sensor)
        for k, (sensor, axis) in enumerate(SENSOR_AXES)
    )
    time = np.rint(stamps * 1e6).astype(np.int64) * (SECOND // 1_000_000)
    recording = Recording(channels, time, interval, interval, "utc", "column", time_column="unix_s")
    return Held(recording, motion, _as_meant(motion.parts, meant), shift)


def _as_meant(parts: tuple[Part, ...], meant: Mapping[int, tuple[float, float, float]]) -> tuple[Part, ...]:
    """Return the parts with the directions that a protocol names, by the number of the position."""
    found, number = [], 0
    for part in parts:
        if part.angle is not None:
            found.append(part)
            continue
        found.append(replace(part, direction=meant.get(number)))
        number += 1
    return tuple(found)


def _readings(bench: Bench, unit: Unit, motion: Motion, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return what is saved, shape (n, 6), and what positions add to the gyros, as the mean over the rests."""
    n, places = len(motion.rate), int(motion.place.max()) + 1
    shift_a = bench.acc_between * rng.normal(size=(places, 3))
    shift_g = bench.gyro_between * rng.normal(size=(places, 3))
    acc = motion.force @ unit.acc_matrix.T + unit.acc_bias + shift_a[motion.place]
    gyro = motion.rate @ unit.gyro_matrix.T + unit.gyro_bias + shift_g[motion.place]
    gyro += motion.force @ unit.g_sensitivity.T
    if bench.knocked:
        laid = len(FACES) * bench.rounds if bench.variant == "ferraris" else len(motion.parts)
        start, stop = _middle(motion.parts[laid // 2])
        swing = np.sin(np.arange(stop - start) * 0.9)[:, np.newaxis] * [0.6, -0.4, 0.3]
        acc[start:stop] += swing
        gyro[start:stop] += 0.2 * swing
    acc = acc + bench.acc_noise * rng.normal(size=(n, 3))
    gyro = gyro + bench.gyro_noise * rng.normal(size=(n, 3))
    gyro = gyro[:, [AXES.index(axis) for axis in bench.wiring]] * np.array(bench.sign)
    acc = acc * factor(UNITS["acc"], bench.said.get("acc", UNITS["acc"]))
    gyro = gyro * factor(UNITS["gyro"], bench.said.get("gyro", UNITS["gyro"]))
    rests = [one for one in motion.parts if one.angle is None]
    shift = np.average([shift_g[motion.place[one.start]] for one in rests], axis=0,
                       weights=[one.stop - one.start for one in rests])  # fmt: skip
    return np.round(np.hstack([acc, gyro]), 7), np.asarray(shift)


def _middle(part: Part) -> tuple[int, int]:
    """Return a fifth of a position, in its middle."""
    length = part.stop - part.start
    return part.start + 2 * length // 5, part.start + 3 * length // 5


def true_values(bench: Bench, unit: Unit) -> tuple[TrueValue, ...]:
    """Return the unit as the results name it, SI; the condition is the kind of sensor."""
    pairs = [(i, j) for i in range(3) for j in range(3) if i != j]
    below = [(i, j) for i, j in pairs if i > j]
    found = []
    for kind, matrix, bias, bias_unit, cross in (
        ("accelerometer", unit.acc_matrix, unit.acc_bias, "m/s^2", below if bench.variant == "tumble" else pairs),
        ("gyro", unit.gyro_matrix, unit.gyro_bias, "rad/s", pairs),
    ):
        own = np.diag(matrix)
        found += [
            *(TrueValue("scale_factor_error", a, float(own[i] - 1.0), "1", "", kind) for i, a in enumerate(AXES)),
            *(
                TrueValue("misalignment", AXES[i] + AXES[j], float(matrix[i, j] / own[i]), "rad", "", kind)
                for i, j in cross
            ),
            *(TrueValue("bias", a, float(bias[i]), bias_unit, "", kind) for i, a in enumerate(AXES)),
        ]
    if bench.temperatures:
        slope = unit.acc_matrix_slope
        for i, a in enumerate(AXES):
            own_bias = float(unit.acc_bias_slope[i])
            found.append(TrueValue("bias_temperature", a, own_bias, "m/s^2/degC", "", "accelerometer", 1))
            for j, other in enumerate(AXES):
                quantity = "scale_factor_error_temperature" if i == j else "cross_axis_sensitivity_temperature"
                axes = a if i == j else a + other
                found.append(TrueValue(quantity, axes, float(slope[i, j]), "1/degC", "", "accelerometer", 1))
    g = unit.g_sensitivity
    return (
        *found,
        *(
            TrueValue("g_sensitivity", AXES[i] + AXES[j], float(g[i, j]), "rad/s/(m/s^2)", "", "gyro")
            for i in range(3)
            for j in range(3)
        ),
    )


RIG = Rig("hand_held", TITLE, on_bench(build, Bench()), FAULTS, tests=("positions",))
