"""Recordings of a unit under changing conditions, as means over settled levels with the power-up that each belongs to.

A level is a stretch in which no condition leaves its value by more than ``ALIKE`` of its range over all recordings. Its
ends, where the condition is on its way, are left out, and ``settle`` after its beginning. A recording in which nothing
changes is one level. A level is one mean (or one a ``block``): its samples share slow noise, so that their number says
little about its error; the fit takes that from the power-ups.

Recordings with one run label are of one power-up; without labels each recording is a power-up of its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from operator import add
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError, PlanError
from ...core.estimate import Array
from ...core.key import AXES, Origin
from ...core.recording import SECOND, Recording
from ...core.remarks import Remark
from ...core.units import convert, kind, si_unit
from ...core.unknowns import Unknowns, joined
from ..corrections import TakenOff, corrected
from ..protocol import Correction, Source
from .entry import SensitivityEntry, conditions_of
from .plan import APPLIED, PRESSURE, REFERENCE, SUPPLY, TEMPERATURE, WARM_UP, Plan

OUTLYING = 0.005  # of the samples at either end of a condition that say nothing of its range
ALIKE = 0.05  # of the range of a condition: a level
STEPPED = 12.0  # deviations of its noise, over which a condition changed
KEPT, TRUNCATED = 0.9, 0.789  # part of the steps, without the largest, and the deviation that is left of normal ones
QUIET = 4.0  # deviations of the noise of a window's mean inside that distance
WINDOWS = 8  # at least, in which a level is looked for
PARTS = 8  # of a level, whose means show its noise
RANGES = {TEMPERATURE: 1.0}  # smallest that is a change [SI]
VOLTAGES = f"{REFERENCE}_voltage"  # channels of reference voltages, with their axis
UNITS = {SUPPLY: "V", PRESSURE: "Pa", TEMPERATURE: "degC", REFERENCE: "V"}


@dataclass(frozen=True, eq=False)
class ConditionRecording:
    """A recording of a unit while conditions changed.

    Parameters
    ----------
    recording : Recording
        Channels named by axis [SI].
    conditions : mapping of str to mapping of str to ndarray, shape (n,)
        By name, then axis: what each sensor is under [SI].
    units : mapping of str to str
        Of the conditions, SI.
    run, name : str
        Power-up, empty where not given; of the recording.
    turned : str
        Axis that the applied input is along; empty where not said.
    corrections : tuple of Correction
        To be taken off each level of it: the recording is as it was read.
    """

    recording: Recording
    conditions: Mapping[str, Mapping[str, Array]]
    units: Mapping[str, str]
    run: str = ""
    name: str = ""
    turned: str = ""
    corrections: tuple[Correction, ...] = ()


@dataclass(frozen=True, eq=False)
class Readings:
    """Means over n levels of all recordings, in the order of time.

    Parameters
    ----------
    axes : tuple of str
        That were read.
    unit : str
        Of the readings, SI.
    run, recording : ndarray of str, shape (n,)
        Power-up and recording of each.
    time : ndarray, shape (n,)
        Middle of the level since the first sample of its power-up [s]; NaN where no time is known.
    samples : ndarray of int, shape (n,)
        Behind each mean.
    values, noise : mapping of str to ndarray, shape (n,)
        Mean of each axis, and its standard uncertainty from the scatter inside the level [unit].
    settling : mapping of str to ndarray, shape (n,)
        Mean of the first half of a level less that of the second [unit].
    conditions : mapping of str to mapping of str to ndarray, shape (n,)
        By name, then axis: mean of the condition; NaN where a recording does not have it [SI].
    units : mapping of str to str
        Of the conditions.
    scatter : mapping of str to float
        Noise of a sample of each condition; 0 where it repeats itself, as a set value does.
    turned : ndarray of str, shape (n,)
        Axis that the applied input is along.
    transients : int
        Samples between levels that were left out.
    taken_off : mapping of Origin to Unknowns
        Of n levels: what is not known of corrections.
    """

    axes: tuple[str, ...]
    unit: str
    run: NDArray[np.str_]
    recording: NDArray[np.str_]
    time: Array
    samples: NDArray[np.int64]
    values: Mapping[str, Array]
    noise: Mapping[str, Array]
    settling: Mapping[str, Array]
    conditions: Mapping[str, Mapping[str, Array]]
    units: Mapping[str, str]
    scatter: Mapping[str, float]
    turned: NDArray[np.str_]
    transients: int = 0
    remarks: tuple[Remark, ...] = ()
    recorded: tuple[ConditionRecording, ...] = field(default=(), repr=False)
    taken_off: TakenOff = field(default_factory=dict[Origin, Unknowns])

    def __len__(self) -> int:
        """Return the number of levels."""
        return len(self.run)

    @property
    def runs(self) -> int:
        """Number of power-ups."""
        return len(self.power_ups)

    @property
    def power_ups(self) -> tuple[str, ...]:
        """Labels of the power-ups, in the order of their first level."""
        return tuple(dict.fromkeys(self.run.tolist()))


def recorded(plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> list[ConditionRecording]:
    """Return the recordings of a test with their conditions.

    Raises
    ------
    PlanError
        ``wrong_value`` for a warm-up after a correction.
    DataError
        ``missing_condition`` where none of them has a condition that is asked for; ``mixed_runs``.
    """
    if corrections and WARM_UP in plan.to:
        what = f"{WARM_UP} after {corrections[0].test}: a start-up is not told from a law over temperature"
        why = "the law is of slow temperatures, the start-up would be in what is taken off"
        raise PlanError(what, why=why, do="Leave after out", code="wrong_value")
    found = [_recorded(source, one, tuple(corrections)) for source in sources for _, one in source.recordings()]
    named = [one.run for one in found if one.run]
    if named and len(named) < len(found):
        without = next(one for one in found if not one.run)
        what = f"recording {without.name} does not name its power-up, others do"
        raise DataError(what, why="power-ups would be ambiguous", do="Name the run of all", code="mixed_runs")
    for name in plan.to:
        lacking = [one.name for one in found if name not in one.conditions and name != WARM_UP]
        if len(lacking) == len(found):
            there = sorted({name for one in found for name in one.conditions})
            what = f"no recording has the condition {name!r}; there are: {', '.join(there) or 'none'}"
            do = f"Name its column: --column {name}=COLUMN, or conditions = {{ {name} = {{ column, unit }} }}"
            raise DataError(what, found[0].recording.source.path, do=do, code="missing_condition")
    return found


def _recorded(source: Source, recording: Recording, corrections: tuple[Correction, ...]) -> ConditionRecording:
    entry = cast("SensitivityEntry", source.entry)
    axes = [axis for axis in AXES if axis in recording.names]
    conditions: dict[str, Mapping[str, Array]] = {}
    units: dict[str, str] = {}
    voltages: dict[str, Array] = {}
    for name in (TEMPERATURE, PRESSURE, SUPPLY, APPLIED, REFERENCE):
        stem = VOLTAGES if name == REFERENCE else name
        own = {axis: channel for axis in axes for channel in (f"{stem}_{axis}", stem) if channel in recording.names}
        by_axis = {axis: f"{stem}_{axis}" if f"{stem}_{axis}" in recording.names else own[axis] for axis in own}
        if by_axis:
            conditions[name] = {axis: _floats(recording, channel) for axis, channel in by_axis.items()}
            units[name] = UNITS.get(name, source.facts.si)
    for axis in axes:  # reference voltages of a sensor without a chain
        named = entry.channels or {}
        given = named.get(f"{REFERENCE}_{axis}") or named.get(REFERENCE)
        if REFERENCE not in conditions and given is not None and given.column in recording.names:
            values = convert(_floats(recording, given.column), given.unit, UNITS[REFERENCE])
            voltages[axis] = values
    if voltages:
        conditions[REFERENCE], units[REFERENCE] = voltages, UNITS[REFERENCE]
    for name, one in conditions_of(entry):
        inside = "degC" if kind(one.unit) == TEMPERATURE else si_unit(one.unit)
        values = convert(_floats(recording, one.column), one.unit, inside)
        conditions[name], units[name] = dict.fromkeys(axes, values), inside
    return ConditionRecording(recording, conditions, units, source.run, source.name, entry.axis or "",
                              corrections)  # fmt: skip


def _floats(recording: Recording, name: str) -> Array:
    return np.asarray(recording.channel(name).data, dtype=np.float64)


def readings_from(plan: Plan, found: Sequence[ConditionRecording], unit: str) -> Readings:
    """Return the means over the levels of all recordings.

    Raises
    ------
    DataError
        ``nothing_left`` where no level is longer than ``settle``; ``no_time`` where that cannot be told.
    """
    names = tuple(dict.fromkeys(name for one in found for name in one.conditions))
    limits = {name: ends([c for one in found for c in one.conditions.get(name, {}).values()]) for name in names}
    ranges = {name: float(np.nan_to_num(high - low)) for name, (low, high) in limits.items()}
    scatter = {name: max((_noise(c) for one in found for c in one.conditions.get(name, {}).values()), default=0.0)
               for name in names}  # fmt: skip
    cut_by = [name for name in names if name in {*plan.to, APPLIED, TEMPERATURE}
              and ranges[name] > max(RANGES.get(name, 0.0), STEPPED * scatter[name])]  # fmt: skip
    ordered = sorted(found, key=lambda one: (_first(one.recording), one.name))
    starts: dict[str, int] = {}
    for one in ordered:
        starts.setdefault(one.run or one.name, _first(one.recording))
    axes = tuple(axis for axis in AXES if any(axis in one.recording.names for one in ordered))
    rows: list[_Level] = []
    taken_off: list[TakenOff] = []
    remarks = [remark for one in ordered for remark in one.recording.remarks]
    remarks += [remark for one in ordered for name in cut_by for remark in _glitches(one, name, *limits[name])]
    transients = 0
    followed: list[bool] = []  # A recording with changes: whether a level after one of them is left
    for one in ordered:
        tolerances = {name: ALIKE * ranges[name] for name in cut_by if name in one.conditions}
        cuts = _cuts(one, tolerances)
        stretches = _levels(one, *cuts, plan)
        whole = _levels(one, *cuts, replace(plan, settle=0.0, block=None))
        followed += [any(start >= whole[0][1] for start, _ in stretches)] if len(whole) > 1 else []
        transients += len(one.recording) - sum(stop - start for start, stop in stretches)
        parts = [_part(one.recording, stretch) for stretch in stretches]
        if one.corrections and parts:
            parts, off = corrected(one.corrections, [(one.name, part) for part in parts])
            taken_off += off
            remarks += [remark for part in parts for remark in part.remarks if remark not in remarks]
        first = starts[one.run or one.name]
        rows += [_level(one, axes, names, *both, first) for both in zip(stretches, parts, strict=True)]
    if not rows or (followed and not any(followed)):
        do = "Shorten settle, or record each level for longer"
        raise DataError(
            f"no level after a change is longer than settle = {plan.settle:g} s", do=do, code="nothing_left"
        )
    units = {name: one.units[name] for one in reversed(ordered) for name in one.units}
    values, noise, settling = (
        {axis: np.array([one.values[axis][i] for one in rows]) for axis in axes} for i in range(3)
    )
    conditions = {
        name: {axis: np.array([one.conditions[name].get(axis, np.nan) for one in rows]) for axis in axes}
        for name in names
    }
    return Readings(
        axes, unit, np.array([one.run for one in rows]), np.array([one.recording for one in rows]),
        np.array([one.time for one in rows]), np.array([one.samples for one in rows], dtype=np.int64),
        values, noise, settling, conditions, units, scatter, np.array([one.turned for one in rows]), transients,
        tuple(remarks), tuple(ordered), joined(taken_off, [1] * len(taken_off)),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Level:
    run: str
    recording: str
    turned: str
    time: float
    samples: int
    values: Mapping[str, tuple[float, float, float]]  # mean, noise, settling
    conditions: Mapping[str, Mapping[str, float]]


def ends(columns: Sequence[Array]) -> tuple[float, float]:
    """Return lowest and highest value of columns but for glitches; not a number where nothing was recorded.

    Glitches are the few samples that lie further from the others than these from each other.
    """
    every = np.concatenate([np.zeros(0), *columns])
    every = every[np.isfinite(every)]
    if not len(every):
        return math.nan, math.nan
    low, high = np.quantile(every, (OUTLYING, 1.0 - OUTLYING), method="closest_observation")
    kept = every[(every >= 2.0 * low - high) & (every <= 2.0 * high - low)] if high > low else every
    return float(kept.min()), float(kept.max())


def _glitches(one: ConditionRecording, name: str, low: float, high: float) -> list[Remark]:
    """Return a remark on samples of a condition outside of what it was."""
    columns = {id(column): column for column in one.conditions.get(name, {}).values()}.values()
    count = sum(int(np.count_nonzero((column < low) | (column > high))) for column in columns)
    if not count:
        return []
    what = f"{name}: {count} samples lie further from the others than these from each other: taken for no level"
    do = "Look at the logger and the wiring of this channel"
    return [Remark("glitches", "warning", what, one.recording.source.path, count, do, subject=name)]


def _noise(column: Array) -> float:
    """Return the standard deviation of a sample about its level: changes of level are among the largest steps."""
    steps = np.sort(np.abs(np.diff(column[np.isfinite(column)])))
    kept = steps[: max(1, round(KEPT * len(steps)))]
    return float(np.sqrt(np.mean(kept**2))) / (TRUNCATED * math.sqrt(2.0)) if len(steps) else 0.0


def _first(recording: Recording) -> int:
    return int(recording.time_ns[0]) if recording.time_ns is not None and len(recording.time_ns) else 0


def _cuts(one: ConditionRecording, tolerances: Mapping[str, float]) -> tuple[list[int], int]:
    """Return where levels of a recording begin, 0 and its length; and the samples that tell a level from the next."""
    n = len(one.recording)
    columns = [(column, tolerances[name]) for name in tolerances
               for column in {id(c): c for c in one.conditions[name].values()}.values()]  # fmt: skip
    size = max((_window(column, tolerance, n) for column, tolerance in columns), default=1)
    count = n // size
    if not columns or count <= 1:
        return [0, n], size
    return _changes([_window_means(c, size) / tolerance for c, tolerance in columns], size, n), size


def _levels(one: ConditionRecording, edges: Sequence[int], size: int, plan: Plan) -> list[tuple[int, int]]:
    """Return the stretches [start, stop) of a recording that are levels, or blocks of them."""
    interval = one.recording.sample_interval
    if plan.settle > 0.0 and len(edges) > 2 and not interval:
        raise DataError("settle without a time axis", one.recording.source.path, do="Give the sample rate",
                        code="no_time")  # fmt: skip
    settle = round(plan.settle / interval) if interval else 0
    found: list[tuple[int, int]] = []
    for i in range(len(edges) - 1):
        start = edges[i] + (max(size, settle) if i else 0)
        stop = edges[i + 1] - (size if i + 2 < len(edges) else 0)
        if stop - start < max(1, 2 * size if len(edges) > 2 else 1):
            continue
        length = stop - start if plan.block is None or not interval else max(1, round(plan.block / interval))
        parts = max(1, (stop - start) // length)
        found += [(start + k * length, start + (k + 1) * length if k + 1 < parts else stop) for k in range(parts)]
    return found


def stays(column: Array) -> NDArray[np.int64]:
    """Return how many samples long a condition stands at each of its levels; none where its noise hides them."""
    low, high = ends([column])
    if not high - low > STEPPED * _noise(column):
        return np.zeros(0, dtype=np.int64)
    tolerance = ALIKE * (high - low)
    size = _window(column, tolerance, len(column))
    edges = np.array(_changes([_window_means(column, size) / tolerance], size, len(column)), dtype=np.int64)
    return edges[1:] - edges[:-1]


def _window(column: Array, tolerance: float, n: int) -> int:
    """Return the samples whose mean tells a level from the next."""
    if n < 2 * WINDOWS:
        return 1
    return int(np.clip(np.ceil((QUIET * _noise(column) / tolerance) ** 2), 1, n // WINDOWS))


def _window_means(column: Array, size: int) -> Array:
    windows = column[: len(column) // size * size].reshape(-1, size)
    means = np.asarray(windows.mean(axis=1), dtype=np.float64)
    for k in np.flatnonzero(~np.isfinite(means)):
        means[k] = _mean(windows[k])
    return means


def _changes(means: Sequence[Array], size: int, n: int) -> list[int]:
    """Return where levels begin, 0 and n: windows that lie within one tolerance of the level so far are of it."""
    first, *others = zip(*(one.tolist() for one in means), strict=True)
    edges, total, members = [0], first, 1
    for k, here in enumerate(others, 1):
        if any(abs(one - whole / members) > 1.0 for one, whole in zip(here, total, strict=True)):
            edges.append(k * size)
            total, members = here, 1
        else:
            total, members = tuple(map(add, total, here)), members + 1
    return [*edges, n]


def _part(recording: Recording, stretch: tuple[int, int]) -> Recording:
    at, times = slice(*stretch), recording.time_ns
    channels = tuple(replace(one, data=one.data[at]) for one in recording.channels)
    return replace(recording, channels=channels, time_ns=None if times is None else times[at])


def _level(one: ConditionRecording, axes: Sequence[str], names: Sequence[str], stretch: tuple[int, int],
           part: Recording, power_up: int) -> _Level:  # fmt: skip
    at = slice(*stretch)
    times = one.recording.time_ns
    middle = (
        float("nan") if times is None else float(0.5 * (int(times[at][0]) + int(times[at][-1])) - power_up) / SECOND
    )
    values = {axis: _summary(_floats(part, axis)) if axis in part.names else (np.nan,) * 3
              for axis in axes}  # fmt: skip
    conditions = {name: {axis: _mean(c[at]) for axis, c in one.conditions.get(name, {}).items()} for name in names}
    return _Level(one.run or one.name, one.name, one.turned, middle, stretch[1] - stretch[0], values, conditions)


def _mean(values: Array) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if len(finite) else float("nan")


def _summary(values: Array) -> tuple[float, float, float]:
    """Return the mean of a level, its uncertainty from its parts, the mean of its first half less the second."""
    half, count = len(values) // 2, min(PARTS, len(values))
    parts = np.array([_mean(one) for one in np.array_split(values, count)]) if count else np.zeros(0)
    parts = parts[np.isfinite(parts)]
    noise = float(np.std(parts, ddof=1) / np.sqrt(len(parts))) if len(parts) > 1 else float("nan")
    return _mean(values), noise, (_mean(values[:half]) - _mean(values[half:])) if half else float("nan")
