"""The body of a source mass in three dimensions: its cells in a parallel projection, the proof mass before it.

Faces that look at the viewer are drawn from the back to the front. Only cells that can be seen from outside are given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection

from ....core.estimate import Array
from ..drawing.data import Curve, curves, numbers, unit
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_title

NAME = "mass_body"
SHOWS = "The cells of the source mass in parallel projection; to the left the proof mass, at the stand-off"
HEIGHT = 3.4  # [in]
VIEW = np.array([0.15, -1.0, 0.4])  # direction of view: the proof mass, at the origin, is left of the body
TONES = ("purple", "blue", "sky")  # of a face across x, y, z
ROOM = 0.06  # of the width left free
CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    return [
        Picture(NAME, str(one.get("test", "")), "", finding(results, one), SHOWS, (HEIGHT,), partial(draw, one))
        for one in curves(results, NAME)
    ]


def finding(results: Mapping[str, Any], curve: Curve) -> str:
    """Return the finding: mass and attraction, and how close it is to the bound."""
    of = [row for row in results.get("results", []) if row.get("test", "") == curve.get("test", "")]
    rows = {row["quantity"]: row["value"] for row in reversed(of)}  # the first of a name counts
    if not {"cells", "mass", "attraction", "attraction_gap"} <= rows.keys():
        return "body of the source mass"
    edge = f"{numbers(curve, 'edge')[0]:.3g} {plain(unit(curve, 'edge'))}"
    what = f"{rows['cells']:.0f} cells of {edge}, {rows['mass']:.0f} kg"
    return f"{what}, attract {rows['attraction']:.1f} ng: {rows['attraction_gap']:.2g} % below the bound for any shape"


def draw(curve: Curve, axes: Sequence[Axes], title: str) -> None:
    """Draw the cells."""
    (ax,) = axes
    centres = np.column_stack([numbers(curve, name) for name in "xyz"])
    edge = float(numbers(curve, "edge")[0])
    faces, tones = _faces(centres, edge)
    flat = faces @ _plane()
    ax.add_collection(PolyCollection(list(flat), facecolors=tones, edgecolors=COLOURS["paper"], linewidths=0.25))
    nearest = np.array([[centres[:, 0].min() - edge / 2.0, 0.0, 0.0]]) @ _plane()
    ax.plot([0.0, nearest[0, 0]], [0.0, nearest[0, 1]], color=COLOURS["quiet"], linewidth=0.9, zorder=0)
    ax.plot(0.0, 0.0, "o", color=COLOURS["vermilion"], markersize=6.0, zorder=5)
    ax.annotate("proof mass", (0.0, 0.0), xytext=(-4.0, 8.0), textcoords="offset points", ha="right", fontsize=9.0)
    _frame(ax, np.concatenate([flat.reshape(-1, 2), np.zeros((1, 2))]), edge, unit(curve, "edge"))
    set_title(ax, title)


def _frame(ax: Axes, points: Array, edge: float, of: str) -> None:
    """Give axes equal scales and one axis of lengths, because the projection keeps no axis."""
    low, high = points.min(axis=0), points.max(axis=0)
    room = ROOM * float(high[0] - low[0])
    ax.set_xlim(float(low[0]) - 5.0 * room, float(high[0]) + room)
    ax.set_ylim(float(low[1]) - room, float(high[1]) + room)
    ax.set_aspect("equal")
    for side in ("left", "bottom"):
        ax.spines[side].set_visible(False)
    ax.set_xticks([])
    ax.set_yticks([])
    set_labels(ax, f"input axis to the right; cells of {edge:.3g} {plain(of)}")


def _plane() -> Array:
    """Return the projection of places to the paper, shape (3, 2)."""
    toward = VIEW / np.linalg.norm(VIEW)
    right = np.cross([0.0, 0.0, 1.0], toward)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(toward, right)])


def _faces(centres: Array, edge: float) -> tuple[Array, list[str]]:
    """Faces that look at the viewer and are not covered by a neighbour, back to front, and their colours."""
    cells = {tuple(cell) for cell in np.rint(centres / edge * 2.0).astype(int).tolist()}
    faces, tones = [], []
    for axis in range(3):
        side = 1 if VIEW[axis] > 0.0 else -1
        step = np.zeros(3, dtype=int)
        step[axis] = 2 * side
        open_ones = [
            i
            for i, cell in enumerate(np.rint(centres / edge * 2.0).astype(int))
            if tuple((cell + step).tolist()) not in cells
        ]
        square = _square(axis, side) * edge
        faces.append(centres[open_ones][:, None, :] + square)
        tones += [COLOURS[TONES[axis]]] * len(open_ones)
    every = np.concatenate(faces)
    order = np.argsort(every.mean(axis=1) @ VIEW)
    return every[order], [tones[i] for i in order]


def _square(axis: int, side: int) -> Array:
    """Corners of a face of a cell of edge one about its middle, shape (4, 3)."""
    others = [one for one in range(3) if one != axis]
    corners = np.full((4, 3), 0.5 * side)
    corners[:, others] = np.array(CORNERS) - 0.5
    return corners
