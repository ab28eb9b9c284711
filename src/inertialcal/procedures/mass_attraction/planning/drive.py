"""Drive of a source mass: window, positions, harmonics, budget, and the forecast of its uncertainty."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ....core.curve import Column, Curve
from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import Key, told_for
from ....core.results import Row
from ....physics.attraction.bodies import Lattice
from ....physics.attraction.extended import ProofMass, mean_field
from ....physics.budget.amplitude import Share, compared, monte_carlo_budget, shares
from ....physics.budget.source import Doubts, Source
from ....physics.mass_shape.bound import Bound, largest_field
from ....physics.mass_shape.cells import Gain, Grid, Pieces, best_cells, best_stack, most_in_weight
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
from .forecast import Cycle, Forecast, forecast, takeover, time_to
from .settings import Body, Constants, Motion, Moved, Timing, ends_of

TEST = "mass_attraction"
CM = 100.0
Direction = tuple[float, float, float]
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
    window: Window  # Used
    best: Window  # The best of the same length
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


WHOLE = 0.01  # tolerance of a multiple of the smallest edge, in edges


WIDE = 0.65  # half width of the best body behind a plane over its reach: 0.62 where it touches


ROOM = 1.1  # size of the grid over that of the best body


SMALLEST = 1e-4  # edge [m]


HEAVIEST = 1e6  # kg: above, edges in centimetres were given as metres


FAR = 10.0  # stand-off over the radius of a sphere of the mass: beyond, the attraction is negligible


MOST_CELLS = 4_000_000


@dataclass(frozen=True, eq=False)
class MassBody:
    """A body, and the largest attraction that its mass could have."""

    body: Lattice  # With the proof mass at the origin and the input axis along x
    grid: Grid  # Places for cells
    count: int  # Number of filled cells
    bound: Bound  # For the same mass behind the plane
    allowed: float = 0.0  # Largest relative gain of free cells over cubes of several sizes; 0 for equal cubes
    # Of each size, from the largest: length of an edge and first cells of its cubes [cells of the grid], shape (n, 3)
    pieces: tuple[tuple[int, NDArray[Any]], ...] = ()

    @property
    def mass(self) -> float:
        """[kg]."""
        return self.count * self.grid.cell_mass

    @property
    def field(self) -> float:
        """Field at the proof mass along the input axis, for a gravitational constant of one [kg/m^2]."""
        return float(self.body.field(np.zeros((1, 3)))[0, 0])

    @property
    def gap(self) -> float:
        """Relative distance below the bound."""
        return 1.0 - self.field / self.bound.field

    @property
    def size(self) -> Array:
        """Extent along x, y and z, shape (3,) [m]."""
        filled = np.nonzero(self.body.density)
        return np.array([float(np.ptp(at) + 1) * self.grid.edge for at in filled])


def body_of(said: Body, gain: Gain) -> MassBody:
    """Return the body with the largest gain: equal cubes, or cubes of several sizes.

    Raises
    ------
    DataError
        If cubes do not fit the grid or the mass, edges are not multiples of the smallest, or a length is absurd.
    """
    pieces = said.cubes or ()
    edge = min((one.edge for one in pieces), default=said.cube or 0.0)
    if edge < SMALLEST:
        what, do = f"cubes of {edge:g} m: the smallest is {SMALLEST:g} m", "Check the unit of the edge"
        raise DataError(what, do=do, code="absurd_length")
    one = Grid(edge, (1, 1, 1), said.stand_off, said.density)
    if not pieces:
        number = most_in_weight(one, said.mass or 0.0) if said.count is None else said.count
        _check_weight(number * one.cell_mass, number, said.mass)
        grid = _grid(one, number, said.grid)
        body = best_cells(grid, number, gain)
        bound = largest_field(number * grid.cell_mass, said.density, said.stand_off)
        return MassBody(body, grid, number, bound, pieces=((1, np.argwhere(body.density > 0.0)),))
    sizes = []
    for piece in pieces:
        times = round(piece.edge / edge)
        if abs(piece.edge / edge - times) > WHOLE:
            what = f"edges of {piece.edge:g} m are not a multiple of {edge:g} m"
            do = "Give edges that are multiples of the smallest"
            raise DataError(what, why="all cubes lie on one grid", do=do, code="no_multiple")
        sizes.append(Pieces(times, piece.count))
    cells = sum(piece.count * piece.cells**3 for piece in sizes)
    _check_weight(cells * one.cell_mass, sum(piece.count for piece in sizes), said.mass)
    grid = _grid(one, cells, said.grid, max(piece.cells for piece in sizes))
    stack = best_stack(grid, tuple(sizes), gain)
    bound = largest_field(cells * grid.cell_mass, said.density, said.stand_off)
    edges = sorted((piece.cells for piece in sizes), reverse=True)
    return MassBody(stack.body, grid, cells, bound, stack.gap, tuple(zip(edges, stack.places, strict=True)))


def _check_weight(weight: float, count: int, mass: float | None) -> None:
    """Refuse what is heavier than allowed, or than any laboratory holds."""
    if mass is not None and weight > mass * (1.0 + 1e-9):
        what = f"{count} cubes weigh {weight:.6g} kg, more than the {mass:g} kg allowed"
        raise DataError(what, do="Allow more mass, or use fewer cubes", code="does_not_fit")
    if weight > HEAVIEST:
        why, do = f"no laboratory holds more than {HEAVIEST:g} kg", "Check the unit of the edges: cm, not m?"
        raise DataError(f"{count} cubes weigh {weight:.3g} kg", why=why, do=do, code="absurd_length")


def _grid(one: Grid, cells: int, shape: Sequence[int] | None, step: int = 1) -> Grid:
    """Return the grid, as given or large enough for the best body."""
    weight = cells * one.cell_mass
    radius = (3.0 * weight / one.density / (4.0 * math.pi)) ** (1.0 / 3.0)
    if one.stand_off > FAR * radius:
        what = (
            f"stand-off {one.stand_off:g} m: {one.stand_off / radius:.0f} times the radius of a sphere "
            f"of {weight:.4g} kg"
        )
        why, do = "the attraction is negligible at this distance", "Check the unit: cm, not m?"
        raise DataError(what, why=why, do=do, code="absurd_length")
    if shape is None:
        reach = largest_field(weight, one.density, one.stand_off).reach
        deep = math.ceil(ROOM * (reach - one.stand_off) / one.edge) + 2 * step
        half = math.ceil(ROOM * WIDE * reach / one.edge) + step
        sides = (deep - deep % -step, 2 * (half - half % -step), 2 * (half - half % -step))
    else:
        sides = (shape[2], shape[0], shape[1])  # along x, the input axis, then y and z
    if math.prod(sides) > MOST_CELLS:
        what = f"a grid of {sides[0]} x {sides[1]} x {sides[2]} cells: {MOST_CELLS:g} is the limit"
        raise DataError(what, do="Use larger cubes, or fewer", code="too_large")
    return Grid(one.edge, sides, one.stand_off, one.density)


NODES = 33  # positions of the travel between which the effect of a proof mass is interpolated


LENGTHS = np.linspace(0.2, 2.0, 10)  # of the curve, over the pointlike length


STEP = 1e-3  # of the distance, for the slope of a gradient


def reach(proof_mass: ProofMass | None) -> float:
    """Return the largest distance from its centre [m]."""
    return 0.0 if proof_mass is None else float(np.hypot(proof_mass.length / 2.0, proof_mass.radius))


def acting(travel: Travel, body: Lattice, way: Direction, proof_mass: ProofMass | None, big_g: float) -> Travel:
    """Return the travel with the field averaged over the proof mass: its effect is interpolated (Chebyshev)."""
    if proof_mass is None:
        return travel
    middle, half = (travel.first + travel.last) / 2.0, (travel.last - travel.first) / 2.0
    nodes = np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
    positions = middle + half * nodes
    shifted = np.ascontiguousarray(-positions[:, None] * np.array(way))
    effect = big_g * mean_field(body, proof_mass, shifted)[:, 0] - travel.at(positions)
    shape = np.polynomial.Chebyshev.fit(nodes, effect, NODES - 1, domain=[-1.0, 1.0])  # through each
    return replace(travel, field=lambda at: travel.field(at) + shape((at - middle) / half))


def effects(body: Lattice, way: Direction, ends: tuple[float, float], proof_mass: ProofMass) -> tuple[float, float]:
    """Return the relative effect on the amplitude between two ends: summed, and by the second-order rule."""
    shifts = np.ascontiguousarray(-np.outer(ends, way))
    point = float(np.diff(body.field(shifts)[:, 0])[0])
    summed = float(np.diff(mean_field(body, proof_mass, shifts)[:, 0])[0])
    near = STEP * float(np.min(np.abs(body.lower[0] - shifts[:, 0])))
    step = np.array([near, 0.0, 0.0])
    slopes = [body.gradient(np.ascontiguousarray(shifts + sign * step))[:, 0, 0] for sign in (1.0, -1.0)]
    curvature = float(np.diff(slopes[0] - slopes[1])[0]) / (
        2.0 * near
    )  # of the field, its difference between both ends
    return summed / point - 1.0, curvature * proof_mass.second_order / 2.0 / point


def proof_rows(body: Lattice, way: Direction, ends: tuple[float, float], proof_mass: ProofMass) -> list[Row]:
    """Return the effect of the proof mass on the amplitude, and the length at which it acts as a point."""
    summed, rule = effects(body, way, ends, proof_mass)
    figures = (
        ("proof_mass_effect", 100.0 * summed, "%", "on the amplitude, summed"),
        ("proof_mass_effect", 100.0 * rule, "%", "on the amplitude, second order"),
        ("pointlike_length", CM * proof_mass.pointlike_length, "cm", "of a proof mass of these radii"),
    )
    return [Row(Key(name), value, None, unit, test=TEST, member=told_for(at)) for name, value, unit, at in figures]


def proof_curve(body: Lattice, way: Direction, ends: tuple[float, float], proof_mass: ProofMass) -> Curve:
    """Return the effect on the amplitude against the length, at these radii; `own` is the length given."""
    lengths = np.unique([*LENGTHS * proof_mass.pointlike_length, proof_mass.length])
    found = np.array([effects(body, way, ends, replace(proof_mass, length=float(one))) for one in lengths])
    own = np.where(lengths == proof_mass.length, 100.0 * found[:, 0], np.nan)
    columns = {
        "length": Column(CM * lengths, "cm"), "effect": Column(100.0 * found[:, 0], "%"),
        "second_order": Column(100.0 * found[:, 1], "%"), "own": Column(own, "%"),
    }  # fmt: skip
    return Curve("proof_mass", "", columns)
