"""The gate: each axis of a recording is looked through before a procedure sees it.

Columns are screened as they are stored, before the chain (``signals.screening``). Samples that are no readings become
NaN in the body axes that they enter; each finding is a remark with the recording and the row, each kind of sample an
exclusion with its count.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, made
from ...core.key import AXES
from ...core.recording import Channel, Recording
from ...core.remarks import Remark
from ...procedures.protocol import Exclusion
from ...sensors.chain.converter import Chain
from ...signals.screening.remarks import remarks_of
from ...signals.screening.screen import NO_READINGS, Finding, Screening, screen
from ...signals.screening.slow import stuck_remark, stuck_slow
from ...signals.sense.change import Change
from ...signals.time.samples import Flags
from ..file.recordings import RecordingEntry
from ..file.sensors import Sensor

RULE = "screened"
READ = "missing"  # what the reader has remarked on
MIXED = 1e-9  # direction cosine from which a sensor axis enters a body axis


@dataclass(frozen=True, eq=False)
class Gate:
    """What columns show, and where axes change: each is looked through once, however many tests read it."""

    found: dict[tuple[str, str, int, bool], Screening] = field(
        default_factory=dict[tuple[str, str, int, bool], Screening]
    )
    changed: dict[Hashable, tuple[Change, ...]] = field(default_factory=dict[Hashable, tuple[Change, ...]])

    def screening(self, file: str, channel: Channel, at_rest: bool) -> Screening:
        """Return what a column of a file shows."""
        key = (file, channel.name, len(channel.data), at_rest)
        if key not in self.found:
            self.found[key] = screen(channel.data, at_rest)
        return self.found[key]


@dataclass(frozen=True, eq=False)
class Passed:
    """A recording without the samples that are no readings, remarks on it, and what was left out."""

    recording: Recording
    remarks: tuple[Remark, ...] = ()
    exclusions: tuple[Exclusion, ...] = ()


def passed(
    gate: Gate,
    name: str,
    entry: RecordingEntry,
    sensor: Sensor,
    raw: Recording,
    body: Recording,
    *,
    at_rest: bool,
    chosen: Flags | None = None,
    chain: Chain | None = None,
) -> Passed:
    """Return a recording in body axes without the samples of its axes that are no readings.

    Parameters
    ----------
    gate : Gate
        That knows columns looked through before.
    name, entry, sensor : str, RecordingEntry, Sensor
        Of the recording.
    raw, body : Recording
        As stored, and in body axes, SI; of one length.
    at_rest : bool
        Whether steps, changes of the noise and waves mean something.
    chosen : ndarray of bool, shape (n,), optional
        Samples that the test takes: of others nothing is said.
    chain : Chain, optional
        Whose ends of the converter are left out, and remarked on, already.
    """
    place = place_in(raw, entry.file)
    left_out: dict[str, Flags] = {}
    remarks: list[Remark] = []
    exclusions: list[Exclusion] = []
    for axis in (axis for axis in AXES if axis in (entry.channels or {})):
        channel = raw.channel((entry.channels or {})[axis].column)
        found = gate.screening(entry.file, channel, at_rest)
        if not found.findings:
            continue
        entered = [one for one in _entered(sensor, axis) if one in body.names]
        there = _there(body, entered, chosen)
        kept: list[Finding] = []
        for one in found.findings:
            if one.code == READ or (one.code == "saturated" and _is_known(one, chain)):
                continue
            flags = there
            if one.code in NO_READINGS:
                flags = found.screened(channel.data, (one.code,))
                for name_of_body in entered:
                    known = left_out.get(name_of_body)
                    left_out[name_of_body] = flags if known is None else known | flags
                flags = flags & there
                there ^= flags
            kept += _inside(one, flags)
        shown = _shown(channel)
        said = remarks_of(
            replace(found, findings=tuple(kept)), f"recording {name}: {channel.name}", place, shown, raw.sample_interval
        )
        remarks += [replace(remark, axis=axis, recording=name) for remark in said]
        exclusions += [
            Exclusion(RULE, f"screening: {one.code}", remark.what, remark.where, axis, one.count, "sample")
            for one, remark in zip(kept, said, strict=True)
            if one.code in NO_READINGS
        ]
    return Passed(without(body, left_out), tuple(remarks), tuple(exclusions))


def place_in(raw: Recording, file: str) -> Callable[[int], str]:
    """Return what gives ``file:row`` of a sample, the file as the campaign names it; most records need no place."""
    return lambda index: raw.changed(source=replace(raw.source, path=file)).place(index)


SLOW = re.compile(r"(?:temperature|pressure|supply|reference)(?:_|$)")  # names of channels that readings are made with


def without_stuck(name: str, entry: RecordingEntry, raw: Recording, body: Recording) -> Passed:
    """Return a recording without the values of temperature, pressure and reference voltages that are stuck.

    Parameters
    ----------
    name, entry : str, RecordingEntry
        Of the recording.
    raw, body : Recording
        As stored, and in body axes, SI; of one length.
    """
    channels = entry.channels or {}
    slow = [(role, one.column) for role, one in channels.items() if SLOW.match(role)]
    if not slow:
        return Passed(body)
    place = place_in(raw, entry.file)
    readings = [raw.channel(one.column).data for axis, one in channels.items() if axis in AXES]
    left_out: dict[str, Flags] = {}
    remarks: dict[str, Remark] = {}
    exclusions: list[Exclusion] = []
    for role, column in slow:
        channel = raw.channel(column)
        found = None if column in remarks else stuck_slow(channel.data, readings, raw.time_ns)
        if found is not None:
            remark = stuck_remark(found, f"recording {name}: {column}", len(raw), place, _shown(channel))
            remarks[column] = replace(remark, subject=column)
            exclusions.append(
                Exclusion(RULE, "screening: stuck", remark.what, remark.where, "", found.length, "sample")
            )
            left_out[role] = np.zeros(len(raw), dtype=bool)
            left_out[role][found.first : found.last + 1] = True
    return Passed(without(body, left_out), tuple(remarks.values()), tuple(exclusions))


def _entered(sensor: Sensor, axis: str) -> list[str]:
    """Return the body axes that an axis of the sensor enters."""
    if sensor.mounting is None:
        return [axis]
    row = sensor.mounting[AXES.index(axis)]
    return [one for one, cosine in zip(AXES, row, strict=True) if abs(cosine) > MIXED]


def _there(body: Recording, axes: Sequence[str], chosen: Flags | None) -> Flags:
    """Return where the test takes a reading of any of some axes."""
    there = np.zeros(len(body), dtype=bool)
    for axis in axes:
        data = body.channel(axis).data
        for first, stop in batches(data):
            there[first:stop] |= np.isfinite(data[first:stop])
    if chosen is not None:
        there &= chosen
    return there


def _is_known(one: Finding, chain: Chain | None) -> bool:
    """Return whether all values that are held lie at the ends of the converter."""
    if chain is None or chain.codes is None:
        return False
    first, last = chain.codes
    return bool(np.all((one.value <= first) | (one.value >= last)))


def _inside(one: Finding, flags: Flags) -> list[Finding]:
    """Return a finding as it concerns some samples; nothing where it does not."""
    inside = np.array([flags[first : last + 1].any() for first, last in one.places.tolist()], dtype=bool)
    if not inside.any():
        return []
    places, size, value = one.places[inside], one.size[inside], one.value[inside]
    return [
        replace(
            one, places=places, size=size, value=value, count=_count(one, int(np.count_nonzero(flags)), len(places))
        )
    ]


def _count(one: Finding, samples: int, places: int) -> int:
    return samples if one.code in NO_READINGS else places if one.code != "repeated_samples" else one.count


def _shown(channel: Channel) -> Callable[[float], str]:
    return lambda value: f"{value:g} {channel.unit or ''}".rstrip()


def _missing_where(flags: Flags, data: NDArray[Any]) -> NDArray[Any]:
    """Return samples as wide as they are, NaN where flagged, shape (n,)."""
    nan = np.result_type(data, np.float32).type(np.nan)
    return made(len(data), nan.dtype, lambda first, stop: np.where(flags[first:stop], nan, data[first:stop]), data)


def without(body: Recording, left_out: Mapping[str, Flags]) -> Recording:
    """Return a recording with NaN at samples by axis; readings stay as wide as they are."""
    if not left_out:
        return body
    channels = []
    for one in body.channels:
        flags = left_out.get(one.name)
        if flags is None:
            channels.append(one)
        else:
            channels.append(one.changed(data=_missing_where(flags, one.data)))
    return body.changed(channels=tuple(channels))
