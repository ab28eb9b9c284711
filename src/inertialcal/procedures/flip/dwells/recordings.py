"""Dwells of a turned head from recordings: the windows before and after each turn.

Each window loses ``plan.settle`` at its start, counted. An axis is not read in a window with too many samples missing,
invalid or at the rail. The rest of the recording that is quiet shows the noise.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError, PlanError
from ....core.estimate import Array
from ....core.key import AXES
from ....core.recording import SECOND, Recording, Times
from ....core.remarks import Remark, gather
from ....statistics.intervals import coverage_factor
from ..plan import Plan
from ..readings import HalfWidths, Quiet, Readings
from .disturbances import disturbances
from .quiet import MOST, Window, quiet_of, stretches

LOW_PASS, MEDIAN = "low_pass", "median"
STATISTICS = ("mean", MEDIAN, LOW_PASS)
FEWEST = 2  # samples of a window
SHOWN = 48  # blocks that a short record is cut into
LONG = 8.0  # windows' lengths of quiet record that the noise model should have
TEMPERATURE = "temperature"
PREDICTED = "predicted_"  # before the axis
PROBABILITIES = (0.95, 0.99)  # of the textbook's intervals
PER_PERIOD = 100  # means a period of the low-pass' cut-off
ORDER = 2


@dataclass(frozen=True, eq=False)
class FlipRecording:
    """A recording of a head while it was turned.

    Parameters
    ----------
    recording : Recording
        Channels named by axis [m/s^2]; optional: ``temperature``, or ``temperature_x`` of each axis [degC];
        ``gain_x``, ... the gain of an axis; ``predicted_x``, ... the bias by a ground model [m/s^2].
    windows : tuple of Window
        Its dwells.
    name : str
        Of the recording; by default its file.
    """

    recording: Recording
    windows: tuple[Window, ...] = ()
    name: str = ""

    @property
    def place(self) -> str:
        """Name of the recording, for messages."""
        return self.name or self.recording.source.path or "recording"

    @property
    def time_ns(self) -> Times:
        """Stamps [ns]; none without a clock."""
        return np.zeros(0, dtype=np.int64) if self.recording.time_ns is None else self.recording.time_ns

    def span(self, window: Window) -> str:
        """Return start and stop of a window, since the first sample, for messages."""
        first = int(self.time_ns[0]) if len(self.time_ns) else 0
        return f"{(window.start - first) / SECOND:.6g} to {(window.stop - first) / SECOND:.6g} s"


@dataclass(frozen=True, eq=False)
class _Dwell:
    """One window: statistics and half widths of each axis, middle and temperature."""

    window: Window
    values: Mapping[str, Mapping[str, float]]
    half_widths: Mapping[str, tuple[float, ...]]
    time: float
    temperature: Mapping[str, float]
    predicted: Mapping[str, float]
    remarks: tuple[Remark, ...] = ()
    reasons: Mapping[str, str] = field(default_factory=dict[str, str])


def readings_from(plan: Plan, turned: Sequence[FlipRecording]) -> Readings:
    """Return the dwells of the recordings of a test, in any order.

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
    for one in turned:
        _check_windows(one)
    total = sum(len(one.windows) for one in turned)
    dwells: list[_Dwell] = []
    quiet: list[Quiet] = []
    places: list[str] = []
    remarks: list[Remark] = []
    disagreements: list[Remark] = []
    misplaced: list[Remark] = []
    for one in turned:
        used = _settled(plan, one)
        channels = _channels(one)
        # levels near zero, after a ground model, do not show a change of gain: it was looked for before
        known = [a for a in channels if any(name in one.recording.names for name in (f"gain_{a}", PREDICTED + a))]
        unread, disturbed, alike, wrong, turns = disturbances(one.time_ns, channels, used, known)
        own = [_dwell(plan, one, window, channels, unread) for window in used]
        rows = len(dwells) + np.arange(len(own))
        read = {axis: data for axis, data in channels.items() if any(axis in dwell.values for dwell in own)}
        record, more = _quiet(plan, one, used, read, rows, total)
        dwells += own
        start = int(one.time_ns[0])
        shown = np.array([(turn.start_ns - start, turn.stop_ns - start) for turn in turns], dtype=np.float64) / SECOND
        quiet.append(replace(record, turns=shown.reshape(-1, 2)))
        disagreements += [remark.at(one.place) for remark in alike]
        misplaced += [remark.at(one.place) for remark in wrong]
        remarks += [*one.recording.remarks, *(remark.at(one.place) for remark in disturbed), *more]
        places += [f"{one.place}: window {i + 1}" for i in range(len(own))]
    axes = [axis for axis in AXES if any(axis in one.recording.names for one in turned)]
    found = _gathered(plan, axes, dwells, quiet, places, remarks)
    return replace(found, disagreements=tuple(disagreements), misplaced=tuple(misplaced))


def _check(plan: Plan) -> None:
    for name in ("block", "low_pass", "subset"):
        value = getattr(plan, name)
        if not (value > 0.0 and math.isfinite(value)):
            raise PlanError(f"plan.{name} is {value:g}", do="Need a number above 0", code="wrong_value")
    if not 0.0 <= plan.missing < 1.0:
        raise PlanError(f"plan.missing is {plan.missing:g}", do="Need a part below 1", code="wrong_value")
    if not (plan.settle >= 0.0 and math.isfinite(plan.settle)):
        raise PlanError(f"plan.settle is {plan.settle:g} s", do="Need 0 or more", code="wrong_value")


def _check_windows(one: FlipRecording) -> None:
    """Refuse no windows, windows that overlap, and those that end before they start."""
    if not one.windows:
        do = "Give a window before and after each turn, with its position"
        raise DataError("no windows: the positions are not known", one.place, do=do, code="no_windows")
    ordered = sorted(one.windows, key=lambda window: window.start)
    for window in ordered:
        if window.stop <= window.start:
            raise PlanError(f"window {one.span(window)} ends before it starts", one.place)
    for before, after in pairwise(ordered):
        if after.start < before.stop:
            raise PlanError(f"windows {one.span(before)} and {one.span(after)} overlap", one.place)


def _settled(plan: Plan, one: FlipRecording) -> list[Window]:
    """Return the windows without their settling."""
    settle = round(plan.settle * SECOND)
    for window in one.windows:
        if window.stop - window.start <= settle:
            what = f"window {one.span(window)} is no longer than the {plan.settle:g} s of settling"
            do = "Make the dwell longer, or give a shorter plan.settle if the filters allow it"
            raise DataError(what, one.place, "no sample would remain", do, "shorter_than_settling")
    return [replace(window, start=window.start + settle) for window in one.windows]


def _channels(one: FlipRecording) -> dict[str, NDArray[np.floating]]:
    names = [axis for axis in AXES if axis in one.recording.names]
    if not names:
        do = f"The recording has: {', '.join(one.recording.names) or 'none'}"
        raise DataError("no channel x, y or z", one.place, do=do, code="wrong_column")
    if not len(one.time_ns):
        do = "Name the time column in clock"
        raise DataError("no time: windows cannot be placed", one.place, do=do, code="no_time")
    return {axis: one.recording.channel(axis).data for axis in names}


def _dwell(
    plan: Plan, one: FlipRecording, window: Window, channels: Mapping[str, NDArray[np.floating]], unread: Set[str]
) -> _Dwell:
    low, high = (int(at) for at in np.searchsorted(one.time_ns, (window.start, window.stop)))
    if high - low < FEWEST:
        what = f"window {one.span(window)} holds {high - low} sample(s)"
        end = (one.time_ns[-1] - one.time_ns[0]) / SECOND
        raise DataError(what, one.place, do=f"The record runs from 0 to {end:.6g} s", code="empty_window")
    stamps = (one.time_ns[low:high] - window.start) / SECOND
    interval = one.recording.sample_interval or float(np.median(np.diff(stamps)))
    values: dict[str, dict[str, float]] = {}
    widths: dict[str, tuple[float, ...]] = {}
    reasons: dict[str, str] = {}
    remarks = []
    for axis, data in channels.items():
        samples = np.asarray(data[low:high], dtype=np.float64)
        good = samples[np.isfinite(samples)]
        present = float(len(good)) * interval / ((window.stop - window.start) / SECOND)
        doubt = _not_read(plan, one, axis, slice(low, high), 1.0 - present)
        if doubt is not None:
            remarks.append(doubt.at(f"{one.place}: {one.span(window)}"))
        if doubt is not None or axis in unread:
            continue
        values[axis] = {"mean": float(good.mean()), MEDIAN: float(np.median(good))}
        try:
            values[axis][LOW_PASS] = low_passed(stamps, samples, plan.low_pass, interval)[0]
        except DataError as error:
            reasons[LOW_PASS] = error.problems[0].what
        widths[axis] = half_widths(stamps, samples, plan.subset, plan.subsets, interval)
    middle = (0.5 * (window.start + window.stop)) / SECOND
    warm = {axis: _temperature(one, axis, low, high) for axis in channels}
    predicted = {axis: _predicted(one, axis, low, high) for axis in values}
    return _Dwell(window, values, widths, middle, warm, predicted, tuple(remarks), reasons)


def _not_read(plan: Plan, one: FlipRecording, axis: str, inside: slice, absent: float) -> Remark | None:
    """Return why an axis is not read in a window; None where it is."""
    if absent > plan.missing:
        what = f"more than {plan.missing:.0%} of the samples missing, invalid or at the rail: {axis} is not read"
        return Remark("dwell_incomplete", "warning", what, axis=axis)
    name = f"gain_{axis}"
    gains = np.unique(one.recording.channel(name).data[inside]) if name in one.recording.names else np.zeros(0)
    if len(gains) > 1:
        what = f"the gain changes from {gains[0]:g} to {gains[-1]:g} inside the window: {axis} is not read"
        do = "Choose a window at one gain: zero and bias differ between gains"
        return Remark("gain_changed", "warning", what, axis=axis, do=do)
    return None


def _temperature(one: FlipRecording, axis: str, low: int, high: int) -> float:
    """Mean temperature of an axis in a window, by its own channel or that of the head [degC]."""
    there = [name for name in (f"{TEMPERATURE}_{axis}", TEMPERATURE) if name in one.recording.names]
    if not there:
        return math.nan
    values = np.asarray(one.recording.channel(there[0]).data[low:high], dtype=np.float64)
    return float(np.nanmean(values)) if np.isfinite(values).any() else math.nan


def _predicted(one: FlipRecording, axis: str, low: int, high: int) -> float:
    """Mean of the bias that a ground model predicts, over the samples of the axis [m/s^2]."""
    if PREDICTED + axis not in one.recording.names:
        return math.nan
    read = np.isfinite(one.recording.channel(axis).data[low:high])
    values = one.recording.channel(PREDICTED + axis).data[low:high][read]
    return float(values.mean()) if len(values) else math.nan


def _quiet(
    plan: Plan,
    one: FlipRecording,
    used: Sequence[Window],
    channels: Mapping[str, NDArray[np.floating]],
    rows: NDArray[np.intp],
    total: int,
) -> tuple[Quiet, list[Remark]]:
    """Return the quiet part of a recording, and its remarks."""
    parts = stretches(used, int(one.time_ns[0]), int(one.time_ns[-1]))
    lengths = [(window.stop - window.start) / SECOND for window in used]
    need = LONG * max(lengths)
    whole = sum(part.stop - part.start for part in parts) / SECOND
    enough = min(whole, 2.0 * need)
    # longer blocks, so that a long record is kept; shorter ones of whole samples, so that a short one shows its noise
    interval = one.recording.sample_interval or float(np.median(np.diff(one.time_ns))) / SECOND
    short = max(math.floor(whole / SHOWN / interval), 2) * interval
    length = min(max(min(plan.block, short), enough / MOST), *lengths)
    record, lost = quiet_of(one.time_ns, channels, parts, rows, total, length, one.place)
    remarks = []
    if lost:
        what = f"{lost} blocks of {length:g} s lack samples: not used for the noise of those axes"
        remarks.append(Remark("blocks_incomplete", "info", what, one.place))
    quiet = len(record.times) * length
    if quiet < need:
        what = f"{quiet:.6g} s of quiet record, less than {LONG:g} times its longest window ({need:.6g} s)"
        do = "Record longer before and after the turn"
        remarks.append(Remark("short_record", "warning", f"{what}: its noise is hardly known", one.place, do=do))
    return record, remarks


def _gathered(
    plan: Plan,
    axes: Sequence[str],
    dwells: Sequence[_Dwell],
    quiet: Sequence[Quiet],
    places: Sequence[str],
    remarks: list[Remark],
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
    predicted = {axis: np.array([d.predicted.get(axis, np.nan) for d in dwells]) for axis in axes}
    remarks += [remark for d in dwells for remark in d.remarks]
    if plan.settle != 0.0:
        what = f"{plan.settle:g} s left out at the start of each window"
        remarks.append(Remark("settling", "info", what, count=len(dwells)))
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
        remarks=gather(remarks),
        reasons={name: why for d in dwells for name, why in d.reasons.items()},
        predicted={axis: one for axis, one in predicted.items() if np.isfinite(one).any()},
    )


def low_passed(seconds: Array, samples: Array, cutoff: float, interval: float) -> tuple[float, float]:
    """Return the mean of a window after a low-pass, and the length left out for settling [s].

    Parameters
    ----------
    seconds, samples : ndarray, shape (n,)
        Stamps [s] and values; NaN is left out.
    cutoff : float
        Of the filter [Hz].
    interval : float
        From sample to sample [s].

    Raises
    ------
    DataError
        ``shorter_than_settling`` if the window is not longer than the settling at both ends; ``sampled_too_slowly``
        if the cut-off is not below half the sample rate.
    """
    from scipy import signal  # noqa: PLC0415 - heavy import, which commands on tables need not wait for

    settling = 1.0 / cutoff
    length = float(seconds[-1] - seconds[0]) + interval if len(seconds) else 0.0
    if not length > 2.0 * settling:
        what = f"a window of {length:.6g} s is not longer than the {2.0 * settling:.6g} s in which the low-pass settles"
        do = "Make the dwells longer, or give a higher plan.low_pass"
        raise DataError(what, why="no sample would remain", do=do, code="shorter_than_settling")
    step = max(settling / PER_PERIOD, interval)
    if not 2.0 * step < settling:
        what = (
            f"a low-pass at {cutoff:.6g} Hz needs samples less than {0.5 * settling:.6g} s apart, not {interval:.6g} s"
        )
        raise DataError(what, do="Give a lower plan.low_pass", code="sampled_too_slowly")
    at = ((seconds - seconds[0]) / step + 1e-6).astype(np.intp)
    count = max(int(length / step + 1e-6), 1)
    inside = np.isfinite(samples) & (at < count)
    n = np.bincount(at[inside], minlength=count)
    sums = np.bincount(at[inside], samples[inside], minlength=count)
    there, places = n > 0, np.arange(count)
    means = np.interp(places, places[there], sums[there] / n[there])  # of equal steps, those without a sample filled in
    sections = signal.butter(ORDER, cutoff, fs=1.0 / step, output="sos")
    level = float(means.mean())
    smooth = signal.sosfiltfilt(sections, means - level, padtype=None) + level
    cut = round(settling / step)
    return float(smooth[cut : len(smooth) - cut].mean()), 2.0 * settling


def half_widths(seconds: Array, samples: Array, subset: float, subsets: int, interval: float) -> tuple[float, ...]:
    """Return half widths of the t-intervals of the mean of the first sub-means, as the textbook has them.

    Parameters
    ----------
    seconds, samples : ndarray, shape (n,)
        Stamps [s] and values; NaN is left out.
    subset : float
        Length of a sub-mean [s].
    subsets : int
        How many.
    interval : float
        From sample to sample [s].

    Returns
    -------
    tuple of float
        At 95 and 99 %; NaN where the window is too short for them.
    """
    length = float(seconds[-1] - seconds[0]) + interval if len(seconds) else 0.0
    none = (np.nan,) * len(PROBABILITIES)
    if length < subset * subsets * (1.0 - 1e-9):
        return none
    at = np.floor((seconds - seconds[0]) / subset + 1e-9)
    parts = [samples[(at == i) & np.isfinite(samples)] for i in range(subsets)]
    if not all(len(part) for part in parts):
        return none
    scatter = float(np.std([part.mean() for part in parts], ddof=1)) / np.sqrt(subsets)
    return tuple(coverage_factor(subsets - 1.0, p) * scatter for p in PROBABILITIES)
