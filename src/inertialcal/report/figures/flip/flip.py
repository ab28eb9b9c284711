"""A flip: what each axis read at its positions, and the quiet record with its windows, their ends named A, B, C.

With a record of the noise its block means stand over time, the windows are shaded, and their ends carry letters, as
the document of the method has them; a line marks each turn that the record shows. The means of the dwells stand in
their order. Filled: position 0; hollow: turned.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from string import ascii_uppercase
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, finite, numbers, thinned, unit, words
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "flip"
SHOWS = "Reading of each axis, a panel an axis; filled at position 0, hollow where turned; the line is the result"
DWELLS = "Reading of each axis at its positions, in the order of the dwells, and the result (line)."
RECORD = "Block means of the quiet record; shaded are the windows, their ends are A, B and so on; lines: turns seen."
MOST = 800  # blocks drawn a panel
SAME = 1e-3  # angles that are one position [rad]
HEIGHT = 1.35  # of a panel [in]
FILLED: dict[str, Any] = {"marker": "o", "color": COLOURS["blue"], "markersize": 4.0}
HOLLOW: dict[str, Any] = {
    "marker": "o", "markerfacecolor": "none", "markeredgecolor": COLOURS["vermilion"], "markersize": 4.5
}  # fmt: skip


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return one picture a test: its dwells, and the record that each of its recordings shows."""
    found = []
    dwells = [curve for curve in curves(results, "flip_dwells") if len(finite(numbers(curve, "reading")))]
    for test in dict.fromkeys(str(curve.get("test", "")) for curve in dwells):
        mine = [curve for curve in dwells if curve.get("test") == test]
        found.append(_of_dwells(test, mine))
        records = [one for one in curves(results, "quiet") if one.get("test") == test]
        found += _of_records(test, records, [one for one in curves(results, "turns") if one.get("test") == test])
    return found


def _of_dwells(test: str, mine: Sequence[Curve]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw_dwells(axes, mine, title)

    count = len(numbers(mine[0], "reading"))
    axes = ", ".join(plain(one.get("axis", "")) for one in mine)
    finding = f"{count} dwells of {axes}"
    return Picture(NAME, test, "", finding, SHOWS, (HEIGHT,) * len(mine), paint, data=mine, note=(DWELLS,))


def _of_records(test: str, records: Sequence[Curve], turns: Sequence[Curve]) -> Iterator[Picture]:
    for name in dict.fromkeys(str(one.get("recording", "")) for one in records):
        own = [one for one in records if one.get("recording") == name and len(finite(numbers(one, "mean")))]
        if own:
            yield _of_record(test, name, (*records, *turns), own)


def _of_record(test: str, name: str, records: Sequence[Curve], own: Sequence[Curve]) -> Picture:
    turns = [one for one in records if one["name"] == "turns" and one.get("recording", "") == name]
    seen = [pair for one in turns for pair in zip(numbers(one, "start"), numbers(one, "stop"), strict=True)]

    def paint(axes: Sequence[Axes], title: str) -> None:
        draw_record(axes, own, title, seen)

    blocks = len(numbers(own[0], "mean"))
    shows = "Block means over time, a panel an axis; shaded are the windows, their ends are A, B, C and so on"
    finding = f"{plain(name)}: {blocks} quiet blocks, {len(spans(own[0]))} windows"
    heights = (HEIGHT,) * len(own)
    return Picture(NAME, test, "", finding, shows, heights, paint, data=records, note=(RECORD,))


def draw_dwells(axes: Sequence[Axes], mine: Sequence[Curve], title: str = "") -> None:
    """Draw the means of the dwells in their order, and what the flip found.

    Parameters
    ----------
    axes : sequence of Axes
        As many as curves.
    mine : sequence of mapping
        ``flip_dwells`` of one test, of ``results.json``.
    title : str
        Above the first; empty for none.
    """
    for ax, curve in zip(axes, mine, strict=True):
        order = np.arange(1.0, len(numbers(curve, "reading")) + 1.0)
        turned = np.abs(numbers(curve, "angle")) > SAME
        reading, expected = numbers(curve, "reading"), numbers(curve, "expected")
        for label in dict.fromkeys(words(curve, "flip")):
            own = np.array(words(curve, "flip")) == label
            ax.plot(order[own], expected[own], color=COLOURS["quiet"], linewidth=0.9, zorder=2)
        ax.plot(order[~turned], reading[~turned], linestyle="none", zorder=3, label="position 0", **FILLED)
        ax.plot(order[turned], reading[turned], linestyle="none", zorder=3, label="turned", **HOLLOW)
        set_labels(ax, y=with_unit(f"{plain(curve.get('axis', ''), 12)} reading", unit(curve, "reading")))
    set_title(axes[0], title)
    set_labels(axes[-1], "dwell, in their order")
    set_legend(axes[-1])


def draw_record(
    axes: Sequence[Axes], own: Sequence[Curve], title: str = "", turns: Sequence[tuple[float, float]] = ()
) -> None:
    """Draw the quiet record of one recording, its windows shaded and their ends named.

    Parameters
    ----------
    axes : sequence of Axes
        As many as curves.
    own : sequence of mapping
        ``quiet`` curves of one recording, of ``results.json``.
    title : str
        Above the first; empty for none.
    turns : sequence of (float, float)
        Start and stop of each turn that the record shows [s].
    """
    for ax, curve in zip(axes, own, strict=True):
        time, mean, turned = numbers(curve, "time"), numbers(curve, "mean"), np.abs(numbers(curve, "angle")) > SAME
        for choose, look, label in ((~turned, FILLED, "position 0"), (turned, HOLLOW, "turned")):
            at = np.flatnonzero(choose)[thinned(mean[choose], MOST)] if choose.any() else np.zeros(0, dtype=np.intp)
            ax.plot(time[at], mean[at], linestyle="none", zorder=3, label=label, **(look | {"markersize": 2.4}))
        for start, stop in spans(curve):
            ax.axvspan(start, stop, color=COLOURS["green"], alpha=0.22, linewidth=0.0, zorder=1)
        for i, (start, stop) in enumerate(turns):
            line = ax.axvline(0.5 * (start + stop), color=COLOURS["ink"], linewidth=0.7, zorder=2)
            line.set_label("turn seen" if i == 0 else "_")
        set_labels(ax, y=with_unit(plain(curve.get("axis", ""), 12), unit(curve, "mean")))
    _letters(axes[0], spans(own[0]))
    set_title(axes[0], title)
    set_labels(axes[-1], with_unit("time", unit(own[0], "time")))
    set_legend(axes[-1])


def spans(curve: Curve) -> list[tuple[float, float]]:
    """Return start and stop of each window: of each stretch of blocks that a dwell was read from."""
    time, used = numbers(curve, "time"), np.array([v is True for v in curve["columns"]["used"]["values"]])
    angle = numbers(curve, "angle")
    if not used.any():
        return []
    half = 0.5 * float(np.min(np.diff(time))) if len(time) > 1 else 0.5
    cuts = np.flatnonzero((np.diff(used.astype(np.int8)) != 0) | (np.diff(angle) != 0.0) | (np.diff(time) > 3.0 * half))
    edges = [0, *(int(cut) + 1 for cut in cuts), len(time)]
    parts = [(a, b) for a, b in pairwise(edges) if used[a]]
    return [(float(time[a]) - half, float(time[b - 1]) + half) for a, b in parts]


def _letters(ax: Axes, found: Sequence[tuple[float, float]]) -> None:
    """Name the ends of the windows above the first panel; none where there are more ends than letters."""
    ends = [end for pair in found for end in pair]
    for i, end in enumerate(ends if len(ends) <= len(ascii_uppercase) else []):
        side = "left" if i % 2 == 0 else "right"  # inside its window, clear of the neighbour's
        ax.text(end, 0.97, ascii_uppercase[i], transform=ax.get_xaxis_transform(), ha=side, va="top", fontsize=8)
