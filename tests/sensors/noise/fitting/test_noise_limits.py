"""Ends of intervals and upper limits against the closed form of the cost of white noise, and a minimum of our own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from noise_records import exact_run
from scipy import optimize, special

from inertialcal.core.estimate import Array
from inertialcal.sensors.noise import _kernels as kernels
from inertialcal.sensors.noise.fitting.likelihood import SPACINGS, covariance_of_runs, estimate, sandwich, terms_wanted
from inertialcal.sensors.noise.fitting.limits import (
    Held,
    Missing,
    end_of,
    interval_of,
    limits_and_records,
    longer,
    wide_intervals,
)
from inertialcal.sensors.noise.fitting.problem import Problem, problem_of
from inertialcal.sensors.noise.terms import RandomWalk

WHITE = ("random_walk",)
CHI_SQUARE = 3.841458820694124  # 95 % point with one degree of freedom
NORMAL = 1.959963984540054
SURE = 2.575829303548901  # standard uncertainties: 99.5 %
LIKELIER = 10.83  # rise that a further term must make up for


def white(n: int) -> tuple[Problem, int]:
    """White noise of 1 unit/sqrt(Hz) at 1 Hz with the variances that are expected, and its column."""
    problem = problem_of([exact_run((RandomWalk(1.0),), n, 1.0)])
    return problem, problem.names.index("random_walk")


def rise(problem: Problem, ratio: float) -> float:
    """2 (cost at ``ratio`` times the best power less the least): all means are in proportion to one power."""
    return float(2.0 * problem.weight.sum() * (np.log(ratio) + 1.0 / ratio - 1.0))


def test_a_power_that_is_known_well_has_a_symmetric_interval_of_its_logarithm() -> None:
    problem, at = white(100_000)
    best = estimate(problem, WHITE)
    bread = sandwich(problem, best, covariance_of_runs(problem, best))
    found = interval_of(problem, best, at, bread, 0.95)
    assert found.lo is not None
    assert found.hi is not None
    relative = float(bread.u[0]) / float(best.powers[at])
    assert np.log(found.hi / found.lo) == pytest.approx(2.0 * NORMAL * relative, rel=1e-6)


def test_ends_lie_where_the_cost_has_risen_by_the_point_of_chi_square() -> None:
    problem, at = white(100)
    best = estimate(problem, WHITE)
    stretch = float(sandwich(problem, best, covariance_of_runs(problem, best)).stretch[0])
    (wide,) = wide_intervals(problem, best, [at], WHITE, [stretch], 0.95)
    assert wide.lo is not None
    assert wide.hi is not None
    for end in (wide.lo, wide.hi):
        assert rise(problem, end / best.powers[at]) == pytest.approx(CHI_SQUARE * stretch, rel=0.03)
    for step, furthest in ((0.1, 40.0), (-0.1, -40.0)):
        held = Held(problem, WHITE, at, (0.0, 0.0))
        x, _ = end_of(held, float(best.powers[at]), best.cost, stretch, CHI_SQUARE, step, furthest)
        assert x is not None
        assert rise(problem, float(np.exp(x))) == pytest.approx(CHI_SQUARE * stretch, rel=0.03)


@pytest.mark.parametrize("way", [kernels.POWER, kernels.LIMIT])
@pytest.mark.parametrize("step", [0.01, 1.0])
def test_a_root_beside_costs_that_were_seen_is_the_same(way: int, step: float) -> None:
    problem, at = white(100)
    best = estimate(problem, WHITE)
    start, wanted, powers = float(best.powers[at]), terms_wanted(WHITE, 0), np.empty(len(problem.names) + 1)

    def root(target: float, tolerance: float, seen: Array) -> float:
        return kernels.root_of(
            problem.columns, problem.table, problem.data, wanted, at, 0.0, 0.0, SPACINGS[:2], way, start,
            0.0 if way == kernels.POWER else 0.1 * start, best.cost, step, target, 40.0, 0.0, tolerance, powers, seen,
        )  # fmt: skip

    seen = np.full(kernels.SEEN, np.nan)
    for target, tolerance in ((3.8, 0.1), (5.1, 1e-3), (1.2, 1e-3), (3.8, 1e-3)):
        fresh = root(target, tolerance, np.full(kernels.SEEN, np.nan))
        assert np.isfinite(fresh)
        assert root(target, tolerance, seen) == fresh
    assert np.isfinite(seen).sum() >= 2


def test_the_degrees_of_freedom_of_a_longer_record_are_those_of_white_noise() -> None:
    short, long = (exact_run((RandomWalk(1.0),), n, 1.0) for n in (4096, 16384))
    at = [0, *range(4, len(long.edf) - 2)]  # between them neighbouring windows overlap by less than at the longest
    roots = longer(short.edf[None])[0]
    np.testing.assert_allclose(2.0 * roots[2, : len(long.edf)][at] ** 2, long.edf[at], rtol=0.1)
    assert np.all(roots[2, len(long.edf) :] == 0.0)


@pytest.mark.parametrize(
    ("name", "share"), [("rate_random_walk", 0.0), ("rate_random_walk", 0.5), ("quantization", 0.5)]
)
def test_the_upper_limit_of_a_term_that_white_noise_hides(name: str, share: float) -> None:
    """At the limit, so small an estimate is 1 in 20 of those that miss the term; by a minimum of our own."""
    plain, at_white = white(4096)
    at = plain.names.index(name)
    a, b, weight = plain.columns[:, at_white], plain.columns[:, at], plain.weight
    D = np.column_stack([a, b])

    def bread(problem: Problem, power: float) -> tuple[float, float]:
        """u of its power, and its stretch, where it is held."""
        held = estimate(problem, ("random_walk", name), at, power)
        W = weight / (D @ held.powers[[at_white, at]]) ** 2
        naive = np.linalg.inv(D.T @ (W[:, None] * D))
        whole = naive @ (D.T * W) @ covariance_of_runs(problem, held) @ (W[:, None] * D) @ naive
        return float(np.sqrt(whole[1, 1])), float(whole[1, 1] / naive[1, 1])

    u, first = bread(plain, 1e-9 * float(np.min(a / b)))
    named = u * float(np.sqrt(LIKELIER / first))
    found = share * named
    problem = replace(plain, variance=a + found * b)
    best = estimate(problem, WHITE)
    missing = [Missing(at, best.position)]
    ((limit, _, beside_rival),) = limits_and_records(problem, best, missing, covariance_of_runs(problem, best))
    assert not beside_rival
    assert limit is not None

    def cost(log_white: float, power: float) -> float:
        mu = np.exp(log_white) * a + power * b
        return float(np.sum(weight * (np.log(mu) + problem.variance / mu)))

    there = optimize.minimize_scalar(cost, args=(limit,), bounds=(-3.0, 1.0), method="bounded", options={"xatol": 1e-9})
    far = float(np.sqrt(2.0 * (there.fun - cost(0.0, found)) / bread(problem, limit)[1]))
    missed = far - (named - found) / (limit - found) * far  # its distance from what would have been named
    chance = float(special.ndtr(-far) / special.ndtr(-missed))
    if name == "quantization":
        assert chance == pytest.approx(0.05, abs=0.015)  # the stretch is that of a rough end
    else:  # named in 99.5 % of records with so much
        assert missed == pytest.approx(SURE, rel=0.06)


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 40.0))
@settings(max_examples=50, deadline=None)
def test_a_root_is_where_scipy_finds_it(seed: int, at: float) -> None:
    rng = np.random.default_rng(seed)
    power, bend = rng.uniform(0.2, 4.0), rng.uniform(0.0, 2.0)

    def function(x: float) -> float:
        return float(x**power - at**power + bend * (np.sqrt(x) - np.sqrt(at)))

    inside, outside, tolerance = 0.0, 64.0, 0.01
    state = np.array([inside, outside, 0.0, function(inside), function(outside), 0.0, 0.0, 0.0])
    while not kernels.brent(state, tolerance):
        state[4] = function(state[1])
    assert state[1] == pytest.approx(optimize.brentq(function, inside, outside, xtol=tolerance), rel=1e-12)


@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.integers(0, 2))
@settings(max_examples=50, deadline=None)
def test_the_inverse_is_that_of_the_directions_that_are_told(seed: int, size: int, lost: int) -> None:
    rng = np.random.default_rng(seed)
    rank = max(size - lost, 1)
    A = rng.normal(size=(size, rank))
    A = A @ A.T
    found = A.copy()
    kernels.invert(found, 1e-10)
    expected = np.linalg.pinv(A, rcond=1e-10, hermitian=True)
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-9 * np.abs(expected).max())
