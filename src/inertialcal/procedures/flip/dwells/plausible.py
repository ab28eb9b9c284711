"""What no accelerometer reads, and no clock tells: numbers that bit errors and wrong columns leave in a recording."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....core.axes import AXES
from ....core.errors import DataError
from ....core.recording import SECOND, Recording
from ....core.remarks import Remark

LARGEST = 1e6  # [m/s^2], far beyond what any accelerometer takes


def is_reading(value: float) -> bool:
    """Whether a number [m/s^2] can be a reading, or is missing (NaN)."""
    return math.isnan(value) or abs(value) <= LARGEST


def readable(recording: Recording) -> Recording:
    """Return the recording with samples of its axes that are no readings as missing, counted in a remark.

    Parameters
    ----------
    recording : Recording
        Channels ``x``, ``y``, ``z`` [m/s^2], as far as they are there.

    Raises
    ------
    DataError
        ``time_goes_back`` if a stamp is earlier than the one before: windows could not be placed.
    """
    _check_time(recording)
    channels, remarks = [], []
    for channel in recording.channels:
        data = channel.data
        if channel.name in AXES and _reaches_beyond(data):
            out = np.abs(data) > LARGEST
            first = int(np.argmax(out))
            what = f"{channel.name}: sample {first + 1} reads {data[first]:.3g} m/s^2, which no accelerometer does"
            do = "They were left out. Look where the file is damaged, or whether this is the right column"
            where = recording.source.path
            remarks.append(Remark("no_reading", "warning", what, where, count=int(np.count_nonzero(out)), do=do))
            channels.append(replace(channel, data=np.where(out, np.nan, data)))
        else:
            channels.append(channel)
    if not remarks:
        return recording
    return replace(recording, channels=tuple(channels), remarks=(*recording.remarks, *remarks))


def _check_time(recording: Recording) -> None:
    time_ns = recording.time_ns
    if time_ns is None or not len(time_ns):
        return
    goes = time_ns[1:] >= time_ns[:-1]
    if not goes.all():
        first = int(np.argmin(goes))
        back = float(time_ns[first] - time_ns[first + 1]) / SECOND
        where = recording.source.path
        where = f"{where}:{recording.first_row + first + 1}" if recording.first_row else f"{where}: sample {first + 2}"
        what = f"the time goes back by {back:.6g} s (steps back in all: {int(np.count_nonzero(~goes))})"
        do = "Mend the stamp, or sort the rows if they are out of order"
        raise DataError(what, where, "windows cannot be placed on such a clock", do, "time_goes_back")


def _reaches_beyond(data: NDArray[Any]) -> bool:
    """Whether a sample is beyond; without a copy of a day's samples."""
    return len(data) > 0 and bool(np.fmax.reduce(data) > LARGEST or np.fmin.reduce(data) < -LARGEST)
