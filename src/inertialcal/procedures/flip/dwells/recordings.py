"""Dwells of a turned head from recordings: the windows before and after each turn.

The windows are given (``Turned.windows``); each loses ``plan.settle`` at its start, counted. A window with too many
samples missing, invalid or at the rail is not read by that axis. What else is quiet in the recording shows the noise.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ....core.axes import AXES
from ....core.errors import DataError, PlanError
from ....core.estimate import Array
from ....core.recording import SECOND, Recording, Times
from ....core.remarks import Remark, gather
from ..plan import Plan
from ..readings import HalfWidths, Quiet, Readings
from .disturbances import seen
from .quiet import MOST, Window, quiet_of, stretches
from .windows import PROBABILITIES, half_widths, low_passed

LOW_PASS, MEDIAN = "low_pass", "median"
STATISTICS = ("mean", MEDIAN, LOW_PASS)
FEWEST = 2  # samples of a window
LONG = 8.0  # windows' lengths of quiet record that the noise model should see
TEMPERATURE = "temperature"
PREDICTED = "predicted_"  # before the axis


@dataclass(frozen=True, eq=False)
class FlipRecording:
    """A recording of a head while it was turned.

    Parameters
    ----------
    recording : Recording
        Channels named by axis [m/s^2]; ``temperature``, or ``temperature_x`` of each axis, where there is one [degC];
        ``gain_x``, ... where the gain of an axis was recorded; ``predicted_x``, ... the bias that a ground model
        predicts [m/s^2].
    windows : tuple of Window
        Its dwells.
    quiet : tuple of (int, int), optional
        Stretches that are quiet [ns]; by default all but what lies between windows of different position.
    name : str
        Of the recording; its file where not given.
    """

    recording: Recording
    windows: tuple[Window, ...] = ()
    quiet: tuple[tuple[int, int], ...] | None = None
    name: str = ""

    @property
    def place(self) -> str:
        """Name of the recording, for messages."""
        return self.name or self.recording.source.path or "recording"


@dataclass(frozen=True, eq=False)
class _Dwell:
    """One window as it was read: statistics and half widths of each axis, middle and temperature."""

    window: Window
    values: Mapping[str, Mapping[str, float]]
    half_widths: Mapping[str, tuple[float, ...]]
    time: float
    temperature: Mapping[str, float]
    predicted: Mapping[str, float]
    remarks: tuple[Remark, ...] = ()
    reasons: Mapping[str, str] = field(default_factory=dict[str, str])


def readings_from(plan: Plan, turned: Sequence[FlipRecording]) -> Readings:
    """Return the dwells of the recordings of a test.

    Parameters
    ----------
    plan : Plan
        Settling, low-pass, sub-means, block length.
    turned : sequence of FlipRecording
        In any order.

    Raises
    ------
    DataError
        If there is no recording, one has no time (``no_time``), no axis (``wrong_column``), no windows
        (``no_windows``), or a window is no longer than the settling (``shorter_than_settling``) or holds no samples
        (``empty_window``).
    PlanError
        If windows overlap or end before they start, or a setting of the plan is not above 0.
    """
    _check(plan)
    if not turned:
        raise DataError("no recordings", code="no_dwells")
    given = [windows(plan, one) for one in turned]
    total = sum(len(own) for own in given)
    dwells: list[_Dwell] = []
    quiet: list[Quiet] = []
    places: list[str] = []
    remarks: list[Remark] = []
    for one, own in zip(turned, given, strict=True):
        used = _settled(plan, one, own)
        channels = _channels(one)
        rows = len(dwells) + np.arange(len(own))
        told = seen(_time(one), channels, used, [axis for axis in channels if _gain_is_known(one, axis)])
        mine = [_dwell(plan, one, window, channels, told.unread) for window in used]
        dwells += mine
        record, found = _quiet(plan, one, used, _read(channels, mine), rows, total)
        quiet.append(record)
        remarks += [*one.recording.remarks, *(remark.at(one.place) for remark in told.remarks), *found]
        places += [f"{one.place}: window {i + 1}" for i in range(len(own))]
    axes = [axis for axis in AXES if any(axis in one.recording.names for one in turned)]
    return _gathered(plan, axes, dwells, quiet, places, remarks)


def _check(plan: Plan) -> None:
    for name in ("block", "low_pass", "subset"):
        value = getattr(plan, name)
        if not (value > 0.0 and math.isfinite(value)):
            raise PlanError(f"plan.{name} is {value:g}", do="Need a number above 0", code="wrong_value")
    if not 0.0 <= plan.missing < 1.0:
        raise PlanError(f"plan.missing is {plan.missing:g}", do="Need a part below 1", code="wrong_value")
    if not (plan.settle >= 0.0 and math.isfinite(plan.settle)):
        raise PlanError(f"plan.settle is {plan.settle:g} s", do="Need 0 or more", code="wrong_value")


def windows(plan: Plan, one: FlipRecording) -> tuple[Window, ...]:
    """Return the windows of a recording, as given.

    Raises
    ------
    DataError
        ``no_windows`` if none is given.
    PlanError
        If they overlap, or end before they start.
    """
    if not one.windows:
        do = "Give a window before and after each turn, with its position"
        raise DataError("no windows: the positions are not known", one.place, do=do, code="no_windows")
    ordered = sorted(one.windows, key=lambda window: window.start)
    for window in ordered:
        if window.stop <= window.start:
            raise PlanError(f"window {_seconds(window, one)} ends before it starts", one.place)
    for before, after in pairwise(ordered):
        if after.start < before.stop:
            raise PlanError(f"windows {_seconds(before, one)} and {_seconds(after, one)} overlap", one.place)
    return one.windows


def _seconds(window: Window, one: FlipRecording) -> str:
    time_ns = one.recording.time_ns
    first = 0 if time_ns is None or not len(time_ns) else int(time_ns[0])
    return f"{(window.start - first) / SECOND:.6g} to {(window.stop - first) / SECOND:.6g} s"


def _settled(plan: Plan, one: FlipRecording, given: Sequence[Window]) -> list[Window]:
    """Take the settling off every window."""
    settle = round(plan.settle * SECOND)
    for window in given:
        if window.stop - window.start <= settle:
            what = f"window {_seconds(window, one)} is no longer than the {plan.settle:g} s of settling"
            do = "Make the dwell longer, or give a shorter plan.settle if the filters allow it"
            raise DataError(what, one.place, "nothing of it would be left", do, "shorter_than_settling")
    return [replace(window, start=window.start + settle) for window in given]


def _channels(one: FlipRecording) -> dict[str, NDArray[np.floating]]:
    names = [axis for axis in AXES if axis in one.recording.names]
    if not names:
        do = f"The recording has: {', '.join(one.recording.names) or 'none'}"
        raise DataError("no channel x, y or z", one.place, do=do, code="wrong_column")
    if one.recording.time_ns is None or not len(one.recording):
        do = "Name the time column in clock"
        raise DataError("no time: windows cannot be placed", one.place, do=do, code="no_time")
    return {axis: one.recording.channel(axis).data for axis in names}


def _time(one: FlipRecording) -> Times:
    assert one.recording.time_ns is not None  # noqa: S101 - checked with the channels
    return one.recording.time_ns


def _gain_is_known(one: FlipRecording, axis: str) -> bool:
    """Tell whether the gain was recorded, or looked for before a ground model: levels near zero do not show it."""
    return any(name in one.recording.names for name in (f"gain_{axis}", PREDICTED + axis))


def _dwell(
    plan: Plan, one: FlipRecording, window: Window, channels: Mapping[str, NDArray[np.floating]], unread: Set[str]
) -> _Dwell:
    time_ns = _time(one)
    low, high = np.searchsorted(time_ns, (window.start, window.stop))
    if high - low < FEWEST:
        what = f"window {_seconds(window, one)} holds {high - low} sample(s)"
        end = (time_ns[-1] - time_ns[0]) / SECOND
        raise DataError(what, one.place, do=f"The record runs from 0 to {end:.6g} s", code="empty_window")
    stamps = (time_ns[low:high] - window.start) / SECOND
    interval = one.recording.sample_interval or float(np.median(np.diff(stamps)))
    values: dict[str, dict[str, float]] = {}
    widths: dict[str, tuple[float, ...]] = {}
    reasons: dict[str, str] = {}
    remarks = []
    for axis, data in channels.items():
        samples = np.asarray(data[low:high], dtype=np.float64)
        present = float(np.count_nonzero(np.isfinite(samples))) * interval / ((window.stop - window.start) / SECOND)
        doubt = _not_read(plan, one, axis, slice(int(low), int(high)), 1.0 - present)
        if doubt is not None:
            remarks.append(doubt.at(f"{one.place}: {_seconds(window, one)}"))
        if doubt is not None or axis in unread:
            continue
        values[axis], why = _statistics(plan, stamps, samples, interval)
        reasons |= why
        widths[axis] = half_widths(stamps, samples, plan.subset, plan.subsets, interval)
    middle = (0.5 * (window.start + window.stop)) / SECOND
    warm = {axis: _temperature(one, axis, int(low), int(high)) for axis in channels}
    told = {axis: _predicted(one, axis, int(low), int(high)) for axis in values}
    return _Dwell(window, values, widths, middle, warm, told, tuple(remarks), reasons)


def _not_read(plan: Plan, one: FlipRecording, axis: str, inside: slice, absent: float) -> Remark | None:
    """Return why an axis is not read in a window; None where it is."""
    if absent > plan.missing:
        what = f"more than {plan.missing:.0%} of the samples missing, invalid or at the rail: {axis} is not read"
        return Remark("dwell_incomplete", "warning", what, axis=axis)
    name = f"gain_{axis}"
    gains = np.unique(one.recording.channel(name).data[inside]) if name in one.recording.names else np.zeros(0)
    if len(gains) > 1:
        what = f"the gain changes from {gains[0]:g} to {gains[-1]:g} inside the window: {axis} is not read"
        return Remark(
            "gain_changed", "warning", what, axis=axis, do="Choose a window of one gain: its zero and bias are others"
        )
    return None


def _temperature(one: FlipRecording, axis: str, low: int, high: int) -> float:
    """Mean temperature of an axis in a window, by its own channel or that of the head [degC]."""
    there = [name for name in (f"{TEMPERATURE}_{axis}", TEMPERATURE) if name in one.recording.names]
    if not there:
        return math.nan
    values = np.asarray(one.recording.channel(there[0]).data[low:high], dtype=np.float64)
    return float(np.nanmean(values)) if np.isfinite(values).any() else math.nan


def _predicted(one: FlipRecording, axis: str, low: int, high: int) -> float:
    """Mean of the bias that a ground model predicts, over the samples that the axis was read in [m/s^2]."""
    if PREDICTED + axis not in one.recording.names:
        return math.nan
    read = np.isfinite(one.recording.channel(axis).data[low:high])
    values = one.recording.channel(PREDICTED + axis).data[low:high][read]
    return float(values.mean()) if len(values) else math.nan


def _statistics(plan: Plan, stamps: Array, samples: Array, interval: float) -> tuple[dict[str, float], dict[str, str]]:
    good = samples[np.isfinite(samples)]
    found = {"mean": float(good.mean()), MEDIAN: float(np.median(good))}
    try:
        found[LOW_PASS] = low_passed(stamps, samples, plan.low_pass, interval)[0]
    except DataError as error:
        return found, {LOW_PASS: error.problems[0].what}
    return found, {}


def _read(channels: Mapping[str, NDArray[np.floating]], dwells: Sequence[_Dwell]) -> dict[str, NDArray[np.floating]]:
    """Return the axes that some dwell reads: what another one lacks takes no block from them."""
    return {axis: data for axis, data in channels.items() if any(axis in one.values for one in dwells)}


def _quiet(
    plan: Plan,
    one: FlipRecording,
    used: Sequence[Window],
    channels: Mapping[str, NDArray[np.floating]],
    rows: NDArray[np.intp],
    total: int,
) -> tuple[Quiet, list[Remark]]:
    """Return the quiet part of a recording, and what is to be said of it."""
    time_ns = _time(one)
    parts = stretches(used, int(time_ns[0]), int(time_ns[-1]), one.quiet)
    lengths = [(window.stop - window.start) / SECOND for window in used]
    length = _block(plan, lengths, sum(part.stop - part.start for part in parts) / SECOND)
    record, lost = quiet_of(time_ns, channels, parts, rows, total, length, one.place)
    remarks = []
    quiet, need = len(record.times) * length, LONG * max(lengths)
    if lost:
        what = f"{lost} blocks of {length:g} s with missing samples, not used for the noise of the axes that miss them"
        remarks.append(Remark("blocks_incomplete", "info", what, one.place))
    if quiet < need:
        what = f"{quiet:.6g} s of quiet record, less than {LONG:g} times its longest window ({need:.6g} s)"
        do = "Record longer before and after the turn"
        remarks.append(Remark("short_record", "warning", f"{what}: its noise is hardly known", one.place, do=do))
    return record, remarks


def _block(plan: Plan, lengths: Sequence[float], quiet: float) -> float:
    """Length of a block [s]: as planned, or longer, so that what is kept is a long record beside the windows."""
    enough = min(quiet, 2.0 * LONG * max(lengths))
    return min(max(plan.block, enough / MOST), *lengths)


def _gathered(
    plan: Plan,
    axes: Sequence[str],
    dwells: Sequence[_Dwell],
    quiet: Sequence[Quiet],
    places: Sequence[str],
    remarks: Sequence[Remark],
) -> Readings:
    tables = {
        name: {axis: np.array([d.values.get(axis, {}).get(name, np.nan) for d in dwells]) for axis in axes}
        for name in STATISTICS
    }
    none = (np.nan,) * len(PROBABILITIES)
    widths = tuple(
        HalfWidths(p, {axis: np.array([d.half_widths.get(axis, none)[i] for d in dwells]) for axis in axes})
        for i, p in enumerate(PROBABILITIES)
    )
    warm = {axis: np.array([d.temperature.get(axis, np.nan) for d in dwells]) for axis in axes}
    told = {axis: np.array([d.predicted.get(axis, np.nan) for d in dwells]) for axis in axes}
    settling = [] if plan.settle == 0.0 else [_settling(plan, len(dwells))]
    return Readings(
        angle=np.array([d.window.angle for d in dwells]),
        flip=np.array([d.window.flip for d in dwells]),
        outputs=tables["mean"],
        others={name: tables[name] for name in STATISTICS[1:]},
        half_widths=widths,
        time=np.array([d.time for d in dwells]),
        temperature={axis: one for axis, one in warm.items() if np.isfinite(one).any()},
        quiet=tuple(quiet),
        where=tuple(places),
        remarks=gather([*remarks, *(remark for d in dwells for remark in d.remarks), *settling]),
        reasons={name: why for d in dwells for name, why in d.reasons.items()},
        predicted={axis: one for axis, one in told.items() if np.isfinite(one).any()},
    )


def _settling(plan: Plan, count: int) -> Remark:
    return Remark("settling", "info", f"{plan.settle:g} s left out at the start of each window", count=count)
