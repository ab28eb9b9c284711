"""Compiled loops of the screening: arrays in, preallocated arrays out, no checks.

``bits`` are the samples as integers of the same width; ``flip`` turns bits of a float into an integer that sorts as the
float does (all bits but the sign), and is 0 for integers. Numbers that are not finite lie outside ``inf`` there, so no
loop assumes finite values, and each is short enough to run on many samples at once.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled
from ...statistics._kernels import reordered as summing

Samples = NDArray[Any]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]

SUB = 16  # samples in which a glitch is looked for at once
SIDE = 15  # samples on each side that a running median takes
WINDOW = 2 * SIDE + 1
PRINT = 24  # samples of a fingerprint
CHANGES = 6  # of value that a fingerprint needs, to be one
CUT = 5.0  # times the level, to which single large values are cut


@summing
def fill_blocks(
    x: Samples,
    bits: Samples,
    size: int,
    flip: Any,
    inf: Any,
    lo: Samples,
    hi: Samples,
    mean: Array,
    rough: Array,
    same: NDArray[np.int32],
    count: NDArray[np.int32],
) -> int:
    """Fill least and largest sample (as sorted bits), mean, half the mean squared step, and number of equal steps.

    A block with numbers that are not finite is left to ``fill_patched``: its count is 0. Returns how many there are.
    """
    last = 8 * bits.itemsize - 1
    odd = 0
    for k in range(len(mean)):
        w = bits[k * size : (k + 1) * size]
        n = len(w)
        least = w[0] ^ ((w[0] >> last) & flip)
        largest = least
        for i in range(n):
            key = w[i] ^ ((w[i] >> last) & flip)
            least, largest = min(least, key), max(largest, key)
        lo[k], hi[k] = least, largest
        if flip != 0 and (largest >= inf or least < -inf):
            count[k] = 0
            odd += 1
            continue
        w1, equal = w[1:], np.int64(0)
        for i in range(n - 1):
            equal += np.int64(w1[i] == w[i])
        y = x[k * size : (k + 1) * size]
        level, total = np.float64(y[0]), 0.0
        for i in range(n):
            total += np.float64(y[i]) - level
        y1, squares = y[1:], 0.0
        for i in range(n - 1):
            step = np.float64(y1[i]) - np.float64(y[i])
            squares += step * step
        same[k], count[k] = equal, n
        mean[k] = level + total / n
        rough[k] = 0.5 * squares / max(n - 1, 1)
    return odd


@compiled
def fill_patched(
    x: Samples,
    bits: Samples,
    size: int,
    flip: Any,
    which: Indices,
    skip: Indices,
    lo: Samples,
    hi: Samples,
    mean: Array,
    rough: Array,
    same: NDArray[np.int32],
    count: NDArray[np.int32],
) -> None:
    """Fill the blocks ``which`` anew, of their finite samples but those of ``skip`` (ascending)."""
    last = 8 * bits.itemsize - 1
    s = 0
    for k in which:
        level, total, squares = 0.0, 0.0, 0.0
        n, pairs, equal, before = 0, 0, 0, -2
        for i in range(k * size, min((k + 1) * size, len(x))):
            while s < len(skip) and skip[s] < i:
                s += 1
            value = np.float64(x[i])
            if (s < len(skip) and skip[s] == i) or not np.isfinite(value):
                continue
            key = bits[i] ^ ((bits[i] >> last) & flip)
            if n == 0:
                level = value
                lo[k], hi[k] = key, key
            lo[k], hi[k] = min(lo[k], key), max(hi[k], key)
            total += value - level
            n += 1
            if before == i - 1:
                step = value - np.float64(x[before])
                squares += step * step
                pairs += 1
                equal += step == 0.0
            before = i
        count[k], same[k] = n, equal
        mean[k] = level + total / n if n else np.nan
        rough[k] = 0.5 * squares / pairs if pairs else np.nan


@compiled
def from_median(x: Samples, first: int, stop: int, out: Array) -> None:
    """Fill samples first .. stop less the running median of 31 around each; NaN where there is none.

    The window holds its values in order, infinity for each that is missing, and one more at both ends. Of what is left
    when a value is taken out, each place takes the larger of the value before it, and of the smaller of its own and the
    value that is put in.
    """
    window, other = np.full(WINDOW + 3, np.inf), np.full(WINDOW + 3, np.inf)
    window[0] = other[0] = -np.inf
    held = 0
    for i in range(max(first - SIDE, 0), min(first + SIDE + 1, len(x))):
        value = np.float64(x[i])
        if np.isfinite(value):
            held += 1
            j = held
            while window[j - 1] > value:
                window[j] = window[j - 1]
                j -= 1
            window[j] = value
    for i in range(first, stop):
        if i > first:
            gone, coming = i - SIDE - 1, i + SIDE
            old = np.float64(x[gone]) if gone >= 0 else np.inf
            new = np.float64(x[coming]) if coming < len(x) else np.inf
            old, new = old if np.isfinite(old) else np.inf, new if np.isfinite(new) else np.inf
            held += int(new < np.inf) - int(old < np.inf)
            for j in range(1, WINDOW + 2):
                low, here, high = window[j - 1], window[j], window[j + 1]
                below, own = low if low < old else here, here if here < old else high
                least = own if own < new else new
                other[j] = below if below > least else least
            window, other = other, window
        here = np.float64(x[i])
        middle = 0.5 * (window[(held + 1) // 2] + window[held // 2 + 1])
        out[i - first] = here - middle if np.isfinite(here) else np.nan


@compiled
def fill_pieces(x: Samples, first: Indices, out: Array) -> None:
    """Fill rows of ``out`` with samples from ``first`` on, less the running median of 31 around each."""
    n, flat = out.shape[1], out.reshape(-1)
    k = 0
    while k < len(first):
        last = k + 1
        while last < len(first) and first[last] == first[last - 1] + n:  # it begins where the one before ends
            last += 1
        from_median(x, first[k], first[k] + n * (last - k), flat[k * n : last * n])
        k = last


@summing
def fill_apart(sums: Array, w: int, out: Array) -> None:
    """Fill the mean of w values less that of the w before them; ``sums`` (b + 1): of the values before each."""
    first, second, third, share = sums[: len(out)], sums[w : w + len(out)], sums[2 * w : 2 * w + len(out)], 1.0 / w
    for i in range(len(out)):
        out[i] = share * (third[i] - second[i] - second[i] + first[i])


@summing
def fill_bent(sums: Array, w: int, out: Array) -> None:
    """Fill the contrast of four windows of w values: third less second, less a third of fourth less first."""
    n, share = len(out), 1.0 / (3.0 * w)
    a, b, c, d, e = sums[:n], sums[w : w + n], sums[2 * w : 2 * w + n], sums[3 * w : 3 * w + n], sums[4 * w : 4 * w + n]
    for i in range(n):  # 3 (d - 2 c + b) - (e - d - b + a)
        out[i] = share * (4.0 * (d[i] + b[i]) - 6.0 * c[i] - e[i] - a[i])


@compiled
def fill_far(x: Samples, size: int, which: Indices, limit: float, low: float, at: Indices, off: Array) -> int:
    """Fill samples of the blocks ``which`` further than ``low`` from the running median, where some exceed ``limit``.

    Returns their number, also where it is larger than there is room for.
    """
    found = 0
    d = np.empty(SUB)
    for k in which:
        for first in range(k * size, min((k + 1) * size, len(x)), SUB):
            stop = min(first + SUB, len(x))
            least, largest = np.inf, -np.inf
            for i in range(max(first - SIDE, 0), min(stop + SIDE, len(x))):
                value = np.float64(x[i])
                if np.isfinite(value):
                    least, largest = min(least, value), max(largest, value)
            if largest - least <= limit:
                continue
            from_median(x, first, stop, d)
            for i in range(stop - first):
                if abs(d[i]) > low:
                    if found < len(at):
                        at[found], off[found] = first + i, d[i]
                    found += 1
    return found


@compiled
def fill_runs(x: Samples, size: int, which: Indices, value: float, starts: Indices, stops: Indices) -> int:
    """Fill the stretches of a value that begin in the blocks ``which``; return their number, room or not."""
    found = 0
    for k in which:
        i = k * size
        end = min((k + 1) * size, len(x))
        if k > 0:
            while i < end and x[i] == value and x[i - 1] == value:
                i += 1
        while i < end:
            if x[i] == value:
                first = i
                while i < len(x) and x[i] == value:
                    i += 1
                if found < len(starts):
                    starts[found], stops[found] = first, i
                found += 1
            i += 1
    return found


@compiled
def longest_equal(bits: Samples, first: int, stop: int) -> tuple[int, int]:
    """Return start and stop of the longest stretch of equal samples that meets first .. stop; it may reach beyond."""
    best, best_stop = first, first
    i = first
    while i > 0 and bits[i - 1] == bits[first]:
        i -= 1
    while i < stop:
        j = i + 1
        while j < len(bits) and bits[j] == bits[i]:
            j += 1
        if j - i > best_stop - best:
            best, best_stop = i, j
        i = j
    return best, best_stop


@compiled
def fill_prints(bits: Samples, size: int, prints: NDArray[np.uint64], at: NDArray[np.int32]) -> None:
    """Fill a fingerprint of each block, and where in the block it is: the same in every copy, wherever it stands.

    It is that of the samples from the place where a hash of three samples is the least of the block [1]_; 0 where the
    samples there change too seldom to tell a copy.

    .. [1] S. Schleimer, D. S. Wilkerson and A. Aiken, SIGMOD 2003, 76 (winnowing).
    """
    for k in range(len(prints)):
        w = bits[k * size : (k + 1) * size]
        w1, w2 = w[1:], w[2:]
        least = np.uint64(0xFFFFFFFFFFFFFFFF)
        for i in range(len(w2)):
            mixed = np.uint64(w[i]) + (np.uint64(w1[i]) << np.uint64(7)) ^ (np.uint64(w2[i]) << np.uint64(17))
            mixed = (mixed ^ (mixed >> np.uint64(29))) * np.uint64(0x9E3779B97F4A7C15)
            least = min(least, (mixed & np.uint64(0xFFFFFFFFFFFF0000)) | np.uint64(i))
        place = np.int64(least & np.uint64(0xFFFF))
        first = k * size + place
        at[k], prints[k] = place, 0
        if len(w2) == 0 or first + PRINT > len(bits):
            continue
        v, v1 = bits[first : first + PRINT], bits[first + 1 : first + PRINT]
        digest, changes = np.uint64(0), np.int64(0)
        for i in range(PRINT):
            part = np.uint64(v[i])
            digest += (part ^ (part >> np.uint64(32))) * (np.uint64(0x9E3779B97F4A7C15) * np.uint64(2 * i + 1))
        for i in range(PRINT - 1):
            changes += np.int64(v1[i] != v[i])
        if changes >= CHANGES:
            prints[k] = digest ^ (digest >> np.uint64(32))


@compiled
def squared_runs(x: Samples) -> float:
    """Return the sum of the squared lengths of all runs of equal samples."""
    total, length = 0.0, 1
    for i in range(1, len(x)):
        if x[i] == x[i - 1]:
            length += 1
        else:
            total += float(length) * length
            length = 1
    return total + float(length) * length


@compiled
def fit_powers(part: Array, values: Array, rounds: int, weight: Array) -> None:
    """Improve the weights (k,) of positive rows (k, n) whose sum is the mean of exponential values (n,).

    Each round multiplies them by the root of what the values ask for over what the mean gives.
    """
    k, n = part.shape
    above, below = np.empty(k), np.empty(k)
    for _ in range(rounds):
        for i in range(k):
            above[i] = below[i] = 0.0
        for t in range(n):
            level = weight[0] * part[0, t]
            for i in range(1, k):
                level += weight[i] * part[i, t]
            kept, inverse = min(values[t], CUT * level) / (level * level), 1.0 / level
            for i in range(k):
                above[i] += part[i, t] * kept
                below[i] += part[i, t] * inverse
        for i in range(k):
            weight[i] *= np.sqrt(above[i] / below[i])
