"""How near a moved mass comes to the proof mass, so that it never overlaps the instrument."""

from __future__ import annotations

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ..attraction.bodies import Lattice
from .travel import Direction, unit

LOOKED = 201  # positions along the travel


def least_distance(body: Lattice, direction: Direction, first: float, last: float) -> tuple[float, float]:
    """Return the least distance of a body's cells to the proof mass, and the position where it is [m].

    Parameters
    ----------
    body : Lattice
        At position zero, the proof mass at the origin.
    direction : tuple of float
        Of the travel.
    first, last : float
        Ends of it [m]. On a travel along an edge each cell is nearest where it is abreast; on others positions between
        the ends are looked at in steps of 1/200.
    """
    way = unit(direction, "direction")
    centres, _ = body.cells
    half = np.array(body.edges) / 2.0
    if np.count_nonzero(way) == 1 and len(centres):
        return _swept(centres, half, way, first, last)
    positions = np.linspace(first, last, LOOKED if last != first else 1)
    least = np.array([_nearest(centres + s * way, half) for s in positions])
    at = int(np.argmin(least))
    return float(least[at]), float(positions[at])


def _swept(centres: Array, half: Array, way: Array, first: float, last: float) -> tuple[float, float]:
    """Return the least distance, and its position, of cuboids moved along one of their edges; exact."""
    abreast = np.clip(-(centres @ way), first, last)
    beyond = np.maximum(np.abs(centres + abreast[:, None] * way) - half, 0.0)
    square = np.einsum("ij,ij->i", beyond, beyond)
    at = int(np.argmin(square))
    return float(np.sqrt(square[at])), float(abreast[at])


def refuse_overlap(body: Lattice, direction: Direction, first: float, last: float, keep_out: float) -> None:
    """Refuse a travel on which the mass comes into the instrument.

    Parameters
    ----------
    body, direction, first, last
        As `least_distance`.
    keep_out : float
        Radius about the centre of the proof mass that the instrument takes [m].

    Raises
    ------
    DataError
        If a cell comes nearer.
    """
    distance, position = least_distance(body, direction, first, last)
    if distance < keep_out or distance == 0.0:
        raise DataError(
            f"at position {position:g} m the mass would overlap the instrument: {distance:.4g} m from the centre of "
            f"the proof mass, but the instrument needs {keep_out:g} m",
            why="the mass would hit the instrument, and material around the proof mass does not pull it to either side",
            do="Move the travel, raise the stand-off, or choose cells farther away.",
            code="overlap",
        )


def _nearest(centres: Array, half: Array) -> float:
    """Least distance of cuboids to the origin; zero inside one."""
    beyond = np.maximum(np.abs(centres) - half, 0.0)
    return float(np.sqrt(np.min(np.einsum("ij,ij->i", beyond, beyond)))) if len(centres) else float("inf")
