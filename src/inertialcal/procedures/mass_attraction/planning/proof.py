"""Effect of a proof mass that is not a point: a cylinder along the input axis, and the mean field over it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....core.curve import Column, Curve
from ....core.key import Key, told_for
from ....core.results import Row
from ....physics.attraction.bodies import Lattice
from ....physics.attraction.extended import ProofMass, mean_field
from ....physics.motion.travel import Travel

TEST = "mass_attraction"
CM = 100.0
NODES = 33  # positions of the travel between which the effect of a proof mass is interpolated
LENGTHS = np.linspace(0.2, 2.0, 10)  # of the curve, over the pointlike length
STEP = 1e-3  # of the distance, for the slope of a gradient
Direction = tuple[float, float, float]


def reach(proof_mass: ProofMass | None) -> float:
    """Return the largest distance from its centre [m]."""
    return 0.0 if proof_mass is None else float(np.hypot(proof_mass.length / 2.0, proof_mass.radius))


def acting(travel: Travel, body: Lattice, way: Direction, proof_mass: ProofMass | None, big_g: float) -> Travel:
    """Return the travel with the field averaged over the proof mass: its effect is interpolated (Chebyshev)."""
    if proof_mass is None:
        return travel
    middle, half = (travel.first + travel.last) / 2.0, (travel.last - travel.first) / 2.0
    nodes = np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
    positions = middle + half * nodes
    shifted = np.ascontiguousarray(-positions[:, None] * np.array(way))
    effect = big_g * mean_field(body, proof_mass, shifted)[:, 0] - travel.at(positions)
    shape = np.polynomial.Chebyshev.fit(nodes, effect, NODES - 1, domain=[-1.0, 1.0])  # through each
    return replace(travel, field=lambda at: travel.field(at) + shape((at - middle) / half))


def effects(body: Lattice, way: Direction, ends: tuple[float, float], proof_mass: ProofMass) -> tuple[float, float]:
    """Return the relative effect on the amplitude between two ends: summed, and by the second-order rule."""
    shifts = np.ascontiguousarray(-np.outer(ends, way))
    point = float(np.diff(body.field(shifts)[:, 0])[0])
    summed = float(np.diff(mean_field(body, proof_mass, shifts)[:, 0])[0])
    near = STEP * float(np.min(np.abs(body.lower[0] - shifts[:, 0])))
    step = np.array([near, 0.0, 0.0])
    slopes = [body.gradient(np.ascontiguousarray(shifts + sign * step))[:, 0, 0] for sign in (1.0, -1.0)]
    curvature = float(np.diff(slopes[0] - slopes[1])[0]) / (
        2.0 * near
    )  # of the field, its difference between both ends
    return summed / point - 1.0, curvature * proof_mass.second_order / 2.0 / point


def proof_rows(body: Lattice, way: Direction, ends: tuple[float, float], proof_mass: ProofMass) -> list[Row]:
    """Return the effect of the proof mass on the amplitude, and the length at which it acts as a point."""
    summed, rule = effects(body, way, ends, proof_mass)
    figures = (
        ("proof_mass_effect", 100.0 * summed, "%", "on the amplitude, summed"),
        ("proof_mass_effect", 100.0 * rule, "%", "on the amplitude, second order"),
        ("pointlike_length", CM * proof_mass.pointlike_length, "cm", "of a proof mass of these radii"),
    )
    return [Row(Key(name), value, None, unit, test=TEST, member=told_for(at)) for name, value, unit, at in figures]


def proof_curve(body: Lattice, way: Direction, ends: tuple[float, float], proof_mass: ProofMass) -> Curve:
    """Return the effect on the amplitude against the length, at these radii; `own` is the length given."""
    lengths = np.unique([*LENGTHS * proof_mass.pointlike_length, proof_mass.length])
    found = np.array([effects(body, way, ends, replace(proof_mass, length=float(one))) for one in lengths])
    own = np.where(lengths == proof_mass.length, 100.0 * found[:, 0], np.nan)
    columns = {
        "length": Column(CM * lengths, "cm"), "effect": Column(100.0 * found[:, 0], "%"),
        "second_order": Column(100.0 * found[:, 1], "%"), "own": Column(own, "%"),
    }  # fmt: skip
    return Curve("proof_mass", "", columns)
