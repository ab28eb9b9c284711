"""Dead time: samples that are averages over less than the time from sample to sample.

Deviations are those of the samples as they stand; tau is the averaging factor times the sample *interval*. What they
mean then depends on the noise [1]_: a sample of white noise averaged over T_a only has T / T_a times the variance of
one that fills its interval T. Read as contiguous, averages of 1 s saved every 2 s give sqrt(2) times the angle random
walk. So each term of ``sensors.noise`` takes both times into its expected Allan variance.

References
----------
.. [1] Barnes and Allan, Variances based on data with dead time between the measurements, NIST TN 1318, 1990.
"""

from __future__ import annotations

import numpy as np

from ...core.errors import DataError
from ...core.remarks import Remark

CONTIGUOUS = 1e-6  # relative difference of averaging time and interval that is none


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
            why="overlapping averages share their noise, and 0 s averages nothing",
            do="Give the averaging time of a sample, at most the sample interval",
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
    do = "Use the fitted terms, which allow for the dead time, not the curve"
    return (Remark("dead_time", "info", what, do=do),)
