"""Positions planned before a test: what ``plan positions`` and ``inertialcal.plan_positions`` do.

Settings are text with a unit. Figures come in the unit that a target was stated in; else bias in that of
the scatter, scale factors in percent, angles in radians.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ....core.errors import DataError, UsageError
from ....core.estimate import Array
from ....core.key import AXES, Key, Reason
from ....core.remarks import Remark
from ....core.results import Row, not_estimated
from ....core.schema.settings import settings_values
from ....core.settings import settings_of
from ....core.show.frames import frame_of_rows
from ....core.show.result_tables import remarks_line
from ....core.show.rounding import number
from ....core.show.tables import Block, Table, html, text
from ....core.units import factor, parse_quantity
from ...planned import write_schedule
from ..plan import Wanted
from .design import (
    DETERMINANT,
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
LAY, REST = 20.0, 20.0  # of a position [s]
EDGE = 0.3  # component of a direction, below which its axis is level
ROUGH = 2  # digits of an uncertainty
USUAL = {"m/s^2": "0.1 mg", "rad": "0.5 deg", "1": "100 ppm"}
SMALLEST = 1e-15  # uncertainty that can be wanted, SI


@dataclass(frozen=True, eq=False)
class PositionsPlan:
    """Positions to take, and the uncertainty that they would give."""

    taken: int  # Positions there already
    directions: Array  # shape (n, 3): all positions, those there already first: what points up, in body axes
    prediction: Prediction  # Of all of them, SI
    rows: tuple[Row, ...]  # The uncertainty to expect of each parameter, ``bias_uncertainty`` of ``bias``
    remarks: tuple[Remark, ...] = ()  # What there is to say of it
    written: str = ""  # File with the programme

    @property
    def results(self) -> dict[str, Any]:
        """Positions, combinations that they do not determine, and rows as ``results.json`` has them."""
        rows = [row.to_dict() for row in self.rows]
        return {
            "positions": self.steps(),
            "not_told": list(self.prediction.undetermined),
            "results": rows,
            "curves": [],
        }

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
        """Return what is shown: the positions, the uncertainty to expect, what they do not determine."""
        found = self.prediction
        steps = tuple((str(one["number"]), str(one["up"])) for one in self.steps())
        head = (Table(("position", "up"), steps, "positions to take"),) if steps else ()
        caption = f"after {len(self.directions)} positions: {found.rank} of {found.count} parameters determined"
        figures = [(row.quantity, row.axis, number(row.value, ROUGH), row.unit) for row in self.rows]
        lost = (f"not determined: {', '.join(found.undetermined)}",) if found.undetermined else ()
        written = (f"programme written into {self.written}",) if self.written else ()
        return (*head, Table(("quantity", "axis", "value", "unit"), figures, caption, (2,)), *lost, *written)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text((*self.parts(), *remarks_line(self.remarks)))

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html((*self.parts(), *remarks_line(self.remarks)))


def plan_positions(**settings: Any) -> PositionsPlan:
    """Plan positions of an accelerometer triad.

    Parameters
    ----------
    **settings
        Those of ``plan positions``, quantities as text with a unit: ``scatter="0.1 mg"`` (needed), ``target``
        (``{"bias": "0.1 mg"}``) or ``following`` (how many positions to add), ``goal``, ``have``, ``known``, ``pose``,
        ``gravity``, ``gravity_u``, ``most``.

    Returns
    -------
    PositionsPlan
        Printable; ``.steps()``, ``.rows``, ``.prediction``, ``.remarks``.

    Raises
    ------
    UsageError
        If a setting is wrong or missing, or settings contradict each other.
    PlanError
        ``target_not_reached``.
    """
    return planned(settings, options=False)


def planned(given: Mapping[str, Any], options: bool = True) -> PositionsPlan:
    """Return the plan that settings give, as text with units; messages speak of options, or of arguments of Python."""
    said = {name: value for name, value in given.items() if value is not None}
    words = {one.name: f"--{one.option}" if options else one.name for one in settings_of(Wanted)}

    def called(path: tuple[str | int, ...]) -> str:
        return words.get(str(path[0]), str(path[0]))

    values, problems = settings_values(Wanted, said, lambda *_: "", called=called)
    if problems:
        raise UsageError(problems)
    wanted = Wanted(**values)
    setup = Setup(wanted.scatter, wanted.known, wanted.pose, wanted.gravity, wanted.gravity_u)
    limits = limits_of(setup, wanted.target, words)
    taken = cube()[SETS[wanted.have]]
    _check(wanted, setup, len(taken), words)
    if limits:
        directions = course(setup, limits, taken, most=wanted.most).directions
    else:
        laid: list[Array] = list(taken)
        for _ in range(wanted.following):
            laid.append(next_position(setup, np.array(laid).reshape(-1, 3), goal=wanted.goal))
        if not laid:
            do = f"Add {words['target']}, {words['following']} or {words['have']}"
            raise UsageError("nothing to plan", do=do, code="wrong_value")
        directions = np.array(laid)
    found = predict_uncertainty(setup, directions)
    exact = {"gravity_u": setup.gravity_u == 0.0, "pose": setup.known and setup.pose == 0.0}
    names = ", ".join(words[name] for name, one in exact.items() if one)
    what, do = f"taken as exact: {names}", "State it: the uncertainty to expect is relative to these as they are"
    remarks = (Remark("no_standard_uncertainty", "warning", what, do=do),) if names else ()
    made = PositionsPlan(len(taken), directions, found, _rows(found, wanted.target, str(said["scatter"])), remarks,
                         wanted.schedule or "")  # fmt: skip
    if wanted.schedule is not None:
        notes = ("positions: in any order; x, y, z: what points up, in body axes",)
        write_schedule(wanted.schedule, HEADS, _programme(made), notes)
    return made


HEADS = ("name", "recording", "power_up", "start [s]", "stop [s]", "duration [s]", "position", "x", "y", "z", "prompt")


def _programme(made: PositionsPlan) -> Iterator[tuple[str, ...]]:
    """Yield the positions to take, each laid, and left alone."""
    for k, one in enumerate(made.steps()):
        start = LAY + k * (LAY + REST)
        direction = [f"{x:.6f}" for x in one["direction"]]
        name, up = f"position {one['number']}", one["up"]
        yield (name, "positions", "1", f"{start:g}", f"{start + REST:g}", f"{REST:g}", str(one["number"]), *direction,
               f"Lay the unit with {up} and let go")  # fmt: skip


def limits_of(setup: Setup, target: Mapping[str, str], words: Mapping[str, str]) -> dict[str, float]:
    """Return the uncertainty wanted by parameter or quantity, SI."""
    every = list(zip(*parameters(setup.known), strict=True))
    units = {str(key): unit for key, unit in every} | {key.quantity: unit for key, unit in every}
    _check_names("target", target, units, setup.known, words)
    limits = {}
    for name, said in target.items():
        do = f'Write it like {name}="{USUAL[units[name]]}"'
        if name == said:
            raise UsageError(f"target {name}: no uncertainty given", do=do, code="wrong_value")
        try:
            limits[name] = parse_quantity(said).to(units[name])
        except DataError as error:
            raise UsageError(f"{name}: {said!r}", why=error.problems[0].what, do=do, code="no_unit") from None
        if not SMALLEST <= limits[name] <= 1.0 / SMALLEST:
            raise UsageError(f"{name}: {said!r}: need more than 0", do=do, code="wrong_value")
    return limits


def _check_names(what: str, given: Iterable[str], names: Iterable[str], known: bool, words: Mapping[str, str]) -> None:
    unknown = next((name for name in given if name not in names), None)
    if unknown is not None:
        do = f"There are: {', '.join(names)}"
        if not known and unknown in parameter_names(known=True):
            do = f"Only known directions determine it: {words['known']}. Without {do[0].lower()}{do[1:]}"
        raise UsageError(f"{what} {unknown!r}: no such parameter", do=do, code="unknown_name")


def _check(wanted: Wanted, setup: Setup, taken: int, words: Mapping[str, str]) -> None:
    """Refuse what contradicts itself, or would change nothing."""
    contradictions = {
        "a target, and a number of positions to add": (
            bool(wanted.target) and wanted.following > 0,
            "Give one of them: positions are added until the target is met, or so many",
        ),
        f"goal {wanted.goal!r}, and no number of positions to add": (
            wanted.goal != DETERMINANT and not wanted.following,
            f"Say how many: {words['following']} 3. A target decides for itself which positions it needs",
        ),
        f"{words['pose']} of directions that are not known": (
            setup.pose > 0.0 and not setup.known,
            f"Add {words['known']}, or leave {words['pose']} out",
        ),
        f"{taken + wanted.following} positions, and {wanted.most} in all": (
            taken + wanted.following > wanted.most,
            f"Add fewer, or allow more with {words['most']}",
        ),
    }
    for what, (wrong, do) in contradictions.items():
        if wrong:
            raise UsageError(what, do=do, code="contradiction")
    if wanted.following:
        names = [DETERMINANT, TRACE, *parameter_names(setup.known)]
        _check_names("goal", [wanted.goal], names, setup.known, words)


def _rows(found: Prediction, target: Mapping[str, str], scatter: str) -> tuple[Row, ...]:
    """Return the uncertainty to expect, or why there is none, in the units that people said."""
    rows = []
    for key, si, u in zip(found.keys, found.units, found.u, strict=True):
        said = target.get(str(key)) or target.get(key.quantity)
        usual = {"1": "%", "m/s^2": parse_quantity(scatter).unit}
        unit = parse_quantity(said).unit if said else usual.get(si, si)
        named = Key(f"{key.quantity}_uncertainty", key.axis)
        row = Row(named, float(u) * factor(si, unit), None, unit, test=TEST)
        if not np.isfinite(u):
            lost = [one for one, parts in zip(found.undetermined, found.parts, strict=True) if key in parts] or [
                str(key)
            ]
            row = not_estimated(named, unit, Reason("not_told", f"these positions do not determine {', '.join(lost)}"))
        rows.append(row)
    return tuple(rows)


def in_words(direction: Array) -> str:
    """Return a direction in words: ``x up``, ``between x up and y down``."""
    axes = [
        f"{axis} {'up' if part > 0.0 else 'down'}"
        for axis, part in zip(AXES, direction, strict=True)
        if abs(part) > EDGE
    ]
    return axes[0] if len(axes) == 1 else f"between {', '.join(axes[:-1])} and {axes[-1]}"
