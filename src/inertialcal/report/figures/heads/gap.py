"""What a head reads beyond what the calibrated ones tell for its place, interval by interval."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.key import AXES
from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "heads_gap"
SHOWS = "Reading less what the calibrated heads tell and less the fit, interval by interval"
HEIGHT = 2.6  # of the panel [in]
LOOKS = {"x": ("o", "blue"), "y": ("s", "vermilion"), "z": ("^", "green")}


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a head."""
    return [_picture(one) for one in curves(results, NAME) if len(finite(numbers(one, "x"))) > 1]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, title)

    rest = np.concatenate([numbers(curve, axis) - numbers(curve, f"fitted_{axis}") for axis in AXES])
    spread = number(float(np.sqrt(np.nanmean(rest**2))), 2)
    finding = f"Means of {plain(curve.get('of', ''))} lie {spread} {plain(unit(curve, 'x'))} (rms) from the fit"
    return Picture(NAME, str(curve.get("test", "")), str(curve.get("of", "")), finding, SHOWS, (HEIGHT,), paint)


def draw(axes: Sequence[Axes], curve: Curve, title: str = "") -> None:
    """Draw what the fit leaves, a series an axis.

    Parameters
    ----------
    axes : sequence of Axes, length 1
        To draw on.
    curve : mapping
        ``heads_gap``.
    title : str
        Above; empty for none.
    """
    (ax,) = axes
    minutes = numbers(curve, "time") / 60.0
    ax.axhline(0.0, color=COLOURS["ink"], linewidth=0.8, zorder=1)
    for axis, (marker, colour) in LOOKS.items():
        ax.plot(minutes, numbers(curve, axis) - numbers(curve, f"fitted_{axis}"), linestyle="none", marker=marker,
                markersize=2.5, color=COLOURS[colour], label=axis)  # fmt: skip
    set_title(ax, title)
    set_labels(ax, with_unit("time", "min"), with_unit("left of the fit", unit(curve, "x")))
    set_legend(ax)
