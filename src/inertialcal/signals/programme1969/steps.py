"""The four reductions of the 1969 programme, as printed. Series have shape (N,) or (N, k), N even; the report has 100.

Each takes the series with its mean removed and gives one with some mean left, which the analysis removes.
"""

from __future__ import annotations

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from .analysis import harmonics

ANCHOR = 9  # samples of each mean of the straight line


def tilt_trace(x: Array, tilt: Array) -> Array:
    """Return the series less its regression on the tilt trace (reduction 1).

    Parameters
    ----------
    x : ndarray, shape (N,)
        Its mean removed.
    tilt : ndarray, shape (N,)
        As the listing uses it: the readings, whose mean it does not remove (appendix A has a series without a mean).

    Raises
    ------
    DataError
        If all readings of the tilt meter are zero.
    """
    square = float(tilt @ tilt)
    if not square > 0.0:
        raise DataError("the tilt meter reads zero throughout", do="Leave reduction 1 out", code="no_scatter")
    return np.asarray(x - float(x @ tilt) / square * tilt)


def straight_line(x: Array) -> Array:
    """Return the series less a straight line through the means of its first and last nine samples (reduction 2).

    Raises
    ------
    DataError
        If the series is shorter than two such means.
    """
    n = len(x)
    if n < 2 * ANCHOR:
        raise DataError(f"{n} samples", why=f"the line runs through two means of {ANCHOR}", code="too_short")
    first, last = x[:ANCHOR].mean(axis=0), x[-ANCHOR:].mean(axis=0)
    along = (np.arange(n) - ANCHOR // 2) / (n - ANCHOR)
    return np.asarray(x - first - (along * (last - first) if x.ndim == 1 else np.outer(along, last - first)))


def without_harmonics(x: Array, lines: int) -> Array:
    """Return the series less its lines 1 ... MA and N/2 - MA ... N/2: one more above than below (reduction 3).

    As the last line has twice its amplitude, taking it away turns its sign.

    Parameters
    ----------
    x : ndarray, shape (N,) or (N, k)
        As the last step left it.
    lines : int
        MA, 0 to N/2 - 1.

    Raises
    ------
    DataError
        If there are not so many lines.
    """
    n = len(x)
    if n % 2 or not 0 <= lines < n // 2:
        raise DataError(f"{lines} lines of {n} samples", do=f"Need an even number of samples, 0 to {n // 2 - 1} lines")
    cosine, sine = harmonics(x)
    K = np.r_[1 : lines + 1, n // 2 - lines : n // 2 + 1]  # bands that meet are taken away twice
    angle = 2.0 * np.pi / n * (np.outer(np.arange(n), K) % n)
    return np.asarray(x - np.cos(angle) @ cosine[K - 1] - np.sin(angle) @ sine[K - 1])


def adjusted_curve(x: Array, half_width: int) -> Array:
    """Return the series less a centred moving mean that shrinks towards both ends (reduction 4).

    Inside the window has 2 JA + 1 full points and a half point at each end. Near an end it is the widest one that fits;
    the first and last two points have rules of their own, which are not mirror images: thirds at the second point,
    a quarter, a half and a quarter at the last but one. For the half points near both ends the listing prints indices
    that are not those of a centred window; here they are (the outermost sample, and its mirror image).

    Parameters
    ----------
    x : ndarray, shape (N,) or (N, k)
        Its mean removed.
    half_width : int
        JA; 2 (JA + 1) should be a multiple of the samples per cycle, or the input is taken away too.

    Raises
    ------
    DataError
        If the window does not fit twice.
    """
    return np.asarray(x - moving_mean_weights(len(x), half_width) @ x)


def moving_mean_weights(n: int, half_width: int) -> Array:
    """Return the weights of the moving mean, a row a sample; shape (N, N).

    Raises
    ------
    DataError
        If the window does not fit twice.
    """
    JA = half_width
    if not JA >= 1 or n - 2 < 2 * (JA + 2):
        raise DataError(f"half width {JA} of {n} samples", do="Need 1 or more, and half the record for the window")
    weights = np.zeros((n, n))
    for i in range(n):
        reach = min(i, n - 1 - i, JA + 1)
        weights[i, i - reach : i + reach + 1] = 1.0 / max(2 * reach, 1)
        weights[i, [i - reach, i + reach]] *= 0.5
    weights[0, :2] = weights[-1, -2:] = 0.5
    weights[1, :3] = 1.0 / 3.0
    return weights
