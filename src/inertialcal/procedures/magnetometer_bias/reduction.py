"""Bias of a gyro from the field of the earth along an orbit, with no attitude known.

Estimated, jointly: the bias of the gyro, that of the magnetometer, and where asked the magnetometer's scale factors,
from arcs of some minutes each of which has an attitude of its own (module ``arcs``; the search begins as in
``start``).

Assumed: both triads are rigid to each other and share a clock and axes; the bias is constant over the record; the
body turns little between two samples; the field is that of the model but for errors that differ from arc to arc,
whose scatter is in the uncertainty, and one that is the same all along, which is Type B (``earth_field.uniform``).
What the gyro reads too much or too little of the turns of the body (scale factor, misalignment) and an angle between
the triads are Type B alike: without them stated figures are relative, and a remark says so.

The uncertainty is that of the mean over the record, by the scatter of the arcs. How well each part of the record knows
the bias (observability) is the curve ``magnetometer_bias_known``.

Where real data break it, by remark: magnetorquers and glitches (``disturbed``: left out), a bias that drifts
(``bias_drifts``), a clock of the orbit that is off (``clock_offset``), scale factors of the magnetometer that are not
estimated (``scale_factor_seen``), a direction that is hardly known (``weak_direction``); axes of the two triads that
do not belong together (``axes_disagree``) and readings that fit no rigid body (``no_fit``) are refused.

References
----------
.. [1] M. L. Psiaki, F. Martel, P. K. Pal, J. Guid. Control Dyn. 13 (1990) 506: attitude and rates from magnetometers.
.. [2] R. Alonso, M. D. Shuster, J. Astronaut. Sci. 50 (2002) 477: magnetometer bias without attitude.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, permutations, product

import numpy as np

from ...core.curve import Column, Curve
from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.influence import Influence
from ...core.key import AXES, Key, Origin, Reason
from ...core.remarks import Remark
from ...core.results import Row
from ...core.show.result_tables import estimate_table, remarks_line
from ...core.show.rounding import items, number, uncertainty
from ...core.show.tables import Block, html, text
from ...core.unknowns import joined
from ...statistics.intervals import t_interval
from ..corrections import ACROSS, SCALE, components
from .arcs import Arc, Noise, Solution, solved
from .plan import INFLUENCES, Plan
from .readings import BLOCK, Readings, Track, sets_of
from .start import best_start, by_magnitude, by_pairs

FEWEST = 6  # arcs, whose scatter the uncertainty rests on
APART = 1.5  # intervals between two samples of the gyro, from which it is a gap
OUTLIER, FAR_OUT = 6.0, 10.0  # robust standard deviations: of the magnitude of the field; of what a reading leaves
SURE = 5.0  # standard uncertainties, from which a departure is told
RISK = 1e-3  # of a remark without cause
WEAK = 10.0  # largest over smallest uncertainty of the bias, by direction
OTHER_AXES = 0.3  # of what is left with the axes as named, that is left with others
OTHER_SENSE = 0.8  # of what is left, that is left with the magnetometer turned round
LIKELY = 3.0  # times what noise leaves of pairs, that a rigid body leaves at most
LAGS = (15.0, 60.0)  # of pairs, by which other axes are tried [s]
MEDIAN = 1.538  # of the length of a vector of three normal numbers
ROUNDS, MOST_OUT, LEAST = 3, 0.3, 3  # of a robust search; part of all readings, and readings of an arc, that it leaves
BETTER = 0.8  # of what magnitudes leave, that they leave with scale factors which matter
FAR = 0.05  # of the field, by which readings may lie from the model: 3 deg across it; no stated error does that
SURE_OF_ELEMENTS = 3.0  # the same, of a position by elements
SCALES, ACROSSES, BY_ELEMENTS = "sensor.scale_factor", "sensor.misalignment", "position by elements"
BIAS, FIELD_BIAS, FIELD_SCALE = "bias", "magnetometer_bias", "magnetometer_scale_factor_error"
RESIDUAL = "field_residual"
SOURCES = {
    "sensor.scale_factor": "scale factor of the gyro",
    "sensor.misalignment": "misalignment of the gyro",
    "magnetometer.mounting": "angle between gyro and magnetometer",
    "earth_field.uniform": "field of the earth, the same all along",
}  # in budgets


@dataclass(frozen=True, eq=False)
class Result:
    """What the test gives."""

    plan: Plan
    readings: Readings
    solution: Solution
    arcs: tuple[Arc, ...]
    noise: Noise
    residual: float  # rms of the magnitude of the field against its model [T]
    remarks: tuple[Remark, ...] = ()

    @property
    def keys(self) -> tuple[Key, ...]:
        """What was estimated, in order."""
        names = (BIAS, FIELD_BIAS, FIELD_SCALE)[: len(self.solution.values) // 3]
        return tuple(Key(name, axis) for name in names for axis in AXES)

    @property
    def estimate(self) -> Estimate:
        """Biases with their covariance."""
        found = self.solution
        units = [unit for unit in ("rad/s", "T", "1")[: len(found.values) // 3] for _ in AXES]
        covariance = found.covariance
        scatter = Component(Origin("scatter of arcs", level="arc"), "A", 0.5 * (covariance + covariance.T),
                            found.dof, "t")  # fmt: skip
        changes = found.changes()
        parts = [scatter, *_stated(changes, self.plan, self.taken_off), *_of_orbits(changes[12:], self.readings),
                 *_of_matrix(changes[:9], self.readings), *self._of_bias()]  # fmt: skip
        made = Estimate(self.keys, found.values, tuple(units), tuple(parts))
        return made if self.readings.matrix is None else _as_read(made, self.readings.matrix.matrix)

    @property
    def taken_off(self) -> frozenset[str]:
        """Influences in whose place earlier tests found what the gyro reads of the turn."""
        matrix = self.readings.matrix
        found = () if matrix is None else matrix.keys
        pairs = {SCALES: [Key(SCALE, axis) for axis in AXES],
                 ACROSSES: [Key(ACROSS, f"{a}{b}") for a, b in permutations(AXES, 2)]}  # fmt: skip
        return frozenset(name for name, keys in pairs.items() if set(keys) <= set(found))

    def _of_bias(self) -> list[Component]:
        """Return what is not known of a bias that was taken off: each block counts by what its arc knows."""
        tracks = self.readings.tracks
        lengths = [len(one.taken_off.starts) for one in tracks]
        off = joined([one.taken_off.unknowns for one in tracks], lengths)
        if not off:
            return []
        inverse = self.solution.forecast
        gain = np.zeros((len(inverse), sum(lengths), 3))
        first = np.cumsum([0, *lengths])
        for arc, one in zip(self.arcs, self.solution.equations, strict=True):
            middle = tracks[arc.record].taken_off.starts + 0.5 * BLOCK
            own = np.flatnonzero((middle >= arc.start) & (middle < arc.start + arc.length))
            own = own if len(own) else np.array([np.argmin(np.abs(middle - arc.start - 0.5 * arc.length))])
            gain[:, first[arc.record] + own] += (inverse @ one.information[:, :3])[:, None, :] / len(own)
        if self.readings.matrix is not None:
            gain = gain @ np.linalg.inv(self.readings.matrix.matrix)
        return components(off, self.keys, gain)

    def rows(self) -> tuple[Row, ...]:
        """Rows of ``results.json``, SI."""
        estimate = self.estimate
        rows = []
        for i, key in enumerate(estimate.keys):
            value, u, dof = (float(one[i]) for one in (estimate.values, estimate.u, estimate.dof))
            told, shared = dof if np.isfinite(dof) else None, estimate.shared(key)
            rows.append(Row(key, value, u, estimate.units[i], told, t_interval(value, u, dof), shared=shared))
        said = Reason("scatter", "root mean square of the magnitude as read, less that of the model")
        return (*rows, Row(Key(RESIDUAL), self.residual, None, "T", reason=said))

    def curves(self) -> list[Curve]:
        """Curves of ``results.json``, SI: how well the bias is known by then; what the magnitude leaves."""
        return [_known(self), *_residuals(self)]

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: the figures in SI, how many remarks."""
        caption = f"gyro against magnetometer: {len(self.arcs)} arcs"
        return (*estimate_table([row.to_dict() for row in self.rows()], caption), *remarks_line(self.remarks))

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def reduce(plan: Plan, readings: Readings) -> Result:
    """Find the bias.

    Raises
    ------
    DataError
        ``too_short`` for fewer than six arcs, ``axes_disagree``, ``no_fit``, ``not_observable``.
    """
    remarks = list(readings.remarks)
    tracks = []
    for one in readings.tracks:
        kept, left = _undisturbed(one)
        tracks.append(kept)
        remarks += left
    arcs = [replace(arc, record=k) for k, one in enumerate(_of_elements(tracks)) for arc in cut(one, plan.arc)]
    if len(arcs) < FEWEST:
        length = sum(one.length for one in arcs)
        what = f"{len(arcs)} arcs of {number(plan.arc, 4)} s without a gap of the gyro ({number(length, 4)} s), need "
        what += f"{FEWEST}"
        gaps = sum(int(np.count_nonzero(np.diff(one.times) > APART * one.interval)) for one in tracks)
        do = "Record longer, or give a shorter --arc"
        if gaps:
            do = f"There are {items(gaps, 'gap')}: fill them from the log, {do[0].lower()}{do[1:]}"
        why = "the uncertainty rests on their scatter"
        raise DataError(what, readings.tracks[0].file, why, do, "too_short")
    offset = by_magnitude(*_all(arcs))
    noise = Noise(_field_noise(arcs, offset), _walk(tracks))
    bias = best_start(arcs, offset)
    _check_axes(arcs, noise, offset, readings.tracks[0].file)
    arcs, found, left = _robust(arcs, np.concatenate([bias, offset]), noise, plan.magnetometer_model == "scale_factor")
    remarks += left
    _check_fit(arcs, found, readings.tracks[0].file)
    _check_sense(arcs, found, noise, readings.tracks[0].file)
    residual = float(np.sqrt(np.mean(np.concatenate([_magnitudes(one, found) for one in arcs]) ** 2)))
    result = Result(plan, readings, found, tuple(arcs), noise, residual, ())
    return replace(result, remarks=(*remarks, *_remarks(result)))


def cut(track: Track, length: float) -> list[Arc]:
    """Return a recording as arcs of about equal length, none of which has a gap of the gyro.

    A stretch shorter than half an arc is left out.
    """
    there = np.asarray(np.isfinite(track.rates).all(axis=1))
    late = np.diff(track.times, prepend=track.times[0]) > APART * track.interval
    edges = np.flatnonzero(~there[1:] | ~there[:-1] | late[1:]) + 1
    arcs = []
    for first, stop in pairwise([0, *edges, len(there)]):
        if not there[first] or stop - first < 2:
            continue
        span = float(track.times[stop - 1] - track.times[first])
        parts = round(span / length) if span >= 0.5 * length else 0
        bounds = np.linspace(first, stop, max(parts, 1) + 1).astype(int)
        if parts:
            arcs += [one for low, high in pairwise(bounds.tolist())
                     if (one := _arc(track, low, high)) is not None]  # fmt: skip
    return arcs


def _arc(track: Track, first: int, stop: int) -> Arc | None:
    rates, field = track.rates[first:stop], track.field[first:stop]
    at = np.flatnonzero(np.isfinite(field).all(axis=1) & np.isfinite(track.reference[first:stop]).all(axis=1))
    if len(at) < 4:
        return None
    steps = float(track.times[stop - 1] - track.times[first]) / (stop - 1 - first)
    between = 0.5 * (rates[1:] + rates[:-1])
    start = float(track.times[first])
    times = track.times[first:stop][at] - start
    moved = None if track.orbit is None else track.orbit.moved[first:stop][at]
    return Arc(times, between, steps, at, field[at], track.reference[first:stop][at], start, moved)


def _of_elements(tracks: Sequence[Track]) -> list[Track]:
    """Return recordings whose orbits are off by the unknowns of all sets of elements: those of one set are the same."""
    sets = sets_of(tracks)
    if not sets:
        return list(tracks)
    made = []
    for one in tracks:
        moved = np.zeros((*one.reference.shape, 3 * len(sets)))
        if one.orbit is not None:
            k = 3 * sets.index(one.orbit.elements)
            moved[..., k : k + 3] = one.orbit.moved
        orbit = one.orbit or next(each.orbit for each in tracks if each.orbit is not None)
        made.append(replace(one, orbit=replace(orbit, moved=moved)))
    return made


def _of_orbits(changes: Array, readings: Readings) -> Iterator[Component]:
    """Yield what the elements of the orbit leave open: along it, across it, up, for each set of them."""
    if not len(changes):
        return
    names = [
        f"{way}, {one.called}" for one in sets_of(readings.tracks) for way in ("along the orbit", "across it", "up")
    ]
    yield Component(Origin(BY_ELEMENTS), "B", changes.T @ changes, changes=changes, unknowns=tuple(names))


def _of_matrix(changes: Array, readings: Readings) -> Iterator[Component]:
    """Yield what is not known of the matrix that was taken off."""
    matrix = readings.matrix
    if matrix is None:
        return
    for origin, one in readings.tracks[0].taken_off.of_matrix.items():
        rows = -matrix.entries(one.law) @ changes
        yield Component(origin, one.kind, rows.T @ rows, float(np.min(one.dof)), one.distribution, one.stated, rows,
                        one.unknowns)  # fmt: skip


def _as_read(found: Estimate, matrix: Array) -> Estimate:
    """Return an estimate whose bias is what the gyro reads of no rate, from the rate that it looks like."""
    turn = np.eye(len(found.values))
    turn[:3, :3] = matrix
    parts = [replace(one, covariance=turn @ one.covariance @ turn.T,
                     changes=None if one.changes is None else one.changes @ turn.T)
             for one in found.components]  # fmt: skip
    return Estimate(found.keys, turn @ found.values, found.units, tuple(parts))


def _all(arcs: Sequence[Arc]) -> tuple[Array, Array]:
    return np.concatenate([one.field for one in arcs]), np.concatenate([one.reference for one in arcs])


def _undisturbed(track: Track) -> tuple[Track, list[Remark]]:
    """Return a recording without the readings whose magnitude stands far out: magnetorquers, glitches."""
    read = np.isfinite(track.field).all(axis=1)
    field, reference = track.field[read], track.reference[read]
    out = np.zeros(len(field), dtype=bool)
    for _ in range(3):
        offset = by_magnitude(field[~out], reference[~out])
        left = np.linalg.norm(field - offset, axis=1) - np.linalg.norm(reference, axis=1)
        middle = float(np.median(left[~out]))
        scatter = 1.4826 * float(np.median(np.abs(left[~out] - middle)))
        out = np.abs(left - middle) > OUTLIER * scatter
    if not out.any() or np.count_nonzero(out) > 0.3 * len(out):
        return track, []
    kept = np.array(track.field)
    kept[np.flatnonzero(read)[out]] = np.nan
    what = f"{int(np.count_nonzero(out))} of {len(out)} readings of the field stand out by up to "
    what += f"{number(float(np.max(np.abs(left[out] - middle))) * 1e9, 3)} nT in magnitude: they are left out"
    do = "Record with magnetorquers off" if np.count_nonzero(out) > 5 else ""
    remark = Remark("disturbed", "warning", what, track.file, int(np.count_nonzero(out)), do, recording=track.name)
    return replace(track, field=kept), [remark]


def _field_noise(arcs: Sequence[Arc], offset: Array) -> float:
    """Return the noise of one axis of the magnetometer, by magnitudes [T]."""
    field, reference = _all(arcs)
    left = np.linalg.norm(field - offset, axis=1) - np.linalg.norm(reference, axis=1)
    return max(float(np.std(left)), 1e-7 * float(np.mean(np.linalg.norm(reference, axis=1))))


def _walk(tracks: Sequence[Track]) -> float:
    """Return the angle random walk of the gyro, by second differences, of which a body has little [rad/sqrt(s)]."""
    squares = []
    for one in tracks:
        second = np.diff(one.rates, 2, axis=0)
        second = second[np.isfinite(second).all(axis=1)]
        if len(second):
            squares.append(float(np.median(np.sum(second**2, axis=1))) / (6.0 * 2.366) * one.interval)
    return max(float(np.sqrt(np.mean(squares))) if squares else 0.0, 1e-9)


def _magnitudes(arc: Arc, found: Solution) -> Array:
    """Return what magnitudes leave, shape (n,) [T]."""
    scale = found.values[6:] if len(found.values) > 6 else np.zeros(3)
    body = (arc.field - found.values[3:6]) / (1.0 + scale)
    return np.asarray(np.linalg.norm(body, axis=1) - np.linalg.norm(arc.reference, axis=1))


def _robust(arcs: Sequence[Arc], start: Array, noise: Noise, scale: bool) -> tuple[list[Arc], Solution, list[Remark]]:
    """Return arcs without the readings that lie far from what the others say, their solution, and a remark on these."""
    found, kept, gone = solved(arcs, start, noise, scale), list(arcs), 0
    for _ in range(ROUNDS):
        each = [one.left for one in found.equations]
        limit = FAR_OUT * float(np.median(np.concatenate(each))) / MEDIAN
        good = [left <= limit for left in each]
        out = sum(int(np.count_nonzero(~one)) for one in good)
        if not out or out + gone > MOST_OUT * sum(len(one.times) for one in arcs):
            break
        kept = [replace(one, times=one.times[of], at=one.at[of], field=one.field[of], reference=one.reference[of],
                        moved=None if one.moved is None else one.moved[of])
                for one, of in zip(kept, good, strict=True) if np.count_nonzero(of) > LEAST]  # fmt: skip
        found, gone = solved(kept, found.values[:6], noise, scale), gone + out
    if not gone:
        return kept, found, []
    what = f"{gone} readings of the field lie far from where gyro and other readings have it: they are left out"
    remark = Remark("disturbed", "warning", what, count=gone, do="Record with magnetorquers off" if gone > 5 else "")
    return kept, found, [remark]


def _check_axes(arcs: Sequence[Arc], noise: Noise, offset: Array, file: str) -> None:
    """Refuse axes of the magnetometer that do not turn with those of the gyro, where others do."""
    size = float(np.mean(np.linalg.norm(_all(arcs)[1], axis=1)))
    likely = LIKELY * (np.sqrt(2.0) * noise.field / size + noise.walk * np.sqrt(LAGS[-1]))
    _, left = by_pairs(arcs, offset, LAGS)
    if left < likely:
        return
    best, others = min(left * OTHER_AXES, likely), ""
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=2):  # of all three at once the angle between two readings says nothing
            turn = np.eye(3)[list(order)] * np.array([1.0, *signs])[:, None]
            moved = [replace(one, field=one.field @ turn.T) for one in arcs]
            _, rest = by_pairs(moved, turn @ offset, LAGS)
            if rest < best:
                named = zip(AXES, order, (1.0, *signs), strict=True)
                best, others = (
                    rest,
                    ", ".join(f"{axis} is {'-' if sign < 0.0 else ''}{AXES[at]}" for axis, at, sign in named),
                )
    if others:
        what = "gyro and magnetometer do not turn together as one body"
        do = f"With the columns of the magnetometer as {others} they do: check the axes of both"
        raise DataError(what, file, do=do, code="axes_disagree")


def _check_fit(arcs: Sequence[Arc], found: Solution, file: str) -> None:
    """Refuse readings that fit no rigid body in this field."""
    size = float(np.mean(np.linalg.norm(_all(arcs)[1], axis=1)))
    rest = float(np.sqrt(np.mean(np.concatenate([_magnitudes(one, found) for one in arcs]) ** 2)))
    if rest > FAR * size:
        what = f"the magnitude of the field differs from its model by {number(rest * 1e9, 3)} nT (rms)"
        do = "Check clock and position, the unit of the magnetometer, and its scale factors"
        raise DataError(what, file, do=do, code="no_fit")
    if _left(found) > FAR * size:
        what = "gyro and magnetometer do not turn together as one body"
        do = "Check axes, units and clocks of both, and of the position"
        raise DataError(what, file, do=do, code="no_fit")


def _check_sense(arcs: Sequence[Arc], found: Solution, noise: Noise, file: str) -> None:
    """Refuse a magnetometer of which all axes have the other sign: angles between readings do not show that."""
    turned_round = [replace(one, field=-one.field) for one in arcs]
    start = np.concatenate([found.values[:3], -found.values[3:6]])
    other = solved(turned_round, start, noise, len(found.values) > 6)
    if _left(other) < OTHER_SENSE * _left(found):
        before, after = (number(_left(one) * 1e9, 3) for one in (found, other))
        what = f"the magnetometer leaves {before} nT (rms) of the field along the orbit; with the sign of every axis "
        what += f"changed, {after} nT"
        do = "Change the sign of all its columns: it was mounted the other way round, or reads against the field"
        raise DataError(what, file, do=do, code="axes_disagree")


def _left(found: Solution) -> float:
    """Return the rms of what readings leave [T]."""
    return float(np.sqrt(np.mean(np.concatenate([one.left for one in found.equations]) ** 2)))


def _stated(changes: Array, plan: Plan, found: Collection[str]) -> Iterator[Component]:
    """Yield the sources that standards state, but for what was found, as changes by each of their unknowns."""
    entry = {f"{a}{b}": changes[3 * i + j] for i, a in enumerate(AXES) for j, b in enumerate(AXES)}
    unknowns: dict[str, dict[str, Array]] = {
        "sensor.scale_factor": {axis: entry[axis * 2] for axis in AXES},
        "sensor.misalignment": {f"{a}{b}": entry[f"{a}{b}"] for a, b in permutations(AXES, 2)},
        # the gyro turned about x by a small angle reads y of z and z of -y
        "magnetometer.mounting": {
            "x": entry["yz"] - entry["zy"], "y": entry["zx"] - entry["xz"], "z": entry["xy"] - entry["yx"],
        },
        "earth_field.uniform": dict(zip(AXES, changes[9:12], strict=True)),
    }  # fmt: skip
    for name, rows in unknowns.items():
        one: Influence | None = plan.standards.get(name)
        if one is not None and one.u > 0.0 and name not in found:
            each = np.array(list(rows.values())) * one.u
            yield Component(one.origin(SOURCES[name]), "B", each.T @ each, one.dof, one.distribution, one.stated, each,
                            tuple(rows))  # fmt: skip


def _remarks(result: Result) -> Iterator[Remark]:
    plan, found = result.plan, result.solution
    if missing := [name for name in INFLUENCES if name not in plan.standards and name not in result.taken_off]:
        effects = "; ".join(f"{name} ({INFLUENCES[name]})" for name in missing)
        what = f"standards without a stated uncertainty: {effects}: results are relative to these"
        yield Remark("relative_to_fixture", "warning", what, do="State them under [standards]")
    yield from _drift(result)
    yield from _clock(result)
    yield from _scale(result)
    values, vectors = np.linalg.eigh(found.covariance[:3, :3])
    if values[0] > 0.0 and np.sqrt(values[-1] / values[0]) > WEAK:
        weak = vectors[:, -1] * np.sign(vectors[np.argmax(np.abs(vectors[:, -1])), -1])
        along = ", ".join(number(float(one), 2) for one in weak)
        u = uncertainty(float(np.degrees(np.sqrt(values[-1]))))
        times = number(float(np.sqrt(values[-1] / values[0])), 2)
        what = f"the bias is hardly known along ({along}): {u} deg/s there, {times} times that where it is known best"
        yield Remark("weak_direction", "warning", what, do="Record longer, or while turning about another axis")


def _drift(result: Result) -> Iterator[Remark]:
    """Yield a bias that drifts over the record, by a slope that is estimated with all else."""
    parts, middles = result.solution.equations, np.array([one.start + 0.5 * one.length for one in result.arcs])
    time = (middles - np.mean(middles)) / max(0.5 * float(np.ptp(middles)), 1e-9)  # -1 to 1
    wider = []
    for one, at in zip(parts, time.tolist(), strict=True):
        more = np.vstack([np.eye(len(one.pull)), at * np.eye(3, len(one.pull))])
        wider.append(replace(one, information=more @ one.information @ more.T, pull=more @ one.pull))
    information = np.asarray(sum(one.information for one in wider))
    pull = np.asarray(sum(one.pull for one in wider))
    step = np.linalg.lstsq(information, pull, rcond=None)[0]
    about = tuple(replace(one, pull=one.pull - one.information @ step) for one in wider)
    change, covariance = 2.0 * step[-3:], 4.0 * Solution(step, about).covariance[-3:, -3:]
    if _is_seen(change, covariance, len(parts) - 2):
        axis = int(np.argmax(np.abs(change) / np.sqrt(np.diag(covariance))))
        size, u = np.degrees([change[axis], np.sqrt(covariance[axis, axis])])
        what = f"the bias of {AXES[axis]} drifts by {number(float(size), 2)} deg/s over the record"
        what += f" (u {uncertainty(float(u))} deg/s): the figure is that of the mean"
        do = "Take parts of the record as tests of their own: their biases are those of several temperatures"
        yield Remark("bias_drifts", "warning", what, do=do, axis=AXES[axis])


def _is_seen(values: Array, covariance: Array, dof: int) -> bool:
    """Return whether values are more than scatter with so many degrees of freedom makes (Hotelling)."""
    from scipy.stats import f  # noqa: PLC0415 - starts slowly

    k, left = len(values), max(dof - len(values) + 1, 1)
    return bool(f.sf(float(values @ np.linalg.solve(covariance, values)) * left / (k * dof), k, left) < RISK)


def _clock(result: Result) -> Iterator[Remark]:
    """Yield an orbit whose clock is off: what magnitudes leave then follows the change of the model."""
    scale = float(np.mean(np.linalg.norm(_all(result.arcs)[1], axis=1)))
    designs, lefts = [], []
    for one in result.arcs:
        slope = np.gradient(np.linalg.norm(one.reference, axis=1), one.times)
        toward = one.field / np.linalg.norm(one.field, axis=1)[:, None]
        designs.append(np.column_stack([slope / scale, toward]))  # the bias of the magnetometer gives way
        lefts.append(_magnitudes(one, result.solution))
    inverse = np.linalg.pinv(np.asarray(sum(one.T @ one for one in designs)))
    fitted = inverse @ np.asarray(sum(one.T @ left for one, left in zip(designs, lefts, strict=True)))
    pulls = [one.T @ (left - one @ fitted) for one, left in zip(designs, lefts, strict=True)]
    late = float(fitted[0]) / scale
    u = float(np.sqrt(sum((inverse @ one)[0] ** 2 for one in pulls))) / scale
    late_by = [SURE_OF_ELEMENTS * one.orbit.late for one in result.readings.tracks if one.orbit is not None]
    step = max([*(one.interval for one in result.arcs), *late_by])
    if abs(late) > SURE * u and abs(late) > step:
        what = (
            f"the magnitude of the field runs {number(abs(late), 3)} s {'ahead of' if late > 0.0 else 'behind'} that "
        )
        what += f"along the orbit (u {uncertainty(u)} s)"
        do = "Check the clock of the position against that of the magnetometer"
        do += "; or take elements of that day" if late_by else ""
        yield Remark("clock_offset", "warning", what, do=do)


def _scale(result: Result) -> Iterator[Remark]:
    """Yield scale factors of the magnetometer that are seen where they are not estimated."""
    if result.plan.magnetometer_model == "scale_factor":
        return
    wider = solved(result.arcs, result.solution.values[:6], result.noise, True)
    change, covariance = wider.values[6:], wider.covariance[6:, 6:]
    left = float(np.sqrt(np.mean(np.concatenate([_magnitudes(one, wider) for one in result.arcs]) ** 2)))
    if left < BETTER * result.residual and _is_seen(change, covariance, len(result.arcs) - 1):
        moved = float(np.degrees(np.max(np.abs(wider.values[:3] - result.solution.values[:3]))))
        errors = ", ".join(f"{axis} {number(100.0 * float(one), 2)} %" for axis, one in zip(AXES, change, strict=True))
        what = (
            f"the magnetometer has scale factor errors ({errors}): they move the bias by up to {number(moved, 2)} deg/s"
        )
        yield Remark("scale_factor_seen", "warning", what, do="Estimate them: --magnetometer-model scale_factor")


def _known(result: Result) -> Curve:
    """Return how well the bias is known after each arc, by the information up to then and the scatter of all arcs."""
    found = result.solution
    inflated = np.diag(found.covariance)[:3] / np.diag(found.forecast)[:3]
    total, times, u = np.zeros_like(found.information), [], []
    for arc, one in zip(result.arcs, found.equations, strict=True):
        total = total + one.information
        if np.linalg.cond(total / np.sqrt(np.outer(np.diag(total), np.diag(total)))) < 1e10:
            times.append(arc.start + arc.length)
            u.append(np.sqrt(np.diag(np.linalg.inv(total))[:3] * inflated))
    columns = {"time": Column(np.array(times), "s")}
    columns |= {f"u_{axis}": Column(np.array(u).reshape(-1, 3)[:, i], "rad/s") for i, axis in enumerate(AXES)}
    return Curve("magnetometer_bias_known", "", columns)


def _residuals(result: Result) -> Iterator[Curve]:
    """Yield what the magnitude of the field leaves, arc by arc: mean, and how far its readings lie about it."""
    left = [_magnitudes(one, result.solution) for one in result.arcs]
    size = [float(np.mean(np.linalg.norm(one.reference, axis=1))) for one in result.arcs]
    middle = np.array([one.start + 0.5 * one.length for one in result.arcs])
    yield Curve("magnetometer_residuals", "", {
        "time": Column(middle, "s"),
        "mean": Column(np.array([float(np.mean(one)) for one in left]), "T", "nT"),
        "deviation": Column(np.array([float(np.std(one)) for one in left]), "T", "nT"),
        "field": Column(np.array(size), "T", "nT"),
    })  # fmt: skip
