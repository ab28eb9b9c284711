"""Rectification: change of the mean reading with the mean square of the vibration.

Means of segments, weighted::

    y_i = b_r + d_r t_i + K a_i^2 + C a_i^4      a_i^2: mean square of the control

b_r and d_r are bias and even drift of a run; C only where three levels or more, rest among them, allow it, and only
as a test: K is that of the fit without it. A sensor that reads ``k1 a + k2 a^2`` has K = k2, whatever the spectrum.
Variance of a mean: that of its block means over their number, and what segments scatter by beyond it (Mandel and
Paule [1]_), with the degrees of freedom of the residuals. Assumed: the bias drifts evenly, or wanders so that segments
scatter about that; blocks are longer than the noise remembers. Parts of a segment would not tell how far the bias
wanders from one segment to the next, so that each segment counts once: three levels between two rests leave 2 degrees
of freedom, and repeating levels in turn with rest narrows the interval most.

References
----------
.. [1] R. C. Paule and J. Mandel, J. Res. NBS 87 (1982) 377.
.. [2] IEEE Std 1293-2018, 12.3.14 (vibration rectification error); IEEE Std 528-2019.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import optimize, special

from ...core.estimate import Array
from ...core.key import NO_REASON, Reason
from .segments import Segment

ALPHA = 0.01  # chance of a false finding of curvature, or of an uneven drift
NO_REST = Reason("no_rest", "no part at rest before and after the vibration: a drift cannot be told from its effect")
NO_LEVEL = Reason("no_vibration", "no part under vibration is long enough")
FEW = Reason("few_segments", "as many unknowns as segments: what the bias does by itself was not observed. Repeat "
             "levels and rests, or leave the drift out: --no-drift")  # fmt: skip


@dataclass(frozen=True, eq=False)
class Point:
    """Mean of a segment: of which run, when [s], its mean square, reading and variance of it."""

    run: int
    time: float
    mean_square: float
    mean: float
    variance: float
    level: int


@dataclass(frozen=True, eq=False)
class Rectified:
    """What the means of segments say of one axis and direction."""

    points: tuple[Point, ...]
    value: float = np.nan  # K [unit/(m/s^2)^2]
    u: float = np.nan
    dof: float = 0.0
    wander: float = 0.0  # Standard deviation of segments beyond their noise [unit]
    curvature: tuple[float, float, float] | None = None  # C [unit/(m/s^2)^4], u, dof
    curved: bool = False
    uneven: bool = False  # The bias drifts, or steps, otherwise than evenly
    reason: Reason = NO_REASON
    levels: int = 0


def points_of(block_means: Array, mean_squares: Array, segments: list[Segment], block: float, run: int) -> list[Point]:
    """Return the means of segments of one run."""
    found = []
    for one in segments:
        x, squares = block_means[one.first : one.stop], mean_squares[one.first : one.stop]
        there = np.isfinite(x) & np.isfinite(squares)
        x = x[there]
        if len(x) >= 3:
            square = float(np.mean(squares[there]))
            middle = 0.5 * (one.first + one.stop) * block
            variance = float(np.var(x, ddof=1)) / len(x)
            found.append(Point(run, middle, square, float(np.mean(x)), variance, one.level))
    return found


def rectified(points: list[Point], drift: bool) -> Rectified:
    """Return K of one axis and direction, or why there is none."""
    whole = Rectified(tuple(points), levels=len({one.level for one in points if one.level}))
    if not any(one.level for one in points):
        return _open(whole, NO_LEVEL)
    runs = sorted({one.run for one in points})
    if not all(_embraced(points, run, drift) for run in runs):
        return _open(whole, NO_REST)
    y, square, variance = (np.array([getattr(one, name) for one in points])
                           for name in ("mean", "mean_square", "variance"))  # fmt: skip
    time = np.array([one.time for one in points])
    run = np.array([one.run for one in points])
    scale = float(np.max(square))
    columns = [np.asarray(run == each, dtype=float) for each in runs]
    middles = {each: 0.5 * (time[run == each].min() + time[run == each].max()) for each in runs}
    spans = {each: max(float(np.ptp(time[run == each])), 1e-9) for each in runs}
    at = np.array([(t - middles[r]) / spans[r] for t, r in zip(time, run, strict=True)])
    if drift:
        columns += [at * (run == each) for each in runs]
    X = np.column_stack([*columns, square / scale])
    n, p = X.shape
    if n <= p:
        return Rectified(whole.points, reason=FEW, levels=whole.levels)
    floor = max(float(np.max(variance)), float(np.finfo(float).eps * max(np.max(np.abs(y)), 1e-300)) ** 2) * 1e-9
    variance = np.maximum(variance, floor)
    b, covariance, tau = _mandel_paule(X, y, variance)
    dof = float(n - p)
    found = Rectified(
        whole.points, float(b[-1]) / scale, float(np.sqrt(covariance[-1, -1])) / scale, dof, float(np.sqrt(tau)),
        levels=whole.levels,
    )  # fmt: skip
    curvature, curved = None, False
    if whole.levels >= 2 and n > p + 1:
        c, cov, _ = _mandel_paule(np.column_stack([X, (square / scale) ** 2]), y, variance)
        u = float(np.sqrt(cov[-1, -1]))
        curvature = float(c[-1]) / scale**2, u / scale**2, dof - 1.0
        curved = _p_value(float(c[-1]), u, dof - 1.0) < ALPHA
    uneven = False
    if drift and n > p + len(runs):
        more = [(at**2 - 1.0 / 12.0) * (run == each) for each in runs]
        c, cov, _ = _mandel_paule(np.column_stack([X, *more]), y, variance)
        left = dof - len(runs)
        each_p = [_p_value(float(c[n_ + p]), float(np.sqrt(cov[n_ + p, n_ + p])), left) for n_ in range(len(runs))]
        uneven = min(each_p) < ALPHA / len(runs)
    return Rectified(found.points, found.value, found.u, dof, found.wander, curvature, curved, uneven,
                     NO_REASON, whole.levels)  # fmt: skip


def _open(whole: Rectified, reason: Reason) -> Rectified:
    return Rectified(whole.points, reason=reason, levels=whole.levels)


def _embraced(points: list[Point], run: int, drift: bool) -> bool:
    """Whether a run has rest before and after its vibration; one of both without drift."""
    mine = [one for one in points if one.run == run]
    rest = [one.time for one in mine if not one.level]
    loud = [one.time for one in mine if one.level]
    if not loud:
        return True
    if not drift:
        return bool(rest)
    return bool(rest) and min(rest) < min(loud) and max(rest) > max(loud)


def _mandel_paule(X: Array, y: Array, variance: Array) -> tuple[Array, Array, float]:
    """Return coefficients, covariance and the variance that points have beyond their own."""
    n, p = X.shape

    def solved(tau: float) -> tuple[Array, Array, float]:
        w = 1.0 / (variance + tau)
        root = np.sqrt(w)
        q, r = np.linalg.qr(X * root[:, None])
        b = np.linalg.solve(r, q.T @ (y * root))
        inverse = np.linalg.inv(r)
        return b, inverse @ inverse.T, float(np.sum(w * (y - X @ b) ** 2))

    tau = 0.0
    if solved(0.0)[2] > n - p:
        high = float(np.var(y)) + float(np.max(variance))
        while solved(high)[2] > n - p:
            high *= 4.0
        tau = float(optimize.brentq(lambda t: solved(t)[2] - (n - p), 0.0, high, xtol=1e-12 * high, rtol=1e-10))
    b, covariance, _ = solved(tau)
    return b, covariance, tau


def _p_value(value: float, u: float, dof: float) -> float:
    return 2.0 * float(special.stdtr(dof, -abs(value) / u)) if u > 0.0 else 1.0
