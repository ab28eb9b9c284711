"""The bias over temperature in the model: what a thermal test found, and what the rate table finds left after it.

The reading on the rate table was corrected by the same polynomial, so its errors are in both with opposite signs: at
the temperature of the rate table they cancel in the sum. They are carried as the unknowns of the thermal test.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..core.estimate import Array, Component, Estimate
from ..procedures.rate_table import reduction as rate_table
from ..procedures.rate_table.quantities import taken_off_changes
from ..procedures.thermal.correction import ThermalCorrection, law_of

BIAS = "bias_"


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
    more = tuple(name for name in found if name.startswith("bias_temperature_") and name[-1] in axes)
    names = (*estimate.names, *more)
    values = [value + found[name][0] if name in found else value for name, value in zip(estimate.names, estimate.values,
              strict=True)] + [found[name][0] for name in more]  # fmt: skip
    units = (*estimate.units, *(found[name][1] for name in more))
    sources = {
        s: off for one in (matrix, bias) for line in one.lines.values() for s, off in line.readings.taken_off.items()
    }
    kept = [_wider(one, len(more)) for one in estimate.components if one.source not in sources]
    off = [_joint(source, one, names, _changes(source, matrix, bias)) for source, one in sources.items()]
    return Estimate(names, np.array(values), units, (*kept, *off))


def _wider(component: Component, more: int) -> Component:
    k = len(component.covariance)
    covariance = np.zeros((k + more, k + more))
    covariance[:k, :k] = component.covariance
    dof = np.full(k + more, np.inf)
    dof[:k] = component.dof
    return replace(component, covariance=covariance, dof=dof)


def _changes(source: str, matrix: rate_table.Result, bias: rate_table.Result) -> dict[str, Array]:
    """Return what one of each unknown changes in every quantity of the rate table."""
    entries = {n: c for n, c in taken_off_changes(matrix.lines, source).items() if not n.startswith(BIAS)}
    return entries | {n: c for n, c in taken_off_changes(bias.lines, source).items() if n.startswith(BIAS)}


def _joint(source: str, off: rate_table.TakenOff, names: tuple[str, ...], changes: Mapping[str, Array]) -> Component:
    size = len(off.law)
    own = {name: off.law[:, at] for at, name in enumerate(off.names)}
    rows = [
        (changes[name] if name in changes and len(changes[name]) else np.zeros(size)) + own.get(name, np.zeros(size))
        for name in names
    ]
    covariance = np.array(rows) @ np.array(rows).T
    dof = np.array([off.dof["xyz".index(name.rpartition("_")[2][0])] for name in names])
    return Component(source, off.kind, 0.5 * (covariance + covariance.T), dof, off.distribution, off.stated)
