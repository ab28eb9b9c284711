"""A survey of a file as text for a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..core.rounding import number
from .output import clean, table, wrapped

if TYPE_CHECKING:
    from ..files.channel_survey import ChannelSurvey
    from ..files.survey import Survey

LONGEST = 40  # characters of a name in the table; --json has it whole


def survey_text(one: Survey) -> str:
    """Return what a file holds: head, channels, time, hints, remarks, and what to type next."""
    parts = [f"{clean(one.path)}: {one.source.format}, {one.rows} rows", _channels(one), _time(one)]
    parts += [wrapped(f"hint: {hint}", "    ") for hint in one.hints]
    parts += [wrapped(str(remark), "    ") for remark in one.remarks]
    if one.next:
        parts.append(f"next: {one.next}")
    return "\n".join(part for part in parts if part)


def _channels(one: Survey) -> str:
    heads = ["  channel", "axis", "what", "unit", "type", "min", "max", "mean", "std", "step", "missing", ""]
    return table([_channel(channel) for channel in one.channels], heads, right=(5, 6, 7, 8, 9, 10))


def _channel(one: ChannelSurvey) -> list[str]:
    notes = []
    if one.is_constant:
        notes.append("constant")
    elif one.stuck and one.longest_run is not None:
        notes.append(f"stuck for {one.longest_run.length}")
    notes += [f"{rail.count} at {rail.value:g}" for rail in one.rails]
    figures = (one.minimum, one.maximum, one.mean, one.std, one.resolution)
    said = one.unit or "?"
    return [
        f"  {_short(one.name)}", one.axis, one.quantity, said, one.dtype, *(number(figure, 5) for figure in figures),
        str(one.missing), ", ".join(notes),
    ]  # fmt: skip


def _short(name: str) -> str:
    """Return a name cut to what a table can show."""
    return name if len(name) <= LONGEST else f"{name[: LONGEST - 1]}…"


def _time(one: Survey) -> str:
    time = one.time
    if time.sample_interval is None:
        return "time: none; give --sample-rate, or --time-column"
    parts = [f"time: {number(time.sample_rate)} Hz ({time.interval_from})"]
    axis = time.axis
    if axis is not None:
        parts.append(f"{number(axis.duration)} s from {time.start}")
        parts.append(f"jitter {number(1e3 * axis.jitter_rms, 3)} ms rms, {number(1e3 * axis.jitter_max, 3)} ms at most")
        parts.append(f"{len(axis.gaps)} gaps ({axis.lost} samples)" if len(axis.gaps) else "no gaps")
        if len(axis.repeated) or len(axis.backward):
            parts.append(f"{len(axis.repeated)} stamps repeated, {len(axis.backward)} unsorted")
    return wrapped("; ".join(parts), "    ")
