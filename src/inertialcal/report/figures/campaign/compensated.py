"""Errors of hold-out dwells, raw and compensated, against the applied input: one panel per axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ....core.estimate import Array
from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, thinned, unit
from ..drawing.picture import Picture
from ..drawing.scales import signed_log
from ..drawing.style import COLOURS, WIDTH, plain, set_labels, set_legend, set_title, with_unit

NAME = "compensated"
SHOWS = "Error of each hold-out dwell against the applied input, raw and compensated, one panel per axis"
OTHERS_TURNED = " At rest: the distribution over the dwells while other axes turned."
STILL = 0.01  # of the largest input: counts as zero
MOST = 400  # dwells drawn per panel; of more, the smallest and largest of each bin
STRIP, GAP = 0.2, 0.03  # of the width of a panel: the distribution at rest, and what is free beside it
BINS = 24  # of that distribution
APART = 3.6  # width of the panel of one axis that stands alone [in]
SERIES: dict[str, dict[str, Any]] = {
    "raw_error": {
        "marker": "D", "markerfacecolor": "none", "markeredgecolor": COLOURS["vermilion"], "markersize": 4.5,
        "label": "raw",
    },
    "compensated_error": {"marker": "o", "color": COLOURS["blue"], "markersize": 3.6, "label": "compensated"},
}  # fmt: skip


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return the one picture of the closed loop, if it was run."""
    found = [curve for curve in curves(results, NAME) if len(finite(numbers(curve, "raw_error")))]
    if not found:
        return []

    loop = results.get("closed_loop", {}).get("axes", [])
    one_each = [_picture([one], [row for row in loop if row["axis"] == one.get("axis")], APART) for one in found]
    return [_picture(found, loop, WIDTH, tuple(one_each) if len(found) > 1 else ())]


def _picture(
    found: Sequence[Curve], loop: Sequence[Mapping[str, Any]], width: float, apart: tuple[Picture, ...] = ()
) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, found, title)

    heights = (1.35 if width == WIDTH else 2.0,) * len(found)
    note = (OTHERS_TURNED,) if others_turned(found) else ()
    test = str(found[0].get("test", ""))
    return Picture(NAME, test, "", finding(found, loop), SHOWS, heights, paint, note=note, width=width, apart=apart)


def others_turned(found: Sequence[Curve]) -> bool:
    """Return whether most dwells of an axis have zero input because other axes turned."""
    return any(2 * np.sum(still) > len(still) for still in map(at_rest, found) if not np.all(still))


def at_rest(curve: Curve) -> NDArray[np.bool_]:
    """Return which dwells of an axis have an input that counts as zero, shape (n,)."""
    sizes = np.abs(numbers(curve, "applied"))
    known = finite(sizes)
    return np.asarray(sizes < STILL * np.max(known)) if len(known) else np.zeros(len(sizes), dtype=np.bool_)


def finding(found: Sequence[Curve], loop: Sequence[Mapping[str, Any]]) -> str:
    """Return the finding: the error of each axis before and after."""
    parts = [
        f"{plain(one['axis'])} {number(one['raw_rms'], 2)} → {number(one['compensated_rms'], 2)}"
        for one in loop
        if one["raw_rms"] is not None and one["compensated_rms"] is not None
    ]
    if parts:
        return f"rms error on hold-out dwells: {', '.join(parts)} {plain(loop[0]['unit'])}"
    dwells = sum(len(finite(numbers(curve, "raw_error"))) for curve in found)
    return f"{dwells} hold-out dwells, raw and compensated"


def draw(axes: Sequence[Axes], found: Sequence[Curve], title: str = "") -> None:
    """Draw each axis on a panel of its own."""
    piled = others_turned(found)
    still = [at_rest(curve) & piled for curve in found]
    everything = np.concatenate([numbers(one, "applied")[~rest] for one, rest in zip(found, still, strict=True)])
    for ax, curve, rest in zip(axes, found, still, strict=True):
        signed_log(ax, "x", everything)
        ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
        applied = numbers(curve, "applied")
        for name, look in SERIES.items():
            values = numbers(curve, name)
            at = np.flatnonzero(~rest)
            at = at[thinned(values[at], MOST)]
            ax.plot(applied[at], values[at], linestyle="none", zorder=3, **look)
        if piled:
            _distribution(ax, curve, rest, finite(everything))
        set_labels(ax, y=with_unit(f"{plain(curve.get('axis', ''), 12)} error", unit(curve, "raw_error")))
    for ax in axes[:-1]:
        ax.tick_params(labelbottom=False)
    set_title(axes[0], title)
    set_labels(axes[-1], with_unit("applied", unit(found[0], "applied")))
    set_legend(axes[-1])


def _distribution(ax: Axes, curve: Curve, rest: NDArray[np.bool_], everything: Array) -> None:
    """Draw the errors at rest as a distribution, in a strip at the right of the panel that has no input axis."""
    scale = ax.xaxis.get_transform()
    low, high = scale.transform(np.array([np.min(everything), np.max(everything)]))
    edge = GAP * (high - low)
    whole = (high - low + 2.0 * edge) / (1.0 - STRIP - GAP)
    ticks = [one for one in ax.get_xticks() if np.min(everything) <= one <= np.max(everything)]
    labels = ax.xaxis.get_major_formatter().format_ticks(ticks)
    start, end, middle = scale.inverted().transform(low - edge + whole * np.array([0.0, 1.0, 1.0 - STRIP / 2.0]))
    ax.set_xlim(start, end)
    ax.set_xticks([*ticks, middle], [*labels, "at rest"], parse_math=False)
    errors = {name: finite(numbers(curve, name)) for name in SERIES}
    every = np.concatenate(list(errors.values()))
    edges = np.linspace(np.min(every), np.max(every), BINS + 1)
    margin = 0.06 * (edges[-1] - edges[0])
    if margin > 0.0:
        ax.set_ylim(edges[0] - margin, edges[-1] + margin)
        counts = {name: np.histogram(finite(numbers(curve, name)[rest]), edges)[0] for name in SERIES}
        for name, counted in counts.items():
            long = 1.0 - STRIP + 0.97 * STRIP * counted / max(int(np.max(counted)), 1)
            colour = SERIES[name].get("color", SERIES[name].get("markeredgecolor"))
            ax.stairs(long, edges, baseline=1.0 - STRIP, orientation="horizontal", transform=ax.get_yaxis_transform(),
                      fill=name == "compensated_error", color=colour, linewidth=1.0, zorder=2)  # fmt: skip
    ax.plot([1.0 - STRIP] * 2, [0.0, 1.0], transform=ax.transAxes, color=COLOURS["grid"], linewidth=0.8, zorder=1)
