"""plan positions: which positions to take, and what they would tell."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..options import Json, Quiet
from ..pairs import pairs
from ..shown.output import json_out

if TYPE_CHECKING:
    from ...procedures.positions.planning.planner import PositionsPlan


def plan(
    scatter: Annotated[
        str | None, typer.Option(help='Scatter of the mean reading of one position: "0.1 mg".', show_default=False)
    ] = None,
    target: Annotated[
        list[str] | None, typer.Option(help='Uncertainty wanted: scale_factor_error="100 ppm"; may be repeated.')
    ] = None,
    have: Annotated[str, typer.Option(help="Positions there already: none, faces, faces+edges or cube.")] = "none",
    known: Annotated[bool, typer.Option("--known", help="The direction of each position is known.")] = False,
    pose: Annotated[str, typer.Option(help="With --known: standard uncertainty of a direction.")] = "0 deg",
    gravity: Annotated[str, typer.Option(help="Local gravity.")] = "9.80665 m/s2",
    gravity_u: Annotated[str, typer.Option("--gravity-u", help="Its standard uncertainty.")] = "0 m/s2",
    following: Annotated[int, typer.Option("--next", help="In place of a target: how many positions to add.")] = 0,
    goal: Annotated[
        str, typer.Option(help="What these are best for: determinant, trace, or a parameter.")
    ] = "determinant",
    most: Annotated[int, typer.Option(help="Positions in all, at most.")] = 200,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Run the command; its help stands in the declaration of the procedure."""
    from ...procedures.positions.planning.planner import plan_positions

    wanted = pairs(target or [], "--target", 'bias="0.1 mg"')
    found = plan_positions(
        scatter=scatter, target=wanted, have=have, known=known, pose=pose, gravity=gravity, gravity_u=gravity_u,
        following=following, goal=goal, most=most,
    )  # fmt: skip
    if as_json:
        json_out("plan positions", _content(found))
    elif not quiet:
        _print(found)
    return 0


def _content(found: PositionsPlan) -> dict[str, Any]:
    return {
        "remarks": [remark.to_dict() for remark in found.remarks],
        "positions": found.steps(),
        "not_told": list(found.prediction.untold),
        **found.results,
    }


def _print(found: PositionsPlan) -> None:
    from ...core.show.tables import text
    from ..shown.summary import remarks_text

    print(text(found.tables()))
    for line in remarks_text([remark.to_dict() for remark in found.remarks]):
        print(line)
