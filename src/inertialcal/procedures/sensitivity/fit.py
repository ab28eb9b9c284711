"""The fit of one sensor: weighted least squares with an intercept a power-up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.key import Key
from ...statistics.own_offsets import OwnOffsets, fit_own_offsets
from .design import Column, Design
from .plan import Plan
from .readings import Readings
from .stated import Stated, stated_terms


@dataclass(frozen=True, eq=False)
class SensorFit:
    """What was found about one sensor."""

    design: Design
    columns: tuple[Column, ...]  # Those that were fitted, without the stated ones
    own: OwnOffsets | None  # None where nothing could be fitted
    stated: tuple[Stated, ...]

    @property
    def keys(self) -> tuple[Key, ...]:
        """Of the terms that are published, in the order of the columns."""
        refused = self.design.refused
        return tuple(one.key for one in self.columns if one.key is not None and one.key not in refused)

    @property
    def at(self) -> list[int]:
        """Number of the coefficient of each of these terms."""
        keys = self.keys
        return [1 + i for i, one in enumerate(self.columns) if one.key in keys]

    @property
    def runs(self) -> int:
        """Power-ups that the fit has."""
        return len(np.unique(self.design.runs))

    def coefficient(self, column: Column) -> float:
        """Return the coefficient of a column, fitted."""
        assert self.own is not None  # noqa: S101 - asked for columns that were fitted
        return float(self.own.coefficients[1 + self.columns.index(column)])


def fitted(plan: Plan, readings: Readings, design: Design) -> SensorFit:
    """Return the fit of the columns of one sensor, stated terms taken off before.

    Raises
    ------
    DataError
        ``too_few_levels`` where they leave no scatter to judge by.
    """
    stated = stated_terms(plan, design)
    known = {one.key for one in stated}
    columns = tuple(one for one in design.columns if one.key not in known)
    y = design.readings - sum((one.value * one.column.values for one in stated), np.zeros(len(design.readings)))
    if not columns:
        return SensorFit(design, columns, None, stated)
    slopes = np.column_stack([one.values for one in columns])
    noise = np.square(readings.noise[design.axis][design.chosen])
    own = fit_own_offsets(slopes, y, design.runs, design.runs)
    if own is None:
        groups = len(np.unique(design.runs))
        what = f"{design.axis}: {len(y)} levels of {groups} power-ups for {len(columns)} terms and {groups} intercepts"
        do = "Record more levels, lower order, or interactions = false"
        raise DataError(what, why="no scatter is left to judge by", do=do, code="too_few_levels")
    if np.all(np.isfinite(noise)):
        beyond = max(float(own.mean_square) - float(noise.mean()), 0.0)
        variances = noise + beyond
        if variances.min() > 0.0:
            weights = variances.mean() / variances
            own = fit_own_offsets(slopes, y, design.runs, design.runs, weights) or own
    return SensorFit(design, columns, own, stated)
