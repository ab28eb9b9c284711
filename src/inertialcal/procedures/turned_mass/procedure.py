"""The procedure ``turned_mass``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..protocol import READING, RELATIVE, Command, Correction, Facts, InputSpec, Procedure, Quantity, Source, Tested
from .figures import FIGURES
from .plan import INFLUENCES, SATELLITE, Plan, PlannedTurns, SaidTurn

if TYPE_CHECKING:
    from ...core.errors import Problem
    from ...core.remarks import Remark
    from ...core.results import WrittenRow
    from ...core.show.rows import Sentence
    from ..entries import Entry, EntryKey, SaidTest
    from ..given import Described, GivenFile
    from ..model_terms import ModelTerms
    from .planning import TurnedPlan
    from .readings import Readings
    from .reduction import Result

QUANTITIES = {
    "scale_factor": Quantity(("other",)),
    "scale_factor_error": Quantity(RELATIVE, shown="%"),
    "high_g_difference": Quantity(RELATIVE, shown="%"),
    "recoil_arm": Quantity(("length",), unit="m", shown="mm"),
    "recoil_difference": Quantity(RELATIVE, shown="%"),
    "axis_offset": Quantity(("length",), unit="m", shown="mm"),
    "axis_offset_across": Quantity(("length",), unit="m", shown="mm"),
    "angle_zero": Quantity(("angle",), unit="rad", shown="deg"),
    "response_amplitude": Quantity(("other",)),
    "quadrature_amplitude": Quantity(("other",)),
    "bias": Quantity(READING),
    "second_order": Quantity(("other",)),
    "third_order": Quantity(("other",)),
}

TURNED = (
    "turned/recordings/run1.csv turned/recordings/run2.csv turned/recordings/run3.csv --schedule turned/schedule.csv"
    ' --column x=pulses --gate "100 s" --mass "4 kg" --radius "0.2 m" --altitude "560 km"'
    ' --scale-factor "10.21 count/s/ug"'
)


class TurnedMass(Procedure[Plan, "Readings", "Result"]):
    """Scale factor of an accelerometer in orbit from a mass that is turned around it."""

    name, kind_of_test = "turned_mass", "turned mass"
    title = "Scale factor of an accelerometer in orbit from a mass that is turned around it, and the recoil."
    commands = (Command("turned-mass", title, examples=(TURNED, f"{TURNED} --plot")),)
    planner = Command(
        "turned-mass",
        "Rates and senses of a turned mass, hours, the null of recoil, and uncertainty of the scale factor.",
        examples=('--periods "1 h" --periods "2 h" --hours "24 h"', '--wanted "1 %" --schedule schedule.csv'),
    )
    planner_type = PlannedTurns
    plan_type, said_type, influences = Plan, SaidTurn, INFLUENCES
    gives = ("scale_factor",)
    takes_corrections = True
    counts_dwells = False
    figures = FIGURES
    inputs = InputSpec(("accelerometer",), missing=True, windows="refused", pulses=True)

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return the channels of a record, with the programme of the mass."""
        from .given import described

        return [described(given, self.inputs)]

    def like(self, given: GivenFile, entry: Mapping[str, Any]) -> tuple[dict[str, Any], Sequence[Remark]]:
        """Return an entry of another campaign, with what is given of this file."""
        from .given import like

        return like(given, entry), ()

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return the input axis and the scale factor of the data sheet, with the standards."""
        return {"axis": facts.axes[0], "nominal": facts.output_scale_factor, "standards": facts.standards}

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the runs of all recordings, as the programme has them."""
        from .readings import readings_from

        return readings_from(sources, corrections)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the scale factor."""
        from .reduction import reduce

        return reduce(plan, readings)

    def terms(self, result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
        """Return the scale factor of the input axis."""
        from .reduction import model_terms

        return model_terms(result, tests)

    def needs(self, influence: str, result: Result) -> bool:
        """Return whether an influence would change this result: the satellite does where the recoil is stated."""
        return influence in self.influences and (influence != SATELLITE or result.plan.recoil == "stated")

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return the scale factor and the recoil arm as a sentence."""
        from ...core.show.rows import Cited, estimated, largest

        found = largest(estimated(rows, "scale_factor"))
        if found is None:
            return ("The response to the turned mass cannot be told from noise",)
        recoil = largest(estimated(rows, "recoil_arm"))
        sentence: Sentence = ("Scale factor ", Cited(found), " from a turned mass")
        return sentence if recoil is None else (*sentence, "; recoil arm ", Cited(recoil))

    def quantities(self) -> Mapping[str, Quantity]:
        """Return kinds and units of its figures."""
        return QUANTITIES

    def planned(self, given: Mapping[str, Any]) -> TurnedPlan:
        """Return what a programme will give."""
        from .planning import planned

        return planned(given)

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return ``turned``."""
        from .entry import KEYS

        return KEYS

    def check(self, test: SaidTest) -> Iterator[Problem]:
        """Yield a plan that does not say the orbit, or the recoil that it takes as stated."""
        from .entry import plan_problems

        return plan_problems(test)

    def check_recording(self, test: SaidTest, name: str, entry: Entry) -> Iterator[Problem]:
        """Yield a recording without a programme of the mass, or of a sensor that does not count pulses."""
        from .entry import recording_problems

        return recording_problems(test, name, entry)


PROCEDURE = TurnedMass()
