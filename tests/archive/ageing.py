"""Units that age, tested once a year: truth, readings, what certificates state. Nothing of the package is used.

A test reads the unit's true value in several power-ups, on a standard whose error is drawn with its certificate and
stays until the next one. Stated are the mean, u of scatter and standard together, the degrees of freedom of the
scatter, and by how much the standard's u changes the mean. What goes wrong in an archive is drawn, too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Ageing:
    """How units are made and tested."""

    years: int = 11  # tests, a year apart
    apart: float = 1.0  # in place of a year
    drift: float = 0.02  # a year
    runs: int = 6  # power-ups in a test
    scatter: float = 0.02  # between power-ups
    standard: float = 0.03  # of the standard
    certificate_years: int = 4  # that a certificate holds
    wander: float = 0.0  # of the unit from test to test, on no line: turned on and mounted anew
    curve: float = 0.0  # that it ages at first, with the logarithm of the years
    adjusted: int | None = None  # year from which it is adjusted
    by: float = 0.0  # how far the adjustment moves it
    swapped: int | None = None  # year in which another unit has its serial number
    factor: float = 1.0  # of the year's figure, where its unit of measure is another
    odd: int = 5  # that year


@dataclass(frozen=True)
class Life:
    """Tests of one unit."""

    years: Array
    values: Array
    u: Array
    dof: Array
    standard: float  # share of u that each certificate has
    certificates: list[str]
    adjusted: list[int]  # how often by then


def life(of: Ageing, rng: np.random.Generator) -> Life:
    """Draw one unit and its tests."""
    years = np.arange(of.years, dtype=float) * of.apart
    true = rng.normal() + of.drift * years + of.wander * rng.normal(size=of.years)
    blocks = np.arange(of.years) // of.certificate_years
    errors = of.standard * rng.normal(size=blocks.max() + 1)[blocks]
    true += of.curve * np.log1p(years)
    after = np.zeros(of.years, dtype=int) if of.adjusted is None else (np.arange(of.years) >= of.adjusted).astype(int)
    true += of.by * after
    if of.swapped is not None:
        true[of.swapped] = rng.normal()
    runs = true[:, None] + errors[:, None] + of.scatter * rng.normal(size=(of.years, of.runs))
    runs[of.odd % of.years] *= of.factor
    own = runs.std(axis=1, ddof=1) / np.sqrt(of.runs)
    u = np.hypot(own, of.standard)
    dof = (of.runs - 1) * (u / own) ** 4
    certificates = [f"C-{block}" for block in blocks]
    return Life(years, runs.mean(axis=1), u, dof, of.standard, certificates, after.tolist())
