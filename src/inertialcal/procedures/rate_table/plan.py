"""What a rate-table test is told (Plan) and what it works on (Readings)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ...core.influence import Influence, Standards
from ...core.settings import fact, setting

# Influences that a rate table test is subject to, and what each would change.
INFLUENCES = {
    "rate_table.rate": "scale factors and all matrix entries in proportion",
    "rate_table.mounting": "cross-axis entries: the turned axis deviates from the nominal one",
    "converter.reference": "scale factors in volts in proportion",
}


@dataclass(frozen=True)
class Attitude:
    """How the axis of the table stands on the ground."""

    tilt: float = setting(
        "Angle of the table axis from the vertical, positive towards azimuth.", unit="rad", example="0.1 deg"
    )
    u: float = setting("Standard uncertainty of the tilt.", 0.0, unit="rad", example="0.02 deg")
    azimuth: float | None = setting(
        "Direction of the tilt, from north towards east; unknown where not given.", None, unit="rad", example="30 deg"
    )
    u_azimuth: float = setting("Standard uncertainty of the azimuth.", 0.0, unit="rad", example="1 deg")


@dataclass(frozen=True)
class Plan:
    """How the test was made and how it is to be reduced."""

    axis: str = setting("Axis that is turned, where the readings do not say it dwell by dwell.", "", example="x")
    zero_reference: bool = setting(
        "The reading at rest was subtracted from every reading: its bias is then that of the subtraction.", False
    )
    asymmetry: bool = setting("Fit one scale factor for each sense of rotation.", True)
    nonlinearity: Literal["auto", "always", "none"] = setting(
        "Second- and third-order terms in the line and the model: those that are seen, all that the rates allow, none.",
        "auto",
    )
    run_level: Literal["power_up", "recording"] = setting(
        "What the runs are: separate power-ups, or merely separate recordings.", "power_up"
    )
    scatter_ratio: float = setting(
        "A dwell whose scatter is this many times more, or less, than that of its neighbours is left out.",
        3.0, above=1.0, example="3",
    )  # fmt: skip
    neighbours: int = setting("How many dwells, nearest in rate, a scatter is compared with.", 8, above=1, example="8")
    rail_scatters: float = setting(
        "A dwell whose rate or reading is this many scatters or less from the end of the range is left out.",
        3.0, above=0.0, example="3",
    )  # fmt: skip
    agreement: float = setting(
        "Largest relative difference of a reading from the rate of the table that is a calibration matter, no mistake.",
        0.1, above=0.0, example="0.1",
    )  # fmt: skip
    missing: float = setting(
        "A dwell of a recording with a larger part of its samples missing, invalid or at the rail is left out.",
        0.1, above=0.0, example="0.1",
    )  # fmt: skip
    applied_tolerance: float = setting(
        "Wander of the applied channel that is no step, and no motion at rest; for an encoder.",
        0.0, unit="rad/s", example="0.01 deg/s",
    )  # fmt: skip
    attitude: Attitude | None = setting(
        "How the table stands; without it the earth rate along the axes is unknown.", None,
        example='{ tilt = "0.1 deg" }',
    )  # fmt: skip
    latitude: float | None = fact("Geodetic latitude [rad].", "site", None)
    input_range: tuple[float, float] | None = fact("Ends of the range [rad/s].", "sensor", None)
    scale_factor: Mapping[str, float] | None = fact("Ideal scale factor of each sensor [V/(rad/s)].", "sensor", None)
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])


@dataclass(frozen=True)
class Columns:
    """Which column of a file is what, where its name does not say it."""

    applied: str | None = setting("Column with the rate of the table.", None, example="rate_dps")
    reading: Mapping[str, str] = setting("Column with the reading, or AXIS=COLUMN.", dict[str, str], example="x=x_dps")
    scatter: str | None = setting("Column with the scatter within the dwell.", None, example="std_dps")
    run: str | None = setting("Column with the power-up run.", None, example="run_id")
    group: str | None = setting("Column with the sample set.", None, example="set")
