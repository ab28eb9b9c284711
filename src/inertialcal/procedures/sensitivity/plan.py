"""What a sensitivity test is told (Plan)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ...core.influence import Influence, Standards
from ...core.settings import fact, setting

WARM_UP, START_TEMPERATURE = "warm_up", "warm_up_start_temperature"
PUMP = "pump"  # condition that is above half of its range where the pump runs
OF_LEVELS = (
    "bias",
    "bias_change",
    "bias_change_below",
    "pressure_constant_below",
    "scatter_sample",
    "pump_noise_ratio",
)
RESIDUALS = ("warm_up_residual", "warm_up_residual_without_model")  # of power-ups held out
TEMPERATURE, PRESSURE, SUPPLY, REFERENCE, APPLIED = "temperature", "pressure", "supply", "reference", "applied"
HIGHEST_ORDER = 5  # of the polynomial in temperature

# Influences that a sensitivity is subject to, and what each would change.
INFLUENCES = {
    "supply_meter.voltage": "sensitivities to the supply in proportion",
    "supply_meter.resolution": "sensitivities to the supply: the rounding of each of its levels",
    "pressure_gauge.pressure": "sensitivities to pressure in proportion",
    "thermometer.temperature": "sensitivities by their own slope over temperature",
    "converter.reference": "sensitivities of the bias in proportion",
    "rate_table.rate": "sensitivities of the scale factor in proportion",
}


@dataclass(frozen=True)
class OfFile:
    """What the command can be told of a file."""

    applied: str | None = setting(
        "Column with the true input, of a table or an arm; none where the unit is at rest.", None, example="table_rate"
    )
    axis: str | None = setting("Axis that the true input is along.", None, example="x")


@dataclass(frozen=True)
class Attitude:
    """How the unit lies, or how the table stands that turns it."""

    tilt: float = setting(
        "Angle of the body's z axis, or of the turned axis, from the vertical, positive towards azimuth.",
        unit="rad", example="0.1 deg",
    )  # fmt: skip
    u: float = setting("Standard uncertainty of the tilt.", 0.0, unit="rad", example="0.02 deg")
    azimuth: float | None = setting(
        "Direction of the tilt, from north towards east; unknown where not given.", None, unit="rad", example="30 deg"
    )
    u_azimuth: float = setting("Standard uncertainty of the azimuth.", 0.0, unit="rad", example="1 deg")


@dataclass(frozen=True)
class Plan:
    """Which conditions the readings are set against, and how."""

    to: list[str] = setting(
        "Conditions: supply, pressure, reference, temperature, or any channel by its name; warm_up.",
        lambda: [SUPPLY], example="supply",
    )  # fmt: skip
    order: int | None = setting(
        "Of the polynomial in temperature; where not given, as many powers as the temperatures of a power-up carry, "
        "up to 3.", None, least=0, most=HIGHEST_ORDER, example="2",
    )  # fmt: skip
    interactions: bool = setting("Sensitivities may change with temperature.", True)
    reference_temperature: float = setting(
        "Sensitivities hold at it; powers are those of the temperature less this.", 20.0, unit="degC", example="20 degC"
    )
    drift: int = setting(
        "Powers of the time since power-up that are taken off, alike in all power-ups: a warm-up that is not over.",
        0, least=0, most=3, example="1",
    )  # fmt: skip
    references: Mapping[str, str] = setting(
        "Nominal value of a condition, where its term is zero; the middle of its levels where not given.",
        dict[str, str], example='supply="5 V"', option="nominal",
    )  # fmt: skip
    settle: float = setting("Left out after each change of a condition.", 0.0, unit="s", least=0, example="60 s")
    block: float | None = setting(
        "Length of the means; longer than the noise is correlated. A mean a level where not given.",
        None, unit="s", above=0, example="60 s",
    )  # fmt: skip
    power_up_delay: float = setting(
        "Time from power-up to the first sample of a power-up, for warm_up.", 0.0, unit="s", least=0, example="2 s"
    )
    stated: Mapping[str, object] = setting(
        "Sensitivity that is known otherwise and taken off: its value, standard uncertainty and source.",
        dict[str, object],
        example='bias_supply={ value = "0.01 deg/s/V", u = "0.002 deg/s/V", source = "data sheet" }',
    )  # fmt: skip
    attitude: Attitude | None = setting(
        "How the unit lies; with the latitude it gives the earth rate along a turned axis, else that is left out.",
        None, example='{ tilt = "0.1 deg" }',
    )  # fmt: skip
    latitude: float | None = fact("Geodetic latitude [rad].", "site", None)
    unit: str = fact("Unit that the sensor is spoken of in, for texts; empty: that of the readings.", "sensor", "")
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])
