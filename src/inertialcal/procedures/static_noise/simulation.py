"""Records of noise whose terms are known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...sensors.noise.simulate import simulate as samples_of
from ...sensors.noise.terms import Term
from .plan import Plan
from .readings import Readings, Run


@dataclass(frozen=True)
class Truth:
    """Terms of each axis, and how they are recorded."""

    terms: Mapping[str, tuple[Term, ...]]  # Of each axis [SI]
    samples: int  # Of each record
    interval: float  # From sample to sample [s]
    averaging: float | None = None  # What each sample is the mean of [s]; the interval by default
    runs: int = 1  # Records


def simulate(plan: Plan, truth: Truth, rng: np.random.Generator) -> Readings:
    """Return records of the terms, after the warm-up of the plan.

    Parameters
    ----------
    plan : Plan
        Its ``warm_up`` is recorded before, and left out.
    truth : Truth
        The terms.
    rng : numpy.random.Generator
        All draws come from it, record by record, axis by axis.
    """
    skipped = int(np.ceil(plan.warm_up / truth.interval - 1e-9))
    scale = dict.fromkeys(truth.terms, 1.0)
    runs = []
    for number in range(truth.runs):
        drawn = {
            axis: samples_of(terms, truth.samples + skipped, truth.interval, rng, truth.averaging)[skipped:]
            for axis, terms in truth.terms.items()
        }
        runs.append(Run(drawn, {}, scale, truth.interval, truth.averaging, "rate", f"run {number + 1}", skipped))
    return Readings(tuple(runs))
