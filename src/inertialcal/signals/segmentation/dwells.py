"""Dwell: one stretch of a signal, reduced to a reading with its scatter, and every sample accounted for.

The first and last samples of a dwell may be averages that reach into the ramp; they are dropped and
counted. Samples that are not finite and single outliers are left out and counted too. The mean of n
samples of correlated noise is worth fewer than n: the effective size follows from the correlation of
neighbours as for a first-order autoregressive process [1]_, its estimate corrected for the bias of a
short series [2]_ and never below zero, so that it cannot promise more than n.

``schedule`` cuts dwells whose edges are known from elsewhere, ``segments`` those that the signal shows.

References
----------
.. [1] Bayley and Hammersley, Suppl. J. Royal Statistical Society 8 (1946) 184-197: effective number of
   independent observations.
.. [2] Marriott and Pope, Biometrika 41 (1954) 390-402: bias of an estimated autocorrelation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.batches import NEAR, batches, count, is_long_stretch, made
from ...core.batches.summaries import Moments
from ...core.errors import PlanError
from ...core.estimate import Array
from ..time.samples import Flags, Indices, Samples

FEWEST = 8  # samples from which a correlation can be told
CORRELATED = 0.99  # largest correlation of neighbours that is told from drift


@dataclass(frozen=True, eq=False)
class Dwell:
    """A stretch at one level, as one reading."""

    # start, stop: samples used, half-open; what was dropped at the edges lies outside
    start: int
    stop: int
    mean: Array  # of the samples used [unit of the signal], shape (channels,)
    scatter: Array  # standard deviation of the samples used (n - 1) [unit of the signal], shape (channels,)
    n: int  # samples used
    n_effective: Array  # independent samples that they are worth for the mean, shape (channels,)
    time_ns: tuple[int, int] | None  # first and last stamp used [ns]
    edge_dropped: int  # samples dropped at the two edges
    missing: int  # samples inside that are not finite
    outliers: int  # single outliers inside, left out
    gaps: int  # gaps of the time axis inside
    stuck: Flags  # whether all samples used are equal, shape (channels,)
    disturbed: int = 0  # samples of the same placement left out because of a disturbance
    # mean of the reference over the samples used, where the dwell was cut by one, shape (applied channels,)
    applied: Array | None = None

    @property
    def u(self) -> Array:
        """Standard uncertainty of the mean from the scatter inside the dwell alone, shape (channels,)."""
        return self.scatter / np.sqrt(self.n_effective)


@dataclass(frozen=True)
class Tally:
    """Where every sample of a record went: the six parts add up to ``samples``."""

    samples: int
    used: int
    edge_dropped: int
    missing: int
    outliers: int
    disturbed: int
    outside: int


def tally(dwells: Sequence[Dwell], samples: int) -> Tally:
    """Count what of a record of so many samples its dwells use, and why not the rest.

    ``missing`` and ``outliers`` count inside the dwells; ``outside`` is all that belongs to no dwell.
    """
    parts = {
        name: sum(getattr(dwell, name) for dwell in dwells)
        for name in ("edge_dropped", "missing", "outliers", "disturbed")
    }
    used = sum(dwell.n for dwell in dwells)
    return Tally(samples, used, **parts, outside=samples - used - sum(parts.values()))


def dwell_of(samples: Samples, start: int, stop: int, drop_edge: int = 1, disturbed: int = 0) -> Dwell | None:
    """Reduce the stretch [start, stop) to a reading.

    Parameters
    ----------
    samples : Samples
        Of the whole record.
    start, stop : int
        Half-open.
    drop_edge : int
        Good samples to drop at each end.
    disturbed : int
        Samples of the same placement that the caller has left out.

    Returns
    -------
    Dwell or None
        None where fewer than two samples are left.

    Raises
    ------
    PlanError
        If ``drop_edge`` is negative.
    """
    if drop_edge < 0:
        raise PlanError(f"drop_edge {drop_edge}, need 0 or more")
    if is_long_stretch(samples.values, stop - start):
        return _dwell_by_batches(samples, start, stop, drop_edge, disturbed)
    good = np.flatnonzero(samples.finite[start:stop] & ~samples.outlier[start:stop]) + start
    used = good[drop_edge : len(good) - drop_edge]
    if len(used) < 2:
        return None
    first, last = int(used[0]), int(used[-1])
    missing = int(np.count_nonzero(~samples.finite[first : last + 1]))
    times = None if samples.time_ns is None else (int(samples.time_ns[first]), int(samples.time_ns[last]))
    x = samples.values[first : last + 1]
    x = x if len(x) == len(used) else np.asfortranarray(x[used - first])
    follows = (np.diff(used) == 1) & ~samples.gap[used[1:]]
    mean, variance, worth, stuck = (one[0] for one in _moments(x, follows, np.zeros(1, dtype=np.int64)))
    return Dwell(
        start=first,
        stop=last + 1,
        mean=mean,
        scatter=np.sqrt(variance * (len(used) / (len(used) - 1.0))),
        n=len(used),
        n_effective=worth,
        time_ns=times,
        edge_dropped=2 * drop_edge,
        missing=missing,
        outliers=last + 1 - first - len(used) - missing,
        gaps=int(np.count_nonzero(samples.gap[first + 1 : last + 1])),
        stuck=stuck,
        disturbed=disturbed,
    )


def _dwell_by_batches(samples: Samples, start: int, stop: int, drop_edge: int, disturbed: int) -> Dwell | None:
    """Reduce a stretch that is longer than a batch, as `dwell_of` does, in two passes."""
    finite, outlier, gap = (one[start:stop] for one in (samples.finite, samples.outlier, samples.gap))
    good = made(stop - start, bool, lambda a, b: finite[a:b] & ~outlier[a:b], finite, outlier)
    n = count(good, lambda part: part) - 2 * drop_edge
    if n < 2:
        return None
    first, last = 0, len(good) - 1
    for _ in range(drop_edge + 1):
        first += int(np.argmax(good[first:])) + 1
        last -= int(np.argmax(good[last::-1])) + 1
    first, last = first - 1, last + 1
    x = samples.values[start + first : start + last + 1]
    good, finite, gap = (one[first : last + 1] for one in (good, finite, gap))
    of = [Moments() for _ in x.T]
    for a, b in batches(x, good):
        of = [one.with_more(own[a:b][good[a:b]]) for one, own in zip(of, x.T, strict=True)]
    mean, squares = np.array([one.mean for one in of]), np.array([one.squares for one in of])
    pairs, products = 0, np.zeros(len(of))
    for a, b in batches(x[1:], good[1:], gap[1:]):
        follows = good[a:b] & good[a + 1 : b + 1] & ~gap[a + 1 : b + 1]
        pairs += int(np.count_nonzero(follows))
        left, right = x[a:b][follows] - mean, x[a + 1 : b + 1][follows] - mean
        products += np.einsum("ij,ij->j", left, right)
    variance = np.where([one.high == one.low for one in of], 0.0, squares / n)
    missing = len(finite) - count(finite, lambda part: part)
    first, last = start + first, start + last
    return Dwell(
        start=first,
        stop=last + 1,
        mean=mean,
        scatter=np.sqrt(squares / (n - 1)),
        n=n,
        n_effective=_worth(n, variance, products, pairs),
        time_ns=None if samples.time_ns is None else (int(samples.time_ns[first]), int(samples.time_ns[last])),
        edge_dropped=2 * drop_edge,
        missing=missing,
        outliers=last + 1 - first - n - missing,
        gaps=count(gap[1:], lambda part: part),
        stuck=np.array([one.high == one.low for one in of]),
        disturbed=disturbed,
    )


def effective_size(x: Array, neighbours: Flags | None = None) -> Array:
    """Return how many independent samples, 1 to n, those of one stretch (n, channels) are worth for their mean.

    ``neighbours`` (n - 1,) says which samples are followed by their neighbour; all by default.
    """
    follows = np.ones(len(x) - 1, dtype=bool) if neighbours is None else neighbours
    worth: Array = _moments(x, follows, np.zeros(1, dtype=np.int64))[2][0]
    return worth


def moments_of(samples: Samples, start: Indices, stop: Indices) -> tuple[Array, Array, Array, NDArray[np.int64]] | None:
    """Reduce k stretches [start, stop) at once, as `dwell_of` does each, with no samples dropped at its ends.

    Returns
    -------
    mean, scatter, n_effective, n : ndarray, shapes (k, channels) and (k,)
        As a ``Dwell`` has them; None where a stretch has fewer than two samples.
    """
    sizes = stop - start
    if sizes.sum() > NEAR:  # one by one: together they would fill the cache
        dwells = [dwell_of(samples, a, b, 0) for a, b in zip(start.tolist(), stop.tolist(), strict=True)]
        found = [(one.mean, one.scatter, one.n_effective, one.n) for one in dwells if one is not None]
        mean, scatter, worth, n = (np.array(part) for part in zip(*found, strict=True))
        return (mean, scatter, worth, n) if len(n) == len(start) else None
    which = np.repeat(np.arange(len(start)), sizes)
    rows = np.arange(len(which)) + (start - np.cumsum(sizes) + sizes)[which]
    good = samples.finite[rows] & ~samples.outlier[rows]
    rows, which = rows[good], which[good]
    n = np.bincount(which, minlength=len(start))
    if not len(n):
        none = np.empty((0, samples.values.shape[1]))
        return none, none, none, n
    if n.min() < 2:
        return None
    follows = (np.diff(rows) == 1) & (which[1:] == which[:-1]) & ~samples.gap[rows[1:]]
    mean, variance, worth, _ = _moments(samples.values[rows], follows, np.cumsum(n) - n)
    return mean, np.sqrt(variance * (n / (n - 1.0))[:, None]), worth, n


def _moments(x: Array, follows: Flags, at: Indices) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Return mean, mean square about it, effective size, and whether all are equal, of k stretches (k, channels).

    Parameters
    ----------
    x : ndarray, shape (n, channels)
        Samples of all stretches, one after another.
    follows : ndarray of bool, shape (n - 1,)
        Samples that are followed by their neighbour.
    at : ndarray of int, shape (k,)
        Where each begins.
    """
    n = np.diff(np.append(at, len(x)))
    counts = n[:, None]
    first = x[at]
    residual = x - np.repeat(first, n, axis=0)  # sums of what is small keep their digits
    stuck = np.add.reduceat(residual != 0.0, at, axis=0, dtype=np.int64) == 0
    mean = np.add.reduceat(residual, at, axis=0) / counts
    residual -= np.repeat(mean, n, axis=0)
    variance = np.add.reduceat(residual * residual, at, axis=0) / counts
    pairs = np.append(follows, False)
    products = np.zeros_like(residual)
    np.multiply(residual[:-1], residual[1:], out=products[:-1], where=follows[:, None])
    number = np.add.reduceat(pairs, at, dtype=np.int64)[:, None]
    worth = _worth(counts, variance, np.add.reduceat(products, at, axis=0), number)
    return first + mean, variance, worth, stuck


def _worth(n: NDArray[np.int64] | int, variance: Array, products: Array, pairs: NDArray[np.int64] | int) -> Array:
    """Return the effective size of n samples from their variance, and the sum of products of so many neighbours."""
    told = (np.asarray(n) >= FEWEST) & (np.asarray(pairs) > 0) & (variance > 0.0)
    raw = np.divide(products, pairs * variance, out=np.zeros_like(variance), where=told)
    rho = np.clip(np.divide(n * raw + 1.0, n - 4.0, out=np.zeros_like(raw), where=told), 0.0, CORRELATED)
    worth = n / (1.0 + 2.0 * rho / (1.0 - rho) * (1.0 - (1.0 - rho**n) / (n * (1.0 - rho))))
    return np.where(told, np.clip(worth, 1.0, n), n)
