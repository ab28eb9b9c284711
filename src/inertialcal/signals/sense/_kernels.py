"""Compiled loops of the search for jumps: arrays in, no checks."""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...statistics._kernels import compiled

ROUNDED = 1e-9  # relative, more than means may differ by rounding


@compiled
def may_stand_out(columns: Array, size: int, gap: int, around: int, few: int, abrupt: float, least: float) -> bool:
    """Return whether a step between means of so many samples may stand out of those beside it in any channel.

    That is: by ``least`` times the median step beyond ``abrupt`` times the largest of its neighbours, ``around`` on
    each side, where there are more than ``few``. No median is taken: steps below a limit are counted.
    """
    channels, n = columns.shape
    many, room = n // size, n // size - gap
    means, step, widest = np.empty(many), np.empty(room), np.empty(room)
    for channel in range(channels):
        x = columns[channel]
        if size == 1:
            means[:] = x
        else:
            for i in range(many):
                total = 0.0
                for value in x[i * size : (i + 1) * size]:
                    total += value
                means[i] = total / size
        later, largest = means[gap:], 0.0
        for i in range(room):
            step[i] = abs(later[i] - means[i])
        for i in range(many):
            largest = max(largest, abs(means[i]))
        widest[:] = step  # of a step and those before it
        for k in range(1, around):
            for i in range(room - k):
                widest[i + k] = max(widest[i + k], step[i])
        most, first, last = -np.inf, gap + around, max(room - gap - around, gap + around)
        before, here, after = widest[around - 1 :], step[first:last], widest[first + gap + around - 1 :]
        for i in range(last - first):
            most = max(most, here[i] - abrupt * max(before[i], after[i]))
        for i in range(room):
            if first <= i < last:
                continue
            beside = 0.0
            if i >= gap + few:
                beside = widest[i - gap - 1]
            if i < room - gap - few:
                for k in range(min(around, room - gap - i)):
                    beside = max(beside, step[i + gap + k])
            most = max(most, step[i] - abrupt * beside)
        if most <= -ROUNDED * largest:
            continue
        limit, below = (most + ROUNDED * largest) * (1.0 + ROUNDED) / least, 0
        for i in range(room):
            below += step[i] < limit
        if below > (room - 1) // 2:
            return True
    return False
