"""Changes of unit, sign, scale or axis inside a record: where another file, setting or sensor begins.

All channels of a triad are looked at together. Three kinds of evidence are used, and each has to agree with the others:

- *Levels.* Before and after a jump from one sample to the next, a straight line is fitted to as many samples as it fits
  (8 to 2048). A change of sign takes every level m to -m, a change of unit to f m, an exchange of axes to the level of
  another channel; no motion does that to all channels at once, within the noise of the lines.
- *Noise.* A change of unit multiplies the noise of every channel by one factor, which is that of two units. So it shows
  in records without a level, too.
- *Response.* Where the applied quantity was recorded, the slope of each channel against it is fitted before and after.

A record may move: what is judged is a jump in one sample between two smooth stretches, which is rare, and only then
whether it is one of these. Jumps that come again are motion, or a sensor that switches between two levels.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import permutations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.remarks import Remark
from ..time.samples import Flags, Indices

FEWEST = 48  # samples of a record that is judged
MOST = 400_000  # samples that are looked at; a longer record is averaged down to so many
BLOCKS = 400  # of which the noise is taken
BLOCK = 8  # fewest samples of a block
SIDE = 8, 2048  # samples, fewest and most, of a line before and after a jump
TIGHT = 4.5  # standard deviations within which levels agree
CLEAR = 15.0  # standard deviations from which a jump is one
RELATIVE = 0.02  # of a jump: what levels may differ by besides
OFFSET = 0.3  # of a jump: what one of three axes may be off by, where the other two agree
EXACT = 0.002  # the same of a change of sign, which nothing else makes
FITS = 3.5  # over the square root of samples: by how much more than white noise they may scatter about a line
BENT = 3.5  # standard deviations of a curvature, up to which a line fits
PATIENCE = 2  # lengths in a row that do not fit
NEAR = 64  # samples that tell the noise of the shortest lines
ABRUPT = 2.0  # times the largest step among the neighbours
SAME_NOISE = 0.35  # of the logarithm of a factor
NEIGHBOURS = 4
CANDIDATES = 12
SMOOTH = 0.5  # of a jump: steps as large elsewhere are motion
ALONE = 1, 2, 4, 16, 64  # samples whose means are compared for that
NOISE_AGREES = 0.08  # of the logarithm of a factor of noise, besides its scatter
LEAST_NOISE = np.log(3.0)  # least change of the noise that can be a unit
STARTED = 35.0  # [rad/s^2], 2,000 deg/s^2: a table may start so fast, and one sample to the next is a jump then
TURNED_WITHIN = 0.045  # [s]: nobody lays an accelerometer on another side so fast; slower samples may miss the turn

LATE = 1.5  # intervals from one stamp to the next, from which a sample is missing

DEG = 180.0 / np.pi
Factors = Mapping[float, tuple[str, str]]
FACTORS: Mapping[str, Factors] = {  # what a change of unit multiplies by: (before, after)
    "angular_rate": {
        DEG: ("rad/s", "deg/s"), 3600.0: ("deg/s", "deg/h"), DEG * 3600.0: ("rad/s", "deg/h"),
        1e3: ("a unit", "its thousandth"), DEG * 1e3: ("rad/s", "mdeg/s"), 1e6: ("a unit", "its millionth"),
    },
    "acceleration": {
        9.80665: ("g", "m/s^2"), 1e3: ("a unit", "its thousandth"), 1e6: ("a unit", "its millionth"),
        1e3 / 9.80665: ("m/s^2", "mg"), 1e6 / 9.80665: ("m/s^2", "ug"),
    },
}  # fmt: skip
ANY: Factors = {
    DEG: ("rad", "deg"), 9.80665: ("g", "m/s^2"), 1e3: ("a unit", "its thousandth"), 1e6: ("a unit", "its millionth"),
}  # fmt: skip


@dataclass(frozen=True)
class Change:
    """One change of what is recorded."""

    code: str  # unit_changed, sign_changed, scale_changed, axes_changed
    index: int  # first sample after it
    channels: tuple[str, ...]  # that change
    factor: float = 1.0  # after over before; of a sign or scale
    units: tuple[str, str] | None = None  # before and after
    sources: tuple[str, ...] = ()  # channels whose readings these channels show after an exchange

    def remark(self, place: Callable[[int], str]) -> Remark:
        """Return what to say of it."""
        names = ", ".join(self.channels)
        if self.code == "unit_changed" and self.units is not None:
            what = f"{names}: the unit changes from {self.units[0]} to {self.units[1]} (factor {self.factor:.4g})"
        elif self.code == "sign_changed":
            what = f"{names}: the sign of the readings turns"
        elif self.code == "axes_changed":
            pairs = ", ".join(f"{a} goes on as {b}" for a, b in zip(self.channels, self.sources, strict=True) if a != b)
            what = f"the axes change places: {pairs}; likely another sensor, or columns in another order"
        else:
            what = f"{names}: the scale changes by the factor {self.factor:.4g}"
        do = "Split the recording here, and state the two parts as they are"
        return Remark(self.code, "error", what, place(self.index), do=do, subject=names, index=self.index)


class _Line(NamedTuple):
    """Levels of all channels at a jump, from a line through one side."""

    level: Array
    u: Array
    scatter: Array
    size: int


class _Jump(NamedTuple):
    """One jump with the lines before and after."""

    at: int
    before: _Line
    after: _Line

    @property
    def step(self) -> Array:
        """Of each channel."""
        return self.after.level - self.before.level

    @property
    def u(self) -> Array:
        """Of each step."""
        return np.hypot(self.before.u, self.after.u)


def changes(
    channels: Sequence[NDArray[Any]],
    names: Sequence[str],
    kind: str = "",
    interval: float | None = None,
    breaks: Indices | None = None,
    applied: Array | None = None,
    at_rest: bool = True,
    scale: float = 1.0,
) -> tuple[Change, ...]:
    """Return where unit, sign, scale or axes of a record change, in order of time.

    Parameters
    ----------
    channels : sequence of ndarray, shape (n,)
        Of one sensor, in one unit; NaN where a sample is missing.
    names : sequence of str
        Of the channels.
    kind : str
        Of unit, as ``core.units.kind`` has it.
    interval : float, optional
        From sample to sample [s].
    breaks : ndarray of int64, optional
        Samples before which a stretch of time is missing, ascending.
    applied : ndarray, shape (n,), optional
        The true input along one axis, as far as it was recorded, in the same unit.
    at_rest : bool
        Whether the sensor was at rest: else a jump of a rate from one sample to the next may be a start of a table.
    scale : float
        SI units in the unit of the channels.

    Returns
    -------
    tuple of Change
        At most one of each code.
    """
    n = len(channels[0]) if len(channels) else 0
    size = max(1, -(-n // MOST))
    x = np.column_stack([averaged(one, size) for one in channels]) if n >= FEWEST else np.zeros((0, 1))
    rows = np.flatnonzero(np.all(np.isfinite(x), axis=1))
    if len(rows) < FEWEST:
        return ()
    x = x[rows]
    cut = np.diff(rows, prepend=rows[0]) > 3
    if breaks is not None and len(breaks):
        cut |= np.diff(np.searchsorted(breaks, rows * size, side="right"), prepend=0) > 0
    given = None if applied is None else averaged(applied, size)[rows]
    given = given if given is not None and np.isfinite(given).all() else None
    factors = FACTORS.get(kind, ANY)
    found: list[Change] = []
    noise = _Noise.of(x)
    if given is not None:
        found += _by_response(x, given, noise, names, factors)
        if not found or found[0].code == "axes_changed":
            exchange = _exchanged_response(x, given, names)
            found = found if exchange is None else [exchange]
    if not found:
        found += _by_noise(x, noise, names, factors)
    if not found:
        motion = 0.0  # largest jump that a motion can make
        if kind == "acceleration":
            motion = 0.0 if interval is not None and interval * size <= TURNED_WITHIN else np.inf
        elif kind == "angular_rate" and not at_rest and given is None:
            motion = np.inf if interval is None else STARTED * interval * size / scale
        found += _by_levels(x, noise, names, factors, cut, given, motion)
    return tuple(replace(one, index=int(rows[one.index]) * size) for one in found)


def averaged(x: NDArray[Any], size: int) -> Array:
    """Return the means of so many samples each."""
    if size == 1:
        return np.asarray(x, dtype=np.float64)
    means: Array = x[: len(x) // size * size].reshape(-1, size).mean(axis=1, dtype=np.float64)
    return means


def _unit(factor: float, factors: Factors, tolerance: float) -> tuple[float, tuple[str, str]] | None:
    """Return the factor of two units that is meant, with the units before and after."""
    if not factor > 0.0:
        return None
    known = list(factors.items()) + [(1.0 / one, pair[::-1]) for one, pair in factors.items()]
    best, units = min(known, key=lambda one: abs(np.log(factor / one[0])))
    return (best, (units[0], units[1])) if abs(np.log(factor / best)) <= tolerance else None


# ---- noise ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Noise:
    """Noise of blocks from second differences, natural logarithm, shape (blocks, channels); which channels have any."""

    size: int
    log: Array
    informative: Flags

    @classmethod
    def of(cls, x: Array) -> _Noise:
        size = max(BLOCK, len(x) // BLOCKS)
        n = (len(x) - 2) // size
        second = np.abs(np.diff(x, 2, axis=0))[: n * size].reshape(n, size, -1)
        mean = second.mean(axis=1) * np.sqrt(np.pi / 2.0 / 6.0)
        with np.errstate(divide="ignore"):
            logs = np.log(mean)
        return cls(size, logs, np.mean(np.isfinite(logs), axis=0) > 0.9)

    def rounding(self, x: Array, at: int) -> Array:
        """Return the standard deviation of rounding, over that of the noise before block ``at``."""
        apart = np.abs(np.diff(x, axis=0))
        least = 1e-9 * np.abs(x).max(axis=0)  # below it, two equal codes were rounded apart
        step = np.array([np.min(d[d > one], initial=np.inf) for d, one in zip(apart.T, least, strict=True)])
        step = np.where(np.isfinite(step), step, 0.0)
        ratio: Array = step / np.sqrt(6.0) / np.exp(_middle(self.log[:at]))
        return ratio

    def ratios(self, at: int) -> tuple[Array, Array]:
        """Return the logarithm of the noise after over before block ``at``, and its standard uncertainty.

        NaN where a channel has no noise before or after.
        """
        parts = [self.log[:at], self.log[at:]]
        middle = [_middle(part) for part in parts]
        var = [
            (1.4826 * 1.2533 * np.median(np.abs(part - m), axis=0)) ** 2 / len(part)
            for part, m in zip(parts, middle, strict=True)
        ]
        return middle[1] - middle[0], np.sqrt(var[0] + var[1])


def _by_noise(x: Array, noise: _Noise, names: Sequence[str], factors: Factors) -> list[Change]:
    """Return a change of unit that multiplies the noise, and the levels where there are any."""
    columns = np.flatnonzero(noise.informative)
    logs = noise.log[:, columns]
    if len(logs) < 8 or not len(columns):
        return []
    ranks = np.argsort(np.argsort(np.where(np.isfinite(logs), logs, -np.inf), axis=0), axis=0)
    walk = np.cumsum(ranks - 0.5 * (len(logs) - 1), axis=0).sum(axis=1)
    at = int(np.argmax(np.abs(walk[3:-4]))) + 4
    only = _Noise(noise.size, logs, noise.informative[columns])
    ratio, u = only.ratios(at)
    middle = float(np.median(ratio))
    low = middle - NOISE_AGREES - 4.0 * u
    with np.errstate(divide="ignore"):  # rounding to steps adds its own noise to what is quieter
        rounded = 0.5 * np.log(np.exp(2.0 * middle) + only.rounding(x[:, columns], at) ** 2)
    known = np.isfinite(ratio).all() and abs(middle) >= LEAST_NOISE
    if not known or np.any(ratio < low) or np.any(ratio > rounded + NOISE_AGREES + 4.0 * u):
        return []
    unit = _unit(float(np.exp(middle)), factors, NOISE_AGREES + 4.0 * float(u.min()))
    index = _refined(x[:, columns], at, noise.size, only)
    near = [one for one in _candidates(x) if abs(one - at * noise.size) <= 2 * noise.size]
    index = near[0] if near else index  # where a level jumps, it tells the sample
    jump = _jump(x, index, np.zeros(len(x), dtype=bool))
    if jump is None:
        return []
    before, after = jump.before, jump.after
    f = unit[0] if unit is not None else _common_factor(jump)
    u_level = np.hypot(after.u, f * before.u)
    informative = np.abs(jump.step) > CLEAR * jump.u
    agrees = np.abs(after.level - f * before.level) <= 6.0 * u_level + 0.1 * np.abs(f * before.level)
    # Channels whose level has to say the same
    enough = 2 if unit is None else 1 if len(columns) < 2 else 0
    if not f > 0.0 or abs(np.log(f) - middle) > SAME_NOISE:
        return []
    clear = np.count_nonzero(agrees & informative)
    offset = clear >= 2 and bool(np.all(np.abs(after.level) < OFFSET * np.abs(before.level)))  # of one of three axes
    if clear < enough or not (np.all(agrees) or offset):
        return []
    code, units = ("scale_changed", None) if unit is None else ("unit_changed", unit[1])
    return [Change(code, index, tuple(names), f, units)]


def _common_factor(jump: _Jump) -> float:
    """Return the factor that takes the levels before a jump to those after it best; NaN where a level has no noise."""
    u, before, after = jump.u, jump.before.level, jump.after.level
    if not np.all(u > 0.0) or not np.any(before != 0.0):
        return float("nan")
    return float(np.sum(before / u * (after / u)) / np.sum((before / u) ** 2))


def _middle(logs: Array) -> Array:
    """Return the median of each channel's finite logarithms; NaN where there are none."""
    finite = [column[np.isfinite(column)] for column in logs.T]
    return np.array([np.median(column) if len(column) else np.nan for column in finite])


def _refined(x: Array, at: int, size: int, noise: _Noise) -> int:
    """Return the sample at which the noise changes, near block ``at``: the most likely of two normal scales."""
    first, last = max(0, (at - 2) * size), min(len(x), (at + 2) * size)
    second = np.diff(x[first:last], 2, axis=0)
    a = _middle(noise.log[:at]) + 0.5 * np.log(6.0)
    b = _middle(noise.log[at:]) + 0.5 * np.log(6.0)
    gain = np.sum(0.5 * second**2 * (np.exp(-2.0 * b) - np.exp(-2.0 * a)) + b - a, axis=1)
    walk = np.concatenate([[0.0], np.cumsum(gain)])  # after is likelier where it falls
    quiet = bool(np.sum(b - a) < 0.0)
    # Second differences across the change are as large as the louder side's
    return first + int(np.argmax(walk)) + (0 if quiet else 2)


# ---- levels -----------------------------------------------------------------------------------------------------


@lru_cache(maxsize=16)
def _shapes(size: int) -> tuple[Array, float, Array]:
    """Return a line through the middle of a stretch, its moment, and the two bends after it, of length 1."""
    t: Array = np.arange(size, dtype=np.float64) + 0.5 - 0.5 * size
    x1 = 2.0 * t / size
    bends: Array = np.stack([1.5 * x1**2 - 0.5, 2.5 * x1**3 - 1.5 * x1])
    bends /= np.sqrt(np.sum(bends**2, axis=1))[:, None]
    return t, float(np.sum(t**2)), bends


def _line(x: Array, index: int, side: int, room: int) -> _Line | None:
    """Return the level at a jump from the samples before (side -1) or after (1), the longest stretch a line fits."""
    found: _Line | None = None
    near = min(room, NEAR)
    around = x[index - near : index] if side < 0 else x[index : index + near]
    size, failed = SIDE[0], 0
    while size <= min(room, SIDE[1]) and failed < PATIENCE:
        part = x[index - size : index][::-1] if side < 0 else x[index : index + size]  # away from the jump
        t, moment, bends = _shapes(size)
        mean = part.mean(axis=0)
        slope = t @ part / moment
        rest = part - mean - np.outer(t, slope)
        scatter = np.sqrt(np.sum(rest**2, axis=0) / (size - 2))
        noise, close = _white(part), _white(part[: max(SIDE[0], size // 4)])
        more = 1.0 + FITS / np.sqrt(size)
        alike = 1.5 + FITS / np.sqrt(0.5 * size)
        bent = np.abs(bends @ rest)
        fits = bool(np.all(bent <= BENT * noise) and np.all(scatter <= more * noise))
        fits = fits and bool(np.all((close <= alike * noise) & (noise <= alike * close)))
        if found is None or fits:
            if size < NEAR:  # so few samples do not tell their scatter
                scatter = np.maximum(scatter, _white(around))
            u = scatter * np.sqrt(1.0 / size + (0.5 * size) ** 2 / moment)
            found = _Line(mean - slope * 0.5 * size, u, scatter, size)
        failed = 0 if fits else failed + 1
        size *= 2
    return found


def _white(part: Array) -> Array:
    """Return the standard deviation of white noise that has the second differences of a stretch."""
    values: Array = np.sqrt(np.mean(np.diff(part, 2, axis=0) ** 2, axis=0) / 6.0)
    return values


def _jump(x: Array, index: int, cut: NDArray[np.bool_]) -> _Jump | None:
    """Return the lines on both sides of a jump, within the stretch without a gap."""
    gaps = np.flatnonzero(cut)
    first = int(gaps[gaps < index].max(initial=0))
    last = int(gaps[gaps > index].min(initial=len(x)))
    before, after = _line(x, index, -1, index - first), _line(x, index, 1, last - index)
    if before is None or after is None:
        return None
    return _Jump(index, before, after)


def _candidates(x: Array) -> list[int]:
    """Return the samples at which the record jumps: the step is far larger than those beside it."""
    found: dict[int, float] = {}  # how far each step stands out
    size = 1
    while len(x) // size >= FEWEST:
        means = x[: len(x) // size * size].reshape(-1, size, x.shape[1]).mean(axis=1) if size > 1 else x
        gap = 1 if size == 1 else 2  # the block of the jump itself is a mixture
        step = np.abs(means[gap:] - means[:-gap])
        typical = np.maximum(np.median(step, axis=0), 1e-9 * np.abs(means).max(axis=0))
        beside = np.zeros_like(step)
        width = NEIGHBOURS
        widest = _widest(step, width)
        shift = width // 2 + gap
        beside[shift:] = np.maximum(beside[shift:], widest[:-shift])
        beside[:-shift] = np.maximum(beside[:-shift], widest[shift:])
        with np.errstate(divide="ignore", invalid="ignore"):
            excess = np.max(np.where(typical > 0.0, (step - ABRUPT * beside) / typical, 0.0), axis=1)
        for row in np.argsort(excess)[: -CANDIDATES - 1 : -1].tolist():
            if excess[row] > 3.0:
                place = row + 1 if size == 1 else _best_split(x, row * size, (row + gap + 1) * size)
                near = [one for one in found if abs(place - one) <= SIDE[0]]  # shorter means tell the sample better
                place = min(near, key=lambda one: abs(place - one)) if near else place
                found[place] = max(found.get(place, 0.0), float(excess[row]))
        size *= 8
    return sorted(found, key=lambda one: -found[one])[: 2 * CANDIDATES]


def _widest(step: Array, width: int) -> Array:
    """Return the largest value of each column within a width about each row."""
    found = np.pad(step, ((width // 2, width - 1 - width // 2), (0, 0)), mode="edge")
    size = 1
    while size < width:  # of windows, twice as wide each time
        more = min(size, width - size)
        found, size = np.maximum(found[:-more], found[more:]), size + more
    return found


def _best_split(x: Array, first: int, last: int) -> int:
    """Return the sample between which and the one before two levels explain a stretch best."""
    part = x[first:last]
    spread = np.maximum(part.std(axis=0), 1e-300)
    part = (part - part.mean(axis=0)) / spread
    count = np.arange(1, len(part))[:, None]
    total = np.cumsum(part, axis=0)[:-1]
    gain = total**2 / count + total**2 / (len(part) - count)
    return first + int(np.argmax(gain.sum(axis=1))) + 1


def _by_levels(
    x: Array,
    noise: _Noise,
    names: Sequence[str],
    factors: Factors,
    cut: NDArray[np.bool_],
    applied: Array | None,
    motion: float,
) -> list[Change]:
    """Return the change that explains a jump of the levels."""
    jumps = [one for place in _candidates(x) if (one := _jump(x, place, cut)) is not None and not cut[place]]
    jumps += [_whole(one, x, noise.size) for one in jumps]
    jumps = [one for one in jumps if np.any(np.abs(one.step) > CLEAR * one.u)]
    for one in sorted(jumps, key=lambda one: -float(np.linalg.norm(one.step))):
        if applied is not None and _is_driven(one, applied):
            continue
        change = _scaled(one, noise, names, factors)
        if change is None and float(np.linalg.norm(one.step)) > motion and _is_alone(one, x):
            change = _mirrored(one, names) or _exchanged(one, names)
        if change is None and np.isfinite(motion):
            change = _exchanged_biases(one, names)
        if change is not None:
            return [change]
    return []


def _whole(jump: _Jump, x: Array, size: int) -> _Jump:
    """Return a jump with the levels of all that lies before and after, for records at rest."""
    lines = []
    for part in (x[: jump.at], x[jump.at :]):
        n = len(part) // size
        if n < 8:
            return jump
        means = part[: n * size].reshape(n, size, -1).mean(axis=1)
        level = np.median(means, axis=0)
        scatter = 1.4826 * np.median(np.abs(means - level), axis=0)
        lines.append(_Line(level, 0.5 * scatter, scatter * np.sqrt(size), len(part)))
    whole = _Jump(jump.at, *lines)
    # The record has to jump there, too: what was laid on another side before or after is no jump
    apart = float(np.linalg.norm(whole.step - jump.step))
    return whole if apart < OFFSET * float(np.linalg.norm(whole.step)) else jump


def _is_alone(jump: _Jump, x: Array) -> bool:
    """Whether the record is smooth elsewhere, so that this jump is no motion."""
    total = np.concatenate([np.zeros((1, x.shape[1])), np.cumsum(x - x[0], axis=0)])
    whole = float(np.linalg.norm(jump.step))
    for size in ALONE:  # short means where it moves, long ones where it is noisy
        if size > ALONE[0] and 2 * size > min(jump.before.size, jump.after.size):
            break
        means = (total[size:] - total[:-size]) / size
        step = means[size:] - means[:-size]  # of the samples from ``size`` on
        bend = step[size:] - step[:-size]  # a steady turn has none
        for change, width in ((step, 2), (bend, 3)):
            length = np.linalg.norm(change, axis=1)
            length[max(0, jump.at - width * size) : jump.at] = 0.0
            if length.max(initial=0.0) < SMOOTH * whole:
                return True
    return False


def _is_driven(jump: _Jump, applied: Array) -> bool:
    """Whether the applied quantity jumps there, too."""
    near = applied[max(0, jump.at - 3) : jump.at + 3]
    return bool(np.ptp(near) > 0.2 * np.abs(jump.step).max())


def _mirrored(jump: _Jump, names: Sequence[str]) -> Change | None:
    """Return a change of sign: every level that jumps goes to its negative."""
    before, after, step, u = jump.before.level, jump.after.level, np.abs(jump.step), jump.u
    jumped = step > 0.5 * CLEAR * u
    mirrored = np.abs(after + before) <= TIGHT * u + EXACT * step.max()
    if not np.any(step > CLEAR * u) or not _same_noise(jump):
        return None
    # Electronics behind the change may add an offset to one of three axes
    most = np.count_nonzero(mirrored & jumped) >= 2 and bool(
        np.all(np.abs(after + before) <= OFFSET * step + TIGHT * u)
    )
    if not np.all(mirrored[jumped]) and not most:
        return None
    turned = names if np.all(mirrored) or most else [name for name, one in zip(names, jumped, strict=True) if one]
    return Change("sign_changed", jump.at, tuple(turned), -1.0)


def _same_noise(jump: _Jump) -> bool:
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = jump.after.scatter / jump.before.scatter
    return bool(np.all((ratio > 1.0 / 3.0) & (ratio < 3.0) | ~np.isfinite(ratio)))


def _exchanged(jump: _Jump, names: Sequence[str]) -> Change | None:
    """Return an exchange of axes: every level is that of another channel, give or take one common offset."""
    before, after, u = jump.before.level, jump.after.level, jump.u
    k = len(names)
    size = float(np.abs(jump.step).max())
    if k < 2:
        return None
    best: tuple[float, tuple[int, ...]] | None = None
    for order in permutations(range(k)):
        if order == tuple(range(k)):
            continue
        off = after - before[list(order)]
        common = float(np.median(off)) if k > 2 else 0.0  # another sensor has another bias
        rest = np.abs(off - common)
        allowed = TIGHT * (u + u[list(order)]) + RELATIVE * size
        told = np.abs((after - before) - float(np.median(after - before))) > 8.0 * allowed
        if np.all(rest <= allowed) and told.any():
            score = float(np.max(rest / allowed))
            if best is None or score < best[0]:
                best = score, order
    if best is None:
        best = _partly_exchanged(jump)
    if best is None:
        return None
    return Change("axes_changed", jump.at, tuple(names), 1.0, None, tuple(names[i] for i in best[1]))


def _exchanged_biases(jump: _Jump, names: Sequence[str]) -> Change | None:
    """Return an exchange of two of three axes at rest, where long lines agree exactly: no start of a turn does that."""
    before, after, u = jump.before.level, jump.after.level, jump.u
    if len(before) != 3 or min(jump.before.size, jump.after.size) < NEAR:
        return None
    for order in ((1, 0, 2), (2, 1, 0), (0, 2, 1)):
        moved = np.array([i != j for i, j in enumerate(order)])
        agrees = np.abs(after - before[list(order)]) <= TIGHT * np.hypot(u, u[list(order)])
        if np.all(agrees) and np.all(np.abs(jump.step[moved]) > CLEAR * u[moved]) and _same_noise(jump):
            return Change("axes_changed", jump.at, tuple(names), 1.0, None, tuple(names[i] for i in order))
    return None


def _partly_exchanged(jump: _Jump) -> tuple[float, tuple[int, ...]] | None:
    """Return an exchange in which two of three axes go on as their neighbours, and the third shows another sensor."""
    before, after, u = jump.before.level, jump.after.level, jump.u
    size = float(np.abs(jump.step).max())
    if len(before) != 3:
        return None
    allowed = TIGHT * 2.0 * u.max() + 1.5 * RELATIVE * max(size, float(np.linalg.norm(before)))
    for order in ((1, 2, 0), (2, 0, 1)):
        agrees = np.abs(after - before[list(order)]) <= allowed
        moved = np.abs(jump.step) > 2.0 * allowed
        if np.count_nonzero(agrees) >= 2 and np.count_nonzero(moved) >= 2 and np.any(agrees & moved):
            return 1.0, order
    return None


def _scaled(jump: _Jump, noise: _Noise, names: Sequence[str], factors: Factors) -> Change | None:
    """Return a change of unit or scale: one factor for all levels and for the noise."""
    before, after = jump.before, jump.after
    f = _common_factor(jump)
    if not f > 0.0 or abs(np.log(f)) < np.log(1.5):
        return None
    u_level = np.hypot(after.u, f * before.u)
    tells = (np.abs(jump.step) > CLEAR * jump.u) & (np.abs(after.level) > 5.0 * after.u)
    agrees = np.abs(after.level - f * before.level) <= TIGHT * u_level + RELATIVE * np.abs(f * before.level)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.log(after.scatter / before.scatter)
    at = min(max(jump.at // noise.size, 1), len(noise.log) - 1)
    overall, _ = noise.ratios(at)
    off = np.minimum(np.abs(ratio - np.log(f)), np.abs(overall - np.log(f)))
    loud = np.isfinite(off) & (off > SAME_NOISE)
    if not np.all(agrees) or not tells.any() or loud.any():
        return None
    unit = _unit(f, factors, 0.02)
    if unit is not None and (np.count_nonzero(tells) >= min(2, len(names)) or abs(np.log(f)) > LEAST_NOISE):
        return Change("unit_changed", jump.at, tuple(names), unit[0], unit[1])
    if np.count_nonzero(tells) >= 2:
        return Change("scale_changed", jump.at, tuple(names), f)
    return None


# ---- response ---------------------------------------------------------------------------------------------------

SAME_RESPONSE = 1.5  # factor up to which a response is the same: saturation, lag and nonlinearity change it
EXPLAINED = 4.0  # times that two responses explain more than one
EXCHANGED = 15.0  # gain of logarithmic likelihood by an exchange, as for white noise
EXPLAINS = 0.8  # of the gain by any change of levels and responses
ALIKE = 0.97  # of the largest gain
LEAST_PART = 0.05  # of the record before and after


def _by_response(x: Array, applied: Array, noise: _Noise, names: Sequence[str], factors: Factors) -> list[Change]:
    """Return the change of the slope of the readings against the applied quantity."""
    found = response_change(x, applied)
    if found is None or not np.any(found[1]):
        return []
    index, before, after = found
    axis = int(np.argmax(np.abs(before)))
    own = float(after[axis] / before[axis])
    other = int(np.argmax(np.abs(after)))
    if other != axis and abs(own) < 0.5 and abs(after[other] / before[axis]) > 1.0 / SAME_RESPONSE:
        order = _simplest(len(names), axis, other)
        return [Change("axes_changed", index, tuple(names), 1.0, None, tuple(names[i] for i in order))]
    if 1.0 / SAME_RESPONSE < -own < SAME_RESPONSE:
        return [Change("sign_changed", index, tuple(names), -1.0)]
    unit = _unit(own, factors, 0.1)
    if unit is not None:
        return [Change("unit_changed", index, tuple(names), unit[0], unit[1])]
    ratio, _ = noise.ratios(min(max(index // noise.size, 1), len(noise.log) - 1))
    if own > 0.0 and abs(np.log(own)) > np.log(SAME_RESPONSE) and abs(ratio[axis] - np.log(own)) < SAME_NOISE:
        return [Change("scale_changed", index, tuple(names), own)]
    return []


def _simplest(k: int, axis: int, other: int) -> tuple[int, ...]:
    """Return the exchange of the fewest axes after which one axis shows in the column of another."""
    order = list(range(k))
    order[axis], order[other] = other, axis
    return tuple(order)


def _exchanged_response(x: Array, applied: Array, names: Sequence[str]) -> Change | None:
    """Return an exchange of axes that explains levels and responses: it shows without a jump, too.

    With the columns put back from a sample on, a level, a drift and one response explain each channel; how much better
    than without is counted in likelihoods, for each sample and each exchange.
    """
    n, k = x.shape
    spread = float(np.ptp(applied))
    if n < FEWEST or k < 2 or not spread > 0.0:
        return None
    terms, _ = np.linalg.qr(np.column_stack([np.ones(n), applied / spread, np.linspace(-1.0, 1.0, n)]))
    y = x - x.mean()
    edge = max(SIDE[0], round(LEAST_PART * n))
    cuts: Indices = np.arange(edge, n - edge)
    sums = [np.cumsum(one, axis=0) for one in (y * y, *(term[:, None] * y for term in terms.T))]
    parts = [(one[cuts - 1], one[-1] - one[cuts - 1]) for one in sums]  # before and after each cut
    least = 1e-12 * float(sums[0][-1].sum())
    if not least > 0.0:
        return None

    def loss(order: Sequence[int]) -> Array:
        """Return the sum of squares of each channel, shape (cuts, channels), with columns put back after each cut."""
        square, *products = [before + after[:, order] for before, after in parts]
        found: Array = np.maximum(square - sum(one**2 for one in products), least)
        return found

    same = loss(tuple(range(k)))[0]
    found: list[tuple[float, int, tuple[int, ...]]] = []
    for order in permutations(range(k)):
        if order != tuple(range(k)):
            gains = 0.5 * n * np.log(same / loss(order))
            best = int(np.argmax(gains.sum(axis=1)))
            found.append((float(gains[best].sum()), best, order))
    most = max(one[0] for one in found)
    if most < EXCHANGED:
        return None
    # Of those that explain as well, that of the fewest axes
    gain, best, order = min((one for one in found if one[0] > ALIKE * most), key=lambda one: (_moved(one[2]), -one[0]))
    index = int(cuts[best])
    moved = [i for i in range(k) if order[i] != i]
    sets = [np.linalg.lstsq(terms[part], y[part][:, moved], rcond=None)[0] for part in (slice(index), slice(index, n))]
    rest = np.concatenate([y[:index, moved] - terms[:index] @ sets[0], y[index:, moved] - terms[index:] @ sets[1]])
    free = np.maximum(np.sum(rest**2, axis=0), least)
    whole = float(np.sum(0.5 * n * np.log(same[moved] / free)))
    size = max(2, round(np.sqrt(n)))
    blocks = rest[: n // size * size].reshape(-1, size, len(moved)).mean(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        colour = float(np.nanmax(np.append(size * blocks.var(axis=0) / rest.var(axis=0), 1.0)))
    if gain < EXCHANGED * colour or gain < EXPLAINS * whole:
        return None
    return Change("axes_changed", index, tuple(names), 1.0, None, tuple(names[order.index(i)] for i in range(k)))


def _moved(order: Sequence[int]) -> int:
    """Return how many axes an exchange moves."""
    return sum(i != j for i, j in enumerate(order))


def response_change(x: Array, applied: Array) -> tuple[int, Array, Array] | None:
    """Return where the response to an applied quantity changes most, and the slopes before and after.

    None where one response explains the record as well.

    Parameters
    ----------
    x : ndarray, shape (n, channels)
        Readings.
    applied : ndarray, shape (n,)
        What was applied.
    """
    n = len(x)
    spread = float(np.ptp(applied))
    if n < FEWEST or not spread > 0.0:
        return None
    r = (applied - applied.mean()) / spread
    y = x - x.mean(axis=0)
    sums = [np.cumsum(one, axis=0) for one in (np.ones(n), r, r * r, y, r[:, None] * y, y * y)]
    edge = max(SIDE[0], round(LEAST_PART * n))
    cuts: Indices = np.arange(edge, n - edge)
    sse, slopes = [], []
    for part in (0, 1):
        c, sr, srr, sy, sry, syy = (one[cuts - 1] if part == 0 else one[-1] - one[cuts - 1] for one in sums)
        moment = srr - sr**2 / c
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = (sry - sr[:, None] * sy / c[:, None]) / moment[:, None]
        usable = moment > 0.01 * c * float(np.var(r))
        slope = np.where(usable[:, None], slope, np.nan)
        sse.append(syy - sy**2 / c[:, None] - slope**2 * moment[:, None])
        slopes.append(slope)
    whole = r @ y / (r @ r)
    all_sse = np.sum((y - np.outer(r, whole)) ** 2)
    two = np.sum(sse[0] + sse[1], axis=1)
    if not np.isfinite(two).any():
        return None
    best = int(np.nanargmin(two))
    if all_sse <= EXPLAINED * max(float(two[best]), 0.0):
        return None
    return int(cuts[best]), slopes[0][best] / spread, slopes[1][best] / spread
