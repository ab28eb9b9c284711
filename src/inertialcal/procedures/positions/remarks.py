"""What is to be said of a result of positions: what they do not tell, which disagree, what is not stated."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...core.remarks import Remark
from .fit.levels import HIDDEN as JUDGED_BY_NOTHING
from .plan import INFLUENCES
from .rows import missing

if TYPE_CHECKING:
    from .reduction import Result

HIDDEN = 0.5  # share of a variance that nothing shows, from which on it is told
ALONE = 0.8  # leverage of a position on which some combination rests


def remarks_of(result: Result) -> list[Remark]:
    """Return the remarks, the gravest first."""
    return [
        *_not_told(result),
        *_not_judged(result),
        *_outliers(result),
        *_of_gyros(result),
        *_alone(result),
        *_standards(result),
    ]


def _not_told(result: Result) -> list[Remark]:
    found = []
    seen = result.acc.seen
    if not seen.whole:
        found.append(_unobserved("the positions", seen.rank, seen.count, seen.combinations, "accelerometers"))
    if result.acc.free == 0:
        m, p = len(result.readings), seen.rank
        what = f"{m} positions for {p} unknowns: nothing is left to judge the accelerometers by"
        found.append(Remark("no_dof", "warning", what, do="Lay the unit into more orientations"))
    return found


def _unobserved(who: str, rank: int, count: int, combinations: tuple[str, ...], of: str) -> Remark:
    text = "; ".join(combinations)
    what = f"{who} tell {rank} of {count} numbers of the {of}; they do not tell: {text}"
    return Remark("not_observable", "warning", what, do="Add orientations between the faces, about all axes")


def _not_judged(result: Result) -> list[Remark]:
    """Say which numbers rest on one reading at each place that decides them, so that most of their u is a bound."""
    found = []
    for kind, one in result.estimates.items():
        unseen = sum(
            (np.diag(part.covariance) for part in one.components if part.origin.level == JUDGED_BY_NOTHING),
            np.zeros(len(one.names)),
        )
        names = [name for name, part, u in zip(one.names, unseen, one.u, strict=True) if part > HIDDEN * u**2]
        if names:
            what = f"nothing shows how the {kind} repeats in {', '.join(names)}: they carry as much as may be hidden"
            found.append(Remark("scatter_not_judged", "warning", what, do="Lay each face, make each turn, twice"))
    return found


def _outliers(result: Result) -> list[Remark]:
    found = []
    for k in np.flatnonzero(result.acc.outliers):
        what = "this position does not agree with the others and is left out of the accelerometers"
        found.append(Remark("outlier_position", "warning", what, result.readings.place(int(k)), do="Check it"))
    gyro = result.gyro
    if gyro is None:
        return found
    for k in np.flatnonzero(gyro.rest.outliers):
        what = "the gyros read another bias here than in the other positions: it is left out of bias and g-sensitivity"
        found.append(
            Remark("outlier_at_rest", "warning", what, result.readings.place(int(k)), do="Was the unit moved?")
        )
    if gyro.rotated is not None:
        rotations = (*result.readings.transitions, *result.readings.turns)
        for k in np.flatnonzero(gyro.rotated.outliers):
            what = "this rotation does not agree with the others and is left out"
            found.append(Remark("outlier_rotation", "warning", what, rotations[k].where, do="Check it"))
    return found


def _of_gyros(result: Result) -> list[Remark]:
    gyro = result.gyro
    if gyro is None:
        return []
    found = []
    if gyro.rotated is not None:
        seen = gyro.rotated.seen
        if not seen.whole:
            found.append(_unobserved("the rotations", seen.rank, seen.count, seen.combinations, "gyros"))
        elif np.all(np.diag(gyro.rotated.W) < 0.0):
            what = "all gyros read the known turns in the other sense: their scale factors come out negative"
            found.append(
                Remark("turn_sense", "warning", what, do="Turn the sign of the angles, if the turns were clockwise")
            )
        fit = gyro.rotated.found
        if fit is not None and fit.free == 0:
            what = "no rotation was repeated: the scatter between rotations is not in the uncertainty"
            found.append(Remark("not_repeated", "warning", what, do="Repeat each turn, and turn it back"))
    if gyro.rest.g_sensitivity is None and result.plan.g_sensitivity is not False:
        found.append(Remark("no_g_sensitivity", "info", f"g-sensitivity of the gyros: {gyro.rest.reason}"))
    return found


def _alone(result: Result) -> list[Remark]:
    """Say where one position decides: nothing else would show that it is wrong."""
    acc = result.acc
    if acc.free == 0 or acc.known:
        return []
    with np.errstate(divide="ignore", invalid="ignore"):
        share = 1.0 - acc.residuals[:, 0] / acc.deletion[:, 0]
    at = np.flatnonzero(~acc.outliers & (share > ALONE))
    if not len(at):
        return []
    worst = int(at[np.argmax(share[at])])
    what = f"some number of the accelerometers rests on this position alone by {100.0 * share[worst]:.0f} %"
    return [Remark("position_alone", "info", what, result.readings.place(worst), len(at), "Lay another near it")]


def _standards(result: Result) -> list[Remark]:
    found = []
    names = missing(result)
    if names:
        effects = "; ".join(f"{name} ({INFLUENCES[name]})" for name in names)
        what = f"standards without a stated uncertainty: {effects}: results are relative to the fixture"
        found.append(Remark("relative_to_fixture", "warning", what, do="State them under [standards]"))
    if result.plan.gravity is None and result.plan.latitude is None:
        what = "neither gravity nor the place is given: standard gravity is taken, up to 0.3 % from the local one"
        found.append(Remark("gravity_assumed", "warning", what, do="Give gravity, or site.latitude"))
    return found
