"""A known drive in drift and coloured noise: its amplitude, with an uncertainty that is true.

``sine_drive`` and ``applied_drive`` say what drives; ``design_of`` chooses drift and side bands; ``fit_line`` finds the
amplitudes in phase and in quadrature, signed, with the noise beside the line; ``amplitude_of`` that of a line whose
phase is not known; ``cross_checks`` other estimates beside. Missing samples are left out of drive and readings: times
are given, and nothing has to be evenly spaced. The frequency is one over the true period, pauses between samples
included.
"""

from .amplitude import Amplitude, amplitude_of
from .cross_checks import CrossCheck, cross_checks
from .design import Design, Drift, design_of
from .differences import difference_weights
from .drive import Drive, applied_drive, averaging_response, sine_drive
from .fit import LineFit, fit_line
from .generalised import Generalised, generalised_fit

__all__ = [
    "Amplitude",
    "CrossCheck",
    "Design",
    "Drift",
    "Drive",
    "Generalised",
    "LineFit",
    "amplitude_of",
    "applied_drive",
    "averaging_response",
    "cross_checks",
    "design_of",
    "difference_weights",
    "fit_line",
    "generalised_fit",
    "sine_drive",
]
