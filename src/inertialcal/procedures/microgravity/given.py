"""The campaign entry of a record of the environment: its axes, the requirement curve, what was asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from ..given import Described, GivenFile
from ..given import described as described_channels
from ..protocol import InputSpec
from .plan import MAGNITUDE, PERPENDICULAR, RATIO

ASKED = (("slow_limit", MAGNITUDE), ("perpendicular_limit", PERPENDICULAR))


def described(given: GivenFile, spec: InputSpec) -> Described:
    """Return the accelerometer of a file, with the curve and the limits as requirements."""
    found = described_channels(given, spec)
    curve = given.own.get("curve")
    entry: dict[str, Any] = {} if not curve else {"curve": str(curve)}
    asked = [] if not curve else [{"id": "curve", "quantity": RATIO, "limit": "1"}]
    asked += [{"id": name, "quantity": quantity, "limit": str(given.own[name])}
              for name, quantity in ASKED if given.own.get(name) is not None]  # fmt: skip
    first: Sequence[dict[str, Any]] = asked if given.number == 1 else ()
    return replace(found, entry=found.entry | entry, requirements=list(first))
