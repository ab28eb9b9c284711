"""Ticks of an axis with their labels, as few shapes: marks as one line, labels as texts.

The ticks of matplotlib can be moved and styled one by one, each of five shapes; a figure of a page stays as it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation

from .metrics import shortened
from .style import COLOURS, TEXT

INCH = 72.0  # [pt]
MARK, PAD = 3.5, 3.5  # length of a tick, and the gap to its label [pt]
TICK = MARK + PAD
GAP = 4.0  # between tick labels, label and legend [pt]
TICK_TEXT = TEXT - 1.0
MOST_TICKS = 6  # but one, of a linear axis
LONGEST = 200.0  # width of a label [pt]
BEHIND = 0.5  # order of drawing: under the data

Ticks = tuple[Sequence[float], Sequence[str]]


@dataclass(frozen=True)
class Side:
    """Where an axis has its labels, in shares of its panel, and which way is out."""

    x: float
    y: float
    out: tuple[float, float]
    ha: str
    va: str
    mark: Literal[0, 2, 3]
    turned: float


BOTTOM = Side(0.5, 0.0, (0.0, -1.0), "center", "top", 3, 0.0)  # marks: TICKDOWN, TICKLEFT of matplotlib
TOP = Side(0.5, 1.0, (0.0, 1.0), "center", "bottom", 2, 0.0)
LEFT = Side(0.0, 0.5, (-1.0, 0.0), "right", "center_baseline", 0, 90.0)


def is_on_top(axis: Axis) -> bool:
    """Return whether the labels of an axis stand above its panel."""
    return axis.get_label_position() == "top"


def is_labelled(axis: Axis) -> bool:
    """Return whether an axis shows the labels of its ticks."""
    shown = axis.get_tick_params()
    return bool(shown.get("labelbottom", True) or shown.get("labeltop", False))


def count(axis: Axis) -> None:
    """Tick an axis of numbers in order at whole numbers."""
    axis.set_major_locator(MaxNLocator(steps=[1, 2, 5, 10], integer=True))


def ticks_of(axis: Axis) -> Ticks:
    """Return the places of the ticks that are seen, and their labels; none where an axis shows none."""
    if not is_labelled(axis):
        return (), ()
    if isinstance(locator := axis.get_major_locator(), MaxNLocator):
        locator.set_params(nbins=MOST_TICKS)
    low, high = sorted(axis.get_view_interval())
    places = axis.get_majorticklocs().tolist()
    labels = axis.get_major_formatter().format_ticks(places)
    seen = [
        (place, shortened(label, TICK_TEXT, LONGEST))
        for place, label in zip(places, labels, strict=True)
        if low <= place <= high
    ]
    return [place for place, _ in seen], [label for _, label in seen]


def draw_ticks(axis: Axis, ticks: Ticks, room: float) -> None:
    """Draw ticks, their labels and the label of the axis, instead of the axis itself.

    Parameters
    ----------
    axis : Axis
        Whose; it is hidden.
    ticks : tuple
        Places and labels.
    room : float
        From the panel outwards, what the labels of ticks take. [pt]
    """
    axis.set_visible(False)
    ax = axis.axes
    side = LEFT if axis is ax.yaxis else TOP if is_on_top(axis) else BOTTOM
    _marks(ax, axis, ticks[0], side)
    along = ax.get_yaxis_transform() if side is LEFT else ax.get_xaxis_transform()
    size = axis.get_tick_params().get("labelsize", TICK_TEXT)
    for place, label in zip(*ticks, strict=True):
        x, y = (side.x, place) if side is LEFT else (place, side.y)
        ax.text(
            x, y, label, transform=along + _away(ax, side, TICK), ha=side.ha, va=side.va, size=size,
            parse_math=False, zorder=BEHIND, clip_on=False,
        )  # fmt: skip
    beyond = TICK + room + GAP if ticks[0] else GAP
    if axis.label.get_text():
        ax.text(
            side.x, side.y, axis.label.get_text(), transform=ax.transAxes + _away(ax, side, beyond), ha="center",
            va="bottom" if side is LEFT else side.va, rotation=side.turned, rotation_mode="anchor",
            size=TEXT, parse_math=False, zorder=BEHIND, clip_on=False,
        )  # fmt: skip


def _marks(ax: Axes, axis: Axis, places: Sequence[float], side: Side) -> None:
    """Draw the marks of all ticks as one line of markers, unless they have no length."""
    if not places or not axis.get_tick_params().get("length", MARK):
        return
    across = [side.x if side is LEFT else side.y] * len(places)
    along = ax.get_yaxis_transform() if side is LEFT else ax.get_xaxis_transform()
    x, y = (across, places) if side is LEFT else (places, across)
    ax.add_artist(
        Line2D(
            x,
            y,
            transform=along,
            linestyle="none",
            marker=side.mark,
            markersize=MARK,
            markeredgewidth=0.8,
            color=COLOURS["quiet"],
            zorder=BEHIND,
            clip_on=False,
        )
    )


def _away(ax: Axes, side: Side, points: float) -> ScaledTranslation:
    x, y = side.out
    scale = ax.figure.dpi_scale_trans
    return ScaledTranslation(points / INCH * x, points / INCH * y, scale)
