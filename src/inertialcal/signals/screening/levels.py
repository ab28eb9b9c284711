"""Steps of the level, changes of the noise, and slow waves, from the means and the roughness of blocks.

*Steps.* Means of four neighbouring windows of w samples, m_1 .. m_4, give ``(m_3 - m_2) - (m_4 - m_1) / 3``: two
thirds of a step in the middle, nothing of a steady drift. It is judged against its own scatter along the record, for
each w from a block to a sixtieth of the record: so white noise, flicker and random walk each set their own limit. What
a smooth drift leaves of it falls with the third power of w, while that of a step stays: windows half as long must show
it too. What comes back soon is no step: windows twice as long must show it.

*Noise.* The same search on the logarithm of the roughness, where drift and steps have no part: two windows, from 4
blocks to a quarter of the record. Blocks are independent there, so that the scatter of wide windows is known from that
of narrow ones. Changes by less than a tenth are passed over. Where the noise changes, steps are judged by the noise
around.

*Waves.* A line in the spectrum of the means (Hann window, slope taken off), from six periods on, against a continuum
of white noise, flicker, random walk and smooth drift fitted to the same spectrum, and against its neighbours on
either side.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ...core.estimate import Array
from ...statistics.quantiles import t_upper
from ..time.samples import Flags, Indices
from .blocks import SMALLEST
from .loops import loops_for

FALSE_ALARM = 5e-4  # of changes of the noise, and of waves, a record
STEP_ALARM = 1e-3  # of steps
NARROW = 60  # windows of the widest step in a record
NARROWEST = 4  # blocks that the noise is averaged over
EVEN = 0.37  # scatter of the logarithm of the noise from window to window, from which it is nearly normal
FEWEST = 24  # blocks
FILLED = 0.5  # of a block that must be there, for its mean to count
SAMPLED = 2**11  # values that a scatter is taken from
MAD = 0.6745  # median of |x| of normal noise
INDEPENDENT = 0.25  # of the windows that a record has room for: their median scatter counts so many
STEP_PART = 2.0 / 3.0  # of a step, that shows
HALF_SHOWS = 0.45  # of a step, in windows half as long
MATTERS = 1.1  # change of the noise
MOST = 32  # changes that are looked for
COARSE = 0.55  # of a step of the codes: what scatters less hangs on where the level lies
GRID = 2**11  # means that waves are looked for in
CYCLES = 6  # of a wave, at least
PER_CYCLE = 6  # means of a cycle, at least
LOBE = 2  # frequencies that a line takes on each side
BESIDE = 6  # frequencies on each side that it must stand out of
MARGIN = 2.0  # of the limit, as the continuum is a mixture of a few powers only
STANDS = 6.0  # times their mean
ROUNDS = 60
POWERS = (0.0, -1.0, -2.0, -4.0, -6.0)  # of frequency: white, flicker, random walk, smooth drift


@dataclass(frozen=True)
class Change:
    """A change at a block: its size (of a step; of the logarithm of the variance), and its significance."""

    at: int
    size: float
    score: float  # over the limit; 1 and more is significant


@dataclass(frozen=True)
class Wave:
    """A slow wave: blocks of a period, amplitude, and how far it stands out of the limit."""

    period: float
    amplitude: float
    score: float


def noise_changes(rough: Array, step: float) -> tuple[Change, ...]:
    """Return where the noise changes, the first block after each, in order.

    Parameters
    ----------
    rough : ndarray, shape (b,)
        Variances by block.
    step : float
        Of the codes.
    """
    b = len(rough)
    if b < FEWEST or not np.median(rough) > (COARSE * step) ** 2:
        return ()
    y = np.log(np.maximum(rough, 1e-3 * float(np.median(rough))))
    sums = _sums(y)
    narrow = NARROWEST
    while (spread := _scatter(_apart(sums, narrow))) > EVEN and 8 * narrow <= b:
        narrow *= 2  # until a filter, which makes neighbours alike, leaves enough that are independent
    scale = spread * np.sqrt(narrow)  # of a difference of two blocks
    if not scale > 0.0:
        return ()
    widths = _doubling(narrow, b // 4)
    limit = _noise_limit(b, narrow)
    if not loops_for(SMALLEST * b).may_change(sums, np.array(widths), limit * scale):
        return ()
    found: list[Change] = []
    cuts = [0, b]
    while len(found) < MOST:
        best: Change | None = None
        for w in widths:
            apart = _apart(sums, w)
            for cut in cuts[1:-1]:
                apart[max(cut - 2 * w, 0) : max(cut, 0)] = 0.0
            i = int(np.argmax(apart)) if apart.max() > -apart.min() else int(np.argmin(apart))
            score = abs(float(apart[i])) / (scale / np.sqrt(w)) / limit
            material = abs(float(apart[i])) > 2.0 * np.log(MATTERS)
            if score > 1.0 and material and (best is None or score > best.score):
                best = Change(i + w, float(apart[i]), score)
        if best is None:
            break
        found.append(best)
        cuts = sorted([*cuts, best.at])
    return tuple(sorted(found, key=lambda one: one.at))


def level_steps(mean: Array, cuts: Indices, smallest: float) -> tuple[Change, ...]:
    """Return where the level steps, the first block after each, in order.

    Parameters
    ----------
    mean : ndarray, shape (b,)
        Means by block.
    cuts : ndarray
        Blocks at which the noise changes.
    smallest : float
        Size of a step below which rounding may feign it.
    """
    b = len(mean)
    wide, limits = _step_limits(b)
    if not len(wide):
        return ()
    sums, widths = _sums(mean), wide.tolist()
    if not len(cuts) and not loops_for(SMALLEST * b).may_step(sums, wide, limits, SAMPLED):
        return ()
    every = {w: _bent(sums, w) for w in widths}
    scores = {w: _judged(every[w], w, b, cuts, limit) for w, limit in zip(widths, limits.tolist(), strict=True)}
    found: list[Change] = []
    for _ in range(MOST):
        tops = [(float(score.max()), w) for w, score in scores.items() if len(score)]
        score, w = max(tops, default=(0.0, 0))
        if score <= 1.0:
            break
        i = int(np.argmax(scores[w]))
        at, size = i + 2 * w, float(every[w][i]) / STEP_PART
        if abs(size) > smallest and _stays(every, w, i):
            found.append(Change(at, size, score))
        for width, one in scores.items():  # the step shows in these
            one[max(at - 4 * width - w, 0) : at + w] = 0.0
    return tuple(sorted(found, key=lambda one: one.at))


def may_change(n: int, size: int, mean: Array, rough: Array) -> bool:
    """Return whether `noise_changes`, `level_steps` or `slow_wave` may find anything in blocks of n whole samples.

    Parameters
    ----------
    n, size : int
        Samples of the record, and of a block.
    mean, rough : ndarray, shape (b,)
        Means and variances by block.
    """
    b = len(mean)
    b -= n - (b - 1) * size < FILLED * size  # blocks that count
    given = _noise_limits(b), *_step_limits(b), SAMPLED
    found = loops_for(n).may_differ(mean[:b], rough[:b], EVEN, *given)
    return found or slow_wave(mean[:b], 0.0) is not None


@lru_cache(32)
def _noise_limits(b: int) -> Array:
    """Return the limit of a change of the noise for the narrowest windows of 4, 8, 16 ... of so many blocks."""
    narrowest = [NARROWEST << k for k in range(b.bit_length()) if b >= FEWEST and NARROWEST << k <= b // 4]
    return np.array([_noise_limit(b, narrow) for narrow in narrowest])


@lru_cache(256)
def _noise_limit(b: int, narrow: int) -> float:
    tests = sum(2.0 * b / w for w in _doubling(narrow, b // 4))
    return float(t_upper(0.5 * FALSE_ALARM / tests, _dof(b / narrow)))


@lru_cache(32)
def _step_limits(b: int) -> tuple[Indices, Array]:
    """Return the windows of steps in so many blocks, halves of the widest, and the limit of each; not to be changed."""
    widths = [b // NARROW >> k for k in range((b // NARROW).bit_length() - 1, -1, -1)] if b >= 4 * NARROWEST else []
    windows = b / np.array(widths, dtype=np.float64)
    limits = t_upper(0.5 * STEP_ALARM / (len(widths) * 2.0 * windows), _dof(windows))
    return np.array(widths, dtype=np.int64), limits


def _stays(every: dict[int, Array], w: int, i: int) -> bool:
    """Whether windows half as long show the step too, as they do not show a smooth drift; and those twice as long.

    These do not show what soon comes back.
    """
    size, widths = float(every[w][i]), [*every]
    at = widths.index(w)
    for other in (*widths[max(at - 1, 0) : at], *widths[at + 1 : at + 2]):
        middle = i + 2 * w - 2 * other
        near = every[other][max(middle - min(w, other), 0) : max(middle + min(w, other) + 1, 0)]
        if len(near) and float(np.max(np.sign(size) * near)) <= HALF_SHOWS * abs(size):
            return False
    return True


def _judged(bent: Array, w: int, b: int, cuts: Indices, limit: float) -> Array:
    """Return the size of each contrast over its limit; nothing where all are below it."""
    if len(bent) < 2 * NARROWEST:
        return np.empty(0)
    whole = _scatter(bent)
    most = max(float(bent.max()), -float(bent.min()))
    if not len(cuts):
        return np.abs(bent) / (limit * whole) if most > limit * whole > 0.0 else np.empty(0)
    scale = np.zeros(len(bent))
    for first, stop in itertools.pairwise((0, *cuts.tolist(), b)):
        inside = bent[first : max(stop - 4 * w + 1, first)]
        own = _scatter(inside) if len(inside) > NARROW * w // 4 else whole
        part = slice(max(first - 4 * w + 1, 0), stop)
        scale[part] = np.maximum(scale[part], own)
    return np.where(scale > 0.0, np.abs(bent) / np.where(scale > 0.0, limit * scale, 1.0), 0.0)


def _sums(x: Array) -> Array:
    """Return the sums of the values before each, less their middle, which keeps digits; shape (b + 1,)."""
    sums = np.zeros(len(x) + 1)
    np.cumsum(x - x[len(x) // 2], out=sums[1:])
    return sums


def _apart(sums: Array, w: int) -> Array:
    """Return the mean of w blocks less that of the w before, for blocks w .. b - w."""
    out = np.empty(max(len(sums) - 2 * w, 0))
    loops_for(SMALLEST * len(sums)).fill_apart(sums, w, out)
    return out


def _bent(sums: Array, w: int) -> Array:
    """Return the contrast of four windows, for blocks 2 w .. b - 2 w."""
    out = np.empty(max(len(sums) - 4 * w, 0))
    loops_for(SMALLEST * len(sums)).fill_bent(sums, w, out)
    return out


def _dof(windows: Array | float) -> Array:
    """Return the degrees of freedom of a scatter that so many windows tell."""
    return np.minimum(INDEPENDENT * np.asarray(windows), 0.5 * SAMPLED)


def _scatter(x: Array) -> float:
    """Return a standard deviation that few large values do not change, of every so manieth value."""
    if not len(x):
        return 0.0
    some = x[:: max(len(x) // SAMPLED, 1)]
    half = len(some) // 2
    apart = np.abs(some - np.partition(some, half)[half])
    return float(np.partition(apart, half)[half]) / MAD


def _doubling(first: int, last: int) -> list[int]:
    return [first << k for k in range(max(last // first, 0).bit_length()) if first << k <= last]


def slow_wave(mean: Array, smallest: float) -> Wave | None:
    """Return the strongest slow wave of block means, shape (b,), or None.

    Waves whose amplitude is below ``smallest`` may be made by rounding.
    """
    group = max(-(-len(mean) // GRID), 1)
    y = mean if group == 1 else mean[: len(mean) // group * group].reshape(-1, group).mean(axis=1)
    m = len(y)
    last = m // PER_CYCLE
    if last < 2 * CYCLES:
        return None
    at, squared = _line(m)
    y = y - np.add.reduce(y) / m - at * float(at @ y) / squared
    p = np.abs(np.fft.rfft(y * _hann(m))[1 : last + 1]) ** 2
    rare = FALSE_ALARM / (last - CYCLES + 1)
    given = p, _basis(last), CYCLES - 1, LOBE, BESIDE, STANDS, ROUNDS, rare, MARGIN
    if not p.min() > 0.0 or not loops_for(SMALLEST * m).may_wave(*given):
        return None
    k = np.arange(1.0, last + 1.0)
    tested = k >= CYCLES
    level = _continuum(p, np.ones(last, dtype=bool))
    ratio = np.where(tested, p / level, 0.0)
    peak = int(np.argmax(ratio))
    left = p[max(peak - LOBE - BESIDE, 0) : peak - LOBE]
    right = p[peak + LOBE + 1 : peak + LOBE + 1 + BESIDE]
    if any(len(side) and p[peak] < STANDS * side.mean() for side in (left, right)):
        return None
    order = k[peak]
    clear = np.min(np.abs(k[:, None] - order * np.arange(1, last // order + 2)), axis=1) > LOBE
    level = _continuum(p, clear)
    limit = float(-np.log(rare))
    # the level is known from few frequencies: an F distribution in place of an exponential one
    dof = 0.5 * np.count_nonzero(clear)
    limit = MARGIN * dof * (float(np.exp(limit / dof)) - 1.0)
    score = float(p[peak] / level[peak]) / limit
    if score <= 1.0:
        return None
    near = p[max(peak - 1, 0) : peak + 2]
    period = m * group / float(near @ k[max(peak - 1, 0) : peak + 2] / near.sum())
    amplitude = float(np.sqrt(32.0 / 3.0 * p[max(peak - LOBE, 0) : peak + LOBE + 1].sum())) / m  # Parseval, Hann
    return Wave(period, amplitude, score) if amplitude > smallest else None


@lru_cache(8)
def _line(m: int) -> tuple[Array, float]:
    """Return places about their middle, not to be changed, and the sum of their squares."""
    at: Array = np.arange(m, dtype=np.float64) - 0.5 * (m - 1)
    return at, float(at @ at)


@lru_cache(8)
def _hann(m: int) -> Array:
    """Return a Hann window, not to be changed."""
    return np.hanning(m)


@lru_cache(8)
def _basis(n: int) -> Array:
    """Return the powers of the first n frequencies, of mean 1, shape (powers, n), not to be changed."""
    basis = np.arange(1.0, n + 1.0) ** np.array(POWERS)[:, None]
    return np.asarray(basis / basis.mean(axis=1, keepdims=True))


def _continuum(p: Array, used: Flags) -> Array:
    """Return the continuum: a sum of powers of frequency, none negative, of the highest likelihood.

    Each value is exponential about it; multiplicative updates [1]_, single large values cut at first.

    .. [1] C. Fevotte and J. Idier, Neural Computation 23 (2011) 2421 (Itakura-Saito divergence).
    """
    basis = _basis(len(p))
    part, values = basis[:, used], p[used]
    weight = np.full(len(POWERS), values.mean() / len(POWERS))
    loops_for(SMALLEST * GRID).fit_powers(np.ascontiguousarray(part), values, ROUNDS, weight)
    return np.asarray(weight @ basis)
