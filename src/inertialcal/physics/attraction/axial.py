"""Coordinates about an axis: distance outward, height along, and vectors and gradients put together from them."""

from __future__ import annotations

import math

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array

Direction = tuple[float, float, float]


def about_axis(points: Array, centre: Direction, axis: Direction) -> tuple[Array, Array, Array, Array]:
    """Return distances from an axis (n,), heights over a centre (n,) [m], and the directions of both (n, 3).

    On the axis itself any direction outward is as good as another.
    """
    along = np.array(axis) / math.hypot(*axis)
    away = points - np.array(centre)
    z = away @ along
    flat = away - z[:, None] * along
    r = np.linalg.norm(flat, axis=1)
    aside = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    aside /= np.linalg.norm(aside)
    out = np.where((r > 0.0)[:, None], flat / np.where(r > 0.0, r, 1.0)[:, None], aside)
    return r, z, out, np.broadcast_to(along, out.shape)


def symmetric_gradient(parts: Array, out: Array, along: Array) -> Array:
    """Return gradients (n, 3, 3) from radial, tangential, axial and mixed ones, shape (4, n)."""
    g_rr, g_tt, g_zz, g_rz = parts
    across = np.cross(along, out)
    found = [
        part[:, None, None] * one[:, :, None] * other[:, None, :]
        for part, one, other in (
            (g_rr, out, out), (g_tt, across, across), (g_zz, along, along), (g_rz, out, along), (g_rz, along, out),
        )
    ]  # fmt: skip
    return np.asarray(np.sum(found, axis=0))


def direction(axis: Direction) -> None:
    """Refuse an axis without direction.

    Raises
    ------
    DataError
        If its length is zero or not finite.
    """
    if not 0.0 < math.hypot(*axis) < math.inf:
        raise DataError(f"axis {axis} has no direction", code="no_direction")
