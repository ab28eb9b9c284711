"""A recording of a stepped table without a campaign file: which channel is what, and its dwells.

Told by names and units, as for a reduced table. Which axis was turned is never taken from the numbers; where nothing
says it, the message names the axis that follows the table.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...core.axes import AXES
from ...core.errors import DataError, UsageError
from ...core.recording import Recording
from ...core.units import convert, kind, normalise
from ...procedures.rate_table.procedure import PROCEDURE
from ...procedures.rate_table.recordings import APPLIED
from ...procedures.rate_table.reduction import Plan, Readings
from ..file.recordings import ChannelEntry, RecordingEntry
from ..file.schema import Test
from ..file.sensors import Sensor
from ..inputs.sources import Folder, Ready, facts_of

SAMPLES_A_STEP = 3.0  # fewer samples between changes of the table's rate: no recording of steps
FOLLOWS = 0.9  # correlation with the table above which an axis is named as the one that follows


def is_stepped(recording: Recording, applied: str | None) -> bool:
    """Tell whether a file is a recording on a clock whose table rate goes in steps, and not a row a dwell."""
    if recording.sample_interval is None or recording.time_ns is None or applied not in recording.names:
        return False
    rate = np.asarray(recording.channel(str(applied)).data, dtype=float)
    steps = np.count_nonzero(np.diff(rate[np.isfinite(rate)]) != 0.0) + 1
    return bool(len(recording) >= SAMPLES_A_STEP * steps)


def stepped_columns(recording: Recording, said: Mapping[str, Any]) -> dict[str, Any]:
    """Return which channel is what: ``applied``, ``reading`` by axis, ``unit``, ``axis``.

    Parameters
    ----------
    recording : Recording
        As read.
    said : mapping
        What the user said: ``applied``, and ``reading``, ``axis``, ``unit``, None where nothing.

    Raises
    ------
    UsageError
        If the channels of the sensor, their unit, or the axis that was turned are not said.
    """
    path, applied, axis = recording.source.path, str(said["applied"]), said["axis"]
    by_axis = _by_axis(recording, applied, said["reading"], axis)
    if not by_axis:
        what = f"{path}: no channel is clearly a gyro's axis; it has {', '.join(recording.names)}"
        raise UsageError(what, do="Say it: --reading x=COLUMN --reading y=COLUMN", code="no_column")
    unit = said["unit"] and normalise(said["unit"])
    units = {unit or recording.channel(name).unit for name in (applied, *by_axis.values())}
    spoken = units.pop() if len(units) == 1 else None
    if spoken is None or kind(spoken) != "angular_rate":
        have = ", ".join(f"{name} ({recording.channel(name).unit or '?'})" for name in (applied, *by_axis.values()))
        what = f"{path}: rate and readings have no common unit of angular rate: {have}"
        why = "counts and volts need the chain of a campaign file"
        raise UsageError(what, why=why, do="Say it: --unit deg/s; or type: inertialcal init DIR", code="no_unit")
    turned = axis or (next(iter(by_axis)) if len(by_axis) == 1 else None)
    if turned is None:
        hint = _following(recording, applied, by_axis)
        raise UsageError(f"{path}: nothing says which axis was turned{hint}", do=f"Say it: --axis {hint[-1:] or 'x'}",
                         code="no_axis")  # fmt: skip
    return {"applied": applied, "reading": by_axis, "unit": spoken, "axis": turned}


def stepped_readings(path: Path, columns: Mapping[str, Any], plan: Plan, sensor: Sensor) -> tuple[Readings, str]:
    """Return the dwells of the recording, and SHA-256 of its file.

    Raises
    ------
    DataError
        As ``rate_table.recordings.readings_from``.
    """
    named = {APPLIED: columns["applied"], **columns["reading"]}
    channels = {name: ChannelEntry(column=column, unit=columns["unit"]) for name, column in named.items()}
    entry = RecordingEntry(sensor="sensor", file=path.name, channels=channels, axis=columns["axis"])
    test = Test(id="rate_table", procedure="rate_table", recordings=["file"])
    source = Ready(Folder(path.parent), "file", entry, sensor, facts_of(sensor, {}), PROCEDURE.inputs, test)
    return PROCEDURE.readings(plan, [source]), source.inputs[path.name]


def _by_axis(
    recording: Recording, applied: str, reading: str | Mapping[str, str] | None, axis: str | None
) -> dict[str, str]:
    if isinstance(reading, str):
        found = {axis or recording.channel(reading).axis: reading}
    elif reading is not None:
        found = dict(reading)
    else:
        rates = [c for c in recording.channels if c.name != applied and c.quantity in ("gyro", "") and c.axis in AXES]
        found = {c.axis: c.name for c in rates}
        if len(found) != len(rates):
            return {}
    unknown = [name for name in found.values() if name not in recording.names]
    if unknown:
        have = ", ".join(recording.names)
        raise DataError(
            f"no column {unknown[0]!r}", recording.source.path, do=f"There are: {have}", code="wrong_column"
        )
    return {one: found[one] for one in AXES if one in found}


def _following(recording: Recording, applied: str, by_axis: Mapping[str, str]) -> str:
    """Say which axis follows the table, ending in its letter; empty where none clearly does."""
    rate = convert(recording.channel(applied).data, recording.channel(applied).unit or "rad/s", "rad/s")
    found = []
    for axis, name in by_axis.items():
        values = convert(recording.channel(name).data, recording.channel(name).unit or "rad/s", "rad/s")
        use = np.isfinite(rate) & np.isfinite(values)
        if use.any() and np.ptp(rate[use]) > 0.0 and np.ptp(values[use]) > 0.0:
            found.append((abs(float(np.corrcoef(rate[use], values[use])[0, 1])), float(np.std(values[use])), axis))
    following = max((one for one in found if one[0] > FOLLOWS), key=lambda one: one[1], default=None)
    return "" if following is None else f"; the one that follows {applied!r} is {following[2]}"
