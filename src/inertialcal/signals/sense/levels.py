"""Changes of sign, scale or axis by the levels before and after a jump: no motion does that to all channels at once."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np

from ...core.estimate import Array
from .change import Change, Factors, unit_of
from .jumps import CLEAR, NEAR, OFFSET, Jump, common_factor
from .noise import LEAST_NOISE, SAME_NOISE, Noise

TIGHT = 4.5  # standard deviations within which levels agree
RELATIVE = 0.02  # of a jump: what levels may differ by besides
EXACT = 0.002  # the same of a change of sign, which nothing else makes
SMOOTH = 0.5  # of a jump: steps as large elsewhere are motion
ALONE = 1, 2, 4, 16, 64  # samples whose means are compared for that


def by_levels(
    x: Array,
    noise: Noise,
    jumps: Sequence[Jump],
    names: Sequence[str],
    factors: Factors,
    applied: Array | None,
    motion: float,
) -> list[Change]:
    """Return the change that explains a jump of the levels; the largest jump first."""
    ordered = sorted(jumps, key=lambda one: -float(np.linalg.norm(one.step)))
    alone: list[bool] = []
    for number, one in enumerate(ordered):
        if applied is not None and _is_driven(one, applied):
            continue
        change = _scaled(one, noise, names, factors)
        if change is None and float(np.linalg.norm(one.step)) > motion:
            alone = alone or _are_alone(ordered, x)
            change = (_mirrored(one, names) or _exchanged(one, names)) if alone[number] else None
        if change is None and np.isfinite(motion):
            change = _exchanged_biases(one, names)
        if change is not None:
            return [change]
    return []


def _are_alone(jumps: Sequence[Jump], x: Array) -> list[bool]:
    """Whether the record is smooth but for each jump, so that this is no motion: in a few looks for all of them."""
    total = np.zeros((x.shape[1], len(x) + 1))
    np.cumsum(x.T - x[0][:, None], axis=1, out=total[:, 1:])
    found = [False] * len(jumps)
    for size in ALONE:  # short means where it moves, long ones where it is noisy
        left = [
            i
            for i, one in enumerate(jumps)
            if not found[i] and (size == ALONE[0] or 2 * size <= min(one.before.size, one.after.size))
        ]
        if not left:
            break
        means = (total[:, size:] - total[:, :-size]) / size
        step = means[:, size:] - means[:, :-size]  # of the samples from ``size`` on
        bend = step[:, size:] - step[:, :-size]  # a steady turn has none
        for change, width in ((step, 2), (bend, 3)):
            length = np.sqrt(np.sum(change * change, axis=0))
            before = np.concatenate(([0.0], np.maximum.accumulate(length)))  # the largest of those before each
            after = np.append(np.maximum.accumulate(length[::-1])[::-1], 0.0)
            for i in left:
                first, stop = (min(max(at, 0), len(length)) for at in (jumps[i].at - width * size, jumps[i].at))
                limit = SMOOTH * float(np.linalg.norm(jumps[i].step))
                found[i] |= bool(max(before[first], after[stop]) < limit)
    return found


def _is_driven(jump: Jump, applied: Array) -> bool:
    """Whether the applied quantity jumps there, too."""
    near = applied[max(0, jump.at - 3) : jump.at + 3]
    return bool(np.ptp(near) > 0.2 * np.abs(jump.step).max())


def _mirrored(jump: Jump, names: Sequence[str]) -> Change | None:
    """Return a change of sign: every level that jumps goes to its negative."""
    before, after, step, u = jump.before.level, jump.after.level, np.abs(jump.step), jump.u
    jumped = step > 0.5 * CLEAR * u
    mirrored = np.abs(after + before) <= TIGHT * u + EXACT * step.max()
    if not np.any(step > CLEAR * u) or not _same_noise(jump):
        return None
    # Electronics behind the change may add an offset to one of three axes
    most = np.count_nonzero(mirrored & jumped) >= 2 and bool(
        np.all(np.abs(after + before) <= OFFSET * step + TIGHT * u)
    )
    if not np.all(mirrored[jumped]) and not most:
        return None
    turned = names if np.all(mirrored) or most else [name for name, one in zip(names, jumped, strict=True) if one]
    return Change("sign_changed", jump.at, tuple(turned), -1.0)


def _same_noise(jump: Jump) -> bool:
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = jump.after.scatter / jump.before.scatter
    return bool(np.all((ratio > 1.0 / 3.0) & (ratio < 3.0) | ~np.isfinite(ratio)))


def _exchanged(jump: Jump, names: Sequence[str]) -> Change | None:
    """Return an exchange of axes: every level is that of another channel, give or take one common offset."""
    before, after, u = jump.before.level, jump.after.level, jump.u
    k = len(names)
    size = float(np.abs(jump.step).max())
    if k < 2:
        return None
    best: tuple[float, tuple[int, ...]] | None = None
    for order in permutations(range(k)):
        if order == tuple(range(k)):
            continue
        off = after - before[list(order)]
        common = float(np.median(off)) if k > 2 else 0.0  # another sensor has another bias
        rest = np.abs(off - common)
        allowed = TIGHT * (u + u[list(order)]) + RELATIVE * size
        told = np.abs((after - before) - float(np.median(after - before))) > 8.0 * allowed
        if np.all(rest <= allowed) and told.any():
            score = float(np.max(rest / allowed))
            if best is None or score < best[0]:
                best = score, order
    if best is None:
        best = _partly_exchanged(jump)
    if best is None:
        return None
    return Change("axes_changed", jump.at, tuple(names), 1.0, None, tuple(names[i] for i in best[1]))


def _exchanged_biases(jump: Jump, names: Sequence[str]) -> Change | None:
    """Return an exchange of two of three axes at rest, where long lines agree exactly: no start of a turn does that."""
    before, after, u = jump.before.level, jump.after.level, jump.u
    if len(before) != 3 or min(jump.before.size, jump.after.size) < NEAR:
        return None
    for order in ((1, 0, 2), (2, 1, 0), (0, 2, 1)):
        moved = np.array([i != j for i, j in enumerate(order)])
        agrees = np.abs(after - before[list(order)]) <= TIGHT * np.hypot(u, u[list(order)])
        if np.all(agrees) and np.all(np.abs(jump.step[moved]) > CLEAR * u[moved]) and _same_noise(jump):
            return Change("axes_changed", jump.at, tuple(names), 1.0, None, tuple(names[i] for i in order))
    return None


def _partly_exchanged(jump: Jump) -> tuple[float, tuple[int, ...]] | None:
    """Return an exchange in which two of three axes go on as their neighbours, and the third shows another sensor."""
    before, after, u = jump.before.level, jump.after.level, jump.u
    size = float(np.abs(jump.step).max())
    if len(before) != 3:
        return None
    allowed = TIGHT * 2.0 * u.max() + 1.5 * RELATIVE * max(size, float(np.linalg.norm(before)))
    for order in ((1, 2, 0), (2, 0, 1)):
        agrees = np.abs(after - before[list(order)]) <= allowed
        moved = np.abs(jump.step) > 2.0 * allowed
        if np.count_nonzero(agrees) >= 2 and np.count_nonzero(moved) >= 2 and np.any(agrees & moved):
            return 1.0, order
    return None


def _scaled(jump: Jump, noise: Noise, names: Sequence[str], factors: Factors) -> Change | None:
    """Return a change of unit or scale: one factor for all levels and for the noise."""
    before, after = jump.before, jump.after
    f = common_factor(jump)
    if not f > 0.0 or abs(np.log(f)) < np.log(1.5):
        return None
    u_level = np.hypot(after.u, f * before.u)
    tells = (np.abs(jump.step) > CLEAR * jump.u) & (np.abs(after.level) > 5.0 * after.u)
    agrees = np.abs(after.level - f * before.level) <= TIGHT * u_level + RELATIVE * np.abs(f * before.level)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.log(after.scatter / before.scatter)
    at = min(max(jump.at // noise.size, 1), len(noise.log) - 1)
    overall = noise.ratio(at)
    off = np.minimum(np.abs(ratio - np.log(f)), np.abs(overall - np.log(f)))
    loud = np.isfinite(off) & (off > SAME_NOISE)
    if not np.all(agrees) or not tells.any() or loud.any():
        return None
    unit = unit_of(f, factors, 0.02)
    if unit is not None and (np.count_nonzero(tells) >= min(2, len(names)) or abs(np.log(f)) > LEAST_NOISE):
        return Change("unit_changed", jump.at, tuple(names), unit[0], unit[1])
    if np.count_nonzero(tells) >= 2:
        return Change("scale_changed", jump.at, tuple(names), f)
    return None
