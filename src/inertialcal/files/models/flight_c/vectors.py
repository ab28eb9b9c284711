"""Test vectors that notice a change of any constant: ends of all ranges, random codes, and codes found on purpose.

A constant that is one step off changes few outputs. Random codes show most steps; `Seeker` looks for codes that show
the others, and tells those that no code can show.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .codes import Codes, ends_of_ranges, joined, random_codes, rows, wild_codes
from .design import Arithmetic, Constants
from .exact import Ideal
from .seeker import Seeker, Step, first_difference
from .twin import run

SEED = 2011
DRAWN = (4_000, 20_000)  # codes to look through, before a step is looked for on purpose
PLAIN = 150  # of each kind of random codes
LIMITS = {"CURVE_ENDS", "INPUT_ENDS"}  # outputs next to these are looked for instead


@dataclass(frozen=True, eq=False)
class Chosen:
    """Codes of vectors, shape (n, k), and the steps of constants that show in none of them."""

    codes: Codes
    invisible: tuple[str, ...]  # no code shows it: it makes no difference
    unnoticed: tuple[str, ...]  # looked for, not found


def choose(ideal: Ideal, how: Arithmetic, constants: Constants, worst: Mapping[str, NDArray[np.int64]]) -> Chosen:
    """Return codes of vectors.

    Parameters
    ----------
    worst : mapping of ndarray, shape (n, k)
        Codes to have among them.
    """
    rng = np.random.default_rng(SEED)
    chosen = joined([dict(worst), ends_of_ranges(ideal, constants), wild_codes(ideal, constants, PLAIN, rng)])
    pool = random_codes(ideal, DRAWN[0], rng)
    values, _ = run(constants, how, pool)
    picked = list(range(PLAIN))
    if "INPUT_ENDS" in constants:  # outputs nearest to a limit, on both sides
        for i in range(len(ideal.axes)):
            for end in constants["INPUT_ENDS"][i]:
                away = np.asarray(values[:, i], dtype=float) - float(end)
                picked += [int(np.argmin(np.where(side * away >= 0, np.abs(away), np.inf))) for side in (-1, 1)]
    chosen = joined([chosen, rows(pool, picked)])
    left = _unseen(constants, how, chosen, list(one_step_off(constants)))
    for n in DRAWN:
        pool = random_codes(ideal, n, rng)
        noticing, left = _noticing(constants, how, pool, left)
        chosen = joined([chosen, rows(pool, noticing)])
    seeker = Seeker(ideal, how, constants, rng)
    seeker.look_for(left)
    return Chosen(joined([chosen, *seeker.found]), tuple(seeker.invisible), tuple(seeker.unnoticed))


def one_step_off(constants: Constants) -> Iterator[Step]:
    """Yield each constant that is not a limit with one entry one step up or down."""
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
                yield Step(label, name, at, {**constants, name: changed})


def _unseen(constants: Constants, how: Arithmetic, codes: Codes, steps: list[Step]) -> list[Step]:
    return _noticing(constants, how, codes, steps)[1]


def _noticing(constants: Constants, how: Arithmetic, pool: Codes, steps: list[Step]) -> tuple[list[int], list[Step]]:
    """Rows that show a step, one a step, and the steps that no row shows."""
    here = run(constants, how, pool)
    noticing, left = [], []
    for step in steps:
        row = first_difference(run(step.constants, how, pool), here)
        if row is None:
            left.append(step)
        else:
            noticing.append(row)
    return sorted(set(noticing)), left
