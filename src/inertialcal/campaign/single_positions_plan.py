"""Positions planned before a test: what ``plan positions`` does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..core.errors import InertialcalError, UsageError
from ..core.estimate import Array
from ..core.frames import frame
from ..core.tables import Grid, Part, html, text
from ..core.units import parse_quantity
from ..procedures.positions.planning import (
    DETERMINANT,
    MOST,
    Prediction,
    Setup,
    course,
    cube,
    next_position,
    parameter_names,
    predict_uncertainty,
)

AXES = ("x", "y", "z")
SETS: Mapping[str, slice] = {
    "none": slice(0, 0),
    "faces": slice(0, 6),
    "faces+edges": slice(0, 18),
    "cube": slice(0, 26),
}
EDGE = 0.3  # component of a direction, below which its axis is level


@dataclass(frozen=True, eq=False)
class PositionsPlan:
    """Positions to take, and the uncertainty that they would give.

    Parameters
    ----------
    taken : int
        Positions there already.
    directions : ndarray, shape (n, 3)
        All positions, those there already first: what points up, in body axes.
    prediction : Prediction
        Of all of them.
    """

    taken: int
    directions: Array
    prediction: Prediction

    def steps(self) -> list[dict[str, Any]]:
        """Return the positions to take, in order: number, words, direction."""
        new = self.directions[self.taken :]
        return [
            {"number": self.taken + k + 1, "up": in_words(one), "direction": [float(x) for x in one]}
            for k, one in enumerate(new)
        ]

    def rows(self) -> list[dict[str, Any]]:
        """Return the parameters with the standard uncertainty to expect; null where they are not told."""
        found = self.prediction
        return [
            {"parameter": name, "u": float(u) if np.isfinite(u) else None, "unit": unit}
            for name, unit, u in zip(found.names, found.units, found.u, strict=True)
        ]

    def to_frame(self) -> Any:
        """Return a pandas DataFrame, a row a parameter."""
        rows = self.rows()
        return frame({name: [row[name] for row in rows] for name in rows[0]})

    def parts(self) -> tuple[Part, ...]:
        """Return what is shown: the positions, the uncertainty to expect, what they do not tell."""
        found = self.prediction
        steps = tuple((str(one["number"]), str(one["up"])) for one in self.steps())
        rows = tuple(
            (str(row["parameter"]), "not told" if row["u"] is None else f"{row['u']:.2g}", str(row["unit"]))
            for row in self.rows()
        )
        told = f"{found.rank} of {found.count} combinations are told"
        untold = tuple(f"not told: {words}" for words in found.untold)
        head = (Grid(("position", "up"), steps, "positions to take"),) if steps else ()
        return (
            *head,
            Grid(("parameter", "u", "unit"), rows, f"after {len(self.directions)} positions; {told}"),
            *untold,
        )

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def positions_plan(
    scatter: str,
    target: Mapping[str, str] | None = None,
    have: str = "none",
    known: bool = False,
    pose: str = "0 deg",
    gravity: str = "9.80665 m/s2",
    gravity_u: str = "0 m/s2",
    following: int = 0,
    goal: str = DETERMINANT,
    most: int = MOST,
) -> PositionsPlan:
    """Plan positions of an accelerometer triad.

    Parameters
    ----------
    scatter : str
        Of the mean reading of one position: ``"0.1 mg"``.
    target : mapping of str to str, optional
        Parameter or quantity -> standard uncertainty wanted: ``{"scale_factor_error": "100 ppm"}``. Positions are
        added until it is met.
    have : {"none", "faces", "faces+edges", "cube"}
        Positions there already.
    known : bool
        Whether the direction of each position is known.
    pose, gravity, gravity_u : str
        Uncertainty of a known direction, local gravity, and its uncertainty.
    following : int
        Without a target: how many positions to add, the best one each time.
    goal : str
        What they are best for: ``"determinant"``, ``"trace"`` or a parameter.
    most : int
        Positions in all.

    Raises
    ------
    UsageError
        ``unknown_name``, ``wrong_value``, ``unit_mismatch``; if there is neither a target nor a position.
    PlanError
        ``target_not_reached``, ``unknown_parameter``, ``bad_argument``.
    """
    if have not in SETS:
        raise UsageError(f"positions {have!r}", do=f"There are: {', '.join(SETS)}", code="unknown_name")
    numbers = {"scatter": (scatter, "m/s^2"), "pose": (pose, "rad"), "gravity": (gravity, "m/s^2")}
    numbers |= {"gravity_u": (gravity_u, "m/s^2")}
    setup = Setup(known=known, **{name: _number(name, *said) for name, said in numbers.items()})
    taken = cube()[SETS[have]]
    if target:
        limits = _limits(setup, target)
        found = course(setup, limits, taken, most=most)
        return PositionsPlan(len(taken), found.directions, found.prediction)
    directions: Sequence[Array] = list(taken)
    for _ in range(following):
        directions = [*directions, next_position(setup, np.array(directions).reshape(-1, 3), goal=goal)]
    if not directions:
        raise UsageError("nothing to plan", do="Say --target, --next, or --have", code="wrong_value")
    return PositionsPlan(len(taken), np.array(directions), predict_uncertainty(setup, np.array(directions)))


def _limits(setup: Setup, target: Mapping[str, str]) -> dict[str, float]:
    units = dict(zip(*parameter_names(setup.known), strict=True))
    units |= {name.rsplit("_", 1)[0]: unit for name, unit in units.items()}
    return {name: _number(name, said, units.get(name, "1")) for name, said in target.items()}


def _number(name: str, said: str, unit: str) -> float:
    try:
        return parse_quantity(said).to(unit)
    except InertialcalError as error:
        raise UsageError(
            f"{name} {said!r}: {error.problems[0].what}", do=f"A number in {unit}", code="unit_mismatch"
        ) from None


def in_words(direction: Array) -> str:
    """Return a direction in words: ``x up``, ``between x up and y down``."""
    axes = [
        f"{axis} {'up' if part > 0.0 else 'down'}"
        for axis, part in zip(AXES, direction, strict=True)
        if abs(part) > EDGE
    ]
    return axes[0] if len(axes) == 1 else f"between {' and '.join(axes)}"
