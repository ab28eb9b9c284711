"""In-orbit flip: bias and ambient acceleration of a triaxial head from dwells at positions it is turned to.

Signs and positions stand in ``positions``, the equations in ``separation``; what bias and ambient acceleration mean,
and where their uncertainty comes from, in ``uncertainty`` (Type A), ``pooling`` (several flips) and ``standards``
(Type B).

What is assumed: within a flip bias and ambient acceleration are constant but for noise and the drift that the plan
names; the head turns about the axis and by the angles stated, within their uncertainty. A value without a known
uncertainty stays, marked ``not_estimated`` with its reason.

References
----------
.. [1] Chestney and Sicker, "In-Orbit Calibration of a SAMS Triaxial Sensor Head", NASA TM-106980, 1996.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...core.curve import Curve
from ...core.errors import DataError
from ...core.estimate import Estimate
from ...core.remarks import Remark, gather
from ...core.results import Row
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.tables import Block, html, text
from .curves import curves as curves_of
from .plan import INFLUENCES, Plan
from .readings import Readings
from .rows import rows
from .separation.control import checks
from .separation.pooling import Flip, differences, flips_of, pooled
from .separation.uncertainty import missing


@dataclass(frozen=True, eq=False)
class Result:
    """What the test gives.

    Parameters
    ----------
    plan, readings : Plan, Readings
        As given.
    flips : tuple of Flip
        Each by its own.
    whole : Flip
        All of them, pooled.
    others : mapping of str to Flip
        The same by other statistics of the windows: ``"median"``, ``"low_pass"``.
    remarks : tuple of Remark
        Findings.
    """

    plan: Plan
    readings: Readings
    flips: tuple[Flip, ...]
    whole: Flip
    others: Mapping[str, Flip]
    remarks: tuple[Remark, ...]

    @property
    def estimate(self) -> Estimate | None:
        """All quantities, SI; None where no uncertainty is known."""
        return self.whole.estimate

    def rows(self) -> tuple[Row, ...]:
        """Rows of ``results.json``, SI."""
        return tuple(rows(self))

    def curves(self) -> list[Curve]:
        """Curves of ``results.json``, SI."""
        return curves_of(self)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: how much went in, the figures in SI, how many remarks."""
        caption = f"flip: {len(self.readings)} dwells, {len(self.flips)} flip(s) about {self.plan.axis}"
        found = estimate_table([row.to_dict() for row in self.rows() if row.case.plain], caption)
        return (*found, *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def reduce(plan: Plan, readings: Readings) -> Result:
    """Separate bias from ambient acceleration.

    Raises
    ------
    DataError
        If there are no dwells (``no_dwells``), none was read (``not_read``), or a drift that the plan has fitted
        cannot be told (``drift_not_carried``).
    """
    if not len(readings):
        raise DataError("no dwells", why="there is nothing to separate", code="no_dwells")
    if not any(np.isfinite(one).any() for one in readings.outputs.values()):
        raise DataError("no axis was read in any dwell", code="not_read")
    flips = flips_of(plan, readings)
    whole = pooled(plan, readings, flips)
    others = {}
    for name, outputs in readings.others.items():
        if any(np.isfinite(one).any() for one in outputs.values()):
            other = readings.by(name)
            others[name] = pooled(plan, other, flips_of(plan, other))
    remarks = [*readings.remarks, *checks(plan, readings, flips, whole), *differences(flips)]
    for one in flips:
        if one.estimate is None:
            do = "Give the recordings, long before and after the turn"
            place = f"flip {one.label}" if len(flips) > 1 else ""
            remarks.append(Remark("no_noise_model", "warning", f"no uncertainty: {one.reason}", place, do=do))
    unstated = missing(plan)
    if unstated:
        effects = "; ".join(f"{name} ({INFLUENCES[name]})" for name in unstated)
        what = f"standards without a stated uncertainty: {effects}: results are relative to the fixture"
        remarks.append(Remark("relative_to_fixture", "warning", what, do="State them under [standards]"))
    return Result(plan, readings, flips, whole, others, gather(remarks))
