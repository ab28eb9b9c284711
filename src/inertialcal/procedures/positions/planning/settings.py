"""Settings of ``plan positions``. Free of numpy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ....core.settings import setting

LARGEST = 1000  # positions that anybody lays


@dataclass(frozen=True)
class Wanted:
    """What is known before a test of positions, and what it has to give."""

    scatter: float = setting(
        "Scatter of the mean reading of one position.", unit="m/s^2", example="0.1 mg", least=1e-12, most=10.0
    )
    target: Mapping[str, str] = setting(
        "Standard uncertainty wanted of a parameter or quantity: positions are added until it is met.",
        dict[str, str], example='scale_factor_error="100 ppm"',
    )  # fmt: skip
    have: Literal["none", "faces", "faces+edges", "cube"] = setting("Positions already taken.", "none")
    known: bool = setting("The direction of each position is known.", False)
    pose: float = setting(
        "Standard uncertainty of a known direction.", 0.0, unit="rad", example="0.5 deg", least=0.0, most=3.2
    )
    gravity: float = setting("Local gravity.", 9.80665, unit="m/s^2", example="9.81 m/s2", least=9.7, most=9.9)
    gravity_u: float = setting("Its standard uncertainty.", 0.0, unit="m/s^2", example="1 mGal", least=0.0, most=1.0)
    following: int = setting(
        "Instead of a target: how many positions to add, the best one each time.", 0, least=0, option="next"
    )
    goal: str = setting("What added positions are best for: determinant, trace, or a parameter.", "determinant")
    most: int = setting("Positions in all, at most.", 200, least=1, most=LARGEST)
