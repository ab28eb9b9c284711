"""What motion the heads share: clock offsets between them, and heads that do not move as the body does.

All heads of one body feel its acceleration. Where that exceeds their noise, the products of what two heads read, over
all axes and lags, tell the offset of their clocks; at that offset the matrix of products tells the rotation between
them (the nearest rotation, by its singular values [1]_), the ratio of their units, and whether they move together.
What turns of the body add differs from head to head, so only gross departures count here.

References
----------
.. [1] P. H. Schonemann, Psychometrika 31 (1966) 1 (orthogonal Procrustes).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import correlate

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.remarks import Remark
from ...core.show.rounding import number, uncertainty
from .grid import body_means, interval_means
from .readings import Flags, Readings, Track, edges_of

MOST = 100_000  # samples that are looked at
PARTS, FEWEST = 8, 5  # of a record, whose lags are compared, and that must tell one
CARRIED = 0.5  # correlation at the best lag, from which motion is shared
BROAD = 0.9  # of the peak, that no other lag may reach
NEAR = 3  # samples about the lag of the whole record, within which those of its parts lie
ROUNDS, TINY = 4, 1e-3  # of the refinement; of a step: what interpolation is good for
CELL = 0.02  # of a sample, from which an offset matters
SEEN, SURE = 3.0, 4.0  # standard uncertainties: an offset is told; it disagrees with what is stated
TURNED = 0.6  # of the correlation after the best rotation, that is there before it
ALONE = 0.3  # of the power that others share, that a head of this body has at least
UNITS = 2.0  # ratio of what heads read, from which a unit is wrong
FACTORS = {9.80665: "m/s^2 read as g, or g as m/s^2", 1e3: "a prefix of 1000", 1e6: "a prefix of a million"}


@dataclass(frozen=True, eq=False)
class Offset:
    """How late the clock of a head is against that of the first one, beyond what was stated."""

    name: str
    late: float  # [s]
    u: float  # [s]


def common(readings: Readings, start: float, stop: float) -> tuple[Array, float]:
    """Return what all heads read on one grid, in axes of the body, without mean and slope; and its step [s]."""
    step = max(*(one.interval for one in readings.tracks), (stop - start) / MOST)
    found = body_means(readings, edges_of(start, stop, step))
    there = np.isfinite(found).all(axis=(0, 2))
    time = np.linspace(-1.0, 1.0, found.shape[1])
    design = np.column_stack([np.ones_like(time), time])
    for i, one in enumerate(found):
        found[i] = one - design @ np.linalg.lstsq(design[there], one[there], rcond=None)[0]
    found[:, ~there] = 0.0
    return found, step


def offsets(readings: Readings, series: Array, step: float, most: float) -> list[Offset]:
    """Return clock offsets against the first calibrated head, of those heads whose motion tells them."""
    tracks = readings.tracks
    first = next(i for i, one in enumerate(tracks) if one.mounted.calibrated)
    found = []
    for i, one in enumerate(tracks):
        if i == first:
            continue
        lag = _lag(series[first], series[i], round(most / step))
        if lag is None:
            lag = _lag(np.diff(series[first], axis=0), np.diff(series[i], axis=0), round(most / step))
        fine = None if lag is None else _refined(tracks[first], one, lag * step, step)
        if fine is not None:
            found.append(Offset(one.mounted.name, *fine))
    return found


def _refined(one: Track, other: Track, late: float, step: float) -> tuple[float, float] | None:
    """Return the offset at which what two heads differ by has no part of the change of the motion, and its u [s].

    The uncertainty is by parts of the record.
    """
    parts = np.zeros(0)
    for _ in range(ROUNDS):
        start = max(float(one.times[0]), float(other.times[0]) - late) + step
        stop = min(float(one.times[-1]), float(other.times[-1]) - late) - step
        edges = edges_of(start, stop, step)
        if len(edges) < PARTS * FEWEST:
            return None
        a = interval_means(one.times, one.body, one.interval, edges)
        b = interval_means(other.times - late, other.body, other.interval, edges)
        there = np.isfinite(a).all(axis=1) & np.isfinite(b).all(axis=1)
        a, b = a[there] - a[there].mean(axis=0), b[there] - b[there].mean(axis=0)
        change = np.gradient(0.5 * (a + b), step, axis=0)
        pull, weight = np.sum(change * (b - a), axis=1), np.sum(change**2, axis=1)
        if not weight.sum() > 0.0:
            return None
        sums = [(float(p.sum()), float(w.sum())) for p, w in zip(np.array_split(pull, PARTS),
                np.array_split(weight, PARTS), strict=True)]  # fmt: skip
        total = float(weight.sum())
        mean = float(pull.sum()) / total
        parts = np.array([(p - mean * w) / total for p, w in sums])
        late -= mean
    return late, float(np.sqrt(np.sum(parts**2) * PARTS / (PARTS - 1)) + TINY * step)


def _lag(one: Array, other: Array, most: int) -> float | None:
    """Return by how many samples another series is late; None where nothing tells."""
    most = min(most, len(one) // 4)
    size = float(np.sqrt(np.sum(one**2) * np.sum(other**2)))
    if most < NEAR or size == 0.0:
        return None
    middle = len(one) - 1
    squares = np.zeros(2 * most + 1)
    for a in one.T:
        for b in other.T:
            squares += correlate(b, a, method="fft")[middle - most : middle + most + 1] ** 2
    at = int(np.argmax(squares))
    if np.sqrt(squares[at]) < CARRIED / np.sqrt(3.0) * size or not NEAR <= at <= 2 * most - NEAR:
        return None
    others = np.concatenate([squares[: max(at - 2 * NEAR, 0)], squares[at + 2 * NEAR :]])
    if not len(others) or others.max() > BROAD**2 * squares[at]:
        return None
    return float(at - most)


def clocks(readings: Readings, found: list[Offset]) -> tuple[dict[str, tuple[float, float]], list[Remark]]:
    """Return offsets to take off, with their uncertainty, where the readings tell them better, and remarks.

    Raises
    ------
    DataError
        ``clock_offset`` where what was stated disagrees with the readings.
    """
    by_name = {one.mounted.name: one for one in readings.tracks}
    first = next(one for one in readings.tracks if one.mounted.calibrated)
    late, remarks = {}, []
    for one in found:
        track = by_name[one.name]
        stated = float(np.hypot(track.mounted.clock_u, first.mounted.clock_u))
        said = track.mounted.clock is not None or track.mounted.clock_u > 0.0
        what = f"the clock of head {one.name} is {number(one.late, 4)} s (u {uncertainty(one.u)} s) ahead of that of "
        what += first.mounted.name
        if said and abs(one.late) > SURE * np.hypot(one.u, stated) and abs(one.late) > CELL * track.interval:
            do = f"Correct clock of heads.{one.name}, or leave it out: the readings tell it"
            what += f", beyond what is stated (u {uncertainty(stated)} s)"
            raise DataError(what, track.file, "heads are compared instant by instant", do, "clock_offset")
        if said and one.u >= stated:
            continue
        late[one.name] = one.late, one.u
        if abs(one.late) > SEEN * one.u and abs(one.late) > CELL * track.interval:
            what += ", by the motion that both read: it is taken off"
            remarks.append(Remark("clock_estimated", "info" if said else "warning", what, track.file,
                                  do="" if said else "State it, if it is known", recording=track.name))  # fmt: skip
    return late, remarks


def checked(readings: Readings, series: Array) -> list[Remark]:
    """Refuse heads that do not move as the others do; return a remark where too little motion is shared to tell.

    Raises
    ------
    DataError
        ``not_one_body``, ``wrong_unit``, ``wrong_orientation``.
    """
    tracks, n = readings.tracks, len(readings.tracks)
    size = np.sqrt(np.sum(series**2, axis=(1, 2)) / series.shape[1])
    shared, before, turns = np.zeros((n, n)), np.zeros((n, n)), {}
    for i in range(n):
        for j in range(n):
            if i != j:
                product = series[i].T @ series[j] / series.shape[1]
                left, singular, right = np.linalg.svd(product)
                turns[i, j] = left @ right
                shared[i, j], before[i, j] = float(np.sum(singular)), float(np.trace(product))
    if not size.all():
        one = tracks[int(np.argmin(size))]
        what = f"head {one.mounted.name} does not read anything: all samples are equal"
        raise DataError(what, one.file, do="Leave it out", code="not_one_body")
    likeness = shared / np.outer(size, size)
    together = likeness > CARRIED
    if not together.any():
        what = "the heads share no motion above their noise: that they are on one body, their orientations, units and"
        what += " clocks could not be tested"
        return [Remark("quiet", "info", what, do="Add a stretch with a manoeuvre, or with crew and machines at work")]
    _one_body(tracks, shared, together)
    _units(tracks, shared)
    wrong = together & (before < TURNED * shared)
    if wrong.any():
        at = int(np.argmax(wrong.sum(axis=1)))
        other = next(j for j in range(n) if j != at and wrong[at, j])
        turn = tracks[at].mounted.orientation @ turns[at, other]
        named = f"head {tracks[at].mounted.name}"
        if wrong.sum() <= 2:
            named = f"head {tracks[at].mounted.name} or {tracks[other].mounted.name}"
        what = f"{named} reads the motion along other axes than its orientation says"
        raise DataError(what, tracks[at].file, _axes_text(turn), "Check orientation and order of its columns",
                        "wrong_orientation")  # fmt: skip
    return []


def _axes_text(turn: Array) -> str:
    """Return which axis of a head is which of the body, where a rotation is near one."""
    order = np.argmax(np.abs(turn), axis=1)
    if len(set(order.tolist())) < len(AXES) or np.min(np.abs(turn[np.arange(3), order])) < CARRIED:
        return "no exchange of axes explains it"
    named = [f"{axis} is {'-' if turn[i, at] < 0.0 else ''}{AXES[at]} of the body"
             for i, (axis, at) in enumerate(zip(AXES, order.tolist(), strict=True))]  # fmt: skip
    return f"what it reads fits if its {', '.join(named)}"


def _one_body(tracks: tuple[Track, ...], shared: Array, together: Flags) -> None:
    """Refuse a head that has no part in what the others share."""
    alone = np.flatnonzero(~together.any(axis=1))
    inside = np.flatnonzero(together.any(axis=1))
    power = float(np.max(shared[np.ix_(inside, inside)]))
    for i in alone.tolist():
        if float(np.max(shared[i, inside])) < ALONE * power:
            names = ", ".join(tracks[j].mounted.name for j in inside.tolist())
            what = f"head {tracks[i].mounted.name} does not move as {names} do"
            do = "Check that it is on the same body, at the same time, and that it works"
            raise DataError(what, tracks[i].file, "on a rigid body they would", do, "not_one_body")


def _units(tracks: tuple[Track, ...], shared: Array) -> None:
    """Refuse a head that reads many times what the others do."""
    n = len(tracks)
    own = np.zeros(n)
    for i in range(n):
        pairs = [(j, k) for j in range(n) for k in range(j) if i not in (j, k)]
        own[i] = np.median([np.sqrt(shared[i, j] * shared[i, k] / max(shared[j, k], 1e-300)) for j, k in pairs])
    ratio = own / np.median(own)
    at = int(np.argmax(np.abs(np.log(np.maximum(ratio, 1e-300)))))
    size = max(ratio[at], 1.0 / max(ratio[at], 1e-300))
    if size > UNITS:
        near = next((text for factor, text in FACTORS.items() if abs(np.log(size / factor)) < 0.2), "")
        what = f"head {tracks[at].mounted.name} reads {number(float(ratio[at]), 3)} times the motion that the others do"
        do = f"Check its unit{f': {near}' if near else ''}, and its gain"
        raise DataError(what, tracks[at].file, "heads on one body read alike", do, "wrong_unit")
