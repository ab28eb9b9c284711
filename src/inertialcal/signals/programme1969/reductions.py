"""Slow parts taken out of a record before a line in it is looked at, and what that costs the line.

Four ways, as older reports use them, made right: regression on a tilt trace with both means removed; a straight line by
least squares; bands of Fourier lines, the highest with half of the weight; a centred moving mean. A missing sample
(NaN) stays missing: nothing is closed up or filled.

Each of the last three is linear in the record and so changes a line as well: with `gain_of` the same reduction is
passed over the line alone, at the same gaps, and the amplitude found is divided by what is left of it. A moving mean
whose window is a whole number of cycles leaves the line as it is inside the record; at its ends the window shrinks and
takes some of the line away.

``signals.sine`` fits line and drift at once and needs none of this.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ..spectrum.fourier import fourier_coefficients

Reduction = Callable[[Array], Array]


def without_tilt(x: ArrayLike, tilt: ArrayLike) -> tuple[Array, float]:
    """Return the record less its regression on a tilt trace, and the coefficient.

    Noise of the tilt meter makes the coefficient too small, and what the drive itself does to the meter (a mass
    attracts the mercury too) takes part of the line away: take the computed part out of the trace first.

    Parameters
    ----------
    x, tilt : array_like, shape (n,)
        NaN where a sample is missing; pairs are used.

    Returns
    -------
    rest : ndarray, shape (n,)
        Its mean removed; NaN where either is missing.
    coefficient : float
        Unit of ``x`` a unit of tilt.

    Raises
    ------
    DataError
        ``missing_tilt`` if less than three pairs are left, ``no_scatter`` if the trace does not vary.
    """
    x, tilt = _record(x), _record(tilt)
    if len(x) != len(tilt):
        raise DataError(f"{len(x)} samples, {len(tilt)} of tilt", do="Give two series of one length")
    pairs = np.isfinite(x) & np.isfinite(tilt)
    if pairs.sum() < 3:
        what = f"{int(pairs.sum())} samples with a tilt reading"
        raise DataError(what, do="Need 3 or more, or leave out the tilt trace", code="missing_tilt")
    centred, lean = (np.where(pairs, one - one[pairs].mean(), np.nan) for one in (x, tilt))
    square = float(np.nansum(lean**2))
    if not square > 0.0:
        raise DataError("the tilt trace does not vary", do="Leave it out", code="no_scatter")
    coefficient = float(np.nansum(centred * lean)) / square
    return centred - coefficient * lean, coefficient


def without_line(x: ArrayLike, times: ArrayLike | None = None) -> Array:
    """Return the record less a straight line by least squares, NaN where a sample is missing; shape (n,).

    Parameters
    ----------
    x : array_like, shape (n,)
        Record.
    times : array_like, shape (n,), optional
        Of the samples; evenly spaced by default.

    Raises
    ------
    DataError
        ``too_short`` if less than three samples are there.
    """
    x = _record(x)
    t = np.arange(len(x), dtype=np.float64) if times is None else np.asarray(times, dtype=np.float64)
    there = np.isfinite(x)
    if there.sum() < 3 or t.shape != x.shape:
        what = f"{int(there.sum())} of {len(x)} samples, {len(t)} times"
        raise DataError(what, do="A straight line needs 3 samples with their times", code="too_short")
    centred, early = x - x[there].mean(), t - t[there].mean()
    slope = float(centred[there] @ early[there]) / float(early[there] @ early[there])
    return np.asarray(centred - slope * early)


def without_bands(x: ArrayLike, low: int, high: int) -> Array:
    """Return the record less its mean, its lines 1 ... low and the ``high`` highest ones; shape (n,).

    Parameters
    ----------
    x : array_like, shape (n,)
        Complete: lines of a record with gaps mix.
    low, high : int
        How many lines at either end; that at half of the sampling frequency counts as the first from above.

    Raises
    ------
    DataError
        ``gaps`` if a sample is missing; or if nothing would be left.
    """
    x = _record(x)
    n, lines = len(x), len(x) // 2
    if not (low >= 0 and high >= 0 and low + high < lines):
        raise DataError(f"{low} + {high} of {lines} lines", do="At least one line must remain")
    found = fourier_coefficients(x)
    K = np.r_[0 : low + 1, lines - high + 1 : lines + 1]
    angle = 2.0 * np.pi / n * (np.outer(np.arange(n), K) % n)
    return np.asarray(x - np.cos(angle) @ found.cosine[K] - np.sin(angle) @ found.sine[K])


def without_moving_mean(x: ArrayLike, reach: int, samples_per_cycle: int | None = None, *, ends: bool = True) -> Array:
    """Return the record less a centred moving mean over ``2 reach`` samples; shape (n,).

    The outermost samples of the window count half. Missing samples are left out of each mean.

    Parameters
    ----------
    x : array_like, shape (n,)
        NaN where a sample is missing; it stays so.
    reach : int
        Samples to each side, S.
    samples_per_cycle : int, optional
        Of the line that shall stay.
    ends : bool
        Whether samples nearer than the reach to an end have the mean of the widest window that fits (and the outermost
        one that of itself and its neighbour); else they are NaN.

    Raises
    ------
    PlanError
        ``whole_cycles`` if the window is no whole number of cycles: the line would be removed with the drift.
    DataError
        ``too_short`` if the record has less samples than the window.
    """
    x = _record(x)
    n = len(x)
    if samples_per_cycle is not None and (2 * reach) % samples_per_cycle:
        what = f"a moving mean over {2 * reach} samples, {samples_per_cycle} samples a cycle"
        good = samples_per_cycle // (2 if samples_per_cycle % 2 == 0 else 1)
        why, do = "the line would be removed with the drift", f"Make the reach a multiple of {good}"
        raise PlanError(what, why=why, do=do, code="whole_cycles")
    if reach < 1 or n < 2 * reach + 1:
        raise DataError(f"{n} samples for a moving mean over {2 * reach}", do="Record longer", code="too_short")
    there = np.isfinite(x)
    sums, counts = (_summed(one, reach) for one in (np.where(there, x, 0.0), there.astype(np.float64)))
    rest = np.where(there & (counts > 0.0), x - sums / np.where(counts > 0.0, counts, 1.0), np.nan)
    if not ends:
        rest[:reach] = rest[n - reach :] = np.nan
    return rest


def gain_of(reduction: Reduction, line: Array) -> float:
    """Return the part of a line that a linear reduction leaves, as its projection on the line.

    Parameters
    ----------
    reduction : callable
        Takes a record, returns it reduced: ``lambda x: without_moving_mean(x, 4, 4)``.
    line : ndarray, shape (n,)
        Of any amplitude, NaN where a sample is missing.

    Raises
    ------
    DataError
        ``no_scatter`` if the line is zero at every sample that is left.
    """
    line = _record(line)
    rest = reduction(line)
    kept = np.isfinite(rest) & np.isfinite(line)
    square = float(line[kept] @ line[kept])
    if not square > 0.0:
        raise DataError("the line is zero at every sample", why="it cannot be seen", code="no_scatter")
    return float(rest[kept] @ line[kept]) / square


def _record(x: ArrayLike) -> Array:
    values = np.asarray(x, dtype=np.float64)
    if values.ndim != 1 or not len(values):
        raise DataError(f"a record of shape {values.shape}, need (n,)", code="bad_shape")
    return values


def _summed(x: Array, reach: int) -> Array:
    """Sum of each sample's window, its outermost samples counted half; narrower towards the ends."""
    n, i = len(x), np.arange(len(x))
    wide = np.minimum(np.minimum(i, n - 1 - i), reach)
    running = np.concatenate([[0.0], np.cumsum(x)])
    sums = running[i + wide + 1] - running[i - wide] - 0.5 * (x[i - wide] + x[i + wide])
    sums[0], sums[-1] = 0.5 * (x[0] + x[1]), 0.5 * (x[-1] + x[-2])
    return np.asarray(sums)
