"""Identity of a figure: its key, the method, the part of the readings; and the reason where there is no figure.

Programs read these fields. The texts made of them (``bias_temperature_2_x``, ``"line at 9.97 Hz"``) are for people and
are never read back.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Literal, NamedTuple

FROM_ZERO = ("bias_voltage",)  # polynomials whose power 0 is told, too
DIGITS = {"temperature": 6, "line": 4}  # significant ones of a place


class At(NamedTuple):
    """Where a figure holds: temperature, -20, degC."""

    what: str
    value: float
    unit: str

    def __str__(self) -> str:
        """Return the place as text: ``"-20 degC"``, ``"9.97 Hz"``."""
        return f"{self.number} {self.unit}".rstrip()

    @property
    def number(self) -> str:
        """Its value as text."""
        return f"{self.value:.{DIGITS.get(self.what, 6)}g}"


class Member(NamedTuple):
    """A part of the readings that has a figure of its own: a flip, a run; or what a figure is told for."""

    kind: str
    label: str

    def __str__(self) -> str:
        """Return the part as text: ``"flip 3"``, ``"run R2 alone"``."""
        if self.kind == "flip":
            return f"flip {self.label}"
        if self.kind == "run":
            return f"run {self.label} alone"
        if self.kind == "held_out":
            return f"held out, {self.label}" if self.label else "held out"
        return self.label


def told_for(what: str) -> Member | None:
    """Return what a figure is told for, in words; None for none."""
    return Member("told_for", what) if what else None


class Method(StrEnum):
    """By which way a figure was found from the same readings; RESULT is the one that counts."""

    RESULT = "result"
    ALL_READINGS = "all_readings"
    MEDIAN = "median"
    LOW_PASS = "low_pass"  # noqa: S105 - a filter
    TEXTBOOK = "as_published"
    WITHIN_RUNS = "within_runs"
    BETWEEN_RUNS = "between_runs"
    DIFFERENCES = "differences"
    GENERALISED = "generalised"
    PRIOR = "prior"  # what was stated before any reading
    WITHOUT_PRIOR = "without_prior"
    AS_READ = "as_read"  # nothing compensated
    UNSCREENED = "unscreened"  # with the samples that screening left out
    CHANGE = "change"  # this test less the one that it is set against
    RATIO = "ratio"  # this test over the one that it is set against
    DRIFT = "drift"  # change a year over the tests of a unit


# Ways that stand beside a result in tables, in the order of their columns.
WAYS = (
    Method.ALL_READINGS, Method.MEDIAN, Method.LOW_PASS, Method.TEXTBOOK, Method.WITHIN_RUNS, Method.BETWEEN_RUNS,
    Method.PRIOR, Method.WITHOUT_PRIOR, Method.AS_READ, Method.UNSCREENED,
)  # fmt: skip
CHANGES = (Method.CHANGE, Method.RATIO)  # from an earlier test to this one
PARTS = ("flip", "run")  # members that stand beside a result, too


class Key(NamedTuple):
    """What a figure is of."""

    quantity: str  # The field's word: ``"scale_factor"``, ``"bias_temperature"``
    axis: str = ""  # ``"x"``, or ``"xz"`` for a matrix entry (row = sensor that reads, column = axis that moves)
    sensor: str = ""  # Kind of sensor, where one result holds several
    # Of a polynomial: ``bias_temperature``, power 2. Of a line: which multiple of the one at its place, or which
    # of several; 0 is itself.
    power: int = 0
    at: At | None = None  # Where it holds

    @property
    def name(self) -> str:
        """Quantity with its power: ``"bias_temperature_2"``."""
        if self.at is not None and self.at.what == "line":
            return self.quantity
        return f"{self.quantity}_{self.power}" if self.power or self.quantity in FROM_ZERO else self.quantity

    def __str__(self) -> str:
        """Return the name of a value in an estimate: ``"bias_temperature_2_x"``, ``"bias_x at -20 degC"``."""
        name = f"{self.name}_{self.axis}" if self.axis else self.name
        return f"{name} at {self.at}" if self.at is not None else name


class Reason(NamedTuple):
    """Why there is no figure, or what limits it: programs read the code, people the text."""

    code: str = ""
    text: str = ""

    def __bool__(self) -> bool:
        """Tell whether there is anything to say."""
        return bool(self.text)

    def __str__(self) -> str:
        """Return the text."""
        return self.text


NO_REASON = Reason()


class Origin(NamedTuple):
    """Where an uncertainty comes from; equal origins are the same unknowns."""

    what: str  # As budgets name it: ``"table rate"``, ``"scatter between runs"``
    test: str = ""  # In which it was found, where it is another one
    standard: str = ""  # Of Type B, whose certificate: ``"rate_table"``
    quantity: str = ""  # Of Type B, which quantity of it: ``"rate"``
    # Of Type A: what was repeated: ``"run"``, ``"dwell"``, ``"sample"``; ``"hidden"`` is a bound where nothing
    # was
    level: str = ""

    def __str__(self) -> str:
        """Return the text that budgets show."""
        return f"{self.test}: {self.what}" if self.test else self.what


class Case(NamedTuple):
    """Which of several figures of one quantity and axis a row is; its text is the ``condition`` of ``results.json``."""

    method: Method = Method.RESULT  # By which way
    member: Member | None = None  # Of which part of the readings
    at: At | None = None  # Where it holds
    times: int = 0  # Which multiple of a line; 0 is itself
    sensor: str = ""  # Kind of sensor, where one result holds several
    condition: str = ""  # Of the campaign; it is told where nothing else is

    @property
    def beside(self) -> bool:
        """Whether it is another way of reducing the same readings, or a part of them, and not the result."""
        return self.method in WAYS or (self.member is not None and self.member.kind in PARTS and self.at is None)

    @property
    def plain(self) -> bool:
        """Whether it is the result of its quantity and axis, whatever the sensor and the condition of the campaign."""
        return self[:4] == PLAIN[:4]

    @property
    def place(self) -> str:
        """Where it holds as text: ``"-20 degC"``, ``"2 x 9.97 Hz"``; empty for no place."""
        return "" if self.at is None else f"{self.number} {self.at.unit}".rstrip()

    @property
    def number(self) -> str:
        """The same without its unit."""
        return "" if self.at is None else f"{self.times} x {self.at.number}" if self.times else self.at.number

    def __str__(self) -> str:
        """Return the text that ``results.json`` has as condition."""
        if self.at is not None and self.at.what == "line":
            parts: list[object] = [f"line at {self.place}", self.member]
        else:
            parts = [self.method if self.method is not Method.RESULT else None, self.member, self.at]
        told = ", ".join(str(part) for part in parts if part is not None)
        return told or self.sensor or self.condition


PLAIN = Case()
AXES = ("x", "y", "z")  # right-handed; the order of vectors and of matrix columns
Kind = Literal["gyro", "accelerometer"]
