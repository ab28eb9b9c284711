"""How well recordings of a sensor at rest determine each noise term, and how long a recording should be."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from ..core.results import case_of
from ..core.show.rows import reason_text
from ..core.show.wording import count, counted, words
from .findings import Figure, Finding, Length
from .numbers import Branch, Number, Text


@dataclass(frozen=True)
class Reach:
    """Uncertainty of one noise term of one axis from the recordings of a test, and the length that is needed."""

    test: str
    axis: str
    term: str
    known: Number | None  # relative error; None for a term that was not detected
    wanted: Number | None  # relative error that the plan requires
    unit: str  # of both
    record: Number  # length of the longest record
    needed: Number | None  # length of one that is enough; None where there is none
    time: str  # unit of these two
    reason: str  # why the term was not detected, or is unreliable

    @property
    def enough(self) -> bool:
        """Whether these recordings are long enough."""
        return self.known is not None and self.wanted is not None and self.known.raw <= self.wanted.raw

    @property
    def longer(self) -> bool:
        """Whether a known, longer recording would be enough."""
        return not self.enough and self.needed is not None and self.needed.raw > self.record.raw


def reaches(curves: Iterable[Branch], rows: Iterable[Branch]) -> list[Reach]:
    """Return the reach of every term of every noise test, with the reasons of their rows."""
    found = []
    reasons = {
        (row["test"], row["axis"], row["quantity"]): Text(reason_text(row)) for row in rows if case_of(row).plain
    }
    for curve in curves:
        if curve["name"] != "record_length":
            continue
        columns = curve["columns"]
        keys = ("term", "relative_error", "wanted", "record", "needed")
        for term, known, wanted, record, needed in zip(*(columns[key]["values"] for key in keys), strict=True):
            unit, time = (str(columns[key]["unit"]) for key in ("relative_error", "record"))
            reason = reasons.get((curve["test"], curve["axis"], term), "")
            found.append(Reach(curve["test"], curve["axis"], term, known, wanted, unit, record, needed, time, reason))
    return found


def by_test(reaches: Iterable[Reach]) -> list[list[Reach]]:
    """Return them by test, in order of first appearance."""
    found: dict[str, list[Reach]] = {}
    for one in reaches:
        found.setdefault(one.test, []).append(one)
    return list(found.values())


def explained(reaches: Iterable[Reach]) -> set[tuple[str, str, str]]:
    """Return test, axis and quantity of each: the noise section gives their reason."""
    return {(one.test, one.axis, one.term) for one in reaches}


def finding(reaches: Sequence[Reach]) -> Finding:
    """Say which term is least well determined, and how many were not detected."""
    found = [(one, one.known, one.wanted) for one in reaches if one.known is not None and one.wanted is not None]
    missing = len(reaches) - len(found)
    lost = f"; {count(missing)} of {counted(len(reaches), 'term')} not detected" if missing else ""
    if not found:
        return (f"None of {counted(len(reaches), 'term')} detected",)
    poor = [(one, known, wanted) for one, known, wanted in found if not one.enough and not one.reason]
    doubtful = next((one for one, _, _ in found if one.reason), None)
    if poor:
        one, known, wanted = max(poor, key=lambda each: each[1].raw)
        term = words(one.term).capitalize()
        said: Finding = (term, " of ", *_where(one, reaches), ": uncertainty ", Figure(known, None, one.unit))
        if one.longer and one.needed is not None:
            needed = Length(one.needed, one.time)
            said = (*said, "; a recording of ", needed, " would give ", Figure(wanted, None, one.unit))
        return (*said, lost)
    if doubtful is not None:
        term = words(doubtful.term).capitalize()
        return (term, " of ", *_where(doubtful, reaches), ": ", doubtful.reason, lost)
    one, _, wanted = found[0]
    start = f"{counted(len(found), 'term').capitalize()} known to "
    return (start, Figure(wanted, None, one.unit), " or better", lost)


def _where(reach: Reach, reaches: Sequence[Reach]) -> Finding:
    """Say of which axis, and of which test where there are several."""
    several = len({str(one.test) for one in reaches}) > 1
    return (reach.axis, " in ", reach.test) if several else (reach.axis,)
