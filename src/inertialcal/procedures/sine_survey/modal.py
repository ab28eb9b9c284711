"""Resonances between a control channel and a response: a modal model fitted to the whole record.

With the spectra U of the control and Y of the response of a sweep, ``Y = H U``, where with s = i f::

    H(f) = sum_k (a_k + b_k s) / (f_k^2 - f^2 + s f_k / Q_k) + c_-2 / s^2 + c_-1 / s + c_0 + c_1 s + c_2 s^2

f_k is the undamped natural frequency of a mode and Q_k = 1 / (2 zeta_k) its amplification [1]_; what lies below and
above the band is in the c. Whatever the control channel did, harmonics and ripple of the controller with it, went
through the item too: the equation holds for the whole record, and nothing has to be quasi-steady. A tracking filter
is: at 4 octaves a minute it reads a Q of 30 at 80 Hz 20 % low. It is used for the picture alone. Tried on simulated
truth (``tests/procedures/sine_survey``): the ratio of tracked amplitudes fitted by the same model is off by -4 % of Q
at Q = 10 and -36 % at Q = 50; this fit by less than 0.1 %.

Where a record begins or ends while the drive is on, what swung before it swings on: each mode gets a free decay of
its own, ``(p_k + q_k s) / (...)``, without U.

Noise of the control channel would make H too small, most where it is largest: its density is found from what is left,
which rises with ``|H|^2`` where the control is noisy, and its part is taken out of the sum of squares (corrected least
squares [2]_). The noise need be neither white nor steady. The covariance is the sandwich with the power of what is
left in cells of time and frequency: where the drive passes a resonance only the noise of that time counts, and hum or
chatter elsewhere does not.

Channels are sampled at the same instants. A delay d turns the phase of H by ``2 pi d f / Q`` across a resonance, which
a and b take up at its frequency alone.

What breaks it: an item that is not linear (an upward and a downward sweep then differ, which is tested); a mode nearer
than its width to an end of the sweep (refused); two modes nearer than the noise can part (they are one, with its Q).

References
----------
.. [1] D. J. Ewins, Modal Testing, 2nd ed., 2000, chapters 2 and 4: residues, and terms for modes out of the band.
.. [2] R. Pintelon and J. Schoukens, System Identification, 2nd ed., 2012, chapter 9: errors in variables.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import fft, linalg, optimize

from ...core.estimate import Array

Complex = NDArray[np.complex128]

BACKGROUND = (-2, -1, 0, 1, 2)  # powers of s
FINE = 1500.0  # joined lines in a factor of e of the frequency, far from poles
INSIDE = 60.0  # joined lines in half the width of a pole
TRIED = 3  # places where a mode may be missing, that are tried before the search ends
MOST = 12  # modes of a response
BEYOND = 0.2  # of the band, by which a mode may lie outside of it
DAMPED, SHARP = 1.5, 2000.0  # limits of Q
SEEN = 45.0  # chi-square of two terms that nothing else in the record reaches by chance: a search of 1e6 cells
BETTER = 40.0  # by which a mode of four terms must lower the sum of squares
NOISIEST = 0.1  # share of the power of the control that may be its noise
RESOLVED = 0.2  # relative standard uncertainty of Q, from which a mode is none: noise has chance likenesses of one
WIDTHS = (6.0, 20.0, 60.0, 200.0)  # frequency over the width that is looked at
CELL = 0.5  # of time, in which the noise is taken as steady, at most [s]
PART = 0.5  # of what a figure rests on, that a cell lasts
CYCLES = 4.0  # of the lowest frequency, that a cell lasts at least
BINS = 2  # of frequency on each side, over which its density is smooth
MOST_TAKEN = 0.7  # share of the noise of a cell that the fit may have taken
NEAREST = 3  # cells of time that are averaged


@dataclass(frozen=True, eq=False)
class Band:
    """Spectra of a sweep inside its band, shape (m,), and what is needed to go back to time."""

    frequency: Array
    control: Complex
    response: Complex
    length: int  # Samples of the record
    rate: float  # Samples a second [Hz]
    first: int  # Line of the first frequency
    open_end: bool  # The drive is on where the record begins or ends
    count: Array  # shape (m,): lines that were joined to each


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of one response with their covariance.

    ``parameters`` are frequency, Q and peak of each mode in turn, shape (3 k,); ``covariance`` (3 k, 3 k).
    """

    frequency: Array  # shape (k,) [Hz]
    amplification: Array  # shape (k,)
    peak: Array  # shape (k,): size of the transmissibility at the frequency of the mode
    own: Array  # shape (k,): part of the mode in it
    covariance: Array
    dof: Array  # shape (3 k,)
    background: Array  # c, of powers of s over `middle`
    middle: float  # [Hz]
    residues: Array  # shape (k, 2): a, b
    control_noise: float  # Standard deviation of a sample of the control that is noise
    noise: float  # The same of what is left
    explained: float  # Share of the power of the response

    def __len__(self) -> int:
        """Return the number of modes."""
        return len(self.frequency)

    def transmissibility(self, frequency: Array) -> Complex:
        """Return the model at some frequencies."""
        poles = np.column_stack([self.frequency, self.amplification])
        terms = _terms(frequency, poles, self.middle)
        return np.asarray(terms @ np.concatenate([self.residues.ravel(), self.background]))


def spectra(control: Array, response: Array, rate: float, lowest: float, highest: float, *, open_end: bool) -> Band:
    """Return the spectra of a record inside a band.

    Parameters
    ----------
    control, response : ndarray, shape (n,)
        In time, without missing samples.
    rate : float
        Samples a second [Hz].
    lowest, highest : float
        Of the band [Hz].
    open_end : bool
        Whether the drive is on where the record begins or ends.
    """
    n = len(control)
    lines = np.arange(max(1, math.ceil(lowest * n / rate)), min(n // 2, math.floor(highest * n / rate)) + 1)
    both = [fft.rfft(one - one.mean())[lines] for one in (control, response)]
    return Band(lines * rate / n, both[0], both[1], n, rate, int(lines[0]), open_end, np.ones(len(lines)))


def find_modes(bands: Sequence[Band], most: int = MOST, least: float = 0.0) -> Modes:
    """Return the modes of a response, from all its sweeps together.

    Parameters
    ----------
    bands : sequence of Band
        A sweep each.
    most : int
        Modes that are looked for.
    least : float
        Part of a mode in the transmissibility at its frequency, below which it is no mode of its own.
    """
    poles = np.zeros((0, 2))
    for weighed in (False, True):  # what is left is no noise before the largest modes are known
        while len(poles) < most:
            problem = _Problem([_joined(one, poles) for one in bands])
            problem.start(poles)
            if weighed:
                problem.weigh(corrected=False)  # a mode that is missing would pass for noise of the control
            poles = problem.improve(poles)
            before, kept = problem.cost, poles
            for candidate in problem.candidates()[:TRIED]:
                tried = problem.improve(np.vstack([poles, candidate]))
                if problem.cost < before - BETTER and problem.own(len(tried) - 1) > least:
                    kept = tried
                    break
            if kept is poles:
                break
            poles = kept
    poles = _needed(bands, poles)
    while True:
        found = _finished(bands, poles)
        unknown = np.sqrt(np.diag(found.covariance)[1::3]) / found.amplification
        if not len(found) or unknown.max() < RESOLVED:
            return found
        poles = np.delete(np.column_stack([found.frequency, found.amplification]), int(np.argmax(unknown)), axis=0)


def _needed(bands: Sequence[Band], poles: Array) -> Array:
    """Return the poles without those that are not needed once the noise of the control is known."""
    while len(poles):
        problem = _Problem([_joined(one, poles) for one in bands])
        problem.start(poles)
        problem.weigh()
        poles = problem.improve(poles)
        cost = problem.cost
        weakest = int(np.argmin([problem.own(k) / poles[k, 1] for k in range(len(poles))]))
        fewer = problem.improve(np.delete(poles, weakest, axis=0))
        if problem.cost > cost + BETTER:
            break
        poles = fewer
    return poles


def _finished(bands: Sequence[Band], poles: Array) -> Modes:
    """Return the modes near where they are known to be, with their covariance from all lines."""
    for _ in range(2):
        problem = _Problem([one if one.open_end else _joined(one, poles) for one in bands])
        problem.start(poles)
        for _ in range(2):
            problem.weigh()
            poles = problem.improve(poles)
    problem = _Problem(bands)
    problem.start(poles)
    problem.weigh()
    return problem.modes(poles)


def _joined(band: Band, poles: Array) -> Band:
    """Return a band whose lines are joined where H is one number over them, finer near known poles.

    With ``u^2 = sum |U|^2`` and ``y = sum conj(U) Y / u`` the sum of squares of the joined lines is that of
    ``|y - H u|^2`` and what no H explains.
    """
    f = band.frequency
    width = f / FINE
    for pole, q in poles:
        width = np.minimum(width, np.hypot(f - pole, 0.5 * pole / q) / INSIDE)
    group = np.floor(np.concatenate([[0.0], np.cumsum(np.diff(f) / width[1:])])).astype(np.int64)
    starts = np.flatnonzero(np.diff(group, prepend=-1))
    counts = np.diff(np.append(starts, len(group)))
    size = np.sqrt(np.maximum(np.add.reduceat(np.abs(band.control) ** 2, starts), 1e-300))
    products: Complex = band.control.conj() * band.response
    joined = np.asarray(np.add.reduceat(products, starts) / size, dtype=np.complex128)
    middle = np.add.reduceat(f * np.abs(band.control) ** 2, starts) / size**2
    return replace(
        band,
        frequency=middle,
        control=size.astype(complex),
        response=joined,
        open_end=False,
        count=counts.astype(float),
    )


def _terms(frequency: Array, poles: Array, middle: float) -> Complex:
    """Return the columns of H for one unit of each coefficient, shape (m, 2 k + background)."""
    s = 1j * frequency
    columns = []
    for f, q in poles:
        under = f * f - frequency**2 + s * (f / q)
        columns += [f * f / (q * under), f * s / (q * under)]
    columns += [(s / middle) ** power for power in BACKGROUND]
    return np.column_stack(columns)


class _Problem:
    """Least squares of one response: lines of all sweeps, their weights, the last solution."""

    def __init__(self, bands: Sequence[Band]) -> None:
        self.bands = bands
        self.f = np.concatenate([one.frequency for one in bands])
        self.u = np.concatenate([one.control for one in bands])
        self.y = np.concatenate([one.response for one in bands])
        self.low, self.high = float(self.f.min()), float(self.f.max())
        self.middle = math.sqrt(self.low * self.high)
        ends = np.cumsum([0, *(len(one.frequency) for one in bands)])
        self.parts = [slice(a, b) for a, b in pairwise(ends.tolist())]
        self.weight = np.concatenate([np.full(len(one.frequency), 1.0 / one.length) for one in bands])
        self.count = np.concatenate([one.count for one in bands])
        self.noisy = np.zeros(len(self.f))  # power of noise of the control in the lines joined
        self.cost = math.inf
        self.linear = np.zeros(0)
        self.left = self.y
        self.h = np.zeros_like(self.y)

    def start(self, poles: Array | None = None) -> None:
        """Fit the linear terms, and scale the weights so that the cost counts lines."""
        self.solve(np.zeros((0, 2)) if poles is None else poles)
        self.weight = self.weight * (len(self.f) / max(self.cost, 1e-300))
        self.solve(np.zeros((0, 2)) if poles is None else poles)

    # ---- the model -------------------------------------------------------------------------------------------------

    def columns(self, poles: Array) -> tuple[Complex, Complex]:
        """Return the columns of H, and those of free decays, which have no U."""
        terms = _terms(self.f, poles, self.middle)
        free = []
        for band, part in zip(self.bands, self.parts, strict=True):
            if not band.open_end:
                continue
            for k in range(2 * len(poles)):
                column = np.zeros(len(self.f), dtype=complex)
                column[part] = terms[part, k]
                free.append(column)
        return terms, np.column_stack(free) if free else np.zeros((len(self.f), 0), dtype=complex)

    def solve(self, poles: Array) -> None:
        """Fit the linear terms for given poles."""
        terms, free = self.columns(poles)
        design = np.hstack([terms * self.u[:, None], free])
        gram = (design.conj() * self.weight[:, None]).T @ design
        gram = gram.real
        k, scale = terms.shape[1], _root(np.diag(gram))
        gram[:k, :k] -= ((terms.conj() * (self.weight * self.noisy)[:, None]).T @ terms).real
        right = ((design.conj() * self.weight[:, None]).T @ self.y).real
        self.linear = linalg.lstsq(gram / np.outer(scale, scale), right / scale, cond=1e-13)[0] / scale
        self._set(terms, free)

    def _set(self, terms: Complex, free: Complex) -> None:
        k = terms.shape[1]
        self.h = terms @ self.linear[:k]
        self.left = self.y - self.h * self.u - free @ self.linear[k:]
        self.cost = self._cost(self.left, self.h)

    def _cost(self, left: Complex, h: Complex) -> float:
        return float(np.sum(self.weight * (np.abs(left) ** 2 - self.noisy * np.abs(h) ** 2)))

    def jacobian(self, poles: Array, terms: Complex, free: Complex) -> tuple[Complex, Complex]:
        """Return changes of H U + decays, and those of H, by logarithms of f, Q of each mode and linear terms."""
        h_changes = []
        of_free: list[Complex] = []
        s = 1j * self.f
        for k, (f, q) in enumerate(poles):
            under = f * f - self.f**2 + s * (f / q)
            shape = terms[:, 2 * k : 2 * k + 2] @ self.linear[2 * k : 2 * k + 2]
            slopes = (2.0 * f * f + s * f / q), (-s * f / q)  # of `under`, by log f and log Q
            own = terms[:, 2 * k] * self.linear[2 * k] * 2.0 + terms[:, 2 * k + 1] * self.linear[2 * k + 1]
            h_changes += [own - shape * slopes[0] / under, -shape - shape * slopes[1] / under]
            width = 2 * len(poles)
            swing = np.zeros(len(self.f), dtype=complex)
            swing_own = np.zeros(len(self.f), dtype=complex)
            for j in range(free.shape[1] // max(width, 1)):
                at = j * width + 2 * k
                weights = self.linear[terms.shape[1] + at : terms.shape[1] + at + 2]
                swing += free[:, at : at + 2] @ weights
                swing_own += free[:, at] * weights[0] * 2.0 + free[:, at + 1] * weights[1]
            of_free += [swing_own - swing * slopes[0] / under, -swing - swing * slopes[1] / under]
        of_h = np.column_stack([*h_changes, terms])
        whole = of_h * self.u[:, None]
        whole[:, : len(of_free)] += np.column_stack(of_free) if of_free else 0.0
        none = np.zeros((len(self.f), free.shape[1]), dtype=complex)
        return np.hstack([whole, free]), np.hstack([of_h, none])

    def normal(self, poles: Array) -> tuple[Array, Array, Array, Complex]:
        """Return the normal matrix, the scale of each unknown, the gradient, and the changes of the model."""
        terms, free = self.columns(poles)
        jacobian, of_h = self.jacobian(poles, terms, free)
        weighted = jacobian.conj() * self.weight[:, None]
        noisy = of_h.conj() * (self.weight * self.noisy)[:, None]
        matrix = (weighted.T @ jacobian).real
        scale = _root(np.diag(matrix))
        matrix = matrix - (noisy.T @ of_h).real
        gradient = (weighted.T @ self.left).real + (noisy.T @ self.h).real
        return matrix, scale, gradient, jacobian

    def improve(self, poles: Array, turns: int = 25) -> Array:
        """Return poles that lower the cost, by Levenberg and Marquardt; the linear terms are solved for."""
        self.solve(poles)
        if not len(poles):
            return poles
        damping = 1e-3
        for _ in range(turns):
            matrix, scale, gradient, _ = self.normal(poles)
            unit = matrix / np.outer(scale, scale)
            before, linear, left, h = self.cost, self.linear, self.left, self.h
            while True:
                step = linalg.lstsq(unit + damping * np.eye(len(unit)), gradient / scale, cond=1e-14)[0] / scale
                step = np.clip(step[: 2 * len(poles)], -0.5, 0.5)
                tried = self._inside(poles * np.exp(step.reshape(-1, 2)))
                self.solve(tried)
                if self.cost <= before or damping > 1e3:
                    break
                damping *= 6.0
            if not self.cost <= before:
                self.cost, self.linear, self.left, self.h = before, linear, left, h
                break
            damping = max(damping * 0.2, 1e-9)
            moved, poles = before - self.cost, tried
            if moved < 1e-3 + 1e-9 * abs(before):
                break
        return poles

    def _inside(self, poles: Array) -> Array:
        limits = np.array([[self.low * (1.0 - BEYOND), DAMPED], [self.high * (1.0 + BEYOND), SHARP]])
        return np.asarray(np.clip(poles, *limits))

    def own(self, k: int) -> float:
        """Return the size of the part of a mode in H at its frequency."""
        a, b = self.linear[2 * k : 2 * k + 2]
        return math.hypot(a, b)

    # ---- noise -------------------------------------------------------------------------------------------------------

    def weigh(self, *, corrected: bool = True) -> None:
        """Set weights by the power of what is left, and the part of the control's noise in it."""
        weight, noisy = np.empty(len(self.f)), np.zeros(len(self.f))
        for band, part in zip(self.bands, self.parts, strict=True):
            power = np.abs(self.left[part]) ** 2 / band.length
            square = np.abs(self.h[part]) ** 2
            logs = np.log(self.f[part])
            knots = np.linspace(logs[0], logs[-1], 5)
            hats = np.maximum(1.0 - np.abs(logs[:, None] - knots) / (knots[1] - knots[0]), 0.0)
            basis = np.column_stack([hats, square])
            size = np.full(len(power), max(float(np.mean(power)), 1e-300))
            found = np.zeros(basis.shape[1])
            for _ in range(8):  # powers scatter by themselves: weights by what is expected
                root = 1.0 / size
                found = optimize.nnls(basis * root[:, None], power * root)[0]
                size = np.maximum(basis @ found, 1e-6 * max(float(np.mean(power)), 1e-300))
            smooth = np.maximum(_smooth(power / size, max(20, len(power) // 400)), 0.05) * size
            weight[part] = 1.0 / (smooth * band.length)
            most = NOISIEST * float(np.median(np.abs(self.u[part]) ** 2 / self.count[part]))
            noisy[part] = min(found[-1] * band.length, most) * self.count[part] if corrected else 0.0
        self.weight, self.noisy = weight, noisy

    # ---- where a mode is missing ---------------------------------------------------------------------------------

    def candidates(self) -> Array:
        """Return frequencies and Q where what is left follows the control, the clearest first; shape (j, 2)."""
        power = np.maximum(np.abs(self.left) ** 2, 1e-300)
        found = []
        for part in self.parts:
            f, w = self.f[part], self.weight[part]
            sums = [np.concatenate([[0.0], np.cumsum(one)]) for one in (
                self.u[part].conj() * self.left[part], np.abs(self.u[part]) ** 2, power[part], w)]  # fmt: skip
            for width in WIDTHS:
                a, b = (np.searchsorted(f, f * (1.0 + side / width)) for side in (-0.5, 0.5))
                a, b = np.minimum(a, np.maximum(np.arange(len(f)) - 1, 0)), np.maximum(b, np.arange(len(f)) + 1)
                wide = [np.searchsorted(f, f * (1.0 + side / width)) for side in (-2.0, 2.0)]
                together, control, _, weights = (one[b] - one[a] for one in sums)
                gain = 2.0 * np.abs(together) ** 2 / np.maximum(control, 1e-300)
                rest = (sums[2][wide[1]] - sums[2][wide[0]]) / np.maximum(wide[1] - wide[0], 1)
                score = np.where(gain > SEEN * rest, gain * weights / (b - a), 0.0)
                for _ in range(2):
                    best = int(np.argmax(score))
                    if score[best] <= 0.0:
                        break
                    found.append((float(score[best]), float(f[best]), width))
                    score[wide[0][best] : wide[1][best]] = 0.0
        found.sort(reverse=True)
        chosen: list[tuple[float, float]] = []
        for _, frequency, width in found:
            if all(abs(frequency / other - 1.0) > 0.5 / width for other, _ in chosen):
                chosen.append((frequency, width))
        return np.array(chosen).reshape(-1, 2)

    # ---- the result ----------------------------------------------------------------------------------------------

    def modes(self, poles: Array) -> Modes:
        """Return the modes in order of frequency, with their covariance."""
        order = np.argsort(poles[:, 0])
        poles = poles[order]
        self.solve(poles)
        k = len(poles)
        matrix, scale, _, jacobian = self.normal(poles)
        inverse = linalg.pinvh(matrix / np.outer(scale, scale)) / np.outer(scale, scale)
        a, b = self.linear[0 : 2 * k : 2], self.linear[1 : 2 * k : 2]
        peaks = self._peaks(poles)
        contrasts = np.zeros((3 * k, len(inverse)))
        for i in range(k):
            contrasts[3 * i, 2 * i] = poles[i, 0]
            contrasts[3 * i + 1, 2 * i + 1] = poles[i, 1]
            contrasts[3 * i + 2] = self._peak_changes(poles, i, len(inverse))
        influence = contrasts @ inverse @ (jacobian.conj() * self.weight[:, None]).T  # (3 k, lines)
        covariance, dof = self._covariance(influence, _orthonormal(jacobian, matrix, scale))
        residual = sum(float(np.sum(np.abs(self.left[part]) ** 2)) for part in self.parts)
        whole = float(np.sum(np.abs(self.y) ** 2))
        lines = sum(one.length * len(one.frequency) for one in self.bands)
        noisy = [self.noisy[part][0] / (band.length * self.count[part][0])
                 for band, part in zip(self.bands, self.parts, strict=True)]  # fmt: skip
        return Modes(
            poles[:, 0], poles[:, 1], peaks, np.hypot(a, b), covariance, dof,
            self.linear[2 * k : 2 * k + len(BACKGROUND)], self.middle, np.column_stack([a, b]).reshape(k, 2),
            math.sqrt(float(np.mean(noisy))), math.sqrt(residual / max(lines, 1)), 1.0 - residual / max(whole, 1e-300),
        )  # fmt: skip

    def _peaks(self, poles: Array) -> Array:
        terms = _terms(poles[:, 0], poles, self.middle)
        return np.abs(terms @ self.linear[: terms.shape[1]])

    def _peak_changes(self, poles: Array, i: int, count: int) -> Array:
        """Return the changes of the size of H at the frequency of a mode, by all parameters of the fit."""
        k, found = len(poles), np.zeros(count)
        base = self._peaks(poles)[i]
        step = 1e-6
        for j in range(2 * k):
            moved = poles.copy()
            moved[j // 2, j % 2] *= math.exp(step)
            found[j] = (self._peaks(moved)[i] - base) / step
        terms = _terms(poles[i : i + 1, 0], poles, self.middle)[0]
        value = terms @ self.linear[: len(terms)]
        found[2 * k : 2 * k + len(terms)] = (terms * np.conj(value) / abs(value)).real
        return found

    def _covariance(self, influence: Complex, basis: Complex) -> tuple[Array, Array]:
        """Return the sandwich of functions of what is left, with its power in cells of time and frequency.

        A figure moves by ``Re sum_f c(f) R(f)``, which is a sum over time; cut into overlapping cells, each with its
        spectrum, the variance is that of the cells, whose power is that of what is left, averaged over neighbours. The
        fit has taken a share of the noise of a cell with it, its leverage, which counts again.
        """
        p = len(influence)
        total, weights = np.zeros((p, p)), np.zeros((p, 2))
        for band, part in zip(self.bands, self.parts, strict=True):
            left = self._in_time(band, self.left[part])
            functions = [self._in_time(band, row.conj()) for row in influence[:, part]]
            size = self._cell(functions, band)
            window = np.sin(np.pi * (np.arange(size) + 0.5) / size)
            cells, shape = _cells(left, window), self._shape(band, part, size)
            power = np.abs(cells) ** 2 / shape
            low, high = band.frequency[0] * size / band.rate, band.frequency[-1] * size / band.rate
            inside = slice(max(int(low), 0), min(int(high) + 2, cells.shape[1]))
            taken = sum(np.abs(_cells(self._in_time(band, one), window)) ** 2 for one in basis[part].T)
            noise = (
                shape * size / band.length * float(np.mean(1.0 / self.weight[part]))
            )  # two parts of a line, of one each
            leverage = np.minimum(_smooth_cells(taken / noise), MOST_TAKEN)
            there = (_smooth_cells(power) / (1.0 - leverage))[:, inside] * shape[inside]
            own = [_cells(one, window)[:, inside] for one in functions]
            factor = (band.length / size) ** 2
            for i in range(p):
                back = _smooth_cells(np.abs(own[i]) ** 2 * shape[inside])
                each = back * power[:, inside]
                weights[i] += each.sum(), (each**2).sum()
                for j in range(i, p):
                    total[i, j] += factor * float(np.sum((own[i] * own[j].conj()).real * there))
                    total[j, i] = total[i, j]
        # squares of powers: E(P^2) = 2 E(P)^2
        dof = weights[:, 0] ** 2 / np.maximum(weights[:, 1] / 2.0, 1e-300)
        return total, np.maximum(dof, 1.0)

    def _cell(self, functions: Sequence[Array], band: Band) -> int:
        """Return the samples of a cell: shorter than what a figure rests on lasts, as noise may follow the level."""
        lasting = min((float(np.sum(one**2) ** 2 / np.sum(one**4)) for one in functions), default=math.inf)
        size: int = round(min(max(PART * lasting, CYCLES * band.rate / band.frequency[0]), CELL * band.rate))
        return size + size % 2

    def _shape(self, band: Band, part: slice, size: int) -> Array:
        """Return the expected shape of what is left over the bins of a cell: noise of the control follows H."""
        expected = 1.0 / (self.weight[part] * band.length)
        edges = np.searchsorted(band.frequency, (np.arange(size // 2 + 2) - 0.5) * band.rate / size)
        sums = np.concatenate([[0.0], np.cumsum(expected)])
        counts = np.diff(edges)
        whole = float(np.mean(expected))
        return np.where(counts > 0, np.diff(sums[edges]) / np.maximum(counts, 1) / whole, 1.0)

    def _in_time(self, band: Band, lines: Complex) -> Array:
        whole = np.zeros(band.length // 2 + 1, dtype=complex)
        whole[band.first : band.first + len(lines)] = lines
        return np.asarray(fft.irfft(whole, band.length))


def _orthonormal(jacobian: Complex, matrix: Array, scale: Array) -> Complex:
    """Return columns that span those of a Jacobian, orthonormal with its weights as real functions."""
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    kept = values > np.finfo(float).eps * len(values) * float(values.max())
    return np.asarray(jacobian / scale @ (vectors[:, kept] / np.sqrt(values[kept])))


def _root(squares: Array) -> Array:
    return np.sqrt(np.maximum(squares, 1e-30 * max(float(np.max(squares)), 1e-270)))


def _cells(values: Array, window: Array) -> Complex:
    """Return spectra of half-overlapping cells, whose windows squared add up to one; shape (cells, bins)."""
    size, half = len(window), len(window) // 2
    count = -(-(len(values) + half) // half)
    padded = np.zeros((count + 1) * half)
    padded[half : half + len(values)] = values
    frames = np.lib.stride_tricks.sliding_window_view(padded, size)[::half]
    return np.asarray(fft.rfft(frames * window, axis=1))


def _smooth_cells(power: Array) -> Array:
    """Return powers averaged over neighbours in frequency and in time."""
    return _box(_box(power, BINS, 1), NEAREST // 2, 0)


def _box(values: Array, half: int, axis: int) -> Array:
    moved = np.moveaxis(values, axis, 0)
    total = np.concatenate([np.zeros((1, *moved.shape[1:])), np.cumsum(moved, axis=0)])
    index = np.arange(len(moved))
    a, b = np.maximum(index - half, 0), np.minimum(index + half + 1, len(moved))
    return np.moveaxis((total[b] - total[a]) / (b - a).reshape(-1, *[1] * (moved.ndim - 1)), 0, axis)


def _smooth(values: Array, half: int) -> Array:
    return _box(values, half, 0)


__all__ = ["Band", "Modes", "find_modes", "spectra"]
