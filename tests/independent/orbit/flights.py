"""Flips of one head over several flights, made without any code of the package.

The head has a bias that is a parabola in temperature. The ground test knows it with an error of stated covariance;
since then it has shifted, by an amount that changes with temperature, drifts, and jumps at each launch: anew, or on top
of the jumps before. Flips measure it with noise and with an offset that all of them share.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
YEAR = 31_557_600.0
T_REF = 20.0


@dataclass
class Head:
    """What was flown, ug and degC: one row a flip, the last flight that which comes next."""

    flight: NDArray[np.int64]
    years: Array
    temperature: Array
    measured: Array
    u: Array
    true: Array  # bias of each flip
    level: Array  # bias of each flip without launches
    ground: Array  # coefficients of the ground model, constant first
    covariance: Array  # of these
    drift: float  # [ug/year]
    slope: float  # of the shift from the ground model [ug/degC]


def flown(
    rng: np.random.Generator,
    flights: int = 6,
    launch: float = 3.0,
    kept: bool = False,
    slope: float = 0.3,
    drift: float = 2.0,
    apart: float = 4.0,
    wander: float = 3.0,
    u_ground: tuple[float, float, float] = (15.0, 0.4, 0.01),
    noise: float = 0.4,
    zero: float = 0.05,
    noise_times: float = 1.0,
    bend: float = 0.0,
    tails: float = 0.0,
) -> Head:
    """Return flights of a head, and one more.

    ``apart``: temperatures of the flips of a flight; ``wander``: spread of those of the flights; ``bend``: of the drift
    [ug/year^2]; ``tails``: degrees of freedom of launches, 0 for normal ones.
    """
    root = np.linalg.cholesky(np.array([[1.0, 0.3, 0.0], [0.3, 1.0, 0.2], [0.0, 0.2, 1.0]]))
    factors = np.diag(u_ground) @ root
    truth = np.array(
        [rng.choice([-1.0, 1.0]) * rng.uniform(800.0, 1500.0), rng.normal(0.0, 5.0), rng.normal(0.0, 0.02)]
    )
    ground = truth + factors @ rng.normal(size=3)
    moved, tilt, aging = rng.normal(0.0, 20.0), rng.normal(0.0, slope), rng.normal(0.0, drift)
    when = np.cumsum(rng.uniform(0.6, 1.6, flights + 1))
    jumps = rng.standard_t(tails, flights + 1) if tails else rng.normal(size=flights + 1)
    jumps = launch * (np.cumsum(jumps) if kept else jumps)
    offset = rng.normal(0.0, zero)
    rows = []
    for f in range(flights + 1):
        centre, count = rng.normal(T_REF, wander), int(rng.integers(2, 4))
        for T in centre + apart * (np.linspace(0.0, 1.0, count) - 0.5):
            own = truth @ np.array([1.0, T - T_REF, (T - T_REF) ** 2])
            level = own + moved + tilt * (T - T_REF) + aging * when[f] + bend * when[f] ** 2
            u = noise * rng.uniform(0.7, 1.5)
            true = level + jumps[f]
            rows.append((f, when[f], T, true + offset + noise_times * rng.normal(0.0, u), u, true, level))
    table = np.array(rows)
    return Head(
        table[:, 0].astype(np.int64), table[:, 1], table[:, 2], table[:, 3], table[:, 4], table[:, 5], table[:, 6],
        ground, factors @ factors.T, aging, tilt + float(truth[1] - ground[1]),
    )  # fmt: skip
