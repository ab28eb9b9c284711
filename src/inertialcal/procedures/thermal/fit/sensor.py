"""One sensor reduced: start-up cut, order chosen, law fitted, paths compared, reference voltages over temperature."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np

from ....core.batches import every, extremes
from ....core.errors import DataError
from ....core.estimate import Array
from ....core.remarks import Remark
from ....core.results import changed
from ....statistics.least_squares import times
from ..plan import Plan
from ..recordings import Readings
from .agreement import disagreements
from .cells import Cells, Series, cells_of, find_cells, joined, lagging
from .law import Law, gathered, judge, law_of, series_each, unjudged_law_of, unjudged_laws_of
from .order import Choice, choose_order, find_scores
from .paths import Paths, Separated, find_differences, find_rates, paths_of, separated
from .start_up import StartUp, start_up_of

R = TypeVar("R")
ROUNDS, RESOLVED = 3, 2.0  # of the fit of a lag that stands out by so many standard uncertainties
NEXT = 2  # orders above the one chosen that the interval allows for
BINS_AN_ORDER = 3  # that a polynomial needs for each order
REFERENCE_ORDER = 3  # largest that comes into question for a reference voltage


@dataclass(frozen=True, eq=False)
class OfSensor:
    """What the test shows of one sensor."""

    series: Series  # All samples
    law: Law  # Bias over temperature
    choice: Choice  # Of its order
    start_up: StartUp  # Transient after power-up, and the cut
    paths: Paths  # What differs between warming and cooling
    references: Mapping[str, Law]  # Reference voltages over temperature [V]
    run_offsets: Array  # shape (r,): mean residual of each run [unit of the readings]
    remarks: tuple[Remark, ...]  # Findings

    @property
    def cells(self) -> Cells:
        """Of the law."""
        return self.law.cells


@dataclass(eq=False)
class _Sensor:
    """One sensor while it is reduced."""

    plan: Plan
    readings: Readings
    series: Series
    start_up: StartUp
    cells: Cells

    @classmethod
    def of(cls, plan: Plan, readings: Readings, series: Series) -> _Sensor:
        """Return a sensor with its cells, the start-up cut."""
        cells = cells_of(plan, series, plan.warm_up or 0.0)
        first = plan.order if plan.order is not None else _largest(cells, plan.largest_order)
        start_up = start_up_of(plan, series, cells, partial(unjudged_law_of, cells, first))
        if start_up.cut > (plan.warm_up or 0.0):
            cells = cells_of(plan, series, start_up.cut)
        return cls(plan, readings, series, start_up, cells)

    @property
    def tried(self) -> int:
        """Largest order that is tried."""
        return max(_largest(self.cells, self.plan.largest_order), self.plan.order or 0)

    def lagging(self, law: Law) -> tuple[Law, Separated]:
        """Return the law with the rate of the temperature as a lag that stands out smooths it."""
        apart = separated(law)
        for _ in range(ROUNDS):
            lag = apart.lag
            if lag.value is None or lag.u is None or not lag.value > RESOLVED * lag.u:
                break
            self.cells = lagging(self.plan, self.series, self.cells, lag.value, self.start_up.cut)
            law = law_of(self.cells, law.order, law.path_fit)
            apart = separated(law)
        return law, apart

    def higher(self, choice: Choice) -> int | None:
        """Return the higher order that the interval allows for; None where there is none."""
        highest = min(choice.order + NEXT, _largest(self.cells, self.plan.largest_order + NEXT))
        return highest if choice.held_out != "given" and highest > choice.order else None


def reduce_sensors(tests: Sequence[tuple[Plan, Readings, Series]]) -> list[OfSensor | DataError]:
    """Reduce sensors, of one unit or of many: those whose cells are of one shape at once.

    A sensor is refused, its error in its place, if nothing valid is left of it, or what is left lies at one
    temperature.
    """
    refused: dict[int, DataError] = {}
    find_cells([(plan, series, plan.warm_up or 0.0) for plan, _, series in tests])
    sensors = _made(range(len(tests)), lambda i: _Sensor.of(*tests[i]), refused)
    numbers = [*sensors]
    for kind in gathered(one.tried for one in sensors.values()):
        own = [sensors[numbers[k]] for k in kind]
        find_scores([one.cells for one in own], own[0].tried)
    choices = {i: choose_order(one.cells, one.tried, one.plan.order) for i, one in sensors.items()}
    laws = _laws({i: (one.cells, choices[i].order) for i, one in sensors.items()}, refused)
    refused |= {i: error for i, error in zip(laws, judge([*laws.values()]), strict=True) if error is not None}
    final = _made((i for i in laws if i not in refused), lambda i: sensors[i].lagging(laws[i]), refused)
    find_differences([law for law, _ in final.values() if law.midway])
    find_rates([law.cells for law, _ in final.values()])
    wanted = {i: (sensors[i].cells, order) for i in final if (order := sensors[i].higher(choices[i])) is not None}
    higher = _laws(wanted, refused)

    def finished(i: int) -> OfSensor:
        law, apart = final[i]
        return _found(sensors[i], changed(law, higher=higher[i]) if i in higher else law, choices[i], apart, offsets[i])

    offsets = dict(zip(final, offsets_each([law for law, _ in final.values()]), strict=True))
    found = _made((i for i in final if i not in refused), finished, refused)
    return [found[i] if i in found else refused[i] for i in range(len(tests))]


def _made(numbers: Iterable[int], make: Callable[[int], R], refused: dict[int, DataError]) -> dict[int, R]:
    """Return what is made of each number; a refusal is put with the others."""
    found: dict[int, R] = {}
    for i in numbers:
        try:
            found[i] = make(i)
        except DataError as error:
            refused[i] = error
    return found


def _laws(wanted: Mapping[int, tuple[Cells, int]], refused: dict[int, DataError]) -> dict[int, Law]:
    """Return laws of cells and orders, by number; a refusal is put with the others."""
    laws: dict[int, Law] = {}
    numbers = [*wanted]
    for kind in gathered(order for _, order in wanted.values()):
        at = [numbers[k] for k in kind]
        for i, law in zip(at, unjudged_laws_of([wanted[i][0] for i in at], wanted[at[0]][1]), strict=True):
            if isinstance(law, DataError):
                refused[i] = law
            else:
                laws[i] = law
    return laws


def _found(one: _Sensor, law: Law, choice: Choice, apart: Separated, offsets: Array) -> OfSensor:
    plan, readings, series, start_up = one.plan, one.readings, one.series, one.start_up
    remarks = (
        *disagreements(series.axis, law.cells, readings),
        *_without_ramp(readings, series),
        *_remarks(plan, readings, series.axis, law, start_up),
    )
    references = _references(plan, readings, series, start_up.cut)
    paths = paths_of(law, apart, plan.no_hysteresis)
    return OfSensor(series, law, choice, start_up, paths, references, offsets, remarks)


def _largest(cells: Cells, wanted: int) -> int:
    """Return the largest order that comes into question: that the bins carry, and no larger than wanted."""
    return min(wanted, max((cells.bins - 1) // BINS_AN_ORDER, 0))


def _references(plan: Plan, readings: Readings, series: Series, cut: float) -> dict[str, Law]:
    """Laws of the reference voltages that were recorded with this sensor."""
    axis, found = series.axis, {}
    sweeps = [one for one in readings.sweeps if axis in one.outputs]
    for name in dict.fromkeys(name for one in sweeps for name in one.references):
        volts = [one.references.get(name, {}).get(axis, len(one)) for one in sweeps]
        try:
            cells = cells_of(plan, series.of(joined(volts)), cut)
        except DataError:  # no valid sample: the chain has a remark
            continue
        found[name] = law_of(cells, choose_order(cells, _largest(cells, REFERENCE_ORDER)).order)
    return found


def run_offsets(law: Law) -> Array:
    """Return the weighted mean residual of each run, shape (r,) [unit of the readings]."""
    return offsets_each([law])[0]


def offsets_each(laws: Sequence[Law]) -> list[Array]:
    """Return the same of several laws, those of one shape at once."""
    found: dict[int, Array] = {}
    for at in gathered((len(one.cells), one.order, one.path_order, one.cells.runs) for one in laws):
        own = [laws[i] for i in at]
        order, path_order, runs = own[0].order, own[0].path_order, own[0].cells.runs
        rows = series_each([one.cells for one in own], max(order, path_order))
        fitted = times(rows[..., : order + 1], np.array([one.coefficients for one in own]))
        if path_order >= 0:
            ways = np.array([one.path_fit.coefficients[order + 1 :] for one in own])
            path = np.array([one.cells.path for one in own])
            fitted = fitted + 0.5 * path * times(rows[..., : path_order + 1], ways)
        weight = np.array([one.cells.weight for one in own])
        left = weight * (np.array([one.cells.reading for one in own]) - fitted)
        number = (np.array([one.cells.run_number for one in own]) + runs * np.arange(len(own))[:, None]).ravel()
        sums, total = np.bincount(number, left.ravel()), np.bincount(number, weight.ravel())
        found.update(zip(at, (sums / total).reshape(len(own), runs), strict=True))
    return [found[i] for i in range(len(laws))]


def _without_ramp(readings: Readings, series: Series) -> list[Remark]:
    """Return a remark for each recording in which the temperature hardly changes: nothing of it is used."""

    def flat() -> list[bool]:
        return [every(series.path[own], lambda part: not part.any()) for own in series.sweeps]

    no_ramp = series.once("no ramp", flat)
    if not any(no_ramp):
        return []
    sweeps = [one for one in readings.sweeps if series.axis in one.outputs]
    found = []
    for one, own, none in zip(sweeps, series.sweeps, no_ramp, strict=True):
        if none:
            low, high = extremes(series.temperature[own], infinite=False)
            change = high - low if high > low else 0.0
            what = f"the temperature of {series.axis} changes by {change:.3g} degC: no ramp, and nothing of it is used"
            found.append(Remark("still_recording", "warning", what, one.place, do="Leave it out, or check its channel"))
    return found


def _remarks(plan: Plan, readings: Readings, axis: str, law: Law, start_up: StartUp) -> list[Remark]:
    found, cells = [], law.cells
    if not law.midway:
        way = {1: "warming", -1: "cooling"}[cells.ways[0]]
        what = f"{axis} sensor: only {way} was seen: midway between warming and cooling is not known"
        do = f"Ramp the other way too, or state sensor.hysteresis; results while {way} are listed apart"
        found.append(Remark("one_path", "warning", what, readings.where, do=do))
    elif cells.left_out.get("one_path"):
        low, high = cells.range
        what = f"{axis} sensor: both paths were seen from {low:.4g} to {high:.4g} degC; the rest is left out"
        found.append(Remark("one_path_beyond", "warning", what, readings.where, cells.left_out["one_path"],
                            "Ramp both ways over the whole range"))  # fmt: skip
    if law.midway and not cells.paths_repeated:
        what = f"{axis} sensor: one run alone shows warming, or cooling: what the paths differ by cannot be told from"
        what += " what the runs differ by: both are in the uncertainty of the bias"
        do = "Ramp both ways in each power-up; give recordings of one power-up one run"
        found.append(Remark("paths_or_runs", "warning", what, readings.where, do=do))
    counts = [f"{n} {WORDS[rule]}" for rule, n in cells.left_out.items() if n]
    what = f"{axis} sensor: {cells.used} samples used in {len(cells)} cells; left out: " + (", ".join(counts) or "none")
    found.append(Remark("cells", "info", what, readings.where))
    return [*found, *_of_start_up(plan, readings, axis, start_up)]


WORDS = {
    "invalid": "missing, invalid or at a rail",
    "warm_up": "before the start-up was over",
    "turn_over": "after a turn of the temperature",
    "one_path": "seen on one path only",
    "sparse": "in cells with few samples",
}


def _of_start_up(plan: Plan, readings: Readings, axis: str, start_up: StartUp) -> list[Remark]:
    found = start_up.found
    if plan.warm_up is not None:
        after = None if found is None else found.settled_after(start_up.settled)
        if after is None or after <= plan.warm_up:
            return []
        what = f"{axis} sensor: warm_up is {plan.warm_up:.4g} s, but the start-up takes {after:.4g} s"
        do = "Leave warm_up out, or give a longer one"
        return [Remark("warm_up_short", "warning", what, readings.where, do=do)]
    if found is None:
        what = f"no start-up could be looked for: {start_up.reason}"
        do = "Stay at the first temperature after power-up, or give plan.warm_up"
        return [Remark("warm_up_unknown", "warning", what, readings.where, do=do)]
    if found.identified and not found.resolved:
        what = (
            f"{axis} sensor: the start-up takes longer than the stay at the first temperature: what is left of it is in"
        )
        what += " slope, hysteresis and thermal lag"
        do = "Stay at the first temperature for four time constants, or give plan.warm_up"
        return [Remark("warm_up_long", "warning", what, readings.where, do=do)]
    return []
