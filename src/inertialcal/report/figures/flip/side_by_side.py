"""Two ground models side by side: for each axis their remaining bias errors in orbit, and the difference.

Dots are the results with their 95 % intervals; the strokes beside them are the single flips behind a result. What has
no known uncertainty has no interval.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes

from ....core.results import finite
from ....core.show.rounding import with_uncertainty
from ....core.show.rows import pairs_of, verdict_of
from ....procedures.flip.figures import COMPARED
from ..drawing.data import distinct
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_title, with_unit

NAME = "side_by_side"
MARKS: dict[str, dict[str, Any]] = {
    "error": {"marker": "o", "color": COLOURS["blue"]},
    "other": {"marker": "o", "color": COLOURS["vermilion"], "markerfacecolor": "none"},
    "change": {"marker": "s", "color": COLOURS["quiet"]},
}
SHOWS = (
    "A panel an axis: remaining bias errors of both ground models, and their difference, with 95 % intervals; strokes"
    " are single flips"
)
HEIGHT = 1.15  # of a panel [in]
LONGEST = 18  # characters of a test's name beside the axes

Pairs = Mapping[tuple[str, str], Mapping[str, Mapping[str, Any]]]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test that is set beside another."""
    against = {step["test"]: step.get("against") for step in results.get("sequence", [])}
    rows = results.get("results", [])
    found = []
    for test in distinct(str(row["test"]) for row in rows if row["quantity"] == COMPARED.change):
        mine = [row for row in rows if row["test"] == test]
        pairs = pairs_of(mine, COMPARED)
        if _results(pairs):
            errors = [row for row in mine if row["quantity"] in COMPARED.roles]
            found.append(_picture(pairs, (test, str(against.get(test) or "the other")), errors))
    return found


def _picture(pairs: Pairs, tests: tuple[str, str], errors: Sequence[Mapping[str, Any]]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, pairs, tests, title)

    heights = (HEIGHT,) * len(_results(pairs))
    return Picture(NAME, tests[0], "", finding(pairs, tests), SHOWS, heights, paint, data=errors)


def finding(pairs: Pairs, tests: tuple[str, str]) -> str:
    """Return the finding: of which axes the error is nearer to zero than that of the other, and by how much."""
    said = []
    for axis, pair in _results(pairs).items():
        word = verdict_of(pair)
        if word == "not shown":
            said.append(f"{plain(axis, 12)} not shown nearer")
        else:
            row = pair["reduction"]
            said.append(
                f"{plain(axis, 12)} {with_uncertainty(abs(row['value']), row['u'])} {plain(row['unit'])} {word}"
            )
    return f"To zero, {plain(tests[0])} against {plain(tests[1])}: {'; '.join(said)}"


def draw(axes: Sequence[Axes], pairs: Pairs, tests: tuple[str, str], title: str = "") -> None:
    """Draw the errors of both, and their difference.

    Parameters
    ----------
    axes : sequence of Axes
        As many as there are axes of the head.
    pairs : mapping
        Of ``pairs_of``.
    tests : (str, str)
        Names of the test and of the other.
    title : str
        Above the first; empty for none.
    """
    shown = _results(pairs)
    labels = [*(plain(test, LONGEST) for test in tests), "difference"]
    for ax, (axis, whole) in zip(axes, shown.items(), strict=True):
        ax.axvline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
        for place, (quantity, marks) in enumerate(MARKS.items()):
            _mark(ax, place, whole.get(quantity), marks)
            flips = [
                pair[quantity]["value"]
                for (of, flip), pair in pairs.items()
                if of == axis and flip and quantity in pair
            ]
            known = [value for value in flips if value is not None]
            ax.plot(known, [place + 0.28] * len(known), "|", color=marks["color"], markersize=6.0, zorder=3)
        ax.set_yticks(range(len(MARKS)), labels=labels, parse_math=False)
        ax.set_ylim(len(MARKS) - 0.4, -0.6)
        ax.tick_params(axis="y", length=0)
        set_labels(ax, y=plain(axis, 12))
    set_title(axes[0], title)
    set_labels(axes[-1], with_unit("error", plain(next(iter(shown.values()))["change"]["unit"], 12)))


def _mark(ax: Axes, place: int, row: Mapping[str, Any] | None, look: Mapping[str, Any]) -> None:
    if row is None or finite(row["value"]) is None:
        return
    interval = row["interval"]
    if interval is not None:
        ax.hlines(place, interval["lo"], interval["hi"], color=look["color"], linewidth=1.8, zorder=2)
    ax.plot(row["value"], place, linestyle="none", zorder=4, **look)


def _results(pairs: Pairs) -> dict[str, Mapping[str, Mapping[str, Any]]]:
    """Return the pairs of all flips together, by axis."""
    return {axis: pair for (axis, flip), pair in pairs.items() if not flip}
