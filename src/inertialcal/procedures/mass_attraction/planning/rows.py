"""Figures of a plan of a source mass: rows (ng, cm, %), remarks on them, and the tables that show them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy import optimize

from ....core.curve import Column, Curve
from ....core.estimate import Array
from ....core.key import Key, Reason, told_for
from ....core.remarks import Remark
from ....core.results import Row, not_estimated
from ....core.show.rounding import settled, settled_number
from ....core.show.tables import Block, Table
from ....core.units import factor
from ....physics.attraction.bodies import Prism
from ....physics.mass_shape.bound import checked
from ....physics.mass_shape.cells import growth
from .drive import CM, DRIVES, POINTS, SCALING, TEST, MassBody, MassBudget, MassDrive, MassForecast
from .runs import RunsForecast
from .settings import Constants, Orbit, Starts, Timing

HOUR = 3600.0
SHOWN_HARMONICS = (2, 3)
BLOCKS: dict[str, tuple[str, ...]] = {
    "body": (
        "cells", "mass", "size", "attraction", "attraction_bound", "attraction_gap", "attraction_sphere",
        "inventory_gap", "stated_attraction", "stated_excess", "mass_needed", "radius", "smallest_gradient",
        "smallest_acceleration", "distance",
    ),
    "drive": (
        "drive_position", "amplitude", "best_window_start", "best_window_amplitude", "motion_harmonic",
        "proof_mass_effect", "pointlike_length", "mercury_amplitude",
    ),
    "budget of the amplitude": ("amplitude_uncertainty",),
    "forecast: standard uncertainty of the scale factor": (
        "scale_factor_uncertainty", "time_to_target", "time_to_budget", "repeating_drift_error",
    ),
}  # fmt: skip
PREDICTED = (
    "repeating_drift_error", "amplitude_uncertainty", "scale_factor_uncertainty", "time_to_target", "time_to_budget",
    "motion_harmonic", "proof_mass_effect", "attraction_gap", "inventory_gap", "stated_excess",
)  # fmt: skip
HEADS = ("quantity", "", "value ± u", "unit")
DIGITS, ROUGH = 5, 3
NEGLIGIBLE = 1e-6  # of the scale factor


def body_rows(body: MassBody, constants: Constants, stated: float | None) -> list[Row]:
    """Return size, mass and attraction of a body, the bound, and a document's attraction next to it [m/s^2]."""
    scale = constants.gravitational_constant / constants.ng
    at = f"face at {CM * body.grid.stand_off:g} cm"
    field, bound = scale * body.field, scale * body.bound.field
    rows = [
        _row("cells", body.count, "1"),
        _row("mass", body.mass, "kg"),
        *(_row("size", CM * size, "cm", axis=axis) for axis, size in zip("xyz", body.size, strict=True)),
        _as_stated("attraction", field, at),
        _as_stated("attraction_bound", bound, at),
        _row("attraction_gap", 100.0 * body.gap, "%", at),
        _as_stated("attraction_sphere", scale * body.bound.sphere, at),
    ]
    if body.allowed:
        rows.append(_row("inventory_gap", 100.0 * body.allowed, "%", "at most"))
    if stated is not None:
        found = checked(stated, body.mass, body.grid.density, body.grid.stand_off, constants.gravitational_constant)
        rows += [
            _row("stated_attraction", stated / constants.ng, "ng", at),
            _row("stated_excess", 100.0 * found.excess, "%", "over the bound"),
            _row("mass_needed", found.mass_needed, "kg", "for the stated attraction"),
        ]
    return rows


def drive_rows(found: MassDrive, budget: MassBudget, constants: Constants) -> list[Row]:
    """Return window, positions, amplitude with its budget, and harmonics."""
    ng = constants.ng
    kind = found.drive.kind.lower()
    places, fields = found.drive.positions.tolist(), found.drive.fields.tolist()
    names = {round(place, 12): f"{field / ng:.6g} ng" for place, field in zip(places, fields, strict=True)}
    rows = [
        *(_row("drive_position", CM * place, "cm", f"{kind}, {field}") for place, field in sorted(names.items())),
        _row("amplitude", found.drive.amplitude / ng, "ng", kind, budget.u / ng),
        _row(
            "best_window_start", CM * found.best.start, "cm", f"length {CM * (found.best.end - found.best.start):g} cm"
        ),
        _row("best_window_amplitude", abs(found.best.change) / 2.0 / ng, "ng"),
    ]
    for order in SHOWN_HARMONICS:
        share = 100.0 * float(found.harmonics[order - 1] / found.harmonics[0])
        rows.append(_row("motion_harmonic", share, "%", f"{order} of a sinusoidal motion"))
    return rows + _budget_rows(budget, found.drive.amplitude, ng)


def _budget_rows(budget: MassBudget, amplitude: float, ng: float) -> list[Row]:
    rows = [_row("amplitude_uncertainty", one.u / ng, "ng", one.name) for one in budget.parts]
    rows.append(_row("amplitude_uncertainty", budget.u / ng, "ng", "linear"))
    rows.append(_row("amplitude_uncertainty", 100.0 * budget.u / amplitude, "%", "linear"))
    if budget.u_drawn is None:
        alone = all(one.name in SCALING for one in budget.parts)
        reason = "all influences only scale it: not needed" if alone else "too many pieces"
        return [*rows, _missing("amplitude_uncertainty", "ng", reason, "Monte Carlo")]
    return [*rows, _row("amplitude_uncertainty", budget.u_drawn / ng, "ng", "Monte Carlo")]


def forecast_rows(found: MassForecast, length: float, target: float | None) -> list[Row]:
    """Return what each drive reaches, when it meets the target, and when the amplitude dominates."""
    after = f"after {length / HOUR:g} h"
    rows = [_row("scale_factor_uncertainty", 100.0 * found.at_end[name], "%", f"{name}, {after}") for name in DRIVES]
    for name in DRIVES if target else ():
        rows.append(_time("time_to_target", found.needed[name], f"{name}, {100.0 * (target or 0.0):g} %"))
    for name in DRIVES if any(found.over.values()) else ():
        rows.append(_time("time_to_budget", found.over[name], name))
    return rows


def runs_rows(together: Mapping[Starts, RunsForecast], u_applied: float, runs: str) -> list[Row]:
    """Return what the runs give together, and what a drift that repeats leaves, by how their drives start."""
    rows = []
    for name, one in together.items():
        condition = f"{runs}, {name}"
        if any(other.error for other in together.values()):
            rows.append(_row("repeating_drift_error", 100.0 * one.error, "%", condition))
        u = one.u(u_applied)
        if u is not None:
            rows.append(_row("scale_factor_uncertainty", 100.0 * u, "%", condition))
    return rows


def runs_remarks(found: RunsForecast, timing: Timing) -> list[Remark]:
    """Return a remark if what a drift leaves is larger than the noise."""
    if not found.error > max(found.u_noise or 0.0, NEGLIGIBLE):
        return []
    what = f"the drift leaves an error of {100.0 * found.error:.2g} % of the scale factor, the same in every run"
    do = 'Set timing.runs = 4 and timing.starts = "alternating": it cancels'
    return [Remark("repeating_drift", "warning", what, do=do if timing.starts == "alike" else "")]


def _time(quantity: str, seconds: float | None, condition: str) -> Row:
    if seconds is None:
        reason = "no time is enough: the uncertainty of the amplitude exceeds it"
        return _missing(quantity, "h", reason, condition)
    return _row(quantity, seconds / HOUR, "h", condition)


def _row(quantity: str, value: float, unit: str, condition: str = "", u: float | None = None, axis: str = "") -> Row:
    return Row(Key(quantity, axis), float(value), u or None, unit, test=TEST, member=told_for(condition))


def _as_stated(quantity: str, value: float, condition: str) -> Row:
    """Return an attraction of the body exactly as stated."""
    reason = "body exactly as stated: the budget of the amplitude holds its uncertainties"
    return replace(_row(quantity, value, "ng", condition), reason=Reason("limits", reason))


def _missing(quantity: str, unit: str, why: str, condition: str) -> Row:
    reason = Reason("not_told", why)
    return replace(not_estimated(Key(quantity), unit, reason, member=told_for(condition)), test=TEST)


def body_remarks(rows: Sequence[Row], constants: Constants) -> tuple[Remark, ...]:
    """Return remarks on a body: a stated attraction above the bound, constants of a document."""
    found = []
    by_name = {row.quantity: row for row in rows}
    excess = by_name.get("stated_excess")
    if excess is not None and (excess.value or 0.0) > 0.0:
        needed = by_name["mass_needed"].value or 0.0
        what = (
            f"the stated attraction is {excess.value:.2g} % above the bound for {by_name['mass'].value:.6g} kg behind "
            f"that plane, in any shape: it needs at least {needed:.5g} kg"
        )
        do = "Mass, density, distance or attraction is wrong"
        found.append(Remark("above_bound", "error", what, do=do))
    if constants != Constants():
        what = (
            f"constants of a document: G = {constants.gravitational_constant:.6g} m^3/s^2/kg, "
            f"1 g = {constants.gravity:g} m/s^2"
        )
        found.append(Remark("document_constants", "info", what))
    return tuple(found)


def budget_remarks(unstated: tuple[str, ...], budget: MassBudget) -> tuple[Remark, ...]:
    """Return remarks on a budget: uncertainties that are not stated, a linear budget that Monte Carlo contradicts."""
    found = []
    if unstated:
        what = f"not stated and taken as exact: uncertainty of {', '.join(unstated)}"
        do = "Set them under [uncertainty]"
        found.append(Remark("no_standard_uncertainty", "warning", what, do=do))
    if budget.agrees is False:
        what = "linear and Monte Carlo budget differ by more than one digit of u (JCGM 101, clause 8)"
        found.append(Remark("not_linear", "warning", what, do="Use the Monte Carlo figure"))
    return tuple(found)


def mass_parts(rows: Sequence[Row]) -> tuple[Block, ...]:
    """Return the tables: body, drive, budget, forecast."""
    found: list[Block] = []
    for caption, names in BLOCKS.items():
        mine = [row for row in rows if row.quantity in names and row.status == "estimated"]
        cells = [
            (row.quantity, " ".join(filter(None, (row.axis, str(row.case)))), _value(row), row.unit) for row in mine
        ]
        found += [Table(HEADS, cells, caption, (2,))] if cells else []
        missing = [row for row in rows if row.quantity in names and row.status == "not_estimated"]
        found += [f"  not estimated: {row.quantity} ({row.case}): {row.reason}" for row in missing]
    return tuple(found)


def _value(row: Row) -> str:
    if row.u is None:
        digits = ROUGH if row.quantity in PREDICTED else DIGITS
        return settled_number(row.value, digits)
    return settled(row.value, row.u)


RATIOS = np.geomspace(0.8, 20.0, 61)  # distance over edge


SPANS = np.concatenate([np.geomspace(1e-3, 1.0, 46), np.geomspace(1.0, 10.0, 16)[1:]])  # mass over that of the body


OWN = 45  # which of them is one


WAYS = {"face": (1.0, 0.0, 0.0), "edge": (1.0, 1.0, 0.0), "corner": (1.0, 1.0, 1.0)}


def body_curve(body: MassBody) -> Curve:
    """Return the cells that can be seen from outside, by their centres."""
    filled = np.pad(body.body.density > 0.0, 1)
    hidden = np.ones(body.body.density.shape, dtype=bool)
    inner = (slice(1, -1),) * 3
    for axis in range(3):
        for step in (1, -1):
            hidden &= np.roll(filled, step, axis)[inner]
    at = np.nonzero(filled[inner] & ~hidden)
    edge = body.grid.edge
    places = [CM * (low + (index + 0.5) * edge) for low, index in zip(body.body.lower, at, strict=True)]
    columns = {name: Column(np.round(place, 9), "cm") for name, place in zip("xyz", places, strict=True)}
    return Curve("mass_body", "", columns | {"edge": Column(np.full(len(at[0]), CM * edge), "cm")})


def field_curves(found: MassDrive, constants: Constants) -> list[Curve]:
    """Return the field along the travel, and the dwells of a cycle upon it."""
    positions = np.linspace(found.travel.first, found.travel.last, POINTS)
    return [
        Curve("mass_field", "", _field(positions, found.travel.at(positions), constants)),
        Curve("mass_drive", "", _field(found.drive.positions, found.drive.fields, constants), found.drive.kind.lower()),
    ]


def _field(positions: Array, fields: Array, constants: Constants) -> dict[str, Column]:
    return {"position": Column(CM * positions, "cm"), "attraction": Column(fields / constants.ng, "ng")}


def cube_curve() -> Curve:
    """Return by how much a cube attracts more than a point of its mass in its middle, toward face, edge and corner."""
    cube = Prism((-0.5,) * 3, (0.5,) * 3, 1.0)
    columns = {"ratio": Column(RATIOS)}
    for name, way in WAYS.items():
        along = np.array(way) / np.linalg.norm(way)
        points = np.ascontiguousarray(-RATIOS[:, None] * along)
        error = cube.field(points) @ along * RATIOS**2 - 1.0
        outside = RATIOS * np.abs(along).max() > 0.5
        columns[name] = Column(np.where(outside, 100.0 * error, np.nan), "%")
    return Curve("cube_as_point", "", columns)


def growth_curve(body: MassBody, constants: Constants) -> Curve:
    """Return the attraction of the touching sphere and of the best body against mass."""
    masses = body.mass * SPANS
    found = growth(masses, body.grid.density, body.grid.stand_off)
    scale = constants.gravitational_constant / constants.ng
    own = np.full(len(SPANS), np.nan)
    own[OWN] = scale * body.field
    columns = {
        "mass": Column(masses, "kg"), "sphere": Column(scale * found.sphere, "ng"),
        "best": Column(scale * found.best, "ng"), "body": Column(own, "ng"),
    }  # fmt: skip
    return Curve("mass_growth", "", columns)


def forecast_curve(found: MassForecast, u_applied: float) -> list[Curve]:
    """Return the uncertainty of the scale factor against time, a curve a drive."""
    return [
        Curve(
            "mass_forecast", "",
            {
                "time": Column(one.time / HOUR, "h"), "u": Column(100.0 * one.u, "%"),
                "u_applied": Column(np.full(len(one.time), 100.0 * u_applied), "%"),
            },
            name,
        )
        for name, one in found.drives.items()
    ]  # fmt: skip


EOTVOS = 1e-9  # [1/s^2]


def orbit_rows(said: Orbit, constants: Constants) -> list[Row]:
    """Return the figures of a mass in orbit; accelerations in the ng of the constants.

    A gradiometer of two accelerometers a baseline b apart that resolves the gradient Gamma resolves a difference of
    ``Gamma b``. A mass m gives the gradient ``2 G m / r^3`` along the line to it, and the attraction ``G m / r^2``.
    """
    pull, b = constants.gravitational_constant * said.mass, said.baseline
    gradient = said.gradient or 0.5 * EOTVOS
    if said.acceleration is not None:
        gradient = said.acceleration / b
    radius = (3.0 * said.mass / (4.0 * math.pi * said.density)) ** (1.0 / 3.0)
    distance = (2.0 * pull / gradient) ** (1.0 / 3.0)

    def over(d: float) -> float:  # G m (1 / d^2 - 1 / (d + b)^2) above the smallest difference, over b
        return pull * (2.0 * d + b) / (d * (d + b)) ** 2 - gradient

    least = min(distance, math.sqrt(pull / (gradient * b))) * 0.1
    from_nearer = float(optimize.brentq(over, least, distance, rtol=1e-12))  # nearer: the gradient falls off over b
    ng, u_relative, cm = constants.ng, constants.u_gravitational_constant, factor("m", "cm")
    figures = [
        ("mass", said.mass, "kg", "", 0.0),
        ("radius", cm * radius, "cm", "sphere", 0.0),
        ("smallest_gradient", gradient / EOTVOS, "Eotvos", "", 0.0),
        ("smallest_acceleration", gradient * b / ng, "ng", "difference over the baseline", 0.0),
        ("distance", cm * distance, "cm", "of its centre, at that gradient", u_relative / 3.0),
        ("attraction", pull / distance**2 / ng, "ng", "at that distance", u_relative / 3.0),
        ("distance", cm * from_nearer, "cm", "from the nearer accelerometer", 0.0),
        ("attraction", pull / (radius + said.stand_off) ** 2 / ng, "ng",
         f"surface at {cm * said.stand_off:g} cm", u_relative),
    ]  # fmt: skip
    return [
        Row(Key(name), value, value * u or None, unit, test=TEST, member=told_for(at))
        for name, value, unit, at, u in figures
    ]
