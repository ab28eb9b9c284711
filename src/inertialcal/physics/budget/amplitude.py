"""Budget of the amplitude by its slopes (GUM): each doubt times the slope of the amplitude to it.

Shifting the body by a small ``e`` changes the field by ``-gradient e``. Turning it by ``w`` about the origin of its
frame turns the field with it, while the proof mass, seen from the body, turns back. At the shift s, with field and
gradient at ``-s`` in the frame of the body, the change is::

    w x g - gradient (w x (-s))

Pieces are taken as points for the slopes to their own places: these are shares of the whole, and a per cent of them is
nothing to an uncertainty.

Budget of the amplitude by Monte Carlo (JCGM 101), and its comparison with the linear one.

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
from dataclasses import dataclass
from os import cpu_count

import numpy as np

from ...core.errors import UsageError
from ...core.estimate import Array, Component, Estimate
from ...core.results import Interval
from ...statistics.propagate import Comparison, MonteCarlo, compare
from . import _kernels
from .source import Doubts, Source

NAME = "amplitude"
DRAWS = 10_000
FEWEST = 2
AT_ONCE = 200  # draws a chunk: 4 MB of 900 pieces
SEEDS = 2**63
P = 0.95


@dataclass(frozen=True)
class Share:
    """What one doubt adds."""

    name: str  # which
    u: float  # standard uncertainty of the amplitude from it [m/s^2]


def shares(source: Source, doubts: Doubts) -> tuple[Share, ...]:
    """Return what each doubt adds to the uncertainty of the amplitude.

    Parameters
    ----------
    source : Source
        What is moved.
    doubts : Doubts
        What is known of it.
    """
    return _amplitude_and_shares(source, doubts)[1]


def linear_budget(source: Source, doubts: Doubts) -> Estimate:
    """Return the amplitude [m/s^2] with a component for each doubt (JCGM 100:2008, 5.1.2).

    Parameters
    ----------
    source : Source
        What is moved.
    doubts : Doubts
        What is known of it.
    """
    amplitude, found = _amplitude_and_shares(source, doubts)
    parts = tuple(Component(one.name, "B", np.array([[one.u**2]]), math.inf) for one in found)
    return Estimate((NAME,), np.array([amplitude]), ("m/s^2",), parts)


def _amplitude_and_shares(source: Source, doubts: Doubts) -> tuple[float, tuple[Share, ...]]:
    """Amplitude, and what each doubt adds, from one look at the field."""
    G, axis, shifts = source.gravitational_constant, np.array(source.axis), source.shifts
    field, gradient = source.body.field(-shifts), source.body.gradient(-shifts)
    rows = axis @ gradient  # slope of each stop's field to the place of the point
    half = np.array([0.5, -0.5])
    amplitude = G * float(half @ (field @ axis))
    stops = G * half * (rows @ np.array(source.direction))
    place = G * half @ rows
    angles = G * half @ _turned(axis, field, rows, shifts)
    per_piece, moved = _pieces(source, axis, shifts)
    found = {
        "gravitational constant": doubts.gravitational_constant * amplitude,
        "density": doubts.density * amplitude,
        "density of pieces": doubts.piece_density * per_piece,
        "places of pieces": doubts.piece_place * moved,
        **{f"place {name}": u * slope for name, u, slope in zip("xyz", doubts.place, place, strict=True)},
        **{f"stop {k + 1}": doubts.stop * stops[k] for k in range(2)},
        **{f"angle about {name}": doubts.angle * slope for name, slope in zip("xyz", angles, strict=True)},
    }
    return amplitude, tuple(Share(name, abs(float(u))) for name, u in found.items() if u != 0.0)


def _turned(axis: Array, field: Array, rows: Array, shifts: Array) -> Array:
    """Slope of each stop's field to a turn of the body about each axis through the origin of its frame, shape (2, 3).

    Seen from the body, the point at -s turns back about that origin, and so does the axis; ``w x g . a = w . g x a``.
    """
    return np.cross(field, axis) + np.cross(shifts, rows)


def _pieces(source: Source, axis: Array, shifts: Array) -> tuple[float, float]:
    """Roots of the sums of squares over pieces, of what each adds to the amplitude, and of its slopes to its place."""
    centres, density = source.body.cells
    mass = density * (math.prod(source.body.edges) * source.gravitational_constant)
    amounts, slopes = _kernels.squares(centres, mass, shifts, axis)
    return math.sqrt(amounts), math.sqrt(slopes)


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
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 - heavy import, for Monte Carlo alone

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
        turns = np.ascontiguousarray(Rotation.from_rotvec(doubts.angle * rng.standard_normal((n, 3))).as_matrix())
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
