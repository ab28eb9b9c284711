"""Bias over temperature in other variables: volts of the temperature channel, degrees, units of the reading.

A temperature channel is linear, ``v = voltage + slope (T - temperature)``, so a polynomial in the one is a polynomial
of the same order in the other: the change is exact. As a Chebyshev series it keeps its coefficients and their
covariance, and only the ends of its range change; a negative slope turns the sign of the odd ones.

Badescu prints the bias of the flight unit twice, over volts (Table 3) and over degrees (Table 4). For z the second
follows from the first. For x and y it does so with the reference temperatures of Table 2 exchanged (25.4 degC for x,
25.7 degC for y): the thesis has taken those of the other sensor.

References
----------
.. [1] V. V. Badescu, NPS thesis, September 2011, equations (9) to (12), Tables 2, 3, 4, 7, 8.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..core.errors import PlanError
from ..statistics.polynomial import Polynomial


def change_variable(polynomial: Polynomial, scale: float, zero: float) -> Polynomial:
    """Return q with ``q(z) = p(x)`` where ``x = scale z + zero``, exactly, its covariance taken along.

    Parameters
    ----------
    polynomial : Polynomial
        p, over x.
    scale : float
        Change of x with z, not 0 [unit of x / unit of z].
    zero : float
        x where z is 0.

    Raises
    ------
    PlanError
        If the scale is zero or not finite.
    """
    if not np.isfinite(scale) or scale == 0.0:
        raise PlanError(f"scale {scale:g} of a change of variable: need a finite number other than 0")
    ends = [(x - zero) / scale for x in polynomial.domain]
    turned = np.ones(polynomial.order + 1) if scale > 0.0 else (-1.0) ** np.arange(polynomial.order + 1)
    covariance = None if polynomial.covariance is None else polynomial.covariance * np.outer(turned, turned)
    return Polynomial(polynomial.coefficients * turned, covariance, polynomial.dof, (min(ends), max(ends)))


def over_temperature(polynomial: Polynomial, slope: float, voltage: float, temperature: float) -> Polynomial:
    """Return a polynomial over the channel's volts as one over degC.

    Parameters
    ----------
    polynomial : Polynomial
        Over volts.
    slope : float
        [V/degC]
    voltage, temperature : float
        Volts that the channel gives at a temperature [V], [degC].

    Raises
    ------
    PlanError
        If the slope is zero.
    """
    return change_variable(polynomial, slope, voltage - slope * temperature)


def over_voltage(polynomial: Polynomial, slope: float, voltage: float, temperature: float) -> Polynomial:
    """Return a polynomial over degC as one over the channel's volts: the inverse of `over_temperature`.

    Raises
    ------
    PlanError
        If the slope is zero.
    """
    if slope == 0.0:
        raise PlanError("slope 0 V/degC: the channel does not tell temperatures")
    return change_variable(polynomial, 1.0 / slope, temperature - voltage / slope)


def in_unit(polynomial: Polynomial, factor: float) -> Polynomial:
    """Return a polynomial of readings in another unit: of volts over the scale factor, say.

    Parameters
    ----------
    polynomial : Polynomial
        Of readings in the first unit.
    factor : float
        Readings of the second unit in one of the first.
    """
    covariance = None if polynomial.covariance is None else polynomial.covariance * factor**2
    return replace(polynomial, coefficients=polynomial.coefficients * factor, covariance=covariance)
