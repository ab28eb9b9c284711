"""A bound on the error of flight C over all codes, for the constants that stand in its text.

What a code contributes depends on that code alone: its error is found for each code, in exact rationals, and the
extremes of the contributions add up. Roundings of sums come on top, each with half a step of the largest number that
it can meet. Where curves bend, the inverse has the proved remainder of its polynomial. A single sensor without
temperature has one code, and there its roundings are not free of each other: see `enumeration`.

Compared with `exact.Ideal`: the true input that model and chain give for the same codes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .codes import Codes
from .design import Arithmetic, Constants, Values, extremes, largest_bend
from .enumeration import can_enumerate, worst_of_all
from .exact import Ideal, Row, Window, scaled
from .inverse import remainder
from .truth import Ends, Integers, fraction_bits, whole, written_curve
from .twin import horner, rounded, thermal

MOST_SIGNALS = 2**18  # codes of a signal that are looked at one by one; beyond, half a step is taken for each


class Span(NamedTuple):
    """Lowest and highest."""

    low: Fraction
    high: Fraction

    @property
    def size(self) -> Fraction:
        """Largest absolute value."""
        return max(-self.low, self.high)

    def plus(self, other: Span) -> Span:
        """Sum of two that vary by themselves."""
        return Span(self.low + other.low, self.high + other.high)

    def widened(self, by: Fraction) -> Span:
        """Both ends moved apart."""
        return Span(self.low - by, self.high + by)


ZERO = Span(Fraction(0), Fraction(0))
PIECES = 16  # on which the slope of an inverse is bounded


class OfCurve(NamedTuple):
    """What is proved of the inverse of a curve."""

    window: Window  # lowest and highest d whose reading may lie between the ends of the curve
    read: Fraction  # error of the reading r_j there; beyond, what is computed and what is true are cut to one end
    bend: Fraction  # error of q_j
    cut: Fraction  # the same where the reading is cut: no error of the reading comes in


@dataclass(frozen=True)
class Bounds:
    """Per axis: proved bound on the error, and lowest and highest output [output unit]."""

    errors: tuple[Fraction, ...]
    apart: tuple[Fraction, ...]  # the same with each contribution and rounding at its worst, whatever the others
    outputs: tuple[Span, ...]
    worst: Codes | None = None  # where the bound of a single sensor is met, of all codes
    remainders: tuple[Fraction, ...] = ()  # of the inverse of each curve, where there is one
    bends: tuple[OfCurve, ...] = ()


def prove(ideal: Ideal, how: Arithmetic, constants: Constants) -> Bounds:
    """Return what no code can exceed."""
    parts = _Fixed(ideal, how, constants) if how.fixed else _Floating(ideal, how, constants)
    k = len(ideal.axes)
    apart = tuple(parts.error(i).size for i in range(k))
    every = worst_of_all(ideal, how, constants, apart[0]) if can_enumerate(ideal) else None
    errors, worst = (apart, None) if every is None else ((every.bound,), every.codes)
    lowest, highest = extremes(ideal)
    outputs = tuple(Span(lo, hi).widened(e) for lo, hi, e in zip(lowest, highest, errors, strict=True))
    if ideal.bends is None:
        return Bounds(errors, apart, outputs, worst)
    remainders = tuple(parts.remainder(j) for j in range(k))
    return Bounds(errors, apart, outputs, worst, remainders, tuple(parts.of_curve(j) for j in range(k)))


def _against(found: Integers, bits: int, codes: NDArray[np.int64], powers: Sequence[Fraction]) -> Span:
    """Extremes of found / 2^bits - (powers[0] c + powers[1] c^2 + ...) over codes c."""
    numerators, common = scaled(list(powers))
    total: Integers = np.zeros(len(codes), dtype=object)
    each = codes.astype(object)
    for one in reversed(numerators):
        total = (total + one) * each
    error = found * common - total * (1 << bits)
    return Span(Fraction(int(error.min()), common << bits), Fraction(int(error.max()), common << bits))


class _Parts:
    """What both arithmetics share."""

    def __init__(self, ideal: Ideal, how: Arithmetic, constants: Constants):
        self.ideal, self.how, self.constants, self.k = ideal, how, constants, len(ideal.axes)
        self.curves: dict[int, OfCurve] = {}
        self.changes: list[Values] = []  # s of each sensor at every temperature
        if ideal.temperatures is not None:
            for j, one in enumerate(ideal.temperatures):
                tau = np.zeros((len(one.steps), self.k), dtype=np.int64)
                tau[:, j] = one.steps
                self.changes.append(thermal(constants, how, tau)[:, j])

    def value(self, name: str, *at: int) -> Fraction:
        """One constant as it is written."""
        return Fraction(self.constants[name][at].item())

    def thermal_error(self, j: int) -> Span:
        """Error of s_j alone."""
        if self.ideal.temperatures is None:
            return ZERO
        found, bits = self.exactly(self.changes[j])
        return _against(found, bits, self.ideal.warmths[j].steps, self.ideal.warmths[j].powers)

    def exactly(self, values: Values) -> tuple[Integers, int]:
        """Return values of s or of outputs as whole numbers, and how many bits of them are fraction."""
        raise NotImplementedError

    def curve(self, j: int) -> tuple[list[Row], Ends]:
        """Powers of r on both sides, and the ends, as they are written."""
        return written_curve(self.how, self.constants, j)

    def error(self, i: int) -> Span:
        """Error of an output."""
        if self.ideal.bends is None:
            return self.summed(i, self.ideal.signals[i], cut=False)
        # Codes far out make the largest errors of products and sums, and there the reading of the curve is cut.
        inside = self.summed(i, self.of_curve(i).window, cut=False)
        outside = self.summed(i, self.ideal.signals[i], cut=True)
        return Span(min(inside.low, outside.low), max(inside.high, outside.high))

    def summed(self, i: int, window: Window, cut: bool) -> Span:
        """Return the error of an output, of d of its own sensor within a window, or with its reading cut."""
        raise NotImplementedError

    def of_curve(self, j: int) -> OfCurve:
        """Return what is proved of the inverse of a curve."""
        if j not in self.curves:
            window = self.window(j)
            read = self.reading(j, window)
            self.curves[j] = OfCurve(window, read, self.bend(j, read), self.cut(j))
        return self.curves[j]

    def window(self, j: int) -> Window:
        """Return the lowest and the highest d whose reading may lie between the ends of the curve.

        Of any other the true reading lies beyond an end by more than the error of the computed one: both are cut there.
        """
        ideal, (lowest, highest) = self.ideal, self.ideal.signals[j]
        change = self.change(j) + self.thermal_error(j).size
        beyond = max(map(abs, self.curve(j)[1])) + self.reading(j, (lowest, highest))
        far = ceil((beyond + abs(ideal.reading[j]) + change) / abs(ideal.slope[j]))
        inside = max(lowest, -far), min(highest, far)
        return inside if inside[0] <= inside[1] else (lowest, highest)

    def change(self, j: int) -> Fraction:
        """Return the largest s_j as it is computed."""
        if self.ideal.temperatures is None:
            return Fraction(0)
        found, bits = self.exactly(self.changes[j])
        return Fraction(int(np.max(np.abs(found))), 1 << bits)

    def reading(self, j: int, window: Window) -> Fraction:
        """Return the error of the reading that a curve is inverted at, of d within a window."""
        raise NotImplementedError

    def bend(self, j: int, read: Fraction) -> Fraction:
        """Return the error of q_j, from that of its reading."""
        raise NotImplementedError

    def cut(self, j: int) -> Fraction:
        """Return the error of q_j at the ends of the curve, by evaluating it there."""
        (powers, ends), constants, found = self.curve(j), self.constants, Fraction(0)
        for side, at in ((0, 1), (1, 0)):
            near = np.atleast_1d(constants["CURVE_ENDS"][j, at])
            near = rounded(near, int(constants["CURVE_SHIFT"])) if self.how.fixed else near
            made = np.zeros_like(near)
            for factor in constants["CURVE"][j, side, ::-1]:
                made = horner(self.how, made, factor, near, constants.get("CURVE_BITS"))
            values, bits = self.exactly(made)
            exact = sum((x * ends[at] ** m for m, x in enumerate(powers[side], 1)), Fraction(0))
            found = max(found, abs(Fraction(int(values[0]), 1 << bits) - exact))
        return self.remainder(j) + found

    def remainder(self, j: int, sides: Sequence[int] = (0, 1)) -> Fraction:
        """Of the written polynomials, for readings above zero (0) and below (1)."""
        bend, (powers, (lowest, highest)) = self.ideal.curves[j], self.curve(j)
        if not bend.reading(bend.lowest) <= lowest <= 0 <= highest <= bend.reading(bend.highest):
            raise ValueError(f"ends {lowest} and {highest} of a curve lie beyond what it is inverted for")
        return max(remainder(bend, powers[side], bool(side)) for side in sides)

    def bend_error(self, j: int, read: Fraction, fine: tuple[Fraction, Fraction]) -> Fraction:
        """Error of q_j, from that of the reading that it is evaluated at and the roundings on the way on each side."""
        powers, ends = self.curve(j)
        found = Fraction(0)
        for side, end in ((0, max(Fraction(0), ends[1]) + read), (1, min(Fraction(0), ends[0]) - read)):
            # Where the sign is taken for the other one, the readings lie on both sides of zero, where q is 0, and both
            # together no further from it than `read`.
            other = read if side else -read
            steep = max(_largest(_derivative(powers[side]), end), _largest(_derivative(powers[1 - side]), other))
            found = max(found, self.remainder(j, (side,)) + steep * read + fine[side])
        return found


def _largest(powers: Row, end: Fraction) -> Fraction:
    """Return a bound on the size of powers[0] + powers[1] r + ... between 0 and an end.

    On each of some pieces: the size in its middle, and half its length times a bound on the slope there.
    """
    found = Fraction(0)
    for piece in range(PIECES):
        middle, far = end * (2 * piece + 1) / (2 * PIECES), abs(end) * (piece + 1) / PIECES
        slope = sum((m * abs(x) * far ** (m - 1) for m, x in enumerate(powers[1:], 1)), Fraction(0))
        found = max(found, abs(_at(powers, middle)) + abs(end) / (2 * PIECES) * slope)
    return found


def _derivative(powers: Row) -> Row:
    """Return the slope of powers[0] r + powers[1] r^2 + ..."""
    return tuple(m * x for m, x in enumerate(powers, 1))


def _at(powers: Row, r: Fraction) -> Fraction:
    total = Fraction(0)
    for x in reversed(powers):
        total = total * r + x
    return total


class _Fixed(_Parts):
    @property
    def fine(self) -> int:
        """Fraction bits of s."""
        return fraction_bits(self.how, self.constants)

    @property
    def coarse(self) -> int:
        """Fraction bits of C and W."""
        return self.how.bits + int(self.constants["OUTPUT_BITS"])

    def exactly(self, values: Values) -> tuple[Integers, int]:
        return values.astype(object), self.fine

    def summed(self, i: int, window: Window, cut: bool) -> Span:
        ideal, coarse = self.ideal, Fraction(1, 2**self.coarse)
        total = Span(*[self.value("CONSTANT", i) / 2**self.fine - ideal.constant[i]] * 2)
        for j in range(self.k):
            off = self.value("WEIGHT", i, j) * coarse - ideal.weights[i][j]
            ends = [off * d for d in (window if j == i else ideal.signals[j])]
            total = total.plus(Span(min(ends), max(ends)))
        if "MIXED" in self.constants:
            mixed_bits = int(self.constants["MIXED_BITS"])
            for j in range(self.k):
                factor = int(self.constants["MIXED"][i, j]) + ((1 << mixed_bits) if i == j else 0)
                if ideal.temperatures is not None:
                    powers = [ideal.inverse[i][j] * x for x in ideal.warmths[j].powers]
                    found, steps = self.changes[j].astype(object) * factor, ideal.warmths[j].steps
                    total = total.plus(_against(found, self.fine + mixed_bits, steps, powers))
                if ideal.bends is not None:
                    written = Fraction(factor, 1 << mixed_bits)
                    curve = self.of_curve(j)
                    bend = abs(written) * (curve.cut if cut and i == j else curve.bend)
                    bend += abs(written - ideal.inverse[i][j]) * largest_bend(ideal.curves[j])
                    total = total.widened(bend)
            total = total.widened(Fraction(1, 2 ** (self.fine + 1)))
        return total.widened(Fraction(1, 2 ** (self.how.bits + 1)))

    def reading(self, j: int, window: Window) -> Fraction:
        ideal, step, coarse = self.ideal, Fraction(1, 2**self.fine), Fraction(1, 2**self.coarse)
        read = step / 2 + abs(self.value("SLOPE", j) * coarse - ideal.slope[j]) * max(map(abs, window))
        read += abs(self.value("READING", j) * step - ideal.reading[j]) + self.thermal_error(j).size
        return read + step * Fraction(2) ** (int(self.constants["CURVE_SHIFT"]) - 1)

    def bend(self, j: int, read: Fraction) -> Fraction:
        step, (_, ends) = Fraction(1, 2**self.fine), self.curve(j)
        e = int(self.constants["CURVE_BITS"]) - (self.fine - int(self.constants["CURVE_SHIFT"]))
        count = self.constants["CURVE"].shape[2]
        fine = [
            sum((((abs(end) + read) / Fraction(2) ** e) ** m for m in range(count)), Fraction(0)) * step / 2
            for end in (ends[1], ends[0])
        ]
        return self.bend_error(j, read, (fine[0], fine[1]))


class _Floating(_Parts):
    def half(self, size: Fraction) -> Fraction:
        """Largest error of rounding a number that is no larger."""
        return half_step(size, self.how)

    def exactly(self, values: Values) -> tuple[Integers, int]:
        return whole(values)

    def product(self, factor: np.generic, ideal: Fraction, ends: Window) -> tuple[Span, Span]:
        """Error and values of a rounded product of a constant with every code."""
        written = Fraction(factor.item())
        if written == 0 and ideal == 0:
            return ZERO, ZERO
        if ends[1] - ends[0] < MOST_SIGNALS:
            codes = np.arange(ends[0], ends[1] + 1)
            values = factor * codes.astype(self.how.dtype)
            error = _against(*whole(values), codes, [ideal])
            return error, Span(Fraction(values.min().item()), Fraction(values.max().item()))
        here = sorted(written * d for d in ends)
        value = Span(here[0], here[1])
        off = sorted((written - ideal) * d for d in ends)
        return Span(off[0], off[1]).widened(self.half(value.size)), value.widened(self.half(value.size))

    def summed(self, i: int, window: Window, cut: bool) -> Span:
        ideal, constants = self.ideal, self.constants
        start = self.value("CONSTANT", i)
        error, value = Span(*[start - ideal.constant[i]] * 2), Span(start, start)
        parts = []
        if "INVERSE" in constants:
            parts += [self.mixed(i, j, cut and i == j) for j in range(self.k)]
        parts += [self.product(constants["WEIGHT"][i, j], ideal.weights[i][j], ideal.signals[j])
                  for j in range(self.k) if j != i]  # fmt: skip
        parts.append(self.product(constants["OWN_WEIGHT"][i], ideal.weights[i][i], window))
        for off, values in parts:
            if values == ZERO and off == ZERO:
                continue  # adds nothing, exactly
            value = value.plus(values)
            rounding = self.half(value.size)
            error, value = error.plus(off).widened(rounding), value.widened(rounding)
        return error

    def mixed(self, i: int, j: int, cut: bool) -> tuple[Span, Span]:
        """Error and values of N_ij (s_j + q_j), rounded."""
        ideal, factor = self.ideal, self.constants["INVERSE"][i, j]
        written, wanted = Fraction(factor.item()), ideal.inverse[i][j]
        if written == 0 and wanted == 0:
            return ZERO, ZERO
        if ideal.bends is None:
            values = factor * self.changes[j]
            powers = [wanted * x for x in ideal.warmths[j].powers]
            error = _against(*whole(values), ideal.warmths[j].steps, powers)
            return error, Span(Fraction(values.min().item()), Fraction(values.max().item()))
        size, change = largest_bend(ideal.curves[j]), self.change(j)
        curve = self.of_curve(j)
        warm, own = self.thermal_error(j).size, curve.cut if cut else curve.bend
        own += warm + self.half(change + size + own)
        size += change + warm
        off = abs(written) * own + abs(written - wanted) * size
        largest = abs(written) * (size + own)
        off += self.half(largest)
        return ZERO.widened(off), ZERO.widened(largest + self.half(largest))

    def reading(self, j: int, window: Window) -> Fraction:
        ideal, half = self.ideal, self.half
        off, straight = self.product(self.constants["SLOPE"][j], ideal.slope[j], window)
        start = self.value("READING", j)
        size = straight.size + abs(start)
        read = off.size + abs(start - ideal.reading[j]) + half(size)
        if ideal.temperatures is None:
            return read
        return read + self.thermal_error(j).size + half(size + half(size) + self.change(j))

    def bend(self, j: int, read: Fraction) -> Fraction:
        powers, ends = self.curve(j)
        half, fine = self.half, []
        for side, end in zip(powers, (ends[1], ends[0]), strict=True):  # Horner's rule, each step with its roundings
            error = Fraction(0)
            for m in range(len(side) - 1, -1, -1):
                error += half(_largest(side[m:], end) + error)
                error = error * abs(end) + half(_largest((Fraction(0), *side[m:]), end) + error * abs(end))
            fine.append(error)
        return self.bend_error(j, read, (fine[0], fine[1]))


def half_step(size: Fraction, how: Arithmetic) -> Fraction:
    """Return half the distance of floating numbers at a size: what rounding there can miss."""
    if size == 0:
        return Fraction(0)
    e = size.numerator.bit_length() - size.denominator.bit_length()
    e -= 1 if size < Fraction(2) ** e else 0
    least = {24: -149, 53: -1074}[how.bits]
    return Fraction(2) ** max(e - how.bits, least - 1)
