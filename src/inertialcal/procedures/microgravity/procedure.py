"""The procedure ``microgravity``: what it takes, what it says of its tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..protocol import (
    LASTS,
    RELATIVE,
    Command,
    Correction,
    Facts,
    InputSpec,
    Procedure,
    Quantity,
    Source,
    Tested,
)
from .figures import FIGURES
from .plan import (
    INFLUENCES,
    INTERVAL_MEAN,
    MAGNITUDE,
    ORBITAL,
    PERIOD,
    PERPENDICULAR,
    RATIO,
    SLOW,
    VIBRATORY,
    OfFile,
    Plan,
)

if TYPE_CHECKING:
    from pathlib import Path

    from ...core.judging import Asked, Verdict
    from ...core.recording import Recording
    from ...core.remarks import Remark
    from ...core.results import Interval, Row, WrittenRow
    from ...core.show.rows import Sentence
    from ...files.info.survey import Survey
    from ..entries import EntryKey
    from ..given import Described, GivenFile
    from ..suggestions import Claim, Draft, FolderFile, Suggestion
    from .readings import Readings
    from .reduction import Result

ACCELERATION = ("acceleration",)
QUANTITIES = {
    VIBRATORY: Quantity(ACCELERATION, size=True, unit="m/s^2", shown="ug", redrawn_by=LASTS),
    RATIO: Quantity(RELATIVE, size=True, unit="1", shown="1", redrawn_by=LASTS),
    SLOW: Quantity(ACCELERATION, unit="m/s^2", shown="ug", redrawn_by=LASTS),
    MAGNITUDE: Quantity(ACCELERATION, size=True, unit="m/s^2", shown="ug", redrawn_by=LASTS),
    PERPENDICULAR: Quantity(ACCELERATION, size=True, unit="m/s^2", shown="ug", redrawn_by=LASTS),
    INTERVAL_MEAN: Quantity(ACCELERATION, unit="m/s^2", shown="ug", redrawn_by=LASTS),
    ORBITAL: Quantity(ACCELERATION, size=True, unit="m/s^2", shown="ug", redrawn_by=LASTS),
    PERIOD: Quantity(("time",), unit="s", shown="min", redrawn_by=None),
}


class Microgravity(Procedure[Plan, "Readings", "Result"]):
    """Acceleration environment in orbit."""

    name, kind_of_test = "microgravity", "record of the environment"
    title = "Acceleration environment in orbit: levels by third of an octave, slow acceleration, spectrogram."
    commands = (
        Command(
            "microgravity",
            title,
            examples=(
                "station/recordings/record.csv --curve station/curve.csv --cut-off '8 Hz' -o bands.png",
                "station/recordings/record.csv --cut-off '8 Hz' --bias-x '20 ug' --bias-y '-35 ug' --bias-z '8 ug'"
                " --bias-u '0.2 ug' --slow-limit '1 ug'",
            ),
        ),
    )
    plan_type, said_type, influences = Plan, OfFile, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "report_only"})
    counts_dwells = False
    takes_corrections = changes = True
    inputs = InputSpec(("accelerometer",), missing=True, windows="records", screening="own", streamed=True)

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return the accelerometer of a file, the curve and the limits."""
        from .given import described

        return [described(given, self.inputs)]

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return ``curve``."""
        from .entry import KEYS

        return KEYS

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return the standards: all else is set."""
        return {"standards": facts.standards}

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return all records, in order of time."""
        from .readings import readings_from

        return readings_from(plan, sources, corrections)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return levels and the slow acceleration."""
        from .reduction import reduce

        return reduce(plan, readings)

    def quantities(self) -> Mapping[str, Quantity]:
        """Return the figures that it can give."""
        return QUANTITIES

    def judge(
        self, asked: Asked, tests: Sequence[Tested[Plan, Readings, Result]]
    ) -> tuple[list[Verdict], list[Row]] | None:
        """Return verdicts on the curve: all bands together, and none over blocks shorter than it asks."""
        if asked.quantity != RATIO:
            return None
        from .judging import judge_curve

        return judge_curve(asked, tests), []

    def interval_at(self, result: Result, row: Row, p: float) -> Interval | None:
        """Return the interval of a level, or of a size of the slow acceleration."""
        from .rows import interval_at

        found = interval_at(result, row, p)
        return super().interval_at(result, row, p) if found is None else found

    def truths(self, result: Result) -> Sequence[Row]:
        """Return the rows: levels stand in no joint estimate."""
        return result.rows()

    def suggests(self, recording: Recording, survey: Survey) -> Suggestion | None:
        """Return the command to type next."""
        from .suggest import suggests

        return suggests(recording, survey)

    def found_in(self, root: Path) -> tuple[dict[str, object], list[Remark]]:
        """Return the archive records of a folder in which the head did not turn."""
        from ..archived import found_in
        from .suggest import in_archive

        found, _ = found_in(root, in_archive)  # what cannot be read was said for the flip
        return dict(found), []

    def claims(self, file: FolderFile) -> Claim | None:
        """Return how well a file of a folder fits this test."""
        from .suggest import claims

        return claims(file)

    def draft(self, contents: Mapping[str, object]) -> Draft:
        """Return the tables of a first campaign.toml."""
        from .suggest import draft

        return draft(contents)

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return level, distance from the curve and slow acceleration."""
        from .rows import finding

        return finding(rows)


PROCEDURE = Microgravity()
