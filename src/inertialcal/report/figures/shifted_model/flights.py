"""Shift of the bias from the ground model over the years, flip by flip, with the new model and its prediction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.results import case_of
from ....core.show.rounding import with_uncertainty
from ..drawing.data import Curve, curves, finite, flags, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "shifted_flights"
SHOWS = (
    "Shift of the bias from the ground model by flip over the years since the first, with 95 % intervals; hollow:"
    " flights that were left out; line: new model; band: where a flight to come lies, at 95 %"
)


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture an axis."""
    trends = {(one.get("test"), one.get("axis")): one for one in curves(results, "shifted_trend")}
    found = []
    for one in curves(results, NAME):
        which = one.get("test"), one.get("axis")
        if not len(finite(numbers(one, "shift"))) or which not in trends:
            continue
        test, axis = (str(part or "") for part in which)
        paint = partial(draw, one, trends[which])
        data = (one, trends[which])
        found.append(Picture(NAME, test, axis, finding(results, test, axis), SHOWS, (2.6,), paint, data=data))
    return found


def finding(results: Mapping[str, Any], test: str, axis: str) -> str:
    """Return the finding: shift and drift of the axis."""
    rows = [one for one in results.get("results", []) if (one["test"], one["axis"]) == (test, axis)]
    named = {one["quantity"]: one for one in rows if one["value"] is not None and case_of(one).plain}

    def figure(quantity: str) -> str:
        one = named[quantity]
        return f"{with_uncertainty(one['value'], one['u'])} {plain(one['unit'])}"

    shift = f"shift {figure('bias_shift')}" if "bias_shift" in named else "no shift"
    return f"{axis}: {shift}" + (f", drift {figure('bias_drift')}" if "bias_drift" in named else "")


def draw(curve: Curve, trend: Curve, axes: Sequence[Axes], title: str) -> None:
    """Draw the flips of an axis, and the new model."""
    (ax,) = axes
    age, shift, lo, hi = (numbers(curve, name) for name in ("age", "shift", "lo", "hi"))
    used = flags(curve, "used")
    x, line, low, high = (numbers(trend, name) for name in ("age", "shift", "lo", "hi"))
    ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
    ax.fill_between(x, low, high, color=COLOURS["blue"], alpha=0.15, linewidth=0.0, zorder=1, label="a flight to come")
    ax.plot(x, line, color=COLOURS["ink"], linewidth=1.2, zorder=2, label="new model")
    ax.vlines(age, lo, hi, color=COLOURS["blue"], linewidth=1.3, zorder=3)
    looks = ((used, COLOURS["blue"], "flips"), (~used, COLOURS["paper"], "left out"))
    for mask, face, label in looks:
        if mask.any():
            ax.plot(age[mask], shift[mask], linestyle="none", marker="o", markersize=4.5, color=COLOURS["blue"],
                    markerfacecolor=face, zorder=4, label=label)  # fmt: skip
    near = np.concatenate([finite(shift), finite(line), [0.0]])
    room = max(float(np.ptp(near)), 1e-12)
    ends = np.concatenate([finite(low), finite(high)])
    if len(ends):
        least = max(float(ends.min()), float(near.min()) - 2.0 * room)
        most = min(float(ends.max()), float(near.max()) + 2.0 * room)
        pad = 0.05 * max(float(near.max()), most) - 0.05 * min(float(near.min()), least)
        ax.set_ylim(min(float(near.min()), least) - pad, max(float(near.max()), most) + pad)
    ax.set_xlim(left=min(0.0, float(x.min())) - 0.02 * float(np.ptp(x)))
    set_title(ax, title)
    set_labels(
        ax, with_unit("age since the first flight", unit(curve, "age")), with_unit("shift", unit(curve, "shift"))
    )
    set_legend(ax)
