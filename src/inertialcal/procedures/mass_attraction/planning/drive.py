"""Drive of a source mass: window, positions, harmonics, budget, and the forecast of its uncertainty."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ....core.errors import DataError
from ....core.estimate import Array
from ....physics.attraction.extended import ProofMass
from ....physics.budget.amplitude import Share, compared, monte_carlo_budget, shares
from ....physics.budget.source import Doubts, Source
from ....physics.motion.clearance import refuse_overlap
from ....physics.motion.travel import (
    Drive,
    Travel,
    Window,
    best_window,
    drive,
    harmonics,
    sine_of_position,
    travel_of_body,
)
from ....sensors.noise import Term
from .body import MassBody
from .forecast import Cycle, Forecast, forecast, takeover, time_to
from .proof import Direction, acting
from .settings import Constants, Motion, Moved, Timing, ends_of

DIRECTIONS: dict[Moved, Direction] = {"along": (1.0, 0.0, 0.0), "across": (0.0, 0.0, -1.0)}
DRIVES: dict[str, Literal["sine", "square", "ABAB"]] = {"sine": "sine", "square": "square", "abab": "ABAB"}
POINTS = 121  # of the field along the travel
SAMPLES = 64  # of a period of a sinusoidal motion
MOST_PIECES = 20_000  # for Monte Carlo, which draws each piece
FARTHEST = 30.0  # travel over stand-off and size of the body: beyond, the attraction is negligible
TIMES = 25  # of the forecast
SCALING = ("gravitational constant", "density")  # influences that only scale the amplitude
NOTHING = 1e-6  # of the largest share: smaller shares are rounding of a slope of zero


@dataclass(frozen=True, eq=False)
class MassDrive:
    """Motion of the mass, and what it applies."""

    travel: Travel  # Field along the input axis [m/s^2]
    window: Window  # Used, and the best of the same length
    best: Window  # Used, and the best of the same length
    drive: Drive  # Positions of one cycle
    harmonics: Array  # shape (5,): of the field under a sinusoidal motion [m/s^2]


@dataclass(frozen=True, eq=False)
class MassBudget:
    """Uncertainty of the amplitude."""

    parts: tuple[Share, ...]  # By influence [m/s^2]
    u: float  # Linear [m/s^2]
    u_drawn: float | None  # Monte Carlo [m/s^2]; None if there are too many pieces
    agrees: bool | None  # Whether Monte Carlo validates the linear budget (JCGM 101); None without it


def drive_of(
    body: MassBody, motion: Motion, stage: tuple[float, float], kind: str, constants: Constants,
    proof_mass: ProofMass | None, keep_out: float,
) -> MassDrive:  # fmt: skip
    """Return the drive of a body on a stage [m], outside the radius of the instrument [m].

    Raises
    ------
    DataError
        If the travel is absurdly long, the body would meet the instrument, or the stroke leaves the stage.
    """
    farthest, extent = max(map(abs, stage)), body.grid.stand_off + float(np.max(body.size))
    if farthest > FARTHEST * extent:
        what = f"a travel to {farthest:g} m: stand-off and body together measure {extent:.2g} m"
        why, do = "the attraction is negligible there", "Check the unit: cm, not m?"
        raise DataError(what, why=why, do=do, code="absurd_length")
    big_g, way = constants.gravitational_constant, DIRECTIONS[motion.direction]
    refuse_overlap(body.body, way, *stage, keep_out)
    at_centre = travel_of_body(body.body, way, *stage, gravitational_constant=big_g)
    travel = acting(at_centre, body.body, way, proof_mass, big_g)
    if motion.stroke is None:
        window = best_window(travel, motion.travel or stage[1] - stage[0])
    else:
        start, end = ends_of(motion.stroke)
        fields = travel.at((start, end))
        window = Window(start, end, float(fields[0] - fields[1]))
    best = best_window(travel, window.end - window.start)
    swing = harmonics(travel, sine_of_position(window, SAMPLES))
    return MassDrive(travel, window, best, drive(travel, window, DRIVES[kind]), swing)


def budget_of(body: MassBody, found: MassDrive, way: Direction, doubts: Doubts, constants: Constants) -> MassBudget:
    """Return the uncertainty of the amplitude: linear, and by Monte Carlo with a fixed seed."""
    places, fields = found.drive.positions, found.drive.fields
    ends = float(places[fields.argmax()]), float(places[fields.argmin()])
    source = Source(body.body, way, ends, (1.0, 0.0, 0.0), constants.gravitational_constant)
    every = sorted(shares(source, doubts), key=lambda one: -one.u)
    parts = tuple(one for one in every if one.u > NOTHING * every[0].u)
    linear = math.hypot(*(one.u for one in parts))
    if all(one.name in SCALING for one in parts) or body.count > MOST_PIECES:
        return MassBudget(parts, linear, None, None)
    drawn = monte_carlo_budget(source, doubts, np.random.default_rng(1))
    agreement = compared(source, doubts, drawn)
    return MassBudget(parts, linear, float(np.std(drawn.samples, ddof=1)), agreement.validated)


@dataclass(frozen=True, eq=False)
class MassForecast:
    """Uncertainty that each drive will reach between the same ends."""

    drives: dict[str, Forecast]  # By drive
    at_end: dict[str, float]  # Relative uncertainty at the end
    needed: dict[str, float | None]  # Time to the target [s]; None if no time is enough
    over: dict[str, float | None]  # Time after which the amplitude dominates the uncertainty [s]


def forecast_of(found: MassDrive, terms: Sequence[Term], timing: Timing, u_applied: float) -> MassForecast:
    """Return the forecast of each drive between the same ends, for noise terms [m/s^2] and a relative u."""
    dwell, move, length, target = timing.dwell, timing.move, timing.length, timing.target
    cycles = {
        name: Cycle(tuple(drive(found.travel, found.window, kind).fields.tolist()), dwell, move)
        for name, kind in DRIVES.items()
    }
    longest = max(cycle.period for cycle in cycles.values())
    times = np.geomspace(longest, max(length, 2.0 * longest), TIMES)
    drives = {name: forecast(cycle, terms, times, u_applied=u_applied) for name, cycle in cycles.items()}
    at_end = {name: float(forecast(cycle, terms, length, u_applied=u_applied).u[0]) for name, cycle in cycles.items()}
    needed = {
        name: time_to(cycle, terms, target, u_applied=u_applied) if target else None for name, cycle in cycles.items()
    }
    over = {name: takeover(cycle, terms, u_applied) for name, cycle in cycles.items()}
    return MassForecast(drives, at_end, needed, over)
