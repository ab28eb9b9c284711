"""The procedure ``sine_survey``: what it takes, what it says of its tests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..protocol import Command, Correction, Facts, InputSpec, Procedure, Quantity, Reduced, Role, Source, Tested
from .figures import FIGURES
from .plan import CONTROL, INFLUENCES, OfFile, Plan, PlannedSurvey

if TYPE_CHECKING:
    from ...core.errors import Problem
    from ...core.judging import Asked, Verdict
    from ...core.recording import Recording
    from ...core.results import Row, WrittenRow
    from ...core.show.rows import Sentence
    from ...files.info.survey import Survey
    from ..entries import SaidTest
    from ..given import Described, GivenFile
    from ..suggestions import Claim, Draft, FolderFile, Suggestion
    from .planning import SurveyPlan
    from .readings import Readings
    from .reduction import Result

RELATIVE = Quantity(("dimensionless",), unit="1", shown="%")
QUANTITIES = {
    "resonance_frequency": Quantity(("frequency",), unit="Hz", shown="Hz"),
    "amplification": Quantity(("dimensionless",), unit="1", shown="1"),
    "transmissibility": Quantity(("dimensionless", "other"), unit="1"),
    "resonance_frequency_change": RELATIVE,
    "amplification_change": RELATIVE,
    "transmissibility_change": RELATIVE,
    "sweep_start": Quantity(("frequency",), unit="Hz", shown="Hz"),
    "sweep_end": Quantity(("frequency",), unit="Hz", shown="Hz"),
    "sweep_rate": Quantity(("frequency", "other")),
    "drive_level": Quantity(("acceleration",), unit="m/s^2", shown="g"),
    "drive_distortion": RELATIVE,
}


class SineSurvey(Procedure[Plan, "Readings", "Result"]):
    """Resonances from a swept sine."""

    name, kind_of_test = "sine_survey", "sine survey"
    title = "Resonances of a vibrating item from a swept sine: frequency and amplification, before and after."
    commands = (
        Command(
            "vibration survey",
            title,
            examples=(
                'survey.csv --control "control [g]" --sweep "50 Hz to 500 Hz" --rate "20 oct/min"',
                "survey.csv -o survey.svg",
            ),
        ),
    )
    planner = Command(
        "vibration survey",
        "How long a sweep lasts, whether a mode follows it, how well the mode will be known.",
        "vibration_survey_plan",
        examples=('--sweep "20 Hz to 1000 Hz" --frequency "80 Hz" --amplification 30', '--rate "4 oct/min"'),
    )
    planner_type = PlannedSurvey
    plan_type, said_type, influences = Plan, OfFile, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "report_only"})
    counts_dwells = False
    set_against = True
    no_corrections = "a transmissibility has no bias that could be taken off"
    inputs = InputSpec(
        ("accelerometer", "gyro"),
        tuple(Role(name, "acceleration", "m/s^2", by_axis=False) for name in CONTROL),
        screening="own",
    )

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return a recording of a sensor on a shaker, with its control channels."""
        from .given import described

        return [described(given, self.inputs)]

    def quantities(self) -> Mapping[str, Quantity]:
        """Return what there is to say of its figures."""
        return QUANTITIES

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return the standards."""
        return {"standards": facts.standards}

    def plan(self, values: Mapping[str, Any], facts: Facts) -> Plan:
        """Return the plan of a test.

        Raises
        ------
        PlanError
            If the sweep that is stated is none.
        """
        made = super().plan(values, facts)
        _ = made.stated_range, made.stated_rate
        return made

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return control and responses of all recordings."""
        from .readings import readings_from

        return readings_from(sources)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return sweeps and modes."""
        from .reduction import reduce

        return reduce(plan, readings)

    def needs(self, influence: str, result: Result) -> bool:
        """Return whether an influence would change this result: a clock changes no survey without a mode."""
        return influence in self.influences and result.estimate is not None

    def against(self, test: Tested[Plan, Readings, Result], other: Tested[Any, Any, Any]) -> Sequence[Row]:
        """Return by how much modes changed since another survey."""
        from .against import change_rows

        return change_rows(test.result, other.result, other.id, (test.occasion, other.occasion))

    def judge(
        self, asked: Asked, tests: Sequence[Tested[Plan, Readings, Result]]
    ) -> tuple[list[Verdict], list[Row]] | None:
        """Return verdicts on modes and their changes, one for each mode."""
        from .judging import JUDGED, judge

        return (judge(asked, tests), []) if asked.quantity in JUDGED else None

    def truths(self, result: Result) -> Sequence[Row]:
        """Return the rows: modes have no joint estimate."""
        return result.rows()

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return the largest change, else the sharpest resonance."""
        from ...core.show.rows import Cited, Quoted

        words = {
            "resonance_frequency_change": "Largest change of a resonance ",
            "amplification": "Sharpest resonance, Q ",
        }
        for quantity, lead in words.items():
            found = [row for row in rows if row["quantity"] == quantity and row["value"] is not None]
            if found:
                largest = max(found, key=lambda row: abs(float(row["value"])))
                return (lead, Cited(largest), ", in ", Quoted(largest["axis"]))
        return ("No resonance could be estimated",)

    def summary(self, found: Reduced) -> str:
        """Return the sweeps that were found."""
        from .shown import summary

        return summary(found.result)

    def planned(self, given: Mapping[str, Any]) -> SurveyPlan:
        """Return how long a sweep lasts and what it will tell of a mode."""
        from .planning import planned

        return planned(given)

    def check(self, test: SaidTest) -> Iterator[Problem]:
        """Yield a sweep or a rate that is none."""
        from ...core.errors import PlanError, Problem
        from .plan import range_of, rate_of

        for name, read in (("sweep", range_of), ("rate", rate_of)):
            text = test.plan.get(name)
            if isinstance(text, str):
                try:
                    read(text)
                except PlanError as error:
                    where = test.at("tests", test.number, "plan", name)
                    yield from (Problem(one.what, where, one.why, one.do, one.code) for one in error.problems)

    def suggests(self, recording: Recording, survey: Survey) -> Suggestion | None:
        """Return the command to type next."""
        from .suggest import suggests

        return suggests(recording, survey)

    def claims(self, file: FolderFile) -> Claim | None:
        """Return how much a file of a folder is made for this test."""
        from .suggest import claims

        return claims(file)

    def draft(self, contents: Mapping[str, object]) -> Draft:
        """Return what a first campaign.toml says of them."""
        from .suggest import draft

        return draft(contents)


PROCEDURE = SineSurvey()
