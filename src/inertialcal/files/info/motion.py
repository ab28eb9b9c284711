"""How a unit was held while it was recorded: at rest, at one level, laid into many positions."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ...core.batches.summaries import median, moments
from ...core.errors import InertialcalError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording
from ...core.remarks import Remark
from ...core.units import factor, kind
from ...signals.segmentation.segments import detect, static_intervals
from ...signals.segmentation.stillness import Stillness, judge_in_pieces
from ...signals.vibration.recognised import LONGEST, recognised
from ..text.headers import UNNAMED
from .channel_survey import ChannelSurvey, median_norm

SHORT = 1_000  # samples: a shorter record says little about noise, and may be a dwell
APART = 20.0  # standard deviations: levels of files that differ by more were turned at different rates
FEWEST = 6  # static intervals
SHORTEST = 1.0  # [s]
LARGEST = 1e100  # squares of larger numbers are none
FREE_FALL = 0.1  # [g]: on the ground a triad reads 1 g in all
ROUND = 0.2  # of its radius, by which distances from the centre of a sphere may differ
TURNED = 0.3  # of the largest reading at rest, by which the second widest direction of the readings spreads


def accelerometers(recording: Recording) -> dict[str, Channel]:
    """Return the accelerometer channels by axis."""
    return {
        c.axis: c for c in recording.channels
        if c.axis in AXES and (c.quantity == "acc" or (c.unit is not None and kind(c.unit) == "acceleration"))
    }  # fmt: skip


def gyros(recording: Recording) -> dict[str, Channel]:
    """Return the gyro channels by axis: three whose axes nobody said in their order, which is to be confirmed."""
    found = [c for c in recording.channels if c.quantity == "gyro"]
    return {c.axis: c for c in found if c.axis in AXES} or _in_order(found)


def any_accelerometers(recording: Recording) -> dict[str, Channel]:
    """Return the accelerometer channels by axis: three whose axes nobody said in their order."""
    return accelerometers(recording) or _in_order([c for c in recording.channels if c.quantity == "acc"])


def _in_order(channels: Sequence[Channel]) -> dict[str, Channel]:
    """Return three channels as x, y and z, in the order of the file; none where there are not three."""
    return dict(zip(AXES, channels, strict=True)) if len(channels) == len(AXES) else {}


def triad(recording: Recording) -> list[Channel]:
    """Return the accelerometers x, y, z whose unit is known."""
    named = (one for one in recording.channels if one.axis in AXES and one.unit)
    return [one for one in named if kind(one.unit or "") == "acceleration"]


def on_ground(recording: Recording) -> bool:
    """Whether accelerometers whose unit is known feel gravity, or more: a single axis may not show it."""
    channels = triad(recording)
    in_g = [factor(one.unit or "", "g") for one in channels]
    return bool(channels) and max(in_g) * median_norm(channels) >= FREE_FALL


def may_float(recording: Recording) -> bool:
    """Whether accelerometers alone do not feel gravity, all of a known unit: nobody can tell of another."""
    own = accelerometers(recording).values()
    known = all(one.unit is not None and kind(one.unit) == "acceleration" for one in own)
    return bool(own) and known and not gyros(recording) and not on_ground(recording)


def is_still(recording: Recording) -> bool:
    """Whether the gyros of a recording, or else its accelerometers, stand still long enough to tell of their noise."""
    if (recording.time_ns is None and recording.sample_interval is None) or len(recording) < SHORT:
        return False
    channels = gyros(recording) or any_accelerometers(recording)
    judged = [one for channel in channels.values() if (one := judge_in_pieces(channel.data)) is not None]
    return bool(judged) and all(one.at_rest for one in judged) and len(_disturbed(judged)) <= MOST


def of_one_level(recordings: Collection[Recording]) -> bool:
    """Whether recordings at rest have the same level: else each is a dwell at a rate of its own."""
    for axis in AXES:
        values = [one[axis].data for one in map(gyros, recordings) if axis in one]
        if values:
            levels = [median(one) for one in values]
            spread = [np.sqrt(one.squares / max(one.count, 1)) for one in map(moments, values)]
            if max(levels) - min(levels) > APART * max(spread):
                return False
    return True


def is_laid(recording: Recording) -> bool:
    """Whether the accelerometers of a recording rest in many orientations, as of a unit that is laid by hand."""
    acc = accelerometers(recording)
    time_ns = recording.stamps
    if time_ns is None or len(acc) != len(AXES):
        return False
    values = np.column_stack([np.asarray(acc[axis].data, dtype=np.float64) for axis in AXES])
    if np.any(np.abs(values) > LARGEST):
        return False
    try:
        placed = static_intervals(detect(values, time_ns, recording.sample_interval), min_duration=SHORTEST)
    except InertialcalError:
        return False
    if len(placed) < FEWEST:
        return False
    mean = np.array([one.mean for one in placed])
    spread = np.linalg.svd(mean - mean.mean(axis=0), compute_uv=False) / np.sqrt(len(mean))
    largest = np.linalg.norm(mean, axis=1).max()
    if any(one.unit is None or kind(one.unit) == "voltage" for one in acc.values()):  # an output may have a zero
        largest = min(largest, _radius(mean))
    return bool(spread[1] > TURNED * largest)


def _radius(mean: Array) -> float:
    """Return the radius of the sphere that readings of gravity lie on; infinite where they do not lie on one."""
    size = np.abs(mean).max()
    design = np.column_stack([2.0 * mean / size, np.ones(len(mean))])
    found, _, rank, _ = np.linalg.lstsq(design, np.sum((mean / size) ** 2, axis=1), rcond=None)
    distance = np.linalg.norm(mean / size - found[:3], axis=1)
    round_one = rank == design.shape[1] and np.ptp(distance) < ROUND * distance.mean()
    return float(size * distance.mean()) if round_one else np.inf


SENSED = ("gyro", "acc")
MOST = 3  # stretches of disturbance; with more of them the sensor is not at rest


def is_sensed(channel: Channel) -> bool:
    """Whether a channel is a gyro's or an accelerometer's, or may be one."""
    unsaid = channel.quantity == "" and (channel.axis or UNNAMED.fullmatch(channel.name))
    return channel.quantity in SENSED or bool(unsaid)


def _is_shaken(channel: Channel, recording: Recording) -> bool:
    """Whether an accelerometer whose unit is known was on a shaker."""
    interval = recording.sample_interval
    if not interval or channel.unit is None or kind(channel.unit) != "acceleration":
        return False
    if channel.data.dtype.kind not in "iuf" or len(channel.data) > LONGEST:
        return False
    return bool(recognised(np.asarray(channel.data, dtype=np.float64) * factor(channel.unit, "m/s^2"), interval))


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
        beyond = max(abs(survey.minimum or 0.0), abs(survey.maximum or 0.0)) > LARGEST  # its square is no number
        if not is_sensed(channel) or survey.missing or survey.is_constant or beyond:
            continue
        judged = judge_in_pieces(channel.data, survey.resolution or 0.0)
        if judged is not None:
            found[channel.name] = judged
    if any(_is_shaken(channel, recording) for channel in recording.channels):
        what = "the sensor is vibrated, at random or by a swept sine: not a recording at rest"
        return (Remark("not_at_rest", "info", what, where=recording.source.path),)
    stretches = _disturbed(found.values())
    path = recording.source.path
    if not all(s.at_rest for s in found.values()) or len(stretches) > MOST:
        what = "the sensor moves, or its level steps: not a recording at rest"
        return (Remark("not_at_rest", "info", what, where=path),)
    if not stretches:
        return ()
    names = ", ".join(name for name, s in found.items() if s.disturbances)
    when = "; ".join(_when(recording, first, last) for first, last in stretches)
    peak = max(d.peak for s in found.values() for d in s.disturbances)
    what = f"not stationary: a disturbance or step {when} in {names}, up to {peak:.0f} times the noise"
    do = "Leave that section out"
    return (Remark("disturbance", "warning", what, where=path, count=len(stretches), do=do),)


def _disturbed(judged: Collection[Stillness]) -> list[tuple[int, int]]:
    """Return the stretches in which any channel was disturbed; those that overlap or touch are one."""
    merged: list[tuple[int, int]] = []
    for first, last in sorted((d.first, d.last) for s in judged for d in s.disturbances):
        if merged and first <= merged[-1][1] + 1:
            merged[-1] = (merged[-1][0], max(last, merged[-1][1]))
        else:
            merged.append((first, last))
    return merged


def _when(recording: Recording, first: int, last: int) -> str:
    """Time since the first sample, or sample numbers where there is no time."""
    time_ns, interval = recording.time_ns, recording.sample_interval
    if time_ns is not None:
        return f"from {(time_ns[first] - time_ns[0]) / SECOND:.4g} s to {(time_ns[last] - time_ns[0]) / SECOND:.4g} s"
    if interval is not None:
        return f"from {first * interval:.4g} s to {last * interval:.4g} s"
    return f"from sample {first + 1} to {last + 1}"
