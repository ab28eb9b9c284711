"""Flips of a test as estimates: each by its own, and all together.

One flip has the uncertainty of its noise (``uncertainty``). Several are pooled: the mean of them, each counted once,
with the scatter between them, which holds the noise and whatever else differs from flip to flip. It has one degree
of freedom less than there are flips. Whether they scatter more than their noise explains is tested beside.
Type B parts are the same in all flips and do not shrink.

A flip that does not separate all that the others do (a missing position) is not pooled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from ...core.estimate import Array, Component, Estimate
from ...core.remarks import Remark
from .plan import Plan, Readings
from .separation import AMBIENT, BIAS, CONTROL, TEMPERATURE, Separated, separate
from .standards import components, patterns
from .uncertainty import noise_components

FEW = 5  # flips: with fewer, the scatter between them is hardly known
RISK = 0.05


@dataclass(frozen=True, eq=False)
class Flip:
    """One flip, or all of them pooled.

    Parameters
    ----------
    label : str
        Of the flip; empty for all.
    names : tuple of str
        Of the values.
    values : ndarray, shape (p,)
        SI.
    estimate : Estimate or None
        The same with covariance; None where there is none.
    reason : str
        Why there is no uncertainty.
    separated : tuple of Separated
        What went in.
    """

    label: str
    names: tuple[str, ...]
    values: Array
    estimate: Estimate | None
    reason: str
    separated: tuple[Separated, ...]

    @property
    def reasons(self) -> dict[str, str]:
        """Why quantities are not separated."""
        return {name: why for one in self.separated for name, why in one.reasons.items() if name not in self.names}


def flips_of(plan: Plan, readings: Readings) -> tuple[Flip, ...]:
    """Return every flip with the uncertainty that its noise and the standards give.

    Raises
    ------
    DataError
        If the plan's drift cannot be told.
    """
    found = []
    for label in readings.flips:
        one = separate(plan, readings, label)
        noise, reason = noise_components(plan, readings, one)
        made = None if reason or not noise else [*noise, *components(plan, patterns(plan, readings, one))]
        found.append(_flip(label, one.names, one.values, made, reason, (one,)))
    return tuple(found)


def pooled(plan: Plan, readings: Readings, flips: Sequence[Flip]) -> Flip:
    """Return all flips together; a single one is itself."""
    most = max(len(one.names) for one in flips)
    used = [one for one in flips if len(one.names) == most and _separates(one)]
    used = used or [one for one in flips if len(one.names) == most]
    used = [one for one in used if one.names == used[0].names]
    if len(used) == 1:
        one = used[0]
        return Flip("", one.names, one.values, one.estimate, one.reason, one.separated)
    values = np.array([one.values for one in used])
    scatter = np.cov(values, rowvar=False).reshape(most, most) / len(used)
    between = Component("scatter between flips", "A", scatter, float(len(used) - 1), "t")
    separated = tuple(part for one in used for part in one.separated)
    every = [patterns(plan, readings, one) for one in separated]
    common = {name: np.mean([one[name] for one in every], axis=0) for name in every[0]}
    return _flip("", used[0].names, values.mean(axis=0), [between, *components(plan, common)], "", separated)


def _separates(one: Flip) -> bool:
    return any(name.startswith(AMBIENT) for name in one.names)


def _flip(
    label: str,
    names: tuple[str, ...],
    values: Array,
    parts: list[Component] | None,
    reason: str,
    separated: tuple[Separated, ...],
) -> Flip:
    if parts is None:
        return Flip(label, names, values, None, reason or "nothing was read", separated)
    return Flip(label, names, values, Estimate(names, values, units(names), tuple(parts)), "", separated)


def units(names: Sequence[str]) -> tuple[str, ...]:
    """Return the SI unit of each value."""
    return tuple(_unit(name) for name in names)


def _unit(name: str) -> str:
    if TEMPERATURE in name:
        return "m/s^2/degC"
    return "m/s^3" if name[:-2].endswith("_rate") else "m/s^2"


def differences(flips: Sequence[Flip]) -> list[Remark]:
    """Say how many flips there are, and of what they differ by more than their noise explains."""
    count = len(flips)
    if count < 2:
        return []
    found = []
    if count < FEW:
        what = f"{count} flips: the scatter between them has {count - 1} degrees of freedom"
        found.append(Remark("few_flips", "warning", what, do=f"Repeat until there are {FEW} flips or more"))
    for name in _shared(flips):
        told = _against_noise(name, flips)
        if told is not None and told[1] < RISK:
            what = f"{name}: chi-square {told[0]:.3g} between {count} flips, {count - 1} expected from their noise"
            do = "It changed between them: look at each flip"
            found.append(Remark("flips_differ", "warning", what, do=do))
    return found


def _shared(flips: Sequence[Flip]) -> list[str]:
    first = flips[0].names
    words = (AMBIENT, BIAS, CONTROL)
    return [name for name in first if name[:-2] in words and all(name in one.names for one in flips)]


def _against_noise(name: str, flips: Sequence[Flip]) -> tuple[float, float] | None:
    """Chi-square of a value between flips against their noise, and its probability; None where noise is unknown."""
    estimates = [one.estimate.select([name]) for one in flips if one.estimate is not None]
    if len(estimates) < len(flips):
        return None
    noise = [sum(float(c.covariance[0, 0]) for c in one.components if c.kind == "A") for one in estimates]
    dof = [min(float(np.min(c.dof)) for c in one.components if c.kind == "A") for one in estimates]
    values = np.array([float(one.values[0]) for one in estimates])
    weights = 1.0 / np.array(noise)
    square = float(np.sum(weights * (values - np.average(values, weights=weights)) ** 2))
    free = len(values) - 1
    behind = float(np.sum(dof)) if np.isfinite(dof).all() else 1e9
    return square, float(special.fdtrc(free, behind, square / free))
