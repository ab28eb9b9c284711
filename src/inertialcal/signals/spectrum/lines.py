"""Lines of a spectrum: what stands out of the noise around it, by a test with a stated false-alarm probability.

Each value is compared with the level of the noise around it: under noise alone the ratio follows Fisher's F, with the
degrees of freedom of the value and of the level. It is tested at the false-alarm probability divided by the number of
values tested (Bonferroni), so that a record of noise alone shows any line at all with no more than that probability.
Values that stand out are marked, the level is taken again without them, until nothing changes. Marked values next to
each other are one finding: a *line* if nearly all of its power lies in a peak as wide as a line makes, else *broad*: a
resonance, or a line that wanders.

Assumed: noise whose spectrum is smooth over a few dozen values; at the knee of a steep filter it is not, so that a
finding must stand out of the values beside it, on either side, too. What it cannot do: find a line below the lowest
tested frequency (stated), tell two lines closer than the width of a peak apart, or a line from a spectrum steeper than
the window's side lobes fall.

Level of the noise around each frequency of a spectrum, and how well it is known.

The level is a straight line through the logarithms of the values on both sides, over ``ln sin(pi f dt)``, corrected for
the bias of a logarithm. Sampled noise is a power of that sine, or goes over smoothly from one power to another, so that
no model is needed. Values marked as no noise are left out. Near half of the sampling frequency the neighbours lie
below; near zero frequency values with too few neighbours have no level. The better the values are known, the nearer
the neighbours must be, or the bend of the spectrum between them would count as a line.

The level is taken as chi-square distributed itself, with the degrees of freedom that the variance of its logarithm asks
for.

References
----------
.. [1] D. B. Percival and A. T. Walden, Spectral Analysis for Physical Applications, Cambridge, 1993, chapter 10.
.. [2] M. S. Bartlett and D. G. Kendall, Suppl. J. Royal Statistical Society 8 (1946) 128-138: mean and variance of the
   logarithm of a chi-square variable.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from inspect import unwrap
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import special

from ...core.errors import PlanError
from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.rounding import number
from .density import Spectrum

Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]

ROUNDS = 20
IN_PEAK = 0.9  # of the power of a finding, that a line has in its peak
MOST_HARMONIC = 50
WIDEST = 64  # neighbours on each side
FEWEST = 12  # neighbours on each side that make a level
PART = 0.5  # of the distance from zero frequency, that the neighbours may reach ...
KNOWN = 32.0  # ... up to so many degrees of freedom of a value; by their fourth root less beyond
ONE_SIDED = 32  # part of all values that lie on one side, at most
KEPT = 2**17  # values of a spectrum, up to which the neighbours of each are kept for the next of its length
SIDE = 6  # values nearest to a run on a side, that it must stand out of
RARE = 1e-3  # probability from which on the tail of F is the lighter, the better the level is known
NEARLY = 0.99  # of the ratio with that probability
NONE = 1e-9  # more than levels may differ by rounding, relative
STRAIGHT = 1e-3  # standard deviation of the place, below which no slope is needed


@dataclass(frozen=True)
class Line:
    """One finding."""

    name: str  # ``"9.97 Hz"``, or ``"3 x 9.97 Hz"`` for a multiple of a lower one
    axis: int  # in which axis
    kind: Literal["line", "broad"]  # whether it is as narrow as a line
    # frequency, u_frequency: centre of its power, and the standard uncertainty of that [Hz]
    frequency: float
    u_frequency: float
    width: float  # from its first to its last value that stands out [Hz]
    # amplitude, u_amplitude: of the sine of the same power [unit]
    amplitude: float
    u_amplitude: float
    ratio: float  # largest density over the level of the noise
    chance: float  # probability that noise alone shows such a ratio anywhere in the spectrum (at most 1)
    # times, lowest: which multiple it is of which lower one [Hz]; 0 for one that is none
    times: int = 0
    lowest: float = 0.0


@dataclass(frozen=True, eq=False)
class Lines:
    """All findings, and what was tested."""

    found: tuple[Line, ...]  # by axis and frequency
    marked: Flags  # values of the spectrum that belong to a finding, its flanks included, shape (k, axes)
    false_alarm: float  # probability, an axis, that noise alone shows any finding
    # lowest and highest frequency tested [Hz]; NaN where the spectrum has too few values to test any
    tested: tuple[float, float]

    def __len__(self) -> int:
        return len(self.found)

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """One remark a finding; or that nothing could be tested."""
        if not np.isfinite(self.tested[0]):
            what = "too few frequencies to separate lines from noise"
            return (Remark("lines_not_tested", "info", what, do="Record longer, or give longer segments"),)
        do = "Find its source, or include it in the fit: terms fitted across it are wrong"
        texts = [
            f"{'line' if line.kind == 'line' else 'broad peak'} in axis {line.axis} at {line.name}, amplitude "
            f"{number(line.amplitude, 3)}, {number(line.ratio, 3)} times the noise around it"
            for line in self.found
        ]
        return tuple(Remark("line", "warning", what, do=do) for what in texts)


def find_lines(spectrum: Spectrum, false_alarm: float = 0.01) -> Lines:
    """Find lines and broad peaks that stand out of the noise.

    Parameters
    ----------
    spectrum : Spectrum
        From ``psd``; long segments show weak lines, short ones broad peaks.
    false_alarm : float
        Probability, an axis, that noise alone shows any line.

    Returns
    -------
    Lines
        With marks for ``Spectrum.without``.

    Raises
    ------
    PlanError
        If the probability is not between 0 and 1.
    """
    each = lines_apart(spectrum, false_alarm)
    if len(each) == 1:
        return each[0]
    found = tuple(replace(line, axis=axis) for axis, one in enumerate(each) for line in one.found)
    tested = np.array([one.tested for one in each if np.isfinite(one.tested[0])]).reshape(-1, 2)
    low, high = (float(tested[:, 0].min()), float(tested[:, 1].max())) if len(tested) else (np.nan, np.nan)
    return Lines(found, np.concatenate([one.marked for one in each], axis=1), false_alarm, (low, high))


def lines_apart(spectrum: Spectrum, false_alarm: float = 0.01) -> list[Lines]:
    """Return what `find_lines` finds in each axis of a spectrum by itself.

    Raises
    ------
    PlanError
        If the probability is not between 0 and 1.
    """
    from ._kernels import may_stand_out  # noqa: PLC0415 - numba starts slowly

    if not 0.0 < false_alarm < 1.0:
        raise PlanError(f"false_alarm {false_alarm:g}, need a probability between 0 and 1")
    test = _test(spectrum, false_alarm)
    each = []
    for axis, density in enumerate(spectrum.density.T):
        if test is not None and not may_stand_out(np.ascontiguousarray(density), *test.given):
            each.append(Lines((), np.zeros((len(density), 1), dtype=bool), false_alarm, test.tested))
        else:
            each.append(_lines_of(spectrum, axis, false_alarm))
    return each


def _lines_of(spectrum: Spectrum, axis: int, false_alarm: float) -> Lines:
    """Return the lines of one axis, searched for."""
    if not np.all(spectrum.density[:, axis] > 0.0):
        return Lines((), np.zeros((len(spectrum.density), 1), dtype=bool), false_alarm, (np.nan, np.nan))
    at, level = _standing_out(spectrum, axis, false_alarm)
    there = spectrum.frequency[np.isfinite(level.level)]
    tested = (float(there[0]), float(there[-1])) if len(there) else (np.nan, np.nan)
    runs = [one for one in _runs(at, spectrum.lobe) if _above_both_sides(spectrum, axis, at, one, false_alarm)]
    standing = np.zeros(len(at), dtype=bool)
    for a, b in runs:
        standing[a:b] = at[a:b]
    here = [replace(_measured(spectrum, axis, level, a, b), axis=0) for a, b in runs]
    return Lines(tuple(_named(here, spectrum.spacing)), _widened(standing, spectrum.lobe)[:, None], false_alarm, tested)


def _test(spectrum: Spectrum, false_alarm: float) -> _Test | None:
    """Return between what no value of a spectrum can stand out, looked at once; None where only the search tells."""
    if len(spectrum.frequency) > KEPT:
        return None
    return _test_of(
        spectrum.frequency.tobytes(), spectrum.interval, spectrum.spacing, spectrum.lobe, float(spectrum.edf),
        spectrum.neighbours.tobytes(), false_alarm,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Test:
    """What a look at the values of a spectrum takes, and the lowest and highest frequency that has a level."""

    given: tuple[Array, Indices, Flags, Array, Array, Array, float, float]
    tested: tuple[float, float]


@lru_cache(2)
def _test_of(
    frequency: bytes, interval: float, spacing: float, lobe: int, edf: float, neighbours: bytes, false_alarm: float
) -> _Test | None:
    """Return what spectra that are alike share; None of those in which no value has a level, or too few are tested."""
    around = _found_neighbours(frequency, interval, spacing, lobe, edf)
    tested = np.frombuffer(frequency)[around.known]
    if not len(tested) or false_alarm / len(tested) >= RARE:
        return None
    least = _least_ratio(edf, around.dof(edf, np.frombuffer(neighbours))[around.known], false_alarm / len(tested))
    edges = np.stack((around.first, around.stop, around.own_first, around.own_stop))
    slope_of, bias = np.where(around.sloped, around.off / around.width, 0.0), _bias(edf)
    given = around.place, edges, around.known, around.count, around.mean_place, slope_of, bias, least * (1.0 - NONE)
    return _Test(given, (float(tested[0]), float(tested[-1])))


def _least_ratio(edf: float, dof: Array, chance: float) -> float:
    """Return a ratio that noise exceeds with more than a probability, however well its level is known."""
    return float(NEARLY * special.fdtri(edf, np.nanmax(dof, initial=1.0), 1.0 - chance))


def _bias(edf: float) -> float:
    """Return the mean of the logarithm of a value over its level."""
    return float(special.digamma(0.5 * edf) - np.log(0.5 * edf))


def _unlikely(spectrum: Spectrum, axis: int, level: Background, chance: float) -> Flags:
    """Which values noise shows at most with a probability; none where there is no level.

    The tail of F is taken of those alone that are large enough where the level is best known.
    """
    with np.errstate(invalid="ignore"):
        ratio = spectrum.density[:, axis] / level.level
        found = ratio > 0.0
        if chance < RARE:
            found &= ratio > _least_ratio(spectrum.edf, level.dof, chance)
    at = np.flatnonzero(found)
    found[at] = special.fdtrc(spectrum.edf, level.dof[at], ratio[at]) < chance
    return np.asarray(found)


def _standing_out(spectrum: Spectrum, axis: int, false_alarm: float) -> tuple[Flags, Background]:
    """Values that stand out, and the level of the noise without them."""
    marked = np.zeros(len(spectrum.frequency), dtype=bool)
    level = background_of(spectrum, axis, marked)
    tested = max(1, int(np.count_nonzero(np.isfinite(level.level))))
    for _ in range(ROUNDS):
        now = marked | _unlikely(spectrum, axis, level, false_alarm / tested)
        if np.array_equal(now, marked) or _widened(now, spectrum.lobe).all():
            break
        marked = now
        again = background_of(spectrum, axis, _widened(marked, spectrum.lobe))
        there = np.isfinite(again.level)  # too few neighbours are left beside many lines
        level = Background(np.where(there, again.level, level.level), np.where(there, again.dof, level.dof))
    return marked & _unlikely(spectrum, axis, level, false_alarm / tested), level


def _widened(marked: Flags, by: int) -> Flags:
    """Values at most ``by`` away from a marked one."""
    return np.asarray(np.convolve(marked, np.ones(2 * by + 1), "same") > 0.5)


def _runs(marked: Flags, lobe: int) -> list[tuple[int, int]]:
    """Return runs [first, stop) of marked values; what is nearer than a peak is wide is one."""
    at = np.flatnonzero(marked)
    if not len(at):
        return []
    new = np.flatnonzero(np.diff(at) > lobe)
    first, last = at[np.concatenate(([0], new + 1))], at[np.concatenate((new, [len(at) - 1]))]
    return [(int(a), int(b) + 1) for a, b in zip(first, last, strict=True)]


def _above_both_sides(spectrum: Spectrum, axis: int, marked: Flags, run: tuple[int, int], false_alarm: float) -> bool:
    """Whether a run stands out of what lies on either side of it, as the knee of a filter does not."""
    density, lobe = spectrum.density[:, axis], spectrum.lobe
    free = ~_widened(marked, lobe)
    tested = max(1, len(density))
    peak = float(density[run[0] : run[1]].max())
    for side in (np.arange(run[0])[::-1], np.arange(run[1], len(density))):
        near = density[side[free[side]][:SIDE]]
        if (
            len(near) == SIDE
            and special.fdtrc(spectrum.edf, SIDE * spectrum.edf, peak / near.mean()) > false_alarm / tested
        ):
            return False
    return True


def _measured(spectrum: Spectrum, axis: int, level: Background, first: int, stop: int) -> Line:
    """Frequency, amplitude and kind of a run of values that stand out."""
    density, lobe = spectrum.density[:, axis], spectrum.lobe
    a, b = max(0, first - lobe), min(len(density), stop + lobe)
    known = np.isfinite(level.level[a:b])
    around = np.flatnonzero(known)  # a peak at the lowest tested frequency has a flank, or its top, below it
    noise = np.interp(np.arange(b - a), around, level.level[a:b][around])
    excess = density[a:b] - noise
    if excess.sum() < excess.max():  # the flanks lie below the noise by chance
        excess = np.maximum(excess, 0.0)
    power = float(excess.sum()) * spectrum.spacing
    frequency = float(np.sum(excess * spectrum.frequency[a:b]) / excess.sum())
    centre = int(np.argmin(np.abs(spectrum.frequency[a:b] - frequency)))
    centred = float(excess[max(0, centre - lobe) : centre + lobe + 1].sum()) * spectrum.spacing
    kind: Literal["line", "broad"] = "line" if centred >= IN_PEAK * power else "broad"
    offset = spectrum.frequency[a:b] - frequency
    u_power, moment = _scatter(spectrum, density[a:b], noise, np.stack((np.ones(b - a), offset)))
    at = first + int(np.argmax(density[first:stop]))
    tested = np.count_nonzero(np.isfinite(level.level))
    ratio = float(density[at] / level.level[at])
    chance = float(special.fdtrc(spectrum.edf, level.dof[at], ratio)) * tested
    return Line(
        "", axis, kind, frequency, moment / power, (stop - first) * spectrum.spacing,
        float(np.sqrt(2.0 * power)), u_power / float(np.sqrt(2.0 * power)), ratio, min(1.0, chance),
    )  # fmt: skip


def _scatter(spectrum: Spectrum, density: Array, noise: Array, weights: Array) -> tuple[float, float]:
    """Return standard deviations of weighted powers of a run: noise alone, and noise that beats with the line.

    A value of a line's density ``L`` in noise ``N`` scatters with variance ``2 (2 L N + N^2) / edf``; values beat
    together within a peak.
    """
    lag = np.arange(len(density))
    near = np.concatenate((spectrum.neighbours, np.zeros(len(density))))[np.abs(lag[:, None] - lag)]
    line = np.maximum(density - noise, 0.0)
    single = np.sqrt(2.0 * (2.0 * line * noise + noise**2) / spectrum.edf)
    spread = [float(np.sqrt((w * single) @ np.sqrt(near) @ (w * single))) for w in weights]
    return spread[0] * spectrum.spacing, spread[1] * spectrum.spacing


def _named(lines: list[Line], spacing: float) -> list[Line]:
    """Name the lines by their frequency, those at a multiple of a lower one by that."""
    named: list[Line] = []
    for line in lines:
        for lower in named:
            order = round(line.frequency / lower.frequency)
            apart = abs(line.frequency - order * lower.frequency)
            if not lower.times and 2 <= order <= MOST_HARMONIC and apart < 0.25 * order * spacing:
                named.append(replace(line, name=f"{order} x {lower.name}", times=order, lowest=lower.frequency))
                break
        else:
            named.append(replace(line, name=f"{number(line.frequency, 4)} Hz"))
    return named


@dataclass(frozen=True, eq=False)
class Background:
    """Level of the noise of one axis."""

    level: Array  # NaN where there are too few neighbours [unit^2/Hz], shape (k,)
    dof: Array  # degrees of freedom of the level, shape (k,)


def background_of(spectrum: Spectrum, axis: int, marked: Flags) -> Background:
    """Return the level of the noise around each value of an axis, those marked as no noise, shape (k,), left out."""
    around = _neighbours(spectrum)
    logs, place = np.log(spectrum.density[:, axis]), around.place
    if marked.any():
        around = around.without(marked)
    known, count, mean_place = around.known, around.count, around.mean_place
    mean_log, product = (around.summed(np.where(marked, 0.0, values)) / count for values in (logs, place * logs))
    slope = np.where(around.sloped, product - mean_place * mean_log, 0.0) / around.width
    level = np.exp(mean_log + slope * around.off - _bias(spectrum.edf))
    dof = around.dof(spectrum.edf, spectrum.neighbours)
    return Background(np.where(known, level, np.nan), np.where(known, dof, np.nan))


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Which values of a spectrum are around each, the peak of a line at its place left out; each of shape (k,)."""

    place: Array  # logarithm of the sine, that is that of a frequency but near half the sample rate
    first: Indices  # of each, and what is behind its last
    stop: Indices
    own_first: Indices  # the same of the peak
    own_stop: Indices
    known: Flags  # whether there are enough
    count: Array
    mean_place: Array
    square: Array  # mean of the squared places

    @cached_property
    def off(self) -> Array:
        """Distance of each from the mean place."""
        return self.place - self.mean_place

    @cached_property
    def sloped(self) -> Flags:
        """Whether places scatter enough for a slope."""
        return self.known & (self.square - self.mean_place**2 > STRAIGHT**2)

    @cached_property
    def width(self) -> Array:
        """Variance of the places; 1 where there is no slope."""
        return np.where(self.sloped, self.square - self.mean_place**2, 1.0)

    def dof(self, edf: float, neighbours: Array) -> Array:
        """Return the degrees of freedom of the level of values with so many, and correlations ``neighbours``."""
        spread = special.polygamma(1, 0.5 * edf) * (1.0 + 2.0 * float(np.sum(neighbours[1:])))
        raised = np.where(self.sloped, 1.0 + self.off**2 / self.width, 1.0)
        variance = np.where(self.known, spread * raised / self.count, 0.1)
        found: Array = 2.0 / variance + 1.0 - variance / 6.0  # trigamma(dof / 2) = variance, to 1e-3 below 0.2
        return found

    def summed(self, values: Array) -> Array:
        """Return the sum of values around each."""
        running = np.concatenate(([0.0], np.cumsum(values)))
        return np.asarray(running[self.stop] - running[self.first] - (running[self.own_stop] - running[self.own_first]))

    def without(self, marked: Flags) -> Neighbours:
        """Return the same without values that are marked."""
        count = self.summed(np.where(marked, 0.0, 1.0))
        known = count >= 2 * FEWEST
        count = np.where(known, count, 1.0)
        mean, square = (self.summed(np.where(marked, 0.0, one)) / count for one in (self.place, self.place**2))
        return replace(self, known=known, count=count, mean_place=mean, square=square)


def _neighbours(spectrum: Spectrum) -> Neighbours:
    """Return which values are around each, none marked: those of axes and records alike are found once."""
    find = _found_neighbours if len(spectrum.frequency) <= KEPT else unwrap(_found_neighbours)
    return find(spectrum.frequency.tobytes(), spectrum.interval, spectrum.spacing, spectrum.lobe, float(spectrum.edf))


@lru_cache(2)
def _found_neighbours(stored: bytes, interval: float, spacing: float, guard: int, edf: float) -> Neighbours:
    frequency = np.frombuffer(stored)
    order, place = np.round(frequency / spacing).astype(np.int64), np.log(np.sin(np.pi * frequency * interval))
    n = len(order)
    at = np.arange(n)
    part, fewest = PART * min(1.0, (KNOWN / edf) ** 0.25), FEWEST + guard
    half = np.minimum(np.minimum((part * order).astype(np.int64), at), min(WIDEST, max(n // ONE_SIDED, fewest)))
    half = np.where((half >= fewest) & (8 * fewest <= n), half, 0)  # half of a short spectrum is no neighbourhood
    high = np.minimum(at + half, n - 1)
    low = np.maximum(high - 2 * half, 0)
    own = np.maximum(at - guard, low), np.minimum(at + guard, high) + 1
    return Neighbours(place, low, high + 1, *own, *([place] * 4)).without(np.zeros(n, dtype=bool))
