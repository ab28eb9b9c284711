"""What a campaign says of a moved mass: columns of reduced runs, the schedule of the mass."""

from __future__ import annotations

from pydantic import Field

from ...core.quantities import Unit
from ...core.schema_words import Strict, Text


class Lines(Strict):
    """lines = {...}: which column of a table of reduced runs is what; a row is a run with a moved mass."""

    run: Text
    applied: Text
    applied_unit: Unit
    response: Text
    noise: Text
    unit: Unit
    beside: int = Field(default=8, gt=0)
    psd_response: Text | None = None
    psd_noise: Text | None = None
    scatter: Text | None = None
    moved: Text | None = None
    u_applied: str | None = None


class MovedMass(Strict):
    """mass = {...}: the schedule of the mass that is moved during a recording, and when it begins."""

    schedule: Text
    begin: str | int | float | None = None
    moved: bool = True
