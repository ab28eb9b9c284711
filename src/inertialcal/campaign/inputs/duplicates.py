"""Duplicates: readings that would count twice, by what they are, whatever their files and names.

Two recordings are one where they share a stretch of samples (``signals.fingerprints``); rows of a table where several
in succession are equal in every reading. Parts of one recording that tests choose by windows or groups are no
duplicates.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, groupby

import numpy as np

from ...core.errors import Problem
from ...core.key import AXES
from ...core.recording import Recording
from ...files.text.table import Table
from ...signals.fingerprints import Fingerprints, alike, fingerprints
from ...signals.time.samples import Flags
from ..file.recordings import RecordingEntry, table_of

CODE = "duplicate_recording"
APPLIED = "applied"  # role of a channel
WHY = "the same readings would count twice"
DO = "Leave one of them out, or name the right file"
ROWS = 4  # that must be equal, one after the other
CHANCE = 1e-4  # that rows of coarse readings are equal
LEAST = 0.05  # share of rows that are equal by chance, at least
COPY = 0.9  # share from which two runs are copies
RUNS = 20  # that are compared to know that share
ALIKE = 8  # equal rows that are looked at


@dataclass(frozen=True, eq=False)
class Content:
    """What a recording, or a table, holds.

    Parameters
    ----------
    name, file : str
        As the campaign calls it.
    samples : Fingerprints or None
        Of a recording.
    table : Table, optional
        Whose rows are readings.
    columns : sequence of str
        Those of its readings.
    run : str
        Its column of runs; empty where it has none.
    """

    name: str
    file: str
    samples: Fingerprints | None = None
    table: Table | None = None
    columns: Sequence[str] = ()
    run: str = ""

    @property
    def has_rows(self) -> bool:
        """Whether there are readings in a table."""
        return self.table is not None and len(self.table) > 0

    @property
    def all_differ(self) -> bool:
        """Whether no two rows are equal, as one column shows."""
        return self.table is not None and any(self.table.all_differ(one) for one in self.columns)

    @property
    def rows(self) -> tuple[tuple[str, ...], ...]:
        """Readings of a table as they are written, run by run."""
        return self._ordered[0]

    @property
    def labels(self) -> tuple[str, ...]:
        """Run of each row, empty where none is named."""
        return self._ordered[1]

    @property
    def places(self) -> tuple[str, ...]:
        """``file:row`` of each row."""
        return self._ordered[2]

    @cached_property
    def _ordered(self) -> tuple[tuple[tuple[str, ...], ...], tuple[str, ...], tuple[str, ...]]:
        table = self.table
        if table is None:
            return (), (), ()
        labels = table.text(self.run) if self.run else ("",) * len(table)
        rows = tuple(zip(*(table.text(one) for one in self.columns), strict=True))
        places = tuple([f"{self.file}:{row}" for row in table.rows.tolist()])
        if len({*labels}) > 1:
            first = {label: number for number, label in reversed(list(enumerate(labels)))}
            order = sorted(range(len(rows)), key=[first[label] for label in labels].__getitem__)
            rows, labels, places = (tuple([one[at] for at in order]) for one in (rows, labels, places))  # type: ignore[assignment]
        return rows, labels, places


def content_of_recording(name: str, entry: RecordingEntry, raw: Recording, chosen: Flags | None) -> Content:
    """Return what a recording holds: its axes as stored, where a test takes them.

    Columns that hold the applied quantity are equal in all recordings; the procedure remarks on them.
    """
    channels = entry.channels or {}
    columns = [raw.channel(channels[axis].column).data for axis in AXES if axis in channels]
    applied = raw.channel(channels[APPLIED].column).data if APPLIED in channels else None
    if applied is not None and any(np.array_equal(column, applied) for column in columns):
        return Content(name, entry.file)
    return Content(name, entry.file, fingerprints(columns, chosen))


def content_of_table(name: str, entry: RecordingEntry, table: Table) -> Content:
    """Return what a table holds: the readings of each row, run by run."""
    said = table_of(entry)
    assert said is not None  # noqa: S101 - it is a table
    key, columns = said
    if key.readings is None:
        return Content(name, entry.file)
    run, readings = key.run(columns) if key.run is not None else None, tuple(key.readings(columns))
    for one in (*((run,) if run else ()), *readings):
        table.index(one)  # raises where it is not there
    return Content(name, entry.file, None, table, readings, run or "")


def duplicates(contents: Sequence[Content]) -> Iterator[Problem]:
    """Yield what the recordings and tables of one test hold twice; a copy once, with the first that it equals."""
    for one in contents:
        yield from _rows_twice(one)
    said: set[int] = set()
    for first, second in pairs(contents):
        if second not in said and (problems := list(between(contents[first], contents[second]))):
            said.add(second)
            yield from problems


def pairs(contents: Sequence[Content]) -> list[tuple[int, int]]:
    """Return the pairs that may hold the same, by number, the lower one first: few, of many recordings."""
    samples = [one.samples for one in contents]
    found = alike(samples) if len(samples) - samples.count(None) > 1 else set()
    found.update(combinations([number for number, one in enumerate(contents) if one.has_rows], 2))
    return sorted(found, key=lambda pair: (pair[1], pair[0]))


def between(one: Content, other: Content) -> Iterator[Problem]:
    """Yield what two recordings, or two tables, of different files share."""
    if one.file == other.file:
        return
    names = f"recordings {one.name} ({one.file}) and {other.name} ({other.file})"
    if one.samples is not None and other.samples is not None:
        shared = one.samples.shared(other.samples)
        if shared is not None:
            whole = shared.samples == one.samples.samples == other.samples.samples
            some = f"{shared.samples} samples, from {shared.first + 1} and {shared.other + 1} on"
            what = f"{names} hold the same {'samples' if whole else some}"
            yield Problem(what, other.file, WHY, DO, CODE)
    elif one.has_rows and other.has_rows:
        found = _longest([*one.rows, *other.rows], len(one.rows))
        if found is not None and _is_copy(found, (*one.rows, *other.rows), ()):
            first, second, length = found
            place = other.places[second - len(one.rows)]
            what = f"{names} hold {length} rows that are equal in every reading, from {one.places[first]} on"
            yield Problem(what, place, WHY, DO, CODE)


def _rows_twice(one: Content) -> Iterator[Problem]:
    found = None if one.all_differ else _longest(one.rows, 0)
    if found is None or not _is_copy(found, one.rows, one.labels):
        return
    first, second, length = found
    labels = one.labels[first], one.labels[second]
    rows = f"{length} rows that are equal in every reading, from {one.places[first]} on"
    if labels[0] != labels[1]:
        what = f"recording {one.name}: runs {labels[0]} and {labels[1]} hold {rows}"
        yield Problem(what, one.places[second], WHY, DO, CODE)
    else:
        what = f"recording {one.name} holds twice {rows}"
        yield Problem(what, one.places[second], WHY, "Remove the copy", "repeated")


def _longest(rows: Sequence[tuple[str, ...]], begin: int) -> tuple[int, int, int] | None:
    """Return the longest stretch of rows that equals an earlier one: the first row of both, and how many.

    Parameters
    ----------
    rows : sequence of tuple of str
        Readings, a row each.
    begin : int
        First row of the second table; 0 where there is one: both stretches may lie in it.
    """
    if len({*rows}) == len(rows):
        return None
    known: dict[tuple[str, ...], list[int]] = {}
    best, before = (0, 0, 0), dict[int, int]()
    for at, row in enumerate(rows):
        here: dict[int, int] = {}
        if any(row):
            earlier = known.setdefault(row, [])
            for same in earlier if at >= begin else ():
                if begin == 0 or same < begin:
                    length = before.get(at - same, 0) + 1
                    here[at - same] = length
                    if min(length, at - same) > best[2]:
                        best = (same - length + 1, at - length + 1, min(length, at - same))
            if len(earlier) < ALIKE:
                earlier.append(at)
        before = here
    return best if best[2] >= ROWS else None


def _is_copy(found: tuple[int, int, int], rows: Sequence[tuple[str, ...]], labels: Sequence[str]) -> bool:
    """Return whether coarse readings do not make rows equal so often by chance."""
    first, _, length = found
    block = rows[first : first + length]
    by_chance = max(LEAST, 1.0 - len(set(block)) / length, _equal_by_chance(rows, labels))
    return bool(by_chance**length * len(rows) < CHANCE)


def _equal_by_chance(rows: Sequence[tuple[str, ...]], labels: Sequence[str]) -> float:
    """Return the share of rows that are equal in two runs, without runs that are copies."""
    by_run = [[row for _, row in own] for _, own in groupby(zip(labels, rows, strict=False), key=lambda pair: pair[0])]
    pairs = list(combinations(by_run[:RUNS], 2))
    shares = [sum(a == b for a, b in zip(*pair, strict=False)) / min(map(len, pair)) for pair in pairs]
    other = [share for share in shares if share < COPY]
    return sum(other) / len(other) if other else 0.0
