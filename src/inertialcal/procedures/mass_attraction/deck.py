"""The 1969 programme on a deck of cards or a recording: what it makes of them, and the same reductions done right.

Rows with the method ``as_published`` are the programme's own, step by step as its listing has it. The others keep wrong
values as gaps, divide what is left of the line by what the reduction leaves of it, and take the uncertainty from the
lines around; the last one of each case fits line and drift at once, as ``sine`` does. Both are in the unit of the
readings: of cards, impulses in each sample time.

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
from ...core.remarks import Remark
from ...core.results import Row, not_estimated
from ...core.show.frames import frame_of_rows
from ...core.show.rounding import number, settled, settled_number
from ...core.show.tables import Block, Table, html, text
from ...core.units import FILE_UNIT, divide, power
from ...files.source import load
from ...files.text.layout import decode
from ...signals.programme1969 import cards, reductions
from ...signals.programme1969.cards import (
    Case,
    MeasuredCase,
    RecordedCase,
    Request,
    SyntheticCase,
    read_cards,
    series_with_gaps,
)
from ...signals.programme1969.programme import NG, Analysis, Step, adjusted_curve, run_case, scale_factor
from ...signals.sine.drive import Drive, sine_drive
from ...signals.sine.fit import design_of, fit_line
from ...statistics.intervals import t_interval

if TYPE_CHECKING:
    from pandas import DataFrame

Reduced = reductions.Reduction
REDUCTIONS = {cards.ANALYSE: "none", cards.TILT: "tilt trace", cards.LINE: "straight line",
              cards.HARMONICS: "harmonics", cards.CURVE: "adjusted curve"}  # fmt: skip
SAMPLES_PER_CYCLE = 4  # of the input, where the card has none
AT_ONCE = "line and drift"
PRINTED = {"amplitude": False, "spectrum_amplitude": False, "standard_deviation": False, "scale_factor": True,
           "scale_factor_error": True}  # whether it is per unit of input  # fmt: skip
CORRELATED = ("accelerometer", "tilt", "cross")
SIDES = 4  # lines on each side of the input's, that give the noise of a reduced series
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
    step: Step | None  # Of the programme; None for the row that fits line and drift at once

    def columns(self, interval: float, unit: str) -> dict[str, dict[str, Column]]:
        """Return series, normalised correlations, spectrum and Fourier lines, by column; nothing without analysis."""
        if self.step is None:
            return {}
        found, removed = self.step.analysis, self.step.removed
        n, lines = len(found.x), len(found.density)
        density = FILE_UNIT if unit == FILE_UNIT else divide(power(unit, 2), "Hz")
        with np.errstate(divide="ignore", invalid="ignore"):
            normal = (found.normalised_x, found.normalised_y, found.normalised_cross)
        shown: dict[str, tuple[str, float, dict[str, tuple[Array, str]]]] = {
            "series": ("time", interval, {"accelerometer": (found.x, unit), "removed": (removed, unit),
                                            "tilt": (found.y, "")}),
            "correlation": ("lag", interval, {k: (v, "1") for k, v in zip(CORRELATED, normal, strict=True)}),
            "spectrum": (
                "frequency", 0.5 / (lines * interval),
                {"density": (found.density, density), "smoothed": (found.smoothed, density),
                 "amplitude": (found.amplitude, unit), "smoothed_amplitude": (found.smoothed_amplitude, unit)},
            ),
            "lines": (
                "frequency", 1.0 / (n * interval),
                {"cosine": (found.cosine, unit), "sine": (found.sine, unit), "amplitude": (found.line, unit)},
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
    """One case."""

    caption: str  # What it is
    interval: float  # Sample time [s]
    steps: tuple[DeckStep, ...]
    unit: str  # Of its readings
    per_input: str  # Of its scale factor
    errors: tuple[str, ...]  # Of the programme, that its figures have


@dataclass(frozen=True, eq=False)
class Deck1969:
    """What the programme of 1969 makes of a deck or a recording, and the same reductions done right."""

    path: str  # Of the deck or recording
    sha256: str  # Of its bytes
    cases: tuple[DeckCase, ...]  # In their order
    remarks: tuple[Remark, ...] = ()  # On a recording

    @property
    def rows(self) -> tuple[Row, ...]:
        """All figures; those of the programme have the method ``as_published``."""
        return tuple(row for case in self.cases for step in case.steps for row in (*step.printed, step.right))

    def curves(self) -> list[Curve]:
        """Return series, correlations, spectrum and Fourier lines, all steps in one, each row with its step."""
        parts = [
            step.columns(case.interval, case.unit)
            for case in self.cases
            for step in case.steps
            if step.step is not None
        ]
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
        found = {"inputs": inputs, "results": [row.to_dict() for row in self.rows]}
        errors = {f"case {at}": list(case.errors) for at, case in enumerate(self.cases, 1)}
        return found | {"programme_errors": errors, "remarks": [one.to_dict() for one in self.remarks]}

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return a table for each case, a line for each step."""
        tables: list[Block] = []
        for case in self.cases:
            lines = []
            for step in case.steps:
                values = [settled_number(row.value, 5) for row in step.printed] or [""] * 5
                right = step.right
                own = settled(right.value, right.u) if right.value is not None else right.reason.text
                lines.append((step.reduction, *values, own))
            tables.append(Table(HEADS, lines, case.caption, (1, 2, 3, 4, 5)))
        units = dict.fromkeys((case.unit, case.per_input) for case in self.cases)
        own = "; ".join(f"amplitudes and std in {unit}, scale factors in {per}" for unit, per in units)
        named = dict.fromkeys(error for case in self.cases for error in case.errors)
        return (
            *tables,
            f"{own[:1].upper()}{own[1:]}. All but the last column as the programme prints them.",
            "Errors of the programme in these columns, which the last one does not have:",
            *(f"{at}. {error}" for at, error in enumerate(named, 1)),
            *(str(one) for one in self.remarks),
        )

    def __str__(self) -> str:
        """Return the tables as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return the tables for a notebook."""
        return html(self.parts())


def reduce_deck(path: str | Path) -> Deck1969:
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
    return Deck1969(
        loaded.path, loaded.sha256, tuple(reduced_case(case, f"case {at}") for at, case in enumerate(deck, 1))
    )


def reduced_case(case: Case, name: str, caption: str = "", unit: str = "count", per_input: str = "count/g") -> DeckCase:
    """Return a case with the analysis after each request, and the reduction done right.

    Parameters
    ----------
    case : Case
        Of a deck or a recording.
    name, caption : str
        ``"case 1"``; the line above its table, made of the cards if empty.
    unit, per_input : str
        Of the readings and of the scale factor.
    """
    kind = "synthetic"
    if isinstance(case, MeasuredCase):
        kind = f"measured, input {case.NA} ng, wrong values: {len(case.wrong)}"
    reduced: Reduced = np.asarray
    x, tilt = series_with_gaps(case)
    steps = []
    for step in run_case(case):
        request = step.request
        label = label_of(request)
        member = Member("reduction", f"{name}, {label}")
        reduced = _done_right(request, reduced, tilt, case)
        right = _amplitude(case, x, member, reduced, unit)
        printed = tuple(_printed(case, step.analysis, member, unit, per_input))
        steps.append(DeckStep(name, label, printed, right, step))
    member = Member("reduction", f"{name}, {AT_ONCE}")
    steps.append(DeckStep(name, AT_ONCE, (), _amplitude(case, x, member, None, unit), None))
    caption = caption or f"{name}: {kind}, {case.N} samples of {case.NH} s"
    return DeckCase(caption, float(case.NH), tuple(steps), unit, per_input, _errors(case, steps))


def label_of(request: Request) -> str:
    """Return a reduction as it is named: ``"harmonics 10"``."""
    return REDUCTIONS[request.what] + (f" {request.number}" if request.number else "")


def _errors(case: Case, steps: list[DeckStep]) -> tuple[str, ...]:
    """Return the errors of the programme that the figures of a case have, with their size in it."""
    per_cycle = case.KO or SAMPLES_PER_CYCLE
    x, _ = series_with_gaps(case)
    wrong, found = int(np.count_nonzero(np.isnan(x))), []
    if wrong:
        found.append(
            f"Wrong or missing values, here {wrong}, are closed up: what follows comes a sample earlier for each,"
            f" {360.0 / per_cycle:g} deg of the drive."
        )
    requests = [step.step.request for step in steps if step.step is not None]
    line = sine_drive(np.arange(case.N) * float(case.NH), 1.0 / (per_cycle * case.NH), 0.0).in_phase
    for request in requests:
        if request.what == cards.TILT:
            found.append("Tilt trace: the readings of the tilt meter keep their mean in the regression.")
        if request.what == cards.HARMONICS:
            found.append(
                f"Harmonics: the line at half of the sampling frequency has twice its amplitude, so that it turns its"
                f" sign; {request.number + 1} lines go from above, {request.number} from below."
            )
        if request.what == cards.CURVE:
            kept = reductions.gain_of(lambda one, width=request.number: adjusted_curve(one, width), line)  # type: ignore[misc]
            found.append(
                f"Adjusted curve: the centred mean shrinks towards both ends, which are no mirror images, and takes"
                f" {number(100.0 * (1.0 - kept), 2)} % of the line."
            )
    found.append(
        "The error of the scale factor is the standard deviation of the data (divided by N) over the input amplitude,"
        " not that of the amplitude; negative densities are hidden by their absolute value."
    )
    return tuple(dict.fromkeys(found))


def _printed(case: Case, found: Analysis, member: Member, unit: str, per_input: str) -> Iterator[Row]:
    """Yield what the programme prints after an analysis."""
    applied = None if isinstance(case, SyntheticCase) else case.NA
    values, reason = [np.nan] * 5, Reason("no_input", "no input amplitude is given")
    per_cycle = case.KO if isinstance(case, RecordedCase) else SAMPLES_PER_CYCLE
    try:
        scale = scale_factor(found, 1.0 if applied is None else applied, per_cycle)
        part = NG * (1.0 if applied is None else applied)
        values = [scale.fourier * part, scale.spectrum * part, scale.std, scale.fourier, scale.error]
    except DataError as error:
        reason = Reason("no_line", error.problems[0].what)
    for (name, of_input), value in zip(PRINTED.items(), values, strict=True):
        if np.isfinite(value) and not (of_input and applied is None):
            yield Row(
                Key(name), float(value), None, per_input if of_input else unit, method=Method.TEXTBOOK, member=member
            )
        else:
            yield not_estimated(Key(name), per_input if of_input else unit, reason, Method.TEXTBOOK, member)


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


def _amplitude(case: Case, x: Array, member: Member, reduced: Reduced | None, unit: str) -> Row:
    """Return the amplitude of the input's line after a reduction; without one, fitted together with the drift."""
    key = Key("amplitude")
    times, frequency = (
        np.asarray(np.arange(len(x)) * float(case.NH), dtype=np.float64),
        1.0 / ((case.KO or SAMPLES_PER_CYCLE) * case.NH),
    )
    try:
        gain, rest = 1.0, x if reduced is None else reduced(x)
        if reduced is not None:
            gain = _gain(reduced, x, times, frequency)
            if abs(gain) < FEWEST:
                raise DataError("the reduction takes the line away")
        there = np.isfinite(rest)
        phase = 2.0 * np.pi * frequency * float(times[there][0] - times[0])
        drive = sine_drive(times[there], frequency, phase)
        if reduced is not None:
            value, u, dof = _beside_lines(drive, rest, times, reduced)
            value /= gain
        else:
            fit = fit_line(design_of(drive), rest[there])
            value, u, dof = float(fit.in_phase[0]), float(fit.u_in_phase[0]), float(fit.dof[0])
    except InertialcalError as error:
        return not_estimated(key, unit, Reason("no_line", error.problems[0].what), member=member)
    return Row(key, value, u, unit, dof, t_interval(value, u, dof), member=member)


def _gain(reduced: Reduced, x: Array, times: Array, frequency: float) -> float:
    """Return what a reduction leaves of a line, at the samples that there are."""
    line = np.sin(2.0 * np.pi * np.fmod(times * frequency, 1.0))
    return reductions.gain_of(reduced, np.where(np.isfinite(x), line, np.nan))


def _beside_lines(drive: Drive, reduced_x: Array, times: Array, reduced: Reduced) -> tuple[float, float, float]:
    """Return the line in phase, the standard uncertainty of its amplitude and degrees of freedom, by the lines around.

    Drift that a reduction leaves stands in those lines too, so that it counts. Each is divided by what the reduction
    leaves of it; bands that a reduction removes do not count.
    """
    there = np.isfinite(reduced_x)
    x = reduced_x[there]
    parts = [np.ones(len(x)), drive.in_phase] + ([] if drive.quadrature is None else [drive.quadrature])
    basis = np.column_stack(parts)
    found = np.linalg.lstsq(basis, x, rcond=None)[0]
    rest = x - basis @ found
    lines = drive.frequency + np.r_[-SIDES:0, 1 : SIDES + 1] / drive.span
    lines = lines[(lines > 0.5 / drive.span) & (lines < 0.5 / drive.step * (1.0 - 1e-9))]
    gains = np.array([_gain(reduced, reduced_x, times, line) for line in lines.tolist()])
    lines, gains = lines[np.abs(gains) > FEWEST], gains[np.abs(gains) > FEWEST]
    if len(lines) < 2:
        raise DataError("no lines next to that of the input", do="Take more cycles", code="too_few_cycles")
    power = np.abs(2.0 / len(x) * np.exp(-2j * np.pi * np.outer(lines, times[there])) @ rest) ** 2
    return float(found[1]), float(np.sqrt(0.5 * (power / gains**2).mean())), 2.0 * len(lines)
