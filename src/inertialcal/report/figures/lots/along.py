"""A figure along a lot: means of units that follow each other, with the middle 90 % of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.metrics import shortened
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, TEXT, plain, set_labels, set_legend, set_title, with_unit

NAME = "lot_along"
SHOWS = "Means of units that follow each other, and the middle 90 % of these units, along the lot"
HEIGHT = 1.5  # [in]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a figure."""
    return [_picture(one) for one in curves(results, NAME) if len(finite(numbers(one, "mean")))]


def _picture(curve: Curve) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], curve, title)

    test, axis, finding = (str(curve.get(name, "")) for name in ("test", "axis", "finding"))
    return Picture(NAME, test, axis, plain(finding, 400), SHOWS, (HEIGHT,), paint, data=[curve])


def draw(ax: Axes, curve: Curve, title: str = "") -> None:
    """Draw a figure along a lot.

    Parameters
    ----------
    ax : Axes
        To draw on.
    curve : mapping
        ``lot_along``.
    title : str
        Above; empty for none.
    """
    place, mean, u, low, high = (numbers(curve, name) for name in ("place", "mean", "u", "low", "high"))
    ax.fill_between(place, low, high, color=COLOURS["sky"], alpha=0.35, lw=0.0, label="middle 90 % of units", zorder=1)
    ax.errorbar(
        place, mean, yerr=1.96 * u, fmt=".", ms=4.0, lw=0.9, color=COLOURS["blue"], label="mean, 95 %", zorder=3
    )
    set_title(ax, title)
    what = shortened(with_unit(plain(curve.get("of", "")), unit(curve, "mean")), TEXT, 72.0 * HEIGHT - 6.0)
    set_labels(ax, with_unit("along the lot", unit(curve, "place")), what)
    set_legend(ax)
