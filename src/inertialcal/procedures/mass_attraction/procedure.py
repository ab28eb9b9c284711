"""The procedure ``mass_attraction``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

from ..protocol import (
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
from .plan import INFLUENCES, Plan, SaidMass

if TYPE_CHECKING:
    from ...core.errors import Problem
    from ...core.remarks import Remark
    from ...core.results import WrittenRow
    from ...core.show.rows import Sentence
    from ..entries import Entry, EntryKey, SaidSensor, SaidTest
    from ..given import Described, GivenFile
    from ..model_terms import ModelTerms
    from .entry import MassEntry
    from .readings import Readings
    from .reduction import Result

QUANTITIES = {
    "scale_factor": Quantity(("other",)),
    "high_g_difference": Quantity(RELATIVE, shown="%"),
    "null_response": Quantity(READING),
    "scale_factor_error": Quantity(RELATIVE, shown="%"),
    "response_amplitude": Quantity(("other",)),
    "quadrature_amplitude": Quantity(("other",)),
    "tilt_amplitude": Quantity(("angle",)),
}

MOVED = (
    "moved/recordings/run1.csv moved/recordings/run2.csv moved/recordings/null1.csv --null null1 --schedule"
    ' moved/schedule.csv --column x=pulses --column tilt=tilt_rad --gate "100 s" --tilt known'
    ' --mercury "9.2e-10 rad" --scale-factor "10.21 count/s/ug"'
)


class MassAttraction(Procedure[Plan, "Readings", "Result"]):
    """Scale factor of an accelerometer from the attraction of a moved mass."""

    name = "mass_attraction"
    title = "Scale factor of an accelerometer from the attraction of a moved mass."
    commands = (
        Command(
            "mass-attraction",
            "Scale factor from a moved mass: its line in the drift, with the uncertainty of noise and of runs.",
            examples=(MOVED, f"{MOVED} --plot"),
        ),
    )
    planner = Command(
        "mass-attraction",
        "Source mass, drive, budget, and uncertainty of the scale factor against hours.",
        examples=("moved.toml --schedule schedule.csv", '--set "orbit.mass=4 kg" --set "orbit.stand_off=10.2 cm"'),
    )
    plan_type, said_type, influences = Plan, SaidMass, INFLUENCES
    kind_of_test = "mass attraction"
    gives = ("scale_factor",)
    takes_corrections = True
    figures = FIGURES
    inputs = InputSpec(
        ("accelerometer",),
        (Role("tilt", "angle", "rad", by_axis=False), Role("temperature", "temperature", "degC", by_axis=False)),
        table="lines",
        missing=True,
        windows="refused",
        pulses=True,
        raw=True,
    )

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return the channels of a record, with the schedule of the mass."""
        from .given import described

        return [described(given, self.inputs)]

    def like(self, given: GivenFile, entry: Mapping[str, Any]) -> tuple[dict[str, Any], Sequence[Remark]]:
        """Return an entry of another campaign, with what is given of this file."""
        from .given import like

        return like(given, entry), ()

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return the input axis and the scale factor of the data sheet, with the standards."""
        own = {"output_unit": facts.output_unit, "nominal": facts.output_scale_factor}
        return {"axis": facts.axes[0], "standards": facts.standards, **own}

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the runs: recordings with their schedules, and tables reduced before."""
        from ...core.errors import DataError
        from .readings import lines_of, moved_mass, readings_from

        moved, lines = [], []
        for source in sources:
            if not source.is_table:
                moved.append(moved_mass(source, corrections))
                continue
            columns = cast("MassEntry", source.entry).lines
            assert columns is not None  # noqa: S101 - as the file was checked
            found = lines_of(source.table(), columns, source.file, source.facts.output_unit)
            chosen = [one for one in found if source.groups is None or one.name in source.groups]
            source.chose(len(chosen))
            lines += chosen
        if not moved and not lines:
            raise DataError(f"test {sources[0].test!r}: no row belongs to its groups", code="nothing_left")
        return replace(readings_from(plan, moved), lines=tuple(lines))

    def agreement(self, plan: Plan, readings: Readings) -> Sequence[Remark]:
        """Return runs that disagree with the others, jumps, and changes of gain."""
        from .agreement import agreement

        return agreement(plan, readings)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the scale factor."""
        from .reduction import reduce

        return reduce(plan, readings)

    def terms(self, result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
        """Return the scale factor of the axis along the mass."""
        from .reduction import model_terms

        return model_terms(result, tests)

    def without_model(self, plan: Plan) -> str:
        """Return how to say the scale factor whose error a model holds."""
        return "" if plan.nominal else 'A model holds the error of a nominal scale factor: --scale-factor "NUMBER UNIT"'

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return the scale factor, its difference from that at high g, and the largest null response as a sentence."""
        from ...core.results import case_of
        from ...core.show.rows import Cited, estimated, largest
        from ...core.show.wording import counted

        runs = {case_of(row): row for row in rows if row["quantity"] == "response_amplitude"}
        found = largest(estimated(rows, "scale_factor"))
        if found is None:
            return (f"The response of {counted(len(runs), 'run')} cannot be told from noise",)
        sentence: Sentence = (
            "Scale factor ",
            Cited(found),
            " from ",
            counted(len(runs), "run"),
            " with the mass moved",
        )
        difference = largest(estimated(rows, "high_g_difference"))
        if difference is not None:
            sentence = (*sentence, "; ", Cited(difference), " off that at high g")
        null = largest([row for row in rows if row["quantity"] == "null_response" and row["value"] is not None])
        return sentence if null is None else (*sentence, "; with the mass at rest at most ", Cited(null))

    def quantities(self) -> Mapping[str, Quantity]:
        """Return kinds and units of its figures."""
        return QUANTITIES

    def needs(self, influence: str, result: Result) -> bool:
        """Return False: the table of standards lists only what is stated, until results schema 2."""
        return False

    def effects(self) -> Mapping[str, str]:
        """Return nothing: the table of standards does not say what they change, until results schema 2."""
        return {}

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return ``lines`` and ``mass``."""
        from .entry import KEYS

        return KEYS

    def check_recording(self, test: SaidTest, name: str, entry: Entry) -> Iterator[Problem]:
        """Yield a recording without a schedule of the mass."""
        from .entry import recording_problems

        return recording_problems(test, name, entry)

    def check_entry(self, name: str, entry: Entry, sensor: SaidSensor, at: Callable[..., str]) -> Iterator[Problem]:
        """Yield columns of a reduced table that do not fit the sensor."""
        from .entry import entry_problems

        return entry_problems(name, entry, sensor, at)


PROCEDURE = MassAttraction()
