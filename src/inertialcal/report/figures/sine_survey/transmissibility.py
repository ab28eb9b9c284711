"""Transmissibility of each response: the modes, the tracking filter, and the survey that it is set against."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number, with_uncertainty
from ..drawing.data import Curve, curves, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "transmissibility"
SHOWS = (
    "Above, the size of the transmissibility over frequency: line by the modes, dots behind the tracking filter,"
    " dashed in the survey that it is set against; below, its phase"
)
HEIGHTS = (2.6, 1.3)  # of the panels [in]
SOME = 3  # modes that the title names


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test and response."""
    tracked = {(one.get("test", ""), one.get("axis", "")): one for one in curves(results, "transmissibility_tracked")}
    models = {(one.get("test", ""), one.get("axis", "")): one for one in curves(results, "transmissibility")}
    against = {step["test"]: step.get("against") for step in results.get("sequence", [])}
    return [
        _picture(results, model, tracked.get(key), models.get((against.get(key[0]) or "", key[1])))
        for key, model in models.items()
    ]


def _picture(results: Mapping[str, Any], model: Curve, tracked: Curve | None, other: Curve | None) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, model, tracked, other, title)

    test, axis = str(model.get("test", "")), str(model.get("axis", ""))
    data = tuple(one for one in (model, tracked, other) if one is not None)
    return Picture(NAME, test, axis, finding(results, test, axis), SHOWS, HEIGHTS, paint, data=data)


def finding(results: Mapping[str, Any], test: str, axis: str) -> str:
    """Return the finding: the changes of frequency where there are any, else the resonances."""
    mine = [row for row in results.get("results", []) if row["test"] == test and row["axis"] == axis]
    changed = [row for row in mine if row["quantity"] == "resonance_frequency_change" and row["value"] is not None]
    if changed:
        largest = max(changed, key=lambda row: abs(row["value"]))
        figure = with_uncertainty(largest["value"], largest["u"])
        return f"{plain(axis)}: largest change of a resonance {figure} {plain(largest['unit'])}".rstrip(" 1")
    found = [row for row in mine if row["quantity"] == "resonance_frequency" and row["value"] is not None]
    if not found:
        return f"{plain(axis)}: no resonance"
    words = ", ".join(number(row["value"], 4) for row in found[:SOME])
    more = f" and {len(found) - SOME} more" if len(found) > SOME else ""
    return f"{plain(axis)}: {len(found)} resonance{'s' if len(found) > 1 else ''}, at {words} Hz{more}"


def draw(axes: Sequence[Axes], model: Curve, tracked: Curve | None, other: Curve | None, title: str = "") -> None:
    """Draw size and phase.

    Parameters
    ----------
    axes : sequence of Axes, length 2
        For size and phase, with one axis of frequency.
    model, tracked, other : mapping
        Curves by the modes, behind the tracking filter, and by the modes of the survey before; None for none.
    title : str
        Above the first; empty for none.
    """
    size, phase = axes
    if tracked is not None:
        look: dict[str, Any] = {"linestyle": "none", "marker": ".", "markersize": 2.6, "color": COLOURS["quiet"]}
        size.loglog(
            numbers(tracked, "frequency"), numbers(tracked, "transmissibility"), label="tracking filter", **look
        )
        phase.semilogx(numbers(tracked, "frequency"), np.degrees(numbers(tracked, "phase")), **look)
    if other is not None:
        look = {"linestyle": "--", "color": COLOURS["vermilion"], "linewidth": 1.1}
        size.loglog(numbers(other, "frequency"), numbers(other, "transmissibility"),
                    label=plain(other.get("test", "")), **look)  # fmt: skip
        phase.semilogx(numbers(other, "frequency"), np.degrees(numbers(other, "phase")), **look)
    look = {"color": COLOURS["blue"], "linewidth": 1.1}
    label = plain(model.get("test", "")) if other is not None else "modes"
    size.loglog(numbers(model, "frequency"), numbers(model, "transmissibility"), label=label, **look)
    phase.semilogx(numbers(model, "frequency"), np.degrees(numbers(model, "phase")), **look)
    phase.set_ylim(-190.0, 190.0)
    phase.set_yticks([-180, -90, 0, 90, 180])
    set_title(size, title)
    set_labels(size, y=with_unit("transmissibility", unit(model, "transmissibility")))
    set_labels(phase, "frequency [Hz]", "phase [deg]")
    set_legend(size)


__all__ = ["NAME", "draw", "finding", "pictures"]
