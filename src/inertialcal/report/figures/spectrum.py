"""Spectral density over frequency: each record with its interval, the same terms as in the Allan deviation, lines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from .data import Curve, curves, finite, flags, numbers, unit
from .log_axes import log_axis
from .noise_terms import DOTS, draw_terms
from .picture import Picture
from .style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "spectrum"
SHOWS = "One-sided density over frequency, both logarithmic; shaded is the 95 % interval, lines are the fitted terms"
HEIGHT = 2.6  # of the panel [in]
ROOM = 1.6
NAMED = 3  # lines in a finding
STROKES = ("-", (0, (4, 1)), (0, (1, 1)), (0, (4, 1, 1, 1)))  # of records


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test and axis."""
    known = [one for one in curves(results, NAME) if np.any(numbers(one, "density") > 0.0)]
    found = []
    for test, axis in dict.fromkeys((str(one.get("test", "")), str(one.get("axis", ""))) for one in known):
        mine = [one for one in known if (one.get("test", ""), one.get("axis", "")) == (test, axis)]
        found.append(_picture(results, test, axis, mine))
    return found


def _picture(results: Mapping[str, Any], test: str, axis: str, mine: Sequence[Curve]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], mine, title)

    return Picture(NAME, test, axis, finding(results, test, axis), SHOWS, (HEIGHT,), paint)


def finding(results: Mapping[str, Any], test: str, axis: str) -> str:
    """Return the finding: lines that stand out of the noise, by their frequency."""
    named = dict.fromkeys(
        plain(str(row["condition"]).partition(", ")[0].removeprefix("line at "))
        for row in results.get("results", [])
        if (row["test"], row["axis"], row["quantity"]) == (test, axis, "line_frequency")
    )
    few = list(named)[:NAMED]
    more = f" and {len(named) - NAMED} more" if len(named) > NAMED else ""
    said = f"line at {', '.join(few)}{more}" if few else "no line stands out of the noise"
    return f"{plain(axis)}: {said}"


def draw(ax: Axes, mine: Sequence[Curve], title: str = "") -> None:
    """Draw the spectra of all records of an axis, and the terms.

    Parameters
    ----------
    ax : Axes
        Where.
    mine : sequence of mapping
        ``spectrum`` curves of ``results.json``, one a record.
    title : str
        Above; empty for none.
    """
    marked: list[tuple[float, float]] = []
    for number, curve in enumerate(mine):
        frequency, density = numbers(curve, "frequency"), numbers(curve, "density")
        lo, hi, line = numbers(curve, "lo"), numbers(curve, "hi"), flags(curve, "line")
        band = np.isfinite(lo) & np.isfinite(hi) & (lo > 0.0)
        if band.any():
            ax.fill_between(frequency, lo, hi, where=band.tolist(), color=COLOURS["sky"], alpha=0.35, linewidth=0.0,
                            zorder=1, label="95 % interval" if number == 0 else None)  # fmt: skip
        name = plain(curve.get("recording", "")) if len(mine) > 1 else "measured"
        ax.plot(frequency, np.where(density > 0.0, density, np.nan), color=COLOURS["blue"], linewidth=0.9, zorder=2,
                linestyle=STROKES[number % len(STROKES)], label=name)  # fmt: skip
        marked += [(f, d) for f, d in zip(frequency[line].tolist(), density[line].tolist(), strict=True) if d > 0.0]
    draw_terms(ax, numbers(mine[0], "frequency"), mine[0])
    if marked:
        x, y = zip(*marked, strict=True)
        ax.plot(x, y, linestyle="none", zorder=5, label="line", **(DOTS[2] | {"color": COLOURS["vermilion"]}))
    shown = np.concatenate([finite(numbers(one, name)) for one in mine for name in ("density", "lo", "hi")])
    log_axis(ax, "x", np.concatenate([numbers(one, "frequency") for one in mine]), 1.15)
    log_axis(ax, "y", shown, ROOM)
    set_title(ax, title)
    set_labels(ax, with_unit("frequency", unit(mine[0], "frequency")), with_unit("density", unit(mine[0], "density")))
    set_legend(ax)


__all__ = ["NAME", "draw", "finding", "pictures"]
