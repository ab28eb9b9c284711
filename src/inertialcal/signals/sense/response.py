"""Changes of the response of a record to what was applied: the slope of each channel against it, before and after."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np

from ...core.estimate import Array
from ..time.samples import Indices
from .change import Change, Factors, unit_of
from .jumps import FEWEST, SIDE
from .noise import SAME_NOISE, Noise

SAME_RESPONSE = 1.5  # factor up to which a response is the same: saturation, lag and nonlinearity change it
EXPLAINED = 4.0  # times that two responses explain more than one
EXCHANGED = 20.0  # gain of logarithmic likelihood by an exchange, as for white noise (16: one of 3,600 clean records)
EXPLAINS = 0.8  # of the gain by any change of levels and responses
ALIKE = 0.97  # of the largest gain
LEAST_PART = 0.05  # of the record before and after
FEWEST_BLOCKS = 6  # by whose means the colour of what is left is told


def by_response(x: Array, applied: Array, noise: Noise, names: Sequence[str], factors: Factors) -> list[Change]:
    """Return the change of the slope of the readings against the applied quantity."""
    found = response_change(x, applied)
    if found is None or not np.any(found[1]):
        return []
    index, before, after = found
    axis = int(np.argmax(np.abs(before)))
    own = float(after[axis] / before[axis])
    other = int(np.argmax(np.abs(after)))
    if other != axis and abs(own) < 0.5 and abs(after[other] / before[axis]) > 1.0 / SAME_RESPONSE:
        order = _simplest(len(names), axis, other)
        return [Change("axes_changed", index, tuple(names), 1.0, None, tuple(names[i] for i in order))]
    if 1.0 / SAME_RESPONSE < -own < SAME_RESPONSE:
        return [Change("sign_changed", index, tuple(names), -1.0)]
    unit = unit_of(own, factors, 0.1)
    if unit is not None:
        return [Change("unit_changed", index, tuple(names), unit[0], unit[1])]
    ratio = noise.ratio(min(max(index // noise.size, 1), len(noise.log) - 1))
    if own > 0.0 and abs(np.log(own)) > np.log(SAME_RESPONSE) and abs(ratio[axis] - np.log(own)) < SAME_NOISE:
        return [Change("scale_changed", index, tuple(names), own)]
    return []


def _simplest(k: int, axis: int, other: int) -> tuple[int, ...]:
    """Return the exchange of the fewest axes after which one axis shows in the column of another."""
    order = list(range(k))
    order[axis], order[other] = other, axis
    return tuple(order)


def exchanged_response(x: Array, applied: Array, names: Sequence[str]) -> Change | None:
    """Return an exchange of axes that explains levels and responses: it shows without a jump, too.

    With the columns put back from a sample on, a level, a drift and one response explain each channel; how much better
    than without is counted in likelihoods, for each sample and each exchange.
    """
    n, k = x.shape
    spread = float(np.ptp(applied))
    if n < FEWEST or k < 2 or not spread > 0.0:
        return None
    terms, _ = np.linalg.qr(np.column_stack([np.ones(n), applied / spread, np.linspace(-1.0, 1.0, n)]))
    y = x - x.mean()
    edge = max(SIDE[0], round(LEAST_PART * n))
    cuts: Indices = np.arange(edge, n - edge)
    sums = [np.cumsum(one, axis=0) for one in (y * y, *(term[:, None] * y for term in terms.T))]
    parts = [(one[cuts - 1], one[-1] - one[cuts - 1]) for one in sums]  # before and after each cut
    least = 1e-12 * float(sums[0][-1].sum())
    if not least > 0.0:
        return None

    def loss(order: Sequence[int]) -> Array:
        """Return the sum of squares of each channel, shape (cuts, channels), with columns put back after each cut."""
        square, *products = [before + after[:, order] for before, after in parts]
        found: Array = np.maximum(square - sum(one**2 for one in products), least)
        return found

    same = loss(tuple(range(k)))[0]
    found: list[tuple[float, int, tuple[int, ...]]] = []
    for order in permutations(range(k)):
        if order != tuple(range(k)):
            gains = 0.5 * n * np.log(same / loss(order))
            best = int(np.argmax(gains.sum(axis=1)))
            found.append((float(gains[best].sum()), best, order))
    most = max(one[0] for one in found)
    if most < EXCHANGED:
        return None
    # Of those that explain as well, that of the fewest axes
    gain, best, order = min((one for one in found if one[0] > ALIKE * most), key=lambda one: (_moved(one[2]), -one[0]))
    index = int(cuts[best])
    moved = [i for i in range(k) if order[i] != i]
    sets = [np.linalg.lstsq(terms[part], y[part][:, moved], rcond=None)[0] for part in (slice(index), slice(index, n))]
    rest = np.concatenate([y[:index, moved] - terms[:index] @ sets[0], y[index:, moved] - terms[index:] @ sets[1]])
    free = np.maximum(np.sum(rest**2, axis=0), least)
    whole = float(np.sum(0.5 * n * np.log(same[moved] / free)))
    added = np.cumsum(rest, axis=0)
    colour = 1.0
    for size in {max(2, round(np.sqrt(n))), min(index, n - index, n // FEWEST_BLOCKS)}:  # of dwells, too
        means = (added[size:] - added[:-size]) / size
        with np.errstate(divide="ignore", invalid="ignore"):
            colour = float(np.nanmax(np.append(size * means.var(axis=0) / rest.var(axis=0), colour)))
    if gain < EXCHANGED * colour or gain < EXPLAINS * whole:
        return None
    return Change("axes_changed", index, tuple(names), 1.0, None, tuple(names[order.index(i)] for i in range(k)))


def _moved(order: Sequence[int]) -> int:
    """Return how many axes an exchange moves."""
    return sum(i != j for i, j in enumerate(order))


def response_change(x: Array, applied: Array) -> tuple[int, Array, Array] | None:
    """Return where the response to an applied quantity changes most, and the slopes before and after.

    None where one response explains the record as well.

    Parameters
    ----------
    x : ndarray, shape (n, channels)
        Readings.
    applied : ndarray, shape (n,)
        What was applied.
    """
    n = len(x)
    spread = float(np.ptp(applied))
    if n < FEWEST or not spread > 0.0:
        return None
    r = (applied - applied.mean()) / spread
    y = x - x.mean(axis=0)
    sums = [np.cumsum(one, axis=0) for one in (np.ones(n), r, r * r, y, r[:, None] * y, y * y)]
    edge = max(SIDE[0], round(LEAST_PART * n))
    cuts: Indices = np.arange(edge, n - edge)
    sse, slopes = [], []
    for part in (0, 1):
        c, sr, srr, sy, sry, syy = (one[cuts - 1] if part == 0 else one[-1] - one[cuts - 1] for one in sums)
        moment = srr - sr**2 / c
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = (sry - sr[:, None] * sy / c[:, None]) / moment[:, None]
        usable = moment > 0.01 * c * float(np.var(r))
        slope = np.where(usable[:, None], slope, np.nan)
        sse.append(syy - sy**2 / c[:, None] - slope**2 * moment[:, None])
        slopes.append(slope)
    whole = r @ y / (r @ r)
    all_sse = np.sum((y - np.outer(r, whole)) ** 2)
    two = np.sum(sse[0] + sse[1], axis=1)
    if not np.isfinite(two).any():
        return None
    best = int(np.nanargmin(two))
    if all_sse <= EXPLAINED * max(float(two[best]), 0.0):
        return None
    return int(cuts[best]), slopes[0][best] / spread, slopes[1][best] / spread
