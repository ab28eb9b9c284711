"""Distribution of a figure over the units of a lot, with limits, and the population without the tests' own scatter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "lot_distribution"
SHOWS = "Units by value, as measured; the normal population without what the tests scatter; limits"
HEIGHT = 1.7  # [in]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a figure."""
    found = curves(results, NAME)
    laws = {(one.get("test"), one.get("axis"), one.get("of")): one for one in curves(results, "lot_population")}
    return [_picture(one, laws.get((one.get("test"), one.get("axis"), one.get("of"))))
            for one in found if len(finite(numbers(one, "units")))]  # fmt: skip


def _picture(curve: Curve, law: Curve | None) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], curve, law, title)

    test, axis, finding = (str(curve.get(name, "")) for name in ("test", "axis", "finding"))
    data = [curve] if law is None else [curve, law]
    return Picture(NAME, test, axis, plain(finding, 400), SHOWS, (HEIGHT,), paint, data=data)


def draw(ax: Axes, curve: Curve, law: Curve | None, title: str = "") -> None:
    """Draw a distribution.

    Parameters
    ----------
    ax : Axes
        To draw on.
    curve, law : mapping
        ``lot_distribution`` and ``lot_population``; no population where none is known.
    title : str
        Above; empty for none.
    """
    low, high, count = (numbers(curve, name) for name in ("from", "to", "units"))
    ax.bar(low, count, high - low, align="edge", color=COLOURS["sky"], linewidth=0.0, label="units, as measured")
    if law is not None:
        x, y = numbers(law, "value"), numbers(law, "units")
        ax.plot(x, y, color=COLOURS["blue"], lw=1.4, label="population, the tests' scatter taken off")
    for name in ("lower", "upper"):
        limit = finite(numbers(curve, name))
        for at in np.unique(limit):
            label = "limits" if not any(line.get_label() == "limits" for line in ax.lines) else "_"
            ax.axvline(float(at), color=COLOURS["vermilion"], ls="--", lw=1.2, label=label)
    set_title(ax, title)
    set_labels(ax, with_unit(plain(curve.get("of", "")), unit(curve, "from")), "units")
    set_legend(ax)
