"""Flips of the rig, from its readings to what the procedure says of them: many at once, on all processors."""

from __future__ import annotations

import math
import multiprocessing
import os
import time
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from inertialcal.core.influence import Influence
from inertialcal.core.key import AXES
from inertialcal.core.recording import SECOND, Channel, Recording
from inertialcal.procedures.flip.dwells.quiet import Window
from inertialcal.procedures.flip.dwells.recordings import FlipRecording, readings_from
from inertialcal.procedures.flip.plan import Plan
from inertialcal.procedures.flip.reduction import Result, reduce
from inertialcal.rigs.sams_tsh.campaign import windows
from inertialcal.rigs.sams_tsh.record import Record, reduced, reduced_bench
from inertialcal.rigs.sams_tsh.setup import Bench
from inertialcal.statistics.intervals import contains, t_interval


@dataclass(frozen=True)
class Turning:
    """When each turn begins [s] and the angle that it ends at [deg]; for how long the robot arm moves [s], if it does.

    ``standards``: whether errors of the standards are drawn, and stated.
    """

    starts: tuple[float, ...] = (1200.0, 2400.0)
    angles: tuple[float, ...] = (180.0, 0.0)
    arm: float = 0.0
    standards: bool = False

    @property
    def bench(self) -> Bench:
        """The rig as it stands."""
        return reduced_bench(0.0, self.starts, self.angles, None, self._stated)

    @property
    def plan(self) -> Plan:
        """What the procedure is told."""
        return Plan(settle=self.bench.settle, standards=self._stated)

    @property
    def _stated(self) -> dict[str, Influence]:
        return dict(Bench().standards) if self.standards else {}

    def record(self, seed: int, corner: float) -> Record:
        """Return one record and its truth."""
        return reduced(
            seed, corner, turn_starts=self.starts, positions_deg=self.angles, arm=self.moving(seed),
            standards=self._stated,
        )  # fmt: skip

    def moving(self, seed: int) -> tuple[float, float] | None:
        """Return when the robot arm moves [s]: all of it inside a window, anywhere in it; None where it does not."""
        if not self.arm:
            return None
        rng = np.random.default_rng(1000 + seed)
        begin, end, _ = windows(self.bench)[int(rng.integers(len(windows(self.bench))))]
        start = float(rng.uniform(begin + self.bench.settle, end - self.arm))
        return start, start + self.arm


THERE_AND_BACK = Turning()
ONE_WAY = Turning((1800.0,), (180.0,))


@dataclass(frozen=True)
class Tally:
    """What so many flips said: intervals that hold the truth, by name, remarks by code, processor time [s]."""

    n: int = 0
    hits: Counter[str] = field(default_factory=Counter[str])
    remarks: Counter[str] = field(default_factory=Counter[str])
    seconds: float = 0.0

    def __add__(self, other: Tally) -> Tally:
        """Return both together."""
        return Tally(
            self.n + other.n, self.hits + other.hits, self.remarks + other.remarks, self.seconds + other.seconds
        )


def recording_of(made: Record, bench: Bench) -> Recording:
    """Return the readings of a record."""
    channels = tuple(Channel(axis, made.readings[:, i], "m/s^2", axis=axis) for i, axis in enumerate(AXES))
    stamps = np.rint(made.seconds * SECOND).astype(np.int64)
    return Recording(channels, stamps, 1.0 / bench.rate, epoch="utc")


def found_by(turning: Turning, made: Record) -> Result:
    """Return what the procedure finds in a record whose windows are stated as the rig's campaign states them."""
    bench = turning.bench
    said = [(round(a * SECOND), round(b * SECOND), math.radians(angle)) for a, b, angle in windows(bench)]
    given = tuple(Window(start, stop, angle) for start, stop, angle in said)
    plan = turning.plan
    return reduce(plan, readings_from(plan, [FlipRecording(recording_of(made, bench), given)]))


def one_flip(turning: Turning, corner: float, seed: int) -> Tally:
    """Return what one flip says."""
    begin = time.process_time()
    made = turning.record(seed, corner)
    result = found_by(turning, made)
    codes = {one.code for one in result.remarks}
    return Tally(1, held(result, made), Counter(codes), time.process_time() - begin)


def held(result: Result, made: Record) -> Counter[str]:
    """Return which 95 % intervals hold the truth; a count of 0 where one does not."""
    estimate = result.estimate
    assert estimate is not None, result.whole.reason.text
    found: Counter[str] = Counter()
    for name, value, u, dof in zip(estimate.names, estimate.values, estimate.u, estimate.dof, strict=True):
        axis = AXES.index(name[-1])
        bias, ambient = float(made.bias[axis]), float(made.ambient[axis])
        true = {"bias": bias, "ambient_acceleration": ambient, "reading": bias + ambient, "control_error": 0.0}
        found[name] = int(contains(t_interval(value, u, dof), true[name[:-2]]))
    return found


def flips(turning: Turning, corner: float, seeds: Iterable[int], processes: int = 0) -> Tally:
    """Return what all flips say together; on so many processes, or here."""
    work = partial(one_flip, turning, corner)
    if not processes:
        return sum(map(work, seeds), Tally())
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # a process a core
    with ProcessPoolExecutor(processes, multiprocessing.get_context("spawn")) as pool:
        return sum(pool.map(work, seeds, chunksize=10), Tally())
