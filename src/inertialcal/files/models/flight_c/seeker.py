"""Codes that show one step of a constant, looked for on purpose.

A step of a constant of sensor j shows only where the correction s_j + q_j of that sensor is another number, and that
depends on two codes of that sensor. So all pairs of them are tried, step by step along Horner's rule and only where the
sum still differs; each pair that is left is completed with many codes of the other sensors. Where no pair is left, no
code shows the step: it makes no difference at all. For other constants all codes of a single sensor are tried; of
several sensors random ones, and in the end each sum that an entry of M^-1 is added to with each number added.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .codes import Codes, Integers, random_differences, rows, spans, with_differences
from .design import Arithmetic, Constants, Values
from .exact import Ideal
from .twin import Inside, Reduced, corrections, horner, inside, mixed_sum, outputs, reduced, run

MOST_PAIRS = 2**24  # of codes of one sensor; where there are more, as many are drawn
CHUNK = 2**17  # pairs at once
TRIES = 2**14  # codes that the pairs of one chunk are completed with
MOST_CHUNKS_TRIED = 24  # in which pairs are completed and the output stays the same; then it is given up
MOST_DRAWN = 2**20  # random codes for a constant of the sums
SIDE = 4096  # sums of the sensors before, and corrections of a sensor, each with each
OF_SENSOR = ("THERMAL", "SLOPE", "READING", "CURVE", "CURVE_ENDS")  # tables with a row a sensor
OF_SUMS = ("CONSTANT", "INVERSE", "MIXED", "WEIGHT", "OWN_WEIGHT")


@dataclass(frozen=True, eq=False)
class Step:
    """A constant one step off: its label, its table, its place there, and all constants with it."""

    label: str
    table: str
    at: tuple[int, ...]
    constants: Constants


@dataclass(frozen=True, eq=False)
class OneSide:
    """Curve of a sensor at the pairs whose readings have one sign."""

    index: Integers  # which pairs
    near: Values
    thermal: Values
    sums: list[Values]  # Horner's rule: what is reached with each power, the lowest first; zero at the end


def first_difference(found: tuple[Values, NDArray[np.uint8]], here: tuple[Values, NDArray[np.uint8]]) -> int | None:
    """Return the first row that is another one in outputs or flags."""
    other = np.any((found[0] != here[0]) | (found[1] != here[1]), axis=1)
    return int(other.argmax()) if other.any() else None


class Seeker:
    """Looks for codes; keeps those found, the steps that no code shows, and those that it came to no end with."""

    def __init__(self, ideal: Ideal, how: Arithmetic, constants: Constants, rng: np.random.Generator):
        self.ideal, self.how, self.constants, self.rng = ideal, how, constants, rng
        self.k = len(ideal.axes)
        self.signal, self.warm = spans(ideal)
        self.found: list[Codes] = []
        self.invisible: list[str] = []
        self.unnoticed: list[str] = []

    def look_for(self, steps: Sequence[Step]) -> None:
        """Look for codes of every step."""
        for j in range(self.k):
            self.sensor(j, [one for one in steps if one.table in OF_SENSOR and one.at[0] == j])
        others = [one for one in steps if one.table in OF_SUMS]
        self.unnoticed += [one.label for one in steps if one.table not in (*OF_SENSOR, *OF_SUMS)]
        if self.k == 1:
            self.sensor(0, others)
        else:
            self.axes(others)

    # ---- constants of one sensor ----

    def sensor(self, j: int, steps: list[Step]) -> None:
        """Look for steps whose effect depends on the codes of one sensor, and on the others in the sums alone."""
        left = {one.label: one for one in steps}
        tried = dict.fromkeys(left, 0)
        own = _of_sensor(self.constants, j)
        for away, warmth in self.pairs(j) if left else ():
            tau = None if warmth is None else warmth - int(self.constants["TEMPERATURE_CENTRE"][j])
            inputs = Reduced(away, tau, np.zeros_like(away))
            at = inside(own, self.how, inputs)
            sides = [self.one_side(own, at, side) for side in (0, 1)] if "CURVE" in own else []
            for label, step in list(left.items()):
                differs = self.differing(step, own, inputs, sides)
                if len(differs) == 0:
                    continue
                row = self.completed(j, step, away[differs, 0], None if warmth is None else warmth[differs, 0])
                tried[label] += 1
                if row is not None:
                    self.found.append(row)
                    del left[label]
                elif self.k > 1 and tried[label] == MOST_CHUNKS_TRIED:
                    self.unnoticed.append(label)
                    del left[label]
            if not left:
                break
        for label in left:
            proved = self.all_pairs(j) and (self.k == 1 or tried[label] == 0)
            (self.invisible if proved else self.unnoticed).append(label)

    def number_of_pairs(self, j: int) -> tuple[int, int]:
        """Differences of the signal and codes of temperature of a sensor that its correction depends on."""
        (low, high), warm = self.signal[j], None if self.warm is None else self.warm[j]
        temperatures = 1 if warm is None else int(warm[1] - warm[0]) + 1
        # without curve the signal does not matter, but for what a single sensor gives
        return int(high - low) + 1 if "CURVE" in self.constants or self.k == 1 else 1, temperatures

    def all_pairs(self, j: int) -> bool:
        """Whether each pair is tried."""
        signals, temperatures = self.number_of_pairs(j)
        return signals * temperatures <= MOST_PAIRS

    def pairs(self, j: int) -> Iterator[tuple[Integers, Integers | None]]:
        """Yield differences of the signal and codes of temperature of one sensor, shape (n, 1), in far strides."""
        signals, temperatures = self.number_of_pairs(j)
        every = signals * temperatures
        chunks = -(-min(every, MOST_PAIRS) // CHUNK)
        for chunk in range(chunks):
            index = np.arange(chunk, every, chunks)
            if not self.all_pairs(j):
                index = self.rng.integers(0, every, CHUNK)
            away = (index % signals + int(self.signal[j, 0]))[:, np.newaxis]
            if signals == 1:
                away = np.zeros_like(away)
            warmth = None if self.warm is None else (index // signals + int(self.warm[j, 0]))[:, np.newaxis]
            yield away, warmth

    def one_side(self, own: Constants, at: Inside, side: int) -> OneSide:
        """Evaluate the curve where readings have one sign."""
        index = np.flatnonzero(at.side[:, 0] == side)
        near = at.near[index, 0]
        sums = [np.zeros_like(near)]
        for m in range(own["CURVE"].shape[2] - 1, -1, -1):
            sums.append(horner(self.how, sums[-1], own["CURVE"][0, side, m], near, own.get("CURVE_BITS")))
        return OneSide(index, near, at.thermal[index, 0], sums[::-1])

    def differing(self, step: Step, own: Constants, inputs: Reduced, sides: list[OneSide]) -> Integers:
        """Rows in which the correction of the sensor is another one with a step, or its flag."""
        if step.table not in OF_SENSOR:
            return np.arange(len(inputs.away))
        changed = _of_sensor(step.constants, step.at[0])
        if step.table != "CURVE":
            here, there = (corrections(one, self.how, inputs) for one in (own, changed))
            return np.flatnonzero((here[0] != there[0])[:, 0] | (here[1] != there[1])[:, 0])
        _, side, m = step.at
        one = sides[side]
        left, near, total = np.arange(len(one.index)), one.near, one.sums[m + 1]
        for power in range(m, -1, -1):
            total = horner(self.how, total, changed["CURVE"][0, side, power], near, own.get("CURVE_BITS"))
            differs = np.flatnonzero(total != one.sums[power][left])
            left, near, total = left[differs], near[differs], total[differs]
        thermal = one.thermal[left]
        shows: Integers = one.index[left[thermal + total != thermal + one.sums[0][left]]]
        return shows

    def completed(self, j: int, step: Step, away: Integers, warmth: Integers | None) -> Codes | None:
        """Codes that show a step, from pairs of one sensor and random codes of the others; None where none does."""
        if self.k > 1:
            take = self.rng.permutation(len(away))[:TRIES]
            take = np.tile(take, -(-TRIES // len(take)))[:TRIES]
            every = random_differences(self.signal, TRIES, self.rng)
            if "CURVE" in self.constants:
                every[:, j] = away[take]
            degrees = None
            if self.warm is not None and warmth is not None:
                degrees = random_differences(self.warm, TRIES, self.rng)
                degrees[:, j] = warmth[take]
        else:
            every, degrees = away[:, np.newaxis], None if warmth is None else warmth[:, np.newaxis]
        codes = with_differences(self.ideal, every, degrees)
        row = first_difference(run(step.constants, self.how, codes), run(self.constants, self.how, codes))
        return None if row is None else rows(codes, [row])

    # ---- constants of the sums ----

    def axes(self, steps: list[Step]) -> None:
        """Look for steps of constants of the sums of several sensors among random codes."""
        left = {one.label: one for one in steps}
        for _ in range(MOST_DRAWN // CHUNK):
            if not left:
                break
            away, warmth = self.drawn(CHUNK)
            self.shown(left, away, warmth)
        for label, step in left.items():
            if step.table == "INVERSE":
                self.inverse(step)
            else:
                self.unnoticed.append(label)

    def drawn(self, n: int) -> tuple[Integers, Integers | None]:
        """Random differences of signals and codes of temperature, shape (n, k)."""
        warmth = None if self.warm is None else random_differences(self.warm, n, self.rng)
        return random_differences(self.signal, n, self.rng), warmth

    def shown(self, left: dict[str, Step], away: Integers, warmth: Integers | None) -> None:
        """Take the steps of the sums that some codes show out of a list, and keep the codes."""
        codes = with_differences(self.ideal, away, warmth)
        inputs = reduced(self.constants, codes)
        change, beyond = corrections(self.constants, self.how, inputs)
        here = outputs(self.constants, self.how, inputs, change, beyond)
        for label, step in list(left.items()):
            row = first_difference(outputs(step.constants, self.how, inputs, change, beyond), here)
            if row is not None:
                self.found.append(rows(codes, [row]))
                del left[label]

    def inverse(self, step: Step) -> None:
        """Look for a step of N_ij in floating point: it has to show in the sum up to sensor j, whatever comes after.

        That sum is tried for each pair of codes of the sensors before and codes of sensor j.
        """
        i, j = step.at
        every = "CURVE" not in self.constants and j < 2  # so few that all can be tried
        before, own = self.drawn(SIDE), self.drawn(SIDE)
        if every:
            before, own = (self.all_temperatures(one) for one in (0, j))
        sums, changes = (self.changes(*one) for one in (before, own))
        total = mixed_sum(self.constants, i, sums, j)
        here, there = (one["INVERSE"][i, j] * changes[:, j] for one in (self.constants, step.constants))
        pairs = [
            np.stack([np.full(len(found), row), found])
            for row, one in enumerate(total)
            if len(found := np.flatnonzero(one + here != one + there))
        ]
        if not pairs:
            (self.invisible if every else self.unnoticed).append(step.label)
            return
        first, second = np.hstack(pairs)
        left = {step.label: step}
        for _ in range(MOST_CHUNKS_TRIED):
            take = self.rng.integers(0, len(first), TRIES)
            away, warmth = self.drawn(TRIES)
            for to, start, source in ((away, before[0], own[0]), (warmth, before[1], own[1])):
                if to is not None and start is not None and source is not None:
                    to[:, :j], to[:, j] = start[first[take], :j], source[second[take], j]
            if "CURVE" not in self.constants:
                away = random_differences(self.signal, TRIES, self.rng)
            self.shown(left, away, warmth)
            if not left:
                return
        self.unnoticed.append(step.label)

    def all_temperatures(self, j: int) -> tuple[Integers, Integers | None]:
        """Every code of temperature of one sensor, the others at the start of their range; shape (n, k)."""
        _, count = self.number_of_pairs(j)
        if self.warm is None:
            return np.zeros((1, self.k), dtype=np.int64), None
        warmth = np.tile(self.warm[:, 0], (count, 1))
        warmth[:, j] += np.arange(count)
        return np.zeros_like(warmth), warmth

    def changes(self, away: Integers, warmth: Integers | None) -> Values:
        """Corrections of each sensor, shape (n, k)."""
        tau = None if warmth is None else warmth - self.constants["TEMPERATURE_CENTRE"]
        return corrections(self.constants, self.how, Reduced(away, tau, np.zeros_like(away)))[0]


def _of_sensor(constants: Constants, j: int) -> Constants:
    """Constants of one sensor alone, as of a unit of one."""
    return {name: one[j : j + 1] if name in OF_SENSOR else one for name, one in constants.items()}
