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

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from ....core.constants import EARTH_ROTATION_RATE
from ....core.estimate import Array, Estimate
from ....core.influence import Influence
from ....core.key import AXES
from ....physics.earth import axis_earth_rate
from ....signals.remembered import remembered
from ..plan import Attitude, Plan
from ..readings import Labels, Readings

ROOT_HALF = float(np.sqrt(0.5))
ROOT_THIRD = float(np.sqrt(1.0 / 3.0))
OMEGA = EARTH_ROTATION_RATE.value


def earth_in_dwells(plan: Plan, axis: str, start: Array, angle: Array) -> tuple[Array, dict[str, Array]]:
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
        Angle turned in it, with its sign [rad]; NaN where not known.

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
    # Mean of the component across the axis over the angle turned, for the two phases, shape (2, n, 3)
    j, k = (i + 1) % 3, (i + 2) % 3
    turned = np.nan_to_num(angle)
    middle = np.nan_to_num(start) + 0.5 * turned
    left = np.sinc(turned / (2.0 * np.pi))
    patterns = np.zeros((2, len(angle), 3))
    patterns[0, :, j], patterns[0, :, k] = left * np.cos(middle), -left * np.sin(middle)
    patterns[1, :, j], patterns[1, :, k] = left * np.sin(middle), left * np.cos(middle)
    across = patterns
    if plan.attitude is None or plan.latitude is None:
        size = OMEGA * ROOT_THIRD
        return np.zeros_like(along), {_direction(axis): size * np.stack([along, *across])}
    rate = _along_table_axis(plan, plan.attitude, plan.latitude)
    sources = {_of_table(one.source): (float(one.u[0]) * along)[None] for one in rate.components if one.u[0] > 0.0}
    sources[_phase(axis)] = _across_axis(rate) * ROOT_HALF * across
    return float(rate.values[0]) * along, sources


def earth_influences(plan: Plan, axis: str) -> Mapping[str, Influence]:
    """Return what each source of `earth_in_dwells` rests on, by its name.

    An angle where the plan or a standard states its uncertainty; else the component of earth rate itself: that of a
    vector in any direction is rectangular, that of one at any angle about the table axis has an arcsine distribution.
    """
    return _influences(plan.attitude, plan.latitude, plan.standards.get("site.latitude"), axis)


@lru_cache(maxsize=64)  # of all units of a lot the same
def _influences(
    attitude: Attitude | None, latitude: float | None, known: Influence | None, axis: str
) -> Mapping[str, Influence]:
    if attitude is None or latitude is None:
        return {_direction(axis): Influence(OMEGA * ROOT_THIRD, "rad/s", distribution="rectangular")}
    rate = _along(attitude, latitude, 0.0 if known is None else known.u)
    angles = {
        "latitude": known or Influence(0.0, "rad"),
        "tilt": Influence(attitude.u, "rad"),
        "azimuth": Influence(attitude.u_azimuth, "rad"),
    }
    found = {
        _of_table(one.source): angles.get(
            one.source, Influence(float(one.u[0]), "rad/s", distribution=one.distribution)
        )
        for one in rate.components
    }
    found[_phase(axis)] = Influence(_across_axis(rate) * ROOT_HALF, "rad/s", distribution="arcsine")
    return found


def _direction(axis: str) -> str:
    return f"direction unknown, {axis} turned"


def _of_table(source: str) -> str:
    return f"{source} of the table"


def _phase(axis: str) -> str:
    return f"phase of the table, {axis} turned"


def _across_axis(rate: Estimate) -> float:
    """Earth rate across the table axis, from that along it [rad/s]."""
    return float(np.sqrt(max(OMEGA**2 - float(rate.values[0]) ** 2, 0.0)))


def _along_table_axis(plan: Plan, attitude: Attitude, latitude: float) -> Estimate:
    known = plan.standards.get("site.latitude")
    return _along(attitude, latitude, 0.0 if known is None else known.u)


@lru_cache(maxsize=64)
def _along(attitude: Attitude, latitude: float, u_latitude: float) -> Estimate:
    return axis_earth_rate(
        latitude,
        attitude.tilt,
        attitude.azimuth,
        u_latitude=u_latitude,
        u_tilt=attitude.u,
        u_azimuth=attitude.u_azimuth,
    )


def gathered(parts: list[tuple[Array, dict[str, Array]]]) -> tuple[Array, dict[str, Array]]:
    """Return the earth rates of several recordings as one; a source of the same name is the same unknown."""
    names = list(dict.fromkeys(name for _, sources in parts for name in sources))
    lengths = [len(earth) for earth, _ in parts]
    joined = {}
    for name in names:
        sizes = {len(sources[name]) for _, sources in parts if name in sources}
        columns = [
            sources[name] if name in sources else np.zeros((max(sizes), n, 3))
            for (_, sources), n in zip(parts, lengths, strict=True)
        ]
        joined[name] = np.concatenate(columns, axis=1)
    return np.concatenate([earth for earth, _ in parts]), joined


def with_earth(plan: Plan, readings: Readings) -> Readings:
    """Return the dwells of a reduced table with the earth rate in them; the angle turned is not known there.

    With a zero reference the component along the axis was subtracted with the reading at rest.
    """
    known = plan.standards.get("site.latitude")
    u_latitude = 0.0 if known is None else known.u
    earth, sources = _of_table_dwells(plan.attitude, plan.latitude, u_latitude, plan.zero_reference, readings.axis)
    return readings.changed(earth=earth, earth_sources=sources)


@remembered
def _of_table_dwells(
    attitude: Attitude | None, latitude: float | None, u_latitude: float, zero_reference: bool, about: Labels
) -> tuple[Array, dict[str, Array]]:
    plan = Plan(attitude=attitude, latitude=latitude, standards={"site.latitude": Influence(u_latitude, "rad")})
    parts: list[tuple[Array, dict[str, Array]]] = []
    order = []
    for axis in np.unique(about):
        at = np.flatnonzero(about == axis)
        unknown = np.full(len(at), np.nan)
        one, found = earth_in_dwells(plan, str(axis), unknown, unknown)
        if zero_reference:
            one, found = np.zeros_like(one), {name: _across_only(p, str(axis)) for name, p in found.items()}
        parts.append((one, found))
        order.append(at)
    earth, sources = gathered(parts)
    back = np.argsort(np.concatenate(order), kind="stable")
    return earth[back], {name: p[:, back] for name, p in sources.items()}


def _across_only(patterns: Array, axis: str) -> Array:
    left = patterns.copy()
    left[:, :, AXES.index(axis)] = 0.0
    return left
