"""Positions planned before a test: what ``plan positions`` and ``inertialcal.plan_positions`` do.

Everything that is said is text with a unit. Figures come in the unit that a target was stated in; else bias in that of
the scatter, scale factors in percent, angles in radians.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ....core.axes import AXES
from ....core.errors import DataError, UsageError
from ....core.estimate import Array
from ....core.key import Key, Reason
from ....core.remarks import Remark
from ....core.results import Row, not_estimated
from ....core.show.frames import frame_of_rows
from ....core.show.result_tables import remarks_line
from ....core.show.rounding import number
from ....core.show.tables import Block, Table, html, text
from ....core.units import factor, parse_quantity
from .design import (
    DETERMINANT,
    MOST,
    TRACE,
    Prediction,
    Setup,
    course,
    cube,
    next_position,
    parameter_names,
    parameters,
    predict_uncertainty,
)

if TYPE_CHECKING:
    from pandas import DataFrame


TEST = "positions"
SETS: Mapping[str, slice] = {
    "none": slice(0, 0),
    "faces": slice(0, 6),
    "faces+edges": slice(0, 18),
    "cube": slice(0, 26),
}
LARGEST = 1000  # positions that anybody lays
EDGE = 0.3  # component of a direction, below which its axis is level
ROUGH = 2  # digits of an uncertainty
GRAVITY = "9.80665 m/s2"
LIKE = {"gravity": GRAVITY, "gravity_u": "1 mGal"}
USUAL = {"m/s^2": "0.1 mg", "rad": "0.5 deg", "1": "100 ppm"}
SCATTER = 1e-12, 10.0  # m/s^2, of the best sensors, and of none
GRAVITIES = 9.7, 9.9  # m/s^2, on earth
WANTED = 1e-15, 1e3  # SI
UPSIDE_DOWN = 3.2  # rad


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
        Of all of them, SI.
    rows : tuple of Row
        The uncertainty to expect of each parameter, ``bias_uncertainty`` of ``bias``.
    remarks : tuple of Remark
        What there is to say of it.
    """

    taken: int
    directions: Array
    prediction: Prediction
    rows: tuple[Row, ...]
    remarks: tuple[Remark, ...] = ()

    @property
    def results(self) -> dict[str, Any]:
        """Rows as ``results.json`` has them."""
        return {"results": [row.to_dict() for row in self.rows], "curves": []}

    def steps(self) -> list[dict[str, Any]]:
        """Return the positions to take, in order: number, words, direction."""
        new = self.directions[self.taken :]
        return [
            {"number": self.taken + k + 1, "up": in_words(one), "direction": [float(x) for x in one]}
            for k, one in enumerate(new)
        ]

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a parameter."""
        return frame_of_rows(self.rows)

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: the positions, the uncertainty to expect, what they do not tell, how many remarks."""
        return (*self.tables(), *remarks_line(self.remarks))

    def tables(self) -> tuple[Block, ...]:
        """Return what is shown, without the remarks."""
        found = self.prediction
        steps = tuple((str(one["number"]), str(one["up"])) for one in self.steps())
        head = (Table(("position", "up"), steps, "positions to take"),) if steps else ()
        caption = f"after {len(self.directions)} positions: {found.rank} of {found.count} combinations are told"
        figures = [(row.quantity, row.axis, number(row.value, ROUGH), row.unit) for row in self.rows]
        untold = (f"not told: {', '.join(found.untold)}",) if found.untold else ()
        return (*head, Table(("quantity", "axis", "value", "unit"), figures, caption, (2,)), *untold)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


def plan_positions(
    *,
    scatter: str | None = None,
    target: Mapping[str, str] | None = None,
    have: str = "none",
    known: bool = False,
    pose: str = "0 deg",
    gravity: str = GRAVITY,
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

    Returns
    -------
    PositionsPlan
        Printable; ``.steps()``, ``.rows``, ``.prediction``, ``.remarks``.

    Raises
    ------
    UsageError
        ``missing``, ``unknown_name``, ``wrong_value``, ``no_unit``; if there is neither a target nor a position;
        if options contradict each other.
    PlanError
        ``target_not_reached``, ``unknown_parameter``, ``bad_argument``.
    """
    if scatter is None:
        raise UsageError("--scatter is not given", do='Say it: --scatter "0.1 mg"', code="missing")
    if have not in SETS:
        raise UsageError(f"positions {have!r}", do=f"There are: {', '.join(SETS)}", code="unknown_name")
    setup = _setup(scatter, known, pose, gravity, gravity_u)
    wanted = target or {}
    limits = _limits(setup, wanted)
    taken = cube()[SETS[have]]
    _check(setup, limits, following, goal)
    _check_most(len(taken) + following, most)
    directions = course(setup, limits, taken, most=most).directions if limits else _added(setup, taken, following, goal)
    found = predict_uncertainty(setup, directions)
    return PositionsPlan(len(taken), directions, found, _rows(found, wanted, scatter), _unstated(setup))


def _setup(scatter: str, known: bool, pose: str, gravity: str, gravity_u: str) -> Setup:
    return Setup(
        scatter=_number("scatter", scatter, "m/s^2", *SCATTER),
        known=known,
        pose=_number("pose", pose, "rad", 0.0, UPSIDE_DOWN),
        gravity=_number("gravity", gravity, "m/s^2", *GRAVITIES),
        gravity_u=_number("gravity_u", gravity_u, "m/s^2", 0.0, 1.0),
    )


def _limits(setup: Setup, target: Mapping[str, str]) -> dict[str, float]:
    """Return the uncertainty wanted by parameter or quantity, SI."""
    every = list(zip(*parameters(setup.known), strict=True))
    units = {str(key): unit for key, unit in every} | {key.quantity: unit for key, unit in every}
    _check_names("target", target, units, setup.known)
    return {name: _number(name, said, units[name], *WANTED) for name, said in target.items()}


def _check_names(what: str, given: Iterable[str], names: Iterable[str], known: bool) -> None:
    unknown = next((name for name in given if name not in names), None)
    if unknown is not None:
        do = f"There are: {', '.join(names)}"
        if not known and unknown in parameter_names(known=True):
            do = f"Known directions alone tell it: --known. Without {do[0].lower()}{do[1:]}"
        raise UsageError(f"{what} {unknown!r}: no such parameter", do=do, code="unknown_name")


def _number(name: str, said: str, unit: str, least: float, most: float) -> float:
    """Return a number in a unit, of a size that there is."""
    like = f'Write a number with its unit, like "{LIKE.get(name, USUAL[unit])}"'
    try:
        value = parse_quantity(said).to(unit)
    except DataError as error:
        raise UsageError(f"{name}: {said!r}", why=error.problems[0].what, do=like, code="no_unit") from None
    if not least <= value <= most:
        what = f"{name}: {said!r} is not from {least:g} to {most:g} {unit}"
        raise UsageError(what, do=like, code="wrong_value")
    return value


def _check(setup: Setup, limits: Mapping[str, float], following: int, goal: str) -> None:
    """Refuse what contradicts itself, or would change nothing."""
    if following < 0:
        raise UsageError(f"{following} positions to add", do="Give a number from 1", code="wrong_value")
    if limits and following:
        do = "Give one of them: positions are added until the target is met, or so many"
        raise UsageError("a target, and a number of positions to add", do=do, code="contradiction")
    if goal != DETERMINANT and not following:
        do = "Say how many: --next 3. Positions for a target are those that it needs"
        raise UsageError(f"goal {goal!r}, and no number of positions to add", do=do, code="contradiction")
    if following:
        names = parameter_names(setup.known)
        _check_names("goal", [goal], [DETERMINANT, TRACE, *names], setup.known)
    if setup.pose > 0.0 and not setup.known:
        do = "Say that directions are known, --known, or leave --pose out"
        raise UsageError("--pose of directions that are not known", do=do, code="contradiction")


def _check_most(count: int, most: int) -> None:
    """Refuse numbers that nobody lays."""
    if not 1 <= most <= LARGEST:
        raise UsageError(f"at most {most} positions", do=f"Give a number from 1 to {LARGEST}", code="wrong_value")
    if count > most:
        do = "Add fewer, or allow more with --most"
        raise UsageError(f"{count} positions, and {most} in all", do=do, code="contradiction")


def _added(setup: Setup, taken: Array, following: int, goal: str) -> Array:
    """Return the positions there already and so many more, the best one each time."""
    directions: Sequence[Array] = list(taken)
    for _ in range(following):
        directions = [*directions, next_position(setup, np.array(directions).reshape(-1, 3), goal=goal)]
    if not directions:
        raise UsageError("nothing to plan", do="Say --target, --next, or --have", code="wrong_value")
    return np.array(directions)


def _rows(found: Prediction, target: Mapping[str, str], scatter: str) -> tuple[Row, ...]:
    """Return the uncertainty to expect, or why there is none, in the units that people said."""
    rows = []
    for key, si, u in zip(found.keys, found.units, found.u, strict=True):
        said = target.get(str(key)) or target.get(key.quantity)
        unit = parse_quantity(said).unit if said else _usual(si, scatter)
        named = Key(f"{key.quantity}_uncertainty", key.axis)
        row = Row(named, float(u) * factor(si, unit), None, unit, test=TEST)
        if not np.isfinite(u):
            row = not_estimated(named, unit, Reason("not_told", f"these positions do not tell {_untold(found, key)}"))
        rows.append(row)
    return tuple(rows)


def _usual(si: str, scatter: str) -> str:
    """Return the unit that a figure is shown in where no target says another."""
    return {"1": "%", "m/s^2": parse_quantity(scatter).unit}.get(si, si)


def _untold(found: Prediction, key: Key) -> str:
    """Return the combinations that are not told and that a parameter takes part in."""
    return ", ".join(one for one, parts in zip(found.untold, found.parts, strict=True) if key in parts) or str(key)


def _unstated(setup: Setup) -> tuple[Remark, ...]:
    """Return what was not stated, and is taken as exact."""
    names = [name for name, u in {"--gravity-u": setup.gravity_u, "--pose": setup.pose}.items() if u == 0.0]
    names = [name for name in names if setup.known or name != "--pose"]
    if not names:
        return ()
    what = f"not stated, and taken as exact: {', '.join(names)}"
    do = "State it: the uncertainty to expect is relative to these as they are"
    return (Remark("no_standard_uncertainty", "warning", what, do=do),)


def in_words(direction: Array) -> str:
    """Return a direction in words: ``x up``, ``between x up and y down``."""
    axes = [
        f"{axis} {'up' if part > 0.0 else 'down'}"
        for axis, part in zip(AXES, direction, strict=True)
        if abs(part) > EDGE
    ]
    return axes[0] if len(axes) == 1 else f"between {', '.join(axes[:-1])} and {axes[-1]}"
