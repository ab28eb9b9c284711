"""Settings of the mean: its plan, what its command can be told of a file, what it plans with. Free of numpy."""

from __future__ import annotations

from dataclasses import dataclass, field

from inertialcal.core.influence import Influence, Standards
from inertialcal.core.settings import setting

INFLUENCES = {"sensor.scale_factor": "the mean in proportion"}


@dataclass(frozen=True)
class Plan:
    """How the mean is taken."""

    skip: float = setting("Left out at the start of each recording.", 0.0, unit="s", example="2 s")
    fewest: int = setting("Recordings that a scatter between them needs.", 2, least=2)
    standards: Standards = field(default_factory=dict[str, Influence], metadata={"from": "standards"})


@dataclass(frozen=True)
class OfFile:
    """What the command is told of its files."""

    upside_down: bool = setting("The unit lay upside down: x and y point the other way.", False)


@dataclass(frozen=True)
class Wanted:
    """What is planned with."""

    scatter: float = setting("Scatter of the mean from recording to recording.", unit="reading", example="0.1 deg/s")
    target: float = setting("Standard uncertainty wanted.", unit="reading", example="0.01 deg/s")
