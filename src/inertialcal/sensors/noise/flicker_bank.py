"""Gauss-Markov terms that stand in for bias instability, which no finite state holds.

Correlation times lie in geometric steps, the sizes are those that come nearest to the flat Allan deviation of 0.664 B
between two averaging times, in least squares without negative parts.
"""

from __future__ import annotations

import numpy as np
from scipy import optimize

from ...core.errors import PlanError
from ...core.estimate import Array
from .allan_of_terms import expected_variance
from .terms import GaussMarkov

PEAK = 1.89  # averaging time over correlation time at which the Allan deviation of Gauss-Markov noise is largest
GRID = 25  # averaging times a decade at which flicker is compared
FLAT = 2.0 * np.log(2.0) / np.pi  # Allan variance of bias instability over B^2


def flicker_bank(
    coefficient: float, shortest: float, longest: float, states: int | None = None
) -> tuple[tuple[GaussMarkov, ...], float]:
    """Return Gauss-Markov terms that stand in for bias instability, and their largest relative difference.

    Parameters
    ----------
    coefficient : float
        B [unit].
    shortest, longest : float
        Averaging times between which the Allan deviation is to be 0.664 B [s].
    states : int, optional
        Number of terms; by default one a decade and one more.

    Returns
    -------
    terms : tuple of GaussMarkov
        Correlation times in geometric steps; those that get no part are left out.
    largest : float
        Difference of the Allan deviation from the flat between both times, relative.

    Raises
    ------
    PlanError
        If the times are not ascending, or no state is asked for.
    """
    if not 0.0 < shortest < longest:
        raise PlanError(f"averaging times from {shortest:g} to {longest:g} s, need ascending positive ones")
    decades = float(np.log10(longest / shortest))
    count = int(np.ceil(decades)) + 1 if states is None else states
    if count < 1:
        raise PlanError(f"{count} states, need 1 or more")
    tau = np.geomspace(shortest, longest, max(GRID, int(GRID * decades)))
    ends = np.geomspace(shortest, longest, 2 * count + 1)[1::2]  # middles of equal parts of the range

    def stretched(stretch: float) -> tuple[Array, Array, float]:
        middle = np.sqrt(shortest * longest)
        times = middle * (ends / middle) ** stretch / PEAK
        bank = [expected_variance(GaussMarkov(1.0, float(time)), tau / shortest, shortest) for time in times]
        shape = np.stack(bank, axis=1) / FLAT
        parts = optimize.nnls(shape, np.ones(len(tau)))[0]
        return times, parts, float(np.max(np.abs(np.sqrt(shape @ parts) - 1.0)))

    best = optimize.minimize_scalar(lambda s: stretched(s)[2], bounds=(0.5, 1.5), method="bounded").x
    times, parts, largest = stretched(float(best))
    terms = [GaussMarkov(float(coefficient * np.sqrt(w)), float(t)) for w, t in zip(parts, times, strict=True) if w > 0]
    return tuple(terms), largest
