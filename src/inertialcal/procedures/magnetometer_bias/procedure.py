"""The procedure ``magnetometer_bias``: what it takes, what it says of its tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

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
from .plan import INFLUENCES, Orbit, Plan, PlannedOrbits

if TYPE_CHECKING:
    from ...core.remarks import Remark
    from ...core.results import WrittenRow
    from ...core.show.rows import Sentence
    from ..entries import EntryKey
    from ..given import Described, GivenFile
    from ..model_terms import ModelTerms
    from ..planned import TestPlan
    from .entry import OrbitEntry
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
    planner = Command(
        "magnetometer-bias",
        "Orbits and sample interval of a gyro and a magnetometer in orbit, and uncertainty of the bias.",
        examples=(
            '--noise "0.2 deg/sqrt(h)" --wanted bias="0.001 deg/s" --simulate 0',
            '--noise "0.2 deg/sqrt(h)" --available "3 h" --motion nadir --simulate 0 --schedule schedule.csv',
        ),
    )
    planner_type = PlannedOrbits
    plan_type, said_type, influences = Plan, Orbit, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "report_only"})
    counts_dwells = False
    gives = ("bias",)
    takes_corrections = takes_matrix = changes = True
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

    def like(self, given: GivenFile, entry: Mapping[str, Any]) -> tuple[dict[str, Any], Sequence[Remark]]:
        """Return an entry of another campaign, with the elements that are given of this file."""
        from .given import like

        return like(given, entry), ()

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return the standards: all else is set."""
        return {"standards": facts.standards}

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return all recordings with the field of the earth along them.

        Raises
        ------
        DataError
            As ``readings.track``, ``readings.after``; ``terms_twice``.
        """
        from .readings import Readings, after, matrix_of, read_elements, track

        found, remarks, matrix = [], [], matrix_of(corrections)
        for source in sources:
            said = cast("OrbitEntry", source.entry).tle
            elements = None if said is None else (source.read_file(said.file, read_elements), said)
            for label, recording in source.recordings():
                name = label or source.name
                rates, off = after(recording, name, corrections, matrix)
                one = replace(track(rates, name, source.file, plan.epoch, elements), taken_off=off)
                remarks += [*rates.remarks, *([] if one.orbit is None else [one.orbit.remark])]
                found.append(one)
        return Readings(tuple(found), tuple(remarks), matrix)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the biases."""
        from .reduction import reduce

        return reduce(plan, readings)

    def planned(self, given: Mapping[str, Any]) -> TestPlan:
        """Return what a record will give."""
        from .planning import planned

        return planned(given)

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return ``tle``."""
        from .entry import KEYS

        return KEYS

    def needs(self, influence: str, result: Result) -> bool:
        """Return whether an influence would change this result: the matrix of the gyro does where none was found."""
        return influence in self.influences and influence not in result.taken_off

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
