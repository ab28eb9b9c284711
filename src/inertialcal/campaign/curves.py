"""Curves of a campaign, in the units of its sensors: rates in that of the sensor, relative errors in percent.

Applied rates and times go through SI and come out to ten digits, so that 3 deg/s is 3; so does what only a picture
shows (``trace``). Readings, residuals and errors keep all digits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..core.curve import Column, Curve
from ..core.units import divide, factor, kind, power, same_dimension
from ..procedures.rate_table.closed_loop import HeldOut
from .display import PULSES, display_unit
from .load import Campaign
from .modelling import Modelled
from .overlays import overlays
from .prepared import modelled_sensor, sensor_of
from .requirements import Tested

IN_HOURS = ("record_length", "mass_series", "mass_correlation")  # as people plan and read them
TEN_DIGITS = ("applied", "rate", "time", "start", "stop")


def curves_content(campaign: Campaign, tested: Sequence[Tested], modelled: Modelled | None) -> list[dict[str, Any]]:
    """Return the curves of all tests, and those of the closed loop, as ``results.json`` holds them.

    Parameters
    ----------
    campaign : Campaign
        As read.
    tested : sequence of Tested
        Every test.
    modelled : Modelled or None
        Model and closed loop.
    """
    found = []
    for one in tested:
        unit = sensor_of(campaign, one.test).unit
        found += [displayed_curve(curve, unit).to_dict(one.test.id) for curve in one.result.curves()]
    units = {one.test.id: sensor_of(campaign, one.test).unit for one in tested}
    found += [displayed_curve(curve, units[test]).to_dict(test) for test, curve in overlays(campaign, tested)]
    if modelled is not None:
        unit = modelled_sensor(campaign).unit
        found += [displayed_curve(compensated(one), unit).to_dict("model") for one in modelled.errors]
    return found


def compensated(one: HeldOut) -> Curve:
    """Return the errors of the dwells held out of one axis, before and after compensation [rad/s]."""
    return Curve(
        "compensated",
        one.axis,
        {
            "applied": Column(one.applied, "rad/s"),
            "raw_error": Column(one.raw, "rad/s"),
            "compensated_error": Column(one.compensated, "rad/s"),
            "run": Column(one.run),
        },
    )


def displayed_curve(curve: Curve, sensor_unit: str) -> Curve:
    """Return a curve in the units of the campaign.

    Parameters
    ----------
    curve : Curve
        SI.
    sensor_unit : str
        As the campaign has it: ``"deg/s"``.
    """
    columns = {name: _displayed(column, sensor_unit) for name, column in curve.columns.items()}
    if curve.name in IN_HOURS:
        columns |= {name: _in_hours(column) for name, column in columns.items() if column.unit == "s"}
    short = [name for name in columns if name in TEN_DIGITS or curve.name == "trace"]
    return replace(curve, columns=columns | {name: _shortened(columns[name]) for name in short})


def _in_hours(column: Column) -> Column:
    """Return lengths of records as people plan them."""
    return Column([None if value is None else value * factor("s", "h") for value in column.values], "h")


def _displayed(column: Column, sensor_unit: str) -> Column:
    unit = column.unit
    shown = "%" if unit == "1" else sensor_unit if unit and kind(unit) == kind(sensor_unit) else unit
    density = divide(power(sensor_unit, 2), "Hz")
    shown = density if unit and same_dimension(unit, density) else shown
    shown = display_unit("scale_factor", unit, sensor_unit) if unit == PULSES else shown
    if shown == unit:
        return column
    return Column(np.array(column.values, dtype=float) * factor(unit, shown), shown)


def _shortened(column: Column) -> Column:
    return replace(column, values=[ten_digits(value) for value in column.values])


def ten_digits(value: float) -> float:
    """Return a number to ten digits: 3 deg/s went through radians and shall come out as 3."""
    return float(f"{value:.10g}")
