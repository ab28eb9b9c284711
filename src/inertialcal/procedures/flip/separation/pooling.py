"""Flips of a test as estimates: each alone, and all pooled.

One flip has the uncertainty of its noise (``uncertainty``). Several are pooled: their mean, each counted once, with the
scatter between them, which holds the noise and anything else that differs from flip to flip; it has one degree of
freedom less than there are flips. A test says whether they scatter more than their noise explains.
Type B parts are the same in all flips and do not shrink.

Flips in one record share noise that is slower than the time between them: it does not scatter, and their mean is as far
off the bias of the record as each is. With C_i the covariance of the noise of flip i and C that of the mean of m flips,
their scatter over m is expected to be ``(sum C_i - m C) / (m (m - 1))``; the excess of C is added.

A flip that separates less than the others (a missing position) is not pooled, and a remark names it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import special

from ....core.estimate import Array, Component, Estimate, joined_dof
from ....core.key import AXES, Key, Origin, Reason
from ....core.remarks import Remark
from ....statistics.decision import holm
from ...corrections import components as after_corrections
from ..plan import Plan
from ..readings import Readings
from .equations import AMBIENT, BIAS, CONTROL, RATES, WARM, Separated, separate
from .uncertainty import components, next_record, noise_components, patterns, record_of

FEW = 5  # flips: with fewer, the scatter between them is hardly known
RISK = 0.05
ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Flip:
    """One flip, or all of them pooled.

    Parameters
    ----------
    label : str
        Of the flip; empty for all.
    keys : tuple of Key
        Of the values.
    values : ndarray, shape (p,)
        SI.
    estimate : Estimate or None
        The same with covariance; None where there is none.
    reason : Reason
        Why there is no uncertainty.
    separated : tuple of Separated
        The flips that went in.
    next_record : mapping of Key to tuple of float
        Uncertainty of each bias as that of the next record, and its degrees of freedom.
    """

    label: str
    keys: tuple[Key, ...]
    values: Array
    estimate: Estimate | None
    reason: Reason
    separated: tuple[Separated, ...]
    next_record: Mapping[Key, tuple[float, float]] = field(default_factory=dict[Key, tuple[float, float]])

    @classmethod
    def of(
        cls,
        label: str,
        values: Array,
        parts: list[Component],
        separated: tuple[Separated, ...],
        onward: Mapping[Key, tuple[float, float]],
    ) -> Flip:
        """Return the values of separated flips with the components of their uncertainty.

        ``onward``: u and degrees of freedom of the noise of each bias as that of the next record.
        """
        keys = separated[0].keys
        estimate = Estimate(keys, values, units(keys), tuple(parts))
        later = {}
        for key, (u, dof) in onward.items():
            others = [one for one in estimate.select([key]).components if not _is_noise(one)]
            squares = [np.array([u**2]), *(np.diagonal(one.covariance) for one in others)]
            known = joined_dof(squares, [dof, *(one.dof for one in others)])
            later[key] = (float(np.sqrt(np.sum(squares))), float(known[0]))
        return cls(label, keys, values, estimate, Reason(), separated, later)

    @property
    def names(self) -> tuple[str, ...]:
        """Keys as text."""
        return tuple(map(str, self.keys))

    @property
    def reasons(self) -> dict[Key, Reason]:
        """Why quantities are not separated."""
        return {key: why for one in self.separated for key, why in one.reasons.items() if key not in self.keys}


def flips_of(plan: Plan, readings: Readings) -> tuple[Flip, ...]:
    """Return every flip with the uncertainty of its noise and of the standards.

    Raises
    ------
    DataError
        If the dwells do not determine the plan's drift.
    """
    flips = []
    for label in readings.flips:
        one = separate(plan, readings, label)
        noise, reason = noise_components(plan, readings, one)
        if noise and not reason:
            parts = [*noise, *components(plan, patterns(plan, readings, one), one)]
            parts += after_corrections(readings.taken_off, one.keys, gain_of(one))
            flips.append(Flip.of(label, one.values, parts, (one,), next_record(plan, readings, one)))
        else:
            why = reason or Reason("not_read", "nothing was read")
            flips.append(Flip(label, one.keys, one.values, None, why, (one,)))
    return tuple(flips)


def pooled(plan: Plan, readings: Readings, flips: Sequence[Flip]) -> Flip:
    """Return all flips together; a single one is itself."""
    used = _used(flips)
    if len(used) == 1:
        return replace(used[0], label="")
    values = np.array([one.values for one in used])
    scatter = np.atleast_2d(np.cov(values, rowvar=False)) / len(used)
    between = Component(Origin("scatter between flips", level="flip"), "A", scatter, float(len(used) - 1), "t")
    separated = tuple(part for one in used for part in one.separated)
    every = [patterns(plan, readings, one) for one in separated]
    common = {name: np.mean([one[name] for one in every], axis=0) for name in every[0]}
    parts = [between, *_in_common(plan, readings, used), *components(plan, common, separated[0])]
    gain = np.mean([gain_of(one) for one in separated], axis=0)
    parts += after_corrections(readings.taken_off, separated[0].keys, gain)
    return Flip.of("", values.mean(axis=0), parts, separated, _onward(plan, readings, used))


def gain_of(one: Separated) -> Array:
    """Return the values of a flip per mean reading of x, y and z in each dwell, shape (p, n, 3)."""
    size = next(iter(one.weights.values())).shape
    nothing = np.zeros(size)
    return np.stack([one.weights.get(axis, nothing) for axis in AXES], axis=-1)


def _is_noise(component: Component) -> bool:
    """Whether it is the noise of the readings; what is not known of a correction is common to all flips."""
    return component.kind == "A" and not component.origin.test


def _onward(plan: Plan, readings: Readings, used: Sequence[Flip]) -> dict[Key, tuple[float, float]]:
    """Return u and degrees of freedom of a mean bias as that of the next record, by noise or scatter of flips."""
    if not readings.quiet:
        return {}
    parts = [one.separated[0] for one in used]
    records = {id(record_of(readings, part.weights)) for part in parts}
    if len(records) == 1:
        weights = {axis: np.mean([part.weights[axis] for part in parts], axis=0) for axis in parts[0].weights}
        return next_record(plan, readings, replace(parts[0], weights=weights))
    values, count = np.array([one.values for one in used]), len(used)
    grown = np.std(values, axis=0, ddof=1) * np.sqrt(1.0 + 1.0 / count)
    return {key: (float(u), count - 1.0) for key, u in zip(used[0].keys, grown, strict=True) if key.quantity == BIAS}


def _used(flips: Sequence[Flip]) -> list[Flip]:
    """Return the flips that are pooled: those that separate most, and the same."""
    most = [one for one in flips if len(one.keys) == max(len(other.keys) for other in flips)]
    ambient = (AMBIENT, RATES[AMBIENT])
    used = [one for one in most if any(key.quantity in ambient for key in one.keys)] or most
    return [one for one in used if one.keys == used[0].keys]


def _in_common(plan: Plan, readings: Readings, used: Sequence[Flip]) -> list[Component]:
    """Return the excess of the noise of the mean over the scatter between flips; nothing where it is unknown."""
    parts = [one.separated[0] for one in used]
    records = [record_of(readings, part.weights) for part in parts]
    groups = {id(one): [part for part, own in zip(parts, records, strict=True) if own is one] for one in records}
    if None in records or len(groups) == len(used) or any(one.estimate is None for one in used):
        return []
    shared: list[Component] = []
    for group in groups.values():
        weights = {axis: np.sum([p.weights[axis] for p in group], axis=0) / len(used) for axis in group[0].weights}
        noise, reason = noise_components(plan, readings, replace(group[0], weights=weights))
        if reason or not noise:
            return []
        shared += noise
    noises = [one for flip in used if flip.estimate for one in flip.estimate.components if _is_noise(one)]
    single = np.sum([one.covariance for one in noises], axis=0)
    whole = np.sum([one.covariance for one in shared], axis=0)
    more = _positive(whole - (single - len(used) * whole) / (len(used) * (len(used) - 1)), whole)
    if not np.any(more):
        return []
    dof = np.min([np.broadcast_to(one.dof, len(more)) for one in shared], axis=0)
    small = np.diagonal(more) < 0.5 * np.diagonal(whole)  # the scatter decides how well the sum is known
    dof = np.where(small, np.minimum(dof, len(used) - 1.0), dof)
    return [Component(Origin("noise that flips of one record have in common", level="record"), "A", more, dof, "t")]


def _positive(covariance: Array, scale: Array) -> Array:
    """Return a covariance without its negative part; whatever is negligible against ``scale`` is zero."""
    size = np.sqrt(np.diagonal(scale))
    size = np.where(size > 0.0, size, 1.0)
    values, ways = np.linalg.eigh(covariance / np.outer(size, size))
    values = np.where(values > ROUNDING, values, 0.0)
    return np.asarray((ways * values) @ ways.T * np.outer(size, size))


def units(keys: Sequence[Key]) -> tuple[str, ...]:
    """Return the SI unit of each value."""
    changing = dict.fromkeys(WARM.values(), "m/s^2/degC") | dict.fromkeys(RATES.values(), "m/s^3")
    return tuple(changing.get(key.quantity, "m/s^2") for key in keys)


def differences(flips: Sequence[Flip]) -> list[Remark]:
    """Remark how few flips there are, and quantities that differ by more than their noise explains."""
    if len(flips) < 2:
        return []
    used, remarks = _used(flips), []
    count = len(used)
    if count < len(flips):
        labels, rest = ([one.label for one in some] for some in (used, [one for one in flips if one not in used]))
        what = f"not pooled: flip {', '.join(rest)}, which separates less than the others; pooled: {', '.join(labels)}"
        do = "See each flip by itself, and its remarks"
        remarks.append(Remark("flip_not_pooled", "warning", what, count=len(rest), do=do))
    if 1 < count < FEW:
        what = f"{count} flips: the scatter between them has {count - 1} degree{'' if count == 2 else 's'} of freedom"
        remarks.append(Remark("few_flips", "warning", what, do=f"Repeat until there are {FEW} flips or more"))
    tested: dict[Key, tuple[float, float]] = {}
    for key in used[0].keys:
        if count > 1 and key.quantity in (AMBIENT, BIAS, CONTROL):
            test = _against_noise(key, used)
            tested |= {} if test is None else {key: test}
    rejected = holm([p for _, p in tested.values()], RISK) if tested else ()
    for (key, (square, _)), differs in zip(tested.items(), rejected, strict=True):
        if differs:
            what = f"{key}: chi-square {square:.3g} between {count} flips, {count - 1} expected from their noise"
            do = "It changed between them: look at each flip"
            remarks.append(Remark("flips_differ", "warning", what, do=do))
    return remarks


def _against_noise(key: Key, flips: Sequence[Flip]) -> tuple[float, float] | None:
    """Chi-square of a value between flips against their noise, and its probability; None where noise is unknown."""
    estimates = [one.estimate.select([key]) for one in flips if one.estimate is not None]
    if len(estimates) < len(flips):
        return None
    noise = [sum(float(c.covariance[0, 0]) for c in one.components if _is_noise(c)) for one in estimates]
    dof = [min(float(np.min(c.dof)) for c in one.components if _is_noise(c)) for one in estimates]
    values = np.array([float(one.values[0]) for one in estimates])
    weights = 1.0 / np.array(noise)
    square = float(np.sum(weights * (values - np.average(values, weights=weights)) ** 2))
    free = len(values) - 1
    behind = float(np.sum(dof)) if np.isfinite(dof).all() else 1e9
    return square, float(special.fdtrc(free, behind, square / free))
