"""History of a figure of one unit: tests with 95 % intervals, the line through them, and where it goes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from ..drawing.data import Curve, curves, finite, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_legend, set_title, with_unit

NAME = "archive_history"
LINE = "archive_line"
SHOWS = "Figure of each test over the year, its 95 % interval as a bar; the line through the tests with its 95 % band"
HEIGHT = 2.4  # [in]
AHEAD = 1.0  # years that limits go on where no line does
SPAN = 2.5  # years, at least: two of them have a tick


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a figure of the unit; its line, where it has one, is the curve of the same ``of``."""
    lines = {_of(one): one for one in curves(results, LINE)}
    found = [one for one in curves(results, NAME) if len(finite(numbers(one, "value")))]
    return [_picture(one, lines.get(_of(one))) for one in found]


def _of(curve: Curve) -> tuple[str, ...]:
    return tuple(str(curve.get(name, "")) for name in ("test", "axis", "of", "condition"))


def _picture(curve: Curve, line: Curve | None) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, curve, line, title)

    data = [curve] if line is None else [curve, line]
    note = () if line is None else ("; the line through them, with the 95 % interval of the unit",)
    return Picture(
        NAME,
        str(curve["test"]),
        str(curve["axis"]),
        plain(curve.get("finding", ""), 400),
        SHOWS,
        (HEIGHT,),
        paint,
        data=data,
        note=note,
    )


def draw(axes: Sequence[Axes], curve: Curve, line: Curve | None, title: str = "") -> None:
    """Draw the tests of a unit over time.

    Parameters
    ----------
    axes : sequence of Axes, length 1
        To draw on.
    curve, line : mapping
        ``archive_history``; ``archive_line``, None where there is none.
    title : str
        Above; empty for none.
    """
    (ax,) = axes
    if line is not None:
        years, values, half = (numbers(line, name) for name in ("year", "value", "half"))
        ax.plot(years, values, color=COLOURS["orange"], label="line through the tests")
        look: dict[str, Any] = {"color": COLOURS["orange"], "alpha": 0.2, "lw": 0}
        ax.fill_between(years, values - half, values + half, label="95 % of the unit", **look)
    tests: dict[str, Any] = {"fmt": "o", "color": COLOURS["blue"], "ms": 4.0, "capsize": 2.0, "label": "tests, 95 %"}
    years = numbers(curve, "year")
    ax.errorbar(years, numbers(curve, "value"), yerr=numbers(curve, "half"), **tests)
    end = years[-1] + AHEAD if line is None else numbers(line, "year")[-1]
    for name, label in (("low", "limit since the last test"), ("high", "_other")):
        if name in curve["columns"]:
            level = [numbers(curve, name)[-1]] * 2
            ax.plot([years[-1], end], level, color=COLOURS["vermilion"], ls="--", lw=1.0, label=label)
    left, right = ax.get_xlim()
    if right - left < SPAN:
        ax.set_xlim(0.5 * (left + right - SPAN), 0.5 * (left + right + SPAN))
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.ticklabel_format(axis="x", useOffset=False)
    set_title(ax, title)
    set_labels(ax, "year", with_unit(plain(curve.get("of", "")), unit(curve, "value")))
    set_legend(ax)
