"""Covariance of Allan variances across averaging times: exact sum, and simulated records."""

from __future__ import annotations

import numpy as np
import pytest

from inertialcal.core.estimate import Array
from inertialcal.sensors.noise import _kernels as kernels
from inertialcal.sensors.noise.allan_of_terms import expected_variance
from inertialcal.sensors.noise.covariance_of_allan import covariance_of_allan, model_edf
from inertialcal.sensors.noise.phase import Phase
from inertialcal.sensors.noise.simulate import simulate
from inertialcal.sensors.noise.terms import (
    BiasInstability,
    GaussMarkov,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Term,
    total_phase,
)
from inertialcal.signals.allan import allan

QUADRATURE = 0.02  # of a correlation or variance: trapezoids between distances
N = 2048
M = 2 ** np.arange(10)

MIXTURES: list[tuple[Term, ...]] = [
    (RandomWalk(1.0),),
    (Quantization(1.0),),
    (BiasInstability(1.0),),
    (RateRandomWalk(1.0),),
    (GaussMarkov(1.0, 30.0),),
    (RandomWalk(1.0), RateRamp(0.002)),
    (RandomWalk(1.0), GaussMarkov(0.3, 10.0), RateRandomWalk(0.01), BiasInstability(0.1), Quantization(0.3)),
]


def every_distance(phase: Phase, m: Array, n: Array) -> Array:
    """The same by the sum over all distances."""
    k, w = len(m), (1.0, -2.0, 1.0)
    out = np.zeros((k, k))
    for i in range(k):
        for j in range(k):
            lag = np.arange(-(n[i] - 1), n[j])
            s = sum(w[a] * w[b] * phase.covariance(lag + b * m[j] - a * m[i]) for a in range(3) for b in range(3)) / (
                m[i] * m[j]
            )
            pairs = np.minimum(n[i], n[j] - lag) - np.maximum(0, -lag)
            out[i, j] = np.sum(pairs * (s**2 / 2 + phase.ramp**2 * m[i] * m[j] * s)) / (n[i] * n[j])
    return out


@pytest.mark.parametrize("terms", MIXTURES, ids=lambda terms: "+".join(term.name for term in terms))
def test_is_the_sum_over_all_distances(terms: tuple[Term, ...]) -> None:
    phase, n = total_phase(terms, 1.0), N - 2 * M + 1
    exact = every_distance(phase, M, n)
    found = covariance_of_allan(phase, M, n)
    unit = np.sqrt(np.diag(exact))
    assert np.max(np.abs(found - exact) / np.outer(unit, unit)) < QUADRATURE


def test_is_that_of_simulated_records() -> None:
    terms = (RandomWalk(1.0), RateRandomWalk(0.03))
    rng = np.random.default_rng(3)
    curve = allan(np.column_stack([simulate(terms, 1024, 1.0, rng) for _ in range(2000)]), 1.0, quantity="rate")
    used = curve.m <= 256
    seen = np.cov(curve.deviation[used] ** 2)
    found = covariance_of_allan(total_phase(terms, 1.0), curve.m[used].astype(float), curve.n[used, 0].astype(float))
    unit = np.sqrt(np.diag(seen))
    assert np.diag(found) == pytest.approx(np.diag(seen), rel=0.2)
    assert np.max(np.abs(found - seen) / np.outer(unit, unit)) < 0.15


def test_white_noise_has_the_published_degrees_of_freedom() -> None:
    m = np.array([1.0])  # Greenhall and Riley: overlapping, m = 1: 18 M^2 / (35 M - 18) is N^2 / (..) ~ 2/3 N
    edf = model_edf(
        expected_variance(RandomWalk(1.0), m, 1.0),
        covariance_of_allan(total_phase((RandomWalk(1.0),), 1.0), m, N - 1.0 * m),
    )
    assert edf[0] == pytest.approx(2.0 / 3.0 * N, rel=2e-3)


def test_compiled_and_plain_loops_agree() -> None:
    phase = total_phase((RandomWalk(1.0), GaussMarkov(0.3, 10.0), BiasInstability(0.1)), 1.0)
    compiled = covariance_of_allan(phase, M[:3], N - 2 * M[:3] + 1)
    parts = np.array([phase.point, phase.linear, phase.cubic, phase.flicker])
    lag = 7.0
    plain = kernels.phase_covariance.py_func(lag, parts, np.zeros((0, 4)), np.zeros((0, 2)))
    smooth = Phase(phase.point, phase.linear, phase.cubic, phase.flicker)
    assert plain == pytest.approx(float(smooth.covariance(np.array([lag]))[0]), rel=1e-12)
    assert np.all(np.linalg.eigvalsh(compiled) > 0.0)
