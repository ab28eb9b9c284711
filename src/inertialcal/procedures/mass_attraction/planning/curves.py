"""Curves of a plan of a source mass: body, field along the travel, cube against point, growth, forecast."""

from __future__ import annotations

import numpy as np

from ....core.curve import Column, Curve
from ....core.estimate import Array
from ....physics.attraction.bodies import Prism
from ....physics.mass_shape.growth import growth
from .body import MassBody
from .drive import POINTS, MassDrive, MassForecast
from .rows import CM, HOUR
from .settings import Constants

RATIOS = np.geomspace(0.8, 20.0, 61)  # distance over edge
SPANS = np.concatenate([np.geomspace(1e-3, 1.0, 46), np.geomspace(1.0, 10.0, 16)[1:]])  # mass over that of the body
OWN = 45  # which of them is one
WAYS = {"face": (1.0, 0.0, 0.0), "edge": (1.0, 1.0, 0.0), "corner": (1.0, 1.0, 1.0)}


def body_curve(body: MassBody) -> Curve:
    """Return the cells that can be seen from outside, by their centres."""
    filled = np.pad(body.body.density > 0.0, 1)
    hidden = np.ones(body.body.density.shape, dtype=bool)
    inner = (slice(1, -1),) * 3
    for axis in range(3):
        for step in (1, -1):
            hidden &= np.roll(filled, step, axis)[inner]
    at = np.nonzero(filled[inner] & ~hidden)
    edge = body.grid.edge
    places = [CM * (low + (index + 0.5) * edge) for low, index in zip(body.body.lower, at, strict=True)]
    columns = {name: Column(np.round(place, 9), "cm") for name, place in zip("xyz", places, strict=True)}
    return Curve("mass_body", "", columns | {"edge": Column(np.full(len(at[0]), CM * edge), "cm")})


def field_curves(found: MassDrive, constants: Constants) -> list[Curve]:
    """Return the field along the travel, and the dwells of a cycle upon it."""
    positions = np.linspace(found.travel.first, found.travel.last, POINTS)
    return [
        Curve("mass_field", "", _field(positions, found.travel.at(positions), constants)),
        Curve("mass_drive", "", _field(found.drive.positions, found.drive.fields, constants), found.drive.kind.lower()),
    ]


def _field(positions: Array, fields: Array, constants: Constants) -> dict[str, Column]:
    return {"position": Column(CM * positions, "cm"), "attraction": Column(fields / constants.ng, "ng")}


def cube_curve() -> Curve:
    """Return by how much a cube attracts more than a point of its mass in its middle, toward face, edge and corner."""
    cube = Prism((-0.5,) * 3, (0.5,) * 3, 1.0)
    columns = {"ratio": Column(RATIOS)}
    for name, way in WAYS.items():
        along = np.array(way) / np.linalg.norm(way)
        points = np.ascontiguousarray(-RATIOS[:, None] * along)
        error = cube.field(points) @ along * RATIOS**2 - 1.0
        outside = RATIOS * np.abs(along).max() > 0.5
        columns[name] = Column(np.where(outside, 100.0 * error, np.nan), "%")
    return Curve("cube_as_point", "", columns)


def growth_curve(body: MassBody, constants: Constants) -> Curve:
    """Return the attraction of the touching sphere and of the best body against mass."""
    masses = body.mass * SPANS
    found = growth(masses, body.grid.density, body.grid.stand_off)
    scale = constants.gravitational_constant / constants.ng
    own = np.full(len(SPANS), np.nan)
    own[OWN] = scale * body.field
    columns = {
        "mass": Column(masses, "kg"), "sphere": Column(scale * found.sphere, "ng"),
        "best": Column(scale * found.best, "ng"), "body": Column(own, "ng"),
    }  # fmt: skip
    return Curve("mass_growth", "", columns)


def forecast_curve(found: MassForecast, u_applied: float) -> list[Curve]:
    """Return the uncertainty of the scale factor against time, a curve a drive."""
    return [
        Curve(
            "mass_forecast", "",
            {
                "time": Column(one.time / HOUR, "h"), "u": Column(100.0 * one.u, "%"),
                "u_applied": Column(np.full(len(one.time), 100.0 * u_applied), "%"),
            },
            name,
        )
        for name, one in found.drives.items()
    ]  # fmt: skip
