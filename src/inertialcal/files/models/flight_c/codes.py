"""Raw codes of every channel: with given differences, drawn at random, at the ends of ranges, beyond the converter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from .design import Constants
from .exact import Ideal, Window
from .twin import channels

Integers = NDArray[np.int64]
Codes = dict[str, Integers]
SMALLEST = 12  # halvings, at most, of what is drawn: some things show in small numbers alone
WILD = 2**31 - 1


def rows(codes: Mapping[str, Integers], which: list[int]) -> Codes:
    """Return some rows of codes."""
    return {name: one[which] for name, one in codes.items()}


def joined(parts: list[Codes]) -> Codes:
    """Return codes one after the other."""
    return {name: np.concatenate([one[name] for one in parts]) for name in parts[0]}


def spans(ideal: Ideal) -> tuple[Integers, Integers | None]:
    """Return lowest and highest difference of signals and of temperatures, shape (k, 2)."""
    warm = None
    if ideal.temperatures is not None:
        warm = np.array([(one.lowest, one.highest) for one in ideal.temperatures], dtype=np.int64)
    return np.array(ideal.signals, dtype=np.int64), warm


def with_differences(
    ideal: Ideal, away: Integers, warmth: Integers | None, rng: np.random.Generator | None = None
) -> Codes:
    """Return codes that have given differences to their references, shape (n, k).

    Parameters
    ----------
    warmth : ndarray, optional
        Codes of temperature above their reference, shape (n, k); not tau.
    rng : numpy.random.Generator, optional
        Draws the references; the middle of what is possible if not given.
    """
    found: Codes = {}

    def pair(name: str, reference: str, values: Integers) -> None:
        least = np.maximum(ideal.lowest, ideal.lowest - values)
        most = np.minimum(ideal.highest, ideal.highest - values)
        below = (least + most) // 2 if rng is None else rng.integers(least, most + 1)
        found[name], found[reference] = values + below, below

    if ideal.has_reference:
        pair("signal", "reference", away)
    else:
        found["signal"] = away + np.array(ideal.origin, dtype=np.int64)
    if warmth is not None:
        if ideal.has_reference:
            pair("temperature", "temperature_reference", warmth)
        else:
            found["temperature"] = warmth
    if ideal.good is not None:
        found["built_in_test"] = np.full(away.shape, max(ideal.good, 0), dtype=np.int64)
    return found


def random_differences(ends: Integers, n: int, rng: np.random.Generator) -> Integers:
    """Return random differences, shape (n, k), the ends of their ranges and small ones often among them."""
    lows, highs = ends[:, 0], ends[:, 1]
    size = (n, len(ends))
    found = rng.integers(lows, highs + 1, size)
    small = (found / 2.0 ** rng.integers(0, SMALLEST, size)).astype(np.int64)
    found = np.clip(np.where(np.arange(n)[:, np.newaxis] % 2, found, small), lows, highs)
    place = rng.random(size)
    return np.where(place < 0.05, lows, np.where(place > 0.95, highs, found))


def random_codes(ideal: Ideal, n: int, rng: np.random.Generator) -> Codes:
    """Return random codes of every channel, shape (n, k): spread over differences, ends of all ranges among them."""
    signal, warm = spans(ideal)
    away = random_differences(signal, n, rng)
    return with_differences(ideal, away, None if warm is None else random_differences(warm, n, rng), rng)


def ends_of_ranges(ideal: Ideal, constants: Constants) -> Codes:
    """Return codes at the ends of each range and next to them, one channel at a time; the others in the middle."""
    k, names = len(ideal.axes), channels(constants)
    usual = _usual(ideal, names)
    listed: list[Codes] = [usual]
    for name, codes in _places(ideal, constants, usual):
        for j in range(k):
            for step in (-1, 0, 1):
                row = {one: values.copy() for one, values in usual.items()}
                row[name][j] = codes[j] + step
                listed.append(row)
    return {name: np.array([row[name] for row in listed]) for name in names}


def _usual(ideal: Ideal, names: tuple[str, ...]) -> Codes:
    """Codes of a good reading in the middle of all ranges, shape (k,)."""
    k, middle = len(ideal.axes), (ideal.lowest + ideal.highest) // 2
    usual = {name: np.full(k, middle, dtype=np.int64) for name in names}
    if ideal.temperatures is not None:
        usual["temperature"] = np.array([one.centre for one in ideal.temperatures], dtype=np.int64)
        usual["temperature"] += middle if ideal.has_reference else 0
    if ideal.good is not None:
        usual["built_in_test"][:] = ideal.good
    return usual


def _places(ideal: Ideal, constants: Constants, usual: Codes) -> Iterator[tuple[str, Integers]]:
    """Yield the ends of all ranges: which channel, and its codes there, shape (k,)."""
    k = len(ideal.axes)
    for name in usual:
        if name != "built_in_test":
            yield name, np.full(k, ideal.lowest)
            yield name, np.full(k, ideal.highest)
    for name, table in (("reference", "REFERENCE_WINDOW"), ("temperature_reference", "TEMPERATURE_WINDOW")):
        if table in constants:
            for side in (0, 1):
                yield name, constants[table][:, side].astype(np.int64)
    if "TEMPERATURE_ENDS" in constants:
        for side in (0, 1):
            ends = constants["TEMPERATURE_ENDS"][:, side].astype(np.int64)
            yield "temperature", ends + (usual["temperature_reference"] if ideal.has_reference else 0)
    if ideal.good is not None:
        yield "built_in_test", np.full(k, ideal.good)


def wild_codes(ideal: Ideal, constants: Constants, n: int, rng: np.random.Generator) -> Codes:
    """Return codes over and beyond the converter, and the extremes of 32 bits."""
    k, span = len(ideal.axes), ideal.highest - ideal.lowest
    beyond = max(2, span // 50)
    ends: Window = ideal.lowest - beyond, ideal.highest + beyond
    codes = {name: rng.integers(ends[0], ends[1] + 1, (n, k)) for name in channels(constants)}
    for row, value in enumerate((-WILD - 1, WILD)):
        for one in codes.values():
            one[row] = value
    return codes
