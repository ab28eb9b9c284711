"""Standards of a campaign: what is stated of each, and which ones apply to its tests and are not stated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..core.influence import Influence
from ..core.results import finite
from ..core.standards import STANDARDS
from ..procedures.flip import reduction as flip
from ..procedures.positions import reduction as positions
from ..procedures.positions.of_sensor import OfSensor
from ..procedures.positions.rows import missing
from ..procedures.rate_table import reduction as rate_table
from ..procedures.rate_table.rows import applies
from ..procedures.static_noise import reduction as static_noise
from ..procedures.thermal import reduction as thermal
from .load import Campaign
from .requirements import Tested

LATITUDE = "site.latitude"
EFFECTS = rate_table.INFLUENCES | {LATITUDE: "earth rate along the axis of the table"}
EVERY = positions.INFLUENCES | thermal.INFLUENCES | static_noise.INFLUENCES | EFFECTS | flip.INFLUENCES


def standards_rows(campaign: Campaign, tested: Sequence[Tested]) -> list[dict[str, Any]]:
    """Return all influences that are stated, as stated, and those that are not and would change the result of a test.

    Parameters
    ----------
    campaign : Campaign
        As read.
    tested : sequence of Tested
        Every test.
    """
    names = [f"{standard}.{influence}" for standard, inner in STANDARDS.items() for influence in inner]
    stated = [(name, campaign.standards.get(name)) for name in names]
    return [
        _row(name, one, _effect(name, tested))
        for name, one in stated
        if one is not None or any(_needs(name, t) for t in tested)
    ]


def _effect(name: str, tested: Sequence[Tested]) -> str:
    """Say what an influence changes in the tests that were run; of none of them, what it changes at all."""
    effects = {
        rate_table.Result: EFFECTS,
        flip.Result: flip.INFLUENCES,
        thermal.Result: thermal.INFLUENCES | {LATITUDE: "earth rate along the axes"},
        static_noise.Result: static_noise.INFLUENCES,
        OfSensor: positions.INFLUENCES,
    }
    found = [effects[type(one.result)].get(name, "") for one in tested if type(one.result) in effects]
    return "; ".join(dict.fromkeys(effect for effect in found if effect)) or EVERY.get(name, "")


def _needs(name: str, one: Tested) -> bool:
    result = one.result
    if isinstance(result, flip.Result | static_noise.Result):
        return name in (flip if isinstance(result, flip.Result) else static_noise).INFLUENCES
    if isinstance(result, thermal.Result):
        known = result.plan.attitude is not None and result.plan.latitude is not None
        return (name in thermal.needed(result.plan)) or (name == LATITUDE and known)
    if isinstance(result, OfSensor):
        return name in missing(result.whole)
    if not isinstance(result, rate_table.Result):
        return False
    if name == LATITUDE:
        return _earth_rate_is_known(result.plan)
    return name in rate_table.INFLUENCES and applies(name, result.plan, result.readings)


def _earth_rate_is_known(plan: rate_table.Plan) -> bool:
    """Whether earth rate along the table axis is taken from the latitude; with a zero reference it drops out."""
    return plan.attitude is not None and plan.latitude is not None and not plan.zero_reference


def _row(name: str, influence: Influence | None, effect: str) -> dict[str, Any]:
    standard, _, quantity = name.partition(".")
    head = {"standard": standard, "influence": quantity, "effect": effect}
    if influence is None:
        return head | {
            "u": None, "unit": "", "dof": None, "distribution": "", "certificate": "", "stated": False,
        }  # fmt: skip
    u, unit = influence.stated
    return head | {
        "u": u, "unit": unit, "dof": finite(influence.dof),
        "distribution": influence.distribution, "certificate": influence.certificate, "stated": True,
    }  # fmt: skip
