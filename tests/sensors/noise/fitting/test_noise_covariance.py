"""Covariance of Allan variances across averaging times: exact sum, and simulated records."""

from __future__ import annotations

from inspect import unwrap

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import minimize, nnls

from inertialcal.core.estimate import Array
from inertialcal.sensors.noise import _kernels as kernels
from inertialcal.sensors.noise.expected import expected_variance
from inertialcal.sensors.noise.fitting.allan_covariance import (
    LAGS,
    _lags,
    covariance_of_allan,
    model_edf,
    noise_on_line,
)
from inertialcal.sensors.noise.fitting.problem import run_of
from inertialcal.sensors.noise.simulate import simulate
from inertialcal.sensors.noise.terms import (
    BiasInstability,
    GaussMarkov,
    Phase,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Sinusoid,
    Term,
    total_phase,
)
from inertialcal.signals.allan import allan

QUADRATURE = 1e-3  # of a correlation or variance: panels of distances
END_EFFECTS = 0.01  # the same, of a line that a record holds many cycles of
SMALL_WINDOWS = 0.3  # the same, of windows of two samples, with gaps: some rest on one sample alone
DEAD_TIME = 0.025  # the same, of flicker with dead time, whose short part is taken as white
N = 2048
M: Array = np.exp2(np.arange(10.0))

MIXTURES: list[tuple[Term, ...]] = [
    (RandomWalk(1.0),),
    (Quantization(1.0),),
    (BiasInstability(1.0),),
    (RateRandomWalk(1.0),),
    (GaussMarkov(1.0, 30.0),),
    (RandomWalk(1.0), RateRamp(0.002)),
    (RandomWalk(1.0), GaussMarkov(0.3, 10.0), RateRandomWalk(0.01), BiasInstability(0.1), Quantization(0.3)),
]


def every_distance(phase: Phase, m: Array, n: Array, line: Phase | None = None) -> Array:
    """The same by the sum over all distances; the differences of a line of unknown phase are known ones."""
    k, w = len(m), (1.0, -2.0, 1.0)
    lags = np.arange(4 * N)
    noise = phase.covariance(lags)
    known = np.zeros(4 * N) if line is None else line.covariance(lags)
    out = np.zeros((k, k))
    for i in range(k):
        for j in range(k):
            lag = np.arange(-(n[i] - 1), n[j])
            at = [(w[a] * w[b], np.abs(lag + b * m[j] - a * m[i]).astype(int)) for a in range(3) for b in range(3)]
            s, mu = (sum(weight * of[lags] for weight, lags in at) / (m[i] * m[j]) for of in (noise, known))
            pairs = np.minimum(n[i], n[j] - lag) - np.maximum(0, -lag)
            out[i, j] = np.sum(pairs * (s**2 / 2 + (mu + phase.ramp**2 * m[i] * m[j]) * s)) / (n[i] * n[j])
    return out


@pytest.mark.parametrize(
    ("terms", "averaging", "tolerance"),
    [*((terms, 1.0, QUADRATURE) for terms in MIXTURES), (MIXTURES[-1], 0.5, DEAD_TIME)],
    ids=lambda value: "+".join(term.name for term in value) if isinstance(value, tuple) else "",
)
def test_is_the_sum_over_all_distances(terms: tuple[Term, ...], averaging: float, tolerance: float) -> None:
    phase, n = total_phase(terms, 1.0, averaging), N - 2 * M + 1
    exact = every_distance(phase, M, n)
    found = covariance_of_allan(phase, M, n)
    unit = np.sqrt(np.diag(exact))
    assert np.max(np.abs(found - exact) / np.outer(unit, unit)) < tolerance


def test_noise_on_a_line_is_the_sum_over_all_distances() -> None:
    noise, line = (RandomWalk(1.0), GaussMarkov(0.5, 10.0)), Sinusoid(20.0, 0.11)
    n, phase = N - 2 * M + 1, total_phase(noise, 1.0)
    exact = every_distance(phase, M, n, total_phase((line,), 1.0))
    both = total_phase((*noise, line), 1.0)
    found = covariance_of_allan(phase, M, n) + noise_on_line(both, both.cosines[0], M, n)
    unit = np.sqrt(np.diag(exact))
    assert exact[0, 0] > 3.0 * every_distance(phase, M[:1], n[:1])[0, 0]
    assert np.max(np.abs(found - exact) / np.outer(unit, unit)) < END_EFFECTS


@pytest.mark.parametrize(
    "terms",
    [(RandomWalk(1.0), RateRandomWalk(0.03)), (RandomWalk(0.03), Sinusoid(0.5, 0.037), Sinusoid(0.3, 0.041))],
    ids=["walk", "lines"],
)
def test_is_that_of_simulated_records(terms: tuple[Term, ...]) -> None:
    rng = np.random.default_rng(3)
    records = np.column_stack([simulate(terms, 1024, 1.0, rng) for _ in range(2000)])
    curve = allan(records, 1.0, quantity="rate", noise=0)
    used = curve.m <= 128
    seen = np.cov(curve.deviation[used] ** 2)
    found = covariance_of_allan(total_phase(terms, 1.0), curve.m[used].astype(float), curve.n[used, 0].astype(float))
    unit = np.sqrt(np.diag(seen))
    assert np.diag(found) == pytest.approx(np.diag(seen), rel=0.2)
    assert np.max(np.abs(found - seen) / np.outer(unit, unit)) < 0.2


def test_white_noise_has_the_published_degrees_of_freedom() -> None:
    m = np.array([1.0])  # Greenhall and Riley: overlapping, m = 1: 18 M^2 / (35 M - 18) is N^2 / (..) ~ 2/3 N
    edf = model_edf(
        expected_variance(RandomWalk(1.0), m, 1.0),
        covariance_of_allan(total_phase((RandomWalk(1.0),), 1.0), m, N - 1.0 * m),
    )
    assert edf[0] == pytest.approx(2.0 / 3.0 * N, rel=2e-3)


def exact_with_gaps(present: NDArray[np.bool_], m: NDArray[np.int64]) -> Array:
    """Covariance for white noise of variance 1 and these very gaps: that of quadratic forms, twice a trace."""
    forms = []
    for size in m:
        rows = []
        for j in range(len(present) - 2 * size + 1):
            windows = [present[at : at + size] for at in (j, j + size)]
            if all(2 * window.sum() >= size for window in windows):
                row = np.zeros(len(present))
                row[j : j + 2 * size] = np.concatenate(
                    [sign * w / w.sum() for sign, w in zip((-1, 1), windows, strict=True)]
                )
                rows.append(row)
        D = np.array(rows)
        forms.append(0.5 * D.T @ D / len(D))
    return np.array([[2.0 * np.sum(one * other) for other in forms] for one in forms])


@pytest.mark.parametrize("share", [0.1, 0.3])
@pytest.mark.parametrize("burst", [1, 20])
def test_missing_samples_leave_the_covariance_right(share: float, burst: int) -> None:
    """Left out of it, they make the intervals of terms too short by their share."""
    present = np.repeat(np.random.default_rng(4).random(400 // burst) >= share, burst)
    x = np.where(present, np.random.default_rng(5).normal(size=400), np.nan)
    run = run_of(allan(x, 1.0, quantity="rate", noise=0))
    exact = exact_with_gaps(present, run.m.astype(int))
    found = covariance_of_allan(total_phase((RandomWalk(1.0),), 1.0), run.m, run.n, run.inflation)
    assert np.diag(found) == pytest.approx(np.diag(exact), rel=SMALL_WINDOWS)
    slopes = run.edf / (run.inflation / run.m)  # what the size of white noise takes from each averaging time
    assert slopes @ found @ slopes == pytest.approx(slopes @ exact @ slopes, rel=0.08)


def test_is_a_covariance() -> None:
    phase = total_phase((RandomWalk(1.0), GaussMarkov(0.3, 10.0), BiasInstability(0.1)), 1.0)
    assert np.all(np.linalg.eigvalsh(covariance_of_allan(phase, M[:3], N - 2 * M[:3] + 1)) > 0.0)


@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.integers(-1, 5))
def test_nonnegative_solutions_are_those_of_the_library(seed: int, p: int, held: int) -> None:
    rng = np.random.default_rng(seed)
    sizes = 10.0 ** rng.uniform(-6.0, 6.0, p)
    root, b = rng.normal(size=(p + 3, p)), rng.normal(size=p + 3)
    free = [i for i in range(p) if i != held]
    expected = np.zeros(p)
    if free:
        expected[free] = nnls(root[:, free], b)[0] / sizes[free]
    A, x = (root.T @ root) * np.outer(sizes, sizes), np.zeros(p)
    kernels.nonnegative(A, (root * sizes).T @ b, held, np.empty((p, p + 1)), x)
    assert x * sizes == pytest.approx(expected * sizes, rel=1e-6, abs=1e-9)


def test_fisher_scoring_finds_the_least_cost() -> None:
    rng = np.random.default_rng(4)
    D, w = rng.uniform(0.1, 1.0, (9, 3)), rng.uniform(1.0, 50.0, 9)
    s = D @ [1.0, 0.0, 2.0] * rng.gamma(w) / w
    v = np.zeros(3)
    cost = kernels.scored(D, np.array([s, w]), -1, 0.0, v, False)

    def other(u: Array) -> float:
        mu = D @ u
        return float(np.sum(w * (np.log(mu) + s / mu)))

    best = minimize(other, np.ones(3), bounds=[(0.0, None)] * 3, tol=1e-12)
    assert cost == pytest.approx(best.fun, abs=1e-4)
    assert v == pytest.approx(best.x, abs=0.02)
    plain = np.zeros(3)
    assert unwrap(kernels.scored)(D, np.array([s, w]), -1, 0.0, plain, False) == pytest.approx(cost)


@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_the_search_is_the_same_to_the_bit_before_it_is_compiled(seed: int, p: int) -> None:
    rng = np.random.default_rng(seed)
    k, table = 12, np.exp(0.1 * rng.normal(size=(60, 12)).cumsum(axis=0))
    D, w = np.exp(rng.normal(size=(k, p))), rng.uniform(1.0, 100.0, k)
    s = D @ np.exp(rng.normal(size=p)) * np.exp(0.3 * rng.normal(size=k))
    found = []
    data, every, spacings = np.array([s, w]), np.ones(p, bool), np.array([5.0, 1.67, 0.3])
    for search in (kernels.fit_of, unwrap(kernels.fit_of)):
        v = np.zeros(p)
        found.append((*search(D[:, : p - 1].copy(), table, data, every, -1, 0.0, 0.0, 59.0, spacings, v), *v))
    assert found[0] == found[1]


def test_what_cubes_of_long_lags_leave_is_that_of_whole_numbers() -> None:
    m1, m2 = np.array([2.0**9, 2.0**18]), np.array([2.0**18, 2.0**18])
    lags = _lags(m1.tobytes(), m2.tobytes(), (m1 + m2).tobytes())
    whole = lags.distance == np.floor(lags.distance)
    exact = [
        sum(int(factor) * abs(t + b * two - a * one) ** 3 for a, b, factor in LAGS)
        for t, one, two in zip(*(x[whole].astype(int).tolist() for x in (lags.distance, lags.m1, lags.m2)), strict=True)
    ]
    rounding = 100.0 * float(np.finfo(np.longdouble).eps) * 2.0**57  # of the largest cube
    assert np.all(np.abs(lags.cubic[whole] - exact) <= rounding + 1e-15 * np.abs(exact))
