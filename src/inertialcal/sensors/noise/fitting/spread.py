"""Covariance of the Allan variances of runs, as powers of terms give it: quadratic in them, whatever they are.

What unit terms give together (``allan_covariance``) hangs on averaging times, numbers and gaps alone: records of one
length share it. Where a sensor has a filter (``filtered``), what it may take is added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ....core.estimate import Array
from .._kernels import Indices, fill_spread
from ..terms import Phase, Sinusoid, Term, averaged_over, means_of_exponential, total_phase
from .allan_covariance import Squares, sizes_of, squares_of, squares_of_each
from .filtered import SHAPE
from .problem import COMPLETE, LINEAR, Run, Taken, run_that_took

SAME_TAU = 0.01  # relative difference of averaging times that are alike
NONE = np.empty(0)
Triple = tuple[Array, Array, Array]  # Squares, parts and doubt of a `Spread` with a leading axis
Arrays = tuple[Indices, Indices, Triple]  # As ``_kernels_each`` takes them
HIDDEN = 2.5  # standard uncertainties of the noise: most that a filter may take unseen


@dataclass(frozen=True, eq=False)
class Spread:
    """What the powers of q terms are multiplied with, of k averaging times of all runs."""

    pairs: Indices  # shape (2, p): Averaging times of each pair, which are of one run
    runs: Indices  # shape (2, k): Which run each averaging time is of, and whether its filter is found
    squares: Array  # shape (q (q + 1) / 2, p): What terms give together, as in ``Squares`` [unit^4]
    # shape (q, k, 3): What a filter takes, or may take, and the slopes of that by the level and the curve of what it
    # leaves [unit^2]
    parts: Array
    doubt: Array  # shape (r, 2, 2): Covariance of level and curve, for each run

    def covariance(self, powers: Array, left: Array = NONE, tau: Array = NONE) -> Array:
        """Return the covariance of all Allan variances, shape (k, k).

        ``left`` is what terms leave unexplained at averaging times ``tau``, each shape (k,); none by default.
        """
        sigma = np.empty((self.runs.shape[1], self.runs.shape[1]))
        fill_spread(
            powers, self.squares, self.pairs, self.runs, self.parts, self.doubt, HIDDEN, SHAPE, left, tau, SAME_TAU,
            sigma,
        )  # fmt: skip
        return sigma


def spread_of(runs: tuple[Run, ...], lines: tuple[float, ...]) -> Spread:
    """Return that of the linear terms and lines."""
    return _of_linear(tuple([run.taken for run in runs]), lines)


@lru_cache(64)  # records of one length share them, but for what a filter may leave
def _of_linear(taken: tuple[Taken, ...], lines: tuple[float, ...]) -> Spread:
    return _spread(taken, (*(term(1.0) for term in LINEAR), *(Sinusoid(1.0, one) for one in lines)))


def spread_with(runs: Sequence[Run], terms: tuple[Term, ...]) -> Spread:
    """Return that of terms of size 1."""
    return _spread(tuple(run.taken for run in runs), terms)


@lru_cache(64)  # records of one length share them
def _spread(taken: tuple[Taken, ...], terms: tuple[Term, ...]) -> Spread:
    runs = [run_that_took(one) for one in taken]
    each = [_of_run(run, terms) for run in runs]
    sizes = [len(run.m) for run in runs]
    starts = np.cumsum([0, *sizes[:-1]])
    which = np.repeat(np.arange(len(runs)), sizes)
    return Spread(
        np.hstack([(one.row + start, one.column + start) for (one, *_), start in zip(each, starts, strict=True)]),
        np.array([which, np.array([run.band is not None for run in runs])[which]]),
        each[0][0].values if len(each) == 1 else np.concatenate([one.values for one, *_ in each], axis=1),
        np.concatenate([np.concatenate([lost[:, :, None], by], axis=2) for _, lost, by, _ in each], axis=1),
        np.array([doubt for *_, doubt in each]),
    )


def _of_run(run: Run, terms: tuple[Term, ...]) -> tuple[Squares, Array, Array, Array]:
    """Return what terms give together, what a filter takes of them, its slopes and their covariance."""
    # errors at gaps are independent from gap to gap, as white noise is
    ends = 0.0 if run.ends is None else float(np.max((run.ends - COMPLETE) / run.m))
    phases = tuple([_phase(term, run.interval, run.averaging, ends) for term in terms])
    by, doubt = np.zeros((len(terms), len(run.m), 2)), np.zeros((2, 2))
    if run.band is None:
        lost = np.zeros((len(terms), len(run.m))) if run.unseen is None else run.unseen.lost(phases, run.m)
        return _squares(phases, run.m.tobytes(), run.n.tobytes(), run.inflation.tobytes()), lost, by, doubt
    lost, by = run.band.lost(phases, run.m), run.band.slopes(phases, run.m)
    taken = lost[:, 0] * run.m[0] ** 2 / 3.0
    left = [one + Phase(point=-float(more)) for one, more in zip(phases, taken, strict=True)]
    return squares_of(left, run.m, run.n, run.inflation), lost, by, run.band.doubt


def spreads_beside(runs: Sequence[Run], terms: tuple[Term, ...], times: Array) -> Arrays:
    """Return what `spread_with` gives of linear terms and Gauss-Markov noise of a time each, with a leading axis.

    Runs are of one sampling, without a band, one each problem.
    """
    first, k, q = runs[0], len(runs[0].m), len(terms) + 1
    ends = 0.0 if first.ends is None else float(np.max((first.ends - COMPLETE) / first.m))
    phases = tuple([_phase(term, first.interval, first.averaging, ends) for term in terms])
    own, of = np.unique(times, return_inverse=True)
    averaging = averaged_over(first.interval, first.averaging)
    point, linear, size = means_of_exponential(averaging / own, first.interval / own)
    linear = linear + point * ends
    u = first.interval / own
    markov = [
        Phase(a, b, exponentials=((c, d),) if c > 0.0 else ())
        for a, b, c, d in zip(point.tolist(), linear.tolist(), size.tolist(), u.tolist(), strict=True)
    ]
    sizes = np.zeros((len(own), q, 5))
    sizes[:, :-1] = np.array(sizes_of(phases)).reshape(-1, 5)
    sizes[:, -1, 0], sizes[:, -1, 1] = -0.5 * linear, point
    values, brief = np.empty((len(own), q * (q + 1) // 2, k * (k + 1) // 2)), np.column_stack([size, u])[:, None]
    for some, each in ((size > 0.0, 1), (size <= 0.0, 0)):  # of brief correlation times no exponential is left
        if some.any():
            which, noises = np.full(each, q - 1), (*phases, markov[int(np.argmax(some))])
            row, column, values[some] = squares_of_each(
                noises, sizes[some], which, brief[some, :each], first.m, first.n, first.inflation
            )
    parts = np.zeros((len(runs), q, k, 3))
    alike: dict[tuple[int, int], Array] = {}  # several have the same time, or the same band
    for i, (run, at) in enumerate(zip(runs, of.tolist(), strict=True)):
        if run.unseen is not None:
            key = id(run.unseen), at
            if key not in alike:
                alike[key] = run.unseen.lost((*phases, markov[at]), run.m)
            parts[i, :, :, 0] = alike[key]
    spreads = values[of] if len(own) > 1 else values, parts, np.zeros((1, 1, 2, 2))
    return np.array([row, column]), np.zeros((2, k), np.int64), spreads


@lru_cache(64)
def _phase(term: Term, interval: float, averaging: float, ends: float) -> Phase:
    found = total_phase((term,), interval, averaging)
    return found + Phase(linear=found.point * ends) if found.point * ends else found


@lru_cache(32)  # records of one length share them
def _squares(phases: tuple[Phase, ...], m: bytes, n: bytes, inflation: bytes) -> Squares:
    return squares_of(phases, np.frombuffer(m), np.frombuffer(n), np.frombuffer(inflation))
