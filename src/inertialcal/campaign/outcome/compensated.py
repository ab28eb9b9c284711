"""Requirements on compensated readings: held out, compensated by the delivered model, judged by the same rule.

What would make them too good is refused or named:

- a test that is not held out (``check`` refuses it), or one that has a power-up or a recording in
  common with the tests behind the model: INCONCLUSIVE, its readings are no news to the model;
- no model that readings held out do not refute: INCONCLUSIVE;
- one power-up, or temperatures beyond those of the model (the procedure says so): INCONCLUSIVE;
- recordings copied under another name: refused before, wherever a test reads them (``inputs.duplicates``).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from ...core.judging import Asked, Verdict
from ...procedures import procedure_of
from ...sensors.model.sensor_model import SensorModel
from ..engine.engine import ReducedTest
from ..file.conditions import in_condition, on_sensor
from ..file.schema import CampaignFile, Test
from ..models.judged import JudgedModel

NO_MODEL = "no model is delivered that could compensate these readings"


@dataclass(frozen=True, eq=False)
class Compensation:
    """The campaign, and its models that readings held out do not refute."""

    file: CampaignFile | None = None
    models: tuple[JudgedModel, ...] = ()

    def model_for(self, test: Test) -> SensorModel | None:
        """Return the delivered model of the sensor and condition of a test; None where there is none."""
        file = self.file
        if file is None:
            return None
        for one in self.models:
            if on_sensor(file, test, one.sensor) and in_condition(file, test, one.sensor, one.condition):
                return one.model
        return None

    def seen(self, test: Test, model: SensorModel) -> list[str]:
        """Return the power-ups and recordings of a test that the tests behind a model have, too."""
        assert self.file is not None  # noqa: S101 - it has a model
        behind = [one for one in self.file.tests if one.id in model.tests]
        own, known = self._parts(test), {part for one in behind for part in self._parts(one)}
        return [part for part in own if part in known]

    def _parts(self, test: Test) -> list[str]:
        """Return what tells the power-ups of a test apart: their labels, and the files."""
        entries = [self.file.recordings[name] for name in test.recordings] if self.file is not None else []
        labels = [f"power-up {label}" for label in (test.power_up, *(one.run for one in entries)) if label]
        return list(dict.fromkeys([*labels, *(f"file {one.file}" for one in entries)]))


def compensated_verdicts(asked: Asked, about: Sequence[ReducedTest], compensation: Compensation) -> Iterator[Verdict]:
    """Yield the verdicts on the tests held out that a requirement is about, each with what was read beside it."""
    for one in about:
        procedure = procedure_of(one.test.procedure)
        if one.test.use != "hold_out" or asked.quantity not in procedure.compensated:
            continue
        model = compensation.model_for(one.test)
        if model is None:
            yield _undecided(asked, one, NO_MODEL)
            continue
        doubts = [one.errors[0].what] if one.errors else []
        if seen := compensation.seen(one.test, model):
            doubts.append(f"the model was fitted on {', '.join(seen[:3])}, too: these readings are not held out")
        for after, raw in procedure.judge_compensated(asked, one.tested, model):
            found = replace(after, readings="compensated", as_read=raw)
            basis = replace(after.basis, in_doubt=True, risk=None)
            yield (
                found
                if not doubts
                else replace(found, verdict="INCONCLUSIVE", reason=f"in doubt: {doubts[0]}", basis=basis)
            )


def _undecided(asked: Asked, one: ReducedTest, reason: str) -> Verdict:
    unit = one.tested.facts.si
    return Verdict(asked.id, one.test.id, asked.axis or "", None, "", None, None, unit, None, *asked.limits(unit),
                   "INCONCLUSIVE", reason, readings="compensated")  # fmt: skip
