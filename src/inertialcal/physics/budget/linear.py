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
from .source import Doubts, Source

NAME = "amplitude"


@dataclass(frozen=True)
class Share:
    """What one doubt adds.

    Parameters
    ----------
    name : str
        Which.
    u : float
        Standard uncertainty of the amplitude from it [m/s^2].
    """

    name: str
    u: float


def shares(source: Source, doubts: Doubts) -> tuple[Share, ...]:
    """Return what each doubt adds to the uncertainty of the amplitude.

    Parameters
    ----------
    source : Source
        What is moved.
    doubts : Doubts
        What is known of it.
    """
    G, axis, shifts = source.gravitational_constant, np.array(source.axis), source.shifts
    amplitude = source.amplitude
    field, gradient = source.body.field(-shifts), source.body.gradient(-shifts)
    rows = np.einsum("i,sij->sj", axis, gradient)  # slope of each stop's field to the place of the point
    half = np.array([0.5, -0.5])
    stops = G * half * (rows @ np.array(source.direction))
    place = G * np.sum(half[:, None] * rows, axis=0)
    angles = [G * _turned(one, axis, field, rows, shifts) for one in np.eye(3)]
    per_piece, moved = _pieces(source)
    found = {
        "gravitational constant": doubts.gravitational_constant * amplitude,
        "density": doubts.density * amplitude,
        "density of pieces": doubts.piece_density * math.sqrt(float(np.sum(per_piece**2))),
        "places of pieces": doubts.piece_place * math.sqrt(float(np.sum(moved**2))),
        **{f"place {name}": u * slope for name, u, slope in zip("xyz", doubts.place, place, strict=True)},
        **{f"stop {k + 1}": doubts.stop * stops[k] for k in range(2)},
        **{f"angle about {name}": doubts.angle * slope for name, slope in zip("xyz", angles, strict=True)},
    }
    return tuple(Share(name, abs(float(u))) for name, u in found.items() if u != 0.0)


def linear_budget(source: Source, doubts: Doubts) -> Estimate:
    """Return the amplitude [m/s^2] with a component for each doubt (JCGM 100:2008, 5.1.2).

    Parameters
    ----------
    source : Source
        What is moved.
    doubts : Doubts
        What is known of it.
    """
    parts = tuple(Component(one.name, "B", np.array([[one.u**2]]), math.inf) for one in shares(source, doubts))
    return Estimate((NAME,), np.array([source.amplitude]), ("m/s^2",), parts)


def _turned(w: Array, axis: Array, field: Array, rows: Array, shifts: Array) -> float:
    """Slope of the amplitude to a turn w of the body about the origin of its frame, for a constant of one.

    Seen from the body, the point at -s turns back about that origin, and so does the axis.
    """
    changed = np.cross(w, field) @ axis - np.einsum("sj,sj->s", rows, np.cross(w, -shifts))
    return float(changed[0] - changed[1]) / 2.0


def _pieces(source: Source) -> tuple[Array, Array]:
    """Amounts that pieces add to the amplitude (n,), and its slopes to their places (n, 3)."""
    centres, density = source.body.cells
    mass = density * math.prod(source.body.edges) * source.gravitational_constant
    axis = np.array(source.axis)
    amount, slope = np.zeros(len(mass)), np.zeros((len(mass), 3))
    for sign, shift in zip((0.5, -0.5), source.shifts, strict=True):
        away = centres + shift
        r_2 = np.einsum("ij,ij->i", away, away)
        along = away @ axis
        w = sign * mass / (r_2 * np.sqrt(r_2))
        amount += w * along
        slope += w[:, None] * (axis - (3.0 * along / r_2)[:, None] * away)
    return amount, slope
