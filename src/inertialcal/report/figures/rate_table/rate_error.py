"""Error against rate with 95 % intervals and, where a requirement holds, its band.

A rate that was judged is drawn as it was judged: the error that the requirement asks about, with the interval that
holds for all its rates together; a shorter, thicker bar is the interval of that rate alone. The verdict shows in
shape and colour. The band stands over the rates that the condition of the requirement takes in, and nowhere else.
Each requirement has a panel of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.estimate import Array
from ....core.show.rounding import number
from ....core.show.rows import Quoted
from ....core.show.wording import tally
from ..drawing.data import Curve, curves, distinct, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.scales import signed_log
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "rate_error"
SHOWS = "Relative error over rate, with 95 % intervals and the limits of the requirement"
WORDS = ("FAIL", "INCONCLUSIVE", "PASS")
OF = {"dwell_mean": "error of a dwell mean", "expected": "expected error", "reading": "error of a reading"}
LOOKS: dict[str, dict[str, Any]] = {
    "PASS": {"marker": "o", "color": COLOURS["green"], "markersize": 5.0},
    "FAIL": {"marker": "X", "color": COLOURS["vermilion"], "markersize": 7.0},
    "INCONCLUSIVE": {
        "marker": "^", "markerfacecolor": COLOURS["orange"], "markeredgecolor": COLOURS["ink"], "markersize": 5.5,
        "markeredgewidth": 0.6,
    },
    "not judged": {
        "marker": "o", "markerfacecolor": COLOURS["paper"], "markeredgecolor": COLOURS["quiet"], "markersize": 4.0
    },
}  # fmt: skip
PAD = 0.04  # by which a band is wider than its rates, relative


@dataclass(frozen=True, eq=False)
class Points:
    """What one panel shows: a row a rate, in the units of the curve."""

    requirement: str  # Its identifier; empty where nothing was required
    rate: Array  # shape (n,)
    error: Array  # shape (n,)
    lo: Array  # shape (n,): lower end of the interval of that rate alone
    hi: Array  # shape (n,): upper end of the interval of that rate alone
    wide_lo: Array  # shape (n,): ends of the interval that it was judged by
    wide_hi: Array  # shape (n,): ends of the interval that it was judged by
    verdict: tuple[str, ...]  # ``"not judged"`` where the condition does not take the rate in
    lower: float  # Limits; NaN for none
    upper: float  # Limits; NaN for none
    of: str  # Which error


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test and axis, a panel a requirement."""
    found = []
    for curve in curves(results, NAME):
        if len(finite(numbers(curve, "error"))):
            found.append(_picture(curve, results.get("verdicts", [])))
    return found


def _picture(curve: Curve, verdicts: Sequence[Mapping[str, Any]]) -> Picture:
    panels = points(curve, verdicts)

    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, verdicts, title)

    test, axis = str(curve.get("test", "")), str(curve.get("axis", ""))
    note = judged_by(test, axis, verdicts)
    return Picture(NAME, test, axis, finding(curve, panels), SHOWS, (2.4,) * len(panels), paint, note=note)


def judged_by(test: str, axis: str, verdicts: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """Say what each requirement made of the errors."""
    mine = [one for one in verdicts if (one["test"], one["axis"]) == (test, axis)]
    said: list[str] = []
    for requirement in distinct(one["requirement"] for one in mine):
        said += ["; ", Quoted(requirement), " is ", tally([one for one in mine if one["requirement"] == requirement])]
    return tuple(said)


def points(curve: Curve, verdicts: Sequence[Mapping[str, Any]]) -> list[Points]:
    """Return what each panel shows: one a requirement on this test and axis, or one without a requirement."""
    mine = [
        one for one in verdicts
        if one["test"] == curve["test"] and one["axis"] == curve["axis"] and one["at"] is not None
    ]  # fmt: skip
    names = distinct(one["requirement"] for one in mine)
    return [_points(curve, name, [one for one in mine if one["requirement"] == name]) for name in names or [""]]


def _points(curve: Curve, requirement: str, judged: Sequence[Mapping[str, Any]]) -> Points:
    rate, error, lo, hi = (numbers(curve, name).copy() for name in ("rate", "error", "lo", "hi"))
    wide_lo, wide_hi = np.full(len(rate), np.nan), np.full(len(rate), np.nan)
    words = ["not judged"] * len(rate)
    for one in judged:
        for i in np.flatnonzero(rate == one["at"]):
            words[i] = one["verdict"]
            interval = one["interval"] or {"lo": None, "hi": None}
            wide_lo[i], wide_hi[i] = _nan(interval["lo"]), _nan(interval["hi"])
            if one["of"] != curve.get("of", ""):  # another error than the curve's: its own interval is not known
                error[i], lo[i], hi[i] = _nan(one["value"]), np.nan, np.nan
    first = judged[0] if judged else {"lower": None, "upper": None, "of": curve.get("of", "")}
    return Points(
        requirement, rate, error, lo, hi, wide_lo, wide_hi, tuple(words), _nan(first["lower"]), _nan(first["upper"]),
        str(first["of"]),
    )  # fmt: skip


def _nan(value: float | None) -> float:
    return np.nan if value is None else float(value)


def finding(curve: Curve, panels: Sequence[Points]) -> str:
    """Return the finding: the verdicts counted, or the largest error where nothing was required."""
    who = f"{plain(curve.get('axis', ''))}: "
    parts = []
    for one in panels:
        judged = [word for word in one.verdict if word in WORDS]
        counts = [f"{word} at {judged.count(word)}" for word in WORDS if word in judged]
        if counts:
            parts.append(f"{plain(one.requirement)} {', '.join(counts)} of {len(judged)} rates")
    if parts:
        return who + "; ".join(parts)
    error = numbers(curve, "error")
    at = int(np.nanargmax(np.abs(error)))
    largest, rate = number(float(error[at]), 2), number(float(numbers(curve, "rate")[at]), 3)
    return f"{who}largest error {largest} {unit(curve, 'error')}, at {rate} {unit(curve, 'rate')}"


def draw(axes: Sequence[Axes], curve: Curve, verdicts: Sequence[Mapping[str, Any]], title: str = "") -> None:
    """Draw the errors of one test and axis.

    Parameters
    ----------
    axes : sequence of Axes
        One a requirement on this test and axis, at least one.
    curve : mapping
        ``rate_error`` of ``results.json``.
    verdicts : sequence of mapping
        All of ``results.json``; those of this test and axis are taken.
    title : str
        Above the first; empty for none.
    """
    panels = points(curve, verdicts)
    for ax, one in zip(axes, panels, strict=True):
        signed_log(ax, "x", one.rate)
        limits = finite(np.array([one.lower, one.upper]))
        start = float(np.max(np.abs(limits))) if len(limits) and np.any(limits) else None
        shown = np.concatenate([one.error, one.lo, one.hi, one.wide_lo, one.wide_hi, limits])
        signed_log(ax, "y", shown, start or _typical(one.error))
        ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
        _band(ax, one)
        _bars(ax, one.rate, one.wide_lo, one.wide_hi, 0.8, "quiet", "95 % for all rates together")
        _bars(ax, one.rate, one.lo, one.hi, 1.8, "quiet", "95 % at this rate")
        words = np.array(one.verdict)
        for word in ("not judged", *reversed(WORDS)):
            mine = (words == word) & np.isfinite(one.error)
            if np.any(mine):
                label = f"{word} ({np.sum(mine)})" if one.requirement else "error"
                ax.plot(one.rate[mine], one.error[mine], linestyle="none", label=label, zorder=4, **LOOKS[word])
        what = OF.get(one.of, "error")
        set_labels(ax, y=with_unit(what, unit(curve, "error")))
    set_title(axes[0], title)
    set_labels(axes[-1], with_unit("rate", unit(curve, "rate")))
    set_legend(axes[-1], _handles(axes))


def _handles(axes: Sequence[Axes]) -> list[Any]:
    found: dict[str, Any] = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    return list(found.values())


def _typical(error: Array) -> float | None:
    """Return where the linear part ends where nothing is required: at the median size, if one is far beyond it."""
    sizes = np.abs(error[np.isfinite(error) & (error != 0.0)])
    if not len(sizes) or float(np.max(sizes)) < 50.0 * float(np.median(sizes)):
        return None
    return float(f"{np.median(sizes):.0e}")


def _bars(ax: Axes, x: Array, lo: Array, hi: Array, width: float, role: str, label: str) -> None:
    """Draw intervals as one line with breaks: hundreds of them stay one shape of the file."""
    known = np.isfinite(x) & np.isfinite(lo) & np.isfinite(hi)
    if np.any(known):
        gap = np.full(int(np.sum(known)), np.nan)
        xs, ys = np.stack([x[known], x[known], gap], axis=1), np.stack([lo[known], hi[known], gap], axis=1)
        ax.plot(xs.ravel(), ys.ravel(), color=COLOURS[role], linewidth=width, label=label, zorder=3)


def stretches(rate: Array, judged: Sequence[bool]) -> list[tuple[float, float]]:
    """Return the ranges of rates that were judged: neighbours together, but never across a change of sign."""
    found: list[list[float]] = []
    before = False
    order = np.argsort(rate, kind="stable")
    for value, inside in zip(rate[order].tolist(), np.asarray(judged, dtype=bool)[order].tolist(), strict=True):
        if inside and before and found[-1][1] * value >= 0.0:
            found[-1][1] = value
        elif inside:
            found.append([value, value])
        before = inside
    return [(first, last) for first, last in found]


def _band(ax: Axes, one: Points) -> None:
    low, high = one.lower, one.upper
    ends = ax.get_ylim()
    if not np.isfinite([low, high]).any():
        return
    label = f"within {plain(one.requirement)}"
    for count, (first, last) in enumerate(stretches(one.rate, [word in WORDS for word in one.verdict])):
        left, right = first - PAD * abs(first), last + PAD * abs(last)
        ax.fill_between(
            [left, right], low if np.isfinite(low) else ends[0], high if np.isfinite(high) else ends[1],
            color=COLOURS["sky"], alpha=0.25, linewidth=0.0, zorder=0, label=label if count == 0 else "_nolegend_",
        )  # fmt: skip
        for limit in finite(np.array([low, high])):
            ax.plot([left, right], [limit, limit], color=COLOURS["blue"], linewidth=1.0, zorder=2)
