"""Readings of a table of reduced means: a row an axis and dwell."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...core.axes import AXES
from ...core.errors import DataError
from ...core.estimate import Array
from .dwells.plausible import is_reading
from .readings import HalfWidths, Readings


@dataclass(frozen=True)
class MeanOf:
    """One mean of a table.

    Parameters
    ----------
    axis : str
        That reads.
    angle : float
        Position [rad].
    mean : float
        [m/s^2].
    flip : str
        Which flip.
    half_widths : tuple of (float, float)
        Probability and half width [m/s^2] of each t-interval that is given.
    temperature : float
        [degC]; NaN where not given.
    others : mapping of str to float
        The same by other statistics [m/s^2].
    dwell : str
        Tells dwells of one flip and position apart; empty where there is one.
    time : float
        Middle of the dwell [s]; NaN where not given.
    where : str
        File and row.
    predicted : float
        Bias that a ground model predicts in the dwell [m/s^2]; NaN where not given.
    """

    axis: str
    angle: float
    mean: float
    flip: str = "1"
    half_widths: tuple[tuple[float, float], ...] = ()
    temperature: float = math.nan
    others: Mapping[str, float] | None = None
    dwell: str = ""
    time: float = math.nan
    where: str = ""
    predicted: float = math.nan


def readings_of_means(means: Sequence[MeanOf]) -> Readings:
    """Return the dwells of a table of means.

    Raises
    ------
    DataError
        If there is none, an axis is unknown (``wrong_value``), a position is not finite (``wrong_value``), a mean is
        beyond any accelerometer (``wrong_value``), or an axis stands twice in a dwell (``repeated_row``).
    """
    if not means:
        raise DataError("no dwells", why="there is nothing to separate", code="no_dwells")
    groups: dict[tuple[str, str, float], dict[str, MeanOf]] = {}
    for one in means:
        _check(one)
        dwell = groups.setdefault((one.flip, one.dwell, one.angle), {})
        if one.axis in dwell:
            what = f"axis {one.axis} stands twice at {math.degrees(one.angle):.6g} deg of flip {one.flip}"
            do = "Name the dwell, where a position is repeated within a flip"
            raise DataError(what, one.where, f"the first is {dwell[one.axis].where or 'above'}", do, "repeated_row")
        dwell[one.axis] = one
    return _pivoted(list(groups), list(groups.values()))


def _check(one: MeanOf) -> None:
    if one.axis not in AXES:
        raise DataError(f"axis {one.axis!r}", one.where, do="Need x, y or z", code="wrong_value")
    if not math.isfinite(one.angle):
        raise DataError(f"position {one.angle}", one.where, do="Need the turn from position 0", code="wrong_value")
    numbers = {"mean": one.mean, "predicted bias": one.predicted} | {f"half width {p:g}": w for p, w in one.half_widths}
    for name, value in {**numbers, **dict(one.others or {})}.items():
        if not is_reading(value):
            what = f"{name} of {one.axis} is {value:.3g} m/s^2, which no accelerometer reads"
            raise DataError(what, one.where, do="Mend the number, or its unit", code="wrong_value")


def _pivoted(keys: list[tuple[str, str, float]], dwells: list[dict[str, MeanOf]]) -> Readings:
    every = [one for dwell in dwells for one in dwell.values()]
    axes = [axis for axis in AXES if any(one.axis == axis for one in every)]
    statistics = dict.fromkeys(name for one in every for name in one.others or {})
    probabilities = sorted({p for one in every for p, _ in one.half_widths})
    time = np.array([_time(dwell) for dwell in dwells])
    warm = {axis: _column([d[axis].temperature if axis in d else np.nan for d in dwells]) for axis in axes}
    told = {axis: _column([d[axis].predicted if axis in d else np.nan for d in dwells]) for axis in axes}
    return Readings(
        angle=np.array([angle for _, _, angle in keys]),
        flip=np.array([flip for flip, _, _ in keys]),
        outputs={axis: _column([d[axis].mean if axis in d else np.nan for d in dwells]) for axis in axes},
        others={
            name: {axis: _column([_other(d.get(axis), name) for d in dwells]) for axis in axes} for name in statistics
        },
        half_widths=tuple(
            HalfWidths(p, {axis: _column([_width(d.get(axis), p) for d in dwells]) for axis in axes})
            for p in probabilities
        ),
        time=time if np.isfinite(time).any() else None,
        temperature={axis: one for axis, one in warm.items() if np.isfinite(one).any()},
        predicted={axis: one for axis, one in told.items() if np.isfinite(one).any()},
        where=tuple(next(iter(dwell.values())).where for dwell in dwells) if any(one.where for one in every) else (),
    )


def _column(values: list[float]) -> Array:
    return np.array(values, dtype=np.float64)


def _time(dwell: Mapping[str, MeanOf]) -> float:
    """Mean over the axes of the time of a dwell; NaN where none gives it."""
    given = [one.time for one in dwell.values() if math.isfinite(one.time)]
    return float(np.mean(given)) if given else math.nan


def _other(one: MeanOf | None, name: str) -> float:
    return math.nan if one is None or one.others is None else one.others.get(name, math.nan)


def _width(one: MeanOf | None, p: float) -> float:
    return math.nan if one is None else dict(one.half_widths).get(p, math.nan)
