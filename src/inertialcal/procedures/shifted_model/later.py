"""Flights that are predicted: what the new model and the ground model say of them, and what their flips measured."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...core.estimate import joined_dof
from ...statistics.intervals import coverage_factor
from .model import bias_at
from .readings import Readings, ground_bias

if TYPE_CHECKING:
    from .reduction import Result


@dataclass(frozen=True)
class Predicted:
    """One axis of one later flight, SI."""

    flight: str
    axis: str
    time: int  # [ns]
    temperature: float  # Mean of its flips [degC]
    measured: float  # Mean of its flips
    ground: float  # Ground model there
    predicted: float  # New model there
    u: float  # Of measured less predicted; NaN where launches are not known
    dof: float
    u_flips: float  # Of measured
    launch: float  # Uncertainty that its launch adds

    @property
    def error(self) -> float:
        """Measured less predicted."""
        return self.measured - self.predicted

    @property
    def inside(self) -> bool:
        """Whether the prediction holds what was measured, at 95 %."""
        return abs(self.error) <= coverage_factor(self.dof) * self.u


def predicted(result: Result, later: Readings, at_date: bool = True) -> Iterator[Predicted]:
    """Yield the flights of later readings, axis by axis, as the model for their date predicts them.

    Parameters
    ----------
    at_date : bool
        Whether the model is made for the date of each flight, else for the date that the plan says.
    """
    for flight in later.flights:
        for axis in later.axes:
            flips = [one for one in later.flips if one.flight == flight and one.axis == axis]
            shift = result.shifts.get(axis)
            if not flips or shift is None:
                continue
            time = flips[len(flips) // 2].time
            model = result.model(time if at_date else None)
            weights = np.array([1.0 / one.u**2 for one in flips])
            weights /= weights.sum()
            temperatures = np.array([one.temperature for one in flips])
            u_flips = float(np.sqrt(np.sum((weights * np.array([one.u for one in flips])) ** 2)))
            _, u, dof = bias_at(model, result, axis, temperatures)
            every = (ground_bias(one, temperatures, result.plan.bias_of)[:, one.axes.index(axis)]
                     for one in (result.readings.ground, model))  # fmt: skip
            ground, new = (float(weights @ one) for one in every)
            launch = shift.launch(time, float(weights @ temperatures))
            free = joined_dof(
                [np.array([u**2 + launch**2]), np.array([u_flips**2])], [min(dof, shift.fit.dof or dof), np.inf]
            )
            total = math.sqrt(u**2 + launch**2 + u_flips**2) if shift.fit.dof else math.nan
            measured = float(weights @ np.array([one.bias for one in flips]))
            yield Predicted(flight, axis, time, float(weights @ temperatures), measured, ground, new, total,
                            float(free[0]), u_flips, launch)  # fmt: skip
