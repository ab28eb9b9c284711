"""A survey of a file as text for a terminal."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ...core.remarks import Remark
from ...core.show.rounding import number
from ...core.show.tables import short
from .output import clean, table, wrapped

if TYPE_CHECKING:
    from ...files.info.channel_survey import ChannelSurvey
    from ...files.info.survey import Survey


def survey_text(one: Survey) -> str:
    """Return what a file holds: head, channels, time, hints, remarks, and what to type next."""
    parts = [
        wrapped(f"{one.path}: {one.source.format}, {one.rows} rows"),
        _channels(one),
        wrapped(str(one.time), "    "),
    ]
    parts += [wrapped(f"hint: {hint}", "    ") for hint in one.hints]
    parts += [wrapped(str(_short(remark, one.path)), "    ") for remark in one.remarks]
    if one.do:
        parts.append(wrapped(f"do: {one.do}", "    "))
    if one.next:
        parts.append(clean(f"next: {one.next}"))
    return "\n".join(part for part in parts if part)


def _short(remark: Remark, path: str) -> Remark:
    """Return a remark whose place has the name of the file alone: its folder stands in the first line."""
    if not remark.where.startswith(path):
        return remark
    return replace(remark, where=Path(path).name + remark.where.removeprefix(path))


def _channels(one: Survey) -> str:
    heads = ["  channel", "axis", "what", "unit", "type", "min", "max", "mean", "std", "step", "missing", ""]
    return table([_channel(channel) for channel in one.channels], heads, right=(5, 6, 7, 8, 9, 10))


def _channel(one: ChannelSurvey) -> list[str]:
    figures = (one.minimum, one.maximum, one.mean, one.std, one.resolution)
    said = one.unit or "?"
    return [
        f"  {short(one.name)}", one.axis, one.quantity, said, one.dtype, *(number(figure, 5) for figure in figures),
        str(one.missing), one.notes,
    ]  # fmt: skip
