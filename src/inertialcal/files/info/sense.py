"""What the channels of a file can be at all, as far as their units are known."""

from __future__ import annotations

from collections.abc import Iterator

from ...core.batches import where_steps
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording
from ...core.remarks import Remark
from ...core.units import factor, kind, si_unit
from ...signals.sense.changes import LATE, changes
from ...signals.sense.limits import ARCHIVE, impossible
from .motion import accelerometers, gyros


def sense_remarks(recording: Recording) -> Iterator[Remark]:
    """Yield what is impossible in a recording, and where unit, sign, scale or axes of a sensor change in it."""
    archived = recording.source.reader == ARCHIVE
    for one in recording.channels:
        yield from impossible(one.data, one.unit, repr(one.name), recording.place, archived=archived).remarks
    for sensor in (gyros(recording), accelerometers(recording)):
        channels = [sensor[axis] for axis in AXES if axis in sensor]
        if (
            channels
            and len({one.unit for one in channels}) == 1
            and all(one.data.dtype.kind in "iuf" for one in channels)
        ):
            yield from _changes(recording, channels)


def _changes(recording: Recording, channels: list[Channel]) -> Iterator[Remark]:
    unit = channels[0].unit or ""
    known = kind(unit)
    if known not in ("angular_rate", "acceleration"):
        return
    interval, breaks = recording.sample_interval, None
    if recording.time_ns is not None and interval is not None:
        late = LATE * interval * SECOND
        breaks = where_steps(recording.time_ns, lambda step: step > late)
    driven = [
        one for one in recording.channels
        if one.unit == unit and not one.axis and one not in channels and one.data.dtype.kind in "iuf"
    ]  # fmt: skip
    applied = driven[0].data if driven else None
    numbers = [one for one in recording.channels if one.unit and one.data.dtype.kind in "iuf"]
    gauges = [one.data for one in numbers if kind(one.unit or "") == "pressure"]
    data, names, scale = [one.data for one in channels], [one.name for one in channels], factor(unit, si_unit(unit))
    for one in changes(data, names, known, interval, breaks, applied, at_rest=False, scale=scale, conditions=gauges):
        yield one.remark(recording.place)
