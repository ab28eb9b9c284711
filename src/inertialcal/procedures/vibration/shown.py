"""What a run prints beside its table: how its spectrum was estimated."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ...core.show.rounding import freedom, number
from ...signals.vibration.deviation import NEPER

if TYPE_CHECKING:
    from .reduction import Result


def summary(result: Result) -> str:
    """Return lines, bandwidth, degrees of freedom and what chance does to a line, in one line."""
    one, spectra, count = result.deviation, result.spectra, len(result.readings.controls)
    dof = float(np.median(one.edf))
    what = "lines" if result.plan.octave is None else f"bands of 1/{result.plan.octave} octave"
    width = f"{number(spectra.spacing, 4)} Hz apart, bandwidth {number(spectra.enbw, 4)} Hz"
    of = f"{result.plan.average} of {count} channels" if count > 1 else "one control channel"
    return (
        f"{len(one)} {what} ({width}) of {of}, {spectra.segments} segments over {number(result.levels.duration, 4)} s"
        f" at full level, {freedom(dof, 3)}:"
        f" a line scatters by {number(NEPER * math.sqrt(2.0 / dof), 2)} dB"
    )


__all__ = ["summary"]
