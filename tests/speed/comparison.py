"""A line of the table of speed: one product, one peer, the goal, and how both are timed.

A line is a function that makes the inputs, checks that the results of both agree, and returns the two calls::

    @line("sine fit, 1e6 samples", peer="scipy cubic", goal=1.0)
    def sine() -> Work:
        x = ...
        return Work(own=lambda: ic.sine(x), peer=lambda: cubic(x), moved=x.nbytes)

It stands in a module of ``speed.lines``, and needs no other entry. Both take turns in one process, so that all meet the
same load; wall time counts, as it is what a user waits for, or the time of the processor, where others use the machine.
The ratio is that of the medians; that of the shortest times stands beside it, and is what a machine without other work
would show. A peer that is a number is a time that is allowed [s], or, where ``own`` returns what it is measured by
(``unit`` other than seconds), the amount that is allowed.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from pkgutil import iter_modules
from statistics import median
from typing import Any

import numpy as np

FEWEST, MOST = 3, 25  # rounds
ENOUGH = 6.0  # time from which a line has no more rounds than the fewest [s]
BANDWIDTH_OF = 2**25  # numbers that are read: 256 MB, far beyond any cache of a core


@dataclass(frozen=True, eq=False)
class Work:
    """What a line compares; both calls are warm: compiled, inputs in memory."""

    own: Callable[[], Any]
    peer: Callable[[], Any] | float  # or what is allowed
    moved: int = 0  # bytes that must be read or written at least, by any program; 0: not told
    unit: str = "s"  # "s": ``own`` is timed; else ``own`` returns the amount
    rest: Callable[[], object] = lambda: None  # done after ``own``, not timed: what it left to threads


@dataclass(frozen=True)
class Line:
    """A line of the table."""

    name: str
    peer: str
    goal: float  # least ratio: of the peer over the product; 0: none, the line is watched alone
    build: Callable[[], Work]


@dataclass(frozen=True)
class Measured:
    """What a line came to."""

    line: Line
    own: float  # median [s, or the unit of the line]
    peer: float
    ratio: float  # of the medians
    best: float  # of the shortest
    limit: float  # ratio that a program would have which does nothing but read what must be read; infinite: not told
    unit: str = "s"


LINES: dict[str, Line] = {}


def line(name: str, peer: str, goal: float) -> Callable[[Callable[[], Work]], Callable[[], Work]]:
    """Enter a function as a line of the table."""

    def enter(build: Callable[[], Work]) -> Callable[[], Work]:
        if name in LINES:
            raise ValueError(f"two lines of the name {name!r}")
        LINES[name] = Line(name, peer, goal, build)
        return build

    return enter


def every_line() -> dict[str, Line]:
    """Return all lines, those of each module of ``speed.lines``, by name."""
    package = import_module("speed.lines")
    for module in sorted(one.name for one in iter_modules(package.__path__)):
        import_module(f"speed.lines.{module}")
    return LINES


def seconds(action: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> float:
    """Return the time that a call takes [s]."""
    started = clock()
    action()
    return clock() - started


def bandwidth() -> float:
    """Return how fast memory is read by all cores [bytes/s]: the dot product of a long array with itself."""
    x = np.ones(BANDWIDTH_OF)
    return x.nbytes / min(seconds(lambda: x @ x) for _ in range(5))


def measured(entry: Line, speed: float, clock: Callable[[], float] = time.perf_counter) -> Measured:
    """Measure a line by a clock [s], where memory is read at a speed [bytes/s]."""
    work = entry.build()
    own, peer = zip(*_rounds(work, clock), strict=True)
    of_peer = median(peer)
    limit = of_peer / (work.moved / speed) if work.moved and work.unit == "s" else np.inf
    return Measured(entry, median(own), of_peer, of_peer / median(own), min(peer) / min(own), float(limit), work.unit)


def _rounds(work: Work, clock: Callable[[], float]) -> Iterator[tuple[float, float]]:
    """Yield what product and peer take, in turn."""
    spent, done = 0.0, 0
    while done < FEWEST or (done < MOST and spent < ENOUGH):
        own = seconds(work.own, clock) if work.unit == "s" else float(work.own())
        work.rest()
        peer = seconds(work.peer, clock) if callable(work.peer) else work.peer
        yield own, peer
        done += 1
        spent += own + (peer if callable(work.peer) else 0.0)
