"""Speed of deviations against allantools, in one process, on the same array and averaging times, results agreeing.

Run by ``make bench``. Both take turns, so that all meet the same load. Timed are the deviations alone, as the peer
gives them; what noise types and intervals cost on top has a bound of its own. The ratio with them is printed beside.
Times are of the processor: what others run beside it takes none of it.
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
from numpy.typing import NDArray

from inertialcal.core.estimate import Array
from inertialcal.signals.allan import Deviation, allan
from inertialcal.signals.allan.deviations import KINDS, variances
from inertialcal.signals.allan.prefix import give_back, phase_of

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
AGREES = 1e-9  # relative
INTERVALS_COST = 1.2
COPIES = 1.2  # most extra memory, in arrays of float64


def seconds(action: Callable[[], Any]) -> float:
    started = time.process_time()
    action()
    return time.process_time() - started


def alone(x: Array, deviation: Deviation, factors: NDArray[np.int64]) -> Array:
    phase = phase_of(x, "rate")
    found: Array = np.sqrt(variances(phase, KINDS[deviation], factors).variance)
    give_back(phase)
    return found


@pytest.mark.bench
@pytest.mark.parametrize(("deviation", "n", "least", "rounds"), CASES)
def test_ratio_to_allantools(deviation: Deviation, n: int, least: float, rounds: int) -> None:
    x = np.random.default_rng(1).normal(size=n)
    found = allan(x, 1.0, quantity="rate", deviation=deviation)  # compiled once, kept on disk

    def peer() -> Any:
        return getattr(allantools, PEERS[deviation])(x, rate=1.0, data_type="freq", taus=found.tau)

    assert found.deviation[:, 0] == pytest.approx(peer()[1], rel=AGREES)
    assert alone(x, deviation, found.m) == pytest.approx(found.deviation[:, 0])
    own, full, other = [], [], []
    for _ in range(rounds):
        own.append(seconds(lambda: alone(x, deviation, found.m)))
        other.append(seconds(peer))
        full.append(seconds(lambda: allan(x, 1.0, quantity="rate", deviation=deviation)))
        other.append(seconds(peer))
    bare, whole, theirs = (1e3 * median(times) for times in (own, full, other))
    times = f"{bare:.2f} ms, with intervals {whole:.2f} ms, allantools {theirs:.1f} ms"
    print(f"\n{deviation}, {n} samples: {times}: {theirs / bare:.1f} and {theirs / whole:.1f} x")
    assert theirs / bare >= least


@pytest.mark.bench
def test_intervals_cost_at_most_a_fifth() -> None:
    x = np.random.default_rng(1).normal(size=1_000_000)
    factors = allan(x, 1.0, quantity="rate").m
    bare, full = [], []
    for _ in range(15):
        bare.append(seconds(lambda: alone(x, "overlapping", factors)))
        full.append(seconds(lambda: allan(x, 1.0, quantity="rate")))
    print(f"\nwith intervals {1e3 * median(full):.2f} ms, deviations alone {1e3 * median(bare):.2f} ms")
    assert median(full) <= INTERVALS_COST * median(bare)


@pytest.mark.parametrize("deviation", PEERS)
def test_extra_memory_is_one_copy(deviation: Deviation) -> None:
    x = np.random.default_rng(1).normal(size=(1_000_000, 2))
    allan(x, 1.0, quantity="rate", deviation=deviation)  # loads the loops
    tracemalloc.start()
    allan(x, 1.0, quantity="rate", deviation=deviation)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak <= COPIES * x[:, 0].nbytes  # one channel after the other
