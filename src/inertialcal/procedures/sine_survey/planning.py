"""A survey planned: how long a sweep lasts, whether a mode follows it, and how well the mode will be known.

What ``plan vibration survey`` and ``inertialcal.plan_vibration_survey`` do. A sweep of amplitude A has at a frequency f
the energy density ``A^2 / (4 df/dt)``. The information on a mode is that of the whole record::

    F_ij = 2 integral Re(conj(dH_i) dH_j) A^2 / (4 df/dt) / (N_y^2 / 2 + |H|^2 N_u^2 / 2) df

with the changes dH of the transmissibility by frequency, Q, both residues and the background of the fit (``modal``),
and the one-sided densities N of the noise of response and control. Its inverse is what a fit can reach at best. One
mode is planned; others nearby, and noise that is not white, make it worse.

How far the mode is from a steady state is ``eta = (df/dt) / (f / Q)^2``, for a logarithmic sweep of R octaves a minute
``R ln 2 Q^2 / (60 f)``. A reading behind a tracking filter needs a small one; the fit of the whole record does not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...core.curve import Curve
from ...core.errors import PlanError, UsageError
from ...core.estimate import Array
from ...core.key import At, Key
from ...core.remarks import Remark
from ...core.results import Row
from ...core.schema.settings import settings_values
from ...core.settings import settings_of
from ...core.show.frames import frame_of_rows
from ...core.show.result_tables import remarks_line
from ...core.show.rounding import number, uncertainty
from ...core.show.tables import Block, Table, html, text
from .modal import BACKGROUND
from .plan import PlannedSurvey, range_of, rate_of
from .sweep import sweep_duration

if TYPE_CHECKING:
    from pandas import DataFrame

RATES = ("1 oct/min", "2 oct/min", "4 oct/min", "8 oct/min")  # that are compared
PER_RATE = {"log": ("1/min", 60.0), "linear": ("Hz/s", 1.0)}
STEADY = 0.1  # eta, from which a tracking filter is not to be trusted
POINTS, WIDE = 4000, 40.0  # of the integral over the band; more within so many half widths of the mode
TEST = "plan"


@dataclass(frozen=True)
class SweepForecast:
    """What a sweep at one rate would give."""

    law: str  # ``"log"`` or ``"linear"``
    rate: float  # octaves or Hz a second
    duration: float  # [s]
    eta: float  # Rate over the half-power width squared
    passing: float  # Time in the half-power width [s]
    u_frequency: float  # [Hz]
    u_amplification: float
    u_peak: float  # Of the transmissibility at the frequency of the mode

    @property
    def rows(self) -> tuple[Row, ...]:
        """Its figures as ``results.json`` has them."""
        unit, size = PER_RATE[self.law]
        at = At("sweep_rate", self.rate * size, unit)
        figures = (("sweep_duration", self.duration, "s"), ("quasi_steadiness", self.eta, "1"),
                   ("resonance_frequency_uncertainty", self.u_frequency, "Hz"),
                   ("amplification_uncertainty", self.u_amplification, "1"),
                   ("transmissibility_uncertainty", self.u_peak, "1"))  # fmt: skip
        return tuple(Row(Key(name, at=at), value, None, its, test=TEST) for name, value, its in figures)


@dataclass(frozen=True, eq=False)
class SurveyPlan:
    """A survey before it is made."""

    wanted: PlannedSurvey
    forecasts: tuple[SweepForecast, ...]
    remarks: tuple[Remark, ...] = ()
    curves: tuple[Curve, ...] = ()

    @property
    def rows(self) -> tuple[Row, ...]:
        """Duration, eta and uncertainties by rate."""
        return tuple(row for one in self.forecasts for row in one.rows)

    @property
    def results(self) -> dict[str, Any]:
        """Rows as ``results.json`` has them."""
        return {"results": [row.to_dict() for row in self.rows], "curves": []}

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row a rate."""
        wanted = self.wanted
        rows = []
        for one in self.forecasts:
            unit, size = PER_RATE[one.law]
            cells = (one.u_frequency, one.u_amplification, one.u_peak)
            rows.append((f"{number(one.rate * size, 4)} {'oct/min' if one.law == 'log' else unit}",
                         f"{one.duration:.3f}", number(one.eta, 2), number(one.passing, 2),
                         *(uncertainty(one) for one in cells)))  # fmt: skip
        heads = ("rate", "duration [s]", "eta", "in the width [s]", "u frequency [Hz]", "u Q", "u transmissibility")
        caption = f"{wanted.sweep}; a mode at {number(wanted.frequency, 4)} Hz, Q {number(wanted.amplification, 3)}"
        return (Table(heads, rows, caption, tuple(range(1, 7))),)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text((*self.parts(), *remarks_line(self.remarks)))

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html((*self.parts(), *remarks_line(self.remarks)))


def plan_vibration_survey(**settings: Any) -> SurveyPlan:
    """Plan a sine survey.

    Parameters
    ----------
    **settings
        Those of ``plan vibration survey``, quantities as text with a unit: ``sweep``, ``rate``, ``level``,
        ``frequency``, ``amplification``, ``part``, ``noise``, ``control_noise``.

    Returns
    -------
    SurveyPlan
        Printable; ``.rows``, ``.forecasts``, ``.remarks``.

    Raises
    ------
    UsageError
        If a setting is wrong.
    """
    return planned(settings, options=False)


def planned(given: Mapping[str, Any], options: bool = True) -> SurveyPlan:
    """Return the plan that settings give, as text with units; messages speak of options, or of arguments of Python."""
    said = {name: value for name, value in given.items() if value is not None}
    words = {one.name: f"--{one.option}" if options else one.name for one in settings_of(PlannedSurvey)}
    if unknown := [name for name in said if name not in words]:
        raise UsageError(f"no setting {unknown[0]!r}", do=f"There are: {', '.join(words)}", code="unknown_name")

    def called(path: tuple[str | int, ...]) -> str:
        return words.get(str(path[0]), str(path[0]))

    values, problems = settings_values(PlannedSurvey, said, lambda *_: "", called=called)
    if problems:
        raise UsageError(problems)
    wanted = PlannedSurvey(**values)
    try:
        ends = range_of(wanted.sweep)
        laws = [rate_of(one) for one in ((wanted.rate,) if wanted.rate is not None else RATES)]
    except PlanError as error:
        raise UsageError(list(error.problems)) from error
    if not min(ends) < wanted.frequency < max(ends):
        what = f"{words['frequency']} {number(wanted.frequency, 4)} Hz is not inside the sweep, {wanted.sweep}"
        raise UsageError(what, do="Give a mode that the sweep passes, or a wider sweep", code="wrong_value")
    found = tuple(forecast(wanted, ends, law, rate) for law, rate in laws)
    remarks = []
    if min(one.eta for one in found) > STEADY:
        what = f"eta is {number(min(one.eta for one in found), 2)}: a tracking filter would read this mode too low"
        remarks.append(Remark("not_steady", "info", f"{what}; the fit of the whole record does not"))
    return SurveyPlan(wanted, found, tuple(remarks))


def forecast(wanted: PlannedSurvey, ends: tuple[float, float], law: str, rate: float) -> SweepForecast:
    """Return what a sweep between two frequencies [Hz] at one rate [octaves or Hz a second] gives."""
    f, q = wanted.frequency, wanted.amplification
    low, high = min(ends), max(ends)
    speed = rate * math.log(2.0) * f if law == "log" else rate
    duration = sweep_duration(low, high, rate) if law == "log" else (high - low) / rate
    grid = np.unique(np.concatenate([
        np.geomspace(low, high, POINTS), np.clip(f + 0.5 * f / q * np.linspace(-WIDE, WIDE, POINTS), low, high),
    ]))  # fmt: skip
    slopes = rate * math.log(2.0) * grid if law == "log" else np.full(len(grid), rate)
    h = _mode(grid, f, q, wanted.part)
    noise = 0.5 * (wanted.noise**2 + np.abs(h) ** 2 * wanted.control_noise**2)
    weight = 2.0 * wanted.level**2 / (4.0 * slopes * noise)
    columns = _changes(grid, f, q, wanted.part, math.sqrt(low * high))
    widths = np.gradient(grid)
    matrix = ((columns.conj() * (weight * widths)[:, None]).T @ columns).real
    scale = np.sqrt(np.diag(matrix))
    covariance = np.linalg.pinv(matrix / np.outer(scale, scale), hermitian=True) / np.outer(scale, scale)
    there = _changes(np.array([f]), f, q, wanted.part, math.sqrt(low * high))[0]
    peak = _mode(np.array([f]), f, q, wanted.part)[0]
    step = 1e-6  # the place where it is read moves with the mode
    moved = _mode(np.array([f * math.exp(step)]), f, q, wanted.part)[0]
    there[0] += (moved - peak) / step
    contrast = (there * np.conj(peak) / abs(peak)).real
    u_peak = math.sqrt(float(contrast @ covariance @ contrast))
    return SweepForecast(law, rate, duration, speed / (f / q) ** 2, f / q / speed, f * math.sqrt(covariance[0, 0]),
                         q * math.sqrt(covariance[1, 1]), u_peak)  # fmt: skip


def _mode(grid: Array, f: float, q: float, part: float) -> Any:
    s = 1j * grid
    return 1.0 - part + part * (f * f + s * f / q) / (f * f - grid**2 + s * f / q)


def _changes(grid: Array, f: float, q: float, part: float, middle: float) -> Any:
    """Return the changes of H by the logarithms of frequency and Q, the residues and the background."""
    step, s = 1e-6, 1j * grid
    of_f = (_mode(grid, f * math.exp(step), q, part) - _mode(grid, f * math.exp(-step), q, part)) / (2.0 * step)
    of_q = (_mode(grid, f, q * math.exp(step), part) - _mode(grid, f, q * math.exp(-step), part)) / (2.0 * step)
    under = f * f - grid**2 + s * f / q
    return np.column_stack([of_f, of_q, f * f / under, f * s / under, *((s / middle) ** p for p in BACKGROUND)])


__all__ = ["SurveyPlan", "SweepForecast", "forecast", "plan_vibration_survey", "planned"]
