"""Figures of a plan of a source mass, as rows: accelerations in ng, lengths in cm, ratios in percent."""

from __future__ import annotations

from dataclasses import replace

from ....core.key import Key, Reason, told_for
from ....core.results import Row, not_estimated
from ....physics.mass_shape import checked
from .body import MassBody
from .drive import DRIVES, SCALING, MassBudget, MassDrive, MassForecast
from .settings import Constants

TEST = "mass_attraction"
CM = 100.0
HOUR = 3600.0
SHOWN_HARMONICS = (2, 3)


def body_rows(body: MassBody, constants: Constants, stated: float | None, keep_off: float) -> list[Row]:
    """Return what the body is, what it attracts, and the most that it could.

    Parameters
    ----------
    body : MassBody
        Which.
    constants : Constants
        Gravitational constant, and what a g is.
    stated : float, optional
        Attraction of a document [m/s^2].
    keep_off : float
        Distance for which it is stated [m].
    """
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
        found = checked(stated, body.mass, body.grid.density, keep_off, constants.gravitational_constant)
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
    names = {round(place, 12): f"{field / ng:.6g} ng" for place, field in zip(*_places(found), strict=True)}
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


def _places(found: MassDrive) -> tuple[list[float], list[float]]:
    return found.drive.positions.tolist(), found.drive.fields.tolist()


def _budget_rows(budget: MassBudget, amplitude: float, ng: float) -> list[Row]:
    rows = [_row("amplitude_uncertainty", one.u / ng, "ng", one.name) for one in budget.parts]
    rows.append(_row("amplitude_uncertainty", budget.u / ng, "ng", "linear"))
    rows.append(_row("amplitude_uncertainty", 100.0 * budget.u / amplitude, "%", "linear"))
    if budget.u_drawn is None:
        alone = all(one.name in SCALING for one in budget.parts)
        reason = "what is in doubt only scales it: no draws are needed" if alone else "too many pieces to draw"
        return [*rows, _missing("amplitude_uncertainty", "ng", reason, "Monte Carlo")]
    return [*rows, _row("amplitude_uncertainty", budget.u_drawn / ng, "ng", "Monte Carlo")]


def forecast_rows(found: MassForecast, length: float, target: float | None) -> list[Row]:
    """Return what each drive reaches, when it reaches the target, and when what is applied takes over."""
    after = f"after {length / HOUR:g} h"
    rows = [_row("scale_factor_uncertainty", 100.0 * found.at_end[name], "%", f"{name}, {after}") for name in DRIVES]
    for name in DRIVES if target else ():
        rows.append(_time("time_to_target", found.needed[name], f"{name}, {100.0 * (target or 0.0):g} %"))
    for name in DRIVES if any(found.over.values()) else ():
        rows.append(_time("time_to_budget", found.over[name], name))
    return rows


def _time(quantity: str, seconds: float | None, condition: str) -> Row:
    if seconds is None:
        reason = "no time is enough: what is applied is not known as well as that"
        return _missing(quantity, "h", reason, condition)
    return _row(quantity, seconds / HOUR, "h", condition)


def _row(quantity: str, value: float, unit: str, condition: str = "", u: float | None = None, axis: str = "") -> Row:
    return Row(Key(quantity, axis), float(value), u or None, unit, test=TEST, member=told_for(condition))


def _as_stated(quantity: str, value: float, condition: str) -> Row:
    """Return an attraction of the body as it is stated, exactly so: what is in doubt stands with the amplitude."""
    reason = "of the body exactly as stated: its doubts are in the budget of the amplitude"
    return replace(_row(quantity, value, "ng", condition), reason=Reason("limits", reason))


def _missing(quantity: str, unit: str, why: str, condition: str) -> Row:
    reason = Reason("not_told", why)
    return replace(not_estimated(Key(quantity), unit, reason, member=told_for(condition)), test=TEST)
