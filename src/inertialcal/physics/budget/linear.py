"""Budget of the amplitude by its slopes (GUM): each doubt times the slope of the amplitude to it.

Shifting the body by a small ``e`` changes the field by ``-gradient e``. Turning it by ``w`` about the origin of its
frame turns the field with it, while the proof mass, seen from the body, turns back. At the shift s, with field and
gradient at ``-s`` in the frame of the body, the change is::

    w x g - gradient (w x (-s))

Pieces are taken as points for the slopes to their own places: these are shares of the whole, and a per cent of them is
nothing to an uncertainty.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array, Component, Estimate
from . import _kernels
from .source import Doubts, Source

NAME = "amplitude"


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
