"""Spectrum of a sampled signal: one-sided density with intervals, lines told from noise, check against Allan variance.

Conventions. The density is one-sided [unit^2/Hz]: its sum over the frequencies times their spacing is the variance. It
is that of the samples as they are: of means over an averaging time, aliased, whatever lies between them. Frequencies
run from above zero to below half of the sampling frequency; the lowest ones, which removing the mean of a segment
falsifies, are left out.

``psd`` gives the Spectrum, ``find_lines`` what in it is no noise, ``allan_of_spectrum`` the Allan variance that it
means and ``compare_allan`` whether a measured one agrees. ``correlation_spectrum`` and ``fourier_coefficients`` are
what older reports are made with: spectrum from correlations, and lines of a complete record.
"""

from .allan_check import Agreement, AllanCurve, SpectralAllan, allan_of_spectrum, compare_allan
from .blackman_tukey import CorrelationSpectrum, correlation_spectrum, hanning_smoothed
from .density import Spectrum
from .fourier import FourierCoefficients, fourier_coefficients
from .lines import Line, Lines, find_lines
from .psd import psd

__all__ = [
    "Agreement",
    "AllanCurve",
    "CorrelationSpectrum",
    "FourierCoefficients",
    "Line",
    "Lines",
    "SpectralAllan",
    "Spectrum",
    "allan_of_spectrum",
    "compare_allan",
    "correlation_spectrum",
    "find_lines",
    "fourier_coefficients",
    "hanning_smoothed",
    "psd",
]
