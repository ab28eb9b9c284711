"""The procedure ``mean_reading``: all that a procedure can say, in as few lines as it takes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

from inertialcal.core.figure import FigureSpec
from inertialcal.core.key import AXES
from inertialcal.procedures.protocol import (
    READING,
    Command,
    Correction,
    Exclusion,
    InputSpec,
    Procedure,
    Quantity,
    Role,
    Source,
    Tested,
)

from .plan import INFLUENCES, OfFile, Plan, Wanted

if TYPE_CHECKING:
    from inertialcal.core.recording import Recording
    from inertialcal.files.info.survey import Survey
    from inertialcal.procedures.entries import EntryKey
    from inertialcal.procedures.given import Described, GivenFile
    from inertialcal.procedures.model_terms import HeldOut, ModelTerms
    from inertialcal.procedures.suggestions import Claim, Draft, FolderFile, Suggestion
    from inertialcal.sensors.model.sensor_model import SensorModel

    from .entry import MeanEntry
    from .planner import MeanPlan
    from .reduction import Readings, Result

CURVES = {"mean_readings": "means {axis}"}


class MeanReading(Procedure[Plan, "Readings", "Result"]):
    """Mean reading of a sensor at rest."""

    name = "mean_reading"
    title = "Mean reading of a sensor at rest."
    commands = (Command("mean-reading", "Mean reading of a sensor at rest, from recordings or a table of means."),)
    planner = Command("mean-reading", "How many recordings a mean needs.")
    plan_type, said_type, planner_type, influences = Plan, OfFile, Wanted, INFLUENCES
    counts_dwells = False
    gives = ("bias",)
    takes_corrections = True
    uses = frozenset({"fit", "hold_out", "report_only"})
    inputs = InputSpec(("gyro", "accelerometer"), (Role("temperature", "temperature", "degC"),), table="mean_table")
    figures = (
        FigureSpec("means", "toy_mean.figures", "Means of {axis}.", curves=CURVES, order=700, top=700),
        FigureSpec("mean_steps", "toy_mean.figures", "Changes of {axis}.", curves={"mean_steps": "steps {axis}"}),
    )

    def quantities(self) -> Mapping[str, Quantity]:
        """Return what there is to say of its figure."""
        return {"mean_reading": Quantity(READING)}

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return its own keys of a recording's entry."""
        from .entry import KEYS

        return KEYS

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return a table of means, or a recording of channels, as it lay."""
        from .given import described

        return [described(given, self.inputs)]

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the means of all recordings, after what other tests found was taken off, and of all tables."""
        import numpy as np

        from .reduction import Readings

        found: dict[str, list[float]] = {}
        skipped = 0
        for source in (one for one in sources if one.is_table):
            columns = cast("MeanEntry", source.entry).mean_table
            assert columns is not None
            for axis in (axis for axis in AXES if getattr(columns, axis, None)):
                values = source.table().numbers(getattr(columns, axis))
                found.setdefault(axis, []).extend(source.in_si(values, columns.unit, axis).tolist())
        recorded = [(source, one) for source in sources if not source.is_table for _, one in source.recordings()]
        named = [source for source, _ in recorded]
        recordings = [one for _, one in recorded]
        for correction in corrections:
            labelled = [(source.name, one) for source, one in zip(named, recordings, strict=True)]
            recordings, _ = correction.apply(labelled)
        for source, one in zip(named, recordings, strict=True):
            sign = -1.0 if cast("MeanEntry", source.entry).upside_down else 1.0
            first = round(plan.skip / (one.sample_interval or 1.0))
            skipped += first
            for axis in (axis for axis in AXES if axis in one.names):
                found.setdefault(axis, []).append(sign * float(np.nanmean(one.channel(axis).data[first:])))
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

    def planned(self, given: Mapping[str, Any]) -> MeanPlan:
        """Return how many recordings a mean needs."""
        from .planner import plan

        return plan(given)

    def suggests(self, recording: Recording, survey: Survey) -> Suggestion | None:
        """Suggest it for what says so in its name."""
        from .suggest import suggests

        return suggests(recording)

    def claims(self, file: FolderFile) -> Claim | None:
        """Claim what says so in its name."""
        from .suggest import claims

        return claims(file)

    def draft(self, contents: Mapping[str, object]) -> Draft:
        """Return a first campaign of such files."""
        from .suggest import draft

        return draft(contents)


PROCEDURE = MeanReading()
