"""Worst error that a search meets: the truth lies between it and the proved bound."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .bound import Bounds
from .codes import Codes, random_codes
from .design import Arithmetic, Constants
from .exact import Ideal
from .truth import sizes

SEED = 1969
RANDOM, KEPT, SWEEP, ROUNDS = 4_000, 6, 200, 2
EFFORTS = (1, 5, 20)  # times as many codes, from new ones each time
NEAR = 1.2  # bound over worst found from which no more are tried


@dataclass(frozen=True, eq=False)
class Found:
    """Worst error that a search met on an axis, with its codes."""

    error: float
    codes: dict[str, list[int]]


def search(ideal: Ideal, how: Arithmetic, constants: Constants, bounds: Bounds, seed: int = SEED) -> tuple[Found, ...]:
    """Return the worst error on each axis: of all codes where these can be tried, else of a directed search.

    Random codes first; from the worst of them on, one code after the other is changed for the worse. Where the bound is
    still far, more of them are tried.
    """
    if bounds.worst is not None:
        return (_found(bounds.worst, 0, sizes(ideal, how, constants, 0, bounds.worst)),)
    rng = np.random.default_rng(seed)
    found = []
    for i, bound in enumerate(bounds.errors):
        tried: list[Found] = []
        for effort in EFFORTS:
            tried.append(_worst(ideal, how, constants, i, effort, rng))
            if bound <= NEAR * tried[-1].error:
                break
        found.append(max(tried, key=lambda one: one.error))
    return tuple(found)


def _found(codes: Codes, row: int, error: np.ndarray) -> Found:
    return Found(float(error[row]), {name: [int(x) for x in one[row]] for name, one in codes.items()})


def _worst(ideal: Ideal, how: Arithmetic, constants: Constants, i: int, effort: int, rng: np.random.Generator) -> Found:
    sweep = effort * SWEEP
    codes = random_codes(ideal, effort * RANDOM, rng)
    error = sizes(ideal, how, constants, i, codes)
    order = np.argsort(-error, kind="stable")[:KEPT]
    best, worst = {name: one[order] for name, one in codes.items()}, error[order]
    places = [(name, j) for name in codes if name in ("signal", "temperature") for j in range(len(ideal.axes))]
    for _ in range(ROUNDS):
        for name, j in places:
            fresh = random_codes(ideal, sweep, rng)
            tried = {one: np.repeat(column, sweep, axis=0) for one, column in best.items()}
            pairs = {"signal": ("reference",), "temperature": ("temperature_reference",)}[name]
            for one in (name, *(other for other in pairs if other in codes)):
                tried[one][:, j] = np.tile(fresh[one][:, j], KEPT)
            error = sizes(ideal, how, constants, i, tried).reshape(KEPT, sweep)
            at = error.argmax(axis=1)
            rows = np.arange(KEPT)
            better = error[rows, at] > worst
            for one, column in best.items():
                column[better] = tried[one].reshape(KEPT, sweep, -1)[rows, at][better]
            worst = np.where(better, error[rows, at], worst)
    return _found(best, int(worst.argmax()), worst)
