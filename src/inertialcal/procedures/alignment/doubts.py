"""What speaks against an alignment: units, signs, axes, a base that moves or sways, gyros that drift.

Refused is what makes the figures wrong beyond their uncertainty; what a sound record can show too is a remark.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import permutations, product
from typing import TYPE_CHECKING

import numpy as np

from ...core.constants import STANDARD_GRAVITY
from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES, Key
from ...core.remarks import Remark
from ...core.show.rounding import number
from ...physics.earth import OMEGA
from ...signals.screening.screen import screen
from ...statistics.quantiles import t_upper
from .keys import EXCESS
from .plan import INFLUENCES, Plan
from .readings import Position, Readings
from .solving import Inputs, Solution, solve
from .turns import degrees, per_hour

if TYPE_CHECKING:
    from .reduction import Result

FAR = 0.05  # of gravity, by which accelerometers may be off
NOT_EARTH, EARTH = 0.2, 0.05  # of its rate: what is left where it is not that of the earth, and where it is
SENSE = 0.2  # of twice the rate of the earth about the vertical
SURE = 1e-4  # probability of a drift or a step that is none
PARTS, FEWEST, LOUD = 8, 60, 2.0  # of a rest, whose scatter is compared; samples of each; times the median
FACTORS = (180.0 / math.pi, math.pi / 180.0, 3600.0, 1.0 / 3600.0, 60.0, 1.0 / 60.0, 1e3, 1e-3)  # of units of rates


def check(plan: Plan, readings: Readings, given: Inputs, found: Solution) -> None:
    """Refuse readings that are not those of gravity and the earth.

    Raises
    ------
    DataError
        ``wrong_unit``, ``wrong_sense``, ``axes_disagree``.
    """
    _check_gravity(readings, given)
    _check_rates(plan, readings, given, found)


def _check_gravity(readings: Readings, given: Inputs) -> None:
    """Refuse a specific force that is not that of gravity."""
    for one, force in zip(readings.positions, given.acc, strict=True):
        ratio = float(np.linalg.norm(force)) / given.gravity
        if abs(ratio - 1.0) <= FAR:
            continue
        g = float(STANDARD_GRAVITY.value)
        scales = {"g": g, "mg": 1e-3 * g, "m/s^2": 1.0 / g}
        like = next((unit for unit, one_of in scales.items() if abs(ratio * one_of - 1.0) <= FAR), "")
        what = f"the accelerometers read {number(ratio, 4)} times gravity at rest"
        do = f"With the unit {like} it fits: check it" if like else "Check unit, scale factors and axes"
        raise DataError(what, one.file, "at rest nothing else is felt", do, "wrong_unit")


def _misfit(found: Solution) -> float:
    """Return what the latitude does not explain of the rates, over the rate of the earth."""
    return found.scatter / OMEGA


def _check_rates(plan: Plan, readings: Readings, given: Inputs, found: Solution) -> None:
    """Refuse rates that are those of the earth in another unit, sign, or with other axes."""
    noise = max(float(np.std(one.gyro, axis=0).max()) / math.sqrt(len(one.gyro)) for one in readings.positions)
    if max(noise, plan.gyro_bias_u or 0.0) > EARTH * OMEGA:
        return
    file = readings.positions[0].file
    if _misfit(found) > NOT_EARTH:
        for factor in FACTORS:
            other = solve(replace(given, gyro=given.gyro * factor))
            if _misfit(other) < EARTH and (len(readings) > 1 or _alike(other, given)):
                what = f"the gyros read the rate of the earth times {number(1.0 / factor, 4)}"
                raise DataError(what, file, do="Check the unit of the rates", code="wrong_unit")
        _check_axes(given, file)
    elif len(readings) > 1:
        _check_sense(given, found, file)


def _alike(found: Solution, given: Inputs) -> bool:
    return abs(found.rate / (OMEGA * math.cos(given.latitude)) - 1.0) < EARTH


def _check_axes(given: Inputs, file: str) -> None:
    """Refuse rates whose size is that of the earth, but whose angle to gravity is not, and say what would fit."""
    if len(given.gyro) == 1 and abs(float(np.linalg.norm(given.gyro[0])) / OMEGA - 1.0) > EARTH:
        return
    if _misfit(solve(replace(given, latitude=-given.latitude))) < EARTH:
        _wrong_sense(file)
    fits = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            if order == (0, 1, 2) and len(set(signs)) == 1:
                continue
            moved = given.gyro[:, list(order)] * np.array(signs)
            if _misfit(solve(replace(given, gyro=moved))) < EARTH:
                named = zip(AXES, order, signs, strict=True)
                fits.append(", ".join(f"{axis} is {'-' if sign < 0.0 else ''}{AXES[at]}" for axis, at, sign in named))
    if fits:
        what = "the rates have the size of that of the earth, but not its angle to gravity"
        do = "Check axes and signs of both triads, and the latitude; "
        do += f"with the columns of the gyros as {fits[0]} they fit"
        raise DataError(what, file, "gravity and the axis of the earth meet at an angle that the latitude tells", do,
                        "axes_disagree")  # fmt: skip


def _check_sense(given: Inputs, found: Solution, file: str) -> None:
    """Refuse a bias that is twice the rate of the earth about the vertical, and nothing in level."""
    down = given.acc[0] / -np.linalg.norm(given.acc[0])
    along = float(found.bias @ down)
    across = float(np.linalg.norm(found.bias - along * down))
    double = 2.0 * OMEGA * math.sin(given.latitude)
    near = abs(along - double) < SENSE * abs(double) and across < SENSE * OMEGA
    if near and abs(double) > SENSE * OMEGA and found.scatter < EARTH * OMEGA:
        _wrong_sense(file)


def _wrong_sense(file: str) -> None:
    what = "the gyros turn about the vertical as the earth does at the opposite latitude"
    do = "Check the sign of the latitude (north is positive), of the gyros (right-handed), and of the accelerometers: "
    do += "an axis that points up reads plus g"
    raise DataError(what, file, "the heading may be the opposite one", do, "wrong_sense")


def doubts(result: Result) -> list[Remark]:
    """Return what else speaks against the figures.

    Raises
    ------
    DataError
        ``base_moved``.
    """
    return [*_base(result), *_drifts(result), *_gravity(result), *_stated(result)]


def _slopes(series: Array) -> tuple[Array, Array]:
    """Return by how much each column changes over the record, and its standard uncertainty, by all other cosines."""
    n = len(series)
    phase = (np.arange(n) + 0.5) / n - 0.5
    scale = float(phase @ phase)
    slope = phase @ series / scale
    rest = series - series.mean(axis=0) - np.outer(phase, slope)
    waves = math.sqrt(2.0 / n) * np.cos(np.outer(np.arange(2, 10), np.pi * (np.arange(n) + 0.5) / n))
    power = np.mean((waves @ rest) ** 2, axis=0)
    return np.asarray(slope), np.asarray(np.sqrt(power / scale))


def _drifts(result: Result) -> Iterator[Remark]:
    """Yield gyros that drift within records by more than their scatter."""
    m = len(result.readings)
    limit = float(t_upper(SURE / (6.0 * m), 8.0))
    worst: tuple[float, int, int, float] | None = None
    for at, one in enumerate(result.readings.positions):
        slope, u = _slopes(one.gyro)
        for axis in range(3):
            size = abs(float(slope[axis]))
            if size > limit * float(u[axis]) and (worst is None or size > abs(worst[3])):
                worst = (size, at, axis, float(slope[axis]))
    if worst is None:
        return
    _, at, axis, slope_of = worst
    what = f"the gyro {AXES[axis]} drifts by {per_hour(slope_of)} within position {at + 1}"
    if m > 1:
        what += ": a bias that changes between positions does not cancel"
    do = "Let the unit warm up; take the positions in the order 0, 180, 180, 0 deg, each as long"
    yield Remark("bias_drifts", "warning", what, result.readings.positions[at].file, axis=AXES[axis], do=do)


def _base(result: Result) -> Iterator[Remark]:
    """Yield a base that stepped, tilts or sways; refuse one that stepped by what matters."""
    for at, one in enumerate(result.readings.positions):
        place = f"position {at + 1}" if len(result.readings) > 1 else "the record"
        step = _step(one)
        if step > 0.0:
            rate, horizontal = step / one.seconds, OMEGA * math.cos(result.given.latitude)
            what = f"the accelerometers step by {degrees(step)} of tilt within {place}: the base moved; over its time "
            what += f"that is a rate of {per_hour(rate)}"
            if rate > 0.05 * horizontal or step > math.radians(0.1):
                do = "Record again on a base that does not move, or only up to the step"
                raise DataError(what, one.file, "the gyros feel it as part of the rate of the earth", do, "base_moved")
            yield Remark("base_moved", "warning", what, one.file, do="Look what moved it")
        yield from _tilting(result, one, place)
        yield from _sway(result, one, place)


def _step(one: Position) -> float:
    """Return the largest step of the direction of gravity that is no noise [rad]; 0 where there is none."""
    size = float(np.linalg.norm(one.mean_acc))
    steps = [0.0]
    for axis in range(3):
        series = one.acc[:, axis]
        left = (series - series.mean()) / max(float(np.std(np.diff(series))) / math.sqrt(2.0), 1e-12)
        n, best = len(left), (0.0, 0)
        sums = np.cumsum(left)
        at = np.arange(8, n - 8)
        gap = (sums[-1] - sums[at - 1]) / (n - at) - sums[at - 1] / at
        sure = np.abs(gap) / np.sqrt(1.0 / at + 1.0 / (n - at))
        best = (float(sure.max()), int(at[np.argmax(sure)]))
        before, after = series[: best[1]], series[best[1] :]
        jump = float(after.mean() - before.mean())
        # a step, and no drift: the neighbours on both sides have moved by most of it
        near = float(after[:6].mean() - before[-6:].mean())
        if best[0] > 8.0 and near * jump > 0.6 * jump**2:
            steps.append(abs(jump) / size)
    return float(max(steps))


def _tilting(result: Result, one: Position, place: str) -> Iterator[Remark]:
    """Yield a tilt that changes evenly: by the base, or by accelerometers that drift."""
    slope, u = _slopes(one.acc)
    down = one.mean_acc / np.linalg.norm(one.mean_acc)
    level = slope - (slope @ down) * down
    tilt = float(np.linalg.norm(level)) / float(np.linalg.norm(one.mean_acc))
    sure = float(np.max(np.abs(slope) / np.maximum(u, 1e-300))) > float(t_upper(SURE / 6.0, 8.0))
    rate = tilt / one.seconds
    if sure and rate > 0.5 * result.bias_u:
        what = f"the direction of gravity changes by {degrees(tilt)} within {place}: where the base tilts, the gyros "
        what += f"feel {per_hour(rate)}; where the accelerometers drift, they do not"
        yield Remark("base_tilts", "warning", what, one.file, do="Use a base that does not tilt; let the unit warm up")


def _sway(result: Result, one: Position, place: str) -> Iterator[Remark]:
    """Yield noise that comes and goes, or a wave, in either triad: people who walk, a base that rocks."""
    if one.raw is None:
        return
    seen = []
    for name, values in zip(("accelerometer", "gyro"), one.raw, strict=True):
        for axis in range(3):
            own = np.ascontiguousarray(values[:, axis])
            kinds = [
                code.replace("_", " ") for code in screen(own, True).codes if code in ("noise_change", "slow_wave")
            ]
            kinds += ["noise change"] if not kinds and _uneven(own) else []
            seen += [f"{name} {AXES[axis]}: {one_of}" for one_of in kinds]
    if seen:
        what = f"the base is not quiet in {place} ({', '.join(seen[:3])}{', ...' if len(seen) > 3 else ''})"
        yield Remark(
            "base_sways", "warning", what, one.file, len(seen), "Keep people and machines away while it aligns"
        )


def _uneven(values: Array) -> bool:
    """Return whether the scatter of neighbours is much larger in some part than it usually is."""
    count = len(values) // PARTS
    if count < FEWEST:
        return False
    steps = np.diff(values[: count * PARTS].reshape(PARTS, count), axis=1)
    each = np.nan_to_num(np.nanmean(steps**2, axis=1)) if np.isfinite(steps).any(axis=1).all() else np.ones(PARTS)
    return bool(each.max() > LOUD * np.median(each))


def _gravity(result: Result) -> Iterator[Remark]:
    """Yield a specific force that differs from gravity by more than is stated, or by much."""
    at = result.whole.index(Key(EXCESS))
    excess, u = float(result.whole.values[at]), float(result.whole.u[at])
    stated = result.plan.accelerometer_bias_u is not None or bool(result.readings.taken_off.get("accelerometer"))
    limit = 4.0 * u if stated else 1e-3 * result.given.gravity
    if abs(excess) > max(limit, 5e-5 * result.given.gravity):
        what = f"the specific force is {number(excess / float(STANDARD_GRAVITY.value) * 1e3, 3)} mg larger than gravity"
        what += f": accelerometers that are off by that tilt the level by {degrees(abs(excess) / result.given.gravity)}"
        yield Remark(
            "gravity_differs", "warning", what, do="Calibrate the accelerometers, and take their bias off first"
        )


def _stated(result: Result) -> Iterator[Remark]:
    """Yield what is not stated of the standards, and biases."""
    plan = result.plan
    lacking = [name for name in INFLUENCES if name not in plan.standards]
    if result.measured or len(result.readings) == 1:
        lacking = [name for name in lacking if name != "turn.angle"]
    effects = [f"{name} ({INFLUENCES[name]})" for name in lacking]
    if plan.accelerometer_bias_u is None and not result.readings.taken_off.get("accelerometer"):
        effects.insert(0, "bias of the accelerometers (roll, pitch)")
    if effects:
        what = f"standards without a stated uncertainty: {'; '.join(effects)}: results are relative to these"
        yield Remark("relative_to_fixture", "warning", what, do="State them under [standards], and in the plan")
    if not result.told and not result.steep:
        u = degrees(result.forecast)
        yield Remark("gyro_too_coarse", "warning", f"no heading is told: its standard uncertainty would be {u}",
                     do="Use a finer gyro, or two positions turned by 180 deg")  # fmt: skip
