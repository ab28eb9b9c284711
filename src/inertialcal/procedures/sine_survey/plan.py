"""Settings of a sine survey, and what its texts of a sweep mean."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ...core.errors import PlanError
from ...core.influence import Influence, Standards
from ...core.settings import fact, setting

CONTROL = ("control", "control_2", "control_3", "control_4")  # roles of channels
CLOCK = "clock.rate"
# Influences that a survey is subject to, and what each would change.
INFLUENCES = {CLOCK: "frequencies and sweep rates in proportion; a change of frequency not at all, where it is shared"}

NUMBER = r"([0-9.]+(?:[eE][-+]?[0-9]+)?)"
RATE = re.compile(rf"^\s*{NUMBER}\s*(oct|octaves?|dec|decades?|Hz)\s*/\s*(min|s)\s*$")
PER = {"min": 60.0, "s": 1.0}
OCTAVES_A_DECADE = 3.321928094887362


@dataclass(frozen=True)
class OfFile:
    """What the command can be told of a file."""

    control: list[str] = setting(
        "Column of a control accelerometer; up to four. Those whose names begin so where none is given.",
        list[str], example="ctrl1",
    )  # fmt: skip


@dataclass(frozen=True)
class Plan:
    """Which sweep was made, and which modes are looked for."""

    sweep: str | None = setting(
        "From which frequency to which the sweep was to go; a sweep that does not is named.", None,
        example="20 Hz to 1000 Hz",
    )  # fmt: skip
    rate: str | None = setting(
        "At which rate: octaves, decades or hertz a minute or second; another one is named.", None, example="4 oct/min"
    )
    level: float | None = setting(
        "Amplitude that the control was to keep; another one is named.", None, unit="m/s^2", example="0.25 g", above=0.0
    )
    least: float = setting(
        "Part of a mode in the transmissibility at its own frequency, below which it is none.", 0.1, above=0.0,
        example="0.05",
    )  # fmt: skip
    modes: int = setting("Modes that are looked for in each response, at most.", 12, least=1, most=40, example="6")
    tracking: int = setting(
        "Cycles in the window of the tracking filter, for the picture; its bandwidth is 1.44 of the frequency over it.",
        12, least=4, most=200, example="20",
    )  # fmt: skip
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])

    @property
    def stated_range(self) -> tuple[float, float] | None:
        """From which frequency to which the sweep was to go [Hz]; None where nobody said.

        Raises
        ------
        PlanError
            ``wrong_value``.
        """
        return None if self.sweep is None else range_of(self.sweep)

    @property
    def stated_rate(self) -> tuple[str, float] | None:
        """Law and rate that the sweep was to have [octaves or Hz a second]; None where nobody said.

        Raises
        ------
        PlanError
            ``wrong_value``.
        """
        return None if self.rate is None else rate_of(self.rate)


@dataclass(frozen=True)
class PlannedSurvey:
    """What is known of a survey before it is made."""

    sweep: str = setting("From which frequency to which.", "20 Hz to 1000 Hz", example="20 Hz to 1000 Hz")
    rate: str | None = setting(
        "Octaves, decades or hertz a minute or second; several are compared where not given.", None, example="4 oct/min"
    )
    level: float = setting("Amplitude of the drive.", 2.4516625, unit="m/s^2", example="0.25 g", above=0.0)
    frequency: float = setting("Natural frequency of the mode.", 100.0, unit="Hz", example="100 Hz", above=0.0)
    amplification: float = setting("Its Q.", 30.0, example="30", above=0.5, most=2000.0)
    part: float = setting("Its part of the motion: Q times this is about its transmissibility.", 1.0, example="0.3",
                          above=0.0)  # fmt: skip
    noise: float = setting("Noise of the response.", 5.5e-4, unit="m/s^2/sqrt(Hz)", example="56 ug/sqrt(Hz)",
                           above=0.0)  # fmt: skip
    control_noise: float = setting("Noise of the control.", 5.5e-4, unit="m/s^2/sqrt(Hz)", example="56 ug/sqrt(Hz)",
                                   least=0.0)  # fmt: skip


def range_of(text: str) -> tuple[float, float]:
    """Return the two frequencies of a text like ``"20 Hz to 1000 Hz"``.

    Raises
    ------
    PlanError
        ``wrong_value``.
    """
    found = re.match(rf"^\s*{NUMBER}\s*Hz\s*(?:to|-|\.\.)\s*{NUMBER}\s*(k?Hz)\s*$", text)
    if found:
        one, other = float(found[1]), float(found[2]) * (1000.0 if found[3] == "kHz" else 1.0)
        if one > 0.0 and other > 0.0 and one != other:
            return one, other
    raise PlanError(f"sweep = {text!r}: no range of frequencies", do="Write: 20 Hz to 1000 Hz", code="wrong_value")


def rate_of(text: str) -> tuple[str, float]:
    """Return law and rate of a text like ``"4 oct/min"`` [octaves or Hz a second].

    Raises
    ------
    PlanError
        ``wrong_value``.
    """
    found = RATE.match(text)
    if not found or not float(found[1]) > 0.0:
        raise PlanError(f"rate = {text!r}: no rate of a sweep", do="Write: 4 oct/min, or 10 Hz/s", code="wrong_value")
    value = float(found[1]) / PER[found[3]]
    if found[2] == "Hz":
        return "linear", value
    return "log", value * (OCTAVES_A_DECADE if found[2].startswith("dec") else 1.0)
