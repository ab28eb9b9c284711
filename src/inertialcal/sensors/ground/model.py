"""Ground model of a triaxial head: bias, scale factor and misalignment as polynomials in temperature, by gain.

What a head reads at gain g, each sensor at its own temperature T, and the way back::

    v = S_g(T) {b_g(T) + (I + A(T)) x}            A: misalignment, zero on its diagonal
    u = v / S_g(T)                                scale factor
    x = L (u - b_g(T))                            bias, then misalignment

with ``L = (I + A)^-1`` in the order "jointly", the inverse of the sensor equation, and ``L = I - A`` in the order
"bias_first", the small-angle correction of the document [1]_; they differ by the square of A. A model in the form of
``sensors.model``, ``r = K0 + M x``, is the same with ``S_g(T) = S0 M_ii``, ``b = K0_i / M_ii``, ``A = M_ij / M_ii``.

The **predicted bias** is ``L b_g(T)``: what the head is thought to read along its axes where nothing accelerates it.
Taken off, it leaves the error of the model; not taken off, readings have the bias itself. Signs and the order of the
matrix are those of ``sensors.model``.

References
----------
.. [1] Chestney and Sicker, NASA TM-106980, 1996.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ..model.equation import away_from_reference, condition_columns, inverted, matrix_at, needed, offset
from ..model.sensor_model import SensorModel

Order = Literal["jointly", "bias_first"]
ORDERS: tuple[Order, ...] = ("jointly", "bias_first")
STEPS = ("bias", "scale_factor", "misalignment")


@dataclass(frozen=True, eq=False)
class Polynomials:
    """Of one sensor at one gain; coefficients of 1, (T - T_ref), (T - T_ref)^2, ..."""

    bias: Array  # shape (p,): [input unit/degC^j]
    scale: Array  # shape (q,): Scale factor over the ideal one that made the readings [1/degC^j]


@dataclass(frozen=True, eq=False)
class GroundModel:
    """A model that was made on the ground.

    Raises
    ------
    DataError
        ``curved_model`` if the model is not a straight line in the input; ``missing_condition`` if it needs more than
        the temperature.
    """

    # Misalignment (``matrix``), reference temperature, temperature range; all there is where no gain is told apart
    base: SensorModel
    # Gain -> axis -> polynomials; instead of bias and scale factor of ``base``
    gains: Mapping[float, Mapping[str, Polynomials]] = field(default_factory=dict[float, Mapping[str, Polynomials]])
    order: Order = "jointly"  # See the head of this module

    def __post_init__(self) -> None:
        if not self.base.linear:
            what = "the ground model has a curve"
            why = "a head in orbit reads micro-g, where bias, scale factor and misalignment are all there is"
            raise DataError(what, why=why, do="Give a model without asymmetry, K2 and K3", code="curved_model")
        others = sorted(set(needed(self.base)) - {"temperature"})
        if others:
            what = f"the ground model needs {', '.join(others)}"
            raise DataError(what, do="Give a model of the temperature alone", code="missing_condition")

    @property
    def axes(self) -> tuple[str, ...]:
        """Axes of the head."""
        return self.base.axes

    def at(self, gains: Sequence[float]) -> AtGains:
        """Return the model at one gain for each axis; a NaN takes the axis out.

        Raises
        ------
        DataError
            ``no_polynomial`` if an axis has none at its gain.
        """
        k = len(self.axes)
        if not self.gains:
            return AtGains(self.base, np.ones((1, k)))
        found = [self._polynomials(axis, gain) for axis, gain in zip(self.axes, gains, strict=True)]
        bias, scale = _columns([one.bias for one in found]), _columns([one.scale for one in found])
        rest = bias[1:] if len(bias) > 1 else None
        reference = self.base.reference_temperature
        model = replace(
            self.base, bias=bias[0], bias_temperature=rest, estimate=None,
            reference_temperature=np.zeros(k) if reference is None else reference,
        )  # fmt: skip
        return AtGains(model, scale)

    def _polynomials(self, axis: str, gain: float) -> Polynomials:
        if np.isnan(gain):
            return Polynomials(np.zeros(1), np.ones(1))
        for own, by_axis in self.gains.items():
            if np.isclose(own, gain, rtol=1e-9, atol=0.0) and axis in by_axis:
                return by_axis[axis]
        there = ", ".join(f"{own:g}" for own, by_axis in self.gains.items() if axis in by_axis)
        raise DataError(
            f"the ground model has no polynomials of {axis} at gain {gain:g}",
            why="bias and scale factor differ from gain to gain",
            do=f"It has those at: {there or 'none'}",
            code="no_polynomial",
        )


@dataclass(frozen=True, eq=False)
class AtGains:
    """A ground model at one set of gains."""

    model: SensorModel  # Bias and misalignment
    scale: Array  # shape (q, k): Coefficients of the scale factor over the ideal one, of T - T_ref

    @property
    def in_temperature(self) -> bool:
        """Whether the temperature must be known."""
        return len(self.scale) > 1 or bool(needed(self.model))

    def parts(
        self, temperature: Array | None, n: int, order: Order, unread: Sequence[str] = ()
    ) -> tuple[Array, Array, Array]:
        """Return scale factor over the ideal one, bias, and L.

        Parameters
        ----------
        temperature : ndarray, shape (n,) or (n, k), optional
            [degC]
        n : int
            Rows.
        order : {"jointly", "bias_first"}
            Of the model.
        unread : sequence of str
            Axes that were not read: the others are not corrected for them.

        Returns
        -------
        tuple of ndarray, shapes (1 or n, k), (1 or n, k), (1 or n, k, k)
            The bias after the scale factor [input unit].

        Raises
        ------
        DataError
            ``missing_condition`` if the temperature is needed and not given.
        """
        columns = condition_columns(self.model, n, {} if temperature is None else {"temperature": temperature})
        matrix = matrix_at(self.model, columns)
        diagonal = np.diagonal(matrix, axis1=1, axis2=2)
        cross = matrix / diagonal[:, :, np.newaxis]
        for axis in unread:
            at = self.model.axes.index(axis)
            cross[:, :, at] = np.eye(len(self.model.axes))[at]
        back = inverted(cross) if order == "jointly" else 2.0 * np.eye(cross.shape[1]) - cross
        return self._scale(temperature, n) * diagonal, offset(self.model, columns) / diagonal, back

    def _scale(self, temperature: Array | None, n: int) -> Array:
        if len(self.scale) == 1:
            return self.scale
        if temperature is None:
            raise DataError("no temperature given", why="the scale factor depends on it", code="missing_condition")
        degrees = np.asarray(temperature, dtype=float).reshape(n, -1)
        away = away_from_reference(self.model, {"temperature": degrees})
        total = np.zeros_like(away)
        for coefficient in self.scale[::-1]:
            total = total * away + coefficient
        return total


def _columns(coefficients: Sequence[Array]) -> Array:
    """Coefficients of k sensors, shape (q, k); a shorter polynomial has zeros."""
    longest = max(len(one) for one in coefficients)
    return np.column_stack([np.pad(one, (0, longest - len(one))) for one in coefficients])
