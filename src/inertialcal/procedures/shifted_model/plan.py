"""Settings of a shifted ground model, and the influences on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ...core.influence import Influence, Standards
from ...core.settings import fact, setting

ZERO, SCALE = "converter.zero", "sensor.scale_factor"
# Influences that all flips share, and what each would change.
INFLUENCES = {
    ZERO: "bias of the new model in full: all flips have the same offset of the electronics",
    SCALE: "bias of the new model in proportion to it",
}


@dataclass(frozen=True)
class SaidFlips:
    """What a caller says of a table of flips."""

    ground: str | None = setting("Model that was made on the ground.", None, example="ground.json")
    windows: list[str] = setting(
        "When the head stood still in a recording, and its position then; found by the turns if not given.",
        list[str], example='"START..STOP=180 deg"', option="window",
    )  # fmt: skip
    angle: str = setting("Angle of the turns of a recording, where the windows are found.", "180 deg",
                         example='"90 deg"')  # fmt: skip
    turn: Mapping[str, str] = setting(
        "Setting of the flip of each recording, as `flip` takes it.", dict[str, str], example="axis=x"
    )


@dataclass(frozen=True)
class Plan:
    """How the flights shift the ground model."""

    ground_date: str | None = setting(
        "Date of the ground model, to refuse flips that are older and to say its age.", None, example="2020-05-01"
    )
    date: str | None = setting("Date that the new model is for; that of the last flight if not given.", None,
                               example="2027-01-01")  # fmt: skip
    launches: Literal["fresh", "kept"] = setting(
        "What launch and turn-on shift: fresh, drawn anew for each flight; or kept, added to those of earlier flights.",
        "fresh",
    )  # fmt: skip
    launch_scatter: float | None = setting(
        "Standard deviation of that shift, where it is known from elsewhere; from the scatter of the flights if not "
        "given.", None, difference="m/s^2", example="5 ug", least=0.0,
    )  # fmt: skip
    trend: Literal["auto", "line", "none"] = setting(
        "Whether the new model has a drift from flight to flight: auto, from four flights on.", "auto"
    )
    slope: Literal["auto", "none"] = setting(
        "Whether the shift may change with temperature: auto, where the temperatures of the flips tell.", "auto"
    )
    shift_slope: float = setting(
        "Standard uncertainty of the change of the shift with temperature, where it is not estimated.", 0.0,
        difference="m/s^2/degC", example="0.5 ug/degC", least=0.0,
    )  # fmt: skip
    bias_of: Literal["head", "sensor"] = setting(
        "Whether the flips give the bias along the axes of the head, after scale factor and misalignment of the ground "
        "model, or that of the sensors as they read.", "head",
    )  # fmt: skip
    later: list[str] = setting("Flights that are left out and predicted.", list[str], example='"5"')
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])
