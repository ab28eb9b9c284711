"""Scale factor of an accelerometer from the attraction of a moved mass.

A mass moves between places near the sensor and dwells at each. Half the difference of its attraction along the input
axis is the amplitude that is applied; the readings follow it within their own drift. Each run gives a response: the
line of the drive, with the noise within the runs (``response``). Response over amplitude is the scale factor
of the run, and ``joining`` makes one of those of all runs.

Estimated: output (pulses a second, volts, counts) per unit of acceleration, for accelerations as small as the mass
applies, mean over the runs. Assumed: the mass was where the schedule says, when it says; apart from it and the tilt
of the pad, nothing follows the drive. The uncertainty is the scatter of the runs or the noise in each, whichever is
wider, combined with the uncertainty of the acceleration applied and of the mercury of the tilt meter, which are common
to all runs. No noise is subtracted from a response; ``published`` does, as the report [1]_ did, for comparison.

References
----------
.. [1] K. Reinel, NASA TM X-53857, 1969.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...core.curve import Curve
from ...core.errors import DataError
from ...core.estimate import Estimate
from ...core.key import Key
from ...core.remarks import Remark, gather
from ...core.results import Row
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.tables import Block, html, text
from ...physics.motion.schedule import Schedule, repeated
from ...sensors.model.sensor_model import Provenance
from ..model_terms import ModelTerms
from ..protocol import Tested
from .drift import drift_remarks
from .joining import ERROR, Joined, estimate_of, joined, quiet_runs
from .plan import INFLUENCES, HighG, Plan, SourceMass
from .published import published_lines
from .readings import Line, Readings, Run, SourceMassRecording, readings_from, run_of_rows
from .response import Response, response_of_line, responses_of
from .rows import check_source, curves, result_remarks, rows, series_remarks

__all__ = [
    "INFLUENCES",
    "HighG",
    "Joined",
    "Line",
    "Plan",
    "Readings",
    "Response",
    "Result",
    "Run",
    "Schedule",
    "SourceMass",
    "SourceMassRecording",
    "readings_from",
    "reduce",
    "repeated",
    "rows",
    "run_of_rows",
]


@dataclass(frozen=True, eq=False)
class Result:
    """Result of a campaign."""

    plan: Plan  # As given
    readings: Readings  # As given
    responses: tuple[Response, ...]  # Of each run
    # Of the runs with the mass moved [output unit/(m/s^2)]; None if their response cannot be told from noise
    joined: Joined | None
    scatter: str  # Source of the uncertainty of ``estimate``: ``between_runs`` or ``within_runs``
    estimate: Estimate | None  # ``scale_factor_x``, and what it is compared with, SI
    reason: str  # Why there is no estimate
    remarks: tuple[Remark, ...] = ()  # On the result

    @cached_property
    def published(self) -> tuple[tuple[Line, ...], str]:
        """Runs in the published way, or why there are none."""
        return published_lines(self.readings)

    @property
    def per_applied(self) -> float | None:
        """Scale factor that makes a response an acceleration [output unit/(m/s^2)]; None if unknown."""
        if self.estimate is not None:
            return abs(float(self.estimate.values[0]))
        return self.plan.nominal

    def rows(self) -> tuple[Row, ...]:
        """Rows of ``results.json``, SI."""
        return tuple(rows(self))

    def curves(self) -> list[Curve]:
        """Curves of ``results.json``, SI."""
        return curves(self)

    def parts(self) -> tuple[Block, ...]:
        """Return number of runs and readings, the figures in SI, number of remarks."""
        caption = f"mass attraction: {self.readings.runs} run(s), {len(self.readings)} reading(s)"
        found = estimate_table([row.to_dict() for row in self.rows() if not row.case.beside], caption)
        return (*found, *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return the tables as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the tables for a notebook."""
        return html(self.parts())


def reduce(plan: Plan, readings: Readings) -> Result:
    """Return the scale factor.

    Parameters
    ----------
    plan : Plan
        Settings of the campaign.
    readings : Readings
        Of its runs.

    Raises
    ------
    DataError
        ``no_runs`` if the mass moved in no run; ``schedule_slip`` if it does not keep to its schedule;
        ``too_attractive``, ``overlap`` or ``absurd_density`` if it cannot be what the plan says.
    """
    if not any([*(run.moved for run in readings.series), *(line.moved for line in readings.lines)]):
        what, do = "the mass moved in no run", "Give a run with the mass moved"
        raise DataError(what, why="null runs alone give no scale factor", do=do, code="no_runs")
    if plan.source is not None:
        for run in readings.series:
            check_source(plan.source, run)
    quiet = quiet_runs(readings.series)
    responses = (
        *(
            one.restored(found)
            for one, found in zip(quiet, responses_of(plan, [one.run for one in quiet]), strict=True)
        ),
        *(response_of_line(one) for one in readings.lines),
    )
    moved = [one for one in responses if one.moved]
    both = joined(moved)
    if abs(both.within.value) >= plan.floor * both.within.u:
        estimate, reason = estimate_of(plan, readings, responses, both, both.scatter), ""
        result = Result(plan, readings, responses, both, both.scatter, estimate, reason)
    else:
        reason = f"the response of {len(moved)} run(s) is below {plan.floor:g} times the noise floor"
        result = Result(plan, readings, responses, None, both.scatter, None, reason)
    remarks = gather(
        [
            *readings.remarks,
            *series_remarks(plan, readings),
            *drift_remarks(readings.series, responses),
            *result_remarks(result),
        ]
    )
    return replace(result, remarks=remarks)


def model_terms(result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
    """Return the scale factor error as a term of the model, for inputs as small as the mass applies.

    None where it was not estimated, or no scale factor is stated to relate it to. A constant that was taken off before
    does not follow the mass: nothing of its uncertainty is in it.
    """
    key, nominal = Key(ERROR, result.plan.axis), result.plan.nominal
    if result.estimate is None or not nominal:
        return None
    applied = max(one.applied for one in result.responses if one.moved)
    origin = Provenance(", ".join(one.id for one in tests), tuple(name for one in tests for name in one.recordings))
    return ModelTerms(
        result.estimate.select([key]),
        (key,),
        (result.plan.axis,),
        {key: origin},
        scale_factor=nominal,
        output_unit=result.plan.output_unit,
        input_range=np.array([(-applied, applied)]),
    )
