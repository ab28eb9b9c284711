"""The same bound for an independent prover: a file for Gappa [1]_, one goal an axis.

It holds the written constants as they are and the ideal ones between two neighbours at 2^-160. Gappa takes codes as
numbers of a range, not one by one, so what it can show is a little larger than the proved bound.

Where curves bend there are more files. One for each sensor shows the error of its reading, of codes whose reading may
lie between the ends of the curve. One for each sensor and sign of its reading shows the error of the inverse alone,
with that error and the remainder of the polynomial as premises; the remainder is proved in `inverse`.

References
----------
.. [1] Daumas and Melquiond, Certification of bounds on expressions involving rounded operators, ACM TOMS 37, 2010.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import ceil, floor
from typing import Self

from .bound import Bounds
from .design import Arithmetic, Constants, largest_bend
from .exact import Ideal

FINE = 160  # bits of the neighbours of an ideal constant
SLACK = Fraction(13, 10)  # of the proved bound, that Gappa has to show
READ_SLACK, BEND_SLACK = Fraction(11, 10), Fraction(14, 10)  # the same of the error of a reading, and of q
APART = Fraction(21, 20)  # of the bound with every rounding at its worst
SPLIT = 2**13  # codes that Gappa takes one by one in seconds


def scripts(
    ideal: Ideal, how: Arithmetic, constants: Constants, bounds: Bounds, notes: Sequence[str]
) -> dict[str, str]:
    """Return files by what is added to their names; Gappa ends with 0 for a file of which it shows every goal."""
    found = {"": _Script(ideal, how, constants, bounds).axes().text(notes)}
    if ideal.bends is not None:
        for j, axis in enumerate(ideal.axes):
            found[f"_{axis}_reading"] = _Script(ideal, how, constants, bounds).reading(j).text(notes)
            for side, sign in enumerate(("positive", "negative")):
                made = _Script(ideal, how, constants, bounds).bend(j, side)
                if made is not None:
                    found[f"_{axis}_{sign}"] = made.text(notes)
    return found


class _Script:
    def __init__(self, ideal: Ideal, how: Arithmetic, constants: Constants, bounds: Bounds):
        self.ideal, self.how, self.constants, self.bounds = ideal, how, constants, bounds
        self.k = len(ideal.axes)
        self.definitions: list[str] = []
        self.premises: dict[str, None] = {}
        self.goals: list[str] = []
        self.hints: list[str] = []
        self.signals = [f"d{j}" for j in range(self.k)]
        self.warm: list[tuple[str, str]] = []  # s of each sensor, as it is computed and as it should be
        self.changes: list[tuple[str, str]] = []  # the same of s + q
        self.coarse = how.bits + int(constants["OUTPUT_BITS"]) if how.fixed else 0
        self.fine = self.coarse - (int(constants["SIGNAL_SCALE"]).bit_length() - 1) if how.fixed else 0

    def axes(self) -> Self:
        """Set the error of each output as goal; where curves bend, of codes inside their own and of those beyond."""
        for j in range(self.k):
            self.code(f"d{j}", *self.ideal.signals[j])
            self.warm.append(self.thermal(j) if "THERMAL" in self.constants else ("", ""))
        bent = self.ideal.bends is not None
        if bent or "THERMAL" in self.constants:
            self.changes = [self.corrected(j, "", self.bounds.bends[j].bend) if bent else self.warm[j]
                            for j in range(self.k)]  # fmt: skip
        for i, most in enumerate(goals(self.ideal, self.bounds)):
            if not bent:
                self.output(f"{i}", i, most)
                continue
            curve, usual = self.bounds.bends[i], (self.signals[i], self.changes[i])
            for word, window, error in (("i", curve.window, curve.bend), ("o", self.ideal.signals[i], curve.cut)):
                self.signals[i] = self.code(f"d{i}{word}", *window)
                self.changes[i] = self.corrected(i, word, error)
                self.output(f"{i}{word}", i, most)
            self.signals[i], self.changes[i] = usual
        return self

    def output(self, name: str, i: int, most: Fraction) -> None:
        here, wanted = self.fixed(i) if self.how.fixed else self.floating(name, i)
        self.goal(f"{self.define(f'x{name}', here)} - {self.define(f'X{name}', wanted)}", most)

    def text(self, notes: Sequence[str]) -> str:
        lines = [f"# {line}".rstrip() for line in notes]
        lines += ["#@ -Eprecision=160", *self.definitions, "", "{ " + "\n  /\\ ".join(self.premises)]
        return "\n".join([*lines, "  ->", "  " + "\n  /\\ ".join(self.goals), "}", *self.hints, ""])

    # ---- words ----

    def define(self, name: str, expression: str) -> str:
        self.definitions.append(f"{name} = {expression};")
        return name

    def premise(self, text: str) -> None:
        self.premises[text] = None

    def code(self, name: str, lowest: int, highest: int) -> str:
        self.premise(f"{name} in [{lowest}, {highest}]")
        self.premise(f"@FIX({name}, 0)")
        return name

    def goal(self, expression: str, size: Fraction) -> None:
        self.goals.append(f"|{expression}| <= {_above(size)}")

    def near(self, name: str, value: Fraction) -> str:
        """Name of an ideal constant, or the number itself where it has few digits."""
        low = floor(value * 2**FINE)
        if Fraction(low, 2**FINE) == value:
            return _dyadic(value)
        self.premise(f"{name} in [{low}b-{FINE}, {low + 1}b-{FINE}]")
        return name

    def rounded(self, expression: str, bits: int = 0) -> str:
        if self.how.fixed:
            return f"fixed<{-bits}, na>({expression})"
        return f"float<{'ieee_32' if self.how.bits == 24 else 'ieee_64'}, ne>({expression})"

    def written(self, name: str, *at: int, bits: int = 0) -> str:
        return _dyadic(Fraction(self.constants[name][at].item()) / Fraction(2) ** bits)

    def horner(self, name: str, factors: Sequence[str], variable: str, bits: Sequence[int]) -> str:
        """Powers of a variable as the code has them, the highest first; ``bits`` after each product."""
        here = ""
        for m in range(len(factors) - 1, -1, -1):
            total = factors[m] if not here else f"({here} + {factors[m]})"
            if here and not self.how.fixed:
                total = self.rounded(f"{here} + {factors[m]}")
            here = self.define(f"{name}_{m}", self.rounded(f"{total} * {variable}", bits[m]))
        return here

    def exact(self, name: str, factors: Sequence[str], variable: str) -> str:
        here = ""
        for m in range(len(factors) - 1, -1, -1):
            total = f"({here} + {factors[m]})" if here else factors[m]
            here = self.define(f"{name}_{m}", f"{total} * {variable}")
        return here

    # ---- sensors ----

    def thermal(self, j: int) -> tuple[str, str]:
        """s_j as it is computed and as it should be."""
        one = self.ideal.warmths[j]
        tau = self.code(f"t{j}", one.lowest - one.centre, one.highest - one.centre)
        count = self.constants["THERMAL"].shape[1]
        powers = [*one.powers, *[Fraction(0)] * (count - len(one.powers))]
        step = int(self.constants["THERMAL_BITS"]) if self.how.fixed else 0
        bits = [self.fine + m * step for m in range(count)]
        written = [self.written("THERMAL", j, m, bits=bits[m] + step) for m in range(count)]
        wanted = [self.near(f"I{j}_{m}", power) for m, power in enumerate(powers)]
        return self.horner(f"s{j}", written, tau, bits), self.exact(f"S{j}", wanted, tau)

    def corrected(self, j: int, word: str, error: Fraction) -> tuple[str, str]:
        """s_j + q_j, with the error of q_j as a premise."""
        (here, wanted), q, true = self.warm[j], f"q{j}{word}", f"Q{j}{word}"
        self.premise(f"|{true}| <= {_above(largest_bend(self.ideal.curves[j]))}")
        self.premise(f"|{q} - {true}| <= {_above(error * BEND_SLACK)}")
        if self.how.fixed:
            self.premise(f"@FIX({q}, {-self.fine})")
        if not here:  # a sum with 0 is exact, and Gappa comes to no end with it
            return q, true
        total = f"{here} + {q}"
        made = self.define(f"c{j}{word}", total if self.how.fixed else self.rounded(total))
        return made, self.define(f"C{j}{word}", f"{wanted} + {true}")

    def reading(self, j: int) -> Self:
        """Set the error of a reading as goal, of codes whose reading may lie between the ends of the curve."""
        self.code(f"d{j}", *self.bounds.bends[j].window)
        here, wanted = self.thermal(j) if self.ideal.temperatures is not None else ("", "")
        slope, start = self.written("SLOPE", j, bits=self.coarse), self.written("READING", j, bits=self.fine)
        if self.how.fixed:
            read = f"{self.rounded(f'{slope} * d{j}', self.fine)} + {start}{_plus(here)}"
        else:
            read = self.rounded(f"{self.rounded(f'{slope} * d{j}')} + {start}")
            read = self.rounded(f"{read}{_plus(here)}") if here else read
        true = f"{self.near(f'A{j}', self.ideal.slope[j])} * d{j} + {self.near(f'B{j}', self.ideal.reading[j])}"
        here, wanted = self.define(f"r{j}", read), self.define(f"R{j}", f"{true}{_plus(wanted)}")
        self.goal(f"{here} - {wanted}", self.of_reading(j))
        return self

    def of_reading(self, j: int) -> Fraction:
        return self.bounds.bends[j].read * READ_SLACK

    def bend(self, j: int, side: int) -> Self | None:
        """Set the error of q_j on one side of zero as goal; nothing where the sensor never reads on that side."""
        constants, how, fine = self.constants, self.how, self.fine
        shift = int(constants["CURVE_SHIFT"]) if how.fixed else 0
        e = int(constants["CURVE_BITS"]) - (fine - shift) if how.fixed else 0
        lowest, highest = (Fraction(x.item()) / 2**fine for x in constants["CURVE_ENDS"][j])
        span = (Fraction(0), highest) if side == 0 else (lowest, Fraction(0))
        if span[0] == span[1]:
            return None
        count = constants["CURVE"].shape[2]
        self.premise(f"r in [{_dyadic(span[0])}, {_dyadic(span[1])}]")
        self.premise(f"|r - R| <= {_above(self.of_reading(j))}")
        self.premise(f"|remainder| <= {_above(self.bounds.remainders[j])}")
        near = self.define("y", self.rounded("r", fine - shift)) if how.fixed else "r"
        factors = [Fraction(x.item()) / Fraction(2) ** (fine + e * m)
                   for m, x in enumerate(constants["CURVE"][j, side], 1)]  # fmt: skip
        written = [_dyadic(x) for x in factors]
        here = self.horner("q", written, near, [fine + e * m for m in range(count)])
        exact = self.exact("Q", written, "R")
        true = self.define("Q", f"{exact} + remainder")
        self.hints.append(f"{here} - {true} -> ({here} - {exact}) - remainder;")
        self.goal(f"{here} - {true}", self.bounds.bends[j].bend * BEND_SLACK)
        return self

    # ---- axes ----

    def fixed(self, i: int) -> tuple[str, str]:
        ideal, coarse = self.ideal, self.coarse
        here = self.written("CONSTANT", i, bits=self.fine)
        wanted = self.near(f"K{i}", ideal.constant[i])
        for j in range(self.k):
            here += f" + {self.written('WEIGHT', i, j, bits=coarse)} * {self.signals[j]}"
            wanted += f" + {self.near(f'W{i}{j}', ideal.weights[i][j])} * {self.signals[j]}"
        if self.changes:
            bits = int(self.constants["MIXED_BITS"])
            own, right = self.changes[i]
            mixed = " + ".join(
                f"{self.written('MIXED', i, j, bits=bits)} * {self.changes[j][0]}" for j in range(self.k)
            )
            off = [self.near(f"E{i}{j}", ideal.inverse[i][j] - int(i == j)) for j in range(self.k)]
            parts = " + ".join(f"{one} * {self.changes[j][1]}" for j, one in enumerate(off))
            here += f" + ({own} + {self.rounded(mixed, self.fine)})"
            wanted += f" + ({right} + ({parts}))"
        return self.rounded(here, self.how.bits), wanted

    def floating(self, name: str, i: int) -> tuple[str, str]:
        ideal = self.ideal
        here, wanted = self.written("CONSTANT", i), self.near(f"K{i}", ideal.constant[i])
        pairs = []
        for j, (own, right) in enumerate(self.changes):
            pairs.append((self.written("INVERSE", i, j), own, self.near(f"N{i}{j}", ideal.inverse[i][j]), right))
        for j in [*(j for j in range(self.k) if j != i), i]:
            place = ("OWN_WEIGHT", i) if j == i else ("WEIGHT", i, j)
            near = self.near(f"W{i}{j}", ideal.weights[i][j])
            pairs.append((self.written(*place), self.signals[j], near, self.signals[j]))
        for n, (a, b, c, d) in enumerate(pairs):
            total = self.rounded(f"{here} + {self.rounded(f'{a} * {b}')}")
            if n == len(pairs) - 1:
                return total, f"{wanted} + {c} * {d}"
            here, wanted = self.define(f"x{name}_{n}", total), self.define(f"X{name}_{n}", f"{wanted} + {c} * {d}")
        raise AssertionError


def _plus(term: str) -> str:
    return f" + {term}" if term else ""


def goals(ideal: Ideal, bounds: Bounds) -> tuple[Fraction, ...]:
    """Return what Gappa has to show of each axis.

    Of a single sensor whose every code was tried that is 1.3 times the bound where Gappa can do the same; else no more
    than roundings that are free of each other allow, as Gappa takes them.
    """
    if bounds.worst is None or (ideal.bends is None and ideal.highest - ideal.lowest < SPLIT):
        return tuple(one * SLACK for one in bounds.errors)
    return tuple(max(one * SLACK, free * APART) for one, free in zip(bounds.errors, bounds.apart, strict=True))


def _above(size: Fraction) -> str:
    return _dyadic(Fraction(ceil(size * 2**FINE), 2**FINE))


def _dyadic(value: Fraction) -> str:
    """Return a number whose denominator is a power of two as Gappa reads it: ``3b-5``."""
    bits = value.denominator.bit_length() - 1
    if value.denominator != 1 << bits:
        raise ValueError(f"{value} has no finite binary form")
    return f"{value.numerator}b-{bits}" if bits else str(value.numerator)
