"""Cells: means over a bin of temperature on one ramp, so that a slow end of a ramp does not outweigh the rest.

The range of a sensor's temperature is cut into equal bins. The samples of one ramp in one bin are one cell. In each
run, the cells of one bin and one path share the weight 1, so every bin counts the same on each path, however long the
unit stayed in it and how many ramps went through.

Left out, and counted: samples without reading or temperature (``invalid``), before the start-up is over (``warm_up``),
on no path (``turn_over``, module ``signals.segmentation.ramps``), in bins that were seen on one path only
and lie beyond the others (``one_path``), and in cells with few samples (``sparse``).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from ....core.batches import any_step, batches, count, empty, kept, made, near, zeros
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
    def complete(self) -> bool:
        """Whether all sensors of the thermometer were read wherever it was, this one among them, in a short record."""

        def found() -> bool:
            known = np.isfinite(self.temperature)
            return all(bool(np.isfinite(one[known]).all()) for one in self.together.values())

        return self.short and self.reading is self.together.get(self.axis) and self.once("complete", found)

    @property
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
                behind = signal.lfilter([new, 1.0 - left - new], [1.0, -left], there)
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
    range: tuple[float, float]  # Ends of the bins that are used [degC]
    left_out: Mapping[str, int] = field(default_factory=dict[str, int])  # Samples by the rule that leaves them out
    both: tuple[float, float] | None = None  # Ends of the temperatures that were seen on both paths [degC]

    once: Once = field(default_factory=Once)  # Of all but reading, scatter and rate

    def __len__(self) -> int:
        return len(self.temperature)

    def changed(self, **fields: object) -> Cells:
        """Return the same with other values of some fields; ``dataclasses.replace`` takes several times as long."""
        found = object.__new__(type(self))
        found.__dict__.update(self.__dict__ | fields)
        return found

    @property
    def runs(self) -> int:
        """Number of runs that have a cell."""
        return self.once("runs", lambda: int(self.run_number.max(initial=-1)) + 1)

    @property
    def run_number(self) -> NDArray[np.intp]:
        """Number of the run of each cell, from 0 among those that have one, shape (c,)."""
        return self.once("run_number", lambda: np.unique(self.run, return_inverse=True)[1])

    @property
    def bins(self) -> int:
        """Number of bins that have a cell."""
        return self.once("bins", lambda: int(np.count_nonzero(np.bincount(self.bin))))

    @property
    def shared_bins(self) -> Indices:
        """Bins that were seen on both paths."""

        def found() -> Indices:
            size = int(self.bin.max(initial=0)) + 1
            warm, cool = (np.bincount(self.bin[self.path == way], minlength=size) for way in (WARMING, COOLING))
            return np.flatnonzero((warm > 0) & (cool > 0))

        return self.once("shared_bins", found)

    @property
    def paths_repeated(self) -> bool:
        """Whether each path was seen by two runs or more, or all by the only one."""

        def found() -> bool:
            return self.runs < 2 or all(len(np.unique(self.run[self.path == way])) >= 2 for way in self.ways)

        return self.once("paths_repeated", found)

    @property
    def ways(self) -> tuple[int, ...]:
        """Paths that there are."""
        return self.once("ways", lambda: tuple(way for way in (COOLING, WARMING) if np.any(self.path == way)))


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
        found = find_ramps(warm[mine], turn_over) if count(warm[mine], np.isfinite) else None
        starts = [at + start for start in found.starts] if found is not None and len(found) else [at]
        if found is not None:
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
    cells, left = _means(plan, series, cut)
    if left["invalid"] == len(series.reading):
        what, do = f"{series.axis} sensor: no sample is valid", "Check the rails, the built-in test and the columns"
        raise DataError(what, do=do, code="no_valid_sample")
    if not len(cells):
        what = f"{series.axis} sensor: no sample lies on a ramp of {series.turn_over:.3g} degC or more"
        raise DataError(what, do="Ramp the chamber further, or give a smaller turn_over", code="no_ramp")
    frame, used = cells.once("used", lambda: _frame(cells, left, series))
    return frame.changed(reading=frame.beside[cells.sensor], scatter=cells.scatter[used], sensor=cells.sensor)


def _frame(cells: Cells, left: Mapping[str, int], series: Series) -> tuple[Cells, Mask]:
    """Return the cells that are used, and which of all these are.

    Raises
    ------
    DataError
        ``few_samples``, ``no_temperature_change``.
    """
    full = cells.samples >= max(FEWEST, SPARSE * float(np.median(cells.samples)))
    if not full.any():
        what = f"{series.axis} sensor: no bin of temperature holds {FEWEST} samples of one ramp"
        do = "Give a recording with more samples, or fewer bins"
        raise DataError(what, why="a mean of fewer has no scatter", do=do, code="few_samples")
    kept, used = _on_both_paths(cells, full, series)
    lowest, highest = kept.range
    if not highest - lowest > NARROW * (series.span[1] - series.span[0]):
        what = f"{series.axis} sensor: the bins with {FEWEST} samples or more all lie at {lowest:.4g} degC"
        do = "Ramp the chamber more slowly; check the channel of the temperature"
        raise DataError(what, why="a polynomial needs a range", do=do, code="no_temperature_change")
    left_out = {
        **left,
        "one_path": int(cells.samples[full & ~used].sum()),
        "sparse": int(cells.samples[~full].sum()),
    }
    return kept.changed(left_out=left_out), used


def lagging(plan: Plan, series: Series, cells: Cells, lag: float, cut: float) -> Cells:
    """Return cells of a sensor with the rate of the temperature as a lag smooths it, mean over each."""
    slow = series.smoothed(lag)
    assert slow.rate is not None  # noqa: S101 - the series has it
    readings = [series.reading]
    count, sums, _ = _sums(plan, slow, cut, readings, _parts(slow, readings))
    at = cells.ramp, cells.bin
    return cells.changed(rate=sums[-1][at] / count[at])


@dataclass(frozen=True, eq=False)
class _Part:
    """Samples of one ramp."""

    ramp: int  # Its number
    columns: Array  # shape (2 + k, n): temperature, time, readings, and the rate where there is one
    path: Paths  # shape (n,)
    bins: Indices  # shape (n,): which bin each is in, to be found


def _parts(series: Series, readings: Sequence[Array]) -> Iterable[_Part]:
    """Return the samples of some readings on one clock, ramp by ramp; those of a short record are kept."""
    rates = [] if series.rate is None else [series.rate]

    def each() -> Iterator[_Part]:
        for ramp, own in series.batches():
            rows = (series.temperature, series.time, *readings, *rates)
            columns = np.array([one[own] for one in rows], dtype=np.float64)
            path = np.array(series.path[own], dtype=np.int8)
            yield _Part(ramp, columns, path, np.empty(len(path), dtype=np.int64))

    return list(each()) if series.short else _Again(each)


class _Again:
    """What is made anew each time that it is gone through."""

    def __init__(self, make: Callable[[], Iterator[_Part]]) -> None:
        self._make = make

    def __iter__(self) -> Iterator[_Part]:
        return self._make()


def _sums(
    plan: Plan, series: Series, cut: float, readings: Sequence[Array], parts: Iterable[_Part]
) -> tuple[Array, Array, Indices]:
    """Return how many samples each bin of each ramp has, (r, b), sums of the columns, (2 + k, r, b), and how many none.

    These by rule: no reading or temperature, before the start-up is over, on no path. The bins of all are found.
    """
    columns, shape, ends = (
        2 + len(readings) + (series.rate is not None),
        (len(series.ramps), plan.bins),
        _edges(plan, series),
    )
    count, sums, left = np.zeros(shape), np.zeros((shape[0], columns, shape[1])), np.zeros(3, dtype=np.int64)
    for part in parts:
        kernels.find_bins(part.columns, len(readings), part.path, ends, cut, part.bins, left)
        kernels.add_sums(part.columns, part.bins, count[part.ramp], sums[part.ramp])
    return count, np.asarray(sums.swapaxes(0, 1)), left


def _edges(plan: Plan, series: Series) -> Array:
    """Return where the first bin begins, and how wide a bin is [degC]."""
    lowest, highest = series.span
    return np.array([lowest, (highest - lowest) / plan.bins])


def _means(plan: Plan, series: Series, cut: float) -> tuple[Cells, dict[str, int]]:
    """Means of the samples of each ramp in each bin, and how many samples are in none, by rule.

    Of sensors that share a thermometer, all are made at once, of a short record.
    """
    if not series.complete or series.rate is not None:
        each, left = _gathered(plan, series, cut, [series.reading])
        return each[0], left
    together = series.together
    each, left = series.once(("means", plan.bins, cut), lambda: _gathered(plan, series, cut, [*together.values()]))
    return each[list(together).index(series.axis)], left


def _gathered(plan: Plan, series: Series, cut: float, readings: Sequence[Array]) -> tuple[list[Cells], dict[str, int]]:
    """Return the means of some readings on one clock, in two passes, and how many samples are in none, by rule."""
    bins, k = plan.bins, len(readings)
    parts = _parts(series, readings)
    count, sums, none = _sums(plan, series, cut, readings, parts)
    left = dict(zip(("invalid", "warm_up", "turn_over"), none.tolist(), strict=True))
    numbers = np.flatnonzero(count)
    means_of = sums / np.where(count, count, 1.0)
    mean_T, mean_t, mean_y, sum_rate = means_of[0], means_of[1], means_of[2 : 2 + k], sums[-1]
    each, ends = np.zeros((len(count), 3 + 2 * k, bins)), _edges(plan, series)
    about = np.ascontiguousarray(means_of.swapaxes(0, 1))
    for part in parts:
        if not isinstance(parts, list):
            kernels.find_bins(part.columns, k, part.path, ends, cut, part.bins, np.zeros(3, dtype=np.int64))
        kernels.add_squares(part.columns, k, part.bins, about[part.ramp], each[part.ramp])
    squares, squares_y = each[:, :3].swapaxes(0, 1), each[:, 3:].swapaxes(0, 1)
    count, mean_T, mean_t, sum_rate = (x.ravel()[numbers] for x in (count, mean_T, mean_t, sum_rate))
    var_T, var_t, cov_Tt = squares.reshape(3, -1)[:, numbers] / count
    free = np.maximum(count - 2.0, 1.0)
    rate = np.divide(cov_Tt, var_t, out=np.full(len(count), np.nan), where=var_t > 0.0)
    number, bin_of = np.divmod(numbers, bins)
    first = np.array([one.start for one in series.ramps])[number]
    sweep = np.searchsorted([one.stop for one in series.sweeps], first, side="right")
    means = mean_y.reshape(k, -1)[:, numbers]
    var_y, cov_Ty = squares_y.reshape(2, k, -1)[:, :, numbers] / count
    taken = np.divide(cov_Ty**2, var_T, out=np.zeros_like(cov_Ty), where=var_T > 0.0)
    scatter = np.sqrt(np.maximum(var_y - taken, 0.0) * count / free)
    once, found = Once(), []
    for i in range(k):
        found.append(Cells(
            mean_T,
            var_T,
            means[i],
            scatter[i],
            count,
            rate if series.rate is None else sum_rate / count,
            mean_t,
            np.array(series.ways)[number],
            np.array(series.runs)[sweep],
            number,
            bin_of,
            np.ones(len(count)),
            means,
            i,
            series.span,
            once=once,
        ))  # fmt: skip
    return found, left


def _on_both_paths(cells: Cells, full: Mask, series: Series) -> tuple[Cells, Mask]:
    """Keep what lies in or next to the temperatures that were seen on both paths; all of it with one path only."""
    kept = _taken(cells, full)
    shared = kept.shared_bins
    if not len(shared):
        return _weighed(kept, _ends(kept, series)), full
    low = kept.temperature[kept.bin == shared[0]].min()
    high = kept.temperature[kept.bin == shared[-1]].max()
    width = (series.span[1] - series.span[0]) / (int(cells.bin.max()) + 1)
    reach = series.turn_over + width
    inside = (cells.temperature >= low - reach) & (cells.temperature <= high + reach)
    kept = _taken(cells, full & inside)
    both = (float(low), float(high))
    return _weighed(kept, _ends(kept, series)).changed(both=both), full & inside


def _ends(cells: Cells, series: Series) -> tuple[float, float]:
    """Lowest and highest temperature of the bins that have a cell, no further than any sample."""
    lowest, highest = series.span
    return (
        max(lowest, float(np.min(cells.temperature - np.sqrt(3.0 * cells.spread)))),
        min(highest, float(np.max(cells.temperature + np.sqrt(3.0 * cells.spread)))),
    )


def _taken(cells: Cells, keep: Mask) -> Cells:
    rows = ("temperature", "spread", "reading", "scatter", "samples", "rate", "time", "path", "run", "ramp", "bin")
    if keep.all():
        return cells.changed(once=Once())
    kept = {name: getattr(cells, name)[keep] for name in rows}
    return cells.changed(weight=cells.weight[keep], beside=cells.beside[:, keep], once=Once(), **kept)


def _weighed(cells: Cells, ends: tuple[float, float]) -> Cells:
    """Give the cells of one run, path and bin the weight 1 together."""
    key = (cells.run * 3 + cells.path + 1) * (int(cells.bin.max()) + 1) + cells.bin
    return cells.changed(weight=1.0 / np.bincount(key)[key], range=ends, once=Once())
