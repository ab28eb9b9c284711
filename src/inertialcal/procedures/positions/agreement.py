"""Positions and turns against gravity, one by one: from where on a sign, a unit or the axes are others, and where.

At rest accelerometers read gravity and gyros next to nothing, however the unit lies. Between two rests the gyros carry
gravity to where the accelerometers find it. Both hold to a few per cent before any calibration; what is looked for is
off by far more, so that no noise is taken for it. A recording, or the rest of one from some position on, is named where
most of it disagrees while most of what comes before agrees; the likely cause is the unit or the signed permutation of
axes that makes its turns agree. A part that is far quieter than the rest hides it: only the part is found at rest.
Where all rests disagree and begin late in the recording, they are such a part.

Readings in counts of unknown scale factor are not judged.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...core.estimate import Array
from ...core.key import AXES
from ...core.remarks import Remark
from ...core.show.rounding import number
from ..agreement import unit_mistaken
from .checks import signed_permutations, thinned
from .fit.rotations import Packed, angle_between, carried, packed
from .plan import Plan
from .readings import Readings, by_axis, local_gravity

OFF = 0.3  # part of gravity by which a rest reads too much or too little
TURNING = 0.1  # of a gyro at rest, from what it reads in other positions [rad/s]
AGREES, DISAGREES = np.radians(12.0), np.radians(25.0)  # error of a turn, in the median
MOST = 0.7  # of what comes after, that disagrees
FEW = 0.15  # of what comes before, that may
LATE = 0.25  # of a recording, before which it rests nowhere
ALIKE = 0.1  # by which the sizes of readings in one unit scatter
SCALES = (np.pi / 180.0, 180.0 / np.pi, 0.5, 2.0, 0.25, 4.0)  # of gyros, besides 1
RATES = (0.5, 2.0, 0.25, 4.0)  # of those, what a wrong sample rate makes


@dataclass(frozen=True)
class Part:
    """Positions first to last of a recording; ``changed``: after others that agree."""

    first: int
    last: int
    changed: bool


def agreement(plan: Plan, readings: Readings) -> list[Remark]:
    """Return the recordings, or parts of them, that disagree with gravity while others agree."""
    force = _in_si(readings.acc.mean, readings.acc.unit == "m/s^2", plan.acc_scale_factor, plan.acc_zero)
    if force is None or len(readings) < 2:
        return []
    return list(_rests(plan, readings, force)) or list(_turns(plan, readings, force))


def _in_si(
    values: Array, is_si: bool, scale: Mapping[str, float] | None, zero: Mapping[str, float] | None
) -> Array | None:
    """Return readings in SI, or None where their scale factor is not known."""
    if is_si:
        return values
    if scale is None:
        return None
    return np.asarray((values - by_axis(zero, 0.0)) / by_axis(scale, 1.0))


def _parts(readings: Readings, wrong: NDArray[np.bool_], size: int) -> Iterator[Part]:
    """Yield whole recordings of which most is wrong while another agrees, and the ends of recordings from a change on.

    Parameters
    ----------
    readings : Readings
        m positions.
    wrong : ndarray of bool, shape (m,)
        Positions that disagree; of turns that at their end.
    size : int
        Fewest positions of a part.
    """
    own = np.array(readings.recordings or (0,) * len(readings))
    shares = {k: float(np.mean(wrong[own == k])) for k in dict.fromkeys(own.tolist())}
    for k, share in shares.items():
        at = np.flatnonzero(own == k)
        if share >= MOST and (min(shares.values()) <= FEW or len(shares) == 1):
            yield Part(int(at[0]), int(at[-1]), changed=len(shares) == 1 and _is_late(readings))
            continue
        here = wrong[at]
        before = np.concatenate([[0], np.cumsum(here)])
        cuts = np.arange(size, len(at) - size + 1)
        if not len(cuts):
            continue
        missed = before[cuts] + (len(at) - cuts) - (before[-1] - before[cuts])
        cut = int(cuts[int(np.argmin(missed))])
        if np.mean(here[:cut]) <= FEW and np.mean(here[cut:]) >= MOST:
            yield Part(int(at[cut]), int(at[-1]), changed=True)


def _is_late(readings: Readings) -> bool:
    """Whether the only recording rests nowhere in its first part."""
    if readings.start_ns is None or len(readings.spans_ns) != 1:
        return False
    first, last = readings.spans_ns[0]
    return bool(readings.start_ns[0] - first > LATE * (last - first))


def _rests(plan: Plan, readings: Readings, force: Array) -> Iterator[Remark]:
    """Yield where rests read no gravity, or gyros turn at rest."""
    size = np.linalg.norm(force, axis=1) / local_gravity(plan)
    wrong = ~(np.abs(size - 1.0) < OFF)
    gyro, rate = readings.gyro, None
    if gyro is not None:
        rate = _in_si(gyro.mean, gyro.unit == "rad/s", plan.gyro_scale_factor, plan.gyro_zero)
        wrong |= False if rate is None else _turning(rate)
    if not wrong.any():
        return
    for part in _parts(readings, wrong, 2):
        inside = slice(part.first, part.last + 1)
        own = size[inside]
        if np.all(np.abs(own - 1.0) < OFF) and (rate is None or np.all(np.ptp(rate[inside], axis=0) < 2.0 * TURNING)):
            continue  # the gyros have another bias: their turns show why
        middle = float(np.median(own))
        place = readings.where[part.first] if readings.where else ""
        is_all = not part.changed and part.last - part.first == len(readings) - 1
        if is_all and readings.acc.unit != "m/s^2" and _is_beside_zero(force / local_gravity(plan)):
            what = f"{_here(readings, part)} accelerometers read {number(float(own.min()), 2)} to"
            what += f" {number(float(own.max()), 2)} times gravity at rest, all in one direction beside gravity"
            do = "State what each reads without input: --acc-zero x=NUMBER, y and z alike; acc_zero of the plan"
            yield Remark("zero_missing", "error", what, place, do=do)
            continue
        if middle > 0.0 and np.ptp(own) < ALIKE * middle and abs(middle - 1.0) >= OFF:
            unit = unit_mistaken(middle, "acceleration") or unit_mistaken(middle, "angular_rate")
            if is_all:
                continue  # ``checks.check_units`` refuses all of it
            code = ("unit_changed" if unit else "scale_changed") if part.changed else "unit_disagrees"
            what = f"{_here(readings, part)} accelerometers read {number(middle, 3)} times gravity at rest"
            what += f": {unit}" if unit else ""
            yield Remark(code, "error", what, place, do="State the unit of this part, or cut the recording there")
            continue
        what = f"{_here(readings, part)} accelerometers read {number(float(own.min()), 2)} to"
        what += f" {number(float(own.max()), 2)} times gravity at rest, or gyros turn: these are other axes or sensors"
        code = "axes_changed" if part.changed else "axes_disagree"
        yield Remark(code, "error", what, place, do="Check the columns, and cut the recording there")


def _is_beside_zero(force: Array) -> bool:
    """Whether readings at rest, shape (m, 3) [g], are of gravity about a point that is far from zero."""
    middle = 0.5 * (force.max(axis=0) + force.min(axis=0))
    around = np.linalg.norm(force - middle, axis=1)
    return bool(np.linalg.norm(middle) > 1.0 + OFF and np.all(np.abs(around - 1.0) < OFF))


def _turning(rate: Array) -> NDArray[np.bool_]:
    """Return where gyros at rest, shape (m, 3) [rad/s], read something else than in most; everywhere if they wander.

    Gyros that read nothing anywhere are not judged.
    """
    near = np.max(np.abs(rate[:, None] - rate[None]), axis=2) < TURNING
    usual = near[int(np.argmax(near.sum(axis=1)))]
    at = np.flatnonzero(usual)
    if not len(at):  # no reading in any position
        return np.zeros(len(rate), dtype=bool)
    wanders = 2 * len(at) < len(rate) and at[-1] - at[0] >= len(at)
    return np.ones(len(rate), dtype=bool) if wanders else np.asarray(~usual)


def _here(readings: Readings, part: Part) -> str:
    if part.changed:
        return f"from position {part.first + 1} on"
    if part.last - part.first == len(readings) - 1:
        return "in all positions"
    return f"in positions {part.first + 1} to {part.last + 1}, which are one recording,"


def _turns(plan: Plan, readings: Readings, force: Array) -> Iterator[Remark]:
    """Yield where gyros carry gravity to another place than the accelerometers find it, and what would mend it."""
    gyro = readings.gyro
    rotations = [one for one in readings.transitions if len(one.gyro) > 1]
    if gyro is None or len(rotations) < 4:
        return
    level = _in_si(gyro.mean, gyro.unit == "rad/s", plan.gyro_scale_factor, plan.gyro_zero)
    if level is None:
        return
    rates = [_in_si(one.gyro, gyro.unit == "rad/s", plan.gyro_scale_factor, plan.gyro_zero) for one in rotations]
    z = [rate - 0.5 * (level[one.before] + level[one.after]) for rate, one in zip(rates, rotations, strict=True)
         if rate is not None]  # fmt: skip
    whole = packed(rotations, z, [np.zeros_like(one) for one in z])
    samples = thinned(whole, whole.first[:-1], whole.first[1:])
    size = np.linalg.norm(force, axis=1)[:, None]
    up = force / np.where(size > 0.0, size, 1.0)  # no direction disagrees with none
    start, stop = (up[[getattr(one, side) for one in rotations]] for side in ("before", "after"))
    as_read = _errors(samples, start, stop, np.eye(3))
    if np.sum(as_read > DISAGREES) < 2:
        return
    tried = [(scale, axes, _errors(samples, start, stop, scale * axes)) for scale, axes in _mistakes()]
    recordings = readings.recordings or (0,) * len(readings)
    own = np.array([recordings[one.after] for one in rotations])
    agrees = {k: bool(np.median(as_read[own == k]) < AGREES) for k in dict.fromkeys(own.tolist())}
    for k, sound in agrees.items():
        at = np.flatnonzero(own == k)
        if not sound and any(agrees.values()):
            part = Part(rotations[at[0]].before, rotations[at[-1]].after, changed=False)
            yield _cause(readings, part, [(scale, axes, error[at]) for scale, axes, error in tried])
        elif (cut := _cut(as_read[at], [error[at] for _, _, error in tried])) is not None:
            part, after = Part(rotations[at[cut]].after, rotations[at[-1]].after, changed=True), at[cut + 1 :]
            yield _cause(readings, part, [(scale, axes, error[after]) for scale, axes, error in tried])


def _mistakes() -> list[tuple[float, Array]]:
    """Return factors and axes of gyros that are taken for others."""
    return [(1.0, axes) for axes in signed_permutations()[1:]] + [(scale, np.eye(3)) for scale in SCALES]


def _cut(as_read: Array, tried: Sequence[Array]) -> int | None:
    """Return the turn in which something changed: those before agree, those after do not; None where there is none.

    Parameters
    ----------
    as_read : ndarray, shape (k,)
        Errors of the turns of a recording [rad].
    tried : sequence of ndarray, shape (k,)
        The same with each mistake mended.
    """
    best, found = 0.0, None
    for cut in range(1, len(as_read) - 2):
        before, after = as_read[:cut], as_read[cut + 1 :]
        if np.median(before) > AGREES or np.sum(after > DISAGREES) < max(2, FEW * len(after)):
            continue
        mended = min(tried, key=lambda one: float(np.sum(one[cut + 1 :])))[cut + 1 :]
        explained = np.median(mended) < AGREES and np.mean(after - mended) > AGREES
        gain = float(np.sum(after - (mended if explained else AGREES)) - np.sum(before))
        if (explained or np.mean(after > DISAGREES) >= MOST) and gain > best:
            best, found = gain, cut
    return found


def _errors(samples: Packed, start: Array, stop: Array, W: Array) -> Array:
    """Return the angle from where gravity is carried to where it is, of each turn [rad]."""
    return angle_between(np.einsum("kij,kj->ki", carried(samples, W[None])[0], start), stop)


def _cause(readings: Readings, part: Part, tried: Sequence[tuple[float, Array, Array]]) -> Remark:
    """Return what makes the turns of a part agree."""
    scale, axes, errors = min(tried, key=lambda one: float(np.sum(one[2])))
    place = readings.where[part.first] if readings.where else ""
    what = f"{_here(readings, part)} gyros carry gravity to where the accelerometers do not find it"
    changed, do = part.changed, "Check the columns of this part, or cut the recording there"
    if np.median(errors) > AGREES:
        code = "axes_changed" if changed else "axes_disagree"
        return Remark(code, "error", what, place, do=do)
    if scale in RATES:
        code = "scale_changed" if changed else "sample_rate_disagrees"
        what += f": their angles are {number(1.0 / scale, 3)} times too large, as by a wrong sample rate"
    elif scale != 1.0:
        code, unit = ("unit_changed" if changed else "unit_disagrees"), "deg/s" if scale < 1.0 else "rad/s"
        what += f": they are in {unit}"
    else:
        code, words = _axes(axes, changed)
        what += f": {words}"
    return Remark(code, "error", what, place, do=do)


def _axes(axes: Array, changed: bool) -> tuple[str, str]:
    """Return code and words for a signed permutation that takes readings of gyros to axes of the accelerometers."""
    inverted = [AXES[i] for i in range(3) if axes[i, i] < 0.0]
    if np.all(np.diag(axes) != 0.0):
        code = "sign_changed" if changed else "sign_disagrees"
        if len(inverted) == len(AXES):
            return code, "the sign of all axes is inverted, of gyros or accelerometers"
        return code, f"the sign of {' and '.join(inverted)} is inverted, of gyros or accelerometers"
    pairs = [(i, int(np.flatnonzero(axes[:, i])[0])) for i in range(3)]
    named = [f"gyro {AXES[i]} turns about {'-' if axes[j, i] < 0.0 else ''}{AXES[j]}" for i, j in pairs if i != j]
    return ("axes_changed" if changed else "axes_disagree"), ", ".join(named)
