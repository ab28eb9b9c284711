"""What a test of noise is told (Plan) and what it works on (Readings)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ...core.axes import Kind
from ...core.influence import Influence, Standards
from ...signals.names import Deviation, Method

TermName = Literal[
    "quantization", "random_walk", "bias_instability", "rate_random_walk", "rate_ramp", "gauss_markov"
]  # fmt: skip

# Influences that a test of noise is subject to, and what each would change.
INFLUENCES = {"sensor.scale_factor": "all noise terms in proportion"}


@dataclass(frozen=True)
class Plan:
    """How records of a sensor at rest are to be reduced.

    Parameters
    ----------
    kind : {"gyro", "accelerometer"} or None
        Of the sensor; None where the unit of the file is neither, and everything stays in that unit.
    unit : str
        Of the samples where the kind is None; empty where nobody said.
    deviation : {"overlapping", "non_overlapping", "modified", "hadamard", "overlapping_hadamard"}
        Which is shown; the terms are always fitted to the overlapping Allan deviation.
    taus : {"octave", "decade", "all"}
        Averaging times that are shown; the fit takes octaves.
    seconds : tuple of float
        Averaging times that are shown instead [s].
    terms : list of str, optional
        Terms that are fitted; all that the record shows, by the criterion of ``sensors.noise.fitting.order``,
        if not said.
    lines : bool
        Whether lines are looked for in the spectrum, and taken into the fit.
    warm_up : float
        Left out at the start of each record [s].
    disturbed : {"leave_out", "keep"}
        What becomes of samples in disturbances.
    spectrum : {"welch", "multitaper"}
        How it is estimated.
    segment : float, optional
        Length of its segments [s]; an eighth of the record, or 131,072 samples where that is less, if not said.
    relative_error : float
        For which the length of a record is worked out (1).
    standards : mapping of Influence
        Uncertainties of the standards; from the campaign.
    """

    kind: Kind | None = field(default=None, metadata={"from": "sensor"})
    unit: str = field(default="", metadata={"from": "sensor"})
    deviation: Deviation = "overlapping"
    taus: Literal["octave", "decade", "all"] = "octave"
    seconds: tuple[float, ...] = field(default=(), metadata={"from": "command"})
    terms: list[TermName] | None = None
    lines: bool = True
    warm_up: float = field(default=0.0, metadata={"unit": "s"})
    disturbed: Literal["leave_out", "keep"] = "leave_out"
    spectrum: Method = "welch"
    segment: float | None = field(default=None, metadata={"unit": "s"})
    relative_error: float = field(default=0.1, metadata={"above": 0.0})
    standards: Standards = field(default_factory=dict[str, Influence], metadata={"from": "standards"})
