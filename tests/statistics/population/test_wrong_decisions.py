"""Yield, and how many decisions on a lot are wrong: counts of simulated lots lie in their intervals."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.statistics.intervals import covers
from inertialcal.statistics.population.risks import risks, share
from inertialcal.statistics.population.scatter import population


def test_share_has_the_exact_interval() -> None:
    # Clopper-Pearson of 8 in 10: 0.4439 to 0.9748
    found = share(8, 10)
    assert found.value == 0.8
    assert found.interval.lo == pytest.approx(0.4439, abs=1e-4)
    assert found.interval.hi == pytest.approx(0.9748, abs=1e-4)


@pytest.mark.parametrize("n", [20, pytest.param(300, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("units", "u", "band"), [(500, 0.1, 0.0), (500, 0.1, 0.16), (2000, 0.05, 0.0)])
def test_counts_of_wrong_decisions(units: int, u: float, band: float, n: int) -> None:
    hits = np.zeros(2, dtype=int)
    for seed in range(1, n + 1):
        rng = np.random.default_rng(seed)
        true = 0.1 + 0.45 * rng.standard_normal(units)
        y = true + u * rng.standard_normal(units)
        found = population(y, np.full(units, u), np.full(units, np.inf))
        accepted = np.abs(y) <= 1.0 - band
        wrong = risks(y, np.full(units, u), accepted, found, -1.0, 1.0)
        counts = np.sum(np.abs(true[accepted]) > 1.0), np.sum(np.abs(true[~accepted]) <= 1.0)
        for i, (one, count) in enumerate(zip((wrong.consumer, wrong.producer), counts, strict=True)):
            hits[i] += (one.interval.lo or 0.0) <= count <= (one.interval.hi or np.inf)
    assert all(covers(int(count), n) for count in hits), hits


def test_without_uncertainty_nothing_is_wrong() -> None:
    y = np.random.default_rng(1).standard_normal(200)
    found = population(y, np.zeros(200), np.full(200, np.inf))
    wrong = risks(y, np.zeros(200), np.abs(y) <= 1.0, found, -1.0, 1.0)
    assert wrong.consumer.expected == 0.0
    assert wrong.producer.expected == 0.0


def test_units_that_are_hardly_ever_outside_are_no_fault_of_the_program() -> None:
    """Of chances of 1e-170 the squares are zero."""
    y, u = 0.001 * np.random.default_rng(1).standard_normal(50), np.full(50, 0.0005)
    found = population(y, u, np.full(50, np.inf))
    chances = set()
    for far in np.arange(10.0, 60.0, 2.0):
        wrong = risks(y, u, np.ones(50, dtype=bool), found, -0.001 * far, 0.001 * far)
        chances.add(wrong.consumer.expected)
        assert wrong.consumer.interval.lo == 0.0
        assert (wrong.consumer.interval.hi or 0.0) <= 1.0
    assert any(0.0 < one < 1e-160 for one in chances)
