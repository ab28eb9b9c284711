"""Runs in the way of the programme of 1969: error readings closed up, moving mean off, Fourier lines, spectrum.

What the programme needs, it gets: an even number of samples in whole cycles of four, the first of them at the middle
position. Closing up a gap shifts the phase of all that follows, and the moving mean takes 1.7 % of the line with it;
both are part of the published way.
"""

from __future__ import annotations

import numpy as np

from ...signals.programme1969.programme import Analysis, adjusted_curve, analyse
from .readings import Line, Readings, Run
from .response.line import shape_of

CYCLE, HALF_WIDTH, BESIDE = 4, 3, 4  # samples a cycle, JA, lines on each side
FEWEST = 40  # samples
ORDER = np.array([0.0, 1.0, 0.0, -1.0])


def published_lines(readings: Readings) -> tuple[tuple[Line, ...], str]:
    """Return all runs as lines in the published way, and why there are none.

    Parameters
    ----------
    readings : Readings
        Runs; those that were reduced before stay as they are.
    """
    if readings.lines:
        return readings.lines, ""
    wrong = next((why for run in readings.series if (why := _unfit(run))), "")
    return ((), wrong) if wrong else (tuple(_line(run) for run in readings.series), "")


def _unfit(run: Run) -> str:
    """Return why the programme cannot take a run; empty where it can."""
    schedule = run.schedule
    if len(schedule) % schedule.samples_per_cycle:
        return f"{run.name}: {len(schedule)} dwells are not in whole cycles"
    if schedule.samples_per_cycle != CYCLE or not np.allclose(shape_of(schedule)[:CYCLE], ORDER, atol=0.01):
        return f"{run.name}: the published way is for middle, maximum, middle, minimum"
    if run.there < FEWEST:
        return f"{run.name}: {run.there} readings, too few for the published way"
    return ""


def analysed(run: Run) -> Analysis:
    """Return the analysis of the programme after its moving mean.

    Parameters
    ----------
    run : Run
        In whole cycles.
    """
    closed = run.reading[np.isfinite(run.reading)]
    n = len(closed) - len(closed) % CYCLE
    x = closed[:n] - closed[:n].mean()
    return analyse(adjusted_curve(x, HALF_WIDTH), np.zeros(n), run.schedule.dwell, n // 2, n // 2)


def _line(run: Run) -> Line:
    """Return G, B, GR, CR and XSD of a run."""
    found = analysed(run)
    n, lines = len(found.x), len(found.density)
    at, of_spectrum = n // CYCLE, 2 * lines // CYCLE
    beside = [k for m in range(1, BESIDE + 1) for k in (-m, m)]
    model = found.sine[at - 1] * np.tile(ORDER, n // CYCLE)
    u = run.schedule.u_applied or 0.0
    return Line(
        run.name,
        run.schedule.amplitude,
        float(found.sine[at - 1]),
        float(np.mean([found.line[at - 1 + k] for k in beside])),
        2 * BESIDE,
        u,
        run.moved,
        float(found.amplitude[of_spectrum - 1]),
        float(np.mean([found.amplitude[of_spectrum - 1 + k] for k in beside])),
        float(np.sqrt(np.mean((found.x - model) ** 2))),
        run.where,
    )
