"""Settings of navigation filters from the noise of a file: one word for each filter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ....core.axes import Kind
from ....core.constants import STANDARD_GRAVITY
from ....core.errors import DataError, UsageError
from ....sensors.noise.terms import Sinusoid, Term
from ....sensors.noise.to_filters import FilterBlock, to_gtsam, to_kalibr, to_kf_gins, to_px4

TARGETS = ("kalibr", "px4", "gtsam", "kf-gins")
THREE = 3  # axes, or one for all


def block_for(
    target: str,
    found: Mapping[Kind, Sequence[Sequence[Term]]],
    sample_rate: float,
    gravity: float | None = None,
    horizon: float | None = None,
) -> FilterBlock:
    """Return the settings of a filter.

    Parameters
    ----------
    target : {"kalibr", "px4", "gtsam", "kf-gins"}
        Which.
    found : mapping of kind to sequence of sequences of Term
        Terms of each axis [SI].
    sample_rate : float
        Of the records [Hz].
    gravity : float, optional
        Of the site [m/s^2]; standard gravity if not said.
    horizon : float, optional
        Averaging time at which a walk stands in for all that wanders [s]; see ``to_filters``.

    Raises
    ------
    UsageError
        If there is no such filter.
    DataError
        ``no_unit`` if no sensor is known by its unit, ``wrong_axes`` if a sensor has two axes.
    """
    if target not in TARGETS:
        raise UsageError(f"no filter {target!r}", do=f"There are: {', '.join(TARGETS)}", code="unknown_name")
    if not found:
        what = f"no sensor whose unit is known: {target} wants rad/s and m/s^2"
        raise DataError(what, do="Say it: --unit gyro=deg/s --unit acc=g", code="no_unit")
    gyro, accelerometer = (_axes(found.get(kind, ()), kind) for kind in ("gyro", "accelerometer"))
    if target == "kalibr":
        return to_kalibr(gyro, accelerometer, sample_rate, horizon=horizon)
    if target == "px4":
        return to_px4(gyro, accelerometer, horizon=horizon)
    if target == "gtsam":
        site = STANDARD_GRAVITY.value if gravity is None else gravity
        return to_gtsam(gyro, accelerometer, site, horizon=horizon)
    return to_kf_gins(gyro, accelerometer, horizon=horizon)


def _axes(terms: Sequence[Sequence[Term]], kind: str) -> list[tuple[Term, ...]]:
    """Return one or three axes without lines, which filters do not hold; one without terms where there is none."""
    found: list[tuple[Term, ...]] = [tuple(term for term in axis if not isinstance(term, Sinusoid)) for axis in terms]
    if len(found) not in (0, 1, THREE):
        what = f"{len(found)} axes of the {kind}: a filter takes three, or one for all"
        raise DataError(what, do="Name one or three channels: --column NAME", code="wrong_axes")
    return found or [()]
