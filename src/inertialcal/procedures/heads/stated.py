"""What the file of a body states, as sources of uncertainty of the figures: Type B.

Each unknown (an angle, a component of a place, of a bias) moves the levels of all heads at once; how is a row of
changes, so that heads which share calibrated ones share their errors.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...core.estimate import Array, Component
from ...core.key import AXES, Origin
from .found import (
    SCALE,
    TURN,
    Calibrated,
    keys_of,
    known_heads,
    mean_acceleration,
    motion_size,
)

if TYPE_CHECKING:
    from .reduction import Result

Change = tuple[str, Array]  # source, and rows of changes of all values


def stated(result: Result, heads: Sequence[Calibrated]) -> list[Component]:
    """Return the sources, each with the changes of all values by its unknowns."""
    found: dict[str, list[Array]] = {}
    for name, rows in (*_of_calibrated(result, heads), *_of_own(result, heads), *_of_slopes(result, heads)):
        found.setdefault(name, []).append(rows)
    parts = []
    for name, each in found.items():
        wide = np.vstack(each)
        wide = wide[np.any(wide != 0.0, axis=1)]
        if len(wide):
            parts.append(Component(Origin(name), "B", wide.T @ wide))
    return parts


def root(covariance: Array) -> Array:
    """Return rows of changes with this covariance: (unknown, axis)."""
    values, vectors = np.linalg.eigh(0.5 * (covariance + covariance.T))
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0.0))).T)


def _onto(result: Result, heads: Sequence[Calibrated], levels: Sequence[Array], biases_only: bool = False) -> Array:
    """Return rows for all values from changes of the level of each head, (unknown, axis) each."""
    lengths = [len(keys_of(result, one)) for one in heads]
    wide = np.zeros((levels[0].shape[0], sum(lengths)))
    first = 0
    for level, length in zip(levels, lengths, strict=True):
        if not biases_only:
            wide[:, first : first + 3] = level
        if result.absolute:
            wide[:, first + 3 : first + 6] = level
        first += length
    return wide


def _sizes(result: Result) -> tuple[Array, Array, Array]:
    """Return what a small rotation, a scale factor and a displacement of unit size do: covariances, in the body."""
    mean, bound = mean_acceleration(result)
    size = np.outer(mean, mean) + bound**2 / 3.0 * np.eye(3)
    gamma, unknown = motion_size(result)
    return (np.trace(size) * np.eye(3) - size, size * np.eye(3), gamma @ gamma.T + 2.0 * unknown**2 * np.eye(3))


def _change(result: Result) -> Array:
    """Return by how much the acceleration changes a second, over the record, shape (1, 3)."""
    first = result.means[known_heads(result.readings)[0]]
    return np.asarray((first[-1] - first[0])[None, :] / max(float(np.ptp(result.times)), result.interval))


def _of_calibrated(result: Result, heads: Sequence[Calibrated]) -> Iterator[Change]:
    tracks = result.readings.tracks
    turned, scaled, displaced = _sizes(result)
    for place, i in enumerate(known_heads(result.readings)):
        mounted = tracks[i].mounted
        own = [float(one.weights.weights[place]) * tracks[one.number - 1].mounted.orientation for one in heads]
        to_own = [one @ mounted.orientation.T for one in own]
        if result.absolute:
            for name, covariance in (
                ("biases of the calibrated heads", mounted.bias_covariance),
                ("drift of the calibrated heads since", mounted.drift_u**2 * np.eye(3)),
            ):
                yield name, _onto(result, heads, [root(covariance) @ one.T for one in to_own], biases_only=True)
        felt = [np.zeros((3, 3)) if one.carried.all() else turn.T for one, turn in zip(heads, own, strict=True)]
        tilts = root(turned) * mounted.orientation_u
        yield "orientations", _onto(result, heads, [tilts @ one for one in felt])
        yield "scale factors", _onto(result, heads, [root(scaled) * mounted.scale_factor_u @ one for one in felt])
        moves = root(displaced) * mounted.position_u
        yield "positions", _onto(result, heads, [moves @ one.T for one in own])
        yield "clocks", _onto(result, heads, [_change(result) * mounted.clock_u @ one.T for one in own])


def _alone(result: Result, heads: Sequence[Calibrated], at: int, rows: Array) -> Array:
    return _onto(result, heads, [rows if k == at else np.zeros_like(rows) for k in range(len(heads))])


def _of_own(result: Result, heads: Sequence[Calibrated]) -> Iterator[Change]:
    turned, scaled, displaced = _sizes(result)
    for at, one in enumerate(heads):
        mounted = result.readings.tracks[one.number - 1].mounted
        turn = mounted.orientation.T
        if not one.carried.all():
            yield "orientations", _alone(result, heads, at, root(turned) * mounted.orientation_u @ turn)
            yield "scale factors", _alone(result, heads, at, root(scaled) * mounted.scale_factor_u @ turn)
        yield "positions", _alone(result, heads, at, root(displaced) * mounted.position_u @ turn)
        yield "clocks", _alone(result, heads, at, _change(result) * mounted.clock_u @ turn)
        yield "motion off the line", _alone(result, heads, at, root(result.off_line[one.name]) @ turn)


def _of_slopes(result: Result, heads: Sequence[Calibrated]) -> Iterator[Change]:
    """Yield what makes slopes too small: noise of the heads that they are over, and clocks."""
    first = 0
    for at, one in enumerate(heads):
        keys = keys_of(result, one)
        named = {(key.quantity, key.axis): first + j for j, key in enumerate(keys)}
        first += len(keys)
        for k in np.flatnonzero(one.carried).tolist():
            for name, sizes in (("noise of the calibrated heads", one.slopes_noise), ("clocks", one.slopes_late)):
                by = (one.slopes[:, k] + np.eye(3)[k]) * sizes[k]
                row = _alone(result, heads, at, (-by * float(one.told_by_others[:, k].mean()))[None, :])
                for a in range(3):
                    row[0, named[(SCALE, AXES[k]) if a == k else (TURN, f"{AXES[a]}{AXES[k]}")]] = by[a]
                yield name, row
