"""Noise terms of an axis as found: each with its interval, or why not, how large at most, and how long to record."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from ....core.estimate import Array, Estimate
from ....core.key import Key, Kind, Reason
from ....core.remarks import Remark
from ....core.results import Interval, Row
from ....core.show.frames import frame
from ....core.show.rounding import ends, with_uncertainty
from ....core.show.tables import Block, Table, html, text
from ..terms import TERMS, Term, converted, shown_units
from .goodness import ChiSquare

if TYPE_CHECKING:
    from pandas import DataFrame

BEST = 5  # choices of terms that are shown
LENGTHS = ((86400.0, "days"), (3600.0, "h"), (60.0, "min"), (1.0, "s"))
REASONS = {
    "too_short": "record too short",
    "like_another": "cannot be separated from {others}",
    "like_white": "same as white noise, with dead time",
    "like_filter": "hidden by the filter: its averaging times are not fitted",
    "hidden_by_white": "hidden by white noise: sample faster to show it",
    "small": "below its limit, or absent",
    "no_record": "too small for any practical record",
    "no_limit": "record too short for a limit",
}  # why a term is not identified
DOUBTS = {
    "terms_do_not_explain": "the terms do not explain the Allan deviation",
    "runs_disagree": "the records do not agree",
}  # codes of remarks after which no figure of a fit may be relied on, and what to say of one


@dataclass(frozen=True)
class Parameter:
    """One parameter of a term."""

    name: str  # The field's word: ``"angle_random_walk"``
    # In ``unit``, inside units
    value: float
    u: float
    interval: Interval  # Of the same unit
    unit: str  # As ``core.units`` prints it


@dataclass(frozen=True)
class TermEstimate:
    """One term: its parameters, or why it has none."""

    name: str  # Of ``terms``
    status: Literal["estimated", "not_identified"]  # Whether the record shows it
    parameters: tuple[Parameter, ...] = ()  # Of an estimated term
    words: tuple[str, ...] = ()  # The field's words of the parameters of one that is not
    # Key of `REASONS`: why not; of an estimated term ``"like_another"`` where others could be in its place
    code: str = ""
    others: tuple[str, ...] = ()  # Terms that it cannot be separated from
    worse: float | None = None  # By how much the criterion is worse with it, or with the others in its place
    upper_limit: float | None = None  # One-sided 95 %, of its coefficient [``unit``]
    unit: str = ""  # Of the limit
    record_needed: float | None = None  # Length of a record that shows the term, were it at its limit [s]
    record: float = 0.0  # Length of the present record [s]
    limit_at: float | None = None  # Correlation time that the limit of Gauss-Markov noise holds for [s]

    @classmethod
    def missing(
        cls, name: str, words: tuple[str, ...], code: str, others: tuple[str, ...], worse: float | None,
        upper_limit: float | None, unit: str, record_needed: float | None, record: float, limit_at: float | None,
    ) -> TermEstimate:  # fmt: skip
        """Return a term that is not identified; the constructor takes several times as long."""
        found = object.__new__(cls)
        found.__dict__.update(
            name=name, status="not_identified", parameters=(), words=words, code=code, others=others, worse=worse,
            upper_limit=upper_limit, unit=unit, record_needed=record_needed, record=record, limit_at=limit_at,
        )  # fmt: skip
        return found

    @property
    def reason(self) -> str:
        """What `code` means, in words; empty where there is nothing to say."""
        if self.status == "estimated" and self.code:
            return f"{', '.join(self.others)} would fit nearly as well"
        said = REASONS.get(self.code, "")
        return said.format(others=", ".join(self.others)) if self.code == "like_another" else said


@dataclass(frozen=True)
class Rival:
    """Terms that may be true in place of those that were taken."""

    terms: tuple[Term, ...]  # With the sizes that they have then
    worse: float  # By how much the criterion is worse


@dataclass(frozen=True, eq=False)
class NoiseFit:
    """Noise terms of one axis."""

    kind: Kind | None  # Of the sensor; None where the unit is that of the file
    unit: str  # Of the samples
    found: tuple[TermEstimate, ...]  # Terms, those estimated first
    estimate: Estimate  # All parameters that were fitted, with their covariance
    # Choices of terms, best first, and by how much the criterion is worse
    choices: tuple[tuple[tuple[str, ...], float], ...]
    residual: ChiSquare | None  # Whether the terms explain the Allan deviation; None where nothing is left over to tell
    agreement: ChiSquare | None  # Whether several runs agree; None for one
    # Relative, of each Allan deviation: what the terms leave unexplained besides scatter, allowed for in all else
    misfit: float
    terms: tuple[Term, ...]  # The terms estimated, to simulate, draw or filter with
    tau: tuple[Array, ...]  # A run each: averaging times [s]
    variance: tuple[Array, ...]  # A run each: Allan variances found [unit^2]
    expected: tuple[Array, ...]  # A run each: Allan variances expected [unit^2]
    estimated_at: Callable[[float], tuple[TermEstimate, ...]]  # Terms estimated, with intervals of a probability
    remarks: tuple[Remark, ...] = ()  # What to know about it
    rivals: tuple[Rival, ...] = ()  # Other terms of long averaging times that the record does not exclude, best first

    def at(self, p: float) -> NoiseFit:
        """Return the same fit with intervals of another probability; upper limits keep theirs."""
        return replace(self, found=self.estimated_at(p) + tuple(one for one in self.found if one.status != "estimated"))

    def term(self, name: str) -> TermEstimate | None:
        """Return what was found of a term; None if it was no candidate."""
        return next((term for term in self.found if term.name == name), None)

    @property
    def fit_warnings(self) -> tuple[str, ...]:
        """Codes of remarks for which the figures are not to be relied on: keys of `DOUBTS`; empty where all is well."""
        return tuple(code for code in DOUBTS if any(remark.code == code for remark in self.remarks))

    def rows(self, axis: str = "", test: str = "", condition: str = "") -> tuple[Row, ...]:
        """Return the parameters as rows of a result, inside units; limits of terms that are not identified."""
        return tuple(rows_of(self.found, self.fit_warnings, axis, test, condition))

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame: a row a parameter, with value, u, interval, unit, status and reason."""
        rows = self.rows()
        columns = {
            "value": [row.value for row in rows],
            "u": [row.u for row in rows],
            "lo": [row.interval.lo if row.interval else None for row in rows],
            "hi": [row.interval.hi if row.interval else None for row in rows],
            "unit": [row.unit for row in rows],
            "status": [row.status for row in rows],
            "reason": [row.reason.text for row in rows],
        }
        return frame(columns, index=[row.quantity for row in rows])

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: terms in units of data sheets, those not identified, tests and remarks."""
        shown: list[Block] = [_table(self.found, self.kind)]
        missing = [term for term in self.found if term.status == "not_identified"]
        if missing:
            shown.append(_missing(missing, self.kind))
        for test, what in ((self.residual, "terms explain the Allan deviation"), (self.agreement, "runs agree")):
            if test is not None:
                shown.append(f"{what}: {test}")
        if len(self.choices) > 1:
            rows = [(", ".join(terms), f"{worse:.1f}") for terms, worse in self.choices[:BEST]]
            shown.append(Table(("terms", "criterion"), rows, "Choices of terms (0 is best)", (1,)))
        return (*shown, *(str(remark) for remark in self.remarks))

    def __str__(self) -> str:
        """Return tables for a terminal."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the same tables for a notebook."""
        return html(self.parts())


def rows_of(
    found: Iterable[TermEstimate], warnings: Sequence[str], axis: str = "", test: str = "", condition: str = ""
) -> Iterator[Row]:
    """Yield the parameters of terms as ``NoiseFit.rows`` gives them, with its warnings."""
    doubt = [DOUBTS[code] for code in warnings]
    for term in found:
        said = "; ".join([*doubt, term.reason] if term.reason else doubt)
        for one in term.parameters:
            values = Key(one.name, axis), one.value, one.u, one.unit, None, one.interval
            yield Row(*values, "estimated", Reason("limits", said), test, condition)
        if term.status == "not_identified":
            yield from _missing_rows(term, axis, test, condition)


def _missing_rows(term: TermEstimate, axis: str, test: str, condition: str) -> list[Row]:
    reason = term.reason
    if term.limit_at is not None:
        reason += f"; limit at a correlation time of {duration(term.limit_at)}"
    if term.record_needed is not None and term.record_needed > term.record:
        reason += f"; a record of {duration(term.record_needed)} would show it if it were at its upper limit"
    why = Reason("not_found", reason)
    if term.upper_limit is None:
        return [
            Row(
                Key(word, axis),
                None,
                None,
                term.unit,
                status="not_estimated",
                reason=why,
                test=test,
                condition=condition,
            )
            for word in term.words
        ]
    interval = Interval(None, term.upper_limit, 0.95)
    return [
        Row(Key(term.words[0], axis), None, None, term.unit, None, interval, "upper_limit", why, test, condition)
    ]  # fmt: skip


def _table(found: tuple[TermEstimate, ...], kind: Kind | None) -> Table:
    rows = [
        _row(one, unit)
        for term in found
        for word, one in zip(TERMS[term.name].parameters, term.parameters, strict=False)
        for unit in shown_units(term.name, word, kind) or (one.unit,)
    ]
    p = next((one.interval.p for term in found for one in term.parameters), 0.95)
    return Table(("term", "value ± u", "unit", f"{100 * p:g} % interval"), rows, "Noise terms", (1, 3))


def _row(one: Parameter, unit: str) -> tuple[str, str, str, str]:
    times = 1.0 if unit == one.unit else converted(1.0, one.unit, unit)
    if one.u == 0.0:
        return one.name, f"{one.value * times:.6g}", unit, "given"
    lo, hi = one.interval.lo, one.interval.hi
    scaled = (one.value * times, one.u * times, 0.0 if lo is None else lo * times, None if hi is None else hi * times)
    return one.name, with_uncertainty(*scaled[:2]), unit, ends(*scaled)


def _missing(missing: list[TermEstimate], kind: Kind | None) -> Table:
    rows = []
    for term in missing:
        unit = next(iter(shown_units(term.name, TERMS[term.name].parameters[0], kind)), term.unit)
        limit, needed = "-", "-"
        if term.upper_limit is not None:
            times = 1.0 if unit == term.unit else converted(1.0, term.unit, unit)
            limit = f"< {term.upper_limit * times:.3g}"
        if term.record_needed is not None and term.record_needed > term.record:
            needed = duration(term.record_needed)
        name = term.words[0] if term.limit_at is None else f"{term.name}, {duration(term.limit_at)}"
        reason = term.reason if term.worse is None else f"{term.reason} (+{term.worse:.1f})"
        rows.append((name, limit, unit if limit != "-" else "", needed, reason))
    heads = ("not identified", "95 % limit", "unit", "record needed", "reason (criterion)")
    return Table(heads, rows, "Not identified; record needed to show a term that is at its limit", (1, 3))


def duration(seconds: float) -> str:
    """Return a length of time in words: ``"2.5 h"``."""
    size, word = LENGTHS[-1]
    for own in LENGTHS:
        if seconds >= 2.0 * own[0]:
            size, word = own
            break
    return f"{seconds / size:.2g} {word}" if seconds < 99.5 * size else f"{seconds / size:.0f} {word}"
