"""Reference voltages over temperature, each less its mean: a panel a voltage, a colour and shape an axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ....core.show.rounding import number
from ..drawing.data import Curve, curves, finite, numbers, thinned, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "reference_voltage"
SHOWS = "Reference voltage less its mean over temperature, a panel a voltage, with the fitted curve of each axis"
HEIGHT = 1.5  # of a panel [in]
MOST = 150  # cells drawn of an axis
LOOKS = (("blue", "o"), ("vermilion", "s"), ("green", "^"))


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    every = [one for one in curves(results, NAME) if len(finite(numbers(one, "voltage")))]
    tests = dict.fromkeys(str(one.get("test", "")) for one in every)
    return [_picture(test, [one for one in every if one.get("test", "") == test]) for test in tests]


def _picture(test: str, mine: Sequence[Curve]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, mine, title)

    return Picture(NAME, test, "", finding(mine), SHOWS, (HEIGHT,) * len(_kinds(mine)), paint)


def _kinds(mine: Sequence[Curve]) -> list[str]:
    return list(dict.fromkeys(str(one.get("of", "")) for one in mine))


def _named(kind: str) -> str:
    """Return a kind of reference as an axis has room for it."""
    return plain(kind.removesuffix("_voltage"), 24).replace("_", " ")


def finding(mine: Sequence[Curve]) -> str:
    """Return the finding: by how much each kind of reference changes over the range."""
    parts = []
    for kind in _kinds(mine):
        own = [numbers(one, "fitted") for one in mine if one.get("of") == kind]
        most = max(float(np.ptp(finite(one))) for one in own)
        parts.append(f"{_named(kind)} changes by {number(most, 2)} {plain(unit(mine[0], 'voltage'))}")
    return f"{' and '.join(parts)} at most"


def draw(axes: Sequence[Axes], mine: Sequence[Curve], title: str = "") -> None:
    """Draw the reference voltages of a test."""
    for ax, kind in zip(axes, _kinds(mine), strict=True):
        own = [one for one in mine if one.get("of") == kind]
        for curve, (colour, shape) in zip(own, LOOKS, strict=False):
            T, volts, fitted = (numbers(curve, name) for name in ("temperature", "voltage", "fitted"))
            level = float(np.mean(finite(volts)))
            shown = thinned(volts, MOST)
            look: dict[str, Any] = {"marker": shape, "markersize": 3.0, "linestyle": "none", "alpha": 0.5}
            ax.plot(T[shown], volts[shown] - level, color=COLOURS[colour], zorder=2, **look)
            order = np.argsort(T)
            name = plain(curve.get("axis", ""), 12)
            ax.plot(T[order], fitted[order] - level, color=COLOURS[colour], linewidth=1.1, label=name, zorder=3)
        set_labels(ax, y=with_unit(_named(kind), unit(own[0], "voltage")))
    set_title(axes[0], title)
    set_labels(axes[-1], with_unit("temperature", unit(mine[0], "temperature")))
    set_legend(axes[-1])
