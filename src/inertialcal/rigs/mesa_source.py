"""The moved mass of the mesa rig: cubes of lead where they attract most, moved up and down before the instrument."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..core.constants import GRAVITATIONAL_CONSTANT
from ..core.estimate import Array
from ..physics.mass_shape import Grid, best_cells
from ..physics.motion import ORDER, Window, drive, travel_of_body, travel_of_table
from ..physics.motion.travel import Travel
from .mesa_setup import CUBES, EDGE, LEAD, STAND_OFF, STOPS, Bench

DOWN = (0.0, 0.0, -1.0)
REACH = 0.02  # of the travel beyond the stops [m]
PLACES = 60  # at which the field is worked out; a spline goes between them


@lru_cache(1)
def travel() -> Travel:
    """Return the field of the mass along its travel [m/s^2], upper stop first [m]."""
    body = best_cells(Grid(EDGE, (10, 20, 20), STAND_OFF, LEAD), CUBES)
    first, last = STOPS[0] - REACH, STOPS[1] + REACH
    exact = travel_of_body(body, DOWN, first, last, gravitational_constant=GRAVITATIONAL_CONSTANT.value)
    places = np.linspace(first, last, PLACES)
    return travel_of_table(places, exact.at(places))


def cycle(bench: Bench) -> tuple[Array, Array]:
    """Return positions [m] and fields [m/s^2] of the dwells of one cycle."""
    positions, fields = _cycle(bench.drive)
    return positions, bench.lighter * fields


@lru_cache(2)
def _cycle(kind: str) -> tuple[Array, Array]:
    one = drive(travel(), Window(*STOPS, 0.0), "ABAB" if kind == "ABAB" else "sine")
    return one.positions, one.fields


def schedule_table(bench: Bench) -> tuple[Array, Array, Array]:
    """Return start [s], position [m] and field [m/s^2] of the dwells of a run, as they are planned."""
    positions, fields = cycle(bench)
    each = np.arange(bench.dwells) % len(positions)
    start: Array = np.arange(bench.dwells, dtype=np.float64) * (bench.dwell + bench.move)
    return start, positions[each], fields[each]


def dwells_a_cycle(bench: Bench) -> int:
    """Return how many."""
    return len(ORDER["ABAB" if bench.drive == "ABAB" else "sine"])
