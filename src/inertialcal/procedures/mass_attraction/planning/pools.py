"""The mercury of a tilt meter, which the source mass attracts: how much its surface leans in each dwell."""

from __future__ import annotations

import numpy as np

from ....core.errors import UsageError
from ....core.estimate import Array
from ....core.key import Key
from ....core.results import Row
from ....physics.attraction import surface_tilt
from .body import MassBody
from .drive import DIRECTIONS, MassDrive
from .settings import Constants, Moved, number

TEST = "mass_attraction"
LIKE = "0 cm,-50 cm,-10 cm; 0 cm,50 cm,-10 cm"
Pools = tuple[tuple[float, ...], ...]


def pools_of(text: str) -> Pools:
    """Return the middles of both surfaces [m]: x along the input axis toward the mass, z up, the proof mass at zero.

    Raises
    ------
    UsageError
        If these are not two places of three lengths.
    """
    places = [part.split(",") for part in text.split(";")]
    if [len(place) for place in places] != [3, 3]:
        why = "x, y and z of the first pool and of the second are needed"
        raise UsageError(f"pools: {text!r}", why=why, do=f'Write it like "{LIKE}"', code="wrong_value")
    return tuple(tuple(number(one.strip(), "m", "pools", "50 cm") for one in place) for place in places)


def mercury_of(body: MassBody, found: MassDrive, moved: Moved, pools: Pools, constants: Constants) -> Array:
    """Return the tilt in each dwell of a cycle, positive where the second pool stands higher, shape (dwells,) [rad].

    Raises
    ------
    DataError
        If the pools are one place, or differ in height.
    """
    shifts = found.drive.positions[:, None] * np.array(DIRECTIONS[moved])
    return surface_tilt(body.body, shifts, pools, constants.gravity, constants.gravitational_constant)


def mercury_row(mercury: Array) -> Row:
    """Return half of the largest less the smallest tilt [rad]."""
    return Row(Key("mercury_amplitude"), float(np.ptp(mercury)) / 2.0, None, "rad", test=TEST)
