"""When a record is enough: intervals of records that ended by themselves hold the truth; what is steady."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.recording import SECOND
from inertialcal.lab.sequence.conditions import at_rest, held, known_well, stays_at_rest, uncertainty
from inertialcal.lab.sequence.sequence import LOOKS

FEWEST, MOST = 20, 400  # samples of a record


def stopped(x: np.ndarray, time_ns: np.ndarray, u: float) -> int:
    """Return after how many samples a record ends, as the sequence looks at it."""
    stop = FEWEST
    while stop < len(x) and not known_well(x[:stop], time_ns[:stop], u):
        stop += max(stop // LOOKS, 1)
    return min(stop, len(x))


@pytest.mark.parametrize("n", [100, pytest.param(1000, marks=pytest.mark.slow)])
def test_intervals_of_records_that_ended_by_themselves_hold_the_truth(n: int) -> None:
    """White noise of scatter 1 about zero, 60 samples or so for the wanted uncertainty: exact 99.9 % of 93 %."""
    rng, inside, lengths = np.random.default_rng(1), 0, []
    time_ns = np.arange(MOST) * SECOND
    for _ in range(n):
        x = rng.normal(size=(MOST, 1))
        stop = stopped(x, time_ns, 0.13)
        _, half = uncertainty(x[:stop], time_ns[:stop])
        used = x[1 : stop - 1, 0]  # without its edges, as of a dwell
        inside += abs(used.mean()) <= half[0]
        lengths.append(stop)
    assert 40 < np.median(lengths) < 90
    assert inside >= 0.93 * n - 3.3 * np.sqrt(0.93 * 0.07 * n)


def test_correlated_noise_takes_longer() -> None:
    rng, time_ns = np.random.default_rng(2), np.arange(4 * MOST) * SECOND
    white = rng.normal(size=(4 * MOST, 1))
    slow = np.empty_like(white)
    slow[0] = white[0]
    for i in range(1, len(slow)):
        slow[i] = 0.6 * slow[i - 1] + 0.8 * white[i]
    assert stopped(slow, time_ns, 0.13) > 2 * stopped(white, time_ns, 0.13)


def test_a_value_is_held_at_its_own_within_its_limits_and_up_to_the_end() -> None:
    time_ns = np.arange(20) * SECOND
    x = np.concatenate([np.linspace(0.0, 9.0, 10), np.full(10, 10.0)])
    assert held(x, time_ns, 10.0, 0.01, 9.0)
    assert not held(x, time_ns, 10.0, 0.01, 9.5)  # not for so long
    assert not held(x, time_ns, 10.1, 0.01, 5.0)  # elsewhere
    assert held(x, time_ns, None, 0.01, 5.0)
    assert not held(np.append(x[:-1], 10.5), time_ns, 10.0, 0.01, 5.0)  # no longer
    assert not held(x[:3], time_ns[:3], 2.0, 0.01, 0.0)


def test_rest_is_what_the_procedures_take_for_it() -> None:
    rng = np.random.default_rng(3)
    time_ns = np.arange(600) * SECOND // 100
    x = rng.normal(scale=0.01, size=(600, 3)) + np.array([0.0, 0.0, 9.8])
    assert at_rest(x, time_ns, 4.0)
    assert stays_at_rest(x, time_ns)
    x[:300, 0] += np.sin(np.arange(300) / 10.0)
    assert at_rest(x, time_ns, 2.5)
    assert not at_rest(x, time_ns, 4.0)
    assert not stays_at_rest(x, time_ns)
    assert not at_rest(x[:250], time_ns[:250], 0.5)


def test_few_samples_make_a_wide_interval() -> None:
    """Student's t of nine degrees of freedom, 2.262 (table), or of fewer where neighbours look alike."""
    rng, time_ns = np.random.default_rng(4), np.arange(12) * SECOND
    for _ in range(20):
        u, half = uncertainty(rng.normal(size=(12, 1)), time_ns)  # ten without the edges
        assert half[0] >= 2.262 * u[0]
