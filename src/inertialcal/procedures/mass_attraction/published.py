"""The reduction of 1969, as published: amplitudes less the mean amplitude beside them, of all runs together.

The amplitudes G and B of the line, from the spectrum and from the Fourier series, lose the mean amplitudes GR and CR
of the eight lines beside them::

    GO = G - GR        BO = B - CR        SC = mean of all GO and BO / amplitude applied

The report takes the mean of all GO and BO, twice their standard deviation as its uncertainty, and rounds both to the
one digit of the uncertainty. Noise does not add to a line in phase as it does to an amplitude without one: what is
subtracted is a bias, about a tenth of the amplitude. It stands here to be compared, with ``condition =
"as_published"``.

References
----------
.. [1] K. Reinel, NASA TM X-53857, 1969, Table 4 and Appendix A.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...core.key import Key, Method, Reason
from ...core.results import Row, not_estimated
from ...statistics.intervals import t_interval
from .readings import Line

if TYPE_CHECKING:
    from .reduction import Result

UNIT = "count/s/(m/s^2)"
FEWEST = 2  # values that a standard deviation needs
STEP = 0.01  # unit in which the report has its amplitudes [count/s]


@dataclass(frozen=True)
class Published:
    """Mean response of runs as the report has it.

    Parameters
    ----------
    response, u : float
        Mean of GO and BO, and twice their standard deviation [count/s].
    rounded, u_rounded : float
        Both to the one digit of the uncertainty [count/s].
    scale_factor, u_scale_factor : float
        From the rounded values [count/s/(m/s^2)].
    values : int
        Of which the mean is.
    """

    response: float
    u: float
    rounded: float
    u_rounded: float
    scale_factor: float
    u_scale_factor: float
    values: int


def less_noise(line: Line) -> tuple[float, float]:
    """Return GO and BO of a run [count/s]."""
    return line.psd_response - line.psd_noise, line.response - line.noise


def published(lines: Sequence[Line]) -> Published | None:
    """Return the mean response of runs with the mass moved; None where there is too little.

    Parameters
    ----------
    lines : sequence of Line
        Runs, those that the report takes.
    """
    moved = [line for line in lines if line.moved]
    values = np.array([value for line in moved for value in less_noise(line) if math.isfinite(value)])
    if len(values) < FEWEST or not np.ptp(values) > 0.0:
        return None
    mean, u = float(values.mean()), 2.0 * float(values.std(ddof=1))
    step = 10.0 ** math.floor(math.log10(u / STEP)) * STEP
    rounded, u_rounded = (round(value / step) * step for value in (mean, u))
    applied = float(np.mean([line.applied for line in moved]))
    u_applied = float(np.mean([line.u_applied for line in moved]))
    scale = rounded / applied
    u_scale = math.hypot(u_rounded / applied, scale * u_applied)
    return Published(mean, u, rounded, u_rounded, scale, u_scale, len(values))


def published_rows(result: Result) -> Iterator[Row]:
    """Yield the scale factor in the published way, or the reason why there is none."""
    axis = result.plan.axis
    lines, why = result.published
    found = published(lines)
    if found is None:
        reason = why or "too few runs for a standard deviation"
        yield not_estimated(Key("scale_factor", axis), UNIT, Reason("few_runs", reason), Method.TEXTBOOK)
        return
    reason = (
        f"mean of {found.values} amplitudes less the mean amplitude beside them, {found.response:.4g} count/s, rounded"
        f" to {found.rounded:.4g} +- {found.u_rounded:.4g}; subtracting takes too much off"
    )
    interval = t_interval(found.scale_factor, found.u_scale_factor, math.inf)
    yield Row(Key("scale_factor", axis), found.scale_factor, found.u_scale_factor, UNIT, None, interval,
              reason=Reason("limits", reason), method=Method.TEXTBOOK)  # fmt: skip
