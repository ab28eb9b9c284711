"""A planned programme rehearsed: what unit and machine would give, step by step, and the campaign that it belongs to.

Each planner's test has its unit: noise, power-ups and standards are drawn as its settings state them. The steps are
those of the schedule. Values on the way to a step come first, then what is held; a step is as long as its record needs.

The truth is that of the unit: what the campaign finds is scored against it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from ..core.errors import DataError
from ..core.estimate import Array
from ..core.recording import SECOND, Channel, Recording
from ..core.units import factor
from ..files.text.table import Table
from ..rigs.parts.campaign import Content
from ..rigs.twin import TrueValue
from ..sensors.noise.simulate import simulate
from ..sensors.noise.terms import BiasInstability, RandomWalk, RateRandomWalk, Term

Indices = NDArray[np.int64]
Stretch = tuple[int, int, float]  # First and last sample but one, what was told; NaN: it needs no telling
BEGIN = 1_772_323_200  # 2026-03-01 00:00:00 UTC [s]
APART = 200_000  # from power-up to power-up [s]
SPARE = 1.2  # of the time for which something has to be steady, that it is
MORE = 3  # samples beyond what a step needs, where it has to be steady first
PER_DWELL = 50  # samples of the shortest step, or more
MOST = 1_500_000  # samples of all recordings


@dataclass(frozen=True)
class Way:
    """How a machine comes to what it is told.

    Parameters
    ----------
    setting, unit : str
        What it is told, and its unit; empty: nothing.
    steady : float
        Time for which it is looked at before a record begins [s].
    during : bool
        It gets there in the course of the step, evenly; else before it.
    first : float, optional
        Where it begins; by default where the first step of a recording is.
    longest : float
        That it is on its way after it was told: a person has laid the unit by then [s].
    """

    setting: str
    unit: str = ""
    steady: float = 0.0
    during: bool = False
    first: float | None = None
    longest: float = math.inf


@dataclass(frozen=True, eq=False)
class Steps:
    """Steps of one recording, in order, shapes (n,)."""

    name: str
    table: Table
    rows: range
    start: Array  # [s]
    stop: Array
    value: Array  # What is told; NaN: nothing

    def text(self, column: str) -> str:
        """Return what the first of its rows says."""
        return self.table.text(column)[self.rows[0]]


@dataclass(frozen=True, eq=False)
class Course:
    """A recording, sample by sample."""

    interval: float  # [s]
    value: Array  # Where the machine is, shape (n,)
    step: Indices  # Number of the step that a sample belongs to or comes before, shape (n,)
    stretches: tuple[Stretch, ...]

    def __len__(self) -> int:
        return len(self.value)


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """What a programme gives on a simulated unit.

    Parameters
    ----------
    way : Way
        What is told to the machine.
    recordings, stretches : mapping
        By name: all that the logger would save; which samples follow what is told.
    content : mapping
        Tables of campaign.toml: site, standards, sensors, recordings, tests.
    sequence : mapping
        What ``[sequence.schedule]`` needs more.
    truth : tuple of TrueValue
        Of the unit.
    """

    way: Way
    recordings: Mapping[str, Recording]
    stretches: Mapping[str, tuple[Stretch, ...]]
    content: Content
    sequence: Content = field(default_factory=dict[str, object])
    truth: tuple[TrueValue, ...] = ()


def steps_of(table: Table, column: str = "") -> Iterator[Steps]:
    """Yield the steps of a schedule, recording by recording.

    Raises
    ------
    DataError
        ``wrong_value`` if a recording stands in two places, or a step takes no time.
    """
    names = table.text("recording")
    start, stop = table.numbers("start"), table.numbers("stop")
    value = table.numbers(column) if column else np.full(len(table), math.nan)
    if len(bad := np.flatnonzero(~(stop > start))):
        raise DataError("a step that takes no time", table.where(int(bad[0])), do="Correct it", code="wrong_value")
    done: set[str] = set()
    at = 0
    for name, own in groupby(names):
        rows = range(at, at + len(list(own)))
        at = rows.stop
        if name in done:
            what = f"recording {name} stands in two places"
            raise DataError(what, table.where(rows[0]), do="Put its rows together", code="wrong_value")
        done.add(name)
        part = slice(rows.start, rows.stop)
        yield Steps(name, table, rows, start[part], stop[part], value[part])


def interval_of(recordings: Sequence[Steps], wanted: float = 0.0) -> float:
    """Return an interval with enough samples of the shortest step, and not too many of all [s]."""
    least = sum(float(one.stop[-1]) for one in recordings) / MOST
    if wanted:
        return max(wanted, least)
    short = min(float(np.min(one.stop - one.start)) for one in recordings) / PER_DWELL
    size = 10.0 ** math.floor(math.log10(short))
    return max(*(one * size for one in (1.0, 2.0, 5.0) if one * size <= short * (1.0 + 1e-9)), least)


def course_of(steps: Steps, way: Way, interval: float) -> Course:
    """Return where the machine is in a recording: on the way, steady, and for as long as each step records."""
    before = steps.value[0] if way.first is None else way.first
    gap = steps.start - np.concatenate([[0.0], steps.stop[:-1]])
    values: list[Array] = []
    numbers: list[Indices] = []
    stretches: list[Stretch] = []
    first = 0
    for k, (wait, start, stop, value) in enumerate(zip(gap, steps.start, steps.stop, steps.value, strict=True)):
        going = 0 if way.during else max(round(min(float(wait) - way.steady, way.longest) / interval), 0)
        held = math.ceil((stop - start) / interval - 1e-9) + 1
        held += math.ceil(SPARE * way.steady / interval) + MORE if way.steady else 0
        on_way = before + (value - before) * (np.arange(going) + 0.5) / max(going, 1)
        there = before + (value - before) * (np.arange(held) + 0.5) / held if way.during else np.full(held, value)
        values.append(np.concatenate([on_way, there]))
        numbers.append(np.full(going + held, k, dtype=np.int64))
        stretches.append((first, first + going + held, float(value)))
        first, before = first + going + held, float(value)
    return Course(interval, np.concatenate(values), np.concatenate(numbers), tuple(stretches))


def terms_of(white: float, instability: float = 0.0, walk: float = 0.0) -> tuple[Term, ...]:
    """Return the noise of a sensor at rest."""
    found: list[Term] = [RandomWalk(white)] if white else []
    found += [BiasInstability(instability)] if instability else []
    found += [RateRandomWalk(walk)] if walk else []
    return tuple(found)


def noise_of(terms: tuple[Term, ...], course: Course, rng: np.random.Generator) -> Array:
    """Return noise in a recording, shape (n,)."""
    return simulate(terms, len(course), course.interval, rng) if terms else np.zeros(len(course))


def recorded(number: int, course: Course, channels: Mapping[str, tuple[Array, str, str]]) -> Recording:
    """Return a recording, of channels as SI values, SI unit and unit that is saved.

    Stamps are the middles of the samples.
    """
    middle = (np.arange(len(course)) + 0.5) * course.interval
    stamps = (BEGIN + number * APART) * SECOND + np.rint(middle * SECOND).astype(np.int64)
    made = tuple(
        Channel(name, values if si == unit else values * factor(si, unit), unit)
        for name, (values, si, unit) in channels.items()
    )
    return Recording(made, stamps, course.interval, course.interval, epoch="utc")


def entry_of(sensor: str, steps: Steps, interval: float, columns: Mapping[str, str], **more: object) -> Content:
    """Return what a campaign says of a recording; columns: channel -> unit."""
    pace = f"{interval:.9g} s"
    return {
        "sensor": sensor,
        "file": f"recordings/{steps.name}.parquet",
        **more,
        "clock": {"column": "time", "stamp": "middle", "interval": pace, "averaging": pace},
        "channels": {name: {"column": name, "unit": unit} for name, unit in columns.items()},
    }
