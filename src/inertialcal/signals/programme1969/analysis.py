"""Analysis of the 1969 programme: correlations, spectrum raw and smoothed, Fourier coefficients, scale factor.

Kept as the listing has it: standard deviations divide by N; Fourier coefficients of lines 1 ... N/2 all have the factor
2/N, that at the Nyquist frequency too (twice its amplitude); negative densities are hidden by their absolute value;
the error of the scale factor is the standard deviation of the data over the input amplitude, not that of the amplitude.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ..correlation import autocorrelation, cross_correlation
from ..spectrum.blackman_tukey import correlation_spectrum, hanning_smoothed
from ..spectrum.fourier import fourier_coefficients

NG = 1e-9  # [g]


@dataclass(frozen=True, eq=False)
class Analysis:
    """What one request for an analysis prints.

    Parameters
    ----------
    x, y : ndarray, shape (N,)
        Series analysed, their means removed.
    removed : float
        Mean that the last step had left in ``x``.
    std_x, std_y : float
        Roots of the mean squares.
    correlation_x, correlation_y, cross : ndarray, shape (MAXL + 1,)
        Unbiased, at lags 0 to MAXL.
    density, smoothed : ndarray, shape (M,)
        Of ``x``, lines 1 to M, per unit of the sample interval's frequency.
    amplitude, smoothed_amplitude : ndarray, shape (M,)
        From the densities and the bandwidth.
    cosine, sine, line : ndarray, shape (N/2,)
        A(K), B(K) and C(K), K = 1 ... N/2.
    """

    x: Array
    y: Array
    removed: float
    std_x: float
    std_y: float
    correlation_x: Array
    correlation_y: Array
    cross: Array
    density: Array
    smoothed: Array
    amplitude: Array
    smoothed_amplitude: Array
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
    """What is printed of the scale factor [unit of the series per g].

    Parameters
    ----------
    fourier : float
        From B(K) of the input line.
    spectrum : float
        From the amplitude of the spectrum at line M/2.
    std : float
        Standard deviation of the series from the sine of that amplitude (divided by N) [unit of the series].
    error : float
        That over the input amplitude.
    """

    fourier: float
    spectrum: float
    std: float
    error: float


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
        raise DataError(f"series of shape {x.shape} and {y.shape}", do="Need two of one even length")
    if not 2 <= lines <= lags:
        raise DataError(f"{lines} lines of {lags} lags", do="Need two lines or more, and as many lags")
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
        raise DataError(what, why="the input lies between two lines", do=do, code="whole_cycles")
    applied = input_amplitude_ng * NG
    amplitude = float(found.amplitude[2 * M // samples_per_cycle - 1])
    at = np.arange(n) % samples_per_cycle
    model = amplitude * np.sin(2.0 * np.pi / samples_per_cycle * at)
    std = float(np.sqrt(np.mean((found.x - model) ** 2)))
    sine = float(found.sine[n // samples_per_cycle - 1])
    return ScaleFactor(sine / applied, amplitude / applied, std, std / applied)
