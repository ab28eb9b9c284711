"""Drawing of a source mass to build from: totals, two side views, each layer from above with the number of each cube.

Pages of A4. A layer is as high as the smallest cube: a larger one is numbered where it is placed, and stays in grey in
the layers that it reaches into. Lengths are in cm from the proof mass, which is the origin.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from ....core.errors import PlanError, UsageError
from ....core.estimate import Array
from ....core.show.rounding import items, number
from ....files.write.atomic import atomic_write
from ....procedures.mass_attraction.planning.build import Build
from ...figure_file import DPI, FORMATS, check_ending
from ..drawing.style import COLOURS, look
from ..drawing.svg import SALT

PAGE = (8.27, 11.69)  # A4 [in]
EDGE = 0.45  # [in] free around a page
HEAD = 0.75  # [in] for the title of a page
ASIDE, ABOVE = 0.75, 0.95  # [in] of a layer for its axes and its title
CELL = 0.22  # [in] of the smallest cube, from which a number is easy to read
SMALLEST_TEXT, LARGEST_TEXT = 3.5, 8.0  # [pt]
DIGIT = 0.62  # width of a digit over its size
MOST_STACKED = 12  # pages on one PNG or SVG
LINE = 0.16  # [in] of the table of layers
CM = 100.0
NEW, OLD, PACKED = "#cfe4f2", "#f2f2f2", "#f7d9c4"  # cubes placed in a layer, reaching into it, to be packed


@dataclass(frozen=True)
class Sheet:
    """How layers lie on a page."""

    columns: int
    rows: int
    scale: float  # inches a cm
    text: float  # of the numbers [pt]


def write_build(
    path: str | os.PathLike[str], build: Build, title: str, inputs: Iterable[str | os.PathLike[str]] = ()
) -> None:
    """Write the drawing: all pages of a PDF, or one below the other as PNG or SVG.

    Parameters
    ----------
    path : path
        Where; one that is there is replaced.
    build : Build
        Cubes in their order.
    title : str
        What is built, for the head of each page.
    inputs : iterable of path
        Files that it may not replace.

    Raises
    ------
    PlanError
        ``too_fine`` if the numbers of so many cubes could not be read.
    UsageError, StoreError
        As ``figure_file.write_figure``; ``too_long`` if there are too many pages for one picture.
    """
    from matplotlib import rc_context  # noqa: PLC0415 - heavy: only where one is drawn
    from matplotlib.backends.backend_pdf import PdfPages  # noqa: PLC0415 - heavy

    ending, sheet = check_ending(path), sheet_of(build)
    each = sheet.columns * sheet.rows
    groups = [range(at, min(at + each, len(build.layers))) for at in range(0, len(build.layers), each)]
    count = 1 + len(groups)
    if ending != ".pdf" and count > MOST_STACKED:
        what = f"{os.fspath(path)}: {count} pages, one picture takes {MOST_STACKED}"
        raise UsageError(what, do="Write a PDF: --build FILE.pdf", code="too_long")
    metadata: Any = dict.fromkeys(FORMATS[ending])
    with atomic_write(path, inputs) as aside, look(), rc_context({"svg.hashsalt": SALT, "svg.fonttype": "path"}):
        if ending == ".pdf":
            with PdfPages(aside, metadata=metadata) as pages:
                for at in range(count):
                    figure = Figure(figsize=PAGE, facecolor="white")
                    _page(figure, build, sheet, title, groups, at)
                    pages.savefig(figure)
            return
        whole = Figure(figsize=(PAGE[0], count * PAGE[1]), facecolor="white")
        for at, part in enumerate(np.ravel(whole.subfigures(count, 1, squeeze=False))):
            _page(part, build, sheet, title, groups, at)
        whole.savefig(aside, format=ending[1:], dpi=DPI, metadata=metadata)


def sheet_of(build: Build) -> Sheet:
    """Return how many layers a page takes so that every number can be read.

    Raises
    ------
    PlanError
        ``too_fine``.
    """
    low, high = _extent(build)
    x, y = CM * (high - low)[:2]
    wide, tall = PAGE[0] - 2.0 * EDGE, PAGE[1] - 2.0 * EDGE - HEAD
    digits = len(str(len(build)))
    found = []
    for columns, rows in product((3, 2, 1), repeat=2):
        scale = min((wide / columns - ASIDE) / x, (tall / rows - ABOVE) / y)
        found.append((min(scale * CM * build.step, CELL), columns * rows, scale, columns, rows))
    _, _, scale, columns, rows = max(found)
    cell = scale * CM * build.step
    text = min(0.85 * 72.0 * cell / (DIGIT * digits), 0.7 * 72.0 * cell, LARGEST_TEXT)
    if text < SMALLEST_TEXT:
        what = f"{len(build)} cubes of {number(CM * build.step, 4)} cm: their numbers would be too small to read"
        raise PlanError(what, do="Write the list alone: --build FILE.csv", code="too_fine")
    return Sheet(columns, rows, scale, text)


def _extent(build: Build) -> tuple[Array, Array]:
    return build.corner.min(axis=0), (build.corner + build.edge[:, None]).max(axis=0)


def _page(figure: Figure | SubFigure, build: Build, sheet: Sheet, title: str, groups: Sequence[range], at: int) -> None:
    """Draw a page: the first has totals and side views, the others have layers."""
    count = 1 + len(groups)
    top = 1.0 - EDGE / PAGE[1]
    figure.text(EDGE / PAGE[0], top, title, va="top", fontsize=11.0, fontweight="bold")
    figure.text(1.0 - EDGE / PAGE[0], top, f"page {at + 1} of {count}", va="top", ha="right", fontsize=8.0)
    if at == 0:
        _overview(figure, build)
        return
    figure.text(
        EDGE / PAGE[0], top - 0.22 / PAGE[1],
        "Layers from above, from the lowest up; cm from the proof mass, which lies at x = 0, y = 0. Blue: placed now;"
        " orange, hatched:\nplaced now, pack below; grey: placed before. The numbers are those of the list, in the"
        " order of placing.",
        va="top", fontsize=7.5, color=COLOURS["quiet"],
    )  # fmt: skip
    low, high = _extent(build)
    x, y = sheet.scale * CM * (high - low)[:2]
    for place, layer in enumerate(groups[at - 1]):
        column, row = place % sheet.columns, place // sheet.columns
        left = EDGE + ASIDE * 0.75 + column * (PAGE[0] - 2.0 * EDGE) / sheet.columns
        bottom = PAGE[1] - EDGE - HEAD - (row + 1) * (y + ABOVE) + 0.5 * ABOVE
        ax = figure.add_axes((left / PAGE[0], bottom / PAGE[1], x / PAGE[0], y / PAGE[1]))
        _layer(ax, build, layer, sheet)


def _layer(ax: Axes, build: Build, layer: int, sheet: Sheet) -> None:
    """Draw a layer in plan view."""
    low, high = CM * np.array(_extent(build))
    cubes, bottom = build.layers[layer], low[2] + CM * layer * build.step
    new = _placed(build, layer)
    first = np.isin(cubes, new)
    for cube, starts in zip(cubes.tolist(), first.tolist(), strict=True):
        _square(ax, build, cube, (0, 1), starts)
        x, y = CM * build.centre[cube, :2]
        size = sheet.text * min(1.6, build.edge[cube] / build.step)
        ink = COLOURS["ink"] if starts else COLOURS["quiet"]
        ax.text(x, y, str(cube + 1), ha="center", va="center", fontsize=size if starts else 0.8 * size, color=ink)
    _lengths(ax, build, cubes, (0, 1), low, high, sheet.scale)
    placed = f"cubes {new.min() + 1} to {new.max() + 1}" if len(new) else "nothing placed"
    placed = f"cube {new[0] + 1}" if len(new) == 1 else placed
    heights = f"z = {_cm(bottom)} to {_cm(bottom + CM * build.step)} cm"
    ax.set_title(f"layer {layer + 1}: {placed}\n{heights}, {number(float(build.mass[new].sum()), 4)} kg", fontsize=7.5,
                 loc="left", pad=3.0)  # fmt: skip


def _square(ax: Axes, build: Build, cube: int, axes: tuple[int, int], starts: bool) -> None:
    """Draw a cube seen along the third axis."""
    corner, edge = CM * build.corner[cube], CM * build.edge[cube]
    packed = starts and bool(build.packed[cube])
    hatch = "////" if packed else None
    face = PACKED if packed else NEW if starts else OLD
    line = COLOURS["ink"] if starts else COLOURS["quiet"]
    ax.add_patch(Rectangle((corner[axes[0]], corner[axes[1]]), edge, edge, facecolor=face, edgecolor=line,
                           linewidth=0.5, hatch=hatch, hatch_linewidth=0.25, clip_on=False))  # fmt: skip


def _lengths(
    ax: Axes, build: Build, cubes: NDArray[np.int64], axes: tuple[int, int], low: Array, high: Array, scale: float
) -> None:
    """Give a view the scale of the drawing and ticks at the faces of its cubes, as close as they can be read."""
    for axis, name in zip(axes, ("x", "y"), strict=True):
        faces = np.unique(np.round(CM * np.concatenate([build.corner[cubes, axis], (build.corner[cubes, axis]
                                                        + build.edge[cubes])]), 6))  # fmt: skip
        kept, room = [faces[0]], (0.16 if name == "y" else 0.14) / scale
        for face in faces[1:].tolist():
            if face - kept[-1] >= room and (face == faces[-1] or faces[-1] - face >= room):
                kept.append(face)
        getattr(ax, f"set_{name}ticks")(kept)
        getattr(ax, f"set_{name}ticklabels")([_cm(face) for face in kept], fontsize=6.0)
        getattr(ax, f"set_{name}lim")(low[axis], high[axis])
    ax.tick_params(axis="x", rotation=90.0, pad=1.5, length=2.0)
    ax.tick_params(axis="y", pad=1.5, length=2.0)
    names = "xyz"
    ax.set_xlabel(f"{names[axes[0]]} [cm]", fontsize=6.5, labelpad=1.0)
    ax.set_ylabel(f"{names[axes[1]]} [cm]", fontsize=6.5, labelpad=1.0)


def _overview(figure: Figure | SubFigure, build: Build) -> None:
    """Draw totals and both side views."""
    low, high = CM * np.array(_extent(build))
    sizes = "x".join(("", *(f" {number(side, 5)} " for side in (high - low)))).removeprefix("x").strip()
    lines = [
        *(f"{items(count, 'cube')} of {number(CM * size, 5)} cm, {number(each, 5)} kg each: {number(every, 6)} kg"
          for size, count, each, every in build.totals()),
        f"All: {items(len(build), 'cube')}, {number(float(build.mass.sum()), 6)} kg, {sizes} cm (x, y, z),"
        f" density {number(build.density, 6)} kg/m^3",
        "Origin of all lengths: the proof mass, with the body at position zero of its drive. x: input axis; z: up.",
        "Place the cubes in the order of their numbers: layer by layer from the lowest, in a layer from the smallest x,"
        " then y.",
    ]  # fmt: skip
    if count := int(np.count_nonzero(build.packed)):
        lines.append(f"{count} cubes do not rest on their whole lower face (hatched): pack below them.")
    top = PAGE[1] - EDGE - 0.35
    figure.text(EDGE / PAGE[0], top / PAGE[1], "\n".join(lines), va="top", fontsize=8.5, linespacing=1.5)
    top -= 0.2 * len(lines) + 0.5
    wide = PAGE[0] - 2.0 * EDGE - 1.4
    span = high[0] + (high[1] - low[1])
    scale = min(wide / span, (top - EDGE - 1.2) / (high[2] - low[2]))
    tall = scale * (high[2] - low[2])
    views = (
        (0, "from the side (from -y)", EDGE + 0.55),
        (1, "from the proof mass (along x)", EDGE + 1.3 + scale * high[0]),
    )
    for axis, name, left in views:
        start = 0.0 if axis == 0 else low[axis]
        width = scale * (high[axis] - start)
        bottom = top - tall - 0.3
        ax = figure.add_axes((left / PAGE[0], bottom / PAGE[1], width / PAGE[0], tall / PAGE[1]))
        order = np.argsort(-build.centre[:, 1] if axis == 0 else -build.centre[:, 0], kind="stable")
        for cube in order.tolist():  # the nearest is drawn last
            _square(ax, build, cube, (axis, 2), True)
        _lengths(ax, build, np.arange(len(build)), (axis, 2), low, high, scale)
        ax.set_title(name, fontsize=8.0, loc="left", pad=4.0)
        if axis == 0:
            ax.set_xlim(0.0, high[0])
            ax.plot(0.0, 0.0, "o", color=COLOURS["vermilion"], markersize=5.0, clip_on=False, zorder=5)
            arrow = {"arrowstyle": "<->", "linewidth": 0.7, "shrinkA": 0.0, "shrinkB": 0.0}
            ax.annotate("", (low[0], 0.0), (0.0, 0.0), arrowprops=arrow, annotation_clip=False)
            ax.text(0.5 * low[0], 0.0, f"{_cm(low[0])}\n", ha="center", va="center", fontsize=6.5)
            ax.annotate("proof\nmass", (0.0, 0.0), (4.0, -6.0), textcoords="offset points", va="top", fontsize=6.5)
    _layer_table(figure, build, top - tall - 1.0)


def _layer_table(figure: Figure | SubFigure, build: Build, top: float) -> None:
    """List the layers: height, cubes that are placed in each, their mass; as many as the page has room for."""
    low = CM * _extent(build)[0]
    heads, rows = ("layer", "z [cm]", "placed", "cubes", "mass [kg]"), []
    for layer in range(len(build.layers)):
        bottom = low[2] + CM * layer * build.step
        new = _placed(build, layer)
        numbers = f"{new[0] + 1} to {new[-1] + 1}" if len(new) else "none"
        mass = number(float(build.mass[new].sum()), 6)
        rows.append((str(layer + 1), f"{_cm(bottom)} to {_cm(bottom + CM * build.step)}", str(len(new)), numbers, mass))
    room = int((top - EDGE) / LINE) - 1
    shown = [heads, *rows] if len(rows) <= room else [heads, *rows[: room - 1], ("...",) * len(heads)]
    for column, at in enumerate((0.0, 0.7, 2.2, 3.0, 4.4)):
        for row, cells in enumerate(shown):
            weight = "bold" if row == 0 else "normal"
            figure.text((EDGE + at) / PAGE[0], (top - LINE * row) / PAGE[1], cells[column], va="top", fontsize=7.5,
                        fontweight=weight)  # fmt: skip


def _placed(build: Build, layer: int) -> NDArray[np.int64]:
    """Return the cubes whose lower face is that of a layer."""
    cubes = build.layers[layer]
    bottom = build.corner[:, 2].min() + layer * build.step
    return np.asarray(cubes[np.abs(build.corner[cubes, 2] - bottom) < 0.5 * build.step])


def _cm(value: float) -> str:
    """Return a length without what rounding left of it."""
    return number(round(float(value), 6) + 0.0, 5)


__all__ = ["sheet_of", "write_build"]
