"""Rows of a result: one quantity of one axis with its uncertainty, or the reason why there is none.

A procedure's Result gives rows; ``results.json`` and ``results.csv`` hold them as they are. Absent numbers
are null; degrees of freedom null mean infinite.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, Protocol, TypeVar

from .key import NO_REASON, At, Case, Key, Member, Method, Reason

T = TypeVar("T")
Status = Literal["estimated", "not_estimated", "upper_limit"]


SCHEMA = 2  # of results.json, and of what commands print with --json
COLUMNS = (
    "quantity", "axis", "sensor", "power", "at_what", "at", "at_unit", "test", "condition", "method", "member_kind",
    "member", "value", "u", "unit", "dof", "lo", "hi", "p", "status", "reason_code", "reason",
)  # of a row as a table  # fmt: skip


class WrittenRow(Protocol):
    """A row of ``results.json``: a mapping, or one that knows where it stands in the file."""

    def __getitem__(self, key: str, /) -> Any:
        """Return a field."""
        ...


@dataclass(frozen=True)
class Interval:
    """Two-sided interval with probability ``p``; an open side is None."""

    lo: float | None
    hi: float | None
    p: float = 0.95

    @classmethod
    def of_own(cls, lo: float, hi: float, p: float) -> Interval:
        """Return it; the constructor takes twice as long."""
        found = object.__new__(cls)
        found.__dict__.update(lo=lo, hi=hi, p=p)
        return found


def changed(one: T, **fields: object) -> T:
    """Return a frozen dataclass with other values of some fields, and what it worked out before forgotten.

    For values that our own code made of such as were checked: ``dataclasses.replace`` calls the constructor, which
    checks everything again, and takes five times as long.

    Examples
    --------
    >>> changed(Interval(1.0, 2.0), hi=3.0)
    Interval(lo=1.0, hi=3.0, p=0.95)
    """
    own, names = one.__dict__, one.__dataclass_fields__  # type: ignore[attr-defined]
    found = object.__new__(type(one))
    found.__dict__.update(own if len(own) == len(names) else {name: own[name] for name in names}, **fields)
    return found


NOT_COMPUTABLE = Reason("not_computable", "the readings give no finite value, or no finite uncertainty")


class Curvature(NamedTuple):
    """What a curvature of the unit does to a figure whose line does not have it."""

    change: float  # Of the figure, in its unit, for one unit of the term; 0 where the line has it
    size: float  # Of the term as it may be, SI; 0 where it is taken as none

    @property
    def share(self) -> float:
        """Signed share of the uncertainty of the figure."""
        return self.change * self.size

    def times(self, scale: float) -> Curvature:
        """Return it for a figure in another unit."""
        return Curvature(self.change * scale, self.size)


@dataclass(frozen=True)
class Row:
    """One published figure; one that is not a finite number, or whose uncertainty is none, is not estimated."""

    key: Key  # What it is of: quantity, axis, sensor, power, place
    value: float | None  # In ``unit``
    u: float | None  # In ``unit``
    unit: str  # As ``core.units`` prints it
    dof: float | None = None  # Degrees of freedom of ``u``; None is infinite
    interval: Interval | None = None  # 95 % unless it says otherwise
    status: Status = "estimated"  # Whether the data carried the answer
    reason: Reason = NO_REASON  # Why not, or what limits it
    test: str = ""  # Identifier of the test in the campaign
    condition: str = ""  # Of the campaign, under which the test ran
    method: Method = Method.RESULT  # By which way; ``Method.TEXTBOOK`` is a document's own
    member: Member | None = None  # Of which part of the readings: one flip, one run
    # Influence that outlives the test (``"rate_table.rate"``) -> change of the value for one standard uncertainty
    # of it, in ``unit``, with its sign
    shared: Mapping[str, float] = field(default_factory=dict)
    # Curvature of the unit (``"third_order_x"``) -> what it does to the value where the line does not have it
    curvature: Mapping[str, Curvature] = field(default_factory=dict)

    def __post_init__(self) -> None:
        known = self.value is None or math.isfinite(self.value)
        certain = self.u is None or bool(self.reason) or math.isfinite(self.u)  # a reason says why there is none
        if self.status == "not_estimated" or (known and certain):
            return
        for name, value in {"value": None, "u": None, "interval": None, "status": "not_estimated"}.items():
            object.__setattr__(self, name, value)
        object.__setattr__(self, "reason", self.reason or NOT_COMPUTABLE)

    @classmethod
    def of_own(
        cls, key: Key, value: float, u: float | None, unit: str, dof: float | None, interval: Interval, reason: Reason,
        method: Method = Method.RESULT, status: Status = "estimated",
    ) -> Row:  # fmt: skip
        """Return the row of an estimated figure that is known to be finite: nothing is checked again."""
        found = object.__new__(cls)
        found.__dict__.update(
            key=key, value=value, u=u, unit=unit, dof=dof, interval=interval, status=status, reason=reason,
            test="", condition="", method=method, member=None, shared={}, curvature={},
        )  # fmt: skip
        return found

    @classmethod
    def without(
        cls, key: Key, value: float | None, unit: str, reason: Reason, method: Method = Method.RESULT,
        member: Member | None = None,
    ) -> Row:  # fmt: skip
        """Return the row of a figure that has no uncertainty."""
        found = object.__new__(cls)
        found.__dict__.update(
            key=key, value=value, u=None, unit=unit, dof=None, interval=None, status="not_estimated", reason=reason,
            test="", condition="", method=method, member=member, shared={}, curvature={},
        )  # fmt: skip
        return found

    def changed(self, **fields: object) -> Row:
        """Return the row with other values of some fields; ``dataclasses.replace`` takes six times as long."""
        found = object.__new__(type(self))
        found.__dict__.update(self.__dict__ | fields)
        found.__post_init__()
        return found

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
        """Return the row as ``results.json`` holds it; numbers that are not finite are null."""
        interval, reason = self.interval, self.reason
        return identity_fields(self) | {
            "value": finite(self.value),
            "u": finite(self.u),
            "unit": self.unit,
            "dof": finite(self.dof),
            "interval": None
            if interval is None
            else {"lo": finite(interval.lo), "hi": finite(interval.hi), "p": interval.p},
            "status": self.status,
            "reason": None if not reason else reason._asdict(),
            "shared": {name: float(change) for name, change in self.shared.items()},
            "curvature": {name: one._asdict() for name, one in self.curvature.items()},
        }

    def flat(self) -> dict[str, str | float | None]:
        """Return the row as ``results.csv`` and data frames hold it: one cell a field."""
        return flat(self.to_dict())

    @classmethod
    def from_dict(cls, row: WrittenRow) -> Row:
        """Return a row of ``results.json``."""
        case, ends, reason = case_of(row), row["interval"], row["reason"]
        value, u, dof = (None if row[name] is None else float(row[name]) for name in ("value", "u", "dof"))
        return cls(
            key_of(row), value, u, str(row["unit"]), dof,
            None if ends is None else Interval(ends["lo"], ends["hi"], ends["p"]),
            row["status"], NO_REASON if reason is None else Reason(str(reason["code"]), str(reason["text"])),
            str(row["test"]), case.condition, case.method, case.member,
            {str(name): float(change) for name, change in row["shared"].items()},
            {str(name): Curvature(float(one["change"]), float(one["size"])) for name, one in row["curvature"].items()},
        )  # fmt: skip


def flat(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row of ``results.json`` with one cell a field."""
    at, member = row["at"] or dict.fromkeys(At._fields), row["member"] or dict.fromkeys(Member._fields)
    ends, reason = row["interval"] or dict.fromkeys(("lo", "hi", "p")), row["reason"] or dict.fromkeys(Reason._fields)
    cells = {
        "at_what": at["what"], "at": at["value"], "at_unit": at["unit"],
        "member_kind": member["kind"], "member": member["label"],
        "reason_code": reason["code"], "reason": reason["text"],
    } | ends  # fmt: skip
    return {name: cells[name] if name in cells else row[name] for name in COLUMNS}


def key_fields(key: Key) -> dict[str, Any]:
    """Return a key as ``results.json`` holds it."""
    return key._asdict() | {"at": None if key.at is None else key.at._asdict()}


def identity_fields(row: Row) -> dict[str, Any]:
    """Return which figure a row is, as ``results.json`` holds it."""
    member = None if row.member is None else row.member._asdict()
    named = {"test": row.test, "condition": row.condition, "method": row.method.value, "member": member}
    return key_fields(row.key) | named


def key_of(row: WrittenRow) -> Key:
    """Return what a row of ``results.json`` is of."""
    at = row["at"]
    place = None if at is None else At(str(at["what"]), float(at["value"]), str(at["unit"]))
    return Key(str(row["quantity"]), str(row["axis"]), str(row["sensor"]), int(float(row["power"])), place)


def case_of(row: WrittenRow) -> Case:
    """Return which of several figures of one quantity and axis a row of ``results.json`` is."""
    key, member = key_of(row), row["member"]
    part = None if member is None else Member(str(member["kind"]), str(member["label"]))
    times = key.power if key.at is not None and key.at.what == "line" else 0
    return Case(Method(str(row["method"])), part, key.at, times, key.sensor, str(row["condition"]))


def not_estimated(
    key: Key, unit: str, reason: Reason, method: Method = Method.RESULT, member: Member | None = None
) -> Row:
    """Return the row of a quantity that the data cannot carry."""
    return Row.without(key, None, unit, reason, method, member)


def finite(number: float | None) -> float | None:
    """Return the number as a float, or None where it is absent, infinite or NaN."""
    return float(number) if number is not None and math.isfinite(number) else None


def by_quantity(rows: Sequence[Row]) -> list[Row]:
    """Return rows with those of one quantity together, in the order of their first."""
    found: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        found.setdefault((row.test, row.quantity), []).append(row)
    return [row for own in found.values() for row in own]
