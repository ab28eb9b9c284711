"""Random vibration: profiles of spectral density, spectra of several channels, levels over time, what breaks a run.

A profile is straight lines on logarithmic axes. Spectra are one-sided densities; decibels are ``10 lg`` of a ratio of
densities or of mean squares. Every figure is of stationary Gaussian noise unless its text says otherwise.
"""
