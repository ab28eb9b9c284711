"""True inputs of raw codes in whole numbers, to far below the last digit of any output; how far they can be off.

All values are times SCALE. Cutting a number to a whole one costs less than a unit; these costs are added up.
"""

from __future__ import annotations

from fractions import Fraction
from math import floor

import numpy as np
from numpy.typing import NDArray

from .design import Arithmetic, Constants, Values
from .exact import Bend, Ideal, Row
from .twin import Codes, reduced, run

Integers = NDArray[np.object_]
Ends = tuple[Fraction, Fraction]
SCALE_BITS = 160
SCALE = 1 << SCALE_BITS
STEPS_OF_NEWTON = 20  # in floating numbers
SLOPE_BITS = 52  # of a slope in whole numbers


def whole(values: Values) -> tuple[Integers, int]:
    """Return floating numbers as whole numbers over 2^bits, exactly, and the bits."""
    mantissa, exponent = np.frexp(np.asarray(values, dtype=float))
    bits = 53 - int(exponent.min(initial=0))
    digits = np.ldexp(mantissa, 53).astype(np.int64).astype(object)
    shifted: Integers = digits * np.array([1 << int(e) for e in (exponent - 53 + bits).ravel()], dtype=object).reshape(
        exponent.shape
    )
    return shifted, bits


def fraction_bits(how: Arithmetic, constants: Constants) -> int:
    """Return how many bits of s and of readings are fraction, in fixed point."""
    return how.bits + int(constants["OUTPUT_BITS"]) - (int(constants["SIGNAL_SCALE"]).bit_length() - 1)


def written_curve(how: Arithmetic, constants: Constants, j: int) -> tuple[list[Row], Ends]:
    """Return powers of r on both sides of the inverse of a curve, and its ends, as they are written."""
    table, ends = constants["CURVE"][j], constants["CURVE_ENDS"][j]
    one, e = Fraction(1), 0
    if how.fixed:
        fine = fraction_bits(how, constants)
        # rho = r / 2^e has CURVE_BITS bits where r has fine - CURVE_SHIFT
        one, e = Fraction(1, 2**fine), int(constants["CURVE_BITS"]) - (fine - int(constants["CURVE_SHIFT"]))
    powers = [tuple(Fraction(x.item()) * one / Fraction(2) ** (e * m) for m, x in enumerate(side, 1)) for side in table]
    lowest, highest = (Fraction(x.item()) * one for x in ends)
    return powers, (lowest, highest)


def written_ends(ideal: Ideal, how: Arithmetic, constants: Constants) -> list[Ends]:
    """Return the readings between which each curve is inverted; none where all are straight."""
    return [written_curve(how, constants, j)[1] for j in range(len(ideal.curves))]


def true_values(
    ideal: Ideal, i: int, away: NDArray[np.int64], tau: NDArray[np.int64] | None, ends: list[Ends]
) -> tuple[Integers, Fraction]:
    """Return the true input of axis i times SCALE, shape (n,), and a bound on its error in units of SCALE.

    Parameters
    ----------
    ends : list of (lowest, highest)
        As `written_ends`.
    """
    n, k = away.shape
    total: Integers = np.full(n, _cut(ideal.constant[i]), dtype=object)
    off = Fraction(1)
    warmth = np.zeros_like(away) if tau is None else tau
    for j in range(k):
        total = total + _cut(ideal.weights[i][j]) * away[:, j].astype(object)
        codes = 1 + int(np.max(np.abs(away[:, j]), initial=0))
        off += codes
        if ideal.bends is None and ideal.temperatures is None:
            continue
        # what a sensor gives depends on its own codes alone: each pair of them once
        key = warmth[:, j] if ideal.bends is None else warmth[:, j] + away[:, j] * 2**32
        _, first, place = np.unique(key, return_index=True, return_inverse=True)
        change, own = _thermal(ideal, j, warmth[first, j])
        if ideal.bends is not None:
            read = change + _cut(ideal.slope[j]) * away[first, j].astype(object) + _cut(ideal.reading[j])
            lowest, highest = (_cut(one) for one in ends[j])
            bend, missed = inverted(ideal.curves[j], np.clip(read, lowest, highest))
            gentlest = min(gentlest_slope(ideal.curves[j], negative) for negative in (False, True))
            change, own = change + bend, own + (own + codes + 1) * (1 + 1 / gentlest) + missed
        total = total + ((_cut(ideal.inverse[i][j]) * change) // SCALE)[place]
        largest = Fraction(int(np.max(np.abs(change), initial=0)), SCALE)
        off += abs(ideal.inverse[i][j]) * own + largest + 1
    return total, off


def _cut(value: Fraction) -> int:
    return floor(value * SCALE)


def _thermal(ideal: Ideal, j: int, tau: NDArray[np.int64]) -> tuple[Integers, Fraction]:
    total: Integers = np.zeros(len(tau), dtype=object)
    if ideal.temperatures is None:
        return total, Fraction(0)
    each, largest, off = tau.astype(object), int(np.max(np.abs(tau), initial=0)), 0
    for power in reversed(ideal.warmths[j].powers):
        total, off = (total + _cut(power)) * each, (off + 1) * largest
    return total, Fraction(off)


def inverted(bend: Bend, read: Integers) -> tuple[Integers, Fraction]:
    """Return u - r with g(u) = r, times SCALE, and a bound on its error in units of SCALE.

    By Newton's method: in floating numbers, then once on whole ones. Whatever it found, the error is at most
    ``|g(u) - r|`` over the smallest slope of g.
    """
    found: Integers = np.empty(len(read), dtype=object)
    off = Fraction(0)
    for negative, end in ((False, bend.highest), (True, bend.lowest)):
        mask = np.array(read < 0, dtype=bool) == negative
        if not mask.any():
            continue
        r, powers = read[mask], bend.powers(negative)
        one, two, three = (float(x) for x in powers)
        near = np.array(r / float(SCALE), dtype=float)
        u = near / one
        for _ in range(STEPS_OF_NEWTON):
            u = u - (u * (one + u * (two + u * three)) - near) / (one + u * (2.0 * two + 3.0 * three * u))
        first, second, third = (_cut(x) for x in powers)
        digits, bits = whole(u)
        exact = (digits << SCALE_BITS) >> bits
        value = exact * (first + exact * (second + exact * third // SCALE) // SCALE) // SCALE
        slopes = np.array((one + u * (2.0 * two + 3.0 * three * u)) * 2.0**SLOPE_BITS, dtype=np.int64).astype(object)
        lowest, highest = sorted((0, int(end * SCALE)))  # towards zero
        exact = np.clip(exact - ((value - r) << SLOPE_BITS) // slopes, lowest, highest)
        value = exact * (first * SCALE**2 + exact * (second * SCALE + exact * third))  # g(u) times SCALE^4
        size = abs(end) + 1
        cuts = size + size**2 + size**3 + 1  # the coefficients and the end, cut
        missed = Fraction(int(np.max(np.abs(value - (r << 3 * SCALE_BITS)))), SCALE**3) + cuts
        off = max(off, missed / gentlest_slope(bend, negative))
        found[mask] = exact - r
    return found, off


def gentlest_slope(bend: Bend, negative: bool) -> Fraction:
    """Return the smallest slope of a curve between zero and its end on one side."""
    first, second, third = bend.powers(negative)
    end = bend.lowest if negative else bend.highest
    places = [Fraction(0), end]
    if third != 0 and min(places) < -second / (3 * third) < max(places):
        places.append(-second / (3 * third))
    return min(first + u * (2 * second + 3 * third * u) for u in places)


def errors(ideal: Ideal, how: Arithmetic, constants: Constants, i: int, codes: Codes) -> tuple[Integers, Fraction]:
    """Return the errors of axis i at codes times SCALE, shape (n,), and by how much these can be off."""
    values, _ = run(constants, how, codes)
    inputs = reduced(constants, codes)
    truth, off = true_values(ideal, i, inputs.away, inputs.tau, written_ends(ideal, how, constants))
    found, bits = (values[:, i].astype(object), how.bits) if how.fixed else whole(values[:, i])
    return np.asarray((found << SCALE_BITS >> bits) - truth, dtype=object), off + 1


def sizes(ideal: Ideal, how: Arithmetic, constants: Constants, i: int, codes: Codes) -> NDArray[np.float64]:
    """Return the absolute errors of axis i at codes, shape (n,) [output unit]."""
    scaled, _ = errors(ideal, how, constants, i, codes)
    return np.array(np.abs(scaled) / float(SCALE), dtype=float) if len(scaled) else np.zeros(0)
