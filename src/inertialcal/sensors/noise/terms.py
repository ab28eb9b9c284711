"""Terms of a sensor's noise, as the standards define them, and what each looks like when it is sampled.

The noise is that of a rate or an acceleration y [unit: rad/s, m/s^2, or that of the file]; a sample is its mean over
``averaging`` seconds, taken every ``interval`` (equal without dead time). Definitions, with tau = m interval and no
dead time [1]_, [2]_:

================== ======================== ===================================== ============================
term               parameters               Allan variance                        spectrum, one-sided
================== ======================== ===================================== ============================
quantization       coefficient Q [unit s]   3 Q^2 / tau^2                         8 Q^2 sin^2(pi f T) / T
random_walk        coefficient N            N^2 / tau                             2 N^2
                   [unit sqrt(s)]
bias_instability   coefficient B [unit]     (2 ln 2 / pi) B^2                     B^2 / (pi f)
rate_random_walk   coefficient K            K^2 tau / 3                           2 K^2 / (2 pi f)^2
                   [unit/sqrt(s)]
rate_ramp          coefficient R [unit/s]   R^2 tau^2 / 2                         (deterministic)
gauss_markov       sigma [unit],            closed form of the covariance         4 sigma^2 t_c /
                   correlation_time t_c [s] sigma^2 exp(-t / t_c)                 (1 + (2 pi f t_c)^2)
sinusoid           amplitude A [unit],      A^2 sin^4(pi f tau) / (pi f tau)^2    (a line)
                   frequency f [Hz]
================== ======================== ===================================== ============================

N is the square root of the *two-sided* density, so that white noise has the Allan variance N^2 / tau: "noise density"
of a data sheet that means rad/s/sqrt(Hz) in that sense. ``random_walk`` is the angle random walk of a gyro, the
velocity random walk of an accelerometer. Bias instability is flicker noise without upper or lower corner: the flat of
the Allan deviation lies at 0.664 B. Quantisation is that of the angle (velocity) whose differences the sensor gives;
with dead time both ends of a window are read apart, and a sample has the independent error sqrt(2) Q / averaging.
Rounding of a *rate* to codes is white, and no term of its own.

References
----------
.. [1] IEEE Std 952-1997, Annex C: terms and their Allan variance.
.. [2] IEEE Std 1293-2018, Annex I: the same of accelerometers; Gauss-Markov and sinusoid.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from ...core.axes import Kind
from ...core.errors import DataError
from ...core.estimate import Array
from ...signals.allan.dead_time import check_averaging
from .phase import Phase

SHORT = 15.0  # averaging over correlation time from which samples two apart are independent (exp(-15))


class NoiseTerm(Protocol):
    """A term: its word, the names of its parameters, and its sampled covariance."""

    name: ClassVar[str]
    parameters: ClassVar[tuple[str, ...]]

    def phase(self, interval: float, averaging: float) -> Phase:
        """Return the covariance of the running sum of its samples; both times in seconds."""


@dataclass(frozen=True)
class Quantization:
    """Rounding of the angle (velocity): coefficient Q [unit s], the standard deviation of a reading of it."""

    name: ClassVar[str] = "quantization"
    parameters: ClassVar[tuple[str, ...]] = ("coefficient",)
    coefficient: float

    def phase(self, interval: float, averaging: float) -> Phase:
        """Return point errors of the running sum; independent samples where there is dead time."""
        variance = (self.coefficient / averaging) ** 2
        return Phase(point=variance) if averaging == interval else Phase(linear=2.0 * variance)


@dataclass(frozen=True)
class RandomWalk:
    """White noise of the rate: angle (velocity) random walk N [unit sqrt(s)]."""

    name: ClassVar[str] = "random_walk"
    parameters: ClassVar[tuple[str, ...]] = ("coefficient",)
    coefficient: float

    def phase(self, interval: float, averaging: float) -> Phase:
        """Return independent samples of variance N^2 / averaging."""
        return Phase(linear=self.coefficient**2 / averaging)


@dataclass(frozen=True)
class BiasInstability:
    """Flicker noise of the rate: coefficient B [unit]."""

    name: ClassVar[str] = "bias_instability"
    parameters: ClassVar[tuple[str, ...]] = ("coefficient",)
    coefficient: float

    def phase(self, interval: float, averaging: float) -> Phase:
        """Return flicker of h = B^2 / pi."""
        return Phase(flicker=self.coefficient**2 / np.pi, duty=averaging / interval)


@dataclass(frozen=True)
class RateRandomWalk:
    """Random walk of the rate: coefficient K [unit/sqrt(s)]."""

    name: ClassVar[str] = "rate_random_walk"
    parameters: ClassVar[tuple[str, ...]] = ("coefficient",)
    coefficient: float

    def phase(self, interval: float, averaging: float) -> Phase:
        """Return steps of variance K^2 interval; a mean over a window varies by K^2 averaging / 6 less than a value.

        The generalised covariance of means is that of values, -K^2 interval |j| / 2, at all lags but 0, where it is
        -K^2 averaging / 6; the term |j| takes both the latter and what the sum of values has above |j|^3.
        """
        step = self.coefficient**2 * interval
        return Phase(cubic=step, linear=(step - self.coefficient**2 * averaging) / 6.0)


@dataclass(frozen=True)
class RateRamp:
    """Constant change of the rate: coefficient R [unit/s]."""

    name: ClassVar[str] = "rate_ramp"
    parameters: ClassVar[tuple[str, ...]] = ("coefficient",)
    coefficient: float

    def phase(self, interval: float, averaging: float) -> Phase:
        """Return the change from sample to sample."""
        return Phase(ramp=self.coefficient * interval)


@dataclass(frozen=True)
class GaussMarkov:
    """Exponentially correlated noise: standard deviation sigma [unit], correlation_time t_c [s]."""

    name: ClassVar[str] = "gauss_markov"
    parameters: ClassVar[tuple[str, ...]] = ("sigma", "correlation_time")
    sigma: float
    correlation_time: float

    def phase(self, interval: float, averaging: float) -> Phase:
        """Return an exponential, and what a single mean varies more or less than it."""
        variance, u = self.sigma**2, interval / self.correlation_time
        parts = means_of_exponential(np.array(averaging / self.correlation_time), np.array(u))
        point, linear, size = (variance * float(part) for part in parts)
        return Phase(point=point, linear=linear, exponentials=((size, u),) if size > 0.0 else ())


@dataclass(frozen=True)
class Sinusoid:
    """Sinusoid of random phase: amplitude A [unit], frequency f [Hz]."""

    name: ClassVar[str] = "sinusoid"
    parameters: ClassVar[tuple[str, ...]] = ("amplitude", "frequency")
    amplitude: float
    frequency: float

    def phase(self, interval: float, averaging: float) -> Phase:
        """Return a cosine, smaller by what the averaging takes.

        Raises
        ------
        DataError
            If the frequency is a multiple of the sample rate: the samples would be constant.
        """
        cycles = self.frequency * interval
        if np.isclose(cycles, np.round(cycles), rtol=0.0, atol=1e-9):
            raise DataError(
                f"a sinusoid of {self.frequency:g} Hz sampled every {interval:g} s is constant",
                do="Leave it out: nothing of it is seen",
                code="line_not_sampled",
            )
        variance = 0.5 * (self.amplitude * np.sinc(self.frequency * averaging)) ** 2
        return Phase(cosines=((float(variance), float(cycles)),))


LinearTerm = Quantization | RandomWalk | BiasInstability | RateRandomWalk | RateRamp
Term = LinearTerm | GaussMarkov | Sinusoid
TERMS: dict[str, type[Term]] = {
    term.name: term
    for term in (Quantization, RandomWalk, BiasInstability, RateRandomWalk, RateRamp, GaussMarkov, Sinusoid)
}


def means_of_exponential(v: Array, u: Array) -> tuple[Array, Array, Array]:
    """Return point, linear and exponential part of the phase of Gauss-Markov noise of sigma 1, of the shape of v.

    The covariance of two means is that of values in their middles times 2 (cosh v - 1) / v^2; a mean itself varies by
    2 (v - 1 + exp(-v)) / v^2, which is 2 (v - sinh v) / v^2 more. Where the correlation time is far below the averaging
    time, only neighbouring samples are correlated.

    Parameters
    ----------
    v, u : ndarray
        Averaging time and interval, over the correlation time.
    """
    brief = v > SHORT
    neighbours = np.where(brief, np.exp(v - u) / v**2, 0.0)
    long = np.where(brief, 1.0, v)
    size = (np.sinh(0.5 * long) / (0.5 * long)) ** 2
    series = -long / 3.0 * (1.0 + long**2 / 20.0 * (1.0 + long**2 / 42.0))
    more = np.where(long < 0.1, series, 2.0 * (long - np.sinh(long)) / long**2)
    linear = np.where(brief, 2.0 * (v - 1.0) / v**2 + 2.0 * neighbours, more)
    return -neighbours, linear, np.where(brief, 0.0, size)


def total_phase(terms: tuple[Term, ...], interval: float, averaging: float | None = None) -> Phase:
    """Return the covariance of the running sum of all terms' samples together.

    Parameters
    ----------
    terms : tuple of Term
        Independent of each other.
    interval, averaging : float
        Time from sample to sample, and that of one mean [s]; without dead time where ``averaging`` is absent.

    Raises
    ------
    DataError
        If the averaging time is not positive, or longer than the interval.
    """
    averaging = averaged_over(interval, averaging)
    total = Phase()
    for term in terms:
        total = total + term.phase(interval, averaging)
    return total


def averaged_over(interval: float, averaging: float | None) -> float:
    """Return the averaging time of a sample [s]: the interval where it is absent, or differs by less than clocks do.

    Parameters
    ----------
    interval, averaging : float
        Time from sample to sample, and that of one mean [s].

    Raises
    ------
    DataError
        As `total_phase`.
    """
    averaging = interval if averaging is None else averaging
    check_averaging(interval, averaging)
    return min(averaging, interval)


def quantity_name(term: str, parameter: str, kind: Kind | None) -> str:
    """Return the field's word of a parameter: ``"angle_random_walk"`` of a gyro, ``"gauss_markov_sigma"``."""
    if parameter != "coefficient":
        return f"{term}_{parameter}"
    if term == "random_walk":
        return {"gyro": "angle_random_walk", "accelerometer": "velocity_random_walk", None: term}[kind]
    if term == "rate_random_walk" and kind == "accelerometer":
        return "acceleration_random_walk"
    if term == "rate_ramp" and kind == "accelerometer":
        return "acceleration_ramp"
    return term
