"""Whether the runs show the same curve: one that does not is a mistake of its recording, not scatter.

Two runs are as far apart as the root mean square difference of their cells in the same bins on the same paths, after
their offsets. A run whose median distance from the others is many times theirs has another curve: axes exchanged, a
sign turned, another sensor. It stays in the fit, where it widens every uncertainty, and is named. A mistake that all
recordings share shows nowhere here.
"""

from __future__ import annotations

import numpy as np

from ....core.remarks import Remark
from ..readings import Readings
from .cells import Cells

FEWEST = 4  # runs, so that most of them can be right
FAR = 8.0  # times the median distance of the others


def odd_runs(axis: str, cells: Cells, readings: Readings) -> list[Remark]:
    """Return a remark for each run of one sensor whose curve is not that of the others."""
    runs = np.unique(cells.run)
    if len(runs) < FEWEST:
        return []
    size = int(cells.bin.max()) + 1
    table = np.full((len(runs), 3 * size), np.nan)
    for row, run in enumerate(runs):
        own = cells.run == run
        key = (cells.path[own] + 1) * size + cells.bin[own]
        weight = np.bincount(key, cells.weight[own], 3 * size)
        total = np.bincount(key, cells.weight[own] * cells.reading[own], 3 * size)
        table[row] = np.divide(total, weight, out=table[row], where=weight > 0.0)
    apart = np.array([[_apart(one, other) for other in table] for one in table])
    np.fill_diagonal(apart, np.nan)
    if not np.isfinite(apart).any(axis=1).all():
        return []
    median = np.nanmedian(apart, axis=1)
    found = []
    for row, run in enumerate(runs):
        others = float(np.median(np.delete(median, row)))
        if others > 0.0 and median[row] > FAR * others:
            what = f"{axis} sensor: run {readings.labels[run]!r} shows another curve than the others"
            do = "Look for exchanged axes, a turned sign, or another unit in this recording"
            found.append(Remark("run_differs", "warning", what, _place(readings, int(run)), do=do))
    return found


def _apart(one: np.ndarray, other: np.ndarray) -> float:
    """Root mean square difference of two curves after their offset; NaN with less than three bins in common."""
    difference = (one - other)[np.isfinite(one) & np.isfinite(other)]
    return float(difference.std()) if len(difference) >= 3 else np.nan


def _place(readings: Readings, run: int) -> str:
    return next(one.place for one in readings.sweeps if one.run == readings.labels[run])
