"""What a record says against its own windows: something moves in one, or the gain of an axis changes.

Both come from the one detector (``signals.segmentation.turns``, ``signals.segmentation.gain_changes``). A window in
which blocks are not quiet is read all the same, and remarked. An axis whose gain changes is not read in any window of
the recording: at which gain its counts were taken for readings is not known, and at another one its electronics zero
and bias are others. Where the gain was recorded beside the axis (a channel ``gain_y``), that decides, window by window
(``recordings``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.recording import SECOND, Times
from ....core.remarks import Remark
from ....signals.segmentation.block_statistics import Blocks, block_statistics
from ....signals.segmentation.gain_changes import gain_changes
from ....signals.segmentation.turn_windows import quiet_part
from ....signals.segmentation.turns import Turns, find_turns
from .quiet import Window

BLOCK = 1.0  # [s]
PART = 0.98  # of a window that is quiet where nothing moves


@dataclass(frozen=True)
class Seen:
    """Axes that cannot be read in a recording, and what is to be said of it."""

    unread: frozenset[str]
    remarks: tuple[Remark, ...]


def seen(
    time_ns: Times, channels: Mapping[str, NDArray[np.floating]], windows: Sequence[Window], known_gain: Sequence[str]
) -> Seen:
    """Look for disturbances in the windows of a recording, and for changes of gain in all of it.

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
    """
    read = {axis: data for axis, data in channels.items() if np.isfinite(data).any()}
    changed: dict[str, Remark] = {}
    moved: list[Remark] = []
    try:
        blocks = block_statistics(list(read.values()), BLOCK, time_ns)
        changed = _changed(blocks, tuple(read), known_gain)
        turns = find_turns(blocks.of([axis not in changed for axis in read]))
        moved = [one for window in windows for one in _moved(turns, window)]
    except DataError:
        pass  # nothing is left, or too short to tell what is quiet: `short_record` says so
    return Seen(frozenset(changed), (*changed.values(), *moved))


def _changed(blocks: Blocks, axes: Sequence[str], known_gain: Sequence[str]) -> dict[str, Remark]:
    """Return the first change of gain of each axis."""
    found: dict[str, Remark] = {}
    for one in gain_changes(blocks):
        axis = axes[one.channel]
        if axis not in known_gain:
            when = f"{(one.time_ns - blocks.start_ns) / SECOND:.0f} s after the start"
            what = f"level and scatter of {axis} change by a factor of {one.level:.3g}: {axis} is not read"
            do = "Cut the record there (--from, --to), or record the gain beside it"
            found.setdefault(axis, Remark("gain_changed", "warning", what, when, do=do, axis=axis))
    return found


def _moved(turns: Turns, window: Window) -> list[Remark]:
    """Return the remark on a window that is not quiet: whole blocks inside it are looked at."""
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
    what = f"{(1.0 - part) * (stop - start) / SECOND:.0f} s of the window are not quiet, or not there"
    do = "Something else moved there (robot arm, crew), or samples are missing: choose another window"
    return [Remark("disturbed", "warning", what, when, do=do)]
