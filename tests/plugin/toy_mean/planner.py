"""How many recordings a mean needs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from inertialcal.core.errors import UsageError
from inertialcal.core.key import Key
from inertialcal.core.remarks import Remark
from inertialcal.core.results import Row
from inertialcal.core.schema.settings import settings_values
from inertialcal.core.show.tables import Block

from .plan import Wanted


@dataclass(frozen=True)
class MeanPlan:
    """The number of recordings."""

    recordings: int
    remarks: tuple[Remark, ...] = ()

    @property
    def results(self) -> Mapping[str, Any]:
        """A row."""
        return {"results": [Row(Key("recordings"), float(self.recordings), None, "1").to_dict()]}

    def parts(self) -> Sequence[Block]:
        """Return one line."""
        return (f"{self.recordings} recordings",)


def plan(given: Mapping[str, Any]) -> MeanPlan:
    """Return how many recordings bring the uncertainty of the mean to its target.

    Raises
    ------
    UsageError
        If a setting is wrong.
    """
    values, problems = settings_values(Wanted, given, lambda *_: "")
    if problems:
        raise UsageError(problems)
    return MeanPlan(max(2, math.ceil((values["scatter"] / values["target"]) ** 2)))
