"""Cells: means over a bin of temperature on one ramp, so that a slow end of a ramp does not outweigh the rest.

The range of a sensor's temperature is cut into equal bins. The samples of one ramp in one bin are one cell. In each
run, the cells of one bin and one path share the weight 1, so every bin counts the same on each path, however long the
unit stayed in it and how many ramps went through.

Left out, and counted: samples without reading or temperature (``invalid``), before the start-up is over (``warm_up``),
on no path (``turn_over``, module ``signals.segmentation.ramps``), in bins that were seen on one path only
and lie beyond the others (``one_path``), and in cells with few samples (``sparse``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from ....core.errors import DataError
from ....core.estimate import Array
from ....signals.segmentation.ramps import COOLING, WARMING, find_ramps
from ..plan import Plan
from ..recordings import Readings, span_of

Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

SPARSE = 0.2  # of the samples of the median cell: a cell with fewer is left out
FEWEST = 3  # samples of a cell
STEPS, LONGEST = 20.0, 1e6  # of a lag, and of a run, that the temperature is filtered in
NARROW = 1e-3  # of the range of all samples: cells inside it are at one temperature


@dataclass(frozen=True, eq=False)
class Series:
    """All samples of one sensor, recording after recording."""

    axis: str  # Of the sensor
    temperature: Array  # shape (n,) or (c,): [degC], the mean of a cell
    reading: Array  # shape (n,) or (c,): [unit of the readings], the mean of a cell; NaN where missing
    time: Array  # shape (n,): since power-up [s]; NaN where no time is known
    run: Indices  # shape (n,) or (c,): number of the run
    sweep: Indices  # shape (n,): number of the recording
    ramp: Indices  # shape (n,) or (c,): number of the ramp among all
    path: Indices  # shape (n,) or (c,): 1 warming, -1 cooling, 0 on no ramp
    span: tuple[float, float]  # Ends of the temperature over all recordings [degC]
    turn_over: float  # [degC]
    rate: Array | None = None  # shape (n,): of the temperature, as a lag smooths it [degC/s]; None: by the cells alone

    def smoothed(self, lag: float) -> Series:
        """Return the same with the rate that an element behind by a lag sees: thermometer less element, over the lag.

        On a long ramp it is the rate of the ramp; after a turn it gets there in some lags.
        """
        rate = np.full(len(self.time), np.nan)
        for run in np.unique(self.run):
            own = np.flatnonzero((self.run == run) & np.isfinite(self.time) & np.isfinite(self.temperature))
            if len(own) < FEWEST:
                continue
            own = own[np.argsort(self.time[own], kind="stable")]
            t, T = self.time[own], self.temperature[own]
            step = max(min(float(np.median(np.diff(t))), lag / STEPS), float(np.ptp(t)) / LONGEST)
            if step > 0.0:
                even = np.arange(t[0], t[-1] + step, step)
                there = np.interp(even, t, T) - T[0]
                kept = np.exp(-step / lag)
                new = 1.0 - lag / step * (1.0 - kept)  # weight of the newer end of a ramp
                behind = signal.lfilter([new, 1.0 - kept - new], [1.0, -kept], there)
                rate[own] = np.interp(t, even, there - behind) / lag
        return replace(self, rate=rate)

    def of(self, reading: Array) -> Series:
        """Return the same times and temperatures with another reading."""
        return replace(self, reading=reading)


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
    range: tuple[float, float]  # Ends of the bins that are used [degC]
    left_out: Mapping[str, int] = field(default_factory=dict[str, int])  # Samples by the rule that leaves them out
    both: tuple[float, float] | None = None  # Ends of the temperatures that were seen on both paths [degC]

    def __len__(self) -> int:
        return len(self.temperature)

    @cached_property
    def runs(self) -> int:
        """Number of runs that have a cell."""
        return len(np.unique(self.run))

    @cached_property
    def shared_bins(self) -> Indices:
        """Bins that were seen on both paths."""
        warm, cool = (np.unique(self.bin[self.path == way]) for way in (WARMING, COOLING))
        return np.asarray(np.intersect1d(warm, cool))

    @cached_property
    def ways(self) -> tuple[int, ...]:
        """Paths that there are."""
        return tuple(int(one) for one in np.unique(self.path))


def series_of(plan: Plan, readings: Readings, axis: str) -> Series:
    """Return all samples of one sensor with their paths.

    Raises
    ------
    DataError
        ``no_temperature`` if the sensor has none, ``no_temperature_change`` if it hardly changes.
    """
    sweeps = [one for one in readings.sweeps if axis in one.outputs]
    if not any(axis in one.temperature for one in sweeps):
        what, do = f"{axis} sensor: no temperature", "Name its channel: temperature, or temperature_x"
        raise DataError(what, readings.where, "the bias is a function of it", do, "no_temperature")
    lowest, highest = span_of(readings, axis)
    if not highest - lowest >= plan.least_range:
        what = f"{axis} sensor: temperature from {lowest:.4g} to {highest:.4g} degC, a range of {highest - lowest:.3g}"
        why, do = f"a polynomial needs {plan.least_range:g} degC or more", "Ramp the chamber; check the channel"
        raise DataError(what, readings.where, why, do, "no_temperature_change")
    turn_over = plan.turn_over or 0.1 * (highest - lowest)
    labels = readings.labels
    parts, ramps = [], 0
    for number, one in enumerate(sweeps):
        nothing = np.full(len(one), np.nan)
        warm = one.temperature.get(axis, nothing)
        found = find_ramps(warm, turn_over) if np.isfinite(warm).any() else None
        path = np.zeros(len(one), dtype=np.int64) if found is None else found.path
        ramp = np.zeros(len(one), dtype=np.int64) if found is None else found.ramp
        run = np.full(len(one), labels.index(one.run))
        time = nothing if one.time is None else one.time
        parts.append((warm, one.outputs[axis], time, run, np.full(len(one), number), ramp + ramps, path))
        ramps += 1 if found is None else max(len(found), 1)
    warm, reading, time, run, sweep, ramp, path = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Series(axis, warm, reading, time, run, sweep, ramp, path, (lowest, highest), turn_over)


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
    invalid = ~(np.isfinite(series.reading) & np.isfinite(series.temperature))
    early = ~invalid & (np.nan_to_num(series.time, nan=np.inf) < cut)
    aside = ~invalid & ~early & (series.path == 0)
    used = np.flatnonzero(~(invalid | early | aside))
    if invalid.all():
        what, do = f"{series.axis} sensor: no sample is valid", "Check the rails, the built-in test and the columns"
        raise DataError(what, do=do, code="no_valid_sample")
    if not len(used):
        what = f"{series.axis} sensor: no sample lies on a ramp of {series.turn_over:.3g} degC or more"
        raise DataError(what, do="Ramp the chamber further, or give a smaller turn_over", code="no_ramp")
    cells = _gathered(plan, series, used)
    full = cells.samples >= max(FEWEST, SPARSE * float(np.median(cells.samples)))
    if not full.any():
        what = f"{series.axis} sensor: no bin of temperature holds {FEWEST} samples of one ramp"
        do = "Give a recording with more samples, or fewer bins"
        raise DataError(what, why="a mean of fewer has no scatter", do=do, code="few_samples")
    kept, beyond = _on_both_paths(cells, full, series)
    lowest, highest = kept.range
    if not highest - lowest > NARROW * (series.span[1] - series.span[0]):
        what = f"{series.axis} sensor: the bins with {FEWEST} samples or more all lie at {lowest:.4g} degC"
        do = "Ramp the chamber more slowly; check the channel of the temperature"
        raise DataError(what, why="a polynomial needs a range", do=do, code="no_temperature_change")
    left_out = {
        "invalid": int(invalid.sum()),
        "warm_up": int(early.sum()),
        "turn_over": int(aside.sum()),
        "one_path": int(cells.samples[beyond].sum()),
        "sparse": int(cells.samples[~full].sum()),
    }
    return replace(kept, left_out=left_out)


def _gathered(plan: Plan, series: Series, used: Indices) -> Cells:
    """Means of the samples of each ramp in each bin."""
    lowest, highest = series.span
    width = (highest - lowest) / plan.bins
    at = np.minimum(((series.temperature[used] - lowest) / width).astype(np.int64), plan.bins - 1)
    numbers, first, cell = np.unique(series.ramp[used] * plan.bins + at, return_index=True, return_inverse=True)
    count = np.bincount(cell).astype(np.float64)
    T = series.temperature[used]
    y, t = series.reading[used], series.time[used]
    mean_T, mean_y, mean_t = (np.bincount(cell, one) / count for one in (T, y, t))
    dT, dy, dt = T - mean_T[cell], y - mean_y[cell], t - mean_t[cell]
    var_T, var_y, var_t, cov_Ty, cov_Tt = (
        np.bincount(cell, one) / count for one in (dT * dT, dy * dy, dt * dt, dT * dy, dT * dt)
    )
    along = np.divide(cov_Ty**2, var_T, out=np.zeros_like(count), where=var_T > 0.0)
    free = np.maximum(count - 2.0, 1.0)
    rate = np.divide(cov_Tt, var_t, out=np.full(len(count), np.nan), where=var_t > 0.0)
    if series.rate is not None:
        rate = np.bincount(cell, series.rate[used]) / count
    head = used[first]
    return Cells(
        mean_T,
        var_T,
        mean_y,
        np.sqrt(np.maximum(var_y - along, 0.0) * count / free),
        count,
        rate,
        mean_t,
        series.path[head],
        series.run[head],
        series.ramp[head],
        numbers % plan.bins,
        np.ones(len(count)),
        series.span,
    )


def _on_both_paths(cells: Cells, full: Mask, series: Series) -> tuple[Cells, Mask]:
    """Keep what lies in or next to the temperatures that were seen on both paths; all of it with one path only."""
    kept = _taken(cells, full)
    shared = kept.shared_bins
    if not len(shared):
        return _weighed(kept, _ends(kept, series)), np.zeros(len(cells), dtype=bool)
    low = kept.temperature[kept.bin == shared[0]].min()
    high = kept.temperature[kept.bin == shared[-1]].max()
    width = (series.span[1] - series.span[0]) / (int(cells.bin.max()) + 1)
    reach = series.turn_over + width
    inside = (cells.temperature >= low - reach) & (cells.temperature <= high + reach)
    kept = _taken(cells, full & inside)
    both = (float(low), float(high))
    return replace(_weighed(kept, _ends(kept, series)), both=both), full & ~inside


def _ends(cells: Cells, series: Series) -> tuple[float, float]:
    """Lowest and highest temperature of the bins that have a cell, no further than any sample."""
    lowest, highest = series.span
    return (
        max(lowest, float(np.min(cells.temperature - np.sqrt(3.0 * cells.spread)))),
        min(highest, float(np.max(cells.temperature + np.sqrt(3.0 * cells.spread)))),
    )


def _taken(cells: Cells, keep: Mask) -> Cells:
    rows = ("temperature", "spread", "reading", "scatter", "samples", "rate", "time", "path", "run", "ramp", "bin")
    return replace(cells, weight=cells.weight[keep], **{name: getattr(cells, name)[keep] for name in rows})


def _weighed(cells: Cells, ends: tuple[float, float]) -> Cells:
    """Give the cells of one run, path and bin the weight 1 together."""
    key = (cells.run * 3 + cells.path + 1) * (int(cells.bin.max()) + 1) + cells.bin
    shared = np.unique(key, return_inverse=True)[1]
    return replace(cells, weight=1.0 / np.bincount(shared)[shared], range=ends)
