"""Mistakes that the physics shows: units, axes that disagree, rotations that do not close against gravity.

At rest every position reads gravity, whatever the orientation: 1 in m/s^2 is a reading in g. Between two positions
gravity tells by how much the unit was turned: a gyro in deg/s that is taken for rad/s turns 57 times too far, a sample
rate that is twice the true one lets it turn half as far, and a gyro whose axes are not those of the accelerometers
carries gravity to the wrong place however large its rates are taken. Where the given axes and scale carry it to within
``CLOSE`` nothing is searched.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations, product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from ...core.errors import DataError
from ...core.estimate import Array
from ...core.key import AXES
from ...core.remarks import Remark
from ...core.show.rounding import uncertainty
from .fit.fixture import ASSUMED, FACE, FACE_FOUND
from .fit.linear_sensor import HIDDEN as JUDGED_BY_NOTHING
from .fit.linear_sensor import Observability
from .fit.rotations import Packed, Problem, angles, converged, packed
from .plan import INFLUENCES
from .readings import Readings, local_gravity
from .rows import missing

if TYPE_CHECKING:
    from .reduction import Result

CLOSE = np.radians(8.0)  # median error from which the start is good enough to fit from
FOUND = np.radians(6.0)  # median error after a fit, below which another start explains the rotations
MUCH = 0.2  # relative scale factor error that is no calibration matter
OBLIQUE = 0.7  # part of a turn's largest component, above which another one may be what reads most
SILENT = 0.3  # part of what the gyros usually read of a turn, below which they did not feel it
PER_G = 9.80665
GRID: Array = 1.3 ** np.arange(-20.0, 21.0)  # scales tried, 1/190 to 190
WIDE: Array = 1.3 ** np.arange(-60.0, 11.0)  # for readings in counts of an unknown scale factor
STEPS = 60  # samples of a rotation that a search uses
LIKELY = 3  # permutations that are fitted
USED = 8  # transitions that a search uses
DEGREE = float(np.pi / 180.0)
HIDDEN = 0.5  # share of a variance that nothing shows, from which on it is remarked
CONFLICT = 0.01  # probability of a disagreement of prior and positions, below which it is remarked
CLEARLY = 1.5  # error of gravity in positions left out over another, from which on it is called worse
WIDE_INTERVAL = 0.05  # half of an interval of 95 %, over gravity or the scale factor
STATE_A_PRIOR = 'state what is known of the unit: --prior-misalignment "0.02 rad", --prior-scale-factor "3 %", ...'
PRIOR_UNIT = {"misalignment": "rad", "scale_factor_error": "", "bias": "m/s^2"}
WIDEST = 12.71  # t of 97.5 % with one degree of freedom
ALONE = 0.8  # leverage of a position on which some combination rests


def check_units(readings: Readings, gravity: float) -> None:
    """Refuse accelerometers that say m/s^2 and read something else at rest.

    Raises
    ------
    DataError
        ``unit_slip``.
    """
    if readings.acc.unit != "m/s^2":
        return
    sizes = np.sqrt(np.einsum("ij,ij->i", readings.acc.mean, readings.acc.mean))
    if 0.5 * gravity < sizes.min() and sizes.max() < 1.5 * gravity:
        return
    size = float(np.median(sizes))
    if 0.5 * gravity < size < 1.5 * gravity:
        return
    slips = {"g": 1.0, "mg": 1000.0, "ft/s2": gravity / 0.3048, "cm/s2": 100.0 * gravity}
    unit = min(slips, key=lambda name: abs(np.log(size / slips[name]))) if size > 0.0 else "g"
    near = abs(np.log(size / slips[unit])) < np.log(1.25) if size > 0.0 else False
    raise DataError(
        f"at rest the accelerometers read {size:.4g} m/s^2, gravity is {gravity:.4g} m/s^2",
        readings.where[0] if readings.where else "",
        f"these are readings in {unit}" if near else "the readings are not in m/s^2, or the unit never rests",
        f'State the unit: --unit acc={unit}, or unit = "{unit}" of the channels in campaign.toml'
        if near
        else "State the unit of the accelerometers",
        "unit_slip",
    )


def signed_permutations() -> list[Array]:
    """Return the 48 matrices that take axes to axes, the identity first."""
    found = []
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        matrix = np.zeros((3, 3))
        matrix[np.arange(3), list(order)] = signs
        found.append(matrix)
    return found


def start_of(problem: Problem, scale_known: bool, places: Sequence[str] = ()) -> Array:
    """Return an inverse matrix from which the fit converges; the identity where that is good enough.

    Parameters
    ----------
    problem : Problem
        Rotations, readings over the ideal scale factor.
    scale_known : bool
        Whether readings are in rad/s, so that a factor is a mistake and not a choice.
    places : sequence of str
        Of the turns by known angles, for messages.

    Raises
    ------
    DataError
        ``axes_disagree`` where other axes explain the rotations, and these do not.
    """
    if problem.sizes[0] < 3:
        return _start_of_turns(problem, scale_known, places)
    small = _few(problem)
    eye = np.eye(3)
    if scale_known and np.median(angles(small, eye)) < CLOSE:
        return eye
    grid = GRID if scale_known else WIDE
    scales = _scan(small, eye, grid)
    start = scales[0][1] * eye
    for _, scale in scales[:3]:
        W = _converged(small, scale * eye)
        if np.median(angles(small, W)) < FOUND and np.all(np.diag(W) > 0.5 * np.abs(W).sum(axis=1)):
            return _converged(small, scale * eye)
    ranked = sorted((*_scan(small, P, grid[::2])[0], k) for k, P in enumerate(signed_permutations()))
    for _, scale, k in ranked[:LIKELY]:
        W = _converged(small, scale * signed_permutations()[k])
        if k != 0 and np.median(angles(small, W)) < FOUND:
            largest = [int(np.argmax(np.abs(W[:, axis]))) for axis in range(3)]
            pairs = [
                f"gyro {AXES[i]} turns about accelerometer axis {'-' if W[j, i] < 0.0 else ''}{AXES[j]}"
                for i, j in enumerate(largest)
                if j != i or W[j, i] < 0.0
            ]
            mirror = "; that is a mirror image: one sign is wrong" if np.linalg.det(W) < 0.0 else ""
            raise DataError(
                f"the axes of gyros and accelerometers disagree: {', '.join(pairs)}{mirror}",
                why="gravity carried by the gyros does not arrive where the accelerometers see it",
                do="Rename or invert the columns of one of them",
                code="axes_disagree",
            )
    return start


def _few(problem: Problem) -> Problem:
    """Return the problem with some transitions alone: those that take the least time."""
    k = problem.sizes[0]
    first = problem.moves.first
    chosen = np.sort(np.argsort(np.diff(first), kind="stable")[: min(USED, k)])
    moves = thinned(problem.moves, first[chosen], first[chosen + 1])
    ends = problem.ends
    ends = type(ends)(*(getattr(ends, name)[chosen] for name in ("start", "stop", "before", "after", "across")))
    return Problem(moves, ends, packed([], [], []), np.zeros((0, 3)), problem.noise, problem.up_variance)


def thinned(moves: Packed, start: NDArray[np.int64], stop: NDArray[np.int64]) -> Packed:
    """Return some rotations, from which sample to which, with at most ``STEPS`` samples each: block means."""
    block = np.maximum(-(-(stop - start) // STEPS), 1)
    counts = -(-(stop - start) // block)
    first, begins = (np.concatenate([[0], np.cumsum(one)]) for one in (counts, stop - start))
    rows = np.arange(begins[-1]) + np.repeat(start - begins[:-1], stop - start)
    which = np.repeat(np.arange(len(start)), counts)
    edges = begins[which] + (np.arange(first[-1]) - first[which]) * block[which]
    size = np.diff(np.append(edges, begins[-1]))
    time = np.concatenate([[0.0], np.cumsum(moves.h[rows])])[:-1]
    z, f, middle = (np.add.reduceat(one, edges, axis=0) for one in (moves.z[rows], moves.f[rows], time))
    h = np.diff(middle / size, append=0.0)
    h[first[1:] - 1] = 0.0
    return Packed(z / size[:, None], f / size[:, None], h, first.astype(np.int64))


def _scan(problem: Problem, direction: Array, grid: Array) -> list[tuple[float, float]]:
    """Median error and scale of the best scales, best first."""
    found = [(float(np.median(angles(problem, scale * direction))), float(scale)) for scale in grid]
    return sorted(found)


def _converged(problem: Problem, W: Array) -> Array:
    return converged(problem, W, np.ones(2 * problem.sizes[0], dtype=bool))


def _start_of_turns(problem: Problem, scale_known: bool, places: Sequence[str]) -> Array:
    """Inverse matrix from turns by known angles: their mean scale, unless they turn about other axes than named."""
    if not problem.sizes[1]:
        return np.eye(3)
    total = problem.turns.sums[0]
    named, read, rows = np.abs(problem.turned), np.argmax(np.abs(total), axis=1), np.arange(len(total))
    along = np.where(named[rows, read] > OBLIQUE * named.max(axis=1), read, np.argmax(named, axis=1))
    share = np.linalg.norm(total, axis=1) / np.linalg.norm(problem.turned, axis=1)
    k = int(np.argmin(share))
    if share[k] < SILENT * np.median(share):
        axis = AXES[along[k]]
        raise DataError(
            f"a turn about {axis} shows in no gyro",
            places[k] if places else "",
            why=f"gyro {axis} is stuck or not connected, or the unit was not turned there",
            do=f"Check the channel of gyro {axis}; else leave this turn out",
            code="turn_not_read",
        )
    signs = np.sign(total[rows, read]) * np.sign(problem.turned[rows, along])
    if np.any(read != along) or len(set(signs)) > 1:
        k = int(np.flatnonzero((read != along) | (signs != signs[0]))[0])
        raise DataError(
            f"a turn about {AXES[along[k]]} shows in gyro {'-' if signs[k] < 0 else ''}{AXES[read[k]]}",
            places[k] if places else "",
            why="the gyro axes are not those of the turns",
            do="Rename or invert the columns, or correct axis and sense of the turn",
            code="axes_disagree",
        )
    scale = float(np.median(problem.turned[rows, along] / total[rows, read]))
    return scale * np.eye(3)


def judged_scale(W: Array, determined: NDArray[np.bool_], unit: str, stated: bool, where: str = "") -> list[Remark]:
    """Return the remark that rotations do not close, where readings in known units are off by a factor.

    Parameters
    ----------
    W : ndarray, shape (3, 3)
        Inverse of the matrix, over the ideal scale factor.
    determined : ndarray of bool, shape (3,)
        Whether the rotations tell the scale factors.
    unit : str
        Of the readings of the gyros.
    stated : bool
        Whether the ideal scale factor is known: by the unit or by the plan.
    where : str
        Recording, and the first position in it.

    Raises
    ------
    DataError
        ``unit_slip`` where the factor is that of degrees and radians.
    """
    own = np.abs(np.diag(W))[determined]
    if not stated or not len(own):
        return []
    factor = float(np.median(own))  # true rate over the rate that was read
    if abs(np.log(factor)) < np.log(1.0 + MUCH):
        return []
    size = f"the gyros read {1.0 / factor:.4g} times the rotation that gravity and the known angles show"
    if min(abs(np.log(factor / DEGREE)), abs(np.log(factor * DEGREE))) < np.log(1.0 + MUCH):
        other = "deg/s" if factor < 1.0 else "rad/s"
        do = f'State the unit: --unit gyro={other}, or unit = "{other}" of the channels in campaign.toml'
        raise DataError(size, where=where, why=f"these are readings in {other}", do=do, code="unit_slip")
    for ratio in (2.0, 0.5, 4.0, 0.25):
        if abs(np.log(factor / ratio)) < np.log(1.1):
            way = f"{ratio:g} times too high" if ratio > 1.0 else f"{1.0 / ratio:g} times too low"
            what = f"{size}: the sample rate is probably {way}"
            do = "Check the sample rate; for known turns, their angle"
            return [Remark("sample_rate_suspect", "error", what, where, do=do)]
    what = f"{size}: the time axis, the unit or the scale factor of the gyros is wrong ({unit})"
    return [Remark("rotations_do_not_close", "error", what, where, do="Check sample rate, stamps and unit")]


def remarks_of(result: Result) -> list[Remark]:
    """Return the remarks, the gravest first."""
    acc, readings = result.acc, result.readings
    found = []
    if not acc.observed.whole:
        found.append(_unobserved("positions", acc.observed, "accelerometers"))
    if acc.free == 0:
        what = f"{len(readings)} positions for {acc.observed.rank} unknowns: no degrees of freedom left"
        do = "Lay the unit into more orientations" + ("" if acc.known else f"; or {STATE_A_PRIOR}")
        found.append(Remark("no_dof", "warning", what, do=do))
    found += _prior_remarks(result)
    found += _scatter_remarks(result)
    for k in np.flatnonzero(acc.outliers):
        what = "this position disagrees with the others: left out of the accelerometers"
        found.append(Remark("outlier_position", "warning", what, readings.place(int(k)), do="Check it"))
    found += _gyro_remarks(result)
    if acc.free > 0 and not acc.known:
        with np.errstate(divide="ignore", invalid="ignore"):
            share = 1.0 - acc.residuals[:, 0] / acc.deletion[:, 0]
        at = np.flatnonzero(~acc.outliers & (share > ALONE))
        if len(at):
            worst = int(at[np.argmax(share[at])])
            what = f"one combination of accelerometer parameters rests on this position by {100.0 * share[worst]:.0f} %"
            place = readings.place(worst)
            found.append(Remark("position_alone", "info", what, place, len(at), "Lay another position near it"))
    if names := missing(result):
        effects = "; ".join(f"{name} ({INFLUENCES[name]})" for name in names)
        what = f"no uncertainty stated for {effects}: results are relative to the fixture"
        found.append(Remark("relative_to_fixture", "warning", what, do="State them under [standards]"))
    if result.plan.gravity is None and result.plan.latitude is None:
        what = "local gravity not given: standard gravity used, up to 0.3 % off"
        found.append(Remark("gravity_assumed", "warning", what, do="Give gravity, or the latitude of the site"))
    return found


def _prior_remarks(result: Result) -> list[Remark]:
    """Return what a stated prior does; without one, which figures the positions hardly determine."""
    plan, judged, found = result.plan, result.prior, list[Remark]()
    if judged is None:
        if plan.priors and result.acc.known:
            what = "the prior is not used: the orientations are known, and their positions determine the accelerometers"
            found.append(Remark("prior_not_used", "warning", what, do="Leave the prior out"))
        elif plan.priors:
            what = "the prior is not used: with it, too, no degree of freedom is left"
            found.append(Remark("prior_not_used", "warning", what, do="State a prior on the other quantities, too"))
        return found + _hardly_determined(result)
    sizes = {name: float(np.sqrt(np.mean(errors**2))) for name, errors in judged.left_out.items()}
    own, alone, raw = (sizes[name] for name in ("prior", "without_prior", "as_read"))
    prior = ", ".join(f"{name} {uncertainty(u)} {PRIOR_UNIT[name]}".strip() for name, u in judged.stated.items())
    what = (
        f"prior on the accelerometers: {prior}. In a position left out, gravity is off by {own:.2g} m/s^2 with it, "
        f"{alone:.2g} without it, {raw:.2g} as read"
    )
    if own > CLEARLY * min(alone, raw):
        better = "the positions alone" if alone <= raw else "the bare readings"
        do = f"By positions left out, {better} are better: leave the prior out, or check it"
        found.append(Remark("prior_does_not_help", "warning", what, do=do))
    else:
        found.append(Remark("prior_used", "info", what))
    if judged.p_value < CONFLICT:
        key, size = judged.farthest
        what = (
            f"the positions disagree with the prior (p = {judged.p_value:.1g}): {key.quantity} {key.axis} lies "
            f"{abs(size):.2g} times its prior u from zero, and a wrong prior biases every figure"
        )
        found.append(Remark("prior_conflict", "warning", what, do="State a wider prior, or leave it out"))
    return found


def _hardly_determined(result: Result) -> list[Remark]:
    """Return the remark that intervals are wider than anybody needs: a data sheet knows more."""
    one, g = result.estimates.get("accelerometer"), local_gravity(result.plan)
    if one is None or result.acc.known:
        return []
    if float(one.u.max()) * WIDEST < WIDE_INTERVAL * min(g, 1.0) and float(one.dof.min()) >= 1.0:
        return []
    half = stdtrit(one.dof, 0.975) * one.u
    wide = [
        f"{key.quantity} {key.axis}"
        for key, size in zip(one.keys, half.tolist(), strict=True)
        if key.quantity in PRIOR_UNIT and size / (g if key.quantity == "bias" else 1.0) > WIDE_INTERVAL
    ]
    if not wide:
        return []
    what = f"intervals wider than {100.0 * WIDE_INTERVAL:.0f} % of gravity, or of the scale factor: {', '.join(wide)}"
    do = f"Add orientations between the faces, about all axes; or {STATE_A_PRIOR}"
    return [Remark("hardly_determined", "warning", what, do=do)]


def _scatter_remarks(result: Result) -> list[Remark]:
    """Say what scatter nothing shows, and which stated one the readings contradict."""
    found, laid = [], result.acc.laid
    for kind, one in result.estimates.items():
        parts = [part.covariance.diagonal() for part in one.components if part.origin.level == JUDGED_BY_NOTHING]
        if not parts:
            continue
        unseen = sum(parts, np.zeros(len(one.names)))
        names = [name for name, part, u in zip(one.names, unseen, one.u, strict=True) if part > HIDDEN * u**2]
        if not names:
            continue
        what = f"{kind}: no repeats show the scatter of {', '.join(names)}; their u is mostly an upper bound"
        do = "Lay each face and make each turn again"
        if kind == "accelerometer" and laid is not None and laid.widened == 1.0:
            what = f"accelerometer: no face was laid again, so that u of {', '.join(names)} assumes a scatter between "
            what += f"positions of {ASSUMED:g} times the noise inside them"
            do = "Lay each face again: repeats show the scatter along gravity"
        elif kind == "accelerometer" and laid is not None:
            do = "Lay each face again, or add columns of the scatter of samples, such as acc_x_std"
        found.append(Remark("scatter_not_judged", "warning", what, do=do))
    if laid is not None and laid.contradicted:
        size = np.degrees(np.sqrt(laid.found.variances[FACE_FOUND]))
        stated = np.degrees(result.plan.standards[FACE].u)
        what = (
            f"opposite faces show them askew by {size:.2g} deg, not by {stated:.2g} deg as stated: {size:.2g} deg used"
        )
        do = "Correct fixture.orientation, or the faces"
        found.append(Remark("face_error_disagrees", "warning", what, do=do))
    return found


def _gyro_remarks(result: Result) -> list[Remark]:
    gyro, readings = result.gyro, result.readings
    if gyro is None:
        return []
    found = []
    for k in np.flatnonzero(gyro.rest.outliers):
        what = "the gyro bias differs here: position left out of bias and g-sensitivity"
        found.append(Remark("outlier_at_rest", "warning", what, readings.place(int(k)), do="Was the unit moved?"))
    if gyro.rotated is not None:
        rotations = (*readings.transitions, *readings.turns)
        for k in np.flatnonzero(gyro.rotated.outliers):
            what = "this rotation disagrees with the others: left out"
            found.append(Remark("outlier_rotation", "warning", what, rotations[k].where, do="Check it"))
        if not gyro.rotated.observed.whole:
            found.append(_unobserved("rotations", gyro.rotated.observed, "gyros"))
        elif np.all(np.diag(gyro.rotated.W) < 0.0):
            what = "all gyros read the known turns with the opposite sign: scale factors come out negative"
            do = "If the turns were clockwise, change the sign of the angles"
            in_si = readings.gyro is not None and readings.gyro.unit == "rad/s"
            stated = result.plan.gyro_scale_factor is not None or in_si
            if any(one.assumed for one in rotations):
                what = "all gyros read the turns, taken as +360 deg, with the opposite sign"
                do, stated = (
                    "If they were clockwise, state it: --turn=-360deg; else check the signs of the gyros",
                    False,
                )
            found.append(Remark("turn_sense", "error" if stated else "warning", what, do=do))
        found += _carried_remarks(gyro.angles)
        fit = gyro.rotated.found
        if fit is not None and fit.free == 0:
            what = "no rotation was repeated: the uncertainty leaves out the scatter between rotations"
            found.append(Remark("not_repeated", "warning", what, do="Make each turn again, and back"))
    if gyro.rest.g_sensitivity is None and result.plan.g_sensitivity is not False:
        found.append(
            Remark("no_g_sensitivity", "info", f"g-sensitivity of the gyros not estimated: {gyro.rest.reason}")
        )
    return found


def _carried_remarks(angles: Array) -> list[Remark]:
    """Say that gyros do not carry gravity to where it is, by the angles that transitions leave."""
    missed = float(np.median(angles)) if len(angles) else 0.0
    if missed <= CLOSE:
        return []
    what = f"carried by the gyros, gravity misses where the accelerometers find it by {np.degrees(missed):.2g} deg"
    do = "Check that each gyro works and is the one that its name says, and that no time is cut out between positions"
    return [Remark("rotations_do_not_close", "error", what, do=do)]


def _unobserved(what: str, observed: Observability, sensors: str) -> Remark:
    combinations = "; ".join(observed.combinations)
    said = (
        f"the {what} determine {observed.rank} of {observed.count} {sensors} parameters; not determined: {combinations}"
    )
    return Remark("not_observable", "warning", said, do="Add orientations between the faces, about all axes")
