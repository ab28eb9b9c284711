"""Survey of one channel: range, scatter, resolution step, missing values, findings of the screening; unit hints."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches.summaries import median_made, moments
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import Channel, Recording, Times
from ...core.remarks import Remark, Severity
from ...core.results import finite
from ...core.show.rounding import number
from ...signals.codes import resolution_of_values
from ...signals.screening.remarks import remarks_of
from ...signals.screening.screen import Finding, Screening, screen
from ...signals.screening.slow import stuck_slow
from ..text.headers import UNNAMED

NOT_SCREENED = Screening((), 0, 0.0, 0.0)
ANY_CHANNEL = ("repeated", "missing")  # findings that mean something for any channel
CHANGES = ("level_step", "noise_change", "slow_wave")  # findings that have no samples to count
SLOW = ("temperature", "pressure", "voltage")  # quantities that may stay at one value for long
NO_CODES = ("index", "time", "status")  # quantities that may repeat or run through their values
CELSIUS, KELVIN = (-60.0, 130.0), (213.0, 403.0)  # usual range of a sensor


@dataclass(frozen=True)
class ChannelSurvey:
    """What a channel holds."""

    name: str  # As ``core.recording.Channel`` has them; unit None when nobody said
    axis: str  # As ``core.recording.Channel`` has them; unit None when nobody said
    quantity: str  # As ``core.recording.Channel`` has them; unit None when nobody said
    unit: str | None  # As ``core.recording.Channel`` has it; None when nobody said
    unit_from: str  # As ``core.recording.Channel`` has them; unit None when nobody said
    dtype: str  # Type of the stored numbers
    count: int  # Samples
    missing: int  # Samples that have no number
    minimum: float | None = None  # In the unit of the channel; None where there is no number
    maximum: float | None = None  # In the unit of the channel; None where there is no number
    mean: float | None = None  # In the unit of the channel; None where there is no number
    std: float | None = None  # In the unit of the channel; None where there is no number
    resolution: float | None = None  # Step of which all differences are whole multiples
    screening: Screening = NOT_SCREENED  # What its samples show

    @property
    def is_constant(self) -> bool:
        """Whether all numbers are equal."""
        return self.count - self.missing > 1 and self.minimum == self.maximum

    @property
    def notes(self) -> str:
        """What is odd about the channel: constant, or how many samples are of which kind."""
        if self.is_constant:
            return "constant"
        shown = (one for one in self.screening.findings if one.code not in ("missing", *CHANGES))
        counts = [f"{one.count} {one.code.replace('_', ' ')}" for one in shown]
        return ", ".join([*counts, *(code.replace("_", " ") for code in CHANGES if code in self.screening)])

    def to_dict(self) -> dict[str, object]:
        """Return plain values, for ``--json``."""
        return {
            "name": self.name,
            "axis": self.axis,
            "quantity": self.quantity,
            "unit": self.unit,
            "unit_from": self.unit_from,
            "dtype": self.dtype,
            "missing": self.missing,
            "min": finite(self.minimum),
            "max": finite(self.maximum),
            "mean": finite(self.mean),
            "std": finite(self.std),
            "resolution": finite(self.resolution),
            "findings": [_plain(one) for one in self.screening.findings],
        }


def survey_channel(channel: Channel) -> ChannelSurvey:
    """Return what a channel holds, before it is screened."""
    found = moments(channel.data)
    said = (channel.name, channel.axis, channel.quantity, channel.unit, channel.unit_from)
    dtype, missing = str(channel.data.dtype), len(channel.data) - found.count
    if not found.count:
        return ChannelSurvey(*said, dtype, len(channel.data), missing)
    return ChannelSurvey(
        *said,
        dtype,
        len(channel.data),
        missing,
        minimum=found.low,
        maximum=found.high,
        mean=found.mean,
        std=found.std,
        resolution=resolution_of_values(channel.data, found.count),
    )


def screened(
    survey: ChannelSurvey,
    data: NDArray[Any],
    at_rest: bool,
    readings: Sequence[NDArray[Any]],
    time_ns: Times | None,
    stated: bool = False,
) -> ChannelSurvey:
    """Return the survey of a channel with what its samples show, of those that mean something for its quantity.

    Parameters
    ----------
    survey : ChannelSurvey
        Of the channel.
    data : ndarray, shape (n,)
        Its samples.
    at_rest : bool
        Whether steps, changes of the noise and waves mean something.
    readings, time_ns
        As `stuck_slow` takes them.
    stated : bool
        It is what was applied, as it was asked for, or an angle: such a course repeats itself, and ends where it must.
    """
    found = screen(data, at_rest)
    if stated:
        found = replace(found, findings=tuple(one for one in found.findings if one.code in ANY_CHANNEL[1:]))
    if survey.quantity in NO_CODES:
        kept_codes = ANY_CHANNEL[1:] if survey.quantity == "index" else ANY_CHANNEL  # a counter of packets begins anew
        found = replace(found, findings=tuple(one for one in found.findings if one.code in kept_codes))
    if survey.quantity in SLOW and not survey.is_constant:
        kept = [one for one in found.findings if one.code != "stuck"]
        held = stuck_slow(data, readings, time_ns)
        if held is not None:
            places, value = np.array([[held.first, held.last]]), np.array([held.value])
            kept.append(Finding("stuck", places, np.full(1, np.nan), held.length, value))
        found = replace(found, findings=tuple(kept))
    return replace(survey, screening=found)


def channel_remarks(survey: ChannelSurvey, place: Callable[[int], str], aside: bool = False) -> tuple[Remark, ...]:
    """Return what a user should know about a channel.

    Parameters
    ----------
    survey : ChannelSurvey
        Of the channel.
    place : callable
        Gives ``file:row`` of a sample.
    aside : bool
        Whether the sensors of the file are in other channels: one that is constant is no loss.
    """
    if survey.is_constant:
        severity: Severity = "info" if aside or survey.quantity in (*NO_CODES, "spread") else "warning"
        what = f"{survey.name!r} is {survey.minimum or 0.0:g} throughout"
        return (Remark("constant_channel", severity, what, place(0), subject=survey.name),)

    def shown(value: float) -> str:
        return f"{number(value)} {survey.unit or ''}".rstrip()

    found = remarks_of(survey.screening, repr(survey.name), place, shown)
    return tuple(replace(one, subject=survey.name) for one in found if one.code != "missing")


def _plain(one: Finding) -> dict[str, object]:
    """Return a finding for ``--json``: the values are those that are held."""
    held = one.value if one.code in ("saturated", "stuck") else one.value[:0]
    return {
        "code": one.code,
        "count": one.count,
        "places": len(one.places),
        "first": one.first,
        "last": one.last,
        "values": np.unique(held).tolist(),
    }


GYRO_STEPS = (  # [deg/s]
    *((step, "InvenSense MPU") for step in (1 / 131, 1 / 65.5, 1 / 32.8, 1 / 16.4)),
    *((step, "ST") for step in (0.00875, 0.0175, 0.07)),
    *((scale / 2**15, f"{scale} deg/s full scale over 2^15 codes") for scale in (125, 250, 500, 1000, 2000)),
)
ACC_STEPS = tuple((1 / codes, f"{codes} LSB/g") for codes in (16384, 8192, 4096, 2048))  # [g]
STEP_AGREES = 1e-4  # relative; the step is printed with few digits
AT_REST = (("m/s2", 9.0, 10.7), ("g", 0.9, 1.1), ("mg", 900.0, 1100.0))  # 1 g with usual bias and scale error
COUNTS_FROM = 256.0  # whole numbers whose largest is beyond 8 bits


@dataclass(frozen=True)
class Hint:
    """A unit that the numbers suggest."""

    target: str  # Group or column, as ``--unit`` takes it
    unit: str  # As ``core.recording.Channel`` has it; None when nobody said
    reason: str  # Why

    def __str__(self) -> str:
        return f"{self.reason}: --unit {self.target}={self.unit}?" if self.unit else self.reason


def unit_hints(recording: Recording, surveys: Sequence[ChannelSurvey] | None = None) -> tuple[Hint, ...]:
    """Return a hint for each group, or unnamed channel, whose unit nobody said.

    Parameters
    ----------
    recording : Recording
        As read.
    surveys : sequence of ChannelSurvey, optional
        Of its channels, in order; by default they are surveyed where a hint needs it.
    """
    hints: list[Hint] = []
    unsaid = [i for i, channel in enumerate(recording.channels) if channel.unit is None]

    def survey(i: int) -> ChannelSurvey:
        return survey_channel(recording.channels[i]) if surveys is None else surveys[i]

    for group in ("gyro", "acc", "temperature"):
        members = [i for i in unsaid if recording.channels[i].quantity == group]
        if members:
            hints.append(_group_hint(group, [recording.channels[i] for i in members], [survey(i) for i in members]))
    hints += _in_g(recording.channels)
    for group, unit in (("gyro", "rad/s"), ("acc", "m/s^2")):  # raw codes under the unit of a message
        stated = [i for i, one in enumerate(recording.channels)
                  if (one.quantity, one.unit, one.unit_from) == (group, unit, "header") and one.axis]  # fmt: skip
        if len(stated) == len(AXES) and (codes := _counts(group, [survey(i) for i in stated])) is not None:
            hints.append(codes)
    for i in unsaid:
        channel = recording.channels[i]
        if channel.quantity == "" and (channel.axis or UNNAMED.fullmatch(channel.name)):
            step = resolution_of_values(channel.data) if surveys is None else surveys[i].resolution
            hints += _unnamed_hint(survey(i)) if step else []
    return tuple(hints)


def _group_hint(group: str, channels: Sequence[Channel], surveys: Sequence[ChannelSurvey]) -> Hint:
    """Hint for all channels of a quantity."""
    known = _counts(group, surveys) or _known_step(group, surveys)
    if group == "acc":
        known = _norm(channels) or known
    if group == "temperature":
        known = _temperature(surveys)
    other = {"gyro": "deg/s or rad/s", "acc": "m/s2 or g", "temperature": "degC"}[group]
    return known or Hint(group, "", f"{group} has no unit, and its values do not give it away: add {other}")


def _in_g(channels: Sequence[Channel]) -> list[Hint]:
    """Hint at readings in g under a header of m/s^2, as some drivers of ROS fill it."""
    acc = [one for one in channels if one.quantity == "acc" and one.axis]
    if len(acc) != 3 or any((one.unit, one.unit_from) != ("m/s^2", "header") for one in acc):
        return []
    found = _norm(acc)
    known = found is not None and found.unit == "g"
    return [Hint("acc", "g", f"median |acc| {median_norm(acc):.4g} m/s^2, and gravity is 9.8 m/s^2")] if known else []


def _norm(channels: Sequence[Channel]) -> Hint | None:
    """Gravity in the median norm of a triad; in the median of a single axis it may hide."""
    if len(channels) != 3:
        return None
    norm = median_norm(channels)
    for unit, low, high in AT_REST:
        if low <= norm <= high:
            return Hint("acc", unit, f"median |acc| {norm:.4g}")
    return None


def median_norm(channels: Sequence[Channel]) -> float:
    """Return the median length of the vectors whose axes are channels, in their unit."""
    axes = [one.data for one in channels]

    def norms(first: int, stop: int) -> Array:
        with np.errstate(over="ignore"):
            return np.asarray(np.sqrt(sum(x[first:stop].astype(np.float64) ** 2 for x in axes)))

    return median_made(norms, *axes)


def _counts(target: str, surveys: Sequence[ChannelSurvey]) -> Hint | None:
    """Whole numbers that reach far."""
    whole = all(s.resolution is not None and s.resolution == round(s.resolution) for s in surveys)
    integers = whole or all(np.dtype(s.dtype).kind in "iu" for s in surveys)
    reach = max((max(abs(s.minimum or 0.0), abs(s.maximum or 0.0)) for s in surveys), default=0.0)
    if not integers or reach < COUNTS_FROM:
        return None
    return Hint(target, "count", f"whole numbers up to {reach:g}")


def _known_step(group: str, surveys: Sequence[ChannelSurvey]) -> Hint | None:
    """Resolution step of a known sensor."""
    steps = [s.resolution for s in surveys if s.resolution is not None]
    if not steps or group not in ("gyro", "acc"):
        return None
    table, unit = (GYRO_STEPS, "deg/s") if group == "gyro" else (ACC_STEPS, "g")
    step = statistics.median(steps)
    found = _sensor(step, table)
    return Hint(group, unit, f"step {step:.6g}, as {found}") if found else None


def _sensor(step: float, table: Sequence[tuple[float, str]]) -> str:
    return next((name for known, name in table if abs(step - known) <= STEP_AGREES * known), "")


def _temperature(surveys: Sequence[ChannelSurvey]) -> Hint | None:
    """Usual range on one of the two scales; whole numbers beyond that of degC are codes as well."""
    low = min((s.minimum for s in surveys if s.minimum is not None), default=np.nan)
    high = max((s.maximum for s in surveys if s.maximum is not None), default=np.nan)
    whole = all("int" in one.dtype for one in surveys)
    for unit, (first, last) in (("degC", CELSIUS), ("K", KELVIN)):
        if first <= low and high <= last and not (unit == "K" and whole):
            return Hint("temperature", unit, f"temperature from {low:.4g} to {high:.4g}")
    return None


def _unnamed_hint(survey: ChannelSurvey) -> list[Hint]:
    """Hint for a channel with a step whose name says nothing."""
    found = _sensor(survey.resolution or 0.0, GYRO_STEPS)
    if found:
        return [Hint(survey.name, "deg/s", f"step {survey.resolution:.6g}, as {found}")]
    counts = _counts(survey.name, [survey])
    return [counts] if counts else []
