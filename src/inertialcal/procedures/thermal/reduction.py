"""Thermal: bias over temperature from ramps, in air or in vacuum, with what differs between paths and power-ups.

The law that is fitted stands in ``law``, how samples become cells in ``cells``, how the order is chosen in ``order``,
warming against cooling in ``paths``, the start-up in ``start_up``, Type B in ``quantities`` and ``earth``, two
conditions against each other in ``against``.

What is estimated: the bias over temperature, mean over turn-ons, midway between warming and cooling, after the
start-up, with earth rate taken off. What is assumed: the unit rests; the ramps of a run share its offset; what differs
from power-up to power-up is independent between them. What the uncertainty means: the standard deviation that the
estimate would have if the whole test were made again with new power-ups, joined with the stated uncertainties of the
standards. Plain least squares takes neighbouring samples as independent, which they are not: they share the drift of
their run.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011, sections IV.A to IV.C, Tables 2 to 8, Figure 23.
.. [2] IEEE Std 1431-2004, 12.8 (operating temperature test series).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

from ...core.curve import Curve
from ...core.errors import DataError, InertialcalError, Problem
from ...core.estimate import Estimate
from ...core.influence import Influence
from ...core.key import Reason
from ...core.remarks import Remark, gather
from ...core.results import Row, changed
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.rounding import freedom
from ...core.show.tables import Block, html, text
from .curves import curves
from .fit.cells import Series, series_of
from .fit.law import Law
from .fit.quantities import (
    Asked,
    Wanted,
    asked_of,
    bias_at,
    earth_along,
    estimate,
    estimates,
    find_asked,
    find_rows,
)
from .fit.sensor import OfSensor, reduce_sensors
from .plan import INFLUENCES, LARGEST_ORDER, Attitude, Plan, Thermometer
from .recordings import Readings, Sweep, ThermalRecording, readings_from
from .rows import needed, rows, rows_many
from .simulation import Truth, simulate

__all__ = [
    "INFLUENCES",
    "LARGEST_ORDER",
    "Attitude",
    "Law",
    "OfSensor",
    "Plan",
    "Readings",
    "Result",
    "Sweep",
    "ThermalRecording",
    "Thermometer",
    "Truth",
    "bias_at",
    "earth_along",
    "needed",
    "readings_from",
    "reduce",
    "rows",
    "simulate",
]

FEW_RUNS = 5  # with fewer, an interval is honest but wide and rests on a guess of the distribution


@dataclass(frozen=True, eq=False)
class Result:
    """What the test gives."""

    plan: Plan  # As given
    readings: Readings  # As given
    sensors: Mapping[str, OfSensor]  # By axis
    asked: Mapping[str, list[Asked]]  # By axis: what is wanted of its law
    estimate: Estimate | None  # All quantities of all sensors, SI
    on_path: Estimate | None  # The same of the one path that was seen, of sensors where there is only one
    references: Mapping[str, Estimate]  # Reference voltages over temperature
    reasons: Mapping[str, Reason]  # Why a sensor has no law
    remarks: tuple[Remark, ...]  # Findings

    @property
    def laws(self) -> dict[str, Law]:
        """Bias over temperature, by axis."""
        return {axis: one.law for axis, one in self.sensors.items()}

    @cached_property
    def _rows(self) -> tuple[Row, ...]:
        return tuple(rows_many([self])[0])

    def rows(self) -> tuple[Row, ...]:
        """Rows of ``results.json``, SI."""
        return self._rows

    def curves(self) -> list[Curve]:
        """Curves of ``results.json``, SI."""
        return curves(self)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: how much went in, the figures in SI, why a sensor has none, how many remarks."""
        caption = f"thermal: {len(self.readings.sweeps)} recording(s), {self.readings.runs} run(s)"
        found = estimate_table([row.to_dict() for row in self.rows() if not row.case.beside], caption)
        return (
            *found,
            *(f"sensor {axis}: {reason}" for axis, reason in self.reasons.items()),
            *remarks_line(self.remarks),
        )

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def reduce(plan: Plan, readings: Readings) -> Result:
    """Find the bias over temperature of each sensor that was read.

    Raises
    ------
    DataError
        If there is no recording, or no sensor can be reduced: the temperature hardly changes
        (``no_temperature_change``), nothing is valid, ...
    """
    found = reduce_many([(plan, readings)])[0]
    if isinstance(found, InertialcalError):
        raise found
    return found


def reduce_many(tests: Sequence[tuple[Plan, Readings]]) -> list[Result | InertialcalError]:
    """Return the result of each unit as `reduce` gives it, or its refusal; sensors alike are fitted at once."""
    problems: list[dict[str, Problem]] = [{} for _ in tests]
    series: list[tuple[int, Series]] = []
    for i, (plan, readings) in enumerate(tests):
        own: list[Series] = []
        for axis in readings.axes:  # before the first is reduced: those that share a thermometer share what it tells
            try:
                own.append(series_of(plan, readings, axis, own))
            except DataError as error:
                problems[i][axis] = error.problems[0]
        series += [(i, one) for one in own]
    sensors: list[dict[str, OfSensor]] = [{} for _ in tests]
    for (i, one), found in zip(series, reduce_sensors([(*tests[i], one) for i, one in series]), strict=True):
        if isinstance(found, DataError):
            problems[i][one.axis] = found.problems[0]
        else:
            sensors[i][one.axis] = found
    find_rows([(plan, one.law) for (plan, _), own in zip(tests, sensors, strict=True) for one in own.values()])
    asked = [
        {axis: asked_of(plan, sensor.law, axis, readings.unit) for axis, sensor in own.items()}
        for (plan, readings), own in zip(tests, sensors, strict=True)
    ]
    find_asked(
        [own[axis].law for own, each in zip(sensors, asked, strict=True) for axis in each],
        [one for each in asked for one in each.values()],
    )
    results: list[Result | InertialcalError] = []
    for (plan, readings), found_of, asked_for, wrong in zip(tests, sensors, asked, problems, strict=True):
        try:
            results.append(_result(plan, readings, found_of, asked_for, wrong))
        except InertialcalError as error:
            results.append(error)
    results = _with_estimates(results)
    if len(results) > 1:  # rows of many are wanted
        _keep_rows([one for one in results if isinstance(one, Result)])
    return results


def _keep_rows(results: Sequence[Result]) -> None:
    """Let results keep their rows, made at once; what one of them is refused for is said where it is asked."""
    with suppress(InertialcalError, ArithmeticError):
        for one, own in zip(results, rows_many(results), strict=True):
            one.__dict__["_rows"] = tuple(own)


def _with_estimates(results: Sequence[Result | InertialcalError]) -> list[Result | InertialcalError]:
    """Return results with all quantities of all sensors, and with those of the one path that was seen."""
    found = [*results]
    whole = [(i, one) for i, one in enumerate(results) if isinstance(one, Result)]
    wanted = [Wanted(one.plan, one.laws, one.asked, one.readings.unit) for _, one in whole]
    single = [(i, one) for i, one in whole if not all(law.midway for law in one.laws.values())]
    for _, one in single:
        known = {**one.plan.standards, "sensor.hysteresis": Influence(0.0, one.readings.unit)}
        laws = {axis: law for axis, law in one.laws.items() if not law.midway}
        wanted.append(Wanted(replace(one.plan, standards=known), laws, one.asked, one.readings.unit))
    names = ["estimate"] * len(whole) + ["on_path"] * len(single)
    for (i, _), name, each in zip([*whole, *single], names, estimates(wanted), strict=True):
        made = found[i]
        if isinstance(made, Result):
            found[i] = each if isinstance(each, DataError) else changed(made, **{name: each})
    return found


def _result(
    plan: Plan,
    readings: Readings,
    sensors: Mapping[str, OfSensor],
    asked: Mapping[str, list[Asked]],
    problems: Mapping[str, Problem],
) -> Result:
    """Return what was found of a unit, but for its estimates.

    Raises
    ------
    DataError
        If no sensor was read, or none can be reduced.
    """
    if not readings.axes:
        raise DataError("no sensor was read", readings.where, code="no_recordings")
    problems = {axis: problems[axis] for axis in readings.axes if axis in problems}
    if not sensors:
        raise DataError([replace(one, where=one.where or readings.where) for one in problems.values()])
    reasons = {axis: Reason(problem.code, problem.what) for axis, problem in problems.items()}
    remarks = [*readings.remarks, *(remark for one in sensors.values() for remark in one.remarks)]
    remarks += [Remark("no_law", "warning", reason.text, readings.where) for reason in reasons.values()]
    return Result(
        plan,
        readings,
        sensors,
        asked,
        None,
        None,
        _references(plan, sensors),
        reasons,
        gather([*remarks, *_remarks(plan, readings, min(one.cells.runs for one in sensors.values()))]),
    )


def _references(plan: Plan, sensors: Mapping[str, OfSensor]) -> dict[str, Estimate]:
    """Return the reference voltages over temperature, by their name."""
    found = {}
    for name in dict.fromkeys(name for one in sensors.values() for name in one.references):
        laws = {axis: one.references[name] for axis, one in sensors.items() if name in one.references}
        bare = replace(plan, at=None)
        asked = {axis: asked_of(bare, law, axis, "V", name) for axis, law in laws.items()}
        one = estimate(plan, laws, asked, "V")
        if one is not None:
            found[name] = one
    return found


def _remarks(plan: Plan, readings: Readings, runs: int) -> list[Remark]:
    """Return what is to be said of the whole test, with so many runs that have a ramp."""
    found = []
    if 2 <= runs < FEW_RUNS:
        what = f"{runs} runs: the scatter between runs has {freedom(runs - 1)}"
        found.append(Remark("few_runs", "warning", what, do=f"Repeat until there are {FEW_RUNS} power-ups or more"))
    if runs < 2:
        what = "one power-up run: what differs from power-up to power-up is not in the uncertainty"
        found.append(Remark("no_runs", "warning", what, do="Repeat the power-up, and name the run of each recording"))
    missing = [name for name in needed(plan) if name not in plan.standards]
    if missing:
        effects = "; ".join(f"{name} ({INFLUENCES[name]})" for name in missing)
        what = f"standards without a stated uncertainty: {effects}: results are relative to the fixture"
        found.append(Remark("relative_to_fixture", "warning", what, do="State them under [standards]"))
    if readings.unit == "rad/s" and (plan.attitude is None or plan.latitude is None):
        what = "how the unit lay is not given: earth rate along the axes (at most 0.0042 deg/s) is unknown, Type B"
        found.append(Remark("attitude_unknown", "warning", what, do="Give plan.attitude and site.latitude"))
    return found
