"""Curve of a record from those of its channels: in the unit of the result, with intervals and remarks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...core.remarks import Remark
from ..names import Deviation, Quantity
from .channel import Channel
from .curve import Allan
from .dead_time import dead_time_remark
from .edf import interval as interval_of
from .gaps import missing_remark


def joined(
    columns: Sequence[Channel],
    m: NDArray[np.int64],
    samples: int,
    interval: float,
    averaging: float | None,
    kind: Deviation,
    quantity: Quantity,
    names: tuple[str, ...],
    unit: str,
    *,
    scale: float,
    p: float,
    remarks: tuple[Remark, ...],
) -> Allan:
    """Return the curve of channels side by side; parameters are those of `Allan`, and the scale of `allan`.

    Parameters
    ----------
    columns : sequence of Channel
        Found at the averaging factors ``m``.
    remarks : tuple of Remark
        On the averaging times.
    """
    edf = np.array([one.edf for one in columns]).T
    found = np.array([one.deviation for one in columns]).T * (scale if quantity == "rate" else scale / interval)
    lo, hi = interval_of(found, edf, p)
    missing = np.array([one.missing for one in columns], dtype=np.int64)
    remarks += dead_time_remark(interval, averaging) + missing_remark(missing, samples, names)
    return Allan(
        tau=m.astype(np.float64) * interval,
        m=m,
        n=np.array([one.terms for one in columns]).T,
        deviation=found,
        lo=lo,
        hi=hi,
        edf=edf,
        power=np.array([one.power for one in columns]).T,
        inflation=np.array([one.inflation for one in columns]).T,
        ends=np.array([one.ends for one in columns]).T,
        p=p,
        interval=interval,
        averaging=averaging,
        samples=samples,
        missing=missing,
        kind=kind,
        quantity=quantity,
        names=names,
        unit=unit,
        remarks=remarks + tuple(remark for one in columns for remark in one.remarks),
    )
