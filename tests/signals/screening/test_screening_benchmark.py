"""Time and memory of the screening against reading a record from memory and copying it once. Run by ``make bench``."""

from __future__ import annotations

import time
import tracemalloc
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np
import pytest

from inertialcal.signals.screening.screen import screen

MOST = 2.0  # times a sum and a copy (issue 20)
MEMORY = 0.1  # of the record


def seconds(action: Callable[[], Any]) -> float:
    started = time.process_time()
    action()
    return time.process_time() - started


@pytest.mark.bench
def test_ratio_to_a_sum_and_a_copy() -> None:
    x = np.random.default_rng(1).normal(size=10_000_000)
    screen(x)  # compiled once, kept on disk
    own, sums, copies = [], [], []
    for _ in range(9):
        own.append(seconds(lambda: screen(x)))
        sums.append(seconds(lambda: np.sum(x)))
        copies.append(seconds(x.copy))
    mine, reading, copying = (1e3 * median(times) for times in (own, sums, copies))
    ratio = mine / (reading + copying)
    print(f"\nscreening {mine:.1f} ms, sum {reading:.1f} ms, copy {copying:.1f} ms: ratio {ratio:.2f}")
    assert ratio <= MOST


@pytest.mark.bench
def test_memory() -> None:
    x = np.random.default_rng(1).normal(size=10_000_000)
    screen(x)
    tracemalloc.start()
    screen(x)
    share = tracemalloc.get_traced_memory()[1] / x.nbytes
    tracemalloc.stop()
    print(f"\nextra memory: {100.0 * share:.1f} % of the record")
    assert share <= MEMORY
