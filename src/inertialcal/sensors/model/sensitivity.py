"""How bias and scale factor change with a recorded condition, such as supply voltage: terms of the sensor equation.

With d = channel - reference, per sensor::

    K0   += bias d + bias_temperature d (T - T_ref)
    M_ii += scale_factor d

A channel is known by its name. Parameters are named after it: ``bias_supply``, ``bias_supply_temperature`` and
``scale_factor_error_supply``. Pressure and temperature have terms of their own in the equation; what those do not hold
(the change with pressure at other temperatures, the scale factor over pressure) is a sensitivity to ``pressure``.

References
----------
.. [1] IEEE Std 1431-2004, section 8.3 (model equation), 12.4 (input power), 12.17 (environment).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.units import normalise

PRESSURE = "pressure"
TAKEN = ("temperature", "temperature_rate", "time", "specific_force")  # conditions that are no channel of this kind
PARTS = {  # part of a sensitivity -> name of its quantity, and its unit; U is the input unit, C that of the channel
    "bias": ("bias_{}", "{U}/({C})"),
    "bias_temperature": ("bias_{}_temperature", "{U}/({C})/degC"),
    "scale_factor": ("scale_factor_error_{}", "1/({C})"),
}
HIGHEST = 12  # power of temperature, or number of exponentials, that a name in a file can have
COUNTED = {f"{word}_{j}" for word in ("temperature", "warm_up") for j in range(1, HIGHEST + 1)}  # bias_temperature_2


class ChannelReference(NamedTuple):
    """What a term over a channel refers to."""

    value: float  # At which the term is zero
    unit: str  # Of the channel, SI or degC
    range: tuple[float, float] | None = None  # That the term holds for


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Change of bias and scale factor with one channel; a part that is None is absent.

    Raises
    ------
    DataError
        If a shape does not fit, a number is not finite, or the channel has a name that another condition has
        (``channel_name``).
    """

    channel: str  # ``"supply"``
    unit: str  # Of the channel, SI or degC
    reference: float  # Value of the channel at which there is no change [unit]
    bias: Array | None = None  # shape (k,): [input unit/unit]
    bias_temperature: Array | None = None  # shape (k,): [input unit/(unit degC)]
    scale_factor: Array | None = None  # shape (k,): [1/unit]
    range: tuple[float, float] | None = None  # Of the channel, that the terms hold for [unit]

    def __post_init__(self) -> None:
        check_channel(self.channel)
        if self.channel == PRESSURE and self.bias is not None:
            raise DataError("the change of the bias with pressure is the model's own term bias_pressure")
        if not np.isfinite(self.reference):
            raise DataError(f"sensitivity to {self.channel}: reference {self.reference:g} is not finite")
        object.__setattr__(self, "unit", normalise(self.unit))
        for part in PARTS:
            value = getattr(self, part)
            if value is not None:
                array = np.array(value, dtype=float)
                array.setflags(write=False)
                object.__setattr__(self, part, array)

    @property
    def parts(self) -> dict[str, Array]:
        """Parts that are present, by name."""
        return {part: getattr(self, part) for part in PARTS if getattr(self, part) is not None}

    @property
    def terms(self) -> dict[str, Array]:
        """The same by the name of their quantity: ``"bias_supply"``."""
        return {quantity_of(part, self.channel): array for part, array in self.parts.items()}

    def with_terms(self, arrays: Mapping[str, Array]) -> Sensitivity:
        """Return it with the arrays of its parts, by the name of their quantity."""
        parts: dict[str, Any] = {part: arrays[quantity_of(part, self.channel)] for part in self.parts}
        return replace(self, **parts)


def quantity_of(part: str, channel: str) -> str:
    """Return the quantity of a part of a sensitivity: ``"bias_supply"``."""
    return PARTS[part][0].format(channel)


def parameter_unit(part: str, unit: str, of_channel: str) -> str:
    """Return the unit of a part, from the input unit and that of the channel."""
    return normalise(PARTS[part][1].replace("{U}", unit).replace("{C}", of_channel))


def check_channel(name: str) -> None:
    """Refuse the name of a channel that is no plain word, or that of another condition.

    Raises
    ------
    DataError
        ``channel_name``.
    """
    taken = name in TAKEN or name in COUNTED
    if taken or not (name.isascii() and name.isidentifier() and name.islower()):
        raise DataError(
            f"channel {name!r}: cannot be the name of a channel",
            why="another term has that name" if taken else "terms and columns are named after it",
            do="Use lower-case letters, digits and _, like supply or board_temperature",
            code="channel_name",
        )
