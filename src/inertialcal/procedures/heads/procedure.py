"""The procedure ``heads``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..protocol import (
    OF_MOUNTING,
    READING,
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
from .plan import Plan, SaidBody

if TYPE_CHECKING:
    from ...core.errors import Problem
    from ...core.judging import Asked, Verdict
    from ...core.recording import Recording
    from ...core.remarks import Remark
    from ...core.results import Row, WrittenRow
    from ...core.show.rows import Sentence
    from ...files.info.survey import Survey
    from ..entries import Entry, EntryKey, SaidTest
    from ..given import Described, GivenFile
    from ..suggestions import Claim, Draft, FolderFile, Suggestion
    from .readings import Readings
    from .reduction import Result

QUANTITIES = {
    "relative_bias": Quantity(READING),
    "bias": Quantity(READING),
    "scale_factor_error": Quantity(RELATIVE, shown="%"),
    "misalignment": Quantity(("angle",), redrawn_by=OF_MOUNTING),
    "uncertainty_growth": Quantity(("dimensionless",), unit="1"),
    "off_line_distance": Quantity(("length",), unit="m", shown="m"),
    "off_line_uncertainty": Quantity(READING),
}
THREE = "body/recordings/tsh1.csv body/recordings/tsh2.csv body/recordings/tsh3.csv body/recordings/gyro.csv"


class Heads(Procedure[Plan, "Readings", "Result"]):
    """Bias of heads from calibrated ones on the same body."""

    name, kind_of_test = "heads", "calibration of heads by others"
    title = "Bias of an accelerometer head from two or more that are calibrated, on the same rigid body."
    commands = (
        Command(
            "heads",
            title,
            examples=(f"{THREE} --body body/body.toml", f"{THREE} --body body/body.toml -o gap.png"),
        ),
    )
    plan_type, said_type = Plan, SaidBody
    figures = FIGURES
    uses = frozenset({"fit", "report_only"})
    counts_dwells = False
    changes = True
    no_corrections = "a bias that another test found belongs into the file of the body, with its uncertainty"
    inputs = InputSpec(("accelerometer", "gyro"), missing=True, several_sensors=True, screening="own")

    def split_label(self, given: str) -> tuple[str, str]:
        """Return the head that stands before a file, and the file."""
        from .given import split_label

        return split_label(given)

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return the head of a file, and its gyro."""
        from .given import described

        return described(given, self.inputs)

    def like(self, given: GivenFile, entry: Mapping[str, Any]) -> tuple[dict[str, Any], Sequence[Remark]]:
        """Return an entry of another campaign, with what is given of this file."""
        head = {**entry.get("head", {}), **({"file": given.own["body"]} if "body" in given.own else {})}
        head |= {"name": given.label} if given.label else {}
        return {**entry, **({"head": head} if "head" in entry else {})}, ()

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return nothing: the file of the body says what the test rests on."""
        return {}

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return what all heads read.

        Raises
        ------
        DataError
            As ``readings.readings_from``.
        """
        from .readings import readings_from

        return readings_from(sources)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return biases of the heads that are not calibrated."""
        from .reduction import reduce

        return reduce(plan, readings)

    def quantities(self) -> Mapping[str, Quantity]:
        """Return the figures that it can give."""
        return QUANTITIES

    def judge(
        self, asked: Asked, tests: Sequence[Tested[Plan, Readings, Result]]
    ) -> tuple[list[Verdict], list[Row]] | None:
        """Return verdicts on the figures of each head."""
        from .judging import judge

        return (judge(asked, tests), []) if asked.quantity in QUANTITIES else None

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return the largest bias, relative where there is no other."""
        from ...core.show.rows import largest_of

        return largest_of(("bias", "relative_bias"), rows) or ("No bias could be estimated",)

    def suggests(self, recording: Recording, survey: Survey) -> Suggestion | None:
        """Return the command to type next."""
        from .suggest import suggests

        return suggests(recording, survey)

    def claims(self, file: FolderFile) -> Claim | None:
        """Return how much a file of a folder is made for this test."""
        from .suggest import claims

        return claims(file)

    def belong_together(self, contents: Sequence[object]) -> bool:
        """Return whether claimed files are the heads of one body."""
        from .suggest import belong_together

        return belong_together(list(contents))

    def draft(self, contents: Mapping[str, object]) -> Draft:
        """Return heads, recordings and the test of them all."""
        from .suggest import draft

        return draft(contents)

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return the body of a head."""
        from .entry import KEYS

        return KEYS

    def check_recording(self, test: SaidTest, name: str, entry: Entry) -> Iterator[Problem]:
        """Yield a recording without a body."""
        from .entry import recording_problems

        yield from recording_problems(test, name, entry)


PROCEDURE = Heads()
