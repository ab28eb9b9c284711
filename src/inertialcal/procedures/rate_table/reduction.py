"""Rate table: scale factor, bias, misalignment and error of rate from dwells at known rates.

The model, the levels of scatter and the signs stand in ``regression`` and ``quantities``; what is left out in
``exclusions``; the error in percent in ``rate_error``.

What is assumed: a dwell is at one rate; the offset of a run (power-up) is the same for all its dwells about one axis;
the dwells of different runs are independent; scatter within a run does not depend on the rate. What the
uncertainty means: the standard deviation that the estimate would have if the whole test were made again with
new runs, joined with the stated uncertainties of the standards.

References
----------
.. [1] IEEE Std 1431-2004, 12.9 (scale factor test series), 12.12 (input axis alignment).
.. [2] V. V. Badescu, NPS thesis, September 2011, section IV.E, Tables 9-12, Appendices E to J.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ...core.curve import Curve
from ...core.errors import DataError, InertialcalError
from ...core.estimate import Estimate
from ...core.key import Reason
from ...core.remarks import Remark, gather
from ...core.results import Row, changed
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.rounding import freedom
from ...core.show.tables import Block, html, text
from .curves import curves
from .exclusions import Exclusions, exclusions
from .fit.earth_input import with_earth
from .fit.nonlinearity import Chosen, with_nonlinearity
from .fit.quantities import estimates
from .fit.rate_error import RateError, Resolution, rate_errors, resolution
from .fit.regression import Line, lines
from .plan import INFLUENCES, Plan
from .readings import Readings
from .rows import applies, limits, rows, rows_many
from .simulation import Truth, simulate

__all__ = [
    "INFLUENCES",
    "Line",
    "Plan",
    "RateError",
    "Readings",
    "Resolution",
    "Result",
    "Truth",
    "curves",
    "exclusions",
    "rate_errors",
    "reduce",
    "resolution",
    "rows",
    "simulate",
    "with_earth",
]

FEW_RUNS = 5  # with fewer, an interval is honest but wide and rests on a guess of the distribution


@dataclass(frozen=True, eq=False)
class Result:
    """What the test gives."""

    plan: Plan  # As given
    readings: Readings  # As given
    lines: Mapping[str, Line]  # Per sensor, dwells left out by rule
    straight: Mapping[str, Line]  # The same without asymmetry and curvature, for the linearity error
    full: Mapping[str, Line]  # The same with all curvatures that the rates allow
    no_curvature: Mapping[str, Mapping[str, Reason]]  # Per sensor, why K2 or K3 is not estimated
    estimate: Estimate | None  # All quantities of all sensors, SI
    all_readings: Estimate | None  # The same with nothing left out; None where nothing was
    reasons: Mapping[str, Reason]  # Why a sensor has no line
    remarks: tuple[Remark, ...]  # Findings

    @cached_property
    def limits(self) -> Reason:
        """What limits every figure: standards that are not stated."""
        return limits(self.plan, self.readings)

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
        runs = f", {self.readings.runs} run(s)" if self.readings.run is not None else ""
        caption = f"rate table: {len(self.readings)} dwells{runs}"
        found = estimate_table([row.to_dict() for row in self.rows() if not row.case.beside], caption)
        reasons = tuple(f"sensor {sensor}: {reason}" for sensor, reason in self.reasons.items())
        return (*found, *reasons, *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def reduce(plan: Plan, readings: Readings) -> Result:
    """Find scale factor, bias, asymmetry and matrix entries of each sensor that was read.

    Raises
    ------
    DataError
        If there are no dwells, or no sensor has enough of them.
    """
    found = reduce_many([(plan, readings)])[0]
    if isinstance(found, InertialcalError):
        raise found
    return found


def reduce_many(tests: Sequence[tuple[Plan, Readings]]) -> list[Result | InertialcalError]:
    """Return the result of each unit as `reduce` gives it, or its refusal; what was turned alike is fitted at once."""
    found: dict[int, Result | InertialcalError] = {}
    units: dict[int, _Unit] = {}
    for i, (plan, readings) in enumerate(tests):
        try:
            units[i] = _Unit.of(plan, readings)
        except InertialcalError as error:
            found[i] = error
    for sensor in dict.fromkeys(sensor for one in units.values() for sensor in one.readings.outputs):
        _fit([one for one in units.values() if sensor in one.readings.outputs], sensor)
    found |= _results(units)
    results = [one for one in found.values() if isinstance(one, Result)]
    if len(results) > 1:  # rows of many are wanted
        with suppress(InertialcalError, ArithmeticError):  # of one of them: said where its own are wanted
            for one, own in zip(results, rows_many(results), strict=True):
                one.__dict__["_rows"] = tuple(own)
    return [found[i] for i in range(len(tests))]


@dataclass(eq=False)
class _Unit:
    """One unit while it is reduced: what was found of each sensor, or why it has no line."""

    plan: Plan
    readings: Readings  # with the rate of the earth
    left_out: Mapping[str, Exclusions]
    used: Mapping[str, Readings]  # by sensor, without what is left out
    straight: dict[str, Line | DataError] = field(default_factory=dict)
    chosen: dict[str, Chosen | DataError] = field(default_factory=dict)
    everything: dict[str, Chosen | DataError] = field(default_factory=dict)  # nothing left out

    @classmethod
    def of(cls, plan: Plan, readings: Readings) -> _Unit:
        """Return a unit with what its sensors leave out.

        Raises
        ------
        DataError
            If there are no dwells, some do not name their run, or have no sample.
        """
        if not len(readings):
            raise DataError("no dwells", why="there is nothing to fit", code="no_dwells")
        if readings.run is not None and 0 < (unnamed := int(np.count_nonzero(readings.run == ""))) < len(readings):
            at = int(np.flatnonzero(readings.run == "")[0])
            where = readings.where[at] if readings.where else ""
            what = f"{unnamed} of {len(readings)} dwells do not name their run"
            raise DataError(
                what, where, "the scatter between runs would be wrong", "Name the run of all, or of none", "mixed_runs"
            )
        if readings.samples is not None and np.any(readings.samples < 1.0):
            at = int(np.flatnonzero(readings.samples < 1.0)[0])
            raise DataError(
                f"{readings.samples[at]:g} samples in a dwell",
                readings.where[at] if readings.where else "",
                code="wrong_value",
            )
        if readings.earth is None:
            readings = with_earth(plan, readings)
        left_out = {sensor: exclusions(plan, readings, sensor) for sensor in readings.outputs}
        used = {sensor: readings.take(~one.any) for sensor, one in left_out.items()}
        return cls(plan, readings, left_out, used)


def _fit(units: Sequence[_Unit], sensor: str) -> None:
    """Fit the lines of one sensor of each unit."""
    for one, line in zip(units, lines([one.used[sensor] for one in units], sensor, asymmetry=False), strict=True):
        one.straight[sensor] = line
    for one, chosen in zip(units, _chosen(units, [one.used[sensor] for one in units], sensor), strict=True):
        one.chosen[sensor] = one.everything[sensor] = chosen
    more = [one for one in units if one.left_out[sensor].any.any()]
    for one, chosen in zip(more, _chosen(more, [one.readings for one in more], sensor), strict=True):
        one.everything[sensor] = chosen


def _chosen(units: Sequence[_Unit], dwells: Sequence[Readings], sensor: str) -> list[Chosen | DataError]:
    """Fit lines with asymmetry where the rates allow it, and with the curvatures that are seen."""
    kinds: dict[tuple[str, bool, int], list[int]] = {}
    for i, (one, readings) in enumerate(zip(units, dwells, strict=True)):
        plan, read = one.plan, readings.take(np.isfinite(readings.outputs[sensor]))
        asymmetry = plan.asymmetry and read.turned.tells_asymmetry(sensor)
        kinds.setdefault((plan.nonlinearity, asymmetry, len(readings.outputs)), []).append(i)
    found: dict[int, Chosen | DataError] = {}
    for (_, asymmetry, sensors), at in kinds.items():
        plan = units[at[0]].plan
        own = with_nonlinearity(plan, [dwells[i] for i in at], sensor, asymmetry, sensors)
        found.update(zip(at, own, strict=True))
    return [found[i] for i in range(len(units))]


def _results(units: Mapping[int, _Unit]) -> dict[int, Result | InertialcalError]:
    """Return what was found of each unit, or its refusal."""
    found: dict[int, Result | InertialcalError] = {}
    wanted: list[tuple[int, str, tuple[Plan, Mapping[str, Line], Mapping[str, Line]]]] = []
    for i, unit in units.items():
        try:
            found[i] = one = _result(unit)
        except InertialcalError as error:
            found[i] = error
            continue
        wanted.append((i, "estimate", (one.plan, one.lines, one.full)))
        every = {s: each for s in one.lines if isinstance(each := unit.everything[s], Chosen)}
        if any(unit.chosen[s] is not each for s, each in every.items()):
            own, full = ({s: getattr(each, name) for s, each in every.items()} for name in ("line", "full"))
            wanted.append((i, "all_readings", (one.plan, own, full)))
    for (i, name, _), estimate in zip(wanted, estimates([given for _, _, given in wanted]), strict=True):
        made = found[i]
        if isinstance(made, Result):
            found[i] = estimate if isinstance(estimate, DataError) else changed(made, **{name: estimate})
    return found


def _result(unit: _Unit) -> Result:
    """Return what was found of a unit, but for its estimates.

    Raises
    ------
    DataError
        If no sensor has a line.
    """
    plan, readings = unit.plan, unit.readings
    chosen: dict[str, Chosen] = {}
    everything: dict[str, Chosen] = {}
    straight: dict[str, Line] = {}
    reasons: dict[str, Reason] = {}
    remarks = [*readings.remarks]
    for sensor in readings.outputs:
        remarks += unit.left_out[sensor].remarks
        plain, own, whole = unit.straight[sensor], unit.chosen[sensor], unit.everything[sensor]
        if isinstance(plain, DataError) or isinstance(own, DataError) or isinstance(whole, DataError):
            refused = next(one for one in (plain, own, whole) if isinstance(one, DataError))
            problem = refused.problems[0]
            reasons[sensor] = Reason(problem.code, problem.what)
            remarks.append(Remark("no_line", "warning", reasons[sensor].text, problem.where))
            continue
        chosen[sensor], straight[sensor], everything[sensor] = own, plain, whole
    if not chosen:
        raise DataError(
            f"no sensor can be reduced: {'; '.join(map(str, reasons.values()))}",
            where=readings.where[0] if readings.where else "",
        )
    own_lines = {sensor: one.line for sensor, one in chosen.items()}
    if any(one.level == "dwell" for one in own_lines.values()) and readings.runs >= 2:
        what = "some axis was turned in one run only: the uncertainty is the scatter between dwells, not between runs"
        remarks.append(Remark("not_repeated_between_runs", "warning", what, do="Turn every axis in every run"))
    full = {sensor: one.full for sensor, one in chosen.items()}
    return Result(
        plan,
        readings,
        own_lines,
        straight,
        full,
        {sensor: one.reasons for sensor, one in chosen.items()},
        None,
        None,
        reasons,
        gather([*remarks, *_remarks(plan, readings)]),
    )


def _remarks(plan: Plan, readings: Readings) -> list[Remark]:
    found = []
    if 2 <= readings.runs < FEW_RUNS:
        what = f"{readings.runs} runs: the scatter between runs has {freedom(readings.runs - 1)}"
        found.append(Remark("few_runs", "warning", what, do=f"Repeat until there are {FEW_RUNS} power-ups or more"))
    if readings.runs < 2:
        what = "power-up runs were not repeated or not given: the scatter between runs is not in the uncertainty"
        recordings = len(np.unique(readings.turned.groups))
        if recordings >= 2 and not readings.runs:
            what = f"power-up runs were not given: each of {recordings} recordings is taken as a power-up"
        found.append(Remark("no_runs", "warning", what, do="Name the run of each dwell, and repeat the power-up"))
    for axis in readings.turned.axes:
        lowest, highest = readings.turned.span(axis)
        if not lowest < 0.0 < highest:
            what = f"{axis} was turned in one sense only: its asymmetry, and how it reads the other sense, are unknown"
            found.append(Remark("one_sense", "warning", what, do="Turn it both ways"))
    for axis in readings.sensors:
        if axis not in readings.turned.axes and plan.axis == "":
            what = f"{axis} was never turned: its scale factor, and what the others read of it, are unknown"
            found.append(Remark("axis_not_turned", "warning", what, do="Turn it"))
    missing = [name for name in INFLUENCES if name not in plan.standards and applies(name, plan, readings)]
    if missing:
        effects = "; ".join(f"{name} ({INFLUENCES[name]})" for name in missing)
        what = f"standards without a stated uncertainty: {effects}: results are relative to the fixture"
        found.append(Remark("relative_to_fixture", "warning", what, do="State them under [standards]"))
    if plan.attitude is None and not plan.zero_reference:
        what = "how the table stands is not given: earth rate along the axes (at most 0.0042 deg/s) is unknown, Type B"
        found.append(Remark("attitude_unknown", "warning", what, do="Give plan.attitude and site.latitude"))
    return found
