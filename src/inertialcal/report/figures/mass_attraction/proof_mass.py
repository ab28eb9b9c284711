"""Effect of the length of a proof mass on the amplitude, and the length at which it acts as a point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..drawing.data import Curve, curves, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "proof_mass"
SHOWS = "Effect of the proof mass on the amplitude over its length, at its radii: summed, and by the second-order rule"


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    return [
        Picture(NAME, str(one.get("test", "")), "", finding(one), SHOWS, (2.6,), partial(draw, one))
        for one in curves(results, NAME)
    ]


def finding(curve: Curve) -> str:
    """Return the finding: effect of the proof mass, and the length at which it acts as a point."""
    length, second, own = (numbers(curve, name) for name in ("length", "second_order", "own"))
    order = np.argsort(second)
    zero = float(np.interp(0.0, second[order], length[order]))
    return (
        f"the proof mass changes the amplitude by {own[np.isfinite(own)][0]:.2g} %; "
        f"{zero:.3g} {plain(unit(curve, 'length'))} is the length at which it acts as a point"
    )


def draw(curve: Curve, axes: Sequence[Axes], title: str) -> None:
    """Draw both, and the proof mass."""
    (ax,) = axes
    length, effect, second, own = (numbers(curve, name) for name in ("length", "effect", "second_order", "own"))
    ax.axhline(0.0, color=COLOURS["quiet"], linewidth=0.8)
    ax.plot(length, effect, color=COLOURS["blue"], label="summed over the proof mass", zorder=3)
    ax.plot(length, second, "--", color=COLOURS["orange"], label="second-order rule", zorder=3)
    ax.plot(length, own, "o", color=COLOURS["vermilion"], markersize=6.0, label="this proof mass", zorder=4)
    set_title(ax, title)
    set_labels(ax, with_unit("length", unit(curve, "length")), with_unit("effect on the amplitude", "%"))
    set_legend(ax)
