"""What a flip works on: dwells of a head at the positions that it was turned to."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.key import AXES, Origin
from ...core.remarks import Remark
from ...core.unknowns import Unknowns

Labels = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Quiet:
    """The quiet part of a recording as block means, and which of them each dwell is the mean of.

    Parameters
    ----------
    times : ndarray, shape (m,)
        Middles of the blocks, since the first sample [s].
    length : float
        Of a block [s].
    angle : ndarray, shape (m,)
        Turn of the head in each block [rad].
    means : mapping of str to ndarray, shape (m,)
        Of each axis [m/s^2]; NaN in blocks that it has not its samples in.
    weights : ndarray, shape (n, m)
        Of each block in each dwell of the Readings; a row adds up to 1, or is 0 for dwells of other recordings.
    spans : ndarray, shape (n, 2)
        Start and stop of each dwell on the same clock [s]; NaN for those of other recordings.
    name : str
        Of the recording.
    turns : ndarray, shape (t, 2)
        Turns that the recording shows: between which times each lies, since the first sample [s].
    """

    times: Array
    length: float
    angle: Array
    means: Mapping[str, Array]
    weights: Array
    spans: Array
    name: str = ""
    turns: Array = field(default_factory=lambda: np.zeros((0, 2)))

    @property
    def dwells(self) -> NDArray[np.bool_]:
        """Which dwells of the Readings lie in this recording, shape (n,)."""
        return np.isfinite(self.spans[:, 0])

    def of(self, axis: str) -> Quiet:
        """Return the blocks that an axis has its samples in; the dwells are means of these."""
        own = np.isfinite(self.means[axis])
        if own.all():
            return self
        weights = self.weights[:, own]
        total = weights.sum(axis=1, keepdims=True)
        weights = weights / np.where(total > 0.0, total, 1.0)
        means = {axis: self.means[axis][own]}
        return replace(self, times=self.times[own], angle=self.angle[own], means=means, weights=weights)


@dataclass(frozen=True, eq=False)
class HalfWidths:
    """Half widths of t-intervals of the dwells' means, as the published way has them.

    Parameters
    ----------
    p : float
        Their probability.
    values : mapping of str to ndarray, shape (n,)
        Of each axis [m/s^2]; NaN where there is none.
    """

    p: float
    values: Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class Readings:
    """Dwells, a row each.

    Parameters
    ----------
    angle : ndarray, shape (n,)
        Stated turn of the head from its position 0, right-handed about the plan's axis [rad].
    flip : ndarray of str, shape (n,)
        Which flip a dwell belongs to.
    outputs : mapping of str to ndarray, shape (n,)
        Mean reading of each axis [m/s^2]; NaN where it was not read.
    others : mapping of str to mapping of str to ndarray, shape (n,)
        The same by other statistics: ``"median"``, ``"low_pass"``.
    half_widths : tuple of HalfWidths
        Of the published way.
    time : ndarray, shape (n,), optional
        Middle of each dwell [s].
    temperature : mapping of str to ndarray, shape (n,)
        Of each axis, mean of each dwell [degC]; NaN or absent where not given.
    quiet : tuple of Quiet
        The recordings that the dwells were cut from.
    where : tuple of str
        Place of each row, for messages.
    remarks : tuple of Remark
        What reading them brought up.
    reasons : mapping of str to str
        Why a statistic of ``others`` is not there.
    predicted : mapping of str to ndarray, shape (n,)
        Bias that a ground model predicts in each dwell, in axes of the head [m/s^2]; NaN or absent where not given.
    disagreements : tuple of Remark
        Changes within recordings that no figure survives.
    misplaced : tuple of Remark
        Windows in the wrong place or at the wrong position, by the turns that the recordings show.
    taken_off : mapping of Origin to Unknowns
        What is not known of the corrections that the readings had before.
    """

    angle: Array
    flip: Labels
    outputs: Mapping[str, Array]
    others: Mapping[str, Mapping[str, Array]] = field(default_factory=dict[str, Mapping[str, Array]])
    half_widths: tuple[HalfWidths, ...] = ()
    time: Array | None = None
    temperature: Mapping[str, Array] = field(default_factory=dict[str, Array])
    quiet: tuple[Quiet, ...] = ()
    where: tuple[str, ...] = ()
    remarks: tuple[Remark, ...] = ()
    reasons: Mapping[str, str] = field(default_factory=dict[str, str])
    predicted: Mapping[str, Array] = field(default_factory=dict[str, Array])
    disagreements: tuple[Remark, ...] = ()
    misplaced: tuple[Remark, ...] = ()
    taken_off: Mapping[Origin, Unknowns] = field(default_factory=dict[Origin, Unknowns])

    def __len__(self) -> int:
        """Return the number of dwells."""
        return len(self.angle)

    @cached_property
    def flips(self) -> tuple[str, ...]:
        """Labels of the flips, in the order of their first dwell."""
        return tuple(dict.fromkeys(str(label) for label in self.flip))

    @property
    def axes(self) -> tuple[str, ...]:
        """Axes that were read, in order."""
        return tuple(axis for axis in AXES if axis in self.outputs)

    def by(self, statistic: str) -> Readings:
        """Return the readings with another statistic in place of the means; it has no noise of its own."""
        return replace(self, outputs=self.others[statistic], others={}, quiet=(), half_widths=(), remarks=())

    def place(self, dwell: int) -> str:
        """Return where a dwell comes from, with its position."""
        position = f"position {math.degrees(self.angle[dwell]):.6g} deg"
        return f"{self.where[dwell]}: {position}" if self.where else position
