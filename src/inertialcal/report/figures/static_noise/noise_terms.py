"""Looks and names of noise terms, the same in every figure: each differs in colour and in stroke.

The Allan deviation of a line falls to nothing at every whole period. Of lines the peaks are drawn, joined, all lines of
an axis as one; and all terms together at the averaging times of the data, where the two are to be compared.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.estimate import Array
from ....core.results import case_of
from ....core.show.rounding import with_uncertainty
from ....core.show.rows import reason_code, reason_text
from ....core.show.wording import words
from ....sensors.noise.terms import GaussMarkov, quantity_name
from ..drawing.data import Curve, numbers, unit
from ..drawing.style import COLOURS, plain

ALL = "all"
KNOWN = ("tau", "deviation", "lo", "hi", "edf", "noise", "expected", "frequency", "density", "line", "corner", ALL)
STROKES: dict[str, dict[str, Any]] = {
    "quantization": {"color": COLOURS["purple"], "linestyle": (0, (1, 1))},
    "random_walk": {"color": COLOURS["green"], "linestyle": (0, (6, 2))},
    "bias_instability": {"color": COLOURS["orange"], "linestyle": (0, (6, 2, 1, 2))},
    "rate_random_walk": {"color": COLOURS["purple"], "linestyle": (0, (3, 2))},
    "rate_ramp": {"color": COLOURS["quiet"], "linestyle": (0, (6, 2, 1, 2, 1, 2))},
    "gauss_markov": {"color": COLOURS["sky"], "linestyle": (0, (4, 2))},
}
SIZES = {quantity_name(GaussMarkov.name, "sigma", None): GaussMarkov.name}  # quantity that a term is told by
ALIKE = SIZES | {  # the field's words by kind of sensor
    "angle_random_walk": "random_walk",
    "velocity_random_walk": "random_walk",
    "acceleration_random_walk": "rate_random_walk",
    "acceleration_ramp": "rate_ramp",
}
OTHER: dict[str, Any] = {"color": COLOURS["quiet"], "linestyle": (0, (1, 2))}
WHOLE: dict[str, Any] = {"color": COLOURS["vermilion"], "linewidth": 1.6}
LONGEST = 120  # characters of a finding: two lines
FEIGNED = ("level_step", "slow_wave")  # codes of reasons for which slow terms are not estimated
IN_BAND = "in_band"  # code of the reason that says that a figure is the level inside the band of a filter
NAMED = 2  # terms in a finding with their figures: two lines of it
DOTS: tuple[dict[str, Any], ...] = (
    {"marker": "o", "color": COLOURS["blue"], "markersize": 3.6},
    {"marker": "s", "color": COLOURS["blue"], "markersize": 3.4, "markerfacecolor": "none"},
    {"marker": "^", "color": COLOURS["blue"], "markersize": 4.0},
    {"marker": "D", "color": COLOURS["blue"], "markersize": 3.2, "markerfacecolor": "none"},
)  # of records


def draw_terms(
    ax: Axes,
    at: Array,
    curve: Curve,
    lines: Sequence[Curve] = (),
    compared: tuple[Array, Array] | None = None,
) -> None:
    """Draw each term, and all of them together."""
    names = terms_of(curve)
    whole = ALL in curve["columns"]
    for name in names:
        alone = whole and len(names) == 1 and not lines
        stroke = WHOLE if alone else STROKES.get(ALIKE.get(name, name), OTHER)
        ax.plot(at, _positive(numbers(curve, name)), label=named(name), **{"linewidth": 1.1, "zorder": 3} | stroke)
    if lines:
        power = np.sum([peaks_joined(at, numbers(one, "deviation")) ** 2 for one in lines], axis=0)
        label = "peaks of the lines"
        if len(lines) == 1:
            label = f"peaks of the {numbers(lines[0], 'frequency')[0]:.4g} {unit(lines[0], 'frequency')} line"
        ax.plot(at, _positive(np.sqrt(power)), linewidth=1.1, zorder=3, label=label, **OTHER)
    if whole and len(names) + len(lines) > 1:
        x, y = compared if lines and compared is not None else (at, numbers(curve, ALL))
        ax.plot(x, _positive(y), label="all terms", **{"zorder": 4} | WHOLE)


def mark(ax: Axes, curve: Curve, column: str, label: str) -> None:
    """Draw where the band of a filter ends, where there is one."""
    if column in curve["columns"]:
        ax.axvline(float(numbers(curve, column)[0]), color=COLOURS["quiet"], linewidth=0.9, linestyle=(0, (5, 3)),
                   zorder=2, label=label)  # fmt: skip


def named(term: str) -> str:
    """Return the field's word of a term: ``"Gauss-Markov"``."""
    return plain(words(term))


def peaks_joined(at: Array, values: Array) -> Array:
    """Return a ringing curve without what lies below its peaks.

    Parameters
    ----------
    at, values : ndarray, shape (n,)
        Rising, and the curve over it; it rises to its largest value and rings down from there.

    Returns
    -------
    ndarray, shape (n,)
        The curve up to its largest value; from there, on logarithmic axes, its concave hull: straight over peaks that
        fall with a power of the averaging time.
    """
    known = np.where(np.isfinite(values) & (values > 0.0), values, 0.0)
    if not np.any(known):
        return known
    first = int(np.argmax(known))
    at_last = np.flatnonzero(known[first:] > 0.0) + first
    x, y = np.log(at[at_last]), np.log(known[at_last])
    hull: list[int] = []
    for c in range(len(x)):
        while len(hull) > 1:  # the middle one of three points goes if it lies on or under the line between the others
            a, b = hull[-2:]
            if (y[b] - y[a]) * (x[c] - x[a]) > (y[c] - y[a]) * (x[b] - x[a]):
                break
            hull.pop()
        hull.append(c)
    joined = np.exp(np.interp(np.log(at), x[hull], y[hull]))
    return np.where(np.arange(len(known)) < first, known, joined)


def terms_of(curve: Curve) -> list[str]:
    """Return the columns of a curve that are terms."""
    return [name for name in curve["columns"] if name not in KNOWN]


def _positive(values: Array) -> Array:
    return np.where(values > 0.0, values, np.nan)


def finding(results: Mapping[str, Any], test: str, axis: str, otherwise: str) -> str:
    """Return the finding: the terms of an axis with their uncertainty; ``otherwise`` where none is known.

    Where the terms do not hold, or a step or a wave feigns some of them, that is the finding: a row says so.
    """
    own = [
        row for row in results.get("results", []) if (row["test"], row["axis"]) == (test, axis) and case_of(row).plain
    ]
    mine = [
        (term, row)
        for row in own
        if row["status"] == "estimated"
        if (term := ALIKE.get(str(row["quantity"]), str(row["quantity"]))) in STROKES
    ]
    doubt = next((reason for _, row in mine if (reason := reason_text(row)) and reason_code(row) != IN_BAND), "")
    sized = [f"{_size(row)} {with_uncertainty(row['value'], row['u'])} {plain(row['unit'])}" for _, row in mine]
    others = [_size(row) for _, row in mine[NAMED:]]
    feigned = dict.fromkeys(reason_text(row) for row in own if reason_code(row) in FEIGNED)
    said = doubt or ", ".join([*sized[:NAMED], *others, *feigned]) or otherwise
    return f"{plain(axis)}: {plain(said, LONGEST)}"


def _size(row: Mapping[str, Any]) -> str:
    return named(SIZES.get(str(row["quantity"]), str(row["quantity"])))
