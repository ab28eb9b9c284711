"""Rows of a result: one quantity of one axis with its uncertainty, or the reason why there is none.

A procedure's Result gives rows; ``results.json`` and ``results.csv`` hold them as they are. Absent numbers
are null; degrees of freedom null mean infinite.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, Literal

WAYS = (
    "all_readings",
    "median",
    "low_pass",
    "as_published",
    "within_runs",
    "between_runs",
)  # conditions: other ways of reducing the same readings
# conditions: one flip, or one record, of several, each by its own
FLIP = re.compile(r"(as_published, )?flip .+|run .+ alone", re.DOTALL)
Status = Literal["estimated", "not_estimated", "upper_limit"]


@dataclass(frozen=True)
class Interval:
    """Two-sided interval with probability ``p``; an open side is None."""

    lo: float | None
    hi: float | None
    p: float = 0.95


@dataclass(frozen=True)
class Row:
    """One published figure.

    Parameters
    ----------
    quantity : str
        The field's word: ``"scale_factor"``, ``"bias"``.
    axis : str
        ``"x"``, or ``"xz"`` for a matrix entry (row = sensor that reads, column = axis that moves).
    value, u : float or None
        In ``unit``.
    unit : str
        As ``core.units`` prints it.
    dof : float or None
        Degrees of freedom of ``u``; None is infinite.
    interval : Interval or None
        95 % unless it says otherwise.
    status : {"estimated", "not_estimated", "upper_limit"}
        Whether the data carried the answer.
    reason : str
        Why not, or what limits it.
    test : str
        Identifier of the test in the campaign.
    condition : str
        Under which conditions; ``"as_published"`` marks a document's own way of reduction.
    """

    quantity: str
    axis: str
    value: float | None
    u: float | None
    unit: str
    dof: float | None = None
    interval: Interval | None = None
    status: Status = "estimated"
    reason: str = ""
    test: str = ""
    condition: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return the row as ``results.json`` holds it; not finite numbers are null."""
        interval = self.interval
        return {
            "quantity": self.quantity,
            "axis": self.axis,
            "test": self.test,
            "condition": self.condition,
            "value": finite(self.value),
            "u": finite(self.u),
            "unit": self.unit,
            "dof": finite(self.dof),
            "interval": None
            if interval is None
            else {"lo": finite(interval.lo), "hi": finite(interval.hi), "p": interval.p},
            "status": self.status,
            "reason": self.reason,
        }


def not_estimated(quantity: str, axis: str, unit: str, reason: str, condition: str = "") -> Row:
    """Return the row of a quantity that the data cannot carry."""
    return Row(quantity, axis, None, None, unit, status="not_estimated", reason=reason, condition=condition)


def is_beside(condition: str) -> bool:
    """Return whether a condition marks another way of reducing the same readings, or a part of them, not the result."""
    return condition in WAYS or FLIP.fullmatch(condition) is not None


def finite(number: float | None) -> float | None:
    """Return the number as a float, or None where it is absent, infinite or NaN."""
    return float(number) if number is not None and math.isfinite(number) else None
