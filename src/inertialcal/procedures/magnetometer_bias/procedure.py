"""The procedure ``magnetometer_bias``: what it takes, what it says of its tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
    Role,
    Source,
    Tested,
)
from .figures import FIGURES
from .plan import INFLUENCES, Orbit, Plan

if TYPE_CHECKING:
    from ...core.results import WrittenRow
    from ...core.show.rows import Sentence
    from ..given import Described, GivenFile
    from ..model_terms import ModelTerms
    from .readings import Readings
    from .reduction import Result

QUANTITIES = {
    "bias": Quantity(READING),
    "magnetometer_bias": Quantity(("other",), shown="nT"),
    "magnetometer_scale_factor_error": Quantity(RELATIVE, shown="%", redrawn_by=OF_MOUNTING),
    "field_residual": Quantity(("other",), size=True, shown="nT", redrawn_by=None),
}


class MagnetometerBias(Procedure[Plan, "Readings", "Result"]):
    """Bias of a gyro in orbit from a magnetometer."""

    name, kind_of_test = "magnetometer_bias", "test against a magnetometer"
    title = "Bias of a gyro in orbit from a magnetometer and the field of the earth; no attitude is needed."
    commands = (
        Command(
            "magnetometer-bias",
            "Bias of a gyro in orbit from a magnetometer and the field of the earth; no attitude is needed.",
            examples=(
                "orbit/recordings/orbit.csv -o known.png",
                'orbit/recordings/orbit.csv --arc "600 s" --magnetometer-model scale_factor',
            ),
        ),
    )
    plan_type, said_type, influences = Plan, Orbit, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "report_only"})
    counts_dwells = False
    gives = ("bias",)
    no_corrections = "what they leave unknown of the bias would not be in its uncertainty"
    changes = True
    inputs = InputSpec(
        ("gyro",),
        (
            Role("magnetometer", "other", "T"),
            Role("position", "length", "m"),
            Role("latitude", "angle", "rad", by_axis=False),
            Role("longitude", "angle", "rad", by_axis=False),
            Role("height", "length", "m", by_axis=False),
        ),
        missing=True,
        windows="records",
    )

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return the gyro of a file, the magnetometer, and where the spacecraft was."""
        from .given import described

        return [described(given, self.inputs)]

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return the standards: all else is set."""
        return {"standards": facts.standards}

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return all recordings with the field of the earth along them.

        Raises
        ------
        DataError
            As ``readings.track``.
        """
        from .readings import Readings, track

        found, remarks = [], []
        for source in sources:
            for label, recording in source.recordings():
                remarks += list(recording.remarks)
                found.append(track(recording, label or source.name, source.file, plan.epoch))
        return Readings(tuple(found), tuple(remarks))

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the biases."""
        from .reduction import reduce

        return reduce(plan, readings)

    def quantities(self) -> Mapping[str, Quantity]:
        """Return the figures that it can give."""
        return QUANTITIES

    def terms(self, result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
        """Return the bias in orbit."""
        from .terms import model_terms

        return model_terms(result, tests)

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return the largest bias."""
        from ...core.show.rows import largest_of

        return largest_of(("bias",), rows) or ("No bias could be estimated",)


PROCEDURE = MagnetometerBias()
