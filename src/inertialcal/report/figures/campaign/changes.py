"""Before and after: what figures changed by since an earlier test, each in parts of what is allowed for it.

A figure that nothing is allowed for is drawn in parts of its own 95 % interval, in a panel of its own: there 1 is the
end of the interval of a change of zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes

from ....core.show.rounding import with_uncertainty
from ....core.show.rows import Changed, changed, quantity_name
from ....core.show.wording import count
from ..drawing.picture import Picture
from ..drawing.style import COLOURS, plain, set_labels, set_title

NAME = "changes"
SHOWS = "A line a figure: its change since the earlier test with 95 % interval, and the band of what is allowed"
LOOKS: dict[str, dict[str, Any]] = {
    "PASS": {"marker": "o", "color": COLOURS["green"]},
    "FAIL": {"marker": "X", "color": COLOURS["vermilion"], "markersize": 7.0},
    "INCONCLUSIVE": {"marker": "^", "color": COLOURS["orange"]},
    "": {"marker": "o", "color": COLOURS["quiet"], "markerfacecolor": "none"},
}
ROW, HEAD = 0.24, 0.5  # height of a line, and of what a panel needs besides [in]
MOST = 16  # lines of a panel
LONGEST = 30  # characters of a name beside the axes

Changes = Sequence[Changed[Any]]


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture for each test that is set against an earlier one."""
    found = []
    rows, verdicts = results.get("results", []), results.get("verdicts", [])
    for step in results.get("sequence", []):
        if not step.get("against"):
            continue
        every = changed(rows, verdicts, step["test"], step["against"])
        panels = [panel[:MOST] for panel in _panels(every) if panel]
        if panels:
            found.append(_picture(step["test"], step["against"], panels))
    return found


def _panels(every: Changes) -> tuple[Changes, Changes]:
    """Return the changes that are judged, and those that are not, both with an interval."""
    known = [one for one in every if one.change["interval"] is not None and one.change["value"] is not None]
    return [one for one in known if one.part is not None], [one for one in known if one.part is None]


def _picture(test: str, other: str, panels: Sequence[Changes]) -> Picture:
    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes, panels, title)

    every = [one for panel in panels for one in panel]
    heights = tuple(HEAD + ROW * len(panel) for panel in panels)
    data = [one.change for one in every]
    return Picture(NAME, test, "", finding(test, other, every), SHOWS, heights, paint, share_x=False, data=data)


def finding(test: str, other: str, every: Changes) -> str:
    """Return the finding: how many changes are not within what is allowed, or the largest by its interval."""
    judged = [one for one in every if one.verdict]
    head = f"{plain(test)} against {plain(other)}"
    if judged:
        bad = [one for one in judged if one.verdict != "PASS"]
        if not bad:
            return f"{head}: all {count(len(judged))} changes within what is allowed"
        worst = next((one for one in bad if one.verdict == "FAIL"), bad[0])
        word = "beyond what is allowed" if worst.verdict == "FAIL" else "not shown to be within what is allowed"
        return f"{head}: {_name(worst)} {_figure(worst)} {word}"
    largest = max(every, key=lambda one: abs(_scaled(one)[1]))
    return f"{head}: largest change by its interval {_name(largest)}, {_figure(largest)}"


def _figure(one: Changed[Any]) -> str:
    row = one.change
    figure = with_uncertainty(row["value"], row["u"])
    return f"× {figure}" if one.is_ratio else f"{figure} {plain(row['unit'])}".removesuffix(" 1")


def _name(one: Changed[Any]) -> str:
    sensor = f"{one.change['sensor']} " if one.change["sensor"] else ""
    return plain(f"{sensor}{quantity_name(one.change).replace('_', ' ')} {one.change['axis']}", LONGEST)


def _scaled(one: Changed[Any]) -> tuple[float, float, float]:
    """Return lower end, value and upper end, in parts of what is allowed, or of the half width of the interval."""
    row, ends = one.change, one.change["interval"]
    value = float(row["value"])
    lo, hi = (value if ends[end] is None else float(ends[end]) for end in ("lo", "hi"))
    if one.part is not None and one.upper is not None and one.lower is not None:
        middle, half = 0.5 * (one.upper + one.lower), 0.5 * (one.upper - one.lower)
    else:
        middle = 1.0 if one.is_ratio else 0.0
        half = max(hi - value, value - lo) or 1.0
    return (lo - middle) / half, (value - middle) / half, (hi - middle) / half


def draw(axes: Sequence[Axes], panels: Sequence[Changes], title: str = "") -> None:
    """Draw a panel of judged changes, and one of the others.

    Parameters
    ----------
    axes : sequence of Axes
        One a panel.
    panels : sequence of sequence of Changed
        Their lines.
    title : str
        Above the first; empty for none.
    """
    for ax, panel in zip(axes, panels, strict=True):
        judged = panel[0].part is not None
        ax.axvline(0.0, color=COLOURS["quiet"], linewidth=0.8, zorder=1)
        if judged:
            ax.axvspan(-1.0, 1.0, color=COLOURS["green"], alpha=0.15, linewidth=0.0, zorder=0)
        for place, one in enumerate(panel):
            lo, value, hi = _scaled(one)
            look = LOOKS[one.verdict if one.verdict in LOOKS else ""]
            ax.hlines(place, lo, hi, color=look["color"], linewidth=1.8, zorder=2)
            ax.plot(value, place, linestyle="none", zorder=4, **look)
        ax.set_yticks(range(len(panel)), labels=[_name(one) for one in panel], parse_math=False)
        ax.set_ylim(len(panel) - 0.4, -0.6)
        ax.tick_params(axis="y", length=0)
        set_labels(ax, "change / allowed change" if judged else "change / half of its interval")
    set_title(axes[0], title)
