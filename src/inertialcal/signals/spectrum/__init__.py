"""Spectrum of a sampled signal: one-sided density with intervals, lines told from noise, check against Allan variance.

Conventions. The density is one-sided [unit^2/Hz]: its sum over the frequencies times their spacing is the variance. It
is that of the samples as they are: of means over an averaging time, aliased, whatever lies between them. Frequencies
run from above zero to below half of the sampling frequency; the lowest ones, which removing the mean of a segment
falsifies, are left out.

``psd`` gives the Spectrum, ``find_lines`` what in it is no noise, ``allan_of_spectrum`` the Allan variance that it
means and ``compare_allan`` whether a measured one agrees. ``correlation_spectrum`` and ``fourier_coefficients`` are
what older reports are made with: spectrum from correlations, and lines of a complete record.
"""
