"""Dead time: samples that are averages over less than the time from sample to sample.

Deviations are those of the samples as they stand; tau is the averaging factor times the sample *interval*. What they
mean then depends on the noise: a sample of white noise averaged over T_a only has T / T_a times the variance of one
that fills its interval T. Read as contiguous, averages of 1 s saved every 2 s give sqrt(2) times the angle random
walk. So each term of ``sensors.noise`` takes both times; here stands the ratio of the variances, as a check.

With D(t) the variance that t of integrated noise has (|t| for white noise, |t|^3 for a random walk of the rate; up to
even powers, which differences take away), the autocovariance of the averages follows by differences over T_a, and the
Allan variance from that of the averages of m samples; a ratio of Allan variances is Barnes's bias function [1]_.

References
----------
.. [1] Barnes and Allan, Variances based on data with dead time between the measurements, NIST TN 1318, 1990.
"""

from __future__ import annotations

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.remarks import Remark

CONTIGUOUS = 1e-6  # relative difference of averaging time and interval that is none
REDDEST = -2


def variance_ratio(power: int, m: int, interval: float, averaging: float) -> float:
    """Return the expected Allan variance of averages with dead time over that of contiguous ones at the same tau.

    Parameters
    ----------
    power : {0, -1, -2}
        Exponent of the spectrum of the rate: white, flicker, random walk.
    m : int
        Samples a window.
    interval, averaging : float
        From sample to sample, and what each is the mean of [s].

    Raises
    ------
    DataError
        If the power has no finite ratio, or the averaging time is not positive or longer than the interval.
    """
    if power not in {0, -1, REDDEST}:
        raise DataError(f"exponent {power}", do="Need 0 (white), -1 (flicker) or -2 (random walk)")
    check_averaging(interval, averaging)
    return _allan_variance(power, m, averaging / interval) / _allan_variance(power, m, 1.0)


def _allan_variance(power: int, m: int, filled: float) -> float:
    """Allan variance of averages over ``filled`` of an interval of 1, but for a factor."""
    lags = np.arange(2.0 * m)
    covariance = -(
        _structure(lags + filled, power) - 2.0 * _structure(lags, power) + _structure(lags - filled, power)
    ) / (filled * filled)
    both = np.concatenate([covariance[:0:-1], covariance])  # of lags -(2m - 1) to 2m - 1
    window = np.concatenate([-np.ones(m), np.ones(m)]) / m
    weights = np.correlate(window, window, mode="full")
    return 0.5 * float(weights @ both)


def _structure(t: Array, power: int) -> Array:
    """Minus the generalised autocovariance of the integrated signal: |t|, -t^2 log|t|, -|t|^3 for 0, -1, -2."""
    t = np.abs(t)
    if power == 0:
        return -t
    if power == REDDEST:
        return t**3
    return t**2 * np.log(np.where(t > 0.0, t, 1.0))


def check_averaging(interval: float, averaging: float | None) -> None:
    """Refuse an averaging time that is not positive, or longer than the sample interval.

    Raises
    ------
    DataError
        With both times.
    """
    if averaging is not None and not 0.0 < averaging <= interval * (1.0 + CONTIGUOUS):
        raise DataError(
            f"an averaging time of {averaging:g} s at a sample interval of {interval:g} s",
            why="averages that overlap share their noise, and 0 s average nothing",
            do="Give what each sample is the mean of, at most the sample interval",
            code="wrong_averaging",
        )


def dead_time_remark(interval: float, averaging: float | None) -> tuple[Remark, ...]:
    """Return the remark on dead time; nothing where there is none, or nobody said."""
    if averaging is None or averaging >= interval * (1.0 - CONTIGUOUS):
        return ()
    factor = np.sqrt(interval / averaging)
    what = (
        f"each sample is the mean of {averaging:g} s every {interval:g} s: "
        f"white noise shows {factor:.3g} times the deviation of contiguous averages"
    )
    do = "Do not read a random walk off the curve; the fit of terms takes the dead time into account"
    return (Remark("dead_time", "info", what, do=do),)
