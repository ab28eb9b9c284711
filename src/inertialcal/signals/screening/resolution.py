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

from ...core.batches import batches, extremes, finite, is_stored, kept, known_finite, near
from ..time.samples import Flags
from .blocks import pieces
from .loops import loops_for

ROUNDED = 4.0  # times the density of rounding, below which noise does not hide what rounding makes
OFF, MOST = 0.05, 0.9  # of a step that differences are off a whole number, and the part of them that codes allow
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
    _, rows = pieces(given, whole=True)
    step, short = loops_for(len(x)).resolved(rows, times, OFF, MOST, CONVERTED)
    if x.dtype.kind == "f":
        kind = np.float32 if short or x.dtype == np.float32 else np.float64
        step = max(step, float(np.spacing(kind(largest * times))) / times)
    return Resolution(step, max(high - middle, middle - low))


def _middle_and_ends(x: NDArray[Any]) -> tuple[float, float, float]:
    """Return the mean, the least and the largest sample in one look; NaN of none."""
    if 0 < len(x) <= near() and not is_stored(x):
        with np.errstate(over="ignore", invalid="ignore"):
            total = float(np.add.reduce(x, dtype=np.float64))
        return total / len(x), float(np.minimum.reduce(x)), float(np.maximum.reduce(x))
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
