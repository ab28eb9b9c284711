"""Survey of one channel: range, scatter, resolution step, stuck and clipped samples, missing values."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from ...core.recording import Channel, Recording
from ...core.remarks import Remark, Severity
from ...core.results import finite
from ...signals.codes import Rail, Run, is_stuck, levels_of, longest_run, rails, resolution

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
    longest_run: Run | None = None  # Longest stretch of equal values
    stuck: bool = False  # Whether it is far longer than the other stretches explain; a constant channel is stuck
    rails: tuple[Rail, ...] = ()  # Extremes at which samples pile up
    rails_at: tuple[int, ...] = ()  # Index of the first sample of each

    @property
    def is_constant(self) -> bool:
        """Whether all numbers are equal."""
        return self.count - self.missing > 1 and self.minimum == self.maximum

    @property
    def notes(self) -> str:
        """What is odd about the channel: constant, stuck, at its rails."""
        found = []
        if self.is_constant:
            found.append("constant")
        elif self.stuck and self.longest_run is not None:
            found.append(f"stuck for {self.longest_run.length}")
        return ", ".join([*found, *(f"{rail.count} at {rail.value:g}" for rail in self.rails)])

    def to_dict(self) -> dict[str, object]:
        """Return plain values, for ``--json``."""
        run = self.longest_run
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
            "longest_run": None if run is None else {"start": run.start, "length": run.length},
            "stuck": self.stuck,
            "clipped": [{"value": rail.value, "count": rail.count} for rail in self.rails],
        }


def survey_channel(channel: Channel) -> ChannelSurvey:
    """Return what a channel holds."""
    index = np.flatnonzero(np.isfinite(channel.data))
    numbers = channel.data[index]
    said = (channel.name, channel.axis, channel.quantity, channel.unit, channel.unit_from)
    dtype, missing = str(channel.data.dtype), len(channel.data) - len(numbers)
    if not len(numbers):
        return ChannelSurvey(*said, dtype, len(channel.data), missing)
    levels = levels_of(numbers)
    with_codes = channel.quantity not in NO_CODES
    values = numbers.astype(np.float64)
    with np.errstate(over="ignore", invalid="ignore"):  # values near the end of float64
        mean, std = float(values.mean()), float(values.std(ddof=1)) if len(values) > 1 else None
    run, piles = longest_run(numbers), rails(levels) if with_codes else ()
    return ChannelSurvey(
        *said,
        dtype,
        len(channel.data),
        missing,
        minimum=float(levels.values[0]),
        maximum=float(levels.values[-1]),
        mean=mean,
        std=std,
        resolution=resolution(levels),
        longest_run=replace(run, start=int(index[run.start])),
        stuck=with_codes and is_stuck(numbers),
        rails=piles,
        rails_at=tuple(int(index[np.argmax(values == pile.value)]) for pile in piles),
    )


def channel_remarks(survey: ChannelSurvey, place: Callable[[int], str]) -> tuple[Remark, ...]:
    """Return what a user should know about a channel.

    Parameters
    ----------
    survey : ChannelSurvey
        Of the channel.
    place : callable
        Gives ``file:row`` of a sample.
    """
    remarks = []
    run = survey.longest_run
    if survey.is_constant:
        severity: Severity = "info" if survey.quantity in NO_CODES else "warning"
        what = f"{survey.name!r} is {survey.minimum:g} throughout"
        remarks.append(Remark("constant_channel", severity, what, place(0), subject=survey.name))
    elif survey.stuck and run is not None:
        what = f"{survey.name!r} stays at {run.value:g} for {run.length} samples: stuck?"
        do = "Leave that section out, or record again"
        remarks.append(Remark("stuck", "warning", what, place(run.start), do=do, subject=survey.name))
    for rail, first in zip(survey.rails, survey.rails_at, strict=True):
        code = ", the limit of a converter" if rail.is_code else ""
        what = f"{survey.name!r} piles up at {rail.value:g}{code}: clipped?"
        do = "Record with a larger range"
        remarks.append(Remark("clipped", "warning", what, place(first), rail.count, do, subject=survey.name))
    return tuple(remarks)


GYRO_STEPS = (  # [deg/s]
    *((step, "InvenSense MPU") for step in (1 / 131, 1 / 65.5, 1 / 32.8, 1 / 16.4)),
    *((step, "ST") for step in (0.00875, 0.0175, 0.07)),
    *((scale / 2**15, f"{scale} deg/s full scale over 2^15 codes") for scale in (125, 250, 500, 1000, 2000)),
)
ACC_STEPS = tuple((1 / codes, f"{codes} LSB/g") for codes in (16384, 8192, 4096, 2048))  # [g]
UNNAMED = re.compile(r"(?:.*_)?[0-9]+")  # column_3, data_2
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


def unit_hints(recording: Recording, surveys: Sequence[ChannelSurvey]) -> tuple[Hint, ...]:
    """Return a hint for each group, or unnamed channel, whose unit nobody said.

    Parameters
    ----------
    recording : Recording
        As read.
    surveys : sequence of ChannelSurvey
        Of its channels, in order.
    """
    hints: list[Hint] = []
    pairs = list(zip(recording.channels, surveys, strict=True))
    for group in ("gyro", "acc", "temperature"):
        members = [(c, s) for c, s in pairs if c.quantity == group and c.unit is None]
        if members:
            hints.append(_group_hint(group, [c for c, _ in members], [s for _, s in members]))
    for channel, survey in pairs:
        if channel.unit is None and channel.quantity == "" and (channel.axis or UNNAMED.fullmatch(channel.name)):
            hints += _unnamed_hint(survey)
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


def _norm(channels: Sequence[Channel]) -> Hint | None:
    """Gravity in the median norm of a triad; in the median of a single axis it may hide."""
    if len(channels) != 3:
        return None
    with np.errstate(over="ignore"):
        norm = float(np.nanmedian(np.sqrt(sum(c.data.astype(np.float64) ** 2 for c in channels))))
    for unit, low, high in AT_REST:
        if low <= norm <= high:
            return Hint("acc", unit, f"median |acc| {norm:.4g}")
    return None


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
    found = _sensor(median(steps), table)
    return Hint(group, unit, f"step {median(steps):.6g}, as {found}") if found else None


def _sensor(step: float, table: Sequence[tuple[float, str]]) -> str:
    return next((name for known, name in table if abs(step - known) <= STEP_AGREES * known), "")


def _temperature(surveys: Sequence[ChannelSurvey]) -> Hint | None:
    """Usual range on one of the two scales."""
    low = min((s.minimum for s in surveys if s.minimum is not None), default=np.nan)
    high = max((s.maximum for s in surveys if s.maximum is not None), default=np.nan)
    for unit, (first, last) in (("degC", CELSIUS), ("K", KELVIN)):
        if first <= low and high <= last:
            return Hint("temperature", unit, f"temperature from {low:.4g} to {high:.4g}")
    return None


def _unnamed_hint(survey: ChannelSurvey) -> list[Hint]:
    """Hint for a channel whose name says nothing."""
    if survey.resolution is not None:
        found = _sensor(survey.resolution, GYRO_STEPS)
        if found:
            return [Hint(survey.name, "deg/s", f"step {survey.resolution:.6g}, as {found}")]
    counts = _counts(survey.name, [survey])
    return [counts] if counts and survey.longest_run and survey.resolution else []
