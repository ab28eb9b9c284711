"""Allan deviations of recordings, with intervals.

Time-first, (n,) or (n, axes). Deviations are always of the *rate*: of rad/s or m/s^2 where the samples are rates, rate
increments, or their integral, which the caller says (``quantity``): nothing tells them apart but the unit. Averaging
time is the averaging factor times the sample interval; samples may be averages over less (``dead_time``).

Intervals are chi-square, with the equivalent degrees of freedom of the noise type found at each averaging time
(``edf``, ``noise_type``). They hold for one averaging time each; neighbouring ones share their noise.

>>> import numpy as np
>>> curve = allan(np.random.default_rng(1).normal(size=10_000), 0.01, quantity="rate", unit="rad/s")
>>> bool(curve.lo[0, 0] < curve.deviation[0, 0] < curve.hi[0, 0])
True
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.estimate import Array
from ..names import Deviation, Quantity
from ..threads import LARGE
from .channel import (
    Allan,
    analyse_alike,
    analyse_channel,
    checked_kind,
    checked_names,
    checked_present,
    checked_samples,
    joined,
)
from .gaps import check_averaging, on_grid
from .loops import FEW
from .taus import Factors, Taus, factors_of

__all__ = ["Allan", "Deviation", "Quantity", "allan", "allan_alike", "on_grid"]

ONE_SIGMA = 0.6827


def allan(
    x: ArrayLike,
    interval: float,
    *,
    quantity: Quantity,
    deviation: Deviation = "overlapping",
    taus: Taus = "octave",
    factors: Factors | None = None,
    averaging: float | None = None,
    scale: float = 1.0,
    present: NDArray[np.bool_] | None = None,
    p: float = ONE_SIGMA,
    noise: Literal["auto"] | int = "auto",
    names: tuple[str, ...] | None = None,
    unit: str = "",
) -> Allan:
    """Return the deviations of a record at several averaging times, with intervals.

    Parameters
    ----------
    x : array_like, shape (n,) or (n, axes)
        Samples, one interval apart. Whole numbers (raw counts) are summed without rounding; NaN is a missing sample.
    interval : float
        From sample to sample [s].
    quantity : {"rate", "increment", "angle"}
        What a sample is: mean of a rate over it, what was added in it, or the integral at its stamp.
    deviation : Deviation
        Which one, by its name in ``deviations.KINDS``; the overlapping Allan deviation by default. Total ones need a
        record without gaps; what mirrors change in their mean is divided out, for the noise type found.
    taus : {"octave", "decade", "all"} or sequence of float
        Averaging times; a list is in seconds.
    factors : sequence of int, optional
        Averaging times in samples, in place of ``taus``.
    averaging : float, optional
        What each sample is the mean of [s], where that is less than the interval.
    scale : float
        Unit of the result a unit of ``x``: the step of a count.
    present : ndarray of bool, shape (n,) or (n, axes), optional
        Which samples are there, for whole numbers, which have no NaN.
    p : float
        Probability of the intervals.
    noise : "auto" or int
        Exponent of the noise, which the degrees of freedom follow from; found at each averaging time by default.
    names, unit : tuple of str, str
        Of the channels, and of the result, for what is printed.

    Raises
    ------
    DataError, PlanError
        If samples are no numbers, of another shape, too few or all missing, or a time or word is not possible; if a
        total deviation is wanted of a record with gaps.
    """
    kind, samples = checked_kind(quantity, deviation, p, noise), checked_samples(x, interval, scale)
    check_averaging(interval, averaging)
    n, axes = samples.shape
    there, names = checked_present(present, samples), checked_names(names, axes)
    m, remarks = factors_of(kind, n + (quantity != "angle"), interval, taus, factors)
    columns = [
        analyse_channel(samples[:, i], None if there is None else there[:, i], quantity, kind, m, noise, names[i])
        for i in range(axes)
    ]
    return joined(
        columns, m, n, interval, averaging, deviation, quantity, names, unit, scale=scale, p=p, remarks=remarks
    )


def allan_alike(
    series: Sequence[Array],
    interval: float,
    *,
    averaging: float | None = None,
    p: float = ONE_SIGMA,
    names: Sequence[str],
    unit: str = "",
) -> tuple[Allan | None, list[int]]:
    """Return the overlapping Allan deviations at octaves of many complete records of one length, side by side.

    They are those of `allan`, of each by itself. Records of which it says anything, or that are too short or too long
    to be taken so, are left out.

    Parameters
    ----------
    series : sequence of ndarray, shape (n,)
        Rates, in float64, one interval apart.
    interval, averaging, p, unit : as `allan` takes them
    names : sequence of str
        Of the records.

    Returns
    -------
    Allan or None
        Of the records that are taken, one a column; None where there is none.
    taken : list of int
        Which they are.

    Raises
    ------
    DataError, PlanError
        As `allan`.
    """
    kind, samples = checked_kind("rate", "overlapping", p, "auto"), len(series[0])
    check_averaging(interval, averaging)
    if not FEW < samples < LARGE:
        return None, []
    m, remarks = factors_of(kind, samples + 1, interval)
    found, taken = analyse_alike(series, kind, m)
    if not taken:
        return None, []
    named = tuple(names[i] for i in taken)
    return joined(
        [found], m, samples, interval, averaging, "overlapping", "rate", named, unit, scale=1.0, p=p, remarks=remarks
    ), taken
