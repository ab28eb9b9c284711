"""What autopilots hold of a sensor: offsets as polynomials of order 3 in one temperature, and files of parameters.

A bias of order 3 or less is moved to the temperature that the autopilot counts from, exactly. A higher order is fitted
anew: the cubic whose *largest* error over the range of temperature is least (a linear programme on Chebyshev points).
Cutting the higher powers off instead is right near one temperature and wrong at the ends, where it matters.

Numbers are kept in float32 by both firmwares, so they are written as the float32 nearest to them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.key import AXES, Kind
from ....core.remarks import Remark
from ....sensors.model.sensor_model import SensorModel
from ..losses import Loss, bias_curves, largest, matrix_loss, other_losses
from ..triad import check_possible

ORDER = 3  # that both firmwares read
POINTS = 401  # Chebyshev points over the range: an order of 9 is held to 1e-4 of its residual
PER_DEGREE = "for each degC that a sensor differs from the thermometer"
NAME = re.compile(r"[A-Z][A-Z0-9_]*")


@dataclass(frozen=True, eq=False)
class Offsets:
    """Bias of three sensors over temperature, as an autopilot holds it."""

    powers: Array  # shape (4, 3): of T - centre [input unit/degC^j]
    centre: float  # [degC]
    range: tuple[float, float]  # Temperatures between which it holds [degC]
    residual: Array  # shape (3,): largest difference from the model's bias over the range [input unit]
    slope: Array  # shape (3,): largest change with temperature over the range [input unit/degC]


def has_temperature(model: SensorModel) -> bool:
    """Return whether the bias changes with temperature."""
    return model.bias_temperature is not None and bool(np.any(model.bias_temperature))


def check_axes(model: SensorModel) -> None:
    """Refuse a model without the axes x, y, z.

    Raises
    ------
    DataError
        ``not_three_axes``.
    """
    if model.axes != AXES:
        what = f"the model has the axes {', '.join(model.axes)}"
        raise DataError(what, why="an autopilot has x, y, z", do="Export it as json, or as code", code="not_three_axes")


def offsets(model: SensorModel, name: str, centre: float | None = None) -> Offsets:
    """Return the bias over temperature as cubics.

    Parameters
    ----------
    model : SensorModel
        Of three sensors.
    name : str
        Whose format it is for, for messages.
    centre : float, optional
        Temperature that the powers count from [degC]; the middle of the range, in whole degrees, if not given.

    Raises
    ------
    DataError
        ``not_three_axes``; ``no_temperature_range`` where the model does not say between which temperatures it holds.
    """
    check_axes(model)
    if model.temperature_range is None:
        raise DataError(
            f"the model of the {model.kind} states no range of temperature",
            why=f"{name} holds its temperature between two limits, and beyond the data a polynomial runs away",
            do="Make the model of a thermal test: inertialcal thermal FILE -o model.json",
            code="no_temperature_range",
        )
    low, high = ends = model.temperature_range
    at = float(np.clip(round(0.5 * (low + high)), low, high)) if centre is None else centre
    curves = bias_curves(model)
    cubics = [one if one.degree() <= ORDER else _nearest(one, ends) for one in curves]
    powers = np.zeros((ORDER + 1, 3))
    for i, one in enumerate(cubics):
        moved = one(Polynomial([at, 1.0])).coef
        powers[: len(moved), i] = moved
    kept = [0.0 if one is cubic else largest(one - cubic, ends) for one, cubic in zip(curves, cubics, strict=True)]
    return Offsets(powers, at, ends, np.array(kept), np.array([largest(one.deriv(), ends) for one in curves]))


def _nearest(curve: Polynomial, ends: tuple[float, float]) -> Polynomial:
    """Return the cubic whose largest difference from a polynomial, between two temperatures, is least."""
    from scipy.optimize import linprog  # noqa: PLC0415 - starts slowly

    place = np.cos(np.linspace(0.0, np.pi, POINTS))
    wanted = curve(0.5 * (ends[0] + ends[1]) + 0.5 * (ends[1] - ends[0]) * place)
    size = float(np.max(np.abs(wanted))) or 1.0
    basis = np.polynomial.chebyshev.chebvander(place, ORDER)
    first = np.linalg.lstsq(basis, wanted / size, rcond=None)[0]
    left = wanted / size - basis @ first  # of least squares: what is small is programmed alone
    unit = float(np.max(np.abs(left)))
    if not unit > np.finfo(float).eps:
        return Chebyshev(size * first, domain=ends).convert(kind=Polynomial)
    rows = np.vstack([np.column_stack([basis, -np.ones(POINTS)]), np.column_stack([-basis, -np.ones(POINTS)])])
    limits = np.concatenate([left, -left]) / unit
    free = [(None, None)] * (ORDER + 1)
    found = linprog([0.0] * (ORDER + 1) + [1.0], A_ub=rows, b_ub=limits, bounds=[*free, (0.0, None)], method="highs")
    best = first + unit * found.x[: ORDER + 1]
    return Chebyshev(size * best, domain=ends).convert(kind=Polynomial)


def known_bias(model: SensorModel) -> bool:
    """Return whether the constant of the bias is known: a thermal test of accelerometers gives only its change."""
    return not (model.estimate is not None and all(f"bias_{axis}" in model.not_estimated for axis in model.axes)
                and not np.any(model.bias))  # fmt: skip


def scales(model: SensorModel) -> list[float | None]:
    """Return 1 / M_ii of accelerometers, an axis each; None of an axis whose own is not known, and of gyros."""
    if model.kind != "accelerometer":
        return [None] * 3
    own = np.diag(model.matrix[0])
    unknown = [model.estimate is not None and f"scale_factor_error_{axis}" in model.not_estimated and entry == 1.0
               for axis, entry in zip(model.axes, own, strict=True)]  # fmt: skip
    return [None if gone else 1.0 / float(entry) for entry, gone in zip(own, unknown, strict=True)]


def losses(model: SensorModel, name: str) -> list[Loss]:
    """Return what an autopilot leaves out of a model.

    Raises
    ------
    DataError
        As `offsets`.
    """
    found = [matrix_loss(model, diagonal=model.kind == "accelerometer")]
    if has_temperature(model):
        held = offsets(model, name)
        if np.any(held.residual):
            orders = len(model.terms["bias_temperature"])
            what = f"bias over temperature beyond order {ORDER} (the model has {orders}; fitted anew)"
            # the firmware multiplies by SCALE what is left
            gain = np.array([one or 1.0 for one in scales(model)])
            found.append(Loss(what, held.residual * gain, "over the range of temperature"))
        found.append(Loss("the temperature of each sensor (one thermometer for all)", held.slope, PER_DEGREE))
    return [one for one in (*found, *other_losses(model)) if one is not None]


def unknown_left(models: Mapping[Kind, SensorModel], name: str) -> tuple[Remark, ...]:
    """Return remarks on what is not written, because nothing estimated it: the vehicle keeps its own."""
    found = []
    for model in models.values():
        if not known_bias(model):
            what = f"{model.kind}: the constant of the bias is not known: it is not written"
            do = "Calibrate the sensor level on the vehicle once these are loaded: its old offsets hold part of them"
            found.append(Remark("left_to_vehicle", "warning", what, do=do))
        missing = [axis for axis, one in zip(model.axes, scales(model), strict=True) if one is None]
        if model.kind == "accelerometer" and missing:
            what = f"accelerometer: scale factor of {', '.join(missing)} is not known: {name} keeps its own"
            found.append(Remark("left_to_vehicle", "info", what))
    return tuple(found)


def unknown_lines(kind: Kind, model: SensorModel, name: str) -> list[str]:
    """Return lines of comment on what is left to the vehicle, as `unknown_left` says it."""
    return [f"# {' '.join(one.what.split())}{f'. {one.do}' if one.do else ''}"
            for one in unknown_left({kind: model}, name)]  # fmt: skip


def figure(value: float) -> str:
    """Return the float32 nearest to a number, in digits that give it back."""
    text = np.format_float_positional(np.float32(value), unique=True, trim="0")
    return text if len(text) <= 16 else np.format_float_scientific(np.float32(value), unique=True)


def parameters(text: str, names: Iterable[str], where: str) -> dict[str, float] | None:
    """Return the parameters of a file by name; None where none has one of these beginnings.

    Lines are ``NAME VALUE``, ``NAME,VALUE``, ``param set NAME VALUE``, or as QGroundControl writes them: vehicle,
    component, name, value, type, with tabs between. What stands behind ``#`` is a comment.

    Raises
    ------
    DataError
        ``schema`` for a value that is no number, or a parameter that stands there twice; ``impossible_value``.
    """
    begin = tuple(names)
    found: dict[str, float] = {}
    for row, line in enumerate(text.splitlines(), 1):
        cells = line.partition("#")[0].replace(",", " ").replace("=", " ").split()
        if cells[:2] == ["param", "set"]:
            cells = cells[2:]
        if len(cells) == 5 and cells[0].isdigit() and cells[1].isdigit():
            cells = cells[2:4]
        if len(cells) < 2 or not NAME.fullmatch(cells[0]) or not cells[0].startswith(begin):
            continue
        name, said = cells[:2]
        place = f"{where}:{row}"
        try:
            value = float(said)
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise DataError(f"{name} is {said[:40]!r}, not a number", where=place, code="schema")
        if name in found:
            raise DataError(f"{name} stands there twice", where=place, do="Delete the one that is wrong", code="schema")
        check_possible(np.array(value), name, place)
        found[name] = value
    return found or None
