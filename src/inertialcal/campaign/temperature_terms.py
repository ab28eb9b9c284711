"""The bias over temperature in the model: what a thermal test found, and what the rate table finds left after it.

The reading on the rate table was corrected by the same polynomial, so its errors are in both with opposite signs: at
the temperature of the rate table they cancel in the sum. They are carried as the unknowns of the thermal test.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..core.estimate import Array, Component, Estimate
from ..core.key import Key
from ..procedures.rate_table import reduction as rate_table
from ..procedures.rate_table.fit.quantities import taken_off_changes
from ..procedures.thermal.correction import ThermalCorrection, law_of

BIAS = "bias"


def with_temperature(
    estimate: Estimate,
    matrix: rate_table.Result,
    bias: rate_table.Result,
    law: ThermalCorrection,
    axes: tuple[str, ...],
) -> Estimate:
    """Return the estimate of a rate table with the bias at the reference temperature, and its coefficients.

    Parameters
    ----------
    estimate : Estimate
        Of the rate table: ``bias_x`` is what is left there.
    matrix, bias : rate_table.Result
        Reductions that its matrix entries and its biases are of.
    law : ThermalCorrection
        That was taken off both.
    axes : tuple of str
        Of the model.
    """
    found = law_of(law)
    more = tuple(key for key in found if key.power and key.axis in axes)
    keys = (*estimate.keys, *more)
    at_reference = {key: value for key, (value, _) in found.items()}
    values = [v + at_reference.get(key, 0.0) for key, v in zip(estimate.keys, estimate.values, strict=True)]
    values += [at_reference[key] for key in more]
    units = (*estimate.units, *(found[key][1] for key in more))
    sources = {
        s: off for one in (matrix, bias) for line in one.lines.values() for s, off in line.readings.taken_off.items()
    }
    kept = [_wider(one, len(more)) for one in estimate.components if one.source not in sources]
    off = [_joint(source, one, keys, _changes(source, matrix, bias)) for source, one in sources.items()]
    return Estimate(keys, np.array(values), units, (*kept, *off))


def _wider(component: Component, more: int) -> Component:
    k = len(component.covariance)
    covariance = np.zeros((k + more, k + more))
    covariance[:k, :k] = component.covariance
    dof = np.full(k + more, np.inf)
    dof[:k] = component.dof
    return replace(component, covariance=covariance, dof=dof)


def _changes(source: str, matrix: rate_table.Result, bias: rate_table.Result) -> dict[Key, Array]:
    """Return what one of each unknown changes in every quantity of the rate table."""
    entries = {key: c for key, c in taken_off_changes(matrix.lines, source).items() if key.quantity != BIAS}
    return entries | {key: c for key, c in taken_off_changes(bias.lines, source).items() if key.quantity == BIAS}


def _joint(source: str, off: rate_table.TakenOff, keys: tuple[Key, ...], changes: Mapping[Key, Array]) -> Component:
    size = len(off.law)
    own = {key: off.law[:, i] for i, key in enumerate(off.keys)}
    rows = [
        (changes[key] if key in changes and len(changes[key]) else np.zeros(size)) + own.get(key, np.zeros(size))
        for key in keys
    ]
    covariance = np.array(rows) @ np.array(rows).T
    dof = np.array([off.dof["xyz".index(key.axis[0])] for key in keys])
    return Component(source, off.kind, 0.5 * (covariance + covariance.T), dof, off.distribution, off.stated)
