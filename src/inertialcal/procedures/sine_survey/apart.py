"""Sweeps of one response, fitted apart and together: an item that changed between two sweeps has no modes of both.

Each sweep gives its modes alone. A mode differs between two sweeps where its frequency, Q or transmissibility does by
more than chance (`FALSE_ALARM` for all of them) and `MATERIAL`. A mode that one sweep alone has is none that the other
missed where the other's own lines say so: near it, the modes of the one leave more of the other than its own do, by
more than any noise.

Where nothing differs all sweeps are fitted together. Where something does, a figure of a mode that all sweeps have is
their mean; its uncertainty is the scatter between the sweeps where it differs, with a degree of freedom for each sweep
but one, and that of the fits where it does not. A mode that some sweep has not got is not estimated; each sweep's
own figures stand beside.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...statistics.intervals import coverage_factor
from .match import matched
from .modal import BETTER, Band, Modes, find_modes

FALSE_ALARM = 1e-3  # of a difference between sweeps of an item that did not change
MATERIAL = 1e-3  # relative difference that is told
NEAREST = 0.01  # of a frequency, over which lines tell of a mode, at least
WIDTHS = 2.0  # half-power widths on each side, over which they do
REJECTED = 2.0 * BETTER  # chi-square by which the modes of another sweep are refused


@dataclass(frozen=True, eq=False)
class Sweeps:
    """Modes of one response by all its sweeps."""

    modes: Modes  # That all sweeps have
    drawn: Modes  # A model of the whole band: of all sweeps; of the first one where they differ
    each: tuple[Modes, ...]  # By each sweep alone; empty where there is one sweep
    differing: NDArray[np.bool_]  # shape (k, 3): frequency, Q, transmissibility that differ between sweeps
    single: tuple[tuple[float, int], ...]  # Modes that not all sweeps have: frequency [Hz], a sweep that has it

    @property
    def differ(self) -> bool:
        """Whether the item was another one in some sweep."""
        return bool(self.differing.any()) or bool(self.single)


def modes_of_sweeps(bands: Sequence[Band], most: int, least: float) -> Sweeps:
    """Return the modes of a response by its sweeps, apart and together.

    Parameters
    ----------
    bands : sequence of Band
        A sweep each.
    most : int
        Modes that are looked for.
    least : float
        Part of a mode in the transmissibility at its frequency, below which it is no mode of its own.
    """
    each = tuple(find_modes([one], most, least) for one in bands) if len(bands) > 1 else ()
    changed, refused = _differences(bands, each)
    if not changed and not refused:
        modes = find_modes(bands, most, least)
        return Sweeps(modes, modes, each, np.zeros((len(modes), 3), dtype=bool), ())
    rows = _common(each)
    differing = np.array([[any((i, k, n) in changed for i, k in enumerate(row)) for n in range(3)] for row in rows],
                         dtype=bool).reshape(-1, 3)  # fmt: skip
    own = {(i, k) for row in rows for i, k in enumerate(row)}
    alone = [(float(f), i) for i, one in enumerate(each) for k, f in enumerate(one.frequency) if (i, k) not in own]
    return Sweeps(_mean(each, rows, differing), each[0], each, differing, tuple(sorted(alone)))


def _differences(
    bands: Sequence[Band], each: Sequence[Modes]
) -> tuple[set[tuple[int, int, int]], set[tuple[int, int]]]:
    """Return figures (sweep, mode, which) that differ from another sweep, and modes that another sweep refuses."""
    changed, refused = set[tuple[int, int, int]](), set[tuple[int, int]]()
    tests = 3 * max((len(one) for one in each), default=1) * math.comb(len(each), 2)
    chance = 1.0 - FALSE_ALARM / max(tests, 1)
    for i, j in combinations(range(len(each)), 2):
        pairs, _ = matched(each[j].frequency, each[i].frequency)
        for b, a in pairs:
            for n in range(3):
                if _apart(each[i], each[j], 3 * a + n, 3 * b + n, chance):
                    changed |= {(i, a, n), (j, b, n)}
        paired = {(i, a) for _, a in pairs} | {(j, b) for b, _ in pairs}
        for one, other in ((i, j), (j, i)):
            for k in range(len(each[one])):
                if (one, k) not in paired and _refused(bands[other], each[other], each[one], k):
                    refused.add((one, k))
    return changed, refused


def _figures(modes: Modes) -> Array:
    return np.column_stack([modes.frequency, modes.amplification, modes.peak]).ravel()


def _apart(one: Modes, other: Modes, a: int, b: int, chance: float) -> bool:
    own, its = float(_figures(one)[a]), float(_figures(other)[b])
    u = math.sqrt(one.covariance[a, a] + other.covariance[b, b])
    factor = coverage_factor(float(min(one.dof[a], other.dof[b])), chance)
    return u > 0.0 and abs(its - own) > max(factor * u, MATERIAL * abs(own))


def _refused(band: Band, own: Modes, other: Modes, k: int) -> bool:
    """Whether the lines of a sweep near a mode of another one refuse that mode."""
    f = float(other.frequency[k])
    half = f * max(WIDTHS / float(other.amplification[k]), NEAREST)
    near = np.abs(band.frequency - f) < half
    if not band.frequency[0] < f - 0.25 * half < f + 0.25 * half < band.frequency[-1] or np.count_nonzero(near) < 8:
        return False
    lines, u, y = band.frequency[near], band.control[near], band.response[near]
    left, foreign = (np.abs(y - one.transmissibility(lines) * u) ** 2 for one in (own, other))
    return float(2.0 * np.sum(foreign - left)) > REJECTED * float(np.mean(left))


def _common(each: Sequence[Modes]) -> list[list[int]]:
    """Return the places of each mode that all sweeps have, in each."""
    partners = [{a: b for b, a in matched(one.frequency, each[0].frequency)[0]} for one in each[1:]]
    return [[k, *(one[k] for one in partners)] for k in range(len(each[0])) if all(k in one for one in partners)]


def _mean(each: Sequence[Modes], rows: Sequence[Sequence[int]], differing: NDArray[np.bool_]) -> Modes:
    n, k = len(each), len(rows)
    values, covariance, dof = np.zeros((k, 3)), np.zeros((3 * k, 3 * k)), np.zeros(3 * k)
    for m, row in enumerate(rows):
        places = [slice(3 * at, 3 * at + 3) for at in row]
        figures = np.array([_figures(one)[at] for one, at in zip(each, places, strict=True)])
        own = slice(3 * m, 3 * m + 3)
        block = np.array([one.covariance[at, at] for one, at in zip(each, places, strict=True)])
        values[m] = figures.mean(axis=0)
        parts = np.array([np.diag(one) for one in block])
        free = np.array([one.dof[at] for one, at in zip(each, places, strict=True)])
        dof[own] = parts.sum(axis=0) ** 2 / np.sum(parts**2 / free, axis=0)  # Welch and Satterthwaite
        joint, apart = block.sum(axis=0) / n**2, figures - values[m]
        differ = differing[m]
        joint[differ], joint[:, differ] = 0.0, 0.0
        joint[np.ix_(differ, differ)] = (apart.T @ apart / (n * (n - 1)))[np.ix_(differ, differ)]
        covariance[own, own], dof[own] = joint, np.where(differ, n - 1.0, dof[own])
    return replace(
        each[0], frequency=values[:, 0], amplification=values[:, 1], peak=values[:, 2], covariance=covariance, dof=dof,
        own=np.array([each[0].own[row[0]] for row in rows]), residues=np.zeros((k, 2)),
        explained=min(one.explained for one in each),
    )  # fmt: skip
