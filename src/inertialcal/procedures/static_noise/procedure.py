"""The procedure ``static_noise``: what it takes, what it says of its tests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

from ...core.key import AXES
from ..protocol import (
    LASTS,
    READING,
    BudgetFigure,
    Command,
    Correction,
    Exclusion,
    Facts,
    InputSpec,
    Levels,
    Procedure,
    Quantity,
    Source,
    Tested,
)
from .figures import FIGURES
from .plan import INFLUENCES, OF_CLOCK, Filters, Plan, PlannedRecord, Samples

if TYPE_CHECKING:
    from ...core.errors import InertialcalError
    from ...core.recording import Recording
    from ...core.remarks import Remark
    from ...core.results import Interval, Row, WrittenRow
    from ...core.show.rows import Sentence
    from ...files.info.survey import Survey
    from ...files.text.table import Table
    from ..given import Described, GivenFile
    from ..model_terms import ModelTerms
    from ..planned import TestPlan
    from ..protocol import Reduced
    from ..rehearsed import Rehearsal
    from ..suggestions import Claim, Draft, FolderFile, Suggestion
    from .readings import Readings
    from .reduction import Result

NO_READINGS = {
    "glitch": "far from their neighbours", "saturated": "at the end of the range", "repeated": "copies of earlier ones",
    "stuck": "one value repeated for too long",
}  # fmt: skip


PLANNED = '--noise "0.2 deg/sqrt(h)" --instability "5 deg/h" --walk "5 deg/h/sqrt(h)"'


@cache
def _quantities() -> Mapping[str, Quantity]:
    from .rows import SENSORS, data_sheet_units

    units = {kind: data_sheet_units(kind) for kind in SENSORS}
    names = dict.fromkeys(name for own in units.values() for name in own)
    return {
        name: Quantity(
            size=True,
            shown_by_kind={kind: own[name] for kind, own in units.items() if name in own},
            redrawn_by=LASTS,
        )
        for name in names
    } | {"level_at_rest": Quantity(READING)}


class StaticNoise(Procedure[Plan, "Readings", "Result"]):
    """Noise of a sensor at rest."""

    name = "static_noise"
    title = "Noise terms of a sensor at rest with error bars, what the record cannot tell, and how long to record."
    commands = (
        Command(
            "allan",
            "Noise terms of a sensor at rest with error bars, what the record cannot tell, and how long to record.",
            examples=("still.csv -o still.svg", "still.csv --column gyro_x --for kalibr"),
        ),
        Command(
            "psd",
            "Spectrum of a sensor at rest: its lines by name, its noise terms, and a check against the Allan"
            " deviation.",
            "spectrum",
            examples=("fan.csv -o fan.svg", "fan.csv --plot"),
        ),
    )
    planner = Command(
        "allan",
        "Hours and samples of a record at rest, how steady its temperature, and how well noise terms will be known.",
        examples=(f"{PLANNED} --wanted instability='10 %'", f'{PLANNED} --available "12 h"'),
    )
    planner_type = PlannedRecord
    plan_type, said_type, shown_type, influences = Plan, Samples, Filters, INFLUENCES
    figures = FIGURES
    gives = ("noise",)
    takes_corrections = changes = True
    inputs = InputSpec(
        ("gyro", "accelerometer"),
        missing=True,
        bare=True,
        ground_model="bias_kept",
        windows="records",
        screening="own",
        streamed=True,
    )

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return the sensors at rest of a file, each with a test of its own."""
        from .given import described_sensors

        return described_sensors(given, self.inputs)

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return the kind of the sensor and the standards; the unit only where there is no kind."""
        return {"kind": facts.kind, "unit": "" if facts.kind else facts.unit, "standards": facts.standards}

    def planned(self, given: Mapping[str, Any]) -> TestPlan:
        """Return what a test will give."""
        from .planning.planner import planned

        return planned(given)

    def rehearsed(self, given: Mapping[str, Any], schedule: Table, seed: int) -> Rehearsal:
        """Return what a schedule gives on a simulated unit."""
        from ..planned import settings_said
        from .planning.planner import known_of
        from .planning.rehearsal import rehearse

        return rehearse(known_of(*settings_said(PlannedRecord, given, options=True)), schedule, seed)

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the records at rest, a record a recording or a window."""
        from ..corrections import corrected
        from .axis_noise import check, end_early
        from .readings import AtRest
        from .recordings import readings_from

        found = []
        for source in sources:
            added = next((one.quantity for axis, one in (source.entry.channels or {}).items() if axis in AXES), None)
            shown = "" if added else source.facts.unit
            named = source.recordings()
            recordings = corrected(corrections, named)[0] if corrections else [one for _, one in named]
            for (label, _), one in zip(named, recordings, strict=True):
                channels = {axis: axis for axis in AXES if axis in one.names}
                samples: Any = added or "rate"
                cut_off, run = source.facts.cut_off, source.run
                found.append(AtRest(one, channels, samples, label, shown, source.screening, cut_off, run))
        readings = readings_from(plan, found)
        try:
            check(plan, readings)
        except BaseException:
            for record in readings.records:
                end_early(record)
            raise
        return readings

    def agreement(self, plan: Plan, readings: Readings) -> Sequence[Remark]:
        """Return which recordings are in another unit than the others, or have another sign."""
        from .agreement import agreement

        return tuple(agreement(plan, readings))

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the noise terms."""
        from .reduction import reduce

        return reduce(plan, readings)

    def reduce_many(self, tests: Sequence[tuple[Plan, Readings]]) -> list[Result | InertialcalError]:
        """Return the noise terms of each of many units: records alike are worked on side by side."""
        from .reduction import reduce_many

        return reduce_many(tests)

    def terms(self, result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
        """Return the noise of each axis."""
        from .terms import model_terms

        return model_terms(result, tests)

    def remarks(self, facts: Facts) -> Sequence[Remark]:
        """Say where body axes are mixtures of the sensor's: their noise is one, too."""
        from ...core.remarks import Remark

        if not facts.oblique:
            return ()
        what = "the mounting is oblique: noise of body axes is a mixture of that of the sensors"
        return [Remark("axes_mixed", "info", what, do="Leave mounting out for the noise of each sensor")]

    def exclusions(self, test: Tested[Plan, Readings, Result]) -> Iterator[Exclusion]:
        """Yield the warm-up, samples that are no readings, and disturbances."""
        for record in test.readings.records:
            if record.warm_up:
                decided = f"campaign: warm_up = {test.plan.warm_up:g} s"
                yield Exclusion("warm_up", decided, "the warm-up", record.name, count=record.warm_up, counts="sample")
            for name, counts in record.bad.items() if record.screened else ():
                for code in (code for code in NO_READINGS if counts.get(code)):
                    why, count = NO_READINGS[code], counts[code]
                    yield Exclusion("screened", f"screening: {code}", why, record.name, name, count, "sample")
        for axis in test.result.axes:
            for found in (one for one in axis.records if one.looked.left_out):
                why, count = f"disturbances at {len(found.looked.disturbed)} place(s)", found.looked.left_out
                yield Exclusion("screened", "screening: disturbed", why, found.run.name, axis.axis, count, "sample")

    def quantities(self) -> Mapping[str, Quantity]:
        """Return what there is to say of the noise terms: sizes, in the units of data sheets."""
        return _quantities()

    def levels(self, result: Result) -> Levels:
        """Return the level of each axis, over the power-ups."""
        from .level import levels

        return levels(result)

    def effects(self) -> Mapping[str, str]:
        """Return what each influence changes."""
        return {**self.influences, **OF_CLOCK}

    def budgeted(self, result: Result) -> Sequence[BudgetFigure]:
        """Return all terms if scale factor or clock take part; else the scatter of the noise is all there is."""
        from .rows import SOURCES

        return super().budgeted(result) if SOURCES.keys() & result.plan.standards.keys() else []

    def interval_at(self, result: Result, row: Row, p: float) -> Interval | None:
        """Return the interval of a noise term."""
        return result.interval_at(row, p)

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return what a test found, as one sentence."""
        from .finding import finding

        return finding(rows)

    def doubt(self, result: Result, axis: str) -> str:
        """Return why the terms of an axis may not hold."""
        return result.doubt(axis)

    def report(self, found: Reduced) -> str:
        """Return the terms, or the spectrum, of each sensor as text, and settings of filters."""
        from .shown import report

        return report(found)

    def content(self, found: Reduced) -> Mapping[str, object]:
        """Return settings of filters."""
        from .shown import content

        return content(found)

    def files(self, found: Reduced) -> Mapping[str, str]:
        """Return curves as CSV, terms as JSON, and settings of filters."""
        from .shown import files

        return files(found)

    def suggests(self, recording: Recording, survey: Survey) -> Suggestion | None:
        """Return the command to type next."""
        from .suggest import suggests

        return suggests(recording, survey)

    def claims(self, file: FolderFile) -> Claim | None:
        """Return how much a file of a folder is made for this test."""
        from .suggest import claims

        return claims(file)

    def belong_together(self, contents: Sequence[object]) -> bool:
        """Return whether recordings at rest have one level: else each is a dwell at a rate of its own."""
        from ...core.recording import Recording
        from ...files.info.motion import of_one_level

        return of_one_level([one for one in contents if isinstance(one, Recording)])

    def draft(self, contents: Mapping[str, object]) -> Draft:
        """Return what a first campaign.toml says of them."""
        from .suggest import draft

        return draft(contents)


PROCEDURE = StaticNoise()
