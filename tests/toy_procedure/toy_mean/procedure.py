"""The procedure ``mean_reading``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from inertialcal.core.axes import AXES
from inertialcal.procedures.protocol import Correction, Exclusion, InputSpec, Procedure, Source, Tested

from .plan import INFLUENCES, Plan

if TYPE_CHECKING:
    from inertialcal.procedures.model_terms import HeldOut, ModelTerms
    from inertialcal.sensors.model.sensor_model import SensorModel

    from .reduction import Readings, Result


class MeanReading(Procedure[Plan, "Readings", "Result"]):
    """Mean reading of a sensor at rest."""

    name = "mean_reading"
    title = "Mean reading of a sensor at rest."
    plan_type, influences = Plan, INFLUENCES
    counts_dwells = False
    makes_model = True
    uses = frozenset({"fit", "hold_out", "report_only"})
    inputs = InputSpec(("gyro", "accelerometer"))

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the means of all recordings."""
        import numpy as np

        from .reduction import Readings

        found: dict[str, list[float]] = {}
        skipped = 0
        for source in sources:
            for _, one in source.recordings():
                first = round(plan.skip / (one.sample_interval or 1.0))
                skipped += first
                for axis in (axis for axis in AXES if axis in one.names):
                    found.setdefault(axis, []).append(float(np.mean(one.channel(axis).data[first:])))
        return Readings({axis: np.array(means) for axis, means in found.items()}, sources[0].facts.si, skipped)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the means."""
        from .reduction import reduce

        return reduce(plan, readings)

    def exclusions(self, test: Tested[Plan, Readings, Result]) -> Iterator[Exclusion]:
        """Yield what was left out at the start."""
        if test.readings.skipped:
            decided = f"campaign: skip = {test.plan.skip:g} s"
            yield Exclusion("skip", decided, "the start", count=test.readings.skipped, counts="sample")

    def terms(self, result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms:
        """Return the means as bias."""
        from inertialcal.procedures.model_terms import ModelTerms
        from inertialcal.sensors.model.sensor_model import Provenance

        own = result.estimate
        keys = tuple(key._replace(quantity="bias") for key in own.keys)
        origin = Provenance(tests[0].id, tests[0].recordings)
        return ModelTerms(replace(own, given=keys), keys, tuple(result.readings.means), dict.fromkeys(keys, origin))

    def held_out(
        self,
        result: Result,
        fitted: Sequence[Tested[Plan, Readings, Result]],
        held: Sequence[Tested[Plan, Readings, Result]],
        model: SensorModel | None,
    ) -> HeldOut:
        """Return what is left of the means of other recordings."""
        from .reduction import held_out

        return held_out(result.estimate, [one.readings for one in held])


PROCEDURE = MeanReading()
