"""The procedure ``flip``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..protocol import (
    READING,
    Command,
    Correction,
    Exclusion,
    InputSpec,
    Procedure,
    Quantity,
    Reduced,
    Source,
    Tested,
)
from .figures import COMPARED, FIGURES
from .plan import INFLUENCES, Plan, PlannedFlips, Turned

if TYPE_CHECKING:
    from pathlib import Path

    from ...core.errors import Problem
    from ...core.key import Key
    from ...core.recording import Recording
    from ...core.remarks import Remark
    from ...core.results import Row, WrittenRow
    from ...core.show.rows import Sentence
    from ...files.info.survey import Survey
    from ...files.text.table import Table
    from ..entries import Entry, EntryKey, SaidSensor, SaidTest
    from ..given import Described, GivenFile
    from ..model_terms import ModelTerms
    from ..planned import TestPlan
    from ..rehearsed import Rehearsal
    from ..suggestions import Claim, Draft, FolderFile, Suggestion
    from .readings import Readings
    from .reduction import Result

QUANTITIES = dict.fromkeys(
    (
        "bias", "ambient_acceleration", "model_bias_error", "control_error", "reading", "bias_shift", "corrected_bias",
        "bias_next_record", "model_bias_error_next_record",
        "model_bias_error_change", "model_bias_error_reduction", "other_model_bias_error", "predicted_bias",
    ),
    Quantity(READING),
) | {"flip_temperature": Quantity(("temperature",))}  # fmt: skip

RULES = {"settling": ("settle", "window")}  # remark: rule, what it counts
UNREAD = {"dwell_incomplete": "missing", "gain_changed": "gain"}  # remark: rule by which an axis is not read


PLANNED = '--noise "5 ug/sqrt(Hz)" --instability "0.5 ug"'


class Flip(Procedure[Plan, "Readings", "Result"]):
    """Bias and ambient acceleration of a head that was turned."""

    name = "flip"
    title = "Bias and ambient acceleration of a triaxial accelerometer head, from turning it in orbit."
    commands = (
        Command(
            "flip",
            "Bias and ambient acceleration of a triaxial accelerometer head, from turning it in orbit.",
            examples=(
                'table03.csv --position "forward=0 deg" --position "reverse=180 deg"',
                'table03.csv --position "forward=0 deg" --position "reverse=180 deg" --plot',
            ),
        ),
    )
    planner = Command(
        "flip",
        "Dwells, turns and flips of a head in orbit, and the uncertainty of bias and ambient acceleration.",
        examples=(f"{PLANNED} --wanted bias='0.5 ug'", f'{PLANNED} --available "4 h"'),
    )
    planner_type = PlannedFlips
    plan_type, influences = Plan, INFLUENCES
    said_type = Turned
    figures, compared = FIGURES, COMPARED
    gives = ("bias",)
    corrects = "bias"
    set_against = takes_corrections = True
    chosen_by = "Choose by positions"
    inputs = InputSpec(("accelerometer",), table="means", ground_model="bias_kept", windows="refused", as_wide=True)

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return the entry of a file: a table of means, or a recording with its windows."""
        from .given import described

        return [described(given, self.inputs)]

    def like(self, given: GivenFile, entry: Mapping[str, Any]) -> tuple[dict[str, Any], Sequence[Remark]]:
        """Return an entry of another campaign as it holds for this file: with windows that lie in its record."""
        from .given import like

        return like(given, entry)

    def inputs_for(self, plan: Plan, corrections: Sequence[Correction] = ()) -> InputSpec:
        """Return the inputs: with ``corrected`` less the bias of a ground model."""
        taken = super().inputs_for(plan, corrections)
        return replace(taken, ground_model="applied") if plan.corrected else taken

    def planned(self, given: Mapping[str, Any]) -> TestPlan:
        """Return what a test will give."""
        from .planning import planned

        return planned(given)

    def rehearsed(self, given: Mapping[str, Any], schedule: Table, seed: int) -> Rehearsal:
        """Return what a schedule gives on a simulated unit."""
        from ..planned import settings_said
        from .rehearsal import rehearse

        return rehearse(settings_said(PlannedFlips, given, options=True)[0], schedule, seed)

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the dwells, of reduced means or of recordings."""
        from ...core.errors import DataError
        from .dwells.recordings import readings_from
        from .inputs import corrected_heads, readings_of_means_tables, turned_head

        tables = [one for one in sources if one.is_table]
        if tables and len(tables) < len(sources):
            names = ", ".join(one.name for one in tables)
            what = f"test {sources[0].test!r}: reduced means ({names}) and recordings in one test"
            raise DataError(what, do="Make two tests of them", code="wrong_value")
        if tables:
            return readings_of_means_tables(tables)
        turned = [turned_head(one) for one in sources]
        return corrected_heads(plan, turned, corrections) if corrections else readings_from(plan, turned)

    def agreement(self, plan: Plan, readings: Readings) -> Sequence[Remark]:
        """Return dwells and flips that disagree with the others."""
        from .agreement import agreement

        return agreement(plan, readings)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return bias and ambient acceleration."""
        from .reduction import reduce

        return reduce(plan, readings)

    def quantities(self) -> Mapping[str, Quantity]:
        """Return units and use of its figures."""
        return QUANTITIES

    def content(self, found: Reduced) -> Mapping[str, object]:
        """Return when the head was flipped, for `shifted-model`."""
        from ...core.times import instant_text
        from .terms import time_of

        time = time_of(found.result)
        return {} if time is None else {"time": instant_text(round(time * 1e9))}

    def exclusions(self, test: Tested[Plan, Readings, Result]) -> Iterator[Exclusion]:
        """Yield starts of windows and samples as remarks count them, then the dwells in which an axis is not read."""

        def decided(key: str) -> str:
            value = getattr(test.plan, key, None)
            return f"rule: {key}" if value is None else f"rule: {key} = {value:g}"

        readings = test.readings
        for remark in readings.remarks:
            if remark.code in RULES:
                key, counts = RULES[remark.code]
                yield Exclusion(remark.code, decided(key), remark.what, remark.where, count=remark.count,
                                counts=counts)  # fmt: skip
        for axis, values in readings.outputs.items():
            why = next((one for one in readings.remarks if one.code in UNREAD and one.axis == axis), None)
            for i, value in enumerate(values if why else ()):
                if why and value != value:  # noqa: PLR0124 - NaN
                    place = readings.where[i] if readings.where else ""
                    yield Exclusion(why.code, decided(UNREAD[why.code]), why.what, place, axis, dwell=True)

    def called(self, result: Result, key: Key) -> Key:
        """Return the key of a value: the bias after a ground model is the error of that model."""
        from .rows import MODEL_BIAS

        left = result.plan.corrected and key.quantity == "bias"
        return key._replace(quantity=MODEL_BIAS) if left else key

    def correction(self, test: str, result: Result) -> Correction | None:
        """Return the bias of the axes across the turn, to be taken off."""
        from .terms import correction

        return correction(test, result)

    def terms(self, result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
        """Return the bias of the axes across the turn."""
        from .terms import model_terms

        return model_terms(result, tests)

    def against(self, test: Tested[Plan, Readings, Result], other: Tested[Any, Any, Any]) -> Sequence[Row]:
        """Return the differences of two tests of one head, as after one ground model and another."""
        from .side_by_side import side_by_side

        return side_by_side(test.result, other.result, other.id)

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return the largest bias, and the error of the control axis."""
        from ...core.show.rows import Cited, Quoted, error_sentence, estimated, largest, largest_of

        biases = largest_of(("bias", "model_bias_error"), rows)
        control = largest(estimated(rows, "control_error"))
        if not biases:
            return error_sentence(rows)
        if control is None:
            return biases
        return (*biases, "; control axis ", Quoted(control["axis"]), " reads ", Cited(control),
                " of the turn, where zero is right")  # fmt: skip

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return ``means`` and ``positions``."""
        from .entry import KEYS

        return KEYS

    def check(self, test: SaidTest) -> Iterator[Problem]:
        """Yield windows: they would have no effect."""
        from .entry import test_problems

        return test_problems(test)

    def check_recording(self, test: SaidTest, name: str, entry: Entry) -> Iterator[Problem]:
        """Yield a recording without positions of the head."""
        from .entry import recording_problems

        return recording_problems(test, name, entry)

    def check_entry(self, name: str, entry: Entry, sensor: SaidSensor, at: Callable[..., str]) -> Iterator[Problem]:
        """Yield columns of a reduced table that do not fit the sensor."""
        from .entry import entry_problems

        return entry_problems(name, entry, sensor, at)

    def suggests(self, recording: Recording, survey: Survey) -> Suggestion | None:
        """Return the command to type next."""
        from .suggest import suggests

        return suggests(recording, survey)

    def found_in(self, root: Path) -> tuple[dict[str, object], list[Remark]]:
        """Return the archive records of a folder in which the head turned: those of one sensor are one recording."""
        from ..archived import found_in
        from .suggest import in_archive

        found, remarks = found_in(root, in_archive)
        return dict(found), remarks

    def claims(self, file: FolderFile) -> Claim | None:
        """Return how well a file of a folder fits this test."""
        from .suggest import claims

        return claims(file)

    def draft(self, contents: Mapping[str, object]) -> Draft:
        """Return the tables of a first campaign.toml."""
        from .suggest import draft

        return draft(contents)


PROCEDURE = Flip()
