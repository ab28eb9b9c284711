"""How the clock of an instrument runs against that of the computer: offset and drift, from when its rows came.

A row comes after it was made, by a delay that is never negative::

    host_i = offset + (1 + drift) device_i + delay_i,   delay_i >= 0

Delays are neither alike nor independent: a busy computer, bursts and buffers that fill make them long for a while. What
bears on the clocks is their lower edge. Of each of up to `MOST` blocks of equal length the lower convex hull is kept,
which holds the earliest arrival whatever the drift; the drift decides which that is, and is found again with it. Blocks
are joined to at most `GROUPS` groups, so that a burst which is shorter than a group leaves no trace, and the earliest
arrival of each is taken as::

    apart_k = offset + drift (time_k - middle) + e_k + w_k

where e is scatter without memory and w a random walk, the load that comes and goes slowly, averaged over a group [1]_.
How much of each there is nobody knows: the drift is the mean over ratios of their variances (`RATIOS`), weighted by the
marginal likelihood [2]_. The interval holds that of each ratio that may be (`LIKELY` of the likeliest or more). Groups
that agree make it narrow; groups that disagree in a row, as under a load that wanders, make it wide. A load that is
never negative wanders in steps of changing size: half of n - 2 degrees of freedom are counted.

Arrivals on whole ticks (`TICKS`: frames of USB, batches of a driver) have delays that run through a tick as the clocks
drift, and seem steady until then: the tick is a part of the uncertainty of its own, rectangular at either end.

What arrivals cannot tell is assumed: clocks drift linearly, and no delay grows in proportion to time over the whole
record, as in a buffer that only fills. This would look like a drift. Hence a drift beyond ``within``, which quartz
cannot have, or one that is known no better than a tenth of that, is said and not used: times keep the rate of the
instrument's own clock. Their rate is known to the uncertainty of the drift and to what the computer's own clock may be
off (`COMPUTER`), which no arrival can tell. The offset holds the least delay of the link, which rows that go one way
cannot tell.

Constant memory: when there are too many blocks, two and two become one.

References
----------
.. [1] Working, Econometrica 28 (1960) 916: averages of a random walk. The mean over one step has variance 1/3, and
   1/6 of a step less than the walk at its middle after that.
.. [2] Harville, Biometrika 61 (1974) 383: marginal (restricted) likelihood of variances.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, special

from ...core.estimate import Array, Component, Estimate, P
from ...core.recording import SECOND, ClockRate, Times
from ...core.show.rounding import uncertainty
from ...core.units import convert
from ...files.loggers.rows import RowLayout

MOST, FEWEST, GROUPS = 64, 8, 16  # blocks; groups
FIRST_BLOCK = 0.1  # [s]
POINTS = 32  # of the hull of a block
RATIOS = (0.0, *np.geomspace(1e-2, 1e5, 15).tolist())  # variance of a step of the walk over that of the scatter
LIKELY = 0.05  # of the largest likelihood
RESOLUTION = 1e-9  # of stamps [s]
TICKS = (16_000_000, 15_625_000, 10_000_000, 8_000_000, 4_000_000, 2_000_000, 1_000_000)  # [ns]
FRAME = TICKS[-1]  # of USB [ns]
TOGETHER = 0.5  # mean resultant length of arrivals on a tick
WITHIN = 1e-3  # what a clock may be off where nobody said: ten times the worst quartz
KNOWN = 0.1  # of that: standard uncertainty up to which a drift is used
COMPUTER = 1e-4  # what the clock of a computer may be off that nobody keeps in step: the worst quartz


@dataclass(frozen=True)
class Clocks:
    """Relation of two clocks."""

    estimate: Estimate | None  # ``offset`` [s] at the middle of the record, and ``drift`` [1]; None: not estimated
    reason: str  # Why it is not estimated
    middle: float  # Time of the instrument that the offset is for [s]
    host_ns: int  # Reading of the computer that the offset counts from
    scatter: float  # Of the earliest arrivals about the line [s]
    earliest: float = 0.0  # Least of them, where the drift is not used [s]
    within: float = WITHIN  # What the clock of the instrument may be off [1]

    @property
    def uncertain(self) -> str:
        """Why the drift is not used, in words; empty where it is."""
        if self.estimate is None:
            return ""
        drift, u = float(self.estimate.values[1]), float(self.estimate.u[1])
        if not u <= KNOWN * self.within:
            return f"known no better than {uncertainty(1e6 * u)} ppm (standard uncertainty)"
        if abs(drift) > self.within:
            return f"{1e6 * drift:.5g} ppm, more than the {1e6 * self.within:g} ppm that its clock may be off"
        return ""

    def rate(self, source: str) -> ClockRate:
        """Return how well the rate at which times run is known, of a clock and record of this name."""
        if self.estimate is None or self.uncertain:
            return ClockRate(self.within / math.sqrt(3.0), source=source)
        own, dof = float(self.estimate.u[1]), float(self.estimate.dof[1])
        u = math.hypot(own, COMPUTER / math.sqrt(3.0))
        return ClockRate(u, dof * (u / own) ** 4, source)  # Welch and Satterthwaite: the computer's has no end of them

    def host_time(self, device: Array) -> Times:
        """Return the reading of the computer at times of the instrument [s], shape (n,) [ns, monotonic]."""
        assert self.estimate is not None  # noqa: S101 - the caller has looked
        offset, drift = (self.earliest, 0.0) if self.uncertain else self.estimate.values.tolist()
        elapsed = offset + (1.0 + drift) * (device - self.middle)
        found: Times = self.host_ns + np.rint(elapsed * SECOND).astype(np.int64)
        return found


class OwnTime:
    """Time of an instrument from its rows, in order: its time, or its counter and the interval that was said.

    A counter is followed over the end of its type. ``restarts`` counts how often the time went back.
    """

    def __init__(self, layout: RowLayout) -> None:
        time, counter = layout.role("time"), layout.role("counter")
        self.channel = time or (counter if layout.interval is not None else None)
        self.interval = 1.0 if layout.interval is None or time is not None else layout.interval
        self.restarts = 0
        self._last: float | None = None
        self._raw = 0

    def seconds(self, values: NDArray[Any]) -> Array:
        """Return the time of each row [s], shape (n,), of the values of `channel` in its own unit."""
        assert self.channel is not None  # noqa: S101 - the caller has looked
        if not len(values):
            return np.empty(0)
        if self.channel.role == "time":
            found = convert(np.asarray(values, float), self.channel.unit, "s")
        else:
            found = self._unwrapped(values)
        self.restarts += int(np.sum(np.diff(found, prepend=found[0] if self._last is None else self._last) < 0))
        self._last = float(found[-1])
        return found

    def _unwrapped(self, values: NDArray[Any]) -> Array:
        size = np.dtype(self.channel.type).itemsize if self.channel is not None else 8
        raw = values.astype(np.int64)
        if self._last is None:
            self._raw, before = int(raw[0]), float(raw[0]) * self.interval
        else:
            before = self._last
        steps = np.diff(raw, prepend=self._raw)
        steps = steps % 2 ** (8 * size) if size <= 2 else steps
        self._raw = int(raw[-1])
        found: Array = before + np.cumsum(steps) * self.interval
        return found


class Relation:
    """What is kept of two clocks while rows come.

    Parameters
    ----------
    within : float
        What the clock of the instrument may be off, relative [1].
    """

    def __init__(self, within: float = WITHIN) -> None:
        self._within = within
        self._origin: tuple[float, int] | None = None  # Time of the instrument [s], reading of the computer [ns]
        self._length = FIRST_BLOCK
        self._blocks: dict[int, tuple[Array, int]] = {}  # by number: hull, shape (points, 2) [s], and rows
        self._count = 0
        self._phases = np.zeros((2, len(TICKS)), np.complex128)  # of arrivals and of the instrument's times, summed

    def add(self, device: Array, host_ns: Times) -> None:
        """Add the last row of each lot: time of the instrument [s], and when it had come [ns, monotonic]."""
        if not len(device):
            return
        if self._origin is None:
            self._origin = (float(device[0]), int(host_ns[0]))
        elapsed = np.asarray(device, float) - self._origin[0]
        since = host_ns - self._origin[1]
        apart = since / SECOND - elapsed
        self._count += len(elapsed)
        for k, tick in enumerate(TICKS):
            turns = np.stack([since % tick / tick, elapsed * SECOND / tick])
            self._phases[:, k] += np.exp(2j * np.pi * turns).sum(axis=1)
        while np.max(np.abs(elapsed)) / self._length >= MOST:
            self._merge()
        numbers = np.floor(elapsed / self._length).astype(np.int64)
        for number in np.unique(numbers).tolist():
            own = np.flatnonzero(numbers == number)
            self._put(number, np.column_stack([elapsed[own], apart[own]]), len(own))

    def _put(self, number: int, points: Array, rows: int) -> None:
        if number in self._blocks:
            kept, before = self._blocks[number]
            points, rows = np.concatenate([kept, points]), before + rows
        self._blocks[number] = (_hull(points), rows)

    def _merge(self) -> None:
        self._length *= 2.0
        blocks, self._blocks = self._blocks, {}
        for number, block in blocks.items():
            self._put(number // 2, *block)

    def found(self) -> Clocks:
        """Return what is known now."""
        groups = self._groups()
        usual = float(np.median([rows for _, _, rows in groups])) if groups else 0.0
        kept = [one for one in groups if 2 * one[2] >= usual]  # one that has just begun is no minimum
        if self._origin is None or len(kept) < FEWEST:
            span = f"{len(kept)} blocks of {self._length:g} s, need {FEWEST}"
            return Clocks(None, f"too short a record: {span}", 0.0, 0, 0.0)
        number = np.array([one[0] for one in kept])
        at, apart = _earliest([hull for _, hull, _ in kept])
        middle = float(np.mean(at))
        values, u, scatter = _line(number - number[0], at - middle, apart)
        observed = Component("scatter of the earliest arrivals", "A", np.diag(u**2), 0.5 * (len(at) - 2))
        tick = self._tick()
        ends = np.array([tick / math.sqrt(12.0), tick / math.sqrt(6.0) / float(np.ptp(at))])  # at both: independent
        parts = [observed, Component("ticks of arrivals", "B", np.diag(ends**2), distribution="rectangular")]
        estimate = Estimate(("offset", "drift"), values, ("s", "1"), tuple(parts if tick else parts[:1]))
        # host = host_0 + (device - device_0) + apart; at the middle: device - device_0 = middle
        host_ns = self._origin[1] + round(middle * SECOND)
        place, earliest = self._origin[0] + middle, float(np.min(apart))
        return Clocks(estimate, "", place, host_ns, scatter, earliest, self._within)

    def _groups(self) -> list[tuple[int, list[Array], int]]:
        """Return groups of blocks in order: number, hulls, rows."""
        numbers = sorted(self._blocks)
        size = -(-(numbers[-1] - numbers[0] + 1) // GROUPS) if numbers else 1
        found: dict[int, tuple[list[Array], int]] = {}
        for number in numbers:
            hull, rows = self._blocks[number]
            hulls, before = found.get((number - numbers[0]) // size, ([], 0))
            found[(number - numbers[0]) // size] = ([*hulls, hull], before + rows)
        return [(number, hulls, rows) for number, (hulls, rows) in found.items()]

    def _tick(self) -> float:
        """Return the tick that arrivals come on [s]; 0: none."""
        came, made = np.abs(self._phases) / self._count >= TOGETHER
        for tick, arrivals, own in zip(TICKS, came, made, strict=True):
            if arrivals and (tick == FRAME or not own):  # rows that are made every 10 ms may well come so
                return tick / SECOND
        return 0.0


def _hull(points: Array) -> Array:
    """Return the lower convex hull of points (time, value), shape (n, 2), at most `POINTS` of it."""
    points = points[np.lexsort((points[:, 1], points[:, 0]))]
    if len(points) > 8 * POINTS:  # the least of each short part: the drift does not matter in it
        edges = np.linspace(0, len(points), 4 * POINTS + 1).astype(int)
        least = [first + int(np.argmin(points[first:stop, 1])) for first, stop in pairwise(edges.tolist())]
        points = points[[0, *least, -1]]
    kept: list[tuple[float, float]] = []
    for x, y in points.tolist():
        while len(kept) > 1:
            (x0, y0), (x1, y1) = kept[-2:]
            if (x1 - x0) * (y - y0) > (y1 - y0) * (x - x0):
                break
            kept.pop()
        if not (kept and kept[-1][0] == x):
            kept.append((x, y))
    if len(kept) > POINTS:
        kept = [kept[i] for i in np.linspace(0, len(kept) - 1, POINTS).astype(int)]
    return np.array(kept)


def _earliest(groups: list[list[Array]]) -> tuple[Array, Array]:
    """Return the earliest arrival of each group, by the drift that they have: time and value [s], shape (groups,)."""
    points = [np.concatenate(one) for one in groups]
    drift, before = 0.0, math.inf
    at = apart = np.empty(0)
    for _ in range(8):
        least = [one[np.argmin(one[:, 1] - drift * one[:, 0])] for one in points]
        at, apart = np.array(least).T
        first, second = np.triu_indices(len(at), 1)
        drift, before = float(np.median((apart[second] - apart[first]) / (at[second] - at[first]))), drift
        if drift == before:
            break
    return at, apart


def _line(number: NDArray[np.int64], at: Array, apart: Array) -> tuple[Array, Array, float]:
    """Return offset and drift, standard uncertainties with (n - 2) / 2 degrees of freedom, scatter about the line.

    Parameters
    ----------
    number : ndarray, shape (n,)
        Of each group, from 0; some may be missing.
    at, apart : ndarray, shape (n,)
        Its earliest arrival: time from the middle, and value [s].
    """
    n, dof = len(at), len(at) - 2
    design = np.column_stack([np.ones(n), at])
    plain, *_ = linalg.lstsq(design, apart)
    rest = apart - design @ plain  # coefficients of the rest are added: nothing is lost to rounding
    scatter = math.sqrt(float(rest @ rest) / dof)
    walk = np.minimum.outer(number, number) + 0.5 - np.eye(n) / 6.0
    found = list(_by_ratio(design, rest, walk))
    logs, centres, sizes = (np.array([one[i] for one in found]) for i in range(3))
    weights = np.exp(logs - np.max(logs))
    centre = weights @ centres / np.sum(weights)
    held = weights >= LIKELY  # the interval holds the interval of each ratio that may be
    t = float(special.stdtrit(0.5 * dof, 0.5 * (1.0 + P)))
    u = np.max(np.abs(centres - centre)[held] / t + sizes[held], axis=0)
    return plain + centre, u, scatter


def _by_ratio(design: Array, rest: Array, walk: Array) -> Iterator[tuple[float, Array, Array]]:
    """Yield for each ratio: logarithm of the marginal likelihood, coefficients, their standard uncertainties."""
    n, dof = len(rest), len(rest) - 2
    for ratio in RATIOS:
        root = linalg.cholesky((np.eye(n) + ratio * walk) / (1.0 + ratio), lower=True)
        white = linalg.solve_triangular(root, np.column_stack([design, rest]), lower=True)
        q, r = linalg.qr(white[:, :2], mode="economic")
        own = linalg.solve_triangular(r, q.T @ white[:, 2])
        left = white[:, 2] - white[:, :2] @ own
        square = max(float(left @ left), dof * RESOLUTION**2)
        back = linalg.inv(r)
        log = -np.sum(np.log(np.diag(root))) - np.sum(np.log(np.abs(np.diag(r)))) - 0.5 * dof * math.log(square)
        yield float(log), own, np.sqrt(square / dof * np.sum(back**2, axis=1))
