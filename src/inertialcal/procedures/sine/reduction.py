"""A known drive in drift: its line in each channel, with the noise of the lines beside it.

What is estimated: amplitude (and phase, where it is free) of a sine of known period, or of a sequence of dwells that
was applied. What is assumed: nothing else follows the drive; drift is described by a line and low cosines, or a
polynomial. What the uncertainty means: the noise beside the line, taken as that on it.

References
----------
.. [1] K. Reinel, NASA TM X-53857, 1969.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...core.curve import Curve
from ...core.errors import DataError
from ...core.remarks import Remark, gather
from ...core.results import Row
from ...signals.sine import cross_checks, design_of, fit_line
from .inputs import Driven
from .plan import Plan
from .result import SineResult


@dataclass(frozen=True, eq=False)
class Readings:
    """Channels under the drive.

    Parameters
    ----------
    driven : tuple of Driven
        One a channel of a recording.
    remarks : tuple of Remark
        What reading them brought up.
    """

    driven: tuple[Driven, ...]
    remarks: tuple[Remark, ...] = ()

    def __len__(self) -> int:
        """Return the number of samples, or of dwells with a reading."""
        return sum(len(one.readings) for one in self.driven)

    @property
    def runs(self) -> int:
        """Number of channels."""
        return len(self.driven)


@dataclass(frozen=True, eq=False)
class Result:
    """What was found.

    Parameters
    ----------
    plan, readings : Plan, Readings
        As given.
    lines : tuple of SineResult
        One a channel.
    remarks : tuple of Remark
        Findings.
    """

    plan: Plan
    readings: Readings
    lines: tuple[SineResult, ...]
    remarks: tuple[Remark, ...] = ()

    @property
    def estimate(self) -> None:
        """None: each figure stands in its row, those of different channels are independent."""
        return

    def rows(self) -> tuple[Row, ...]:
        """Rows of ``results.json``."""
        return tuple(row for one in self.lines for row in one.rows())

    def curves(self) -> list[Curve]:
        """Curves of ``results.json``."""
        return [curve for one in self.lines for curve in one.curves()]


def reduce(plan: Plan, readings: Readings) -> Result:
    """Find the drive in each channel.

    Raises
    ------
    DataError
        ``no_recordings`` if there is no channel; as ``signals.sine``.
    PlanError
        If drift or side bands do not fit the record.
    """
    if not readings.driven:
        raise DataError("no channel", code="no_recordings")
    lines = tuple(line_of(plan, one) for one in readings.driven)
    remarks = gather([*readings.remarks, *(remark for one in lines for remark in one.remarks())])
    return Result(plan, readings, lines, remarks)


def line_of(plan: Plan, driven: Driven) -> SineResult:
    """Fit the drive to one channel, with the other estimates beside it.

    Raises
    ------
    DataError, PlanError
        As ``signals.sine``.
    """
    design = design_of(driven.drive, plan.drift, plan.order, plan.side_bands)
    fit = fit_line(design, driven.readings)
    checks = cross_checks(fit, driven.readings) if driven.drive.phase_known else ()
    return SineResult(driven, fit, checks)
