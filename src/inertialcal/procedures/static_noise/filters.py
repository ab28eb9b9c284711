"""Settings of navigation filters from the noise of a call's sensors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...core.constants import STANDARD_GRAVITY
from ...core.errors import DataError, UsageError
from ...sensors.noise.terms import Sinusoid, Term
from ...sensors.noise.to_filters import FilterBlock, to_gtsam, to_kalibr, to_kf_gins, to_px4

if TYPE_CHECKING:
    from ..protocol import Reduced

TARGETS = ("kalibr", "px4", "gtsam", "kf-gins")
THREE = 3  # axes, or one for all


def filter_block(found: Reduced, target: str, horizon: float | None = None) -> FilterBlock:
    """Return the settings of a filter, from what ``allan`` found.

    Parameters
    ----------
    found : Reduced
        Of ``inertialcal.allan``.
    target : {"kalibr", "px4", "gtsam", "kf-gins"}
        Which filter.
    horizon : float, optional
        Averaging time at which a walk stands in for all that wanders, bias instability above all [s].

    Raises
    ------
    UsageError
        If there is no such filter.
    DataError
        ``no_unit`` if no sensor is known by its unit, ``wrong_axes`` if a sensor has two axes.
    """
    if target not in TARGETS:
        raise UsageError(f"no filter {target!r}", do=f"There are: {', '.join(TARGETS)}", code="unknown_name")
    by_kind = {one.facts.kind: [axis.terms for axis in one.result.axes] for one in found.tested if one.facts.kind}
    if not by_kind:
        what = f"no sensor with a known unit: {target} needs rad/s and m/s^2"
        raise DataError(what, do="Give the unit: --unit gyro=deg/s --unit acc=g", code="no_unit")
    gyro, accelerometer = (_axes(by_kind.get(kind, ()), kind) for kind in ("gyro", "accelerometer"))
    first = found.tested[0]
    if target == "kalibr":
        return to_kalibr(gyro, accelerometer, 1.0 / first.readings.records[0].interval, horizon=horizon)
    if target == "px4":
        return to_px4(gyro, accelerometer, horizon=horizon)
    if target == "gtsam":
        return to_gtsam(gyro, accelerometer, first.facts.gravity or STANDARD_GRAVITY.value, horizon=horizon)
    return to_kf_gins(gyro, accelerometer, horizon=horizon)


def _axes(terms: Sequence[Sequence[Term]], kind: str) -> list[tuple[Term, ...]]:
    """Return one or three axes without lines, which filters do not hold; one without terms where there is none."""
    found: list[tuple[Term, ...]] = [tuple(term for term in axis if not isinstance(term, Sinusoid)) for axis in terms]
    if len(found) not in (0, 1, THREE):
        what = f"{len(found)} axes of the {kind}: a filter takes three, or one for all"
        raise DataError(what, do="Name one or three channels: --column COLUMN", code="wrong_axes")
    return found or [()]
