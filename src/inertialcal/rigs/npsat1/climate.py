"""Temperature and pressure of a unit in a chamber over time.

The chamber goes from set-point to set-point in ramps; the unit follows it with one time constant. What the bias has of
hysteresis goes from one side to the other as the temperature does: s, -1 after long cooling and +1 after long warming,
starts midway and turns over with the distance in temperature from where the path turned.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...core.estimate import Array
from .setup import Bench, Chamber
from .tables import AIR_TORR, CONSTANT_BELOW_TORR, REGION_VOLTS, REGIONS_TORR

TURN_OVER = 3.0  # distance in which hysteresis goes to the other side [degC]


@dataclass(frozen=True, eq=False)
class Climate:
    """Conditions of three sensors at n times.

    Parameters
    ----------
    temperature : ndarray, shape (n, 3)
        That the temperature channels are at [degC].
    felt : ndarray, shape (n, 3)
        That the bias is at: the same some time before [degC].
    side : ndarray, shape (n, 3)
        s of the module head.
    torr : ndarray, shape (n,)
        Pressure [Torr].
    """

    temperature: Array
    felt: Array
    side: Array
    torr: Array


def knots(bench: Bench, chamber: Chamber, ramp: float) -> tuple[Array, Array]:
    """Return times [s] and set-points [degC] between which the chamber goes in straight lines.

    Parameters
    ----------
    bench, chamber : Bench, Chamber
        As they are run.
    ramp : float
        Of the set-point [degC/min].
    """
    times, points = [0.0, chamber.hold], [bench.set_points[0]] * 2
    for before, after in pairwise(bench.set_points):
        reached = times[-1] + 60.0 * abs(after - before) / ramp
        times += [reached, reached + chamber.soak]
        points += [after, after]
    return np.array(times), np.array(points)


def followed(times: Array, points: Array, time_constant: float, at: Array) -> Array:
    """Return what follows straight lines with one time constant, in closed form, shape of ``at``.

    Parameters
    ----------
    times, points : ndarray, shape (k,)
        Ends of the lines; before the first and after the last it is constant.
    time_constant : float
        [s]
    at : ndarray
        Times [s].
    """
    slopes = np.append(np.diff(points) / np.maximum(np.diff(times), 1e-9), 0.0)
    behind = np.zeros(len(times))  # behind[i]: output less input at times[i]
    for i, span in enumerate(np.diff(times)):
        rest = -slopes[i] * time_constant
        behind[i + 1] = rest + (behind[i] - rest) * np.exp(-span / time_constant)
    line = np.maximum(np.searchsorted(times, at, side="right") - 1, 0)
    since = np.maximum(at - times[line], 0.0)
    rests = -slopes[line] * time_constant
    gone = np.exp(-since / time_constant)
    return np.asarray(points[line] + slopes[line] * since + rests + (behind[line] - rests) * gone)


def side_of_path(temperature: Array) -> Array:
    """Return s of the module head along the path of one sensor, shape (n,)."""
    steps = np.sign(np.diff(temperature))
    moving = np.flatnonzero(steps)
    turns = moving[np.flatnonzero(np.diff(steps[moving])) + 1]  # steps at which it goes the other way
    edges = [0, *turns.tolist(), len(temperature) - 1]
    found, s = np.zeros(len(temperature)), 0.0
    for begin, end in pairwise(edges):
        part = temperature[begin : end + 1]
        way = np.sign(part[-1] - part[0])
        found[begin : end + 1] = way + (s - way) * np.exp(-np.abs(part - part[0]) / TURN_OVER)
        s = float(found[end])
    return found


def vacuum_part(torr: Array) -> Array:
    """Return how much of the change from air to vacuum there is at a pressure [Torr], by sensor, shape (n, 3).

    0 in air, 1 where the bias is constant; between them the regions of Table 6, each at its geometric middle, over the
    mean of those that are constant.
    """
    ends = np.array(REGIONS_TORR)
    constant = ends[:, 1] <= CONSTANT_BELOW_TORR
    level = REGION_VOLTS[constant].mean(axis=0)
    at = np.log10([CONSTANT_BELOW_TORR, *np.sqrt(ends[~constant, 0] * ends[~constant, 1]), AIR_TORR])
    parts = np.vstack([np.ones(3), REGION_VOLTS[~constant] / level, np.zeros(3)])
    return np.column_stack([np.interp(np.log10(torr), at, part) for part in parts.T])
