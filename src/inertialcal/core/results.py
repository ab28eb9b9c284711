"""Rows of a result: one quantity of one axis with its uncertainty, or the reason why there is none.

A procedure's Result gives rows; ``results.json`` and ``results.csv`` hold them as they are. Absent numbers
are null; degrees of freedom null mean infinite.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from .key import NO_REASON, Case, Key, Member, Method, Reason, case_of, key_of, reason_of

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
    key : Key
        What it is of: quantity, axis, sensor, power, place.
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
    reason : Reason
        Why not, or what limits it.
    test : str
        Identifier of the test in the campaign.
    condition : str
        Of the campaign, under which the test ran.
    method : Method
        By which way; ``Method.TEXTBOOK`` is a document's own.
    member : Member or None
        Of which part of the readings: one flip, one run.
    """

    key: Key
    value: float | None
    u: float | None
    unit: str
    dof: float | None = None
    interval: Interval | None = None
    status: Status = "estimated"
    reason: Reason = NO_REASON
    test: str = ""
    condition: str = ""
    method: Method = Method.RESULT
    member: Member | None = None

    @property
    def quantity(self) -> str:
        """The field's word, with the power of a coefficient: ``"bias_temperature_2"``."""
        return self.key.name

    @property
    def axis(self) -> str:
        """Sensor, or two letters for a matrix entry."""
        return self.key.axis

    @property
    def case(self) -> Case:
        """Which of several figures of one quantity and axis it is."""
        key = self.key
        times = key.power if key.at is not None and key.at.what == "line" else 0
        return Case(self.method, self.member, key.at, times, key.sensor, self.condition)

    def to_dict(self) -> dict[str, Any]:
        """Return the row as ``results.json`` holds it; not finite numbers are null."""
        interval = self.interval
        return {
            "quantity": self.quantity,
            "axis": self.axis,
            **({"sensor": self.key.sensor} if self.key.sensor else {}),
            "test": self.test,
            "condition": str(self.case),
            "value": finite(self.value),
            "u": finite(self.u),
            "unit": self.unit,
            "dof": finite(self.dof),
            "interval": None
            if interval is None
            else {"lo": finite(interval.lo), "hi": finite(interval.hi), "p": interval.p},
            "status": self.status,
            "reason": self.reason.text,
        }

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Row:
        """Return a row of ``results.json``; the code of its reason is not there, and a requirement's name is none."""
        case, ends = case_of(str(row["condition"])), row.get("interval")
        key = key_of(str(row["quantity"]), str(row["axis"]))
        value, u, dof = (None if row[name] is None else float(row[name]) for name in ("value", "u", "dof"))
        return cls(
            key._replace(sensor=str(row.get("sensor") or case.sensor), at=case.at, power=case.times or key.power),
            value, u, str(row["unit"]), dof,
            None if ends is None else Interval(ends["lo"], ends["hi"], ends["p"]),
            row["status"], reason_of(str(row["reason"])), str(row["test"]), case.condition, case.method, case.member,
        )  # fmt: skip


def not_estimated(
    key: Key, unit: str, reason: Reason, method: Method = Method.RESULT, member: Member | None = None
) -> Row:
    """Return the row of a quantity that the data cannot carry."""
    return Row(key, None, None, unit, status="not_estimated", reason=reason, method=method, member=member)


def finite(number: float | None) -> float | None:
    """Return the number as a float, or None where it is absent, infinite or NaN."""
    return float(number) if number is not None and math.isfinite(number) else None


def by_quantity(rows: Sequence[Row]) -> list[Row]:
    """Return rows with those of one quantity side by side, in the order of their first."""
    order = list(dict.fromkeys((row.test, row.quantity) for row in rows))
    return sorted(rows, key=lambda row: order.index((row.test, row.quantity)))
