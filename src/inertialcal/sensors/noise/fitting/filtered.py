"""Band of a sensor whose filter cuts its noise below half the sample rate: found in the spectrum, used in the fit.

A low pass leaves the density of each term at low frequencies and takes a share 1 - h(f) of it above. What it takes of
an Allan variance over m samples follows from the spectrum of the term, whatever the filter [1]_::

    lost(m) = integral of S(f) (1 - h(f)) 2 sin^4(pi f m) / (m sin(pi f))^2,    f in cycles a sample, -1/2 to 1/2

For white noise and long m this is N^2 c / tau^2 with one constant c: the pole of the filter. Averaging times below
1.5 periods of the corner tell of the filter alone; those above are fitted with the terms less what is lost. The size of
white noise is then the level inside the band, as sampled: what folds into the band is in it, as a user of the samples
has it.

Found: densities over bands are fitted by white noise, flicker, walk, rounded angle and Gauss-Markov noise (Whittle
[2]_), with and without a low pass of first order over all; a filter is there where twice the gain of log likelihood
exceeds `CLEAR` and the corner lies above `SLOWEST` of the sample rate; before that, one Gauss-Markov term is fitted
closely. Then the level is taken below half of the corner
as (N^2 + B/f + K/f^2) / (1 + c f^2)^2, and h is the density over that level: no order or kind of filter is assumed.

Assumed: the filter acts on all noise alike and its gain is 1 below its corner; the noise ahead of it is a sum of the
terms. Its uncertainty: those of the level and of its curve up to half of the corner, with their covariance, enter as a
misfit of what is lost, common to all averaging times, with `SHAPE` of it. Where no filter is found, a mild one may be
there: what the largest takes that fits the spectrum nearly as well as the best (`NEAR`) enters in the same way.

Real data break it in three ways, each simulated. A fall of 2 % at half the sample rate (first order at 44 Hz, sampled
at 50 Hz) is not seen in an hour: N is 0.35 % low with u = 0.5 %, its interval holds in 94 of 100. Ripple or a resonance
inside the band counts as level: a Chebyshev filter of 1 dB reads N up to 3 % high. Flicker above the white noise at
half of the corner hides N, and reads 2 to 4 % high.

References
----------
.. [1] D. B. Percival, IEEE Trans. Ultrason. Ferroelectr. Freq. Control 38 (1991) 590: Allan variance by the spectrum.
.. [2] P. Whittle, Ark. Mat. 2 (1953) 423: likelihood by the periodogram.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from ....core.estimate import Array
from ....signals._kernels_lanes import LANES
from ....signals.spectrum.density import Spectrum
from ....statistics.least_squares import symmetric_inverse
from .._kernels import fit_of
from .._kernels_band import banded_each, lowest_each
from ..expected import density_of_samples, density_of_steps
from ..terms import GaussMarkov, Phase

PER_DECADE = 60  # bands of the spectrum
CLEAR = 25.0  # twice the gain of log likelihood from which a filter is there
SLOWEST = 1.0 / 60.0  # of the sample rate: a corner below is that of a drift, as a correlation time of 10 samples is
BRIEF = 10.0  # samples: correlation times from here on are noise of the sensor
STEEP = 30.0  # fall of the density about one octave that shows a filter of itself
PERIODS = 1.5  # of the corner, in the shortest averaging time of the fit
PART = 0.5  # of the corner, up to which the level is fitted
FEWEST = 6  # bands below that
NONE_MARKOV = np.empty((0, 0)), np.empty(0)  # no table of Gauss-Markov noise, nothing to search
LEAST = 40  # bands of a spectrum that is searched
LOWEST = 0.01  # of the corner, from which it is
SHAPE = 0.07  # least relative uncertainty of what is lost
LIKELY = 2.0  # standard uncertainties
GRID = 4096  # frequencies of the integral
CYCLES: Array = (np.arange(GRID, dtype=np.float64) + 0.5) * (0.5 / GRID)  # those frequencies
STEPS = 4.0 * np.sin(np.pi * CYCLES) ** 2
RESOLVED = 512  # samples of a window that the grid resolves; sin^4 is 3/8 on average beyond
FOLDS = np.geomspace(1e-4, 1e4, 65)  # sizes of a low pass that are tried: its density is 1 / (1 + size 4 sin^2(pi f))
COARSE = 8  # of these sizes, one of which is tried first: ten times the size has a good part of the gain
DOUBTFUL = 2.0  # twice the gain of log likelihood there, from which those about the best are tried
LIKELY_THERE = 0.4 * CLEAR  # the same of those, from which all are tried
STRIDE = 4  # of mild ones, in the same way
NEAR = 0.5  # log likelihood less than the best: one standard uncertainty
MILD = 0.3  # size of a low pass, above which it does not stay hidden
MILDEST = np.array([0.0, *FOLDS[FOLDS <= MILD]])
ROUNDED = 3  # column of the rounded angle, which rises
TOP, FALLEN = 0.35, 0.95  # cycles a sample above which a filter has taken some of the density
NONE = 4  # of them that are as good as none
CURVES = np.concatenate(
    [-np.geomspace(0.01, 1.0, 25)[::-1], [0.0], np.geomspace(0.01, 3.0, 33)]
)  # of the level: -ln h at the end of the fit


@dataclass(frozen=True, eq=False)
class Band:
    """What a filter leaves of the noise of one record."""

    corner: float  # Where half of the density is left, in cycles a sample; beyond 1/2 extrapolated by first order
    cycles: Array  # shape (k,): Frequencies, in cycles a sample
    passed: Array  # shape (k,): Share of the density that is left there
    shown: tuple[float, float, float]  # Where half is left by the spectrum, whatever is stated: lowest, best, highest
    curve: float  # -ln h at the end of the level, nearly: see `rolled`
    doubt: Array  # shape (2, 2): Covariance of the logarithm of the level that the share is of, and of the curve
    found: bool = True  # False: the spectrum does not show it, nor excludes it
    _known: dict[tuple[tuple[float, ...], float], Array] = field(init=False, repr=False, default_factory=dict)

    @property
    def end(self) -> float:
        """Up to where the level is fitted [cycles a sample]."""
        return min(PART * self.corner, 0.5)

    @property
    def first(self) -> int:
        """Samples in the shortest mean that tells of the terms."""
        return max(1, int(np.ceil(PERIODS / self.corner)))

    @cached_property
    def share(self) -> Array:
        """Share of the density that is left, at the frequencies of the integral."""
        return self.passed_at(CYCLES)

    def passed_at(self, cycles: Array) -> Array:
        """Return the share of the density that is left at frequencies in cycles a sample, of their shape."""
        low = self.cycles[0]
        share = np.interp(cycles, self.cycles, self.passed)
        return np.where(cycles < low, 1.0 + (self.passed[0] - 1.0) * (cycles / low) ** 2, share)

    def lost(self, phases: Sequence[Phase], m: Array) -> Array:
        """Return what the filter takes of the Allan variance of each noise over m samples, shape (p, k) [unit^2]."""
        sizes = np.array([(one.point, one.linear, one.cubic, one.flicker) for one in phases])
        wander = {one.duty for one in phases if one.flicker} or {1.0}
        if len(wander) > 1:
            return np.concatenate([self.lost([one], m) for one in phases])
        found = sizes @ self._lost_of_units(tuple(m.tolist()), wander.pop())
        for i, one in enumerate(phases):
            if one.exponentials:
                found[i] += self.lost_of(exponential_density(one.exponentials), m)
        return np.asarray(found)

    def lost_of(self, density: Array, m: Array) -> Array:
        """Return what the filter takes of the Allan variance of noise with a density at `CYCLES`, shape (k,)."""
        return np.asarray(density @ _taken(self, tuple(m.tolist())))

    def _lost_of_units(self, m: tuple[float, ...], duty: float) -> Array:
        """Return what the filter takes of point, linear, cubic and flicker noise of size 1, shape (4, k)."""
        if (m, duty) not in self._known:
            self._known[m, duty] = unit_densities(duty) @ _taken(self, m)
        return self._known[m, duty]

    def slopes(self, phases: Sequence[Phase], m: Array) -> Array:
        """Return slopes of what is lost of each noise by the logarithm of level and curve, shape (p, k, 2) [unit^2]."""
        part = (CYCLES / self.end) ** 2
        slopes = np.where(self.end < CYCLES, [[1.0], [0.0]], [np.zeros(GRID), part / (1.0 + 0.5 * self.curve * part)])
        weights = windows(tuple(m.tolist()))
        return np.array([weights @ (slopes * density_at(one) * self.share).T for one in phases])


@lru_cache(maxsize=32)  # records share mild bands
def _taken(band: Band, m: tuple[float, ...]) -> Array:
    """Return what a filter takes of Allan variances for a density of 1 at each of `CYCLES`, shape (GRID, k)."""
    return np.ascontiguousarray((windows(m) * (1.0 - band.share)).T)


@lru_cache(maxsize=16)
def windows(m: tuple[float, ...]) -> Array:
    """Return weights of the density at `CYCLES` in Allan variances over m samples, shape (k, GRID)."""
    at = np.array(m)[:, None]
    fourth = np.where(at <= RESOLVED, np.sin(np.pi * CYCLES * at) ** 4, 0.375)
    return np.asarray(4.0 * (0.5 / GRID) * fourth / (at * np.sin(np.pi * CYCLES)) ** 2)


def density_at(phase: Phase) -> Array:
    """Return the density of samples at `CYCLES`, shape (GRID,) [unit^2]."""
    found = density_of_steps(phase, STEPS)
    return found + phase.flicker * unit_flicker(phase.duty) if phase.flicker else found


def exponential_density(exponentials: tuple[tuple[float, float], ...]) -> Array:
    """Return the density of samples of Gauss-Markov noise at `CYCLES`, shape (GRID,) [unit^2]."""
    return density_at(Phase(exponentials=exponentials))


@lru_cache(maxsize=8)
def unit_densities(duty: float) -> Array:
    """Return the density of point, linear, cubic and flicker noise of size 1 at `CYCLES`, shape (4, GRID)."""
    units = (Phase(point=1.0), Phase(linear=1.0), Phase(cubic=1.0), Phase(flicker=1.0, duty=duty))
    return np.array([density_at(one) for one in units])


@lru_cache(maxsize=8)
def unit_flicker(duty: float) -> Array:
    """Return the density of flicker of h = 1 at `CYCLES`: its folding is slow to sum."""
    return density_of_samples(Phase(flicker=1.0, duty=duty), CYCLES)


def bands_of(
    spectra: Sequence[Spectrum], marked: Sequence[NDArray[np.bool_] | None]
) -> tuple[Array, NDArray[np.int64]]:
    """Return bands of spectra with the same frequencies, without lines, and how many each has, shape (n,).

    Of shape (n, 3, k): frequency [cycles a sample], mean density and half the degrees of freedom.
    """
    first = spectra[0]
    cycles = first.frequency * first.interval
    density = np.array([one.density[:, 0] for one in spectra])
    left, out, counts = (
        np.zeros(density.shape, np.bool_),
        np.empty((len(spectra), 3, len(cycles))),
        np.empty(len(spectra), np.int64),
    )
    for i, own in enumerate(marked):
        if own is not None:
            left[i] = own
    bands = np.floor(np.log10(cycles / cycles[0]) * PER_DECADE + 1e-9)
    banded_each(bands, cycles, density, left, float(first.edf), first.neighbours.copy(), out, counts)
    return out, counts


def columns_at(cycles: Array, interval: float) -> Array:
    """Return the density of each unit term, shape (k, p): white, flicker, walk, rounded angle, Gauss-Markov."""
    return _columns_at(cycles.tobytes(), interval)


@lru_cache(maxsize=4)
def _columns_at(stored: bytes, interval: float) -> Array:
    """Return the same; axes and records of one length share their frequencies."""
    cycles = np.frombuffer(stored)
    times = BRIEF * 1.25 ** np.arange(21)
    units = [Phase(linear=1.0), Phase(flicker=1.0), Phase(cubic=1.0), Phase(point=1.0)]
    units += [GaussMarkov(1.0, time).phase(1.0, 1.0) for time in times]
    return np.column_stack([2.0 * interval * density_of_samples(one, cycles) for one in units])


def least(D: Array, density: Array, weight: Array) -> tuple[float, Array]:
    """Return the least cost of a sum of columns, not negative, and their sizes."""
    scale, sizes = D.max(axis=0), np.empty(D.shape[1] + 1)
    scaled, wanted = np.ascontiguousarray(D / scale), np.arange(D.shape[1] + 1) < D.shape[1]
    table, spacings = NONE_MARKOV
    cost = fit_of(scaled, table, np.array([density, weight]), wanted, -1, 0.0, 0.0, 0.0, spacings, sizes)[1]
    return cost, sizes[:-1] / scale


@lru_cache(maxsize=4)  # spectra of one length share their frequencies
def _behind(stored: bytes, interval: float) -> tuple[Array, Array, Array]:
    """Return columns alone, shape (p, k), and those that fall behind low passes of `FOLDS` and of `MILDEST`.

    Each has 1 as its largest value, of shape (sizes, p, k) behind low passes, and is filled up with zeros as
    ``_kernels_band`` takes it; not to be changed. Those behind mild ones are of white noise, flicker and walk alone:
    others give way to any filter.
    """
    swing = 4.0 * np.sin(np.pi * np.frombuffer(stored)) ** 2
    every = _columns_at(stored, interval)
    D = np.delete(every, ROUNDED, axis=1)

    def scaled(D: Array, sizes: Array) -> Array:
        behind = D.T / (1.0 + sizes[:, None, None] * swing)
        found = np.zeros((len(sizes), -(-D.shape[1] // 4) * 4, filled(len(D))))
        found[:, : D.shape[1], : len(D)] = behind / behind.max(axis=2, keepdims=True)
        return found

    return scaled(every, np.zeros(1))[0], scaled(D, FOLDS), scaled(D[:, :3], MILDEST)


def filled(count: int) -> int:
    """Return the length of rows of that many numbers, filled up."""
    return -(-count // LANES) * LANES


def gains_of(cycles: Array, density: Array, weight: Array, interval: float) -> list[tuple[float, float, float]]:
    """Return twice the gain of log likelihood by a low pass, its corner [cycles a sample], and a mild one's size.

    Of each of n spectra, densities and weights of shape (n, k). The low pass is one of first order. Of mild ones, it is
    the largest that fits nearly as well as the best.
    """
    n, k = density.shape
    data, found = np.zeros((n, 2, filled(k))), np.empty((n, 4))
    data[:, 0, :k], data[:, 1, :k] = density, weight
    rules = NONE + 1, ROUNDED, COARSE, DOUBTFUL, LIKELY_THERE, STRIDE, NEAR
    lowest_each(*_behind(cycles.tobytes(), interval), data, rules, found)
    gains = []
    for (best, cost, plain, hidden), own, by in zip(found.tolist(), density, weight, strict=True):
        alone = plain
        if 2.0 * (plain - cost) >= CLEAR:
            alone = min(plain, with_one_time(cycles, own, by, interval))
        gains.append((2.0 * (alone - cost), CORNERS[int(best)], float(MILDEST[int(hidden)])))
    return gains


def with_one_time(cycles: Array, density: Array, weight: Array, interval: float) -> float:
    """Return the least cost with one Gauss-Markov term, its time searched closely.

    All times of `columns_at` together are so much alike that the solver stops short by 100 and more.
    """
    linear = columns_at(cycles, interval)[:, : ROUNDED + 1]

    def cost(logarithm: float) -> float:
        phase = GaussMarkov(1.0, float(np.exp(logarithm))).phase(1.0, 1.0)
        return least(np.column_stack([linear, density_of_samples(phase, cycles)]), density, weight)[0]

    times = np.log(BRIEF) + np.log(1.25) * np.arange(21)
    first = float(times[int(np.argmin([cost(float(one)) for one in times]))])
    bounds = max(first - 0.25, np.log(BRIEF)), first + 0.25
    found = optimize.minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": 1e-3})
    return float(min(found.fun, cost(first)))


@lru_cache(maxsize=32)  # sizes are those of `FOLDS`
def mild_band(size: float) -> Band:
    """Return the band of a mild low pass that the spectrum does not show, not to be changed."""
    passed, corner = 1.0 / (1.0 + size * 4.0 * np.sin(np.pi * CYCLES) ** 2), corner_of(size)
    return Band(corner, CYCLES, passed, (corner,) * 3, 0.0, np.zeros((2, 2)), False)


def corner_of(size: float) -> float:
    """Return the corner of 1 / (1 + size 4 sin^2(pi f)), that of the low pass before sampling [cycles a sample]."""
    a = 1.0 + 0.5 / size
    return float(np.arccosh(a) / (2.0 * np.pi))


CORNERS = tuple(corner_of(float(size)) for size in FOLDS)


@dataclass(frozen=True, eq=False)
class Search:
    """Spectrum of one record in bands, and how well a low pass explains it."""

    cycles: Array  # shape (k,): Frequencies, in cycles a sample
    density: Array  # shape (k,): Mean densities
    weight: Array  # shape (k,): Half of their degrees of freedom
    interval: float  # From sample to sample [s]
    gain: float  # Twice the gain of log likelihood by a low pass of first order
    corner: float  # Its corner, in cycles a sample
    hidden: float = 0.0  # Size of a mild low pass that may be there where none is found

    @staticmethod
    def together(records: Sequence[Search]) -> bool:
        """Return whether records of one sensor show a filter."""
        clear = sum(one.gain for one in records) >= CLEAR
        return clear and float(np.median([one.corner for one in records])) >= SLOWEST

    def unseen(self) -> Band | None:
        """Return the band of a low pass that may be there where none is found; None where its best size is zero."""
        return None if self.hidden == 0.0 else mild_band(self.hidden)

    def band(self, stated: float | None = None) -> Band | None:
        """Return the band, about a stated corner [cycles a sample]; None where too little lies inside of it."""
        corner = self.corner if stated is None else stated
        found = band_at(self.cycles, self.density, self.weight, self.interval, corner, stated is not None)
        if found is None or stated is not None:
            return found
        top = self.cycles >= TOP
        return found if np.average(found.passed[top], weights=self.weight[top]) < FALLEN else None

    def fall(self, corner: float) -> float:
        """Return the factor by which the density falls about a frequency [cycles a sample], within an octave."""
        below = self.density[(self.cycles >= 0.7 * corner) & (self.cycles <= corner)]
        above = self.density[(self.cycles >= 1.4 * corner) & (self.cycles <= 2.0 * corner)]
        return float(np.median(below) / np.median(above)) if len(below) and len(above) else 1.0


def search(spectrum: Spectrum, marked: NDArray[np.bool_] | None = None) -> Search | None:
    """Return the spectrum of a record, searched for a low pass; None where it has too few frequencies."""
    return search_many([(spectrum, marked)])[0]


def search_many(asked: Sequence[tuple[Spectrum, NDArray[np.bool_] | None]]) -> list[Search | None]:
    """Return the same of each of many spectra, with their marks; those with the same frequencies side by side."""
    alike: dict[tuple[object, ...], list[int]] = {}
    for i, (one, _) in enumerate(asked):
        alike.setdefault((id(one.frequency), id(one.neighbours), one.edf, one.interval), []).append(i)
    found: list[Search | None] = [None] * len(asked)
    for places in alike.values():
        bands, counts = bands_of([asked[i][0] for i in places], [asked[i][1] for i in places])
        ways: dict[bytes, list[int]] = {}
        for j, count in enumerate(counts.tolist()):
            if count >= LEAST:
                ways.setdefault(bands[j, 0, :count].tobytes(), []).append(j)
        for stored, at in ways.items():
            cycles = np.frombuffer(stored)
            own = bands[at, 1:, : len(cycles)]
            searches = _searched(cycles, own[:, 0], own[:, 1], asked[places[0]][0].interval)
            for j, low_pass in zip(at, searches, strict=True):
                found[places[j]] = low_pass
    return found


def _searched(cycles: Array, density: Array, weight: Array, interval: float) -> list[Search]:
    """Return spectra with the same bands searched, densities and weights of shape (n, k)."""
    steep = steep_falls(cycles, density)
    usual = [i for i, one in enumerate(steep) if one is None]
    gains = dict(zip(usual, gains_of(cycles, density[usual], weight[usual], interval), strict=True))
    return [
        Search(cycles, density[i], weight[i], interval, *(gains[i] if one is None else (float("inf"), one)))
        for i, one in enumerate(steep)
    ]


def steep_falls(cycles: Array, density: Array) -> list[float | None]:
    """Return from where densities, shape (n, k), fall as that of no term does, and stay low [cycles a sample].

    None for nowhere. A walk falls by 8 from the octave below a frequency to the octave above it.
    """
    highest = np.maximum.accumulate(density[:, ::-1], axis=1)[:, ::-1]  # of all above
    inside = np.flatnonzero((cycles >= SLOWEST) & (2.0 * cycles < cycles[-1]))
    above = np.searchsorted(cycles, 2.0 * cycles[inside])
    # else no median below is so much more
    low = STEEP * highest[:, above] < np.maximum.accumulate(density, axis=1)[:, inside]
    found: list[float | None] = [None] * len(density)
    for j in np.flatnonzero(low.any(axis=1)).tolist():
        own = density[j]
        for i, after in zip(inside[low[j]], above[low[j]], strict=True):
            below = np.median(own[np.searchsorted(cycles, 0.5 * cycles[i], side="right") : i + 1])
            if STEEP * highest[j, after] < below:
                found[j] = float(cycles[np.flatnonzero(own >= 0.5 * below)[-1]])
                break
    return found


def band_at(cycles: Array, density: Array, weight: Array, interval: float, corner: float, held: bool) -> Band | None:
    """Return the band with its corner made closer; None where too little lies inside of it."""
    found = None
    for _ in range(4):
        level = level_of(cycles, density, weight, interval, corner)
        if level is None:
            return found
        passed, curve, doubt = level
        lowest, new, highest = (
            crossing(cycles, passed * np.exp(k * np.sqrt(doubt[0, 0])), corner) for k in (-LIKELY, 0.0, LIKELY)
        )
        found = Band(corner if held else new, cycles, passed, (lowest, new, highest), curve, doubt)
        if held or abs(new / corner - 1.0) < 0.02:
            break
        corner = new
    return found


def level_of(
    cycles: Array, density: Array, weight: Array, interval: float, corner: float
) -> tuple[Array, float, Array] | None:
    """Return the share passed, its curve, and the covariance of the level below a part of the corner and the curve."""
    end = min(PART * corner, 0.5)
    inside = (cycles >= LOWEST * corner) & (cycles <= end)
    if np.count_nonzero(inside) < FEWEST:
        return None
    D = columns_at(cycles, interval)[:, :3]
    part, own, measured = cycles[inside] / end, density[inside], weight[inside]
    costs = [least(D[inside] * rolled(part, curve)[:, None], own, measured)[0] for curve in CURVES]
    best = int(np.argmin(costs))
    curve = float(CURVES[best])
    if 0 < best < len(CURVES) - 1:
        a, b = np.polyfit(CURVES[best - 1 : best + 2], np.array(costs[best - 1 : best + 2]) - costs[best], 2)[:2]
        curve = float(np.clip(-0.5 * b / a, CURVES[best - 1], CURVES[best + 1])) if a > 0.0 else curve
    shape = rolled(part, curve)
    _, sizes = least(D[inside] * shape[:, None], own, measured)
    level = D @ sizes
    mu = level[inside] * shape
    there = sizes > 0.0
    slopes = np.column_stack([D[inside][:, there] * shape[:, None], -mu * part**2 / (1.0 + 0.5 * curve * part**2)])
    H = (slopes.T * (measured / mu**2)) @ slopes
    scale = 1.0 / np.sqrt(np.diag(H))
    covariance = symmetric_inverse(H * np.outer(scale, scale), 1e-10) * np.outer(scale, scale)
    at = D[np.searchsorted(cycles, end) - 1, there]
    to = np.zeros((2, len(at) + 1))  # the logarithm of the level at its end, and the curve
    to[0, :-1], to[1, -1] = at / (at @ sizes[there]), 1.0
    passed = np.where(cycles <= end, rolled(np.minimum(cycles / end, 1.0), curve), density / level)
    return passed, curve, to @ covariance @ to.T


def rolled(part: Array, curve: float) -> Array:
    """Return the share passed at parts of the end of the fit: between a low pass of first order and a Gaussian one."""
    return np.asarray((1.0 + 0.5 * curve * part**2) ** -2)


def crossing(cycles: Array, passed: Array, corner: float) -> float:
    """Return where half of the density is left [cycles a sample]; by first order where nowhere."""
    below = np.flatnonzero((passed < 0.5) & (cycles > 0.2 * corner))
    for i in below:
        if i + 3 >= len(passed) or np.median(passed[i : i + 4]) < 0.5:
            if i == 0:
                return float(cycles[0])
            a, b = np.log(passed[i - 1 : i + 1])
            return float(np.exp(np.interp(-np.log(0.5), [-a, -b], np.log(cycles[i - 1 : i + 1]))))
    return corner
