"""A case of the 1969 programme: the series that it uses, and what each request makes of them.

Reductions 1, 2 and 4 start from the data each time and so replace each other; reduction 3 acts on what is there, with
the coefficients of the last analysis.

What a synthetic case gives is taken as real numbers: whether the machine cut them to whole ones the text does not tell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from .analysis import Analysis, analyse
from .cards import CURVE, HARMONICS, LINE, TILT, MeasuredCase, Request, SyntheticCase
from .steps import adjusted_curve, straight_line, tilt_trace, without_harmonics


@dataclass(frozen=True, eq=False)
class Step:
    """A request, and the analysis that followed it."""

    request: Request
    analysis: Analysis


def closed_up(series: NDArray[np.generic], wrong: Sequence[int]) -> NDArray[np.generic]:
    """Return a series with wrong positions taken out by shifting what follows to the left.

    All that follows comes earlier by a sample, so that a drive of known phase is out of step from there on: never do
    this with data; mark them as missing.

    Parameters
    ----------
    series : ndarray, shape (n,)
        Values.
    wrong : sequence of int
        Positions from 1, each in the series as shortened by those before it.

    Raises
    ------
    DataError
        If there is no such position.
    """
    for position in wrong:
        if not 1 <= position <= len(series):
            raise DataError(f"wrong position {position}", do=f"The series has 1 to {len(series)} by then")
        series = np.delete(series, position - 1)
    return series


def synthetic(case: SyntheticCase) -> tuple[Array, Array]:
    """Return the series of a synthetic case, shape (N,) each.

    Sine and cosine run as ``pi i / K`` with the half period K on the card, as the code has it (the printed heading
    says 2 pi).
    """
    i = np.arange(case.N)
    parts = ((case.LXS, case.KXS, np.sin), (case.LXC, case.KXC, np.cos), (case.LY, case.KY, np.cos))
    sine, cosine, tilt = (size * wave(np.pi / max(half, 1) * (i % (2 * max(half, 1)))) for size, half, wave in parts)
    return sine + cosine, tilt


def series_of(case: SyntheticCase | MeasuredCase) -> tuple[Array, Array]:
    """Return accelerometer and tilt series that are used, wrong positions closed up; shape (N,) each."""
    if isinstance(case, SyntheticCase):
        return synthetic(case)
    AX, AY = (closed_up(one, case.wrong)[: case.N].astype(np.float64) for one in (case.AX, case.AY))
    return AX, AY


def run_case(case: SyntheticCase | MeasuredCase) -> tuple[Step, ...]:
    """Return the analysis after each request.

    Raises
    ------
    DataError
        As the steps.
    """
    x, tilt = series_of(case)
    data = x - x.mean()
    current, steps = data, []
    for request in case.requests:
        current = _after(request, data, current, tilt)
        found = analyse(current, tilt, float(case.NH), case.MAXL, case.MAXK)
        current = found.x
        steps.append(Step(request, found))
    return tuple(steps)


def _after(request: Request, data: Array, current: Array, tilt: Array) -> Array:
    """Return the series that a request leaves."""
    if request.what == TILT:
        return tilt_trace(data, tilt)
    if request.what == LINE:
        return straight_line(data)
    if request.what == HARMONICS:
        return without_harmonics(current, request.number)
    return adjusted_curve(data, request.number) if request.what == CURVE else current
