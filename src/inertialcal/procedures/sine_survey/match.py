"""Which mode of one survey, or sweep, is which of another."""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...core.key import Reason
from ...core.show.rounding import number

NEAR = 0.1  # of a frequency, within which a mode may have moved


def matched(after: Array, before: Array) -> tuple[list[tuple[int, int]], list[tuple[Reason, int, float]]]:
    """Return which mode after is which before, and those that cannot be told: reason, number, frequency.

    Parameters
    ----------
    after, before : ndarray
        Natural frequencies in order [Hz].

    Returns
    -------
    pairs : list of (int, int)
        Places in both.
    refused : list of (Reason, int, float)
        Modes without a pair; those of before are counted on behind those of after.
    """
    logs = [np.log(one) for one in (after, before)]
    near = np.abs(logs[0][:, None] - logs[1][None]) < NEAR
    pairs: list[tuple[int, int]] = []
    refused: list[tuple[Reason, int, float]] = []
    extra = len(after)
    groups = _groups(near)
    for mine, its in groups:
        if len(mine) == len(its) and _in_order(logs[0][mine], logs[1][its]):
            pairs += list(zip(mine, its, strict=True))
            continue
        if not its:
            refused += [
                (Reason("mode_new", "the earlier survey has no mode there"), i + 1, float(after[i])) for i in mine
            ]
            continue
        if not mine:
            for j in its:
                extra += 1
                refused.append((Reason("mode_lost", "it was there before and is gone"), extra, float(before[j])))
            continue
        words = ", ".join(number(float(before[j]), 4) for j in its)
        why = Reason("ambiguous", f"cannot tell which of the modes before it is: {words} Hz")
        refused += [(why, i + 1, float(after[i])) for i in mine]
    return sorted(pairs), sorted(refused, key=lambda one: one[1])


def _groups(near: np.ndarray) -> list[tuple[list[int], list[int]]]:
    """Return modes of both that are near to each other, directly or through others."""
    rows, columns = near.shape
    left, found = set(range(rows)), []
    free = set(range(columns))
    while left or free:
        mine, its = ({left.pop()}, set()) if left else (set(), {free.pop()})
        while True:
            more = {j for i in mine for j in np.flatnonzero(near[i]).tolist() if j in free}
            free -= more
            its |= more
            also = {i for j in its for i in np.flatnonzero(near[:, j]).tolist() if i in left}
            left -= also
            mine |= also
            if not more and not also:
                break
        found.append((sorted(mine), sorted(its)))
    return found


def _in_order(after: Array, before: Array) -> bool:
    """Whether each moved by less than half of what parts it from the next."""
    if len(before) < 2:
        return True
    gap = min(float(np.diff(before).min()), float(np.diff(after).min()))
    return bool(np.max(np.abs(after - before)) < 0.5 * gap)
