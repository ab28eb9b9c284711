"""Fit of a known drive in drift and noise: what is in phase, what is in quadrature, and how well it is known.

The amplitudes are weighted sums of the readings that no smooth drift enters (``smooth``), at the times of the samples
that there are: gaps and jitter need no repair. No noise is subtracted: with the phase known the estimate has no bias.

The uncertainty is that of the noise in these sums: white noise and a random walk, found by restricted maximum
likelihood from the sums of readings in which neither drive nor drift has a part (``noise``). Its degrees of freedom are
Satterthwaite's, and with them the interval is Student's. Runs of one instrument tell of their noise together.

A long record is cut into stretches of a few hundred readings, each with a drift of its own; their amplitudes are
averaged. Samples are first averaged over a twelfth of a period where there are many. From 30 stretches on the
uncertainty is that of their scatter, which assumes nothing of the noise but that it forgets within a stretch.

Assumed: drift has no part faster than a sine of two periods of the drive, the drive is known exactly and nothing else
follows it. Where real data break it:

- drift with corners, or sines near the drive: the amplitude moves with the length of the smoothing (`LineFit.shifts`);
- noise that changes within the record: the uncertainty is that of its mean, right within 10 % where it doubles;
- noise with a line beside the drive: it counts as noise, and the uncertainty is too large.

References
----------
.. [1] G. A. F. Seber and A. J. Lee, Linear Regression Analysis, 2nd ed., Wiley, 2003, 3.10.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ..blas import one_blas_thread
from .drive import Drive
from .noise import Noise, noise_of, same_noise
from .smooth import LENGTH, OTHERS, Stretch, stretch_of

CELLS = 12  # of a period, over which samples are averaged
MANY = 1.5 * CELLS  # samples of a period, from which they are
HALF = 0.5  # of the samples of a cell, that it needs
LARGEST = 300  # readings of a stretch
SCATTER = 30  # stretches, from which their scatter is the uncertainty
FEWEST = 4  # contrasts
FEWEST_CYCLES = 6.0
DIGITS = 9  # of times and drive, to which stretches are alike


@dataclass(frozen=True, eq=False)
class Design:
    """What is fitted: a drive and a smooth drift."""

    drive: Drive  # at the samples that there are
    stretches: tuple[Stretch, ...]
    parts: tuple[slice, ...]  # cells of each stretch
    cell: NDArray[np.int64]  # of each sample; -1 for a cell with too few, shape (n,)
    counts: Array  # samples of each cell

    def means(self, readings: Array) -> Array:
        """Return the means over the cells, shape (cells, k)."""
        return _means(readings, self.cell, self.counts)

    def sums(self, weights: Array) -> Array:
        """Return the sums of weights of samples over the cells, shape (cells,)."""
        if len(self.counts) == len(weights):
            return weights
        return np.asarray(
            np.bincount(self.cell[self.cell >= 0], weights[self.cell >= 0], len(self.counts)), dtype=np.float64
        )

    @cached_property
    def alike(self) -> tuple[Stretch, ...]:
        """For each stretch the first with the same times, counted from its own start, and the same line."""
        first: dict[bytes, Stretch] = {}
        keys = [np.round(np.column_stack([one.times - one.times[0], one.line]), DIGITS).tobytes()
                for one in self.stretches]  # fmt: skip
        return tuple(first.setdefault(key, one) for key, one in zip(keys, self.stretches, strict=True))

    @cached_property
    def weights(self) -> dict[float, list[Array]]:
        """Weights of drive and quadrature in each stretch, shape (1 or 2, n), by the length of the prior of drift."""
        return {length: [one.weights_of_drift(length) for one in self.alike] for length in (LENGTH, *OTHERS)}

    @cached_property
    def shares(self) -> Array:
        """Share of each stretch in the amplitude: by its uncertainty in white noise."""
        size = np.array([1.0 / (w[0] @ w[0]) for w in self.weights[LENGTH]])
        return np.asarray(size / size.sum())

    @cached_property
    def drift_basis(self) -> Array:
        """Orthonormal columns that every smooth drift is a sum of, noise apart, shape (cells, p)."""
        own = [one.drift_basis for one in self.alike]
        basis = np.zeros((len(self.counts), sum(one.shape[1] for one in own)))
        at = 0
        for part, one in zip(self.parts, own, strict=True):
            basis[part, at : at + one.shape[1]] = one
            at += one.shape[1]
        return basis

    @cached_property
    def contrasts(self) -> list[tuple[Array, Array]]:
        """Uncorrelated contrasts of each stretch, shape (n, m), and the variance of each for a walk, shape (m,)."""
        return [one.uncorrelated for one in self.alike]


@dataclass(frozen=True, eq=False)
class Shift:
    """What the amplitude changes by with another length of the smoothing, arrays of shape (k,)."""

    length: float  # [periods of the drive]
    across: bool  # of the quadrature
    value: Array
    u: Array
    dof: Array


@dataclass(frozen=True, eq=False)
class LineFit:
    """Drive found in one record, or in several of one design."""

    # in_phase, u_in_phase: amplitude in phase with the drive, signed, and its standard uncertainty [unit of the
    # readings, or that over the unit applied], shape (k,)
    in_phase: Array
    u_in_phase: Array
    # quadrature, u_quadrature: a quarter of a period ahead of it, shape (k,)
    quadrature: Array | None
    u_quadrature: Array | None
    dof: Array  # degrees of freedom of the uncertainties, shape (k,)
    shifts: tuple[Shift, ...]  # with other lengths of the smoothing
    found: Noise | None  # white noise and walk of the cells; None where stretches scatter
    cells: Array  # readings, shape (cells, k)
    design: Design  # what was fitted

    @cached_property
    def weights(self) -> Array:
        """Weight of each reading in the in-phase amplitude, shape (n,)."""
        design = self.design
        each = np.zeros(len(design.counts))
        for part, own, share in zip(design.parts, design.weights[LENGTH], design.shares, strict=True):
            each[part] = share * own[0]
        return np.where(design.cell >= 0, (each / design.counts)[design.cell], 0.0)

    @property
    def noise(self) -> Array:
        """Standard deviation of white noise with the density at the drive [unit of the readings], shape (k,)."""
        return np.asarray(self.u_in_phase / np.linalg.norm(self.weights))

    @property
    def density(self) -> Array:
        """One-sided spectral density of the noise at the drive, shape (k,) [unit^2/Hz]."""
        return 2.0 * self.noise**2 * self.design.drive.step

    def u_of(self, weights: Array) -> float:
        """Return the standard uncertainty of another sum of the readings of the first record, weights (n,)."""
        design, noise = self.design, self.found
        if noise is None:
            return float(self.noise[0] * np.linalg.norm(weights))
        each = design.sums(weights)
        walk = sum(float(each[part] @ one.walk @ each[part])
                   for part, one in zip(design.parts, design.alike, strict=True))  # fmt: skip
        return float(np.sqrt(noise.of(float(each @ each), walk)[0][0]))

    def fitted(self) -> tuple[Array, Array]:
        """Return line and drift of the first record at the samples, shape (n,) each, not to be changed."""
        return self._line_and_drift

    @cached_property
    def _line_and_drift(self) -> tuple[Array, Array]:
        design, drive = self.design, self.design.drive
        line = self.in_phase[0] * drive.in_phase
        amplitudes = [self.in_phase[0]]
        if drive.quadrature is not None and self.quadrature is not None:
            line = line + self.quadrature[0] * drive.quadrature
            amplitudes.append(self.quadrature[0])
        drift, times = np.empty(len(self.cells)), np.empty(len(self.cells))
        for part, one in zip(design.parts, design.stretches, strict=True):
            drift[part] = one.drift(self.cells[part, :1] - (one.line @ amplitudes)[:, None])[:, 0]
            times[part] = one.times
        return line, np.interp(drive.times * drive.frequency, times, drift)


def design_of(drive: Drive) -> Design:
    """Return what is fitted to a record with a drive.

    Parameters
    ----------
    drive : Drive
        At the samples that there are.

    Raises
    ------
    DataError
        ``too_few_cycles`` below six cycles, or where they are too few to show the noise.
    """
    if drive.cycles < FEWEST_CYCLES * (1.0 - 1e-9):
        raise _too_short(drive, FEWEST_CYCLES)
    n, periods = len(drive.times), drive.times * drive.frequency
    step = drive.step * drive.frequency
    cell, step = (np.floor(CELLS * (periods - periods[0]) + 1e-6), 1.0 / CELLS) if MANY * step < 1.0 else (
        np.arange(n), step)  # fmt: skip
    whole = cell.astype(np.int64)
    cell = np.concatenate([[0], np.cumsum(whole[1:] != whole[:-1])])  # ascending, as times are
    counts = np.bincount(cell)
    enough = counts >= HALF * np.median(counts)
    if not enough.all():
        cell = np.where(enough[cell], np.cumsum(enough)[cell] - 1, -1)
    kept = counts[enough].astype(np.float64)
    line = [drive.in_phase] if drive.quadrature is None else [drive.in_phase, drive.quadrature]
    columns = np.column_stack([_means(one, cell, kept) for one in (periods, *line)])
    parts = _parts(len(kept), step)
    stretches = tuple(stretch_of(columns[one, 0], columns[one, 1:], step) for one in parts)
    return Design(drive, stretches, parts, cell, kept)


def _means(values: Array, cell: NDArray[np.int64], counts: Array) -> Array:
    if len(counts) == len(values):
        return values
    own = values if cell.min() >= 0 else values[cell >= 0]
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
    return np.asarray((np.add.reduceat(own, starts, axis=0).T / counts).T)


def _parts(n: int, step: float) -> tuple[slice, ...]:
    """Return stretches of about equal length, of whole periods where a period is a whole number of readings."""
    count = -(-n // LARGEST)
    size = -(-n // count)
    cycle = round(1.0 / step)
    if count > 1 and abs(cycle * step - 1.0) < 10.0**-DIGITS:
        size = -(-size // cycle) * cycle
    starts = list(range(0, n, size))
    if len(starts) > 1 and n - starts[-1] < HALF * size:
        starts.pop()
    return tuple(slice(a, b) for a, b in zip(starts, [*starts[1:], n], strict=True))


@one_blas_thread()
def fit_line(design: Design, readings: Array) -> LineFit:
    """Fit a design to readings.

    Parameters
    ----------
    design : Design
        For the samples of the readings.
    readings : ndarray, shape (n,) or (n, k)
        One record, or several with the same samples and each with its own noise; all finite: leave missing samples out
        of drive and readings.

    Raises
    ------
    DataError
        If shapes disagree or a reading is missing; ``rank_deficient`` if drive and drift cannot be separated at these
        samples, ``too_few_cycles`` if their noise cannot be found, ``no_scatter`` if there is none.
    """
    cells = design.means(_checked(design, readings))
    if len(design.stretches) >= SCATTER:
        return _fitted(design, cells, None)
    return _fitted(design, cells, noise_of(*contrasts_of(design, cells)))


@one_blas_thread()
def common_noise(alone: Sequence[LineFit]) -> list[LineFit]:
    """Return fits of runs of one instrument, one record each, with the noise of all where it may be the same."""
    steps = np.array([one.design.stretches[0].step / one.design.drive.frequency for one in alone])
    if len(alone) < 2 or np.ptp(steps) > HALF * steps.min() or any(one.found is None for one in alone):
        return list(alone)
    each = [contrasts_of(one.design, one.cells) for one in alone]
    together = noise_of([z for own, _ in each for z in own], [d for _, own in each for d in own])
    joined = [(np.concatenate(z)[:, 0], np.concatenate(d)) for z, d in each]
    if not same_noise([z for z, _ in joined], [d for _, d in joined], together):
        return list(alone)
    return [_fitted(one.design, one.cells, together) for one in alone]


def contrasts_of(design: Design, cells: Array) -> tuple[list[Array], list[Array]]:
    """Return the contrasts of records in each stretch, and their variances for a walk."""
    values = [sums.T @ cells[part] for part, (sums, _) in zip(design.parts, design.contrasts, strict=True)]
    walks = [walk for _, walk in design.contrasts]
    if sum(len(walk) for walk in walks) < FEWEST:
        raise _too_short(design.drive, 2.0 * max(design.drive.cycles, FEWEST_CYCLES))
    return values, walks


def _fitted(design: Design, cells: Array, noise: Noise | None) -> LineFit:
    own = design.weights[LENGTH]
    in_phase, u, dof = _summed(design, cells, [w[0] for w in own], noise)
    if not np.all(u > 1e-13 * np.abs(cells).max(axis=0)):
        raise DataError("nothing but drive and drift in the record", why="noise not estimated", code="no_scatter")
    across, u_across = None, None
    if len(own[0]) > 1:
        across, u_across, _ = _summed(design, cells, [w[1] for w in own], noise)
    shifts = []
    for length, others in design.weights.items():
        if length != LENGTH:
            for row in range(len(own[0])):
                apart = [other[row] - w[row] for other, w in zip(others, own, strict=True)]
                shifts.append(Shift(length, bool(row), *_summed(design, cells, apart, noise)))
    return LineFit(in_phase, u, across, u_across, dof, tuple(shifts), noise, cells, design)


def _summed(design: Design, cells: Array, weights: list[Array], noise: Noise | None) -> tuple[Array, Array, Array]:
    """Return sums of the readings, their standard uncertainties and degrees of freedom, shape (k,) each."""
    share = design.shares
    each = np.array([w @ (x - x[:1]) for w, x in zip(weights, (cells[part] for part in design.parts), strict=True)])
    value = np.asarray(share @ each)
    if noise is None:
        variance = share @ (each - value) ** 2 / (len(share) - 1.0)
        return value, np.sqrt(variance), np.full(len(value), len(share) - 1.0)
    white = float(sum(a**2 * (w @ w) for a, w in zip(share, weights, strict=True)))
    walk = float(sum(a**2 * (w @ one.walk @ w) for a, w, one in zip(share, weights, design.alike, strict=True)))
    variance, dof = noise.of(white, walk)
    return value, np.sqrt(variance), dof


def _checked(design: Design, readings: Array) -> Array:
    x = np.asarray(readings, dtype=np.float64)
    x = x[:, None] if x.ndim == 1 else x
    if x.ndim != 2 or len(x) != len(design.drive.times):
        what = f"{len(design.drive.times)} samples of the drive, {len(x)} readings"
        raise DataError(what, do="Give one of the drive for each reading", code="different_length")
    if not np.all(np.isfinite(x)):
        missing = int(np.count_nonzero(~np.isfinite(x).all(axis=1)))
        raise DataError(f"{missing} readings are missing", do="Leave them out of readings and drive", code="gaps")
    return x


def _too_short(drive: Drive, needed: float) -> DataError:
    period, cycles = 1.0 / drive.frequency, drive.cycles
    what = f"a record of {drive.span:.6g} s, a period of {period:.6g} s: {cycles:.3g} cycles"
    why = "it is shorter than one period" if cycles < 1.0 else "drive and drift cannot be separated"
    do = f"Record {needed:.3g} cycles or more: {needed * period:.6g} s"
    return DataError(what, why=why, do=do, code="too_few_cycles")
