"""Looks and names of noise terms, the same in every figure: each differs in colour and in stroke."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ...core.estimate import Array
from ...core.rounding import with_uncertainty
from .data import Curve, numbers
from .style import COLOURS, plain

ALL = "all"
KNOWN = ("tau", "deviation", "lo", "hi", "edf", "noise", "expected", "frequency", "density", "line", ALL)
STROKES: dict[str, dict[str, Any]] = {
    "quantization": {"color": COLOURS["purple"], "linestyle": (0, (1, 1))},
    "random_walk": {"color": COLOURS["green"], "linestyle": (0, (6, 2))},
    "bias_instability": {"color": COLOURS["orange"], "linestyle": (0, (6, 2, 1, 2))},
    "rate_random_walk": {"color": COLOURS["purple"], "linestyle": (0, (3, 2))},
    "rate_ramp": {"color": COLOURS["quiet"], "linestyle": (0, (6, 2, 1, 2, 1, 2))},
    "gauss_markov": {"color": COLOURS["sky"], "linestyle": (0, (4, 2))},
}
ALIKE = {  # the field's words by kind of sensor
    "angle_random_walk": "random_walk",
    "velocity_random_walk": "random_walk",
    "acceleration_random_walk": "rate_random_walk",
    "acceleration_ramp": "rate_ramp",
}
OTHER: dict[str, Any] = {"color": COLOURS["quiet"], "linestyle": (0, (1, 2))}
WHOLE: dict[str, Any] = {"color": COLOURS["vermilion"], "linewidth": 1.6}
NAMED = 3  # terms in a finding
DOTS: tuple[dict[str, Any], ...] = (
    {"marker": "o", "color": COLOURS["blue"], "markersize": 3.6},
    {"marker": "s", "color": COLOURS["blue"], "markersize": 3.4, "markerfacecolor": "none"},
    {"marker": "^", "color": COLOURS["blue"], "markersize": 4.0},
    {"marker": "D", "color": COLOURS["blue"], "markersize": 3.2, "markerfacecolor": "none"},
)  # of records


def draw_terms(ax: Axes, at: Array, curve: Curve) -> None:
    """Draw each term, and all of them together.

    Parameters
    ----------
    ax : Axes
        Where.
    at : ndarray, shape (n,)
        Averaging time or frequency.
    curve : mapping
        ``allan_terms`` or ``spectrum`` of ``results.json``.
    """
    names = terms_of(curve)
    for name in names:
        stroke = STROKES.get(ALIKE.get(name, name), OTHER)
        ax.plot(at, _positive(numbers(curve, name)), linewidth=1.1, zorder=3, label=plain(name.replace("_", " ")),
                **stroke)  # fmt: skip
    if ALL in curve["columns"] and names:
        label = "all terms" if len(names) > 1 else "as fitted"
        ax.plot(at, _positive(numbers(curve, ALL)), zorder=4, label=label, **WHOLE)


def terms_of(curve: Curve) -> list[str]:
    """Return the columns of a curve that are terms."""
    return [name for name in curve["columns"] if name not in KNOWN]


def _positive(values: Array) -> Array:
    return np.where(values > 0.0, values, np.nan)


def finding(results: Mapping[str, Any], test: str, axis: str, otherwise: str) -> str:
    """Return the finding: the terms of an axis with their uncertainty; ``otherwise`` where none is known."""
    parts = list(_told(results.get("results", []), test, axis))
    return f"{plain(axis)}: {', '.join(parts[:NAMED]) or otherwise}"


def _told(rows: Sequence[Mapping[str, Any]], test: str, axis: str) -> Iterator[str]:
    for row in rows:
        mine = (row["test"], row["axis"]) == (test, axis) and row["status"] == "estimated"
        name = str(row["quantity"])
        term = ALIKE.get(name, name.removesuffix("_sigma"))
        if mine and term in STROKES and " alone" not in row["condition"]:
            yield f"{name.replace('_', ' ')} {with_uncertainty(row['value'], row['u'])} {plain(row['unit'])}"
