"""Level of the control by third of an octave, with its 95 % interval, beside that of the profile."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, set_labels, set_legend, set_title, with_unit

NAME = "vibration_bands"
SHOWS = "Root mean square of each third of an octave over frequency, both logarithmic, with that of the profile"
HEIGHT = 2.4  # of the panel [in]
FACTOR = 1.96


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a run."""
    return [_picture(one) for one in curves(results, "vibration_bands")]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], curve, title)

    test, axis = str(curve.get("test", "")), str(curve.get("axis", ""))
    return Picture(NAME, test, axis, finding(curve), SHOWS, (HEIGHT,), paint)


def finding(curve: Curve) -> str:
    """Return the finding: the band that is farthest from the profile."""
    ratio = 20.0 * np.log10(numbers(curve, "rms") / numbers(curve, "profile"))
    at = int(np.nanargmax(np.abs(ratio)))
    frequency = float(numbers(curve, "frequency")[at])
    return f"Farthest from the profile: {number(float(ratio[at]), 2)} dB in the band at {number(frequency, 3)} Hz"


def draw(ax: Axes, curve: Curve, title: str = "") -> None:
    """Draw the levels of bands."""
    low, high, frequency = (numbers(curve, name) for name in ("low", "high", "frequency"))
    rms, u, profile = (numbers(curve, name) for name in ("rms", "u", "profile"))
    edges = np.append(low, high[-1])
    ax.stairs(profile, edges, color=COLOURS["ink"], linewidth=1.3, label="profile", baseline=None)
    ax.errorbar(frequency, rms, FACTOR * u, color=COLOURS["blue"], linestyle="none", marker="o", markersize=3.6,
                elinewidth=1.0, capsize=2.0, label="control, 95 %")  # fmt: skip
    log_axis(ax, "x", edges, 1.05)
    log_axis(ax, "y", finite(np.concatenate([rms, profile])), 1.4)
    set_title(ax, title)
    set_labels(ax, with_unit("frequency", "Hz"), with_unit("rms", unit(curve, "rms")))
    set_legend(ax)


__all__ = ["NAME", "draw", "finding", "pictures"]
