"""Attraction along a travel: how the component along the input axis changes as a mass is moved on a line.

The mass is shifted by ``position * direction``; the proof mass stays at the origin. A travel is a body, or a table of
a document: positions with fields, between which a cubic spline goes.

Drives of a moved mass: where it dwells, and what the sensor is given.

``sine`` dwells at middle, maximum, middle, minimum, as Reinel's mass did: half of the dwells say nothing of the
amplitude. ``square`` and ``ABAB`` dwell at maximum and minimum only; ``square`` stays two dwells at each, so that its
period is that of the sine, ``ABAB`` one, so that its line lies highest above slow noise.

The middle is where the field is the mean of both ends, not where the position is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import interpolate, optimize

from ...core.errors import DataError
from ...core.estimate import Array
from ..attraction.bodies import Body, slipped
from ..attraction.extended import ProofMass, mean_field

Direction = tuple[float, float, float]
LOOKED = 401  # positions that are looked through before an extreme is refined
FINE = 1e-12  # of a travel, to which positions are found
FEWEST = 4  # positions of a table, for a cubic
Kind = Literal["sine", "square", "ABAB"]
ORDER: dict[str, tuple[int, ...]] = {"sine": (0, 1, 0, -1), "square": (1, 1, -1, -1), "ABAB": (1, -1)}


@dataclass(frozen=True, eq=False)
class Travel:
    """Field along the input axis against the position of the mass."""

    field: Callable[[Array], Array]  # positions, shape (n,) [m] -> fields, shape (n,), in any one unit
    # first, last: positions that the mass can have [m]
    first: float
    last: float

    def at(self, positions: ArrayLike) -> Array:
        """Return the field at positions, in their shape.

        Raises
        ------
        DataError
            If one is outside of the travel.
        """
        given = np.asarray(positions, dtype=float)
        beyond = (given < self.first) | (given > self.last) | ~np.isfinite(given)
        if beyond.any():
            raise DataError(
                f"position {given[beyond].flat[0]:g} m is outside the rig's travel, {self.first:g} to {self.last:g} m",
                why="the field is not known there",
                code="outside_travel",
            )
        return self.field(given.ravel()).reshape(given.shape)


def travel_of_body(
    body: Body,
    direction: Direction,
    first: float,
    last: float,
    axis: Direction = (1.0, 0.0, 0.0),
    proof_mass: ProofMass | None = None,
    gravitational_constant: float = 1.0,
) -> Travel:
    """Return the travel of a body.

    Parameters
    ----------
    body : Body
        At position zero, the proof mass at the origin.
    direction : tuple of float
        Of the travel.
    first, last : float
        Ends of it [m].
    axis : tuple of float
        Input axis.
    proof_mass : ProofMass, optional
        Default: a point.
    gravitational_constant : float
        Default: one.

    Raises
    ------
    DataError
        If a direction has no length, or the ends are the same.
    """
    way, along = unit(direction, "direction"), unit(axis, "axis")
    if not (last > first and np.isfinite([first, last]).all()):
        raise DataError(f"a travel from {first:g} to {last:g} m has no length", code="no_travel")

    def field(positions: Array) -> Array:
        points = np.ascontiguousarray(-positions[:, None] * way)
        found = body.field(points) if proof_mass is None else mean_field(body, proof_mass, points)
        component: Array = gravitational_constant * found @ along
        return component

    return Travel(field, first, last)


def travel_of_table(positions: ArrayLike, fields: ArrayLike) -> Travel:
    """Return the travel that a table tells; between its rows a cubic spline.

    Parameters
    ----------
    positions : array_like, shape (n,)
        Rising [m].
    fields : array_like, shape (n,)
        In any one unit.

    Raises
    ------
    DataError
        If there are fewer than four rows, or positions do not rise.
    """
    x, y = np.asarray(positions, dtype=float), np.asarray(fields, dtype=float)
    if x.ndim != 1 or len(x) < FEWEST or x.shape != y.shape or not (np.diff(x) > 0.0).all():
        raise DataError(
            f"{x.size} positions: a travel needs {FEWEST} or more, rising, with a field each", code="no_travel"
        )
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        row = int(np.argmax(~(np.isfinite(x) & np.isfinite(y))))
        raise DataError(
            f"position {x[row]:g} with field {y[row]:g} is not finite",
            where=f"row {row + 1} of the travel",
            do="Leave the row out.",
            code="not_finite",
        )
    spline = interpolate.CubicSpline(x, y)
    return Travel(lambda at: np.asarray(spline(at), dtype=float), float(x[0]), float(x[-1]))


@dataclass(frozen=True)
class Window:
    """Part of a travel."""

    # start, end: [m]
    start: float
    end: float
    change: float  # field at the start less that at the end


def best_window(travel: Travel, length: float) -> Window:
    """Return the window of a length whose ends differ most in field.

    Parameters
    ----------
    travel : Travel
        Where.
    length : float
        Stroke of the drive [m].

    Raises
    ------
    DataError
        If the stroke is longer than the travel.
    """
    room = travel.last - travel.first - length
    if not (length > 0.0 and room >= -FINE * abs(length)):
        raise DataError(
            f"a stroke of {length:g} m does not fit the rig's travel, {travel.first:g} to {travel.last:g} m",
            do=slipped(length, travel.last - travel.first) or "Shorten the stroke, or lengthen the travel.",
            code="outside_travel",
        )

    def change(start: float) -> float:
        ends = travel.at(np.clip([start, start + length], travel.first, travel.last))
        return float(ends[0] - ends[1])

    start = _largest(lambda s: abs(change(s)), travel.first, travel.first + max(room, 0.0))
    return Window(start, start + length, change(start))


def position_of(travel: Travel, field: float, between: tuple[float, float]) -> float:
    """Return the position of a field between two positions [m].

    Raises
    ------
    DataError
        If the field does not pass the value between them.
    """
    low, high = between
    ends = travel.at([low, high]) - field
    if not ends[0] * ends[1] <= 0.0:
        raise DataError(
            f"field {field:g} does not occur between {low:g} and {high:g} m, where it goes from "
            f"{ends[0] + field:g} to {ends[1] + field:g}",
            code="outside_travel",
        )
    return float(optimize.brentq(lambda s: float(travel.at(s)) - field, low, high, xtol=FINE * abs(high - low)))


def _largest(value: Callable[[float], float], low: float, high: float) -> float:
    """Place of the largest value: looked through, then refined between the neighbours."""
    if high <= low:
        return low
    at = np.linspace(low, high, LOOKED)
    best = int(np.argmax([value(float(s)) for s in at]))
    ends = at[max(best - 1, 0)], at[min(best + 1, LOOKED - 1)]
    found = optimize.minimize_scalar(lambda s: -value(s), bounds=ends, method="bounded", options={"xatol": 1e-10})
    return max((float(found.x), float(at[best])), key=value)


def unit(given: Direction, name: str) -> Array:
    """Return the direction with length one.

    Raises
    ------
    DataError
        If it has no length.
    """
    vector = np.array(given, dtype=float)
    length = float(np.linalg.norm(vector))
    if not (length > 0.0 and np.isfinite(length)):
        raise DataError(f"{name} {given} has no length", code="no_direction")
    found: Array = vector / length
    return found


@dataclass(frozen=True, eq=False)
class Drive:
    """One cycle of positions."""

    kind: str  # name of the drive
    positions: Array  # of each dwell [m], shape (dwells,)
    fields: Array  # there, shape (dwells,)

    @property
    def amplitude(self) -> float:
        """Half of the difference of largest and smallest field."""
        return float(np.ptp(self.fields) / 2.0)

    @property
    def mean(self) -> float:
        """Mean of both."""
        return float((np.max(self.fields) + np.min(self.fields)) / 2.0)


def drive(travel: Travel, window: Window, kind: Kind) -> Drive:
    """Return the dwells of a cycle.

    Parameters
    ----------
    travel : Travel
        Field against position.
    window : Window
        Between whose ends the mass moves.
    kind : {"sine", "square", "ABAB"}
        Which drive.

    Raises
    ------
    DataError
        If the drive has no such name, or the window lies outside of the travel.
    """
    if kind not in ORDER:
        raise DataError(f"drive {kind!r} is not known: {', '.join(ORDER)}", code="unknown_drive")
    ends = travel.at([window.start, window.end])
    high, low = (window.start, window.end) if ends[0] >= ends[1] else (window.end, window.start)
    places = {1: high, -1: low}
    if 0 in ORDER[kind]:
        places[0] = position_of(travel, float(ends.mean()), (window.start, window.end))
    positions = np.array([places[step] for step in ORDER[kind]])
    return Drive(kind, positions, travel.at(positions))


def sine_of_position(window: Window, samples: int) -> Array:
    """Return positions over one period of a sinusoidal motion, shape (samples,) [m]; from the middle to the start."""
    phase = 2.0 * np.pi * np.arange(samples) / samples
    positions: Array = (window.start + window.end) / 2.0 + (window.start - window.end) / 2.0 * np.sin(phase)
    return positions


def harmonics(travel: Travel, positions: Array, count: int = 5) -> Array:
    """Return the amplitudes of the first harmonics of the field over one period of positions.

    Parameters
    ----------
    travel : Travel
        Field against position.
    positions : ndarray, shape (n,)
        Evenly in time over one period [m].
    count : int
        How many; fewer than half of n.

    Returns
    -------
    ndarray, shape (count,)
        From the first on, in the unit of the field.

    Raises
    ------
    DataError
        If there are not more than twice as many positions as harmonics.
    """
    if len(positions) <= 2 * count:
        raise DataError(
            f"{len(positions)} positions per period: {count} harmonics need {2 * count + 1}",
            code="too_few_positions",
        )
    lines = np.fft.rfft(travel.at(positions)) / len(positions)
    amplitudes: Array = 2.0 * np.abs(lines[1 : count + 1])
    return amplitudes
