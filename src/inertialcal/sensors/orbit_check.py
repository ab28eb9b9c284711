"""Whether a compensated suite of gyros sees the rate of an orbit, and that of the earth.

A reading of one axis, turned at the rate alone and averaged over a time tau, is compensated by the model. Its
standard uncertainty is, for a reading taken as it is::

    u^2 = u(model)^2 + s(run to run)^2 + N^2 / tau

and for one less a reading at rest of the same length, in the same run::

    u^2 = u(difference by the model)^2 + 2 A(tau)^2,     A^2 = N^2 / tau + (2 ln 2 / pi) B^2 + K^2 tau / 3

where the bias and its run-to-run part cancel, and of the model the errors of scale factor and matrix stay. N, B, K are
angle random walk, bias instability and rate random walk of the model's noise. A rate is seen if it is larger than
k u, with k from the degrees of freedom of u: the 95 % interval of the reading does not hold zero. Where the bias has no
uncertainty, that of a reading taken as it is is not known.

Assumed: temperature, pressure and other channels at the model's reference, and known; settled after power-up;
weightless. Other parameters without uncertainty count as exact; what the model lacks (noise, run-to-run,
g-sensitivity) counts as zero, and is said. Gauss-Markov noise counts with its whole standard deviation. For the reading
at rest the satellite stands still against the stars.

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
from ..core.estimate import Array, Component, Estimate, joined_dof
from ..core.key import Key
from ..physics.earth import axis_earth_rate
from ..physics.orbit import orbital_rate
from ..statistics.intervals import binomial_interval, coverage_factor
from .model.equation import Conditions, condition_columns, inverted, matrix_at
from .model.sensor_model import SensorModel
from .model.uncertainty import estimate_of, point, reading_by, without_uncertainty

NEAR = 1.5  # factor between a rate of the table and that of the orbit, up to which a dwell counts
P = 0.95  # of intervals
SETTLED = 1e9  # [s] after power-up
WALKS = ("angle_random_walk", "bias_instability", "rate_random_walk")
INSTEAD = {"bias_instability": ("gauss_markov_sigma",), "rate_random_walk": ("gauss_markov_sigma",)}


@dataclass(frozen=True)
class AxisCheck:
    """One axis, by one way of reading."""

    axis: str
    zero_reference: bool  # Whether a reading at rest is subtracted
    u: float  # Of a compensated reading at the orbit's rate; NaN where the bias has none [rad/s]
    dof: float  # Of u
    half: float  # Of its 95 % interval, half [rad/s]
    orbit_ratio: float  # Rate of the orbit over that half; infinite where the model has nothing that u could hold
    earth_ratio: float  # Rate of the earth, or its vertical part, over it

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
    runs: int
    inside: int  # Of them, with a mean error inside the band
    error: float  # Compensated reading less table and earth rate, mean over runs [rad/s]; NaN without dwells
    u: float | None  # From run to run; None of fewer than two [rad/s]
    band: float  # Half of the 95 % interval of a reading taken as it is; NaN where it is not known [rad/s]


def band_holds(dwells: Sequence[DwellCheck]) -> bool:
    """Return whether as many runs lie in the stated bands as 95 % intervals let expect, all axes together."""
    known = [one for one in dwells if np.isfinite(one.band)]
    runs = sum(one.runs for one in known)
    return runs == 0 or binomial_interval(sum(one.inside for one in known), runs)[1] >= P


def dwell_check(found: OrbitCheck, axis: str, applied: Array, error: Array, run: Sequence[str]) -> DwellCheck:
    """Return whether compensated dwells near the orbit's rate, within a factor of 1.5, lie in the stated band.

    Parameters
    ----------
    applied, error : ndarray, shape (n,)
        Rate about the axis, earth rate included, and compensated reading less that [rad/s].
    run : sequence of str
        Run of each dwell.
    """
    n = float(found.rate.values[0])
    band = next(one.half for one in found.checks if one.axis == axis and not one.zero_reference)
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
    here, exact = _reference_conditions(model), without_uncertainty(model)
    checks = []
    for i, axis in enumerate(model.axes):
        direct, difference, run_to_run = _changes(model, i, n, here)
        white, all_noise = _noise(model, axis, averaging)
        for zero_reference, change, noise in ((False, direct, white), (True, difference, math.sqrt(2.0) * all_noise)):
            u, dof = _u_of(model, axis, change, 0.0 if zero_reference else run_to_run, noise)
            if not zero_reference and str(Key("bias", axis)) in exact:
                u, dof = math.nan, math.nan
            half = coverage_factor(dof, P) * u if u > 0.0 else u
            sizes = (n, abs(float(earth.values[0])))
            ratios = [size / half if half > 0.0 else math.inf for size in sizes]
            checks.append(AxisCheck(axis, zero_reference, u, dof, half, *ratios))
    return OrbitCheck(altitude, rate, averaging, earth, latitude, tuple(checks), tuple(_lacking(model, exact)))


def _lacking(model: SensorModel, exact: Sequence[str]) -> list[str]:
    """Return what the model lacks, or has without uncertainty, in words."""
    found = []
    if model.noise is None:
        found.append("noise: the model has none")
    else:
        for quantity in WALKS:
            known = {key.axis for key in model.noise.keys if key.quantity in (quantity, *INSTEAD.get(quantity, ()))}
            axes = [axis for axis in model.axes if axis not in known]
            if axes:
                found.append(f"noise, {quantity.replace('_', ' ')} of {', '.join(axes)}: not estimated")
    found += [] if model.bias_run_to_run is not None else ["bias from run to run: the model has none"]
    found += (
        [] if model.g_sensitivity is not None else ["g-sensitivity: the model has none, and its bias was found at 1 g"]
    )
    biases = {str(Key("bias", axis)): axis for axis in model.axes}
    without = [axis for name, axis in biases.items() if name in exact]
    others = [name for name in exact if name not in biases]
    found += [f"bias of {', '.join(without)}: the model has none, so that u of a direct reading is not known"] * bool(
        without
    )
    return [*found, *([f"taken as exact: {', '.join(others)}"] if others else [])]


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


def _changes(model: SensorModel, i: int, rate: float, here: Conditions) -> tuple[Array, Array, float]:
    """Return by how much each parameter moves one axis at a rate, and its difference from rest, shape (p,).

    Third comes the scatter of the axis from run to run [rad/s].
    """
    x = np.zeros((2, len(model.axes)))
    x[1, i] = rate
    columns = condition_columns(model, len(x), here)
    by_name = {one.name: one for one in model.parameters}
    at = point(model, x, columns)
    to_input = inverted(matrix_at(model, columns)) / at.slope[:, np.newaxis, :]
    names = estimate_of(model).names
    moved = (to_input @ np.stack([reading_by(model, by_name[name], at) for name in names], axis=2))[:, i]
    scatter = np.zeros(len(x[0])) if model.bias_run_to_run is None else model.bias_run_to_run
    return moved[1], moved[1] - moved[0], math.sqrt(float(to_input[-1, i] ** 2 @ scatter**2))


def _u_of(model: SensorModel, axis: str, change: Array, run_to_run: float, noise: float) -> tuple[float, float]:
    """Return u of one axis with its degrees of freedom: model, run-to-run, and noise, whose size counts as known.

    The scatter from run to run is known as well as the run part of the bias is; each source as well as the parameter
    that it comes through most.
    """
    estimate, bias = estimate_of(model), str(Key("bias", axis))
    place = estimate.names.index(bias) if bias in estimate.names else None
    variances, dofs = [np.array(noise**2)], [np.array(np.inf)]
    rest = run_to_run**2
    for one in estimate.components:
        variance = max(float(change @ one.covariance @ change), 0.0)
        free = np.broadcast_to(one.dof, len(change))
        dof = free[np.argmax(change**2 * np.diag(one.covariance))]
        if rest and place is not None and one.origin.level == "run" and one.covariance[place, place] > 0.0:
            variance, dof, rest = variance + rest, free[place], 0.0
        variances.append(np.array(variance))
        dofs.append(np.array(dof))
    variances.append(np.array(rest))
    dofs.append(np.array(np.inf))
    total = float(sum(variances))
    if total == 0.0:
        return 0.0, math.inf
    return math.sqrt(total), float(joined_dof(variances, dofs))


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
