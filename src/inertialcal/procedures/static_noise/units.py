"""Units that noise terms are shown in: those of data sheets, by kind of sensor."""

from __future__ import annotations

from functools import cache
from types import MappingProxyType
from typing import get_args

from ...core.axes import Kind
from ...core.units import normalise
from ...sensors.noise.terms import TERMS, quantity_name, shown_units
from .reduction import quantity_units

SENSORS: tuple[Kind, ...] = get_args(Kind)


@cache
def data_sheet_units(kind: Kind) -> MappingProxyType[str, str]:
    """Return the unit that each quantity of noise is shown in: ``angle_random_walk`` in ``deg/sqrt(h)``.

    Parameters
    ----------
    kind : {"gyro", "accelerometer"}
        Of the sensor.
    """
    inside = quantity_units(kind, "")
    found = {}
    for name, term in TERMS.items():
        for parameter in term.parameters:
            quantity = quantity_name(name, parameter, kind)
            if quantity in inside:
                shown = shown_units(name, parameter, kind)
                found[quantity] = normalise(shown[0]) if shown else inside[quantity]
    return MappingProxyType(found)


def second_unit(quantity: str, kind: Kind) -> str:
    """Return another unit that data sheets give a quantity in; empty where there is none.

    Parameters
    ----------
    quantity : str
        Of a row.
    kind : {"gyro", "accelerometer"}
        Of the sensor.
    """
    for name, term in TERMS.items():
        for parameter in term.parameters:
            if quantity_name(name, parameter, kind) == quantity:
                shown = shown_units(name, parameter, kind)
                return normalise(shown[1]) if len(shown) > 1 else ""
    return ""
