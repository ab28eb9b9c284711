"""From SI to the units that the campaign speaks: those of its sensor, percent for relative errors."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from ..core.curve import Column, Curve
from ..core.results import Interval, Row, changed
from ..core.units import divide, factor, kind, kind_of_unit, normalise, power, same_dimension, si_unit
from . import all_quantities, procedure_names

CONDITIONS = ("degC", "V", "Pa")  # units that readings may change with
PULSES = "count/s/(m/s^2)"  # scale factor of a pulse-rate converter


def display_unit(quantity: str, unit: str, sensor_unit: str) -> str:
    """Return the unit that a figure is shown in.

    Parameters
    ----------
    quantity : str
        The field's word.
    unit : str
        SI.
    sensor_unit : str
        As the campaign has it: ``"deg/s"``.
    """
    return _display_unit(quantity, unit, sensor_unit, procedure_names())


@lru_cache(4096)
def _display_unit(quantity: str, unit: str, sensor_unit: str, _: tuple[str, ...]) -> str:
    own = _own_unit(quantity, unit, sensor_unit)
    if own:
        return own
    if kind(unit) == kind(sensor_unit):
        return sensor_unit
    if unit in {"V/(rad/s)", "V/(m/s^2)"}:
        return divide("V", sensor_unit)
    if unit == PULSES:
        return normalise(f"count/s/({sensor_unit})")
    return _coefficient_unit(unit, sensor_unit)


def _own_unit(quantity: str, unit: str, sensor_unit: str) -> str:
    """Return the unit that people speak a quantity in, whatever else has that kind of unit; empty where none."""
    known = all_quantities().get(quantity)
    if known is None:
        return ""
    if known.shown == "%":
        return "%" if unit == "1" else ""
    if known.shown == "deg":
        return stated_unit(unit, sensor_unit)
    sensor = kind_of_unit(sensor_unit) if known.shown_by_kind else None
    shown = known.shown_by_kind.get(sensor, "") if sensor else known.shown.replace("{unit}", sensor_unit)
    shown = normalise(shown) if shown else ""
    return shown if shown and same_dimension(shown, unit) else ""


def _coefficient_unit(unit: str, sensor_unit: str) -> str:
    """Return the unit of a coefficient of a polynomial, or of a square, with that of the sensor in place of SI."""
    own = si_unit(sensor_unit)
    for rest in (
        "/sqrt(Hz)",
        *(f"/{by}" for by in (*CONDITIONS, *(f"{by}/degC" for by in CONDITIONS))),
        *(f"/{by}^{j}" for by in ("degC", "V") for j in range(2, 13)),
    ):
        if unit == normalise(f"({own}){rest}") or unit == f"{own}{rest}":
            return normalise(f"({sensor_unit}){rest}")
    return normalise(f"({sensor_unit})^2") if unit == normalise(f"({own})^2") else unit


def stated_unit(unit: str, sensor_unit: str) -> str:
    """Return the unit that the uncertainty of a source is shown in: as it was stated, SI as people speak of it.

    Parameters
    ----------
    unit : str
        That it was stated in, or SI.
    sensor_unit : str
        As the campaign has it: ``"deg/s"``.
    """
    if unit == "1":
        return "%"
    if unit == "rad":
        return "rad" if "rad" in sensor_unit else "deg"
    return sensor_unit if unit == si_unit(sensor_unit) else unit


def displayed(row: Row, sensor_unit: str, **fields: Any) -> Row:
    """Return the row in the units of the campaign; those of a sensor of no known kind stay in that of the file.

    Parameters
    ----------
    row : Row
        SI.
    sensor_unit : str
        As the campaign has it: ``"deg/s"``.
    **fields
        Fields of the row that change as well, in its unit.
    """
    unit, scale = shown_in(row.quantity, row.unit, sensor_unit)
    if unit == row.unit:
        return row.changed(**fields) if fields else row
    shared, curvature = fields.pop("shared", row.shared), fields.pop("curvature", row.curvature)
    return row.changed(
        value=scaled(row.value, scale),
        u=scaled(row.u, scale),
        interval=scaled_interval(row.interval, scale),
        unit=unit,
        shared={name: change * scale for name, change in shared.items()},
        curvature={name: one.times(scale) for name, one in curvature.items()},
        **fields,
    )


def shown_in(quantity: str, unit: str, sensor_unit: str) -> tuple[str, float]:
    """Return the unit that a row is shown in, and the factor to it; arguments as `display_unit` takes them."""
    return _shown(quantity, unit, sensor_unit, procedure_names())


@lru_cache(4096)
def _shown(quantity: str, unit: str, sensor_unit: str, names: tuple[str, ...]) -> tuple[str, float]:
    if kind_of_unit(sensor_unit) is None:
        return unit, 1.0
    shown = _display_unit(quantity, unit, sensor_unit, names)
    return shown, factor(unit, shown) if shown != unit else 1.0


def scaled(number: float | None, scale: float) -> float | None:
    """Return the number times a factor; absent stays absent."""
    return None if number is None else number * scale


def scaled_interval(interval: Interval | None, scale: float) -> Interval | None:
    """Return the interval times a factor; open sides stay open."""
    if interval is None:
        return None
    return changed(interval, lo=scaled(interval.lo, scale), hi=scaled(interval.hi, scale))


TEN_DIGITS = ("applied", "rate", "time", "start", "stop")


def displayed_curve(curve: Curve, sensor_unit: str) -> Curve:
    """Return a curve in the units of the campaign.

    Parameters
    ----------
    curve : Curve
        SI.
    sensor_unit : str
        As the campaign has it: ``"deg/s"``.
    """
    known = kind_of_unit(sensor_unit) is not None
    columns = {name: _displayed(column, sensor_unit) if known else column for name, column in curve.columns.items()}
    short = [name for name in columns if name in TEN_DIGITS or curve.picture]
    return replace(curve, columns=columns | {name: _shortened(columns[name]) for name in short})


def curve_contents(curves: Iterable[Curve], unit: str | None, test: str = "") -> list[dict[str, Any]]:
    """Return curves as ``results.json`` holds them, with what has the kind of a unit in it, and ratios in percent.

    Parameters
    ----------
    curves : iterable of Curve
        SI.
    unit : str or None
        Of the files; None leaves SI.
    test : str
        Name of the test.
    """
    return [_content_in_unit(curve.to_dict(test), unit) for curve in curves]


def _content_in_unit(curve: dict[str, Any], unit: str | None) -> dict[str, Any]:
    for column in curve["columns"].values():
        own = column["unit"]
        shown = "%" if own == "1" else unit if unit and own and kind(own) == kind(unit) else own
        if shown != own:
            scale = factor(own, shown)
            column["values"] = [None if value is None else value * scale for value in column["values"]]
            column["unit"] = shown
    return curve


def _displayed(column: Column, sensor_unit: str) -> Column:
    unit = column.unit
    if column.shown:
        scale = factor(unit, column.shown)
        return Column([scaled(value, scale) for value in column.values], column.shown)
    shown = "%" if unit == "1" else sensor_unit if unit and kind(unit) == kind(sensor_unit) else unit
    density = divide(power(sensor_unit, 2), "Hz")
    shown = density if unit and same_dimension(unit, density) else shown
    shown = display_unit("scale_factor", unit, sensor_unit) if unit == PULSES else shown
    if shown == unit:
        return column
    return Column(np.array(column.values, dtype=float) * factor(unit, shown), shown)


def _shortened(column: Column) -> Column:
    """Return a column to ten digits, as `ten_digits` has them, all in one go."""
    values = column.values.tolist() if isinstance(column.values, np.ndarray) else column.values
    return replace(column, values=[*map(float, ("%.10g " * len(values) % tuple(values)).split())])


def ten_digits(value: float) -> float:
    """Return a number to ten digits: 3 deg/s went through radians and shall come out as 3."""
    return float(f"{value:.10g}")
