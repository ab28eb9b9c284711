"""The numbers of flight C: how many bits each has, chosen from ranges that hold for all codes.

Fixed point, with N fraction bits in the output and G guard bits; F_s = N + G fraction bits in s and in readings::

    h = S_n;  h = rounded(h tau, B) + S_(n-1); ...;  s = rounded(h tau, B)      S_k has F_s + k B bits, 2^B > |tau|
    p_i = C_i + s_i + rounded(sum_j E_ij s_j, B_E)                               E = N - I
    x_i = rounded(sum_j W_ij d_j + p_i 2^B_d, B_d + G)                            W has F_s + B_d bits, 2^B_d > |d|

so that each constant is as fine as the largest number that it is multiplied with needs, and no finer. Floating point
has no formats to choose: ``x_i = W_ii d_i + (C_i + sum_j N_ij s_j + sum_(j != i) W_ij d_j)``, where the largest part
comes last.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError, UsageError
from .exact import Bend, Ideal
from .inverse import inverse_powers

GUARD = range(8, 3, -1)  # guard bits, the most that fit; with fewer, an output has digits that mean nothing
LOST = range(-3, 1)  # size of what a reading loses before it is raised to powers: in q, 2^lost of the last bit
INT32, INT64 = 2**31 - 1, 2**62  # the second with a bit to spare for the half that rounding adds
REMAINDER = Fraction(1, 64)  # of a step of the output: what the inverse of a curve may leave
EXACT_CODES = {"float": 2**24, "double": 2**53}  # whole numbers that a floating type holds

Values = NDArray[Any]  # int64, float32 or float64
Constants = Mapping[str, Values]


@dataclass(frozen=True)
class Arithmetic:
    """How numbers are held: ``q27``, ``float32``, ``float64``."""

    name: str
    bits: int  # fraction bits of a fixed-point output; digits of a floating one
    ctype: str  # of the constants: int64_t, float, double

    @property
    def fixed(self) -> bool:
        """Whether it is fixed point."""
        return self.ctype == "int64_t"

    @property
    def dtype(self) -> np.dtype[np.generic]:
        """The same in numpy."""
        return np.dtype({"int64_t": "int64", "float": "float32", "double": "float64"}[self.ctype])

    @property
    def output(self) -> str:
        """Type of an output in C."""
        return "int32_t" if self.fixed else self.ctype


FLOATS = {"float32": Arithmetic("float32", 24, "float"), "float64": Arithmetic("float64", 53, "double")}


def arithmetic(text: str) -> Arithmetic:
    """Return the arithmetic of a name.

    Raises
    ------
    UsageError
        ``unknown_arithmetic``.
    """
    if text in FLOATS:
        return FLOATS[text]
    found = re.fullmatch(r"q([1-9][0-9]?)", text)
    if found is None or int(found[1]) > 31:
        raise UsageError(
            f"--arithmetic {text}: no such arithmetic",
            do="Give q27 (27 fraction bits in 32; q1 to q31), float32 or float64",
            code="unknown_arithmetic",
        )
    return Arithmetic(text, int(found[1]), "int64_t")


@dataclass(frozen=True)
class Constant:
    """A named number, row or table of the code."""

    ctype: str
    values: Values
    comment: str


@dataclass(frozen=True, eq=False)
class Design:
    """The constants of one sensor, in the order of the code."""

    arithmetic: Arithmetic
    constants: Mapping[str, Constant]
    guard: int = 0  # guard bits of fixed point


def design(ideal: Ideal, how: Arithmetic) -> Design:
    """Return the constants of a sensor in an arithmetic.

    Raises
    ------
    DataError
        ``overflow`` where the output does not fit, with the largest format that does; ``cannot_hold``.
    """
    whole = _whole(ideal)
    if not how.fixed:
        largest = max(abs(one) for span in ideal.signals for one in span)
        largest = max([largest, *(int(np.max(np.abs(one.steps))) for one in ideal.temperatures or ())])
        if largest > EXACT_CODES[how.ctype]:
            raise DataError(
                f"{how.name} cannot hold codes up to {largest}",
                why=f"it is exact up to {EXACT_CODES[how.ctype]} only",
                do="Give --arithmetic float64",
                code="overflow",
            )
        return Design(how, whole | _floating(ideal, how))
    made = _fixed(ideal, how)
    if made is not None:
        constants, guard = made
        return Design(how, whole | constants, guard)
    fits = next((n for n in range(how.bits - 1, 0, -1) if _fixed(ideal, Arithmetic("", n, how.ctype))), None)
    lowest, highest = extremes(ideal)
    raise DataError(
        f"{how.name} does not hold the outputs of all codes: {float(min(lowest)):.4g} to "
        f"{float(max(highest)):.4g} {ideal.unit}",
        why="they or what they are summed from would overflow",
        do="Give --arithmetic float64" if fits is None else f"Give --arithmetic q{fits}, the largest that fits",
        code="overflow",
    )


def extremes(ideal: Ideal) -> tuple[list[Fraction], list[Fraction]]:
    """Return the lowest and the highest output of each axis over all codes; too wide by little where curves bend."""
    lowest, highest = list(ideal.constant), list(ideal.constant)
    own = _largest_corrections(ideal)
    for i, row in enumerate(ideal.weights):
        for j, weight in enumerate(row):
            ends = [weight * d for d in ideal.signals[j]]
            lowest[i] += min(ends) - abs(ideal.inverse[i][j]) * own[j]
            highest[i] += max(ends) + abs(ideal.inverse[i][j]) * own[j]
    return lowest, highest


def _largest_corrections(ideal: Ideal) -> list[Fraction]:
    """Bound on |s_j + q_j| of each sensor."""
    found = []
    for j in range(len(ideal.axes)):
        total = Fraction(0)
        if ideal.temperatures is not None:
            one = ideal.warmths[j]
            size = max(abs(one.lowest - one.centre), abs(one.highest - one.centre))
            total += sum((abs(power) * size**k for k, power in enumerate(one.powers, 1)), Fraction(0))
        if ideal.bends is not None:
            total += largest_bend(ideal.curves[j])
        found.append(total)
    return found


def largest_bend(bend: Bend) -> Fraction:
    """Return a bound on |g(u) - u| over the range of a curve."""
    size = max(-bend.lowest, bend.highest)
    return size * (abs(bend.asymmetry) / 2 + size * (abs(bend.second) + size * abs(bend.third)))


# ---- whole numbers that every arithmetic has -----------------------------------------------------------------------


def _whole(ideal: Ideal) -> dict[str, Constant]:
    def table(name: str, values: object, comment: str) -> None:
        found[name] = Constant("int32_t", np.asarray(values, dtype=np.int64), comment)

    found: dict[str, Constant] = {}
    ends = "ends of the converter" if ideal.has_ends else "ends of the codes that the bound holds for"
    table("LOWEST", ideal.lowest, ends)
    table("HIGHEST", ideal.highest, "")
    if not ideal.has_reference:
        table("ORIGIN", ideal.origin, "code of the fixed reference")
    if ideal.reference_window is not None:
        table("REFERENCE_WINDOW", ideal.reference_window, "plausible codes of the reference")
    if ideal.temperatures is not None:
        if ideal.temperature_window is not None:
            table("TEMPERATURE_WINDOW", ideal.temperature_window, "plausible codes of the reference of the temperature")
        each = [(one.lowest, one.highest) for one in ideal.temperatures]
        table("TEMPERATURE_ENDS", each, "codes above the reference in the temperature range of the model")
        table("TEMPERATURE_CENTRE", [one.centre for one in ideal.temperatures], "subtracted from them: tau")
    if ideal.good is not None:
        table("GOOD", ideal.good, "lowest good code of the built-in test")
    return found


def _powers(ideal: Ideal) -> list[list[Fraction]]:
    """Powers of tau of every sensor, of the same number."""
    if ideal.temperatures is None:
        return []
    size = max(1, *(len(one.powers) for one in ideal.temperatures))
    return [[*one.powers, *[Fraction(0)] * (size - len(one.powers))] for one in ideal.temperatures]


# ---- floating point ------------------------------------------------------------------------------------------------


def _floating(ideal: Ideal, how: Arithmetic) -> dict[str, Constant]:
    def table(name: str, values: object, comment: str) -> None:
        rounded = np.vectorize(nearest, otypes=[float])(np.array(values, dtype=object))
        found[name] = Constant(how.ctype, np.asarray(rounded, dtype=how.dtype), comment)

    def nearest(value: Fraction) -> float:
        return to_float(value, how)

    k, unit = len(ideal.axes), ideal.unit
    found: dict[str, Constant] = {}
    if ideal.temperatures is not None:
        table("THERMAL", _powers(ideal), f"s over tau, tau^2, ... [{unit}]")
    if ideal.bends is not None:
        table("SLOPE", ideal.slope, f"one code [{unit}]")
        table("READING", ideal.reading, f"reading at d = 0 and tau = 0 [{unit}]")
        target = REMAINDER * Fraction(2) ** (
            _exponent(max(abs(one) for ends in extremes(ideal) for one in ends)) - how.bits
        )
        powers = inverse_powers(ideal.curves, target)
        inside = [[_inward(bend.reading(end), how) for end in (bend.lowest, bend.highest)] for bend in ideal.curves]
        table("CURVE_ENDS", inside, f"readings that are inverted [{unit}]")
        table("CURVE", powers, "inverse of the curve, for r >= 0 and r < 0: added to r, over r, r^2, ...")
    if ideal.temperatures is not None or ideal.bends is not None:
        table("INVERSE", ideal.inverse, "M^-1; row = axis of the output, column = the sensor")
    off = [[Fraction(0) if i == j else x for j, x in enumerate(row)] for i, row in enumerate(ideal.weights)]
    table("CONSTANT", ideal.constant, f"output at d = 0 and tau = 0 [{unit}]")
    table("WEIGHT", off, f"output a code of the other sensors [{unit}]")
    table("OWN_WEIGHT", [ideal.weights[i][i] for i in range(k)], f"output a code of the sensor along the axis [{unit}]")
    if ideal.input_range is not None:
        table("INPUT_ENDS", ideal.input_range, f"that the model holds for [{unit}]")
    return found


def to_float(value: Fraction, how: Arithmetic) -> float:
    """Return the nearest number of a floating type, ties to even."""
    if value == 0:
        return 0.0
    exponent = _exponent(abs(value)) - how.bits
    size = value / Fraction(2) ** exponent
    return float(Fraction(round(size)) * Fraction(2) ** exponent)


def _exponent(size: Fraction) -> int:
    """Smallest e with size < 2^e."""
    e = size.numerator.bit_length() - size.denominator.bit_length()
    return e + 1 if size >= Fraction(2) ** e else e


def _inward(value: Fraction, how: Arithmetic) -> Fraction:
    """Return the number of a floating type next to a value, on the side of zero."""
    if value == 0:
        return value
    exponent = Fraction(2) ** (_exponent(abs(value)) - how.bits)
    return int(value / exponent) * exponent


# ---- fixed point ---------------------------------------------------------------------------------------------------


def _fixed(ideal: Ideal, how: Arithmetic) -> tuple[dict[str, Constant], int] | None:
    """Constants with as many guard bits as fit, and how many; None where no number fits."""
    lowest, highest = extremes(ideal)
    if (max(*highest, *(-one for one in lowest)) * 2**how.bits) + 2 > INT32:
        return None
    for guard in GUARD:
        for lost in LOST if ideal.bends is not None else LOST[:1]:
            made = _with_guard(ideal, how, guard, lost)
            if made is not None:
                return made, guard
    return None


def _with_guard(ideal: Ideal, how: Arithmetic, guard: int, lost: int) -> dict[str, Constant] | None:
    fine, k, unit = how.bits + guard, len(ideal.axes), ideal.unit
    found: dict[str, Constant] = {}

    def table(name: str, values: object, bits: int | None, comment: str) -> NDArray[np.object_]:
        fractions = np.array(values, dtype=object)
        whole: NDArray[np.object_] = np.vectorize(
            lambda x: round_away(x * Fraction(2) ** (bits or 0)), otypes=[object]
        )(fractions)
        found[name] = Constant("int64_t", whole, f"{comment}, times 2^{bits}" if bits else comment)
        return whole

    def shift(name: str, bits: int, comment: str) -> None:
        found[name] = Constant("uint32_t", np.asarray(bits, dtype=np.int64), comment)

    largest = [0]  # absolute values of the numbers that are summed or multiplied
    signal = max(abs(one) for span in ideal.signals for one in span)
    signal_bits = signal.bit_length()
    changes = [0] * k  # bound on |s_j + q_j|, whole
    if ideal.temperatures is not None:
        changes = _fixed_thermal(ideal, fine, (table, shift), largest)
    if ideal.bends is not None:
        changes = _fixed_curve(ideal, how, (fine, lost), (table, shift), changes, largest)
    if found:
        total = max(changes)
        identity = [[x - int(i == j) for j, x in enumerate(row)] for i, row in enumerate(ideal.inverse)]
        mixed_bits = max(1, total.bit_length())
        whole = table("MIXED", identity, mixed_bits, "M^-1 - I; row = axis of the output, column = the sensor")
        shift("MIXED_BITS", mixed_bits, "of these")
        largest += [sum(abs(x) * changes[j] for j, x in enumerate(row)) for row in whole]
        changes = [changes[i] + (one >> mixed_bits) + 1 for i, one in enumerate(largest[-k:])]
    found["SIGNAL_SCALE"] = Constant("int64_t", np.asarray(2**signal_bits), "2^bits of a signal")
    constant = table("CONSTANT", ideal.constant, fine, f"output at d = 0 and tau = 0 [{unit}]")
    weights = table("WEIGHT", ideal.weights, fine + signal_bits, f"output a code of each sensor [{unit}]")
    for i, row in enumerate(weights):
        largest.append(sum(abs(x) for x in row) * signal + ((abs(constant[i]) + changes[i]) << signal_bits))
    shift("OUTPUT_BITS", signal_bits + guard, f"from there to {how.bits} fraction bits")
    if ideal.input_range is not None:
        ends = [(max(-INT32, ceil(lo * 2**how.bits)), min(INT32, floor(hi * 2**how.bits)))
                for lo, hi in ideal.input_range]  # fmt: skip
        table("INPUT_ENDS", [[Fraction(x) for x in row] for row in ends], None,
              f"that the model holds for [{unit}, times 2^{how.bits}]")  # fmt: skip
    if max(largest) >= INT64:
        return None
    return {
        name: Constant(one.ctype, np.asarray(one.values, dtype=np.int64), one.comment) for name, one in found.items()
    }


def _fixed_thermal(
    ideal: Ideal, fine: int, make: tuple[Callable[..., NDArray[np.object_]], Callable[..., None]], largest: list[int]
) -> list[int]:
    """Add the constants of s; return bounds on it."""
    table, shift = make
    most = max(1, *(int(np.max(np.abs(one.steps))) for one in ideal.warmths))
    bits, found = most.bit_length(), []
    rows = [[power * Fraction(2) ** (m * bits) for m, power in enumerate(row, 1)] for row in _powers(ideal)]
    whole = table("THERMAL", rows, fine, f"s over tau, tau^2, ... [{ideal.unit}], the power m times 2^({bits} m)")
    shift("THERMAL_BITS", bits, "of each power of tau")
    for row in whole:
        size = 0
        for power in reversed(row):
            largest.append((size + abs(power)) * most)
            size = (largest[-1] >> bits) + 1
        found.append(size)
    return found


def _fixed_curve(
    ideal: Ideal, how: Arithmetic, bits: tuple[int, int],
    make: tuple[Callable[..., NDArray[np.object_]], Callable[..., None]], changes: list[int], largest: list[int],
) -> list[int]:  # fmt: skip
    """Add the constants of the inverse curves; return bounds on |s_j + q_j|."""
    table, shift = make
    (fine, lost), unit = bits, ideal.unit
    signal = max(abs(one) for span in ideal.signals for one in span)
    signal_bits = signal.bit_length()
    slope = table("SLOPE", ideal.slope, fine + signal_bits, f"one code [{unit}]")
    reading = table("READING", ideal.reading, fine, f"reading at d = 0 and tau = 0 [{unit}]")
    shift("SLOPE_BITS", signal_bits, f"from there to {fine} fraction bits")
    ends = [[bend.reading(end) for end in (bend.lowest, bend.highest)] for bend in ideal.curves]
    inside = [[Fraction(int(x * 2**fine)) for x in row] for row in ends]  # towards zero
    table("CURVE_ENDS", inside, None, f"readings that are inverted [{unit}, times 2^{fine}]")
    top = max(Fraction(1, 2**fine), *(abs(x) for row in ends for x in row))
    e = _exponent(top)  # readings are below 2^e
    steep = max(abs(x - 1) for bend in ideal.curves for x in _slopes(bend))
    read_bits = min(fine - 1, max(1 - e, fine - lost + _exponent(max(steep, Fraction(1, 2**20)))))
    shift("CURVE_SHIFT", fine - read_bits, "that a reading loses before it is raised to powers")
    shift("CURVE_BITS", read_bits + e, "of each power of it")
    powers = inverse_powers(ideal.curves, REMAINDER / 2**how.bits)
    rows = [[[x * Fraction(2) ** (e * m) for m, x in enumerate(side, 1)] for side in one] for one in powers]
    curve = table("CURVE", rows, fine,
                  f"inverse of the curve, for r >= 0 and r < 0: added to r, over powers of r/2^{e}")  # fmt: skip
    found = []
    for j, one in enumerate(curve):
        largest.append(abs(slope[j]) * signal)
        largest.append((largest[-1] >> signal_bits) + 1 + abs(reading[j]) + changes[j])
        bend = 0
        for side, end in zip(one, reversed(ends[j]), strict=True):
            size, near = 0, int(abs(end) * 2**read_bits) + 1
            for power in reversed(side):
                largest.append((size + abs(power)) * near)
                size = (largest[-1] >> (read_bits + e)) + 1
            bend = max(bend, size)
        found.append(changes[j] + bend)
    return found


def _slopes(bend: Bend) -> list[Fraction]:
    """Slope of a curve at its ends and on both sides of zero."""
    found = []
    for negative, end in ((True, bend.lowest), (False, bend.highest)):
        first, second, third = bend.powers(negative)
        found += [first, first + end * (2 * second + 3 * third * end)]
    return found


def round_away(value: Fraction) -> int:
    """Return the nearest whole number, halves away from zero."""
    size = floor(abs(value) + Fraction(1, 2))
    return size if value >= 0 else -size
