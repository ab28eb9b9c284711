"""plan positions: which positions to take, and what they would tell."""

from __future__ import annotations

from typing import Annotated

import typer

from .options import Json, Quiet
from .output import json_out
from .pairs import pairs


def plan_positions(
    scatter: Annotated[
        str, typer.Option(help='Scatter of the mean reading of one position: "0.1 mg".', show_default=False)
    ],
    target: Annotated[
        list[str] | None, typer.Option(help='Uncertainty wanted: scale_factor_error="100 ppm"; may be repeated.')
    ] = None,
    have: Annotated[str, typer.Option(help="Positions there already: none, faces, faces+edges or cube.")] = "none",
    known: Annotated[bool, typer.Option("--known", help="The direction of each position is known.")] = False,
    pose: Annotated[str, typer.Option(help="Standard uncertainty of a known direction.")] = "0 deg",
    gravity: Annotated[str, typer.Option(help="Local gravity.")] = "9.80665 m/s2",
    gravity_u: Annotated[str, typer.Option("--gravity-u", help="Its standard uncertainty.")] = "0 m/s2",
    following: Annotated[int, typer.Option("--next", help="Without a target: how many positions to add.")] = 0,
    goal: Annotated[
        str, typer.Option(help="What these are best for: determinant, trace, or a parameter.")
    ] = "determinant",
    most: Annotated[int, typer.Option(help="Positions in all, at most.")] = 200,
    as_json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Which positions of an accelerometer triad to take, one after another, and the uncertainty to expect."""
    from ..campaign.single_positions_plan import positions_plan

    wanted = pairs(target or [], "--target", 'bias="0.1 mg"')
    found = positions_plan(scatter, wanted, have, known, pose, gravity, gravity_u, following, goal, most)
    if as_json:
        untold = list(found.prediction.untold)
        json_out("plan", {"positions": found.steps(), "predicted": found.rows(), "not_told": untold})
    elif not quiet:
        print(found)
    return 0
