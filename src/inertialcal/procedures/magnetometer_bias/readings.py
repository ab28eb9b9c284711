"""Readings of a gyro and a magnetometer in orbit, with the field of the earth along it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import reduce
from pathlib import Path

import numpy as np

from ...core.errors import DataError, UsageError
from ...core.estimate import Array
from ...core.key import AXES, Origin
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark
from ...core.show.rounding import number, uncertainty
from ...core.unknowns import Unknowns, joined
from ...files.source import load
from ...physics.elements import Elements, age_text, chosen, parse_elements, track_by
from ...physics.geomagnetic import earth_fixed, field_along
from ..corrections import MatrixCorrection, between, corrected
from ..protocol import Correction
from .entry import Tle

FIELD = tuple(f"magnetometer_{axis}" for axis in AXES)
POSITION = tuple(f"position_{axis}" for axis in AXES)
GEODETIC = ("latitude", "longitude", "height")
FEWEST = 100  # readings of the field
BLOCK = 60.0  # of a record, over which a bias that was taken off is one [s]
STEP = 1e3  # of a position, by which its change of the field is taken [m]
FASTEST = 0.3  # turn between two samples [rad], beyond which mean rates no longer say how the body turned


@dataclass(frozen=True, eq=False)
class TakenOff:
    """What earlier tests have taken off the rates of one recording, block by block."""

    starts: Array = field(default_factory=lambda: np.zeros(0))  # shape (m,): of the blocks [s]
    unknowns: Mapping[Origin, Unknowns] = field(default_factory=dict["Origin", "Unknowns"])  # of a bias
    of_matrix: Mapping[Origin, Unknowns] = field(default_factory=dict["Origin", "Unknowns"])


NOTHING = TakenOff()


@dataclass(frozen=True, eq=False)
class Orbit:
    """An orbit by elements, and what is not known of it."""

    moved: Array  # shape (n, 3, 3): change of the field by one standard uncertainty along, across the orbit, up [T]
    late: float  # standard uncertainty of the position along the orbit, as time [s]
    elements: Elements
    remark: Remark


@dataclass(frozen=True, eq=False)
class Track:
    """One recording."""

    times: Array  # shape (n,): since the first sample [s]
    rates: Array  # shape (n, 3): gyro, NaN where missing [rad/s]
    field: Array  # shape (n, 3): magnetometer, NaN where missing [T]
    reference: Array  # shape (n, 3): field of the earth in axes that do not turn [T]
    interval: float  # [s]
    name: str = ""
    file: str = ""
    orbit: Orbit | None = None  # where it is by elements
    taken_off: TakenOff = NOTHING  # by earlier tests


@dataclass(frozen=True, eq=False)
class Readings:
    """All recordings of a test."""

    tracks: tuple[Track, ...]
    remarks: tuple[Remark, ...] = ()
    matrix: MatrixCorrection | None = None  # that was taken off the rates

    def __len__(self) -> int:
        """Return the number of samples."""
        return sum(len(one.times) for one in self.tracks)

    @property
    def runs(self) -> int:
        """Number of recordings."""
        return len(self.tracks)


def sets_of(tracks: Sequence[Track]) -> list[Elements]:
    """Return the sets of elements that recordings rest on, each once."""
    return list(dict.fromkeys(one.orbit.elements for one in tracks if one.orbit is not None))


def matrix_of(corrections: Sequence[Correction]) -> MatrixCorrection | None:
    """Return what tests found of the matrix of the gyro, all in one.

    Raises
    ------
    DataError
        ``terms_twice`` if two found the same.
    """
    found = [one for one in corrections if isinstance(one, MatrixCorrection)]
    return reduce(MatrixCorrection.joined, found) if found else None


def after(
    recording: Recording, name: str, corrections: Sequence[Correction], matrix: MatrixCorrection | None
) -> tuple[Recording, TakenOff]:
    """Return a recording with rates after earlier tests: less the bias that one found, through the inverse of a matrix.

    A bias over temperature changes along the record, and so does what is not known of it: by blocks.

    Raises
    ------
    DataError
        As the corrections say.
    """
    if not corrections:
        return recording, TakenOff()
    biases = [one for one in corrections if not isinstance(one, MatrixCorrection)]
    (made,), _ = corrected(biases, [(name, recording)])
    starts, parts = [], []
    if biases and recording.time_ns is not None:
        there = np.isfinite(made.array([axis for axis in AXES if axis in made.names])).all(axis=1)
        first = int(recording.time_ns[0])
        block = (recording.time_ns - first) // round(BLOCK * SECOND)
        for k in np.unique(block[there]).tolist():
            low = first + k * round(BLOCK * SECOND)
            _, (unknowns,) = corrected(biases, [(name, between(recording, low, low + round(BLOCK * SECOND) - 1))])
            starts.append(k * BLOCK)
            parts.append(unknowns)
    own: Mapping[Origin, Unknowns] = {}
    if matrix is not None:
        (made,), (own,) = matrix.apply([(name, made)])
    return made, TakenOff(np.array(starts), joined(parts, [1] * len(parts)), own)


def read_elements(path: str | Path) -> tuple[Elements, ...]:
    """Return all sets of a file of two-line elements.

    Raises
    ------
    DataError
        As ``physics.elements.parse_elements``; if it cannot be read.
    """
    return parse_elements(load(path).data.decode("latin-1"), str(path))


def track(
    recording: Recording,
    name: str,
    file: str,
    epoch: str | None,
    elements: tuple[Sequence[Elements], Tle] | None = None,
) -> Track:
    """Return one recording with the field of the earth along it.

    Raises
    ------
    DataError
        ``no_magnetometer``, ``no_position``, ``no_time``, ``no_date``, ``too_short``, ``sample_rate``, ``wrong_unit``;
        as ``physics.geomagnetic.field_along``, ``physics.elements.track_by``.
    """
    for needed, code in ((FIELD, "no_magnetometer"), (AXES, "no_axes")):
        if missing := [one for one in needed if one not in recording.names]:
            what = f"recordings.{name}: no channel {', '.join(missing)}"
            raise DataError(what, file, "all three axes of both triads are needed", code=code)
    fixed = all(one in recording.names for one in POSITION)
    if elements is None and not fixed and not all(one in recording.names for one in GEODETIC):
        do = "Give the channels latitude, longitude and height, or position_x, position_y, position_z (earth-fixed); "
        do += "or two-line elements of the orbit"
        raise DataError(f"recordings.{name}: where the spacecraft was is not given", file, do=do, code="no_position")
    if recording.time_ns is None or len(recording) < 2:
        why = "where the spacecraft was, and how it turned, are told by time"
        raise DataError(f"recordings.{name}: no time", file, why, "Record the time of each sample", "no_time")
    times = (recording.time_ns - recording.time_ns[0]) / SECOND
    orbit = None
    if elements is not None:
        start = int(recording.time_ns[0]) if recording.epoch == "utc" else _instant(epoch, name, file, clock=True)
        position, orbit = _by_elements(elements, times, start, name, file)
    else:
        start = int(recording.time_ns[0]) if recording.epoch == "utc" else _instant(epoch, name, file)
        place = recording.array(POSITION if fixed else GEODETIC)
        position = place if fixed else earth_fixed(*place.T)
    known = np.isfinite(position).all(axis=1)
    rates, magnetic = recording.array(AXES), recording.array(FIELD)
    read = np.isfinite(magnetic).all(axis=1) & known
    if np.count_nonzero(read) < FEWEST:
        what = f"recordings.{name}: {int(np.count_nonzero(read))} readings of field and position, need {FEWEST}"
        raise DataError(what, file, do="Record longer", code="too_short")
    reference = np.full(rates.shape, np.nan)
    reference[known] = field_along(times[known], position[known], start, file)
    magnetic[~read] = np.nan
    interval = float(recording.sample_interval or np.median(np.diff(times)))
    one = Track(times, rates, magnetic, reference, interval, name, file, orbit)
    _check(one)
    return one


def _by_elements(
    elements: tuple[Sequence[Elements], Tle], times: Array, start: int, name: str, file: str
) -> tuple[Array, Orbit]:
    """Return earth-fixed positions by elements, and how far the field is off where these are."""
    sets, said = elements
    one = chosen(sets, said.satellite, start + round(0.5 * float(times[-1]) * SECOND))
    found = track_by(one, times, start)
    own = field_along(times, found.position, start, file)
    moved = np.stack([
        (field_along(times, found.position + STEP * found.directions[:, :, k], start, file) - own) * found.u[k] / STEP
        for k in range(3)
    ], axis=2)  # fmt: skip
    size = float(np.sqrt(np.mean(np.sum(moved**2, axis=(1, 2)))))
    what = f"position of {name} by elements of {one.called}, {age_text(found.age)} from their epoch at most: known to "
    what += f"{uncertainty(found.u[0] * 1e-3)} km along the orbit, {uncertainty(found.u[1] * 1e-3)} km across it: "
    what += f"{uncertainty(size * 1e9)} nT in the field"
    do = "Elements of the day, or recorded positions, are better" if abs(found.age) > 1.0 else ""
    remark = Remark("orbit_by_elements", "info", what, one.where, do=do, recording=name)
    return found.position, Orbit(moved, float(found.u[0]) / found.speed, one, remark)


def _instant(epoch: str | None, name: str, file: str, clock: bool = False) -> int:
    if epoch is not None and clock and len(epoch.strip()) <= len("2026-03-01"):
        what = f"recordings.{name}: {epoch} is a date without the time of day"
        do = "Give the instant of the first sample, with its time of day"
        raise DataError(what, file, "a satellite moves by 7.6 km a second", do, "no_date")
    if epoch is None:
        what = f"recordings.{name}: times count from no known date"
        do = 'Give the date of the first sample: --epoch "2026-03-01", or mission_start'
        raise DataError(what, file, "the field of the earth changes by some 100 nT a year", do, "no_date")
    try:
        when = datetime.fromisoformat(epoch)
    except ValueError:
        raise UsageError(f"epoch {epoch!r} is no date", do='Write it like "2026-03-01"', code="wrong_value") from None
    return int((when if when.tzinfo else when.replace(tzinfo=UTC)).timestamp() * SECOND)


def _check(one: Track) -> None:
    """Refuse units that cannot be, and turns that are too fast for the sample rate."""
    ratio = float(np.nanmedian(np.linalg.norm(one.field, axis=1)) / np.nanmedian(np.linalg.norm(one.reference, axis=1)))
    if not 0.5 < ratio < 2.0:
        what = f"recordings.{one.name}: the magnetometer reads {number(ratio, 3)} times the field of the earth there"
        raise DataError(what, one.file, do="Check its unit, and columns and units of the position", code="wrong_unit")
    turn = float(np.nanpercentile(np.linalg.norm(one.rates, axis=1), 99.0)) * one.interval
    if turn > FASTEST:
        what = f"recordings.{one.name}: the body turns by {number(np.degrees(turn), 3)} deg from sample to sample"
        do = "Record faster, or while the body turns more slowly; or check the unit of the rates"
        raise DataError(what, one.file, "how it turned in between is not known", do, "sample_rate")
