"""Budget of the amplitude by Monte Carlo (JCGM 101), and its comparison with the linear one.

Every piece is displaced and weighed anew in each draw, as a point whose field is scaled at each stop by what the true
cuboid has over a point there. All doubts are normal.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import Rotation

from ...core.estimate import Array, Component, Estimate
from ...core.results import Interval
from ...statistics.propagate import Comparison, MonteCarlo, compare
from . import _kernels
from .linear import NAME, linear_budget
from .source import Doubts, Source

DRAWS = 10_000
AT_ONCE = 500  # draws whose pieces are in memory together
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
    """
    centres, density = source.body.cells
    mass = density * math.prod(source.body.edges) * source.gravitational_constant
    shape, axis = _shape(source, centres), np.array(source.axis)
    found = np.empty(draws)
    for start in range(0, draws, AT_ONCE):
        n = min(AT_ONCE, draws - start)
        common = 1.0 + doubts.density * rng.standard_normal(n) + doubts.gravitational_constant * rng.standard_normal(n)
        weighed = common[:, None] * (1.0 + doubts.piece_density * rng.standard_normal((n, len(mass))))
        moved = doubts.piece_place * rng.standard_normal((n, len(mass), 3))
        stops = doubts.stop * rng.standard_normal((n, 2, 1)) * np.array(source.direction)
        places = source.shifts + stops + np.array(doubts.place) * rng.standard_normal((n, 1, 3))
        turns = _rotations(doubts.angle * rng.standard_normal((n, 3)))
        part = found[start : start + n]
        _kernels.amplitudes(centres, mass, shape, np.ascontiguousarray(places), turns, axis, weighed, moved, part)
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
