"""When samples of a recording at rest were taken: their interval and averaging time, and stamps that are wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....core.errors import DataError
from ....core.estimate import Array
from ....core.recording import SECOND, Times
from ....core.remarks import Remark
from ....core.show.rounding import number
from ....signals.time.time_axis import TimeAxis, analyse
from .at_rest import AtRest

FLAG = "flag"  # where the sample interval comes from, when the user said it
NOT_TIME = "not_time"  # remark of reading on a column that was taken for no time
AGREES = 0.01  # relative difference of intervals that is passed over
NO_GAP = 1.4  # sample intervals: a longer step is a gap
FEWEST = 2  # samples of a record
SAME_TIME = 1e-3  # relative difference of averaging time and sample interval that is that of two clocks


@dataclass(frozen=True, eq=False)
class Grid:
    """How samples stand in time."""

    interval: float  # From sample to sample [s]
    placed: bool = False  # Whether the stamps put them on the grid of it
    # shape (n,): Time of each since the first [s], for messages, where samples are taken as evenly spaced
    clock: Array | None = None
    remarks: tuple[Remark, ...] = ()  # What to say


def grid_of(one: AtRest) -> Grid:
    """Return the sample interval, whether samples are to be put on its grid by their stamps, and what to say.

    Parameters
    ----------
    one : AtRest
        The recording.

    Raises
    ------
    DataError
        If it has no sample interval (``no_time``), or stamps that are repeated or run backwards.
    """
    recording = one.recording
    said = recording.sample_interval
    stamps = recording.time_ns
    if said is None or not said > 0.0:
        seen = "; ".join(remark.what for remark in recording.remarks if remark.code == NOT_TIME)
        what = "nothing says how far the samples are apart" + (f": {seen}" if seen else "")
        do = "Sort the rows, or s" if seen else "S"
        do += "ay the sample rate (--sample-rate HZ), or name the column of time (--time-column)"
        raise DataError(what, one.place, "every averaging time is counted off in samples", do, "no_time")
    if stamps is None or len(stamps) < FEWEST:
        return Grid(said)
    mean = (int(stamps[-1]) - int(stamps[0])) / SECOND / (len(stamps) - 1)
    if recording.interval_from != FLAG and _is_even(stamps, said):
        return Grid(mean)
    axis = analyse(stamps)
    if recording.interval_from == FLAG:
        return Grid(said, False, recording.seconds, _not_used(axis, one))
    regular = axis.pattern == "regular" and axis.interval is not None
    _refuse_disorder(axis, one, regular)
    if not regular or axis.interval is None:
        what = "stamps say when packets arrived: the samples are taken as evenly spaced, and gaps are not seen"
        return Grid(said, False, recording.seconds, (Remark("stamps_not_used", "warning", what, one.place),))
    uneven = len(axis.gaps) > 0 or abs(axis.interval - said) > AGREES * said
    return Grid(said, True) if uneven else Grid(mean)


def _is_even(stamps: Times, interval: float) -> bool:
    """Whether no step is backward, zero, or long enough for a gap: the quick answer for most records."""
    steps = np.diff(stamps)
    return bool(
        steps.min() > 0 and steps.max() <= NO_GAP * interval * SECOND and steps.mean() > 0.9 * interval * SECOND
    )


def _not_used(axis: TimeAxis, one: AtRest) -> tuple[Remark, ...]:
    """Say what the stamps would have told, where a sample rate was said in their place."""
    lost = axis.lost + len(axis.repeated) + len(axis.backward)
    what = "the sample rate was said: the samples are taken as evenly spaced, and their stamps are not used"
    if not lost:
        return (Remark("stamps_not_used", "info", what, one.place),)
    seen = f"{axis.lost} missing sample(s), {len(axis.repeated)} repeated and {len(axis.backward)} backward stamps"
    return (Remark("stamps_not_used", "warning", f"{what}, though they show {seen}", one.place),)


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


def averaging_of(one: AtRest, interval: float) -> float | None:
    """Return what each sample is the mean of [s]: the sample interval, where the difference is that of two clocks.

    Who says both times says them of one clock, and the stamps may be those of another: their ratio is what counts.

    Parameters
    ----------
    one : AtRest
        The recording.
    interval : float
        From sample to sample, by the stamps [s].

    Raises
    ------
    DataError
        If averages overlap, or last no time.
    """
    said = one.recording.averaging_time
    if said is None:
        return None
    stated = one.recording.sample_interval or interval
    scaled = said * interval / stated if abs(stated / interval - 1.0) <= AGREES else said
    if abs(scaled / interval - 1.0) <= SAME_TIME:
        return interval
    if not 0.0 < scaled <= interval:
        what = f"an averaging time of {number(said)} s every {number(interval)} s"
        why = "averages that overlap share their noise, and 0 s average nothing"
        do = "Say what each sample is the mean of, at most the time from sample to sample"
        raise DataError(what, one.place, why, do, "averaging_time")
    return scaled
