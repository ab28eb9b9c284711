"""Picture: one figure ready to be drawn, on axes that are given or on new ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .layout import place
from .style import WIDTH, look, set_heading, set_ticks

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

GAP = 0.9  # height that title, labels and legend take [in]
HEADING = 0.2  # height of a line of a heading beyond the second [in]


@dataclass(frozen=True, eq=False)
class Picture:
    """What one figure shows."""

    name: str  # which figure: ``"rate_error"``
    # of which test and axis; empty where it is about all of them
    test: str
    axis: str
    finding: str  # the finding, with rounded figures: the title
    shows: str  # what the axes are, for a reader who does not see them
    heights: tuple[float, ...]  # of each panel [in]
    draw: Callable[[Sequence[Axes], str], None]  # takes as many axes as there are panels, and a title (empty: none)
    share_x: bool = True  # whether the panels have one x axis
    # curves or rows of the results that it is drawn from; by default the curves that its figure names, of its test and
    # axis
    data: Sequence[Mapping[str, Any]] = ()
    note: tuple[str, ...] = ()  # what the caption of its figure says of these data; names of the user's are ``Quoted``
    width: float = WIDTH  # [in]
    # the same as several pictures, one a panel: a page has them side by side where it is wide, else below each other
    apart: tuple[Picture, ...] = ()

    @property
    def label(self) -> str:
        """Text for who does not see the figure."""
        return f"{self.finding}. {self.shows}"


def side_by_side(pictures: Sequence[Picture]) -> Figure:
    """Return one figure with several pictures beside each other, each with its title."""
    from matplotlib.figure import Figure as NewFigure  # noqa: PLC0415 - only where one is drawn

    high = max(sum(picture.heights) for picture in pictures) + GAP
    with look():
        whole = NewFigure(figsize=(WIDTH * len(pictures), high), layout="constrained", facecolor="white")
        parts = whole.subfigures(1, len(pictures), squeeze=False)[0]
        for part, picture in zip(parts, pictures, strict=True):
            _fill(part, picture)
            set_heading(part, picture.finding)
    return whole


def on_new_figure(picture: Picture, titled: bool, figure: Figure | None = None) -> Figure:
    """Return a figure with the picture on it."""
    from matplotlib.figure import Figure as NewFigure  # noqa: PLC0415 - only where one is drawn

    with look():
        fig = NewFigure() if figure is None else figure
        fig.set_size_inches(picture.width, sum(picture.heights) + GAP)
        fig.set_facecolor("white")
        if titled:
            fig.set_layout_engine("constrained")
            _fill(fig, picture)
            more = set_heading(fig, picture.finding) - 2
            fig.set_size_inches(picture.width, sum(picture.heights) + GAP + max(more, 0) * HEADING)
        else:
            place(fig, _fill(fig, picture), picture.heights)
    return fig


def _fill(part: Figure | SubFigure, picture: Picture) -> list[Axes]:
    """Return the panels, drawn."""
    ratios = {"height_ratios": picture.heights}
    grid = part.subplots(len(picture.heights), 1, sharex=picture.share_x, squeeze=False, gridspec_kw=ratios)
    axes = list(grid[:, 0])
    for ax in axes:
        set_ticks(ax)
    picture.draw(axes, "")
    for ax in axes[: len(axes) - 1 if picture.share_x else 0]:
        ax.tick_params(axis="x", bottom=False, labelbottom=False)  # those under the lowest panel are theirs too
    return axes
