"""The procedure ``rate_table``: what it takes, what it says of its tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..entries import latitude_needed
from ..protocol import (
    LASTS,
    OF_MOUNTING,
    READING,
    RELATIVE,
    BudgetFigure,
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
from .figures import FIGURES
from .plan import INFLUENCES, Columns, Plan, PlannedRates

if TYPE_CHECKING:
    from ...core.errors import InertialcalError, Problem
    from ...core.judging import Asked, Verdict
    from ...core.recording import Recording
    from ...core.remarks import Remark
    from ...core.results import Row
    from ...files.info.survey import Survey
    from ...files.text.table import Table
    from ...sensors.model.sensor_model import SensorModel
    from ..entries import Entry, EntryKey, SaidSensor, SaidTest
    from ..given import Described, GivenFile
    from ..model_terms import HeldOut, ModelTerms
    from ..planned import TestPlan
    from ..rehearsed import Rehearsal
    from ..suggestions import Claim, Draft, FolderFile, Question, Suggestion
    from .readings import Readings
    from .reduction import Result

LATITUDE = "site.latitude"
QUANTITIES = {
    "rate_error": Quantity(RELATIVE, over="rate", unit="1"),
    "bias": Quantity(READING),
    "scale_factor": Quantity(("other",)),
    "scale_factor_error": Quantity(RELATIVE, shown="%"),
    "scale_factor_asymmetry": Quantity(RELATIVE, shown="%"),
    "second_order": Quantity(("other",), shown="1/({unit})"),
    "third_order": Quantity(("other",), shown="1/({unit})^2"),
    "cross_axis_sensitivity": Quantity(RELATIVE, shown="%", redrawn_by=OF_MOUNTING),
    "misalignment": Quantity(("angle",), redrawn_by=OF_MOUNTING),
    "linearity_error": Quantity(RELATIVE),
    "scatter_sample": Quantity(READING, redrawn_by=LASTS),
    "scatter_dwell": Quantity(READING, redrawn_by=LASTS),
    "scatter_run": Quantity(READING, redrawn_by=LASTS),
    "scatter_recording": Quantity(READING, redrawn_by=LASTS),
    "residual_bias": Quantity(READING),
    "resolution": Quantity(READING, redrawn_by=None),
}


PLANNED = '--noise "0.2 deg/sqrt(h)" --fastest "100 deg/s"'


class RateTable(Procedure[Plan, "Readings", "Result"]):
    """Scale factor, bias and misalignment from dwells at known rates."""

    name = "rate_table"
    title = "Scale factor, bias, misalignment and error of rate from dwells at known rates."
    commands = (
        Command(
            "rate-table",
            "Scale factor, bias, asymmetry and misalignment from dwells at known rates: a table, or a recording of it.",
            examples=("gyro_z.csv", "gyro_z.csv -o gyro_z.png"),
        ),
    )
    planner = Command(
        "rate-table",
        "Runs, dwells and rates of a rate table, and the uncertainty of scale factor, bias and misalignment.",
        examples=(f"{PLANNED} --wanted scale_factor_error='200 ppm'", f'{PLANNED} --available "8 h"'),
    )
    planner_type = PlannedRates
    plan_type, influences = Plan, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "hold_out", "report_only"})
    gives = ("scale_factor", "misalignment", "asymmetry", "bias")
    corrects = "matrix"
    takes_corrections = changes = True
    chosen_by = "Choose by windows, or give rows.group"
    said_type = Columns
    inputs = InputSpec(("gyro",), (Role("applied", "", "rad/s", by_axis=False),), table="rows")

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return what a file is taken for: a table of dwells, or a recording of a table turned in steps."""
        from .given import described

        return [described(given)]

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the dwells of tables and of recordings, after what earlier tests found was taken off."""
        from ..corrections import corrected
        from .recordings import readings_from, together, turned_recordings
        from .tables import readings_of_table

        parts = [readings_of_table(plan, one) for one in sources if one.is_table]
        turned = turned_recordings(plan, [one for one in sources if not one.is_table])
        recordings, unknowns = corrected(corrections, [(one.name, one.recording) for one in turned])
        turned = [
            replace(one, recording=recording, taken_off=unknown)
            for one, recording, unknown in zip(turned, recordings, unknowns, strict=True)
        ]
        return together([*parts, readings_from(plan, turned)] if turned else parts)

    def planned(self, given: Mapping[str, Any]) -> TestPlan:
        """Return what a test will give."""
        from .planning import planned

        return planned(given)

    def rehearsed(self, given: Mapping[str, Any], schedule: Table, seed: int) -> Rehearsal:
        """Return what a schedule gives on a simulated unit."""
        from ..planned import settings_said
        from .rehearsal import rehearse

        return rehearse(settings_said(PlannedRates, given, options=True)[0], schedule, seed)

    def agreement(self, plan: Plan, readings: Readings) -> Sequence[Remark]:
        """Return runs and readings that disagree with the table, or with each other."""
        from .agreement import agreement_many

        return agreement_many([(plan, readings)])[0]

    @property
    def agreement_many(self) -> Callable[[Sequence[tuple[Plan, Readings]]], Sequence[Sequence[Remark]]]:
        """What gives the same of many units: those that were turned alike are looked at together."""
        from .agreement import agreement_many

        return agreement_many

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the lines of all sensors."""
        from .reduction import reduce

        return reduce(plan, readings)

    def reduce_many(self, tests: Sequence[tuple[Plan, Readings]]) -> list[Result | InertialcalError]:
        """Return the result of each unit, or its refusal; what was turned alike is fitted at once."""
        from .reduction import reduce_many

        return reduce_many(tests)

    def quantities(self) -> Mapping[str, Quantity]:
        """Return what there is to say of its figures."""
        return QUANTITIES

    def exclusions(self, test: Tested[Plan, Readings, Result]) -> Iterator[Exclusion]:
        """Yield samples at edges and outliers, then each dwell that a rule left out, sensor by sensor."""
        from .exclusions import dwells_left_out, samples_left_out

        yield from samples_left_out(test.readings)
        yield from dwells_left_out(test.plan, test.readings)

    def needs(self, influence: str, result: Result) -> bool:
        """Return whether an influence would change this result; the latitude, where earth rate is taken from it."""
        from .rows import applies

        plan = result.plan
        if influence == LATITUDE:  # with a zero reference earth rate drops out
            return plan.attitude is not None and plan.latitude is not None and not plan.zero_reference
        return influence in self.influences and applies(influence, plan, result.readings)

    def effects(self) -> Mapping[str, str]:
        """Return what each influence changes."""
        return {**self.influences, LATITUDE: "earth rate along the axis of the table"}

    def judge(
        self, asked: Asked, tests: Sequence[Tested[Plan, Readings, Result]]
    ) -> tuple[list[Verdict], list[Row]] | None:
        """Return the verdicts on the error of rate, rate by rate; other figures are judged by the general rule."""
        from .judging import judge_rate_errors

        return judge_rate_errors(asked, tests) if asked.quantity == "rate_error" else None

    def budgeted(self, result: Result) -> Sequence[BudgetFigure]:
        """Return all values; a bias after a zero reference is what is left of it, scale factors in volts come too."""
        from .rows import RESIDUAL

        ideal, found = result.plan.scale_factor or {}, []
        for one in super().budgeted(result):
            quantity, axis = one.key.quantity, one.key.axis
            if quantity == "scale_factor_error" and axis in ideal:
                volts = one.key._replace(quantity="scale_factor")
                found.append(BudgetFigure(volts, "V/(rad/s)", one.at, abs(ideal[axis])))
            left = quantity == "bias" and result.plan.zero_reference
            found.append(replace(one, key=one.key._replace(quantity=RESIDUAL)) if left else one)
        return found

    def joined(self, tests: Sequence[Tested[Plan, Readings, Result]]) -> tuple[Plan, Readings] | None:
        """Return all dwells as one test; the axis alone may differ."""
        from .model.held_out import joined

        return None if len(tests) == 1 and not tests[0].plan.axis else joined(tests)

    def terms(self, result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms:
        """Return matrix, bias and asymmetry."""
        from .model.held_out import model_terms

        return model_terms(result, tests)

    def correction(self, test: str, result: Result) -> Correction | None:
        """Return the matrix; None where no scale factor could be estimated."""
        from ..corrections import ACROSS, SCALE, MatrixCorrection

        estimate = result.estimate
        keys = () if estimate is None else tuple(key for key in estimate.keys if key.quantity in (SCALE, ACROSS))
        return None if estimate is None or not keys else MatrixCorrection((test,), (estimate.select(keys),))

    def check_alike(self, tests: Sequence[Tested[Plan, Readings, Result]]) -> None:
        """Refuse tests some of which have their bias against a reading at rest."""
        from .model.held_out import check_alike

        check_alike(tests)

    def held_out(
        self,
        result: Result,
        fitted: Sequence[Tested[Plan, Readings, Result]],
        held: Sequence[Tested[Plan, Readings, Result]],
        model: SensorModel | None,
    ) -> HeldOut | None:
        """Return what the model does to dwells held out."""
        from .model.held_out import judged_on

        return None if model is None else judged_on(model, result, fitted, held)

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return ``rows`` and ``schedule``."""
        from .entry import KEYS

        return KEYS

    def check(self, test: SaidTest) -> Iterator[Problem]:
        """Yield an attitude without a latitude."""
        yield from latitude_needed(test)

    def check_entry(self, name: str, entry: Entry, sensor: SaidSensor, at: Callable[..., str]) -> Iterator[Problem]:
        """Yield columns of a reduced table that do not fit the sensor."""
        from .entry import entry_problems

        return entry_problems(name, entry, sensor, at)

    def suggests(self, recording: Recording, survey: Survey) -> Suggestion | None:
        """Return the command to type next."""
        from .suggest import suggests

        return suggests(recording, survey)

    def claims(self, file: FolderFile) -> Claim | None:
        """Return how much a file of a folder is made for this test."""
        from .suggest import claims

        return claims(file)

    def asks(self, contents: Mapping[str, object]) -> Sequence[Question]:
        """Return what it has to be told: the axis that was turned."""
        from .suggest import asks

        return asks(contents)

    def draft(self, contents: Mapping[str, object]) -> Draft:
        """Return what a first campaign.toml says of them."""
        from .suggest import draft

        return draft(contents)


PROCEDURE = RateTable()
