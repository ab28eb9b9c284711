"""Plan of a mass-attraction test: body, drive, budget of the amplitude, forecast of the scale factor, schedule."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ....core.constants import STANDARD_GRAVITY
from ....core.curve import Curve
from ....core.errors import PlanError, Problem
from ....core.estimate import Array
from ....core.key import Key
from ....core.remarks import Remark, gather
from ....core.results import Row
from ....core.settings import settings_of
from ....core.show.frames import frame_of_rows
from ....core.show.result_tables import remarks_line
from ....core.show.tables import Block, html, text
from ....core.show.wording import counted
from ....core.units import parse_quantity
from ....physics.attraction.extended import ProofMass
from ....physics.attraction.tilt import surface_tilt
from ....physics.budget.source import Doubts
from ....physics.mass_shape.cells import Gain, Grid, change
from ....physics.motion.clearance import refuse_overlap
from ....physics.motion.schedule import Schedule, repeated
from ....physics.motion.travel import ORDER
from ...settings_file import Groups, GroupsRead, read_groups
from .build import Build, build_of
from .drive import (
    CM,
    DIRECTIONS,
    DRIVES,
    TEST,
    MassBody,
    MassBudget,
    MassDrive,
    MassForecast,
    body_of,
    budget_of,
    drive_of,
    forecast_of,
    proof_curve,
    proof_rows,
)
from .forecast import NAMED, noise_from, terms_of
from .rows import (
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
    orbit_rows,
    runs_remarks,
    runs_rows,
)
from .runs import PHASES, phases, runs_forecast, started
from .settings import HOUR, Constants, Settings, ends_of, stage_of

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
        Dwells of the first run.
    starts : tuple of int
        By how much the drive of each run starts ahead of that of the first [deg].
    inputs : mapping of str to str
        SHA-256 by path of the files that were read.
    constants : Constants
        Behind all figures.
    """

    rows: tuple[Row, ...]
    curves: tuple[Curve, ...] = ()
    remarks: tuple[Remark, ...] = ()
    body: MassBody | None = None
    drive: MassDrive | None = None
    budget: MassBudget | None = None
    forecast: MassForecast | None = None
    schedule: Schedule | None = None
    starts: tuple[int, ...] = (0,)
    mercury: Array | None = None
    inputs: Mapping[str, str] = field(default_factory=dict[str, str])
    constants: Constants = field(default_factory=Constants)

    @property
    def build(self) -> Build:
        """All cubes, in the order in which they are placed.

        Raises
        ------
        PlanError
            ``no_body`` for a mass in orbit.
        """
        if self.body is None:
            raise PlanError("a mass in orbit is not built of cubes", do="Plan a body", code="no_body")
        return build_of(self.body)

    @property
    def schedules(self) -> dict[int, Schedule]:
        """Schedules of the runs, by how much their drives start ahead of that of the first [deg]."""
        return {ahead: started(self.schedule, ahead) for ahead in dict.fromkeys(self.starts)} if self.schedule else {}

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
        Groups ``body``, ``motion``, ``timing``, ``instrument``, ``proof_mass``, ``noise``, ``drift``,
        ``uncertainty``, ``constants``, ``orbit``: their keys replace those of `settings`.

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
        remarks.append(Remark("no_rig", "info", what, do='Give its range: motion.rig = ["LOWEST cm", "HIGHEST cm"]'))
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
        do = 'Set [noise]: noise.velocity_random_walk = "NUMBER ug/sqrt(Hz)", or noise.file'
        remarks.append(Remark("no_noise", "info", "no noise is given: no forecast", do=do))
    starts = phases(timing.starts, timing.runs)
    plan = replace(plan, schedule=schedule, starts=starts, inputs=inputs, remarks=gather([*plan.remarks, *remarks]))
    u_noise = None
    if terms:
        found = forecast_of(moving, terms, timing, u_applied)
        u_noise = float(np.sqrt(found.at_end[kind] ** 2 - u_applied**2))
        rows = (*plan.rows, *forecast_rows(found, timing.length, timing.target))
        plan = replace(plan, rows=rows, curves=(*plan.curves, *forecast_curve(found, u_applied)), forecast=found)
    if timing.runs == 1 and said.drift is None:
        return plan
    together = {
        name: runs_forecast(schedule, phases(name, timing.runs), u_noise, said.drift)
        for name, turns in PHASES.items()
        if (timing.runs % len(turns) == 0 and len(moving.drive.positions) % len(turns) == 0)
        or name == timing.starts
    }  # fmt: skip
    return replace(
        plan,
        rows=(*plan.rows, *runs_rows(together, u_applied, f"{kind}, {counted(timing.runs, 'run')}")),
        remarks=gather([*plan.remarks, *runs_remarks(together[timing.starts], timing)]),
    )


NOT_BOTH = {
    "body.cubes": ("body.cube", "body.count"),
    "motion.stroke": ("motion.travel",),
    "orbit.gradient": ("orbit.acceleration",),
    "noise.file": tuple(f"noise.{name}" for name in NAMED),
}


ELEMENTS = {
    "body.grid": 3,
    "motion.rig": 2,
    "motion.stroke": 2,
    "instrument.first_pool": 3,
    "instrument.second_pool": 3,
}


def setting_problems(read: GroupsRead[Settings]) -> Iterator[Problem]:
    """Yield everything that is wrong with settings that are right one by one."""
    for key, others in NOT_BOTH.items():
        given = [one for one in others if _value(read, one) is not None]
        if given and _value(read, key) is not None:
            why, do = "they contradict each other", "Keep one of them"
            yield Problem(f"{key} with {', '.join(given)}", read.at(*key.split(".")), why, do, "contradiction")
    for key, count in ELEMENTS.items():
        values = _value(read, key)
        if isinstance(values, list) and (len(values) != count or (count == 2 and values[0] == values[1])):
            do = f"Give {count} different values"
            yield Problem(f"{key}: {values}", read.at(*key.split(".")), do=do, code="wrong_value")
    if read.settings.orbit is None:
        yield from _of_body(read)
        yield from _of_test(read)
    elif set(read.given) - {"orbit", "constants"}:
        unused = ", ".join(name for name in read.given if name not in {"orbit", "constants"})
        why, do = "an orbit has only the groups orbit and constants", "Remove the others"
        yield Problem(f"orbit with {unused}", read.at("orbit"), why, do, "contradiction")


def _value(read: GroupsRead[Settings], key: str) -> object:
    """Return a setting; None if it is not given."""
    group, name = key.split(".")
    return getattr(getattr(read.settings, group), name, None)


def _of_body(read: GroupsRead[Settings]) -> Iterator[Problem]:
    body, where = read.settings.body, read.at("body")
    if body is None:
        do = "Set body.stand_off, body.cube and body.count, or orbit; --write-example FILE shows all settings"
        yield Problem("body is missing", where, do=do, code="missing_key")
        return
    if body.cubes is None and body.cube is None:
        yield Problem("body.cube is missing", where, do='Set its edge: cube = "EDGE cm"', code="missing_key")
    if body.cubes is None and body.count is None and body.mass is None:
        do = "Give the number of cubes, or the largest mass"
        yield Problem("body.count and body.mass are missing", where, do=do, code="missing_key")
    if body.grid is not None and min(body.grid, default=0) < 1:
        do = "Give the cells across, across and along the input axis: [20, 20, 10]"
        yield Problem(f"body.grid: {body.grid}", read.at("body", "grid"), do=do, code="wrong_value")
    if body.optimise == "change" and read.settings.motion.stroke is None:
        do = 'Give the ends of the drive: motion.stroke = ["NEAREST cm", "FARTHEST cm"]'
        where = read.at("body", "optimise")
        yield Problem('body.optimise = "change" needs motion.stroke', where, do=do, code="missing_key")


def _of_test(read: GroupsRead[Settings]) -> Iterator[Problem]:
    said, timing = read.settings, read.settings.timing
    pools = [said.instrument.first_pool, said.instrument.second_pool]
    if pools != [None, None]:
        where = read.at("instrument")
        if None in pools:
            do = "Give the middles of both surfaces"
            yield Problem("instrument.first_pool without second_pool, or the reverse", where, do=do, code="missing_key")
        if stage_of(said.motion) is None:
            do = "Set motion.rig, motion.stroke or motion.travel"
            yield Problem(
                "instrument.first_pool: without a drive the mercury does not tilt", where, do=do, code="unused"
            )
    if timing.starts != "alike" and (turns := len(PHASES[timing.starts])) > timing.runs:
        what = f'timing.starts = "{timing.starts}" needs {turns} runs or more, timing.runs is {timing.runs}'
        yield Problem(what, read.at("timing", "starts"), do=f"Set timing.runs = {turns}", code="contradiction")
    if timing.starts == "quarters" and len(ORDER[DRIVES[timing.drive]]) % 4:
        what = f'timing.starts = "quarters": a cycle of drive "{timing.drive}" has no quarters'
        yield Problem(what, read.at("timing", "starts"), do='Set starts = "alternating"', code="contradiction")
    if said.drift is not None and (said.drift.time is None) == (said.drift.period is None):
        what = "drift needs time or period, one of them"
        yield Problem(what, read.at("drift"), do='Set it: drift.time = "NUMBER h"', code="missing_key")
    period = len(ORDER[DRIVES[timing.drive]]) * (timing.dwell + timing.move)
    if timing.length < period:
        what = f"timing.length: {timing.length / HOUR:g} h is shorter than one cycle of {period / HOUR:.3g} h"
        where, do = read.at("timing", "length"), "Give more time, or shorter dwells"
        yield Problem(what, where, do=do, code="too_short")
