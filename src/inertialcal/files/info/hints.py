"""Hints at a unit that nobody said: questions with their reason, never an answer.

Three things give a unit away: an accelerometer at rest reads 1 g; whole numbers in thousands are counts; and
a resolution step that is the least significant bit of a known sensor.

References
----------
.. [1] InvenSense, MPU-6000/MPU-6050 product specification 3.4, 6.1 and 6.2: 131, 65.5, 32.8, 16.4
   LSB/(deg/s); 16384, 8192, 4096, 2048 LSB/g.
.. [2] STMicroelectronics, L3G4200D data sheet, table 4: 8.75, 17.5, 70 mdps/digit.
.. [3] A full scale of 125, 250, ... 2000 deg/s over 2^15 codes.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from ...core.recording import Channel, Recording
from .channel_survey import ChannelSurvey

GYRO_STEPS = (  # [deg/s]
    *((step, "InvenSense MPU") for step in (1 / 131, 1 / 65.5, 1 / 32.8, 1 / 16.4)),
    *((step, "ST") for step in (0.00875, 0.0175, 0.07)),
    *((scale / 2**15, f"{scale} deg/s over 2^15 codes") for scale in (125, 250, 500, 1000, 2000)),
)
ACC_STEPS = tuple((1 / codes, f"{codes} LSB/g") for codes in (16384, 8192, 4096, 2048))  # [g]
UNNAMED = re.compile(r"(?:.*_)?[0-9]+")  # column_3, data_2
STEP_AGREES = 1e-4  # relative; the step is printed with few digits
AT_REST = (("m/s2", 9.0, 10.7), ("g", 0.9, 1.1), ("mg", 900.0, 1100.0))  # 1 g with usual bias and scale error
COUNTS_FROM = 256.0  # whole numbers whose largest is beyond 8 bits
CELSIUS, KELVIN = (-60.0, 130.0), (213.0, 403.0)  # usual range of a sensor


@dataclass(frozen=True)
class Hint:
    """A unit that the numbers suggest.

    Parameters
    ----------
    target : str
        Group or column, as ``--unit`` takes it.
    unit : str
        Suggested; empty where nothing suggests one.
    reason : str
        Why.
    """

    target: str
    unit: str
    reason: str

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
    return known or Hint(group, "", f"{group} has no unit, and its numbers do not tell: say {other}")


def _norm(channels: Sequence[Channel]) -> Hint | None:
    """Gravity in the median norm of a triad; in the median of a single axis it may hide."""
    if len(channels) != 3:
        return None
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
