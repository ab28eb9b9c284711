"""The analysis programme of the 1969 report, step by step as its listing has it: for comparison, not for use.

Two series of up to 100 samples, one of the accelerometer and one of the tilt meter; four reductions; correlations,
spectrum and Fourier coefficients; scale factor. Rules that are wrong or odd are kept, and named at each function: wrong
positions are closed up (which shifts the phase of all that follows), the highest line has twice its weight, the moving
mean shrinks towards the ends of the record and takes 1.3 % of the signal with it, standard deviations divide by N,
negative densities are hidden by their absolute value, and the error of the scale factor is the standard deviation of
the data over the input amplitude, not that of the amplitude. `reductions` and ``signals.sine`` do it right.

Reductions 1, 2 and 4 start from the data each time and so replace each other; reduction 3 acts on the current series,
with the coefficients of the last analysis. Each takes series with their mean removed, shape (N,) or (N, k), N even (the
report has 100), and leaves some mean, which the analysis removes. Where the text at hand misreads the listing, a step
does what the report says of it. Samples count from 1 in the report and from 0 here; time index 0 is the first sample
in both (the listing uses I - 1, appendix A prints I).

References
----------
.. [1] K. Reinel, Accelerometer Calibration in the Low g Range by Means of Mass Attraction, NASA TM X-53857, 1969,
   appendices A and B.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ..correlation import autocorrelation, cross_correlation
from ..spectrum.blackman_tukey import correlation_spectrum, hanning_smoothed
from ..spectrum.fourier import fourier_coefficients
from . import cards
from .cards import Case, Request, closed_up_series

NG = 1e-9  # [g]
ANCHOR = 9  # samples of each mean of the straight line


@dataclass(frozen=True, eq=False)
class Analysis:
    """What one request for an analysis prints."""

    # x, y: series analysed, their means removed, shape (N,)
    x: Array
    y: Array
    removed: float  # mean that the last step had left in ``x``
    # std_x, std_y: roots of the mean squares
    std_x: float
    std_y: float
    # correlation_x, correlation_y, cross: unbiased, at lags 0 to MAXL, shape (MAXL + 1,)
    correlation_x: Array
    correlation_y: Array
    cross: Array
    # density, smoothed: of ``x``, lines 1 to M, per unit of the sample interval's frequency, shape (M,)
    density: Array
    smoothed: Array
    # amplitude, smoothed_amplitude: from the densities and the bandwidth, shape (M,)
    amplitude: Array
    smoothed_amplitude: Array
    # cosine, sine, line: A(K), B(K) and C(K), K = 1 ... N/2, shape (N/2,)
    cosine: Array
    sine: Array
    line: Array

    @property
    def normalised_x(self) -> Array:
        """Correlation over its value at lag 0, shape (MAXL + 1,)."""
        return np.asarray(self.correlation_x / self.correlation_x[0])

    @property
    def normalised_y(self) -> Array:
        """Correlation over its value at lag 0, shape (MAXL + 1,)."""
        return np.asarray(self.correlation_y / self.correlation_y[0])

    @property
    def normalised_cross(self) -> Array:
        """Cross-correlation over the root of the product of both at lag 0, shape (MAXL + 1,)."""
        return np.asarray(self.cross / np.sqrt(self.correlation_x[0] * self.correlation_y[0]))


@dataclass(frozen=True)
class ScaleFactor:
    """What is printed of the scale factor [unit of the series per g]."""

    fourier: float  # from B(K) of the input line
    spectrum: float  # from the amplitude of the spectrum at line M/2
    std: float  # standard deviation of the series from the sine of that amplitude (divided by N) [unit of the series]
    error: float  # that over the input amplitude


def analyse(x: Array, y: Array, interval: float, lags: int, lines: int) -> Analysis:
    """Analyse the current series.

    Parameters
    ----------
    x, y : ndarray, shape (N,)
        Accelerometer, as the last step left it, and tilt meter; N even.
    interval : float
        Sample time NH [s], pauses left out as in the report.
    lags : int
        MAXL.
    lines : int
        MAXK, the largest lag of the spectrum: not above MAXL.

    Raises
    ------
    DataError
        If the series differ in length, N is odd, or there are more lines than lags.
    """
    x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if x.shape != y.shape or x.ndim != 1 or len(x) % 2:
        raise DataError(f"series of shapes {x.shape} and {y.shape}", do="Both need the same even length")
    if not 2 <= lines <= lags:
        raise DataError(f"{lines} lines of {lags} lags", do="Need 2 or more lines and at least as many lags")
    removed = float(x.mean())
    x, y = x - removed, y - y.mean()
    of_x, of_y = (autocorrelation(one, lags, centred=False).values for one in (x, y))
    raw = correlation_spectrum(of_x[: lines + 1], interval)
    smooth = hanning_smoothed(raw)
    cosine, sine = harmonics(x)
    return Analysis(
        x, y, removed, float(np.sqrt(of_x[0])), float(np.sqrt(of_y[0])), of_x, of_y,
        cross_correlation(x, y, lags, centred=False).values, raw.density[1:], smooth.density[1:], raw.amplitude[1:],
        smooth.amplitude[1:], cosine, sine, np.hypot(cosine, sine),
    )  # fmt: skip


def harmonics(x: Array) -> tuple[Array, Array]:
    """Return A(K) and B(K), K = 1 ... N/2, with the factor 2/N throughout: the last is twice its amplitude.

    Parameters
    ----------
    x : ndarray, shape (N,) or (N, k)
        N even.
    """
    found = fourier_coefficients(x)
    cosine, sine = found.cosine[1:].copy(), found.sine[1:].copy()
    cosine[-1] *= 2.0
    sine[-1] *= 2.0
    return cosine, sine


def scale_factor(found: Analysis, input_amplitude_ng: float, samples_per_cycle: int = 4) -> ScaleFactor:
    """Return the scale factor of an analysis.

    Parameters
    ----------
    found : Analysis
        Of a series whose input is ``sin(2 pi i / samples_per_cycle)``, i = 0 ... N - 1.
    input_amplitude_ng : float
        NA [ng].
    samples_per_cycle : int
        KO; this part of the programme is fixed to 4.

    Raises
    ------
    DataError
        If the amplitude is not above zero, the record is not of whole cycles, or no line of the spectrum is the
        input's (``whole_cycles``).
    """
    n, M = len(found.x), len(found.density)
    if not input_amplitude_ng > 0.0:
        raise DataError(f"an input amplitude of {input_amplitude_ng} ng", do="It must be above zero")
    if n % samples_per_cycle or (2 * M) % samples_per_cycle:
        what = f"{n} samples and {M} lines, {samples_per_cycle} samples a cycle"
        do = "Take whole cycles and an even number of lines, or fit the line: signals.sine"
        raise DataError(what, why="the input falls between two lines", do=do, code="whole_cycles")
    applied = input_amplitude_ng * NG
    amplitude = float(found.amplitude[2 * M // samples_per_cycle - 1])
    at = np.arange(n) % samples_per_cycle
    model = amplitude * np.sin(2.0 * np.pi / samples_per_cycle * at)
    std = float(np.sqrt(np.mean((found.x - model) ** 2)))
    sine = float(found.sine[n // samples_per_cycle - 1])
    return ScaleFactor(sine / applied, amplitude / applied, std, std / applied)


@dataclass(frozen=True, eq=False)
class Step:
    """A request, and the analysis that followed it."""

    request: Request
    analysis: Analysis
    removed: Array  # what it took from the readings, their mean included: of the adjusted curve the centred mean, (N,)


def run_case(case: Case) -> tuple[Step, ...]:
    """Return the analysis after each request.

    Raises
    ------
    DataError
        As the steps.
    """
    x, tilt = closed_up_series(case)
    data = x - x.mean()
    current, steps = data, []
    for request in case.requests:
        match request.what:
            case cards.TILT:
                current = tilt_trace(data, tilt)
            case cards.LINE:
                current = straight_line(data)
            case cards.HARMONICS:
                current = without_harmonics(current, request.number)
            case cards.CURVE:
                current = adjusted_curve(data, request.number)
        found = analyse(current, tilt, float(case.NH), case.MAXL, case.MAXK)
        current = found.x
        steps.append(Step(request, found, x - found.x))
    return tuple(steps)


def tilt_trace(x: Array, tilt: Array) -> Array:
    """Return the series, its mean removed, less its regression on the tilt trace (reduction 1).

    The listing uses the readings of the tilt meter, whose mean it does not remove (appendix A has a series without a
    mean).

    Raises
    ------
    DataError
        If all readings of the tilt meter are zero.
    """
    square = float(tilt @ tilt)
    if not square > 0.0:
        raise DataError("the tilt meter reads zero throughout", do="Leave reduction 1 out", code="no_scatter")
    return np.asarray(x - float(x @ tilt) / square * tilt)


def straight_line(x: Array) -> Array:
    """Return the series less a straight line through the means of its first and last nine samples (reduction 2).

    Raises
    ------
    DataError
        If the series is shorter than two such means.
    """
    n = len(x)
    if n < 2 * ANCHOR:
        raise DataError(f"{n} samples", why=f"the line runs through two means of {ANCHOR}", code="too_short")
    first, last = x[:ANCHOR].mean(axis=0), x[-ANCHOR:].mean(axis=0)
    along = (np.arange(n) - ANCHOR // 2) / (n - ANCHOR)
    return np.asarray(x - first - (along * (last - first) if x.ndim == 1 else np.outer(along, last - first)))


def without_harmonics(x: Array, lines: int) -> Array:
    """Return the series less its lines 1 ... MA and N/2 - MA ... N/2: one more above than below (reduction 3).

    As the last line has twice its amplitude, taking it away turns its sign.

    Raises
    ------
    DataError
        If there are not so many lines: 0 to N/2 - 1.
    """
    n = len(x)
    if n % 2 or not 0 <= lines < n // 2:
        raise DataError(f"{lines} lines of {n} samples", do=f"Need an even number of samples, 0 to {n // 2 - 1} lines")
    cosine, sine = harmonics(x)
    K = np.r_[1 : lines + 1, n // 2 - lines : n // 2 + 1]  # bands that meet are taken away twice
    angle = 2.0 * np.pi / n * (np.outer(np.arange(n), K) % n)
    return np.asarray(x - np.cos(angle) @ cosine[K - 1] - np.sin(angle) @ sine[K - 1])


def adjusted_curve(x: Array, half_width: int) -> Array:
    """Return the series less a centred moving mean that shrinks towards both ends (reduction 4).

    Inside the window has 2 JA + 1 full points and a half point at each end. Near an end it is the widest one that fits;
    the first and last two points have rules of their own, which are not mirror images: thirds at the second point,
    a quarter, a half and a quarter at the last but one. For the half points near both ends the listing prints indices
    that are not those of a centred window; here they are (the outermost sample, and its mirror image).

    Parameters
    ----------
    x : ndarray, shape (N,) or (N, k)
        Its mean removed.
    half_width : int
        JA; 2 (JA + 1) should be a multiple of the samples per cycle, or the input is taken away too.

    Raises
    ------
    DataError
        If the window does not fit twice.
    """
    n = len(x)
    JA = half_width
    if not JA >= 1 or n - 2 < 2 * (JA + 2):
        raise DataError(f"half width {JA} of {n} samples", do="Need 1 or more, and half the record for the window")
    weights = np.zeros((n, n))
    for i in range(n):
        reach = min(i, n - 1 - i, JA + 1)
        weights[i, i - reach : i + reach + 1] = 1.0 / max(2 * reach, 1)
        weights[i, [i - reach, i + reach]] *= 0.5
    weights[0, :2] = weights[-1, -2:] = 0.5
    weights[1, :3] = 1.0 / 3.0
    return np.asarray(x - weights @ x)
