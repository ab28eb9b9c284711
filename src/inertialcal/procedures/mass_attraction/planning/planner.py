"""Plan of a mass-attraction test: what ``plan mass-attraction`` and ``inertialcal.plan_mass_attraction`` do.

Everything that is said is text with a unit. The proof mass is at the origin and the input axis along x; the mass stands
behind the plane at the stand-off and is moved away (along) or past (across), from position zero.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ....core.curve import Curve
from ....core.errors import UsageError
from ....core.estimate import Array
from ....core.remarks import Remark, gather
from ....core.results import Row
from ....core.show.frames import frame_of_rows
from ....core.show.result_tables import remarks_line
from ....core.show.tables import Block, html, text
from ....physics.attraction import ProofMass
from ....physics.budget import Doubts
from ....physics.mass_shape import Gain, Grid
from ....physics.motion import ORDER, refuse_overlap
from ....physics.motion.schedule import Schedule, repeated
from ....sensors.noise import Term
from .body import MassBody, body_of, stack_of
from .curves import body_curve, cube_curve, field_curves, forecast_curve, growth_curve
from .drive import DIRECTIONS, DRIVES, MassBudget, MassDrive, MassForecast, budget_of, drive_of, forecast_of
from .motion import Motion, Timing, check_choices, gain_of, motion_of, needed, refuse_beside, timing_of
from .noise import noise_from
from .orbit import orbit_of, orbit_rows
from .pools import Pools, mercury_of, mercury_row, pools_of
from .proof import proof_curve, proof_mass_of, proof_rows, reach
from .remarks import body_remarks, budget_remarks
from .rows import TEST, body_rows, drive_rows, forecast_rows
from .settings import (
    LEAD,
    Constants,
    constants_of,
    density_of,
    doubts_of,
    grid_of,
    inventory_of,
    mass_of,
    noise_of,
    one_of,
    positive,
)
from .shown import mass_parts

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, eq=False)
class MassPlan:
    """Plan of a mass-attraction test.

    Parameters
    ----------
    rows : tuple of Row
        All figures.
    curves : tuple of Curve
        What the figures show.
    remarks : tuple of Remark
        What there is to say of it.
    body : MassBody or None
        None for a mass in orbit.
    drive, budget, forecast
        As far as they were asked for, else None.
    mercury : ndarray or None
        Tilt of a meter's mercury in each dwell of a cycle [rad].
    schedule : Schedule or None
        Of the chosen drive for the hours asked for.
    inputs : mapping of str to str
        SHA-256 by path of the files that were read.
    constants : Constants
        Behind all of it.
    """

    rows: tuple[Row, ...]
    curves: tuple[Any, ...] = ()
    remarks: tuple[Remark, ...] = ()
    body: MassBody | None = None
    drive: MassDrive | None = None
    budget: MassBudget | None = None
    forecast: MassForecast | None = None
    schedule: Schedule | None = None
    mercury: Array | None = None
    inputs: Mapping[str, str] | None = None
    constants: Constants = field(default_factory=Constants)

    @property
    def results(self) -> dict[str, Any]:
        """Rows and curves as ``results.json`` has them."""
        return {
            "results": [row.to_dict() for row in self.rows],
            "curves": [curve.to_dict(TEST) for curve in self.curves],
        }

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: body, field and drive, budget, forecast, how many remarks."""
        return (*mass_parts(self.rows), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def plan_mass_attraction(
    *,
    cube: str | None = None,
    count: int | None = None,
    mass: str | None = None,
    inventory: str | None = None,
    density: str = LEAD,
    stand_off: str | None = None,
    grid: str | None = None,
    optimise: str = "attraction",
    stated: str | None = None,
    direction: str = "across",
    rig: str | None = None,
    stroke: str | None = None,
    travel: str | None = None,
    instrument: str = "0 cm",
    proof_mass: str | None = None,
    pools: str | None = None,
    drive: str = "sine",
    dwell: str = "100 s",
    move: str = "20 s",
    hours: float = 24.0,
    noise: str | None = None,
    noise_file: str | Path | None = None,
    noise_axis: str | None = None,
    target: str | None = None,
    u_density: str | None = None,
    u_piece_density: str | None = None,
    u_position: str | None = None,
    u_stop: str | None = None,
    u_piece_place: str | None = None,
    u_angle: str | None = None,
    big_g: str | None = None,
    gravity: str | None = None,
    shape: bool = False,
    orbit: bool = False,
    threshold: str = "0.5 Eotvos",
    baseline: str = "2 m",
) -> MassPlan:
    """Plan the calibration of an accelerometer by a moved mass.

    Parameters
    ----------
    cube : str
        Edge of the cubes, ``"5.08 cm"``.
    count : int, optional
        How many; by default as many as ``mass`` allows.
    mass : str, optional
        What they may weigh.
    inventory : str, optional
        In place of ``cube`` and ``count``: ``"100x10.2 cm,100x5.1 cm"``.
    density : str
        Of the material; lead by default.
    stand_off : str
        From the proof mass to the nearest face of the mass at position zero.
    grid : str, optional
        Cells across, across and along the input axis, ``"20x20x10"``; by default large enough.
    optimise : {"attraction", "change"}
        What the shape is best for: attraction at position zero, or its change over the stroke.
    stated : str, optional
        Attraction that a document states, to be checked against the most that can be.
    direction : {"across", "along"}
        How the mass is moved: past the sensor, or away from it along the input axis.
    rig : str, optional
        Positions that the stage has, ``"0 cm:60 cm"``.
    stroke, travel : str, optional
        Ends of the drive, ``"12.7 cm:43.2 cm"``; or the length of the best window.
    instrument : str
        How far the case reaches from the proof mass.
    proof_mass : str, optional
        A cylinder along the input axis, ``"length 2.9 cm, inner radius 1.3 cm, radius 1.4 cm"``; a point by default.
    pools : str, optional
        Middles of both surfaces of a tilt meter of mercury, x along the input axis toward the mass and z up:
        ``"0 cm,-50 cm,-10 cm; 0 cm,50 cm,-10 cm"``. The schedule then has how they lean, positive where the second
        stands higher.
    drive : {"sine", "square", "abab"}
        Order of the dwells.
    dwell, move : str
        Length of a dwell, and of the pause between two.
    hours : float
        Length of the test.
    noise : str, optional
        Of the sensor: ``"N=5 ug/sqrt(Hz) B=0.02 ug"``.
    noise_file : path, optional
        In its place: what ``allan --json`` or a run wrote; ``noise_axis`` says which axis.
    target : str, optional
        Relative standard uncertainty of the scale factor wanted, ``"1 %"``.
    u_density, u_piece_density, u_position, u_stop, u_piece_place, u_angle : str, optional
        Standard uncertainties: of the density of all cubes and of each, of the place of the body against the proof
        mass, of each stop, of the place of each cube in the body, of the angles of the body.
    big_g, gravity : str, optional
        Constants of a document; by default CODATA 2022 and standard gravity.
    shape : bool
        The body alone.
    orbit : bool
        A small mass and a gradiometer of that ``threshold`` and ``baseline`` instead.

    Returns
    -------
    MassPlan
        Printable; ``.rows``, ``.curves``, ``.schedule``, ``.remarks``.

    Raises
    ------
    UsageError
        If options are missing, contradict each other, or are no numbers with a unit.
    DataError
        If that mass, or that drive, cannot be.
    """
    constants = constants_of(big_g, gravity)
    material = density_of(density)
    apart = positive(needed(stand_off, "stand_off", "10.2 cm"), "m", "stand_off", "10.2 cm")
    if orbit:
        Grid(apart, (1, 1, 1), apart, material)  # refuses what no material and no distance is
        refuse_beside(
            "--orbit", cube=cube, count=count, inventory=inventory, grid=grid, stated=stated, rig=rig, stroke=stroke,
            travel=travel, noise=noise, target=target,
            pools=pools,
            **{"proof-mass": proof_mass, "noise-from": noise_file, "u-density": u_density, "u-stop": u_stop,
               "u-piece-density": u_piece_density, "u-position": u_position, "u-piece-place": u_piece_place,
               "u-angle": u_angle, "shape": shape or None},
        )  # fmt: skip
        small = orbit_of(mass_of(mass or "4 kg"), material, threshold, baseline, apart, constants)
        return MassPlan(tuple(orbit_rows(small, apart, constants)), constants=constants)
    motion = motion_of(direction, rig, stroke, travel, instrument)
    check_choices(cube, count, inventory, noise, noise_file)
    said = None if stated is None else constants.acceleration(stated, "stated")
    kind, timing = one_of(drive, tuple(DRIVES), "drive"), timing_of(dwell, move, hours)
    timing.cycles(len(ORDER[DRIVES[kind]]))
    wanted = None if target is None else positive(target, "1", "target", "1 %")
    known = _noise(noise, noise_file, noise_axis, constants)
    doubts = doubts_of(
        {"density": u_density, "piece_density": u_piece_density, "position": u_position, "stop": u_stop,
         "piece_place": u_piece_place, "angle": u_angle}, constants,
    )  # fmt: skip
    body = _body(cube, count, mass, inventory, material, apart, grid, gain_of(optimise, motion))
    alone = _of_body(body, constants, said, apart)
    cylinder = None if proof_mass is None else proof_mass_of(proof_mass)
    surfaces = None if pools is None else pools_of(pools)
    refuse_overlap(body.body, (1.0, 0.0, 0.0), 0.0, 0.0, max(motion.case, reach(cylinder)))
    if shape or not motion.asked:
        if surfaces is not None:
            raise UsageError(
                "--pools: without a drive nothing leans", do="Say --rig, --stroke or --travel", code="unused"
            )
        return alone
    return _forecast(_moved(alone, body, motion, kind, doubts, cylinder, surfaces), timing, known, wanted)


def _of_body(body: MassBody, constants: Constants, stated: float | None, apart: float) -> MassPlan:
    """Return what there is to say of the body."""
    rows = body_rows(body, constants, stated, apart)
    curves = (body_curve(body), cube_curve(), growth_curve(body, constants))
    return MassPlan(tuple(rows), curves, body_remarks(rows, constants), body, constants=constants)


def _moved(
    alone: MassPlan, body: MassBody, motion: Motion, kind: str, stated: tuple[Doubts, tuple[str, ...]],
    proof_mass: ProofMass | None, pools: Pools | None,
) -> MassPlan:  # fmt: skip
    """Return the plan with drive and budget."""
    constants = alone.constants
    found = drive_of(
        body, motion.direction, motion.stage, motion.ends, motion.length, kind, constants, motion.case, proof_mass
    )
    budget = budget_of(body, found, motion.direction, stated[0], constants)
    rows, curves = _of_proof_mass(body, motion, found, proof_mass)
    mercury = None if pools is None else mercury_of(body, found, motion.direction, pools, constants)
    rows += [] if mercury is None else [mercury_row(mercury)]
    return replace(
        alone,
        rows=(*alone.rows, *drive_rows(found, budget, constants), *rows),
        curves=(*alone.curves, *field_curves(found, constants), *curves),
        remarks=(*alone.remarks, *motion.remarks, *budget_remarks(stated[1], budget)),
        drive=found,
        budget=budget,
        mercury=mercury,
    )


def _of_proof_mass(
    body: MassBody, motion: Motion, found: MassDrive, proof_mass: ProofMass | None
) -> tuple[list[Row], list[Curve]]:
    """Return figures and curve of a proof mass that is no point."""
    if proof_mass is None:
        return [], []
    asked = body.body, DIRECTIONS[motion.direction], (found.window.start, found.window.end), proof_mass
    return proof_rows(*asked), [proof_curve(*asked)]


def _forecast(plan: MassPlan, timing: Timing, known: Known, target: float | None) -> MassPlan:
    """Return the plan with its schedule, and what each drive will reach where the noise is known."""
    moving, budget = plan.drive, plan.budget
    assert moving is not None and budget is not None  # noqa: S101, PT018 - planned before
    u_applied = budget.u / moving.drive.amplitude
    kind: Any = moving.drive.kind.lower()
    cycles = timing.cycles(len(moving.drive.positions))
    schedule = repeated(
        moving.drive.positions, moving.drive.fields, cycles=cycles, dwell=timing.dwell, move=timing.move, drive=kind,
        u_applied=u_applied, mercury=plan.mercury,
    )  # fmt: skip
    plan = replace(plan, schedule=schedule, inputs=known.inputs, remarks=gather([*plan.remarks, *known.remarks]))
    if not known.terms:
        return plan
    found = forecast_of(moving, known.terms, timing.dwell, timing.move, timing.length, u_applied, target)
    return replace(
        plan,
        rows=(*plan.rows, *forecast_rows(found, timing.length, target)),
        curves=(*plan.curves, *forecast_curve(found, u_applied)),
        forecast=found,
    )


@dataclass(frozen=True)
class Known:
    """Noise, where it comes from, and what there is to say of it."""

    terms: tuple[Term, ...]
    inputs: Mapping[str, str]
    remarks: tuple[Remark, ...]


def _body(
    cube: str | None, count: int | None, mass: str | None, inventory: str | None, density: float, apart: float,
    grid: str | None, gain: Gain,
) -> MassBody:  # fmt: skip
    weight = None if mass is None else mass_of(mass)
    cells = None if grid is None else grid_of(grid)
    if inventory is not None:
        return stack_of(inventory_of(inventory), density, apart, weight, cells, gain)
    edge = positive(needed(cube, "cube", "5.08 cm"), "m", "cube", "5.08 cm")
    return body_of(edge, density, apart, count, weight, cells, gain)


def _noise(noise: str | None, path: str | Path | None, axis: str | None, constants: Constants) -> Known:
    """Return the terms, the file that they come from, and what there is to say."""
    if noise is not None:
        return Known(noise_of(noise, constants), {}, ())
    if path is not None:
        terms, chosen, digest = noise_from(str(path), axis)
        names = ", ".join(term.name for term in terms)
        what = f"noise of axis {chosen}: {names}; what its record did not show is left out"
        said = Remark("noise_file", "info", what, str(path))
        return Known(terms, {str(path): digest}, (said,))
    do = 'Say it: --noise "N=5 ug/sqrt(Hz) B=0.02 ug", or --noise-from FILE'
    return Known((), {}, (Remark("no_noise", "info", "no noise is given: nothing is forecast", do=do),))
