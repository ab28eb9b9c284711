"""Rig of an IMU without a turntable: laid by hand into one position after another, and turned in between.

``tumble`` lays it into many positions whose orientation nobody knows; ``ferraris`` on its six faces, twice, and turns
it about each axis by a known angle, there and, laid anew, back. The unit has scale factors, misalignments, biases,
g-sensitivity and noise at two levels: of a sample, and between positions. The accelerometers' own axes are the body
where orientations are not known (M lower triangular); a fixture defines it where they are, and M is full.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from ...core.axes import AXES
from ...core.estimate import Array
from ...core.influence import Influence
from ...core.recording import SECOND, Channel, Recording
from ...core.units import factor
from ..protocol import Fault, TrueValue, Twin, drawn_error, with_fault
from .campaign import campaign_text, protocol_file, recording_file
from .motion import Motion, Part, moved
from .protocol import FACES, named_parts, protocol

TITLE = "an IMU laid by hand into many positions, without a turntable"
__all__ = ["FAULTS", "TITLE", "Bench", "Held", "Unit", "build", "draw_unit", "held", "twin"]

BEGIN = 1_272_467_400  # 2010-04-28 15:10:00 UTC [s]
CHANNELS = tuple(f"{sensor}_{axis}" for sensor in ("acc", "gyro") for axis in AXES)
RIG = {"tumble": "hand_held", "ferraris": "six_faces"}
APART = 3_600  # from record to record [s]
UNITS = {"acc": "m/s^2", "gyro": "rad/s"}


@dataclass(frozen=True, eq=False)
class Unit:
    """The unit as it is.

    Parameters
    ----------
    acc_matrix, gyro_matrix : ndarray, shape (3, 3)
        Row: sensor; column: axis of the body [1].
    acc_bias, gyro_bias : ndarray, shape (3,)
        [m/s2], [rad/s]
    g_sensitivity : ndarray, shape (3, 3)
        [(rad/s)/(m/s2)]
    """

    acc_matrix: Array
    gyro_matrix: Array
    acc_bias: Array
    gyro_bias: Array
    g_sensitivity: Array


@dataclass(frozen=True)
class Bench:
    """The test as it is made.

    Parameters
    ----------
    variant : {"tumble", "ferraris"}
        Many positions, or six faces and three turns.
    positions : int
        Of a tumble.
    rounds : int
        How often each of six faces is laid, and each turn made, there and back.
    records : int
        Recordings; of several the last is held out.
    first, dwell, turn : float
        The first position, the others at least, and a turn at least [s]; up to half as long again.
    sample_rate : float
        [Hz]
    spread : float
        Scatter of an orientation about the one that was meant: of a hand, or of a face that is not square [rad].
    lift : float
        Acceleration while the unit is moved [m/s2].
    acc_noise, gyro_noise : float
        Of a sample [m/s2], [rad/s].
    acc_between, gyro_between : float
        Between positions [m/s2], [rad/s].
    scale, misalignment : float
        Sizes of the unit's errors, from unit to unit [1], [rad].
    acc_bias, gyro_bias, g_sensitivity : float
        The same [m/s2], [rad/s], [(rad/s)/(m/s2)].
    latitude, gravity : float
        Of the site [rad]; as it is told [m/s2].
    gravity_error, angle, orientation, mounting, clock : Influence
        Uncertainties of local gravity, of a known turn, of a face, of all faces and turns alike, of the logger's clock.
    wiring : tuple of str
        Which gyro each channel of the gyros holds.
    sign : tuple of int
        Sign of each of these channels.
    flat : bool
        Whether all positions have the z axis level.
    knocked : bool
        Whether the table is knocked in one position; of six faces, on one of them.
    left_out : str
        Face on which it is never laid: ``"y-"``.
    misnamed : bool
        Whether two faces are written down for one another.
    sense : int
        Sign of the angles that are written down of turns.
    said : mapping
        Unit that a sensor is truly recorded in, where it is not the one that is said.
    pace : float
        Stamps are this much closer than the samples.
    copies : int
        How often the same record is handed over.
    """

    variant: Literal["tumble", "ferraris"] = "tumble"
    positions: int = 26
    rounds: int = 2
    records: int = 2
    first: float = 20.0
    dwell: float = 5.0
    turn: float = 1.6
    sample_rate: float = 100.0
    spread: float = 0.15
    lift: float = 2.0
    acc_noise: float = 0.02
    gyro_noise: float = 2e-3
    acc_between: float = 1e-3
    gyro_between: float = 1e-4
    scale: float = 0.01
    misalignment: float = 0.01
    acc_bias: float = 0.2
    gyro_bias: float = 0.01
    g_sensitivity: float = 1.5e-4
    latitude: float = 0.8
    gravity: float = 9.807
    gravity_error: Influence = field(default=Influence(3e-4, "m/s^2", certificate="gravity map"))
    angle: Influence = field(default=Influence(2e-3, "rad", certificate="square block"))
    orientation: Influence = field(default=Influence(2e-3, "rad", certificate="square block"))
    mounting: Influence = field(default=Influence(1e-3, "rad", certificate="square block"))
    clock: Influence = field(default=Influence(2e-5, "1", certificate="data sheet of the logger"))
    wiring: tuple[str, str, str] = AXES
    sign: tuple[int, int, int] = (1, 1, 1)
    flat: bool = False
    knocked: bool = False
    left_out: str = ""
    misnamed: bool = False
    sense: int = 1
    said: Mapping[str, str] = field(default_factory=dict)
    pace: float = 1.0
    copies: int = 1


FAULTS: dict[str, Fault] = {
    "few_positions": Fault("three positions are too few", "too_few_positions", {"positions": 3}),
    "one_plane": Fault("the z axis was level in all positions", "one_plane", {"flat": True, "spread": 0.0}),
    "knocked": Fault("the table was knocked in one position", "disturbed_position", {"knocked": True}),
    "acc_in_g": Fault("the accelerometers read in g, and m/s2 is said", "unit_slip", {"said": {"acc": "g"}}),
    "gyro_in_deg": Fault("the gyros read in deg/s, and rad/s is said", "unit_slip", {"said": {"gyro": "deg/s"}}),
    "swapped_axes": Fault("gyros x and y have changed places", "axes_disagree", {"wiring": ("y", "x", "z")}),
    "inverted_axis": Fault("the z gyro has the wrong sign", "axes_disagree", {"sign": (1, 1, -1)}),
    "compressed_time": Fault("the stamps run half as fast", "sample_rate_suspect", {"pace": 0.5}),
    "identical": Fault("one record is handed over as two", "duplicate_recording", {"copies": 2}),
}


@dataclass(frozen=True, eq=False)
class Held:
    """A record with what lies behind it.

    Parameters
    ----------
    recording : Recording
        Channels ``acc_x`` ... ``gyro_z``.
    motion : Motion
        True inputs.
    parts : tuple of Part
        What a protocol would say: positions and turns as they were meant.
    """

    recording: Recording
    motion: Motion
    parts: tuple[Part, ...]


def twin(seed: int, fault: str = "") -> Twin:
    """Return the campaign of a seed, with one mistake in it if asked.

    Raises
    ------
    UsageError
        If there is no mistake of that name.
    """
    return with_fault(build, Bench(), FAULTS, seed, fault)


def build(bench: Bench, seed: int) -> Twin:
    """Return the campaign that a bench gives.

    Parameters
    ----------
    bench : Bench
        The test as it is made.
    seed : int
        Of all draws.
    """
    of_unit, of_bench, of_records = np.random.default_rng(seed).spawn(3)
    unit = draw_unit(bench, of_unit)
    gravity = bench.gravity + drawn_error(bench.gravity_error, of_bench)
    pace = bench.pace * (1.0 + drawn_error(bench.clock, of_bench))
    drawn: dict[str, float | list[float]] = {"gravity": gravity, "clock": pace}
    mounting = np.zeros(3)
    if bench.variant == "ferraris":
        mounting = np.array([drawn_error(bench.mounting, of_bench) for _ in AXES])
        drawn["mounting"] = mounting.tolist()
    records = [held(bench, unit, gravity, pace, number, of_records, mounting) for number in range(bench.records)]
    lots = [one.recording for one in records for _ in range(bench.copies)]
    files = {recording_file(number): recording for number, recording in enumerate(lots, 1)}
    text = campaign_text(bench, RIG[bench.variant], len(lots))
    protocols = {}
    if bench.variant == "ferraris":
        named = [named_parts(one.parts) for one in records for _ in range(bench.copies)]
        protocols = {protocol_file(number): one for number, one in enumerate(named, 1)}
    return Twin(RIG[bench.variant], seed, "", text, files, true_values(bench, unit), drawn, protocols=protocols)


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


def held(
    bench: Bench,
    unit: Unit,
    gravity: float,
    pace: float,
    number: int,
    rng: np.random.Generator,
    mounting: Array | None = None,
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
    """
    up, legs, meant = protocol(bench, np.zeros(3) if mounting is None else mounting, rng)
    lifts = bench.lift * rng.normal(size=(len(legs), 3)) / np.sqrt(3.0)
    motion = moved(legs, up, 1.0 / bench.sample_rate, gravity, bench.latitude, lifts)
    readings = _readings(bench, unit, motion, rng)
    stamps = BEGIN + number * APART + np.arange(1, len(readings) + 1) * pace / bench.sample_rate
    interval = pace / bench.sample_rate
    channels = tuple(
        Channel(name, np.ascontiguousarray(readings[:, k]), UNITS[name[:-2]], "campaign", name[-1], name[:-2])
        for k, name in enumerate(CHANNELS)
    )
    time = np.rint(stamps * 1e6).astype(np.int64) * (SECOND // 1_000_000)
    recording = Recording(channels, time, interval, interval, "utc", "time column 'unix_s'")
    return Held(recording, motion, _as_meant(motion.parts, meant))


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


def _readings(bench: Bench, unit: Unit, motion: Motion, rng: np.random.Generator) -> Array:
    """Return what is saved, shape (n, 6)."""
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
    return np.round(np.hstack([acc, gyro]), 7)


def _middle(part: Part) -> tuple[int, int]:
    """Return a fifth of a position, in its middle."""
    length = part.stop - part.start
    return part.start + 2 * length // 5, part.start + 3 * length // 5


def true_values(bench: Bench, unit: Unit) -> tuple[TrueValue, ...]:
    """Return the unit as the results name it, SI; the test is named by the kind of sensor."""
    lower = bench.variant == "tumble"
    found = [
        *_linear("accelerometer", unit.acc_matrix, unit.acc_bias, "m/s^2", lower),
        *_linear("gyro", unit.gyro_matrix, unit.gyro_bias, "rad/s", False),
    ]
    found += [
        TrueValue("g_sensitivity", a + f, float(unit.g_sensitivity[i, j]), "rad/s/(m/s^2)", "gyro")
        for i, a in enumerate(AXES)
        for j, f in enumerate(AXES)
    ]
    return tuple(found)


def _linear(kind: str, matrix: Array, bias: Array, unit: str, lower: bool) -> list[TrueValue]:
    """Return scale factor errors, misalignments and biases of three sensors."""
    own = np.diag(matrix)
    pairs = [(i, j) for i in range(3) for j in range(3) if i > j or (i < j and not lower)]
    cross = [(AXES[i] + AXES[j], float(matrix[i, j] / own[i])) for i, j in pairs]
    return [
        *(TrueValue("scale_factor_error", a, float(own[i] - 1.0), "1", kind) for i, a in enumerate(AXES)),
        *(TrueValue("misalignment", pair, value, "rad", kind) for pair, value in cross),
        *(TrueValue("bias", a, float(bias[i]), unit, kind) for i, a in enumerate(AXES)),
    ]
