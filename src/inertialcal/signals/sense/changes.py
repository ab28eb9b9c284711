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

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, extremes
from ...core.estimate import Array
from ..remembered import remembered
from ..time.samples import Flags, Indices
from ..vibration.recognised import recognised
from .change import ANY, FACTORS, Change, Factors, unit_of
from .jumps import CLEAR, FEWEST, OFFSET, Jump, candidates, common_factor, jump_at, jumps, may_jump
from .levels import by_levels
from .noise import LEAST_NOISE, SAME_NOISE, Noise, block_of, refined
from .response import by_response, exchanged_response

MOST = 400_000  # samples that are looked at; a longer record is averaged down to so many
NOISE_AGREES = 0.08  # of the logarithm of a factor of noise, besides its scatter
STARTED = 35.0  # [rad/s^2], 2,000 deg/s^2: a table may start so fast, and one sample to the next is a jump then
NEAR = 4  # samples, within which a condition jumps
JUMPS = 8.0  # times what it changes by from sample to sample
STEP = 0.05  # of its range
TURNED_WITHIN = 0.045  # [s]: nobody lays an accelerometer on another side so fast; slower samples may miss the turn

SAME, EXACT = 1e-6, 1e-9  # relative
LATE = 1.5  # intervals from one stamp to the next, from which a sample is missing


@remembered
def changes(
    channels: Sequence[NDArray[Any]],
    names: Sequence[str],
    kind: str = "",
    interval: float | None = None,
    breaks: Indices | None = None,
    applied: Array | None = None,
    at_rest: bool = True,
    stored: Sequence[NDArray[Any]] = (),
    scale: float = 1.0,
    conditions: Sequence[NDArray[Any]] = (),
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
    stored : sequence of ndarray, shape (n,), optional
        The channels as they were stored. Where a zero was taken off them in between they are looked through, too: a
        sign or a unit changes about the zero of what was written.
    scale : float
        SI units in the unit of the channels.
    conditions : sequence of ndarray, shape (n,)
        Pressure, supply and the like, in any unit. Biases change with them, and noise with the air: where one of them
        jumps, no change of scale is concluded (one of unit is).

    Returns
    -------
    tuple of Change
        At most one of each code.
    """
    n = len(channels[0]) if len(channels) else 0
    size = max(1, -(-n // MOST))
    if n < FEWEST:
        return ()
    columns = np.array([averaged(one, size) for one in channels])
    rows, cut = np.arange(columns.shape[1]), np.zeros(columns.shape[1], dtype=bool)
    whole = bool(np.isfinite(columns.sum()))  # then all are: what is not finite stays so in a sum
    if not whole:
        rows = np.flatnonzero(np.isfinite(columns).all(axis=0))
        if len(rows) < FEWEST:
            return ()
        cut = np.diff(rows, prepend=rows[0]) > 3
    x = (columns if whole else columns[:, rows]).T  # each channel in one piece
    if breaks is not None and len(breaks):
        cut |= np.diff(np.searchsorted(breaks, rows * size, side="right"), prepend=0) > 0
    given = None if applied is None else averaged(applied, size)[rows]
    given = given if given is not None and np.isfinite(given).all() else None
    motion = 0.0  # largest jump that a motion can make
    if kind == "acceleration":
        motion = 0.0 if interval is not None and interval * size <= TURNED_WITHIN else np.inf
    elif kind == "angular_rate" and not at_rest and given is None:
        motion = np.inf if interval is None else STARTED * interval * size / scale
    record = _Record(x, cut)
    factors = FACTORS.get(kind, ANY)
    found = _found(record, names, factors, given, motion)
    if not found and len(stored) == x.shape[1]:
        y = np.array([averaged(one, size) for one in stored])
        y = (y if whole else y[:, rows]).T
        ratio = _scale(x, y)
        if ratio is not None and np.isfinite(y).all():
            found = _found(_as_stored(record, y), names, factors, given, motion / ratio)
    found = [replace(one, index=int(rows[one.index]) * size) for one in found]
    if found and kind == "acceleration" and interval is not None:  # levels of a shaker are as far apart as units
        shaken = any(recognised(np.asarray(one, dtype=np.float64), interval) for one in channels)
        found = [one for one in found if not (shaken and one.code in ("unit_changed", "scale_changed"))]
    return tuple(
        one for one in found if one.code != "scale_changed" or not any(_steps(c, one.index) for c in conditions)
    )


def _steps(levels: NDArray[Any], at: int) -> bool:
    """Return whether a condition jumps near a sample, far more than from one sample to the next before and after."""
    values = levels[max(at - FEWEST, 0) : at + FEWEST].astype(np.float64)
    sizes = np.abs(np.diff(values[np.isfinite(values)]))
    middle = min(at, FEWEST)
    near = sizes[max(middle - NEAR, 0) : middle + NEAR]
    sides = [float(np.median(side)) for side in (sizes[:middle], sizes[middle:]) if len(side)]
    least, largest = extremes(levels, infinite=False)
    return len(near) > 0 and float(near.max()) > max(JUMPS * max(sides), STEP * (largest - least))


@dataclass(frozen=True, eq=False)
class _Record:
    """Samples of a record, their noise and jumps; of channels that are others by gains and zeros, taken from those."""

    x: Array  # shape (n, channels)
    cut: Flags  # shape (n,): whether a gap lies before a sample
    base: _Record | None = None
    gain: Array | None = None
    zero: Array | None = None

    @cached_property
    def noise(self) -> Noise:
        """Of each channel."""
        if self.base is not None and self.gain is not None:
            return self.base.noise.mapped(self.gain)
        return Noise.of(self.x)

    @property
    def may_change(self) -> bool:
        """Whether its noise may change by the factor of a unit, or its levels jump: one look, where all is sound."""
        return bool(self.cut.any()) or may_jump(self.x, block_of(len(self.x)), float(LEAST_NOISE))

    @cached_property
    def jumps(self) -> list[Jump]:
        """Clear jumps."""
        if self.base is not None and self.gain is not None and self.zero is not None:
            return [one.mapped(self.gain, self.zero) for one in self.base.jumps]
        return jumps(self.x, self.cut, self.noise.size)


def _found(
    record: _Record, names: Sequence[str], factors: Factors, applied: Array | None, motion: float
) -> list[Change]:
    """Return what changes, by the first kind of evidence that shows it: response, noise, levels."""
    if applied is None and not record.may_change:
        return []
    x, noise = record.x, record.noise
    found: list[Change] = []
    if applied is not None:
        found += by_response(x, applied, noise, names, factors)
        if not found or found[0].code == "axes_changed":
            exchange = exchanged_response(x, applied, names)
            found = found if exchange is None else [exchange]
    found = found or _by_noise(x, noise, names, factors)
    return found or by_levels(x, noise, record.jumps, names, factors, applied, motion)


def _scale(data: Array, columns: Array) -> float | None:
    """Return SI units in the unit of columns; None where one factor makes the data of them, or none does about."""
    largest = np.unravel_index(np.argmax(columns), columns.shape)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        made = columns * (data[largest] / columns[largest])
        if np.all(np.abs(data - made) <= EXACT * np.abs(made)):  # as a change of unit makes them
            return None
    good = np.isfinite(columns)
    spread = np.std(columns, where=good) if good.any() else 0.0
    if not spread > 0.0:
        return None
    scale = float(np.std(data, where=good) / spread)
    off = np.abs(np.abs(data) - scale * np.abs(columns))
    return scale if scale > 0.0 and np.any(off[good] > SAME * scale * np.abs(columns)[good]) else None


def _as_stored(record: _Record, columns: Array) -> _Record:
    """Return the record of the columns: with the jumps of the channels where each is gain times channel plus zero."""
    x = record.x
    middle, centre = x.mean(axis=0), columns.mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = np.sum((x - middle) * (columns - centre), axis=0) / np.sum((x - middle) ** 2, axis=0)
    zero = centre - gain * middle
    off = np.abs(columns - gain * x - zero)
    if np.isfinite(gain).all() and np.all(gain != 0.0) and np.all(off <= SAME * np.abs(columns - centre).max(axis=0)):
        return _Record(columns, record.cut, record, gain, zero)
    return _Record(columns, record.cut)


def averaged(x: NDArray[Any], size: int) -> Array:
    """Return the means of so many samples each."""
    if size == 1:
        return np.asarray(x, dtype=np.float64)
    used = x[: len(x) // size * size]
    means = np.empty(len(used) // size)
    for first, stop in batches(used, whole=size):
        means[first // size : stop // size] = used[first:stop].reshape(-1, size).mean(axis=1, dtype=np.float64)
    return means


def _by_noise(x: Array, noise: Noise, names: Sequence[str], factors: Factors) -> list[Change]:
    """Return a change of unit that multiplies the noise, and the levels where there are any."""
    columns = np.flatnonzero(noise.informative)
    logs = noise.log[:, columns]
    if len(logs) < 8 or not len(columns):
        return []
    order = np.argsort(np.where(np.isfinite(logs), logs, -np.inf), axis=0)
    ranks = np.argsort(order, axis=0)
    walk = (2 * np.cumsum(ranks, axis=0) - (len(logs) - 1) * np.arange(1, len(logs) + 1)[:, None]).sum(axis=1)
    at = int(np.argmax(np.abs(walk[3:-4]))) + 4
    only = Noise(noise.size, logs, noise.informative[columns])
    ratio = only.ratio(at)
    middle = float(np.median(ratio))

    def unlike() -> bool:
        allowed = NOISE_AGREES + 4.0 * only.u_ratio(at)
        with np.errstate(divide="ignore"):  # rounding to steps adds its own noise to what is quieter
            rounded = 0.5 * np.log(np.exp(2.0 * middle) + only.rounding(x[:, columns], at) ** 2)
        return bool(np.any(ratio < middle - allowed) or np.any(ratio > rounded + allowed))

    if not np.isfinite(ratio).all() or abs(middle) < LEAST_NOISE or unlike():
        return []
    unit = unit_of(float(np.exp(middle)), factors, NOISE_AGREES + 4.0 * float(only.u_ratio(at).min()))
    index = refined(x[:, columns], at, noise.size, only)
    near = [one for one in candidates(x) if abs(one - at * noise.size) <= 2 * noise.size]
    index = near[0] if near else index  # where a level jumps, it tells the sample
    jump = jump_at(x, index, np.zeros(len(x), dtype=bool))
    if jump is None:
        return []
    before, after = jump.before, jump.after
    f = unit[0] if unit is not None else common_factor(jump)
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
