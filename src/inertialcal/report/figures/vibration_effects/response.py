"""Response to vibration by band: gain with 95 % intervals, and noise under vibration against rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "vibration_response"
SHOWS = (
    "Above, gain from the acceleration of the control to the reading in thirds of an octave, with 95 % intervals;"
    " below, noise under vibration over noise at rest"
)
MARKS = tuple(m * 10.0**k for k in range(-3, 6) for m in (1.0, 2.0, 5.0))  # of frequency [Hz]
HEIGHTS = (2.2, 1.8)  # of the panels [in]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture an axis and direction."""
    return [_picture(one) for one in curves(results, "vibration_effect_bands") if len(finite(numbers(one, "gain")))]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, title)

    test, axis = str(curve.get("test", "")), str(curve.get("axis", ""))
    return Picture(NAME, test, axis, finding(curve, axis), SHOWS, HEIGHTS, paint)


def finding(curve: Curve, axis: str) -> str:
    """Return the finding: the largest gain that stands out of the noise."""
    gain, frequency = numbers(curve, "gain"), numbers(curve, "frequency")
    seen = numbers(curve, "significant") > 0.0
    if not seen.any():
        return f"{plain(axis)}: no response stands out of the noise in any band"
    at = int(np.argmax(np.where(seen, gain, 0.0)))
    shown = f"{number(float(gain[at]), 3)} {plain(unit(curve, 'gain'))}".removesuffix(" 1")
    return f"{plain(axis)}: largest response to 1 g {shown}, at {number(float(frequency[at]), 3)} Hz"


def draw(axes: Sequence[Axes], curve: Curve, title: str = "") -> None:
    """Draw gain and noise.

    Parameters
    ----------
    axes : sequence of Axes, length 2
        To draw on.
    curve : mapping
        ``vibration_effect_bands``.
    title : str
        Above; empty for none.
    """
    above, below = axes
    frequency, gain, lo, hi = (numbers(curve, name) for name in ("frequency", "gain", "lo", "hi"))
    seen, shaken = numbers(curve, "significant") > 0.0, numbers(curve, "shaken") > 0.0
    above.vlines(frequency[seen], lo[seen], hi[seen], color=COLOURS["blue"], linewidth=1.4)
    above.plot(frequency[seen], gain[seen], "o", color=COLOURS["blue"], markersize=4.0, label="response")
    limits = shaken & ~seen
    if limits.any():
        above.plot(frequency[limits], hi[limits], "v", color=COLOURS["quiet"], markersize=5.0, label="95 % upper limit")
    above.set_ylim(bottom=0.0)
    ratio, low, high = (numbers(curve, name) for name in ("ratio", "ratio_lo", "ratio_hi"))
    alike = 100.0 if unit(curve, "ratio") == "%" else 1.0
    below.axhline(alike, color=COLOURS["quiet"], linewidth=0.8)
    below.vlines(frequency, low, high, color=COLOURS["vermilion"], linewidth=1.4)
    below.plot(frequency, ratio, "s", color=COLOURS["vermilion"], markersize=3.6)
    for ax in axes:
        ax.set_xscale("log")
        ax.set_xlim(0.9 * frequency[0], 1.1 * frequency[-1])
        ax.set_xticks(marks := [each for each in MARKS if 0.9 * frequency[0] <= each <= 1.1 * frequency[-1]])
        ax.set_xticklabels([f"{each:g}" for each in marks])
        ax.set_xticks([], minor=True)
    set_title(above, title)
    set_labels(above, y=with_unit("response to 1 g", unit(curve, "gain")))
    set_labels(below, with_unit("frequency", "Hz"), with_unit("noise / at rest", unit(curve, "ratio")))
    if seen.any() and limits.any():
        set_legend(below, above.get_legend_handles_labels()[0])
