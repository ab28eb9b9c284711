"""Part of a recording between two times: the start belongs to it, the stop does not."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ...core.errors import DataError, UsageError
from ...core.recording import Recording, Times
from ...core.remarks import Remark
from ...core.times import SECOND, NoMissionStartError, instant_text, read_elapsed, read_instant

NUMBER = re.compile(r"[+-]?[0-9]+(?:\.[0-9]*)?", re.ASCII)


@dataclass(frozen=True)
class Window:
    """Times as they were said; None where nothing bounds that side."""

    # As ``core.times.read_instant`` takes them; of a recording that counts from its own time zero, as
    # ``read_elapsed`` takes them
    start: object = None
    # As ``core.times.read_instant`` takes them; of a recording that counts from its own time zero, as
    # ``read_elapsed`` takes them
    stop: object = None
    mission_start: object = None  # Instant at which mission elapsed time is zero

    @property
    def is_all(self) -> bool:
        """Whether nothing is cut off."""
        return self.start is None and self.stop is None

    def bounds(self, epoch: Literal["utc", "elapsed"]) -> tuple[int | None, int | None]:
        """Return start and stop [ns] on the time of a recording.

        Raises
        ------
        UsageError
            ``wrong_time``, if one is no such time, or the stop is not after the start; ``no_mission_start``.
        """
        try:
            origin = None if self.mission_start is None else read_instant(_plain(self.mission_start))
            start, stop = (_read(given, epoch, origin) for given in (self.start, self.stop))
        except ValueError as error:
            own = "" if epoch == "utc" else "The recording has elapsed time, not UTC"
            code = "no_mission_start" if isinstance(error, NoMissionStartError) else "wrong_time"
            raise UsageError(str(error), do=own, code=code) from None
        if start is not None and stop is not None and stop <= start:
            raise UsageError(f"from {self.start} to {self.stop}: the end must be after the start", code="wrong_time")
        return start, stop


def cut(recording: Recording, window: Window) -> Recording:
    """Return the part of a recording that lies in a window; what is left out is counted in a remark.

    Raises
    ------
    DataError
        ``no_time``, if the recording has none; ``nothing_left``, if no sample lies in the window.
    UsageError
        ``wrong_time``.
    """
    if window.is_all:
        return recording
    if recording.time_ns is None:
        what = "--from and --to need a time column"
        raise DataError(what, where=recording.source.path, do="Name its time column", code="no_time")
    time = recording.time_ns
    start, stop = window.bounds(recording.epoch)
    inside = np.ones(len(time), dtype=bool)
    if start is not None:
        inside &= time >= start
    if stop is not None:
        inside &= time < stop
    kept = np.flatnonzero(inside)
    if not len(kept):
        raise nothing_left(recording.source.path, time, recording.epoch)
    together = int(kept[-1]) - int(kept[0]) + 1 == len(kept)
    part = slice(int(kept[0]), int(kept[-1]) + 1) if together else kept
    return replace(
        recording,
        channels=tuple(replace(channel, data=channel.data[part]) for channel in recording.channels),
        time_ns=time[part],
        remarks=(*recording.remarks, cut_remark(recording.source.path, len(kept), len(time))),
        first_row=recording.first_row + int(kept[0]) if recording.first_row and together else 0,
    )


def cut_remark(path: str, kept: int, total: int, files: int = 0) -> Remark:
    """Return the remark that says how much was left out; ``files``: how many were not opened for it."""
    more = f"; {files} file(s) outside not opened" if files else ""
    return Remark("cut_to_times", "info", f"{kept} of {total} samples are in the requested time window{more}", path)


def nothing_left(path: str, time: Times, epoch: Literal["utc", "elapsed"]) -> DataError:
    """Return the error for a window without a sample."""
    first, last = (
        instant_text(int(t)) if epoch == "utc" else f"{int(t) / SECOND:.9g} s" for t in (time.min(), time.max())
    )
    return DataError(
        "no sample in the requested time window",
        where=path,
        do=f"The recording runs from {first} to {last}",
        code="nothing_left",
    )


def _read(given: object, epoch: Literal["utc", "elapsed"], origin: int | None) -> int | None:
    if given is None:
        return None
    return read_instant(_plain(given), origin) if epoch == "utc" else read_elapsed(given)


def _plain(given: object) -> object:
    """Return a number that was typed as text as a number: UNIX seconds."""
    if not isinstance(given, str) or not NUMBER.fullmatch(given.strip()):
        return given
    return int(given) if given.strip().isdigit() else float(given)
