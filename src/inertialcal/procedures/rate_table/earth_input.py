"""Earth rate in the dwells of a rate table: what is known of it is an input, what is not is Type B.

The table axis stands at ``tilt`` from the vertical, towards ``azimuth``. The component of earth rate along it
stays; the component across turns with the table, and over the angle turned in a dwell its mean is known by
integration, but for its phase: where the table stood at the start against north is not known, so its cosine and
sine are unknowns of mean zero and variance one half, the same for all recordings about one axis.

Without an attitude nothing is known: every direction of earth rate is equally likely, so each component has
mean zero and standard uncertainty Omega / sqrt(3).

Body axes while axis i is turned by the angle theta: i stays along the table axis, the next one (j) and the one
after (k) are ``cos(theta) p + sin(theta) q`` and ``-sin(theta) p + cos(theta) q``, p and q across the axis.
"""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...physics.earth import axis_component, mean_over_turn
from .plan import AXES, Attitude, Plan

ROOT_HALF = float(np.sqrt(0.5))


def earth_along_axes(plan: Plan, axis: str, start: Array, angle: Array) -> tuple[Array, dict[str, Array]]:
    """Return the mean earth rate along the body axes in each dwell, and what is not known of it.

    Parameters
    ----------
    plan : Plan
        With attitude and latitude, or without.
    axis : str
        That is turned.
    start : ndarray, shape (n,)
        Table angle at the start of each dwell, from an unknown zero [rad]; NaN where not known.
    angle : ndarray, shape (n,)
        Angle turned in it, with its sign [rad].

    Returns
    -------
    earth : ndarray, shape (n, 3)
        [rad/s].
    sources : dict of str to ndarray, shape (s, n, 3)
        Independent patterns of one standard uncertainty each [rad/s].
    """
    i = AXES.index(axis)
    along = np.zeros((len(angle), 3))
    along[:, i] = 1.0
    attitude = plan.attitude
    if attitude is None or plan.latitude is None:
        size = EARTH / np.sqrt(3.0)
        sources = {f"direction, {axis} turned": np.stack([size * along, *(size * p for p in _across(i, start, angle))])}
        return np.zeros_like(along), sources
    component = axis_component(plan.latitude, attitude.tilt, attitude.azimuth)
    across = float(np.sqrt(max(EARTH**2 - component.value**2, 0.0)))
    sources = {name: (u * along)[None] for name, u in _known_to(plan, attitude, component).items()}
    sources[f"phase, {axis} turned"] = np.stack([across * ROOT_HALF * p for p in _across(i, start, angle)])
    return component.value * along, sources
