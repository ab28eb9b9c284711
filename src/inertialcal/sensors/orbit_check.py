"""Whether a compensated suite of gyros sees the rate of an orbit, and that of the earth.

A reading of one axis, turned at the rate alone and averaged over a time tau, is compensated by the model. Its
standard uncertainty is, for a reading taken as it is::

    u^2 = u(model)^2 + s(run to run)^2 + N^2 / tau

and for one less a reading at rest of the same length, in the same run::

    u^2 = u(difference by the model)^2 + 2 A(tau)^2,     A^2 = N^2 / tau + (2 ln 2 / pi) B^2 + K^2 tau / 3

where the bias and its run-to-run part cancel, and of the model the errors of scale factor and matrix stay. N, B, K are
angle random walk, bias instability and rate random walk of the model's noise. A rate is seen if it is larger than
1.96 u: the 95 % interval of the reading does not hold zero.

Assumed: temperature, pressure and other channels at the model's reference, and known; settled after power-up;
weightless. Parameters without uncertainty count as exact; what the model lacks (noise, run-to-run, g-sensitivity)
counts as zero, and is said. Gauss-Markov noise counts with its whole standard deviation. For the reading at rest the
satellite stands still against the stars.

References
----------
.. [1] IEEE Std 952-1997, Annex C (Allan variance of the terms).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..core.constants import BIAS_INSTABILITY_FACTOR, EARTH_ROTATION_RATE
from ..core.errors import DataError
from ..core.estimate import Array, Component, Estimate
from ..physics.earth import axis_earth_rate
from ..physics.orbit import orbital_rate
from .model.equation import Conditions, condition_columns, inverted, matrix_at, predict
from .model.sensor_model import SensorModel
from .model.uncertainty import compensated_uncertainty, point, reading_by, without_uncertainty

NEAR = 1.5  # factor between a rate of the table and that of the orbit, up to which a dwell counts
FACTOR = 1.96  # u in half a 95 % interval
SETTLED = 1e9  # [s] after power-up


@dataclass(frozen=True)
class AxisCheck:
    """One axis, by one way of reading."""

    axis: str
    zero_reference: bool  # Whether a reading at rest is subtracted
    u: float  # Of a compensated reading at the orbit's rate [rad/s]
    orbit_ratio: float  # Rate of the orbit over 1.96 u; infinite where the model has nothing that u could hold
    earth_ratio: float  # Rate of the earth, or its vertical part, over 1.96 u

    @property
    def orbit_seen(self) -> bool:
        """Whether the orbit's rate is seen at 95 %."""
        return 1.0 < self.orbit_ratio < math.inf

    @property
    def earth_seen(self) -> bool:
        """Whether the earth's rate is seen at 95 %: all of it, or its vertical part."""
        return 1.0 < self.earth_ratio < math.inf


@dataclass(frozen=True)
class OrbitCheck:
    """What a suite sees of an orbit."""

    altitude: float  # [m]
    rate: Estimate  # Of the orbit [rad/s]
    averaging: float  # [s]
    earth: Estimate  # Rate of the earth: all of it, or at a latitude its vertical part [rad/s]
    latitude: float | None  # Geodetic [rad]
    checks: tuple[AxisCheck, ...]  # Each axis, as it is and with a zero reference
    not_counted: tuple[str, ...]  # What the model lacks, or has without uncertainty


@dataclass(frozen=True)
class DwellCheck:
    """Dwells of one axis, held out, at rates near that of the orbit."""

    axis: str
    dwells: int
    runs: int  # Power-ups
    inside: int  # Of them, with a mean error inside the band
    error: float  # Compensated reading less table and earth rate, mean over power-ups [rad/s]; NaN without dwells
    u: float | None  # From power-up to power-up; None of fewer than two [rad/s]
    band: float  # Half of the 95 % interval of a reading taken as it is [rad/s]


def dwell_check(found: OrbitCheck, axis: str, applied: Array, error: Array, run: Sequence[str]) -> DwellCheck:
    """Return whether compensated dwells near the orbit's rate, within a factor of 1.5, lie in the stated band.

    Parameters
    ----------
    applied, error : ndarray, shape (n,)
        Rate about the axis, earth rate included, and compensated reading less that [rad/s].
    run : sequence of str
        Power-up of each dwell.
    """
    n = float(found.rate.values[0])
    band = next(FACTOR * one.u for one in found.checks if one.axis == axis and not one.zero_reference)
    near = (np.abs(applied) > n / NEAR) & (np.abs(applied) < n * NEAR) & np.isfinite(error)
    names = np.asarray(run)[near]
    means = np.array([error[near][names == name].mean() for name in np.unique(names)])
    u = float(np.std(means, ddof=1) / np.sqrt(len(means))) if len(means) > 1 else None
    mean = float(np.mean(means)) if len(means) else np.nan
    return DwellCheck(axis, int(near.sum()), len(means), int(np.sum(np.abs(means) <= band)), mean, u, band)


def orbit_check(
    model: SensorModel,
    altitude: float,
    averaging: float = 100.0,
    latitude: float | None = None,
    u_latitude: float = 0.0,
) -> OrbitCheck:
    """Return whether each axis of a suite sees the rate of an orbit.

    Parameters
    ----------
    altitude : float
        Of a circular orbit [m].
    averaging : float
        Time over which a reading is averaged [s].
    latitude, u_latitude : float
        Geodetic, of a suite whose axis stands upright: it reads the vertical part of the earth's rate. Without it
        the whole counts [rad].

    Raises
    ------
    DataError
        ``not_a_gyro``; ``altitude``, ``averaging``; ``no_covariance`` if the model carries no uncertainty.
    """
    if model.kind != "gyro":
        raise DataError("no gyro: an accelerometer does not see the rate of an orbit", code="not_a_gyro")
    if not (math.isfinite(averaging) and averaging > 0.0):
        raise DataError(f"averaging time {averaging:g} s: need more than 0 s", code="averaging")
    rate = orbital_rate(altitude)
    known = Component("earth rate", "B", np.zeros((1, 1)))
    whole = Estimate(("earth_rate",), np.array([EARTH_ROTATION_RATE.value]), ("rad/s",), (known,))
    earth = whole if latitude is None else axis_earth_rate(latitude, 0.0, u_latitude=u_latitude)
    n = float(rate.values[0])
    here = _reference_conditions(model)
    checks = []
    for i, axis in enumerate(model.axes):
        x = np.zeros((2, len(model.axes)))
        x[1, i] = n
        direct = float(compensated_uncertainty(model, predict(model, x, **here), **here)[1, i])
        white, all_noise = _noise(model, axis, averaging)
        for zero_reference, u in (
            (False, math.hypot(direct, white)),
            (True, math.hypot(_difference_u(model, x, here)[i], math.sqrt(2.0) * all_noise)),
        ):
            ratios = [size / (FACTOR * u) if u > 0.0 else math.inf for size in (n, abs(float(earth.values[0])))]
            checks.append(AxisCheck(axis, zero_reference, u, *ratios))
    lacking = [] if model.noise is not None else ["noise: the model has none"]
    lacking += [] if model.bias_run_to_run is not None else ["bias from run to run: the model has none"]
    lacking += (
        [] if model.g_sensitivity is not None else ["g-sensitivity: the model has none, and its bias was found at 1 g"]
    )
    exact = without_uncertainty(model)
    lacking += [f"taken as exact: {', '.join(exact)}"] if exact else []
    return OrbitCheck(altitude, rate, averaging, earth, latitude, tuple(checks), tuple(lacking))


def _reference_conditions(model: SensorModel) -> Conditions:
    here: Conditions = {
        "time": SETTLED, "temperature_rate": 0.0, "specific_force": np.zeros(3),
        "channels": {one.channel: one.reference for one in model.sensitivities},
    }  # fmt: skip
    if model.reference_temperature is not None:
        here["temperature"] = np.asarray(model.reference_temperature)[np.newaxis]
    if model.reference_pressure is not None:
        here["pressure"] = model.reference_pressure
    return here


def _difference_u(model: SensorModel, x: Array, here: Conditions) -> Array:
    """Return what uncertainty the model leaves in the difference of two compensated inputs, shape (k,) [rad/s]."""
    if model.estimate is None:  # refused before
        return np.zeros(len(model.axes))
    columns = condition_columns(model, len(x), here)
    by_name = {one.name: one for one in model.parameters}
    at = point(model, x, columns)
    to_input = inverted(matrix_at(model, columns)) / at.slope[:, np.newaxis, :]
    moved = to_input @ np.stack([reading_by(model, by_name[name], at) for name in model.estimate.names], axis=2)
    change = moved[1] - moved[0]
    variance = np.einsum("kp,pq,kq->k", change, model.estimate.covariance, change)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))


def _noise(model: SensorModel, axis: str, tau: float) -> tuple[float, float]:
    """Return the standard deviation of a mean over tau, and the Allan deviation, by the model's noise [rad/s]."""
    if model.noise is None:
        return 0.0, 0.0
    size = {
        key.quantity: float(value)
        for key, value in zip(model.noise.keys, model.noise.values, strict=True)
        if key.axis == axis
    }
    white = size.get("angle_random_walk", 0.0) ** 2 / tau
    slow = (BIAS_INSTABILITY_FACTOR.value * size.get("bias_instability", 0.0)) ** 2
    slow += size.get("rate_random_walk", 0.0) ** 2 * tau / 3.0
    correlated = size.get("gauss_markov_sigma", 0.0) ** 2
    return math.sqrt(white + correlated), math.sqrt(white + slow + correlated)
