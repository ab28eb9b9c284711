"""Logarithmic axes with plain labels, and axes over decades of both signs: linear around zero, logarithmic beyond.

Rates of one test go from thousandths of its range to the whole of it, and relative errors grow as the rate falls:
on a linear axis all but the largest would lie on one spot.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from ....core.estimate import Array

NOTHING = 1e-4  # of the largest size: what is smaller is a zero (earth rate in a dwell at rest), no decade of its own
LARGEST = 1e100  # beyond it the transform overflows; no reading is
WIDE = 30.0  # ratio of the largest to the smallest size from which an axis goes over decades
MOST_DECADES = 4  # labelled on each side
NEAR = 2.9  # a decade nearer than this to the linear part has no label of its own
MOST = 7  # labels of an axis
FEW = 1.6  # decades, up to which there are two ticks between them
LEAST = 3  # decades inside, with less of which there is one tick between them
PLAIN = (1e-3, 1e5)  # written without an exponent


def signed_log(ax: Axes, which: Literal["x", "y"], values: Array, start: float | None = None) -> bool:
    """Set an axis over decades where values need it; return whether it was done.

    Parameters
    ----------
    ax : Axes
        Whose.
    which : {"x", "y"}
        Which of its axes.
    values : ndarray, shape (n,)
        What it shall show, in its unit.
    start : float, optional
        Where the linear part ends; by default at the smallest size that is not zero.
    """
    sizes = np.abs(values[np.isfinite(values) & (values != 0.0)])
    if not len(sizes):
        return False
    sizes = sizes[sizes >= NOTHING * np.max(sizes)]
    first = float(start) if start else float(np.min(sizes))
    last = float(np.max(sizes))
    if not first * (NEAR if start else WIDE) < last < LARGEST or first < 1.0 / LARGEST:
        return False
    ticks = _ticks(first, last, bool(np.any(values < 0.0)), bool(np.any(values > 0.0)), start is not None)
    scale, axis = (ax.set_xscale, ax.xaxis) if which == "x" else (ax.set_yscale, ax.yaxis)
    scale("symlog", linthresh=first, linscale=0.7 if start is None else 1.2)
    axis.set_major_locator(FixedLocator(ticks))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}".replace("-", "−")))
    return True


def decades(ax: Axes, values: Array) -> None:
    """Set the y axis over decades, for values of one sign that are all above zero, with one, two or five a label."""
    low, high = float(np.min(values)), float(np.max(values))
    steps = (1.0, 2.0, 5.0) if high < 100.0 * low else (1.0,)
    range_of = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks = [step * 10.0**decade for decade in range_of for step in steps]
    ax.set_yscale("log")
    ax.set_ylim(low / 1.3, high * 1.3)
    ax.yaxis.set_major_locator(FixedLocator([tick for tick in ticks if low / 1.3 <= tick <= high * 1.3]))
    ax.yaxis.set_minor_locator(NullLocator())
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def _ticks(first: float, last: float, below: bool, above: bool, at_start: bool) -> list[float]:
    lowest = math.ceil(math.log10(first * (NEAR if at_start else 1.0)) - 1e-9)
    decades = list(range(lowest, math.floor(math.log10(last) + 1e-9) + 1))
    step = max(1, math.ceil(len(decades) / MOST_DECADES))
    sizes = [10.0**decade for decade in reversed(decades[::-1][::step])]
    sizes = [first, *sizes] if at_start else sizes
    return [*(-size for size in reversed(sizes) if below), 0.0, *(size for size in sizes if above)]


def log_axis(ax: Axes, which: Literal["x", "y"], values: Array, room: float = 1.0) -> bool:
    """Make an axis logarithmic over positive values; return whether there are any.

    Parameters
    ----------
    ax : Axes
        Whose.
    which : {"x", "y"}
        Which of its axes.
    values : ndarray, shape (n,)
        What it shall show, in its unit.
    room : float
        Factor that is left free on both sides.
    """
    shown = values[np.isfinite(values) & (values > 0.0)]
    if not len(shown):
        return False
    low, high = float(shown.min()) / room, float(shown.max()) * room
    if not high > low * (1.0 + 1e-9):
        low, high = low / 2.0, high * 2.0
    scale, axis, limit = (
        (ax.set_xscale, ax.xaxis, ax.set_xlim) if which == "x" else (ax.set_yscale, ax.yaxis, ax.set_ylim)
    )
    scale("log")
    limit(low, high)
    axis.set_major_locator(FixedLocator(_log_ticks(low, high)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: label(value)))
    return True


def label(value: float) -> str:
    """Return a tick as people write it: ``0.001``, ``1e-05``."""
    if PLAIN[0] <= value < PLAIN[1]:
        return f"{value:g}"
    decade = math.floor(math.log10(value) + 1e-9)
    return f"{value / 10.0**decade:.3g}e{decade:d}".replace("-", "−")


def _log_ticks(low: float, high: float) -> list[float]:
    """Return at least two ticks inside, where there is room for two numbers of few digits."""
    if math.log10(high / low) <= FEW:
        found = _inside(low, high, (1.0, 2.0, 5.0))
        return (
            found
            if len(found) > 1
            else [tick for tick in MaxNLocator(4, steps=[1, 2, 5, 10]).tick_values(low, high) if low <= tick <= high]
        )
    found = _inside(low, high, (1.0,))
    if len(found) < LEAST:
        return _inside(low, high, (1.0, 3.0))
    return found[:: math.ceil(len(found) / MOST)]


def _inside(low: float, high: float, subs: tuple[float, ...]) -> list[float]:
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    every = [float(f"{sub}e{decade}") for decade in decades for sub in subs]
    return [tick for tick in every if low <= tick <= high]
