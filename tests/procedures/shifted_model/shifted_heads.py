"""Heads of the independent simulator as readings of the procedure."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from independent.orbit.flights import T_REF, YEAR, Head, flown
from inertialcal.core.constants import STANDARD_GRAVITY
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.influence import Influence
from inertialcal.core.key import Key
from inertialcal.procedures.shifted_model.later import predicted
from inertialcal.procedures.shifted_model.model import bias_at
from inertialcal.procedures.shifted_model.plan import Plan
from inertialcal.procedures.shifted_model.readings import Flip, Readings
from inertialcal.procedures.shifted_model.reduction import Result, reduce
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.sensor_model import Item, SensorModel
from inertialcal.statistics.intervals import coverage_factor

UG = 1e-6 * STANDARD_GRAVITY.value
BEGIN = 1_500_000_000
ZERO = Influence(0.05 * UG, "m/s^2", standard="converter", quantity="zero")
PLAN = Plan(standards={"converter.zero": ZERO})


def ground_of(head: Head, covariance: bool = True) -> SensorModel:
    """The ground model of a head of one axis."""
    keys = (Key("bias", "y"), Key("bias_temperature", "y", power=1), Key("bias_temperature", "y", power=2))
    units = ("m/s^2", "m/s^2/degC", "m/s^2/degC^2")
    part = Component("ground test", "A", head.covariance * UG**2)
    made = model_from(
        Estimate(keys, head.ground * UG, units, (part,)), "accelerometer", ("y",), reference_temperature=T_REF,
        temperature_range=(-20.0, 60.0), item=Item("maker", "head", "7"),
    )  # fmt: skip
    return made if covariance else replace(made, estimate=None)


def readings_of(head: Head, ground: SensorModel | None = None) -> Readings:
    """The flips of a head; the flight to come is the last."""
    flips = tuple(
        Flip(str(f + 1), (BEGIN + round(years * YEAR)) * 10**9, "y", float(T), float(m) * UG, float(u) * UG, math.inf)
        for f, years, T, m, u in zip(head.flight, head.years, head.temperature, head.measured, head.u, strict=True)
    )
    return Readings(flips, ground or ground_of(head))


def reduced(head: Head, plan: Plan = PLAN) -> Result:
    """What all but the last flight give."""
    return reduce(replace(plan, later=[str(head.flight.max() + 1)]), readings_of(head))


def hits(head: Head, plan: Plan = PLAN) -> dict[str, bool]:
    """Whether each stated interval holds what is true: drift, flight to come as flipped, and the bias it truly has."""
    result = reduced(head, plan)
    (one,) = predicted(result, result.later)
    found = {"prediction": one.inside}
    own = result.shifts["y"]
    if own.line is not None:
        value, u, dof = own.line
        found["drift"] = abs(value - head.drift * UG / YEAR) <= coverage_factor(dof) * u
    at, time = int(np.flatnonzero(head.flight == head.flight.max())[0]), result.later.flips[0].time
    T = float(head.temperature[at])
    value, u, dof = bias_at(result.model(time), result, "y", np.array([T]))
    k = coverage_factor(min(dof, own.fit.dof or dof))
    found["bias"] = bool(abs(value - head.true[at] * UG) <= k * math.hypot(u, own.launch(time, T)))
    return found


def counted(n: int, make: Callable[[np.random.Generator], Head] = flown, plan: Plan = PLAN) -> dict[str, int]:
    """How many of n heads hold each; seeds 1 to n."""
    total: dict[str, int] = {}
    for seed in range(1, n + 1):
        for name, hit in hits(make(np.random.default_rng(seed)), plan).items():
            total[name] = total.get(name, 0) + hit
    return total


__all__ = ["PLAN", "UG", "YEAR", "counted", "flown", "ground_of", "hits", "readings_of", "reduced"]
