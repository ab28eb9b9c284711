"""The reduction of 1969, as published, for comparison: amplitudes less the mean amplitude next to them, of all runs.

A run goes through the programme of [1]_: error readings closed up, moving mean subtracted, Fourier lines and spectrum.
The programme needs an even number of samples in whole cycles of four, beginning at the middle position. Closing up a
gap shifts the phase of everything that follows, and the moving mean removes 1.7 % of the line; both belong to this way.

The amplitudes G and B of the line, from the spectrum and from the Fourier series, lose the mean amplitudes GR and CR of
the eight lines next to them::

    GO = G - GR        BO = B - CR        SC = mean of all GO and BO / amplitude applied

The report takes twice the standard deviation of all GO and BO as the uncertainty of their mean, and rounds both to the
one digit of the uncertainty. Noise does not add to a line in phase as it does to an amplitude without one: the
subtraction is a bias of about a tenth of the amplitude. Rows of this way have the method ``as_published``.

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
from ...signals.programme1969.programme import Analysis, adjusted_curve, analyse
from ...statistics.intervals import t_interval
from .line import shape_of
from .readings import Line, Readings, Run

if TYPE_CHECKING:
    from .reduction import Result

FEWEST_VALUES = 2  # for a standard deviation
STEP = 0.01  # unit of the amplitudes in the report [count/s]
CYCLE, HALF_WIDTH, BESIDE = 4, 3, 4  # samples a cycle, JA, lines on each side
FEWEST_SAMPLES = 40
ORDER = np.array([0.0, 1.0, 0.0, -1.0])


@dataclass(frozen=True)
class Published:
    """Mean response of runs as the report has it."""

    response: float  # Mean of GO and BO [count/s]
    u: float  # Twice their standard deviation [count/s]
    rounded: float  # Both to the one digit of the uncertainty [count/s]
    u_rounded: float  # Both to the one digit of the uncertainty [count/s]
    scale_factor: float  # From the rounded values [count/s/(m/s^2)]
    u_scale_factor: float  # Its uncertainty, from the rounded values [count/s/(m/s^2)]
    values: int  # Number of GO and BO


def less_noise(line: Line) -> tuple[float, float]:
    """Return GO and BO of a run [count/s]."""
    return line.psd_response - line.psd_noise, line.response - line.noise


def published(lines: Sequence[Line]) -> Published | None:
    """Return the mean response of runs with the mass moved; None for too few runs."""
    moved = [line for line in lines if line.moved]
    values = np.array([value for line in moved for value in less_noise(line) if math.isfinite(value)])
    if len(values) < FEWEST_VALUES or not np.ptp(values) > 0.0:
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
    plan = result.plan
    found = published(lines)
    if found is None:
        reason = why or "too few runs for a standard deviation"
        yield not_estimated(Key("scale_factor", axis), plan.scale_unit, Reason("few_runs", reason), Method.TEXTBOOK)
        return
    reason = (
        f"mean of {found.values} amplitudes less the mean amplitude next to them, {found.response:.4g}"
        f" {plan.output_unit}, rounded to {found.rounded:.4g} +- {found.u_rounded:.4g}; this subtracts too much"
    )
    interval = t_interval(found.scale_factor, found.u_scale_factor, math.inf)
    yield Row(Key("scale_factor", axis), found.scale_factor, found.u_scale_factor, plan.scale_unit, None, interval,
              reason=Reason("limits", reason), method=Method.TEXTBOOK)  # fmt: skip


def published_lines(readings: Readings) -> tuple[tuple[Line, ...], str]:
    """Return all runs as lines in the published way, or why there are none; runs reduced before stay as they are."""
    if readings.lines:
        return readings.lines, ""
    for run in readings.series:
        schedule = run.schedule
        if len(schedule) % schedule.samples_per_cycle:
            return (), f"{run.name}: {len(schedule)} dwells are not in whole cycles"
        if schedule.samples_per_cycle != CYCLE or not np.allclose(shape_of(schedule)[:CYCLE], ORDER, atol=0.01):
            return (), f"{run.name}: the published way is for middle, maximum, middle, minimum"
        if run.there < FEWEST_SAMPLES:
            return (), f"{run.name}: {run.there} readings, too few for the published way"
    return tuple(_line(run) for run in readings.series), ""


def analysed(run: Run) -> Analysis:
    """Return the analysis of the programme after its moving mean, of a run in whole cycles."""
    closed = run.reading[np.isfinite(run.reading)]
    n = len(closed) - len(closed) % CYCLE
    x = closed[:n] - closed[:n].mean()
    return analyse(adjusted_curve(x, HALF_WIDTH), np.zeros(n), run.schedule.dwell, n // 2, n // 2)


def _line(run: Run) -> Line:
    """Return G, B, GR, CR and XSD of a run."""
    found = analysed(run)
    n, lines = len(found.x), len(found.density)
    at, of_spectrum = n // CYCLE, 2 * lines // CYCLE
    near = [k for m in range(1, BESIDE + 1) for k in (-m, m)]
    model = found.sine[at - 1] * np.tile(ORDER, n // CYCLE)
    return Line(
        run.name,
        run.schedule.amplitude,
        response=float(found.sine[at - 1]),
        noise=float(np.mean([found.line[at - 1 + k] for k in near])),
        beside=2 * BESIDE,
        u_applied=run.schedule.u_applied or 0.0,
        moved=run.moved,
        psd_response=float(found.amplitude[of_spectrum - 1]),
        psd_noise=float(np.mean([found.amplitude[of_spectrum - 1 + k] for k in near])),
        scatter=float(np.sqrt(np.mean((found.x - model) ** 2))),
        where=run.where,
    )
