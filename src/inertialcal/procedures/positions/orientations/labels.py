"""Names of positions against what the accelerometers read there, and sections of a protocol against one another.

At rest the specific force points up: in a position that is named ``x+`` the accelerometer of x reads plus g. Names that
are exchanged are not seen in a fit, which is linear in them: they come out as scale factors and misalignments that are
none. So the direction that is read is compared with the one that is named, before anything is fitted.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Protocol

import numpy as np

from ....core.axes import AXES
from ....core.errors import DataError
from ....core.estimate import Array
from ....core.remarks import Remark
from ..readings import Readings

LEAST = 0.5  # cosine of the angle between the direction that is named and the one that is read, misalignment and all
NEAR_ZERO = 0.2  # of the span of an axis, below which the middle of its readings is a bias and not a zero
SPANNED = 0.5  # of the widest span, from which an axis has been turned enough to tell its middle
ON_FACE = 0.99  # cosine
LISTED = 3


class Named(Protocol):
    """A part of a recording with its name."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def start(self) -> int: ...  # noqa: D102
    @property
    def stop(self) -> int: ...  # noqa: D102


def pointing(mean: Array) -> Array:
    """Return the direction that each position reads, unit vectors, shape (m, 3).

    Parameters
    ----------
    mean : ndarray, shape (m, 3)
        Readings at rest, of any unit and zero.
    """
    middle = 0.5 * (mean.max(axis=0) + mean.min(axis=0))
    near_zero = np.abs(middle) < NEAR_ZERO * np.ptp(mean, axis=0)
    x = mean - np.where(near_zero, 0.0, middle)
    return np.asarray(x / np.linalg.norm(x, axis=1)[:, None])


def check_names(readings: Readings) -> None:
    """Refuse positions that are named by one direction and read another.

    Raises
    ------
    DataError
        ``position_misnamed``.
    """
    span = np.ptp(readings.acc.mean, axis=0) if len(readings) else np.zeros(3)
    if readings.direction is None or span.min() < SPANNED * span.max() or span.max() == 0.0:
        return
    read = pointing(readings.acc.mean)
    along = np.sum(read * readings.direction, axis=1)
    wrong = np.flatnonzero(along < LEAST)  # NaN where a direction is not known
    if not len(wrong):
        return
    named = [
        f"{readings.place(int(k))} is named {_word(readings.direction[k])} and reads {_word(read[k])}"
        for k in wrong[:LISTED]
    ]
    more = f"; and {len(wrong) - LISTED} more" if len(wrong) > LISTED else ""
    known = int(np.isfinite(along).sum())
    opposite = len(wrong) == known and bool(np.all(along[wrong] < -LEAST))
    do = (
        "All read the opposite: turn the signs of the accelerometers, or name the positions by the axis that points up"
        if opposite
        else "Correct the names, or columns and signs of the accelerometers"
    )
    raise DataError(
        f"{len(wrong)} of {known} positions do not lie as they are named: {'; '.join(named)}{more}",
        why="with x+ the x axis points up, and its accelerometer reads plus g",
        do=do,
        code="position_misnamed",
    )


def _word(direction: Array) -> str:
    """Return a direction in words: ``x+`` where it is near an axis, else its components."""
    k = int(np.argmax(np.abs(direction)))
    if abs(direction[k]) > 1.0 - LEAST / 2.0:
        return f"{AXES[k]}{'+' if direction[k] > 0.0 else '-'}"
    return f"({', '.join(f'{one:.2f}' for one in direction)})"


def missing_faces(readings: Readings) -> list[Remark]:
    """Say which of the six faces is missing, where all positions are known and lie on faces."""
    d = readings.direction
    if d is None or not np.isfinite(d).all() or not np.all(np.abs(d).max(axis=1) > ON_FACE):
        return []
    there = {_word(one) for one in d}
    missing = [f"{axis}{sign}" for axis in AXES for sign in "+-" if f"{axis}{sign}" not in there]
    if not missing or len(missing) > 3:
        return []
    axes = ", ".join(dict.fromkeys(one[0] for one in missing))
    what = (
        f"{len(there)} of the six faces: {', '.join(missing)} missing: bias and scale factor of {axes} rest on the "
        "other faces, and the closed form of six faces cannot be had"
    )
    return [Remark("face_missing", "warning", what, do="Lay the unit on each face, up and down")]


def check_sections(sections: Sequence[Named], samples: int, where: str) -> None:
    """Refuse sections of one kind that are not in the recording, or not apart.

    Parameters
    ----------
    sections : sequence of Named
        Positions, or turns.
    samples : int
        Of the recording.
    where : str
        Its file.

    Raises
    ------
    DataError
        ``wrong_section``.
    """
    for one in sections:
        if not 0 <= one.start < one.stop <= samples or one.stop - one.start < 2:
            what = f"section {one.name or 'without name'}: samples {one.start} to {one.stop}, of {samples}"
            why = "the protocol is of another recording, or counts at another rate"
            do = "Count samples from 0, the end not among them, or give times with their unit"
            raise DataError(what, where, why, do, "wrong_section")
    for one, other in pairwise(sorted(sections, key=lambda each: each.start)):
        if other.start < one.stop:
            what = (
                f"sections {one.name} (samples {one.start} to {one.stop}) and {other.name} ({other.start} to "
                f"{other.stop}) overlap"
            )
            raise DataError(what, where, "the same samples would count twice", "Part them", "wrong_section")
