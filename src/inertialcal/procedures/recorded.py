"""What every recording gives, whichever test reads it: how it was sampled and saved, what its built-in test said.

All figures are of the recording as it was saved, whatever windows a test takes of it::

    save_interval = mean step from one stamp to the next, late ones left out
    sample_rate   = 1 / save_interval
    late_saves    = late steps / steps                            late: longer than jitter explains
    skipped_saves = saves that had room in late steps / (saves + skipped saves)
    longest_gap   = longest step
    built_in_test = samples at or above the lowest good voltage / samples

Assumed: stamps err by less than a unit of the last decimal that their steps have (at most 1 s; 60 s where all are whole
minutes), taken as the width of a rectangular distribution, and by the jitter that their steps show. Regular saves every
2 s are stamps of whole seconds, not of every other one. ``clock.rate`` is one unknown for all recordings: it
stretches every time alike. Without it times hold by the clock of the recording, which the reason says. Where stamps
come in bursts nobody can tell a skipped save from a late packet: neither is estimated, the interval is the mean step.
Counts have no uncertainty: they are compared with their limits as they are.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from ..core.curve import Column, Curve
from ..core.errors import DataError
from ..core.estimate import Array
from ..core.influence import Influence
from ..core.key import Key, Member, Reason
from ..core.recording import SECOND, Recording
from ..core.results import Row, not_estimated
from ..signals.time.time_axis import TimeAxis, analyse
from ..statistics.intervals import t_interval
from .protocol import RELATIVE, Quantity

SAVE_INTERVAL, SAMPLE_RATE, LONGEST_GAP = "save_interval", "sample_rate", "longest_gap"
SAVES = "save_intervals"  # curve of a recording
LATE_SAVES, SKIPPED_SAVES, BUILT_IN_TEST = "late_saves", "skipped_saves", "built_in_test"
QUANTITIES: Mapping[str, Quantity] = MappingProxyType(
    {
        SAVE_INTERVAL: Quantity(("time",), unit="s", shown="s"),
        SAMPLE_RATE: Quantity(("frequency",), unit="Hz", shown="Hz"),
        LONGEST_GAP: Quantity(("time",), unit="s", shown="s"),
        LATE_SAVES: Quantity(RELATIVE, size=True, unit="1", shown="%"),
        SKIPPED_SAVES: Quantity(RELATIVE, size=True, unit="1", shown="%"),
        BUILT_IN_TEST: Quantity(RELATIVE, size=True, unit="1", shown="%"),
    }
)
RESOLUTIONS = (60 * SECOND, *(10**power for power in range(9, -1, -1)))  # that clocks print stamps with [ns]
CLOCK = "clock.rate"  # standard behind all times
COUNTED = frozenset({LATE_SAVES, SKIPPED_SAVES, BUILT_IN_TEST})  # figures that are exact
NO_TIME = Reason("no_time", "the recording has no time")
BURSTS = Reason("bursts", "stamps come in bursts: a late or skipped save looks like a late packet")
OWN_CLOCK = Reason("own_clock", "by the clock of the recording: clock.rate is not stated")


def recorded_rows(
    name: str, recording: Recording, tested: Mapping[str, Array], lowest: float | None, clock: Influence | None
) -> list[Row]:
    """Return the rows that a recording gives, SI.

    Parameters
    ----------
    name : str
        Of the recording.
    recording : Recording
        As its file has it.
    tested : mapping of str to ndarray, shape (n,)
        Voltage of the built-in test by axis [V]; NaN where missing, which is not good.
    lowest : float or None
        Lowest voltage of a good built-in test [V].
    clock : Influence or None
        Relative uncertainty of the rate of its clock, where stated.
    """
    member = Member("recording", name)
    rows = [*_of_time(recording, clock, member)]
    if lowest is not None:
        rows += [
            _counted(Key(BUILT_IN_TEST, axis), int(np.sum(volts >= lowest)), len(volts), "samples", member)
            for axis, volts in tested.items()
            if len(volts)
        ]
    return rows


def saves_curve(name: str, recording: Recording) -> Curve | None:
    """Return how often each time from one save to the next occurs, to a quarter of the interval, the shortest first.

    None of a recording without late saves, or whose stamps come in bursts. Of more than twelve lengths the most
    frequent ones are there.

    Parameters
    ----------
    name : str
        Of the recording.
    recording : Recording
        As its file has it.
    """
    try:
        axis = None if recording.time_ns is None else analyse(recording.time_ns)
    except DataError:
        axis = None
    if axis is None or not len(axis.gaps):
        return None
    steps = sorted(axis.steps)
    columns = {"length": Column([length for length, _ in steps], "s"), "count": Column([count for _, count in steps])}
    return Curve(SAVES, "", columns, recording=name)


def _of_time(recording: Recording, clock: Influence | None, member: Member) -> list[Row]:
    try:
        axis = None if recording.time_ns is None else analyse(recording.time_ns)
    except DataError:
        axis = None
    if axis is None or recording.time_ns is None or not axis.interval:
        units = {SAVE_INTERVAL: "s", SAMPLE_RATE: "Hz", LONGEST_GAP: "s", LATE_SAVES: "1", SKIPPED_SAVES: "1"}
        return [_without(one, unit, NO_TIME, member) for one, unit in units.items()]
    steps, late = axis.n - 1, len(axis.gaps)
    kept = steps - late
    interval = (axis.duration - float(axis.gaps.length.sum())) / kept
    stamp = _u_of_step(recording, axis)
    u = stamp * math.sqrt(late + 1.0) / kept  # both ends of each stretch between late steps
    rate = 0.0 if clock is None else clock.u
    dof = math.inf if clock is None else clock.dof
    reason = OWN_CLOCK if clock is None else Reason()
    figures = [
        (SAVE_INTERVAL, interval, math.hypot(u, rate * interval), "s"),
        (SAMPLE_RATE, 1.0 / interval, math.hypot(u / interval, rate) / interval, "Hz"),
        (LONGEST_GAP, axis.longest_step, math.hypot(stamp, rate * axis.longest_step), "s"),
    ]
    sign = {SAMPLE_RATE: -1.0}  # a clock that is fast by rate makes intervals long, and rates low
    shared = {one: {} if clock is None else {CLOCK: sign.get(one, 1.0) * rate * value} for one, value, *_ in figures}
    rows = [
        Row(Key(one), value, u, unit, dof, t_interval(value, u, dof), reason=reason, member=member, shared=shared[one])
        for one, value, u, unit in figures
    ]
    if axis.pattern == "bursts":
        return [*rows, *(_without(one, "1", BURSTS, member) for one in (LATE_SAVES, SKIPPED_SAVES))]
    rows.append(_counted(Key(LATE_SAVES), late, steps, "steps", member))
    return [*rows, _counted(Key(SKIPPED_SAVES), axis.lost, axis.n + axis.lost, "saves due", member)]


def _counted(key: Key, count: int, whole: int, what: str, member: Member) -> Row:
    return Row(key, count / whole, None, "1", member=member, reason=Reason("counted", f"{count} of {whole} {what}"))


def _without(quantity: str, unit: str, reason: Reason, member: Member) -> Row:
    return not_estimated(Key(quantity), unit, reason, member=member)


def _u_of_step(recording: Recording, axis: TimeAxis) -> float:
    """Return the standard uncertainty of the time from one stamp to another: of both ends [s]."""
    assert recording.time_ns is not None  # noqa: S101 - whoever analysed it
    common = int(np.gcd.reduce(np.abs(np.diff(recording.time_ns))))
    resolution = next(one for one in RESOLUTIONS if common % one == 0) / SECOND
    return math.hypot(resolution / math.sqrt(6.0), axis.jitter_rms)
