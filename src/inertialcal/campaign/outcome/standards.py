"""Standards of a campaign: what is stated of each, and which ones apply to its tests and are not stated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...core.influence import Influence, standard_of
from ...core.results import finite
from ...core.schema.standards import STANDARDS
from ...procedures import loaded_procedures
from ..engine.engine import ReducedTest
from ..file.load import Campaign


def standards_rows(campaign: Campaign, tested: Sequence[ReducedTest]) -> list[dict[str, Any]]:
    """Return all influences that are stated, as stated, and those that are not and would change the result of a test.

    Parameters
    ----------
    campaign : Campaign
        As read.
    tested : sequence of ReducedTest
        Every test.
    """
    names = [f"{standard}.{influence}" for standard, inner in STANDARDS.items() for influence in inner]
    stated = [(name, campaign.standards.get(name)) for name in names]
    return [
        _row(name, one, _effect(name, tested))
        for name, one in stated
        if one is not None or any(t.procedure.needs(name, t.result) for t in tested)
    ]


def _effect(name: str, tested: Sequence[ReducedTest]) -> str:
    """Say what an influence changes in the tests that were run; of none of them, what it changes at all."""
    found = [one.procedure.effects().get(name, "") for one in tested]
    every = (one.effects()[name] for one in loaded_procedures() if name in one.effects())
    return "; ".join(dict.fromkeys(effect for effect in found if effect)) or next(every, "")


def _row(name: str, influence: Influence | None, effect: str) -> dict[str, Any]:
    standard, quantity = standard_of(name)
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
