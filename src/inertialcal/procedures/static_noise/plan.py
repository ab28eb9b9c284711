"""Settings of noise at rest: the plan of a test, and what allan and psd ask of a file and of filters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
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


@dataclass(frozen=True)
class PlannedRecord:
    """What is known of the noise of a sensor, and how well its terms have to be known."""

    noise: str | None = setting(
        "White noise, which also says whether it is a gyro or an accelerometer.", None, example="0.2 deg/sqrt(h)"
    )
    instability: str | None = setting("Bias instability.", None, example="5 deg/h")
    walk: str | None = setting("Random walk of the bias.", None, example="5 deg/h/sqrt(h)")
    quantization: str | None = setting("Quantization noise.", None, example="0.5 arcsec")
    noise_file: Path | None = setting(
        "Output of `allan --json`, or results.json of a run, whose terms are taken.", None, example="noise.json"
    )
    axis: str | None = setting("Axis to take from the file, if it has several.", None, example="x")
    wanted: Mapping[str, str] = setting(
        "Relative standard uncertainty wanted of noise, instability, walk or quantization.", dict[str, str],
        example='instability="10 %"',
    )  # fmt: skip
    available: float | None = setting("Time that there is.", None, unit="s", example="12 h", above=0.0)
    sample_rate: float = setting("Samples a second.", 100.0, unit="Hz", example="100 Hz", above=0.0)
    cut_off: float | None = setting(
        "Cut-off of the sensor's low pass, where samples are instants, not means over their interval.", None, unit="Hz",
        example="40 Hz", above=0.0,
    )  # fmt: skip
    coefficient: str | None = setting("Size of the temperature coefficient of the bias.", None,
                                      example="3e-3 deg/s/degC")  # fmt: skip
    room: float | None = setting(
        "Temperature wanders by so much (Allan deviation) over the time at which a term is read.", None,
        difference="degC", example="0.05 K", least=0.0,
    )  # fmt: skip
    u_scale: float = setting("Relative standard uncertainty of the scale factor.", 0.0, unit="1", example="0.1 %",
                             least=0.0)  # fmt: skip
    simulate: int = setting(
        "Simulated records by which the forecast is checked; 0 for none.", 20, least=0, most=2000, example="40"
    )
    schedule: str | None = setting("Write the programme as CSV into this file.", None, example="schedule.csv")
