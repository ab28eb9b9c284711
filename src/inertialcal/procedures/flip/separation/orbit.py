"""A ground model against orbit: its predicted bias, compared with that of the flip.

Where the readings come with the bias that a ground model predicts in their dwells, P_k, a flip combines P as it
combines the readings: the same weights w that give the bias B (or its remaining error E) give the prediction to compare
it with [1]_::

    predicted_bias   P = w P_k
    bias_shift       B - P         of raw readings: how far the model is off in orbit
    corrected_bias   P + E         of readings less the model's bias (``plan.corrected``); E is model_bias_error

All are in the axes of the readings, and all signs are those of the reading: one rule for every axis. The prediction is
taken as a number without error: ``bias_shift`` and ``model_bias_error`` are the error of the model, so its own
uncertainty is no part of theirs, and that of the flip is (of several flips: their scatter). Along the turn, where bias
and ambient acceleration are not separated, there is a prediction alone.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996, Table 19: predicted, corrected and measured bias.
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
    """Yield each axis whose bias a model predicts: all flips pooled, then each of several."""
    axes = [axis for axis in readings.axes if axis in readings.predicted]
    every = {axis: _of_axis(plan, readings, flips, axis) for axis in axes}
    for own in every.values():
        if own:
            whole = pooled(plan, readings, [one.flip for one in own])
            used = [one for one in own if any(part.flip == one.label for part in whole.separated)]
            mean = float(np.mean([one.predicted for one in used]))
            labels = tuple(one.label for one in used)
            yield replace(own[0], label="", predicted=mean, flip=whole, flips=labels)
    for flip in flips if len(flips) > 1 else ():
        yield from (one for own in every.values() for one in own if one.label == flip.label)


def _of_axis(plan: Plan, readings: Readings, flips: Sequence[Flip], axis: str) -> list[Against]:
    """Return the flips with a bias (along the turn: a reading) whose dwells all have a prediction."""
    key = Key(READING if axis == plan.axis else BIAS, axis)
    quantity = "" if axis == plan.axis else CORRECTED if plan.corrected else SHIFT
    found = []
    for flip in flips:
        if key not in flip.keys:
            continue
        at, predicted = flip.keys.index(key), 0.0
        for sensor, weights in flip.separated[0].weights.items():
            counts = np.abs(weights[at]) > DEPENDS * np.abs(weights).max()
            if counts.any():
                known = readings.predicted.get(sensor, np.full(len(readings), np.nan))
                predicted += float(weights[at][counts] @ known[counts])
        if np.isfinite(predicted):
            values = flip.values.copy()
            values[at] += predicted if plan.corrected else -predicted
            estimate = None if flip.estimate is None else replace(flip.estimate, values=values)
            moved = replace(flip, values=values, estimate=estimate)
            found.append(Against(axis, flip.label, predicted, quantity, moved, key, (flip.label,)))
    return found
