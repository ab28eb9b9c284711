"""The procedure ``thermal``: what it takes, what it says of its tests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..entries import latitude_needed, reading_units
from ..protocol import (
    READING,
    RELATIVE,
    Command,
    Correction,
    Exclusion,
    Facts,
    InputSpec,
    Procedure,
    Quantity,
    Role,
    Source,
    Tested,
)
from .figures import FIGURES
from .plan import INFLUENCES, LARGEST_ORDER, Plan, PlannedRamps, Thermometer

if TYPE_CHECKING:
    from ...core.errors import InertialcalError, Problem
    from ...core.judging import Asked, Verdict
    from ...core.recording import Recording
    from ...core.results import Row, WrittenRow
    from ...core.show.rows import Sentence
    from ...files.info.survey import Survey
    from ...files.text.table import Table
    from ...sensors.model.sensor_model import SensorModel
    from ..entries import SaidTest
    from ..model_terms import HeldOut, ModelTerms
    from ..planned import TestPlan
    from ..rehearsed import Rehearsal
    from ..suggestions import Claim, Draft, FolderFile, Suggestion
    from .recordings import Readings
    from .reduction import Result

RULES = ("warm_up", "turn_over", "one_path", "sparse")
LATITUDE = "site.latitude"
QUANTITIES = {
    "bias": Quantity(READING, over="temperature"),
    "bias_over_temperature": Quantity(READING, over="temperature"),
    "path_difference": Quantity(READING),
    "hysteresis": Quantity(READING),
    "vacuum_offset": Quantity(READING),
    "vacuum_step": Quantity(READING),
    "vacuum_step_temperature": Quantity(("other",)),
    "vacuum_step_relative_temperature": Quantity(("other",), shown="%/degC"),
    "scatter_run": Quantity(READING),
    "scatter_recording": Quantity(READING),
    "warm_up_change": Quantity(READING),
    "warm_up_time": Quantity(("time",)),
    "warm_up_time_constant": Quantity(("time",)),
    "thermal_lag": Quantity(("time",)),
    "reference_voltage": Quantity(("voltage",)),
    "temperature_reference_voltage": Quantity(("voltage",)),
    "reference_voltage_temperature_1": Quantity(("other",)),
    "temperature_reference_voltage_temperature_1": Quantity(("other",)),
    **{f"bias_temperature_{power}": Quantity(("other",)) for power in range(1, LARGEST_ORDER + 1)},
    "vacuum_offset_run_to_run": Quantity(READING),
    "bias_shift": Quantity(READING),
    "bias_shift_run_to_run": Quantity(READING),
    "residual_bias": Quantity(READING),
    "scatter_sample": Quantity(READING),
    "thermometer_slope": Quantity(("other",)),
    "thermometer_voltage": Quantity(("voltage",)),
    "temperature_error": Quantity(("temperature",)),
    "temperature_error_of_range": Quantity(RELATIVE, shown="%"),
    "thermometer_nonlinearity": Quantity(("temperature",)),
    "thermometer_lag": Quantity(("time",)),
    "temperature_lowest": Quantity(("temperature",)),
    "temperature_highest": Quantity(("temperature",)),
}


PLANNED = '--noise "0.2 deg/sqrt(h)" --coldest "-30 degC" --hottest "65 degC" --turn-on "0.005 deg/s"'


class Thermal(Procedure[Plan, "Readings", "Result"]):
    """Bias over temperature of a unit at rest."""

    name, kind_of_test = "thermal", "thermal test"
    title = "Bias over temperature of a unit at rest: polynomial, warming against cooling, start-up, power-ups."
    commands = (
        Command(
            "thermal",
            "Bias over temperature of a unit at rest: polynomial, warming against cooling, start-up, power-ups.",
            examples=('run1.csv run2.csv run3.csv --at "0 degC" --at "70 degC"', "run1.csv run2.csv run3.csv --plot"),
        ),
    )
    planner = Command(
        "thermal",
        "Runs, ramps and hours of a thermal test, and the uncertainty of the bias over temperature.",
        examples=(f"{PLANNED} --wanted bias='0.003 deg/s'", f'{PLANNED} --available "72 h"'),
    )
    planner_type = PlannedRamps
    plan_type, influences = Plan, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "hold_out", "report_only"})
    gives = ("bias", "hysteresis")
    corrects = "bias"
    set_against = judged_alone = True
    compensated = ("bias",)
    no_corrections = "it finds the bias itself, at all its temperatures: what was taken off would be found again"
    counts_dwells = False
    inputs = InputSpec(
        ("gyro", "accelerometer"),
        (
            Role("temperature", "temperature", "degC", required=True),
            Role("pressure", "pressure", "Pa", by_axis=False),
            Role("reference_temperature", "temperature", "degC", by_axis=False),
        ),
        voltages=True,
        by_body=True,
        still=True,
        streamed=True,
    )

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return what sensor and site say, thermometers as the plan has them."""
        from ...core.units import same_dimension

        own = facts.thermometers
        known = None if own is None else {axis: Thermometer(*one) for axis, one in own.items()}
        spoken = facts.unit if facts.unit and same_dimension(facts.unit, facts.si) else ""
        return super().plan_fields(facts) | {"thermometers": known, "unit": spoken}

    def planned(self, given: Mapping[str, Any]) -> TestPlan:
        """Return what a test will give."""
        from .planning import planned

        return planned(given)

    def rehearsed(self, given: Mapping[str, Any], schedule: Table, seed: int) -> Rehearsal:
        """Return what a schedule gives on a simulated unit."""
        from ..planned import settings_said
        from .planning import known_of
        from .rehearsal import rehearse

        return rehearse(known_of(*settings_said(PlannedRamps, given, options=True)), schedule, seed)

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the recordings of all sources."""
        from .recordings import ThermalRecording, readings_from

        warmed = [ThermalRecording(one, source.run, source.name) for source in sources
                  for _, one in source.recordings()]  # fmt: skip
        return readings_from(warmed, sources[0].facts.si)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the bias over temperature."""
        from .reduction import reduce

        return reduce(plan, readings)

    def reduce_many(self, tests: Sequence[tuple[Plan, Readings]]) -> list[Result | InertialcalError]:
        """Return the result of each unit, or its refusal; sensors that are alike are fitted at once."""
        from .reduction import reduce_many

        return reduce_many(tests)

    def correction(self, test: str, result: Result) -> Correction:
        """Return the bias over temperature, to be taken off."""
        from .correction import ThermalCorrection

        return ThermalCorrection(test, result)

    def terms(self, result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
        """Return the bias over temperature, hysteresis, and the scatter between power-ups."""
        from .terms import model_terms

        return model_terms(result, tests)

    def terms_many(
        self, given: Sequence[tuple[Result, Sequence[Tested[Plan, Readings, Result]]]]
    ) -> list[ModelTerms | None]:
        """Return the same of many results at once."""
        from .terms import model_terms_many

        return model_terms_many(given)

    def held_out(
        self,
        result: Result,
        fitted: Sequence[Tested[Plan, Readings, Result]],
        held: Sequence[Tested[Plan, Readings, Result]],
        model: SensorModel | None,
    ) -> HeldOut:
        """Return what the polynomial of one test leaves of the bias on power-ups of another of the same condition."""
        from ..model_terms import HeldOut
        from .held_out.closed_loop import held_out, loops, overlays, residual_rows

        (own,), (other,) = fitted, held
        judged = model if result.readings.unit == "rad/s" else None  # of accelerometers the level holds gravity
        residuals = held_out(result, other.result, own.occasion.remounted(other.occasion), judged)
        first, second = (result, None) if own.against is None else (own.against.result, result)
        rows = residual_rows(residuals, other.result.readings.unit, own.id)
        return HeldOut(loops(residuals, other.result.readings.unit), tuple(rows), overlays(other.result, first, second))

    def against(self, test: Tested[Plan, Readings, Result], other: Tested[Any, Any, Any]) -> Sequence[Row]:
        """Return the bias that one condition has more than the other."""
        from .against import offset_rows, quantity_of

        occasions = (test.occasion, other.occasion)
        return offset_rows(test.result, other.result, other.id, quantity_of(test.condition), occasions)

    def exclusions(self, test: Tested[Plan, Readings, Result]) -> Iterator[Exclusion]:
        """Yield the samples that no cell was made of, by rule."""
        from .fit.sensor import WORDS

        for axis, one in test.result.sensors.items():
            decided = {
                "warm_up": f"rule: warm_up = {one.start_up.cut:.4g} s",
                "turn_over": f"rule: turn_over = {one.series.turn_over:.4g} degC",
            }
            for rule in (rule for rule in RULES if one.cells.left_out.get(rule)):
                count, by = one.cells.left_out[rule], decided.get(rule, f"rule: {rule}")
                yield Exclusion(rule, by, WORDS[rule], axis=axis, count=count, counts="sample")

    def quantities(self) -> Mapping[str, Quantity]:
        """Return what there is to say of its figures."""
        return QUANTITIES

    def judge(
        self, asked: Asked, tests: Sequence[Tested[Plan, Readings, Result]]
    ) -> tuple[list[Verdict], list[Row]] | None:
        """Return the verdicts on figures over a range of temperatures; others are judged by the general rule."""
        from .over_temperature import CHANGE, judge_bias
        from .thermometer import ERROR, ERROR_OF_RANGE, judge_error

        if asked.quantity in (ERROR, ERROR_OF_RANGE):
            return list(judge_error(asked, tests)), []
        over = asked.quantity == CHANGE or (asked.quantity == "bias" and asked.where)
        return (list(judge_bias(asked, tests)), []) if over else None

    def judge_compensated(
        self, asked: Asked, test: Tested[Plan, Readings, Result], model: SensorModel
    ) -> list[tuple[Verdict, Verdict | None]]:
        """Return the verdicts on the bias over temperature less that of a model, each with that on the bias as read."""
        from .over_temperature import judge_less

        return list(judge_less(asked, test, model))

    def needs(self, influence: str, result: Result) -> bool:
        """Return whether an influence would change this result; the latitude, where the attitude is known too."""
        from .rows import needed

        known = result.plan.attitude is not None and result.plan.latitude is not None
        return influence in needed(result.plan) or (influence == LATITUDE and known)

    def effects(self) -> Mapping[str, str]:
        """Return what each influence changes."""
        return {**self.influences, LATITUDE: "earth rate along the axes"}

    def truths(self, result: Result) -> Sequence[Row]:
        """Return all rows: those against another test say more than the estimate."""
        return result.rows()

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return what a test found, as one sentence."""
        from .finding import finding

        return finding(rows)

    def check(self, test: SaidTest) -> Iterator[Problem]:
        """Yield an attitude without a latitude, and limits in the unit of another kind of sensor."""
        yield from latitude_needed(test)
        yield from reading_units(test, ("settled", "no_hysteresis"))

    def suggests(self, recording: Recording, survey: Survey) -> Suggestion | None:
        """Return the command to type next."""
        from .suggest import suggests

        return suggests(recording, survey)

    def claims(self, file: FolderFile) -> Claim | None:
        """Claim a recording of sensors whose temperature was made to change."""
        from .suggest import claims

        return claims(file)

    def draft(self, contents: Mapping[str, object]) -> Draft:
        """Return the sensors and tests over temperature of a first campaign."""
        from .suggest import draft

        return draft(contents)


PROCEDURE = Thermal()
