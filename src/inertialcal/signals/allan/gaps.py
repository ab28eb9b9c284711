"""Gaps and dead time: the regular grid that a record with missing samples lies on, and averages over less than it.

Windows of an Allan deviation are counted in time, so samples must stand where they were taken. A record with gaps is
put on the grid of its sample interval, with nothing where no sample came. A sample is moved by at most half an
interval, and never interpolated; stamps that are not a grid at all are refused.

Dead time: samples are averages over less than the time from sample to sample. Deviations are those of the samples as
they stand; tau is the averaging factor times the sample *interval*. What they mean then depends on the noise [1]_: a
sample of white noise averaged over T_a only has T / T_a times the variance of one that fills its interval T. Read as
contiguous, averages of 1 s saved every 2 s give sqrt(2) times the angle random walk. So each term of ``sensors.noise``
takes both times into its expected Allan variance.

References
----------
.. [1] Barnes and Allan, Variances based on data with dead time between the measurements, NIST TN 1318, 1990.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Numbers
from ...core.recording import SECOND, Times
from ...core.remarks import Remark
from ..time.time_axis import backward_steps

FILL = 2  # windows are used from 1 / FILL of their samples
COMPLETE = 3.0  # squared weights of the three errors of the running sum in a term, over 2 / m^2: 1 + 4 + 1
MOST_EMPTY = 100.0  # places on the grid, a sample, above which a record is no record with gaps


def on_grid(x: Numbers, time_ns: Times, interval: float) -> tuple[Numbers, NDArray[np.bool_]]:
    """Return samples on the regular grid of their interval, and which places hold one.

    Parameters
    ----------
    x : ndarray, shape (n,) or (n, axes)
        Samples of any type, which they keep.
    time_ns : ndarray of int64, shape (n,)
        Their stamps [ns].
    interval : float
        From sample to sample [s].

    Returns
    -------
    values : ndarray, shape (places,) or (places, axes)
        0 where no sample came.
    present : ndarray of bool, shape (places,)
        Whether one came.

    Raises
    ------
    DataError
        If stamps are repeated or run backwards, two samples fall on one place, or nearly all places are empty.
    """
    if time_ns.shape != (len(x),):
        raise DataError(f"{len(x)} samples, time of shape {time_ns.shape}", code="wrong_shape")
    steps = np.diff(time_ns)
    if np.any(steps <= 0):
        first, repeated = int(np.argmax(steps <= 0)) + 1, int(np.count_nonzero(steps == 0))
        back = f"; {backward_steps(time_ns)}" if np.any(steps < 0) else ""
        raise DataError(
            f"{repeated} repeated timestamp(s), {np.count_nonzero(steps < 0)} out of order{back}",
            where=f"sample {first}",
            why="averaging times are counted in samples, which must be in order",
            do="Cut the record there, or sort it; and remove or correct repeated rows",
            code="time_backwards" if repeated < np.count_nonzero(steps <= 0) else "time_repeated",
        )
    # From step to step: an interval that is known to 1e-5 would drift off the grid over a long record.
    places = np.concatenate([[0], np.cumsum(np.rint(steps / (interval * SECOND)).astype(np.int64))])
    n = len(x)
    same = np.diff(places) == 0
    if same.any():
        raise DataError(
            f"{np.count_nonzero(same)} sample(s) come within half a sample interval of {interval:g} s",
            where=f"sample {int(np.argmax(same)) + 1}",
            why="they do not lie on the grid of that interval",
            do="Give the right interval; drop the time column if it holds packet arrival times",
            code="off_grid",
        )
    if places[-1] + 1 > MOST_EMPTY * n:
        raise DataError(
            f"{n} samples over {places[-1] + 1} intervals of {interval:g} s",
            why="nearly all samples would be missing",
            do="Give the right sample interval, or cut the record",
            code="all_missing",
        )
    present = np.zeros(int(places[-1]) + 1, dtype=bool)
    present[places] = True
    values = np.zeros((len(present), *x.shape[1:]), dtype=x.dtype)
    values[places] = x
    return values, present


def missing_remark(missing: NDArray[np.int64], n: int, names: tuple[str, ...]) -> tuple[Remark, ...]:
    """Return what is said of missing samples, in one line a channel."""
    do = "Windows at least half full are used; find out why samples are missing"
    return tuple(
        Remark("gaps", "warning", f"{name}: {lost} of {n} samples are missing ({lost / n:.2%})", do=do)
        for name, lost in zip(names, missing.tolist(), strict=True)
        if lost
    )


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
