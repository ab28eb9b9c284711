"""Sine survey: the sweep as the control channel shows it, and the resonances of each response.

Estimated: start, end, rate and level of each sweep (``sweep``); natural frequency, amplification Q and transmissibility
at that frequency of each mode of each response (``modal``), from all sweeps of a test together. Assumed: the item is
linear, and moves with the control point alone; both channels have one clock and filters alike. Their covariance rests
on what the fit leaves, where and when it leaves it. Of the standards only the clock acts: on frequencies, in
proportion, alike for all; not on Q.

Where real data break it: an item that changed between sweeps or is not linear (``sweeps_differ``: see ``apart``), or
that changed during one (``changed_in_sweep``, ``unexplained``), a mode at an end of the sweep (not estimated:
``edge``), a drive that is clipped (``clipped_drive``), that loses its level (``control_lost``) or samples
(``lost_samples``), columns that changed places (``swapped_channels``), control accelerometers that move apart
(``control_disagrees``).

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011, section IV.B: sine survey of 0.25 g from 20 to 1000 Hz at 4 octaves a
   minute before and after random vibration.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.curve import Column, Curve
from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.key import At, Key, Origin, Reason, told_for
from ...core.remarks import Remark, gather
from ...core.results import Interval, Row, not_estimated
from ...core.show.rounding import number
from ...core.units import divide
from ...statistics.intervals import t_interval
from .apart import modes_of_sweeps
from .doubts import doubts, fit_doubts
from .plan import CLOCK, Plan
from .readings import Readings
from .swept import OfAxis, Swept, sweeps_of

FREQUENCY, AMPLIFICATION, PEAK = "resonance_frequency", "amplification", "transmissibility"
OF_MODE = (FREQUENCY, AMPLIFICATION, PEAK)
POINTS = 600  # of a curve
SCATTER = Origin("what the modes leave of the response", level="sample")


@dataclass(frozen=True, eq=False)
class Result:
    """The sweeps, and the modes of each response."""

    plan: Plan
    readings: Readings
    swept: tuple[Swept, ...]
    axes: dict[str, OfAxis]
    estimate: Estimate | None
    remarks: tuple[Remark, ...] = ()

    @property
    def unit(self) -> str:
        """Of a transmissibility."""
        return unit_of(self.readings)

    def rows(self) -> tuple[Row, ...]:
        """Return the rows of ``results.json``."""
        found = [row for one in self.swept for row in self._of_sweep(one)]
        for axis, of_axis in self.axes.items():
            number_of_mode = 0
            for k in range(len(of_axis.modes)):
                if of_axis.edge[k]:
                    continue
                number_of_mode += 1
                found += [self._row(mode_key(name, axis, number_of_mode)) for name in OF_MODE]
            found += self._edges(of_axis, number_of_mode)
            if of_axis.sweeps.differ:
                found += self._of_each(of_axis, number_of_mode + int(of_axis.edge.sum()))
        return tuple(found)

    def _row(self, key: Key) -> Row:
        assert self.estimate is not None  # noqa: S101 - there is a mode
        at = self.estimate.index(key)
        value, u, dof = (float(one[at]) for one in (self.estimate.values, self.estimate.u, self.estimate.dof))
        return Row(key, value, u, self.estimate.units[at], dof if math.isfinite(dof) else None,
                   t_interval(value, u, dof), shared=self.estimate.shared(key))  # fmt: skip

    def _edges(self, of_axis: OfAxis, known: int) -> Iterator[Row]:
        low, high = (end([one.sweep.lowest if end is min else one.sweep.highest for one in self.swept])
                     for end in (min, max))  # fmt: skip
        outer = of_axis.modes.frequency[of_axis.edge]
        for i, frequency in enumerate(outer.tolist()):
            what = f"a mode near {number(frequency, 3)} Hz is nearer to an end of the sweep than its width"
            why = Reason("edge", f"{what}: sweep beyond {number(low, 4)} to {number(high, 4)} Hz")
            yield from (not_estimated(mode_key(name, of_axis.axis, known + 1 + i), unit, why)
                        for name, unit in zip(OF_MODE, ("Hz", "1", self.unit), strict=True))  # fmt: skip
        if not known and not len(outer) and not of_axis.sweeps.differ:
            what = f"no mode makes {self.plan.least:g} or more of the transmissibility"
            why = Reason("no_resonance", f"{what} between {number(low, 4)} and {number(high, 4)} Hz")
            yield not_estimated(mode_key(FREQUENCY, of_axis.axis, 1), "Hz", why)

    def _of_each(self, of_axis: OfAxis, known: int) -> Iterator[Row]:
        """Yield modes that not all sweeps have, and those of each sweep, where the sweeps differ."""
        for i, (frequency, has) in enumerate(of_axis.sweeps.single, known + 1):
            what = f"a mode at {number(frequency, 4)} Hz is in {of_axis.labels[has]}, and not in every sweep"
            why = Reason("sweeps_differ", f"{what}: the item changed, or it is not linear")
            yield from (not_estimated(mode_key(name, of_axis.axis, i), unit, why)
                        for name, unit in zip(OF_MODE, ("Hz", "1", self.unit), strict=True))  # fmt: skip
        for label, modes in zip(of_axis.labels, of_axis.sweeps.each, strict=True):
            for k in range(len(modes)):
                for place, (name, values, unit) in enumerate(
                    zip(
                        OF_MODE, (modes.frequency, modes.amplification, modes.peak), ("Hz", "1", self.unit), strict=True
                    )
                ):
                    value, dof = float(values[k]), float(modes.dof[3 * k + place])
                    u = math.sqrt(modes.covariance[3 * k + place, 3 * k + place])
                    yield Row(mode_key(name, of_axis.axis, k + 1), value, u, unit, dof, t_interval(value, u, dof),
                              member=told_for(label))  # fmt: skip

    def _of_sweep(self, swept: Swept) -> Iterator[Row]:
        one, member = swept.sweep, told_for(swept.label if len(self.swept) > 1 else "")
        clock = self.plan.standards.get(CLOCK)
        u_clock = 0.0 if clock is None else clock.u
        unit, size = ("1/min", 60.0) if one.law == "log" else ("Hz/s", 1.0)
        figures = (
            ("sweep_start", one.start, one.u_start, "Hz", math.inf),
            ("sweep_end", one.stop, one.u_end, "Hz", math.inf),
            ("sweep_rate", one.rate * size, one.u_rate * size, unit, one.dof),
        )
        for name, value, own, its, dof in figures:
            u = math.hypot(own, value * u_clock)
            joined = dof * (u / own) ** 4 if own > 0.0 else math.inf
            if name == "sweep_rate":
                interval = t_interval(value, u, joined)
            else:  # where it begins lies in a rectangle
                interval = Interval(value - 0.95 * math.sqrt(3.0) * u, value + 0.95 * math.sqrt(3.0) * u)
            yield Row(Key(name, "control"), value, u, its, joined if math.isfinite(joined) else None, interval,
                      member=member, shared={CLOCK: value * u_clock} if u_clock else {})  # fmt: skip
        total = np.sqrt(np.sum(one.harmonics**2, axis=0))
        text = "harmonics 2 to 5 below 0.45 of the sample rate, median along the sweep; u is their scatter"
        for name, values, its, why in (
            ("drive_level", one.amplitude, "m/s^2",
             Reason("scatter", "median of the amplitude along the sweep; u is its scatter")),
            ("drive_distortion", total, "1", Reason("median", text)),
        ):  # fmt: skip
            value = float(np.median(values))
            scatter = 1.4826 * float(np.median(np.abs(values - value)))
            yield Row(Key(name, "control"), value, scatter, its, reason=why, member=member)

    def curves(self) -> list[Curve]:
        """Return transmissibilities: as the tracking filter reads them, and as the modes give them."""
        return [curve for axis, one in self.axes.items() for curve in self._of_axis(axis, one)]

    def _of_axis(self, axis: str, of_axis: OfAxis) -> Iterator[Curve]:
        swept = self.swept[0]
        frequency, tracked = tracked_ratio(swept, axis, self.plan.tracking)
        size = Column(np.abs(tracked), self.unit, self.unit)
        columns = {"frequency": Column(frequency, "Hz"), "transmissibility": size,
                   "phase": Column(np.angle(tracked), "rad")}  # fmt: skip
        yield Curve("transmissibility_tracked", axis, columns, picture=True)
        one = swept.sweep
        grid = np.geomspace(one.lowest, min(one.highest, 0.49 * swept.shaken.rate), POINTS)
        drawn = of_axis.sweeps.drawn
        for f, q in zip(drawn.frequency, drawn.amplification, strict=True):
            grid = np.append(grid, f * (1.0 + np.linspace(-3.0, 3.0, 41) / q))
        grid = np.unique(grid[(grid >= one.lowest) & (grid <= one.highest)])
        found = drawn.transmissibility(grid)
        columns = {"frequency": Column(grid, "Hz"), "transmissibility": Column(np.abs(found), self.unit, self.unit),
                   "phase": Column(np.angle(found), "rad")}  # fmt: skip
        yield Curve("transmissibility", axis, columns, picture=True)


def mode_key(quantity: str, axis: str, mode: int) -> Key:
    """Return the key of a figure of a mode, counted from 1 in order of frequency."""
    return Key(quantity, axis, at=At("mode", float(mode), ""))


def unit_of(readings: Readings) -> str:
    """Return the unit of response over control."""
    own = readings.shaken[0].unit
    return "1" if own == "m/s^2" else divide(own, "m/s^2")


def reduce(plan: Plan, readings: Readings) -> Result:
    """Find the sweeps, and the modes of each response.

    Raises
    ------
    DataError
        ``no_recordings``, ``no_sweep``.
    """
    if not readings.shaken:
        raise DataError("no recording", code="no_recordings")
    swept = [one for shaken in readings.shaken for one in sweeps_of(shaken)]
    axes = {}
    for axis in dict.fromkeys(axis for one in readings.shaken for axis in one.responses):
        mine = [one for one in swept if axis in one.shaken.responses]
        bands = [one.band(axis) for one in mine]
        sweeps = modes_of_sweeps(bands, plan.modes, plan.least)
        modes = sweeps.modes
        low, high = max(one.frequency[0] for one in bands), min(one.frequency[-1] for one in bands)
        half = 0.5 * modes.frequency / modes.amplification
        edge = (modes.frequency - half < low) | (modes.frequency + half > high)
        axes[axis] = OfAxis(axis, sweeps, tuple(one.label for one in mine), edge)
    remarks = [*readings.remarks]
    for one in swept:
        remarks += doubts(plan, one)
    for of_axis in axes.values():
        mine = [one for one in swept if of_axis.axis in one.shaken.responses]
        remarks += fit_doubts(of_axis, mine, plan.least)
    return Result(plan, readings, tuple(swept), axes, _estimate(plan, readings, axes), gather(remarks))


def _estimate(plan: Plan, readings: Readings, axes: dict[str, OfAxis]) -> Estimate | None:
    keys: list[Key] = []
    values: list[float] = []
    units: list[str] = []
    blocks, dof = [], []
    for axis, of_axis in axes.items():
        kept = np.flatnonzero(~of_axis.edge)
        at = (3 * kept[:, None] + np.arange(3)).ravel()
        blocks.append(of_axis.modes.covariance[np.ix_(at, at)])
        dof.append(of_axis.modes.dof[at])
        for i, k in enumerate(kept.tolist(), 1):
            keys += [mode_key(name, axis, i) for name in OF_MODE]
            values += [float(of_axis.modes.frequency[k]), float(of_axis.modes.amplification[k]),
                       float(of_axis.modes.peak[k])]  # fmt: skip
            units += ["Hz", "1", unit_of(readings)]
    if not keys:
        return None
    covariance = np.zeros((len(keys), len(keys)))
    first = 0
    for block in blocks:
        covariance[first : first + len(block), first : first + len(block)] = block
        first += len(block)
    components = [Component(SCATTER, "A", 0.5 * (covariance + covariance.T), np.concatenate(dof), "t")]
    clock = plan.standards.get(CLOCK)
    if clock is not None and clock.u > 0.0:
        own = np.array([value if key.quantity == FREQUENCY else 0.0 for key, value in zip(keys, values, strict=True)])
        changes = clock.u * own[None]
        components.append(Component(clock.origin("clock of the recorder"), "B", changes.T @ changes, clock.dof,
                                    clock.distribution, clock.stated, changes))  # fmt: skip
    return Estimate(tuple(keys), np.array(values), tuple(units), tuple(components))


def tracked_ratio(swept: Swept, axis: str, cycles: int) -> tuple[Array, NDArray[np.complex128]]:
    """Return frequencies and response over control behind a tracking filter: a Hann window of so many cycles."""
    one, rate = swept.sweep, swept.shaken.rate
    grid = np.geomspace(one.lowest, one.highest, POINTS // 2)[1:-1]
    kept, found = [], []
    for f in grid:
        middle, half = one.when(float(f)), 0.5 * cycles / f
        a, b = round((middle - half) * rate), round((middle + half) * rate)
        if a < swept.first or b > swept.stop or b - a < 8:
            continue
        t = np.arange(a, b) / rate
        turned = np.hanning(b - a) * np.exp(-1j * one.phase(t))
        below = np.sum(swept.shaken.control[a:b] * turned)
        if abs(below) > 0.0:
            kept.append(float(f))
            found.append(np.sum(swept.shaken.responses[axis][a:b] * turned) / below)
    return np.array(kept), np.array(found)
