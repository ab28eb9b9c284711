"""Remarks: what a user should know about usable but suspicious data.

A remark travels in results and report. The same finding at many places is one remark with a count:
182 skipped saves are one line.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from typing import Literal

Severity = Literal["info", "warning", "error"]


@dataclass(frozen=True)
class Remark:
    """One finding.

    Parameters
    ----------
    code : str
        Stable word: ``"few_runs"``.
    severity : {"info", "warning", "error"}
        How much it matters.
    what : str
        The finding, with its figures.
    where : str
        ``file:row`` or time of the first place.
    count : int
        At how many places.
    do : str
        What to do about it.
    """

    code: str
    severity: Severity
    what: str
    where: str = ""
    count: int = 1
    do: str = ""

    def __str__(self) -> str:
        """One line, the severity first."""
        times = f" ({self.count} x)" if self.count > 1 else ""
        place = f"{self.where}: " if self.where else ""
        text = f"{self.severity}: {place}{self.what}{times}"
        return f"{text}. {self.do}" if self.do else text

    def to_dict(self) -> dict[str, str | int]:
        """Return the parts as plain values, for ``results.json``."""
        return asdict(self)

    def at(self, where: str) -> Remark:
        """Return the same remark, placed in front of its own place."""
        return replace(self, where=f"{where}: {self.where}" if self.where else where)


FEW = 3  # different texts of one kind that are listed one by one


def condensed(remarks: Iterable[Remark]) -> tuple[Remark, ...]:
    """Return the remarks gathered, and those of one code and severity with many texts as one line.

    The line has the text of the first and says how many more there are; the count is that of all.
    """
    kinds: dict[tuple[str, str], list[Remark]] = {}
    for remark in gather(remarks):
        kinds.setdefault((remark.code, remark.severity), []).append(remark)
    found = []
    for alike in kinds.values():
        if len(alike) <= FEW:
            found += alike
            continue
        what = f"{alike[0].what}; and the like at {len(alike) - 1} other places"
        found.append(replace(alike[0], what=what, count=sum(remark.count for remark in alike)))
    return tuple(found)


def gather(remarks: Iterable[Remark]) -> tuple[Remark, ...]:
    """Return the remarks with equal findings counted together, in order of first appearance."""
    seen: dict[tuple[str, str, str, str], Remark] = {}
    for remark in remarks:
        key = (remark.code, remark.severity, remark.what, remark.do)
        first = seen.get(key)
        seen[key] = remark if first is None else replace(first, count=first.count + remark.count)
    return tuple(seen.values())
