"""A known drive in a recording without a campaign file: what ``sine FILE`` and ``inertialcal.sine`` do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...core.errors import UsageError
from ...core.remarks import Remark, gather
from ...core.results import Row
from ...core.show.frames import frame_of_rows
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.rounding import number
from ...core.show.tables import Block, html, text
from ...files.source import load
from ...files.text.headers import bare_name
from ..mass_attraction.schedule_csv import read_schedule
from .inputs import channel_of, driven_by_schedule, driven_by_sine
from .plan import Plan
from .reduction import SineResult, line_of
from .sources import Source, one_of, quantity, recordings_of

if TYPE_CHECKING:
    from pandas import DataFrame


DRIFTS = ("dct", "polynomial")


@dataclass(frozen=True, eq=False)
class SineFile:
    """A drive found in one channel of a file.

    Parameters
    ----------
    line : SineResult
        What was found.
    inputs : mapping of str to str
        SHA-256 by path.
    remarks : tuple of Remark
        What reading and fitting brought up.
    """

    line: SineResult
    inputs: Mapping[str, str]
    remarks: tuple[Remark, ...]

    @property
    def rows(self) -> tuple[Row, ...]:
        """All figures, in the unit of the file."""
        return self.line.rows()

    def content(self) -> dict[str, Any]:
        """Return figures and curves as ``results.json`` would hold them."""
        curves = [curve.to_dict() for curve in self.line.curves()]
        return {"results": [row.to_dict() for row in self.rows], "curves": curves}

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: what was fitted, the figures, how many remarks."""
        return (*self.tables(), *remarks_line(self.remarks))

    def tables(self) -> tuple[Block, ...]:
        """Return what was fitted, and the figures."""
        design = self.line.fit.design
        kind = "sine" if design.drive.quadrature is not None else "applied sequence"
        known = "phase known" if design.drive.phase_known else "phase free"
        said = (
            f"{bare_name(self.line.driven.channel.name)}: {kind} of {number(1.0 / design.drive.frequency, 6)} s,"
            f" {known};"
            f" {len(self.line.driven.readings)} readings, {number(design.drive.cycles, 5)} cycles"
        )
        fitted = (
            f"drift: {_drift(design.drift, design.rows)}; noise from {design.side_bands} line(s) on each side,"
            f" {number(self.line.fit.dof, 3)} degrees of freedom"
        )
        rows = self.rows
        limits = [f"{row.quantity}: {row.reason}" for row in rows if row.status == "upper_limit"]
        return (*estimate_table([row.to_dict() for row in rows], said), *limits, fitted)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def _drift(kind: str, rows: int) -> str:
    return f"polynomial of degree {rows}" if kind == "polynomial" else f"a line and {rows} cosines"


def sine(
    source: Source,
    *,
    period: str | None = None,
    phase: str | None = None,
    schedule: str | Path | None = None,
    column: str | None = None,
    drift: str = "dct",
    order: int | None = None,
    side_bands: int | None = None,
    **recorded: Any,
) -> SineFile:
    """Find the amplitude of a known drive in drift and noise, with an uncertainty from beside its line.

    The drive is a sine of known period, whose phase may be known, or a schedule of what was applied in each dwell.

    Parameters
    ----------
    source : path, Recording or array
        Any format that ``inertialcal.read`` takes; an array is (n,), with ``sample_rate`` and ``unit``.
    period : str, optional
        ``"480 s"``: true time from cycle to cycle, pauses included. A sine that goes on during each sample is meant.
    phase : str, optional
        Of the sine at the first sample, ``"90 deg"``; free if not said.
    schedule : path, optional
        CSV of dwells, in place of a period; it begins with the record. The drive stands still during each dwell.
    column : str, optional
        Channel; the only one if not named.
    drift : {"dct", "polynomial"}
        A straight line and the lowest cosines, or a polynomial.
    order : int, optional
        Highest cosine, or degree.
    side_bands : int, optional
        Lines on each side from which the noise is told.
    **recorded
        ``units``, ``unit``, ``sample_rate``, ``averaging``, ``time_column``, ``start``, ``stop``, ``mission_start``,
        ``frame``: as ``inertialcal.allan`` takes them.

    Raises
    ------
    DataError
        If the file cannot be read or cannot carry any answer.
    UsageError
        If neither or both of period and schedule are given, or it is not clear which channel is meant.
    PlanError
        If drift or side bands do not fit the record.
    """
    if (period is None) == (schedule is None):
        both = "both are given" if period else "neither is given"
        raise UsageError(f"period and schedule: {both}", do='Give one: --period "480 s", or --schedule FILE')
    if phase is not None and schedule is not None:
        raise UsageError("phase and schedule", why="the schedule has the phase", do="Leave the phase out")
    one_of(drift, DRIFTS, "drift")
    recording = recordings_of(source, **recorded)[0]
    channel = channel_of(recording, column)
    if schedule is not None:
        driven = driven_by_schedule(recording, channel, read_schedule(schedule), schedule)
    else:
        turn = None if phase is None else quantity(phase, "rad", "phase", "90 deg")
        driven = driven_by_sine(recording, channel, quantity(str(period), "s", "period", "480 s"), turn)
    inputs = {recording.source.path: recording.source.sha256} if recording.source.path else {}
    inputs |= {} if schedule is None else {str(schedule): load(schedule).sha256}
    found = line_of(Plan(drift=drift, order=order, side_bands=side_bands), driven)  # type: ignore[arg-type]
    return SineFile(found, inputs, gather([*recording.remarks, *found.remarks()]))


__all__ = ["SineFile", "sine"]
