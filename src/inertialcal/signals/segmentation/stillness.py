"""Rest and its disturbances: a selection from the one detector of still and moving stretches (``segments``).

A moving stretch, or a short still one at another level, counts as a disturbance if at least five of its samples lie
further from the level around it than five standard deviations of the noise at rest; a single spike is none, nor is a
slow drift. A record of which too little is still, or whose level steps too often, is not at rest.

A record of more than 16,777,216 samples is looked through in pieces of 4,194,304, each by itself (`judge_in_pieces`):
it is at rest if three quarters of its samples lie in pieces that are.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import every, known_finite, release
from ...core.estimate import Array
from ...statistics.quantiles import f_upper, t_upper
from .noise_scale import BLOCK, LIVE, LIVE_BLOCKS, QUIET, ROUNDS, of_quiet_blocks
from .segments import Detection, detect

SHORTEST = 200  # samples from which rest can be told
SIGMAS = 5.0
LONG = 0.02  # part of the record from which a still stretch is rest and not part of a disturbance
FEWEST = 5  # samples of a disturbance
STILL_SHARE = 0.75  # least part of a record at rest that is still
MOST_STEPS = 3  # of the level
WHOLE = 2**24  # samples: a longer record is looked through in pieces ...
PIECE = 2**22  # ... of so many
PLAN = Detection(false_alarm=1e-3)


@dataclass(frozen=True)
class Disturbance:
    """First and last sample, and the largest deviation in standard deviations of the noise."""

    first: int
    last: int
    peak: float


@dataclass(frozen=True)
class Stillness:
    """Whether a channel is at rest at all, and where it is disturbed.

    ``widening`` is by how much more than white noise the means of its widest windows scatter.
    """

    at_rest: bool
    disturbances: tuple[Disturbance, ...]
    widening: float = 1.0


def judge(values: Array, floor: float = 0.0) -> Stillness | None:
    """Return where a channel is disturbed, or None where it is too short to tell.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Finite, evenly sampled, in any unit.
    floor : float
        Smallest standard deviation that the noise may have: the resolution step.
    """
    if len(values) < SHORTEST:
        return None
    found = detect(values, plan=PLAN)
    sigma = max(float(found.noise.scale[0]), floor)
    length = found.stop - found.start
    still = np.flatnonzero(found.still & (length >= LONG * len(values)))
    hidden = bool(found.noise.step[0] > 0.0 and not found.noise.live[0])
    if sigma == 0.0 or (hidden and floor == 0.0):
        return None
    widening = float(found.widening[0])
    if not len(still):
        return Stillness(False, (), widening)
    # Noise that is not white scatters more over a long stretch than over the few samples that its scale is told from.
    sigma = max(sigma, float(np.sqrt(np.average(found.scatter[still, 0] ** 2, weights=length[still]))))
    level = np.interp(np.arange(len(found)), still, found.level[still, 0])
    disturbances = []
    for i in np.setdiff1d(np.arange(len(found)), still):
        far = np.abs(values[found.start[i] : found.stop[i]] - level[i])
        if np.sum(far > SIGMAS * sigma) >= FEWEST:
            disturbances.append(Disturbance(int(found.start[i]), int(found.stop[i]) - 1, float(far.max()) / sigma))
    steps = int(np.sum(np.abs(np.diff(found.level[still, 0])) > SIGMAS * sigma))
    share = float(np.sum(length[still])) / len(values)
    return Stillness(share >= STILL_SHARE and steps <= MOST_STEPS, tuple(disturbances), widening)


def surely_still(values: Array) -> bool:
    """Return whether `judge` finds a channel at rest and undisturbed, or nothing to tell: one look, no search.

    It need not say so: where the noise is not white, or anything stands out, only the search tells.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Evenly sampled, in any unit.
    """
    from ._kernels_levels import is_still  # noqa: PLC0415 - numba starts slowly

    if len(values) < SHORTEST:
        return True
    limit, usual = of_quiet_blocks()
    away, loud = _least_limits(len(values))
    most = (LIVE_BLOCKS, QUIET, usual, limit)
    return bool(is_still(values, BLOCK, LIVE, most, ROUNDS, away, len(PLAN.scales), PLAN.shortest, loud))


@lru_cache(8)
def _least_limits(n: int) -> tuple[float, float]:
    """Return the limits of ``still_stretches`` for n samples, of levels and of variances, for a noise that is known."""
    tail = 0.5 * PLAN.false_alarm / n
    return float(t_upper(tail / (2.0 * (len(PLAN.scales) + 1)), np.inf)), float(
        f_upper(tail, PLAN.shortest - 1.0, np.inf)
    )


def judge_in_pieces(x: NDArray[Any], floor: float = 0.0) -> Stillness | None:
    """Return where a channel of any length is disturbed, or None where all its pieces are too short to tell.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Evenly sampled, in any unit; samples that are not finite are left out.
    floor : float
        As `judge` takes it.
    """
    placed: list[Disturbance] = []
    judged = still = 0
    widening = 0.0
    size = PIECE if len(x) > WHOLE else max(len(x), 1)
    for first in range(0, len(x), size):
        part = np.asarray(x[first : first + size], dtype=np.float64)
        whole = known_finite(part) or every(part, lambda own: np.isfinite(own).all())
        good = np.arange(0) if whole else np.isfinite(part)
        rest = judge(part if whole else part[good], floor)
        release(x[first : first + size])
        if rest is None:
            continue
        count = len(part) if whole else int(np.count_nonzero(good))
        judged, still, widening = judged + count, still + count * rest.at_rest, max(widening, rest.widening)
        rows = np.flatnonzero(good) if rest.disturbances and not whole else np.arange(0)
        for one in rest.disturbances:
            at = (one.first, one.last) if whole else (int(rows[one.first]), int(rows[one.last]))
            placed.append(Disturbance(first + at[0], first + at[1], one.peak))
    return Stillness(still >= STILL_SHARE * judged, tuple(placed), widening) if judged else None
