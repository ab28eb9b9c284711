"""The procedure ``vibration_effects``: what it takes, what it says of its tests."""

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
    Role,
    Source,
)
from .figures import FIGURES
from .plan import INFLUENCES, Direction, Plan

if TYPE_CHECKING:
    from ...core.recording import Recording
    from ...core.remarks import Remark
    from ...core.results import Row, WrittenRow
    from ...core.show.rows import Sentence
    from ...files.info.survey import Survey
    from ..given import Described, GivenFile
    from ..suggestions import Claim, Draft, FolderFile, Suggestion
    from .readings import Readings
    from .reduction import Result

QUANTITIES = {
    "vibration_rectification": Quantity(
        ("other",), shown_by_kind={"gyro": "deg/h/g^2", "accelerometer": "ug/g^2"}, redrawn_by=LASTS
    ),
    "vibration_rectification_curvature": Quantity(
        ("other",), shown_by_kind={"gyro": "deg/h/g^4", "accelerometer": "ug/g^4"}, redrawn_by=LASTS
    ),
    "vibration_sensitivity": Quantity(
        ("other", "dimensionless"), size=True, shown_by_kind={"gyro": "deg/h/g"}, redrawn_by=LASTS
    ),
    "vibration_noise_ratio": Quantity(RELATIVE, size=True, redrawn_by=None),
    "control_rms": Quantity(("acceleration",), size=True, shown="g", redrawn_by=None),
}


class VibrationEffects(Procedure[Plan, "Readings", "Result"]):
    """What vibration does to bias and noise of a sensor."""

    name, kind_of_test = "vibration_effects", "test of vibration effects"
    title = "What vibration does to bias and noise: rectification against g rms^2, g-sensitivity by frequency, noise."
    commands = (
        Command(
            "vibration effects",
            "What vibration does to bias and noise: rectification against g rms^2, g-sensitivity by frequency, noise.",
            examples=("shaken.csv --column control=control", "shaken.csv --axis z -o rectification.png"),
        ),
    )
    plan_type, said_type, influences = Plan, Direction, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "report_only"})
    counts_dwells = False
    changes = True
    inputs = InputSpec(
        ("gyro", "accelerometer"),
        (
            Role("control", "acceleration", "m/s^2", by_axis=False),
            Role("control_rms", "acceleration", "m/s^2", by_axis=False),
        ),
        missing=True,
        screening="own",
        windows="records",
    )

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return the sensor of a file, the acceleration of the control, and the direction of vibration."""
        from .given import described

        return [described(given, self.inputs)]

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return nothing: all of it is set."""
        return {}

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the runs of all sources."""
        from .readings import Readings, vibrated

        found, remarks = [], []
        for source in sources:
            axis, run = source.entry.axis or "", source.run
            for label, recording in source.recordings():
                remarks += list(recording.remarks)
                name, facts = label or source.name, source.facts
                found.append(vibrated(recording, name, source.file, axis, facts.cut_off, run, facts.si))
        return Readings(tuple(found), sources[0].facts.si, tuple(remarks))

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return what vibration does to each axis."""
        from .reduction import reduce

        return reduce(plan, readings)

    def agreement(self, plan: Plan, readings: Readings) -> Sequence[Remark]:
        """Return which columns have changed places."""
        from .reduction import disagreements

        return disagreements(plan, readings)

    def quantities(self) -> Mapping[str, Quantity]:
        """Return the figures that it can give."""
        return QUANTITIES

    def truths(self, result: Result) -> Sequence[Row]:
        """Return all rows: those of bands have intervals of their own."""
        return result.rows()

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return the largest rectification."""
        from ...core.show.rows import largest_of

        return largest_of(("vibration_rectification",), rows) or ("No rectification could be estimated",)

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


PROCEDURE = VibrationEffects()
