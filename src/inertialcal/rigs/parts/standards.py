"""Errors of standards, drawn as their certificates say."""

from __future__ import annotations

import numpy as np

from ...core.influence import Influence


def drawn_error(influence: Influence | None, rng: np.random.Generator) -> float:
    """Return the unknown error of a standard, drawn as its certificate says [its unit]; 0 where there is none."""
    if influence is None:
        return 0.0
    if influence.distribution == "rectangular":
        half = influence.u * np.sqrt(3.0)
        return float(rng.uniform(-half, half))
    return float(rng.normal(0.0, influence.u))
