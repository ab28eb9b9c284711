"""Covariance of what is fitted with weights that are not the inverse covariance of what is found.

With D the slopes of what is expected, W the weights and Sigma the covariance of what is found::

    H = D' W D,    J = D' W Sigma W D,    covariance = H^-1 J H^-1

References
----------
.. [1] C. Varin, N. Reid and D. Firth, Statistica Sinica 21 (2011) 5: composite likelihood, Godambe information.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....core.estimate import Array

SINGULAR = 1e-12  # of the largest eigenvalue: directions that nothing tells of


@dataclass(frozen=True, eq=False)
class Sandwich:
    """Covariance of the unknowns, and what it would be if W were the inverse of Sigma, each shape (q, q)."""

    covariance: Array
    naive: Array

    @property
    def stretch(self) -> Array:
        """Variance over that as if W were the inverse of Sigma, shape (q,)."""
        return np.asarray(np.diag(self.covariance) / np.diag(self.naive))

    @property
    def u(self) -> Array:
        """Standard uncertainties, shape (q,)."""
        return np.sqrt(np.diag(self.covariance))


def sandwich_of(D: Array, weights: Array, sigma: Array) -> Sandwich:
    """Return the covariance of the unknowns; see the module head.

    Parameters
    ----------
    D : ndarray, shape (k, q)
        Slopes.
    weights : ndarray, shape (k,)
        Diagonal of W.
    sigma : ndarray, shape (k, k)
        Covariance of what is found.
    """
    DW = D.T * weights
    H = DW @ D
    scale = 1.0 / np.sqrt(np.diag(H))  # powers of different terms differ by orders of magnitude
    scales = np.outer(scale, scale)
    inverse = np.linalg.pinv(H * scales, rcond=SINGULAR, hermitian=True) * scales
    half = inverse @ DW
    covariance = half @ sigma @ half.T
    return Sandwich(0.5 * (covariance + covariance.T), inverse)
