"""Attraction along the travel of a source mass, with the dwells of a cycle upon it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME, DRIVE = "mass_field", "mass_drive"
SHOWS = "Attraction along the input axis over the position of the mass; points: dwells; shaded: stroke"


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    found = []
    for one in curves(results, NAME):
        test = str(one.get("test", ""))
        dwells = [drive for drive in curves(results, DRIVE) if drive.get("test", "") == test]
        found.append(Picture(NAME, test, "", finding(one, dwells), SHOWS, (2.4,), partial(draw, one, dwells)))
    return found


def finding(curve: Curve, dwells: Sequence[Curve]) -> str:
    """Return the finding: the amplitude of the stroke."""
    if not dwells:
        return "attraction along the travel"
    place, field = (numbers(dwells[0], name) for name in ("position", "attraction"))
    stroke = f"{np.nanmin(place):.4g} to {np.nanmax(place):.4g} {plain(unit(curve, 'position'))}"
    amplitude = f"{np.ptp(field) / 2.0:.3g} {plain(unit(curve, 'attraction'))}"
    return f"moving the mass from {stroke} applies an amplitude of {amplitude}"


def draw(curve: Curve, dwells: Sequence[Curve], axes: Sequence[Axes], title: str) -> None:
    """Draw the field and the dwells."""
    (ax,) = axes
    place, field = numbers(curve, "position"), numbers(curve, "attraction")
    ax.plot(place, field, color=COLOURS["blue"], linewidth=1.4, label="attraction", zorder=3)
    for one in dwells:
        at, there = numbers(one, "position"), numbers(one, "attraction")
        ax.axvspan(
            float(np.nanmin(at)), float(np.nanmax(at)), color=COLOURS["grid"], alpha=0.45, linewidth=0.0, zorder=0
        )
        name = f"dwells of the drive ({plain(one.get('of', ''), 12)})"
        ax.plot(at, there, "o", color=COLOURS["vermilion"], markersize=6.0, label=name, zorder=4)
    ax.set_ylim(bottom=min(0.0, float(np.nanmin(field))))
    set_title(ax, title)
    set_labels(
        ax,
        with_unit("position of the mass", unit(curve, "position")),
        with_unit("attraction", unit(curve, "attraction")),
    )
    set_legend(ax)
