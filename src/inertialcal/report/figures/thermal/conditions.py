"""Bias over temperature in two conditions, vacuum and air say: both polynomials with 95 % bands, a panel an axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes

from ....core.show.rounding import with_uncertainty
from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "conditions"
SHOWS = "Bias over temperature in this test and in the one it is compared with; 95 % bands, one panel per axis"
HEIGHT = 1.4  # of a panel [in]
OFFSETS = ("vacuum_offset", "bias_shift")


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return one picture for each test that is compared with another."""
    laws = [one for one in curves(results, "thermal_law") if len(finite(numbers(one, "bias")))]
    found = []
    for step in results.get("sequence", []):
        pairs = _pairs(laws, step["test"], step.get("against"))
        if pairs:
            rows = [row for row in results.get("results", []) if row["test"] == step["test"]]
            found.append(_picture(step["test"], step["against"], pairs, rows))
    return found


def _pairs(laws: Sequence[Curve], test: str, other: str | None) -> list[tuple[Curve, Curve]]:
    theirs = {one.get("axis"): one for one in laws if other is not None and one.get("test") == other}
    return [(one, theirs[one.get("axis")]) for one in laws if one.get("test") == test and one.get("axis") in theirs]


def _picture(test: str, other: str, pairs: Sequence[tuple[Curve, Curve]], rows: Sequence[Mapping[str, Any]]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, pairs, title)

    return Picture(NAME, test, "", finding(other, rows), SHOWS, (HEIGHT,) * len(pairs), paint)


def finding(other: str, rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the finding: what each axis differs by at the reference temperature."""
    parts: dict[str, str] = {}
    for row in rows:
        if row["quantity"] in OFFSETS and row["value"] is not None:
            figure = with_uncertainty(row["value"], row["u"])
            parts.setdefault(str(row["axis"]), f"{plain(row['axis'], 12)} {figure} {plain(row['unit'])}")
    return f"against {plain(other)}: {', '.join(parts.values()) or 'difference not estimated'}"


def draw(axes: Sequence[Axes], pairs: Sequence[tuple[Curve, Curve]], title: str = "") -> None:
    """Draw both laws of all axes."""
    for ax, pair in zip(axes, pairs, strict=True):
        for curve, colour, dashes in zip(pair, ("blue", "vermilion"), ("-", "--"), strict=True):
            T, bias, lo, hi = (numbers(curve, name) for name in ("temperature", "bias", "lo", "hi"))
            ax.fill_between(T, lo, hi, color=COLOURS[colour], alpha=0.25, linewidth=0.0, zorder=1)
            label = plain(curve.get("test", ""))
            ax.plot(T, bias, dashes, color=COLOURS[colour], linewidth=1.2, label=label, zorder=3)
        set_labels(ax, y=with_unit(f"{plain(pair[0].get('axis', ''), 12)} bias", unit(pair[0], "bias")))
    set_title(axes[0], title)
    set_labels(axes[-1], with_unit("temperature", unit(pairs[0][0], "temperature")))
    set_legend(axes[-1])
