"""Settings of noise at rest: the plan of a test, and what allan and psd ask of a file and of filters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ...core.influence import Influence, Standards
from ...core.key import Kind
from ...core.settings import fact, setting
from ...signals.names import Deviation, Method

TermName = Literal[
    "quantization", "random_walk", "bias_instability", "rate_random_walk", "rate_ramp", "gauss_markov"
]  # fmt: skip

# Influences that a test of noise is subject to, and what each would change.
INFLUENCES = {"sensor.scale_factor": "all noise terms in proportion"}
# Where it is stated; no clock of a recording is so far off that a noise term would show it.
OF_CLOCK = {
    "clock.rate": "noise terms by their power of time, correlation times and frequencies of lines in proportion"
}


@dataclass(frozen=True)
class Plan:
    """How records of a sensor at rest are to be reduced."""

    kind: Kind | None = fact(
        "Of the sensor; None where the unit of the file is neither, and everything stays in that unit.", "sensor", None
    )
    unit: str = fact("Of the samples where the kind is None; empty where nobody said.", "sensor", "")
    deviation: Deviation = setting(
        "Deviation to show; terms are always fitted to the overlapping Allan deviation.", "overlapping"
    )
    taus: Literal["octave", "decade", "all"] = setting("Averaging times to show; the fit uses octaves.", "octave")
    tau: list[float] | None = setting("Averaging times to show instead of these.", None, unit="s", example="10 s")
    terms: list[TermName] | None = setting(
        "Terms to fit; by default all that the record shows.", None, example="random_walk",
    )  # fmt: skip
    lines: bool = setting("Find lines in the spectrum and include them in the fit.", True)
    warm_up: float = setting("Time left out at the start of each record.", 0.0, unit="s", example="600 s")
    disturbed: Literal["leave_out", "keep"] = setting(
        "Samples that are no readings: glitches, disturbances, stuck, saturated or repeated ones.", "leave_out"
    )
    cut_off: float | None = setting(
        "Cut-off of the sensor's low pass; by default that of the sensor or the file, or as the spectrum shows.", None,
        unit="Hz", example="5 Hz", above=0.0,
    )  # fmt: skip
    spectrum: Method = setting("Estimator of the spectrum.", "welch")
    segment: float | None = setting(
        "Length of a segment of the spectrum; by default an eighth of the record, at most 131,072 samples.",
        None,
        unit="s",
        example="1000 s",
    )
    relative_error: float = setting(
        "Relative error of a term for which the record length is computed.", 0.1, above=0.0, example="0.1"
    )
    standards: Standards = fact("Uncertainties of the standards.", "standards", dict[str, Influence])


@dataclass(frozen=True)
class Samples:
    """Samples of a file, for allan and psd."""

    quantity: Literal["rate", "increment", "angle"] | None = setting(
        "What a sample is: a rate, its increment over a sample, or its integral; needed for angles and velocities.",
        None,
    )
    scale_factor: Mapping[str, str] = setting(
        "Scale factor of a column or group in counts or volts.", dict[str, str], example='gyro="131 count/(deg/s)"'
    )


FilterName = Literal["kalibr", "px4", "gtsam", "kf-gins"]
Drive = Literal["bias_instability", "rate_random_walk", "rate_ramp", "gauss_markov", "upper_limit"]


@dataclass(frozen=True)
class Filters:
    """Settings of navigation filters to print."""

    for_filter: list[FilterName] | None = setting(
        "Filter whose settings are printed.", None, example="kalibr", option="for"
    )
    horizon: float | None = setting(
        "Averaging time at which a random walk replaces all that wanders, for filters.", None, unit="s",
        example="100 s", above=0.0,
    )  # fmt: skip
    take: list[Drive] | None = setting(
        "Term that filters take where the record cannot separate several, by default that of the largest drive; "
        "upper_limit: the limit of a random walk of the bias that was not found.",
        None, example="rate_random_walk",
    )  # fmt: skip
