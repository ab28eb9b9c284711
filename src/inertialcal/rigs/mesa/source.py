"""The moved mass of the mesa rig: the lead of the report, moved up and down before the instrument.

Its field along the travel is the report's table, which was computed from the places of the cubes. The rig needs a field
that is known, not one that is right: its amplitude is what the schedule says and what the rig applies. Rows about the
stops are taken; the one that does not follow from the shape lies at zero, a misprint (18.904 for 18.994) is put right.

References
----------
.. [1] K. Reinel, NASA TM X-53857, 1969, Table 3.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ...core.estimate import Array
from ...physics.motion import ORDER, Window, drive, travel_of_table
from ...physics.motion.travel import Travel
from .setup import STOPS, UG, Bench

# Vertical position [cm], attraction along the input axis [ng].
TABLE_3 = (
    (7.6, 71.280), (10.2, 69.623), (12.7, 67.571), (15.2, 65.103), (17.8, 62.196), (20.3, 58.823), (22.9, 54.970),
    (25.4, 50.658), (27.9, 45.979), (30.5, 41.127), (33.1, 36.372), (35.6, 31.954), (38.1, 28.003), (40.7, 24.548),
    (43.2, 21.562), (45.7, 18.994), (48.2, 16.788),
)  # fmt: skip
CM, NG = 0.01, 1e-3 * UG


@lru_cache(1)
def travel() -> Travel:
    """Return the field of the mass along its travel [m/s^2], upper stop first [m]."""
    position, field = np.array(TABLE_3).T
    return travel_of_table(CM * position, NG * field)


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
