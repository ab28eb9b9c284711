"""What changes within a run of a moved mass, told apart from drift: slip, gain, jumps, kinks, single readings.

Each fault has a column of its own: the level or slope from dwell k on, one reading, the drive from dwell k on (gain),
or the drive shifted from dwell k on (slip). The readings are whitened for white noise, a random walk of level or slope,
drift of any size that is smooth over ``LENGTH`` periods of the drive, and a cubic. Restricted likelihood fits the size
of the walk for each column anew, so a jump is not taken for noise, nor strong noise for a jump. A column counts if
twice the logarithm of the likelihood rises by its limit in ``LIMITS``; the limits allow for the number of dwells.

- A slip has as many parameters as the schedule: the readings choose between the two.
- Jumps of the level, kinks of the drift and single false readings are added to the model one after the other, and the
  rest is tried again. A gain also changes the level and the drift that it multiplies: where the level jumps, a score of
  ``NEXT_TO`` is enough.
- Faults at the same dwell of every run are tried on all runs together (`common_change`).

Assumed: a run has few faults. What breaks it: a saw-tooth, or a sine close to the drive, raises the noise, so slips and
gains go unnoticed; a strong random walk does the same; a fault in the last cycle may get the name of another.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from ...core.estimate import Array
from ...physics.motion.schedule import Schedule
from ...signals.sine.drive import applied_drive
from .line import shape_of

Kind = Literal["slip", "gain", "jump", "kink", "reading"]
LENGTH = 1.25  # periods of the drive, over which drift is smooth
DRIFT = 1e8  # variance of that drift over the variance of white noise
DEGREE = 3  # of the polynomial that goes with it
WALKS = (0.0, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0)  # variance of a step of a walk over that of white noise
BENDS = (1e-4, 1e-3, 1e-2, 0.1, 1.0)  # the same, of a step of its slope
SHIFTS = (1.0, -1.0, 2.0, -2.0, 0.5, -0.5)  # dwells, by which the mass may be late
LIMITS: Mapping[Kind, float] = {"slip": 21.0, "gain": 19.0, "jump": 24.0, "reading": 24.0, "kink": 28.0}
COSTS: Mapping[Kind, float] = {"slip": 0.0, "gain": 5.0, "jump": 0.0, "reading": 0.0, "kink": 6.0}  # of a parameter
GAIN_OF_ALL = 14.0  # limit of a gain of all runs: their cycles are few
NEXT_TO = 10.0  # limit of a gain that changes where the level jumps
MOST = 3  # jumps, kinks and readings of a run
FEWEST = 24  # readings
PIECE, OVERLAP = 200, 60  # dwells that are compared at once, and that two such pieces share
ALIKE = 0.8  # correlation from which a drive that is late all the time looks like the schedule, or its opposite
PRESENT = 3.0  # standard uncertainties of a response, whose gain may change
HALF = 0.5  # of the limits: below it at the likeliest walk, the others are not tried
TAIL = 8.0  # medians of a residual, from which faults may hide each other
TINY = 1e-20  # of a sum of squares: rounding
NONE = 1e-6  # part of a column that the rest of the model leaves: less is nothing


@dataclass(frozen=True)
class Change:
    """One fault within a run."""

    kind: Kind  # Which
    at: int  # Dwell that it comes before, or that is false, from 0; 0 for a slip of the whole run
    score: float  # Gain of twice the logarithm of the likelihood
    size: float  # Slip: dwells late; gain: factor; jump or reading: [output unit]; kink: [count/s] a dwell

    def columns(self, n: int) -> Array:
        """Return what it adds to n readings, shape (n, 1), of a kink (n, 2): the slope, then the level."""
        at = np.arange(n)
        if self.kind == "reading":
            return np.asarray((at == self.at)[:, None] * 1.0)
        step = (at >= self.at) * 1.0
        return np.column_stack([step * (at - self.at), step] if self.kind == "kink" else [step])


@dataclass(frozen=True, eq=False)
class Changes:
    """Faults of a run."""

    found: tuple[Change, ...]  # One after the other; nothing more is looked for after a slip or gain
    columns: Array  # shape (n, m): of jumps and kinks
    sizes: Array  # shape (m,) [output unit]
    inflation: float  # Of the variance of the response by the columns that are subtracted

    @property
    def repairable(self) -> bool:
        """Whether all of them can be subtracted."""
        return len(self.found) <= MOST and all(one.kind not in ("slip", "gain") for one in self.found)

    def repaired(self, x: Array) -> Array:
        """Return readings without jumps and kinks, false readings as gaps."""
        x = x - self.columns @ self.sizes
        x[[one.at for one in self.found if one.kind == "reading"]] = np.nan
        return np.asarray(x)


@dataclass(frozen=True, eq=False)
class _Noise:
    """Columns whitened for one size of the walk, polynomial taken off."""

    root: Array  # shape (n, n): Cholesky factor of the covariance of noise and smooth drift
    slow: Array  # shape (n, DEGREE + 1): orthonormal columns of the polynomial
    log_det: float  # Of the covariance and of the polynomial
    dof: float  # Readings less what smooth drift and the polynomial take
    tried: dict[str | float, Array]  # shape (n, n) each: a column a dwell; by the name of the fault, or by the shift
    power: dict[str | float, Array]  # Squared length of each column before the polynomial was taken off

    def white(self, columns: Array) -> Array:
        """Return columns whitened, polynomial taken off."""
        found = linalg.solve_triangular(self.root, columns, lower=True, check_finite=False)
        return np.asarray(found - self.slow @ (self.slow.T @ found))


@lru_cache(maxsize=8)
def _noises(shape: bytes, times: bytes, there: bytes, per_cycle: int) -> tuple[_Noise, ...]:
    """Return the whitened columns for each walk; shape and times [dwells] of all dwells, and which have a reading."""
    s, t, keep = np.frombuffer(shape), np.frombuffer(times), np.frombuffer(there, dtype=np.bool_)
    here = t[keep]
    apart = (here[:, None] - here[None, :]) / (LENGTH * per_cycle)
    smooth = np.eye(len(here)) + DRIFT * np.exp(-0.5 * apart**2)
    walk = np.minimum(here[:, None], here[None, :]) - t[0] + 1.0
    bends = walk**2 * (3.0 * np.maximum(here[:, None], here[None, :]) - 3.0 * t[0] + 3.0 - walk) / 6.0
    polynomial = np.polynomial.legendre.legvander((2.0 * here - t[0] - t[-1]) / (t[-1] - t[0]), DEGREE)
    found = []
    dof = 0.0
    for noise in (*(part * walk for part in WALKS), *(part * bends for part in BENDS)):
        root = linalg.cholesky(smooth + noise, lower=True)
        slow, r = np.linalg.qr(linalg.solve_triangular(root, polynomial, lower=True))
        log_det = 2.0 * float(np.sum(np.log(np.diag(root))) + np.sum(np.log(np.abs(np.diag(r)))))
        readings = np.zeros((len(here), len(s)))  # each dwell alone, whitened; zero for a gap
        readings[:, keep] = linalg.solve_triangular(root, np.eye(len(here)), lower=True)
        jumps = _onward(readings)
        raw: dict[str | float, Array] = {"jump": jumps, "reading": readings, "gain": _onward(readings * s)}
        raw["kink"] = np.column_stack([_onward(jumps)[:, 1:], np.zeros(len(here))])
        raw |= {by: (readings @ s)[:, None] + _onward(readings * (shifted(s, by) - s)) for by in SHIFTS}
        power = {name: np.sum(each**2, axis=0) for name, each in raw.items()}
        tried = {name: each - slow @ (slow.T @ each) for name, each in raw.items()}
        dof = dof or float(np.sum(tried["reading"] ** 2))
        found.append(_Noise(root, slow, log_det, dof, tried, power))
    return tuple(found)


def _onward(columns: Array) -> Array:
    """Return the sum of each column and all after it."""
    return np.asarray(np.cumsum(columns[:, ::-1], axis=1)[:, ::-1])


def shifted(s: Array, by: float) -> Array:
    """Return a drive that is so many dwells late; half a dwell: the mean of two dwells."""
    if by % 1.0:
        return np.asarray(0.5 * (s + shifted(s, 2.0 * by)))
    d = int(by)
    ends = np.full(abs(d), s[0] if d > 0 else s[-1])
    return np.concatenate([ends, s[:-d]] if d > 0 else [s[-d:], ends])


@dataclass(frozen=True, eq=False)
class _Piece:
    """Dwells that are compared at once."""

    begin: int  # First dwell
    reading: Array  # shape (n,); NaN for a gap
    drive: Array  # shape (n, 1 or 2): in phase, and in quadrature if there is one
    times: Array  # shape (n,) [dwells]
    per_cycle: int


def noises_of(piece: _Piece) -> tuple[_Noise, ...]:
    """Return the whitened columns of a piece."""
    s = np.ascontiguousarray(piece.drive[:, 0])
    return _noises(s.tobytes(), piece.times.tobytes(), np.isfinite(piece.reading).tobytes(), piece.per_cycle)


@dataclass(frozen=True, eq=False)
class _Free:
    """Fit of the drive in any phase, with the columns of faults found before, for one walk; all of it whitened."""

    noise: _Noise
    white: Array  # Readings
    known: Array  # Columns of the faults
    base: Array  # The same, orthonormal
    line: Array  # Drive
    drive: Array  # The same without the columns of the faults, orthonormal
    y: Array  # Readings without the columns of the faults
    along: Array  # Share of the drive in them
    log_det: float
    dof: float

    @property
    def rest(self) -> Array:
        """Residuals."""
        return np.asarray(self.y - self.drive @ self.along)

    @property
    def square(self) -> float:
        """Squares of the readings."""
        return float(self.y @ self.y)

    @property
    def free(self) -> float:
        """Squares of the residuals."""
        return max(float(self.rest @ self.rest), TINY * self.square)

    @property
    def value(self) -> float:
        """Twice the logarithm of the likelihood."""
        return -self.log_det - self.dof * float(np.log(max(self.free, 1e-300)))


def _free(noise: _Noise, x: Array, before: Array, drive: Array) -> _Free:
    white, known, line = noise.white(x), noise.white(before), noise.white(drive)
    base, r = np.linalg.qr(known)
    log_det = noise.log_det + 2.0 * float(np.sum(np.log(np.abs(np.diag(r)))))
    y = white - base @ (base.T @ white)
    alone = np.linalg.qr(line - base @ (base.T @ line))[0]
    dof = max(noise.dof - before.shape[1] - 2.0, 1.0)
    return _Free(noise, white, known, base, line, alone, y, alone.T @ y, log_det, dof)


@dataclass(frozen=True, eq=False)
class _Tried:
    """Likelihoods of the faults of one piece, given those found before."""

    best: dict[tuple[str, float], tuple[float, int]]  # by fault and shift: the largest, and its dwell
    # by fault and shift, shape (n,): signed standard score; of a slip its gain of squared signal over noise
    scores: dict[tuple[str, float], Array]
    amplitude: float  # In phase
    sizes: Array  # shape (m,): of the columns of the faults found before
    inflation: float  # Of the variance of the amplitude by these columns
    tail: float  # Largest whitened residual over the median one
    present: float  # Square of the response over its standard uncertainty


def _try(piece: _Piece, before: Array, near: Sequence[int], moved: bool) -> _Tried:  # noqa: C901 - one fit
    """Return the likelihood of each fault at each dwell; ``before``: columns of jumps found at the dwells ``near``."""
    x, s, per = piece.reading, np.ascontiguousarray(piece.drive[:, 0]), piece.per_cycle
    keep = np.isfinite(x)
    n, m, at = len(x), before.shape[1], np.arange(len(x))
    inner = (at >= per) & (at <= n - per)
    close = inner & np.any([np.abs(at - k) <= 1 for k in (*near, -n)], axis=0)
    late = {by: shifted(s, by) for by in SHIFTS}
    unlike = [by for by, other in late.items() if abs(s @ other) < ALIKE * np.sqrt((s @ s) * (other @ other))]
    opposite = [by for by, other in late.items() if s @ other < -ALIKE * np.sqrt((s @ s) * (other @ other))]
    best: dict[tuple[str, float], tuple[float, int]] = {}
    found = None
    fits = [_free(noise, x[keep], before[keep], piece.drive[keep]) for noise in noises_of(piece)]
    for one in sorted(fits, key=lambda each: -each.value):
        noise, base, drive, along, rest = one.noise, one.base, one.drive, one.along, one.rest
        y, dof, square, free = one.y, one.dof, one.square, one.free
        full = np.column_stack([base, drive])

        def unit(name: str, *others: Array, noise: _Noise = noise, full: Array = full) -> Array:
            c = noise.tried[name] - full @ (full.T @ noise.tried[name])
            for other in others:
                c = c - other * np.sum(other * c, axis=0)
            size = np.sum(c**2, axis=0)
            return np.asarray(c / np.sqrt(np.where(size > NONE * noise.power[name], size, np.inf)))

        level = unit("jump")
        t = {"jump": level.T @ rest, "reading": unit("reading").T @ rest, "gain": unit("gain").T @ rest}
        bend = unit("kink", level).T @ rest
        left: list[tuple[str, float, Array, NDArray[np.bool_]]] = [
            ("planned", 0.0, np.full(n, square - float(along[0]) ** 2), at == 0),
            ("free", 0.0, np.full(n, free), at == 0),
            ("jump", 0.0, free - t["jump"] ** 2, keep & (at > 0)), ("reading", 0.0, free - t["reading"] ** 2, keep),
            ("kink", 0.0, free - t["jump"] ** 2 - bend**2, keep & (at > 1) & (at < n - 1)),
        ]  # fmt: skip
        gains = {}
        present = along[0] ** 2 > PRESENT**2 * free / dof
        sign = -1.0 if present and along[0] * (drive[:, 0] @ one.line[:, 0]) < 0.0 else 1.0
        if moved:
            left += [
                ("gain", 0.0, free - t["gain"] ** 2, inner & present),
                ("gain there", 0.0, free - t["gain"] ** 2, close),
            ]
            for by in SHIFTS:
                c = noise.tried[by] - base @ (base.T @ noise.tried[by])
                response = c.T @ y / np.sqrt(np.maximum(np.sum(c**2, axis=0), NONE))
                response = response if by in opposite else np.maximum(sign * response, 0.0)
                left += [("slip", by, square - response**2, at > 0), ("whole", by, square - response**2, at == 0)]
                gains["slip", by] = response**2 - float(along[0]) ** 2
        for name, by, squares, where in left:
            if not where.any() or (name == "whole" and by not in unlike):
                continue
            k = int(np.argmin(np.where(where, squares, np.inf)))
            value = -one.log_det - dof * float(np.log(max(float(squares[k]), TINY * square)))
            if value > best.get((name, by), (-np.inf, 0))[0]:
                best[name, by] = value, k
        if found is None:
            variance, both = free / dof, np.column_stack([one.known, one.line])
            tail = float(np.max(np.abs(rest)) / max(float(np.median(np.abs(rest))), TINY * np.sqrt(square) + TINY))
            inverse = np.asarray(np.linalg.pinv(both))
            inflation = float(np.sum(inverse[m] ** 2) / np.sum(np.linalg.pinv(one.line)[0] ** 2))
            scores = {(name, 0.0): each / np.sqrt(variance) for name, each in t.items()}
            scores |= {key: each / variance for key, each in gains.items()}
            found = _Tried(
                best,
                scores,
                float(inverse[m] @ one.white),
                inverse[:m] @ one.white,
                inflation,
                tail,
                along[0] ** 2 * dof / free,
            )
            if tail < TAIL and _likeliest(found, HALF) is None:
                return found
    assert found is not None  # noqa: S101 - one of the walks is best
    return found


def _likeliest(tried: _Tried, part: float = 1.0) -> Change | None:
    """Return the likeliest fault over part of its limit; its size is that of a slip only."""
    best = tried.best
    free, planned = best["free", 0.0][0], best["planned", 0.0][0]
    found = []
    for kind, limit in LIMITS.items():
        for (name, by), (value, at) in best.items():
            if name == kind:
                score = value - (max(free, planned) if kind == "slip" else free)
                found += [(score - COSTS[kind], Change(kind, at, score, by))] if score > part * limit else []
    if ("gain there", 0.0) in best and (score := best["gain there", 0.0][0] - free) > part * NEXT_TO:
        found.append((score, Change("gain", best["gain there", 0.0][1], score, 0.0)))
    whole = max(((value, by) for (name, by), (value, _) in best.items() if name == "whole"), default=(-np.inf, 0.0))
    late = max(
        ((value, by, at) for (name, by), (value, at) in best.items() if name == "slip"), default=(-np.inf, 0.0, 0)
    )
    if whole[0] - planned > part * LIMITS["slip"]:
        value, by, at = late if late[0] > whole[0] + COSTS["gain"] else (*whole, 0)
        found.append((value - planned, Change("slip", at, value - planned, by)))
    return max(found, key=lambda one: one[0])[1] if found else None


def _together(piece: _Piece, own: Sequence[Change], tried: _Tried, moved: bool) -> list[Change]:
    """Return jumps and readings that hide each other, likely only together; the first of them do if several do."""
    found: list[Change] = []
    total = 0.0
    while len(found) <= MOST:
        free = tried.best["free", 0.0][0]
        score, kind = max((tried.best[kind, 0.0][0] - free, kind) for kind in ("jump", "reading"))
        found.append(Change(kind, tried.best[kind, 0.0][1], score, 0.0))  # type: ignore[arg-type]
        total += score
        if total > len(found) * LIMITS["jump"]:
            return found
        before = np.column_stack([one.columns(len(piece.reading)) for one in (*own, *found)])
        tried = _try(piece, before, (), moved)
    return []


def _pieces(schedule: Schedule, x: Array, overlap: int = OVERLAP) -> Iterator[_Piece]:
    n = len(x)
    count = 1 if n <= PIECE else int(np.ceil((n - overlap) / (PIECE - overlap)))
    drive, times = drive_of(schedule), schedule.middle / schedule.step
    for begin in [round(k * (n - PIECE) / (count - 1)) for k in range(count)] if count > 1 else [0]:
        part = slice(begin, min(begin + PIECE, n))
        own = x[part]
        there = np.isfinite(own)
        if there.sum() >= FEWEST and np.ptp(own[there]) > 0.0 and np.ptp(drive[part][there, 0]) > 0.0:
            yield _Piece(begin, own, drive[part], times[part] - times[begin], schedule.samples_per_cycle)


def drive_of(schedule: Schedule) -> Array:
    """Return the drive of unit amplitude and, if it is a sine that shows one, its quadrature, shape (n, 1 or 2)."""
    drive = applied_drive(schedule.middle, shape_of(schedule), schedule.frequency)
    return np.column_stack([drive.in_phase] if drive.quadrature is None else [drive.in_phase, drive.quadrature])


def changes_of(schedule: Schedule, x: Array, moved: bool = True) -> Changes:
    """Return the faults of a run.

    Parameters
    ----------
    schedule : Schedule
        As planned, n dwells.
    x : ndarray, shape (n,)
        Readings; NaN for a gap.
    moved : bool
        False for a null run: neither slip nor gain.
    """
    n, rest = len(x), np.array(x)
    found: list[Change] = []
    columns, sizes, inflation = np.empty((n, 0)), np.empty(0), 1.0
    for begin in [one.begin for one in _pieces(schedule, x)]:
        for piece in [one for one in _pieces(schedule, rest) if one.begin == begin]:
            own, tried = _of_piece(piece, moved, MOST - len(found))
            shift = [replace(one, at=one.at + begin if one.at or one.kind == "reading" else 0) for one in own]
            found += shift
            level = [one for one in shift if one.kind in ("jump", "kink")]
            if level and len(found) <= MOST:
                widths = [one.columns(1).shape[1] for one in own if one.kind in ("jump", "kink", "reading")]
                kinds = [one.kind for one in own if one.kind in ("jump", "kink", "reading")]
                keep = np.repeat([kind != "reading" for kind in kinds], widths)
                more, size = np.column_stack([one.columns(n) for one in level]), tried.sizes[: len(keep)][keep]
                columns, sizes = np.column_stack([columns, more]), np.concatenate([sizes, size])
                inflation *= tried.inflation
                rest = rest - more @ size
            rest[[one.at for one in shift if one.kind == "reading"]] = np.nan
        if len(found) > MOST or any(one.kind in ("slip", "gain") for one in found):
            break
    return Changes(tuple(found), columns, sizes, inflation)


def _of_piece(piece: _Piece, moved: bool, room: int) -> tuple[list[Change], _Tried]:
    """Return the faults of a piece, and the last fit with the columns of all of them; ``room``: for how many."""
    n = len(piece.reading)
    own: list[Change] = []
    tried = _try(piece, np.empty((n, 0)), (), moved)
    while len(own) <= room:
        change = _likeliest(tried)
        more = [change] if change is not None else []
        if change is None and tried.tail > TAIL:
            more = _together(piece, own, tried, moved)
        own += more
        if not more or own[-1].kind == "slip":
            break
        before = np.column_stack([one.columns(n) for one in own])
        if own[-1].kind == "gain":
            turned = (np.arange(n) >= own[-1].at) * piece.drive[:, 0]
            tried = _try(piece, np.column_stack([before[:, :-1], turned]), (), moved=False)
            own[-1] = replace(own[-1], size=1.0 + float(tried.sizes[-1]) / tried.amplitude)
            break
        tried = _try(piece, before, [one.at for one in own if one.kind != "reading"], moved)
    at = 0
    for k, one in enumerate(own):
        if one.kind not in ("slip", "gain"):
            own[k] = replace(one, size=float(tried.sizes[at]))
            at += one.columns(1).shape[1]
    return own, tried


@dataclass(frozen=True)
class Regression:
    """Coefficient of one series in another, apart from drive and drift."""

    value: float  # [output unit over unit of the other]
    u: float  # Its standard uncertainty
    reverse: float  # The same if all that it leaves of the readings comes from noise of the other


def regression(schedule: Schedule, x: Array, other: Array) -> Regression | None:
    """Return the coefficient of a series in the readings; None if drive and drift leave nothing of it."""
    xx = xy = yy = dof = 0.0
    for piece in _pieces(schedule, np.where(np.isfinite(other), x, np.nan), overlap=0):
        keep = np.isfinite(piece.reading)
        y = other[piece.begin : piece.begin + len(keep)][keep, None]
        fits = [_free(noise, piece.reading[keep], y, piece.drive[keep]) for noise in noises_of(piece)]
        one = max(fits, key=lambda each: each.value)
        line = np.linalg.qr(one.line)[0]
        a, b = (v - line @ (line.T @ v) for v in (one.white, one.known[:, 0]))
        xx, xy, yy, dof = xx + float(a @ a), xy + float(a @ b), yy + float(b @ b), dof + one.dof
    if not (yy > 0.0 and xy != 0.0):
        return None
    left = max(xx - xy**2 / yy, 0.0)
    return Regression(xy / yy, float(np.sqrt(left / max(dof, 1.0) / yy)), xx / xy)


def common_change(
    runs: Sequence[tuple[Schedule, Array]], near: Sequence[int] = (), free: float | None = None
) -> Change | None:
    """Return a jump, a gain or a slip at the same dwell of several runs of n dwells; None if there is none.

    Parameters
    ----------
    runs : sequence of (Schedule, ndarray of shape (n,))
        With the mass moved; readings without the faults of single runs.
    near : sequence of int
        Dwells where the level of single runs jumps: a gain that changes there has the lower limit.
    free : float, optional
        Runs that are independent, if not all: one fewer after the mean of all of them was subtracted from each.
    """
    pieces = [list(_pieces(schedule, x)) for schedule, x in runs]
    if len(runs) < 2 or len({len(x) for _, x in runs}) > 1 or len({len(each) for each in pieces}) > 1:
        return None
    best: Change | None = None
    for same in zip(*pieces, strict=True):
        tried = [_try(piece, np.empty((len(piece.reading), 0)), (), moved=True) for piece in same]
        per, n, r = same[0].per_cycle, len(same[0].reading), float(len(same))
        inner = np.arange(n)
        for kind, by in tried[0].scores:
            # the same mean subtracted from all: noise r / free times as large in their sum, by their own
            share = 1.0 if free is None else free / r
            each = np.array([one.scores[kind, by] for one in tried]) * (share if kind == "slip" else np.sqrt(share))
            if kind == "slip":
                score, where = each.sum(axis=0), inner > 0
            else:
                signs = np.array([np.sign(one.amplitude) if kind == "gain" else 1.0 for one in tried])
                score = (signs @ each) ** 2 / r
                present = float(np.mean([one.present for one in tried])) > PRESENT**2
                where = (inner >= per) & (inner <= n - per) & present if kind == "gain" else inner > 0
            k = int(np.argmax(np.where(where, score, -np.inf)))
            limit = LIMITS[kind] if kind != "gain" else GAIN_OF_ALL  # type: ignore[index]
            if kind == "gain" and near:
                at = np.flatnonzero(where & np.any([np.abs(inner + same[0].begin - j) <= 1 for j in near], axis=0))
                if len(at) and score[at].max() > NEXT_TO and score[k] <= limit:
                    k, limit = int(at[np.argmax(score[at])]), NEXT_TO
            if score[k] > limit and (best is None or score[k] - COSTS[kind] > best.score - COSTS[best.kind]):  # type: ignore[index]
                best = Change(kind, k + same[0].begin, float(score[k]), by)  # type: ignore[arg-type]
    return best
