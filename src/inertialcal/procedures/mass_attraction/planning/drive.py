"""The drive of a source mass: its window, positions, harmonics, budget, and the uncertainty that it will reach."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ....core.errors import DataError
from ....core.estimate import Array
from ....physics.attraction import ProofMass
from ....physics.budget import Doubts, Share, Source, compared, monte_carlo_budget, shares
from ....physics.motion import (
    Drive,
    Travel,
    Window,
    best_window,
    drive,
    harmonics,
    refuse_overlap,
    sine_of_position,
    travel_of_body,
)
from ....sensors.noise import Term
from .body import MassBody
from .forecast import Cycle, Forecast, forecast, takeover, time_to
from .proof import acting, reach
from .settings import Constants, Moved

DIRECTIONS: dict[Moved, tuple[float, float, float]] = {"along": (1.0, 0.0, 0.0), "across": (0.0, 0.0, -1.0)}
DRIVES: dict[str, Literal["sine", "square", "ABAB"]] = {"sine": "sine", "square": "square", "abab": "ABAB"}
POINTS = 121  # of the field along the travel
SAMPLES = 64  # of a period of a sinusoidal motion
MOST_PIECES = 20_000  # up to which pieces are drawn one by one
FARTHEST = 30.0  # a travel over the stand-off and the size of the body, from which nothing is left to tell
TIMES = 25  # of the forecast
SCALING = ("gravitational constant", "density")  # doubts that the amplitude is proportional to
NOTHING = 1e-6  # of the largest share: what is smaller is rounding of a slope that is zero


@dataclass(frozen=True, eq=False)
class MassDrive:
    """How the mass is moved, and what that applies.

    Parameters
    ----------
    travel : Travel
        Along the input axis [m/s^2].
    window, best : Window
        That is used, and the best of the same length.
    drive : Drive
        Positions of one cycle.
    harmonics : ndarray, shape (5,)
        Of the field under a sinusoidal motion [m/s^2].
    """

    travel: Travel
    window: Window
    best: Window
    drive: Drive
    harmonics: Array


@dataclass(frozen=True, eq=False)
class MassBudget:
    """Doubt of the amplitude.

    Parameters
    ----------
    parts : tuple of Share
        [m/s^2].
    u : float
        Linear [m/s^2].
    u_drawn : float or None
        Of the draws [m/s^2]; None where there are too many pieces.
    agrees : bool or None
        Whether the linear one may be used, as JCGM 101 has it; None where nothing was drawn.
    """

    parts: tuple[Share, ...]
    u: float
    u_drawn: float | None
    agrees: bool | None


def drive_of(
    body: MassBody, moved: Moved, rig: tuple[float, float], stroke: tuple[float, float] | None, length: float | None,
    kind: str, constants: Constants, instrument: float, proof_mass: ProofMass | None = None,
) -> MassDrive:  # fmt: skip
    """Return the drive of a body.

    Parameters
    ----------
    body : MassBody
        At position zero.
    moved : {"along", "across"}
        The input axis: away from the proof mass, or past it.
    rig : tuple of float
        Positions that the stage has [m].
    stroke : tuple of float, optional
        Ends of the drive [m].
    length : float, optional
        Of the best window; default: the whole rig.
    kind : str
        Of the drive.
    constants : Constants
        With the gravitational constant.
    instrument : float
        Radius of the case about the proof mass [m].
    proof_mass : ProofMass, optional
        Default: a point.

    Raises
    ------
    DataError
        If the mass would meet the instrument, or the stroke does not lie within the rig.
    """
    _check_rig(body, moved, rig, max(instrument, reach(proof_mass)))
    G = constants.gravitational_constant
    at_centre = travel_of_body(body.body, DIRECTIONS[moved], *rig, gravitational_constant=G)
    travel = acting(at_centre, body.body, DIRECTIONS[moved], proof_mass, G)
    window = best_window(travel, length or rig[1] - rig[0]) if stroke is None else _window(travel, stroke)
    best = best_window(travel, window.end - window.start)
    motion = harmonics(travel, sine_of_position(window, SAMPLES))
    return MassDrive(travel, window, best, drive(travel, window, DRIVES[kind]), motion)


def _window(travel: Travel, stroke: tuple[float, float]) -> Window:
    ends = travel.at(stroke)
    return Window(*stroke, float(ends[0] - ends[1]))


def _check_rig(body: MassBody, moved: Moved, rig: tuple[float, float], instrument: float) -> None:
    extent = body.grid.stand_off + float(np.max(body.size))
    if max(map(abs, rig)) > FARTHEST * extent:
        raise DataError(
            f"a travel to {max(map(abs, rig)):g} m of a mass that is {extent:.2g} m large with its distance",
            why="there is no attraction left out there",
            do="Look at the unit: cm, not m?",
            code="absurd_length",
        )
    refuse_overlap(body.body, DIRECTIONS[moved], *rig, instrument)


def budget_of(body: MassBody, found: MassDrive, moved: Moved, doubts: Doubts, constants: Constants) -> MassBudget:
    """Return the doubt of the amplitude: by slopes, and by draws with a fixed seed."""
    places, fields = found.drive.positions, found.drive.fields
    ends = float(places[fields.argmax()]), float(places[fields.argmin()])
    source = Source(body.body, DIRECTIONS[moved], ends, (1.0, 0.0, 0.0), constants.gravitational_constant)
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
    """What each drive will reach between the same ends.

    Parameters
    ----------
    drives : dict of str to Forecast
        By the drive.
    at_end : dict of str to float
        Relative uncertainty at the end.
    needed : dict of str to float or None
        Time to the target [s]; None where no time is enough.
    over : dict of str to float or None
        From when on what is applied is the larger doubt [s].
    """

    drives: dict[str, Forecast]
    at_end: dict[str, float]
    needed: dict[str, float | None]
    over: dict[str, float | None]


def forecast_of(
    found: MassDrive, terms: Sequence[Term], dwell: float, move: float, length: float, u_applied: float,
    target: float | None,
) -> MassForecast:  # fmt: skip
    """Return what each drive between the same ends will reach.

    Parameters
    ----------
    found : MassDrive
        Whose window.
    terms : sequence of Term
        Noise of the sensor [m/s^2].
    dwell, move, length : float
        Of each dwell, pause, and of the whole test [s].
    u_applied : float
        Relative.
    target : float, optional
        Relative uncertainty wanted.
    """
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
