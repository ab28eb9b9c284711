"""Reduction: levels of bands against the requirement, the slow acceleration, and what may stand in their way.

The level of a band is that of the process over the record: the interval says how far the level of another record of the
same environment may lie. The requirement of the station is on the root mean square over 100 s, taken here of all axes
together; each block is such a mean, and how many blocks lie above the curve is told beside.

Slow acceleration (quasi-steady, below 0.01 Hz): trimmed means of blocks of 100 s, whose response is zero at 0.01 Hz and
its multiples. The trimmed mean leaves out a fixed share of the samples at each end; the adaptive filter of the
archive's own products, whose share follows the shape of the distribution, is not what is made here. Its noise is that
of second differences of successive blocks (a drift and an orbit leave little in them), taken as independent from block
to block. Its bias is known by what was stated or found by an earlier test, else the slow acceleration is not estimated:
a sensor's bias is ten to a thousand times as large.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...core.curve import Curve
from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.key import AXES, Key, Origin
from ...core.remarks import Remark
from ...core.results import Row
from ...core.show.rounding import number
from ...core.units import factor
from ...core.unknowns import joined
from ...physics.attitude import from_roll_pitch_yaw
from ..corrections import components
from .bands import BANDS, Band, Power, power, refused
from .plan import INFLUENCES, REQUIRED, SCALE, SLOW, Plan
from .readings import HERTZ, Readings
from .scan import Cut, Found, scan, weights_of

G = 9.80665  # [m/s^2]
WEIGHT = 0.3 * G  # a record whose mean is larger was not made in orbit
QUIETEST = 1e-9 * G  # no accelerometer is quieter than that over its whole band
FEWEST = 4  # blocks of the slow acceleration
SECOND_DIFFERENCE = 6.0  # of independent values of variance 1
LESS = 1.944  # values of a second difference for one degree of freedom
SHORTEST, LONGEST, TURNS = 4800.0, 6600.0, 3.0  # periods of low orbits [s], and how many a search needs
HELD = 4  # repeats of an extreme value: saturated, where they are a good part of all repeats
MOSTLY = 0.2
LOUD = 0.5  # share of a band's power that the sensor's own noise may have unnoticed
PARSEVAL = 0.2  # by which powers of spectrum and time may differ
STEPS = (1.0, 2.0, 5.0)


@dataclass(frozen=True, eq=False)
class Trend:
    """Slow acceleration over time."""

    times: Array  # shape (k,): middle of each block [s]
    values: Array  # shape (k, a): bias taken off; in axes of the station where these are known [m/s^2]
    noise: Array  # shape (a,): standard uncertainty of one block, bias aside
    dof: float


@dataclass(frozen=True, eq=False)
class Orbit:
    """Part of the slow acceleration that follows the orbit."""

    period: float  # [s]
    u_period: float | None  # where it was looked for
    amplitude: Array  # shape (a,) [m/s^2]
    u: Array
    means: Array  # shape (o, a): of each whole orbit
    times: Array  # shape (o,): middle of each [s]


@dataclass(frozen=True, eq=False)
class Result:
    """What records say of the environment, SI."""

    plan: Plan
    readings: Readings
    cut: Cut
    found: Found
    powers: dict[tuple[str, str], Power]  # by axis, ``"rss"`` among them, and band (its number as text; ``"all"``)
    bands: tuple[Band, ...]  # that are estimated
    left: tuple[tuple[Band, str], ...]  # that are not, with the reason
    estimate: Estimate | None  # Mean of the slow acceleration; None where the bias is not known
    trend: Trend | None
    orbit: Orbit | None
    remarks: tuple[Remark, ...] = ()

    @property
    def axes(self) -> tuple[str, ...]:
        """Axes that were read."""
        return self.readings.tracks[0].axes

    @cached_property
    def limits(self) -> Array:
        """Of the bands that are estimated, shape (bands,): NaN where there is none [m/s^2]."""
        one, middle = self.readings.requirement, np.array([band.middle for band in self.bands])
        return np.full(len(self.bands), np.nan) if one is None else one.at(middle)

    @property
    def shortened(self) -> bool:
        """Whether blocks are shorter than was asked for."""
        return self.cut.block * self.cut.interval < 0.99 * self.plan.block

    def power(self, axis: str, band: Band) -> Power:
        """Return the mean power of an axis in a band."""
        return self.powers[axis, str(band.number)]

    def rows(self) -> Sequence[Row]:
        """Return the rows of ``results.json``, SI."""
        from .rows import rows  # noqa: PLC0415 - rows know results

        return rows(self)

    def curves(self) -> Sequence[Curve]:
        """Return the curves of ``results.json``, SI."""
        from .curves import curves  # noqa: PLC0415

        return curves(self)


def reduce(plan: Plan, readings: Readings) -> Result:
    """Return what records say of the environment.

    Raises
    ------
    DataError
        ``too_short``, ``wrong_unit``, ``nothing_left``.
    """
    cut = _cut(plan, readings)
    axes = readings.tracks[0].axes
    bias = np.array([(plan.bias or {}).get(axis, 0.0) for axis in axes])
    found = scan(readings, cut, bias)
    _check(readings, found)
    bands = tuple(band for band in BANDS if not refused(band, cut.step, cut.top))
    left = tuple((band, why) for band in BANDS if (why := refused(band, cut.step, cut.top)))
    cut = replace(cut, edges=np.array([[one.low, one.high] for one in bands]).reshape(-1, 2))
    powers = _powers(plan, axes, cut, found, bands)
    trend, estimate = _slow(plan, readings, found)
    orbit = None if trend is None else _orbit(plan, trend)
    result = Result(plan, readings, cut, found, powers, bands, left, estimate, trend, orbit)
    return replace(result, remarks=(*readings.remarks, *_remarks(result)))


def _cut(plan: Plan, readings: Readings) -> Cut:
    interval = readings.tracks[0].interval
    longest = max(stop - first for one in readings.tracks for first, stop in one.stretches)
    wanted = plan.block / interval
    n = round(wanted / 2.0) * 2
    if n > longest:
        lengths = sorted({step * 10.0**k for k in range(-3, 6) for step in STEPS})
        fitting = [one for one in lengths if one <= 0.2 * longest * interval]
        n = round(fitting[-1] / interval / 2.0) * 2 if fitting else 0
    if n < 32:
        what = f"the longest stretch without a gap is {number(longest * interval, 3)} s, {longest} samples"
        raise DataError(what, readings.tracks[0].file, "a spectrum needs more", "Give a longer record", "too_short")
    stated = [plan.cut_off or one.cut_off for one in readings.tracks]
    limits = [0.5 / interval, *((one or 1.0 / interval / HERTZ) for one in stated)]
    top = min(limits)
    step = 1.0 / (n * interval)
    edges = np.array([[one.low, one.high] for one in BANDS if not refused(one, step, top)]).reshape(-1, 2)
    return Cut(interval, n, max(2, round(plan.interval / interval)), plan.trim, top, edges)


def _check(readings: Readings, found: Found) -> None:
    """Refuse what was not made in orbit, or is in another unit than it says."""
    where = readings.tracks[0].file
    if not found.blocks:
        what = f"no block without a missing sample or a glitch: {found.left_out} left out"
        raise DataError(what, where, "spectra do not go across a gap", "Make blocks shorter",
                        "nothing_left")  # fmt: skip
    mean = float(np.linalg.norm(np.nanmean(np.concatenate(found.mean), axis=0)))
    size = math.sqrt(float(np.sum(np.mean(found.squares, axis=0))))
    if mean > WEIGHT or size > WEIGHT:
        what = f"mean {number(mean / G, 3)} g, root mean square about it {number(size / G, 3)} g"
        do = "Correct the unit of its columns, or take a record made in orbit"
        raise DataError(what, where, "in orbit it is below a thousandth of g", do, "wrong_unit")
    if size < QUIETEST:
        what = f"root mean square about the mean {number(size / G * 1e6, 3)} ug over all frequencies"
        raise DataError(what, where, "no accelerometer is that quiet", "Correct the unit of its columns", "wrong_unit")


def _powers(
    plan: Plan, axes: Sequence[str], cut: Cut, found: Found, bands: Sequence[Band]
) -> dict[tuple[str, str], Power]:
    scale = plan.standards.get(SCALE)
    u = 0.0 if scale is None else scale.u
    each = np.array(found.bands).reshape(found.blocks, len(bands), len(axes))
    blocks = (found.blocks, found.pairs)
    powers: dict[tuple[str, str], Power] = {}
    squares = found.lines**2
    together = squares.sum(axis=1) + 2.0 * np.sum(np.abs(found.cross) ** 2, axis=1)
    sources = [(axis, found.lines[:, i], squares[:, i], each[:, :, i]) for i, axis in enumerate(axes)]
    if len(axes) == len(AXES):
        sources.append(("rss", found.lines.sum(axis=1), together, each.sum(axis=2)))
    weights = list(weights_of(cut))
    whole = np.sum(weights, axis=0) if weights else np.zeros(cut.lines)
    for axis, lines, square, own in sources:
        for i, band in enumerate(bands):
            part = slice(*_span(weights[i]))
            powers[axis, str(band.number)] = power(weights[i][part], lines[part], square[part], own[:, i], blocks, u)
        if bands:
            powers[axis, "all"] = power(whole, lines, square, own.sum(axis=1), blocks, u)
    return powers


def _span(weights: Array) -> tuple[int, int]:
    at = np.flatnonzero(weights)
    return (int(at[0]), int(at[-1]) + 1) if len(at) else (0, 0)


def _slow(plan: Plan, readings: Readings, found: Found) -> tuple[Trend | None, Estimate | None]:
    """Return the slow acceleration over time, and its mean where the bias is known."""
    if len(found.slow) < FEWEST:
        return None, None
    times, values = np.array(found.slow_times), np.array(found.slow)
    follows = np.array(found.follows)
    both = follows[2:] & follows[1:-1]
    bends = (values[2:] - 2.0 * values[1:-1] + values[:-2])[both]
    if len(bends) < FEWEST - 2:
        return None, None
    noise, dof = np.sqrt(np.mean(bends**2, axis=0) / SECOND_DIFFERENCE), max(len(bends) / LESS, 1.0)
    axes = readings.tracks[0].axes
    by_test = set(axes).intersection(*(one.corrected for one in readings.tracks))
    known = [axis for axis in axes if axis in by_test or axis in (plan.bias or {})]
    if len(axes) < len(AXES) or not known or (plan.attitude is not None and len(known) < len(axes)):
        return Trend(times, values, noise, dof), None
    keys = tuple(Key(SLOW, axis) for axis in axes)
    mean = values.mean(axis=0)
    parts = [Component(Origin("scatter of blocks", level="block"), "A", np.diag(noise**2 / len(values)), dof)]
    if plan.bias_u:
        changes = np.eye(len(axes)) * plan.bias_u
        parts.append(Component(Origin("bias"), "B", changes @ changes, stated=(plan.bias_u, "m/s^2"), changes=changes,
                               unknowns=axes))  # fmt: skip
    off = [{origin: replace(one, changes=one.changes.mean(axis=1, keepdims=True))
            for origin, one in track.taken_off.items()} for track in readings.tracks]  # fmt: skip
    shares = np.array([len(one) for one in readings.tracks]) / len(readings)
    parts += components(joined(off, [1] * len(off)), keys, np.eye(len(axes))[:, None, :] * shares[None, :, None])
    if (scale := plan.standards.get(SCALE)) is not None and scale.u > 0.0:
        changes = np.diag(mean * scale.u)
        parts.append(Component(Origin("scale factor", standard="sensor", quantity="scale_factor"), "B",
                               changes @ changes, scale.dof, stated=(scale.u, "1"), changes=changes,
                               unknowns=axes))  # fmt: skip
    if plan.attitude is not None:
        C = from_roll_pitch_yaw(*plan.attitude)
        values, mean = values @ C.T, C @ mean
        noise = np.sqrt(np.diag(C @ np.diag(noise**2) @ C.T))
        parts = [replace(one, covariance=C @ one.covariance @ C.T,
                         changes=None if one.changes is None else one.changes @ C.T) for one in parts]  # fmt: skip
    whole = Estimate(keys, mean, ("m/s^2",) * len(axes), tuple(parts))
    return Trend(times, values, noise, dof), whole.select([key for key in keys if key.axis in known])


def _orbit(plan: Plan, trend: Trend) -> Orbit | None:
    """Return what follows the orbit, with the period that was given, or that fits best."""
    span = float(trend.times[-1] - trend.times[0])
    period, u_period = plan.orbit, None
    if period is None:
        if span < TURNS * SHORTEST:
            return None
        periods = np.linspace(SHORTEST, min(LONGEST, span / TURNS), 721)
        left = np.array([_fitted(trend, float(one))[1] for one in periods])
        at = int(np.argmin(left))
        if at in (0, len(periods) - 1):
            return None
        period = float(periods[at])
        bend = (left[at - 1] - 2.0 * left[at] + left[at + 1]) / (periods[1] - periods[0]) ** 2
        u_period = math.sqrt(2.0 / bend) if bend > 0.0 else None
    elif span < period:
        return None
    law, _ = _fitted(trend, period)
    # Of the phase that a part of an orbit tells worse; sqrt(2 / n) of each over whole orbits
    design = _orbital(trend, period)
    u = trend.noise * math.sqrt(float(np.linalg.eigvalsh(np.linalg.inv(design.T @ design)[1:, 1:])[-1]))
    amplitude = np.hypot(law[1], law[2])
    if plan.orbit is None and not np.any(amplitude > 4.0 * u):
        return None
    number_of = np.floor((trend.times - trend.times[0]) / period).astype(int)
    whole = [k for k in range(int(span // period)) if np.count_nonzero(number_of == k) > 2]
    means = np.array([trend.values[number_of == k].mean(axis=0) for k in whole]).reshape(len(whole), -1)
    times = np.array([trend.times[number_of == k].mean() for k in whole])
    return Orbit(period, u_period, amplitude, u, means, times)


def _orbital(trend: Trend, period: float) -> Array:
    """Return the columns constant, cosine and sine of an orbit, shape (n, 3)."""
    turns = 2.0 * math.pi * trend.times / period
    return np.column_stack([np.ones_like(turns), np.cos(turns), np.sin(turns)])


def _fitted(trend: Trend, period: float) -> tuple[Array, float]:
    """Return constant, cosine and sine of each axis, shape (3, a), and the squares that are left, in its noise."""
    design = _orbital(trend, period)
    law: Array = np.asarray(np.linalg.lstsq(design, trend.values, rcond=None)[0], dtype=np.float64)
    return law, float(np.sum(((trend.values - design @ law) / np.maximum(trend.noise, 1e-30)) ** 2))


def _remarks(result: Result) -> Iterator[Remark]:
    plan, found, cut = result.plan, result.found, result.cut
    length = cut.block * cut.interval
    if missing := [name for name in INFLUENCES if name not in plan.standards]:
        effects = "; ".join(f"{name} ({INFLUENCES[name]})" for name in missing)
        yield Remark("relative_to_sensor", "info", f"standards without a stated uncertainty: {effects}",
                     do="State them under [standards]")  # fmt: skip
    if result.shortened:
        what = f"no stretch without a gap is {number(plan.block)} s long: blocks of {number(length, 4)} s"
        do = "Do not take levels of them for those over 100 s" if plan.block == REQUIRED else ""
        yield Remark("short_blocks", "warning", what, do=do)
    stretches = sum(len(one.stretches) for one in result.readings.tracks)
    if stretches > 1:
        what = f"{stretches} stretches, {stretches - 1} gap(s) between: no block goes across one"
        if found.short:
            what += f"; {found.short} samples stand in stretches shorter than a block"
        yield Remark("stretches", "info", what)
    if found.left_out:
        what = f"{found.left_out} of {found.left_out + found.blocks} blocks hold a glitch or a missing sample"
        yield Remark("blocks_left_out", "warning", f"{what}: left out of spectra and means")
    if found.glitches:
        first = number(found.glitches[0], 6)
        what = f"{len(found.glitches)} sample(s) alone far from both neighbours, the first at {first} s"
        yield Remark("glitches", "warning", what, do="They stay in the display of least and largest values")
    yield from _saturated(result)
    if all((plan.cut_off or one.cut_off) is None for one in result.readings.tracks):
        what = f"the cut-off of the low pass is not stated: bands up to {number(cut.top, 4)} Hz (rate / {HERTZ:g})"
        yield Remark("cut_off_unknown", "warning", what, do="State it (cut_off)")
    yield from _slow_remarks(result)
    yield from _levels(result)


def _saturated(result: Result) -> Iterator[Remark]:
    found = result.found
    low, high = (np.concatenate(one) for one in (found.low, found.high))
    held, repeats = np.concatenate(found.held), np.sum(found.repeats, axis=0)
    for i, axis in enumerate(result.axes):
        for side, (ends, pick) in enumerate(((low[:, i], np.nanmin), (high[:, i], np.nanmax))):
            end = float(pick(ends))
            count = float(np.sum(held[:, side, i][ends == end]))
            if count >= HELD and count >= MOSTLY * repeats[i]:
                what = f"{axis} stays at {number(end * factor('m/s^2', 'ug'), 4)} ug for {count:.0f} samples"
                do = "Levels of that time are lower bounds: take a wider range"
                yield Remark("saturated", "error", f"{what}, its {'largest' if side else 'least'} value", do=do,
                             axis=axis)  # fmt: skip


def _without_bias(result: Result) -> list[str]:
    known = set() if result.estimate is None else {key.axis for key in result.estimate.keys}
    return [axis for axis in result.axes if axis not in known]


def _slow_remarks(result: Result) -> Iterator[Remark]:
    trend, plan = result.trend, result.plan
    if trend is None:
        what = f"{len(result.found.slow)} blocks: the slow acceleration needs {FEWEST} that follow each other"
        yield Remark("few_blocks", "warning", what, do="Give a longer record")
        return
    lacking = [] if result.estimate is None else _without_bias(result)
    if lacking:
        what = f"the bias of {', '.join(lacking)} is not known: slow acceleration and bias cannot be told apart there"
        yield Remark("bias_unknown", "warning", what, do="A flip has none of the axis of its turn: turn about another")
    if result.estimate is None:
        what = "the bias is not known: slow acceleration and bias cannot be told apart"
        yield Remark("bias_unknown", "warning", what,
                     do="State it (bias_x, bias_y, bias_z), or take off what a flip found: after")  # fmt: skip
    elif plan.bias is not None and not plan.bias_u:
        what = "the bias has no uncertainty: that of the slow acceleration is too small"
        yield Remark("bias_without_u", "warning", what, do="State it: bias_u")
    if plan.attitude is not None and result.estimate is not None:
        yield Remark("station_axes", "info", "slow acceleration in axes of the station, by roll, pitch and yaw")
    design = np.column_stack([np.ones_like(trend.times), trend.times - trend.times.mean()])
    span = float(np.ptp(trend.times))
    slope = np.linalg.lstsq(design, trend.values, rcond=None)[0][1]
    u = trend.noise / np.sqrt(np.sum(design[:, 1] ** 2))
    left = trend.values - design @ np.linalg.lstsq(design, trend.values, rcond=None)[0]
    spread = left.std(axis=0)
    drifts = [(i, float(slope[i]) * span) for i in range(len(slope))
              if abs(slope[i]) > 5.0 * u[i] and abs(slope[i]) * span > 3.0 * max(spread[i], 1e-30)]  # fmt: skip
    names = AXES if plan.attitude is not None else result.axes
    for i, change in drifts:
        what = f"{names[i]} drifts by {number(change * factor('m/s^2', 'ug'), 3)} ug over the record"
        do = "Look at the temperature of the sensor: a bias that follows it is taken off by a thermal test"
        yield Remark("drifts", "warning", what, do=do, axis=names[i])


def _levels(result: Result) -> Iterator[Remark]:
    """Yield what there is to say of levels: the curve, changes from block to block, own noise, powers of both kinds."""
    found, plan = result.found, result.plan
    named = "rss" if len(result.axes) == len(AXES) else result.axes[0]
    changing = [one for one in result.bands if not result.power(named, one).steady]
    if changing:
        what = f"the level changes on the way in {len(changing)} of {len(result.bands)} bands"
        yield Remark("not_steady", "info", f"{what}: their intervals are by the scatter of blocks")
    yield from _against_curve(result, named)
    if plan.own_noise:
        for one in result.bands[::-1]:
            own = plan.own_noise**2 * (one.high - one.low) * (len(AXES) if named == "rss" else 1)
            if own > LOUD * result.power(named, one).power:
                at = number(one.nominal, 3)
                what = f"the sensor's own noise gives more than half of the power of the band at {at} Hz"
                yield Remark("own_noise", "warning", what, do="Take levels there for upper limits")
                break
    spectrum = float(np.sum(found.lines))
    time = float(np.sum(np.mean(found.squares, axis=0)))
    if abs(spectrum / time - 1.0) > PARSEVAL:
        what = f"power of the spectrum over that of the samples: {number(spectrum / time, 3)}"
        yield Remark("parseval", "warning", f"{what}, should be 1: the level changes within blocks")


def _against_curve(result: Result, named: str) -> Iterator[Remark]:
    """Yield bands of the curve that are not judged, and blocks above it."""
    requirement, found, limits = result.readings.requirement, result.found, result.limits
    if requirement is None:
        return
    if not np.any(np.isfinite(limits)):
        yield Remark("curve_elsewhere", "warning", "the curve has no limit where bands are estimated")
    missing = [band for band, _ in result.left
               if np.isfinite(requirement.at(np.array([band.middle]))).all()]  # fmt: skip
    if missing:
        below = [one for one in missing if not result.bands or one.middle < result.bands[0].middle]
        parts = [(below, "below", -1), ([one for one in missing if one not in below], "above", 0)]
        said = [f"{len(some)} {word} {number(some[end].nominal, 3)} Hz" for some, word, end in parts if some]
        what = f"bands of the curve that are not judged: {' and '.join(said)}, inclusive"
        yield Remark("bands_not_judged", "warning", what, do="Take longer blocks, or a record of a wider pass band")
    if named == "rss" and found.bands:
        rms = np.sqrt(np.array(found.bands).sum(axis=2))
        above = np.any(rms > limits, axis=1)
        if above.any():
            what = f"{int(above.sum())} of {found.blocks} blocks lie above the curve in a band or more"
            yield Remark("blocks_above", "info", what)


__all__ = ["Orbit", "Result", "Trend", "reduce"]
