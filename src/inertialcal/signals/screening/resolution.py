"""Level below which a line in the spectrum of a channel means nothing: resolution of its numbers, and its converter.

*Rounding.* Numbers of step D scatter by ``D^2 / 12``, spread evenly over the spectrum, a density of ``D^2 dt / 6``,
where the signal crosses several steps from sample to sample [1]_. Where the noise lies no higher than a few times that,
the rounding of a slow signal makes lines by itself, of up to ``2 D / pi``: lines smaller than D mean nothing there. In
noise well above it, lines far below a step are real.

*Converter.* Non-linearity makes lines of whatever the channel carries. The best converters keep them 120 dB below the
largest input: what is smaller than 1e-6 of the largest swing of the record may be made there, however little noise is
around. So it is in the stop band of a filter, where no noise hides them.

References
----------
.. [1] B. Widrow, I. Kollar and M.-C. Liu, IEEE Trans. Instrum. Meas. 45 (1996) 353: statistical theory of quantization.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...core.batches import batches, extremes, finite, kept, known_finite, near
from ...core.estimate import Array
from ..time.samples import Flags
from .blocks import pieces

ROUNDED = 4.0  # times the density of rounding, below which noise does not hide what rounding makes
OFF, MOST = 0.05, 0.9  # of a step that differences are off a whole number, and the part of them that codes allow
FIRST = 4  # part of the differences that is looked at first
CONVERTED = 4.0  # units in the last place, by which a conversion of units and back may be off
SPURIOUS = 1e-6  # of the largest swing: 120 dB


@dataclass(frozen=True)
class Resolution:
    """Resolution of the numbers of a channel."""

    step: float  # smallest difference that they show where they are largest [unit]
    swing: float  # largest deviation from the mean [unit]

    def density(self, interval: float) -> float:
        """Return the one-sided density of rounding [unit^2/Hz] of samples an ``interval`` apart [s]."""
        return self.step**2 * interval / 6.0

    def hides(self, amplitude: ArrayLike, background: ArrayLike, interval: float) -> Flags:
        """Return which lines mean nothing.

        Parameters
        ----------
        amplitude : array_like
            Of each line [unit].
        background : array_like
            Density of the noise around each [unit^2/Hz].
        interval : float
            From sample to sample [s].
        """
        size, around = np.asarray(amplitude, dtype=np.float64), np.asarray(background, dtype=np.float64)
        rounded = (around <= ROUNDED * self.density(interval)) & (size < self.step)
        return np.asarray(rounded | (size < SPURIOUS * self.swing))


def resolution_of(x: NDArray[Any], times: float = 1.0) -> Resolution:
    """Return the resolution of a channel.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Samples: the step is that of the codes, of the digits that were printed, or of the floats, 32 bits long where
        64 bits hold nothing more.
    times : float
        What a sample is multiplied by to be as stored.
    """
    given, (middle, low, high) = x, _middle_and_ends(x)
    if not np.isfinite(middle):  # of a record without missing samples they need not be looked for
        given = kept(x, finite(x))
        middle, low, high = _middle_and_ends(given)
    if not len(given):
        return Resolution(0.0, 0.0)
    largest = max(abs(low), abs(high))
    _, rows = pieces(given)
    stored, largest = rows * times, largest * times
    apart = np.abs(np.diff(rows, axis=1))
    apart = apart[apart > 0.0]
    step = float(apart.min()) if len(apart) else 0.0
    if step and not _are_whole(apart, step):
        step = 0.0  # no codes
    if x.dtype.kind == "f":
        short = x.dtype == np.float32 or all(_are_short(some) for some in (stored[:1], stored))
        step = max(step, float(np.spacing(np.float32(largest) if short else np.float64(largest))) / times)
    return Resolution(step, max(high - middle, middle - low))


def _are_whole(apart: Array, step: float) -> bool:
    """Return whether most of some differences are whole numbers of a step; a few tell that too many are not."""
    for some in (apart[: len(apart) // FIRST], apart):
        off = np.count_nonzero(~(np.abs(some / step - np.rint(some / step)) < OFF))
        if (len(apart) - off) / len(apart) < MOST:
            return False
    return True


def _are_short(stored: Array) -> bool:
    """Return whether numbers hold nothing beyond 32 bits."""
    with np.errstate(over="ignore", invalid="ignore"):  # beyond all numbers of 32 bits
        close = np.abs(stored - stored.astype(np.float32)) <= CONVERTED * np.spacing(np.abs(stored))
    return bool(close.all())


def _middle_and_ends(x: NDArray[Any]) -> tuple[float, float, float]:
    """Return the mean, the least and the largest sample in one look; NaN of none."""
    total, low, high = 0.0, np.inf, -np.inf
    known = known_finite(x)
    if known:
        low, high = extremes(x)
    with np.errstate(over="ignore", invalid="ignore"):
        for first, stop in batches(x, size=near()):
            part = x[first:stop]
            total += float(np.sum(part, dtype=np.float64))
            if not known:
                low, high = min(low, float(part.min())), max(high, float(part.max()))
    return (total / len(x), low, high) if len(x) else (np.nan, np.nan, np.nan)
