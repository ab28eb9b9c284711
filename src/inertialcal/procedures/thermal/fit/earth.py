"""Earth rate along the axes of a body at rest: what is known of it is taken off, what is not is Type B.

The body lies as ``plan.Attitude`` says; its axes are those of the table of ``physics.earth`` at table angle zero. With
an unknown azimuth the vertical part is known, and the level part may point anywhere: two unknowns of mean zero and
variance one half. Without an attitude or a latitude every direction of the whole is equally likely: each component has
mean zero and standard uncertainty Omega / sqrt(3).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ....core.estimate import Array
from ....core.influence import Influence
from ....physics.earth import OMEGA, earth_rate, level_to_table
from ..plan import Attitude, Plan

STEP = 1e-4  # [rad], of the differences


@dataclass(frozen=True, eq=False)
class Unknown:
    """What is not known of the earth rate from one source.

    Parameters
    ----------
    patterns : ndarray, shape (s, 3)
        Along x, y, z, each one standard uncertainty [rad/s].
    influence : Influence
        What it rests on.
    """

    patterns: Array
    influence: Influence


def earth_along(plan: Plan) -> tuple[Array, Mapping[str, Unknown]]:
    """Return earth rate along the body axes, shape (3,) [rad/s], and what is not known of it, by source."""
    attitude, latitude = plan.attitude, plan.latitude
    if attitude is None or latitude is None:
        size = OMEGA / np.sqrt(3.0)
        unknown = Unknown(size * np.eye(3), Influence(size, "rad/s", distribution="rectangular"))
        return np.zeros(3), {"attitude unknown": unknown}
    known = plan.standards.get("site.latitude", Influence(0.0, "rad"))
    found = {}
    for name, at, influence in (
        ("latitude", 0, known),
        ("tilt of the body", 1, Influence(attitude.u, "rad")),
        ("azimuth of the body", 2, Influence(attitude.u_azimuth, "rad")),
    ):
        if influence.u > 0.0 and not (at == 2 and attitude.azimuth is None):
            slope = _slope(latitude, attitude, at)
            found[name] = Unknown((influence.u * slope)[None], influence)
    if attitude.azimuth is None:
        found["azimuth of the body unknown"] = _any_azimuth(latitude, attitude)
    return _mean(latitude, attitude.tilt, attitude.azimuth), found


def _slope(latitude: float, attitude: Attitude, at: int) -> Array:
    """Change of earth rate along x, y, z with the latitude (0), the tilt (1) or the azimuth (2), shape (3,)."""
    moved = STEP * np.eye(3)[at]
    azimuth = None if attitude.azimuth is None else (attitude.azimuth - moved[2], attitude.azimuth + moved[2])
    low = _mean(latitude - moved[0], attitude.tilt - moved[1], None if azimuth is None else azimuth[0])
    high = _mean(latitude + moved[0], attitude.tilt + moved[1], None if azimuth is None else azimuth[1])
    return np.asarray((high - low) / (2.0 * STEP))


def _mean(latitude: float, tilt: float, azimuth: float | None) -> Array:
    """Earth rate along x, y, z; mean over all azimuths where it is not known."""
    if azimuth is None:
        return np.asarray(0.5 * (_mean(latitude, tilt, 0.0) + _mean(latitude, tilt, np.pi)))
    return np.asarray(level_to_table(tilt, azimuth) @ earth_rate(latitude))


def _any_azimuth(latitude: float, attitude: Attitude) -> Unknown:
    middle = _mean(latitude, attitude.tilt, None)
    waves = np.stack([_mean(latitude, attitude.tilt, angle) - middle for angle in (0.0, 0.5 * np.pi)])
    size = float(np.cos(latitude) * OMEGA * np.sqrt(0.5))
    return Unknown(waves * np.sqrt(0.5), Influence(size, "rad/s", distribution="arcsine"))
