"""Remarks: what a user should know about usable but suspicious data.

A remark travels in results and report. The same finding at many places is one remark with a count:
182 skipped saves are one line.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from typing import Literal

from .errors import Problem

Severity = Literal["info", "warning", "error"]
OF_PROGRAMS = ("axis", "subject", "index", "recording")  # fields that results.json does not hold


@dataclass(frozen=True)
class Remark:
    """One finding."""

    code: str  # Stable word: ``"few_runs"``
    severity: Severity  # How much it matters
    what: str  # The finding, with its figures
    where: str = ""  # ``file:row`` or time of the first place
    count: int = 1  # At how many places
    do: str = ""  # What to do about it
    axis: str = ""  # That it is about
    subject: str = ""  # What it is about, as a name: a column, a sensor
    index: int = 0  # Number of the first sample or row that it is about
    recording: str = ""  # That it is about, as the campaign calls it

    def __str__(self) -> str:
        """One line, the severity first."""
        times = f" ({self.count} x)" if self.count > 1 else ""
        place = f"{self.where}: " if self.where else ""
        text = f"{self.severity}: {place}{self.what}{times}"
        return f"{text}. {self.do}" if self.do else text

    def to_dict(self) -> dict[str, str | int]:
        """Return the parts as plain values, for ``results.json``: those that people read."""
        return {name: value for name, value in asdict(self).items() if name not in OF_PROGRAMS}

    @property
    def problem(self) -> Problem:
        """The same as a reason to refuse."""
        return Problem(self.what, self.where, do=self.do, code=self.code)

    def at(self, where: str) -> Remark:
        """Return the same remark, placed in front of its own place."""
        return replace(self, where=f"{where}: {self.where}" if self.where else where)


def is_placed(where: str, place: str) -> bool:
    """Tell whether the place of a remark is one, or inside it: as ``Remark.at`` puts it in front."""
    return where == place or where.startswith(f"{place}: ")


FEW = 3  # different texts of one kind that are listed one by one
NAMED = 12  # recordings that a line names


def condensed(remarks: Iterable[Remark]) -> tuple[Remark, ...]:
    """Return the remarks gathered, and those of one code and severity with many texts as one line.

    The line has the text of the first, says how many more there are and in which recordings; the count is that of all.
    Errors are never joined.
    """
    kinds: dict[tuple[str, str], list[Remark]] = {}
    for remark in gather(remarks):
        kinds.setdefault((remark.code, remark.severity), []).append(remark)
    found = []
    for alike in kinds.values():
        if len(alike) <= FEW or alike[0].severity == "error":
            found += alike
            continue
        names = list(dict.fromkeys(remark.recording for remark in alike if remark.recording))
        some = ", ".join([*names[:NAMED], *["..."] * (len(names) > NAMED)])
        what = f"{alike[0].what}; and the like at {len(alike) - 1} other places{f' ({some})' * (len(names) > 1)}"
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
