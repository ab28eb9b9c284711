"""The look of every figure: one palette, one size of text, texts from data taken as they are.

Colours are those of Okabe and Ito, which colour-blind readers can tell apart; what differs in colour differs in
shape or hatch too. A role has one colour in light and one in dark: files are drawn in light, pages name the role
(``svg``) and let the reader's setting choose.

A figure is 5 inches wide, so that its text stays readable on a telephone.

References
----------
.. [1] M. Okabe and K. Ito, "Color Universal Design", 2002, rev. 2008: set of colours.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from textwrap import fill
from typing import Any

from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.transforms import offset_copy

from .metrics import folded, height, width

WIDTH = 5.0  # [in]
TEXT = 10.0  # [pt]
LINE = 62  # characters in a line of a title
LONGEST = 40  # characters of a name from the data
BELOW = -38.0  # of the legend under the axes, clear of their label [pt]
LEGEND = 270.0  # most that a legend is wide: it begins where its panel does, at up to 80 [pt]
BESIDE = 60.0  # of a figure, that its legend leaves free [pt]
LEGEND_TEXT = TEXT - 1.0  # [pt]
MOST_COLUMNS = 3  # of a legend
HANDLE = 2.5 * LEGEND_TEXT  # width of what stands before a label of the legend [pt]
COLUMN_GAP, ROW_GAP = 11.0, 4.5  # of a legend [pt]

# role -> (light, dark); the light ones differ from each other, so that a page can find them again.
ROLES: dict[str, tuple[str, str]] = {
    "ink": ("#1b1b1b", "#e8e8e8"),
    "quiet": ("#595959", "#b0b0b0"),
    "grid": ("#d9d9d9", "#3d4248"),
    "paper": ("#fffffe", "#16191d"),
    "blue": ("#0072b2", "#4aa8e0"),
    "orange": ("#e69f00", "#f0b429"),
    "green": ("#009e73", "#2fc79b"),
    "vermilion": ("#d55e00", "#ff8a4c"),
    "sky": ("#56b4e9", "#6fc3f0"),
    "purple": ("#cc79a7", "#dd94bd"),
    "yellow": ("#f0e442", "#f5ea6b"),
}
COLOURS = {role: light for role, (light, _) in ROLES.items()}

_RC: Any = {
    "text.parse_math": False,
    "text.usetex": False,
    "text.color": COLOURS["ink"],
    "font.family": ["sans-serif"],
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": TEXT,
    "axes.titlesize": TEXT + 0.5,
    "axes.titlelocation": "left",
    "axes.titlepad": 8.0,
    "axes.labelsize": TEXT,
    "axes.labelcolor": COLOURS["ink"],
    "axes.edgecolor": COLOURS["quiet"],
    "axes.facecolor": "none",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "axes.formatter.use_mathtext": False,
    "axes.formatter.use_locale": False,
    "axes.axisbelow": True,
    "axes.grid": False,
    "xtick.labelsize": TEXT - 1.0,
    "ytick.labelsize": TEXT - 1.0,
    "xtick.color": COLOURS["quiet"],
    "ytick.color": COLOURS["quiet"],
    "xtick.labelcolor": COLOURS["ink"],
    "ytick.labelcolor": COLOURS["ink"],
    "grid.color": COLOURS["grid"],
    "grid.linewidth": 0.6,
    "legend.fontsize": LEGEND_TEXT,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    "lines.markersize": 5.0,
    "hatch.linewidth": 0.8,
    "path.simplify": False,
}


@contextmanager
def look() -> Iterator[None]:
    """Draw inside this with the look of the house, whatever the user has set."""
    with rc_context(_RC):
        yield


def variables(dark: bool = False) -> str:
    """Return the CSS declarations of all colours: ``--fig-ink: #1b1b1b; ...``, for a page that holds figures."""
    return " ".join(f"--fig-{role}: {pair[dark]};" for role, pair in ROLES.items())


def plain(text: object, longest: int = LONGEST) -> str:
    """Return a text from the data that can be drawn: no control or direction marks, not longer than that."""
    shown = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in str(text))
    return shown if len(shown) <= longest else shown[: longest - 1] + "…"


def with_unit(name: str, unit: str) -> str:
    """Return the label of an axis: ``"rate [deg/s]"``."""
    return f"{name} [{plain(unit)}]" if unit not in ("", "1") else name


def set_title(ax: Axes, text: str) -> None:
    """Give axes a title that is folded to their width and taken as it is."""
    if text:
        ax.set_title(fill(plain(text, 400), LINE), loc="left", parse_math=False)


def set_ticks(ax: Axes) -> None:
    """Give axes the ticks of the house: they are made when a figure is drawn, with what the user has set by then."""
    ax.tick_params(labelsize=TEXT - 1.0, color=COLOURS["quiet"], labelcolor=COLOURS["ink"])


def set_heading(figure: Figure | SubFigure, text: str) -> int:
    """Give a figure a title over its whole width; the text is taken as it is. Return its number of lines."""
    size = TEXT + 0.5
    shown = folded(plain(text, 400), size, 0.94 * figure.bbox.width / figure.dpi * 72.0)
    figure.suptitle(shown, x=0.01, ha="left", fontsize=size, parse_math=False)
    return shown.count("\n") + 1


def set_labels(ax: Axes, x: str = "", y: str = "") -> None:
    """Label axes; the texts are taken as they are."""
    if x:
        ax.set_xlabel(x, parse_math=False)
    if y:
        ax.set_ylabel(y, parse_math=False)


def set_legend(ax: Axes, handles: Sequence[Artist] | None = None, below: float = BELOW) -> None:
    """Put the legend under the axes, where it covers nothing; labels are taken as they are, long ones are folded."""
    given, labels = ax.get_legend_handles_labels() if handles is None else (handles, [h.get_label() for h in handles])
    if not given:
        return
    room = _room(ax)
    texts = [folded(str(label), LEGEND_TEXT, room - HANDLE) for label in labels]
    place = offset_copy(ax.transAxes, ax.get_figure(root=True), 0.0, below, units="points")
    legend = ax.legend(
        given, [f"{i}" for i in range(len(given))], loc="upper left", bbox_to_anchor=(0.0, 0.0), bbox_transform=place,
        ncols=len(_columns(texts, room)), borderaxespad=0.0, borderpad=0.0, columnspacing=COLUMN_GAP / LEGEND_TEXT,
        handletextpad=0.5, handlelength=2.0, labelspacing=ROW_GAP / LEGEND_TEXT,
    )  # fmt: skip
    for shown, text in zip(legend.get_texts(), texts, strict=True):
        shown.set_parse_math(False)
        shown.set_text(text)  # set here, because a label that begins with "_" would be left out


def legend_size(ax: Axes) -> tuple[float, float]:
    """Return width and height of the legend of axes [pt]; zeros for none."""
    legend = ax.get_legend()
    if legend is None:
        return 0.0, 0.0
    columns = _columns([text.get_text() for text in legend.get_texts()], _room(ax))
    high = max(sum(height(text, LEGEND_TEXT) + ROW_GAP for text in column) for column in columns)
    return _wide(columns), high


def _room(ax: Axes) -> float:
    """Return how wide a legend of axes may be, in points."""
    figure = ax.get_figure(root=True)
    return LEGEND if figure is None else min(LEGEND, figure.get_figwidth() * 72.0 - BESIDE)


def _columns(texts: Sequence[str], room: float) -> list[list[str]]:
    """Return the columns of a legend, as many as there is room for; the first ones are the longer ones."""
    for count in range(min(MOST_COLUMNS, len(texts)), 0, -1):
        sizes = [len(texts) // count + (i < len(texts) % count) for i in range(count)]
        rest = iter(texts)
        columns = [list(islice(rest, size)) for size in sizes]
        if _wide(columns) <= room:
            break
    return columns


def _wide(columns: Sequence[Sequence[str]]) -> float:
    own = [HANDLE + max(width(text, LEGEND_TEXT) for text in column) for column in columns]
    return sum(own) + COLUMN_GAP * (len(own) - 1)
