"""Changes of level in a long record of several channels, each with its time, its length and its size, by likelihood.

The level of each channel follows a random walk under white noise, both of unknown size, and changes by so much at a few
times. All channels change together, each by its own size, in the course of a body that is turned smoothly from one
position to another. How far the level wanders by itself is estimated with the changes (maximum likelihood through the
Kalman filter [1]_), so that a walk, slow noise or a drift is not cut into steps. Where a change may lie is seen by the
auxiliary residuals of the smoother [2]_: the score of a step at each sample, over all of the record before and after.

Changes are added one by one, the noise estimated anew each time and, on a second path, kept white: changes that come
and go look like a walk until all of them are there. Of all the sets so made the one of greatest likelihood stays, less
``PENALTY`` a change. Every change of it raises twice the logarithm of the likelihood by twice that.

References
----------
.. [1] P. de Jong, Annals of Statistics 19 (1991) 1073: the diffuse Kalman filter; regressors go through it as data do.
.. [2] P. de Jong and J. Penzer, J. Am. Stat. Assoc. 93 (1998) 796; A. Harvey and S. J. Koopman, J. Bus. Econ. Stat. 10
   (1992) 377: auxiliary residuals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array

PENALTY = 12.0  # of the logarithm of the likelihood: a change anywhere
AT_SPIKE = 7.0  # the same where a spike is, and the logarithm of their number
# the same of changes that go to and fro between two levels: of all of them, and of each
TO_AND_FRO, EACH, EACH_AT_SPIKE = 6.0, 6.0, 2.0
NEAR = 30.0  # most from a spike to a change that goes with it [s]
AS_LIKELY = 12.0  # of twice the logarithm of the likelihood: a place where a change may be as well
MOST = 16  # changes
WALKS = np.concatenate([[0.0], np.logspace(-8.0, 1.0, 13)])  # variance of a step of the level over the white noise's
LONGEST = 180.0  # change [s]
TIE = 1e-6  # of twice the log-likelihood: places that samples left out make alike; the first of them is taken
EDGE = 30.0  # least level before the first change and after the last [s]
APART, APART_AT_SPIKES = 150.0, 50.0  # least time between the middles of two changes [s]: anywhere, at spikes


@dataclass(frozen=True)
class Change:
    """A change of level: when it begins and ends [s]."""

    start: float
    stop: float

    @property
    def middle(self) -> float:
        """Its middle [s]."""
        return 0.5 * (self.start + self.stop)


@dataclass(frozen=True, eq=False)
class Series:
    """Means over blocks of equal length: their middles [s] (n), values (n, k), and relative variances, 0 for none.

    ``spikes``: where something else says that a change may be.
    """

    seconds: Array
    values: Array
    weight: Array
    length: float
    spikes: tuple[Change, ...] = ()

    def apart(self, one: Change, two: Change) -> bool:
        """Whether two changes are far enough apart to be two: less where each has a spike of its own."""
        between = abs(one.middle - two.middle)
        if between >= APART:
            return True
        a, b = at_spike(one, self.spikes), at_spike(two, self.spikes)
        return between >= APART_AT_SPIKES and a is not None and b is not None and a != b

    def course(self, change: Change) -> Array:
        """Return how far a change is done in each block, 0 to 1, shape (n,)."""
        whole = change.stop - change.start
        if whole <= 0.0:
            return np.clip((self.seconds - change.start) / self.length + 0.5, 0.0, 1.0)
        s = np.clip((self.seconds - change.start) / whole, 0.0, 1.0)
        return np.asarray(0.5 - 0.5 * np.cos(np.pi * s - 0.5 * np.sin(2.0 * np.pi * s)))

    def regressors(self, changes: Sequence[Change]) -> Array:
        """Return the courses of changes, and a straight line, shape (n, changes + 1)."""
        span = max(float(self.seconds[-1] - self.seconds[0]), self.length)
        line = (self.seconds - self.seconds[0]) / span
        return np.column_stack([*(self.course(one) for one in changes), line])


@dataclass(frozen=True, eq=False)
class Fit:
    """Changes with their noise: of each channel."""

    changes: tuple[Change, ...]
    likelihood: float  # logarithm
    walk: Array  # (k,), over the white noise
    sigma: Array  # (k,): of a usual block, white
    size: Array  # (changes, k)
    covariance: Array  # of the sizes of a channel, (k, changes, changes)

    @property
    def u(self) -> Array:
        """Standard uncertainties of the sizes (changes, k)."""
        variance = np.array([np.diag(one) for one in self.covariance]).T
        return np.asarray(np.sqrt(variance.reshape(len(self.changes), len(self.walk))))


@dataclass(frozen=True, eq=False)
class _White:
    """One channel and regressors, whitened for one size of the walk."""

    walk: float
    rest: Array  # data less regressors (n,)
    columns: Array  # orthonormal (n, m)
    back: Array  # triangular factor
    beta: Array
    gain: Array
    spread: Array
    variance: float
    likelihood: float


def whitened(series: Series, channel: int, regressors: Array, walk: float) -> _White:
    """Return a channel whitened, and its least-squares fit."""
    from ._kernels_local_level import fill_whitened  # noqa: PLC0415 - numba starts slowly

    columns = np.column_stack([series.values[:, channel], regressors])
    white, gain, spread = np.empty_like(columns), np.empty(len(columns)), np.empty(len(columns))
    logarithms = fill_whitened(columns, series.weight[:, channel], walk, white, gain, spread)
    own, back = np.linalg.qr(white[:, 1:])
    beta = own.T @ white[:, 0]
    rest = white[:, 0] - own @ beta
    n = max(int(np.count_nonzero(spread)), 1)
    variance = max(float(rest @ rest) / n, 1e-300)
    likelihood = -0.5 * (n * np.log(variance) + logarithms)
    return _White(walk, rest, own, back, beta, gain, spread, variance, float(likelihood))


def best_walk(series: Series, channel: int, regressors: Array, near: float) -> _White:
    """Return the channel whitened for the walk of greatest likelihood: none, or the best on the way up from one."""
    none = whitened(series, channel, regressors, 0.0)
    at = int(np.clip(np.searchsorted(WALKS, near), 1, len(WALKS) - 1))
    best = whitened(series, channel, regressors, float(WALKS[at]))
    for way in (1, -1):
        here = at
        while 1 <= here + way < len(WALKS):
            one = whitened(series, channel, regressors, float(WALKS[here + way]))
            if one.likelihood <= best.likelihood:
                break
            best, here = one, here + way
        if here != at:
            break
    return max(none, best, key=lambda one: one.likelihood)


def fitted(series: Series, changes: Sequence[Change], near: Array | None = None) -> Fit:
    """Return sizes and noise for changes at these times; ``near`` (k): walks from which to look for the best."""
    X, K = series.regressors(changes), len(changes)
    start = np.full(series.values.shape[1], 1e-3) if near is None else near
    parts = [best_walk(series, channel, X, float(walk)) for channel, walk in enumerate(start)]
    size, covariance = [], []
    for one in parts:
        inverse = np.linalg.pinv(one.back)
        size.append((inverse @ one.beta)[:K])
        covariance.append(one.variance * (inverse @ inverse.T)[:K, :K])
    return Fit(
        tuple(changes), sum(one.likelihood for one in parts), np.array([one.walk for one in parts]),
        np.sqrt([one.variance for one in parts]), np.array(size).T.reshape(K, len(parts)), np.array(covariance),
    )  # fmt: skip


def _scores(series: Series, changes: Sequence[Change], walks: Array) -> Array:
    """Return by how much twice the log-likelihood of all channels grows with a step at each block (n,)."""
    from ._kernels_local_level import fill_scores  # noqa: PLC0415 - numba starts slowly

    X = series.regressors(changes)
    total = np.zeros(len(series.seconds))
    for channel, walk in enumerate(walks):
        one = whitened(series, channel, X, float(walk))
        white = np.column_stack([one.rest, one.columns])
        score, information = np.empty_like(white), np.empty(len(white))
        fill_scores(white, one.gain, one.spread, score, information)
        free = information - np.sum(score[:, 1:] ** 2, axis=1)
        good = free > 1e-3 * np.maximum(information, 1e-300)
        total += np.where(good, score[:, 0] ** 2 / np.where(good, free * one.variance, 1.0), 0.0)
    return total


def placed(series: Series, others: Sequence[Change], start: Change, walks: Array) -> Change:
    """Return a change moved and stretched to where it explains most beside the others."""
    best = start
    for step in (4.0, 1.0):
        middles = best.middle + np.arange(-6, 7) * step * max(series.length, 1.0)
        middles = middles[(middles > series.seconds[0] + EDGE) & (middles < series.seconds[-1] - EDGE)]
        length = best.stop - best.start
        lengths = (0.0, 60.0, 150.0) if step > 1.0 else length + np.array([-45.0, -30.0, -15.0, 0.0, 15.0, 30.0])
        free = [all(series.apart(Change(m, m), one) for one in others) for m in middles]
        middles = middles[np.array(free, dtype=bool)]
        tried = [Change(m - 0.5 * d, m + 0.5 * d) for m in middles for d in lengths if 0.0 <= d <= LONGEST]
        if not tried:
            return best
        gain = gains(series, others, tried, walks)
        best = tried[int(np.flatnonzero(gain >= gain.max() - TIE)[0])]
    return best


def gains(series: Series, others: Sequence[Change], tried: Sequence[Change], walks: Array) -> Array:
    """Return by how much twice the log-likelihood grows with each of some changes beside others, shape (tried,)."""
    from ._kernels_local_level import fill_whitened  # noqa: PLC0415 - numba starts slowly

    gain = np.zeros(len(tried))
    known = series.regressors(others)
    own = np.column_stack([series.course(one) for one in tried])
    for channel, walk in enumerate(walks):
        columns = np.column_stack([series.values[:, channel], known, own])
        white, gain_, spread = np.empty_like(columns), np.empty(len(columns)), np.empty(len(columns))
        fill_whitened(columns, series.weight[:, channel], float(walk), white, gain_, spread)
        m = 1 + known.shape[1]
        basis = np.linalg.qr(white[:, 1:m])[0]
        y = white[:, 0] - basis @ (basis.T @ white[:, 0])
        z = white[:, m:] - basis @ (basis.T @ white[:, m:])
        square = np.sum(z**2, axis=0)
        product = (y @ z) ** 2 / np.where(square > 1e-12, square, np.inf)
        whole, n = float(y @ y), np.count_nonzero(spread)
        gain -= n * np.log(np.maximum(1.0 - product / max(whole, 1e-300), 1e-12))
    return gain


def find_changes(series: Series) -> Fit:
    """Return the changes of greatest likelihood, less their penalty."""
    none = fitted(series, ())
    known: dict[tuple[Change, ...], Fit] = {(): none}
    for white in (True, False):
        changes: tuple[Change, ...] = ()
        for _ in range(MOST):
            walks = np.zeros(len(none.walk)) if white else known[changes].walk
            more = _next(series, changes, walks)
            if more is None:
                break
            known[more] = fitted(series, more, known[changes].walk)
            changes = more
    changes = _at_spikes(series)
    while changes and changes not in known:
        known[changes] = fitted(series, changes)
        changes = _without_least(known[changes])

    def score(one: Fit) -> float:
        return merit(series, one)

    best = max(known.values(), key=score)
    while best.changes:  # each where it explains most, and only those that do
        moved = list(best.changes)
        for i, one in enumerate(moved):
            moved[i] = placed(series, moved[:i] + moved[i + 1 :], one, best.walk)
        moved.sort(key=lambda one: one.middle)
        best = max(best, fitted(series, moved, best.walk), key=score)
        fewer = [fitted(series, best.changes[:i] + best.changes[i + 1 :], best.walk) for i in range(len(best.changes))]
        least = max(fewer, key=score)
        if score(least) <= score(best):
            break
        best = least
    return best


def merit(series: Series, fit: Fit) -> float:
    """Return the log-likelihood of changes less their penalty: as they are, or as to and fro between two levels."""
    many = float(np.log(max(len(series.spikes), 1)))
    struck = [at_spike(one, series.spikes) is not None for one in fit.changes]
    free = fit.likelihood - sum(AT_SPIKE + many if one else PENALTY for one in struck)
    if len(fit.changes) < 2:
        return free
    X = series.regressors(fit.changes)
    signs = (-1.0) ** np.arange(len(fit.changes))
    two = np.column_stack([X[:, :-1] @ signs, X[:, -1]])
    likelihood = sum(whitened(series, c, two, float(walk)).likelihood for c, walk in enumerate(fit.walk))
    each = sum(EACH_AT_SPIKE + 0.5 * many if one else EACH for one in struck)
    return max(free, likelihood - TO_AND_FRO - each)


def at_spike(change: Change, spikes: Sequence[Change]) -> Change | None:
    """Return the nearest spike that reaches to a change, if one does."""
    near = [one for one in spikes if one.start - NEAR <= change.middle <= one.stop + NEAR]

    def off(one: Change) -> float:
        return max(abs(one.middle - change.middle) - 0.5 * (one.stop - one.start), 0.0)

    return min(near, key=off, default=None)


def likely_spikes(series: Series, fit: Fit, i: int) -> list[Change]:
    """Return the spikes that a change may go with: near it, and where it explains the level as well as where it is."""
    one = fit.changes[i]
    near = [p for p in series.spikes if p.start - NEAR <= one.middle <= p.stop + NEAR]
    tried = [Change(p.middle, p.middle) for p in near] + [Change(p.start, p.stop) for p in near]
    gain = gains(series, fit.changes[:i] + fit.changes[i + 1 :], [one, *tried], fit.walk)
    enough = gain.max() - AS_LIKELY
    return [p for k, p in enumerate(near) if max(gain[1 + k], gain[1 + len(near) + k]) >= enough]


def located(series: Series, fit: Fit, i: int) -> tuple[float, float, float, float]:
    """Return the middle of a change, its standard uncertainty, and between what it lies with 95 % [s]."""
    one = fit.changes[i]
    others = fit.changes[:i] + fit.changes[i + 1 :]
    step = max(series.length, 10.0)
    middles = one.middle + np.arange(-30, 31) * step
    middles = middles[(middles > series.seconds[0]) & (middles < series.seconds[-1])]
    tried = [Change(m - 0.5 * d, m + 0.5 * d) for m in middles for d in np.arange(0.0, LONGEST + 1.0, 20.0)]
    gain = gains(series, others, tried, fit.walk)
    likely = np.exp(0.5 * (gain - gain.max()))
    likely /= likely.sum()
    at = np.array([one.middle for one in tried])
    middle = float(likely @ at)
    u = float(np.sqrt(likely @ (at - middle) ** 2 + step**2 / 12.0))
    ends = []
    for values, p in (([one.start for one in tried], 0.025), ([one.stop for one in tried], 0.975)):
        order = np.argsort(values, kind="stable")
        place = min(int(np.searchsorted(np.cumsum(likely[order]), p)), len(order) - 1)
        ends.append(float(values[order[place]]))
    return middle, u, ends[0], ends[1]


def steps_at(series: Series, fit: Fit, at: Sequence[float] | Array) -> tuple[Array, Array]:
    """Return the steps of level at some places beside the changes, and their uncertainties (places, k)."""
    from ._kernels_local_level import fill_scores  # noqa: PLC0415 - numba starts slowly

    X = series.regressors(fit.changes)
    rows = np.clip(np.searchsorted(series.seconds, at), 0, len(series.seconds) - 1)
    size, u = (np.empty((len(rows), len(fit.walk))) for _ in range(2))
    for channel, walk in enumerate(fit.walk):
        one = whitened(series, channel, X, float(walk))
        white = np.column_stack([one.rest, one.columns])
        score, information = np.empty_like(white), np.empty(len(white))
        fill_scores(white, one.gain, one.spread, score, information)
        free = np.maximum(information - np.sum(score[:, 1:] ** 2, axis=1), 1e-300)[rows]
        size[:, channel], u[:, channel] = score[rows, 0] / free, np.sqrt(one.variance / free)
    return size, u


def _at_spikes(series: Series) -> tuple[Change, ...]:
    """Return changes in the middle of the longest spikes, those that leave a level between them."""
    found: list[Change] = []
    for one in sorted(series.spikes, key=lambda one: one.start - one.stop):
        inside = series.seconds[0] + EDGE < one.middle < series.seconds[-1] - EDGE
        if inside and len(found) < MOST and all(series.apart(one, other) for other in found):
            found.append(Change(one.middle, one.middle))
    return tuple(sorted(found, key=lambda one: one.start))


def _without_least(fit: Fit) -> tuple[Change, ...]:
    """Return the changes without that whose size is the least of its uncertainty."""
    square = np.sum((fit.size / np.maximum(fit.u, 1e-300)) ** 2, axis=1)
    i = int(np.argmin(square))
    return fit.changes[:i] + fit.changes[i + 1 :]


def _next(series: Series, changes: tuple[Change, ...], walks: Array) -> tuple[Change, ...] | None:
    """Return the changes with the one more that explains most; None where none explains enough."""
    scores = _scores(series, changes, walks)
    for one in changes:
        for i in np.flatnonzero((np.abs(series.seconds - one.middle) < APART) & (scores > PENALTY)):
            if not series.apart(Change(series.seconds[i], series.seconds[i]), one):
                scores[i] = 0.0
    scores[(series.seconds < series.seconds[0] + EDGE) | (series.seconds > series.seconds[-1] - EDGE)] = 0.0
    at = int(np.argmax(scores))
    if not scores[at] > PENALTY:
        return None
    when = float(series.seconds[at]) - 0.5 * series.length
    new = placed(series, changes, Change(when, when), walks)
    return tuple(sorted((*changes, new), key=lambda one: one.start))
