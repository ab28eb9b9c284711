"""Two clocks: offset and drift from rows that come late, with uncertainties that hold; save intervals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from inertialcal.files.loggers.rows import RowChannel, RowLayout
from inertialcal.lab.acquisition.intervals import Intervals
from inertialcal.lab.acquisition.relation import FEWEST, OwnTime, Relation

DRIFT, OFFSET = 37e-6, 1234.5  # truth
PLACE = 1_700_000_000.0


def related(seed: int, rows: int = 4000, interval: float = 0.01, delay: float = 2e-3) -> Relation:
    """Return what is kept of a link whose delays are exponential, about a least one of 1 ms; in lots of 16 rows."""
    rng = np.random.default_rng(seed)
    device = (PLACE + interval * np.arange(rows)).astype(np.float64)
    made = OFFSET + (1.0 + DRIFT) * (device - PLACE)  # by the computer's clock
    came = np.rint(1e9 * (made + 1e-3 + rng.exponential(delay, rows))).astype(np.int64)
    relation = Relation()
    for first in range(0, rows, 16):
        relation.add(device[first : first + 16], came[first : first + 16])
    return relation


def is_inside(seed: int) -> bool:
    found = related(seed).found()
    assert found.estimate is not None
    half = stats.t.ppf(0.975, found.estimate.dof[1]) * found.estimate.u[1]
    return bool(abs(found.estimate.values[1] - DRIFT) <= half)


def hold(n: int) -> None:
    inside = sum(is_inside(seed) for seed in range(1, n + 1))
    interval = stats.binomtest(inside, n).proportion_ci(0.999)
    assert interval.high >= 0.95, f"{inside} of {n}"


def test_the_drift_is_held_by_its_interval() -> None:
    hold(100)


@pytest.mark.slow
def test_the_drift_is_held_by_its_interval_in_a_thousand() -> None:
    hold(1000)


def test_times_of_the_instrument_are_put_on_the_computers_clock() -> None:
    found = related(1).found()
    assert found.estimate is not None
    device = np.array([PLACE, PLACE + 20.0, PLACE + 39.0])
    expected = OFFSET + 1e-3 + (1.0 + DRIFT) * (device - PLACE)  # the least delay cannot be told from the offset
    np.testing.assert_allclose(found.host_time(device) / 1e9, expected, atol=3e-4)


def test_a_short_record_says_so() -> None:
    found = related(1, rows=20).found()
    assert found.estimate is None
    assert f"need {FEWEST}" in found.reason


def test_memory_does_not_grow() -> None:
    relation = Relation()
    for day in range(200):
        at = 86400.0 * day + np.arange(0.0, 86400.0, 600.0)
        relation.add(at, np.rint(1e9 * at).astype(np.int64))
    assert len(relation._blocks) <= 64
    found = relation.found()
    assert found.estimate is not None
    assert abs(found.estimate.values[1]) < 1e-9


def test_a_counter_is_followed_over_the_end_of_its_type() -> None:
    own = OwnTime(RowLayout((RowChannel("n", "uint8", role="counter"),), interval=0.5))
    first = own.seconds(np.array([254, 255, 0], np.uint8))
    second = own.seconds(np.array([1, 4], np.uint8))
    assert [*first, *second] == [127.0, 127.5, 128.0, 128.5, 130.0]
    assert own.restarts == 0


def test_a_time_in_its_unit_that_goes_back_is_counted() -> None:
    own = OwnTime(RowLayout((RowChannel("t", "int64", "ms", role="time"),)))
    np.testing.assert_allclose(own.seconds(np.array([1000, 2500])), [1.0, 2.5])
    own.seconds(np.array([100, 200]))
    assert own.restarts == 1


def test_save_intervals_are_those_of_the_thesis() -> None:
    """3 s 17 times, 5 s 7 times and 6 s twice among 2 s: errata of npsat2011, and its appendix on ACS 238."""
    rng = np.random.default_rng(1)
    apart = rng.permutation(np.repeat([2.0, 3.0, 5.0, 6.0], [4000, 17, 7, 2]))
    seconds = 1.27e9 + np.cumsum(apart)
    intervals = Intervals(2.0)
    for lot in np.array_split(seconds, 700):
        intervals.add(lot)
    assert str(intervals) in ("3 s x17, 5 s x7, 6 s x2 for 2 s", "3 s x16, 5 s x7, 6 s x2 for 2 s")
    assert intervals.count == len(seconds) - 1
    assert math.isclose(sum(intervals.odd.values()), 26, abs_tol=1)


def test_save_intervals_take_no_more_memory_with_time() -> None:
    intervals = Intervals(1.0)
    intervals.add(np.cumsum(np.random.default_rng(2).uniform(0.0, 1e4, 50_000)))
    assert len(intervals._counts) <= 1000
    assert intervals.count == 49_999
    assert str(Intervals(2.0)) == ""
