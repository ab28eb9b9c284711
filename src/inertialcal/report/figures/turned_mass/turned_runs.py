"""Response of each run with a turned mass over the rate of its recoil, with attraction less recoil as fitted.

Whiskers are 95 % intervals from the noise of each run. Filled: turned in the sense of the orbit; hollow: against it;
crossed out: a run that meets the orbit, which is not used.
"""

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

NAME = "turned_runs"
SHOWS = (
    "Response of each run in phase with the mass over the rate of its recoil, with its 95 % interval; filled: turned in"
    " the sense of the orbit, hollow: against it; line: attraction less recoil"
)
MICRO = 1e6  # of recoil rates


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    found = []
    for one in curves(results, NAME):
        if len(finite(numbers(one, "cosine"))):
            test, axis = str(one.get("test", "")), str(one.get("axis", ""))
            said = finding(results, one, test, axis)
            found.append(Picture(NAME, test, axis, said, SHOWS, (2.6,), partial(draw, one), data=(one,)))
    return found


def finding(results: Mapping[str, Any], curve: Curve, test: str, axis: str) -> str:
    """Return the finding: scale factor and recoil arm."""
    mine = [
        row
        for row in results.get("results", [])
        if (row["test"], row["axis"]) == (test, axis) and row["value"] is not None and not case_of(row).beside
    ]
    runs = f"{len(numbers(curve, 'cosine'))} runs"
    named = {row["quantity"]: f"{with_uncertainty(row['value'], row['u'])} {plain(row['unit'])}" for row in mine}
    if "scale_factor" not in named:
        return f"{runs}: the response cannot be told from noise"
    recoil = f", recoil arm {named['recoil_arm']}" if "recoil_arm" in named else ""
    return f"{runs}: scale factor {named['scale_factor']}{recoil}"


def draw(curve: Curve, axes: Sequence[Axes], title: str) -> None:
    """Draw the runs of a test."""
    (ax,) = axes
    q, value = MICRO * numbers(curve, "recoil_rate"), numbers(curve, "cosine")
    lo, hi, fitted = (numbers(curve, name) for name in ("lo", "hi", "fitted_cosine"))
    ahead, used = numbers(curve, "rate") > 0.0, flags(curve, "used")
    ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
    there = np.isfinite(fitted)
    if there.any() and np.ptp(q[there]) > 0.0:
        slope, level = np.polyfit(q[there], fitted[there], 1)
        ends = np.array([min(q.min(), 0.0), q.max() + 0.05 * np.ptp(q)])
        ax.plot(
            ends, level + slope * ends, color=COLOURS["ink"], linewidth=1.2, label="attraction less recoil", zorder=2
        )
    ax.vlines(q, lo, hi, color=COLOURS["blue"], linewidth=1.3, zorder=3)
    looks = (
        (ahead & used, "o", COLOURS["blue"], "with the orbit"),
        (~ahead & used, "o", COLOURS["paper"], "against the orbit"),
        (~used, "x", COLOURS["vermilion"], "meets the orbit, not used"),
    )
    for mask, marker, face, label in looks:
        if mask.any():
            edge = COLOURS["vermilion"] if marker == "x" else COLOURS["blue"]
            ax.plot(q[mask], value[mask], linestyle="none", marker=marker, markersize=5.0, markerfacecolor=face,
                    markeredgecolor=edge, label=label, zorder=4)  # fmt: skip
    set_title(ax, title)
    set_labels(ax, "rate of the recoil [1e-6/s^2]", with_unit("response", unit(curve, "cosine")))
    set_legend(ax)
