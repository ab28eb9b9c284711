"""Other estimates of the same record beside the fit, and whether they agree with it.

All are sums of the same readings with other weights, so they share most of their noise: what may differ between them
is the noise in the difference of the weights, far less than their uncertainties together. Where noise is told by
generalised least squares its covariance is used for it; in longer records noise is taken as white with the density at
the drive. More than three standard deviations of that difference is called a disagreement: drift that one of them does
not take out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.remarks import Remark
from .differences import difference_weights
from .fit import LineFit
from .generalised import LARGEST, Generalised, generalised_fit

MOST = 3.0  # standard deviations of a difference
SMALL = 1e-3  # of the uncertainty of the fit: a smaller difference is none


@dataclass(frozen=True)
class CrossCheck:
    """Another estimate of what is in phase."""

    name: str  # ``"alternating_differences"`` or ``"generalised_least_squares"``
    # value, u: amplitude in phase and its standard uncertainty; None where it could not be made
    value: float | None = None
    u: float | None = None
    # difference, u_difference: from that of the fit, and its standard uncertainty: of the difference, noise in common
    # left out
    difference: float | None = None
    u_difference: float | None = None
    reason: str = ""  # why it could not be made

    @property
    def disagrees(self) -> bool:
        """Whether it differs by more than noise explains."""
        return (
            self.difference is not None
            and self.u_difference is not None
            and abs(self.difference) > MOST * self.u_difference
        )

    def remark(self) -> Remark:
        """Return what is said of a disagreement."""
        words = self.name.replace("_", " ")
        what = f"{words} differ from the fit by {self.difference:.3g}, noise explains {self.u_difference:.2g}"
        do = "Look at the drift: a step, a saw-tooth or a change of the noise that one of them does not take out"
        return Remark("methods_disagree", "warning", what, do=do)


def cross_checks(found: LineFit, readings: Array) -> tuple[CrossCheck, ...]:
    """Estimate the same by alternating differences and by generalised least squares.

    Parameters
    ----------
    found : LineFit
        Of these readings.
    readings : ndarray, shape (n,)
        The first record of the fit.
    """
    x = np.asarray(readings, dtype=np.float64) - float(np.median(readings))
    checks, noise = [], None
    try:
        noise = generalised_fit(found.design.drive, x)
        checks.append(_compared("generalised_least_squares", noise.weights, found, x, noise, noise.u))
    except DataError as error:
        problem = error.problems[0]
        checks.append(CrossCheck("generalised_least_squares", reason=f"{problem.what}: {problem.why}"))
    try:
        weights = difference_weights(found.design.drive)
        checks.insert(0, _compared("alternating_differences", weights, found, x, noise, None))
    except DataError as error:
        checks.insert(0, CrossCheck("alternating_differences", reason=error.problems[0].why))
    return tuple(checks)


def _compared(
    name: str, weights: Array, found: LineFit, x: Array, noise: Generalised | None, u: float | None
) -> CrossCheck:
    value, sigma = float(weights @ x), float(found.noise[0])
    difference = value - float(found.in_phase[0])
    if noise is not None and len(x) <= LARGEST:
        own = found.weights_on(np.eye(len(x)))
        apart = weights - own
        square, spread = float(apart @ noise.covariance @ apart), float(weights @ noise.covariance @ weights)
    else:
        shared = float(found.weights_on(weights[:, None])[0])
        own_square = float((found.u_in_phase[0] / sigma) ** 2)
        spread = sigma**2 * float(weights @ weights)
        square = spread - 2.0 * sigma**2 * shared + sigma**2 * own_square
    floor = SMALL * float(found.u_in_phase[0])
    return CrossCheck(name, value, u or float(np.sqrt(max(spread, 0.0))), difference,
                      float(np.sqrt(max(square, floor**2))))  # fmt: skip
