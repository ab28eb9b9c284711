"""Line of the drive in the readings of one run, by ``signals.sine``, in the unit of the readings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.estimate import Array
from ...physics.motion.schedule import Schedule
from ...signals.sine.drive import applied_drive
from ...signals.sine.fit import Design, LineFit, design_of
from ...signals.sine.fit import fit_line as fit_drive

NONE = 1e-9  # of a length: smaller is zero


FEWEST = 12  # readings
BESIDE = 4  # lines on each side of the drive, that are shown


@dataclass(frozen=True, eq=False)
class Fitted:
    """Line of a drive."""

    amplitude: float  # In phase with the drive [unit of the readings]
    u: float  # Its standard uncertainty [unit of the readings]
    quadrature: float  # A quarter of a cycle ahead of the drive; NaN if the drive has none
    u_quadrature: float  # Its standard uncertainty
    dof: float  # Degrees of freedom of both
    drift: Array  # shape (n,): NaN for a gap
    line: Array  # shape (n,): NaN for a gap
    frequencies: Array  # shape (m,): of the drive, then of the lines next to it [Hz]
    found: LineFit  # The fit itself


def shape_of(schedule: Schedule) -> Array:
    """Return what is applied, about its middle, over its amplitude, shape (n,)."""
    middle = 0.5 * (schedule.applied.max() + schedule.applied.min())
    return np.asarray((schedule.applied - middle) / schedule.amplitude)


def start_phase(schedule: Schedule) -> float:
    """Return the phase of the drive at its first dwell, by its first harmonic [rad]: pi apart if it is reversed."""
    angle = 2.0 * np.pi * schedule.frequency * (schedule.middle - schedule.middle[0])
    columns = np.column_stack([np.sin(angle), np.cos(angle), np.ones(len(angle))])
    a, b, _ = np.linalg.lstsq(columns, shape_of(schedule), rcond=None)[0]
    return float(np.arctan2(b, a))


def line_design(schedule: Schedule, there: NDArray[np.bool_]) -> Design:
    """Return the line and drift that are fitted to the dwells with a reading.

    Raises
    ------
    DataError
        ``too_short`` if there are too few readings; as ``signals.sine``.
    """
    if there.sum() < FEWEST:
        what = f"{int(there.sum())} of {len(there)} dwells have a reading: a line needs at least {FEWEST}"
        raise DataError(what, do="Measure longer", code="too_short")
    return design_of(applied_drive(schedule.middle[there], shape_of(schedule)[there], schedule.frequency))


def fit_series(schedule: Schedule, x: Array) -> LineFit:
    """Return the line of the drive in one series, shape (n,), NaN for a gap; errors as `line_design`."""
    there = np.isfinite(x)
    return fit_drive(line_design(schedule, there), x[there])


def fitted_line(found: LineFit, there: NDArray[np.bool_]) -> Fitted:
    """Return the line of a series, whose readings are at the dwells of a mask, shape (n,)."""
    line, drift = np.full((2, len(there)), np.nan)
    line[there], drift[there] = found.fitted()
    quadrature = np.nan if found.quadrature is None else float(found.quadrature[0])
    u_quadrature = np.nan if found.u_quadrature is None else float(found.u_quadrature[0])
    drive = found.design.drive
    lines = drive.frequency + np.arange(-BESIDE, BESIDE + 1) / drive.span
    near = lines[(np.arange(-BESIDE, BESIDE + 1) != 0) & (lines <= 0.5 / drive.step * (1.0 + NONE)) & (lines > 0.0)]
    return Fitted(
        float(found.in_phase[0]), float(found.u_in_phase[0]), quadrature, u_quadrature, float(found.dof[0]), drift,
        line, np.concatenate([[drive.frequency], near]), found,
    )  # fmt: skip


def fit_line(schedule: Schedule, x: Array) -> Fitted:
    """Return the line of the drive in one series, shape (n,), NaN for a gap; errors as `line_design`."""
    return fitted_line(fit_series(schedule, x), np.isfinite(x))
