"""The ground model that the engineer of the simulated head has: its true polynomials, with an error.

In the form of ``sensors.ground.model``: what the head reads is ``S(T)/S0 (K0 + M x)``, so its scale factor is that
times ``M_ii`` (at the reference temperature: a change of 1e-5 of some ug is nothing), its bias ``K0 / M_ii``, its
misalignment ``M_ij / M_ii``. The error of the scale factor is that of the standard, and none of the model.

What the truth means, where readings come after the model: its bias error is the mean over the record of what the
corrected head reads without acceleration, along the axes that the model gives it.
"""

from __future__ import annotations

import numpy as np

from ...core.axes import AXES
from ..protocol import TrueValue
from .head import polynomial
from .record import Record
from .setup import REFERENCE_TEMPERATURE, SCALE_FACTOR_V_PER_G, UG, Bench, Drawing, Head

UNIT = "m/s^2"


def draw_model(bench: Bench, head: Head, rng: np.random.Generator) -> Drawing:
    """Return the ground model of a head, errors of bias, of its slope and of the misalignment drawn."""
    own = np.diagonal(head.matrix[0])
    bias = head.bias / own
    bias[0] += rng.normal(0.0, bench.model_ug * UG, 3)
    bias[1] += rng.normal(0.0, bench.model_slope_ug * UG, 3)
    scale = head.scale * own * np.array(SCALE_FACTOR_V_PER_G)
    cross = head.matrix / own[:, None]
    cross[0] += rng.normal(0.0, bench.model_misalignment, (3, 3))
    cross[:, range(3), range(3)] = 0.0
    return Drawing(bias, scale, cross)


def true_values(bench: Bench, head: Head, model: Drawing, made: Record) -> list[TrueValue]:
    """Return what a flip of the corrected head is measured by."""
    away = made.temperature - REFERENCE_TEMPERATURE
    cross = model.cross[0] + model.cross[1] * away.mean(axis=0)[:, None]
    back = np.linalg.inv(np.eye(3) + cross) if bench.ground == "jointly" else np.eye(3) - cross
    bias = back @ (made.bias / np.diagonal(head.matrix[0]))
    error = bias - back @ polynomial(model.bias, away).mean(axis=0)
    found = []
    for names, values in ((("bias", "corrected_bias"), bias), (("model_bias_error", "bias_shift"), error)):
        found += [TrueValue(name, axis, float(values[i]), UNIT) for name in names for i, axis in enumerate(AXES)]
    return found
