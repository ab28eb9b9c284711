"""Transmissibility of each response: the modes, the tracking filter, and the survey that it is set against."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.estimate import Array
from ....core.show.rounding import number, with_uncertainty
from ..drawing.data import Curve, curves, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
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
        return f"{plain(axis)}: largest change of a resonance {figure} {plain(largest['unit'])}".removesuffix(" 1")
    known = [row for row in mine if row["quantity"] == "resonance_frequency" and row["value"] is not None]
    one_sweep = next((row["member"] for row in known if row.get("member")), None)  # where sweeps differ: the first
    found = [row for row in known if row.get("member") == one_sweep]
    if not found:
        return f"{plain(axis)}: no resonance"
    words = ", ".join(number(row["value"], 4) for row in found[:SOME])
    more = f" and {len(found) - SOME} more" if len(found) > SOME else ""
    if one_sweep is not None:
        return f"{plain(axis)}: the sweeps differ; {plain(one_sweep['label'])}: {words} Hz{more}"
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
    drawn: list[tuple[Curve, str, dict[str, Any]]] = []
    look: dict[str, Any]
    if tracked is not None:
        look = {"linestyle": "none", "marker": ".", "markersize": 2.2, "color": COLOURS["quiet"], "zorder": 1}
        drawn.append((tracked, "tracking filter", look))
    if other is not None:
        look = {"linestyle": "--", "color": COLOURS["vermilion"], "linewidth": 1.1, "zorder": 2}
        drawn.append((other, plain(other.get("test", "")), look))
    label = plain(model.get("test", "")) if other is not None else "modes"
    drawn.append((model, label, {"color": COLOURS["blue"], "linewidth": 1.1, "zorder": 3}))
    for curve, name, look in drawn:
        size.plot(numbers(curve, "frequency"), numbers(curve, "transmissibility"), label=name, **look)
        phase.plot(numbers(curve, "frequency"), _unbroken(np.degrees(numbers(curve, "phase"))), label=name, **look)
    for ax in axes:
        log_axis(ax, "x", numbers(model, "frequency"), 1.05)
    log_axis(size, "y", np.concatenate([numbers(curve, "transmissibility") for curve, _, _ in drawn]), 1.2)
    phase.set_ylim(-190.0, 190.0)
    phase.set_yticks([-180, -90, 0, 90, 180])
    set_title(size, title)
    own = unit(model, "transmissibility")
    set_labels(size, y="transmissibility" if own in ("", "1") else with_unit("transmissibility", own))
    set_labels(phase, "frequency [Hz]", "phase [deg]")
    set_legend(phase)


def _unbroken(degrees: Array) -> Array:
    """Return phases with nothing drawn from one end of the circle to the other."""
    found = degrees.copy()
    found[1:][np.abs(np.diff(degrees)) > 180.0] = np.nan
    return found


__all__ = ["NAME", "draw", "finding", "pictures"]
