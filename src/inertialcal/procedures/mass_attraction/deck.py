"""A deck of the 1969 programme: what the programme makes of it, and the same reductions done right next to that.

Rows with the method ``as_published`` are the programme's own, step by step as its listing has it. The others keep wrong
values as gaps, divide what is left of the line by what the reduction leaves of it, and take the uncertainty from the
lines around; the last one of each case fits line and drift at once, as ``sine`` does. Both are in the unit of the
cards, impulses in each sample time.

References
----------
.. [1] K. Reinel, NASA TM X-53857, 1969, appendices A and B.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...core.curve import Column, Curve
from ...core.errors import DataError, InertialcalError
from ...core.estimate import Array
from ...core.key import Key, Member, Method, Reason
from ...core.results import Row, not_estimated
from ...core.show.frames import frame_of_rows
from ...core.show.rounding import number, with_uncertainty
from ...core.show.tables import Block, Table, html, text
from ...files.source import load
from ...files.text.layout import decode
from ...signals.programme1969 import cards, reductions
from ...signals.programme1969.cards import Case, MeasuredCase, Request, read_cards, series_with_gaps
from ...signals.programme1969.programme import NG, Analysis, run_case, scale_factor
from ...signals.sine.drive import sine_drive
from ...signals.sine.fit import design_of, fit_line
from ...statistics.intervals import t_interval

if TYPE_CHECKING:
    from pandas import DataFrame

Reduced = reductions.Reduction
REDUCTIONS = {cards.ANALYSE: "none", cards.TILT: "tilt trace", cards.LINE: "straight line",
              cards.HARMONICS: "harmonics", cards.CURVE: "adjusted curve"}  # fmt: skip
SAMPLES_PER_CYCLE = 4  # of the input, where the card has none
AT_ONCE = "line and drift"
PRINTED = {"amplitude": "count", "spectrum_amplitude": "count", "standard_deviation": "count",
           "scale_factor": "count/g", "scale_factor_error": "count/g"}  # fmt: skip
CORRELATED = ("accelerometer", "tilt", "cross")
FEWEST = 0.1  # of a line, that a reduction must leave
HEADS = ("reduction", "Fourier", "spectrum", "std", "scale factor", "error", "gaps kept, gain corrected")


@dataclass(frozen=True, eq=False)
class DeckStep:
    """One request of a case."""

    case: str  # ``"case 1"``
    reduction: str  # ``"straight line"``
    printed: tuple[Row, ...]  # The programme's figures
    # Amplitude of the line by the same reduction with gaps kept and its gain divided out, or why there is none
    right: Row
    analysis: Analysis | None  # Of the programme; None for the row that fits line and drift at once

    def columns(self, interval: float) -> dict[str, dict[str, Column]]:
        """Return series, normalised correlations, spectrum and Fourier lines, by column; nothing without analysis."""
        if (found := self.analysis) is None:
            return {}
        n, lines = len(found.x), len(found.density)
        with np.errstate(divide="ignore", invalid="ignore"):
            normal = (found.normalised_x, found.normalised_y, found.normalised_cross)
        shown: dict[str, tuple[str, float, dict[str, tuple[Array, str]]]] = {
            "series": ("time", interval, {"accelerometer": (found.x, "count"), "tilt": (found.y, "")}),
            "correlation": ("lag", interval, {k: (v, "1") for k, v in zip(CORRELATED, normal, strict=True)}),
            "spectrum": (
                "frequency", 0.5 / (lines * interval),
                {"density": (found.density, "count^2/Hz"), "smoothed": (found.smoothed, "count^2/Hz"),
                 "amplitude": (found.amplitude, "count"), "smoothed_amplitude": (found.smoothed_amplitude, "count")},
            ),
            "lines": (
                "frequency", 1.0 / (n * interval),
                {"cosine": (found.cosine, "count"), "sine": (found.sine, "count"), "amplitude": (found.line, "count")},
            ),
        }  # fmt: skip
        made = {}
        for name, (axis, step, columns) in shown.items():
            first, unit = (1, "Hz") if axis == "frequency" else (0, "s")
            size = len(next(iter(columns.values()))[0])
            made[name] = {
                "step": Column([f"{self.case}, {self.reduction}"] * size),
                axis: Column((first + np.arange(size)) * step, unit),
                **{label: Column(values, of) for label, (values, of) in columns.items()},
            }
        return made


@dataclass(frozen=True, eq=False)
class DeckCase:
    """One case of a deck: what it is, its sample time [s], its steps."""

    caption: str
    interval: float
    steps: tuple[DeckStep, ...]


@dataclass(frozen=True, eq=False)
class Deck1969:
    """What the programme of 1969 makes of a deck, and the same reductions done right."""

    path: str  # Of the deck
    sha256: str  # Of its bytes
    cases: tuple[DeckCase, ...]  # In their order

    @property
    def rows(self) -> tuple[Row, ...]:
        """All figures; those of the programme have the method ``as_published``."""
        return tuple(row for case in self.cases for step in case.steps for row in (*step.printed, step.right))

    def curves(self) -> list[Curve]:
        """Return series, correlations, spectrum and Fourier lines, all steps in one, each row with its step."""
        parts = [step.columns(case.interval) for case in self.cases for step in case.steps if step.analysis is not None]
        made = []
        for kind in parts[0] if parts else ():
            every = [part[kind] for part in parts]
            columns = {
                name: Column([value for part in every for value in part[name].values], one.unit)
                for name, one in every[0].items()
            }
            made.append(Curve(f"programme_1969_{kind}", "", columns))
        return made

    def content(self) -> dict[str, Any]:
        """Return what ``--json`` gives."""
        inputs = [{"path": self.path, "sha256": self.sha256}]
        return {"inputs": inputs, "results": [row.to_dict() for row in self.rows]}

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return a table for each case, a line for each step."""
        tables = []
        for case in self.cases:
            lines = []
            for step in case.steps:
                values = [number(row.value, 5) for row in step.printed] or [""] * 5
                right = step.right
                own = with_uncertainty(right.value, right.u) if right.value is not None else right.reason.text
                lines.append((step.reduction, *values, own))
            tables.append(Table(HEADS, lines, case.caption, (1, 2, 3, 4, 5)))
        return (
            *tables,
            "Amplitudes and std in counts a sample, scale factors in count/g. All but the last column"
            " as the programme prints them.",
        )

    def __str__(self) -> str:
        """Return the tables as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the tables for a notebook."""
        return html(self.parts())


def programme_1969(path: str | Path) -> Deck1969:
    """Run the analysis programme of 1969 on a deck of card images, and set the same reductions done right next to it.

    Parameters
    ----------
    path : path
        Text, a line a card, or packed with gzip: cases of measured or synthetic series with their requests.

    Returns
    -------
    Deck1969
        Amplitude of the input line by Fourier series and spectrum [count], standard deviation and scale factor
        [count/g] after each request.

    Raises
    ------
    DataError
        ``bad_card``: the message names card and columns; or as the programme where a request cannot be done.
    """
    loaded = load(path)
    deck = read_cards(decode(loaded.data, loaded.path)[0], loaded.path)
    return Deck1969(loaded.path, loaded.sha256, tuple(_case(case, f"case {at}") for at, case in enumerate(deck, 1)))


def _case(case: Case, name: str) -> DeckCase:
    """Return a case with the analysis after each request, and the reduction done right."""
    kind = "synthetic"
    if isinstance(case, MeasuredCase):
        kind = f"measured, input {case.NA} ng, wrong values: {len(case.wrong)}"
    reduced: Reduced = np.asarray
    x, tilt = series_with_gaps(case)
    steps = []
    for step in run_case(case):
        request = step.request
        label = REDUCTIONS[request.what] + (f" {request.number}" if request.number else "")
        member = Member("reduction", f"{name}, {label}")
        reduced = _done_right(request, reduced, tilt, case)
        right = _amplitude(case, x, member, reduced)
        steps.append(DeckStep(name, label, tuple(_printed(case, step.analysis, member)), right, step.analysis))
    member = Member("reduction", f"{name}, {AT_ONCE}")
    steps.append(DeckStep(name, AT_ONCE, (), _amplitude(case, x, member, None), None))
    return DeckCase(f"{name}: {kind}, {case.N} samples of {case.NH} s", float(case.NH), tuple(steps))


def _printed(case: Case, found: Analysis, member: Member) -> Iterator[Row]:
    """Yield what the programme prints after an analysis."""
    applied = case.NA if isinstance(case, MeasuredCase) else 1
    values, reason = [np.nan] * 5, Reason("no_input", "synthetic: no input amplitude")
    try:
        scale = scale_factor(found, applied)
        values = [scale.fourier * applied * NG, scale.spectrum * applied * NG, scale.std, scale.fourier, scale.error]
    except DataError as error:
        reason = Reason("no_line", error.problems[0].what)
    for (name, unit), value in zip(PRINTED.items(), values, strict=True):
        if np.isfinite(value) and (unit == "count" or isinstance(case, MeasuredCase)):
            yield Row(Key(name), float(value), None, unit, method=Method.TEXTBOOK, member=member)
        else:
            yield not_estimated(Key(name), unit, reason, Method.TEXTBOOK, member)


def _done_right(request: Request, last: Reduced, tilt: Array, case: Case) -> Reduced:
    """Return the reduction of a request, from the data, done right; reduction 3 goes on from the last one."""
    per_cycle = case.KO or SAMPLES_PER_CYCLE
    match request.what:
        case cards.TILT:
            return lambda x: reductions.without_tilt(x, tilt)[0]
        case cards.LINE:
            return reductions.without_line
        case cards.HARMONICS:
            return lambda x: reductions.without_bands(last(x), request.number, request.number + 1)
        case cards.CURVE:
            return lambda x: reductions.without_moving_mean(x, request.number + 1, per_cycle)
    return last


def _amplitude(case: Case, x: Array, member: Member, reduced: Reduced | None) -> Row:
    """Return the amplitude of the input's line after a reduction; without one, fitted together with the drift."""
    key = Key("amplitude")
    times, frequency = np.arange(len(x)) * float(case.NH), 1.0 / ((case.KO or SAMPLES_PER_CYCLE) * case.NH)
    try:
        gain, rest = 1.0, x
        if reduced is not None:
            rest = reduced(x)
            line = np.where(np.isfinite(x), sine_drive(times, frequency, 0.0).in_phase, np.nan)
            gain = reductions.gain_of(reduced, line)
            if abs(gain) < FEWEST:
                raise DataError("the reduction takes the line away")
        there = np.isfinite(rest)
        phase = 2.0 * np.pi * frequency * float(times[there][0] - times[0])
        drive = sine_drive(times[there], frequency, phase)
        fit = fit_line(design_of(drive, "dct") if reduced is None else design_of(drive, "polynomial", 0), rest[there])
    except InertialcalError as error:
        return not_estimated(key, "count", Reason("no_line", error.problems[0].what), member=member)
    value, u = float(fit.in_phase[0]) / gain, float(fit.u_in_phase[0]) / abs(gain)
    return Row(key, value, u, "count", fit.dof, t_interval(value, u, fit.dof), member=member)
