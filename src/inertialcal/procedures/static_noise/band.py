"""Band of a sensor with a low pass: where its noise is cut, as found in the spectrum and as stated.

A filter is found by all records of an axis together (``sensors.noise.fitting.filtered``). A cut-off that the settings
or the header of the file state is used where nothing is found, too, and compared with the corner that is found.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...core.remarks import Remark
from ...core.show.rounding import number
from ...sensors.noise.fitting.filtered import Band, Search, search_many
from .plan import Plan

if TYPE_CHECKING:
    from .record import Recorded

ALIKE = 1.5  # ratio of a stated cut-off to the corner from which they disagree
STEEPER = 100.0  # ratio of the falls about both, from which the stated one is the filter's, the other that of the noise
PASSED = 1e-3  # of the density, below which a line is one of the stop band
BELOW = 0.45  # of the sample rate: a cut-off above it takes nothing that the samples would show


@dataclass(frozen=True, eq=False)
class Bands:
    """What the filter of one axis leaves of its noise."""

    each: tuple[Band | None, ...] = ()  # A record each; None where it is cut nowhere
    unseen: tuple[Band | None, ...] = ()  # A record each: what a mild filter might leave that no spectrum shows
    corner: float | None = None  # Where half of the density is left: the median of the records [Hz]
    remarks: tuple[Remark, ...] = ()

    @property
    def said(self) -> str:
        """What to say of a figure of the fit; empty without a filter."""
        return "" if self.corner is None else f"level inside the band, up to {number(self.corner, 3)} Hz"


def stated_cut_off(plan: Plan, record: Recorded) -> float | None:
    """Return the cut-off that is stated for a record [Hz]."""
    return plan.cut_off if plan.cut_off is not None else record.run.cut_off


def bands_of(asked: Sequence[tuple[Plan, Sequence[Recorded], str]]) -> list[Bands]:
    """Return the bands of the records of each of many axes; their spectra are searched side by side."""
    there = [one.spectral for _, records, _ in asked for one in records if one.spectral.spectrum is not None]
    found = iter(search_many([
        (one.spectrum, None if one.lines is None else one.lines.marked[:, 0])
        for one in there if one.spectrum is not None
    ]))  # fmt: skip
    return [
        _bands(plan, records, axis, [None if one.spectral.spectrum is None else next(found) for one in records])
        for plan, records, axis in asked
    ]


def _bands(plan: Plan, records: Sequence[Recorded], axis: str, searches: Sequence[Search | None]) -> Bands:
    """Return the bands of the records of one axis, as they were searched."""
    known = [one for one in searches if one is not None]
    found = bool(known) and Search.together(known)
    stated = [stated_cut_off(plan, one) for one in records]
    each: list[Band | None] = []
    for one, cut_off, own in zip(searches, stated, records, strict=True):
        said = None if cut_off is None else cut_off * own.run.interval
        used = found or (said is not None and said < BELOW)
        stated_here = said if said is not None and said < BELOW else None
        each.append(one.band(stated_here) if one is not None and used else None)
    known_corners = [one.corner / own.run.interval for one, own in zip(each, records, strict=True) if one is not None]
    if known_corners:  # one sensor has one filter: where a record alone does not show it, the others do
        middle = float(np.median(known_corners))
        each = [
            one.band(middle * own.run.interval) if band is None and one is not None else band
            for one, band, own in zip(searches, each, records, strict=True)
        ]
    corners = [one.corner / own.run.interval for one, own in zip(each, records, strict=True) if one is not None]
    if not corners:
        unseen = tuple(None if one is None or found else one.unseen() for one in searches)
        return Bands(tuple(each), unseen, None, tuple(_unused(axis, found, [s for s in stated if s is not None])))
    corner = float(np.median(corners))
    remarks = _remarks(axis, corner, found, records, each, stated, known)
    return Bands(tuple(each), (None,) * len(each), corner, tuple(remarks))


def _unused(axis: str, found: bool, stated: Sequence[float]) -> list[Remark]:
    """Return what to say where no band is used."""
    if found:
        what = (
            f"{axis}: the noise falls towards half the sample rate, as behind a low pass, but the record is too short"
        )
        return [Remark("low_pass", "warning", what, do="Record for longer", axis=axis)]
    return []


def _remarks(
    axis: str,
    corner: float,
    found: bool,
    records: Sequence[Recorded],
    each: Sequence[Band | None],
    stated: Sequence[float | None],
    searches: Sequence[Search],
) -> list[Remark]:
    shortest = max(one.first * own.run.interval for one, own in zip(each, records, strict=True) if one is not None)
    where = f"{number(corner, 3)} Hz"
    used = f"the random walk is the level inside the band, averaging times below {number(shortest, 2)} s are not fitted"
    cut_off = next((one for one in stated if one is not None), None)
    if not found:
        what = (
            f"{axis}: cut-off stated at {number(cut_off or corner, 3)} Hz, but the spectrum shows no fall there: {used}"
        )
        return [Remark("cut_off_disagrees", "warning", what, do="Check the stated cut-off", axis=axis)]
    if cut_off is None:
        return [
            Remark("low_pass", "info", f"{axis}: low pass: half of the density is left at {where}; {used}", axis=axis)
        ]
    ends = [np.array(one.shown) / own.run.interval for one, own in zip(each, records, strict=True) if one is not None]
    lowest, shown, highest = np.median(ends, axis=0).tolist()
    falls = [one.fall(cut_off * one.interval) / one.fall(shown * one.interval) for one in searches]
    if (lowest < ALIKE * cut_off and highest > cut_off / ALIKE) or np.median(falls) > STEEPER:
        what = (
            f"{axis}: low pass: cut-off stated at {where}, half of the density is left at {number(shown, 3)} Hz; {used}"
        )
        return [Remark("low_pass", "info", what, axis=axis)]
    what = f"{axis}: cut-off stated at {where}, but half of the density is left at {number(shown, 3)} Hz: {used}"
    return [Remark("cut_off_disagrees", "warning", what, do="Check the stated cut-off", axis=axis)]


def inside_band(record: Recorded) -> Recorded:
    """Return a record without the lines of the stop band, which the sensor cannot have measured."""
    lines, band = record.spectral.lines, record.band
    if lines is None or band is None or not len(lines):
        return record
    passed = band.passed_at(np.array([line.frequency for line in lines.found]) * record.run.interval)
    far = np.array([line.frequency for line in lines.found]) * record.run.interval > band.corner
    kept = tuple(
        line for line, share, beyond in zip(lines.found, passed, far, strict=True) if share > PASSED or not beyond
    )
    if len(kept) == len(lines.found):
        return record
    return replace(record, spectral=replace(record.spectral, lines=replace(lines, found=kept)))
