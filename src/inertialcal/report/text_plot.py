"""A figure in text: the curves and points of its panels as dots of Braille signs, or in ASCII.

Each sign holds 2 x 4 dots [1]_; in ASCII a sign is one place, and each curve has a mark of its own.

References
----------
.. [1] The Unicode Standard, block Braille Patterns (U+2800): bits of the dots of a cell.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..core.estimate import Array
from ..core.show.tables import clean, short

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .figures.drawing.picture import Picture

Places = NDArray[np.int64]
HEIGHT = 16  # rows of a panel
NARROW = 20  # columns of a panel, at least
MARKS = "*+xo#@%&"
DOTS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])  # row, column of a cell -> bit
BLANK = 0x2800
STEPS = 4  # points drawn for each dot of the longer side between two of a curve


def text_plot(pictures: Sequence[Picture], width: int, braille: bool = True) -> str:
    """Return pictures as text, one below the other.

    Parameters
    ----------
    pictures : sequence of Picture
        What is drawn.
    width : int
        Columns.
    braille : bool
        Whether the signs may be Braille; else ASCII.
    """
    from .figures.drawing.picture import on_new_figure  # noqa: PLC0415 - heavy: only where one is drawn

    blocks = []
    for picture in pictures:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Glyph .* missing")
            figure = on_new_figure(picture, titled=True)
            figure.draw_without_rendering()
        panels = [_panel(ax, max(width, NARROW + 12), braille) for ax in figure.axes if _has_data(ax)]
        blocks.append("\n".join([clean(picture.finding.replace("\n", " ")), *panels]))
    return "\n\n".join(blocks)


def _has_data(ax: Axes) -> bool:
    return next(_series(ax), None) is not None


def _series(ax: Axes) -> Iterator[tuple[Array, bool]]:
    """Yield the points of each curve of a panel, shape (n, 2), between 0 and 1, and whether they are joined."""
    place = ax.transScale + ax.transLimits
    drawn: list[tuple[Any, bool]] = [
        (line.get_xydata(), line.get_linestyle() not in ("None", "", " ")) for line in ax.lines
        if line.get_transform() == ax.transData
    ]  # fmt: skip
    for one in ax.collections:
        offsets = np.asarray(one.get_offsets())
        if one.get_offset_transform() == ax.transData and offsets.size:
            drawn.append((offsets, False))
        elif hasattr(one, "get_segments") and one.get_transform() == ax.transData:
            drawn += [(segment, True) for segment in one.get_segments()]
    for points, joined in drawn:
        with np.errstate(all="ignore"):
            found = place.transform(np.asarray(points, float).reshape(-1, 2))
        if np.isfinite(found).all(axis=1).any():
            yield found, joined


def _panel(ax: Axes, width: int, braille: bool) -> str:
    """Return a panel with its labels and the ends of its axes."""
    (left, right), ends = ax.get_xlim(), ax.get_ylim()
    high, low = (f"{end:.3g}" for end in sorted(ends, reverse=True))
    margin = max(len(high), len(low))
    columns = width - margin - 3
    rows = _dots(ax, columns) if braille else _marks(ax, columns)
    labels = [high, *[""] * (HEIGHT - 2), low]
    lines = [f"{label.rjust(margin)} |{row}" for label, row in zip(labels, rows, strict=True)]
    first, last = f"{left:.4g}", f"{right:.4g}"
    label = short(clean(_words(ax.get_xlabel())), max(columns - len(first) - len(last) - 2, 1))
    below = f"{first} {label.center(columns - len(first) - len(last) - 2)} {last}"
    head = clean(_words(ax.get_ylabel()))
    floor = f"{'':{margin}} +{'-' * columns}"
    return "\n".join([*([head] if head else []), *lines, floor, f"{'':{margin + 2}}{below}"])


def _words(label: str) -> str:
    return " ".join(label.split())


def _cells(ax: Axes, columns: int, rows: int) -> Iterator[tuple[Places, Places]]:
    """Yield columns and rows of the places that each curve takes."""
    for points, joined in _series(ax):
        at = points * (columns - 1, rows - 1)
        if joined and len(at) > 1:
            at = np.concatenate([at[:1], *map(_between, at[:-1], at[1:])])
        at = at[np.isfinite(at).all(axis=1)]
        place = np.rint(at).astype(np.int64)
        inside = ((place >= 0) & (place < (columns, rows))).all(axis=1)
        yield place[inside, 0], rows - 1 - place[inside, 1]


def _between(first: Array, second: Array) -> Array:
    steps = np.max(np.abs(second - first))
    n = int(min(STEPS * steps, 10_000)) + 1 if np.isfinite(steps) else 1
    return first + (second - first) * (np.arange(1, n + 1) / n)[:, None]


def _dots(ax: Axes, columns: int) -> list[str]:
    cells = np.zeros((HEIGHT, columns), np.int64)
    for x, y in _cells(ax, 2 * columns, 4 * HEIGHT):
        np.bitwise_or.at(cells, (y // 4, x // 2), DOTS[y % 4, x % 2])
    return ["".join(chr(BLANK + bits) if bits else " " for bits in row).rstrip() for row in cells.tolist()]


def _marks(ax: Axes, columns: int) -> list[str]:
    cells = np.full((HEIGHT, columns), " ")
    for number, (x, y) in enumerate(_cells(ax, columns, HEIGHT)):
        cells[y, x] = MARKS[number % len(MARKS)]
    return ["".join(row).rstrip() for row in cells.tolist()]
