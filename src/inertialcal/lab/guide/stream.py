"""Rows of an instrument as they come, as specific force and angular rate in SI: as `positions` takes the recording.

Which column is what, units and chain are decided once, from the first rows, by what decides for a recording: the
campaign that the call of the procedure stands for. Rows after them take the same way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ...campaign.calls.call import campaign_of
from ...campaign.calls.document import document_of
from ...campaign.calls.given import files_of
from ...campaign.file.load import Campaign
from ...campaign.inputs.chains import body_scale_factors
from ...campaign.inputs.channels import chain_of, in_body_axes
from ...core.errors import UsageError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.recording import SECOND, Channel, Recording, Source, Times
from ...core.units import kind
from ...files.loggers.rows import RowLayout
from ...files.text.headers import heading
from ...procedures import procedure_of
from ...procedures.given import GivenFile, Said
from ...procedures.positions.plan import Plan
from ...procedures.positions.readings import local_gravity
from ..acquisition.relation import OwnTime

SENSORS = {"accelerometer": "acceleration", "gyro": "angular_rate"}


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples in SI."""

    time_ns: Times  # shape (n,): of the instrument's clock, or when they came
    force: Array  # shape (n, 3) [m/s^2]
    rate: Array | None  # shape (n, 3) [rad/s]; None without gyros
    temperature: Array | None  # shape (n,) [degC]


class Stream:
    """What is taken of an instrument.

    Parameters
    ----------
    layout : RowLayout
        Of its rows.
    first : ndarray, shape (n, channels)
        Rows in the unit of each channel, the first that came.
    interval : float
        From row to row [s].
    said : Said
        Of them, as for a file of theirs.
    name : str
        Of the instrument.

    Raises
    ------
    UsageError
        As `positions` if it is not clear what they are; ``no_scale_factor`` where nothing says how counts become SI.
    """

    def __init__(self, layout: RowLayout, first: Array, interval: float, said: Said, name: str) -> None:
        self._interval, self._own = interval, OwnTime(layout)
        self._begun, self._last, self._last_time = False, (0.0, 0.0), 0.0
        self._headings = [(one.name, heading(one.name, one.unit or None)) for one in layout.channels]
        procedure = procedure_of("positions")
        (given,), files = files_of(
            [self._raw(first, np.arange(len(first), dtype=np.float64) * interval, name)], said, procedure.inputs
        )
        one = GivenFile(given, said, {}, {}, partial(files.read, given), partial(files.table, given), has_rows=False)
        document, self.columns, self.remarks = document_of(procedure, [one], {})
        self.campaign: Campaign = campaign_of(document)
        self._channels = files.read(given).channels
        file = self.campaign.file
        self._sensors = [
            (name, entry, sensor, chain_of(entry, sensor))
            for name, entry in file.recordings.items() for sensor in [file.sensors[entry.sensor]]
        ]  # fmt: skip
        self._scale: dict[str, Array] = {}  # Units of a reading in SI, of sensors whose readings stay counts or volts
        for _, _, sensor, _ in self._sensors:
            if kind(sensor.unit) == SENSORS[sensor.kind]:
                continue
            nominal = body_scale_factors(sensor)
            if nominal is None:
                group = "acc" if sensor.kind == "accelerometer" else "gyro"
                scale = "256 count/(m/s2)" if group == "acc" else "16 count/(deg/s)"
                what = f"{group} in {sensor.unit}: nothing says how it becomes {SENSORS[sensor.kind].replace('_', ' ')}"
                do = f'Give the scale factor of its data sheet, for example {group}="{scale}"'
                raise UsageError(what, why="the guide judges by gravity", do=do, code="no_scale_factor")
            self._scale[str(sensor.kind)] = np.array([nominal[axis] for axis in AXES])
        if not any(sensor.kind == "accelerometer" for _, _, sensor, _ in self._sensors):
            raise UsageError(
                f"{name} has no accelerometers", why="gravity is what calibrates", code="no_accelerometers"
            )

    @property
    def gyros(self) -> bool:
        """Whether there are gyros."""
        return any(sensor.kind == "gyro" for _, _, sensor, _ in self._sensors)

    @property
    def gravity(self) -> float:
        """Local gravity [m/s^2]."""
        site = self.campaign.file.site
        return local_gravity(Plan(gravity=site.gravity, latitude=site.latitude, height=site.height or 0.0))

    @property
    def gravity_u(self) -> float:
        """Its standard uncertainty [m/s^2]; 0: not stated."""
        stated = self.campaign.standards.get("gravity.value")
        return 0.0 if stated is None else stated.u

    def _raw(self, values: Array, seconds: Array, name: str = "") -> Recording:
        channels = tuple(
            Channel(name, values[:, i], said.unit, "header" if said.unit else "", said.axis, said.quantity)
            for i, (name, said) in enumerate(self._headings)
        )
        return Recording(channels, np.rint(seconds * SECOND).astype(np.int64), self._interval, source=Source(name))

    def add(self, seconds: Array, values: Array) -> Samples:
        """Return rows in SI: when they came, shape (n,) [s], and their values, shape (n, channels)."""
        at = self._times(seconds, values)
        raw = self._raw(values, at)
        named = zip(self._channels, raw.channels, strict=True)
        raw = replace(raw, channels=tuple(replace(known, data=one.data) for known, one in named))
        found: dict[str, Any] = {}
        for name, entry, sensor, chain in self._sensors:
            body = in_body_axes(raw, name, entry, sensor, chain)
            readings = np.column_stack([np.asarray(body.channel(a).data, np.float64) for a in AXES])
            found[str(sensor.kind)] = readings / self._scale.get(str(sensor.kind), 1.0)
            if "temperature" in body.names:
                found["temperature"] = np.asarray(body.channel("temperature").data, np.float64)
        stamps = np.rint(at * SECOND).astype(np.int64)
        return Samples(stamps, found["accelerometer"], found.get("gyro"), found.get("temperature"))

    def _times(self, seconds: Array, values: Array) -> Array:
        """Return the time of each row by the clock of the instrument, which goes on where that began anew [s]."""
        channel = self._own.channel
        if channel is None:
            return seconds
        place = [name for name, _ in self._headings].index(channel.name)
        own = self._own.seconds(values[:, place])
        before, came = self._last if self._begun else (own[0], seconds[0])
        steps = np.diff(own, prepend=before)
        gone = np.diff(seconds, prepend=came)
        steps = np.where(steps < 0.0, np.maximum(gone, self._interval), steps)
        at = (self._last_time if self._begun else own[0]) + np.cumsum(steps)
        self._last, self._last_time, self._begun = (float(own[-1]), float(seconds[-1])), float(at[-1]), True
        return np.asarray(at)
