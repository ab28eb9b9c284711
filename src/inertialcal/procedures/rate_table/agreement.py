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

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
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


def agreement(plan: Plan, readings: Readings) -> list[Remark]:
    """Return where runs and readings disagree with the nominal, and with each other."""
    if not len(readings) or not readings.outputs:
        return []
    runs = _runs(readings)
    if copies := _copies(readings, runs):
        return copies
    judged = _Judged(plan, readings, runs)
    return [
        *judged.saturated(),
        *judged.against_nominal(),
        *judged.against_others(),
        *judged.single_readings(),
    ]


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


def _copies(readings: Readings, runs: Sequence[Run]) -> list[Remark]:
    """Return a remark for each run in which a channel holds the rates of the table, digit by digit."""
    found: dict[tuple[str, str], tuple[list[Run], list[str]]] = {}
    full = float(np.max(np.abs(readings.applied)))
    near = {sensor: np.abs(y - readings.applied) <= EQUAL * full for sensor, y in readings.outputs.items()}
    if not any(one.any() for one in near.values()):
        return []
    for run in runs:
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


class _Judged:
    """Runs with their responses.

    Readings at the rail are left out here too. Those of an odd scatter are not: a run in another unit has one.
    """

    def __init__(self, plan: Plan, readings: Readings, runs: Sequence[Run]) -> None:
        self.plan, self.runs, self.applied, self.where = plan, runs, readings.applied, readings.where
        left_out = {sensor: exclusions(plan, readings, sensor) for sensor in readings.outputs}
        earth = np.zeros((len(readings), len(AXES))) if readings.earth is None else readings.earth
        outputs = {
            sensor: np.where(left_out[sensor].rail, np.nan, y - earth[:, AXES.index(sensor)])
            for sensor, y in readings.outputs.items()
        }
        self.outputs, self.used = outputs, {sensor: ~one.any for sensor, one in left_out.items()}
        self.sensors = tuple(outputs)
        self.turned = readings.turned
        applied, numbers = readings.applied, self.turned.run_numbers
        self.slope, level = self._lines()
        self.off = {  # off the line of the run
            s: y - level[numbers, j] - self.slope[numbers, j] * applied for j, (s, y) in enumerate(outputs.items())
        }
        self.sets = self.turned.like_runs
        # Less what all readings at a rate have in common: curvature of the sensor; its scatter and that of the slopes
        self.odd = {s: off.copy() for s, off in self.off.items()}
        alone = {(k, s): one for k in range(len(self.sets)) for s, one in self._scales(k).items()}
        self.scales = self._lent(alone)
        spread = self._spreads()
        scale = np.zeros_like(self.slope)
        for k, one in enumerate(self.sets):
            for j, sensor in enumerate(outputs):
                scale[list(one), j] = self.scales[k, sensor][0]
        some = spread > 0.0
        self.u = np.where(some, scale / np.sqrt(EFFICIENCY * np.where(some, spread, 1.0)), 0.0)
        self.named = np.zeros(len(runs), dtype=bool)

    def _lines(self) -> tuple[Array, Array]:
        """Return slope and level of each sensor in each run, shapes (runs, sensors)."""
        y = np.column_stack([*self.outputs.values()]).T
        slope, level = (np.full((len(self.runs), len(y)), np.nan) for _ in range(2))
        for numbers, rows in self.turned.run_lengths:
            if rows.shape[1] <= AT_ONCE:
                found = repeated_median_lines(self.applied[rows][:, None], y[:, rows].swapaxes(0, 1))
                slope[numbers], level[numbers] = found
                continue
            for i, at in zip(numbers, rows, strict=True):
                lines = [repeated_median_line(self.applied[at], one[at]) for one in y]
                slope[i], level[i] = zip(*lines, strict=True)
        return slope, level

    def _spreads(self) -> Array:
        """Return the sum of squares of the rates of each run about their mean, as read, shape (runs, sensors)."""
        found, runs = np.zeros_like(self.slope), len(self.runs)
        for j, y in enumerate(self.outputs.values()):
            numbers, x = self.turned.run_numbers, self.applied
            if not (read := np.isfinite(y)).all():
                numbers, x = numbers[read], x[read]
            count = np.maximum(np.bincount(numbers, minlength=runs), 1)
            away = x - (np.bincount(numbers, x, runs) / count)[numbers]
            found[:, j] = np.bincount(numbers, away**2, runs)
        return found

    def _scales(self, k: int) -> dict[str, tuple[float, float]]:
        """Return by sensor scale and degrees of freedom of the readings of a set of runs about their lines."""
        at = np.concatenate([self.runs[i].at for i in self.sets[k]])
        kinds: dict[bytes, list[str]] = {}
        for sensor, off in self.off.items():
            kinds.setdefault(np.isfinite(off[at]).tobytes(), []).append(sensor)
        found: dict[str, tuple[float, float]] = {}
        for known, sensors in kinds.items():
            rows = at[np.frombuffer(known, dtype=bool)]
            off = np.array([self.off[sensor] for sensor in sensors])
            fitted = 2 * len(self.sets[k])
            if len(rows):
                for same in self.turned.at_rates(rows, SAME_RATE):
                    if same.shape[1] >= ENOUGH:
                        off[:, same] -= medians(off[:, same])[..., None]
                        fitted += len(same)
            for sensor, one in zip(sensors, off, strict=True):
                self.odd[sensor][rows] = one[rows]
            scale, dof = robust_scales(off[:, rows], fitted)
            found.update(zip(sensors, zip(scale.tolist(), dof.tolist(), strict=True), strict=True))
        return {sensor: found[sensor] for sensor in self.sensors}

    def _lent(self, alone: Mapping[tuple[int, str], tuple[float, float]]) -> dict[tuple[int, str], tuple[float, float]]:
        """Return scales with their degrees of freedom; one that rests on little is not below what is usual."""
        if all(dof >= SURE for _, dof in alone.values()):
            return dict(alone)
        axes = [self.runs[one[0]].axis for one in self.sets]
        usual: dict[bool, tuple[float, float]] = {}
        for own in (True, False):
            like = [one for (k, s), one in alone.items() if (axes[k] == s) == own and one[1] > 0.0]
            if like:
                usual[own] = median(scale for scale, _ in like), sum(dof for _, dof in like)
        found = {}
        for (k, s), (scale, dof) in alone.items():
            least, shared = usual.get(axes[k] == s, (scale, dof))
            found[k, s] = (scale, dof) if dof >= SURE else (max(scale, least), shared)
        return found

    def against_nominal(self) -> Iterator[Remark]:
        """Yield what reads something else than the rate of the table."""
        for axis in dict.fromkeys(run.axis for run in self.runs):
            mine = [i for i, run in enumerate(self.runs) if run.axis == axis and not self.named[i]]
            causes = {i: self._cause(i) for i in mine if not self._is_nominal(i)}
            bad = {i: cause for i, cause in causes.items() if cause is not None}
            self.named[list(bad)] = True
            if len(mine) > 1 and len(bad) == len(mine) and len({one.code for one in bad.values()}) == 1:
                first, cause = next(iter(bad.items()))
                yield cause.remark(f"all {len(mine)} runs about {axis}", self.runs[first].place, axis)
                continue
            for i, cause in bad.items():
                yield cause.remark(self.runs[i].name, self.runs[i].place, axis)

    def _is_nominal(self, i: int) -> bool:
        """Whether nothing of a response would be named, whatever its scatter leaves open."""
        away = {
            s: abs(one - (s == self.runs[i].axis)) for s, one in zip(self.sensors, self.slope[i].tolist(), strict=True)
        }
        own = away.pop(self.runs[i].axis, np.nan)
        return own <= self.plan.agreement and all(one <= CLEAR for one in away.values())

    def _cause(self, i: int) -> Cause | None:
        axis = self.runs[i].axis
        k = next(k for k, one in enumerate(self.sets) if i in one)
        response = dict(zip(self.sensors, self.slope[i].tolist(), strict=True))
        dof = [self.scales[k, sensor][1] for sensor in self.sensors]
        sure = 1.0 - 0.5 * FALSE_ALARM / self.slope.size
        doubt = {s: t_quantile(nu, sure) * self.u[i, j] if nu else 0.0
                 for j, (s, nu) in enumerate(zip(self.sensors, dof, strict=True))}  # fmt: skip
        kind, applied = "angular_rate", "the rate of the table"
        return likely_cause(response, axis, self.plan.agreement, kind, applied, doubt=doubt)

    def against_others(self) -> Iterator[Remark]:
        """Yield runs that differ from the others about the axis."""
        pairs = [(k, j) for k in range(len(self.sets)) for j in range(len(self.sensors))]
        owns = {(k, j): self.runs[self.sets[k][0]].axis == self.sensors[j] for k, j in pairs}
        alike: dict[int, list[tuple[int, int]]] = {}  # judged by themselves, of one number of runs
        alone: list[tuple[int, int]] = []
        slopes = np.where(self.named[:, None], np.nan, self.slope)
        for k, j in pairs:
            one = list(self.sets[k])
            whole = len(one) >= FEW and np.isfinite(slopes[one, j]).all()
            (alike.setdefault(len(one), []) if whole else alone).append((k, j))
        everyone = list(owns.values())
        alpha = {own: FALSE_ALARM * (0.5 if own else 0.25) / max(everyone.count(own), 1) for own in (True, False)}
        for some in alike.values():
            values, u = (np.array([of[list(self.sets[k]), j] for k, j in some]) for of in (slopes, self.u))
            found = any_disagrees(values, u, np.array([alpha[owns[pair]] for pair in some]))
            alone += [pair for pair, bad in zip(some, found, strict=True) if bad]
        for k, j in sorted(alone):
            one, sensor = list(self.sets[k]), self.sensors[j]
            few = np.isfinite(slopes[one, j]).sum() < FEW
            scatter, dof = self._scatter_of_others(k, j) if few else (0.0, 0.0)
            bad = disagreeing(slopes[one, j], self.u[one, j], alpha[owns[k, j]], scatter, dof)
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
            axis = self.runs[one[0]].axis
            ends = self._saturated(k, axis) if axis in self.sensors else None
            if ends is not None:
                self.named[list(one)] = True
                name = f"all {len(one)} runs about {axis}" if len(one) > 1 else self.runs[one[0]].name
                low, high = np.degrees(ends)
                what = f"{axis} follows the lower rates, and at the highest reads {low:+.5g} and {high:+.5g} deg/s only"
                do = "Leave the highest rates out, or give the range of the sensor"
                cause = Cause("saturated", f"{what}: it saturates", do)
                yield cause.remark(name, self.runs[one[0]].place, axis)

    def _saturated(self, k: int, axis: str) -> Array | None:
        """Return the readings at the highest rates both ways, where they saturate; None elsewhere."""
        at = np.concatenate([self.runs[i].at for i in self.sets[k]])
        highest = self.turned.highest(at[np.isfinite(self.off[axis][at])])
        if highest is None or highest.sizes < ENOUGH:
            return None
        y, off = self.outputs[axis], self.off[axis]
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
        largest, fitted = highest.largest, 2 * len(self.sets[k])
        if not (least > CLIPPED * largest and (others < CUBIC * bend * least or step < HELD)):
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
        count = sum(np.isfinite(off).sum() for off in self.off.values())
        p = FALSE_ALARM * 0.25 / max(float(count), 1.0)
        for k, one in enumerate(self.sets):
            at = np.concatenate([self.runs[i].at for i in one])
            for sensor in self.sensors:
                scale, dof = self.scales[k, sensor]
                if dof <= 0.0 or scale <= 0.0:  # coarse readings may not scatter at all
                    continue
                if not np.any(self.used[sensor][at] & (np.abs(self.odd[sensor][at]) > FEWEST_SCATTERS * scale)):
                    continue
                limit = scale * max(FEWEST_SCATTERS, t_quantile(dof, 1.0 - 0.5 * p))
                for i in one:
                    if not self.named[i]:
                        yield from self._odd_readings(self.runs[i], sensor, limit, scale, len(one))

    def _odd_readings(self, run: Run, sensor: str, limit: float, scale: float, runs: int) -> Iterator[Remark]:
        x, off, used = self.applied[run.at], self.odd[sensor][run.at], self.used[sensor][run.at]
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
        rate, far, reads = np.degrees([x[worst], away[worst], self.outputs[sensor][run.at[worst]]])
        many = "1 reading is" if len(odd) == 1 else f"{len(odd)} of {len(run.at)} readings are"
        what = (
            f"{many} unlike the others: {sensor} at {rate:+.6g} deg/s about {run.axis} reads {reads:+.6g} deg/s,"
            f" {far:+.4g} deg/s or {size[worst] / scale:.3g} scatters off"
        )
        place = self.where[run.at[worst]] if self.where else ""
        yield Cause("reading_disagrees", what, "Check it, or leave it out").remark(run.name, place, sensor, severity)
