"""Channels of a recording against time: one panel per channel, minimum and maximum per bin, gaps as gaps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.recording import SECOND, Channel, Recording
from ....signals.time.samples import min_max
from ..drawing.data import envelope
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, TEXT, plain, set_labels, with_unit

NAME = "recording"
MOST = 12  # channels drawn
SHOWS = "Each channel over time, minimum and maximum per bin; gaps in the recording are gaps in the line"


def picture(recording: Recording, axis: str | None = None) -> Picture:
    """Return the picture of a recording.

    Raises
    ------
    DataError
        ``nothing_to_draw``, if there is no sample, or no channel with a finite number.
    """
    known = [channel for channel in recording.channels if _drawable(channel)]
    chosen = [channel for channel in known if axis in (None, channel.axis)]
    if not chosen:
        have = ", ".join(dict.fromkeys(channel.axis for channel in known if channel.axis))
        missing = "No channel with numbers" if axis is None or not known else f"No channel of axis {axis!r}"
        do = f"There are: {have}" if known and have else ""
        raise DataError(f"{missing} to plot", recording.source.path, do=do, code="nothing_to_draw")
    drawn = chosen[:MOST]

    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, recording, drawn, title)

    return Picture(NAME, "", axis or "", finding(recording, drawn), SHOWS, (0.95,) * len(drawn), paint)


def finding(recording: Recording, drawn: Sequence[Channel]) -> str:
    """Return the finding: how much there is."""
    name = recording.source.path.replace("\\", "/").rpartition("/")[2]
    seconds = recording.seconds
    length = "" if seconds is None else f", {seconds[-1]:.6g} s"
    part = f", {len(drawn)} of {len(recording.channels)} channels" if len(drawn) < len(recording.channels) else ""
    said = f"{len(recording)} samples{length}{part}"
    return f"{plain(name)}: {said}" if name else said


def draw(axes: Sequence[Axes], recording: Recording, channels: Sequence[Channel], title: str = "") -> None:
    """Draw channels, one on each axes."""
    time_ns, name = _time(recording)
    order = np.argsort(time_ns, kind="stable")
    for ax, channel in zip(axes, channels, strict=True):
        values: Array = np.asarray(channel.data, dtype=np.float64)[order]
        bins = min_max(values[:, np.newaxis], time_ns[order])
        at, line = envelope(bins.time, bins.lo[:, 0], bins.hi[:, 0])
        ax.plot(at, line, color=COLOURS["blue"], linewidth=0.9, solid_capstyle="projecting")
        label = with_unit(plain(channel.name), channel.unit or "?")
        above = f"{title}\n{label}" if title and ax is axes[0] else label
        ax.set_title(above, fontsize=TEXT - 1, pad=3.0, loc="left", parse_math=False)
    for ax in axes[:-1]:
        ax.tick_params(labelbottom=False)
    set_labels(axes[-1], name)


def _drawable(channel: Channel) -> bool:
    try:
        return bool(np.any(np.isfinite(np.asarray(channel.data, dtype=np.float64))))
    except (TypeError, ValueError):  # a channel of text
        return False


def _time(recording: Recording) -> tuple[np.ndarray[tuple[int], np.dtype[np.int64]], str]:
    """Return stamps [ns] and what they are; a recording without time counts its samples, a second each."""
    if recording.time_ns is not None:
        return recording.time_ns, "time since the first sample [s]"
    rows = np.arange(len(recording), dtype=np.int64)
    if recording.sample_interval is not None:
        return np.rint(rows * recording.sample_interval * SECOND).astype(np.int64), "time since the first sample [s]"
    return rows * SECOND, "sample"
