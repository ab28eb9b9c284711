"""Speed of deviations against allantools, in one process, on the same array and averaging times, results agreeing.

Run by ``make bench``. Both take turns, so that all meet the same load; ours comes with intervals and noise types, the
peer's without. Times are of the processor: what others run beside it takes none of it.
"""

from __future__ import annotations

import time
import tracemalloc
from collections.abc import Callable
from statistics import median
from typing import Any

import allantools
import numpy as np
import pytest

from inertialcal.signals.allan import Deviation, allan

PEERS: dict[Deviation, str] = {"overlapping": "oadev", "modified": "mdev", "overlapping_hadamard": "ohdev"}
CASES: list[tuple[Deviation, int, float, int]] = [  # deviation, samples, least ratio (issue 6), rounds
    ("overlapping", 100_000, 10.0, 25),
    ("overlapping", 1_000_000, 25.0, 9),
    ("overlapping", 10_000_000, 10.0, 3),
    ("modified", 100_000, 6.0, 15),
    ("modified", 1_000_000, 6.0, 7),
    ("overlapping_hadamard", 100_000, 6.0, 15),
    ("overlapping_hadamard", 1_000_000, 6.0, 7),
]
INTERVALS_COST = 1.2
COPIES = 1.2  # most extra memory, in arrays of float64


def seconds(action: Callable[[], Any]) -> float:
    started = time.process_time()
    action()
    return time.process_time() - started


@pytest.mark.bench
@pytest.mark.parametrize(("deviation", "n", "least", "rounds"), CASES)
def test_ratio_to_allantools(deviation: Deviation, n: int, least: float, rounds: int) -> None:
    x = np.random.default_rng(1).normal(size=n)
    found = allan(x, 1.0, quantity="rate", deviation=deviation)  # compiled once, kept on disk

    def peer() -> Any:
        return getattr(allantools, PEERS[deviation])(x, rate=1.0, data_type="freq", taus=found.tau)

    assert found.deviation[:, 0] == pytest.approx(peer()[1], rel=1e-9)
    own, other = [], []
    for _ in range(rounds):
        own.append(seconds(lambda: allan(x, 1.0, quantity="rate", deviation=deviation)))
        other.append(seconds(peer))
    ratio = median(other) / median(own)
    times = f"{1e3 * median(own):.2f} ms, allantools {1e3 * median(other):.1f} ms"
    print(f"\n{deviation}, {n} samples: {times}, {ratio:.1f} x")
    assert ratio >= least


@pytest.mark.bench
def test_intervals_cost_at_most_a_fifth() -> None:
    x = np.random.default_rng(1).normal(size=1_000_000)
    allan(x, 1.0, quantity="rate")
    bare, full = [], []
    for _ in range(15):  # said noise without its edf in the store would still count the edf: take the sums alone
        bare.append(seconds(lambda: sums(x)))
        full.append(seconds(lambda: allan(x, 1.0, quantity="rate")))
    print(f"\nwith intervals {1e3 * median(full):.2f} ms, sums alone {1e3 * median(bare):.2f} ms")
    assert median(full) <= INTERVALS_COST * median(bare)


def sums(x: Any) -> Any:
    from inertialcal.signals.allan.deviations import KINDS, variances
    from inertialcal.signals.allan.prefix import phase_of

    return variances(phase_of(x, "rate"), KINDS["overlapping"], 2 ** np.arange(19))


@pytest.mark.parametrize("deviation", PEERS)
def test_extra_memory_is_one_copy(deviation: Deviation) -> None:
    x = np.random.default_rng(1).normal(size=(1_000_000, 2))
    allan(x[:5000], 1.0, quantity="rate", deviation=deviation)
    tracemalloc.start()
    allan(x, 1.0, quantity="rate", deviation=deviation)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak <= COPIES * x[:, 0].nbytes  # one channel after the other
