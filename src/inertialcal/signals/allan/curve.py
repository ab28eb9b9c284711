"""Allan: deviations over averaging time with their intervals, and what should be known of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.remarks import Remark
from ...core.show.frames import frame
from ...core.show.result_tables import dof, remarks_line
from ...core.show.rounding import number
from ...core.show.tables import Block, Table, html, short, text
from ..names import Deviation, Quantity
from .deviations import KINDS

if TYPE_CHECKING:
    from pandas import DataFrame

NAMES = {2: "quantisation", 1: "flicker of angle", 0: "white", -1: "flicker", -2: "random walk", -3: "flicker walk"}
NAMES |= {-4: "random run"}
MOST_ROWS = 40  # printed


@dataclass(frozen=True, eq=False)
class Allan:
    """Deviations of one or several channels."""

    tau: Array  # averaging time [s]: averaging factor times sample interval, shape (k,)
    m: NDArray[np.int64]  # averaging factor [samples], shape (k,)
    n: NDArray[np.int64]  # terms behind each deviation, shape (k, axes)
    # deviation, lo, hi: deviation of the rate, and the ends of its interval, in ``unit``; NaN where no term is there,
    # ends also where a channel is constant, shape (k, axes)
    deviation: Array
    lo: Array
    hi: Array
    edf: Array  # equivalent degrees of freedom, shape (k, axes)
    # exponent of the noise around each averaging time: 2 quantisation, 0 white, -1 flicker, -2 random walk, shape (k,
    # axes)
    power: Array
    # by how much missing samples raise the variance of white noise; divided out where ``power`` is 0 or more, shape (k,
    # axes)
    inflation: Array
    # sum of the squared weights that errors of the integrated signal have in a term, over 2 / m^2: 3 of a complete
    # record, more where gaps leave ends of stretches inside of windows. Of the Allan deviations; else 3, shape (k,
    # axes)
    ends: Array
    p: float  # probability of the intervals
    interval: float  # from sample to sample [s]
    averaging: float | None  # what each sample is the mean of [s]; None when nobody said
    samples: int  # length of the record
    missing: NDArray[np.int64]  # samples that are not there, shape (axes,)
    kind: Deviation  # which deviation
    quantity: Quantity  # what the samples were
    names: tuple[str, ...]  # one a channel
    unit: str = ""  # of the deviation; empty when nobody said
    remarks: tuple[Remark, ...] = ()  # what is suspicious

    def __len__(self) -> int:
        return len(self.tau)

    @property
    def variance(self) -> Array:
        """Square of the deviation, shape (k, axes)."""
        return self.deviation**2

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame: a row an averaging time of a channel."""
        k, axes = self.deviation.shape
        shown = {name: getattr(self, name).T.ravel() for name in ("n", "deviation", "lo", "hi", "edf", "power")}
        axis = [name for name in self.names for _ in range(k)]
        return frame({"axis": axis, "tau": np.tile(self.tau, axes), "m": np.tile(self.m, axes), **shown})

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row an averaging time, a deviation with its interval a channel."""
        unit = f" [{self.unit}]" if self.unit else ""
        words = KINDS[self.kind].words
        seconds = number(self.samples * self.interval)
        caption = f"{words}{unit} of {seconds} s at {number(1.0 / self.interval)} Hz; intervals hold with {self.p:.4g}"
        one = len(self.names) == 1
        heads = ["tau [s]", *(short(name) for name in self.names), *(("edf", "noise") if one else ())]
        shown = _spread(len(self), MOST_ROWS)
        rows = [[number(float(self.tau[k]), 5), *self._cells(k)] for k in shown]
        left = (f"{len(shown)} of {len(self)} averaging times shown",) if len(shown) < len(self) else ()
        right = tuple(range(len(self.names) + 1 + one))
        return (Table(heads, rows, caption, right), *left, *remarks_line(self.remarks))

    def _cells(self, k: int) -> list[str]:
        every = zip(self.deviation[k], self.lo[k], self.hi[k], strict=True)
        cells = [f"{number(d, 4)} ({number(lo, 4)} .. {number(hi, 4)})" for d, lo, hi in every]
        if len(cells) > 1:
            return cells
        power = self.power[k, 0]
        return [*cells, dof(float(self.edf[k, 0])), NAMES[int(power)] if np.isfinite(power) else "-"]

    def __str__(self) -> str:
        """Return a table with a row an averaging time."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the same table for a notebook."""
        return html(self.parts())


def _spread(n: int, most: int) -> list[int]:
    """Return up to ``most`` indices of n, evenly over their logarithm."""
    if n <= most:
        return list(range(n))
    return sorted({round(value) - 1 for value in np.geomspace(1.0, n, most)})
