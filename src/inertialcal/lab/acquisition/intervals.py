"""Save intervals: how long from row to row, and how often it was longer or shorter than it should be.

The tests of the suite of 2011 were saved every 2 s, and some saves came after 3, 5 or 6 s [1]_: what is missing must be
known while the test goes on. Intervals are those of the instrument's own time where it sends one, of its counter where
it sends that, and else of the arrivals, which jitter more.

References
----------
.. [1] Badescu, NPS thesis, 2011, ch. III: saves of ACS 238 and 206.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np

from ...core.estimate import Array

STEPS = 10  # of an interval: to so much of it intervals are told apart
SHORT, LONG = 0.75, 1.25  # of an interval: beyond these one is remarked
MOST = 1000  # different intervals that are told apart; longer ones count as the longest of these


class Intervals:
    """Intervals of an instrument.

    Parameters
    ----------
    nominal : float
        From row to row [s].
    """

    def __init__(self, nominal: float) -> None:
        self.nominal = nominal
        self._counts: Counter[int] = Counter()
        self._last: float | None = None

    def add(self, seconds: Array) -> None:
        """Add when rows were made [s], in order, shape (n,)."""
        if not len(seconds):
            return
        apart = np.diff(seconds, prepend=seconds[:1] if self._last is None else self._last)
        apart = apart[1:] if self._last is None else apart
        self._last = float(seconds[-1])
        steps = np.clip(np.rint(STEPS * apart / self.nominal), 0, MOST * STEPS).astype(np.int64)
        for step, count in zip(*(one.tolist() for one in np.unique(steps, return_counts=True)), strict=True):
            if step in self._counts or len(self._counts) < MOST:
                self._counts[step] += count
            else:
                self._counts[max(self._counts)] += count

    @property
    def count(self) -> int:
        """How many there were."""
        return self._counts.total()

    @property
    def odd(self) -> Mapping[float, int]:
        """How many there were of each length [s] that is longer or shorter than it should be."""
        found = {step: count for step, count in sorted(self._counts.items())
                 if not SHORT * STEPS <= step <= LONG * STEPS}  # fmt: skip
        return {round(step * self.nominal / STEPS, 9): count for step, count in found.items()}

    def __str__(self) -> str:
        """``"3 s x17, 5 s x7, 6 s x2 for 2 s"``; empty where none is odd."""
        said = ", ".join(f"{length:g} s x{count}" for length, count in self.odd.items())
        return f"{said} for {self.nominal:g} s" if said else ""
