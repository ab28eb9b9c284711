"""What a record of a turned mass is taken for by its noun: pulses as of a moved mass, and the programme."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ...core.errors import UsageError
from ..given import Described, GivenFile
from ..mass_attraction import given as moved
from ..protocol import InputSpec


def described(given: GivenFile, spec: InputSpec) -> Described:
    """Return the channels of a record, with its programme.

    Raises
    ------
    UsageError
        If mass, radius, orbit, programme or gate is missing, or it is not clear which column holds the pulses.
    """
    if given.said.chain is None and (given.said.lsb is not None or given.said.reference):
        what = "turned_mass needs pulses, counted over a gate: lsb and reference are of readings in volts"
        raise UsageError(what, given.name, do="Leave it out, and give the pulses", code="option_without_effect")
    for name, example in (("mass", "4 kg"), ("radius", "0.2 m")):
        if given.plan.get(name) is None:
            do = f"Add: {given.add(name, example)}"
            raise UsageError(
                f"{name} of the turned mass missing", given.name, "its attraction follows from it", do, "missing"
            )
    if (given.plan.get("altitude") is None) == (given.plan.get("orbit_period") is None):
        both = "both are given" if given.plan.get("altitude") is not None else "neither is given"
        do = f"Give one: {given.add('altitude', '560 km')}, or {given.add('orbit_period', '5740 s')}"
        raise UsageError(
            f"altitude and orbit period: {both}", given.name, "the recoil depends on the orbit", do, "missing"
        )
    found = moved.described(given, spec)
    return replace(found, entry=_turned(found.entry))


def like(given: GivenFile, entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return the entry of another campaign, with programme, start and stamps of this file; errors as a moved mass."""
    return _turned(moved.like(given, entry))


def _turned(entry: Mapping[str, Any]) -> dict[str, Any]:
    """Return an entry whose mass turns."""
    found = {name: one for name, one in entry.items() if name != "mass"}
    own = {name: one for name, one in entry.get("mass", {}).items() if name in ("schedule", "begin")}
    if own:
        found["turned"] = {**found.get("turned", {}), **own}
    return found
