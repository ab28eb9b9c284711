"""Where heads on one body disagree finely: redundancy, drift, orientation, position; and what is only relative."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtrc, fdtrc

from ...core.estimate import Array
from ...core.key import AXES
from ...core.remarks import Remark
from ...core.show.rounding import number, uncertainty
from ...physics.motion.rigid import gradient
from .contrasts import fitted, long_run, redundant
from .found import (
    CLEAR,
    SCALE,
    TURN,
    Calibrated,
    gap_of,
    known_heads,
    mean_acceleration,
    motion_size,
    motion_told,
    weights_of,
)

if TYPE_CHECKING:
    from .reduction import Result

RISK = 1e-3  # of a remark without cause
SURE = 5.0  # standard uncertainties of a departure that is told
TIMES = 3.0  # what is stated, that a departure exceeds
UG = 9.80665e-6  # [m/s^2]


def doubts(result: Result) -> Iterator[Remark]:
    """Yield remarks on a result."""
    yield from _relative(result)
    yield from _redundancy(result)
    yield from _drift(result)
    for one in result.heads:
        yield from _orientation(result, one)
        yield from _position(result, one)


def _relative(result: Result) -> Iterator[Remark]:
    tracks = result.readings.tracks
    known = [tracks[i].mounted for i in known_heads(result.readings)]
    bare = [one.name for one in known if one.bias is None]
    if bare:
        what = f"heads {', '.join(bare)} have no bias of their own: the others are calibrated relative to them"
        yield Remark("relative", "info", what, do="Flip them, and give bias and bias_u of each")
    if old := [one.name for one in known if not one.drift_said]:
        what = f"heads {', '.join(old)}: what their bias drifts since it was found is not stated: it counts as none"
        yield Remark("drift_not_stated", "warning", what, do="Give drift_u, the standard uncertainty a day")
    if missing := [name for name, here in (
        ("position_u", any(one.mounted.position_u > 0.0 for one in tracks)),
        ("orientation_u", any(one.mounted.orientation_u > 0.0 for one in tracks)),
    ) if not here]:  # fmt: skip
        what = f"no {' or '.join(missing)} is stated: positions and orientations count as exact"
        yield Remark("relative_to_fixture", "warning", what, do="State what the drawings or the survey say")
    off = [one for one in result.heads if float(np.linalg.norm(one.weights.off)) > 0.0]
    if off and result.readings.motion.orbit is None and any(np.linalg.norm(one.weights.off) > 0.01 for one in off):
        largest = max(float(np.linalg.norm(one.weights.off)) for one in off)
        size = float(np.max(np.abs(gradient(1.16e-3, np.array([1.0, 0.0, 0.0]))))) * largest / UG
        what = (
            f"no orbit is stated: the gradient of gravity off the line, in low orbit up to {number(size, 2)} ug, is not"
        )
        yield Remark(
            "orbit_not_stated", "warning", f"{what} in the figures", do="Give altitude and vertical under [motion]"
        )


def _redundancy(result: Result) -> Iterator[Remark]:
    """Yield heads that disagree by more than their uncertainties, where more are known than needed."""
    readings = result.readings
    known = known_heads(readings)
    if not result.absolute:
        return
    p = _agreement(result, known)
    if p is None:
        what = "two heads on a line, or as many as the places need: nothing shows whether their biases agree"
        yield Remark("not_redundant", "info", what, do="Calibrate a further head")
        return
    if p < RISK:
        others = {i: _agreement(result, [j for j in known if j != i]) for i in known}
        told = {i: one for i, one in others.items() if one is not None and one >= RISK}
        worst = max(told, key=lambda i: told[i]) if told else None
        what = f"the calibrated heads disagree (probability {number(p, 2)})"
        if worst is not None and len(told) == 1:
            what += f": without {readings.tracks[worst].mounted.name} the others agree"
        do = "Check biases, positions and orientations; flip the heads again"
        yield Remark("heads_disagree", "error", what, do=do)


def _agreement(result: Result, known: Sequence[int]) -> float | None:
    """Return the probability of the disagreement of calibrated heads; None where they are not redundant."""
    mounted = [result.readings.tracks[i].mounted for i in known]
    if len(known) < 3:
        return None
    places = np.array([one.position for one in mounted])
    combined = redundant(places, max(one.position_u for one in mounted))
    if not len(combined):
        return None
    biases = np.array([one.orientation.T @ (np.zeros(3) if one.bias is None else one.bias) for one in mounted])
    free = result.means[list(known)] - biases[:, None, :]
    mean, bound = mean_acceleration(result)
    felt = np.outer(mean, mean) + bound**2 / 3.0 * np.eye(3)
    gamma, unknown = motion_size(result)
    moved = gamma @ gamma.T + 2.0 * unknown**2 * np.eye(3)
    worst = 1.0
    for axis in range(3):
        rest = np.tensordot(combined, free[:, :, axis], 1).T  # (n, q)
        by_scatter, dof = long_run(rest - rest.mean(axis=0))
        stated = np.array([
            (one.orientation.T @ (one.bias_covariance + one.drift_u**2 * np.eye(3)) @ one.orientation)[axis, axis]
            + one.orientation_u**2 * (np.trace(felt) - felt[axis, axis])
            + one.scale_factor_u**2 * felt[axis, axis] + one.position_u**2 * moved[axis, axis]
            for one in mounted
        ])  # fmt: skip
        covariance = by_scatter + (combined * stated) @ combined.T
        q, level = len(combined), rest.mean(axis=0)
        square = float(level @ np.linalg.solve(covariance, level))
        share = float(np.trace(by_scatter) / np.trace(covariance))
        free_dof = dof / max(share, 1e-9) ** 2
        if free_dof > 1e4 or free_dof <= q:
            p = float(chdtrc(q, square))
        else:
            p = float(fdtrc(q, free_dof - q + 1.0, square * (free_dof - q + 1.0) / (free_dof * q)))
        worst = min(worst, 3.0 * p)
    return worst


def _drift(result: Result) -> Iterator[Remark]:
    """Yield a head that drifts against the others."""
    time = np.linspace(-0.5, 0.5, len(result.times))
    design = np.column_stack([np.ones_like(time), time])
    tracks = result.readings.tracks
    found: list[tuple[float, float, float, int, str]] = []
    for at in range(len(tracks)):
        rest = [i for i in range(len(tracks)) if i != at]
        weights = weights_of(result.readings, at, rest)
        if float(np.linalg.norm(weights.off)) > 1e-3 and not motion_told(result):
            continue
        gap = gap_of(result.readings, result.means, result.gammas, at, rest)
        line = fitted(design, gap)
        covariance, dof = long_run(line.influence)
        for a, axis in enumerate(AXES):
            slope, u = float(line.values[1, a]), float(np.sqrt(covariance[3 + a, 3 + a]))
            u_mean = float(np.sqrt(covariance[a, a]))
            if float(fdtrc(1, dof, (slope / u) ** 2)) < RISK / (3.0 * len(tracks)) and abs(slope) > 2.0 * u_mean:
                found.append((abs(slope) / u, slope, u, at, axis))
    if not found:
        return
    _, slope, u, at, axis = max(found)
    alike = {one[3] for one in found if one[4] == axis}
    ranked = sorted((one for one in found if one[4] == axis), reverse=True)
    names = [tracks[i].mounted.name for i in sorted(alike)]
    clear = len(tracks) > 3 and (len(ranked) == 1 or ranked[0][0] > 1.5 * ranked[1][0])
    who = f"head {tracks[at].mounted.name}" if clear or len(names) == 1 else f"one of {', '.join(names)}"
    what = f"{who} drifts against the others: {axis} of the body by {number(slope / UG, 3)} ug over the record"
    what += f" (u {uncertainty(u / UG)} ug); biases are those of the middle"
    do = "Let all heads warm up; or take a part of the record"
    yield Remark("drift", "warning", what, do=do, axis=axis,
                 recording=tracks[at].name if clear or len(names) == 1 else "")  # fmt: skip


def _orientation(result: Result, one: Calibrated) -> Iterator[Remark]:
    """Yield misalignment of a head that its orientation does not explain."""
    estimate, tracks = result.estimate, result.readings.tracks
    if estimate is None or not one.told:
        return
    known = [tracks[i].mounted for i in known_heads(result.readings)]
    own = tracks[one.number - 1].mounted
    of_others = float(
        np.sqrt(sum(float(w) ** 2 * k.orientation_u**2 for w, k in zip(one.weights.weights, known, strict=True)))
    )
    stated = float(np.hypot(own.orientation_u, of_others))
    for key, value, u in zip(estimate.keys, estimate.values.tolist(), estimate.u.tolist(), strict=True):
        if key.at is not None and int(key.at.value) != one.number:
            continue
        if key.quantity == TURN and abs(value) > SURE * np.hypot(u, stated) and stated > 0.0:
            what = f"head {one.name} is turned by {number(float(np.degrees(value)), 3)} deg ({key.axis}) beyond what is"
            what += f" stated (u {uncertainty(float(np.degrees(stated)))} deg)"
            do = "Correct its orientation; the misalignment that is estimated holds"
            yield Remark("orientation_differs", "warning", what, do=do, recording=tracks[one.number - 1].name)
            return
        if key.quantity == SCALE and abs(value) > 0.1 and abs(value) > SURE * u:
            what = f"head {one.name} reads {number(100.0 * value, 3)} % too much in {key.axis}"
            yield Remark("far_from_nominal", "warning", what, do="Check its gain and its unit",
                         recording=tracks[one.number - 1].name)  # fmt: skip
            return


def _position(result: Result, one: Calibrated) -> Iterator[Remark]:
    """Yield a head that is not where it is said to be: it reads turns of the body as another place would."""
    tracks, known = result.readings.tracks, known_heads(result.readings)
    own = tracks[one.number - 1].mounted
    rest = one.line.rest @ own.orientation  # in the body
    pairs = zip(one.weights.weights, known, strict=True)
    stated = own.position_u**2 + sum(float(w) ** 2 * tracks[i].mounted.position_u ** 2 for w, i in pairs)
    stated = float(np.sqrt(stated))
    shift: Array
    if result.gammas is not None:
        gammas = result.gammas - result.gammas.mean(axis=0)
        squares = np.einsum("kij,kil->jl", gammas, gammas)
        if np.linalg.cond(squares) > 1e8:
            return
        inverse = np.linalg.inv(squares / len(rest))
        shift = inverse @ np.einsum("kij,ki->j", gammas, rest) / len(rest)
        left = rest - gammas @ shift
        covariance, _ = long_run(np.einsum("kij,ki->kj", gammas, left) @ inverse)
    elif len(known) == 2:
        first, second = known
        turned = result.means[second] - result.means[first]
        turned = turned - turned.mean(axis=0)
        power, noise = float(np.mean(turned**2)), float(np.mean(rest**2)) * 2.0 / (1.0 + one.weights.growth**2)
        if power < CLEAR * noise:
            return
        along = float(np.sum(turned * rest) / np.sum(turned**2))
        line = tracks[second].mounted.position - tracks[first].mounted.position
        shift = along * line
        left = np.sum(turned * (rest - along * turned), axis=1)[:, None] / (3.0 * power)
        u = float(np.hypot(np.sqrt(long_run(left)[0][0, 0]), noise / power))
        covariance = np.outer(line, line) * u**2
    else:
        return
    u = float(np.sqrt(np.trace(covariance)))
    size = float(np.linalg.norm(shift))
    if size > SURE * u and size > TIMES * max(stated, 1e-3):
        place = ", ".join(number(float(x), 3) for x in shift)
        what = f"head {one.name} reads turns of the body as if it were {number(size, 3)} m (u {uncertainty(u)} m) from"
        what += f" where it is said to be: by ({place}) m"
        do = "Check position of all heads; what is found is the shift of this one if the others are right"
        yield Remark("wrong_position", "error", what, do=do, recording=tracks[one.number - 1].name)
