"""How a unit was held while it was recorded: at rest, at one level, laid into many positions."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ...core.axes import AXES
from ...core.errors import InertialcalError
from ...core.recording import Channel, Recording
from ...core.units import kind
from ...signals.segmentation.segments import detect, static_intervals
from ...signals.segmentation.stillness import judge

SHORT = 1_000  # samples: a shorter record says little about noise, and may be a dwell
APART = 20.0  # standard deviations: levels of files that differ by more were turned at different rates
FEWEST = 6  # static intervals
SHORTEST = 1.0  # [s]
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


def is_still(recording: Recording) -> bool:
    """Whether the gyros of a recording, or else its accelerometers, stand still long enough to tell of their noise."""
    if recording.time_ns is None or len(recording) < SHORT:
        return False
    channels = gyros(recording) or any_accelerometers(recording)
    values = [one.data.astype(np.float64) for one in channels.values()]
    judged = [judge(one[np.isfinite(one)]) for one in values]
    found = [one.at_rest for one in judged if one is not None]
    return bool(found) and all(found)


def of_one_level(recordings: Collection[Recording]) -> bool:
    """Whether recordings at rest have the same level: else each is a dwell at a rate of its own."""
    for axis in AXES:
        values = [one[axis].data.astype(np.float64) for one in map(gyros, recordings) if axis in one]
        if values:
            levels = [float(np.nanmedian(one)) for one in values]
            if max(levels) - min(levels) > APART * max(float(np.nanstd(one)) for one in values):
                return False
    return True


def is_laid(recording: Recording) -> bool:
    """Whether the accelerometers of a recording rest in many orientations, as of a unit that is laid by hand."""
    acc = accelerometers(recording)
    if recording.time_ns is None or len(acc) != len(AXES):
        return False
    values = np.column_stack([np.asarray(acc[axis].data, dtype=np.float64) for axis in AXES])
    try:
        placed = static_intervals(detect(values, recording.time_ns, recording.sample_interval), min_duration=SHORTEST)
    except InertialcalError:
        return False
    if len(placed) < FEWEST:
        return False
    mean = np.array([one.mean for one in placed])
    spread = np.linalg.svd(mean - mean.mean(axis=0), compute_uv=False) / np.sqrt(len(mean))
    return bool(spread[1] > TURNED * np.linalg.norm(mean, axis=1).max())
