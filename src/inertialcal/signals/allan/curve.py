"""Allan: deviations over averaging time with their intervals, and what should be known of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.remarks import Remark
from ..names import Deviation, Quantity


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
