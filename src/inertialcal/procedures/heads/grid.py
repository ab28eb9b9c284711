"""Readings of several clocks as means over the same intervals, and how the body turned in each.

Each sample is the mean over its interval; means over other intervals follow from the integral, which is taken as a
cubic in between, with the slope at the end of a sample by four about it. An interval of which a part is missing has no
mean.
"""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...physics.motion.rigid import centripetal, cross
from .readings import Flags, Readings, Track

WHOLE = 0.999  # of an interval, that must have been read
APART = 1.5  # intervals of samples, from which there is a gap
FEWEST = 4  # samples
SAME = 1e-3  # of a sample: intervals that end with it
EDGE = 0.125  # of an interval, about its ends, over which rates are averaged


def interval_means(times: Array, values: Array, interval: float, edges: Array) -> Array:
    """Return means over intervals, NaN where a part is missing.

    Parameters
    ----------
    times, values : ndarray, shape (n,), (n, k)
        Middles of samples [s], and samples.
    interval : float
        Of samples [s].
    edges : ndarray, shape (m + 1,)
        Between the intervals of the means [s].

    Returns
    -------
    ndarray, shape (m, k)
    """
    there = np.isfinite(values).all(axis=1)
    times, values = times[there], values[there]
    if len(times) < FEWEST:
        return np.full((len(edges) - 1, values.shape[1]), np.nan)
    middle = values.mean(axis=0)  # of which integrals would lose digits
    free = np.column_stack([values - middle, np.ones(len(times))])
    gap = np.diff(times) > APART * interval
    knots, slopes = _between(times, free, interval, gap)
    steps = np.zeros_like(slopes)
    steps[1:] = _areas(free, gap) * np.diff(knots)[:, None]
    integral = np.cumsum(steps, axis=0)
    inside = np.clip(edges, knots[0], knots[-1])
    at = np.minimum(np.searchsorted(knots, inside, side="right") - 1, len(knots) - 2)
    width = np.diff(knots)[at]
    x = ((inside - knots[at]) / width)[:, None]
    first, second = integral[at], integral[at + 1]
    bend, rise = x * x * (3.0 - 2.0 * x), width[:, None] * x * (1.0 - x)
    read = first + (second - first) * bend + rise * ((1.0 - x) * slopes[at] - x * slopes[at + 1])
    read[:, -1] = np.interp(inside, knots, integral[:, -1])  # time that was read
    found = np.diff(read, axis=0)
    covered = found[:, -1]
    with np.errstate(divide="ignore", invalid="ignore"):
        means = found[:, :-1] / covered[:, None] + middle
    means[~(covered >= WHOLE * np.diff(edges))] = np.nan
    return np.asarray(means)


def _between(times: Array, free: Array, interval: float, gap: Flags) -> tuple[Array, Array]:
    """Return the ends of samples, those of gaps twice, and the readings there by four samples about each."""
    places = 0.5 * (times[1:] + times[:-1])
    near = 0.5 * (free[1:] + free[:-1])
    if len(times) > FEWEST:
        whole = ~(gap[:-2] | gap[1:-1] | gap[2:])
        four = (7.0 * (free[1:-2] + free[2:-1]) - free[:-3] - free[3:]) / 12.0
        near[1:-1][whole] = four[whole]
    after, before = times[:-1][gap] + 0.5 * interval, times[1:][gap] - 0.5 * interval
    places[gap], near[gap] = after, free[:-1][gap]
    numbers = np.flatnonzero(gap) + 1
    places = np.insert(places, numbers, before)
    near = np.insert(near, numbers, free[1:][gap], axis=0)
    knots = np.concatenate([[times[0] - 0.5 * interval], places, [times[-1] + 0.5 * interval]])
    return knots, np.vstack([free[:1], near, free[-1:]])


def _areas(free: Array, gap: Flags) -> Array:
    """Return the mean between each pair of ends: a sample, or nothing in a gap."""
    return np.insert(free, np.flatnonzero(gap) + 1, 0.0, axis=0)


def turning(gyro: Track, edges: Array) -> Array:
    """Return [alpha x] + [omega x][omega x] in each interval, by a gyro, shape (m, 3, 3) [1/s^2]."""
    rates = gyro.body
    products = (rates[:, :, None] * rates[:, None, :]).reshape(-1, 9)
    outer = interval_means(gyro.times, products, gyro.interval, edges).reshape(-1, 3, 3)
    half = 0.5 * max(2.0 * gyro.interval, EDGE * float(edges[1] - edges[0]))
    first, last = float(gyro.times[0]) - 0.5 * gyro.interval, float(gyro.times[-1]) + 0.5 * gyro.interval
    about = np.clip(np.column_stack([edges - half, edges + half]), first, last)
    at = interval_means(gyro.times, rates, gyro.interval, about.ravel())[::2]
    speeding = np.diff(at, axis=0) / np.diff(about.mean(axis=1))[:, None]
    return np.asarray(cross(speeding) + centripetal(outer))


def body_means(readings: Readings, edges: Array) -> Array:
    """Return means of all heads in axes of the body, shape (heads, m, 3)."""
    return np.array([interval_means(one.times, one.body, one.interval, edges) for one in readings.tracks])


def smoothing(track: Track, edges: Array) -> Array:
    """Return by which part means of a head are too small in its motion, by axis of the body, shape (3,).

    Its samples end between the ends of the intervals: found by moving them there and back, which loses twice as much.
    """
    step = track.interval
    phase = float((edges[0] - track.times[0]) / step - 0.5) % 1.0
    if min(phase, 1.0 - phase) < SAME:
        return np.zeros(3)
    own = track.times[0] + step * (np.arange(len(track.times) + 1) - 0.5)
    ahead = own + phase * step
    there = interval_means(track.times, track.body, step, ahead)
    back = interval_means(ahead[:-1] + 0.5 * step, there, step, own)
    first, second = (interval_means(own[:-1] + 0.5 * step, one, step, edges) for one in (track.body, back))
    good = np.isfinite(first).all(axis=1) & np.isfinite(second).all(axis=1)
    if np.count_nonzero(good) < FEWEST:
        return np.zeros(3)
    first, second = first[good] - first[good].mean(axis=0), second[good] - second[good].mean(axis=0)
    power = np.maximum(np.sum(first**2, axis=0), 1e-300)
    return np.asarray(0.5 * (1.0 - np.sum(first * second, axis=0) / power))
