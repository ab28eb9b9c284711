"""Compiled loops of the search for jumps: arrays in, no checks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled

ROUNDED = 1e-9  # relative, more than means may differ by rounding
SURE = 1e-6  # relative, more than what is judged may differ by rounding
MAD = 1.4826  # standard deviation of normal noise over the median distance from its median
TYPICAL = 0.83  # of the mean step of normal noise: its median step is 0.85 of it
FEW_BLOCKS = 8  # that changes of the noise are looked for in
NEXT = 4  # blocks on each side of a change
AT_ONCE = 64  # steps that are looked at together: few hold any that stands out
ROOM = 1024  # steps that stand out: where there are more, only the search tells
STRETCH = 8, 64, 2048  # samples of a line: fewest, those that tell the noise of shorter ones, and most


@compiled
def may_change(columns: Array, block: int, sizes: NDArray[np.int64], rules: Array) -> bool:
    """Return whether a record (channels, n) without gaps may hold a change of its noise, or a clear jump.

    A part of ``changes`` and ``jumps`` for records that hold none: ``block``, samples in which the noise is taken;
    ``sizes`` (4,), of means that jumps are looked for in: samples of a record, factor, neighbours and fewest of these;
    ``rules`` (8,): least change of the noise, ``abrupt`` and ``least`` of a jump, ``clear``, ``fits`` and ``bent`` of a
    line, lengths in a row that do not fit, and blocks that tell a level.
    """
    if _noise_may_change(columns, block, rules[0]):
        return True
    fewest, longer, around, few = sizes
    means, size, places = columns, 1, np.empty(ROOM, dtype=np.int64)
    while means.shape[1] >= fewest:
        gap = 1 if size == 1 else 2
        found = fill_standing_out(means, gap, around, few, rules[1], rules[2], places)
        if found > len(places):
            return True
        for i in places[:found]:
            at = i + 1 if size == 1 else _best_split(columns, i * size, (i + gap + 1) * size)
            if _may_be_clear(columns, at, block, rules):
                return True
        means, size = _joined(means, longer), size * longer
    return False


@compiled
def _joined(columns: Array, size: int) -> Array:
    """Return the means of so many values each."""
    channels, many = len(columns), columns.shape[1] // size
    means = np.empty((channels, many))
    for channel in range(channels):
        x, out = columns[channel], means[channel]
        for k in range(many):
            y, a, b = x[k * size : (k + 1) * size], 0.0, 0.0
            for i in range(0, size - 1, 2):
                a, b = a + y[i], b + y[i + 1]
            out[k] = (a + b + (y[size - 1] if size % 2 else 0.0)) / size
    return means


@compiled
def _noise_may_change(columns: Array, block: int, least: float) -> bool:
    """Return whether the noise of blocks may change so much: see ``changes``, of which this is the first part."""
    many = (columns.shape[1] - 2) // block
    second, size, off = np.empty(block), np.empty(many), 0
    for channel in range(len(columns)):
        x, least_sum, largest_sum, whole = columns[channel], np.inf, 0.0, 0.0
        for k in range(many):
            y = x[k * block : (k + 1) * block + 2]
            here, ahead = y[1:], y[2:]
            for i in range(len(second)):
                second[i] = abs(ahead[i] - 2.0 * here[i] + y[i])
            a, b, c, d, e, f, g, h = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for i in range(0, block - 7, 8):
                a, b, c, d = a + second[i], b + second[i + 1], c + second[i + 2], d + second[i + 3]
                e, f, g, h = e + second[i + 4], f + second[i + 5], g + second[i + 6], h + second[i + 7]
            for i in range(block // 8 * 8, block):
                a += second[i]
            total = ((a + b) + (c + d)) + ((e + f) + (g + h))
            size[k], whole = total, whole + total
            least_sum, largest_sum = min(least_sum, total), max(largest_sum, total)
        if many > 0 and not (least_sum > 0.0 and largest_sum < np.inf):
            return True
        if many >= FEW_BLOCKS:
            level, times = whole / many, np.exp(0.5 * least) * (1.0 - SURE)
            if largest_sum >= level * times or least_sum <= level / times:
                off += _half_lies_off(size, level, times)
    return off > 0 and 2 * off >= len(columns)  # the median of all channels must change


@compiled
def _half_lies_off(values: Array, level: float, times: float) -> bool:
    """Return whether half of the values up to some place, or from it on, are so many times a level, or that part of it.

    Else the medians before and after no place differ by the square of it.
    """
    n, high, low = len(values), level * times, level / times
    for way in range(2):
        above, below = 0, 0
        for k in range(n):
            value = values[n - 1 - k] if way else values[k]
            above, below = above + (value >= high), below + (value <= low)
            if k + 1 >= NEXT and 2 * max(above, below) >= k + 1:
                return True
    return False


@compiled
def _best_split(columns: Array, first: int, last: int) -> int:
    """Return the sample between which and the one before two levels explain a stretch best."""
    n = last - first
    gain = np.zeros(n - 1)
    for channel in range(columns.shape[0]):
        part = columns[channel, first:last] - np.mean(columns[channel, first:last])
        scale, total = max(np.sum(part * part) / n, 1e-300), 0.0
        for i in range(n - 1):
            total += part[i]
            gain[i] += total * total / scale * (1.0 / (i + 1) + 1.0 / (n - i - 1))
    return first + int(np.argmax(gain)) + 1


@compiled
def _may_be_clear(columns: Array, at: int, block: int, rules: Array) -> bool:
    """Return whether the levels before and after a sample may differ clearly: by lines, or by all that lies there."""
    channels, n = columns.shape
    level, u = np.empty((2, channels)), np.empty((2, channels))
    if not (_fill_line(columns, at - 1, -1, at, rules, level[0], u[0])
            and _fill_line(columns, at, 1, n - at, rules, level[1], u[1])):  # fmt: skip
        return False
    for channel in range(channels):
        limit = (1.0 - SURE) * rules[3] * np.hypot(u[0, channel], u[1, channel])
        if abs(level[1, channel] - level[0, channel]) > limit:
            return True
    if min(at, n - at) < rules[7] * block:
        return False
    for channel in range(channels):
        for side in range(2):
            x = columns[channel, at:] if side else columns[channel, :at]
            means = np.empty(len(x) // block)
            for k in range(len(means)):
                means[k] = np.mean(x[k * block : (k + 1) * block])
            level[side, channel] = np.median(means)
            u[side, channel] = 0.5 * MAD * np.median(np.abs(means - level[side, channel]))
        limit = (1.0 - SURE) * rules[3] * np.hypot(u[0, channel], u[1, channel])
        if abs(level[1, channel] - level[0, channel]) > limit:
            return True
    return False


@compiled
def _fill_line(columns: Array, first: int, way: int, room: int, rules: Array, level: Array, u: Array) -> bool:
    """Fill level and uncertainty at a sample, of each channel, from the longest stretch a line fits; False for none.

    The stretch begins there and goes on by ``way``, 1 or -1, as far as there is ``room``.
    """
    channels = columns.shape[0]
    size, failed, number, found = STRETCH[0], 0, 0, False
    noise = np.empty((16, channels))  # of stretches of 8, 16, 32 ...
    while room >= size and size <= STRETCH[2] and failed < rules[6]:
        middle, half = 0.5 * size - 0.5, 0.5 * size
        moment = size * (size * size - 1.0) / 12.0
        fits, more, alike = True, 1.0 + rules[4] / np.sqrt(size), 1.5 + rules[4] / np.sqrt(half)
        own_level, own_u = np.empty(channels), np.empty(channels)
        for channel in range(channels):
            part = np.empty(size)
            for i in range(size):
                part[i] = columns[channel, first + way * i]
            mean, slope = np.mean(part), 0.0
            for i in range(size):
                slope += part[i] * (i - middle)
            slope /= moment
            square, bend, twist, of_bend, of_twist = 0.0, 0.0, 0.0, 0.0, 0.0
            for i in range(size):
                t = (i - middle) / half
                rest, one, other = part[i] - mean - slope * (i - middle), 1.5 * t * t - 0.5, (2.5 * t * t - 1.5) * t
                square += rest * rest
                bend, twist = bend + rest * one, twist + rest * other
                of_bend, of_twist = of_bend + one * one, of_twist + other * other
            scatter, own = np.sqrt(square / (size - 2)), _white(part)
            noise[number, channel] = own
            close = noise[max(number - 2, 0), channel]
            most = rules[5] * own
            fits = fits and abs(bend) <= most * np.sqrt(of_bend) and abs(twist) <= most * np.sqrt(of_twist)
            fits = fits and scatter <= more * own and close <= alike * own and own <= alike * close
            if size < STRETCH[1]:
                near = np.empty(min(room, STRETCH[1]))
                for i in range(len(near)):
                    near[i] = columns[channel, first + way * i]
                scatter = max(scatter, _white(near))
            own_u[channel] = scatter * np.sqrt(1.0 / size + half * half / moment)
            own_level[channel] = mean - slope * half
        if fits or not found:
            level[:], u[:], found = own_level, own_u, True
        failed = 0 if fits else failed + 1
        size, number = 2 * size, number + 1
    return found


@compiled
def _white(part: Array) -> float:
    """Return the standard deviation of white noise with the second differences of a stretch."""
    total = 0.0
    for i in range(len(part) - 2):
        second = part[i + 2] - 2.0 * part[i + 1] + part[i]
        total += second * second
    return float(np.sqrt(total / (len(part) - 2) / 6.0))


@compiled
def fill_standing_out(
    means: Array, gap: int, around: int, few: int, abrupt: float, least: float, at: NDArray[np.int64]
) -> int:  # fmt: skip
    """Fill which steps between means (channels, n) may stand out of those beside them in any channel.

    That is: by ``least`` times the median step beyond ``abrupt`` times the largest of its neighbours, ``around`` on
    each side, where there are more than ``few``. A median is taken only where most steps are small for their mean.
    Returns how many there are, room or not.
    """
    channels, many = means.shape
    room, found = many - gap, 0
    step = np.empty(room)
    for channel in range(channels):
        x = means[channel]
        ahead = x[gap:]
        for i in range(room):
            step[i] = abs(ahead[i] - x[i])
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        for i in range(0, room - 3, 4):
            a, b, c, d = a + step[i], b + step[i + 1], c + step[i + 2], d + step[i + 3]
        typical, below = TYPICAL * ((a + b) + (c + d)) / room, 0  # no larger than the median, mostly
        for i in range(room):
            below += step[i] < typical
        if below > (room - 1) // 2:
            typical = np.median(step)
        if not typical > 0.0:
            typical = ROUNDED * np.abs(x).max()
        limit, first = least * typical * (1.0 - SURE), gap + around
        last = max(room - first, first)
        for start in range(first, last, AT_ONCE):
            size, some = min(AT_ONCE, last - start), 0  # that stand out of the nearest step on each side
            before, here, after = step[start - gap - 1 :], step[start:], step[start + gap :]
            for i in range(size):
                beside = before[i] if before[i] > after[i] else after[i]
                some += here[i] - abrupt * beside > limit
            for i in range(start, start + size if some > 0 else start):
                beside = max(step[i - gap - 1], step[i + gap])
                if step[i] - abrupt * beside > limit and _stands_out(step, i, gap, around, few, abrupt, limit):
                    at[min(found, len(at) - 1)] = i
                    found += 1
        for ends in ((0, min(first, room)), (last, room)):
            for i in range(ends[0], ends[1]):
                if _stands_out(step, i, gap, around, few, abrupt, limit):
                    at[min(found, len(at) - 1)] = i
                    found += 1
    return found


@compiled
def _stands_out(step: Array, i: int, gap: int, around: int, few: int, abrupt: float, limit: float) -> bool:
    """Return whether a step exceeds ``abrupt`` times the largest of those beside it by more than a limit."""
    beside, room = 0.0, len(step)
    if step[i] <= limit:
        return False
    if i >= gap + few:
        for k in range(max(i - gap - around, 0), i - gap):
            beside = max(beside, step[k])
    if i < room - gap - few:
        for k in range(i + gap, min(i + gap + around, room)):
            beside = max(beside, step[k])
    return bool(step[i] - abrupt * beside > limit)
