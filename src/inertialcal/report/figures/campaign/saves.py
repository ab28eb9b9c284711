"""Save intervals: how often the time from one save to the next was how long, over all recordings of a test.

The tests of the suite of 2011 were saved every 2 s, some saves came after 3, 5 or 6 s [1]_.

References
----------
.. [1] Badescu, NPS thesis, 2011, ch. III.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from ....core.show.rounding import number
from ....core.show.wording import counted
from ..drawing.data import distinct, numbers
from ..drawing.picture import Picture
from ..drawing.scales import log_axis
from ..drawing.style import COLOURS, TEXT, plain, set_labels, set_legend, set_title

NAME = "save_intervals"
SHOWS = "A bar for each time from one save to the next: how often it occurs, on a logarithmic axis"
DIGITS = 5  # of a length: stamps that count from 1970 hold no more than 0.2 us of it
HEIGHT = 1.7  # [in]
WIDTH = 0.7  # of a bar, in places
MOST = 10  # lengths that are drawn and told, the most frequent ones
LATE = 1.2  # of the usual length: what is longer is late


def pictures(results: Mapping[str, Any]) -> list[Picture]:
    """Return a picture a test."""
    curves = [one for one in results.get("curves", []) if one["name"] == NAME]
    tests = {test: [one for one in curves if one["test"] == test] for test in distinct(one["test"] for one in curves)}
    counts = {test: _often(own) for test, own in tests.items()}
    return [_picture(test, tests[test], often) for test, often in counts.items() if often]


def _often(curves: Sequence[Mapping[str, Any]]) -> Counter[float]:
    """Return how often each length [s] occurs in all of them."""
    often: Counter[float] = Counter()
    for one in curves:
        lengths, counts = numbers(one, "length"), numbers(one, "count")
        for length, times in zip(lengths.tolist(), counts.tolist(), strict=True):
            if times > 0:
                often[length] += round(times)
    return often


def _picture(test: str, curves: Sequence[Mapping[str, Any]], often: Counter[float]) -> Picture:
    usual = often.most_common(1)[0][0]
    shown = dict(sorted(often.most_common(MOST)))

    def paint(axes: Sequence[Axes], title: str) -> None:
        draw(axes[0], shown, usual, title)

    late = {length: times for length, times in sorted(often.items()) if length > LATE * usual}
    steps, total = sum(late.values()), sum(often.values())
    head = f"{plain(test)}: {steps:,} of {total:,} saves later than after {number(usual, DIGITS)} s"
    rest = f"; {counted(len(often) - len(shown), 'rarer length')} not drawn" if len(often) > len(shown) else ""
    note = (f" {counted(len(curves), 'recording').capitalize()}{rest}.",)
    return Picture(NAME, test, "", head, SHOWS, (HEIGHT,), paint, note=note)


def draw(ax: Axes, often: Mapping[float, int], usual: float, title: str = "") -> None:
    """Draw how often each length [s] occurs."""
    for i, (length, times) in enumerate(often.items()):
        late = length > LATE * usual
        colour = COLOURS["vermilion" if late else "blue"]
        ax.bar(i, times, WIDTH, color=colour, hatch="//" if late else "", edgecolor=COLOURS["paper"], linewidth=0.0)
        ax.annotate(f"{times:,}", (i, times), (0, 2), textcoords="offset points", ha="center", fontsize=TEXT - 1)
    log_axis(ax, "y", np.array([0.6, 3.0 * max(often.values())]))
    ax.set_xticks(range(len(often)), [number(length, DIGITS) for length in often])
    ax.set_xlim(-0.6, max(len(often), 4) - 0.4)
    set_labels(ax, "time from one save to the next [s]", "saves")
    set_title(ax, title)
    set_legend(ax, [
        Patch(facecolor=COLOURS["blue"], label=f"as usual, {number(usual, DIGITS)} s"),
        Patch(facecolor=COLOURS["vermilion"], hatch="//", edgecolor=COLOURS["paper"], linewidth=0.0, label="late"),
    ])  # fmt: skip
