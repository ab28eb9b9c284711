"""The matrix as a picture: row = sensor, column = input axis.

The diagonal shows the scale factor error, positive where the sensor reads too much; off it stands the misalignment,
positive where the reading rises with the other axis. Colour strength is the size of an entry: 1 % on the diagonal is as
strong as 0.01 rad off it. The number also carries the sign.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import Patch, Rectangle

from ....core.errors import DataError
from ....core.results import case_of
from ....core.show.rounding import number, with_uncertainty
from ....core.units import factor
from ..drawing.data import distinct
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, TEXT, plain, set_legend, set_title

NAME = "matrix"
MODEL = "model"  # test that the rows of the model carry
DIAGONAL, OFF_DIAGONAL = "scale_factor_error", "misalignment"
SHOWS = "Rows: sensors; columns: input axes"
STRONGEST = 0.55  # opacity of the largest entry: the number on it stays readable
CELL = 0.85  # height of a row [in]

Rows = Sequence[Mapping[str, Any]]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture of the model, and one of each test with an entry off the diagonal."""
    tests = distinct(row["test"] for row in results.get("results", []))
    found = []
    for test in sorted(tests, key=lambda test: test != MODEL):
        rows = [row for row in results["results"] if row["test"] == test and case_of(row).plain]
        if entries(rows) and (test == MODEL or any(_known(row) for row in rows if row["quantity"] == OFF_DIAGONAL)):
            found.append(of_rows(rows, test))
    return found


def of_rows(rows: Rows, test: str = MODEL) -> Picture:
    """Return the picture of the rows of one test or model.

    Raises
    ------
    DataError
        If they hold no entry of a matrix.
    """
    cells = entries(rows)
    if not cells:
        raise DataError("No scale factor error and no misalignment: no matrix to plot", code="nothing_to_draw")

    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], rows, title)

    height = CELL * len(axes_of(cells))
    return Picture(NAME, test, "", finding(rows), SHOWS, (height,), paint, data=rows)


def entries(rows: Rows) -> dict[tuple[str, str], Mapping[str, Any]]:
    """Return the entries of the matrix by (sensor, input axis)."""
    diagonal = {row["axis"]: row for row in rows if row["quantity"] == DIAGONAL}
    pairs = {a + b: (a, b) for a in diagonal for b in diagonal if a != b}
    off = {pairs[row["axis"]]: row for row in rows if row["quantity"] == OFF_DIAGONAL and row["axis"] in pairs}
    return {(axis, axis): row for axis, row in diagonal.items()} | off


def axes_of(cells: Iterable[tuple[str, str]]) -> list[str]:
    """Return the axes, in the order of their rows."""
    return distinct(sensor for sensor, axis in cells if sensor == axis)


def finding(rows: Rows) -> str:
    """Return the finding: the largest entry on and off the diagonal, and how many were not estimated."""
    cells = entries(rows)
    parts = []
    for name, words in ((DIAGONAL, "scale-factor error"), (OFF_DIAGONAL, "misalignment")):
        known = {key: row for key, row in cells.items() if row["quantity"] == name and _known(row)}
        if known:
            (sensor, axis), row = max(known.items(), key=lambda item: abs(item[1]["value"]))
            where = sensor if sensor == axis else f"{sensor} towards {axis}"
            parts.append(f"largest {words} {number(row['value'], 2)} {row['unit']} ({plain(where)})")
    missing = len(axes_of(cells)) ** 2 - sum(_known(row) for row in cells.values())
    parts += [f"{missing} entries not estimated"] if missing else []
    return ", ".join(parts) or "no entry estimated"


def draw(ax: Axes, rows: Rows, title: str = "") -> None:
    """Draw the matrix."""
    cells = entries(rows)
    axes = axes_of(cells)
    largest = max((_size(row) for row in cells.values() if _known(row)), default=0.0)
    for i, sensor in enumerate(axes):
        for j, axis in enumerate(axes):
            _cell(ax, (i, j), cells.get((sensor, axis)), largest)
    names = [plain(axis, 12) for axis in axes]
    ax.set_xlim(0, len(axes))
    ax.set_ylim(len(axes), 0)
    places = [i + 0.5 for i in range(len(axes))]
    ax.set_xticks(places, labels=names, parse_math=False)
    ax.set_yticks(places, labels=names, parse_math=False)
    ax.tick_params(length=0, labelsize=TEXT)
    ax.xaxis.tick_top()
    ax.xaxis.set_label_position("top")
    ax.set_xlabel("input axis")
    ax.set_ylabel("sensor")
    for side in ax.spines.values():
        side.set_visible(False)
    set_title(ax, title)
    hatched = (
        [Patch(label="not estimated", **_blank())]
        if any(not _known(cells.get((a, b))) for a in axes for b in axes)
        else []
    )
    tints = [
        Patch(color=COLOURS[role], alpha=STRONGEST, label=label)
        for role, label in (("orange", "positive"), ("blue", "negative"))
    ]
    set_legend(ax, [*tints, *hatched], below=-8.0)


def _known(row: Mapping[str, Any] | None) -> bool:
    return row is not None and row["value"] is not None and row["status"] != "not_estimated"


def _size(row: Mapping[str, Any]) -> float:
    ratio = "rad" if row["quantity"] == OFF_DIAGONAL else "1"
    return abs(float(row["value"])) * factor(row["unit"], ratio)


def _blank() -> dict[str, Any]:
    return {"facecolor": "none", "edgecolor": COLOURS["quiet"], "hatch": "////", "linewidth": 0.0}


def _cell(ax: Axes, at: tuple[int, int], row: Mapping[str, Any] | None, largest: float) -> None:
    i, j = at
    frame: dict[str, Any] = {"xy": (j, i), "width": 1.0, "height": 1.0}
    middle: dict[str, Any] = {"x": j + 0.5, "y": i + 0.5, "ha": "center", "va": "center", "parse_math": False}
    if row is None or not _known(row):
        ax.add_patch(Rectangle(**frame, **_blank()))
        box = {"facecolor": COLOURS["paper"], "edgecolor": "none", "pad": 2.0}
        ax.text(s="not\nestimated", color=COLOURS["quiet"], fontsize=TEXT - 1, bbox=box, **middle)
    else:
        strength = STRONGEST * _size(row) / largest if largest > 0.0 else 0.0
        colour = COLOURS["orange" if row["value"] > 0.0 else "blue"]
        ax.add_patch(Rectangle(**frame, facecolor=colour, alpha=strength, linewidth=0.0))
        ax.text(s=_figure(row), color=COLOURS["ink"], fontsize=TEXT - 0.5, linespacing=1.35, **middle)
    ax.add_patch(Rectangle(**frame, facecolor="none", edgecolor=COLOURS["quiet"], linewidth=0.6, clip_on=False))


def _figure(row: Mapping[str, Any]) -> str:
    """Return value, uncertainty and unit on lines of their own."""
    text = with_uncertainty(row["value"], row["u"]).replace("-", "−")
    value, sign, u = text.partition(" ± ")
    unit = plain(row["unit"])
    return f"{value}\n± {u}\n{unit}" if sign else f"{value}\n{unit}"
