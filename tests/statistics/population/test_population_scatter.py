"""Scatter of a population: closed forms, truth of simulated lots, what breaks it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from inertialcal.core.errors import DataError
from inertialcal.core.results import Interval
from inertialcal.statistics.intervals import covers, t_quantile
from inertialcal.statistics.population.scatter import Population, _normal_p, population

MEAN, LOWER, UPPER = 0.3, -1.0, 3.0
# units, stations, scatter of the population, own uncertainty, its degrees of freedom, what a station shares
CASES = {
    "one station": (60, 1, 0.4, 0.1, 5.0, 0.0),
    "four stations": (200, 4, 0.3, 0.2, 4.0, 0.2),
    "tests scatter more": (400, 4, 0.1, 0.3, 10.0, 0.1),
    "few units": (12, 1, 0.4, 0.2, 5.0, 0.0),
    "uniform": (200, 2, 0.4, 0.1, 5.0, 0.1),
}


def exact(values: np.ndarray, own: float = 0.0) -> Population:
    return population(values, np.full(values.size, own), np.full(values.size, np.inf))


def lot(name: str, seed: int) -> tuple[Population, float]:
    """Return what is found of a simulated lot, and what its population scatters."""
    n, stations, scatter, u, dof, common = CASES[name]
    rng = np.random.default_rng(seed)
    at = np.arange(n) % stations
    unit = rng.uniform(-1.0, 1.0, n) * math.sqrt(3.0) if name == "uniform" else rng.standard_normal(n)
    true_u = u * np.exp(0.3 * rng.standard_normal(n))
    y = MEAN + scatter * unit + common * rng.standard_normal(stations)[at] + true_u * rng.standard_normal(n)
    stated = true_u * np.sqrt(rng.chisquare(dof, n) / dof)
    return population(y, stated, np.full(n, dof), common, at), scatter


def holds(interval: Interval, value: float) -> bool:
    return (interval.lo is None or interval.lo <= value) and (interval.hi is None or value <= interval.hi)


def test_without_uncertainty_it_is_the_standard_deviation() -> None:
    y = np.random.default_rng(1).normal(2.0, 0.5, 25)
    found = exact(y)
    assert found.scatter == pytest.approx(y.std(ddof=1), rel=1e-12)
    assert found.mean == pytest.approx(y.mean(), rel=1e-12)
    assert found.mean_u == pytest.approx(y.std(ddof=1) / 5.0, rel=1e-12)
    assert found.mean_dof == pytest.approx(24.0)
    low, high = (math.sqrt(24 / stats.chi2.ppf(q, 24)) * y.std(ddof=1) for q in (0.975, 0.025))
    assert found.scatter_interval.lo == pytest.approx(low, rel=2e-3)
    assert found.scatter_interval.hi == pytest.approx(high, rel=2e-3)


def test_what_tests_scatter_is_taken_off() -> None:
    y = np.random.default_rng(2).normal(0.0, 0.5, 4_000)
    assert exact(y, 0.3).scatter == pytest.approx(0.4, rel=0.03)


def test_capability_of_the_handbook() -> None:
    # NIST/SEMATECH e-Handbook 6.1.6: limits 8 and 20, mean 16, standard deviation 2: Cp 1.0, Cpk 0.6667
    y = np.random.default_rng(3).standard_normal(50)
    y = 16.0 + 2.0 * (y - y.mean()) / y.std(ddof=1)
    found = exact(y).capability(8.0, 20.0)
    assert found.cp == pytest.approx(1.0, rel=1e-9)
    assert found.cpk == pytest.approx(2.0 / 3.0, rel=1e-9)
    assert found.conforming == pytest.approx(stats.norm.cdf(2.0) - stats.norm.cdf(-4.0), rel=1e-9)


def test_one_limit() -> None:
    y = 1.0 + 0.1 * np.random.default_rng(4).standard_normal(200)
    found = exact(y)
    assert found.capability(None, 1.6).cpk == pytest.approx((1.6 - found.mean) / (3 * found.scatter), rel=1e-9)
    assert math.isnan(found.capability(None, 1.6).cp)


def test_a_population_that_does_not_show() -> None:
    rng = np.random.default_rng(5)
    found = population(rng.normal(0.0, 0.3, 300), np.full(300, 0.3), np.full(300, np.inf))
    assert not found.seen
    capable = found.capability(-1.0, 1.0)
    assert math.isnan(capable.cpk)
    assert capable.cpk_interval.hi is None
    assert capable.cpk_interval.lo is not None
    assert capable.cpk_interval.lo > 1.0


def test_uncertainties_stated_too_large_are_told() -> None:
    rng = np.random.default_rng(6)
    assert exact(rng.normal(0.0, 0.3, 300), 0.6).excess < 1e-9
    assert exact(rng.normal(0.0, 0.6, 300), 0.6).excess > 1e-3


def test_units_that_are_not_normal_are_told() -> None:
    rng = np.random.default_rng(7)
    assert exact(rng.exponential(1.0, 400)).normal_p < 1e-6
    assert exact(rng.standard_normal(400)).normal_p > 1e-3


@pytest.mark.parametrize("n", [30, 31, 400])
def test_normality_is_that_of_scipy(n: int) -> None:
    rng = np.random.default_rng(n)
    for x in (rng.standard_normal(n), rng.exponential(size=n), rng.uniform(size=n), 3.0 + rng.standard_t(3, n)):
        assert _normal_p(x) == pytest.approx(stats.normaltest(x).pvalue, rel=1e-10)


def test_stations_that_differ_widen_the_mean() -> None:
    rng = np.random.default_rng(8)
    at = np.arange(400) % 4
    y = rng.standard_normal(400) + np.array([0.0, 0.0, 0.0, 4.0])[at]
    found = population(y, np.zeros(400), np.full(400, np.inf), 0.0, at)
    assert found.scatter == pytest.approx(1.0, rel=0.1)
    assert found.between == pytest.approx(2.0, rel=0.1)
    assert found.mean_dof == 3.0


def test_the_same_each_time() -> None:
    first, second = (lot("four stations", 3)[0] for _ in range(2))
    assert first.scatter_interval == second.scatter_interval
    assert first.capability(LOWER, UPPER) == second.capability(LOWER, UPPER)


def test_refusals() -> None:
    with pytest.raises(DataError, match="leave no scatter"):
        exact(np.array([1.0]))
    with pytest.raises(DataError, match="not finite"):
        exact(np.array([1.0, np.nan]))
    with pytest.raises(DataError, match="below an upper"):
        exact(np.array([1.0, 2.0, 3.0])).capability(2.0, 1.0)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("n", [20, pytest.param(300, marks=pytest.mark.slow)])
def test_coverage(name: str, n: int) -> None:
    hits = dict.fromkeys(("mean", "scatter", "cpk", "conforming"), 0)
    for seed in range(1, n + 1):
        found, scatter = lot(name, seed)
        capable = found.capability(LOWER, UPPER)
        share = stats.norm.cdf((UPPER - MEAN) / scatter) - stats.norm.cdf((LOWER - MEAN) / scatter)
        hits["mean"] += abs(found.mean - MEAN) <= t_quantile(found.mean_dof, 0.975) * found.mean_u
        hits["scatter"] += holds(found.scatter_interval, scatter)
        hits["cpk"] += holds(capable.cpk_interval, min(MEAN - LOWER, UPPER - MEAN) / (3 * scatter))
        hits["conforming"] += holds(capable.conforming_interval, share)
    assert all(covers(count, n) for count in hits.values()), hits
