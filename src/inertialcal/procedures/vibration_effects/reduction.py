"""Effects of vibration: rectification of the mean, g-sensitivity by frequency, noise under vibration against rest.

Estimated, by axis and direction of vibration: the change of the mean reading against the mean square of the control
(vibration rectification error, ``rectification``); the response of the reading to the control, and the noise that is
not coherent with it, in thirds of an octave at the highest level (``spectra``). Levels and rest are found in the record
(``segments``). Assumed: control and reading have one clock; the control is what the unit feels (a loose fixture breaks
that); nothing else than vibration and an even drift moves the bias. The uncertainty: scatter of segments, or of
windows; the scale factor of the control is taken as exact, and K has twice its relative error.

Where real data break it, by remark: a range that is reached (``clipped``: no figure), vibration up to half the sample
rate (``aliasing``), bands above the low pass of the unit (``in_band``), a mean that does not follow the square
(``not_quadratic``), a drift that is not even or a shift (``uneven_drift``), one level alone (``one_level``), columns
that have changed places (``doubts``), samples that are missing of a reading or of the control (``gaps``).

References
----------
.. [1] IEEE Std 1293-2018, 12.3.14; IEEE Std 528-2019 (vibration rectification error, g-sensitivity).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ...core.constants import STANDARD_GRAVITY
from ...core.curve import Column, Curve
from ...core.estimate import Array, Component, Estimate
from ...core.key import NO_REASON, At, Key, Origin, Reason
from ...core.remarks import Remark, gather
from ...core.results import Interval, Row, not_estimated
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.rounding import number
from ...core.show.tables import Block, html, text
from ...core.units import normalise
from ...signals.vibration.rails import rails_of
from ...statistics.intervals import t_interval
from .doubts import doubts
from .plan import Plan
from .readings import Readings, Vibrated, block_means, block_squares
from .rectification import Point, Rectified, points_of, rectified
from .segments import Segment, segments_of
from .spectra import Band, Spectra, bands_of, summed

LINES = 400  # by default, below the sample rate
FOLDED = 0.01  # of the largest density of the control, that may stand at half the sample rate
TOP = 0.9  # of half the sample rate, from which that is looked at
LOST = 0.2  # of the blocks, that may belong to no level

RECTIFICATION, CURVATURE = "vibration_rectification", "vibration_rectification_curvature"
NOT_SHAKEN = Reason("no_vibration", "the control does not vibrate in this band")
NOT_COHERENT = Reason("not_found", "not coherent with the control: no more than noise may be in one of all bands")
RESPONSE, RATIO, LEVEL = "vibration_sensitivity", "vibration_noise_ratio", "control_rms"


@dataclass(frozen=True, eq=False)
class Effects:
    """What one axis does under vibration in one direction."""

    axis: str
    direction: str
    rectified: Rectified
    bands: tuple[Band, ...] = ()
    no_bands: Reason = NO_REASON
    clipped: int = 0
    cut_off: float | None = None

    @property
    def name(self) -> str:
        """Axis that reads, and axis that was vibrated along, where that is known."""
        return f"{self.axis}{self.direction}"


@dataclass(frozen=True, eq=False)
class Result:
    """What the test gives."""

    plan: Plan
    readings: Readings
    effects: tuple[Effects, ...]
    levels: Mapping[str, tuple[float, ...]]  # rms of the control by direction, from the lowest [m/s^2]
    remarks: tuple[Remark, ...] = ()

    @property
    def estimate(self) -> Estimate | None:
        """Rectification of all axes and directions; None where there is none."""
        found = [one for one in self.effects if not one.rectified.reason]
        if not found:
            return None
        each = [one.rectified for one in found]
        covariance = np.diag([one.u**2 for one in each])
        scatter = Component(Origin("scatter of segments", level="segment"), "A", covariance,
                            np.array([one.dof for one in each]), "t")  # fmt: skip
        keys = tuple(Key(RECTIFICATION, one.name) for one in found)
        values = np.array([one.value for one in each])
        return Estimate(keys, values, (_per(self.readings.unit, 2),) * len(found), (scatter,))

    def rows(self) -> tuple[Row, ...]:
        """Rows of ``results.json``, SI."""
        told = Reason("level", "highest level of the control, as recorded")
        levels = (Row(Key(LEVEL, direction), each[-1], None, "m/s^2", reason=told)
                  for direction, each in self.levels.items() if each)  # fmt: skip
        return (*levels, *(row for one in self.effects for row in _rows(one, self.readings.unit)))

    def curves(self) -> list[Curve]:
        """Curves of ``results.json``, SI."""
        return [curve for one in self.effects for curve in _curves(one, self.readings.unit)]

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: how much went in, the figures in SI, how many remarks."""
        runs = self.readings.runs
        caption = f"vibration effects: {runs} run{'s' * (runs != 1)}"
        return (*estimate_table([row.to_dict() for row in self.rows()], caption), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def reduce(plan: Plan, readings: Readings) -> Result:
    """Find what vibration does to each axis."""
    remarks = list(readings.remarks)
    cut = [_cut(plan, one) for one in readings.runs_of]
    for run, one in zip(readings.runs_of, cut, strict=True):
        remarks += _on_run(run, one)
    effects, levels = [], {}
    for direction in dict.fromkeys(one.direction for one in readings.runs_of):
        mine = [one for one in cut if one.run.direction == direction]
        squares: dict[int, list[float]] = {}
        for one in mine:
            for each in one.segments:
                if each.level:
                    squares.setdefault(each.level, []).append(each.mean_square)
        levels[direction] = tuple(math.sqrt(float(np.mean(squares[level]))) for level in sorted(squares))
        for axis in dict.fromkeys(axis for one in mine for axis in one.run.axes):
            effects.append(_effects(plan, [one for one in mine if axis in one.run.axes], axis, direction))
    remarks += [remark for one in effects for remark in _on_effects(one)]
    return Result(plan, readings, tuple(effects), levels, gather(remarks))


def disagreements(plan: Plan, readings: Readings) -> tuple[Remark, ...]:
    """Return which columns have changed places, as far as runs show it."""
    cut = [_cut(plan, one) for one in readings.runs_of]
    return tuple(doubts([(one.run, one.size, one.segments) for one in cut]))


@dataclass(frozen=True, eq=False)
class Cut:
    """One run, cut into blocks and segments."""

    run: Vibrated
    size: int  # Samples of a block
    mean_squares: Array
    segments: list[Segment]
    lost: int  # Blocks that belong to no level

    def stretch(self, one: Segment) -> slice:
        """Return its samples."""
        return slice(one.first * self.size, one.stop * self.size)


def _cut(plan: Plan, run: Vibrated) -> Cut:
    size = max(round(plan.block / run.interval), 2)
    squares = block_squares(run.control, size, run.rms)
    there = np.flatnonzero(np.isfinite(squares))
    # A block that was not recorded has the level before it: it counts for no mean, but ends no segment
    filled = squares[there[np.maximum(np.searchsorted(there, np.arange(len(squares)), side="right") - 1, 0)]]
    segments, lost = segments_of(filled, plan.quiet)
    return Cut(run, size, squares, segments, lost)


def _effects(plan: Plan, cut: list[Cut], axis: str, direction: str) -> Effects:
    points: list[Point] = []
    bad = 0
    for number_, one in enumerate(cut):
        values = one.run.axes[axis]
        loud = [values[one.stretch(each)] for each in one.segments if each.level]
        bad += sum(rails_of(part).samples for part in loud)
        means = block_means(values, one.size)
        points += points_of(means, one.mean_squares, one.segments, one.size * one.run.interval, number_)
    cut_off = next((one.run.cut_off for one in cut if one.run.cut_off), None)
    if bad:
        said = f"{bad} samples at the end of the range under vibration: the mean is not that of the input"
        what = Reason("clipped", said)
        return Effects(axis, direction, Rectified(tuple(points), reason=what), (), what, bad, cut_off)
    bands, why = _bands(plan, cut, axis)
    return Effects(axis, direction, rectified(points, plan.drift), tuple(bands), why, 0, cut_off)


def _bands(plan: Plan, cut: list[Cut], axis: str) -> tuple[list[Band], Reason]:
    if any(one.run.rms for one in cut):
        return [], Reason("no_waveform", "the control is a logged level, not a waveform: no phase to compare with")
    interval = cut[0].run.interval
    same = [one for one in cut if abs(one.run.interval / interval - 1.0) < 1e-6]
    lines = LINES if plan.resolution is None else round(1.0 / (interval * plan.resolution))
    window = max(2 * (lines // 2), 16)
    highest = max((each.mean_square for one in same for each in one.segments if each.level), default=0.0)
    parts = [(one, each) for one in same for each in one.segments]
    loud = [_pair(one, each, axis) for one, each in parts if each.level and each.mean_square > 0.7 * highest]
    rest = [_pair(one, each, axis) for one, each in parts if each.rest]
    vibration = summed(loud, interval, window)
    if vibration is None and any(not np.isfinite(one).all() for pair in loud for one in pair):
        return [], Reason("gaps", "missing samples leave too few whole windows for a spectrum: record without loss")
    if vibration is None or not np.all(vibration.xx > 0.0):
        said = "the highest level is too short for its spectrum: record longer, or give a coarser resolution"
        return [], Reason("too_short", said)
    return bands_of(vibration, summed(rest, interval, window)), NO_REASON


def _pair(one: Cut, segment: Segment, axis: str) -> tuple[Array, Array]:
    where = one.stretch(segment)
    return one.run.control[where], one.run.axes[axis][where]


def _per(unit: str, power: int) -> str:
    return normalise(f"({unit})/(m/s^2)^{power}" if power > 1 else f"({unit})/(m/s^2)")


def _rows(one: Effects, unit: str) -> Iterator[Row]:
    found = one.rectified
    key = Key(RECTIFICATION, one.name)
    if found.reason:
        yield not_estimated(key, _per(unit, 2), found.reason)
    else:
        said = NO_REASON
        if found.curved or found.uneven:
            what = "the mean does not follow the mean square" if found.curved else "the bias does not drift evenly"
            said = Reason("in_doubt", f"in doubt: {what}")
        yield Row(key, found.value, found.u, _per(unit, 2), found.dof, t_interval(found.value, found.u, found.dof),
                  reason=said)  # fmt: skip
    if found.curvature is not None:
        value, u, dof = found.curvature
        yield Row(Key(CURVATURE, one.name), value, u, _per(unit, 4), dof, t_interval(value, u, dof))
    yield from _band_rows(one, unit)


def _band_rows(one: Effects, unit: str) -> Iterator[Row]:
    if one.no_bands:
        yield not_estimated(Key(RESPONSE, one.name), _per(unit, 1), one.no_bands)
        yield not_estimated(Key(RATIO, one.name), "1", one.no_bands)
    for band in one.bands:
        at = At("frequency", float(f"{band.middle:.4g}"), "Hz")
        own = Key(RESPONSE, one.name, at=at)
        inside = NO_REASON
        if one.cut_off is not None and band.high > one.cut_off:
            inside = Reason("in_band", f"above the low pass of the unit, {number(one.cut_off, 4)} Hz: with its loss")
        if not band.shaken:
            yield not_estimated(own, _per(unit, 1), NOT_SHAKEN)
        elif band.significant:
            interval = Interval(band.lo, band.hi)
            yield Row(own, band.gain, band.u, _per(unit, 1), None, interval, reason=inside)
        else:
            yield Row(own, band.hi, None, _per(unit, 1), None, Interval(0.0, band.hi), "upper_limit", NOT_COHERENT)
        if math.isfinite(band.ratio):
            interval = Interval(band.ratio_lo, band.ratio_hi)
            yield Row(Key(RATIO, one.name, at=at), band.ratio, band.u_ratio, "1", band.dof, interval)


def _curves(one: Effects, unit: str) -> Iterator[Curve]:
    points = one.rectified.points
    if points:
        columns = {"time": Column(np.array([each.time for each in points]), "s")}
        columns |= {"mean_square": Column(np.array([each.mean_square for each in points]), "(m/s^2)^2"),
                    "mean": Column(np.array([each.mean for each in points]), unit)}  # fmt: skip
        columns["u"] = Column(np.sqrt([each.variance + one.rectified.wander**2 for each in points]), unit)
        columns["without_drift"] = Column(_without_drift(one.rectified), unit)
        columns["run"] = Column(np.array([each.run + 1.0 for each in points]))
        columns["level"] = Column(np.array([float(each.level) for each in points]))
        yield Curve("vibration_effect_means", one.name, columns)
    if one.bands:
        density = f"{unit}/sqrt(Hz)"
        parts = {
            "frequency": ("middle", "Hz"), "gain": ("gain", unit), "lo": ("lo", unit), "hi": ("hi", unit),
            "coherence": ("coherence", "1"), "noise": ("noise", density), "quiet": ("quiet", density),
            "ratio": ("ratio", "1"), "ratio_lo": ("ratio_lo", "1"), "ratio_hi": ("ratio_hi", "1"),
        }  # fmt: skip
        scale = dict.fromkeys(("gain", "lo", "hi"), STANDARD_GRAVITY.value)  # to 1 g, in the unit that people speak
        columns = {
            name: Column(np.array([getattr(each, own) for each in one.bands], dtype=float) * scale.get(name, 1.0), its)
            for name, (own, its) in parts.items()
        }
        columns["significant"] = Column([each.significant and each.shaken for each in one.bands])
        columns["shaken"] = Column([each.shaken for each in one.bands])
        yield Curve("vibration_effect_bands", one.name, columns)


def _without_drift(found: Rectified) -> Array:
    """Return the means less what an even drift makes of each run, so that their line begins at zero."""
    mean = np.array([one.mean for one in found.points])
    if found.reason:
        return mean - mean[0] if len(mean) else mean
    left = mean - found.value * np.array([one.mean_square for one in found.points])
    for run in {one.run for one in found.points}:
        of = np.array([one.run == run for one in found.points])
        time = np.array([one.time for one in found.points])[of]
        order = 1 if np.ptp(time) > 0.0 and np.count_nonzero(of) > 2 else 0
        mean[of] -= np.polyval(np.polyfit(time - time[0], left[of], order), time - time[0])
    return mean


def _on_run(run: Vibrated, cut: Cut) -> Iterator[Remark]:
    if cut.lost > LOST * len(cut.mean_squares):
        what = f"{cut.lost} of {len(cut.mean_squares)} blocks belong to no steady level: they are left out"
        yield Remark(
            "levels_unsteady",
            "warning",
            what,
            do="Hold each level longer, or give a shorter block",
            where=run.file,
            recording=run.name,
        )
    lost = ~np.isfinite(run.control)
    for axis, values in {"": run.control, **run.axes}.items():
        there = np.isfinite(values)
        if missing := int(np.count_nonzero(~there if not axis else ~there & ~lost)):
            what = f"{missing} samples of {axis or 'the control'} are missing: means are of the others, blocks without "
            what += "half of theirs and windows of spectra with any of them are left out"
            yield Remark("gaps", "warning", what, run.file, missing, axis=axis, recording=run.name)
    if not run.direction:
        what = (
            f"recording {run.name}: along which axis it was vibrated is not said: figures are of the reading axis alone"
        )
        yield Remark(
            "direction_unknown", "info", what, do="Give axis of the recording", where=run.file, recording=run.name
        )
    if run.rms or not any(one.level for one in cut.segments):
        return
    loudest = max((one for one in cut.segments if one.level), key=lambda one: one.mean_square)
    x = run.control[cut.stretch(loudest)]
    found: Spectra | None = summed([(x, x)], run.interval, 2 * min(LINES // 2, len(x) // 20))
    if found is None:
        return
    high = found.frequency > TOP * found.frequency[-1]
    share = float(np.mean(found.xx[high]) / np.max(found.xx))
    if share > FOLDED:
        half = 0.5 / run.interval
        what = (
            f"recording {run.name}: the control vibrates up to half the sample rate ({number(half, 4)} Hz): what lies "
            "above folds into the readings, so that response and noise by band are those of folded vibration"
        )
        do = "Record faster, or with a low pass before sampling"
        yield Remark("aliasing", "warning", what, do=do, where=run.file, recording=run.name)


def _on_effects(one: Effects) -> Iterator[Remark]:
    found, name = one.rectified, one.name
    if one.clipped:
        what = f"{name}: {one.clipped} samples at the end of the range under vibration: no figure is told"
        yield Remark("clipped", "warning", what, do="Vibrate less, or use a wider range", axis=one.axis)
        return
    if not found.reason and found.levels == 1:
        what = f"{name}: one level alone: that the mean follows the square of the level is taken for granted"
        yield Remark("one_level", "warning", what, do="Record two levels or more", axis=one.axis)
    if found.curved:
        what = f"{name}: the mean does not follow the mean square of the vibration: no one figure holds at all levels"
        yield Remark(
            "not_quadratic", "warning", what, do="Use the figure near the levels of this record only", axis=one.axis
        )
    if found.uneven:
        what = f"{name}: the bias drifts unevenly, or stepped: rectification is in doubt"
        do = "Warm up longer, shorten the record, or repeat levels in turn with rest"
        yield Remark("uneven_drift", "warning", what, do=do, axis=one.axis)
