"""Test vectors that notice a change of any constant: ends of all ranges, random codes, and codes found on purpose.

A constant that is one step off changes few outputs, so codes are drawn until one of them shows it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .bound import random_codes
from .design import Arithmetic, Constants
from .exact import Ideal
from .twin import channels, run

SEED = 2011
DRAWN = (4_000, 20_000, 80_000)  # codes to look through, for a constant that fewer do not show
FEW = 12  # steps for which the most are drawn; more than these belong to coefficients too small to show
PLAIN = 150  # of each kind of random codes
LIMITS = {"CURVE_ENDS", "INPUT_ENDS"}  # outputs next to these are looked for instead
WILD = 2**31 - 1

Codes = dict[str, NDArray[np.int64]]


@dataclass(frozen=True, eq=False)
class Chosen:
    """Codes of vectors, shape (n, k), and constants of which a step shows in none of them."""

    codes: Codes
    unnoticed: tuple[str, ...]


def choose(ideal: Ideal, how: Arithmetic, constants: Constants, worst: Mapping[str, NDArray[np.int64]]) -> Chosen:
    """Return codes of vectors.

    Parameters
    ----------
    worst : mapping of ndarray, shape (n, k)
        Codes to have among them.
    """
    rng = np.random.default_rng(SEED)
    chosen = _joined([dict(worst), _ends(ideal, constants), _wild(ideal, constants, rng)])
    pool = random_codes(ideal, constants, DRAWN[0], rng)
    values, _ = run(constants, how, pool)
    picked = list(range(PLAIN))
    if "INPUT_ENDS" in constants:  # outputs nearest to a limit, on both sides
        for i in range(len(ideal.axes)):
            for end in constants["INPUT_ENDS"][i]:
                away = np.asarray(values[:, i], dtype=float) - float(end)
                picked += [int(np.argmin(np.where(side * away >= 0, np.abs(away), np.inf))) for side in (-1, 1)]
    chosen = _joined([chosen, _rows(pool, picked)])
    left = _unseen(constants, how, chosen, list(one_step_off(constants)))
    for n in DRAWN:
        if not left or (n == DRAWN[-1] and len(left) > FEW):
            break
        pool = random_codes(ideal, constants, n, rng)
        rows, left = _noticing(constants, how, pool, left)
        chosen = _joined([chosen, _rows(pool, rows)])
    return Chosen(chosen, tuple(name for name, _ in left))


def one_step_off(constants: Constants) -> Iterator[tuple[str, Constants]]:
    """Yield each constant that is not a limit with one entry one step up or down, and which."""
    for name, values in constants.items():
        if name in LIMITS:
            continue
        for at in np.ndindex(values.shape):
            for side in (-1, 1):
                entry = values[at]
                if values.dtype.kind == "f" and entry == 0.0:
                    continue  # an absent term; its next neighbour is no change that shows
                changed = values.copy()
                changed[at] = np.nextafter(entry, side * np.inf) if values.dtype.kind == "f" else entry + side
                label = name + "".join(f"[{i}]" for i in at) + (" + 1" if side > 0 else " - 1")
                yield label, {**constants, name: changed}


def _unseen(
    constants: Constants, how: Arithmetic, codes: Codes, changes: list[tuple[str, Constants]]
) -> list[tuple[str, Constants]]:
    values, flags = run(constants, how, codes)
    return [one for one in changes if _first(run(one[1], how, codes), values, flags) is None]


def _noticing(
    constants: Constants, how: Arithmetic, pool: Codes, changes: list[tuple[str, Constants]]
) -> tuple[list[int], list[tuple[str, Constants]]]:
    values, flags = run(constants, how, pool)
    rows, left = [], []
    for one in changes:
        row = _first(run(one[1], how, pool), values, flags)
        if row is None:
            left.append(one)
        else:
            rows.append(row)
    return sorted(set(rows)), left


def _first(found: tuple[NDArray[np.generic], NDArray[np.uint8]], values: NDArray[np.generic],
           flags: NDArray[np.uint8]) -> int | None:  # fmt: skip
    """First row that is another one."""
    other = np.any((found[0] != values) | (found[1] != flags), axis=1)
    return int(other.argmax()) if other.any() else None


def _rows(codes: Codes, rows: list[int]) -> Codes:
    return {name: one[rows] for name, one in codes.items()}


def _joined(parts: list[Codes]) -> Codes:
    return {name: np.concatenate([one[name] for one in parts]) for name in parts[0]}


def _ends(ideal: Ideal, constants: Constants) -> Codes:
    """Codes at the ends of each range and next to them, one channel at a time; the others in the middle."""
    k, names = len(ideal.axes), channels(constants)
    usual = _usual(ideal, names)
    rows: list[dict[str, NDArray[np.int64]]] = [usual]

    def put(name: str, codes: NDArray[np.int64]) -> None:
        for j in range(k):
            for step in (-1, 0, 1):
                row = {one: values.copy() for one, values in usual.items()}
                row[name][j] = codes[j] + step
                rows.append(row)

    for name, codes in _places(ideal, constants, usual):
        put(name, codes)
    return {name: np.array([row[name] for row in rows]) for name in names}


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


def _places(ideal: Ideal, constants: Constants, usual: Codes) -> Iterator[tuple[str, NDArray[np.int64]]]:
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


def _wild(ideal: Ideal, constants: Constants, rng: np.random.Generator) -> Codes:
    """Codes over and beyond the converter, and the extremes of 32 bits."""
    k, span = len(ideal.axes), ideal.highest - ideal.lowest
    beyond = max(2, span // 50)
    low, high = ideal.lowest - beyond, ideal.highest + beyond
    codes = {name: rng.integers(low, high + 1, (PLAIN, k)) for name in channels(constants)}
    for row, value in enumerate((-WILD - 1, WILD)):
        for one in codes.values():
            one[row] = value
    return codes
