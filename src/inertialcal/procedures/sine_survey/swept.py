"""A sweep with the samples that it is in, and the modes of a response that it gives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .apart import Sweeps
from .modal import Band, Modes, spectra
from .readings import Shaken
from .sweep import Sweep, find_sweeps

QUIET = 0.05  # of the level at an end of the record, from which the drive is on there


@dataclass(frozen=True, eq=False)
class Swept:
    """One sweep with the record that it is in."""

    shaken: Shaken
    sweep: Sweep
    first: int
    stop: int
    label: str

    @property
    def part(self) -> slice:
        """Samples of it."""
        return slice(self.first, self.stop)

    @property
    def open_end(self) -> bool:
        """Whether the drive is on where its samples begin or end."""
        control = self.shaken.control[self.part]
        few = max(8, round(0.05 * self.shaken.rate))
        level = float(np.median(self.sweep.amplitude))
        return any(float(np.std(one)) * math.sqrt(2.0) > QUIET * level for one in (control[:few], control[-few:]))

    def band(self, axis: str) -> Band:
        """Return the spectra of control and response inside the sweep."""
        control, response = self.shaken.control[self.part], self.shaken.responses[axis][self.part]
        one = self.sweep
        highest = min(one.highest, 0.49 * self.shaken.rate)
        return spectra(control, response, self.shaken.rate, one.lowest, highest, open_end=self.open_end)


@dataclass(frozen=True, eq=False)
class OfAxis:
    """The modes of one response."""

    axis: str
    sweeps: Sweeps
    labels: tuple[str, ...]  # Of its sweeps
    edge: NDArray[np.bool_]  # shape (k,): too near to an end of the sweep

    @property
    def modes(self) -> Modes:
        """Modes that all its sweeps have."""
        return self.sweeps.modes


def sweeps_of(shaken: Shaken) -> list[Swept]:
    """Return the sweeps of a recording, each with its samples: up to halfway to its neighbours."""
    found = find_sweeps(shaken.control, shaken.rate, shaken.where)
    cuts = [0, *(round(0.5 * (one.end + other.begin) * shaken.rate)
                 for one, other in pairwise(found)), len(shaken.control)]  # fmt: skip
    ways = ["up" if one.up else "down" for one in found]
    told = [f"{way} {ways[: i + 1].count(way)}" if ways.count(way) > 1 else way for i, way in enumerate(ways)]
    labels = [f"{shaken.name}, {one}" for one in told] if len(found) > 1 else [shaken.name]
    return [Swept(shaken, one, cuts[i], cuts[i + 1], labels[i]) for i, one in enumerate(found)]
