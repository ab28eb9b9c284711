"""Noise and drift that the quiet record of a flip shows, and what they do to its results.

The block means of an axis at the positions theta are taken as::

    y = level + what turns + white + slow + drift

``slow`` is nothing, 1/f noise or a random walk, of the head (the same at all positions) or of ambient acceleration
(it turns with the head: the covariance of two blocks times the cosine of the angle between them); ``drift`` is nothing
or a straight line, again of the head or of ambient acceleration. Level and what turns are not looked at: only
contrasts enter, by restricted likelihood [1]_, with the generalised covariances of ``statistics.slow_noise`` [2]_. A
record of a few dwells does not say which of these it holds, and how much of each. So no best one is chosen: variances
are averaged over all of them, each by its likelihood on a grid of sizes, times how likely it was taken before [3]_.

What the uncertainty means. ``bias`` and ``ambient_acceleration`` are means over the quiet record of what wanders
slowly; white noise is none of either. So the error of a bias is the white noise of its dwells in full, the slow noise
of the head as far as the dwells differ from the record, and changes of the ambient acceleration between the dwells of
one position and of the other. In white noise of one-sided density S, dwells of T seconds in all give ``S / (2 T)``. A
drift is not taken off: the square of the error that it makes, as the record shows it, is added. The stated u is the
median standard deviation of the average; its degrees of freedom are those of Student's t with the same 95 % interval.
For an ambient acceleration, slow noise counts as that of head or cabin, whichever moves it more: few dwells hardly show
which it is.

What is assumed: white noise of one level throughout; independent axes; sizes of slow noise and drift equally likely
per factor of 2, from hardly to be seen up to far beyond the white noise.

Three ways in which real data break it (figures in the manual): slow noise that is as long as a dwell in three dwells
or fewer, hardly seen in them; a drift between two short dwells too slow to be seen inside them; ambient acceleration
that swings with the orbit, so that its mean over the record is not that over the dwells.

References
----------
.. [1] D. A. Harville, J. Am. Stat. Assoc. 72 (1977) 320 (restricted likelihood).
.. [2] G. Matheron, Adv. Appl. Prob. 5 (1973) 439 (generalised covariance of intrinsic random functions).
.. [3] G. E. P. Box and G. C. Tiao, Bayesian Inference in Statistical Analysis, 1973, ch. 5 (variance components).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.estimate import Array
from ....statistics.intervals import student_of_mixture
from ....statistics.slow_noise import FLICKER, WALK, window_covariance
from ..readings import Quiet
from .equations import directions

MOST = 240  # pieces of a record: time grows with their cube
FEWEST = 8  # contrasts that show noise
HEAD, AMBIENT = "head", "ambient"
Slow = tuple[str, str]  # noise, and of what
BEFORE: Mapping[Slow | None, float] = {
    None: 0.25, (FLICKER, HEAD): 0.2, (FLICKER, AMBIENT): 0.12, (WALK, HEAD): 0.25, (WALK, AMBIENT): 0.18,
}  # fmt: skip
NO_LINE, LINE = 0.6, 0.2  # how likely no drift is, and one of either source
SIZES = 2.0 ** np.arange(-6, 13)  # variance of slow noise in the mean contrast, over that of white noise
STEPS = 2.0 ** np.arange(2, 22)  # square of all contrasts of a drift, over the same
AHEAD = {FLICKER: 10.0, WALK: 3.0}  # record lengths from the beginning of this record to that of the next
SEEN = 1e-6  # of a drift: relative size that the design leaves of it
BALANCED = 1e-9  # of weights: relative sum of those of a difference
NEGLIGIBLE = 1e-7  # probability of a size
ROUNDING = 1e-15  # of contrasts of equal means, relative to their size and number
MEMORY = 16  # records that are kept: axes and simulated tests share theirs


@dataclass(frozen=True, eq=False)
class _Drift:
    """A straight line: of what, its value in each piece (n,) and on the contrasts (m,), where its length is 1."""

    source: str
    values: Array
    contrasts: Array
    rate: float  # per second


@dataclass(frozen=True, eq=False)
class _Pieces:
    """A record in runs of blocks, all values times the root of their blocks, so that white noise has one variance."""

    start: Array  # shape (n,) [s]
    stop: Array
    angle: Array  # shape (n,) [rad]
    root: Array  # shape (n,)
    membership: Array  # shape (n, blocks): sums blocks over root
    contrasts: Array  # shape (m, n): weights that the design does not see
    kernels: Mapping[str, Array]  # covariance of means of slow noise of unit size, shape (n, n)
    slow: Mapping[Slow, tuple[Array, Array, float]]  # variances (m,) and axes of the contrasts, mean variance
    drifts: tuple[_Drift, ...]


@dataclass(frozen=True, eq=False)
class _Cells:
    """Sizes of a slow noise and of a drift, shape (q,)."""

    slow: Slow | None
    drift: _Drift | None
    log: Array  # restricted likelihood times what was taken before, ln
    white: Array  # variance of a piece of one block
    size: Array  # variance of slow noise of unit size
    square: Array  # mean square of the drift
    probability: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True, eq=False)
class RecordNoise:
    """Noise and drift of one axis, as its quiet record shows them."""

    pieces: _Pieces
    cells: tuple[_Cells, ...]

    def without_drift(self) -> RecordNoise:
        """Return white and 1/f noise of the head alone: what a control axis is tested against."""
        kept = [one for one in self.cells if one.drift is None and one.slow in (None, (FLICKER, HEAD))]
        return replace(self, cells=_weighted(kept))

    def covariance(self, lines: Array) -> tuple[Array, Array]:
        """Return covariance and degrees of freedom of the errors of results, by their weights of blocks (p, b)."""
        weights = lines @ self.pieces.membership.T
        count = len(weights)
        mean, u, dof = np.zeros((count, count)), np.zeros(count), np.full(count, np.inf)
        used = np.flatnonzero(np.any(weights != 0.0, axis=1))
        for i in used:
            for k in used[used < i]:
                variance, probability = self._variances(weights[i], weights[k])
                mean[i, k] = mean[k, i] = float(variance @ probability)
            own = weights[i]
            variance, probability = self._variances(own, own)
            mean[i, i] = float(variance @ probability)
            u[i], dof[i] = self._student(variance, probability)
        size = np.sqrt(np.diagonal(mean))
        shrunk = np.where(size > 0.0, u / np.where(size > 0.0, size, 1.0), 0.0)
        return mean * np.outer(shrunk, shrunk), dof

    def next_record(self, line: Array) -> tuple[float, float]:
        """Return u and degrees of freedom of a bias as that of the next record, by its weights of blocks (b,)."""
        weights = self.pieces.membership @ line
        return self._student(*self._variances(weights, weights, onward=True))

    def _student(self, variance: Array, probability: Array) -> tuple[float, float]:
        kept = probability > NEGLIGIBLE
        free = float(len(self.pieces.contrasts))
        return student_of_mixture(np.sqrt(variance[kept]), probability[kept] / probability[kept].sum(), free)

    def _variances(self, one: Array, other: Array, onward: bool = False) -> tuple[Array, Array]:
        """Covariance of two errors for each size, shape (all q,), and the probability of each."""
        white, found = float(one @ other), []
        slow = {kind: self._of_slow(kind, one, other, onward) for kind in self.pieces.slow}
        for cells in self.cells:
            variance = white * cells.white
            if cells.slow is not None:
                variance = variance + slow[cells.slow] * cells.size
            if cells.drift is not None:
                variance = variance + cells.square * (
                    self._of_drift(cells.drift, one, onward) * self._of_drift(cells.drift, other, onward)
                )
            found.append(np.maximum(variance, 0.0) if one is other else variance)
        return np.concatenate(found), np.concatenate([cells.probability for cells in self.cells])

    def _of_slow(self, kind: Slow, one: Array, other: Array, onward: bool) -> float:
        """Covariance of two errors by slow noise of unit size; a mean over the record is no error."""
        noise, source = kind
        if onward and source == HEAD:
            return self._of_next(noise, one)
        difference = abs(float(one @ self.pieces.root)) <= BALANCED * float(np.abs(one) @ self.pieces.root)
        either = difference and one is other and (noise, AMBIENT) in self.pieces.slow
        found = []
        if source == HEAD or either:
            found.append(self._less_record(noise, one, other))
        if source == AMBIENT or either:
            turns = (np.cos(self.pieces.angle), np.sin(self.pieces.angle))
            found.append(sum(self._less_record(noise, one * turn, other * turn) for turn in turns))
        return max(found)

    def _less_record(self, noise: str, one: Array, other: Array) -> float:
        root = self.pieces.root
        mean = root / float(root @ root)
        a, b = (weights - float(weights @ root) * mean for weights in (one, other))
        return float((a * root) @ self.pieces.kernels[noise] @ (b * root))

    def _of_next(self, noise: str, weights: Array) -> float:
        p = self.pieces
        begin, length = float(p.start.min()), float(p.stop.max() - p.start.min())
        start = np.append(p.start, begin + AHEAD[noise] * length)
        kernel = window_covariance(start, np.append(p.stop, start[-1] + length), noise)
        line = np.append(weights * p.root, -float(weights @ p.root))
        return float(line @ kernel @ line)

    def _of_drift(self, drift: _Drift, weights: Array, onward: bool) -> float:
        error = float(weights @ drift.values)
        if onward and drift.source == HEAD:
            p = self.pieces
            error -= float(weights @ p.root) * drift.rate * float(p.stop.max() - p.start.min())
        return error


def noise_of(record: Quiet, axis: str, turns: bool, drift: str = "none") -> RecordNoise:
    """Return noise and drift of an axis.

    Parameters
    ----------
    record : Quiet
        The blocks that the axis has its samples in.
    axis : str
        Which.
    turns : bool
        Whether it lies across the turn, so that ambient acceleration turns in it.
    drift : str
        What the plan fits: ``"bias"`` or ``"ambient"`` in proportion to time.

    Raises
    ------
    DataError
        ``too_few_blocks`` if fewer than 8 contrasts are left, ``no_scatter`` if the means do not differ.
    """
    used = np.ascontiguousarray(record.weights != 0.0)
    pieces = _pieces(record.times.tobytes(), record.length, record.angle.tobytes(), used.tobytes(), turns, drift)
    means = record.means[axis]
    seen = pieces.contrasts @ (pieces.membership @ means)
    m = len(seen)
    if not float(seen @ seen) > (ROUNDING * len(means)) ** 2 * float(means @ means):
        raise DataError("the block means do not differ", why="no noise can be found", code="no_scatter")
    cells = []
    for slow, before in BEFORE.items():
        if slow is not None and slow not in pieces.slow:
            continue
        variances, axes, scale = (np.zeros(m), np.eye(m), 1.0) if slow is None else pieces.slow[slow]
        sizes = np.zeros(1) if slow is None else SIZES
        y = axes.T @ seen
        whole = 1.0 + sizes[:, None] * variances
        square = np.sum(y**2 / whole, axis=1)
        log = np.log(before / len(sizes)) - 0.5 * np.sum(np.log(whole), axis=1)
        white = square / m
        own = log + np.log(NO_LINE) - 0.5 * m * np.log(square)
        cells.append(_Cells(slow, None, own, white, white * sizes / scale, np.zeros(len(sizes))))
        for one in pieces.drifts:
            along = axes.T @ one.contrasts
            q = np.sum(along**2 / whole, axis=1)[:, None]
            g = np.sum(along * y / whole, axis=1)[:, None]
            fits = STEPS / (1.0 + STEPS * q)
            rest = square[:, None] - fits * g**2
            own = log[:, None] + np.log(LINE / len(STEPS)) - 0.5 * np.log1p(STEPS * q) - 0.5 * m * np.log(rest)
            white, size = (rest / m).ravel(), (rest / m * sizes[:, None] / scale).ravel()
            cells.append(_Cells(slow, one, own.ravel(), white, size, ((fits * g) ** 2 + rest / m * fits).ravel()))
    return RecordNoise(pieces, _weighted(cells))


def _weighted(cells: Sequence[_Cells]) -> tuple[_Cells, ...]:
    """Return cells with their probability."""
    most = max(float(one.log.max()) for one in cells)
    total = float(sum(np.exp(one.log - most).sum() for one in cells))
    return tuple(replace(one, probability=np.exp(one.log - most) / total) for one in cells)


@lru_cache(MEMORY)
def _pieces(times: bytes, length: float, angles: bytes, used: bytes, turns: bool, drift: str) -> _Pieces:
    middle, angle = np.frombuffer(times), np.frombuffer(angles)
    runs = _runs(middle, length, angle, np.frombuffer(used, dtype=bool).reshape(-1, len(middle)))
    count = np.bincount(runs)
    root = np.sqrt(count.astype(float))
    membership = np.zeros((len(count), len(middle)))
    membership[runs, np.arange(len(middle))] = 1.0 / root[runs]
    start, stop = (np.zeros(len(count)) for _ in range(2))
    first = np.searchsorted(runs, np.arange(len(count)))
    last = np.append(first[1:], len(runs)) - 1
    start, stop, angle = middle[first] - 0.5 * length, middle[last] + 0.5 * length, angle[first]
    since = 0.5 * (start + stop)
    since = since - float(count @ since) / float(count.sum())
    steps = directions(angle)
    fitted = [np.ones(len(since)), *steps.T]
    if drift == "bias" or (drift == "ambient" and not turns):
        fitted.append(since)
    elif drift == "ambient":
        fitted += [since * step for step in steps.T]
    basis, s, _ = np.linalg.svd(np.column_stack(fitted) * root[:, None], full_matrices=True)
    rank = int(np.sum(s > BALANCED * s.max()))
    left = len(count) - rank
    if left < FEWEST:
        what = f"{len(count)} block means, of which {rank} are fitted: need {FEWEST} more than that"
        why = "white and slow noise cannot be separated"
        raise DataError(what, why=why, do="Record longer", code="too_few_blocks")
    contrasts = np.asarray(basis[:, rank:].T)
    kernels = {noise: window_covariance(start, stop, noise) for noise in (FLICKER, WALK)}
    turning = np.cos(np.subtract.outer(angle, angle))
    slow, drifts = {}, []
    sources = (HEAD, AMBIENT) if turns and steps.shape[1] else (HEAD,)
    for source in sources:
        for noise, kernel in kernels.items():
            whole = (
                contrasts @ (np.outer(root, root) * (kernel * turning if source == AMBIENT else kernel)) @ contrasts.T
            )
            variances, axes = np.linalg.eigh(whole)
            variances = np.maximum(variances, 0.0)
            scale = float(variances.mean())
            slow[noise, source] = (variances / scale, np.asarray(axes), scale)
        for line in [since] if source == HEAD else [since * step for step in steps.T]:
            values = root * line
            found = contrasts @ values
            size = float(np.linalg.norm(found))
            if size > SEEN * float(np.linalg.norm(values)):
                drifts.append(_Drift(source, values / size, found / size, 1.0 / size))
    return _Pieces(start, stop, angle, root, membership, contrasts, kernels, slow, tuple(drifts))


def _runs(middle: Array, length: float, angle: Array, used: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the piece of each block: runs of one dwell without a gap, 240 of them at most."""
    apart = np.diff(middle) > length * (1.0 + SEEN)
    apart |= (np.diff(angle) != 0.0) | np.any(used[:, 1:] != used[:, :-1], axis=0)
    whole = np.append(0, np.cumsum(apart))
    size = max(int(np.ceil(len(middle) / MOST)), 1)
    while True:
        lengths = np.bincount(whole)
        parts = np.ceil(lengths / size).astype(int)
        if parts.sum() <= MOST or size >= lengths.max():
            break
        size += 1
    at = np.arange(len(middle)) - np.searchsorted(whole, whole)
    within = (at * parts[whole]) // lengths[whole]
    return np.asarray(np.append(0, np.cumsum(parts))[whole] + within, dtype=np.intp)
