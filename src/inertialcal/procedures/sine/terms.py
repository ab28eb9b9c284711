"""What a test of a known drive gives to the model of a sensor: scale factors, where a schedule says what was applied.

Of each axis that responds: the mean over its recordings, weighted by their noise. What a correction takes off does not
follow the drive, but for its law over temperature: what is not known of a constant changes no amplitude.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...core.estimate import Component, Estimate
from ...core.key import AXES, Key, Origin
from ...sensors.model.sensor_model import Provenance
from ..model_terms import ModelTerms
from ..protocol import Tested

if TYPE_CHECKING:
    from .plan import Plan
    from .reduction import Readings, Result, SineResult

SCATTER = Origin("noise at the drive", level="sample")


def model_terms(result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
    """Return the scale factors relative to those that readings in SI were made with; None where there is none."""
    by_axis: dict[str, list[SineResult]] = {}
    for one in result.lines:
        if one.scale_factor is not None and one.driven.unit == "m/s^2" and one.driven.channel.axis in AXES:
            by_axis.setdefault(one.driven.channel.axis, []).append(one)
    if not by_axis:
        return None
    keys = tuple(Key("scale_factor_error", axis) for axis in by_axis)
    names = dict.fromkeys(one.driven.name for lines in by_axis.values() for one in lines)
    values, scatter, dof = np.zeros(len(keys)), np.zeros(len(keys)), np.zeros(len(keys))
    applied = np.zeros((len(names), len(keys)))
    for k, lines in enumerate(by_axis.values()):
        found = np.array([one.scale_factor for one in lines])  # value, u by noise, u by what is applied, dof
        weight = found[:, 1] ** -2.0 / np.sum(found[:, 1] ** -2.0)
        values[k] = weight @ found[:, 0] - 1.0
        own = (weight * found[:, 1]) ** 2
        scatter[k], dof[k] = own.sum(), own.sum() ** 2 / np.sum(own**2 / found[:, 3])
        for one, share, each in zip(lines, weight, found, strict=True):
            applied[list(names).index(one.driven.name), k] += share * each[2]
    components = [Component(SCATTER, "A", np.diag(scatter), dof, "t")]
    for name, changes in zip(names, applied, strict=True):
        if np.any(changes):
            origin = Origin(f"acceleration applied, {name}")
            components.append(Component(origin, "B", np.outer(changes, changes), changes=changes[None]))
    ranges = [max(abs(one.driven.applied or 0.0) for one in lines) for lines in by_axis.values()]
    provenance = Provenance(", ".join(one.id for one in tests), tuple(names))
    return ModelTerms(
        Estimate(keys, values, ("1",) * len(keys), tuple(components)),
        keys,
        tuple(by_axis),
        dict.fromkeys(keys, provenance),
        input_range=np.array([(-most, most) for most in ranges]),
    )
