"""From columns to a Recording: units, clock, channels, remarks."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..core.errors import DataError, InertialcalError, UsageError
from ..core.recording import COMPENSATED, MARK, Channel, Recording, Source
from ..core.remarks import Remark, gather
from ..core.unit.magnitudes import check_sample_rate
from ..signals.time.time_axis import analyse
from .columns import Column, Content, missing_remarks, nan_in_required, without_unfilled_end
from .info.describe import Described, axis_remarks, describe, find_column, rate_remark
from .text import xsens
from .text.grouped import grouped_column, problem
from .text.headers import heading, normal_unit
from .text.hobo import without_events
from .text.layout import CELL
from .time.clock import Clock, find_clock, unit_rates
from .time.unused import unused_clocks

MARKED = re.compile(rf"(?:^|[./]){COMPENSATED}([0-9a-f]{{{MARK}}})$", re.IGNORECASE)
BESIDE = re.compile(r"([+-]?[0-9]+(?:\.[0-9]*)?(?:[eE][+-]?[0-9]+)?) ?([A-Za-z%°µ].*)")  # number and unit in one cell
LOOKED_AT = 100  # cells of a column of words in which a number with its unit must appear
MEANT_BY_VALUES = ("", "time", "index")  # quantities of columns whose values may tell what they are
SHOWN = 5  # texts of a label column in its remark


def assemble(
    content: Content,
    source: Source,
    *,
    units: Mapping[str, str] | None = None,
    sample_rate: float | None = None,
    time_column: str | None = None,
    required: Sequence[str] = (),
    dates: str | None = None,
) -> Recording:
    """Return the recording that the columns of a file make.

    Parameters
    ----------
    content : Content
        As a reader hands it over.
    source : Source
        File, hash, format.
    units, sample_rate, time_column, required, dates
        As ``files.read`` takes them.

    Raises
    ------
    DataError, UsageError
        As ``files.read`` says.
    """
    path = source.path
    if sample_rate is not None and (wrong := check_sample_rate(sample_rate)):
        raise UsageError(wrong, code="sample_rate")
    content, compensated_by = _without_mark(content)
    content = replace(content, columns=tuple(map(with_unit_beside, content.columns)))
    content = xsens.settled(without_events(content, path), path)
    if content.time_ns is None:
        content = without_unfilled_end(content, path)
    described, unit_remarks = describe(content.columns, units or {}, path)
    if content.time_ns is None:
        clock = find_clock(described, content, path, time_column, dates)
    else:
        clock = Clock(None, content.time_ns, "utc")
    if clock.time_ns is not None:
        clock = replace(clock, time_ns=_data(clock.time_ns))
    _refuse_grouped(content, path)
    channels = _channels(described, clock, path)
    _require(described, required, content, path)
    timed = _timed(clock, content, described, sample_rate, path)
    unused = () if clock.time_ns is not None else unused_clocks(described, lambda index: content.place(path, index))
    remarks = (
        *content.remarks,
        *unit_remarks,
        *_missing(described, content, path),
        *_texts(described, clock, path),
        *clock.remarks,
        *timed.remarks,
        *unused,
        *_compensated(compensated_by, path),
    )
    return replace(
        timed,
        channels=channels,
        source=source,
        remarks=gather(remarks),
        first_row=_first_row(content),
        compensated_by=compensated_by,
    )


@dataclass(frozen=True, eq=False)
class Assembled:
    """Columns of a file, and the recording that they made: others of the same stamps make one that differs in values.

    Stamps, units and meanings are found once for recordings of many units.
    """

    content: Content
    recording: Recording

    def with_values(self, content: Content, source: Source) -> Recording | None:
        """Return the recording of other columns; None where their values may change more than the samples.

        So it is where one has a missing value, and where stamps, or columns without a meaning by their names, differ.
        """
        own, made = self.content, self.recording
        same = (own.format, own.sample_rate, own.cut_off, own.clock) == (
            content.format, content.sample_rate, content.cut_off, content.clock,
        )  # fmt: skip
        if made.remarks or made.compensated_by or not same or content.remarks or content.rows is not None:
            return None
        if made.time_ns is None or content.time_ns is not None or len(own.columns) != len(content.columns):
            return None
        channels: dict[str, Channel] = {one.name: one for one in made.channels}
        filled = False  # to the end, as the other is
        for before, now in zip(own.columns, content.columns, strict=True):
            if (before.name, before.unit, before.values.dtype) != (now.name, now.unit, now.values.dtype):
                return None
            if not (now.is_number and now.is_complete and before.is_complete):
                return None
            one = channels.get(now.name)
            if one is None or one.quantity in MEANT_BY_VALUES:
                labels = one is not None and not one.quantity and _is_constant(before.values)  # neither time nor index
                if not np.array_equal(before.values, now.values) and not (labels and _is_constant(now.values)):
                    return None
                filled = filled or now.values[-1] != 0
            if one is not None:
                channels[now.name] = one.changed(data=_data(now.values))
        return made.changed(channels=tuple(channels.values()), source=source) if filled else None


def _is_constant(values: NDArray[Any]) -> bool:
    return bool((values == values[:1]).all())


def _refuse_grouped(content: Content, path: str) -> None:
    """Refuse text that is numbers with grouped digits: a text file's reader has looked already."""
    number = CELL["."].fullmatch
    found = ((c, grouped_column(c.values, number)) for c in content.columns if c.values.dtype.kind == "O")
    problems = [
        problem(c.name, str(c.values[at]), content.place(path, at), certain=True) for c, at in found if at is not None
    ]
    if problems:
        raise DataError(problems)


def with_unit_beside(column: Column) -> Column:
    """Return a column of texts like ``2.5039 VDC``, all of one unit that its header does not contradict, as numbers."""
    if column.values.dtype.kind != "O" or not len(column.values):
        return column
    said = heading(column.name, column.unit)
    first = next((found for cell in column.values[:LOOKED_AT] if (found := BESIDE.fullmatch(str(cell).strip()))), None)
    if first is None:
        return column
    written = first[2]
    try:
        unit = normal_unit(written, said.quantity)
    except InertialcalError:
        return column
    if said.unit not in (None, unit):
        return column
    texts = [str(cell).strip() for cell in column.values]
    cells = [found if (found := BESIDE.fullmatch(text)) and found[2] == written else None for text in texts]
    if any(cell is None and text for cell, text in zip(cells, texts, strict=True)):
        return column
    values = np.array([float(cell[1]) if cell else np.nan for cell in cells])
    return replace(column, values=values, unit=unit, empty=np.flatnonzero(np.isnan(values)))


def _without_mark(content: Content) -> tuple[Content, str]:
    """Return the content without the column that says by which model it was compensated, and that model."""
    marks = {i: found[1] for i, one in enumerate(content.columns) if (found := MARKED.search(one.name.strip()))}
    kept = tuple(one for i, one in enumerate(content.columns) if i not in marks)
    return (replace(content, columns=kept), next(iter(marks.values())).lower()) if marks else (content, "")


def _compensated(model: str, path: str) -> tuple[Remark, ...]:
    what = f"compensated by model {model}: true inputs, not readings"
    return (Remark("compensated", "info", what, where=path),) if model else ()


def _first_row(content: Content) -> int:
    """Row of sample 0; 0 where comments or blank lines between the rows make it no help for the others."""
    rows = content.rows
    if rows is None or not len(rows) or rows[-1] - rows[0] != len(rows) - 1:
        return 0
    return int(rows[0])


def _channels(described: Sequence[Described], clock: Clock, path: str) -> tuple[Channel, ...]:
    """All columns of numbers but the time."""
    chosen = [d for i, d in enumerate(described) if i != clock.column and d.column.is_number]
    if not chosen:
        names = ", ".join(d.name for d in described) or "none"
        raise DataError(
            "no column of numbers, apart from time",
            where=path,
            do=f"The file has: {names}. Check separator and decimal sign",
            code="no_channel",
        )
    return tuple(Channel(d.name, _data(d.column.values), d.unit, d.unit_from, d.axis, d.quantity) for d in chosen)


def _data(values: NDArray[Any]) -> NDArray[Any]:
    """Return a read-only view, so that a frozen recording stays as it was read."""
    view = values.view()
    view.flags.writeable = False
    return view


def _require(described: Sequence[Described], required: Sequence[str], content: Content, path: str) -> None:
    """Refuse literal NaN, and text, in the columns that must hold numbers."""
    for name in required:
        column = described[find_column(described, name, path)].column
        if not column.is_number and column.values.dtype.kind != "M":
            raise DataError(
                f"text {str(column.values[0])!r} in number column {column.name!r}",
                where=content.place(path, 0),
                code="text_in_numbers",
            )
        if len(column.not_a_number):
            first = int(column.not_a_number[0])
            raise nan_in_required(column.name, "NaN", len(column.not_a_number), content.place(path, first))


def _timed(
    clock: Clock,
    content: Content,
    described: Sequence[Described],
    sample_rate: float | None,
    path: str,
) -> Recording:
    """Return a recording without channels: time, interval and where it comes from."""
    interval: float | None = None
    source: Literal["column", "flag", "header", ""] = ""
    column = ""
    if sample_rate is not None:
        interval, source = 1.0 / sample_rate, "flag"
    elif content.sample_rate is not None:
        interval, source = 1.0 / content.sample_rate, "header"
    if clock.time_ns is None or clock.column is None or len(clock.time_ns) < 2:
        said = {} if content.sample_rate is None else {"the header says": content.sample_rate}
        remarks = (
            rate_remark(sample_rate, said or unit_rates(described), path)
            if sample_rate and content.time_ns is None
            else ()
        )
        return Recording(
            (), clock.time_ns, interval, None, clock.epoch, source, remarks=remarks, cut_off=content.cut_off,
            clock=content.clock,
        )  # fmt: skip
    axis = analyse(clock.time_ns, steps=clock.steps)
    remarks = axis_remarks(axis, clock.time_ns, lambda index: content.place(path, index))
    if interval is None:
        interval, source, column = axis.interval, "column", described[clock.column].name
    elif axis.interval is not None:
        remarks += rate_remark(1.0 / interval, {"the time stamps say": 1.0 / axis.interval}, path, source == "header")
    return Recording(
        (), clock.time_ns, interval, None, clock.epoch, source, remarks=remarks, time_column=column,
        cut_off=content.cut_off, clock=content.clock,
    )  # fmt: skip


def _missing(described: Sequence[Described], content: Content, path: str) -> list[Remark]:
    """Remarks on empty cells and literal NaN."""
    return [
        remark
        for d in described
        if d.column.values.dtype.kind != "O"
        for remark in missing_remarks(
            d.name, d.column.empty, d.column.not_a_number, lambda index: content.place(path, index)
        )
    ]


def _texts(described: Sequence[Described], clock: Clock, path: str) -> list[Remark]:
    """Remarks on columns that are no channel because they hold text or dates."""
    remarks = []
    for i, d in enumerate(described):
        if i == clock.column or d.column.is_number:
            continue
        texts = list(dict.fromkeys(str(text) for text in d.column.values))
        some = ", ".join(texts[:SHOWN]) + (", ..." if len(texts) > SHOWN else "")
        what = f"column {d.name!r} is text ({len(texts)} different: {some[:80]}): no channel"
        remarks.append(Remark("text_column", "info", what, where=path, subject=d.name))
    return remarks
