"""Columns that run like time and are not used as time: what they say of the record all the same.

Such a column increases by one step nearly everywhere, and its name says nothing. Where it goes back, stands still or
jumps ahead, samples are out of order, doubled or lost, whatever sample rate was given.

Not meant: what wraps round (an angle at 360 deg, a counter at 65536), a table that stops and turns, readings that
drift, codes that repeat. Exceptions of a clock are single steps, and few.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.units import kind
from ..info.describe import Described

FEWEST = 30  # rows
FIRST = 1000  # rows that are looked at before the rest is
REGULAR = 0.25  # largest difference of a regular step from the median step, in median steps
MOST_IRREGULAR = 0.05  # share of other steps
GAP = 1.5  # median steps from which samples are missing
TOGETHER = 2  # irregular steps in a row; a clock has its exceptions one by one
WRAPS = 5  # equal falls that are those of a counter
ROUND = (1.0, 24.0, 60.0, 180.0, 360.0, 400.0, 3600.0, 86400.0, 604800.0, np.pi, 2.0 * np.pi)
ROUNDS = np.array([*ROUND, *(2.0**k for k in range(3, 65))])  # where numbers wrap
DECADES = 10.0 ** np.arange(
    -3, 20
)  # where they wrap too; a single fall by so much may be a short record's second start


@dataclass(frozen=True)
class Irregular:
    """Where a column that runs like time does not."""

    step: float  # Median step, in the unit of the column
    backward: NDArray[np.int64]  # Index of each value that is below the one before it
    repeated: NDArray[np.int64]  # Index of each value that equals the one before it
    gaps: NDArray[np.int64]  # Index of the first value after each gap
    restarts: bool = False  # Whether it goes back to where it began


def unused_clocks(described: Sequence[Described], place: Callable[[int], str]) -> tuple[Remark, ...]:
    """Return a remark for each column that runs like time, is not used as time, and is irregular somewhere.

    Parameters
    ----------
    described : sequence of Described
        Columns that are not the time of the recording.
    place : callable
        Gives ``file:row`` of an index.
    """
    found = []
    for one in described:
        column = one.column
        named = (
            one.quantity not in ("", "time") or bool(one.axis) or (one.unit is not None and kind(one.unit) != "time")
        )
        if named or not column.is_number or not column.is_complete:
            continue
        irregular = irregularities(column.values)
        if irregular is not None:
            whole = one.unit is None and bool(np.all(column.values == np.rint(column.values)))
            found.append(_remark(one.name, irregular, place, whole))
    return tuple(found)


@np.errstate(over="ignore", invalid="ignore")  # values near the end of float64
def irregularities(values: NDArray[np.generic]) -> Irregular | None:
    """Return where a column that runs like time does not; None where it does not run like time, or always does."""
    if len(values) < FEWEST or not _runs(values[:FIRST].astype(np.float64)):
        return None
    numbers = values.astype(np.float64)
    steps = np.diff(numbers)
    median = float(np.median(steps))
    odd = np.flatnonzero(np.abs(steps - median) > REGULAR * median)
    if not len(odd) or not _runs(numbers):
        return None
    begins = np.flatnonzero(np.diff(odd, prepend=-2) > 1)
    lengths = np.diff(begins, append=len(odd))
    if lengths.max() > TOGETHER:
        return None
    pairs = odd[begins[lengths == 2]]
    glitches = pairs[
        (np.abs(steps[pairs] + steps[pairs + 1] - 2.0 * median) <= REGULAR * median) & (steps[pairs] != 0.0)
    ]
    odd = np.setdiff1d(odd, np.concatenate((glitches, glitches + 1)), assume_unique=True)  # one value out of line
    backward = odd[steps[odd] < 0.0]
    if len(backward) and _wraps(median - steps[backward], median):
        return None
    repeated = odd[steps[odd] == 0.0] + 1
    gaps = odd[steps[odd] >= GAP * median] + 1
    restarts = bool(len(backward)) and bool(np.any(np.abs(numbers[backward + 1] - numbers[0]) <= 2.0 * median))
    if len(backward) + len(repeated) + len(gaps) == 0:
        return None
    return Irregular(median, backward + 1, repeated, gaps, restarts)


def _runs(numbers: Array) -> bool:
    """Whether numbers increase by one step nearly everywhere."""
    steps = np.diff(numbers)
    median = float(np.median(steps))
    return median > 0.0 and bool(np.mean(np.abs(steps - median) > REGULAR * median) <= MOST_IRREGULAR)


def _wraps(sizes: Array, step: float) -> bool:
    """Whether falls are all those of a number that wraps round: at a round number, or always at the same."""
    rounds = ROUNDS if len(sizes) == 1 else np.append(ROUNDS, DECADES)
    is_round = bool(np.any(np.abs(rounds - sizes.mean()) <= 0.5 * step))
    return bool(np.ptp(sizes) <= step) and (len(sizes) >= WRAPS or is_round)


def _remark(name: str, found: Irregular, place: Callable[[int], str], whole: bool) -> Remark:
    runs = f"{name!r} runs like time, by {number(found.step)} a row, and is not used as time"
    unit = f" --unit {shlex.quote(name)}=UNIT" if whole else ""
    do = f"If it is time: --time-column {shlex.quote(name)}{unit}, or clock = {{ column = ... }} in campaign.toml"
    said = {
        "goes back": found.backward,
        "jumps ahead": found.gaps,
        "repeats its value": found.repeated,
    }
    where = found.backward if len(found.backward) else np.sort(np.concatenate((found.gaps, found.repeated)))
    what = f"{runs}: " + ", ".join(f"{what} ({len(at)} x)" for what, at in said.items() if len(at))
    if found.restarts:
        what += ", to its beginning: a second recording in the same file?"
    first = int(where[0])
    code = "time_backwards" if len(found.backward) else "stamps_not_used"
    return Remark(code, "warning", what, place(first), do=do, subject=name, index=first)
