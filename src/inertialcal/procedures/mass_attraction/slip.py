"""Slip of the schedule: the mass came a dwell late or early from some dwell on."""

from __future__ import annotations

import numpy as np

from ...core.estimate import Array
from ...physics.motion.schedule import Schedule
from .line import NONE, line_design, shape_of

SLIP = 25.0  # gain of squared signal over noise that proves a slip of the schedule


def fits_better_late(schedule: Schedule, x: Array) -> tuple[float, int]:
    """Return how much better a late or early mass explains a series, and from which dwell on.

    For each dwell k, the drive is as planned before k, and one dwell late or early from k on.

    Parameters
    ----------
    schedule : Schedule
        As planned, n dwells.
    x : ndarray, shape (n,)
        Readings; NaN for a gap.

    Returns
    -------
    (float, int)
        Largest gain of the squared signal over noise, with the residuals of the better schedule as noise; the dwell,
        counted from 0.
    """
    there = np.isfinite(x)
    design = line_design(schedule, there, None)
    drift = np.concatenate([part[design.line :] for _, part in design.parts(design.main)], axis=1)
    slow = np.asarray(np.linalg.qr(drift.T)[0])  # orthonormal columns of the drift
    s, at = shape_of(schedule), np.arange(len(schedule))
    late, early = np.concatenate([s[:1], s[:-1]]), np.concatenate([s[1:], s[-1:]])
    moved = [np.where(at[:, None] < at[None, :], s[:, None], other[:, None]) for other in (late, early)]
    tried = np.column_stack([s, *moved])[there]
    y = x[there] - slow @ (slow.T @ x[there])
    alone = tried - slow @ (slow.T @ tried)
    power = np.einsum("ij,ij->j", alone, alone)
    response = alone.T @ y
    response[1:] = np.maximum(response[1:], 0.0)  # a response of the other sign is not a slip
    explained = np.where(power > NONE, response**2 / np.maximum(power, NONE), 0.0)
    best = int(np.argmax(explained))
    noise = (y @ y - explained[best]) / max(len(y) - slow.shape[1] - 1, 1)
    gain = explained[best] - explained[0]
    return float(gain / noise) if gain > NONE * (y @ y) else 0.0, int((best - 1) % len(s)) if best else 0
