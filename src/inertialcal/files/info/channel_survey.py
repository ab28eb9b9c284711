"""Survey of one channel: range, scatter, resolution step, stuck and clipped samples, missing values."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...core.recording import Channel
from ...core.remarks import Remark, Severity
from ...core.results import finite
from ...signals.codes import Rail, Run, is_stuck, levels_of, longest_run, rails, resolution

NO_CODES = ("index", "time", "status")  # quantities that may repeat or run through their values


@dataclass(frozen=True)
class ChannelSurvey:
    """What a channel holds.

    Parameters
    ----------
    name, axis, quantity, unit, unit_from : str
        As ``core.recording.Channel`` has them; unit None when nobody said.
    dtype : str
        Type of the stored numbers.
    count, missing : int
        Samples, and how many of them have no number.
    minimum, maximum, mean, std : float or None
        In the unit of the channel; None where there is no number.
    resolution : float or None
        Step of which all differences are whole multiples.
    longest_run : Run or None
        Longest stretch of equal values.
    stuck : bool
        Whether it is far longer than the other stretches explain; a constant channel is stuck.
    rails : tuple of Rail
        Extremes at which samples pile up.
    rails_at : tuple of int
        Index of the first sample of each.
    """

    name: str
    axis: str
    quantity: str
    unit: str | None
    unit_from: str
    dtype: str
    count: int
    missing: int
    minimum: float | None = None
    maximum: float | None = None
    mean: float | None = None
    std: float | None = None
    resolution: float | None = None
    longest_run: Run | None = None
    stuck: bool = False
    rails: tuple[Rail, ...] = ()
    rails_at: tuple[int, ...] = ()

    @property
    def is_constant(self) -> bool:
        """Whether all numbers are equal."""
        return self.count - self.missing > 1 and self.minimum == self.maximum

    @property
    def notes(self) -> str:
        """What is odd about the channel: constant, stuck, at its rails."""
        found = []
        if self.is_constant:
            found.append("constant")
        elif self.stuck and self.longest_run is not None:
            found.append(f"stuck for {self.longest_run.length}")
        return ", ".join([*found, *(f"{rail.count} at {rail.value:g}" for rail in self.rails)])

    def to_dict(self) -> dict[str, object]:
        """Return plain values, for ``--json``."""
        run = self.longest_run
        return {
            "name": self.name,
            "axis": self.axis,
            "quantity": self.quantity,
            "unit": self.unit,
            "unit_from": self.unit_from,
            "dtype": self.dtype,
            "missing": self.missing,
            "min": finite(self.minimum),
            "max": finite(self.maximum),
            "mean": finite(self.mean),
            "std": finite(self.std),
            "resolution": finite(self.resolution),
            "longest_run": None if run is None else {"start": run.start, "length": run.length},
            "stuck": self.stuck,
            "clipped": [{"value": rail.value, "count": rail.count} for rail in self.rails],
        }


def survey_channel(channel: Channel) -> ChannelSurvey:
    """Return what a channel holds."""
    index = np.flatnonzero(np.isfinite(channel.data))
    numbers = channel.data[index]
    said = (channel.name, channel.axis, channel.quantity, channel.unit, channel.unit_from)
    dtype, missing = str(channel.data.dtype), len(channel.data) - len(numbers)
    if not len(numbers):
        return ChannelSurvey(*said, dtype, len(channel.data), missing)
    levels = levels_of(numbers)
    with_codes = channel.quantity not in NO_CODES
    values = numbers.astype(np.float64)
    with np.errstate(over="ignore", invalid="ignore"):  # values near the end of float64
        mean, std = float(values.mean()), float(values.std(ddof=1)) if len(values) > 1 else None
    run, piles = longest_run(numbers), rails(levels) if with_codes else ()
    return ChannelSurvey(
        *said,
        dtype,
        len(channel.data),
        missing,
        minimum=float(levels.values[0]),
        maximum=float(levels.values[-1]),
        mean=mean,
        std=std,
        resolution=resolution(levels),
        longest_run=replace(run, start=int(index[run.start])),
        stuck=with_codes and is_stuck(numbers),
        rails=piles,
        rails_at=tuple(int(index[np.argmax(values == pile.value)]) for pile in piles),
    )


def channel_remarks(survey: ChannelSurvey, place: Callable[[int], str]) -> tuple[Remark, ...]:
    """Return what a user should know about a channel.

    Parameters
    ----------
    survey : ChannelSurvey
        Of the channel.
    place : callable
        Gives ``file:row`` of a sample.
    """
    remarks = []
    run = survey.longest_run
    if survey.is_constant:
        severity: Severity = "info" if survey.quantity in NO_CODES else "warning"
        what = f"{survey.name!r} is {survey.minimum:g} throughout"
        remarks.append(Remark("constant_channel", severity, what, place(0), subject=survey.name))
    elif survey.stuck and run is not None:
        what = f"{survey.name!r} stays at {run.value:g} for {run.length} samples: stuck?"
        do = "Leave that stretch out, or record again"
        remarks.append(Remark("stuck", "warning", what, place(run.start), do=do, subject=survey.name))
    for rail, first in zip(survey.rails, survey.rails_at, strict=True):
        code = ", the end of a converter" if rail.is_code else ""
        what = f"{survey.name!r} piles up at {rail.value:g}{code}: clipped?"
        do = "Record with a larger range"
        remarks.append(Remark("clipped", "warning", what, place(first), rail.count, do, subject=survey.name))
    return tuple(remarks)
