"""The procedure ``rate_table``: what it takes, what it says of its tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..protocol import Command, Correction, InputSpec, Procedure, Role, Source
from .figures import FIGURES
from .plan import INFLUENCES, Plan

if TYPE_CHECKING:
    from .readings import Readings
    from .reduction import Result


class RateTable(Procedure[Plan, "Readings", "Result"]):
    """Scale factor, bias and misalignment from dwells at known rates."""

    name = "rate_table"
    title = "Scale factor, bias, misalignment and error of rate from dwells at known rates."
    commands = (
        Command(
            "rate-table",
            "Scale factor, bias, asymmetry and misalignment from dwells at known rates: a table, or a recording of it.",
        ),
    )
    plan_type, influences = Plan, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "hold_out", "report_only"})
    inputs = InputSpec(("gyro",), (Role("applied", "angular_rate", "rad/s", by_axis=False),), table="rows")

    def inputs_for(self, plan: Plan, corrections: Sequence[Correction] = ()) -> InputSpec:
        """Return what is taken: before a correction, temperatures by the body axis whose sensor feels them."""
        return replace(self.inputs, by_body=bool(corrections))

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the dwells of tables and of recordings, after what earlier tests found was taken off."""
        from .recordings import readings_from, together
        from .stepped import turned_recordings
        from .tables import readings_of_table

        parts = [readings_of_table(plan, one) for one in sources if one.is_table]
        turned = turned_recordings(plan, [one for one in sources if not one.is_table])
        for correction in corrections:
            recordings, unknowns = correction.apply([(one.name, one.recording) for one in turned])
            turned = [
                replace(one, recording=recording, taken_off={**one.taken_off, **unknown})
                for one, recording, unknown in zip(turned, recordings, unknowns, strict=True)
            ]
        return together([*parts, readings_from(plan, turned)] if turned else parts)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the lines of all sensors."""
        from .reduction import reduce

        return reduce(plan, readings)


PROCEDURE = RateTable()
