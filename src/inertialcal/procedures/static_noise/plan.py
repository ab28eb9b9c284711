"""Settings of a test of noise: its plan, what its nouns say of a file, what they show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ...core.axes import Kind
from ...core.influence import Influence, Standards
from ...core.settings import fact, setting
from ...signals.names import Deviation, Method

TermName = Literal[
    "quantization", "random_walk", "bias_instability", "rate_random_walk", "rate_ramp", "gauss_markov"
]  # fmt: skip

# Influences that a test of noise is subject to, and what each would change.
INFLUENCES = {"sensor.scale_factor": "all noise terms in proportion"}


@dataclass(frozen=True)
class Plan:
    """How records of a sensor at rest are to be reduced."""

    kind: Kind | None = fact(
        "Of the sensor; None where the unit of the file is neither, and everything stays in that unit.", "sensor", None
    )
    unit: str = fact("Of the samples where the kind is None; empty where nobody said.", "sensor", "")
    deviation: Deviation = setting(
        "Which deviation is shown; the terms are always fitted to the overlapping Allan deviation.", "overlapping"
    )
    taus: Literal["octave", "decade", "all"] = setting(
        "Averaging times that are shown; the fit takes octaves.", "octave"
    )
    tau: list[float] | None = setting("Averaging times that are shown instead.", None, unit="s", example="10 s")
    terms: list[TermName] | None = setting(
        "Terms that are fitted; where not given, all that the record shows, by the criterion of "
        "sensors.noise.fitting.order.", None, example="random_walk",
    )  # fmt: skip
    lines: bool = setting("Whether lines are looked for in the spectrum, and taken into the fit.", True)
    warm_up: float = setting("Left out at the start of each record.", 0.0, unit="s", example="600 s")
    disturbed: Literal["leave_out", "keep"] = setting("What becomes of samples in disturbances.", "leave_out")
    spectrum: Method = setting("How the spectrum is estimated.", "welch")
    segment: float | None = setting(
        "Length of the segments of the spectrum; an eighth of the record, or 131,072 samples where that is less, where "
        "not given.", None, unit="s", example="1000 s",
    )  # fmt: skip
    relative_error: float = setting(
        "Relative error for which the length of a record is worked out.", 0.1, above=0.0, example="0.1"
    )
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])


@dataclass(frozen=True)
class Samples:
    """What a noun of noise at rest is told of the samples of a file."""

    quantity: Literal["rate", "increment", "angle"] | None = setting(
        "What a sample is, where the unit does not tell: a rate, what is added in it, or the integral.", None
    )
    scale_factor: Mapping[str, str] = setting(
        "Scale factor of a column or group in counts or volts.", dict[str, str], example='gyro="131 count/(deg/s)"'
    )


FilterName = Literal["kalibr", "px4", "gtsam", "kf-gins"]


@dataclass(frozen=True)
class Filters:
    """Which settings of navigation filters are shown."""

    for_filter: list[FilterName] | None = setting(
        "Print the settings of this filter: kalibr, px4, gtsam or kf-gins.", None, example="kalibr", option="for"
    )
    horizon: float | None = setting(
        "With --for: a walk stands in for all that wanders, exact at this averaging time.", None, unit="s",
        example="100 s", above=0.0,
    )  # fmt: skip
