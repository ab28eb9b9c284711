"""Which recordings, runs or readings of a rate table disagree with the table and with each other.

Every run about an axis has a response: what each channel reads of the rate of the table, as the repeated median of the
slopes, which nearly half of its readings cannot bend. It is compared

with the nominal
    the channel of the axis reads 1 of the rate, within ``plan.agreement`` and what its scatter leaves open; none reads
    more of it;
with the other runs about the axis at like rates
    on the scatter of those that agree (`statistics.agreement`), channel by channel;
reading by reading
    with the line of its own run and with what the other readings at that rate are off their lines: 7 robust standard
    deviations, more where there are few readings.

The chance of a false alarm is shared out: half to the responses of the axes that were turned, a quarter to those of the
others, a quarter to single readings. A difference that is clear
but too small to matter (a tenth of ``plan.agreement``) is a warning, and no error.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from statistics import median

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.key import AXES
from ...core.remarks import Remark, Severity
from ...statistics.agreement import (
    FALSE_ALARM,
    any_disagrees,
    disagreeing,
    medians,
    repeated_median_line,
    repeated_median_lines,
    robust_scales,
)
from ...statistics.intervals import t_quantile
from ..agreement import CLEAR, Cause, likely_cause
from .exclusions import exclusions
from .plan import Plan
from .readings import Readings
from .turned import LikeRows

FEWEST_SCATTERS = 7.0  # robust standard deviations from which a reading is odd
MATTERS = 0.1  # of ``plan.agreement``: relative difference from which a model would be wrong
SAME_RATE = 0.005  # of the largest rate
ENOUGH = 3  # readings at a rate that tell what a reading there should be
FEW = 5  # runs below which the scatter between the runs about other axes counts as well
CLIPPED = 0.01  # of the largest rate: what a saturated mean misses at least
CUBIC = 0.4  # part of what a cubic bend, which misses a share at the highest rate, misses at the next one
HELD = 0.1  # step of the readings from there to the highest, over that of the rates
SURE = 30.0  # degrees of freedom from which a scale stands for itself
AT_ONCE = 64  # readings of a run up to which the lines of all runs are found at once
EQUAL = 1e-9  # relative difference of numbers that are copies
EFFICIENCY = 0.64  # of a repeated median


@dataclass(frozen=True, eq=False)
class Run:
    """One run about one axis."""

    name: str  # As remarks call it
    place: str  # Its file; of a table that of its first reading
    axis: str
    at: NDArray[np.intp]  # Its rows


def agreement_many(tests: Sequence[tuple[Plan, Readings]]) -> list[list[Remark]]:
    """Return where runs and readings of each of many tests disagree with the nominal, and with each other.

    Units that were turned alike are looked at together.
    """
    found: list[list[Remark]] = [[] for _ in tests]
    alike: dict[tuple[object, ...], list[tuple[int, _Read]]] = {}
    for i, (plan, readings) in enumerate(tests):
        if not len(readings) or not readings.outputs:
            continue
        if copies := _copies(readings):
            found[i] = copies
            continue
        one = _Read.of(plan, readings)
        key = (id(plan), id(readings.turned), one.sensors) if np.isfinite(one.outputs).all() else (i,)
        alike.setdefault(key, []).append((i, one))
    for units in alike.values():
        figures = _Figures([one for _, one in units])
        for u, (i, one) in enumerate(units):
            if not figures.quiet[u]:
                judged = _Judged(one, figures, u)
                found[i] = [
                    *judged.saturated(),
                    *judged.against_nominal(),
                    *judged.against_others(),
                    *judged.single_readings(),
                ]
    return found


def _runs(readings: Readings) -> list[Run]:
    files = {one.recording: file for one, file in zip(readings.traces, readings.files, strict=False)}
    found = []
    for one in readings.turned.runs_about:
        said = [one.recording] if one.recording else []
        if one.run not in ("", one.recording):
            said.append(f"run {one.run} about {one.axis}")
        elif one.several or not said:
            said.append(f"about {one.axis}")
        place = files.get(one.recording) or (readings.where[one.at[0]] if readings.where else "")
        found.append(Run(", ".join(said), place, one.axis, one.at))
    return found


def _copies(readings: Readings) -> list[Remark]:
    """Return a remark for each run in which a channel holds the rates of the table, digit by digit."""
    found: dict[tuple[str, str], tuple[list[Run], list[str]]] = {}
    full = float(np.abs(readings.applied).max())
    away = np.abs(np.array([*readings.outputs.values()]) - readings.applied)
    if not (away <= EQUAL * full).any():
        return []
    for run in _runs(readings):
        x = readings.applied[run.at]
        if len(np.unique(x)) < ENOUGH:
            continue
        outputs = {sensor: y[run.at] for sensor, y in readings.outputs.items()}
        read = {sensor: y for sensor, y in outputs.items() if np.isfinite(y).sum() >= ENOUGH}
        copies = [sensor for sensor, y in read.items() if np.nanmax(np.abs(y - x)) <= EQUAL * np.max(np.abs(x))]
        if copies:
            first = run.at[0]
            recording = "" if readings.recording is None else str(readings.recording[first])
            label = "" if readings.run is None else str(readings.run[first])
            alike, sensors = found.setdefault((recording, label), ([], []))
            alike.append(run)
            sensors += [sensor for sensor in copies if sensor not in sensors]
    remarks = []
    for (recording, label), (alike, copies) in found.items():
        whole = [recording] * bool(recording) + [f"run {label}"] * (label not in ("", recording))
        name = alike[0].name if len(alike) == 1 else ", ".join(whole) or alike[0].name
        holds = f"{' and '.join(copies)} hold{'s' * (len(copies) == 1)}"
        what = f"{holds} the rates of the table, digit by digit: no sensor reads without error"
        do = "Give the columns with the readings of the sensor"
        remarks.append(Cause("copy_of_applied", what, do).remark(name, alike[0].place, copies[0]))
    return remarks


@dataclass(frozen=True, eq=False)
class _Read:
    """What a test reads, a row a sensor.

    Readings at the rail are left out here too. Those of an odd scatter are not: a run in another unit has one.
    """

    plan: Plan
    readings: Readings
    sensors: tuple[str, ...]
    outputs: Array  # shape (sensors, n)
    used: NDArray[np.bool_]  # shape (sensors, n)

    @classmethod
    def of(cls, plan: Plan, readings: Readings) -> _Read:
        """Return what a test reads."""
        sensors = tuple(readings.outputs)
        left_out = [exclusions(plan, readings, sensor) for sensor in sensors]
        rail = np.array([one.rail for one in left_out])
        y: Array = np.array([*readings.outputs.values()])
        if readings.earth is not None:
            y = y - readings.earth.T[[AXES.index(sensor) for sensor in sensors]]
        outputs = np.where(rail, np.nan, y) if rail.any() else y
        return cls(plan, readings, sensors, outputs, ~np.array([one.any for one in left_out]))


class _Figures:
    """Responses of the runs of tests whose units were turned alike and read everything; or of one test."""

    def __init__(self, units: Sequence[_Read]) -> None:
        first = units[0]
        self.plan, self.sensors, self.turned = first.plan, first.sensors, first.readings.turned
        self.applied, self.sets = first.readings.applied, self.turned.like_runs
        self.outputs = np.array([one.outputs for one in units])  # (units, sensors, n)
        self.slope, level = self._lines()  # (units, runs, sensors)
        numbers = self.turned.run_numbers
        by_run = (one[:, numbers].swapaxes(1, 2) for one in (level, self.slope))  # (units, sensors, n) each
        self.off = self.outputs - next(by_run) - next(by_run) * self.applied  # off the line of the run
        self.known = np.isfinite(self.off)
        axes = np.array([one.axis for one in self.turned.runs_about])
        self.own = axes[:, None] == np.array(self.sensors)  # (runs, sensors)
        # Less what all readings at a rate have in common: curvature of the sensor; its scatter and that of the slopes
        self.odd = self.off.copy()
        self.scale, self.dof = self._lent(*self._scales())  # (units, sets, sensors)
        spread = self._spreads()
        some = spread > 0.0
        scale = self.scale[:, self.turned.set_of_run]
        self.u = np.where(some, scale / np.sqrt(EFFICIENCY * np.where(some, spread, 1.0)), 0.0)
        self.nominal = self._nominal()  # (units, runs)
        judged = (self.dof > 0.0) & (self.scale > 0.0)  # coarse readings may not scatter at all
        least = np.where(judged, FEWEST_SCATTERS * self.scale, np.inf)[:, self.turned.set_of_run[numbers]]
        used = np.array([one.used for one in units])
        self.beyond = used & (np.abs(self.odd) > least.swapaxes(1, 2))  # (units, sensors, n)
        self.quiet: NDArray[np.bool_] = np.asarray(self.nominal.all(axis=1) & ~self.beyond.any(axis=(1, 2)))
        if self.quiet.any():
            self.quiet &= ~(self._differs() | self._may_saturate())

    @property
    def alpha(self) -> Array:
        """Chance of a false alarm that each sensor in each set of runs may have, shape (sets, sensors)."""
        owns = self.own[[one[0] for one in self.sets]]
        count = int(np.count_nonzero(owns))
        return FALSE_ALARM * np.where(owns, 0.5 / max(count, 1), 0.25 / max(owns.size - count, 1))

    def _lines(self) -> tuple[Array, Array]:
        """Return slope and level of each sensor in each run, shapes (units, runs, sensors)."""
        y = self.outputs
        slope, level = (np.full((len(y), len(self.turned.runs_about), y.shape[1]), np.nan) for _ in range(2))
        for numbers, rows in self.turned.run_lengths:
            if rows.shape[1] <= AT_ONCE:
                found = repeated_median_lines(self.applied[rows][:, None], y[:, :, rows].swapaxes(1, 2))
                slope[:, numbers], level[:, numbers] = found
                continue
            for i, at in zip(numbers, rows, strict=True):
                for u, unit in enumerate(y):
                    lines = [repeated_median_line(self.applied[at], one[at]) for one in unit]
                    slope[u, i], level[u, i] = zip(*lines, strict=True)
        return slope, level

    def _spreads(self) -> Array:
        """Return the sum of squares of the rates of each run about their mean, as read, (1 or units, runs, sensors)."""
        read = np.isfinite(self.outputs)
        if read.all():
            return np.repeat(self.turned.spread_in_runs(read[0, 0])[:, None], read.shape[1], axis=1)[None]
        return np.array([np.column_stack([self.turned.spread_in_runs(one) for one in unit]) for unit in read])

    def _scales(self) -> tuple[Array, Array]:
        """Return scale and degrees of freedom of the readings of sets of runs about their lines.

        Shapes (units, sets, sensors).
        """
        scale, dof = (np.zeros((len(self.outputs), len(self.sets), len(self.sensors))) for _ in range(2))

        def find(sets: NDArray[np.intp], sensors: NDArray[np.intp], like: LikeRows) -> None:
            off, fitted = self.off[:, sensors], 2 * len(self.sets[sets[0]])
            for same in like.at_rates:
                if same.shape[2] >= ENOUGH:
                    off[:, :, same] -= medians(off[:, :, same])[..., None]
                    fitted += same.shape[1]
            at = like.rows.ravel()
            self.odd[:, sensors[:, None], at] = off[:, :, at]
            for out, found in zip((scale, dof), robust_scales(off[:, :, like.rows], fitted), strict=True):
                out[:, sets[:, None], sensors] = found.swapaxes(1, 2)

        every = np.arange(len(self.sensors))
        if self.known.all():
            for sets, like in self.turned.sets_alike(SAME_RATE):
                find(sets, every, like)
            return scale, dof
        for k, sensors, rows in self._read_alike():
            rates = [same[None] for same in self.turned.at_rates(rows, SAME_RATE)]
            find(np.array([k]), np.array(sensors), LikeRows(rows[None], rates))
        return scale, dof

    def _read_alike(self) -> Iterator[tuple[int, list[int], NDArray[np.intp]]]:
        """Yield the sets of runs of one test, the sensors that read the same rows of them, and these."""
        for k, at in enumerate(self.turned.rows_of_sets):
            kinds: dict[bytes, list[int]] = {}
            for j, known in enumerate(self.known[0][:, at]):
                kinds.setdefault(known.tobytes(), []).append(j)
            for there, sensors in kinds.items():
                rows = at[np.frombuffer(there, dtype=bool)]
                if len(rows):
                    yield k, sensors, rows

    def _lent(self, scale: Array, dof: Array) -> tuple[Array, Array]:
        """Return scales with their degrees of freedom; one that rests on little is not below what is usual."""
        if (dof >= SURE).all():
            return scale, dof
        own, least, shared = self.own[[one[0] for one in self.sets]], scale.copy(), dof.copy()
        for kind in (own, ~own):
            known = dof[:, kind] > 0.0  # (units, k)
            middle = medians(np.where(known, scale[:, kind], np.nan))
            total = np.where(known, dof[:, kind], 0.0).sum(axis=1)
            for out, one in ((least, middle), (shared, total)):
                out[:, kind] = np.where(known.any(axis=1), one, out[:, kind].T).T
        sure = dof >= SURE
        return np.where(sure, scale, np.maximum(scale, least)), np.where(sure, dof, shared)

    def _nominal(self) -> NDArray[np.bool_]:
        """Return of each run whether nothing of its response would be named, whatever its scatter leaves open."""
        away = np.abs(self.slope - self.own) <= np.where(self.own, self.plan.agreement, CLEAR)
        return np.asarray(away.all(axis=2) & self.own.any(axis=1))

    def _differs(self) -> NDArray[np.bool_]:
        """Return of which tests a run may differ from the others about its axis, nothing else being wrong."""
        found, alpha = np.zeros(len(self.slope), dtype=bool), self.alpha
        for sets, runs in self.turned.set_lengths:
            values, u = (each[:, runs].swapaxes(2, 3) for each in (self.slope, self.u))  # (units, sets, sensors, runs)
            if runs.shape[1] < FEW or not np.isfinite(values).all():
                found[:] = True  # each is judged by itself
                continue
            limits = np.broadcast_to(alpha[sets], values.shape[:3]).ravel()
            count = runs.shape[1]
            any_of = any_disagrees(values.reshape(-1, count), u.reshape(-1, count), limits)
            found |= any_of.reshape(len(found), -1).any(axis=1)
        return found

    def _may_saturate(self) -> NDArray[np.bool_]:
        """Return of which tests a sensor may miss the highest rates, both ways."""
        found = np.zeros(len(self.slope), dtype=bool)
        for k, one in enumerate(self.sets):
            axis = self.turned.runs_about[one[0]].axis
            if axis not in self.sensors:
                continue
            j, rows = self.sensors.index(axis), self.turned.rows_of_sets[k]
            if not self.known[:, j, rows].all():
                found[:] = True
                continue
            highest = self.turned.highest(rows)
            if highest is not None and highest.sizes >= ENOUGH:
                low, high = (medians(self.off[:, j, way[0][1]]) for way in highest.ways)
                found |= np.minimum(low, -high) > CLIPPED * highest.largest
        return found


class _Judged:
    """The runs of one test with their responses."""

    def __init__(self, one: _Read, figures: _Figures, u: int) -> None:
        self.plan, self.readings, self.sensors = one.plan, one.readings, one.sensors
        self.applied, self.where, self.used, self.outputs = figures.applied, one.readings.where, one.used, one.outputs
        self.turned, self.sets, self.own, self.alpha = figures.turned, figures.sets, figures.own, figures.alpha
        self.slope, self.off, self.known, self.odd = (
            each[u] for each in (figures.slope, figures.off, figures.known, figures.odd)
        )
        self.scale, self.dof, self.u, self.nominal, self.beyond = (
            each[u] for each in (figures.scale, figures.dof, figures.u, figures.nominal, figures.beyond)
        )
        self.named = np.zeros(len(self.slope), dtype=bool)

    @cached_property
    def runs(self) -> list[Run]:
        """Its runs, as remarks call them."""
        return _runs(self.readings)

    def against_nominal(self) -> Iterator[Remark]:
        """Yield what reads something else than the rate of the table."""
        nominal = self.nominal
        if (nominal | self.named).all():
            return
        for axis in dict.fromkeys(run.axis for run in self.runs):
            mine = [i for i, run in enumerate(self.runs) if run.axis == axis and not self.named[i]]
            causes = {i: self._cause(i) for i in mine if not nominal[i]}
            bad = {i: cause for i, cause in causes.items() if cause is not None}
            self.named[list(bad)] = True
            if len(mine) > 1 and len(bad) == len(mine) and len({one.code for one in bad.values()}) == 1:
                first, cause = next(iter(bad.items()))
                yield cause.remark(f"all {len(mine)} runs about {axis}", self.runs[first].place, axis)
                continue
            for i, cause in bad.items():
                yield cause.remark(self.runs[i].name, self.runs[i].place, axis)

    def _cause(self, i: int) -> Cause | None:
        axis = self.runs[i].axis
        k = next(k for k, one in enumerate(self.sets) if i in one)
        response = dict(zip(self.sensors, self.slope[i].tolist(), strict=True))
        dof = self.dof[k].tolist()
        sure = 1.0 - 0.5 * FALSE_ALARM / self.slope.size
        doubt = {s: t_quantile(nu, sure) * self.u[i, j] if nu else 0.0
                 for j, (s, nu) in enumerate(zip(self.sensors, dof, strict=True))}  # fmt: skip
        kind, applied = "angular_rate", "the rate of the table"
        return likely_cause(response, axis, self.plan.agreement, kind, applied, doubt=doubt)

    def against_others(self) -> Iterator[Remark]:
        """Yield runs that differ from the others about the axis."""
        slopes = np.where(self.named[:, None], np.nan, self.slope)
        alpha = self.alpha
        alone = np.ones(alpha.shape, dtype=bool)  # not judged by themselves, of one number of runs
        for sets, runs in self.turned.set_lengths:
            values, u = (each[runs].swapaxes(1, 2) for each in (slopes, self.u))  # (sets, sensors, runs)
            at, of = np.nonzero(np.isfinite(values).all(axis=2) & (runs.shape[1] >= FEW))
            alone[sets[at], of] = any_disagrees(values[at, of], u[at, of], alpha[sets[at], of])
        for pair in np.argwhere(alone):
            k, j = int(pair[0]), int(pair[1])
            one, sensor = list(self.sets[k]), self.sensors[j]
            few = np.isfinite(slopes[one, j]).sum() < FEW
            scatter, dof = self._scatter_of_others(k, j) if few else (0.0, 0.0)
            bad = disagreeing(slopes[one, j], self.u[one, j], float(alpha[k, j]), scatter, dof)
            if bad.any():
                yield from self._different([one[i] for i in np.flatnonzero(bad)], one, j, sensor)

    def _scatter_of_others(self, k: int, j: int) -> tuple[float, float]:
        """Return the scatter of the like response between the runs of the other sets, and its degrees of freedom.

        That of the axis itself, or of another axis, of all sensors: the largest.
        """
        own = self.runs[self.sets[k][0]].axis == self.sensors[j]
        found, dof = [], 0
        for other, one in enumerate(self.sets):
            for i, sensor in enumerate(self.sensors):
                slopes = np.where(self.named[list(one)], np.nan, self.slope[list(one), i])
                count = int(np.isfinite(slopes).sum())
                if (other, i) != (k, j) and (self.runs[one[0]].axis == sensor) == own and count > 1:
                    found.append(max(float(np.nanstd(slopes, ddof=1)), float(np.max(self.u[list(one), i]))))
                    dof += count - 1
        return (max(found), float(dof)) if found else (0.0, 0.0)

    def _different(self, bad: Sequence[int], one: Sequence[int], j: int, sensor: str) -> Iterator[Remark]:
        axis, own = self.runs[one[0]].axis, self.runs[one[0]].axis == sensor
        judged = [i for i in one if not self.named[i] and np.isfinite(self.slope[i, j])]
        everything = len(bad) == len(judged)
        rest = float(np.median([self.slope[i, j] for i in judged if everything or i not in bad]))
        for i in bad:
            size = abs(self.slope[i, j] - rest)
            severity: Severity = "error" if size > MATTERS * self.plan.agreement else "warning"
            reads = f"{sensor} reads {self.slope[i, j]:+.6g} of the rate about {axis}"
            if everything:
                others = ", ".join(self.runs[other].name for other in bad if other != i)
                what = f"{reads}, unlike {others}: nothing tells which is wrong"
            else:
                what = f"{reads}, the other runs {rest:+.6g}: {100.0 * (self.slope[i, j] - rest):+.3g} % of the rate"
            code, do = "gain_disagrees", "Check gain, range, rate and temperature of this run, or leave it out"
            if not own:
                code, do = "axes_disagree", "Check how the unit was mounted in this run, or leave it out"
            yield Cause(code, what, do).remark(self.runs[i].name, self.runs[i].place, sensor, severity)

    def saturated(self) -> Iterator[Remark]:
        """Yield runs that follow the lower rates and not the highest ones, both ways: their means saturate."""
        for k, one in enumerate(self.sets):
            axis = self.turned.runs_about[one[0]].axis
            ends = self._saturated(k, self.sensors.index(axis)) if axis in self.sensors else None
            if ends is not None:
                self.named[list(one)] = True
                name = f"all {len(one)} runs about {axis}" if len(one) > 1 else self.runs[one[0]].name
                low, high = np.degrees(ends)
                what = f"{axis} follows the lower rates, and at the highest reads {low:+.5g} and {high:+.5g} deg/s only"
                do = "Leave the highest rates out, or give the range of the sensor"
                cause = Cause("saturated", f"{what}: it saturates", do)
                yield cause.remark(name, self.runs[one[0]].place, axis)

    def _saturated(self, k: int, j: int) -> Array | None:
        """Return the readings of a sensor at the highest rates both ways, where they saturate; None elsewhere."""
        rows = self.turned.rows_of_sets[k]
        highest = self.turned.highest(rows[self.known[j, rows]])
        if highest is None or highest.sizes < ENOUGH:
            return None
        y, off, largest = self.outputs[j], self.off[j], highest.largest
        tops = [median(off[rows].tolist()) for _, rows in (way[0] for way in highest.ways)]
        if not min(tops[0], -tops[1]) > CLIPPED * largest:
            return None
        ends, least, step, others, bend = [], np.inf, 0.0, 0.0, 0.0
        for way, rates in zip((-1.0, 1.0), highest.ways, strict=True):
            (rate, rows), (next_rate, next_rows) = rates  # all of them read
            top, top_off, lower, lower_off = (
                median(of[some].tolist()) for some in (rows, next_rows) for of in (y, off)
            )
            ends.append(top)
            least = min(least, -way * top_off)
            others, bend = max(others, abs(lower_off)), max(bend, (next_rate / rate) ** 3)
            step = max(step, abs((top - lower) / (rate - next_rate)))
        fitted = 2 * len(self.sets[k])
        if not (others < CUBIC * bend * least or step < HELD):
            return None
        x = np.abs(self.applied[highest.rows])
        inner = [off[highest.rows[x < (1.0 - SAME_RATE) * rate]] for rate in (abs(highest.ways[1][1][0]), largest)]
        rest = next((one for one in inner if len(one) > fitted), None)
        if rest is None:
            return None
        dof = float(len(rest) - fitted)
        noise = float(np.sqrt(np.sum(rest**2) / dof)) * t_quantile(dof, 1.0 - FALSE_ALARM / 10.0)
        return np.array(ends) if least > noise else None

    def single_readings(self) -> Iterator[Remark]:
        """Yield readings that are off the line of their run, unlike the others at their rate."""
        p = FALSE_ALARM * 0.25 / max(float(np.count_nonzero(self.known)), 1.0)
        beyond = self.beyond
        if not beyond.any():
            return
        for k, one in enumerate(self.sets):
            for j in np.flatnonzero(beyond[:, self.turned.rows_of_sets[k]].any(axis=1)).tolist():
                scale = float(self.scale[k, j])
                limit = scale * max(FEWEST_SCATTERS, t_quantile(float(self.dof[k, j]), 1.0 - 0.5 * p))
                for i in one:
                    if not self.named[i]:
                        yield from self._odd_readings(self.runs[i], j, limit, scale, len(one))

    def _odd_readings(self, run: Run, j: int, limit: float, scale: float, runs: int) -> Iterator[Remark]:
        x, off, used, sensor = self.applied[run.at], self.odd[j, run.at], self.used[j, run.at], self.sensors[j]
        full = float(np.max(np.abs(x)))
        if runs < ENOUGH:  # no other reading shows how the sensor is curved
            limit = max(limit, self.plan.agreement * full)
        kept = used & (np.abs(off) <= limit)
        odd = np.flatnonzero(used & (np.abs(off) > limit))
        if not len(odd) or len(np.unique(x[kept])) < ENOUGH:
            return
        # The line again, by least squares without them: that of the medians scatters more at the ends
        design = np.column_stack([np.ones_like(x), x])
        solve = np.linalg.pinv(design[kept])
        away = off - design @ (solve @ off[kept])
        size = np.abs(away) / np.sqrt(1.0 + np.sum((design @ solve) ** 2, axis=1))
        odd = odd[size[odd] > limit]
        if not len(odd):
            return
        worst = odd[np.argmax(size[odd])]
        severity: Severity = "error" if size[worst] > MATTERS * self.plan.agreement * full else "warning"
        rate, far, reads = np.degrees([x[worst], away[worst], self.outputs[j, run.at[worst]]])
        many = "1 reading is" if len(odd) == 1 else f"{len(odd)} of {len(run.at)} readings are"
        what = (
            f"{many} unlike the others: {sensor} at {rate:+.6g} deg/s about {run.axis} reads {reads:+.6g} deg/s,"
            f" {far:+.4g} deg/s or {size[worst] / scale:.3g} scatters off"
        )
        place = self.where[run.at[worst]] if self.where else ""
        yield Cause("reading_disagrees", what, "Check it, or leave it out").remark(run.name, place, sensor, severity)
