"""Free prisms, against harmonica, which needs a call for each component; both may use all cores."""

from __future__ import annotations

import numpy as np

from inertialcal.core.estimate import Array
from inertialcal.physics.attraction.bodies import G, Prism

from ..comparison import Work, line

POINTS, PRISMS = 2_000, 20
MGAL = 1e-5  # m/s^2
FIELDS = {"g_e": 1.0, "g_n": 1.0, "g_z": -1.0}  # g_z is positive downward
AGREED = 1e-12  # of the largest field


@line(f"field of free prisms, {POINTS} points x {PRISMS}", peer="harmonica, parallel, 3 components", goal=2.0)
def prisms() -> Work:
    import harmonica  # type: ignore[import-untyped]

    rng = np.random.default_rng(1)
    low, density = rng.uniform(-1.0, 1.0, (PRISMS, 3)), rng.uniform(1e3, 8e3, PRISMS)
    high, points = low + rng.uniform(0.2, 1.0, (PRISMS, 3)), rng.uniform(-3.0, 3.0, (POINTS, 3))
    bodies = [Prism(tuple(a), tuple(b), float(c)) for a, b, c in zip(low, high, density, strict=True)]
    ends, at = np.stack([low, high], axis=2).reshape(-1, 6), tuple(points.T.copy())

    def own() -> Array:
        found: Array = G * np.sum([body.field(points) for body in bodies], axis=0)
        return found

    def peer() -> Array:
        parts = [s * harmonica.prism_gravity(at, ends, density, field=f, parallel=True) for f, s in FIELDS.items()]
        return MGAL * np.stack(parts, axis=1)

    assert np.abs(own() - peer()).max() < AGREED * np.abs(peer()).max()
    return Work(own, peer)
