"""Records of a sensor at rest, from recordings: put on the grid of their sample interval, the warm-up left out.

Averaging times are counted off in samples, so samples must stand where they were taken. Stamps that are repeated or run
backwards are refused; gaps become missing samples. Where the stamps say when packets arrived, or a sample rate was said
in their place, the samples are taken as evenly spaced, which is remarked: gaps are then not seen.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.errors import DataError
from ...core.recording import SECOND, Recording, Times
from ...core.remarks import Remark, gather
from ...core.rounding import number
from ...signals.allan import code_remarks, on_grid
from ...signals.allan.prefix import Quantity
from ...signals.time_axis import TimeAxis, analyse
from .plan import Plan, Readings, Run

FLAG = "flag"  # where the sample interval comes from, when the user said it
AGREES = 0.01  # relative difference of intervals that is passed over
LARGEST = 1e60  # reading: beyond it fourth powers overflow
NO_GAP = 1.4  # sample intervals: a longer step is a gap
FEWEST = 2  # samples of a record


@dataclass(frozen=True, eq=False)
class AtRest:
    """A recording of a sensor at rest.

    Parameters
    ----------
    recording : Recording
        With its channels.
    channels : mapping of str to str
        Which channel is which axis.
    scale : mapping of str to float
        SI unit a unit of the channel; 1 where not said.
    quantity : {"rate", "increment", "angle"}
        What its samples are.
    name : str
        For messages; its file where not given.
    """

    recording: Recording
    channels: Mapping[str, str]
    scale: Mapping[str, float] = field(default_factory=dict[str, float])
    quantity: Quantity = "rate"
    name: str = ""

    @property
    def place(self) -> str:
        """Name of the recording, for messages."""
        return self.name or self.recording.source.path or "recording"


def readings_from(plan: Plan, recordings: Sequence[AtRest]) -> Readings:
    """Return the records of a test.

    Parameters
    ----------
    plan : Plan
        Its ``warm_up`` is left out at the start of each.
    recordings : sequence of AtRest
        All with the same axes.

    Raises
    ------
    DataError
        If there is none (``no_records``) or they differ in their axes (``wrong_column``); if one has no sample interval
        (``no_time``), stamps that are repeated (``time_repeated``) or run backwards (``time_backwards``), a channel
        of text (``wrong_column``) or of impossible size (``wrong_value``), or nothing left after the warm-up
        (``nothing_left``).
    """
    if not recordings:
        raise DataError("no recordings of a sensor at rest", code="no_records")
    axes = tuple(recordings[0].channels)
    for one in recordings:
        if tuple(one.channels) != axes:
            what = f"axes {', '.join(one.channels)}, the first recording has {', '.join(axes)}"
            raise DataError(what, one.place, do="Name recordings of the same axes", code="wrong_column")
    found = [_run(plan, one) for one in recordings]
    several = len(recordings) > 1
    remarks = [
        remark.at(one.place) if several else remark
        for one, (_, told) in zip(recordings, found, strict=True)
        for remark in told
    ]
    read = [remark for one in recordings for remark in one.recording.remarks]
    return Readings(tuple(run for run, _ in found), gather([*read, *remarks]))


def _run(plan: Plan, one: AtRest) -> tuple[Run, list[Remark]]:
    interval, places, remarks = _interval(one)
    values: dict[str, NDArray[Any]] = {}
    present: dict[str, NDArray[np.bool_]] = {}
    for axis, name in one.channels.items():
        data = one.recording.channel(name).data
        if data.dtype.kind not in "iuf":
            raise DataError(f"column {name!r} holds no numbers", one.place, code="wrong_column")
        _refuse_sizes(data, name, one)
        remarks += code_remarks(data, axis)
        values[axis], there = _placed(data, one, interval) if places else (data, None)
        if there is not None:
            present[axis] = there
    quantity = one.quantity
    if quantity == "angle":
        values, present = _differenced(values, present)
        quantity = "increment"
    skipped, more = _skipped(plan, one, next(iter(values.values())), interval)
    values = {axis: data[skipped:] for axis, data in values.items()}
    present = {axis: there[skipped:] for axis, there in present.items()}
    scale = {axis: one.scale.get(axis, 1.0) for axis in values}
    averaging = one.recording.averaging_time
    return Run(values, present, scale, interval, averaging, quantity, one.place, skipped), [*remarks, *more]


def _refuse_sizes(data: NDArray[Any], name: str, one: AtRest) -> None:
    """Refuse numbers that are no reading: their squares are beyond what a number can hold."""
    largest = float(np.max(np.abs(data, where=np.isfinite(data), out=np.zeros(len(data))), initial=0.0))
    if largest > LARGEST:
        what = f"column {name!r} reaches {largest:.3g}"
        raise DataError(what, one.place, "no sensor reads so much", "Look at the file", "wrong_value")


def _interval(one: AtRest) -> tuple[float, bool, list[Remark]]:
    """Return the sample interval [s], whether samples are to be put on its grid by their stamps, and what to say."""
    recording = one.recording
    said = recording.sample_interval
    stamps = recording.time_ns
    if said is None or not said > 0.0:
        do = "Say the sample rate (--sample-rate HZ), or name the column of time (--time-column)"
        what = "nothing says how far the samples are apart"
        raise DataError(what, one.place, "every averaging time is counted off in samples", do, "no_time")
    if stamps is None or len(stamps) < FEWEST:
        return said, False, []
    mean = (int(stamps[-1]) - int(stamps[0])) / SECOND / (len(stamps) - 1)
    if recording.interval_from != FLAG and _is_even(stamps, said):
        return mean, False, []
    axis = analyse(stamps)
    if recording.interval_from == FLAG:
        return said, False, _not_used(axis, one)
    regular = axis.pattern == "regular" and axis.interval is not None
    _refuse_disorder(axis, one, regular)
    if not regular or axis.interval is None:
        what = "stamps say when packets arrived: the samples are taken as evenly spaced, and gaps are not seen"
        return said, False, [Remark("stamps_not_used", "warning", what, one.place)]
    uneven = len(axis.gaps) > 0 or abs(axis.interval - said) > AGREES * said
    return (said, True, []) if uneven else (mean, False, [])


def _is_even(stamps: Times, interval: float) -> bool:
    """Whether no step is backward, zero, or long enough for a gap: the quick answer for most records."""
    steps = np.diff(stamps)
    return bool(
        steps.min() > 0 and steps.max() <= NO_GAP * interval * SECOND and steps.mean() > 0.9 * interval * SECOND
    )


def _not_used(axis: TimeAxis, one: AtRest) -> list[Remark]:
    """Say what the stamps would have told, where a sample rate was said in their place."""
    lost = axis.lost + len(axis.repeated) + len(axis.backward)
    what = "the sample rate was said: the samples are taken as evenly spaced, and their stamps are not used"
    if not lost:
        return [Remark("stamps_not_used", "info", what, one.place)]
    seen = f"{axis.lost} missing sample(s), {len(axis.repeated)} repeated and {len(axis.backward)} backward stamps"
    return [Remark("stamps_not_used", "warning", f"{what}, though they show {seen}", one.place)]


def _refuse_disorder(axis: TimeAxis, one: AtRest, regular: bool) -> None:
    """Refuse stamps that run backwards, and repeated ones where each stamp means its own sample."""
    why = "an averaging time is counted off in samples of one order"
    if len(axis.backward):
        what, at, code = f"{len(axis.backward)} stamp(s) run backwards", axis.backward, "time_backwards"
    elif regular and len(axis.repeated):
        what, at, code = f"{len(axis.repeated)} repeated stamp(s)", axis.repeated, "time_repeated"
    else:
        return
    row = one.recording.first_row
    place = f"{one.recording.source.path}:{row + int(at[0])}" if row else f"{one.place}: sample {int(at[0]) + 1}"
    do = (
        "Sort the record, drop what is twice in it, or say the sample rate (--sample-rate HZ): stamps are then not used"
    )
    raise DataError(what, place, why, do, code)


def _placed(data: NDArray[Any], one: AtRest, interval: float) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    stamps = one.recording.time_ns
    assert stamps is not None  # noqa: S101 - asked before
    try:
        return on_grid(data, stamps, interval)
    except DataError as error:
        first = error.problems[0]
        where = f"{one.place}: {first.where}" if first.where else one.place
        raise DataError(first.what, where, first.why, first.do, first.code) from None


def _differenced(
    values: Mapping[str, NDArray[Any]], present: Mapping[str, NDArray[np.bool_]]
) -> tuple[dict[str, NDArray[Any]], dict[str, NDArray[np.bool_]]]:
    """Return the increments of an integrated signal; unsigned codes as signed ones, so that a step back is one."""
    signed = {axis: x.astype(np.int64) if x.dtype.kind == "u" else x for axis, x in values.items()}
    steps = {axis: np.diff(x) for axis, x in signed.items()}
    return steps, {axis: there[1:] & there[:-1] for axis, there in present.items()}


def _skipped(plan: Plan, one: AtRest, data: NDArray[Any], interval: float) -> tuple[int, list[Remark]]:
    """Return how many samples the warm-up takes."""
    count = int(np.ceil(plan.warm_up / interval - 1e-9))
    if count <= 0:
        return 0, []
    if count >= len(data):
        what = f"a warm-up of {number(plan.warm_up)} s, the record is {number(len(data) * interval)} s long"
        raise DataError(what, one.place, do="Leave out less", code="nothing_left")
    what = f"the first {number(plan.warm_up)} s of {number(len(data) * interval)} s are left out (warm_up)"
    return count, [Remark("warm_up_left_out", "info", what)]
