"""Allan variances that a fit takes: one axis of one run, octaves of it that carry something.

The fit needs of a curve only what `AllanLike` says, so that curves of other programs can be fitted as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array, Numbers
from ...core.units import factor

SPACING = 1.9  # least ratio of neighbouring averaging times: closer ones repeat each other
LEAST_EDF = 1.5  # of a point that is used
LEAST_POINTS = 4


class AllanLike(Protocol):
    """Overlapping Allan deviation over averaging times, as ``signals.allan`` gives it."""

    @property
    def m(self) -> Numbers:
        """Samples in a mean, shape (k,)."""

    @property
    def n(self) -> Numbers:
        """Terms averaged, shape (k,) or (k, axes)."""

    @property
    def deviation(self) -> Array:
        """Shape (k,) or (k, axes) [unit]."""

    @property
    def edf(self) -> Array:
        """Equivalent degrees of freedom, shape of the deviation."""

    @property
    def interval(self) -> float:
        """Time from sample to sample [s]."""

    @property
    def averaging(self) -> float | None:
        """Averaging time of a sample [s]; None when nobody said, and the interval is taken."""


@dataclass(frozen=True, eq=False)
class Run:
    """Overlapping Allan variances of one axis of one record.

    Parameters
    ----------
    m : ndarray, shape (k,)
        Samples in a mean, ascending.
    variance : ndarray, shape (k,)
        Overlapping Allan variances [unit^2].
    n : ndarray, shape (k,)
        Terms averaged.
    edf : ndarray, shape (k,)
        Equivalent degrees of freedom: twice the weight.
    interval, averaging : float
        Time from sample to sample, and that of one mean [s].
    inflation : ndarray, shape (k,)
        By how much missing samples raise the variance of white noise; 1 without gaps.
    ends : ndarray, shape (k,), optional
        Squared weights of errors of the integrated signal over 2 / m^2; default: 3, without gaps.
    """

    m: Array
    variance: Array
    n: Array
    edf: Array
    interval: float
    averaging: float
    inflation: Array
    ends: Array | None = None

    @property
    def tau(self) -> Array:
        """Averaging times [s]."""
        return np.asarray(self.m * self.interval)

    @property
    def samples(self) -> float:
        """Samples that the record has room for."""
        return float(np.max(self.n + 2.0 * self.m - 1.0))

    @property
    def length(self) -> float:
        """Length of the record [s]."""
        return self.samples * self.interval


def unit_of(curve: AllanLike | Run) -> str:
    """Return the unit that a curve says it has; empty where nobody said."""
    return str(getattr(curve, "unit", ""))


def run_of(curve: AllanLike | Run, axis: int | None = None, unit: str = "") -> Run:
    """Return what the fit takes of a curve.

    Parameters
    ----------
    curve : AllanLike or Run
        Overlapping Allan deviation.
    axis : int, optional
        Column, where the curve has several.
    unit : str
        To convert to, where the curve says its own; a `Run` has none.

    Raises
    ------
    DataError
        If the deviation is of another kind, in a unit of something else, the axis is not said, a constant channel has
        no noise, or fewer than four averaging times carry anything.
    """
    if isinstance(curve, Run):
        return _usable(curve)
    _check_kind(curve)
    given = unit_of(curve)
    scale = factor(given, unit) if given and unit else 1.0
    variance = (scale * _column(np.asarray(curve.deviation, dtype=float), axis)) ** 2
    averaging = getattr(curve, "averaging", None)
    inflation = np.ones(len(variance))
    raised = getattr(curve, "inflation", None)
    if raised is not None:  # of white noise by missing samples, divided out where the noise seems white
        inflation = _column(np.asarray(raised, dtype=float), axis)
        power = _column(np.asarray(getattr(curve, "power", inflation), dtype=float), axis)
        variance = np.where(power >= 0.0, variance * inflation, variance)
    ends = getattr(curve, "ends", None)
    run = Run(
        np.asarray(curve.m, dtype=float),
        variance,
        _column(np.asarray(curve.n, dtype=float), axis),
        _column(np.asarray(curve.edf, dtype=float), axis),
        float(curve.interval),
        float(curve.interval if averaging is None else averaging),
        inflation,
        None if ends is None else _column(np.asarray(ends, dtype=float), axis),
    )
    return _usable(run)


def _check_kind(curve: AllanLike) -> None:
    kind = getattr(curve, "kind", "overlapping")
    if kind != "overlapping":
        raise DataError(
            f"a curve of the {kind} deviation",
            why="weights and covariance of the fit are those of the overlapping Allan variance",
            do='Compute it with deviation="overlapping"',
            code="not_overlapping",
        )


def _column(values: Array, axis: int | None) -> Array:
    if values.ndim == 1:
        return values
    if axis is None and values.shape[1] != 1:
        raise DataError(f"a curve of {values.shape[1]} axes", do="Say which: axis=0, 1, ...", code="axis")
    if axis is not None and not 0 <= axis < values.shape[1]:
        raise DataError(f"axis {axis} of a curve of {values.shape[1]}", do="The first is axis=0", code="axis")
    return np.asarray(values[:, axis or 0])


def _usable(run: Run) -> Run:
    """Keep octaves with something in them."""
    there = run.variance[np.isfinite(run.variance)]
    if len(there) and not np.any(there > 0.0):
        raise DataError(
            "the Allan deviation is zero throughout",
            why="a constant channel has no noise that could be told",
            do="Look whether the sensor is stuck, or its steps coarser than its noise",
            code="constant",
        )
    good = np.isfinite(run.variance) & (run.variance > 0.0) & (run.edf >= LEAST_EDF) & (run.n >= 1.0)
    kept: list[int] = []
    for i in np.flatnonzero(good):
        if not kept or run.m[i] >= SPACING * run.m[kept[-1]]:
            kept.append(int(i))
    if len(kept) < LEAST_POINTS:
        raise DataError(
            f"{len(kept)} averaging time(s) with {LEAST_EDF:g} or more degrees of freedom, need {LEAST_POINTS}",
            why=f"{run.samples:.0f} samples cannot separate terms of noise",
            do="Record for longer",
            code="too_short",
        )
    at = np.array(kept)
    ends = None if run.ends is None else run.ends[at]
    return Run(
        run.m[at], run.variance[at], run.n[at], run.edf[at], run.interval, run.averaging, run.inflation[at], ends
    )  # fmt: skip
