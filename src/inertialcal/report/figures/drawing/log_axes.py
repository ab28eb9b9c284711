"""Logarithmic axes with plain labels: decades, or what lies between where few decades are shown; at least two."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from ....core.estimate import Array

MOST = 7  # labels of an axis
FEW = 1.6  # decades, up to which there are two ticks between them
LEAST = 3  # decades inside, with less of which there is one tick between them
PLAIN = (1e-3, 1e5)  # written without an exponent


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
    axis.set_major_locator(FixedLocator(_ticks(low, high)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: label(value)))
    return True


def label(value: float) -> str:
    """Return a tick as people write it: ``0.001``, ``1e-05``."""
    if PLAIN[0] <= value < PLAIN[1]:
        return f"{value:g}"
    decade = math.floor(math.log10(value) + 1e-9)
    return f"{value / 10.0**decade:.3g}e{decade:d}".replace("-", "−")


def _ticks(low: float, high: float) -> list[float]:
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
