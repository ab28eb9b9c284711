"""A ground model against orbit: the bias that it predicts, and what a flip makes of it.

Where the readings come with the bias that a ground model predicts in their dwells, P_k, a flip combines P as it
combines the readings: the same weights w that give the bias B (or what is left of it, E) give the prediction that it
is to be compared with [1]_::

    predicted_bias   P = w P_k
    bias_shift       B - P         of readings that the model's bias is still in: how far it is off in orbit
    corrected_bias   P + E         of readings that it was taken off from (``plan.corrected``); E is model_bias_error

All are in the axes of the readings, and all signs are those of the reading: one rule for every axis. The prediction is
taken as a number without error: ``bias_shift`` and ``model_bias_error`` are the error of the model, so its own
uncertainty is no part of theirs, and that of the flip is (of several flips: their scatter). Along the turn bias and
ambient acceleration are one, and there is a prediction alone.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996, Table 19: predicted and corrected bias beside the measured one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ....core.key import Key
from ..plan import Plan
from ..readings import Readings
from .equations import BIAS, READING
from .pooling import Flip, pooled

PREDICTED, SHIFT, CORRECTED = "predicted_bias", "bias_shift", "corrected_bias"
DEPENDS = 1e-9  # of a weight, relative to the largest


@dataclass(frozen=True, eq=False)
class Against:
    """One axis of a flip, or of all of them pooled, against the ground model.

    Parameters
    ----------
    axis : str
        Which.
    label : str
        Of the flip; empty for all.
    predicted : float
        Bias that the model predicts, by the weights of the flip [m/s^2].
    quantity : str
        What ``flip`` holds at ``key``: ``bias_shift`` or ``corrected_bias``; empty along the turn.
    flip : Flip
        With that value in place of the bias, and its uncertainty.
    key : Key
        Of the value in the flip.
    flips : tuple of str
        Labels of those that went in: all that have a prediction.
    """

    axis: str
    label: str
    predicted: float
    quantity: str
    flip: Flip
    key: Key
    flips: tuple[str, ...]


def against_model(plan: Plan, readings: Readings, flips: Sequence[Flip]) -> Iterator[Against]:
    """Yield each axis that a model predicts the bias of: all flips pooled, then each of several.

    Parameters
    ----------
    plan, readings : Plan, Readings
        As given.
    flips : sequence of Flip
        Each by its own.
    """
    axes = [axis for axis in readings.axes if axis in readings.predicted]
    every = {axis: _of_axis(plan, readings, flips, axis) for axis in axes}
    for found in every.values():
        if found:
            whole = pooled(plan, readings, [one.flip for one in found])
            used = [one for one in found if any(part.flip == one.label for part in whole.separated)]
            mean = float(np.mean([one.predicted for one in used]))
            labels = tuple(one.label for one in used)
            yield replace(found[0], label="", predicted=mean, flip=whole, flips=labels)
    for one in flips if len(flips) > 1 else ():
        yield from (found for own in every.values() for found in own if found.label == one.label)


def _of_axis(plan: Plan, readings: Readings, flips: Sequence[Flip], axis: str) -> list[Against]:
    """Return the flips that bias, or the reading along the turn, was found in and whose dwells have a prediction."""
    key = Key(READING if axis == plan.axis else BIAS, axis)
    quantity = "" if axis == plan.axis else CORRECTED if plan.corrected else SHIFT
    found = []
    for one in flips:
        if key in one.keys and (predicted := _predicted(readings, one, key)) is not None:
            moved = _moved(one, key, predicted if plan.corrected else -predicted)
            found.append(Against(axis, one.label, predicted, quantity, moved, key, (one.label,)))
    return found


def _predicted(readings: Readings, flip: Flip, key: Key) -> float | None:
    """Return what the flip's own weights make of the prediction [m/s^2]; None where a dwell that counts has none."""
    at = flip.keys.index(key)
    total = 0.0
    for axis, weights in flip.separated[0].weights.items():
        line = weights[at]
        counts = np.abs(line) > DEPENDS * np.abs(weights).max()
        if counts.any():
            total += float(line[counts] @ readings.predicted.get(axis, np.full(len(readings), np.nan))[counts])
    return total if np.isfinite(total) else None


def _moved(flip: Flip, key: Key, by: float) -> Flip:
    """Return the flip with one value moved by a number without error."""
    values = flip.values.copy()
    values[flip.keys.index(key)] += by
    estimate = None if flip.estimate is None else replace(flip.estimate, values=values)
    return replace(flip, values=values, estimate=estimate)
