"""Values at the ends of a range: a channel that is clipped.

The largest and the least value of a channel that is not clipped come once, or, of coarse codes and of a slow sine, not
much more often than the values next to them. Two signs tell a clipped one: values pile up at an end, many more than in
the tenth of a standard deviation next to it; or, of a channel that goes there seldom, it stays there from one sample to
the next. The second sign is good for noise alone: a sine turns slowly, and stays at its peak for several samples.

Assumed: nothing of the spectrum. Clipping before a filter, as that of a drive, leaves no equal values, and does not
show here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.estimate import Array

FEWEST, PILED = 8, 2.0  # samples at an end, and how many times those next to it: clipped
NEXT = 0.1  # standard deviations that count as next to it


@dataclass(frozen=True)
class Rails:
    """Ends of the range of a channel.

    Parameters
    ----------
    samples : int
        At an end where they pile up; 0 where they do at neither.
    runs : int
        Of two or more equal samples at an end, one after the other.
    value : float
        The end with more samples [unit].
    """

    samples: int
    runs: int
    value: float


def rails_of(x: Array) -> Rails:
    """Return what stands at the ends of a range.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Samples in order; NaN are left out [unit].
    """
    there = x[np.isfinite(x)]
    if len(there) < FEWEST or there.max() == there.min():
        return Rails(0, 0, float(there[0]) if len(there) else np.nan)
    mean, sd = float(np.mean(there)), float(np.std(there))
    samples, runs, most, value = 0, 0, 0, 0.0
    for end, sign in ((float(there.max()), 1.0), (float(there.min()), -1.0)):
        at = there == end
        count = int(np.count_nonzero(at))
        pairs = at[1:] & at[:-1]
        runs += int(np.count_nonzero(pairs & ~np.append(False, pairs[:-1])))
        if count > most:
            most, value = count, end
        if count < FEWEST or abs(end - mean) <= sd:
            continue
        away = sign * (end - there)
        code = float(np.min(away[away > 0.0]))  # to the next value that there is
        near = int(np.count_nonzero((away > 0.0) & (away <= max(NEXT * sd, 1.5 * code))))
        samples += count if count > PILED * near else 0
    return Rails(samples, runs, value)


__all__ = ["Rails", "rails_of"]
