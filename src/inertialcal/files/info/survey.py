"""Survey of a file: what ``info`` shows. Nothing is judged here that a result depends on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ...core.key import AXES
from ...core.recording import Channel, ClockRate, Recording, Source
from ...core.remarks import Remark, gather
from ...core.results import finite
from ...core.show.result_tables import remarks_line
from ...core.show.rounding import number, uncertainty
from ...core.show.tables import Block, Table, ending, html, text
from ...core.units import kind
from ...signals.screening.screen import NO_READINGS
from ...signals.time.time_axis import TimeAxis, analyse
from ..budget import SURVEY, claim_recording
from ..text.headers import UNNAMED, is_set_point
from ..time.stamps import time_remarks
from .channel_survey import ChannelSurvey, Hint, channel_remarks, screened, survey_channel, unit_hints
from .motion import is_sensed, motion_remarks
from .sense import sense_remarks
from .table_columns import guess_channels

SENSORS = ("gyro", "acc")
HEADS = ("channel", "axis", "what", "unit", "min", "max", "mean", "std", "missing", "")

NAMELESS = (
    "positions: --column acc_x=COLUMN (likewise acc_y, acc_z, gyro_x, ...) --unit acc=UNIT; rate-table: --axis AXIS "
    "--column applied=COLUMN --column x=COLUMN --unit UNIT; thermal: --column x=COLUMN --column temperature=COLUMN "
    "--unit UNIT --unit temperature=UNIT"
)


@dataclass(frozen=True)
class TimeSurvey:
    """Time of a file."""

    epoch: Literal["utc", "elapsed"] | None  # What time zero is; None where the file has no time
    start: str | None  # First stamp: an instant, or seconds
    sample_interval: float | None  # Nominal [s]
    interval_from: str  # Where it comes from; empty where there is none
    axis: TimeAxis | None  # What the stamps say; None where there are fewer than two
    clock: ClockRate | None = None  # To what their rate is known, where who recorded them found that out

    @property
    def sample_rate(self) -> float | None:
        """Nominal sampling frequency [Hz]."""
        return 1.0 / self.sample_interval if self.sample_interval else None

    def __str__(self) -> str:
        """One line: rate, span, jitter, gaps."""
        if self.sample_interval is None:
            return "time: none; add --sample-rate or --time-column"
        parts = [f"time: {number(self.sample_rate)} Hz ({self.interval_from})"]
        axis = self.axis
        if axis is not None:
            parts.append(f"{number(axis.duration)} s from {self.start}")
            jitter = f"{number(1e3 * axis.jitter_rms, 3)} ms rms, {number(1e3 * axis.jitter_max, 3)} ms at most"
            parts.append(f"jitter {jitter}")
            parts.append(f"{len(axis.gaps)} gaps ({axis.lost} samples)" if len(axis.gaps) else "no gaps")
            if len(axis.repeated) or len(axis.backward):
                parts.append(f"{len(axis.repeated)} stamps repeated, {len(axis.backward)} unsorted")
        if self.clock is not None:
            parts.append(f"rate of the clock known to {uncertainty(100.0 * self.clock.u)} % (standard uncertainty)")
        return "; ".join(parts)

    def to_dict(self) -> dict[str, object]:
        """Return plain values, for ``--json``; times in s."""
        said: dict[str, object] = {
            "epoch": self.epoch,
            "start": self.start,
            "sample_rate": finite(self.sample_rate),
            "sample_interval": finite(self.sample_interval),
            "interval_from": self.interval_from,
        }
        if self.clock is not None:
            said["clock_rate_u"] = self.clock.u
        axis = self.axis
        if axis is None:
            return said
        return said | {
            "duration": finite(axis.duration),
            "pattern": axis.pattern,
            "median_step": finite(axis.median_step),
            "longest_step": finite(axis.longest_step),
            "jitter_rms": finite(axis.jitter_rms),
            "jitter_max": finite(axis.jitter_max),
            "gaps": len(axis.gaps),
            "missing_samples": axis.lost,
            "steps": [{"step": step, "count": count} for step, count in axis.steps],
            "repeated": len(axis.repeated),
            "unsorted": len(axis.backward),
        }


@dataclass(frozen=True)
class Survey:
    """What a file holds.

    Parameters
    ----------
    source : Source
        Path, SHA-256, format.
    rows : int
        Samples.
    channels : tuple of ChannelSurvey
        One a channel.
    time : TimeSurvey
        Time axis and sample rate.
    hints : tuple of Hint
        At units that nobody said.
    remarks : tuple of Remark
        Of reading, and of the survey.
    next : str or None
        Command to type next; the survey itself knows none.
    compensated_by : str
        Of the recording.
    """

    source: Source
    rows: int
    channels: tuple[ChannelSurvey, ...]
    time: TimeSurvey
    hints: tuple[Hint, ...]
    remarks: tuple[Remark, ...]
    next: str | None = None
    compensated_by: str = ""

    @property
    def do(self) -> str:
        """What to do before figures of this file are used; empty where nothing is wrong."""
        loud = [one for one in self.remarks if one.severity != "info"]
        known = {one.name for one in self.channels}
        named = [name for name in dict.fromkeys(one.subject for one in loud) if name in known]
        errors = sum(one.severity == "error" for one in loud)
        parts = [f"correct the {'error' if errors == 1 else 'errors'} first"] if errors else []
        parts += [f"look at {', '.join(map(repr, named))} first"] if named else []
        if any(one.code in NO_READINGS for one in loud):
            parts.append("tests leave out the samples that are no readings, and give figures with and without them")
        return "; ".join(parts)

    @property
    def path(self) -> str:
        """Path as given."""
        return self.source.path

    @property
    def sha256(self) -> str:
        """SHA-256 of the file."""
        return self.source.sha256

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: a row a channel, the time, hints, how many remarks, what to type next.

        `info` prints it with type and resolution step of each channel too.
        """
        caption = f"{ending(self.path)}: {self.source.format}, {self.rows} rows"
        rows = []
        for one in self.channels:
            figures = [number(figure, 5) for figure in (one.minimum, one.maximum, one.mean, one.std)]
            rows.append((one.name, one.axis, one.quantity, one.unit or "?", *figures, str(one.missing), one.notes))
        grid = Table(HEADS, rows, caption, (4, 5, 6, 7, 8))
        hints = tuple(f"hint: {hint}" for hint in self.hints)
        ends = tuple(f"{word}: {said}" for word, said in (("do", self.do), ("next", self.next)) if said)
        return (grid, str(self.time), *hints, *remarks_line(self.remarks), *ends)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())

    def to_dict(self) -> dict[str, Any]:
        """Return plain values, for ``--json``."""
        return {
            "path": self.source.path,
            "sha256": self.source.sha256,
            "format": self.source.format,
            "rows": self.rows,
            "compensated_by": self.compensated_by,
            "channels": [channel.to_dict() for channel in self.channels],
            "time": self.time.to_dict(),
            "hints": [str(hint) for hint in self.hints],
            "remarks": [remark.to_dict() for remark in self.remarks],
            "do": self.do,
            "next": self.next,
        }


def survey_recording(recording: Recording) -> Survey:
    """Return what a recording holds.

    Parameters
    ----------
    recording : Recording
        As read.
    """
    claim_recording(recording, SURVEY)
    channels = tuple(survey_channel(channel) for channel in recording.channels)
    motion = motion_remarks(recording, channels)
    at_rest = not any(remark.code == "not_at_rest" for remark in motion)
    readings = [channel.data for channel in recording.channels if is_sensed(channel)]
    applied = guess_channels(recording.channels).applied
    channels = tuple(
        screened(
            survey,
            channel.data,
            at_rest and is_sensed(channel),
            readings,
            recording.time_ns,
            channel.name == applied or _is_course(channel),
        )
        for survey, channel in zip(channels, recording.channels, strict=True)
    )
    path, first = recording.source.path, recording.first_row

    def place(index: int) -> str:
        """Return ``file:row`` of a sample, as far as rows have a meaning."""
        return f"{path}:{first + index}" if first else f"{path}: sample {index + 1}"

    hints = unit_hints(recording, channels)
    remarks = gather(
        (
            *recording.remarks,
            *time_remarks(recording),
            *(remark for one in channels for remark in channel_remarks(one, place, _is_aside(one, channels))),
            *sense_remarks(recording),
            *nameless_remarks(recording),
            *motion,
        )
    )
    return Survey(
        source=recording.source,
        rows=len(recording),
        channels=channels,
        time=_time(recording),
        hints=hints,
        remarks=remarks,
        compensated_by=recording.compensated_by,
    )


def _is_course(channel: Channel) -> bool:
    """Whether a channel holds an angle of no gyro, or what a controller was asked for."""
    is_angle = channel.unit is not None and kind(channel.unit) == "angle" and channel.quantity != "gyro"
    return (is_angle and not channel.axis) or is_set_point(channel.name)


def nameless_remarks(recording: Recording) -> tuple[Remark, ...]:
    """Return what can be typed of a file whose columns, several, have no names."""
    channels = [one for one in recording.channels if one.quantity != "index"]
    if len(channels) < len(AXES) or any(
        one.axis or one.quantity or not UNNAMED.fullmatch(one.name) for one in channels
    ):
        return ()
    what = f"{len(channels)} columns of {len(recording):,} rows without names: say which is which, by name or number"
    return (Remark("nameless_columns", "info", what, where=recording.source.path, do=NAMELESS),)


def _is_aside(channel: ChannelSurvey, channels: Sequence[ChannelSurvey]) -> bool:
    """Whether nobody knows what a channel is, in a file whose sensors are known."""
    return not channel.quantity and any(one.axis and one.quantity in SENSORS for one in channels)


def _time(recording: Recording) -> TimeSurvey:
    """Time axis, as the recording has it."""
    stamps = recording.time_ns
    interval, source = recording.sample_interval, recording.interval_origin
    if stamps is None or not len(stamps):
        return TimeSurvey(None, None, interval, source, None)
    utc = recording.epoch == "utc"
    start = f"{np.datetime64(int(stamps[0]), 'ns')}Z" if utc else f"{stamps[0] / 1e9:.9g} s"
    axis = analyse(stamps, recording.averaging_time) if len(stamps) > 1 else None
    return TimeSurvey(recording.epoch, start, interval, source, axis, recording.clock)
