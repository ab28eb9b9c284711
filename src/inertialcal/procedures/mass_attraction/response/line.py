"""The line of a moved mass in a drifting series, by ``signals.sine``, and whether another schedule explains it better.

The drive is what the schedule applies, about its middle and over its amplitude, so that the line is in the unit of the
readings. A dwell without a reading has no row; nothing is closed up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....core.errors import DataError
from ....core.estimate import Array
from ....physics.motion.schedule import Schedule
from ....signals.sine.drive import applied_drive
from ....signals.sine.fit import Design, LineFit, design_of
from ....signals.sine.fit import fit_line as fit_drive

NONE = 1e-9  # of a length, below which it is nothing
FEWEST = 12  # readings


@dataclass(frozen=True, eq=False)
class Fitted:
    """A line.

    Parameters
    ----------
    amplitude, u : float
        In phase with the drive, and its standard uncertainty [unit of the readings].
    quadrature, u_quadrature : float
        A quarter of a cycle ahead of the drive, and its standard uncertainty; NaN where the drive has none.
    dof : float
        Degrees of freedom of both.
    drift, line : ndarray, shape (n,)
        What was taken as drift, and as the line; NaN where there is no reading.
    frequencies : ndarray, shape (m,)
        Of the drive, then of its side bands [Hz].
    """

    amplitude: float
    u: float
    quadrature: float
    u_quadrature: float
    dof: float
    drift: Array
    line: Array
    frequencies: Array


def shape_of(schedule: Schedule) -> Array:
    """Return what is applied, about its middle, over its amplitude, shape (n,)."""
    middle = 0.5 * (schedule.applied.max() + schedule.applied.min())
    return np.asarray((schedule.applied - middle) / schedule.amplitude)


def fit_lines(schedule: Schedule, series: Array, side_bands: int | None = None) -> tuple[LineFit, NDArray[np.bool_]]:
    """Return the line of the drive in series of the same dwells, and which dwells are in it.

    Parameters
    ----------
    schedule : Schedule
        n dwells.
    series : ndarray, shape (n,) or (n, k)
        Readings; a row with a NaN is left out.
    side_bands : int, optional
        On each side, from which the noise is read; as ``signals.sine`` chooses by default.

    Raises
    ------
    DataError
        ``too_short`` if there are too few readings; as ``signals.sine``.
    """
    there: NDArray[np.bool_] = np.asarray(np.isfinite(series.reshape(len(series), -1)).all(axis=1))
    if there.sum() < FEWEST:
        what = f"{int(there.sum())} of {len(series)} dwells have a reading: a line needs {FEWEST} or more"
        raise DataError(what, do="Measure longer", code="too_short")
    return fit_drive(_design(schedule, there, side_bands), series[there]), there


def _design(schedule: Schedule, there: NDArray[np.bool_], side_bands: int | None) -> Design:
    drive = applied_drive(schedule.middle[there], shape_of(schedule)[there], schedule.frequency)
    return design_of(drive, side_bands=side_bands)


def fit_line(schedule: Schedule, x: Array, side_bands: int | None = None) -> Fitted:
    """Return the line of the drive in one series, shape (n,); errors as `fit_lines`."""
    found, there = fit_lines(schedule, x, side_bands)
    line, drift = (_spread(part, there) for part in found.fitted())
    quadrature = np.nan if found.quadrature is None else float(found.quadrature[0])
    u_quadrature = np.nan if found.u_quadrature is None else float(found.u_quadrature[0])
    drive, steps = found.design.drive, np.arange(1, found.design.side_bands + 1)
    beside = np.abs(drive.frequency + np.concatenate([-steps, steps]) / drive.span)
    frequencies = np.concatenate([[drive.frequency], np.unique(beside[beside <= 0.5 / drive.step * (1.0 + NONE)])])
    return Fitted(
        float(found.in_phase[0]), float(found.u_in_phase[0]), quadrature, u_quadrature, found.dof, drift, line,
        frequencies,
    )  # fmt: skip


def fits_better_late(schedule: Schedule, x: Array) -> tuple[float, int]:
    """Return how much better a late mass explains a series, and the dwell from which it would be late.

    For each dwell k, the drive is taken as planned before k and one dwell late from it on, or one dwell early.

    Parameters
    ----------
    schedule : Schedule
        As planned, n dwells.
    x : ndarray, shape (n,)
        Readings; NaN where there is none.

    Returns
    -------
    (float, int)
        Largest gain of the squared signal over noise, the noise being what the better schedule leaves; the dwell,
        counted from 0.
    """
    there = np.isfinite(x)
    slow = _slow(_design(schedule, there, None))
    s, at = shape_of(schedule), np.arange(len(schedule))
    late, early = np.concatenate([s[:1], s[:-1]]), np.concatenate([s[1:], s[-1:]])
    moved = [np.where(at[:, None] < at[None, :], s[:, None], other[:, None]) for other in (late, early)]
    tried = np.column_stack([s, *moved])[there]
    y = x[there] - slow @ (slow.T @ x[there])
    alone = tried - slow @ (slow.T @ tried)
    power = np.einsum("ij,ij->j", alone, alone)
    response = alone.T @ y
    response[1:] = np.maximum(response[1:], 0.0)  # a response of the other sign is no slip
    explained = np.where(power > NONE, response**2 / np.maximum(power, NONE), 0.0)
    best = int(np.argmax(explained))
    noise = (y @ y - explained[best]) / max(len(y) - slow.shape[1] - 1, 1)
    gain = explained[best] - explained[0]
    return float(gain / noise) if gain > NONE * (y @ y) else 0.0, int((best - 1) % len(s)) if best else 0


def _slow(design: Design) -> Array:
    """Return orthonormal columns of the drift, shape (m, rows + 1)."""
    columns = np.concatenate([part[design.line :] for _, part in design.parts(design.main)], axis=1)
    return np.asarray(np.linalg.qr(columns.T)[0])


def _spread(values: Array, there: NDArray[np.bool_]) -> Array:
    whole = np.full(len(there), np.nan)
    whole[there] = values
    return whole
