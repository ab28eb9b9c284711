"""Cells: means over a bin of temperature on one ramp, so that a slow end of a ramp does not outweigh the rest.

The range of a sensor's temperature is cut into equal bins. The samples of one ramp in one bin are one cell. In each
run, the cells of one bin and one path share the weight 1, so every bin counts the same on each path, however long the
unit stayed in it and how many ramps went through.

Left out, and counted: samples without reading or temperature (``invalid``), before the start-up is over (``warm_up``),
on no path (``turn_over``, module ``signals.segmentation.ramps``), in bins that were seen on one path only
and lie beyond the others (``one_path``), and in cells with few samples (``sparse``).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ....core.batches import any_step, batches, empty, kept, made, near, zeros
from ....core.batches.summaries import median_made
from ....core.errors import DataError
from ....core.estimate import Array
from ....signals.segmentation.ramps import COOLING, WARMING, find_ramps
from ..plan import Plan
from ..recordings import Readings, Sweep, span_of
from . import _kernels_cells as kernels

Indices = NDArray[np.int64]
Paths = NDArray[np.int8]
Mask = NDArray[np.bool_]
R = TypeVar("R")

SPARSE = 0.2  # of the samples of the median cell: a cell with fewer is left out
FEWEST = 3  # samples of a cell
STEPS, LONGEST = 20.0, 1e6  # of a lag, and of a run, that the temperature is filtered in
RULES = ("invalid", "warm_up", "turn_over", "one_path", "sparse")  # that leave samples out
NARROW = 1e-3  # of the range of all samples: cells inside it are at one temperature


class Once:
    """What does not depend on the readings: found once for all sensors that share a thermometer."""

    def __init__(self) -> None:
        self._found: dict[Hashable, object] = {}

    def __call__(self, what: Hashable, make: Callable[[], R]) -> R:
        """Return what stands under a name, made where there is none yet."""
        if what not in self._found:
            self._found[what] = make()
        return self._found[what]  # type: ignore[return-value]  # what its own maker gave

    def __contains__(self, what: Hashable) -> bool:
        """Whether something stands under a name."""
        return what in self._found

    def __getitem__(self, what: Hashable) -> Any:
        """Return what stands under a name."""
        return self._found[what]

    def keep(self, what: Hashable, found: object) -> None:
        """Let something stand under a name: what was found of several at once."""
        self._found[what] = found


@dataclass(frozen=True, eq=False)
class Series:
    """All samples of one sensor, recording after recording."""

    axis: str  # Of the sensor
    temperature: Array  # shape (n,) or (c,): [degC], the mean of a cell
    reading: Array  # shape (n,) or (c,): [unit of the readings], the mean of a cell; NaN where missing
    time: Array  # shape (n,): since power-up [s]; NaN where no time is known
    path: Paths  # shape (n,): 1 warming, -1 cooling, 0 on no ramp
    sweeps: tuple[slice, ...]  # Samples of each recording
    runs: tuple[int, ...]  # Number of the run of each recording
    ramps: tuple[slice, ...]  # Samples of each ramp, and of each recording without one: all samples, in order
    ways: tuple[int, ...]  # 1 or -1 of each ramp, 0 of a recording without one
    span: tuple[float, float]  # Ends of the temperature over all recordings [degC]
    turn_over: float  # [degC]
    rate: Array | None = None  # shape (n,): of the temperature, as a lag smooths it [degC/s]; None: by the cells alone
    once: Once = field(default_factory=Once)  # Of times and temperatures

    def changed(self, **fields: object) -> Series:
        """Return the same with other values of some fields; ``dataclasses.replace`` takes several times as long."""
        found = object.__new__(type(self))
        found.__dict__.update(self.__dict__ | fields)
        return found

    @property
    def together(self) -> dict[str, Array]:
        """Readings by axis of the sensors that share these times and temperatures."""
        return self.once("together", lambda: {self.axis: self.reading})

    @property
    def columns(self) -> Array:
        """Temperature, time, and the readings of all sensors that share them, shape (2 + k, n): of a short record."""
        return self.once(
            "columns", lambda: np.array([self.temperature, self.time, *self.together.values()], dtype=float)
        )

    @property
    def complete(self) -> bool:
        """Whether all sensors of the thermometer were read wherever it was, this one among them, in a short record."""

        def found() -> bool:
            known, read = np.isfinite(self.columns[0]), np.isfinite(self.columns[2:])
            return bool(read.all() or read[:, known].all())

        return self.short and self.reading is self.together.get(self.axis) and self.once("complete", found)

    @cached_property
    def short(self) -> bool:
        """Whether what is found of times and temperatures is kept: not of a long record."""
        return len(self.temperature) <= near()

    @property
    def run(self) -> Indices:
        """Number of the run of each sample, shape (n,)."""
        return np.repeat(self.runs, [one.stop - one.start for one in self.sweeps])

    def of_run(self, run: int) -> list[slice]:
        """Return the samples of the recordings of a run."""
        return [one for one, number in zip(self.sweeps, self.runs, strict=True) if number == run]

    @property
    def runs_of_ramps(self) -> list[int]:
        """Number of the run of each ramp."""
        ends = [one.stop for one in self.sweeps]
        return [self.runs[bisect_right(ends, ramp.start)] for ramp in self.ramps]

    def batches(self) -> Iterator[tuple[int, slice]]:
        """Yield batches of samples of one ramp, each with its number."""
        read: list[NDArray[Any]] = [
            self.temperature,
            self.reading,
            self.time,
            self.path,
            *([] if self.rate is None else [self.rate]),
        ]
        for number, own in enumerate(self.ramps):
            for first, stop in batches(*(one[own] for one in read), size=near()):
                yield number, slice(own.start + first, own.start + stop)

    def smoothed(self, lag: float) -> Series:
        """Return the same with the rate that an element behind by a lag sees: thermometer less element, over the lag.

        On a long ramp it is the rate of the ramp; after a turn it gets there in some lags.
        """
        rate = joined([len(self.time)])
        for run in sorted({*self.runs}):
            t, T, median = self._timed(run)
            if len(t) < FEWEST:
                continue
            step = max(min(median, lag / STEPS), float(t[-1] - t[0]) / LONGEST)
            if step > 0.0:
                even, there = self._evenly(run, t, T, step)
                left = np.exp(-step / lag)
                new = 1.0 - lag / step * (1.0 - left)  # weight of the newer end of a ramp
                behind = np.empty_like(there)
                kernels.fill_behind(new, 1.0 - left - new, left, there, behind)
                for own in self.of_run(run):
                    time, out = self.time[own], rate[own]
                    for first, stop in batches(time, out):
                        out[first:stop] = np.interp(time[first:stop], even, there - behind) / lag
        return self.changed(rate=rate)

    def _evenly(self, run: int, t: Array, T: Array, step: float) -> tuple[Array, Array]:
        """Return even times of a run, and the temperature there less the first."""

        def found() -> tuple[Array, Array]:
            even = np.arange(t[0], t[-1] + step, step)
            return even, _interpolated(even, t, T) - T[0]

        return self.once(("even", run, step), found) if self.short else found()

    def _timed(self, run: int) -> tuple[Array, Array, float]:
        """Return time and temperature of a run, where both are known, in order of time, and the usual step."""

        def found() -> tuple[Array, Array, float]:
            t, T = self._in_order(run)
            if len(t) < FEWEST:
                return t, T, np.nan
            return t, T, median_made(lambda first, stop: np.diff(t[first : stop + 1]), t[:-1])

        return self.once(("timed", run), found) if self.short else found()

    def _in_order(self, run: int) -> tuple[Array, Array]:
        """Return time and temperature of a run, where both are known, in order of time."""
        times, temperatures = [], []
        for own in self.of_run(run):
            t, T = self.time[own], self.temperature[own]
            known = made(len(t), bool, lambda a, b, t=t, T=T: np.isfinite(t[a:b]) & np.isfinite(T[a:b]), t, T)  # type: ignore[misc]
            times.append(kept(t, known))
            temperatures.append(kept(T, known))
        t, T = joined(times), joined(temperatures)
        if any_step(t, lambda step: step < 0.0):
            order = np.argsort(t, kind="stable")
            t, T = t[order], T[order]
        return t, T

    def of(self, reading: Array, axis: str = "") -> Series:
        """Return the same times and temperatures with another reading, of this sensor or another one."""
        return self.changed(reading=reading, axis=axis or self.axis)


def joined(parts: Sequence[Array | int]) -> Array:
    """Return readings end to end, shape (n,): a number stands for so many that are missing; one array is not copied."""
    if len(parts) == 1 and not isinstance(parts[0], int):
        return parts[0]
    sizes = [one if isinstance(one, int) else len(one) for one in parts]
    out, at = empty(sum(sizes), np.float64), 0
    for one, size in zip(parts, sizes, strict=True):
        own = out[at : at + size]
        for first, stop in batches(own, *([] if isinstance(one, int) else [one])):
            own[first:stop] = np.nan if isinstance(one, int) else one[first:stop]
        at += size
    return out


def _interpolated(at: Array, t: Array, x: Array) -> Array:
    """Return a signal at some times, both ascending, shape (m,)."""
    out = np.empty(len(at))
    for first, stop in batches(t, x):
        low = np.searchsorted(at, t[first])
        high = np.searchsorted(at, t[stop]) if stop < len(t) else len(at)
        out[low:high] = np.interp(at[low:high], t[first : stop + 1], x[first : stop + 1])
    return out


@dataclass(frozen=True, eq=False)
class Cells:
    """Means, a row a cell."""

    temperature: Array  # shape (n,) or (c,): [degC], the mean of a cell
    spread: Array  # shape (c,): variance of the temperature [degC^2]
    reading: Array  # shape (n,) or (c,): [unit of the readings], the mean of a cell; NaN where missing
    scatter: Array  # shape (c,): standard deviation of the samples about their own line over temperature
    samples: Array  # shape (c,): how many
    rate: Array  # shape (c,): of the temperature [degC/s]; NaN where no time is known
    time: Array  # shape (c,): mean, since power-up [s]
    path: Indices  # shape (n,) or (c,): 1 warming, -1 cooling, 0 on no ramp
    run: Indices  # shape (n,) or (c,): number of the run
    ramp: Indices  # shape (n,) or (c,): number of the ramp among all
    bin: Indices  # shape (c,): number of the bin, from 0
    weight: Array  # shape (c,): those of one run, path and bin add up to 1
    beside: Array  # shape (k, c): readings of all sensors that share these cells
    sensor: int  # Row of this one among them
    deviation: float  # Of all samples of this one, about their own lines [unit of the readings]
    ends: tuple[float, float]  # Least and largest reading of this one [unit of the readings]
    range: tuple[float, float]  # Ends of the bins that are used [degC]
    bins: int  # That have a cell
    ramps: int  # That have a cell
    used: int  # Samples of all cells
    shared_bins: Indices  # That were seen on both paths
    ways: tuple[int, ...]  # Paths that there are
    root: Array  # shape (c,): of the weight
    left_out: Mapping[str, int] = field(default_factory=dict[str, int])  # Samples by the rule that leaves them out
    both: tuple[float, float] | None = None  # Ends of the temperatures that were seen on both paths [degC]

    once: Once = field(default_factory=Once)  # Of all but reading, scatter and rate

    def __len__(self) -> int:
        return len(self.temperature)

    @classmethod
    def of_own(cls, shared: Mapping[str, object], **fields: object) -> Cells:
        """Return cells of all their fields; the constructor takes several times as long."""
        found = object.__new__(cls)
        found.__dict__.update(shared, **fields)
        return found

    def changed(self, **fields: object) -> Cells:
        """Return the same with other values of some fields; ``dataclasses.replace`` takes several times as long."""
        found = object.__new__(type(self))
        found.__dict__.update(self.__dict__ | fields)
        return found

    @cached_property
    def runs(self) -> int:
        """Number of runs that have a cell."""
        return int(self.run_number.max(initial=-1)) + 1

    @cached_property
    def loops(self) -> int:
        """Number of pairs of a ramp of warming and one of cooling in one run."""
        most, each = int(self.ramp.max()) + 1, []
        for way in (WARMING, COOLING):
            own = self.path == way
            seen = np.flatnonzero(np.bincount(self.run_number[own] * most + self.ramp[own]))
            each.append(np.bincount(seen // most, minlength=self.runs))
        return int(np.minimum(*each).sum())

    @cached_property
    def run_number(self) -> NDArray[np.intp]:
        """Number of the run of each cell, from 0 among those that have one, shape (c,)."""
        return np.unique(self.run, return_inverse=True)[1]

    @cached_property
    def paths_repeated(self) -> bool:
        """Whether each path was seen by two runs or more, or all by the only one."""
        return self.runs < 2 or all(len(np.unique(self.run[self.path == way])) >= 2 for way in self.ways)


def series_of(plan: Plan, readings: Readings, axis: str, others: Sequence[Series] = ()) -> Series:
    """Return all samples of one sensor with their paths; ``others``: those of sensors that may share its thermometer.

    Raises
    ------
    DataError
        ``no_temperature`` if the sensor has none, ``no_temperature_change`` if it hardly changes.
    """
    sweeps = [one for one in readings.sweeps if axis in one.outputs]
    if not any(axis in one.temperature for one in sweeps):
        what, do = f"{axis} sensor: no temperature", "Name its channel: temperature, or temperature_x"
        raise DataError(what, readings.where, "the bias is a function of it", do, "no_temperature")
    reading = joined([one.outputs[axis] for one in sweeps])
    for other in others:
        if all(_alike(one, axis, other.axis) for one in readings.sweeps):
            other.together[axis] = reading
            return other.of(reading, axis)
    lowest, highest = span_of(readings, axis)
    if not highest - lowest >= plan.least_range:
        what = f"{axis} sensor: temperature from {lowest:.4g} to {highest:.4g} degC, a range of {highest - lowest:.3g}"
        why, do = f"a polynomial needs {plan.least_range:g} degC or more", "Ramp the chamber; check the channel"
        raise DataError(what, readings.where, why, do, "no_temperature_change")
    turn_over = plan.turn_over or 0.1 * (highest - lowest)
    labels = readings.labels
    warm = joined([one.temperature.get(axis, len(one)) for one in sweeps])
    time = joined([len(one) if one.time is None else one.time for one in sweeps])
    path, at = zeros(len(warm), np.int8), 0
    own: list[slice] = []
    ramps: list[slice] = []
    ways: list[int] = []
    for one in sweeps:
        mine = slice(at, at + len(one))
        found = None
        with suppress(DataError):  # no temperature is valid
            found = find_ramps(warm[mine], turn_over)
        starts = [at + start for start in found.starts] if found is not None and len(found) else [at]
        if found is not None and len(sweeps) == 1:
            path = found.path
        elif found is not None:
            for first, stop in batches(path[mine], found.path):
                path[at + first : at + stop] = found.path[first:stop]
        ramps += [slice(*ends) for ends in pairwise([*starts, mine.stop])]
        ways += found.ways if found is not None and len(found) else [0]
        own.append(mine)
        at = mine.stop
    runs = tuple(labels.index(one.run) for one in sweeps)
    span = (lowest, highest)
    return Series(axis, warm, reading, time, path, tuple(own), runs, tuple(ramps), tuple(ways), span, turn_over)


def _alike(sweep: Sweep, axis: str, other: str) -> bool:
    """Whether two sensors of a recording share one thermometer, or neither was read."""
    same = sweep.temperature.get(axis) is sweep.temperature.get(other)
    return same and (axis in sweep.outputs) == (other in sweep.outputs)


def cells_of(plan: Plan, series: Series, cut: float = 0.0) -> Cells:
    """Return the cells of one sensor.

    Parameters
    ----------
    plan : Plan
        ``bins`` is used here.
    series : Series
        Its samples.
    cut : float
        Left out after each power-up [s].

    Raises
    ------
    DataError
        ``no_valid_sample`` if none is left, ``no_ramp`` if none is on a path, ``few_samples`` if no bin holds enough of
        them, ``no_temperature_change`` if those that do lie at one temperature.
    """
    if series.complete and series.rate is None:
        found = series.once(_key(plan, cut), lambda: _cells_each([(plan, series, cut)])[0])
        at = list(series.together).index(series.axis)
    else:
        found, at = _of_one_shape(plan.bins, [(plan, series, cut)], alone=True)[0], 0
    if isinstance(found, _Refused):
        raise found.error(series)
    return found[at]


def find_cells(given: Sequence[tuple[Plan, Series, float]]) -> None:
    """Find the cells that `cells_of` wants of several sensors, with the cut of each: of all thermometers at once."""
    own = {(id(one.once), _key(plan, cut)): (plan, one, cut) for plan, one, cut in given
           if one.complete and one.rate is None}  # fmt: skip
    wanted = [(plan, one, cut) for plan, one, cut in own.values() if _key(plan, cut) not in one.once]
    for (plan, one, cut), found in zip(wanted, _cells_each(wanted), strict=True):
        one.once.keep(_key(plan, cut), found)


def _key(plan: Plan, cut: float) -> Hashable:
    return "cells", plan.bins, cut


class _Refused(NamedTuple):
    """Why a sensor has no cells."""

    code: str
    at: float = np.nan  # Where all of it lies [degC]

    def error(self, series: Series) -> DataError:
        """Return it as an error of a sensor."""
        axis, code, why = series.axis, self.code, ""
        if code == "no_valid_sample":
            what, do = "no sample is valid", "Check the rails, the built-in test and the columns"
        elif code == "no_ramp":
            what = f"no sample lies on a ramp of {series.turn_over:.3g} degC or more"
            do = "Ramp the chamber further, or give a smaller turn_over"
        elif code == "few_samples":
            what, why = f"no bin of temperature holds {FEWEST} samples of one ramp", "a mean of fewer has no scatter"
            do = "Give a recording with more samples, or fewer bins"
        else:
            what = f"the bins with {FEWEST} samples or more all lie at {self.at:.4g} degC"
            why, do = "a polynomial needs a range", "Ramp the chamber more slowly; check the channel of the temperature"
        return DataError(f"{axis} sensor: {what}", why=why, do=do, code=code)


def _cells_each(given: Sequence[tuple[Plan, Series, float]]) -> list[list[Cells] | _Refused]:
    """Return the cells of all sensors of each of several thermometers, those of one shape at once."""
    kinds: dict[tuple[int, int, int], list[int]] = {}
    for i, (plan, one, _) in enumerate(given):
        kinds.setdefault((plan.bins, len(one.ramps), len(one.together)), []).append(i)
    found: dict[int, list[Cells] | _Refused] = {}
    for (bins, *_), at in kinds.items():
        own = [given[i] for i in at]
        found.update(zip(at, _of_one_shape(bins, own), strict=True))
    return [found[i] for i in range(len(given))]


def lagging(plan: Plan, series: Series, cells: Cells, lag: float, cut: float) -> Cells:
    """Return cells of a sensor with the rate of the temperature as a lag smooths it, mean over each."""
    slow = series.smoothed(lag)
    assert slow.rate is not None  # noqa: S101 - the series has it
    sums = _Sums.of(1, len(slow.ramps), plan.bins, 1, rated=True)
    sums.add(0, plan, slow, cut, True)
    return cells.changed(rate=sums.means[0, :, -1][cells.ramp, cells.bin])


class _Sums(NamedTuple):
    """What the samples of k readings have in each bin of each ramp, of several clocks."""

    samples: Array  # shape (u, r, b): how many
    means: Array  # shape (u, r, 2 + k, b): of temperature, time, readings, and the rate where there is one
    squares: Array  # shape (u, r, 3 + 2 k, b): about the means, as ``_kernels_cells.add_cells`` has them
    left: (
        Indices  # shape (u, 3): in no bin, by rule: no reading or temperature, before the start-up is over, on no path
    )

    @classmethod
    def of(cls, units: int, ramps: int, bins: int, k: int, rated: bool) -> _Sums:
        """Return those of no sample."""
        rows = (2 + k + rated, 3 + 2 * k)
        means, squares = (np.zeros((units, ramps, row, bins)) for row in rows)
        return cls(np.zeros((units, ramps, bins)), means, squares, np.zeros((units, 3), dtype=np.int64))

    def add(self, u: int, plan: Plan, series: Series, cut: float, alone: bool) -> None:
        """Add the samples of a sensor, ``alone``, or of all that share its thermometer: of a long record in batches."""
        lowest, highest = series.span
        ends = np.array([lowest, (highest - lowest) / plan.bins])
        rows = [series.temperature, series.time, series.reading, *([] if series.rate is None else [series.rate])]
        k = 1 if alone else len(series.together)

        def part(ramps: slice, bounds: Sequence[tuple[int, int]], own: slice) -> None:
            columns = np.array([one[own] for one in rows], dtype=np.float64) if alone else series.columns
            path, limits = np.ascontiguousarray(series.path[own], dtype=np.int8), np.array(bounds, dtype=np.int64)
            samples, means, squares = (one[u, ramps] for one in (self.samples, self.means, self.squares))
            kernels.add_cells(columns, k, path, limits, ends, cut, samples, means, squares, self.left[u])

        if series.short:
            part(slice(None), [(one.start, one.stop) for one in series.ramps], slice(None))
            return
        for ramp, own in series.batches():
            part(slice(ramp, ramp + 1), [(0, own.stop - own.start)], own)


def _of_one_shape(
    bins: int, given: Sequence[tuple[Plan, Series, float]], alone: bool = False
) -> list[list[Cells] | _Refused]:
    """Return the cells of all sensors of each of several clocks with as many ramps, or of the one that is given alone.

    What lies in or next to the temperatures that were seen on both paths is used; all of it with one path only.
    """
    series = [one for _, one, _ in given]
    k, rated = 1 if alone else len(series[0].together), series[0].rate is not None
    sums = _Sums.of(len(given), len(series[0].ramps), bins, k, rated)
    for i, one in enumerate(given):
        sums.add(i, *one, alone)
    count, means, squares, left = sums
    numbers = np.flatnonzero(count)
    samples = count.ravel()[numbers]
    (mean_T, mean_t), mean_y = np.split(_by_row(means, numbers)[: 2 + k], [2])
    var_T, var_t, cov_Tt = _by_row(squares[:, :, :3], numbers) / samples
    var_y, cov_Ty = (_by_row(squares[:, :, 3 + start : 3 + start + k], numbers) / samples for start in (0, k))
    rate = np.divide(cov_Tt, var_t, out=np.full(len(samples), np.nan), where=var_t > 0.0)
    taken = np.divide(cov_Ty**2, var_T, out=np.zeros_like(cov_Ty), where=var_T > 0.0)
    scatter = np.sqrt(np.maximum(var_y - taken, 0.0) * samples / np.maximum(samples - 2.0, 1.0))
    unit, rest = np.divmod(numbers, count[0].size)
    ramp, number = np.divmod(rest, bins)
    way = np.array([one.ways for one in series])[unit, ramp]
    run = np.array([one.runs_of_ramps for one in series])[unit, ramp]
    sized = np.sort(count.reshape(len(given), -1))
    filled = np.bincount(unit, minlength=len(given))
    middle = [sized[range(len(given)), np.minimum(count[0].size - filled + at, count[0].size - 1)]
              for at in ((filled - 1) // 2, filled // 2)]  # fmt: skip
    full = samples >= np.maximum(FEWEST, SPARSE * 0.5 * (middle[0] + middle[1]))[unit]
    refused: dict[int, _Refused] = {}
    for i in np.flatnonzero(np.bincount(unit, full, minlength=len(given)) == 0.0).tolist():
        none = "no_valid_sample" if left[i, 0] == len(series[i].reading) else "no_ramp"
        refused[i] = _Refused("few_samples" if filled[i] else none)
    flat = {
        "temperature": mean_T, "spread": var_T, "samples": samples, "time": mean_t, "path": way, "run": run,
        "ramp": ramp, "bin": number, "rate": _by_row(means[:, :, -1:], numbers)[0] if rated else rate,
        "readings": mean_y, "scatters": scatter, "unit": unit, "full": full,
    }  # fmt: skip
    if refused:
        keep = ~np.isin(unit, [*refused])
        flat = {name: one[..., keep] for name, one in flat.items()}
    kept = [i for i in range(len(given)) if i not in refused]
    found = dict(zip(kept, _used([series[i] for i in kept], bins, flat, left[kept]), strict=True)) if kept else {}
    return [refused[i] if i in refused else found[i] for i in range(len(given))]


def _by_row(sums: Array, numbers: Indices) -> Array:
    """Return rows of what each ramp and bin has, (u, r, c, b), at the numbers of cells: shape (c, n)."""
    return sums.transpose(2, 0, 1, 3).reshape(sums.shape[2], -1)[:, numbers]


def _used(
    series: Sequence[Series], bins: int, flat: Mapping[str, NDArray[Any]], left: Indices
) -> list[list[Cells] | _Refused]:
    """Return the cells that are used, of those of each thermometer, end to end."""
    full, T, samples, number, path = (flat[name] for name in ("full", "temperature", "samples", "bin", "path"))
    starts = np.flatnonzero(np.diff(flat["unit"], prepend=-1))
    unit = np.repeat(np.arange(len(series)), np.diff(starts, append=len(T)))
    span, turn_over = np.array([one.span for one in series]).T, np.array([one.turn_over for one in series])
    shared = _seen(unit, number, full & (path == WARMING), len(series), bins)
    shared &= _seen(unit, number, full & (path == COOLING), len(series), bins)
    looped: Mask = np.asarray(shared.any(axis=1))
    first, last = shared.argmax(axis=1), bins - 1 - shared[:, ::-1].argmax(axis=1)
    low = np.minimum.reduceat(np.where(full & (number == first[unit]), T, np.inf), starts)
    high = np.maximum.reduceat(np.where(full & (number == last[unit]), T, -np.inf), starts)
    reach = turn_over + (span[1] - span[0]) / (np.maximum.reduceat(number, starts) + 1)
    used = full & (~looped[unit] | ((low - reach)[unit] <= T) & ((high + reach)[unit] >= T))
    beyond, sparse = (np.add.reduceat(samples * one, starts).astype(int).tolist() for one in (full & ~used, ~full))
    if not used.all():
        flat, unit = {name: one[..., used] for name, one in flat.items()}, unit[used]
    starts = np.flatnonzero(np.diff(unit, prepend=-1))
    T, number, run, path = (flat[name] for name in ("temperature", "bin", "run", "path"))
    key = ((unit * (int(run.max()) + 1) + run) * 3 + path + 1) * bins + number
    weight = 1.0 / np.bincount(key)[key]  # those of one run, path and bin have the weight 1 together
    wide = np.sqrt(3.0 * flat["spread"])  # no further than any sample
    lowest = np.maximum(span[0], np.minimum.reduceat(T - wide, starts))
    highest = np.minimum(span[1], np.maximum.reduceat(T + wide, starts))
    warm, cool = (_seen(unit, number, path == way, len(series), bins) for way in (WARMING, COOLING))
    its_ramps = [_seen(unit, flat["ramp"], path == way, len(series), len(series[0].ramps)).sum(axis=1)
                 for way in (WARMING, COOLING)]  # fmt: skip
    seen = {
        "bins": np.count_nonzero(warm | cool, axis=1).tolist(),
        "shared_bins": [np.flatnonzero(one) for one in warm & cool],
        "ramps": np.add(*its_ramps).tolist(),
        "ways": [tuple(way for way, on in ((COOLING, cold), (WARMING, hot)) if on)
                 for cold, hot in np.column_stack([cool.any(axis=1), warm.any(axis=1)]).tolist()],
        "root": np.split(np.sqrt(weight), starts[1:]),
        "used": np.add.reduceat(flat["samples"], starts).astype(int).tolist(),
    }  # fmt: skip
    if all(len({*one.runs}) == 1 for one in series):
        seen |= {"runs": [1] * len(series), "run_number": np.split(np.zeros(len(T), dtype=np.intp), starts[1:]),
                 "loops": np.minimum(*its_ramps).tolist()}  # fmt: skip
    total = np.add.reduceat(flat["scatters"] ** 2 * flat["samples"], starts, axis=1)
    deviation = np.sqrt(total / np.add.reduceat(flat["samples"], starts)).T.tolist()
    least, most = (one.reduceat(flat["readings"], starts, axis=1).T.tolist() for one in (np.minimum, np.maximum))
    narrow: list[bool] = np.asarray(~(highest - lowest > NARROW * (span[1] - span[0]))).tolist()
    left_out = (dict(zip(RULES, own, strict=True)) for own in zip(*left.T.tolist(), beyond, sparse, strict=True))
    ends = [*starts[1:].tolist(), len(T)]
    names = ("temperature", "spread", "samples", "rate", "time", "path", "run", "ramp", "bin")
    shared_by = (dict(zip(seen, own, strict=True)) for own in zip(*seen.values(), strict=True))
    its_ends, both_ends = (zip(*one, strict=True) for one in ((lowest.tolist(), highest.tolist()),
                                                             (low.tolist(), high.tolist())))  # fmt: skip
    columns = zip(shared_by, deviation, least, most, starts.tolist(), ends, its_ends, left_out, looped.tolist(),
                  both_ends, narrow, strict=True)  # fmt: skip
    found: list[list[Cells] | _Refused] = []
    for mine, far, low_y, high_y, start, stop, its, out, loop, both, is_narrow in columns:
        if is_narrow:
            found.append(_Refused("no_temperature_change", its[0]))
            continue
        own: dict[str, object] = mine | {name: flat[name][start:stop] for name in names}
        readings, scatters = flat["readings"][:, start:stop], flat["scatters"][:, start:stop]
        own |= {"weight": weight[start:stop], "beside": readings, "range": its, "left_out": out,
                "both": both if loop else None, "once": Once()}  # fmt: skip
        each = enumerate(zip(readings, scatters, far, zip(low_y, high_y, strict=True), strict=True))
        found.append([Cells.of_own(own, reading=reading, scatter=scatter, sensor=i, deviation=deviates, ends=between)
                      for i, (reading, scatter, deviates, between) in each])  # fmt: skip
    return found


def _seen(unit: Indices, number: Indices, which: Mask, units: int, bins: int) -> Mask:
    """Return which bins of each unit some cells lie in, shape (u, b)."""
    return np.asarray(np.bincount((unit * bins + number)[which], minlength=units * bins).reshape(units, bins) > 0)
