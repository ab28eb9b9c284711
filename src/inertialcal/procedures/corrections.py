"""Readings after earlier tests: what these found is taken off, and what is not known of it goes on into the figures.

A correction is taken off sample by sample. Its unknowns are common to all recordings of a test, and to every other test
that it was taken off (equal origins): they are no scatter, and more readings do not average them. A figure that is
linear in mean readings changes with them by its gain. The uncertainty of the correction so enters once, by these
unknowns, and what a constant does not change (a difference of readings, a scale factor) does not follow it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..core.errors import DataError
from ..core.estimate import Array, Component
from ..core.key import AXES, Key, Origin
from ..core.recording import SECOND, Recording
from ..core.unknowns import Unknowns
from .protocol import Correction

TakenOff = Mapping[Origin, Unknowns]  # by origin, a dwell a recording


def corrected(
    corrections: Sequence[Correction], named: Sequence[tuple[str, Recording]]
) -> tuple[list[Recording], list[TakenOff]]:
    """Return recordings after corrections, and the unknowns of what was taken off each.

    Parameters
    ----------
    corrections : sequence of Correction
        Each is taken off the recordings in its unit.
    named : sequence of (str, Recording)
        Each with its name: channels named by axis [SI], and what the corrections depend on.

    Raises
    ------
    DataError
        ``another_sensor`` if no recording is of the sensor of a correction; as the corrections say.
    """
    recordings: list[Recording] = [one for _, one in named]
    taken_off: list[dict[Origin, Unknowns]] = [{} for _ in named]
    for correction in corrections:
        own = [k for k, one in enumerate(recordings) if _unit(one) == correction.unit]
        if not own:
            units = ", ".join(dict.fromkeys(_unit(one) for one in recordings))
            what = f"after = {correction.test!r}, which found something in {correction.unit}; readings are in {units}"
            raise DataError(what, recordings[0].source.path, do="Leave out after", code="another_sensor")
        made, unknowns = correction.apply([(named[k][0], recordings[k]) for k in own])
        for k, recording, unknown in zip(own, made, unknowns, strict=True):
            recordings[k] = recording
            taken_off[k] |= unknown
    return recordings, list(taken_off)


def _unit(recording: Recording) -> str:
    return next((one.unit or "" for one in recording.channels if one.name in AXES), "")


def between(recording: Recording, start: int, stop: int) -> Recording:
    """Return the samples of a recording from one stamp to another, both included [ns]; without stamps, since its start.

    Parameters
    ----------
    recording : Recording
        With stamps, or a sample interval.
    start, stop : int
        [ns]
    """
    times = recording.time_ns
    if times is None:
        times = np.round(np.arange(len(recording)) * (recording.sample_interval or 1.0) * SECOND).astype(np.int64)
    keep = (times >= start) & (times <= stop)
    channels = tuple(replace(one, data=one.data[keep]) for one in recording.channels)
    return replace(recording, channels=channels, time_ns=times[keep])


def components(taken_off: TakenOff, keys: Sequence[Key], gain: Array) -> list[Component]:
    """Return what the unknowns of corrections change in figures that are linear in mean readings.

    Parameters
    ----------
    taken_off : mapping of Origin to Unknowns
        Of n dwells.
    keys : sequence of Key
        Of the figures.
    gain : ndarray, shape (k, n, 3)
        Figures per mean reading of x, y and z in each dwell.
    """
    found = []
    for origin, off in taken_off.items():
        changes = moved(off, gain)
        if np.any(changes):
            covariance = changes.T @ changes
            covariance = 0.5 * (covariance + covariance.T)
            dof = dof_of(off, gain)
            found.append(Component(origin, off.kind, covariance, dof, off.distribution, off.stated, changes,
                                   off.unknowns))  # fmt: skip
    return found


def moved(off: Unknowns, gain: Array) -> Array:
    """Return what each unknown changes in figures of a gain (k, n, 3) per mean reading, shape (s, k)."""
    return np.asarray(-np.einsum("sna,kna->sk", off.changes, gain))


def dof_of(off: Unknowns, gain: Array) -> Array:
    """Return the degrees of freedom of each figure, shape (k,): the fewest of the sensors that it rests on."""
    used = np.any(gain != 0.0, axis=1) & np.any(off.changes != 0.0, axis=(0, 1))
    return np.asarray(np.where(used, off.dof, np.inf).min(axis=1, initial=np.inf))
