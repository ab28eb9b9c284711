"""Allan deviations of one record of one axis: the one that terms are fitted to, and the one that is shown."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.remarks import Remark
from ...signals.allan import Allan, allan
from ...signals.names import Deviation
from .plan import Plan
from .readings import Run

FITTED: Deviation = "overlapping"  # that the terms are fitted to
INTERVAL = 0.95  # of the deviations
UNITS = {"gyro": "rad/s", "accelerometer": "m/s^2"}


def fitted(plan: Plan, run: Run, axis: str, there: NDArray[np.bool_]) -> Allan:
    """Return the deviation at octaves that terms are fitted to [SI].

    Parameters
    ----------
    plan : Plan
        Whose kind of sensor says the unit.
    run : Run
        The record.
    axis : str
        Which.
    there : ndarray of bool, shape (n,)
        Where a sample is there, and is used.
    """
    return _allan(plan, run, axis, there, FITTED, "octave")


def shown(plan: Plan, run: Run, axis: str, there: NDArray[np.bool_]) -> tuple[Allan, tuple[Remark, ...]]:
    """Return the deviation that was asked for, at octaves where no averaging time that was asked for fits.

    Parameters
    ----------
    plan, run, axis, there
        As ``fitted`` takes them.
    """
    try:
        return _allan(plan, run, axis, there, plan.deviation, plan.seconds or plan.taus), ()
    except DataError as error:
        if not plan.seconds:
            raise
        what = f"{axis}: {error.problems[0].what}: octaves are shown"
    found = _allan(plan, run, axis, there, plan.deviation, "octave")
    return found, (Remark("taus_not_shown", "warning", what, do="Ask for shorter ones, or record longer"),)


def _allan(
    plan: Plan,
    run: Run,
    axis: str,
    there: NDArray[np.bool_],
    deviation: Deviation,
    taus: str | Sequence[float],
) -> Allan:
    """Return a deviation, from the samples in the type of the file: whole numbers are summed exactly."""
    return allan(
        run.values[axis],
        run.interval,
        quantity=run.quantity,
        deviation=deviation,
        taus=taus,
        averaging=run.averaging,
        scale=run.scale[axis],
        present=None if there.all() else there,
        p=INTERVAL,
        names=(axis,),
        unit=UNITS[plan.kind] if plan.kind else plan.unit,
    )
