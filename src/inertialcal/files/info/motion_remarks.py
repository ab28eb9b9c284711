"""Remarks on motion: a recording of a sensor at rest that is disturbed, or one that is not at rest."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from ...core.recording import Channel, Recording
from ...core.remarks import Remark
from ...signals.segmentation.stillness import Stillness, judge
from .channel_survey import ChannelSurvey

SENSED = ("gyro", "acc")
UNNAMED = re.compile(r"(?:.*_)?[0-9]+")  # column_3, accelBuffer_2
LARGEST = 1e100
MOST = 3  # stretches of disturbance; with more of them the sensor is not at rest


def motion_remarks(recording: Recording, surveys: Sequence[ChannelSurvey]) -> tuple[Remark, ...]:
    """Return one remark on motion or disturbance, or none.

    Parameters
    ----------
    recording : Recording
        As read.
    surveys : sequence of ChannelSurvey
        Of its channels, in order.
    """
    found: dict[str, Stillness] = {}
    for channel, survey in zip(recording.channels, surveys, strict=True):
        if not _is_sensed(channel) or survey.missing or survey.is_constant or _is_beyond(survey):
            continue
        judged = judge(channel.data.astype(np.float64), survey.resolution or 0.0)
        if judged is not None:
            found[channel.name] = judged
    stretches = _merged([(d.first, d.last) for s in found.values() for d in s.disturbances])
    path = recording.source.path
    if not all(s.at_rest for s in found.values()) or len(stretches) > MOST:
        what = "the sensor moves, or its level steps: no recording at rest"
        return (Remark("not_at_rest", "info", what, where=path),)
    if not stretches:
        return ()
    names = ", ".join(name for name, s in found.items() if s.disturbances)
    when = "; ".join(_when(recording, first, last) for first, last in stretches)
    peak = max(d.peak for s in found.values() for d in s.disturbances)
    what = f"not stationary: a disturbance or step {when} in {names}, up to {peak:.0f} times the noise"
    do = "Leave that stretch out"
    return (Remark("disturbance", "warning", what, where=path, count=len(stretches), do=do),)


def _is_beyond(survey: ChannelSurvey) -> bool:
    """Whether the numbers are so large that their squares are none."""
    return max(abs(survey.minimum or 0.0), abs(survey.maximum or 0.0)) > LARGEST


def _is_sensed(channel: Channel) -> bool:
    """Whether a channel is one of a sensor, or may be for all that its name says."""
    unsaid = channel.quantity == "" and (channel.axis or UNNAMED.fullmatch(channel.name))
    return channel.quantity in SENSED or bool(unsaid)


def _merged(stretches: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Stretches that overlap or touch, as one."""
    merged: list[tuple[int, int]] = []
    for first, last in sorted(stretches):
        if merged and first <= merged[-1][1] + 1:
            merged[-1] = (merged[-1][0], max(last, merged[-1][1]))
        else:
            merged.append((first, last))
    return merged


def _when(recording: Recording, first: int, last: int) -> str:
    """Time since the first sample, or sample numbers where there is no time."""
    seconds, interval = recording.seconds, recording.sample_interval
    if seconds is not None:
        return f"from {seconds[first]:.4g} s to {seconds[last]:.4g} s"
    if interval is not None:
        return f"from {first * interval:.4g} s to {last * interval:.4g} s"
    return f"from sample {first + 1} to {last + 1}"
