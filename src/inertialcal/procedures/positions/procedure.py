"""The procedure ``positions``: what it takes, what it says of its tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..protocol import (
    LASTS,
    OF_MOUNTING,
    READING,
    RELATIVE,
    Command,
    Correction,
    Exclusion,
    Facts,
    InputSpec,
    Procedure,
    Quantity,
    Reduced,
    Source,
    Tested,
)
from .figures import FIGURES
from .plan import HIGHEST_ORDER, INFLUENCES, FileSettings, Plan, Wanted

if TYPE_CHECKING:
    from ...core.errors import InertialcalError, Problem
    from ...core.key import Kind
    from ...core.recording import Recording
    from ...core.remarks import Remark
    from ...core.results import Row
    from ...files.info.survey import Survey
    from ...files.text.table import Table
    from ...sensors.model.sensor_model import SensorModel
    from ..entries import Entry, EntryKey, SaidSensor
    from ..given import Described, GivenFile
    from ..model_terms import HeldOut, ModelTerms
    from ..rehearsed import Rehearsal
    from ..suggestions import Claim, Draft, FolderFile, Question, Suggestion
    from .planning.planner import PositionsPlan
    from .readings import Readings
    from .reduction import Result

QUANTITIES = {
    "bias": Quantity(READING),
    "bias_next_record": Quantity(READING, redrawn_by=None),
    "scale_factor": Quantity(("other",)),
    "scale_factor_error": Quantity(RELATIVE, shown="%"),
    "misalignment": Quantity(("angle",), redrawn_by=OF_MOUNTING),
    "direction_cosine": Quantity(RELATIVE, redrawn_by=None),
    **{f"bias_temperature_{j}": Quantity(("other",)) for j in range(1, HIGHEST_ORDER + 1)},
    **{f"scale_factor_error_temperature_{j}": Quantity(("other",)) for j in range(1, HIGHEST_ORDER + 1)},
    **{f"cross_axis_sensitivity_temperature_{j}": Quantity(("other",)) for j in range(1, HIGHEST_ORDER + 1)},
    "cross_axis_sensitivity": Quantity(RELATIVE, shown="%", redrawn_by=OF_MOUNTING),
    "g_sensitivity": Quantity(("other",), shown="({unit})/g"),  # of readings in counts it stays in counts
    "scatter_position": Quantity(READING, redrawn_by=LASTS),
    "gravity_error_left_out": Quantity(READING, redrawn_by=None),
    "face_error": Quantity(("angle",), shown="deg", redrawn_by=LASTS),
    "scatter_laying": Quantity(("angle",), shown="deg", redrawn_by=LASTS),
    "scatter_rotation": Quantity(("angle",), shown="deg", redrawn_by=LASTS),
    "transition_error": Quantity(("angle",), shown="deg", redrawn_by=LASTS),
}

LOST = {"position_incomplete": "position", "rotation_incomplete": "rotation"}  # remark and rule: what it counts


class Positions(Procedure[Plan, "Readings", "Result"]):
    """Accelerometers and gyros from static positions and the rotations between them."""

    name = "positions"
    title = "Accelerometers and gyros from static positions and the rotations between them, without a turntable."
    commands = (
        Command(
            "positions",
            "Scale factors, misalignment, bias and g-sensitivity from static positions and rotations by hand.",
            examples=(
                "hand/recordings/hand1.csv --unit acc=m/s2 --unit gyro=rad/s"
                ' --gravity "9.807 m/s2" --latitude "45.8 deg"',
                "hand/recordings/hand1.csv --unit acc=m/s2 --unit gyro=rad/s --for px4",
            ),
        ),
    )
    planner = Command(
        "positions",
        "Positions of accelerometers to take, one after another, and the uncertainty to expect of them.",
        examples=(
            '--scatter "0.2 mg" --have faces --target bias="0.15 mg" --gravity-u "0.1 mg"',
            '--scatter "0.2 mg" --target bias="0.15 mg" --json',
        ),
    )
    plan_type, said_type, planner_type, influences = Plan, FileSettings, Wanted, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "hold_out", "report_only"})
    gives = ("scale_factor", "misalignment", "bias", "g_sensitivity", "sensitivity")
    takes_corrections = changes = True
    inputs = InputSpec(("accelerometer", "gyro"), table="rests", several_sensors=True, raw=True, streamed=True)

    def split_label(self, given: str) -> tuple[str, str]:
        """Return the sensor, position or turn that stands before a file, and the file."""
        from .given import split_label

        return split_label(given)

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return accelerometers and gyros of a file."""
        from .given import described

        return described(given)

    def like(self, given: GivenFile, entry: Mapping[str, Any]) -> tuple[dict[str, Any], Sequence[Remark]]:
        """Return an entry of another campaign, with what is given of this file."""
        from .given import own_keys

        return {**entry, **own_keys(given)}, ()

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return gravity, latitude and height of the site, the standards, and the nominal scale factor of counts."""
        from ...core.units import kind

        found: dict[str, Any] = {"gravity": facts.gravity, "latitude": facts.latitude, "height": facts.height or 0.0}
        for one in (facts, *facts.others):
            name = {"accelerometer": "acc_scale_factor", "gyro": "gyro_scale_factor"}.get(one.kind or "")
            if name and one.scale_factor and kind(one.unit) in ("count", "voltage"):  # else readings are in SI
                found[name] = one.scale_factor
        return {**found, "standards": facts.standards}

    def plan(self, values: Mapping[str, Any], facts: Facts) -> Plan:
        """Return the plan of a test.

        Raises
        ------
        PlanError
            If gravity, latitude or the shortest rest cannot be meant.
        """
        from ...core.errors import PlanError
        from .readings import site_problems

        plan = super().plan(values, facts)
        if problems := site_problems(plan):
            raise PlanError(problems)
        return plan

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return static intervals and the rotations between them."""
        from .inputs import readings_of

        return readings_of(plan, sources, corrections)

    def agreement(self, plan: Plan, readings: Readings) -> Sequence[Remark]:
        """Return recordings, or parts of them, that disagree with gravity."""
        from .agreement import agreement

        return agreement(plan, readings)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return what positions and rotations tell of both triads."""
        from .reduction import reduce

        return reduce(plan, readings)

    def reduce_many(self, tests: Sequence[tuple[Plan, Readings]]) -> list[Result | InertialcalError]:
        """Return the same of many units, those with equal numbers of positions at once."""
        from .reduction import reduce_many

        return reduce_many(tests)

    def by_sensor(self, result: Result) -> Mapping[str, Result]:
        """Return the parts of the accelerometers and of the gyros."""
        from ...core.results import changed

        kinds: tuple[Kind, ...] = ("accelerometer",) if result.gyro is None else ("accelerometer", "gyro")
        return {kind: changed(result, sensor=kind) for kind in kinds}

    def truths(self, result: Result) -> Sequence[Row]:
        """Return the rows of all sensors."""
        return result.rows()

    def quantities(self) -> Mapping[str, Quantity]:
        """Return what there is to say of its figures."""
        return QUANTITIES

    def exclusions(self, test: Tested[Plan, Readings, Result]) -> Iterator[Exclusion]:
        """Yield positions and rotations that lack readings."""
        for remark in test.readings.remarks:
            if remark.code in LOST:
                counts = LOST[remark.code]
                yield Exclusion(remark.code, "no readings", remark.what, remark.where, count=remark.count,
                                counts=counts)  # fmt: skip

    def needs(self, influence: str, result: Result) -> bool:
        """Return whether the test is subject to an influence that is not stated."""
        from .rows import missing

        return influence in missing(result)

    def terms(self, result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
        """Return the terms of one sensor."""
        from ...core.key import AXES
        from ...core.units import normalise
        from ...sensors.model.sensor_model import INPUT_UNIT, Provenance
        from ..model_terms import ModelTerms

        found = result.terms.get(result.sensor)
        if result.estimate is None or found is None:
            return None
        keys, origin = found.estimate.keys, Provenance(tests[0].id, tests[0].recordings)
        return ModelTerms(
            found.estimate,
            keys,
            AXES,
            dict.fromkeys(keys, origin),
            found.not_estimated,
            found.values,
            found.scale_factor,
            None if normalise(found.output_unit) == INPUT_UNIT[found.kind] else found.output_unit,
            found.input_range,
            reference_temperature=None if found.over is None else found.over.reference,
            temperature_range=None if found.over is None else found.over.range,
        )

    def held_out(
        self,
        result: Result,
        fitted: Sequence[Tested[Plan, Readings, Result]],
        held: Sequence[Tested[Plan, Readings, Result]],
        model: SensorModel | None,
    ) -> HeldOut:
        """Return what positions and rotations held out say of the sensor."""
        from ...core.remarks import Remark
        from ..model_terms import HeldOut
        from .closed_loop import loops_of

        remounted = any(one.occasion.remounted(other.occasion) for one in fitted for other in held)
        loops = loops_of(result, [one.readings for one in held], result.sensor or "accelerometer", remounted)
        if loops:
            return HeldOut(loops)
        what = "what is held out has fewer than two positions: nothing is judged by them"
        return HeldOut(remarks=(Remark("not_judged", "warning", what, do="Hold out a recording of more positions"),))

    def check_entry(self, name: str, entry: Entry, sensor: SaidSensor, at: Callable[..., str]) -> Iterator[Problem]:
        """Yield columns of a table that do not fit the sensor."""
        from .entry import entry_problems

        yield from entry_problems(name, entry, sensor, at)

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return ``orientations``, ``sections`` and ``turn``."""
        from .entry import KEYS

        return KEYS

    def summary(self, found: Reduced) -> str:
        """Return how many positions and rotations there are, and which gravity was used."""
        from .readings import local_gravity

        readings = found.result.readings
        known = 0 if readings.direction is None else int(sum(abs(one).sum() > 0.0 for one in readings.direction))
        parts = [
            f"{len(readings)} positions" + (f", {known} of known orientation" if 0 < known < len(readings) else "")
        ]
        parts += [f"{len(readings.transitions)} rotations between them"] if readings.transitions else []
        parts += [f"{len(readings.turns)} turns by a known angle"] if readings.turns else []
        return f"found: {', '.join(parts)}; gravity {local_gravity(found.plan):.6g} m/s2"

    def planned(self, given: Mapping[str, Any]) -> PositionsPlan:
        """Return positions to take, and the uncertainty to expect of them."""
        from .planning.planner import planned

        return planned(given)

    def rehearsed(self, given: Mapping[str, Any], schedule: Table, seed: int) -> Rehearsal:
        """Return what a schedule gives on a simulated unit."""
        from .planning.rehearsal import rehearse

        return rehearse(given, schedule, seed)

    def suggests(self, recording: Recording, survey: Survey) -> Suggestion | None:
        """Return the command to type next."""
        from .suggest import suggests

        return suggests(recording, survey)

    def claims(self, file: FolderFile) -> Claim | None:
        """Return how much a file of a folder is made for this test."""
        from .suggest import claims

        return claims(file)

    def asks(self, contents: Mapping[str, object]) -> Sequence[Question]:
        """Return what it has to be told: gravity."""
        from .suggest import asks

        return asks(contents)

    def draft(self, contents: Mapping[str, object]) -> Draft:
        """Return what a first campaign.toml says of them."""
        from .suggest import draft

        return draft(contents)


PROCEDURE = Positions()
