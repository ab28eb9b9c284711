"""The procedure ``vibration``: what it takes, what it says of its runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

from ..protocol import (
    RELATIVE,
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
from .plan import (
    CONTROLS,
    DEVIATION,
    DURATION,
    INFLUENCES,
    KURTOSIS,
    LEVEL,
    LEVEL_DEVIATION,
    RATE_LEVEL,
    OfFile,
    Plan,
    PlannedRun,
)

if TYPE_CHECKING:
    from ...core.errors import Problem
    from ...core.judging import Asked, Verdict
    from ...core.recording import Recording
    from ...core.remarks import Remark
    from ...core.results import Interval, Row, WrittenRow
    from ...core.show.rows import Sentence
    from ...files.info.survey import Survey
    from ..entries import Entry, EntryKey, SaidTest
    from ..given import Described, GivenFile
    from ..protocol import Planned, Reduced
    from ..suggestions import Claim, Draft, FolderFile, Suggestion
    from .entry import VibrationEntry
    from .readings import Readings
    from .reduction import Result

QUANTITIES = {
    DEVIATION: Quantity(("other",), over="frequency", unit="dB", shown="dB"),
    LEVEL: Quantity(("acceleration",), size=True, unit="m/s^2", shown="g"),
    RATE_LEVEL: Quantity(("angular_rate",), size=True, unit="rad/s", shown="deg/s"),
    LEVEL_DEVIATION: Quantity(RELATIVE, unit="1", shown="%"),
    DURATION: Quantity(("time",), unit="s", shown="s"),
    KURTOSIS: Quantity(RELATIVE, unit="1", shown="1"),
}


class Vibration(Procedure[Plan, "Readings", "Result"]):
    """Random vibration to a profile."""

    name, kind_of_test = "vibration", "random vibration"
    title = "Random vibration against its profile: spectrum, overall level, duration, and what breaks a run."
    commands = (
        Command(
            "vibration",
            title,
            examples=(
                'run.csv --profile workmanship.csv --control control_1 --tolerance "3 dB" --overall "10 %"',
                "run.csv --profile workmanship.csv --control control_1 --control control_2 -o run.svg",
            ),
        ),
    )
    planner = Command(
        "vibration",
        "Duration and resolution of a run for a wanted chance of a verdict.",
        "vibration_plan",
        examples=(
            '--profile workmanship.csv --tolerance "3 dB" -o plan.svg',
            '--profile workmanship.csv --duration "60 s"',
        ),
    )
    planner_type = PlannedRun
    plan_type, said_type, influences = Plan, OfFile, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "report_only"})
    counts_dwells = False
    no_corrections = "its levels are of what was read: a bias taken off changes none of them"
    inputs = InputSpec(
        ("accelerometer", "gyro"),
        tuple(Role(name, "acceleration", "m/s^2", by_axis=False) for name in CONTROLS),
        missing=True,
        screening="own",
    )

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return a run: control channels, responses, profile, tolerances."""
        from .given import described

        return [described(given, self.inputs)]

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return ``profile``."""
        from .entry import KEYS

        return KEYS

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the run of a test."""
        from .readings import readings_from

        return readings_from(plan, sources)

    def agreement(self, plan: Plan, readings: Readings) -> Sequence[Remark]:
        """Return channels that cannot be what they are called, and what must not be judged."""
        from .reduction import reduce

        return reduce(plan, readings).errors

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the run against its profile."""
        from .reduction import reduce

        return reduce(plan, readings)

    def quantities(self) -> Mapping[str, Quantity]:
        """Return what there is to say of its figures."""
        return QUANTITIES

    def exclusions(self, test: Tested[Plan, Readings, Result]) -> Iterator[Exclusion]:
        """Yield the samples below full level."""
        n = len(test.readings)
        used = int(test.result.levels.samples(n).sum())
        if used < n:
            why = "not at full level, or beside a change of level"
            yield Exclusion("level", "rule: full level", why, count=n - used, counts="sample")

    def needs(self, influence: str, result: Result) -> bool:
        """Return whether an influence would change this result."""
        named = {one.influence for one in result.powers().values()}
        return influence in named

    def judge(
        self, asked: Asked, tests: Sequence[Tested[Plan, Readings, Result]]
    ) -> tuple[list[Verdict], list[Row]] | None:
        """Return verdicts on the lines of a spectrum together, and on an overall level that stepped up."""
        if asked.quantity not in (DEVIATION, LEVEL_DEVIATION):
            return None
        from .judging import judge_level, judge_lines

        found = judge_lines(asked, tests) if asked.quantity == DEVIATION else judge_level(asked, tests)
        return None if found is None else (found, [])

    def interval_at(self, result: Result, row: Row, p: float) -> Interval | None:
        """Return the interval of a level."""
        one = result.powers().get(row.key)
        return super().interval_at(result, row, p) if one is None else one.interval(p)

    def truths(self, result: Result) -> Sequence[Row]:
        """Return the rows: there is no joint estimate."""
        return result.rows()

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return what a run was, as one sentence."""
        from .rows import finding

        return finding(rows)

    def summary(self, found: Reduced) -> str:
        """Return lines, bandwidth and degrees of freedom of the spectrum."""
        from .shown import summary

        return summary(found.result)

    def planned(self, given: Mapping[str, Any]) -> Planned:
        """Return what a run will give."""
        from .planning import planned

        return planned(given)

    def check_recording(self, test: SaidTest, name: str, entry: Entry) -> Iterator[Problem]:
        """Yield a run without a profile."""
        from ...core.errors import Problem

        if cast("VibrationEntry", entry).profile is None:
            what = f"recordings.{name}: no profile"
            do = 'Say profile = "FILE.csv"'
            yield Problem(what, test.at("recordings", name), "a run is judged against one", do, "missing_key")

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


PROCEDURE = Vibration()
