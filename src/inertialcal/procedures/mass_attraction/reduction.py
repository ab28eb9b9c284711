"""Scale factor of an accelerometer from the attraction of a moved mass: its schedule, its runs, what they give.

A mass is moved between places near the sensor and dwells at each; half the difference of its attraction along the
input axis is the amplitude that is applied, and the sensor's readings follow it in their own drift. Each run gives a
response, the line of the drive with its error from the lines beside it (``line``, ``response``); response over what was
applied is the scale factor of the run, and ``runs`` joins them.

What is estimated: pulses per second and unit of acceleration, of accelerations as small as the mass applies, mean over
the runs. What is assumed: the mass was where the schedule says, when it says; apart from it and the tilt of the pad,
nothing follows the drive. What the uncertainty means: how the runs differ (or the noise in each, as the plan says),
joined with what is uncertain of the acceleration applied and of the mercury of the tilt meter; these are the same in
all runs. No noise is subtracted from a response. ``published`` does, as the report [1]_ did, for comparison.

References
----------
.. [1] K. Reinel, NASA TM X-53857, 1969.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...core.curve import Curve
from ...core.errors import DataError
from ...core.estimate import Estimate
from ...core.remarks import Remark, gather
from ...core.results import Row
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.tables import Block, html, text
from ...physics.motion.schedule import Schedule, repeated
from .checks import check_source, series_remarks
from .curves import curves
from .findings import findings
from .plan import INFLUENCES, HighG, Plan, SourceMass
from .programme1969 import published_lines
from .readings import Line, Readings, Run
from .recordings import SourceMassRecording, readings_from, run_of_rows
from .response.of_run import Response, response_of, response_of_line
from .response.runs import Combined, combined
from .response.scale import estimate_of, words_of
from .rows import rows

__all__ = [
    "INFLUENCES",
    "Combined",
    "HighG",
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
    """What the campaign gives.

    Parameters
    ----------
    plan, readings : Plan, Readings
        As given.
    responses : tuple of Response
        Of each run.
    combined : Combined or None
        Of the runs with the mass moved [count/s/(m/s^2)]; None where their response is not told from noise.
    scatter : str
        Where the uncertainty of ``estimate`` comes from: ``between_runs`` or ``within_runs``.
    estimate : Estimate or None
        ``scale_factor_x``, and what it is compared with, SI.
    says : mapping of str to str
        What is to be said of a quantity of it.
    reason : str
        Why there is no estimate.
    remarks : tuple of Remark
        Findings.
    """

    plan: Plan
    readings: Readings
    responses: tuple[Response, ...]
    combined: Combined | None
    scatter: str
    estimate: Estimate | None
    says: Mapping[str, str]
    reason: str
    remarks: tuple[Remark, ...] = ()

    @cached_property
    def published(self) -> tuple[tuple[Line, ...], str]:
        """Runs in the published way, reduced before or here; or why there are none."""
        return published_lines(self.readings)

    @property
    def per_applied(self) -> float | None:
        """Scale factor by which a response is told as an acceleration [count/s/(m/s^2)]; None where none is known."""
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
        """Return what is shown: how much went in, the figures in SI, how many remarks."""
        caption = f"mass attraction: {self.readings.runs} run(s), {len(self.readings)} reading(s)"
        found = estimate_table([row.to_dict() for row in self.rows() if not row.case.beside], caption)
        return (*found, *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def reduce(plan: Plan, readings: Readings) -> Result:
    """Find the scale factor.

    Parameters
    ----------
    plan : Plan
        How the campaign was made.
    readings : Readings
        Of its runs.

    Raises
    ------
    DataError
        ``no_runs`` if in no run the mass was moved; ``schedule_slip`` if it does not keep to its schedule;
        ``too_attractive``, ``overlap`` or ``absurd_density`` if it cannot be what the plan says.
    """
    if not any([*(run.moved for run in readings.series), *(line.moved for line in readings.lines)]):
        what, do = "in no run the mass was moved", "Give a run with the mass moved; null runs alone tell nothing"
        raise DataError(what, do=do, code="no_runs")
    if plan.source is not None:
        for run in readings.series:
            check_source(plan.source, run)
    responses = (
        *(response_of(plan, run) for run in readings.series), *(response_of_line(one) for one in readings.lines)
    )  # fmt: skip
    both, scatter = _joined(plan, responses)
    reason = "" if both is not None else _not_told(plan, responses)
    estimate = None if both is None else estimate_of(plan, readings, responses, both, scatter)
    result = Result(plan, readings, responses, both, scatter, estimate, words_of(plan, estimate), reason)
    remarks = gather([*readings.remarks, *series_remarks(plan, readings), *findings(result)])
    return replace(result, remarks=remarks)


def _joined(plan: Plan, responses: tuple[Response, ...]) -> tuple[Combined | None, str]:
    """Return the runs as one, and where its uncertainty comes from; None where they are not told from noise."""
    moved = [one for one in responses if one.moved]
    values, u, dof = np.array([[one.scale_factor, one.u_scale_factor, one.dof] for one in moved]).T
    both = combined(values, u, dof)
    scatter = "within_runs" if both.between is None else plan.scatter
    return (both if abs(both.within.value) >= plan.floor * both.within.u else None), scatter


def _not_told(plan: Plan, responses: tuple[Response, ...]) -> str:
    runs = sum(one.moved for one in responses)
    return f"the response of {runs} run(s) together is below {plan.floor:g} times the noise floor: not told from noise"
