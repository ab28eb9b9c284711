"""History of a figure of one unit: tests with 95 % intervals, the line through them, and where it goes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes

from ....core.estimate import Array
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "history"
SHOWS = "Figure of each test over the year, its 95 % interval as a bar; the line through the tests with its 95 % band"
HEIGHT = 2.4  # [in]


@dataclass(frozen=True, eq=False)
class Drawn:
    """What is drawn."""

    what: str  # Figure, in words
    unit: str
    finding: str
    years: Array  # Of each test
    values: Array
    half: Array  # Half of the 95 % interval of each
    line_years: Array  # Empty where there is no line
    line: Array
    band: Array  # Half of its 95 % interval
    limits: tuple[float, float] | None = None  # That the unit may reach before it is calibrated again


def picture(drawn: Drawn) -> Picture:
    """Return the picture of one figure."""

    def paint(axes: Sequence[Axes], title: str) -> None:
        ax = axes[0]
        if drawn.line_years.size:
            ax.plot(drawn.line_years, drawn.line, color=COLOURS["orange"], label="line through the tests")
            ends = (drawn.line - drawn.band, drawn.line + drawn.band)
            ax.fill_between(drawn.line_years, *ends, color=COLOURS["orange"], alpha=0.2, lw=0, label="95 % of the unit")
        look: dict[str, Any] = {"fmt": "o", "color": COLOURS["blue"], "ms": 4.0, "capsize": 2.0, "label": "tests, 95 %"}
        ax.errorbar(drawn.years, drawn.values, yerr=drawn.half, **look)
        for i, limit in enumerate(drawn.limits or ()):
            label = "limit since the last test" if not i else "_other"
            ax.axhline(limit, color=COLOURS["vermilion"], ls="--", lw=1.0, label=label)
        ax.ticklabel_format(axis="x", useOffset=False)
        set_title(ax, title)
        set_labels(ax, "year", with_unit(plain(drawn.what), drawn.unit))
        set_legend(ax)

    return Picture(NAME, "", "", drawn.finding, SHOWS, (HEIGHT,), paint)
