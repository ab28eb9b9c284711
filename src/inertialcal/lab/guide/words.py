"""A turn in words that a person follows from how the sensor lies: what to turn it about, and what then points up.

Directions are what points up, in body axes. To bring ``then`` up where ``up`` is up the body turns about the vertical
plane of both: by the vector ``angle (then x up) / |then x up|``, right-handed, in body axes.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...core.estimate import Array
from ...core.key import AXES
from ...procedures.positions.planning.planner import in_words

ALONG = 0.94  # cosine of 20 deg: a turn about such a direction is one about the axis
OVER = np.radians(150.0)  # a turn by more is "over"
ROUND = 15.0  # degrees that an angle is told to: a hand meets it no better


def named(direction: Array, labels: Mapping[str, str]) -> str:
    """Return what points up: ``z up (label)``, ``between x up and z down``; ``labels``: ``x+`` ... -> what is there."""
    k = int(np.argmax(np.abs(direction)))
    words = in_words(direction)
    label = labels.get(f"{AXES[k]}{'+' if direction[k] > 0.0 else '-'}", "")
    if not label:
        opposite = labels.get(f"{AXES[k]}{'-' if direction[k] > 0.0 else '+'}", "")
        label = f"{opposite} down" if opposite else ""
    return f"{words} ({label})" if label and words.count(" ") == 1 else words


def lies(direction: Array) -> str:
    """Return how it lies then: flat on a face, on an edge or on a corner."""
    return ("flat", "on an edge, propped up", "on a corner, propped up")[int(np.sum(np.abs(direction) > EDGE)) - 1]


EDGE = 0.3  # component of a direction, below which its axis is level


def turn(up: Array, then: Array, labels: Mapping[str, str], sides: Mapping[str, str]) -> str:
    """Return a turn in words.

    Parameters
    ----------
    up, then : ndarray, shape (3,)
        What points up now, and what should, in body axes.
    labels : mapping of str to str
        What stands on a face: ``{"z+": "label"}``.
    sides : mapping of str to str
        How an axis is called: ``{"x": "its long side"}``; by default ``its x axis``.
    """
    a, b = up / np.linalg.norm(up), then / np.linalg.norm(then)
    angle = float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
    target = named(then, labels)
    if angle > OVER:  # any level axis will do: one with a name, or the most level one
        level = [k for k in range(3) if abs(a[k]) < EDGE]
        if not level:
            return f"Turn it upside down, so that it lies {lies(then)}: {target}"
        about = next((k for k in level if AXES[k] in sides), level[0])
        return f"Turn it over about {_side(about, sides)}, so that it lies {lies(then)}: {target}"
    across = np.cross(b, a)
    across = across / max(float(np.linalg.norm(across)), 1e-12)
    about = int(np.argmax(np.abs(across)))
    how = f"{max(ROUND, ROUND * round(float(np.degrees(angle)) / ROUND)):.0f} deg"
    if abs(across[about]) > ALONG:
        return f"Turn it by {how} about {_side(about, sides)}, so that it lies {lies(then)}: {target}"
    return f"Tilt it by {how}, so that it lies {lies(then)}: {target}"


def _side(axis: int, sides: Mapping[str, str]) -> str:
    return sides.get(AXES[axis], f"its {AXES[axis]} axis")
