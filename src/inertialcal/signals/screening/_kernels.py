"""Compiled loops of the screening: arrays in, preallocated arrays out, no checks.

Each adds up in one order, which the loop in numpy keeps to. ``bits`` are the samples as integers of the same width;
``flip`` turns bits of a float into an integer that sorts as the float does (all bits but the sign), and is 0 for
integers. Numbers that are not finite lie outside ``inf`` there, so no loop assumes finite values, and each is short
enough to run on many samples at once.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics._kernels import compiled

Samples = NDArray[Any]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]

PIECE = 64  # samples of a piece, as ``blocks`` has them
BLOCK = 16  # samples of a block of a short record
SUB = 16  # samples in which a glitch is looked for at once
SIDE = 15  # samples on each side that a running median takes
WINDOW = 2 * SIDE + 1
PRINT = 24  # samples of a fingerprint
CHANGES = 6  # of value that a fingerprint needs, to be one
CUT = 5.0  # times the level, to which single large values are cut
MAD = 0.6745  # median of |x| of normal noise
CODES = 32_000.0  # of distances, so that they fit into 16 bits
REACH = 3  # codes within which the distance of a sample is known
BIN, LAST = 6, 63  # bits of the codes that are counted together, and the last of these
COARSE = 8  # one sample in so many may lie near a rank
RUN = 256  # samples that are compared with those around at a time ...
STEPS = 32  # ... and steps of the distance that they are looked for beyond
FAR = 7.0  # scales that a glitch is off at least
LANES = 64  # runs of samples that medians are taken of at a time
BINS = 512  # in which values are counted
ROUNDED = 1.0 + 1e-9  # more than results may differ by rounding
NEARLY = 1.0 + 1e-6  # more than a fit of some rounds may differ by it
HALF_PLACE = 2.0**-53  # of a number: its last place is larger
HUGE = 1e100  # numbers whose squares and sums are still far from the largest
TINY = 1e-300  # numbers that have all their places
LN2 = 0.6931471805599453  # ln 2
PLACES = 52  # bits of a number before those of its power of two ...
ROOT = 0x3FE6A09E667F3BCD  # ... and all bits of the root of 1/2


@compiled
def _sum_about(x: Samples, level: float) -> float:
    """Return the sum of samples less a level, every fourth with the others of its place."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    fours = len(x) // 4
    for i in range(fours):
        a, b = a + (np.float64(x[4 * i]) - level), b + (np.float64(x[4 * i + 1]) - level)
        c, d = c + (np.float64(x[4 * i + 2]) - level), d + (np.float64(x[4 * i + 3]) - level)
    rest = x[4 * fours :]
    if len(rest) > 0:
        a += np.float64(rest[0]) - level
    if len(rest) > 1:
        b += np.float64(rest[1]) - level
    if len(rest) > 2:
        c += np.float64(rest[2]) - level
    return (a + b) + (c + d)


@compiled
def _squared_steps(x: Samples) -> float:
    """Return the sum of the squared steps from sample to sample, every fourth with the others of its place."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    fours = (len(x) - 1) // 4
    for i in range(fours):
        e, f, g = np.float64(x[4 * i + 1]), np.float64(x[4 * i + 2]), np.float64(x[4 * i + 3])
        one, two, three, four = e - np.float64(x[4 * i]), f - e, g - f, np.float64(x[4 * i + 4]) - g
        a, b, c, d = a + one * one, b + two * two, c + three * three, d + four * four
    rest = x[4 * fours :]
    if len(rest) > 1:
        one = np.float64(rest[1]) - np.float64(rest[0])
        a += one * one
    if len(rest) > 2:
        two = np.float64(rest[2]) - np.float64(rest[1])
        b += two * two
    if len(rest) > 3:
        three = np.float64(rest[3]) - np.float64(rest[2])
        c += three * three
    return (a + b) + (c + d)


@compiled
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
        level = np.float64(y[0])
        same[k], count[k] = equal, n
        mean[k] = level + _sum_about(y, level) / n
        rough[k] = 0.5 * _squared_steps(y) / max(n - 1, 1)
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
    total, squares = np.empty(4), np.empty(4)  # of every fourth sample and step
    for k in which:
        level, total[:], squares[:] = 0.0, 0.0, 0.0
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
            total[(i - k * size) % 4] += value - level
            n += 1
            if before == i - 1:
                step = value - np.float64(x[before])
                squares[(i - k * size - 1) % 4] += step * step
                pairs += 1
                equal += step == 0.0
            before = i
        count[k], same[k] = n, equal
        mean[k] = level + ((total[0] + total[1]) + (total[2] + total[3])) / n if n else np.nan
        steps = (squares[0] + squares[1]) + (squares[2] + squares[3])
        rough[k] = 0.5 * steps / pairs if pairs else np.nan


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
def fill_ranked(x: Samples, m: int, ranks: Indices, out: Array) -> bool:
    """Fill some ranks, ascending, of the distances of the first m samples from the running median of 31.

    Medians are taken of codes, whole numbers of 16 bits in the order of the samples, many runs of samples at a time:
    they tell each distance to a code, and those near a rank are then taken exactly. Distances in codes are counted in
    bins, and in each code of the bins near a rank, which may lie in any of three. Returns False, where samples are
    missing, or codes are too coarse for that.
    """
    n, least, largest, lost = len(x), np.inf, -np.inf, 0.0
    for i in range(n):
        value = np.float64(x[i])
        least, largest, lost = min(least, value), max(largest, value), lost + 0.0 * value
    some = np.sort(x[:: max(n // BINS, 1)].astype(np.float64))
    low, high = some[len(some) // 50], some[len(some) - 1 - len(some) // 50]  # a few samples may be far off
    low, high = max(least, low - 2.0 * (high - low)), min(largest, high + 2.0 * (high - low))
    scale = CODES / (high - low) + lost  # NaN where a sample is not finite
    if not (0.0 < scale < np.inf):
        return False
    codes, clipped = np.empty(n, dtype=np.int16), 0
    for i in range(n):
        code = (np.float64(x[i]) - low) * scale
        clipped += not 0.0 <= code <= CODES
        codes[i] = np.int16(min(max(code, 0.0), CODES))
    first, last = SIDE, min(m, n - SIDE)
    if clipped > n // COARSE or last <= first:
        return False
    medians = np.empty(last - first, dtype=np.int16)
    _fill_medians(codes, first, medians)
    apart, exact = np.empty(m, dtype=np.int32), np.empty(1)
    own, off, top = codes[first:last], apart[first:last], np.int32(CODES)
    for i in range(len(off)):
        middle, code = np.int32(medians[i]), np.int32(own[i])
        known = (middle > 0) & (middle < top) & (code > 0) & (code < top)
        off[i] = abs(code - middle) if known else np.int32(-1)
    apart[:first], apart[last:] = -1, -1
    for i in range(m):
        if apart[i] < 0:
            if first <= i < last and not 0 < medians[i - first] < CODES:
                return False
            from_median(x, i, i + 1, exact)
            apart[i] = np.int32(min(abs(exact[0]) * scale, CODES))
    own_bins = np.zeros(((int(CODES) >> BIN) + 3, 4), dtype=np.int64)  # of every fourth distance, in the bin before
    for i in range(m):
        own_bins[(apart[i] >> BIN) + 1, i & 3] += 1
    bins = np.zeros(len(own_bins), dtype=np.int64)  # of distances below a bin
    for k in range(1, len(bins)):
        bins[k] = bins[k - 1] + ((own_bins[k, 0] + own_bins[k, 1]) + (own_bins[k, 2] + own_bins[k, 3]))
    place, many = np.full(len(bins), -1, dtype=np.int32), 0  # of the counts of its codes
    for k in range(len(ranks)):
        own = np.searchsorted(bins, ranks[k], side="right") - 1
        for one in range(max(own - 1, 0), min(own + 2, len(bins) - 1)):
            if place[one] < 0:
                place[one], many = many << BIN, many + 1
    counts, near = np.zeros((many << BIN) + 1, dtype=np.int64), np.empty(m, dtype=np.int32)
    many = 0
    for i in range(m):
        at = place[apart[i] >> BIN]
        if at >= 0:
            near[many], many = i, many + 1
            counts[at + (apart[i] & LAST)] += 1
    size, wanted = np.empty(many), 0
    for k in range(len(ranks)):
        own = np.searchsorted(bins, ranks[k], side="right") - 1
        code, below = own << BIN, bins[own]
        while below + counts[place[own] + (code & LAST)] <= ranks[k]:
            below, code = below + counts[place[own] + (code & LAST)], code + 1
        if code + REACH >= CODES:
            return False
        bottom, found = max(code - REACH, 0), 0
        for one in range(bottom, code):
            below -= counts[place[one >> BIN] + (one & LAST)]
        for i in near[:many]:
            if bottom <= apart[i] <= code + REACH:
                from_median(x, i, i + 1, exact)
                size[found], found = abs(exact[0]), found + 1
        wanted += found
        if wanted > m // COARSE + len(ranks) * REACH:
            return False
        out[k] = np.sort(size[:found])[ranks[k] - below]
    return True


@compiled
def _fill_medians(codes: NDArray[np.int16], first: int, medians: NDArray[np.int16]) -> None:
    """Fill the running median of 31 codes around each from ``first`` on, as `from_median` finds it.

    The samples are cut into runs of one length; step by step all runs move on by a sample.
    """
    many, last = len(medians), len(codes) - 1
    length = -(-many // LANES)
    steps = length + WINDOW - 1
    turned, found = np.empty((steps, LANES), dtype=np.int16), np.empty((length, LANES), dtype=np.int16)
    for lane in range(LANES):
        begin = first - SIDE + lane * length
        for step in range(steps):
            turned[step, lane] = codes[min(begin + step, last)]
    window = np.full((WINDOW + 2, LANES), 32767, dtype=np.int16)
    window[0] = -1
    other, none = window.copy(), np.full(LANES, 32767, dtype=np.int16)
    for step in range(steps):
        gone, coming = turned[step - WINDOW] if step >= WINDOW else none, turned[step]
        for j in range(1, WINDOW + 1):
            low, here, high, to = window[j - 1], window[j], window[j + 1], other[j]
            for lane in range(LANES):
                old = gone[lane]
                below = low[lane] if low[lane] < old else here[lane]
                own = here[lane] if here[lane] < old else high[lane]
                least = own if own < coming[lane] else coming[lane]
                to[lane] = below if below > least else least
        window, other = other, window
        if step >= WINDOW - 1:
            found[step - WINDOW + 1] = window[SIDE + 1]
    for lane in range(LANES):
        for step in range(min(length, many - lane * length)):
            medians[lane * length + step] = found[step, lane]


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


@compiled
def fill_apart(sums: Array, w: int, out: Array) -> None:
    """Fill the mean of w values less that of the w before them; ``sums`` (b + 1): of the values before each."""
    first, second, third, share = sums[: len(out)], sums[w : w + len(out)], sums[2 * w : 2 * w + len(out)], 1.0 / w
    for i in range(len(out)):
        out[i] = share * (third[i] - 2.0 * second[i] + first[i])


@compiled
def fill_bent(sums: Array, w: int, out: Array) -> None:
    """Fill the contrast of four windows of w values: third less second, less a third of fourth less first."""
    n, share = len(out), 1.0 / (3.0 * w)
    a, b, c, d, e = sums[:n], sums[w : w + n], sums[2 * w : 2 * w + n], sums[3 * w : 3 * w + n], sums[4 * w : 4 * w + n]
    for i in range(n):  # 3 (d - 2 c + b) - (e - d - b + a)
        out[i] = share * (4.0 * (d[i] + b[i]) - 6.0 * c[i] - e[i] - a[i])


@compiled
def _largest(x: Array) -> float:
    """Return the largest size of values."""
    a, b, c, d = 0.0, 0.0, 0.0, 0.0
    fours = len(x) // 4
    for i in range(fours):
        a, b = max(a, abs(x[4 * i])), max(b, abs(x[4 * i + 1]))
        c, d = max(c, abs(x[4 * i + 2])), max(d, abs(x[4 * i + 3]))
    for i in range(4 * fours, len(x)):
        a = max(a, abs(x[i]))
    return max(a, b, c, d)


@compiled
def may_change(sums: Array, widths: Indices, limit: float) -> bool:
    """Return whether means of w values differ from those of the w before by more than a limit over the root of w."""
    room = np.empty(len(sums))
    for w in widths:
        out = room[: max(len(sums) - 2 * w, 0)]
        fill_apart(sums, w, out)
        if _largest(out) * np.sqrt(w) * ROUNDED > limit:
            return True
    return False


@compiled
def may_step(sums: Array, widths: Indices, limits: Array, sampled: int) -> bool:
    """Return whether the largest contrast of four windows may exceed so many scatters, for any width.

    The scatter is the median distance from the median, over that of normal noise, of every so manieth value: it is no
    smaller than a limit if less than half of the values lie in any stretch twice as long, counted in bins a half of it.
    """
    room, bins = np.empty(len(sums)), np.empty(BINS + 5, dtype=np.int64)
    for k in range(len(widths)):
        w = widths[k]
        out = room[: max(len(sums) - 4 * w, 0)]
        if len(out) < 8:
            continue
        fill_bent(sums, w, out)
        most = _largest(out)
        width = 0.5 * MAD * most / limits[k] * ROUNDED
        if not width > 0.0:
            continue
        some = out[:: max(len(out) // sampled, 1)]
        least, scale = -most, 1.0 / width
        if 2.0 * most * scale >= BINS:
            return True
        bins[:] = 0
        for value in some:
            bins[int((value - least) * scale)] += 1
        within = bins[0] + bins[1] + bins[2] + bins[3]
        for i in range(4, len(bins)):
            within += bins[i]
            if within > len(some) // 2:  # which may be more than lie in the stretch: the scatter itself tells
                if most * ROUNDED > limits[k] * _scatter(out, sampled):
                    return True
                break
            within -= bins[i - 4]
    return False


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
def smallest_step(rows: Array) -> float:
    """Return the smallest difference of neighbours in rows (k, m) that is not zero; 0 where there is none."""
    least = np.inf
    for k in range(rows.shape[0]):
        row = rows[k]
        for i in range(len(row) - 1):
            apart = abs(row[i + 1] - row[i])
            least = apart if 0.0 < apart < least else least
    return least if least < np.inf else 0.0


@compiled
def look(x: Samples, bits: Samples, many: int, rank: int, mean: Array, rough: Array) -> bool:
    """Return whether a record holds no glitches, nothing that is held or stored twice, and no samples that are missing.

    That is sure where no sample equals the one before, least and largest occur once, no three samples that a block is
    known by occur in another, and none is far from the running median: by a limit that is no larger than that of
    ``glitches``, as ``rank`` of the first ``many`` distances tells it. Fills mean and half the mean squared step of
    blocks of ``BLOCK`` samples.
    """
    n, b = len(x), len(mean)
    lo, hi = np.empty(b), np.empty(b)
    if _fill_extremes(x, lo, hi, mean, rough) > 0 or not np.isfinite(mean.sum()):
        return False
    if not (lo.min() > -HUGE and hi.max() < HUGE):
        return False
    for ends in (lo, hi):
        end, found = lo.min() if ends is lo else hi.max(), 0
        for k in range(b):
            if ends[k] == end:
                for i in range(k * BLOCK, min((k + 1) * BLOCK, n)):
                    found += np.float64(x[i]) == end
        if found > 1:
            return False
    if _may_repeat(bits, b):
        return False
    apart = 0.0
    for k in range(b):
        apart += hi[k] - lo[k]
    for part in (0.26, 0.2):  # of the mean range of blocks: 0.26 is 0.92 standard deviations of white noise
        size = part * apart / b
        if size > 0.0 and many - _count_far(x, many, size, mean) <= rank:
            break
        size = 0.0
    limit, which, wide = FAR * size / ROUNDED, np.empty(b, dtype=np.int64), 0
    for k in range(b):
        i, j = max(k - 1, 0), min(k + 1, b - 1)
        which[wide] = k
        wide += max(hi[i], hi[k], hi[j]) - min(lo[i], lo[k], lo[j]) > limit
    at, off = np.empty(1, dtype=np.int64), np.empty(1)
    return size > 0.0 and fill_far(x, BLOCK, which[:wide], limit, limit, at, off) == 0


@compiled
def _fill_extremes(x: Samples, lo: Array, hi: Array, mean: Array, rough: Array) -> int:
    """Fill least and largest sample, mean, and half the mean squared step of blocks; return the number of equal steps.

    The last block may be short. A sample that is missing shows in the mean.
    """
    whole, equal = len(x) // BLOCK, 0
    for k in range(whole):
        y = x[k * BLOCK : (k + 1) * BLOCK]
        level = np.float64(y[0])
        a, b, c, d = 0.0, 0.0, 0.0, 0.0
        e, f, g, h = 0.0, 0.0, 0.0, 0.0
        l0, l1, l2, l3 = level, level, level, level
        h0, h1, h2, h3 = level, level, level, level
        for i in range(BLOCK // 4):
            p, q, r, s = (
                np.float64(y[4 * i]),
                np.float64(y[4 * i + 1]),
                np.float64(y[4 * i + 2]),
                np.float64(y[4 * i + 3]),
            )
            l0, l1, l2, l3 = p if p < l0 else l0, q if q < l1 else l1, r if r < l2 else l2, s if s < l3 else l3
            h0, h1, h2, h3 = p if p > h0 else h0, q if q > h1 else h1, r if r > h2 else h2, s if s > h3 else h3
            a, b, c, d = a + (p - level), b + (q - level), c + (r - level), d + (s - level)
            t = np.float64(y[4 * i + 4]) if i < BLOCK // 4 - 1 else s
            p, q, r, t = q - p, r - q, s - r, t - s
            e, f, g, h = e + p * p, f + q * q, g + r * r, h + t * t
            equal += (p == 0.0) + (q == 0.0) + (r == 0.0) + ((t == 0.0) & (i < BLOCK // 4 - 1))
        lo[k], hi[k] = min(l0, l1, l2, l3), max(h0, h1, h2, h3)
        mean[k], rough[k] = level + ((a + b) + (c + d)) / BLOCK, 0.5 * ((e + f) + (g + h)) / (BLOCK - 1)
    for k in range(whole, len(mean)):
        y = x[k * BLOCK :]
        level, total, squares = np.float64(y[0]), 0.0, 0.0
        lo[k], hi[k] = level, level
        for i in range(len(y)):
            p = np.float64(y[i])
            lo[k], hi[k], total = min(lo[k], p), max(hi[k], p), total + (p - level)
            if i > 0:
                step = p - np.float64(y[i - 1])
                squares, equal = squares + step * step, equal + (step == 0.0)
        mean[k], rough[k] = level + total / len(y), 0.5 * squares / max(len(y) - 1, 1)
    for k in range(1, len(mean)):
        equal += x[k * BLOCK] == x[k * BLOCK - 1]
    return equal


@compiled
def _may_repeat(bits: Samples, b: int) -> bool:
    """Return whether two blocks may hold the same samples: three in a row, by which ``fill_prints`` knows each."""
    n = len(bits) - 2
    w, w1, w2, mixed = bits[:n], bits[1:], bits[2:], np.empty(n, dtype=np.uint64)
    for i in range(n):
        own = np.uint64(w[i]) + (np.uint64(w1[i]) << np.uint64(7)) ^ (np.uint64(w2[i]) << np.uint64(17))
        mixed[i] = (own ^ (own >> np.uint64(29))) * np.uint64(0x9E3779B97F4A7C15) >> np.uint64(16)
    room = 64
    while room < 2 * b:
        room *= 2
    table = np.zeros(room, dtype=np.uint64)
    for k in range(b):
        own = mixed[min(k * BLOCK, n - 1)]
        for i in range(k * BLOCK, min((k + 1) * BLOCK - 2, n)):
            own = min(own, mixed[i])
        if k * BLOCK >= n:  # a last block of two samples has no three
            break
        at = np.int64(own & np.uint64(room - 1))
        while table[at] != 0:
            if table[at] == own + np.uint64(1):
                return True
            at = (at + 1) % room
        table[at] = own + np.uint64(1)
    return False


@compiled
def _count_far(x: Samples, m: int, apart: float, mean: Array) -> int:
    """Return how many of the first m samples are surely further from the running median of 31 than so much.

    A sample is, where 16 of the 31 lie below it by more, or above it. They are compared as whole numbers of 8 bits:
    what these are apart by more than ``STEPS``, the samples are, as cut off numbers are less apart than they were.
    """
    found, scale, last = 0, STEPS / apart, min(m, len(x) - SIDE)
    codes, below, above = (
        np.empty(RUN + 2 * SIDE, dtype=np.int8),
        np.empty(RUN, dtype=np.int8),
        np.empty(RUN, dtype=np.int8),
    )
    low, high = np.empty(RUN, dtype=np.int8), np.empty(RUN, dtype=np.int8)
    for first in range(SIDE, last, RUN):
        size, k = min(RUN, last - first), first // BLOCK
        own = mean[k : max((first + size) // BLOCK, k + 1)]
        level, part = own.sum() / len(own), x[first - SIDE : first + size + SIDE]
        for i in range(len(part)):
            code = (np.float64(part[i]) - level) * scale + 128.0
            codes[i] = np.int8(np.int32(min(max(code, 0.0), 255.0)) - 128)
        for i in range(size):
            own_code = int(codes[SIDE + i])
            low[i], high[i] = np.int8(max(own_code - STEPS, -128)), np.int8(min(own_code + STEPS, 127))
            below[i], above[i] = 0, 0
        for j in range(0, WINDOW - 3, 4):
            w, w1, w2, w3 = codes[j:], codes[j + 1 :], codes[j + 2 :], codes[j + 3 :]
            for i in range(size):
                p, q, r, s, least, most = w[i], w1[i], w2[i], w3[i], low[i], high[i]
                below[i] = np.int8(
                    below[i] + np.int8(p < least) + np.int8(q < least) + np.int8(r < least) + np.int8(s < least)
                )
                above[i] = np.int8(
                    above[i] + np.int8(p > most) + np.int8(q > most) + np.int8(r > most) + np.int8(s > most)
                )
        w, w1, w2 = codes[WINDOW - 3 :], codes[WINDOW - 2 :], codes[WINDOW - 1 :]
        for i in range(size):
            p, q, r, least, most = w[i], w1[i], w2[i], low[i], high[i]
            fewer = np.int8(below[i] + np.int8(p < least) + np.int8(q < least) + np.int8(r < least))
            more = np.int8(above[i] + np.int8(p > most) + np.int8(q > most) + np.int8(r > most))
            low[i] = np.int8((fewer > SIDE) | (more > SIDE))
        for i in range(size):
            found += low[i]
    return found


@compiled
def resolved(rows: Array, times: float, off: float, most: float, converted: float) -> tuple[float, bool]:
    """Return the step of rows (k, m), 0 where their differences are no whole steps; whether they fit into 32 bits.

    ``off``: of a step, beyond which a difference is no whole one, as ``most`` of all must be; ``times``: what a sample
    is multiplied by to be as stored, and ``converted``: units in the last place that this may have changed.
    """
    least, many, size = np.full(rows.shape[1], np.inf), 0, rows.shape[1] - 1  # by place in the row
    for row in rows:
        after = row[1:]
        for i in range(size):
            apart = abs(after[i] - row[i])
            apart = apart if apart > 0.0 else np.inf
            least[i] = apart if apart < least[i] else least[i]
        for i in range(size):
            many += abs(after[i] - row[i]) > 0.0
    step, odd = least.min(), 0
    for row in rows:
        for i in range(len(row) - 1):
            apart = abs(row[i + 1] - row[i])
            if apart > 0.0:
                share = apart / step
                odd += not abs(share - np.rint(share)) < off
        if (many - odd) / max(many, 1) < most:
            break
    short = True
    for row in rows:
        doubtful = 0  # more off than half the last places allowed: a last place is that of the exponent alone
        for i in range(len(row)):
            stored = row[i] * times
            doubtful += not abs(stored - np.float64(np.float32(stored))) <= HALF_PLACE * converted * abs(stored)
        for i in range(len(row) if doubtful > 0 else 0):
            stored = row[i] * times
            if not abs(stored - np.float64(np.float32(stored))) <= converted * np.spacing(abs(stored)):
                short = False
                break
        if not short:
            break
    return (step if many > 0 and (many - odd) / many >= most else 0.0), short


@compiled
def _scatter(x: Array, sampled: int) -> float:
    """Return a standard deviation that few large values do not change, of every so manieth value."""
    some = x[:: max(len(x) // sampled, 1)].copy()
    half = len(some) // 2
    apart = np.abs(some - np.partition(some, half)[half])
    return float(np.partition(apart, half)[half]) / MAD


@compiled
def _take_logs(x: Array) -> None:
    """Put the natural logarithm, to some 1e-15, in the place of each number: many at a time; none is below ``TINY``.

    Each is 2^k (1 + s) / (1 - s) with |s| < 0.172, of which a series gives the logarithm.
    """
    bits, rest, power = x.view(np.int64), np.empty(len(x), dtype=np.int64), np.empty(len(x))
    for i in range(len(x)):
        own = (bits[i] - ROOT) >> PLACES
        rest[i], power[i] = bits[i] - (own << PLACES), np.float64(own)
    part = rest.view(np.float64)
    for i in range(len(x)):
        s = (part[i] - 1.0) / (part[i] + 1.0)
        t = s * s
        total = 1.0 / 15.0 + t * (1.0 / 17.0 + t * (1.0 / 19.0))
        total = 1.0 / 9.0 + t * (1.0 / 11.0 + t * (1.0 / 13.0 + t * total))
        total = 1.0 + t * (1.0 / 3.0 + t * (1.0 / 5.0 + t * (1.0 / 7.0 + t * total)))
        x[i] = power[i] * LN2 + 2.0 * s * total


@compiled
def may_differ(
    mean: Array, rough: Array, even: float, noise_limits: Array, widths: Indices, limits: Array, sampled: int
) -> bool:  # fmt: skip
    """Return whether the noise of blocks (b,) may change, or their level step: a part of ``levels`` for sound records.

    ``noise_limits``: for the narrowest windows of 4, 8, 16 ... blocks; ``even``: scatter that these must keep to.
    """
    b = len(mean)
    if not np.isfinite(rough).all() or not np.isfinite(mean).all():
        return True
    middle = rough.max() if len(noise_limits) > 0 else 0.0
    lowest = max(1e-3 * middle, TINY)
    if middle > 0.0 and rough.min() <= lowest:
        middle = np.median(rough)
        lowest = 1e-3 * middle
    sums = np.zeros(b + 1)
    if middle > 0.0:
        y = np.maximum(rough, lowest)
        if lowest >= TINY:
            _take_logs(y)
        else:
            y = np.log(y)
        for i in range(b):
            sums[i + 1] = sums[i] + (y[i] - y[b // 2])
        narrow, k, spread = 4, 0, 0.0
        while True:
            room = np.empty(b + 1 - 2 * narrow)
            fill_apart(sums, narrow, room)
            spread = _scatter(room, sampled)
            if abs(spread - even) < ROUNDED - 1.0:
                return True
            if not spread > even or 8 * narrow > b:
                break
            narrow, k = 2 * narrow, k + 1
        scale, many = spread * np.sqrt(narrow), 1
        while narrow << many <= b // 4:
            many += 1
        own = np.empty(many, dtype=np.int64)
        for i in range(many):
            own[i] = narrow << i
        if scale > 0.0 and may_change(sums, own, noise_limits[k] * scale):
            return True
    for i in range(b):
        sums[i + 1] = sums[i] + (mean[i] - mean[b // 2])
    return len(widths) > 0 and may_step(sums, widths, limits, sampled)


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
    level, kept, inverse = np.empty(n), np.empty(n), np.empty(n)
    for _ in range(rounds):
        first = weight[0]
        own = part[0]
        for t in range(n):
            level[t] = first * own[t]
        for i in range(1, k):
            other, own = weight[i], part[i]
            for t in range(n):
                level[t] += other * own[t]
        for t in range(n):
            share = 1.0 / level[t]
            kept[t], inverse[t] = min(values[t] * share, CUT) * share, share
        for i in range(k):
            own = part[i]
            a, b, c, d, e, f, g, h = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0  # every fourth with the others of its place
            for t in range(0, n - 3, 4):
                p, q, r, s = own[t], own[t + 1], own[t + 2], own[t + 3]
                a, b, c, d = a + p * kept[t], b + q * kept[t + 1], c + r * kept[t + 2], d + s * kept[t + 3]
                e, f, g, h = e + p * inverse[t], f + q * inverse[t + 1], g + r * inverse[t + 2], h + s * inverse[t + 3]
            rest = n // 4 * 4
            if rest < n:
                a, e = a + own[rest] * kept[rest], e + own[rest] * inverse[rest]
            if rest + 1 < n:
                b, f = b + own[rest + 1] * kept[rest + 1], f + own[rest + 1] * inverse[rest + 1]
            if rest + 2 < n:
                c, g = c + own[rest + 2] * kept[rest + 2], g + own[rest + 2] * inverse[rest + 2]
            weight[i] *= np.sqrt(((a + b) + (c + d)) / ((e + f) + (g + h)))


@compiled
def _stands(power: Array, k: int, lobe: int, beside: int, stands: float) -> bool:
    """Return whether a power stands out of the mean of those on either side, where there are."""
    for side in (power[max(k - lobe - beside, 0) : max(k - lobe, 0)], power[k + lobe + 1 : k + lobe + 1 + beside]):
        total = 0.0
        for value in side:
            total += value
        if len(side) > 0 and power[k] * ROUNDED < stands * total / len(side):
            return False
    return True


@compiled
def may_wave(
    power: Array, basis: Array, first: int, lobe: int, beside: int, stands: float, rounds: int, rare: float,
    margin: float,
) -> bool:  # fmt: skip
    """Return whether any power from ``first`` on may be a wave: see ``levels.slow_wave``, of which this is a part.

    ``basis`` (k, n): of the continuum; ``rare``: false alarms over the powers that are tested; ``margin``: of a limit.
    """
    n, k = len(power), first
    while k < n and not _stands(power, k, lobe, beside, stands):
        k += 1
    if k == n:
        return False
    every = np.ones(n, dtype=np.bool_)
    level, peak = _continuum(power, basis, every, rounds), first
    for i in range(first, n):
        if power[i] * level[peak] > power[peak] * level[i]:
            peak = i
    if not _stands(power, peak, lobe, beside, stands):
        return False
    order = peak + 1
    for i in range(n):
        off = (i + 1) % order
        off = min(off, order - off) if i + 1 >= order else order - off
        every[i] = off > lobe
    dof = 0.5 * np.count_nonzero(every)
    limit = margin * dof * (np.exp(-np.log(rare) / dof) - 1.0)
    return bool(power[peak] * NEARLY > limit * _continuum(power, basis, every, rounds)[peak])


@compiled
def _continuum(power: Array, basis: Array, used: Flags, rounds: int) -> Array:
    """Return the continuum at all powers, fitted to those that are used."""
    many = np.count_nonzero(used)
    part, values, found, total = np.empty((len(basis), many)), np.empty(many), 0, 0.0
    for i in range(len(power)):
        if used[i]:
            values[found], total = power[i], total + power[i]
            for k in range(len(basis)):
                part[k, found] = basis[k, i]
            found += 1
    weight = np.full(len(basis), total / many / len(basis))
    fit_powers(part, values, rounds, weight)
    level = np.zeros(len(power))
    for k in range(len(basis)):
        for i in range(len(power)):
            level[i] += weight[k] * basis[k, i]
    return level
