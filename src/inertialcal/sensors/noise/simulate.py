"""Samples of noise terms, drawn with their exact covariance at every lag.

It stands with the terms, above the rigs, because both the planner and the proof of the fit draw from it; rigs build
their recordings from it. Every sample is a mean over ``averaging`` seconds, taken every ``interval``. Random walk,
Gauss-Markov and flicker are drawn as means, not as values at the stamps, so that the result does not depend on a
smaller step. A random walk starts at zero, flicker has the mean 0 over the record, a ramp is 0 in the middle of the
first window: none of them has a level of its own.

Flicker is drawn through its steps from sample to sample, which are stationary with negative covariances beyond lag 0:
a circle of twice the length holds them without error [1]_.

References
----------
.. [1] P. F. Craigmile, J. Time Series Analysis 24 (2003) 505.
.. [2] D. T. Gillespie, Phys. Rev. E 54 (1996) 2084: exact updating of the Ornstein-Uhlenbeck process and its integral.
"""

from __future__ import annotations

from functools import singledispatch

import numpy as np
from scipy import fft

from ...core.errors import DataError
from ...core.estimate import Array
from .terms import (
    BiasInstability,
    GaussMarkov,
    Quantization,
    RandomWalk,
    RateRamp,
    RateRandomWalk,
    Sinusoid,
    Term,
    averaged_over,
    flicker_covariance,
)


def simulate(
    terms: Term | tuple[Term, ...],
    n: int,
    interval: float,
    rng: np.random.Generator,
    averaging: float | None = None,
) -> Array:
    """Return samples of the terms' sum, shape (n,) [unit].

    Parameters
    ----------
    terms : Term, or tuple of Term
        Independent of each other.
    n : int
        Samples.
    interval, averaging : float
        Time from sample to sample, and that of one mean [s]; without dead time where ``averaging`` is absent.
    rng : numpy.random.Generator
        All draws come from it, term by term in order.

    Raises
    ------
    DataError
        If there are fewer than two samples, or the averaging time is not positive or longer than the interval.
    """
    averaging = averaged_over(interval, averaging)
    if n < 2:
        raise DataError(f"{n} sample(s), need 2 or more", code="too_short")
    total = np.zeros(n)
    for term in terms if isinstance(terms, tuple) else (terms,):
        total += samples(term, n, interval, averaging, rng)
    return total


@singledispatch
def samples(term: Term, n: int, interval: float, averaging: float, rng: np.random.Generator) -> Array:
    """Return samples of one term, shape (n,) [unit]."""
    raise TypeError(f"no simulation of {type(term).__name__}")


@samples.register
def _(term: Quantization, n: int, interval: float, averaging: float, rng: np.random.Generator) -> Array:
    if averaging == interval:
        return np.diff(rng.normal(0.0, term.coefficient / averaging, n + 1))
    return rng.normal(0.0, np.sqrt(2.0) * term.coefficient / averaging, n)


@samples.register
def _(term: RandomWalk, n: int, interval: float, averaging: float, rng: np.random.Generator) -> Array:
    return rng.normal(0.0, term.coefficient / np.sqrt(averaging), n)


@samples.register
def _(term: RateRandomWalk, n: int, interval: float, averaging: float, rng: np.random.Generator) -> Array:
    inside = rng.normal(0.0, term.coefficient * np.sqrt(averaging), n)
    between = rng.normal(0.0, term.coefficient * np.sqrt(interval - averaging), n)
    bridge = rng.normal(0.0, term.coefficient * np.sqrt(averaging / 12.0), n)
    return np.asarray(np.cumsum(inside + between) - between - 0.5 * inside + bridge)


@samples.register
def _(term: RateRamp, n: int, interval: float, averaging: float, rng: np.random.Generator) -> Array:
    return np.asarray(term.coefficient * interval * np.arange(n))


@samples.register
def _(term: GaussMarkov, n: int, interval: float, averaging: float, rng: np.random.Generator) -> Array:
    from scipy import signal  # noqa: PLC0415 - starts slowly, and estimating needs none of it

    v, gap = averaging / term.correlation_time, (interval - averaging) / term.correlation_time
    end_variance = -np.expm1(-2.0 * v)  # of the end of a window, given its start; sigma = 1
    mean_share = -np.expm1(-v) / v  # of the start, in the mean over the window
    together = np.expm1(-v) ** 2 / v
    mean_variance = _mean_variance(v)
    draws = rng.standard_normal((2, n))
    end = np.sqrt(end_variance) * draws[0]
    mean = together / end_variance * end + np.sqrt(mean_variance - together**2 / end_variance) * draws[1]
    driven = np.exp(-gap) * end + rng.normal(0.0, np.sqrt(-np.expm1(-2.0 * gap)), n)
    first = rng.standard_normal()
    start = signal.lfilter([1.0], [1.0, -np.exp(-v - gap)], np.concatenate([[first], driven[:-1]]))
    return np.asarray(term.sigma * (mean_share * start + mean))


@samples.register
def _(term: Sinusoid, n: int, interval: float, averaging: float, rng: np.random.Generator) -> Array:
    sampled = term.amplitude * np.sinc(term.frequency * averaging)
    turns = term.frequency * interval * np.arange(n) + rng.uniform()
    return np.asarray(sampled * np.sin(2.0 * np.pi * turns))


@samples.register
def _(term: BiasInstability, n: int, interval: float, averaging: float, rng: np.random.Generator) -> Array:
    size = 2 * int(fft.next_fast_len(n - 1, real=True))
    half = size // 2
    lags = np.minimum(np.arange(size), size - np.arange(size)).astype(float)
    power = np.maximum(fft.rfft(step_covariance(lags, averaging / interval)).real, 0.0)
    draws = rng.standard_normal((half + 1, 2)).view(np.complex128)[:, 0] * np.sqrt(0.5 * size * power)
    draws[[0, -1]] = np.sqrt(2.0) * draws[[0, -1]].real
    steps = fft.irfft(draws, size)[: n - 1]
    found = np.concatenate([[0.0], np.cumsum(steps)])
    return np.asarray(term.coefficient / np.sqrt(np.pi) * (found - found.mean()))


def step_covariance(lags: Array, duty: float) -> Array:
    """Return the covariance of steps from sample to sample of 1/f noise of h = 1, at lags j >= 0."""
    near = np.minimum(lags, 1000.0)
    around = [flicker_covariance(np.abs(near + by), duty) for by in (-1.0, 0.0, 1.0)]
    far = np.maximum(lags, 1000.0)
    return np.asarray(np.where(lags <= 1000.0, 2.0 * around[1] - around[0] - around[2], -1.0 / far**2 - 0.5 / far**4))


def _mean_variance(v: float) -> float:
    """Variance of the mean over a window, given its start, sigma = 1."""
    if v < 0.01:  # 2 v / 3 and what follows, where differences have no digits
        return v * (2.0 / 3.0 - v / 2.0 + 7.0 * v**2 / 30.0 - v**3 / 12.0)
    return float(2.0 * (v + np.expm1(-v)) / v**2 - (np.expm1(-v) / v) ** 2)
