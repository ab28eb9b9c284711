"""Budget of the amplitude by Monte Carlo (JCGM 101), and its comparison with the linear one.

Every piece is displaced anew in each draw, as a point whose field is scaled at each stop by what the true cuboid has
over a point there. All doubts are normal.

The densities of the pieces enter as a weighted sum. Given all else in a draw that sum is normal, with the squares of
what the pieces add for its variance, whatever places and angles were drawn: one normal number has its exact law, and
stands for one a piece.

Draws are made in chunks, each from a generator of its own that the caller's seeds. What comes out does not depend on
how many processors there are.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count

import numpy as np
from scipy.spatial.transform import Rotation

from ...core.errors import UsageError
from ...core.estimate import Array, Component, Estimate
from ...core.results import Interval
from ...statistics.propagate import Comparison, MonteCarlo, compare
from . import _kernels
from .linear import NAME, linear_budget
from .source import Doubts, Source

DRAWS = 10_000
FEWEST = 2
AT_ONCE = 200  # draws a chunk: 4 MB of 900 pieces
SEEDS = 2**63
P = 0.95


def monte_carlo_budget(source: Source, doubts: Doubts, rng: np.random.Generator, draws: int = DRAWS) -> MonteCarlo:
    """Return draws of the amplitude [m/s^2], with their mean, standard deviation and 95 % interval.

    Parameters
    ----------
    source : Source
        What is moved.
    doubts : Doubts
        What is known of it.
    rng : numpy.random.Generator
        Of the draws.
    draws : int
        How many.

    Raises
    ------
    UsageError
        If there are too few for a standard deviation.
    """
    if draws < FEWEST:
        raise UsageError(f"{draws} draws: {FEWEST} or more are needed for a standard deviation", code="too_few_draws")
    chunk = _chunk(source, doubts)
    starts = range(0, draws, AT_ONCE)
    seeds = rng.integers(SEEDS, size=len(starts))
    sizes = [min(AT_ONCE, draws - start) for start in starts]
    with ThreadPoolExecutor(cpu_count()) as pool:
        found = np.concatenate(list(pool.map(chunk, seeds, sizes)))
    variance = Component("draws", "B", np.array([[np.var(found, ddof=1)]]), math.inf)
    estimate = Estimate((NAME,), np.array([np.mean(found)]), ("m/s^2",), (variance,))
    lo, hi = np.quantile(found, [0.5 - P / 2.0, 0.5 + P / 2.0])
    return MonteCarlo(estimate, (Interval(float(lo), float(hi), P),), found[:, None])


def compared(source: Source, doubts: Doubts, drawn: MonteCarlo) -> Comparison:
    """Return whether the linear budget can be used: both 95 % intervals agree to a digit of u (JCGM 101, clause 8).

    Parameters
    ----------
    source : Source
        What is moved.
    doubts : Doubts
        What is known of it.
    drawn : MonteCarlo
        From `monte_carlo_budget`.
    """
    return compare(linear_budget(source, doubts), drawn, digits=1)[0]


def _chunk(source: Source, doubts: Doubts) -> Callable[[int, int], Array]:
    """Make a function of a seed and a number of draws that returns amplitudes, shape (draws,)."""
    centres, density = source.body.cells
    mass = density * math.prod(source.body.edges) * source.gravitational_constant
    across = np.ascontiguousarray(centres.T), mass, np.ascontiguousarray(_shape(source, centres).T)
    axis, direction, place = np.array(source.axis), np.array(source.direction), np.array(doubts.place)

    def drawn(seed: int, n: int) -> Array:
        rng = np.random.default_rng(seed)
        common = 1.0 + doubts.density * rng.standard_normal(n) + doubts.gravitational_constant * rng.standard_normal(n)
        weighed = doubts.piece_density * rng.standard_normal(n)
        stops = doubts.stop * rng.standard_normal((n, 2, 1)) * direction
        places = source.shifts + stops + place * rng.standard_normal((n, 1, 3))
        turns = _rotations(doubts.angle * rng.standard_normal((n, 3)))
        moved = rng.standard_normal((n, 3, len(mass)))
        moved *= doubts.piece_place
        found = np.empty((n, 2))
        _kernels.amplitudes(*across, places, turns, axis, moved, found)
        return common * (found[:, 0] + weighed * found[:, 1])

    return drawn


def _shape(source: Source, centres: Array) -> Array:
    """Field of each cuboid along the axis over that of a point, at both stops, shape (n, 2); 1 where it is across."""
    at = np.nonzero(source.body.density)
    axis = np.array(source.axis)
    found = np.ones((len(centres), 2))
    for stop, shift in enumerate(source.shifts):
        true = source.body.each(-shift)[at] @ axis
        away = centres + shift
        point = math.prod(source.body.edges) * (away @ axis) / np.linalg.norm(away, axis=1) ** 3
        largest = np.abs(point).max()
        clear = np.abs(point) > 1e-6 * largest
        found[clear, stop] = true[clear] / point[clear]
    return found


def _rotations(turn: Array) -> Array:
    """Rotation matrices of small turns about x, y and z, shape (n, 3, 3): exact for each length and direction."""
    return np.ascontiguousarray(Rotation.from_rotvec(turn).as_matrix())
