"""Readings of a gyro and a magnetometer in orbit, with the field of the earth along it."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from ...core.errors import DataError, UsageError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...physics.geomagnetic import earth_fixed, field_along

FIELD = tuple(f"magnetometer_{axis}" for axis in AXES)
POSITION = tuple(f"position_{axis}" for axis in AXES)
GEODETIC = ("latitude", "longitude", "height")
FEWEST = 100  # readings of the field
FASTEST = 0.3  # turn between two samples [rad], beyond which mean rates no longer say how the body turned


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


@dataclass(frozen=True, eq=False)
class Readings:
    """All recordings of a test."""

    tracks: tuple[Track, ...]
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of samples."""
        return sum(len(one.times) for one in self.tracks)

    @property
    def runs(self) -> int:
        """Number of recordings."""
        return len(self.tracks)


def track(recording: Recording, name: str, file: str, epoch: str | None) -> Track:
    """Return one recording with the field of the earth along it.

    Raises
    ------
    DataError
        ``no_magnetometer``, ``no_position``, ``no_time``, ``no_date``, ``too_short``, ``sample_rate``, ``wrong_unit``;
        as ``physics.geomagnetic.field_along``.
    """
    for needed, code in ((FIELD, "no_magnetometer"), (AXES, "no_axes")):
        if missing := [one for one in needed if one not in recording.names]:
            what = f"recordings.{name}: no channel {', '.join(missing)}"
            raise DataError(what, file, "all three axes of both triads are needed", code=code)
    fixed = all(one in recording.names for one in POSITION)
    if not fixed and not all(one in recording.names for one in GEODETIC):
        do = "Give the channels latitude, longitude and height, or position_x, position_y, position_z (earth-fixed)"
        raise DataError(f"recordings.{name}: where the spacecraft was is not given", file, do=do, code="no_position")
    if recording.time_ns is None or len(recording) < 2:
        why = "where the spacecraft was, and how it turned, are told by time"
        raise DataError(f"recordings.{name}: no time", file, why, "Record the time of each sample", "no_time")
    place = recording.array(POSITION if fixed else GEODETIC)
    position = place if fixed else earth_fixed(*place.T)
    times = (recording.time_ns - recording.time_ns[0]) / SECOND
    known = np.isfinite(position).all(axis=1)
    rates, field = recording.array(AXES), recording.array(FIELD)
    read = np.isfinite(field).all(axis=1) & known
    if np.count_nonzero(read) < FEWEST:
        what = f"recordings.{name}: {int(np.count_nonzero(read))} readings of field and position, need {FEWEST}"
        raise DataError(what, file, do="Record longer", code="too_short")
    start = int(recording.time_ns[0]) if recording.epoch == "utc" else _instant(epoch, name, file)
    reference = np.full(rates.shape, np.nan)
    reference[known] = field_along(times[known], position[known], start, file)
    field[~read] = np.nan
    interval = float(recording.sample_interval or np.median(np.diff(times)))
    one = Track(times, rates, field, reference, interval, name, file)
    _check(one)
    return one


def _instant(epoch: str | None, name: str, file: str) -> int:
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
