"""Curves of the environment: bands, intervals of time, cumulative level, spectrogram, slow acceleration."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...core.curve import Column, Curve
from ...core.estimate import Array
from ...core.key import AXES
from .plan import RSS
from .scan import CELLS

if TYPE_CHECKING:
    from .reduction import Result

SI, UG = "m/s^2", "ug"
MOST = 600  # intervals of the display
TIMES = 72  # of the spectrogram
POINTS = 240  # of the cumulative level
PERCENTILES = (0, 50, 95, 100)


def curves(result: Result) -> Sequence[Curve]:
    """Return the curves, SI."""
    return [*_bands(result), *_intervals(result), *_cumulative(result), *_spectrogram(result), *_trend(result)]


def _named(result: Result) -> Iterator[tuple[str, Array]]:
    """Yield axes, and all together, each with what picks it from arrays whose last axis is that of axes."""
    for i, axis in enumerate(result.axes):
        yield axis, np.eye(len(result.axes))[i]
    if len(result.axes) == len(AXES):
        yield RSS, np.ones(len(AXES))


def _bands(result: Result) -> Iterator[Curve]:
    if not result.bands:
        return
    each = np.array(result.found.bands)
    own = result.plan.own_noise
    for axis, pick in _named(result):
        powers = [result.power(axis, one) for one in result.bands]
        ends = [one.interval(0.95) for one in powers]
        blocks = np.percentile(np.sqrt(each @ pick), PERCENTILES, axis=0)
        columns = {
            "frequency": Column(np.array([one.nominal for one in result.bands]), "Hz"),
            "low": Column(np.array([one.low for one in result.bands]), "Hz"),
            "high": Column(np.array([one.high for one in result.bands]), "Hz"),
            "rms": Column(np.array([one.rms for one in powers]), SI, UG),
            "u": Column(np.array([one.u_rms for one in powers]), SI, UG),
            "interval_low": Column(np.array([float(one.lo or 0.0) for one in ends]), SI, UG),
            "interval_high": Column(np.array([float(one.hi or 0.0) for one in ends]), SI, UG),
            "dof": Column(np.array([one.dof for one in powers])),
        }
        names = ("block_least", "block_median", "block_95", "block_largest")
        columns |= {name: Column(one, SI, UG) for name, one in zip(names, blocks, strict=True)}
        if own:
            noise = [own * math.sqrt((one.high - one.low) * float(pick.sum())) for one in result.bands]
            columns["own_noise"] = Column(np.array(noise), SI, UG)
        if axis == RSS and result.readings.requirement is not None:
            columns["limit"] = Column(result.limits, SI, UG)
        yield Curve("microgravity_bands", axis, columns)


def _intervals(result: Result) -> Iterator[Curve]:
    """Yield least, largest, mean and root mean square of intervals; groups of many keep the ends."""
    found = result.found
    at = np.concatenate(found.at)
    order = np.argsort(at, kind="stable")
    at = at[order]
    every = (found.low, found.high, found.mean, found.square, found.counts)
    low, high, mean, square, counts = (np.concatenate(one)[order] for one in every)
    size = -(-len(at) // MOST)
    starts = np.arange(0, len(at), size)
    lengths = np.diff(np.append(starts, len(at)))
    middle = np.add.reduceat(at, starts) / lengths
    edges = np.diff(at, prepend=at[0])
    usual = float(np.median(edges[1:])) if len(at) > 1 else math.inf
    gap = np.maximum.reduceat(np.where(edges > 1.5 * usual, 1.0, 0.0), starts) > 0.0
    weight = np.maximum(counts, 0.0)
    total = np.add.reduceat(weight, starts, axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        means = np.add.reduceat(np.nan_to_num(mean) * weight, starts, axis=0) / total
        squares = np.add.reduceat(np.nan_to_num(square) * weight, starts, axis=0) / total
    for i, axis in enumerate(result.axes):
        yield Curve("microgravity_intervals", axis, {
            "time": Column(middle, "s"),
            "least": Column(np.fmin.reduceat(low[:, i], starts), SI, UG),
            "largest": Column(np.fmax.reduceat(high[:, i], starts), SI, UG),
            "mean": Column(means[:, i], SI, UG),
            "rms": Column(np.sqrt(squares[:, i]), SI, UG),
            "after_gap": Column([bool(one) for one in gap]),
        })  # fmt: skip


def _cumulative(result: Result) -> Iterator[Curve]:
    """Yield the level of all frequencies up to each, from the lower edge of the lowest band on."""
    if not result.bands:
        return
    first, last = result.bands[0].low, min(result.bands[-1].high, result.cut.top)
    frequency = np.geomspace(first, last, POINTS)
    step = result.cut.step
    sums = np.vstack([np.zeros(len(result.axes)), np.cumsum(result.found.lines, axis=0)])
    edges = (np.arange(len(sums)) - 0.5) * step
    for axis, pick in _named(result):
        power = np.interp(frequency, edges, sums @ pick)
        yield Curve("microgravity_cumulative", axis, {
            "frequency": Column(frequency, "Hz"),
            "rms": Column(np.sqrt(np.maximum(power - power[0], 0.0)), SI, UG),
        })  # fmt: skip


def _spectrogram(result: Result) -> Iterator[Curve]:
    """Yield the density of all axes together, in cells of time and frequency whose powers are kept."""
    cells = np.array(result.found.cells).sum(axis=2)
    times = np.array(result.found.times)
    if len(times) < 2:
        return
    length = result.cut.block * result.cut.interval
    span = float(times[-1] - times[0])
    count = min(TIMES, max(2, round(span / (0.5 * length)) + 1))
    wide = span / count
    column = np.minimum(((times - times[0]) / wide).astype(int), count - 1)
    edges = np.linspace(0.0, result.cut.top, CELLS + 1)
    middle = 0.5 * (edges[1:] + edges[:-1])
    at: list[float] = []
    frequency: list[float] = []
    density: list[float] = []
    for k in range(count):
        inside = column == k
        values = cells[inside].mean(axis=0) / np.diff(edges) if inside.any() else np.full(CELLS, np.nan)
        at += [float(times[0] + (k + 0.5) * wide)] * CELLS
        frequency += middle.tolist()
        density += values.tolist()
    yield Curve("microgravity_spectrogram", RSS if len(result.axes) == len(AXES) else "", {
        "time": Column(np.array(at), "s"),
        "frequency": Column(np.array(frequency), "Hz"),
        "density": Column(np.array(density), "(m/s^2)^2/Hz", "ug^2/Hz"),
    })  # fmt: skip


def _trend(result: Result) -> Iterator[Curve]:
    one = result.trend
    if one is None:
        return
    names = AXES if len(result.axes) == len(AXES) else result.axes
    columns = {"time": Column(one.times, "s")}
    for i, axis in enumerate(names):
        columns[axis] = Column(one.values[:, i], SI, UG)
        columns[f"u_{axis}"] = Column(np.full(len(one.times), one.noise[i]), SI, UG)
    yield Curve("microgravity_slow", "", columns)
    if result.orbit is not None and len(result.orbit.times):
        found = {"time": Column(result.orbit.times, "s")}
        found |= {axis: Column(result.orbit.means[:, i], SI, UG) for i, axis in enumerate(names)}
        yield Curve("microgravity_orbits", "", found)
