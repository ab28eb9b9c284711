"""A proof mass that is no point: a cylinder along the input axis, and what it changes of field and amplitude."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from ....core.curve import Column, Curve
from ....core.errors import UsageError
from ....core.estimate import Array
from ....core.key import Key, told_for
from ....core.results import Row
from ....physics.attraction import Lattice, ProofMass, mean_field
from ....physics.motion import Travel
from .settings import positive

TEST = "mass_attraction"
CM = 100.0
NODES = 33  # positions of the travel between which the effect of a proof mass is interpolated
LENGTHS = np.linspace(0.2, 2.0, 10)  # over the one that acts as a point, of the curve
LIKE = "length 2.915 cm, inner radius 1.268 cm, radius 1.37 cm"
PART = re.compile(r"\s*(length|inner radius|radius)\s+(\S.*?)\s*", re.ASCII)
STEP = 1e-3  # of the distance, of the slope of a gradient
Direction = tuple[float, float, float]


def proof_mass_of(text: str) -> ProofMass:
    """Return the cylinder that a text describes, along the input axis.

    Parameters
    ----------
    text : str
        ``"length 2.915 cm, inner radius 1.268 cm, radius 1.37 cm"``; solid without an inner radius.

    Raises
    ------
    UsageError
        If a word is none, comes twice or is missing, or a length has no unit.
    DataError
        If there is no such cylinder.
    """
    found: dict[str, float] = {}
    for part in text.split(","):
        match = PART.fullmatch(part)
        if match is None or match[1] in found:
            raise UsageError(f"proof_mass: {text!r}", do=f'Write it like "{LIKE}"', code="wrong_value")
        found[match[1]] = positive(match[2], "m", f"proof_mass: {match[1]}", "1.37 cm")
    if not {"length", "radius"} <= found.keys():
        why = "length and radius are needed"
        raise UsageError(f"proof_mass: {text!r}", why=why, do=f'Write it like "{LIKE}"', code="missing")
    return ProofMass(found["length"], found["radius"], found.get("inner radius", 0.0))


def reach(proof_mass: ProofMass | None) -> float:
    """Return how far it reaches from its centre [m]."""
    return 0.0 if proof_mass is None else float(np.hypot(proof_mass.length / 2.0, proof_mass.radius))


def acting(travel: Travel, body: Lattice, way: Direction, proof_mass: ProofMass | None, big_g: float) -> Travel:
    """Return the travel with the field averaged over the proof mass.

    The difference from the field at its centre is found at Chebyshev's positions, and interpolated.
    """
    if proof_mass is None:
        return travel

    def effect(positions: Array) -> Array:
        shifted = np.ascontiguousarray(-positions[:, None] * np.array(way))
        return big_g * mean_field(body, proof_mass, shifted)[:, 0] - travel.at(positions)

    middle, half = (travel.first + travel.last) / 2.0, (travel.last - travel.first) / 2.0
    nodes = np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
    shape = np.polynomial.Chebyshev.fit(
        nodes, effect(middle + half * nodes), NODES - 1, domain=[-1.0, 1.0]
    )  # through each
    return replace(travel, field=lambda at: travel.field(at) + shape((at - middle) / half))


def effects(body: Lattice, way: Direction, ends: tuple[float, float], proof_mass: ProofMass) -> tuple[float, float]:
    """Return by how much the amplitude between two ends differs from that of a point: summed, and by the rule [1]."""
    shifts = np.ascontiguousarray(-np.outer(ends, way))
    point = float(np.diff(body.field(shifts)[:, 0])[0])
    summed = float(np.diff(mean_field(body, proof_mass, shifts)[:, 0])[0])
    return summed / point - 1.0, _curvature(body, shifts) * proof_mass.second_order / 2.0 / point


def _curvature(body: Lattice, shifts: Array) -> float:
    """Difference between both ends of the second derivative of the field along the input axis, along it."""
    near = STEP * float(np.min(np.abs(body.lower[0] - shifts[:, 0])))
    step = np.array([near, 0.0, 0.0])
    slopes = [body.gradient(np.ascontiguousarray(shifts + sign * step))[:, 0, 0] for sign in (1.0, -1.0)]
    return float(np.diff(slopes[0] - slopes[1])[0]) / (2.0 * near)


def proof_rows(body: Lattice, way: Direction, ends: tuple[float, float], proof_mass: ProofMass) -> list[Row]:
    """Return what a point would get wrong, and the length with which the proof mass would be one."""
    summed, rule = effects(body, way, ends, proof_mass)
    told = (
        ("proof_mass_effect", 100.0 * summed, "%", "on the amplitude, summed"),
        ("proof_mass_effect", 100.0 * rule, "%", "on the amplitude, second order"),
        ("pointlike_length", CM * proof_mass.pointlike_length, "cm", "of a proof mass of these radii"),
    )
    return [Row(Key(name), value, None, unit, test=TEST, member=told_for(at)) for name, value, unit, at in told]


def proof_curve(body: Lattice, way: Direction, ends: tuple[float, float], proof_mass: ProofMass) -> Curve:
    """Return the effect on the amplitude against the length, at these radii; `own` at the length that it has."""
    lengths = np.unique([*LENGTHS * proof_mass.pointlike_length, proof_mass.length])
    found = np.array([effects(body, way, ends, replace(proof_mass, length=float(one))) for one in lengths])
    own = np.where(lengths == proof_mass.length, 100.0 * found[:, 0], np.nan)
    columns = {
        "length": Column(CM * lengths, "cm"), "effect": Column(100.0 * found[:, 0], "%"),
        "second_order": Column(100.0 * found[:, 1], "%"), "own": Column(own, "%"),
    }  # fmt: skip
    return Curve("proof_mass", "", columns)
