"""Noise of a sensor at rest: terms with their intervals, what the records cannot tell, how long to record.

Definitions of the terms stand in ``sensors.noise.terms``, the estimator in ``sensors.noise.fitting.likelihood``.
Several records of one sensor are fitted together, with a test that they agree.

What is assumed: the sensor stands still, so that all it reads but its mean is its noise; the noise is normal and the
same throughout. Disturbances are found and left out (counted); lines are found in the spectrum and take part in the
fit; drift is remarked and stays in, unless the warm-up is left out. The sizes are relative to the scale factor of the
sensor.

References
----------
.. [1] IEEE Std 952-1997, Annex C; IEEE Std 1293-2018, Annex I.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...core.curve import Curve
from ...core.errors import DataError, InertialcalError
from ...core.estimate import Component, Estimate
from ...core.remarks import Remark, gather
from ...core.results import Interval, Row
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.tables import Block, html, text
from ...sensors.noise.fitting.noise_fit import duration
from ...sensors.noise.terms import Sinusoid, quantity_name
from .axis_noise import FAST, AxisNoise, check, end_early, noises_of, problems_of
from .curves import curves as curves_of
from .plan import INFLUENCES, Plan
from .planning.record_length import Reach, reaches, sentence
from .readings import AtRest, Readings, Run, Truth, simulate
from .record import Recorded
from .recordings import readings_from
from .rows import SCALE, interval_at, quantity_units, rows, with_standards

__all__ = [
    "INFLUENCES",
    "AtRest",
    "AxisNoise",
    "Plan",
    "Reach",
    "Readings",
    "Recorded",
    "Result",
    "Run",
    "Truth",
    "check",
    "quantity_units",
    "reaches",
    "readings_from",
    "reduce",
    "rows",
    "sentence",
    "simulate",
]

OF_LINES = tuple(quantity_name(Sinusoid.name, one, None) for one in Sinusoid.parameters)


@dataclass(frozen=True, eq=False)
class Result:
    """What the test gives."""

    # As given
    plan: Plan
    readings: Readings
    axes: tuple[AxisNoise, ...]  # One an axis
    remarks: tuple[Remark, ...]  # Findings

    @cached_property
    def estimate(self) -> Estimate | None:
        """Terms of all axes, SI or in the unit of the file; None where there are none."""
        found = [_of_axis(one) for one in self.axes if one.fit is not None]
        known = [one for one in found if one is not None]
        return with_standards(_joined(known), self.plan.standards) if known else None

    def rows(self) -> tuple[Row, ...]:
        """Rows of ``results.json``, SI or in the unit of the file."""
        return tuple(rows(self))

    def curves(self) -> list[Curve]:
        """Curves of ``results.json``, SI or in the unit of the file."""
        return curves_of(self)

    def interval_at(self, row: Row, p: float) -> Interval | None:
        """Return the interval of another probability of an estimated row; None where it has none."""
        return interval_at(self, row, p)

    def doubt(self, axis: str) -> str:
        """Return why figures of an axis may not hold; empty where nothing speaks against them."""
        return next((one.doubt for one in self.axes if one.axis == axis), "")

    def sentences(self) -> Iterator[tuple[str, str]]:
        """Yield for each axis and term how well it is known, and how long to record."""
        for one in self.axes:
            for reach in reaches(self.plan, one):
                yield one.axis, sentence(reach, self.plan.relative_error)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: how much went in, the figures in SI, how long to record, how many remarks."""
        count = len(self.readings)
        caption = f"static noise: {count} record{'s' * (count != 1)}, {duration(self.readings.length)} in all"
        found = estimate_table([row.to_dict() for row in self.rows() if not row.condition], caption)
        return (*found, *(f"{axis}: {said}" for axis, said in self.sentences()), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def reduce(plan: Plan, readings: Readings) -> Result:
    """Find the noise terms of each axis.

    Raises
    ------
    DataError
        If there are no records (``no_records``), or no axis has terms: then with the reason of each (``constant``,
        ``all_missing``). A record too short for terms gives its deviations alone.
    """
    found = reduce_many([(plan, readings)])[0]
    if isinstance(found, InertialcalError):
        raise found
    return found


def reduce_many(tests: Sequence[tuple[Plan, Readings]]) -> list[Result | InertialcalError]:
    """Return the result of each unit as `reduce` gives it, or its refusal; records alike are worked on side by side."""
    asked = [(plan, readings, axis) for plan, readings in tests for axis in readings.axes]
    try:
        found = iter(noises_of(asked))
    finally:
        for _, readings in tests:
            for run in readings.records:
                end_early(run)
    results: list[Result | InertialcalError] = []
    for plan, readings in tests:
        try:
            results.append(_result(plan, readings, tuple(next(found) for _ in readings.axes)))
        except InertialcalError as error:
            results.append(error)
    return results


def _result(plan: Plan, readings: Readings, axes: tuple[AxisNoise, ...]) -> Result:
    """Return what was found of a unit.

    Raises
    ------
    DataError
        As `reduce`.
    """
    if not axes:
        raise DataError("no record of a sensor at rest", code="no_records")
    if all(one.fit is None and not one.curve_alone for one in axes):
        found = {one.axis: one.problem for one in axes if one.problem is not None}
        raise DataError(problems_of(found, readings))
    remarks = [*readings.remarks, *(remark for one in axes for remark in one.remarks), *_relative(plan)]
    return Result(plan, readings, axes, gather(remarks))


def _relative(plan: Plan) -> list[Remark]:
    if plan.kind is None or SCALE in plan.standards:
        return []
    what = "scale factor without a stated uncertainty: noise terms are relative to it"
    return [Remark("relative_to_fixture", "info", what, do='Add its uncertainty: --standard sensor.scale_factor="..."')]


def _of_axis(one: AxisNoise) -> Estimate | None:
    assert one.fit is not None  # noqa: S101 - checked before
    estimate, faulty = one.fit.estimate, bool(one.slow_fault)
    slow = {
        parameter.name for term in one.fit.found if faulty and term.name not in FAST for parameter in term.parameters
    }
    keys = [key for key in estimate.keys if key.quantity not in {*OF_LINES, *slow}]
    if not keys:
        return None
    found = estimate.select(keys)
    return Estimate.of_own(
        tuple([key._replace(axis=one.axis) for key in keys]), found.values, found.units, found.components
    )


def _joined(estimates: Sequence[Estimate]) -> Estimate:
    """Return estimates of axes as one; noise of different axes is independent."""
    sizes = [len(one.names) for one in estimates]
    whole = np.zeros((sum(sizes), sum(sizes)))
    start = 0
    for one, size in zip(estimates, sizes, strict=True):
        whole[start : start + size, start : start + size] = one.covariance
        start += size
    source = estimates[0].components[0].source
    return Estimate.of_own(
        tuple([key for one in estimates for key in one.keys]),
        np.concatenate([one.values for one in estimates]),
        tuple([unit for one in estimates for unit in one.units]),
        (Component(source, "A", whole),),
    )
