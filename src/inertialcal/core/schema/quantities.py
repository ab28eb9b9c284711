"""Quantities of a campaign file: text "number unit", read into SI floats of the kind that the key needs."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from ..errors import DataError
from ..settings import PER_ACCELERATION
from ..units import kind, normalise, parse_quantity, same_dimension
from ..units import si_unit as si_of

GRAM = re.compile(r"(?<=\d)\s*g\s*(/\s*[cm]?m|$)")  # of a mass or density: there g is a gram, not an acceleration

READING = "reading"  # unit of a setting that is in the unit of the sensor, whichever kind it is
KINDS_OF_READING = ("angular_rate", "acceleration")
OUTPUTS = ("count/s", "V", "count")  # of sensors


def quantity(si_unit: str, difference: bool = False) -> Any:
    """Return a pydantic type: text like ``"-36.4 deg"``, read into a float in ``si_unit``.

    Parameters
    ----------
    si_unit : str
        Unit inside; anything that converts to it is accepted.
    difference : bool
        It is a difference of temperatures, and 1 K is 1 degC.
    """

    def read(given: object) -> float:
        if isinstance(given, bool) or not isinstance(given, str):
            raise ValueError(
                f'{given!r} is not a quantity: write "number unit", like "{_like(given, si_unit)}", in quotes'
            )
        try:
            read = parse_quantity(GRAM.sub(r" gram\1", given) if si_unit in {"kg", "kg/m^3"} else given)
            if si_unit == READING and kind(read.unit) in KINDS_OF_READING:
                return read.to(si_of(read.unit))
            if si_unit == PER_ACCELERATION:
                units = (f"{one}/(m/s^2)" for one in OUTPUTS)
                own = next((one for one in units if same_dimension(read.unit, one)), "count/s/(m/s^2)")
                return read.to(own, difference=difference)
            if read.unit == "1" and si_unit != "1":
                raise ValueError(f'{given!r} has no unit: write a number with its unit, like "1 {si_unit}"')
            if si_unit == READING or not same_dimension(read.unit, si_unit):
                like = "deg/s or m/s2" if si_unit == READING else si_unit
                raise ValueError(f"{given!r} is not in a unit like {like}")
            return read.to(si_unit, difference=difference)
        except DataError as error:
            raise ValueError(_text(error)) from None

    return Annotated[float, BeforeValidator(read)]


def _like(given: object, si_unit: str) -> str:
    """Return how a quantity is written: a share in %, as large as the bare number that was given."""
    if si_unit == "1":
        bare = isinstance(given, int | float) and not isinstance(given, bool)
        return f"{100.0 * given:.6g} %" if bare else "1 %"  # type: ignore[operator]
    return f"1 {'deg/s' if si_unit == READING else si_unit}"


def read_unit(given: object) -> str:
    """Read the name of a unit, for pydantic; the canonical spelling comes out."""
    if not isinstance(given, str):
        raise ValueError(f"{given!r} is not a unit: write its name in quotes")
    try:
        return normalise(given)
    except DataError as error:
        raise ValueError(_text(error)) from None


def _text(error: DataError) -> str:
    problem = error.problems[0]
    return f"{problem.what}. {problem.do}" if problem.do else problem.what


Unit = Annotated[str, BeforeValidator(read_unit)]
UnitOrNone = Annotated[str, BeforeValidator(lambda given: "" if given == "" else read_unit(given))]  # "": not known
Angle = quantity("rad")
AngularRate = quantity("rad/s")
Acceleration = quantity("m/s^2")
Length = quantity("m")
Pressure = quantity("Pa")
Temperature = quantity("degC")
Relative = quantity("1")
Voltage = quantity("V")
Duration = quantity("s")
Frequency = quantity("Hz")
NAME = r"^[A-Za-z0-9][A-Za-z0-9_.-]*$"
Name = Annotated[str, Field(pattern=NAME, max_length=64)]
Text = Annotated[str, Field(max_length=2000)]
Axis = Literal["x", "y", "z"]
PerAxis = str | dict[Axis, str]  # one quantity for all axes, or one each


class Strict(BaseModel):
    """Unknown keys are refused; nothing changes after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)
