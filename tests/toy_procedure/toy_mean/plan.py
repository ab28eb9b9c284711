"""What the mean is told."""

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
