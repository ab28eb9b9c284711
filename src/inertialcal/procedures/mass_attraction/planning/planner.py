"""Plan of a mass-attraction test: body, drive, budget of the amplitude, forecast of the scale factor, schedule."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ....core.constants import STANDARD_GRAVITY
from ....core.errors import PlanError
from ....core.estimate import Array
from ....core.key import Key
from ....core.remarks import Remark, gather
from ....core.results import Row
from ....core.settings import settings_of
from ....core.show.frames import frame_of_rows
from ....core.show.result_tables import remarks_line
from ....core.show.tables import Block, html, text
from ....core.units import parse_quantity
from ....physics.attraction.extended import ProofMass
from ....physics.attraction.tilt import surface_tilt
from ....physics.budget.source import Doubts
from ....physics.mass_shape.cells import Gain, Grid, change
from ....physics.motion.clearance import refuse_overlap
from ....physics.motion.schedule import Schedule, repeated
from ...settings_file import Groups, GroupsRead, read_groups
from .body import MassBody, body_of
from .checks import setting_problems
from .drive import DIRECTIONS, MassBudget, MassDrive, MassForecast, budget_of, drive_of, forecast_of
from .noise import noise_from, terms_of
from .orbit import orbit_rows
from .proof import proof_curve, proof_rows
from .rows import (
    CM,
    TEST,
    body_curve,
    body_remarks,
    body_rows,
    budget_remarks,
    cube_curve,
    drive_rows,
    field_curves,
    forecast_curve,
    forecast_rows,
    growth_curve,
    mass_parts,
)
from .settings import Constants, Settings, ends_of, stage_of

if TYPE_CHECKING:
    from pandas import DataFrame

IN_GRAVITY = re.compile(r"[pnum]?g\b")  # a unit that is a multiple of g


@dataclass(frozen=True, eq=False)
class MassPlan:
    """Plan of a mass-attraction test.

    Parameters
    ----------
    rows : tuple of Row
        All figures.
    curves : tuple of Curve
        Data of the figures.
    remarks : tuple of Remark
        What to know about the plan.
    body : MassBody or None
        None for a mass in orbit.
    drive, budget, forecast
        As far as the settings allow, else None.
    mercury : ndarray or None
        Tilt of the mercury of a tilt meter in each dwell of a cycle [rad].
    schedule : Schedule or None
        Dwells of the test.
    inputs : mapping of str to str
        SHA-256 by path of the files that were read.
    constants : Constants
        Behind all figures.
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
    inputs: Mapping[str, str] = field(default_factory=dict[str, str])
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
        """Return body, drive, budget, forecast and the number of remarks."""
        return (*mass_parts(self.rows), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return the tables as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the tables for a notebook."""
        return html(self.parts())


def plan_mass_attraction(settings: str | Path | Groups | None = None, **groups: Mapping[str, object]) -> MassPlan:
    """Plan the calibration of an accelerometer by a moved mass.

    Parameters
    ----------
    settings : path or mapping, optional
        TOML file of settings, or the same as groups: ``{"body": {"cube": "5.08 cm", "count": 900}}``. Quantities are
        texts with a unit. ``inertialcal plan mass-attraction --write-example FILE`` writes a file to begin with.
    **groups : mapping
        Groups ``body``, ``motion``, ``timing``, ``instrument``, ``proof_mass``, ``noise``, ``uncertainty``,
        ``constants``, ``orbit``: their keys replace those of `settings`.

    Returns
    -------
    MassPlan
        Printable; ``.rows``, ``.curves``, ``.schedule``, ``.remarks``.

    Raises
    ------
    PlanError
        With every setting that is unknown, missing or wrong, or contradicts another: file, line, why, what to do.
    DataError
        If a file cannot be read, or such a mass or drive cannot exist.

    Examples
    --------
    >>> body = {"cube": "5.08 cm", "count": 900, "stand_off": "7.6 cm"}
    >>> plan_mass_attraction(body=body, motion={"stroke": ["12.7 cm", "43.2 cm"]}).schedule.period
    480.0
    """
    read = read_groups(Settings, settings, groups)
    problems = list(setting_problems(read))
    if problems:
        raise PlanError(problems)
    said = _in_document_gravity(read)
    constants, motion = said.constants, said.motion
    if said.orbit is not None:
        Grid(said.orbit.stand_off, (1, 1, 1), said.orbit.stand_off, said.orbit.density)  # refuses absurd values
        return MassPlan(tuple(orbit_rows(said.orbit, constants)), inputs=read.inputs, constants=constants)
    assert said.body is not None  # noqa: S101 - as checked
    way, gain = DIRECTIONS[motion.direction], Gain()
    if said.body.optimise == "change" and motion.stroke is not None:
        start, end = (np.array(way) * at for at in ends_of(motion.stroke))
        gain = change(tuple(end - start), start=tuple(start))
    body = body_of(said.body, gain)
    rows = body_rows(body, constants, said.body.stated)
    curves = (body_curve(body), cube_curve(), growth_curve(body, constants))
    remarks = body_remarks(rows, constants)
    plan = MassPlan(tuple(rows), curves, remarks, body, inputs=read.inputs, constants=constants)
    cylinder, keep_out = None, said.instrument.case
    if said.proof_mass is not None:
        cylinder = ProofMass(said.proof_mass.length, said.proof_mass.radius, said.proof_mass.inner_radius)
        keep_out = max(keep_out, math.hypot(cylinder.length / 2.0, cylinder.radius))
    refuse_overlap(body.body, (1.0, 0.0, 0.0), 0.0, 0.0, keep_out)
    stage = stage_of(motion)
    if stage is None:
        return plan
    return _forecast(_moved(plan, body, said, stage, cylinder, keep_out), said)


def _in_document_gravity(read: GroupsRead[Settings]) -> Settings:
    """Return the settings with every multiple of g as the constants say; they were read with standard gravity."""
    said = read.settings
    ratio = said.constants.gravity / STANDARD_GRAVITY.value
    for name in ("body", "noise", "orbit"):
        group, texts = getattr(said, name), read.given.get(name, {})
        scaled = {
            one.name: getattr(group, one.name) * ratio
            for one in (settings_of(type(group)) if group is not None else ())
            if one.unit.startswith("m/s") and one.name in texts
            and IN_GRAVITY.match(parse_quantity(str(texts[one.name])).unit)
        }  # fmt: skip
        said = replace(said, **{name: replace(group, **scaled)}) if scaled else said
    return said


def _moved(
    plan: MassPlan, body: MassBody, said: Settings, stage: tuple[float, float], proof_mass: ProofMass | None,
    keep_out: float,
) -> MassPlan:  # fmt: skip
    """Return the plan with drive and budget."""
    constants, motion, given = said.constants, said.motion, said.uncertainty
    way = DIRECTIONS[motion.direction]
    found = drive_of(body, motion, stage, said.timing.drive, constants, proof_mass, keep_out)
    u = {name: value or 0.0 for name, value in vars(given).items() if name != "position"}
    place = given.position or 0.0
    doubts = Doubts(place=(place, place, place), gravitational_constant=constants.u_gravitational_constant, **u)
    budget = budget_of(body, found, way, doubts, constants)
    rows, curves, remarks = drive_rows(found, budget, constants), field_curves(found, constants), []
    if proof_mass is not None:
        cylinder = body.body, way, (found.window.start, found.window.end), proof_mass
        rows, curves = [*rows, *proof_rows(*cylinder)], [*curves, proof_curve(*cylinder)]
    mercury = None
    if said.instrument.first_pool is not None and said.instrument.second_pool is not None:
        pools = (said.instrument.first_pool, said.instrument.second_pool)
        shifts = found.drive.positions[:, None] * np.array(way)
        mercury = surface_tilt(body.body, shifts, pools, constants.gravity, constants.gravitational_constant)
        rows.append(Row(Key("mercury_amplitude"), float(np.ptp(mercury)) / 2.0, None, "rad", test=TEST))
    if motion.rig is None:
        what = f"motion.rig is not given: a stage from {CM * stage[0]:g} to {CM * stage[1]:g} cm is assumed"
        remarks.append(Remark("no_rig", "info", what, do='Give its range: motion.rig = ["0 cm", "60 cm"]'))
    unstated = tuple(name for name, value in vars(given).items() if value is None)
    return replace(
        plan,
        rows=(*plan.rows, *rows),
        curves=(*plan.curves, *curves),
        remarks=(*plan.remarks, *remarks, *budget_remarks(unstated, budget)),
        drive=found,
        budget=budget,
        mercury=mercury,
    )


def _forecast(plan: MassPlan, said: Settings) -> MassPlan:
    """Return the plan with its schedule, and with what each drive will reach if the noise is known."""
    moving, budget, timing = plan.drive, plan.budget, said.timing
    assert moving is not None and budget is not None  # noqa: S101, PT018 - planned before
    u_applied = budget.u / moving.drive.amplitude
    kind: Any = moving.drive.kind.lower()
    period = len(moving.drive.positions) * (timing.dwell + timing.move)
    schedule = repeated(
        moving.drive.positions, moving.drive.fields, cycles=int(timing.length / period + 1e-9), dwell=timing.dwell,
        move=timing.move, drive=kind, u_applied=u_applied, mercury=plan.mercury,
    )  # fmt: skip
    terms, inputs, remarks = terms_of(said.noise), dict(plan.inputs), []
    if said.noise.file is not None:
        terms, axis, inputs[str(said.noise.file)] = noise_from(said.noise.file, said.noise.axis)
        names = ", ".join(term.name for term in terms)
        what = f"noise of axis {axis}: {names}; terms that its record does not show are left out"
        remarks.append(Remark("noise_file", "info", what, str(said.noise.file)))
    elif not terms:
        do = 'Set [noise], like noise.velocity_random_walk = "5 ug/sqrt(Hz)", or noise.file'
        remarks.append(Remark("no_noise", "info", "no noise is given: no forecast", do=do))
    plan = replace(plan, schedule=schedule, inputs=inputs, remarks=gather([*plan.remarks, *remarks]))
    if not terms:
        return plan
    found = forecast_of(moving, terms, timing, u_applied)
    return replace(
        plan,
        rows=(*plan.rows, *forecast_rows(found, timing.length, timing.target)),
        curves=(*plan.curves, *forecast_curve(found, u_applied)),
        forecast=found,
    )
