"""What a figure of a lot depends on besides the unit: its station, its place in the chamber, when it was made.

*Levels* (stations, chamber positions, operators). The mean of each level is set against the others. Levels may differ
by what units scatter, ``S^2 / n_g``, and by what the standards of each are stated to be uncertain by (``common``);
what is beyond is a level that is off. The one farthest off is named, taken out, and the rest judged again (a
generalized extreme studentized deviate test [1]_), each step at a probability of 5 % over all levels and over all
figures that are judged together (Bonferroni), so that a lot in which nothing is off names any level in at most 5 %, by
Student's t: of a few units at each level S is hardly known. Of two levels none can be told to be the wrong one: both
are named. Without a stated size the normal scores of ranks are judged (van der Waerden), so that heavy tails make no
finding. Before stations are set against each other the line along the lot (below) is taken off: a drift would count as
scatter of units, or as a station that tested late ones. Of such stations the uncertainty of the slope counts too
(``in_step``).

*Along the lot*: the slope against time, or against the number of the unit. Units are taken in ``BLOCKS`` blocks,
whose means a line is fitted to: a mean that wanders from block to block widens the uncertainty of the slope, so that
a drift is one only where the line stands out from that.

References
----------
.. [1] B. Rosner, Technometrics 25 (1983) 165-172.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.estimate import Array

P = 0.05  # of a false alarm in a lot, for each kind of finding
BLOCKS = 40  # along a lot, at most
LEAST = 5  # units in a block, and blocks of a line
ROUNDING = 1e-12  # of a figure: one that scatters less is the same for all units
HALF = 0.5  # of the levels that may be off, at most


@dataclass(frozen=True)
class Level:
    """One level of a factor, against the others.

    Parameters
    ----------
    number : int
        Of the level.
    n : int
        Units.
    mean : float
        Of their figures, as they were given.
    offset, u : float
        How far it lies from the mean of the levels that are not off, and the standard uncertainty of that by the
        scatter of units alone: of a level that is off with that of the others.
    allowed : float
        Standard deviation that is stated for such differences: standards and units together.
    p : float
        Probability of so far a level in a lot where none is off, over all levels and figures; 1 if beyond.
    off : bool
        Whether it is named.
    """

    number: int
    n: int
    mean: float
    offset: float
    u: float
    allowed: float
    p: float
    off: bool


def levels(
    values: Array,
    at: NDArray[np.intp],
    common: float,
    figures: int = 1,
    spent: int = 0,
    in_step: Array | None = None,
) -> list[Level]:
    """Return the levels of a factor that have units.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Figures of units.
    at : ndarray of int, shape (n,)
        Level of each, from 0 on.
    common : float
        Standard uncertainty of what all units of one level share, drawn anew for each level.
    figures : int
        How many figures are judged together.
    spent : int
        Degrees of freedom that were taken off the figures before: where means of stations were, one for each but one.
    in_step : ndarray, shape (n,), optional
        Standard uncertainty of each figure by what was taken off all of them in proportion to it, such as a drift: they
        are all off together, each with the sign that it has here.
    """
    sizes = np.bincount(at)
    known = np.flatnonzero(sizes)
    n = sizes[known].astype(np.float64)
    means = np.bincount(at, values)[known] / n
    free = values.size - known.size - spent
    rest = values - (np.bincount(at, values) / np.maximum(sizes, 1))[at]
    square = float(rest @ rest) / max(free, 1)
    if known.size < 2 or free < 1 or not square > (ROUNDING * float(np.abs(values).max())) ** 2:
        return [Level(int(k), int(m), float(v), 0.0, math.nan, math.nan, 1.0, False)
                for k, m, v in zip(known, n, means, strict=True)]  # fmt: skip
    moved = np.zeros(known.size) if in_step is None else np.bincount(at, in_step)[known] / n
    fixed = square / n + common**2
    told, spread = (means, fixed) if common else _scored(values, at, n, free)
    told_moved = moved if common else moved / math.sqrt(square)
    most = square * free / float(special.chdtri(free, 1.0 - P / figures)) / n  # that may be behind what is seen
    seen = most / (most + common**2) if common else np.ones(known.size)
    kept = np.ones(known.size, dtype=bool)
    p_of = np.ones(known.size)
    while kept.sum() >= max(2, math.ceil(known.size * HALF)):
        own = np.flatnonzero(kept)
        z, share = np.array([_distance(told, spread, seen, told_moved, own, int(k)) for k in own]).T
        worst = int(np.argmax(z))
        chance = 2.0 * special.stdtr(free / share[worst] ** 2, -z[worst])
        p = min(1.0, float(chance) * own.size * figures)
        named = own if own.size == 2 else own[[worst]]
        p_of[named] = p
        if p >= P:
            break
        kept[named] = False
    chosen = np.flatnonzero(kept) if kept.any() else np.arange(known.size)
    weights = 1.0 / fixed[chosen]
    centre = float(weights @ means[chosen]) / float(weights.sum())
    found = []
    for i, k in enumerate(known):
        beside = i not in chosen  # else it is one of those that it is set against
        others = 1.0 / float(weights.sum()) if beside else 0.0
        scatter = float(weights**2 @ (square / n[chosen])) * others**2
        line = (moved[i] - float(weights @ moved[chosen]) / float(weights.sum())) ** 2 if beside else moved[i] ** 2
        u, allowed = math.sqrt(square / n[i] + scatter + line), math.sqrt(fixed[i] + others + line)
        found.append(
            Level(int(k), int(n[i]), float(means[i]), float(means[i]) - centre, u, allowed, float(p_of[i]),
                  not bool(kept[i]))
        )  # fmt: skip
    return found


def _scored(values: Array, at: NDArray[np.intp], n: Array, free: int) -> tuple[Array, Array]:
    """Return means of normal scores and their variances: they are right for any population."""
    scores = normal_scores(values)
    sizes = np.bincount(at)
    means = np.bincount(at, scores) / np.maximum(sizes, 1)
    rest = scores - means[at]
    return means[sizes > 0], float(rest @ rest) / free / n


def normal_scores(values: Array) -> Array:
    """Return the normal deviates of ranks."""
    ranks = np.empty(values.size)
    ranks[np.argsort(values, kind="stable")] = np.arange(values.size)
    return np.asarray(special.ndtri((ranks + 0.5) / values.size))


def _distance(
    means: Array, fixed: Array, seen: Array, moved: Array, own: NDArray[np.intp], k: int
) -> tuple[float, float]:
    """Return how far a level lies from the others, in standard deviations of that; what part of its variance is seen.

    The rest is what standards state, which is known: the degrees of freedom are those of what is seen, over the square
    of its part (Welch and Satterthwaite). Of few units that part is taken as large as it may be.
    """
    others = own[own != k]
    weights = 1.0 / fixed[others]
    weights = weights / float(weights.sum())
    parts = np.array([fixed[k], weights**2 @ fixed[others], (moved[k] - weights @ moved[others]) ** 2])
    far = abs(float(means[k] - weights @ means[others])) / math.sqrt(float(parts.sum()))
    return far, float(parts @ [seen[k], weights @ seen[others], 1.0] / parts.sum())


@dataclass(frozen=True)
class Along:
    """How a figure changes along a lot.

    Parameters
    ----------
    slope, u : float
        Per unit of the place, and its standard uncertainty.
    dof : int
        Degrees of freedom of that.
    change : float
        From the first unit to the last, by the slope.
    p : float
        Probability of such a slope where there is none, over all figures judged together.
    wanders : bool
        Whether blocks differ by more than their units explain, beside the line.
    """

    slope: float
    u: float
    dof: int
    change: float
    p: float
    wanders: bool

    @property
    def drifts(self) -> bool:
        """Whether the lot drifts; a mean that wanders is told as that."""
        return self.p < P and not self.wanders


def along(values: Array, place: Array, at: NDArray[np.intp] | None = None, figures: int = 1) -> Along | None:
    """Return the change of a figure along a lot; None where too few units say where they stand.

    Parameters
    ----------
    values, place : ndarray, shape (n,)
        Figure of each unit, and when it was made, or its number.
    at : ndarray of int, shape (n,), optional
        Station of each: each has a mean of its own.
    figures : int
        How many figures are judged together.
    """
    groups = np.zeros(values.size, dtype=np.intp) if at is None else at
    order = np.argsort(place, kind="stable")
    y, x, g = values[order], place[order], groups[order]
    count = min(BLOCKS, y.size // LEAST)
    if count < LEAST or not x[-1] > x[0]:
        return None
    span = float(x[-1] - x[0])
    t = (x - x.mean()) / span
    sizes = np.maximum(np.bincount(g), 1)
    y, t = (one - (np.bincount(g, one) / sizes)[g] for one in (y, t))  # a station that began late makes no slope
    if not float(t @ t) > 0.0:
        return None
    slope = float(t @ y) / float(t @ t)
    rest = y - slope * t
    block = (np.arange(y.size) * count) // y.size
    n = np.bincount(block)
    score = np.bincount(block, t * rest)  # a sandwich over blocks: units of a block may be alike
    lost = 1 + int(np.count_nonzero(np.bincount(g)))
    dof = max(count - 2, 1)
    inflate = count / dof
    u = math.sqrt(inflate * float(score @ score)) / float(t @ t)
    plain = math.sqrt(float(rest @ rest) / max(y.size - lost, 1) / float(t @ t))
    u = max(u, plain)
    if not u:
        return None
    p = min(1.0, 2.0 * float(special.stdtr(dof, -abs(slope) / u)) * figures)
    means = np.bincount(block, rest) / n
    within = rest - means[block]
    inner = float(within @ within) / max(y.size - count, 1)
    ratio = float(n @ means**2) / dof / inner if inner else 0.0
    far = float(special.fdtrc(dof, max(y.size - count, 1), ratio)) * figures < P if ratio else False
    return Along(slope / span, u / span, dof, slope, p, far)
