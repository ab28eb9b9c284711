"""One gate for every record: what in the samples of a channel is no reading, or not of the same kind as the rest.

``screen`` looks one channel of evenly spaced samples through, in the units it is stored in; it needs neither the sample
rate nor the unit. The record is read once, in blocks (``blocks``), and nothing of it is sorted; what is looked at more
closely is a bounded number of samples.

================  =======================================================================  ==========================
code              finding                                                                  module
================  =======================================================================  ==========================
glitch            up to 10 samples far from the running median of 31                       ``glitches``
disturbed         more than 10 such samples together                                       ``glitches``
saturated         samples held at, or piled up on, the least or largest value              ``held``
stuck             one value repeated far longer than the record does elsewhere             ``held``
repeated          a stretch that equals an earlier one, sample by sample                   ``held``
repeated_samples  samples saved again in place of the next, all along the record           ``held``
missing           samples that are no finite numbers
level_step        the level changes from one sample to the next, and stays                 ``levels``
noise_change      the noise grows or falls by a tenth or more                              ``levels``
slow_wave         a periodic line, from six periods in the record on                       ``levels``
================  =======================================================================  ==========================

*Assumed of a good record.* Its noise is stationary: any mixture of white noise, flicker, random walk and low-passed
noise, with tails up to exponential ones; besides, drift that is smooth over a fifteenth of the record, and waves of
fewer than six periods. Codes may be coarse. Of a sensor that is moved on purpose (``at_rest=False``) only glitches and
what is held, repeated or missing are looked for.

*False alarms.* Designed at 0.3 % of good channels in all: .1 % for steps, .05 % each for noise, waves and glitches,
.04 % for samples piled up at an end, .01 % for what is stuck or repeated. ``tests/signals/screening`` counts them in
18 kinds of simulated records, 900 of 1,000, 10,000 and 100,000 samples each, and in pieces of real ones: none or one of
900.

*What it finds.* In 60 of 60 records each: one sample in 10,000 off by 50 standard deviations, bursts of three, one
-32768 among 238,256 real samples; a step of 1.1 standard deviations in 72,000 samples (0.7: also; 0.35: none); noise
that grows by 30 %; a wave of 0.3 standard deviations peak to peak and six periods in 72,000 samples; 5 % or 0.01 %
of the samples clipped, or four; 20 samples stuck; 512 samples stored twice; one sample in 50 saved again.
Without the samples of ``screened``, the angle random walk came back within 0.1 %.

*What it cannot see.* A glitch of less than seven scales; clipping followed by added noise; a step smaller than some
nine standard deviations of the mean of a sixtieth of the record, whatever makes it scatter; a wave of fewer than six
periods; a copy that was rounded anew, or of fewer than some 400 samples in a long record; a stuck stretch of fewer than
ten samples, or of a channel whose noise is far below a step of its codes. Jumps of the level that a sensor makes by
itself are findings too, as are the knocks and the vibration of a place: they are no faults of the record, but terms
fitted across them are wrong all the same.

*How to use it.* ::

    found = screen(x)                      # the channel as stored
    for remark in remarks_of(found, "x"):  # what to say (``remarks``)
        print(remark)
    x[found.screened(x)]                   # what is no reading; figures are made with and without

Lines of a spectrum that the numbers of the file cannot carry are judged apart (``resolution``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ...core.batches import batches, release, zeros
from ...core.estimate import Array
from ..remembered import remembered
from ..time.samples import Flags, Indices
from .blocks import PIECE, SMALLEST, SUBSAMPLE, Blocks, bits_of, blocks_of, pieces
from .glitches import FEWEST, Scale, Stretches, far_samples, ranks_of, scale_of
from .held import HELD, Copy, Habits, Held, copies, habits_of, rails, repeats, stuck
from .levels import FILLED, level_steps, may_change, noise_changes, slow_wave
from .loops import loops_for

Code = Literal[
    "glitch", "disturbed", "saturated", "stuck", "repeated", "repeated_samples", "missing", "level_step",
    "noise_change", "slow_wave",
]  # fmt: skip
NO_READINGS: tuple[Code, ...] = ("glitch", "disturbed", "saturated", "stuck", "repeated", "missing")
PLAIN = "bBhHiIlLqQfd"  # types of samples that loops take as they are
HOLES: tuple[Code, ...] = ("disturbed", "stuck")  # of which no block has part in levels


@dataclass(frozen=True, eq=False)
class Finding:
    """All that a channel shows of one kind."""

    code: Code
    places: (
        Indices  # samples [first, last] of each place, in order of time, shape (k, 2); the first 4,096 at an extreme
    )
    # size: of each place, in standard deviations of the noise, with sign where it has one: distance from the median,
    # height of a step or amplitude of a wave; of noise_change the ratio after to before; NaN where it has none
    size: Array
    count: int  # samples at all places; of changes and waves, the places
    value: Array  # of each place: value that is held, samples from the original to its copy, samples of a period

    @property
    def first(self) -> int:
        """First sample of the first place."""
        return int(self.places[0, 0])

    @property
    def last(self) -> int:
        """Last sample of the last place."""
        return int(self.places[-1, 1])


@dataclass(frozen=True, eq=False)
class Screening:
    """What a channel shows."""

    findings: tuple[Finding, ...]  # at most one a code, in the order of the table above
    samples: int
    # noise: standard deviation that sizes are counted in [unit of the channel]; 0 where it is not known
    # step: smallest difference of neighbours that is not zero [unit of the channel]; both are 0 without findings
    noise: float
    step: float

    def __contains__(self, code: str) -> bool:
        """Whether there is a finding of a code."""
        return any(one.code == code for one in self.findings)

    def __getitem__(self, code: str) -> Finding:
        """Return the finding of a code."""
        return next(one for one in self.findings if one.code == code)

    @property
    def codes(self) -> tuple[str, ...]:
        """Codes of the findings."""
        return tuple(one.code for one in self.findings)

    def screened(self, x: NDArray[Any], codes: tuple[Code, ...] = NO_READINGS) -> Flags:
        """Return which samples of the channel are no readings, shape (n,): figures are made with and without them.

        Parameters
        ----------
        x : ndarray, shape (n,)
            The channel that was screened.
        codes : tuple of str
            Findings that count. Steps, changes of the noise and waves have no samples to leave out, nor has a channel
            that is stuck throughout: nothing would be left to say so.
        """
        out = zeros(len(x), bool)
        for one in self.findings:
            whole = one.code == "stuck" and one.count == self.samples
            if one.code not in codes or one.code not in NO_READINGS or whole:
                continue
            if one.code == "missing":
                for first, stop in batches(x, out):
                    out[first:stop] |= ~np.isfinite(x[first:stop])
            elif one.code == "saturated":
                values = np.unique(one.value)
                for first, stop in batches(x, out):
                    out[first:stop] |= np.isin(x[first:stop], values)
            else:
                for first, last in one.places.tolist():
                    out[first : last + 1] = True
        return out


def screen(x: NDArray[Any], at_rest: bool = True) -> Screening:
    """Look one channel through.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Evenly spaced samples as stored, integers or floats, NaN where one is missing.
    at_rest : bool
        Whether the sensor was at rest, so that steps, changes of the noise and waves mean something.

    Returns
    -------
    Screening
        With a finding for each kind of fault.

    Raises
    ------
    DataError
        If it is no single channel of numbers.

    Examples
    --------
    >>> import numpy as np
    >>> rate = np.random.default_rng(1).normal(size=10_000)
    >>> rate[1234] = -32768.0
    >>> found = screen(rate)
    >>> found.codes
    ('glitch',)
    >>> found["glitch"].places
    array([[1234, 1234]])
    >>> int(found.screened(rate).sum())
    1
    """
    x = np.asarray(x)
    if not len(x):
        return Screening((), 0, 0.0, 0.0)
    found = _sound(x, at_rest) or _looked_through(x, at_rest)
    return found if found.findings else Screening((), len(x), 0.0, 0.0)


def noise_of(x: NDArray[Any]) -> float:
    """Return the standard deviation that sizes of findings would be counted in; 0 where it is not known.

    Parameters
    ----------
    x : ndarray, shape (n,)
        A channel without findings [unit].
    """
    x = blocks_of(np.asarray(x)).x
    return scale_of(x, *pieces(x)).sigma if len(x) >= FEWEST else 0.0


def _sound(x: NDArray[Any], at_rest: bool) -> Screening | None:
    """Return what a short record shows in which nothing can be found; None where something may, which is searched.

    A few looks in compiled loops; where these are not at hand, the search takes no longer.
    """
    n, kind = len(x), x.dtype
    if not FEWEST <= n <= SUBSAMPLE or x.ndim > 1 or kind.char not in PLAIN or not kind.isnative:
        return None
    if not x.flags.c_contiguous:
        return None
    many, loops = n // PIECE * PIECE, loops_for(n)
    mean, rough = np.empty((2, -(-n // SMALLEST)))
    if not loops.look(x, x.view(bits_of(kind)[0]), many, ranks_of(many)[0][0], mean, rough):
        return None
    return None if at_rest and may_change(n, SMALLEST, mean, rough) else Screening((), n, 0.0, 0.0)


@remembered
def _looked_through(x: NDArray[Any], at_rest: bool) -> Screening:
    with np.errstate(over="ignore", invalid="ignore"):  # differences of the largest numbers
        found = _searched(x, at_rest)
    release(x)  # of samples that are looked at here and there, a system may keep 2 MiB about each
    return found


def _searched(x: NDArray[Any], at_rest: bool) -> Screening:
    blocks = blocks_of(x)
    found: dict[Code, Finding] = {}
    lost = len(x) - int(blocks.count.sum())
    if lost:
        found["missing"] = _missing(blocks, lost)
    if len(x) - lost < 2:
        return Screening(tuple(found.values()), len(x), 0.0, 0.0)
    first, rows = pieces(blocks.x, whole=not lost)
    scale = scale_of(blocks.x, first, rows, whole=not lost) if len(x) >= FEWEST else Scale(0.0, 0.0, np.inf)
    short, long = far_samples(blocks, scale, at_rest)
    for code, one in (("glitch", short), ("disturbed", long)):
        if len(one.places):
            found[code] = _stretches(code, one, scale)  # type: ignore[index,arg-type]
    skip = _samples(np.concatenate((short.places, long.places)))
    clean = blocks.without(skip)
    habits = habits_of(clean, rows)
    again = copies(clean, habits)
    if again:
        found["repeated"] = _repeated(again)
        clean = clean.beside(found["repeated"].places)
    _held(found, clean, habits, skip, scale.step, at_rest)
    if at_rest and scale.sigma > 0.0:
        _levels(found, clean, scale)
    order = get_args(Code)
    return Screening(
        tuple(sorted(found.values(), key=lambda one: order.index(one.code))), len(x), scale.sigma, scale.step
    )


def _missing(blocks: Blocks, lost: int) -> Finding:
    size = np.minimum(blocks.size, len(blocks.x) - np.arange(len(blocks)) * blocks.size)
    rows = np.flatnonzero(blocks.count < size)
    at = (rows[:, None] * blocks.size + np.arange(blocks.size)).ravel()
    at = at[at < len(blocks.x)]
    at = at[~np.isfinite(blocks.x[at])]
    first = np.flatnonzero(np.diff(at, prepend=at[0] - 2) > 1)
    places = np.column_stack((at[first], at[np.append(first[1:], len(at)) - 1]))
    none = np.full(len(places), np.nan)
    return Finding("missing", places, none, lost, none)


def _stretches(code: Code, one: Stretches, scale: Scale) -> Finding:
    count = int(np.sum(one.places[:, 1] - one.places[:, 0] + 1))
    return Finding(code, one.places, one.peak / scale.sigma, count, np.full(len(one.places), np.nan))


def _samples(places: Indices) -> Indices:
    """Return all samples of places, ascending."""
    length = places[:, 1] - places[:, 0] + 1
    before = np.concatenate(([0], np.cumsum(length)[:-1])) if len(length) else length
    return np.sort(np.repeat(places[:, 0] - before, length) + np.arange(int(length.sum())))


def _repeated(again: tuple[Copy, ...]) -> Finding:
    places = np.array([[one.first, one.last] for one in again])
    count = int(np.sum(places[:, 1] - places[:, 0] + 1))
    lags = np.array([float(one.lag) for one in again])
    return Finding("repeated", places, np.full(len(again), np.nan), count, lags)


def _held(
    found: dict[Code, Finding], blocks: Blocks, habits: Habits, skip: Indices, step: float, at_rest: bool
) -> None:
    ends = rails(blocks, habits, skip, step)
    again = repeats(habits) if at_rest and not habits.has_fewer(HELD + 1) else 0.0
    if again:
        n, none = len(blocks.x), np.full(1, np.nan)
        found["repeated_samples"] = Finding("repeated_samples", np.array([[0, n - 1]]), none, round(again * n), none)
    groups: list[tuple[Code, tuple[Held, ...]]] = [
        ("saturated", ends), ("stuck", stuck(blocks, habits, tuple(one.value for one in ends)))
    ]  # fmt: skip
    for code, every in groups:
        if every:
            places = np.concatenate([one.places for one in every])
            value = np.concatenate([np.full(len(one.places), one.value) for one in every])
            order = np.argsort(places[:, 0], kind="stable")
            none = np.full(len(places), np.nan)
            found[code] = Finding(code, places[order], none, sum(one.count for one in every), value[order])


def _levels(found: dict[Code, Finding], blocks: Blocks, scale: Scale) -> None:
    held = np.zeros(len(blocks), dtype=bool)
    for code in (one for one in HOLES if one in found):
        for first, last in found[code].places.tolist():
            held[first // blocks.size : last // blocks.size + 1] = True
    kept = np.flatnonzero((blocks.count >= FILLED * blocks.size) & ~held & np.isfinite(blocks.rough))
    mean = blocks.mean[kept]
    if not len(kept):
        return
    changes = noise_changes(blocks.rough[kept], scale.step)
    cuts = np.array([one.at for one in changes], dtype=np.int64)
    if changes:
        ratio = np.exp(0.5 * np.array([one.size for one in changes]))
        found["noise_change"] = _places("noise_change", kept[cuts] * blocks.size, ratio)
    coarse = scale.sigma < scale.step
    steps = level_steps(mean, cuts, 1.5 * scale.step if coarse else 0.0)
    if steps:
        at = kept[np.array([one.at for one in steps])] * blocks.size
        found["level_step"] = _places("level_step", at, np.array([one.size for one in steps]) / scale.sigma)
    wave = slow_wave(mean, 0.5 * scale.step if coarse else 0.0)
    if wave is not None:
        whole = np.array([[0, len(blocks.x) - 1]])
        size = np.array([wave.amplitude / scale.sigma])
        found["slow_wave"] = Finding("slow_wave", whole, size, 1, np.array([wave.period * blocks.size]))


def _places(code: Code, at: Indices, size: Array) -> Finding:
    return Finding(code, np.column_stack((at, at)), size, len(at), np.full(len(at), np.nan))
