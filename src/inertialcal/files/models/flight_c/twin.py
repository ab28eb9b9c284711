"""The arithmetic of flight C in Python, equal to the bit: the same steps in the same types, over many codes at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .design import Arithmetic, Constants, Values

BIT, RAIL, TEMPERATURE, REFERENCE, INPUT = 1, 2, 4, 8, 16
FLAGS = {"BIT": BIT, "RAIL": RAIL, "TEMPERATURE": TEMPERATURE, "REFERENCE": REFERENCE, "INPUT": INPUT}
Codes = Mapping[str, NDArray[np.int64]]  # channel -> shape (n, k)


@dataclass(frozen=True, eq=False)
class Reduced:
    """What is left of raw codes before any arithmetic that rounds; arrays of shape (n, k)."""

    away: NDArray[np.int64]  # d
    tau: NDArray[np.int64] | None
    flags: NDArray[np.int64]


def channels(constants: Constants) -> tuple[str, ...]:
    """Return which codes are taken, in the order of the code."""
    found = ["signal"]
    found += ["reference"] if "REFERENCE_WINDOW" in constants else []
    found += ["temperature"] if "TEMPERATURE_ENDS" in constants else []
    found += ["temperature_reference"] if "TEMPERATURE_WINDOW" in constants else []
    return (*found, "built_in_test") if "GOOD" in constants else tuple(found)


def reduced(constants: Constants, codes: Codes) -> Reduced:
    """Return differences of codes, cut to their ranges, and the flags of the codes alone."""
    lowest, highest = int(constants["LOWEST"]), int(constants["HIGHEST"])

    def taken(name: str) -> NDArray[np.int64]:
        given = codes[name]
        flags[...] |= np.where((given < lowest + 1) | (given > highest - 1), RAIL, 0)
        return np.clip(given, lowest, highest)

    def outside(values: NDArray[np.int64], ends: Values, flag: int) -> None:
        flags[...] |= np.where((values < ends[:, 0]) | (values > ends[:, 1]), flag, 0)

    flags = np.zeros(codes["signal"].shape, dtype=np.int64)
    away = taken("signal")
    if "REFERENCE_WINDOW" in constants:
        outside(codes["reference"], constants["REFERENCE_WINDOW"], REFERENCE)
        away = away - taken("reference")
    else:
        away = away - constants["ORIGIN"].astype(np.int64)
    tau = None
    if "TEMPERATURE_ENDS" in constants:
        tau = taken("temperature")
        if "TEMPERATURE_WINDOW" in constants:
            outside(codes["temperature_reference"], constants["TEMPERATURE_WINDOW"], REFERENCE)
            tau = tau - taken("temperature_reference")
        ends = constants["TEMPERATURE_ENDS"]
        outside(tau, ends, TEMPERATURE)
        tau = np.clip(tau, ends[:, 0], ends[:, 1]).astype(np.int64) - constants["TEMPERATURE_CENTRE"].astype(np.int64)
    if "GOOD" in constants:
        flags |= np.where(codes["built_in_test"] < int(constants["GOOD"]), BIT, 0)
    return Reduced(away.astype(np.int64), tau, flags)


def rounded(value: NDArray[np.int64], bits: int) -> NDArray[np.int64]:
    """Return value / 2^bits, halves away from zero."""
    size = (np.abs(value) + (1 << (bits - 1))) >> bits
    return np.asarray(np.where(value < 0, -size, size))


def horner(how: Arithmetic, total: Values, factor: Values, variable: Values, bits: Values | None) -> Values:
    """Return one step of Horner's rule, (total + factor) * variable, rounded by bits in fixed point."""
    product = (total + factor) * variable
    return rounded(product, int(bits)) if how.fixed and bits is not None else product


def thermal(constants: Constants, how: Arithmetic, tau: NDArray[np.int64]) -> Values:
    """Return s at codes of temperature, shape (n, k)."""
    powers, near = constants["THERMAL"], tau.astype(how.dtype)
    change = np.zeros_like(near)
    for m in range(powers.shape[1] - 1, -1, -1):
        change = horner(how, change, powers[:, m], near, constants.get("THERMAL_BITS"))
    return change


@dataclass(frozen=True, eq=False)
class Inside:
    """Where a curve is evaluated; arrays of shape (n, k)."""

    thermal: Values  # s
    near: Values  # reading, cut to the ends of the curve; in fixed point with the bits that are raised to powers
    side: NDArray[np.int64]  # 1 where it is negative
    beyond: NDArray[np.int64]  # flag of readings that were cut


def inside(constants: Constants, how: Arithmetic, inputs: Reduced) -> Inside:
    """Return the readings at which curves are evaluated; zeros where there is none."""
    away, total = inputs.away, np.zeros(inputs.away.shape, dtype=how.dtype)
    if inputs.tau is not None:
        total = thermal(constants, how, inputs.tau)
    if "CURVE" not in constants:
        none = np.zeros(away.shape, dtype=np.int64)
        return Inside(total, np.zeros_like(total), none, none)
    ends = constants["CURVE_ENDS"]
    if how.fixed:
        read = rounded(constants["SLOPE"] * away, int(constants["SLOPE_BITS"])) + constants["READING"] + total
    else:
        read = constants["SLOPE"] * away.astype(how.dtype)
        read = read + constants["READING"]
        read = read + total
    beyond = np.where((read < ends[:, 0]) | (read > ends[:, 1]), INPUT, 0)
    read = np.clip(read, ends[:, 0], ends[:, 1])
    near = rounded(read, int(constants["CURVE_SHIFT"])) if how.fixed else read
    return Inside(total, near, np.where(read < 0, 1, 0), beyond)


def corrections(constants: Constants, how: Arithmetic, inputs: Reduced) -> tuple[Values, NDArray[np.int64]]:
    """Return s + q, shape (n, k), and the flag of readings beyond the curve."""
    at = inside(constants, how, inputs)
    if "CURVE" not in constants:
        return at.thermal, at.beyond
    curve = constants["CURVE"]
    own = curve[np.arange(curve.shape[0]), at.side]  # (n, k, m)
    bend = np.zeros_like(at.near)
    for m in range(curve.shape[2] - 1, -1, -1):
        bend = horner(how, bend, own[:, :, m], at.near, constants.get("CURVE_BITS"))
    return at.thermal + bend, at.beyond


def run(constants: Constants, how: Arithmetic, codes: Codes) -> tuple[Values, NDArray[np.uint8]]:
    """Return outputs and flags, shape (n, k), as the C of these constants gives them.

    Parameters
    ----------
    codes : mapping of ndarray, shape (n, k)
        Raw codes of each channel, any 32-bit number.
    """
    inputs = reduced(constants, codes)
    change, beyond = corrections(constants, how, inputs)
    return outputs(constants, how, inputs, change, beyond)


def mixed_sum(constants: Constants, i: int, change: Values, count: int) -> Values:
    """Return C_i and the corrections of the first sensors in axis i, summed as the floating code does, shape (n,)."""
    total: Values = np.full(len(change), constants["CONSTANT"][i], dtype=change.dtype)
    for j in range(count):
        total = total + constants["INVERSE"][i, j] * change[:, j]
    return total


def outputs(
    constants: Constants, how: Arithmetic, inputs: Reduced, change: Values, beyond: NDArray[np.int64]
) -> tuple[Values, NDArray[np.uint8]]:
    """Return outputs and flags, from what `corrections` gives."""
    changed = "THERMAL" in constants or "CURVE" in constants
    flags = inputs.flags | beyond
    k = inputs.away.shape[1]
    columns = []
    if how.fixed:
        for i in range(k):
            own = np.full(len(flags), constants["CONSTANT"][i])
            if changed:
                mixed = sum(constants["MIXED"][i, j] * change[:, j] for j in range(k))
                own = own + change[:, i] + rounded(np.asarray(mixed), int(constants["MIXED_BITS"]))
            total = own * constants["SIGNAL_SCALE"]
            total = total + sum(constants["WEIGHT"][i, j] * inputs.away[:, j] for j in range(k))
            columns.append(rounded(np.asarray(total), int(constants["OUTPUT_BITS"])).astype(np.int32))
    else:
        away = inputs.away.astype(how.dtype)
        for i in range(k):
            total = mixed_sum(constants, i, change, k if changed else 0)
            for j in range(k):
                total = total + constants["WEIGHT"][i, j] * away[:, j]
            columns.append(constants["OWN_WEIGHT"][i] * away[:, i] + total)
    values = np.column_stack(columns)
    if "INPUT_ENDS" in constants:
        ends = constants["INPUT_ENDS"]
        flags = flags | np.where((values < ends[:, 0]) | (values > ends[:, 1]), INPUT, 0)
    return values, flags.astype(np.uint8)
