"""Records of noise terms from seeds, and their fits."""

from __future__ import annotations

import numpy as np

from inertialcal.core.estimate import Array
from inertialcal.sensors.noise.expected import expected_variance
from inertialcal.sensors.noise.fitting.allan_covariance import covariance_of_allan, model_edf
from inertialcal.sensors.noise.fitting.estimator import fit
from inertialcal.sensors.noise.fitting.noise_fit import NoiseFit
from inertialcal.sensors.noise.fitting.problem import Run
from inertialcal.sensors.noise.simulate import simulate
from inertialcal.sensors.noise.terms import GaussMarkov, RandomWalk, RateRandomWalk, Sinusoid, Term, total_phase
from inertialcal.signals.allan import Allan, allan

WALK = (RandomWalk(1.0), RateRandomWalk(1.0))  # 100 Hz: equal at 1.7 s
GMWM = (RandomWalk(0.1), GaussMarkov(np.sqrt(0.05), 1.0), RateRandomWalk(np.sqrt(7.5e-5)))  # 100 Hz, N = 1e5


def record(terms: tuple[Term, ...], n: int, interval: float, seed: int, averaging: float | None = None) -> Array:
    return simulate(terms, n, interval, np.random.default_rng([2026, seed]), averaging)


def curve(terms: tuple[Term, ...], n: int, interval: float, seed: int, averaging: float | None = None) -> Allan:
    return allan(record(terms, n, interval, seed, averaging), interval, quantity="rate", averaging=averaging)


def names(terms: tuple[Term, ...]) -> list[str]:
    return [term.name for term in terms if not isinstance(term, Sinusoid)]


def fitted(
    terms: tuple[Term, ...], n: int, interval: float, seed: int, averaging: float | None = None, auto: bool = False
) -> NoiseFit:
    """The fit of one record, to the terms that it has or to those that are chosen."""
    lines = [term.frequency for term in terms if isinstance(term, Sinusoid)]
    wanted = "auto" if auto else names(terms)
    return fit(curve(terms, n, interval, seed, averaging), "gyro", terms=wanted, lines=lines)


def values(found: NoiseFit) -> dict[str, float]:
    return {f"{term.name}.{name}": getattr(term, name) for term in found.terms for name in term.parameters}


def exact_run(terms: tuple[Term, ...], n: int, interval: float, averaging: float | None = None) -> Run:
    """The Allan variances that terms are expected to have."""
    m: Array = np.exp2(np.arange(np.floor(np.log2(n / 4)) + 1.0))
    phase, pairs = total_phase(terms, interval, averaging), n - 2.0 * m + 1.0
    variance = expected_variance(terms, m, interval, averaging)
    edf = model_edf(variance, covariance_of_allan(phase, m, pairs))
    return Run(m, variance, pairs, edf, interval, averaging or interval, np.ones(len(m)))
