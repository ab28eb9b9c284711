"""What a requirement asks and what a test answers: limits, decision rule, ``where``, and the verdict at each place.

``where`` follows a small stated grammar, never eval::

    condition  = comparison { ("and" | "or") comparison }     "and" binds stronger than "or"
    comparison = [ "abs(" ] name [ ")" ] operator quantity
    operator   = ">=" | ">" | "<=" | "<"
    quantity   = "number unit", as everywhere

An empty text holds always.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from statistics import NormalDist
from typing import Literal

from .errors import DataError
from .results import Interval
from .units import Quantity, kind, parse_quantity, same_dimension, si_unit

LEVEL = 0.95
LONGEST = 400  # characters
# What may be compared, and which kind of quantity it is
NAMES = {"rate": "angular_rate", "temperature": "temperature", "frequency": "frequency"}
OPERATORS: dict[str, Callable[[float, float], bool]] = {
    ">=": operator.ge,
    ">": operator.gt,
    "<=": operator.le,
    "<": operator.lt,
}
COMPARISON = re.compile(r"\s*(?:abs\(\s*(?P<sized>\w+)\s*\)|(?P<plain>\w+))\s*(?P<op>>=|<=|>|<)\s*(?P<value>.+?)\s*")
ROUNDING = 1e-9  # relative: 0.1 deg/s in a table and in a condition are the same rate

Readings = Literal["as_read", "compensated"]
RuleName = Literal["interval", "simple_acceptance", "guard_factor", "false_accept_risk", "test_uncertainty_ratio"]


@dataclass(frozen=True)
class Process:
    """Distribution of the true values of all items, normal: what a global risk is about (JCGM 106, clause 7)."""

    mean: Quantity | None = None  # Middle of the limits where not given
    sd: Quantity | None = None
    in_tolerance: float | None = None  # Instead of sd: share of all items inside the limits

    def normal(self, unit: str, lower: float | None, upper: float | None) -> tuple[float, float]:
        """Return mean and standard deviation in the unit of the limits."""
        middle = 0.0 if lower is None or upper is None else 0.5 * (lower + upper)
        mean = middle if self.mean is None else self.mean.to(unit)
        if self.sd is not None:
            return mean, self.sd.to(unit, difference=True)
        half = 0.0 if lower is None or upper is None else 0.5 * (upper - lower)
        return mean, half / NormalDist().inv_cdf(0.5 * (1.0 + (self.in_tolerance or 0.5)))

    def __str__(self) -> str:
        """Return it in words."""
        if self.in_tolerance is not None:
            return f"a process with {100.0 * self.in_tolerance:g} % in tolerance (normal, centred)"
        return f"a process of mean {self.mean or 'midway'} and standard deviation {self.sd} (normal)"


@dataclass(frozen=True)
class Rule:
    """Decision rule of a requirement: how far inside its limits a value must lie to PASS."""

    name: RuleName = "interval"
    factor: float = 1.0  # Of ``guard_factor``: multiple of U
    risk: float = 0.05  # Of ``false_accept_risk``
    process: Process | None = None  # With it the risk is global: over all items
    ratio: float = 4.0  # Of ``test_uncertainty_ratio``
    otherwise: Rule | None = None  # Of ``test_uncertainty_ratio``: rule below that ratio
    binary: bool = False  # FAIL in place of INCONCLUSIVE where u is known
    normal: tuple[float, float] | None = None  # Mean and standard deviation of the process, in the unit of the limits

    def within(self, unit: str, lower: float | None, upper: float | None) -> Rule:
        """Return the rule with the process in the unit of the limits."""
        if self.process is None and self.normal is None and self.otherwise is None:
            return self
        inner = None if self.otherwise is None else self.otherwise.within(unit, lower, upper)
        normal = None if self.process is None else self.process.normal(unit, lower, upper)
        return replace(self, normal=normal, otherwise=inner)

    @property
    def fallback(self) -> Rule:
        """Rule below the ratio."""
        return self.otherwise or Rule()

    def __str__(self) -> str:
        """Return it in words."""
        rest = "else FAIL" if self.binary else "else INCONCLUSIVE"
        if self.name == "simple_acceptance":
            return "simple acceptance: PASS if the value lies inside the limits, else FAIL"
        if self.name == "test_uncertainty_ratio":
            below = "95 % interval" if self.fallback == Rule() else str(self.fallback)
            return (
                f"test uncertainty ratio: where the limits lie {2.0 * self.ratio:g} U apart or more"
                f" (TUR {self.ratio:g}:1), simple acceptance; below: {below}"
            )
        outside = "" if self.binary else self._outside
        return f"{self._inside}{outside}, {rest}"

    @property
    def _inside(self) -> str:
        if self.name == "guard_factor":
            return (
                f"guard factor {self.factor:g}: PASS if the value lies inside the limits by {self.factor:g} U or more"
            )
        if self.name == "interval":
            return "PASS if the 95 % interval lies inside the limits"
        if self.process is not None:
            return (
                f"global false-accept risk {100.0 * self.risk:g} %: PASS inside the limits by a guard band w or more,"
                f" so that {100.0 * self.risk:g} % of all items at most PASS and do not conform, of {self.process}"
            )
        return (
            f"false-accept risk {100.0 * self.risk:g} %: PASS if the true value lies outside the limits with a"
            f" probability of {100.0 * self.risk:g} % at most"
        )

    @property
    def _outside(self) -> str:
        if self.name == "guard_factor":
            return f", FAIL if outside by more than {self.factor:g} U"
        if self.name == "interval":
            return ", FAIL if wholly outside"
        if self.process is not None:
            return ", FAIL outside by more than w"
        return ", FAIL if it lies inside with that at most"


@dataclass(frozen=True)
class Basis:
    """What a verdict was made by."""

    rule: str = ""  # In words
    accept_lower: float | None = None  # Values from here on PASS, at this uncertainty; None for no limit
    accept_upper: float | None = None
    # Specific risk: of a PASS, the probability that the true value lies outside the limits, of a FAIL inside, by this
    # measurement alone; None for another verdict, or where no probability can be said
    risk: float | None = None
    ratio: float | None = None  # Test uncertainty ratio: span of two limits over 2 U
    compared: Interval | None = None  # Value with its guard band on both sides: what was compared with the limits
    in_doubt: bool = False  # More than u keeps it from being decided


@dataclass(frozen=True)
class Comparison:
    """One comparison of a named quantity with a number, SI."""

    name: str
    size: bool
    op: str
    value: float

    def holds(self, values: Mapping[str, float]) -> bool:
        """Return True where it holds; equal up to rounding counts as equal."""
        x = abs(values[self.name]) if self.size else values[self.name]
        if abs(x - self.value) <= ROUNDING * abs(self.value):
            return "=" in self.op
        return OPERATORS[self.op](x, self.value)


@dataclass(frozen=True)
class Condition:
    """Alternatives, each a list of comparisons that must all hold."""

    alternatives: tuple[tuple[Comparison, ...], ...]

    def holds(self, values: Mapping[str, float]) -> bool:
        """Return True where it holds for the values, SI."""
        return any(all(one.holds(values) for one in every) for every in self.alternatives)


def parse_condition(text: str) -> Condition:
    """Read a condition.

    Raises
    ------
    DataError
        If it does not follow the grammar, names something unknown, or has a quantity that cannot be read.
    """
    if not text.strip():
        return Condition(((),))
    if len(text) > LONGEST:
        raise DataError(f"where is {len(text)} characters long, at most {LONGEST}")
    return Condition(
        tuple(
            tuple(_comparison(part) for part in re.split(r"\band\b", alternative))
            for alternative in re.split(r"\bor\b", text)
        )
    )


def _comparison(text: str) -> Comparison:
    match = COMPARISON.fullmatch(text)
    if match is None:
        raise DataError(
            f"where = {text.strip()!r} is no comparison", do='Write: "abs(rate) >= 0.1 deg/s and rate < 5 deg/s"'
        )
    name = match["sized"] or match["plain"]
    if name not in NAMES:
        raise DataError(f"where: {name!r} is not known", do=f"There are: {', '.join(NAMES)}")
    given = parse_quantity(match["value"])
    if kind(given.unit) != NAMES[name]:
        raise DataError(
            f"where: {name} cannot be compared with {match['value']!r}", do='Write: "abs(rate) >= 0.1 deg/s"'
        )
    return Comparison(name, match["sized"] is not None, match["op"], given.to(si_unit(given.unit)))


@dataclass(frozen=True)
class Asked:
    """What a requirement asks of a figure, as a procedure sees it."""

    id: str
    quantity: str
    axis: str | None = None  # None for all
    # What of it: where a procedure tells them apart, or its change from the test that its test is set against
    of: Literal["expected", "dwell_mean", "reading", "change"] = "dwell_mean"
    limit: str | None = None  # As stated: size of both limits
    lower: str | None = None  # As stated
    upper: str | None = None  # As stated
    where: str = ""  # Over which range
    rule: Rule = Rule()  # By which it is decided

    @cached_property
    def condition(self) -> Condition:
        """The range, parsed."""
        return parse_condition(self.where)

    def comparable(self, unit: str) -> bool:
        """Return whether the limits are of the kind of a unit."""
        stated = self.limit or self.lower or self.upper or ""
        return same_dimension(parse_quantity(stated).unit, unit)

    def limits(self, unit: str, size: bool = False) -> tuple[float | None, float | None]:
        """Return the limits in a unit; a limit on either side is one above for a size, which is never negative.

        Of temperatures they are differences: no figure is judged that is a temperature itself.

        Raises
        ------
        DataError
            If the limits are of another kind.
        """
        if self.limit is not None:
            far = abs(parse_quantity(self.limit).to(unit, difference=True))
            return (None if size else -far), far
        ends = (self.lower, self.upper)
        lower, upper = (None if one is None else parse_quantity(one).to(unit, difference=True) for one in ends)
        return lower, upper


@dataclass(frozen=True)
class Verdict:
    """A requirement judged at one place."""

    requirement: str
    test: str
    axis: str
    at: float | None  # Rate [rad/s] or temperature [degC] that it is judged at; None where it is about a single figure
    of: str  # What of it: ``expected``, ``dwell_mean``, ``reading``, ``change``; empty for a single figure
    value: float | None  # In ``unit``
    u: float | None  # In ``unit``
    unit: str
    interval: Interval | None
    lower: float | None  # Limits in ``unit``
    upper: float | None  # Limits in ``unit``
    verdict: str  # By the rule
    reason: str = ""  # Why not PASS or FAIL
    at_unit: str = "rad/s"
    sensor: str = ""  # Kind of sensor where one test has several
    basis: Basis = field(default_factory=Basis)  # Rule, acceptance limits, risk
    readings: Readings = "as_read"  # Of what readings: as they are, or after compensation
    as_read: Verdict | None = None  # Of compensated readings: the same as they were read, by the same rule
