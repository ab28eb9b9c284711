"""Shift of the new model from the ground model over temperature, with the flips."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import uncertainty
from ..drawing.data import Curve, curves, finite, flags, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "shifted_temperature"
SHOWS = (
    "Shift of the new model from the ground model over temperature, with the 95 % band for a flight to come; points:"
    " flips of all flights, at their own age; hollow: flights that were left out"
)


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture an axis."""
    flips = {(one.get("test"), one.get("axis")): one for one in curves(results, "shifted_flights")}
    found = []
    for one in curves(results, NAME):
        which = one.get("test"), one.get("axis")
        if not len(finite(numbers(one, "shift"))) or which not in flips:
            continue
        test, axis = (str(part or "") for part in which)
        paint = partial(draw, one, flips[which])
        found.append(Picture(NAME, test, axis, finding(one), SHOWS, (2.6,), paint, data=(one, flips[which])))
    return found


def finding(curve: Curve) -> str:
    """Return the finding: where the new model is known worst."""
    half = 0.5 * (numbers(curve, "hi") - numbers(curve, "lo"))
    if not len(finite(half)):
        return "the new model over temperature"
    least, most = (float(pick(finite(half))) for pick in (np.min, np.max))
    of = plain(unit(curve, "shift"))
    known = f"{uncertainty(least)} to {uncertainty(most)} {of}"
    return f"{curve.get('axis', '')}: a flight to come is known to {known}, at 95 %"


def draw(curve: Curve, flips: Curve, axes: Sequence[Axes], title: str) -> None:
    """Draw the shift over temperature."""
    (ax,) = axes
    T, line, low, high = (numbers(curve, name) for name in ("temperature", "shift", "lo", "hi"))
    ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
    ax.fill_between(T, low, high, color=COLOURS["blue"], alpha=0.15, linewidth=0.0, zorder=1, label="a flight to come")
    ax.plot(T, line, color=COLOURS["ink"], linewidth=1.2, zorder=2, label="new model")
    used, at, shift = flags(flips, "used"), numbers(flips, "temperature"), numbers(flips, "shift")
    for mask, face, label in ((used, COLOURS["blue"], "flips"), (~used, COLOURS["paper"], "left out")):
        if mask.any():
            ax.plot(at[mask], shift[mask], linestyle="none", marker="o", markersize=4.5, color=COLOURS["blue"],
                    markerfacecolor=face, zorder=4, label=label)  # fmt: skip
    set_title(ax, title)
    set_labels(ax, with_unit("temperature", "degC"), with_unit("shift", unit(curve, "shift")))
    set_legend(ax)
