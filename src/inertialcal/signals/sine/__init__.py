"""A known drive in drift and coloured noise: its amplitude, with an uncertainty that is true.

``sine_drive`` and ``applied_drive`` say what drives; ``design_of`` what is fitted; ``fit_line`` finds the
amplitudes in phase and in quadrature, signed, with the noise; ``amplitude_of`` that of a line whose
phase is not known; ``cross_checks`` other estimates beside. Missing samples are left out of drive and readings: times
are given, and nothing has to be evenly spaced. The frequency is one over the true period, pauses between samples
included.
"""
