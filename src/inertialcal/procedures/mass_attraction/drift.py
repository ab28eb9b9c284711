"""Drift of the runs that is not smooth: what `signals.sine` cannot keep out of a response.

*Near the drive.* The mean response changes with the length of the smoothing (`signals.sine.cross_checks`).

*What repeats.* Drift that is the same in every run is in no scatter of their responses. Where it is smooth, none of it
enters them; where it has kinks or corners, it does, and it shows in the mean over the runs of the contrasts, sums of
readings that neither the drive nor a smooth drift enters: they are larger than their scatter from run to run explains.
For m contrasts of R runs, weighted by their noise, ``R mean^2`` over the variance between runs has Fisher's F with m
and (R - 1) m degrees of freedom. F sees a saw-tooth, which is in all contrasts; a kink is in few, so the mean is also
compared with a kink at each dwell, by Student's t and Bonferroni. Runs whose drive starts in different phases need no
such test: what repeats cancels in their mean.

Both are errors: the verdict is INCONCLUSIVE, and no model is written. Of 1,000 campaigns of white noise, flicker or a
walk, 10 are called so. A kink of 100 responses in each of four runs of 100 dwells, with noise of a quarter of a
response, moves the scale factor by up to 1.8 % (u = 1.9 %) before dwell 75 and is found in 2 to 15 of 100 campaigns;
at dwell 80 by 2.8 % and in 50, at dwell 85 by 3.9 % and in 93. Nothing finds the earlier ones: their contrasts in the
mean over four runs are 1.2 to 3 standard deviations.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy import linalg, special

from ...core.estimate import Array
from ...core.remarks import Remark
from ...signals.sine.cross_checks import CrossCheck, cross_checks, smoothing_remark
from ...signals.sine.fit import contrasts_of
from ...signals.sine.noise import noise_of
from .joining import phases_ahead
from .line import line_design
from .readings import Run
from .response import Response

FALSE = 0.006  # chance that noise of the runs alone is called a drift that repeats
SHOWN = 1e-6  # part of the largest kink in the contrasts, that one must have


def drift_remarks(runs: Sequence[Run], responses: Sequence[Response]) -> Iterator[Remark]:
    """Yield what the drift of runs does to their mean response.

    Parameters
    ----------
    runs : sequence of Run
        With readings, of any kind.
    responses : sequence of Response
        Of them, in the same order.
    """
    moved = [one for one in responses if one.moved and one.fitted is not None]
    if moved and np.any(phases_ahead(moved)):
        return  # what repeats cancels, the rest is in the scatter of the runs
    if moved:
        yield from _near_drive(moved)
        yield from _methods(moved)
    yield from _repeats(runs, responses)


def _near_drive(moved: Sequence[Response]) -> Iterator[Remark]:
    weights = np.array([1.0 / one.u_scale_factor**2 for one in moved])
    weights /= weights.sum()
    applied = np.array([one.applied for one in moved])
    fits = [one.fitted.found for one in moved if one.fitted is not None]
    shifts = []
    for each in zip(*(fit.shifts for fit in fits), strict=True):
        if not each[0].across:
            value, u, dof = (np.array([float(getattr(one, name)[0]) for one in each]) for name in ("value", "u", "dof"))
            total = float(np.linalg.norm(weights * u / applied))
            shifts.append((each[0].length, float(weights @ (value / applied)), total, float(np.mean(dof))))
    scale = float(weights @ [one.scale_factor for one in moved])
    u_scale = float(np.linalg.norm(weights * [one.u_scale_factor for one in moved]))
    if (found := smoothing_remark(shifts, scale, u_scale)) is not None:
        yield found


def _methods(moved: Sequence[Response]) -> Iterator[Remark]:
    """Compare the mean response with that by the other methods, of the runs that have them [output unit]."""
    made = [check for one in moved if one.fitted is not None
            for check in cross_checks(one.fitted.found, one.series[np.isfinite(one.series)])]  # fmt: skip
    for name in dict.fromkeys(check.name for check in made):
        each = np.array([(check.difference, check.u_difference) for check in made
                         if check.name == name and check.value is not None], dtype=np.float64)  # fmt: skip
        if len(each):
            u = float(np.linalg.norm(each[:, 1])) / len(each)
            mean = CrossCheck(name, difference=float(each[:, 0].mean()), u_difference=u)
            if mean.disagrees:
                yield mean.remark()


def _repeats(runs: Sequence[Run], responses: Sequence[Response]) -> Iterator[Remark]:
    """Test the mean contrasts of runs with one schedule of dwells, at the dwells that all of them have."""
    series = {one.name: one.series for one in responses}
    groups: dict[tuple[int, float, int], list[Run]] = {}
    for run in runs:
        schedule = run.schedule
        key = (len(schedule), round(schedule.step / schedule.period, 6), schedule.samples_per_cycle)
        groups.setdefault(key, []).append(run)
    group = max(groups.values(), key=len, default=[])
    if len(group) < 2:
        return
    readings = np.column_stack([series[run.name] for run in group])
    there = np.asarray(np.isfinite(readings).all(axis=1))
    schedule = next((run.schedule for run in group if run.moved), group[0].schedule)
    design = line_design(schedule, there)
    values, walks = (np.concatenate(one) for one in contrasts_of(design, design.means(readings[there])))
    kinks = [sums.T @ np.maximum(np.subtract.outer(one.times, one.times[1:-1]), 0.0)
             for one, (sums, _) in zip(design.stretches, design.contrasts, strict=True)]  # fmt: skip
    chance = repeating_chance(values, walks, linalg.block_diag(*kinks))
    if chance < FALSE:
        what = f"the {len(group)} runs share a drift that is not smooth: noise would make its like with probability"
        what += f" {chance:.2g}"
        do = "It may be part of the response: start every other run half a cycle later, so that what repeats cancels"
        yield Remark("drift_repeats", "error", what, do=do)


def repeating_chance(contrasts: Array, walks: Array, kinks: Array) -> float:
    """Return the chance that noise alone makes means over the runs as large, or as much like a kink.

    Parameters
    ----------
    contrasts : ndarray, shape (m, R)
        Of each run.
    walks : ndarray, shape (m,)
        Their variances for a walk of unit steps.
    kinks : ndarray, shape (m, k)
        Contrasts of kinks of any size.
    """
    m, runs = contrasts.shape
    apart = contrasts @ linalg.helmert(runs).T  # differences between the runs, uncorrelated
    noise = noise_of([apart.T.reshape(-1, 1)], [np.tile(walks, runs - 1)])
    share = float(noise.share @ noise.chance[:, 0])
    root = np.sqrt(1.0 - share + share * walks / noise.unit)[:, None]
    mean, dof = (contrasts / root).mean(axis=1), (runs - 1.0) * m
    between = float(np.sum((apart / root) ** 2)) / dof
    f = float(special.fdtrc(m, dof, runs * float(mean @ mean) / m / between))
    size = np.linalg.norm(kinks / root, axis=0)
    clear = size > SHOWN * size.max()
    t = np.abs(mean @ (kinks / root)[:, clear]) / size[clear] * np.sqrt(runs / between)
    kink = 2.0 * float(clear.sum()) * float(special.stdtr(dof, -t.max()))
    return min(2.0 * min(f, kink), 1.0)
