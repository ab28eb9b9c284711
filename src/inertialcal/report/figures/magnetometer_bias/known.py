"""How well the bias of a gyro is known by then: standard uncertainty of each axis over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.key import AXES
from ....core.show.rounding import uncertainty
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "magnetometer_bias_known"
SHOWS = (
    "Standard uncertainty of the bias of each axis by the scatter of the arcs up to then, without what standards add"
)
HEIGHT = 2.6  # of the panel [in]
LOOKS = {"x": ("o", "blue"), "y": ("s", "vermilion"), "z": ("^", "green")}


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    return [_picture(one) for one in curves(results, NAME) if len(finite(numbers(one, "u_x"))) > 1]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, title)

    return Picture(NAME, str(curve.get("test", "")), "", finding(curve), SHOWS, (HEIGHT,), paint)


def finding(curve: Curve) -> str:
    """Return the finding: how well the axis is known that is known least, at the end."""
    last = {axis: float(numbers(curve, f"u_{axis}")[-1]) for axis in AXES}
    least = max(last, key=last.__getitem__)
    return f"{least} is known least: {uncertainty(last[least])} {plain(unit(curve, 'u_x'))} at the end"


def draw(axes: Sequence[Axes], curve: Curve, title: str = "") -> None:
    """Draw a line an axis.

    Parameters
    ----------
    axes : sequence of Axes, length 1
        To draw on.
    curve : mapping
        ``magnetometer_bias_known``.
    title : str
        Above; empty for none.
    """
    (ax,) = axes
    minutes = numbers(curve, "time") / 60.0
    for axis, (marker, colour) in LOOKS.items():
        ax.plot(minutes, numbers(curve, f"u_{axis}"), marker=marker, markersize=3.5, color=COLOURS[colour], label=axis)
    log_axis(ax, "y", np.concatenate([numbers(curve, f"u_{axis}") for axis in AXES]), 1.3)
    ax.set_xlim(0.0, float(np.max(minutes)) * 1.03)
    set_title(ax, title)
    set_labels(ax, with_unit("time", "min"), with_unit("u(bias)", unit(curve, "u_x")))
    set_legend(ax)
