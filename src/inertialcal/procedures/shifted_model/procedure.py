"""The procedure ``shifted_model``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..protocol import (
    READING,
    Command,
    Correction,
    Facts,
    InputSpec,
    Procedure,
    Quantity,
    Reduced,
    Source,
    Tested,
)
from .figures import FIGURES
from .plan import INFLUENCES, Plan, SaidFlips

if TYPE_CHECKING:
    from ...core.errors import Problem
    from ...core.remarks import Remark
    from ...core.results import WrittenRow
    from ...core.show.rows import Sentence
    from ...sensors.model.sensor_model import SensorModel
    from ..entries import Entry, EntryKey, SaidSensor
    from ..given import Described, GivenFile
    from ..model_terms import HeldOut, ModelTerms
    from .readings import Readings
    from .reduction import Result

QUANTITIES = {
    "bias_shift": Quantity(READING),
    "bias_drift": Quantity(("other",), shown="{unit}/year"),
    "bias_shift_slope": Quantity(("other",), shown="{unit}/degC"),
    "launch_shift": Quantity(READING, size=True),
    "bias_next_flight": Quantity(READING),
    "prediction_error": Quantity(READING),
    "ground_prediction_error": Quantity(READING),
}


class ShiftedModel(Procedure[Plan, "Readings", "Result"]):
    """Bias of a ground model, shifted by flips over several flights."""

    name, kind_of_test = "shifted_model", "shifted ground model"
    title = "Bias of a ground model shifted by flips over several flights, with drift and launches."
    commands = (
        Command(
            "shifted-model",
            title,
            examples=(
                "flights/flips.csv --ground flights/ground.json --ground-date 2018-05-01 -o new.json",
                'flights/flips.csv --ground flights/ground.json --ground-date 2018-05-01 --later "6" --plot',
            ),
        ),
    )
    plan_type, said_type, influences = Plan, SaidFlips, INFLUENCES
    uses = frozenset({"fit", "hold_out", "report_only"})
    gives = ("bias", "scale_factor", "misalignment", "sensitivity", "noise")
    chosen_by = "Choose by groups"
    counts_dwells = False
    made_of = "flip"
    figures = FIGURES
    inputs = InputSpec(("accelerometer",), table="flips", ground_model="bias_kept", windows="refused")

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return the columns of a table of flips, with the ground model; or the flip of a recording."""
        from .given import described, described_recording, is_recording

        return [described_recording(given, self.inputs) if is_recording(given) else described(given)]

    def like(self, given: GivenFile, entry: Mapping[str, Any]) -> tuple[dict[str, Any], Sequence[Remark]]:
        """Return an entry of another campaign, with the ground model that is given."""
        from .given import like

        return like(given, entry), ()

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return the standards: all else is set."""
        return {"standards": facts.standards}

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the flips of all tables, and those of the tests that it is made of."""
        from .readings import readings_from

        return readings_from(plan, sources, corrections)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the shifts."""
        from .reduction import reduce

        return reduce(plan, readings)

    def quantities(self) -> Mapping[str, Quantity]:
        """Return kinds and units of its figures."""
        return QUANTITIES

    def terms(self, result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
        """Return all terms of the new model."""
        from .terms import model_terms

        return model_terms(result, tests)

    def held_out(
        self,
        result: Result,
        fitted: Sequence[Tested[Plan, Readings, Result]],
        held: Sequence[Tested[Plan, Readings, Result]],
        model: SensorModel | None,
    ) -> HeldOut | None:
        """Return how later flips judge the new model against the ground model."""
        from .terms import held_out

        return held_out(result, held)

    def summary(self, found: Reduced) -> str:
        """Return the flights with their shifts from both models."""
        from .shown import summary

        return summary(found.result, found.unit)

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return the largest shift and drift as a sentence."""
        from ...core.show.rows import Cited, estimated, largest

        shift = largest(estimated(rows, "bias_shift"))
        if shift is None:
            return ("The flights do not shift the ground model",)
        drift = largest(estimated(rows, "bias_drift"))
        sentence: Sentence = ("Largest shift from the ground model ", Cited(shift))
        return sentence if drift is None else (*sentence, "; largest drift ", Cited(drift))

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return ``flips``."""
        from .entry import KEYS

        return KEYS

    def check_entry(self, name: str, entry: Entry, sensor: SaidSensor, at: Callable[..., str]) -> Iterator[Problem]:
        """Yield biases in a unit of another kind."""
        from .entry import entry_problems

        return entry_problems(name, entry, sensor, at)


PROCEDURE = ShiftedModel()
