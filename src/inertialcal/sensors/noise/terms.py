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

Values are SI inside and in the units of data sheets at the edge. The unit of a coefficient follows from that of the
samples by unit algebra; where the samples have no known unit the same algebra holds, and nothing is converted.

References
----------
.. [1] IEEE Std 952-1997, Annex C: terms and their Allan variance.
.. [2] IEEE Std 1293-2018, Annex I: the same of accelerometers; Gauss-Markov and sinusoid.
.. [3] G. Matheron, Adv. Appl. Prob. 5 (1973) 439: generalised covariance of intrinsic random functions.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.errors import DataError
from ...core.estimate import Array, Estimate
from ...core.key import Key, Kind
from ...core.units import factor, multiply, power, si_unit
from ...signals.allan.gaps import check_averaging

SHORT = 15.0  # averaging over correlation time from which samples two apart are independent (exp(-15))
SERIES_FROM = 30  # lag from which the dead-time part of flicker is summed as a series
_FACTORIALS = tuple(float(special.factorial(order)) for order in range(14, 2, -1))
SMALL = 0.5  # argument below which a series has more digits than differences have
HALF = Fraction(1, 2)
POWERS_OF_TIME: dict[str, Fraction] = {
    "quantization": Fraction(1),
    "random_walk": HALF,
    "bias_instability": Fraction(0),
    "rate_random_walk": -HALF,
    "rate_ramp": Fraction(-1),
}
SHOWN: dict[str, dict[str, tuple[str, ...]]] = {
    "gyro": {
        "quantization": ("arcsec",),
        "random_walk": ("deg/sqrt(h)", "deg/s/sqrt(Hz)"),
        "bias_instability": ("deg/h",),
        "rate_random_walk": ("deg/h/sqrt(h)",),
        "rate_ramp": ("(deg/h)/h",),
        "sigma": ("deg/h",),
        "amplitude": ("deg/h",),
    },
    "accelerometer": {
        "quantization": ("m/s",),
        "random_walk": ("ug/sqrt(Hz)", "m/s/sqrt(h)"),
        "bias_instability": ("ug",),
        "rate_random_walk": ("ug/sqrt(s)",),
        "rate_ramp": ("ug/h",),
        "sigma": ("ug",),
        "amplitude": ("ug",),
    },
}


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
                do="Leave it out: samples do not show it",
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


def terms_of(noise: Estimate, kind: Kind, axis: str) -> tuple[Term, ...]:
    """Return the noise terms of an axis that an estimate holds whole, in SI."""
    held = {key: float(value) * factor(unit, si_unit(unit)) for key, value, unit in
            zip(noise.keys, noise.values, noise.units, strict=True)}  # fmt: skip
    found = []
    for name, term in TERMS.items():
        keys = [Key(quantity_name(name, parameter, kind), axis) for parameter in term.parameters]
        if all(key in held for key in keys):
            found.append(term(*(held[key] for key in keys)))
    return tuple(found)


@dataclass(frozen=True)
class Phase:
    """Covariance of the running sum of samples: one form for every term and every deviation.

    A sample is the mean of the noise over ``averaging`` seconds, taken every ``interval``. Most terms have no variance,
    but every contrast of the samples has one. It follows from a generalised covariance ``C`` of their running sum
    x_n = y_0 + ... + y_(n-1) [3]_: for weights w that sum to zero, and whose first moments do for rate noise that
    wanders, ``var(sum w_i x_i) = sum w_i w_j C(i - j)``. Even polynomials of C drop out and are left away, so that
    what remains has no more rounding than the answer. At a lag of j samples::

        C(j) = point [j = 0] - linear |j| / 2 + cubic |j|^3 / 12 + flicker (j^2 ln|j| / 2 - dead-time part)
               - sum of g E(j; u) + sum of cosines

    A ramp is no noise: it adds the constant ``ramp`` times m to each second difference of means over m samples.
    """

    point: float = 0.0  # Variance of independent errors of the running sum itself [unit^2], unit being that of a sample
    linear: float = 0.0  # Variance of a sample where samples are independent [unit^2]
    cubic: float = 0.0  # Variance of a step from sample to sample of a random walk [unit^2]
    # h of the one-sided spectrum h / f [unit^2]; with dead time its samples differ from those of neighbouring
    # means by a summable covariance, added exactly
    flicker: float = 0.0
    duty: float = 1.0  # Averaging time over interval; 1 without dead time
    # (g, u): covariance g exp(-u j) between samples [unit^2]; u is interval over correlation time
    exponentials: tuple[tuple[float, float], ...] = ()
    cosines: tuple[tuple[float, float], ...] = ()  # Variance of the sampled sinusoid [unit^2], and cycles a sample
    ramp: float = 0.0  # Change from sample to sample [unit]

    def __add__(self, other: Phase) -> Phase:
        """Sum of independent noises sampled alike."""
        return Phase(
            self.point + other.point,
            self.linear + other.linear,
            self.cubic + other.cubic,
            self.flicker + other.flicker,
            other.duty if other.flicker else self.duty,
            self.exponentials + other.exponentials,
            self.cosines + other.cosines,
            float(np.hypot(self.ramp, other.ramp)),
        )

    def covariance(self, lags: Array | NDArray[np.int64]) -> Array:
        """Return C at lags in samples, of their shape [unit^2]."""
        j = np.abs(np.asarray(lags, dtype=float))
        found = self.point * (j == 0.0) - 0.5 * self.linear * j + self.cubic * j**3 / 12.0
        if self.flicker:
            logs = np.log(np.where(j > 0.0, j, 1.0))
            found = found + self.flicker * (0.5 * j**2 * logs - dead_time_part(j, self.duty))
        for size, u in self.exponentials:
            found = found - size * twice_summed_exponential(j, u)
        for variance, cycles in self.cosines:
            found = found + variance * np.cos(2.0 * np.pi * cycles * j) / (2.0 * np.sin(np.pi * cycles)) ** 2
        return np.asarray(found)


def twice_summed_exponential(lags: Array, u: float) -> Array:
    """Return E, whose second difference is exp(-u |j|) but for a constant, at lags j >= 0.

    It is ``(exp(-u j) - 1) a + (1/2 + a (1 - exp(-u))) j - a u^2 j^2 / 2`` with a = 1 / (4 sinh^2(u / 2)), arranged so
    that nothing cancels for correlation times much longer than a record; the even last part has no effect.
    """
    gain, excess = exponential_gain(np.array(u))
    return np.asarray(gain * remainder(u * lags) + excess * lags)


def exponential_gain(u: Array) -> tuple[Array, Array]:
    """Return a of `twice_summed_exponential`, and the factor of |j| next to the remainder, of the shape of u."""
    half = 0.5 * np.minimum(u, 300.0)
    gain = 0.25 / np.sinh(half) ** 2
    return gain, np.asarray(0.5 * _one_less_squared_ratio(half) - gain * remainder(u))


def remainder(x: Array) -> Array:
    """Return exp(-x) - 1 + x - x^2 / 2, x >= 0."""
    near = np.minimum(x, SMALL)
    series = np.zeros_like(near)
    for factorial in _FACTORIALS:  # Horner, x^3 taken out
        series = 1.0 / factorial - near * series
    return np.asarray(np.where(x < SMALL, -(near**3) * series, np.expm1(-x) + x - 0.5 * x**2))


def _one_less_squared_ratio(x: Array) -> Array:
    """Return 1 - (x / sinh x)^2."""
    series = x**2 / 3.0 - x**4 / 15.0 + 2.0 * x**6 / 189.0
    return np.asarray(np.where(x < 0.05, series, 1.0 - (x / np.sinh(x)) ** 2))


def flicker_covariance(lags: Array, duty: float) -> Array:
    """Return the covariance of samples of 1/f noise of h = 1, up to a constant, at lags j >= 0."""

    def twice(t: Array) -> Array:
        size = np.abs(t)
        return np.asarray(0.5 * size**2 * np.log(np.where(size > 0.0, size, 1.0)))

    near = np.minimum(lags, SERIES_FROM)
    exact = 1.5 - (twice(near + duty) - 2.0 * twice(near) + twice(near - duty)) / duty**2
    far = np.maximum(lags, SERIES_FROM)
    series = -np.log(far) + duty**2 / (12.0 * far**2) + duty**4 / (60.0 * far**4) + duty**6 / (168.0 * far**6)
    return np.asarray(np.where(lags < SERIES_FROM, exact, series))


def dead_time_part(lags: Array, duty: float) -> Array:
    """Return the twice summed difference between the covariances of flicker with and without dead time, h = 1."""
    if duty == 1.0:
        return np.zeros_like(lags)
    head, first, second = _heads(duty)
    n = np.maximum(lags, 1.0)
    near = np.minimum(n, SERIES_FROM).astype(np.int64)
    sums, moments = first[near], second[near]
    far = np.maximum(n, SERIES_FROM)
    for order, size in ((2, duty**2 - 1.0), (4, (duty**4 - 1.0) / 5.0), (6, (duty**6 - 1.0) / 14.0)):
        sums = sums + size / 12.0 * (special.zeta(order, SERIES_FROM) - special.zeta(order, far))
        if order == 2:
            moments = moments + size / 12.0 * (special.digamma(far) - special.digamma(SERIES_FROM))
        else:
            moments = moments + size / 12.0 * (special.zeta(order - 1, SERIES_FROM) - special.zeta(order - 1, far))
    return np.asarray(np.where(lags > 0.0, lags * (0.5 * head + sums) - moments, 0.0))


@lru_cache(32)
def _heads(duty: float) -> tuple[float, Array, Array]:
    """Difference at lag 0; its sums, and those of lag times difference, over lags 1 to n - 1, up to SERIES_FROM."""
    lags = np.arange(SERIES_FROM, dtype=float)
    difference = flicker_covariance(lags, duty) - flicker_covariance(lags, 1.0)
    first, second = np.zeros(SERIES_FROM + 1), np.zeros(SERIES_FROM + 1)
    first[2:] = np.cumsum(difference[1:])
    second[2:] = np.cumsum((lags * difference)[1:])
    return float(difference[0]), first, second


def sample_unit(kind: Kind | None, file_unit: str = "") -> str:
    """Return the unit of samples inside: SI of the kind, else that of the file."""
    if kind is None:
        return file_unit
    return {"gyro": "rad/s", "accelerometer": "m/s^2"}[kind]


@lru_cache(256)
def parameter_unit(term: str, parameter: str, unit: str) -> str:
    """Return the unit of a parameter of noise whose samples have that unit."""
    if parameter in {"sigma", "amplitude"}:
        return unit
    if parameter == "correlation_time":
        return "s"
    if parameter == "frequency":
        return "Hz"
    exponent = POWERS_OF_TIME[term]
    return unit if exponent == 0 else multiply(unit, power("s", exponent))


def shown_units(term: str, parameter: str, kind: Kind | None) -> tuple[str, ...]:
    """Return the units of data sheets for a parameter, the usual one first; none where the kind is not known."""
    if kind is None:
        return ()
    return SHOWN[kind].get(term if parameter == "coefficient" else parameter, ())


def converted(value: float, unit: str, wanted: str) -> float:
    """Return a parameter in another unit: N of 1 deg/s/sqrt(Hz) is 60 deg/sqrt(h).

    Raises
    ------
    DataError
        With code ``unit_mismatch``, if the units measure different things.
    """
    return value * factor(unit, wanted)
