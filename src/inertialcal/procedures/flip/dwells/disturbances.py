"""Evidence in a record against its own windows: a movement in one, a change of gain, time that goes back.

Movements and changes of gain come from the one detector (``signals.segmentation.turns``,
``signals.segmentation.gain_changes``). A window with blocks that are not quiet is read all the same, and remarked. An
axis whose gain changes is not read in any window of the recording: the gain at which its counts were converted is not
known, and zero and bias of its electronics differ between gains. Where the gain was recorded as well (a channel
``gain_y``), that decides, window by window (``recordings``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.recording import SECOND, Recording, Times
from ....core.remarks import Remark
from ....core.show.rounding import number
from ....signals.segmentation.block_statistics import block_statistics
from ....signals.segmentation.gain_changes import gain_changes
from ....signals.segmentation.turn_windows import quiet_part
from ....signals.segmentation.turns import Turn, Turns, block_length, find_turns
from ....signals.sense.limits import LIMITS
from ....signals.time.time_axis import AGAIN, backward_steps
from ...agreement import unit_mistaken
from .quiet import Window
from .said import said_and_seen

BLOCK = 1.0  # [s]
ALIKE = 0.2  # relative difference of factors that are one
PART = 0.98  # of a window that is quiet where nothing moves


def disturbances(
    time_ns: Times, channels: Mapping[str, NDArray[np.floating]], windows: Sequence[Window], known_gain: Sequence[str]
) -> tuple[frozenset[str], tuple[Remark, ...], tuple[Remark, ...], tuple[Remark, ...], tuple[Turn, ...]]:
    """Look for movements in the windows of a recording, and for changes of gain in all of it.

    Parameters
    ----------
    time_ns : ndarray of int64, shape (n,)
        Stamps [ns].
    channels : mapping of str to ndarray, shape (n,)
        Each axis [m/s^2].
    windows : sequence of Window
        After settling.
    known_gain : sequence of str
        Axes whose gain was recorded.

    Returns
    -------
    unread : frozenset of str
        Axes that cannot be read in the recording.
    remarks : tuple of Remark
        Why, and windows that are not quiet.
    disagreements : tuple of Remark
        That all axes change by one factor.
    misplaced : tuple of Remark
        Windows in the wrong place or at the wrong position, by the turns that are seen.
    turns : tuple of Turn
        Those.
    """
    axes = [axis for axis, data in channels.items() if np.isfinite(data).any()]
    changed: dict[str, Remark] = {}
    moved: list[Remark] = []
    factors: dict[str, float] = {}
    alike: tuple[Remark, ...] = ()
    wrong: list[Remark] = []
    shown: tuple[Turn, ...] = ()
    try:
        length = block_length(BLOCK, time_ns, None)
        blocks = block_statistics([channels[axis] for axis in axes], length, time_ns)
        for one in gain_changes(blocks):
            axis = axes[one.channel]
            if axis not in known_gain:
                when = f"{(one.time_ns - blocks.start_ns) / SECOND:.0f} s after the start"
                what = f"level and scatter of {axis} change by a factor of {one.level:.3g}: {axis} is not read"
                do = "Cut the record there (--from, --to), or record the gain as well"
                changed.setdefault(axis, Remark("gain_changed", "warning", what, when, do=do, axis=axis))
                factors.setdefault(axis, one.level)
        alike = _changed_alike(axes, factors, changed)
        turns = find_turns(blocks.of([axis not in changed for axis in axes]))
        moved = [one for window in windows for one in _moved(turns, window)]
        if not alike:
            seen, wrong = said_and_seen(turns, windows)
            moved += seen
            shown = turns.turns
    except DataError:
        pass  # no axis remains, or the record is too short to tell what is quiet: `short_record` says so
    return frozenset(changed), (*changed.values(), *moved), alike, tuple(wrong), shown


def _changed_alike(
    axes: Sequence[str], factors: Mapping[str, float], changed: Mapping[str, Remark]
) -> tuple[Remark, ...]:
    """Return the remark that all axes change by one factor: the unit, or the range of all."""
    every = np.abs(list(factors.values()))
    if len(axes) < 2 or len(factors) < len(axes) or float(np.ptp(np.log(every))) > ALIKE:
        return ()
    size = float(np.median(every))
    unit = unit_mistaken(size, "acceleration") or unit_mistaken(size, "angular_rate")
    what = f"all axes change to {number(size, 3)} times what they were{f': {unit}' if unit else ''}"
    do = "Cut the record there (--from, --to), and state unit and range of each part"
    return (Remark("unit_changed" if unit else "scale_changed", "error", what, changed[axes[0]].where, do=do),)


def _moved(turns: Turns, window: Window) -> list[Remark]:
    """Return the remark on a window with whole blocks that are not quiet."""
    blocks = turns.blocks
    begin = -((blocks.start_ns - window.start) // blocks.length_ns)
    end = (window.stop - blocks.start_ns) // blocks.length_ns
    if end <= begin:
        return []
    start, stop = (blocks.start_ns + int(at) * blocks.length_ns for at in (begin, end))
    part = quiet_part(turns, start, stop)
    if part >= PART:
        return []
    when = f"window {(window.start - blocks.start_ns) / SECOND:.0f} to {(window.stop - blocks.start_ns) / SECOND:.0f} s"
    what = f"{(1.0 - part) * (stop - start) / SECOND:.0f} s of the window are not quiet, or missing"
    do = "Something else moved (robot arm, crew), or samples are missing: choose another window"
    return [Remark("disturbed", "warning", what, when, do=do)]


def is_reading(value: float) -> bool:
    """Tell whether a number [m/s^2] can be a reading, or is missing (NaN)."""
    return math.isnan(value) or abs(value) <= LIMITS["acceleration"].high


def stamped(recording: Recording) -> Recording:
    """Return the recording with stamps; samples without count from their first, by the interval.

    Raises
    ------
    DataError
        ``time_backwards`` if a stamp is earlier than the one before: windows could not be placed.
    """
    if recording.time_ns is None:
        recording = replace(recording, time_ns=recording.stamps, epoch="elapsed")
    time_ns = recording.time_ns
    if time_ns is not None and np.any(time_ns[1:] < time_ns[:-1]):
        where = recording.place(int(np.argmax(time_ns[1:] < time_ns[:-1])) + 1)
        why = "windows cannot be placed on such a clock"
        raise DataError(backward_steps(time_ns), where, why, AGAIN, "time_backwards")
    return recording
