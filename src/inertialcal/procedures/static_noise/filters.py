"""Settings of navigation filters from the noise of a call's sensors.

Where the record cannot separate the terms of long averaging times (flicker or a random walk), the block says so, and
takes those that drive the bias most, or those that ``take`` names. Their white noise is that of the table, whichever is
taken. Where no random walk was found, the block gives its upper limit as a comment; ``take`` writes it as the value.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ...core.constants import STANDARD_GRAVITY
from ...core.errors import DataError, UsageError
from ...sensors.noise.terms import Term
from ...sensors.noise.to_filters import FilterBlock, to_gtsam, to_kalibr, to_kf_gins, to_px4

if TYPE_CHECKING:
    from ..protocol import Reduced

TARGETS = ("kalibr", "px4", "gtsam", "kf-gins")
THREE = 3  # axes, or one for all


def filter_block(found: Reduced, target: str, horizon: float | None = None, take: Sequence[str] = ()) -> FilterBlock:
    """Return the settings of a filter, from what ``allan`` found.

    Parameters
    ----------
    found : Reduced
        Of ``inertialcal.allan``.
    target : {"kalibr", "px4", "gtsam", "kf-gins"}
        Which filter.
    horizon : float, optional
        Averaging time at which a walk stands in for all that wanders, bias instability above all [s].
    take : sequence of str
        Terms that are taken where the record cannot separate them from others; ``"upper_limit"``: that of the random
        walk of the bias, where it was not found.

    Raises
    ------
    UsageError
        If there is no such filter.
    DataError
        ``no_unit`` if no sensor is known by its unit, ``wrong_axes`` if a sensor has two axes.
    """
    if target not in TARGETS:
        raise UsageError(f"no filter {target!r}", do=f"There are: {', '.join(TARGETS)}", code="unknown_name")
    by_kind = {
        one.facts.kind: [axis.for_filters(one.facts.kind, horizon, take) for axis in one.result.axes]
        for one in found.tested
        if one.facts.kind
    }
    if not by_kind:
        what = f"no sensor with a known unit: {target} needs rad/s and m/s^2"
        raise DataError(what, do="Give the unit: --unit gyro=UNIT --unit acc=UNIT", code="no_unit")
    said = [line for axes in by_kind.values() for _, lines in axes for line in lines]
    gyro, accelerometer = (
        _axes([terms for terms, _ in by_kind.get(kind, ())], kind) for kind in ("gyro", "accelerometer")
    )
    block = _block(found, target, gyro, accelerometer, horizon)
    return replace(block, text="".join(f"# {line}\n" for line in said) + block.text)


def _block(
    found: Reduced, target: str, gyro: list[tuple[Term, ...]], accelerometer: list[tuple[Term, ...]],
    horizon: float | None,
) -> FilterBlock:  # fmt: skip
    first = found.tested[0]
    if target == "kalibr":
        return to_kalibr(gyro, accelerometer, 1.0 / first.readings.records[0].interval, horizon=horizon)
    if target == "px4":
        return to_px4(gyro, accelerometer, horizon=horizon)
    if target == "gtsam":
        return to_gtsam(gyro, accelerometer, first.facts.gravity or STANDARD_GRAVITY.value, horizon=horizon)
    return to_kf_gins(gyro, accelerometer, horizon=horizon)


def _axes(terms: Sequence[Sequence[Term]], kind: str) -> list[tuple[Term, ...]]:
    """Return one or three axes; one without terms where there is none."""
    found = [tuple(axis) for axis in terms]
    if len(found) not in (0, 1, THREE):
        what = f"{len(found)} axes of the {kind}: a filter takes three, or one for all"
        raise DataError(what, do="Name one or three channels: --column COLUMN", code="wrong_axes")
    return found or [()]
