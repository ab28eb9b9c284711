"""A survey of a file as tables: channels, time, hints, remarks, what to type next."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...core.show.result_tables import told
from ...core.show.rounding import number
from ...core.show.tables import Grid, Part, ending

if TYPE_CHECKING:
    from .channel_survey import ChannelSurvey
    from .survey import Survey

HEADS = ("channel", "axis", "what", "unit", "min", "max", "mean", "std", "missing", "")


def survey_parts(one: Survey) -> tuple[Part, ...]:
    """Return what is shown of a survey; `info` prints it with type and resolution step of each channel too."""
    caption = f"{ending(one.path)}: {one.source.format}, {one.rows} rows"
    grid = Grid(HEADS, [_cells(channel) for channel in one.channels], caption, (4, 5, 6, 7, 8))
    hints = tuple(f"hint: {hint}" for hint in one.hints)
    ends = (f"next: {one.next}",) if one.next else ()
    return (grid, time_line(one), *hints, *told(one.remarks), *ends)


def _cells(one: ChannelSurvey) -> tuple[str, ...]:
    figures = (number(figure, 5) for figure in (one.minimum, one.maximum, one.mean, one.std))
    return one.name, one.axis, one.quantity, one.unit or "?", *figures, str(one.missing), notes(one)


def notes(one: ChannelSurvey) -> str:
    """Return what is odd about a channel: constant, stuck, at its rails."""
    found = []
    if one.is_constant:
        found.append("constant")
    elif one.stuck and one.longest_run is not None:
        found.append(f"stuck for {one.longest_run.length}")
    return ", ".join([*found, *(f"{rail.count} at {rail.value:g}" for rail in one.rails)])


def time_line(one: Survey) -> str:
    """Return one line on the time: rate, span, jitter, gaps."""
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
    return "; ".join(parts)
