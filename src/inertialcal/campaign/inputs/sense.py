"""What the channels of a recording can be at all: impossible values, and changes of unit, sign, scale or axis in it.

Every channel that a procedure reads is held against what is physically possible for its kind of unit, the axes also
against the stated range of the sensor (``signals.sense.limits``). What is impossible becomes NaN, with a remark and an
exclusion. All axes together are looked through for a change of what they record (``signals.sense.changes``).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import where_steps
from ...core.errors import DataError
from ...core.key import AXES
from ...core.recording import SECOND, Recording, Times
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.units import factor, kind
from ...procedures.protocol import Exclusion, Facts
from ...signals.sense.change import Change
from ...signals.sense.changes import LATE, MOST, averaged, changes
from ...signals.sense.limits import ARCHIVE, impossible
from ...signals.time.samples import Flags, Indices
from ...signals.time.time_axis import step_ends
from ..file.recordings import ChannelEntry, RecordingEntry
from .gate import Passed, place_in, without

RULE = "impossible"
APPLIED = "applied"
CONDITIONS = ("pressure", "voltage")  # kinds of unit
FEW = 1000  # samples that tell of gravity
NEAR = 0.1  # of gravity: usual bias and error of scale


def sensible(
    name: str,
    entry: RecordingEntry,
    facts: Facts,
    raw: Recording,
    body: Recording,
    *,
    at_rest: bool,
    chosen: Flags | None = None,
    mounting: Sequence[Sequence[float]] | None = None,
    known: dict[Hashable, tuple[Change, ...]] | None = None,
    key: Hashable = None,
    scaled: bool = False,
) -> Passed:
    """Return a recording without values that are impossible, with what there is to say of its sense.

    Parameters
    ----------
    name, entry, facts : str, RecordingEntry, Facts
        Of the recording and its sensor.
    raw, body : Recording
        As stored, and in body axes, SI, named by role; of one length.
    at_rest : bool
        Whether the sensor was at rest.
    chosen : ndarray of bool, shape (n,), optional
        Samples that the test takes: of others nothing is said.
    mounting : shape (3, 3), optional
        Of the sensor: its axes from those of the body. Columns change places as the sensor has them.
    known : dict, optional
        Changes that were looked for before, by ``key``.
    scaled : bool
        Whether the axes of the body are those that are stored but for one factor: these show nothing more.

    Raises
    ------
    DataError
        ``impossible_temperature``, ...: if a channel holds nothing else.
    """
    place = place_in(raw, entry.file)
    given = entry.channels or {}
    left_out: dict[str, Flags] = {}
    remarks: list[Remark] = []
    exclusions: list[Exclusion] = []
    for one in body.channels:
        if one.name not in given and one.name not in AXES:
            continue
        values = one.data if chosen is None else np.where(chosen, one.data, np.nan)
        ends = facts.input_range if one.name in AXES and not facts.oblique else None
        archived = raw.source.reader == ARCHIVE and one.name in AXES
        found = impossible(values, one.unit, f"recording {name}, {one.name}", place, ends, archived, facts.unit)
        axis = one.name if one.name in AXES else ""
        remarks += [replace(remark, axis=axis, recording=name) for remark in found.remarks]
        if not found.remarks or not found.flags.any():
            continue
        said = found.remarks[0]
        if not np.any(np.isfinite(values) & ~found.flags):
            raise DataError(said.what, said.where, "nothing else is in the channel", said.do, said.code)
        left_out[one.name] = found.flags
        exclusions.append(Exclusion(RULE, f"limits: {said.code}", said.what, said.where, axis, said.count, "sample"))
    columns = {one.column for one in given.values()}
    for one in raw.channels:  # that the test does not read, but that tell of the file
        if one.name not in columns:
            for remark in impossible(one.data, one.unit, f"recording {name}, {one.name} (not used)", place).remarks:
                remarks.append(replace(remark, severity="warning", recording=name))
    remarks += _in_another_unit(name, facts, raw, body, given)
    whole, body = body, without(body, left_out)
    axes = [axis for axis in AXES if axis in body.names]
    if axes and facts.kind is not None:
        known = known if known is not None else {}
        if key not in known:
            stored = [raw.channel(given[axis].column).data for axis in axes if axis in given and not scaled]
            # What was left out may be in another unit
            bodies = [body, whole] if left_out.keys() & {*axes} else [body]
            found_in = (_changes(one, axes, at_rest, chosen, mounting, stored) for one in bodies)
            known[key] = next(filter(None, found_in), ())
        named = (change.remark(place) for change in known[key])
        remarks += [replace(one, what=f"recording {name}: {one.what}", recording=name) for one in named]
    return Passed(body, tuple(remarks), tuple(exclusions))


def _in_another_unit(
    name: str, facts: Facts, raw: Recording, body: Recording, given: Mapping[str, ChannelEntry]
) -> Iterator[Remark]:
    """Yield a remark where a triad reads gravity as 1 m/s^2, or as 9.8 g: as of a file that states a wrong unit."""
    if facts.kind != "accelerometer" or not set(AXES) <= {*body.names} & given.keys():
        return
    if any(kind(raw.channel(given[axis].column).unit or "count") != "acceleration" for axis in AXES):
        return
    rows = slice(None, None, max(1, len(body) // FEW))
    values = np.column_stack([body.channel(axis).data[rows] for axis in AXES])
    values = values[np.isfinite(values).all(axis=1)]
    norm = float(np.median(np.sqrt((values**2).sum(axis=1)))) if len(values) else 0.0
    for stated, meant in (("m/s^2", "g"), ("g", "m/s^2")):
        gravity = factor("g", "m/s^2") * factor(stated, meant)  # as it is read then
        if abs(norm - gravity) <= NEAR * gravity:
            shown = f"{number(norm * factor('m/s^2', stated), 3)} {stated}"
            what = (
                f"recording {name}: the median |acc| is {shown}: that is gravity in {meant}. Is the stated unit wrong?"
            )
            do = f"If so, state {meant}, whatever the file says"
            yield Remark("gravity_in_another_unit", "warning", what, raw.source.path, do=do, recording=name)


def _changes(
    body: Recording,
    axes: Sequence[str],
    at_rest: bool,
    chosen: Flags | None,
    mounting: Sequence[Sequence[float]] | None,
    stored: Sequence[NDArray[Any]],
) -> tuple[Change, ...]:
    """Return changes of the axes of a sensor, or of its columns, where a bias was taken off them in between."""
    rows = slice(None) if chosen is None or chosen.all() else np.flatnonzero(chosen)
    interval, breaks = body.sample_interval, None
    if body.time_ns is not None and interval is not None:
        breaks = _breaks(body.time_ns if isinstance(rows, slice) else body.time_ns[rows], LATE * interval * SECOND)
    n = len(body) if isinstance(rows, slice) else len(rows)
    size = max(1, -(-n // MOST))  # samples that are joined: of a long record all that follows is short
    if breaks is not None:
        breaks = -(-breaks // size)
    interval = None if interval is None else interval * size
    applied = averaged(body.channel(APPLIED).data[rows], size) if APPLIED in body.names else None
    others = [one for one in body.channels if one.name not in (*AXES, APPLIED) and one.unit]
    conditions = [averaged(one.data[rows], size) for one in others if kind(one.unit or "") in CONDITIONS]
    unit = body.channel(axes[0]).unit or ""
    data = [averaged(body.channel(axis).data[rows], size) for axis in axes]
    if mounting is not None and len(axes) == len(AXES):
        data = list(np.asarray(mounting) @ np.array(data))
    of_unit = kind(unit) if unit else ""
    means = [averaged(column[rows], size) for column in stored]
    columns = [np.where(np.isfinite(x), own, np.nan) for x, own in zip(data, means, strict=False)]
    if all(np.array_equal(x, own, equal_nan=True) for x, own in zip(data, columns, strict=False)):
        columns = []  # nothing was taken off them, and no factor applied
    found = changes(data, axes, of_unit, interval, breaks, applied, at_rest, columns, conditions=conditions)
    at = [one.index * size for one in found]
    if not isinstance(rows, slice):
        at = [int(rows[one]) for one in at]
    return tuple(replace(one, index=index) for one, index in zip(found, at, strict=True))


def _breaks(time_ns: Times, longest: float) -> Indices:
    """Return the samples before which more time than the longest step is missing [ns]."""
    if step_ends(time_ns)[1] <= longest:
        return np.empty(0, dtype=np.int64)
    return where_steps(time_ns, lambda step: step > longest)
