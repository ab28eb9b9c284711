"""A model with the verdict on it, and what tests without a model say of readings held out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ...core.curve import Curve
from ...core.errors import InertialcalError
from ...core.remarks import Remark
from ...procedures import procedure_of
from ...procedures.model_terms import HeldOut
from ...procedures.protocol import Tested
from ...sensors.model.sensor_model import SensorModel
from ...statistics.closed_loop import AxisLoop, overall
from ..engine.engine import computable, placed
from ..file.conditions import on_sensor
from ..file.load import Campaign

NOT_RUN = "not run"


@dataclass(frozen=True)
class ResidualLoop:
    """One axis of a test held out of which no model is made."""

    test: str  # Held out
    against: str  # Fitted
    loop: AxisLoop  # Before, after, verdict


@dataclass(frozen=True, eq=False)
class JudgedModel:
    """The model of a sensor in a condition, and its closed loop."""

    sensor: str  # As the campaign calls it
    condition: str  # Of the campaign; empty where no test states one
    model: SensorModel | None  # ``judged`` where the closed loop PASSes
    name: str = ""  # Of its rows: ``model``, ``model_vacuum``
    loops: tuple[AxisLoop, ...] = ()  # Empty where nothing was held out
    verdict: str = NOT_RUN  # ``PASS``, ``FAIL``, ``INCONCLUSIVE``, or ``not run``
    remarks: tuple[Remark, ...] = ()  # Findings
    curves: tuple[Curve, ...] = ()  # Of readings held out, SI
    residuals: tuple[ResidualLoop, ...] = ()  # Of tests held out that found what was taken off before

    @property
    def is_judged(self) -> bool:
        """Whether anything was held out."""
        return bool(self.loops or self.residuals)


@dataclass(frozen=True, eq=False)
class Modelled:
    """The models of a campaign, and a closed loop of tests that no model is made of."""

    every: tuple[JudgedModel, ...] = ()  # First those of the sensor that was fitted first
    residuals: tuple[ResidualLoop, ...] = ()  # Of tests held out of which no model was made

    @property
    def delivered(self) -> tuple[JudgedModel, ...]:
        """Models that readings held out do not refute."""
        return tuple(one for one in self.every if one.model is not None and one.verdict != "FAIL")

    @property
    def is_judged(self) -> bool:
        """Whether anything was held out."""
        return bool(self.residuals) or any(one.is_judged for one in self.every)

    @property
    def whole_verdict(self) -> str:
        """The worst verdict of all that was judged; ``not run`` where nothing was."""
        found = {one.verdict for one in self.every if one.is_judged}
        found |= {overall([one.loop for one in self.residuals])} if self.residuals else set()
        return next((word for word in ("FAIL", "INCONCLUSIVE", "PASS") if word in found), NOT_RUN)


@dataclass(frozen=True, eq=False)
class Residual:
    """What the result of one test leaves of readings that another one of its procedure holds out."""

    against: str  # Fitted
    found: HeldOut  # Rows, curves and loops


def hold_out_residuals(campaign: Campaign, reduced: Mapping[str, Tested[Any, Any, Any]]) -> dict[str, Residual]:
    """Return what is left on readings held out of tests that are judged one by one, by test.

    Each is set against the first test for a fit of its procedure, on the same sensor and in the same condition.

    Raises
    ------
    DataError
        As the procedure says.
    """
    found = {}
    for number, test in enumerate(campaign.file.tests):
        procedure = procedure_of(test.procedure)
        if test.use != "hold_out" or not procedure.judged_alone:
            continue
        sensor = campaign.file.recordings[test.recordings[0]].sensor
        fitted = next(
            (
                one
                for one in campaign.file.tests
                if one.use == "fit"
                and (one.procedure, one.condition) == (test.procedure, test.condition)
                and on_sensor(campaign.file, one, sensor)
            ),
            None,
        )
        if fitted is None:
            continue
        own = reduced[fitted.id]
        try:
            with computable(test.id):
                held = procedure.held_out(own.result, [own], [reduced[test.id]], None)
        except InertialcalError as error:
            raise type(error)([placed(problem, campaign, number) for problem in error.problems]) from None
        if held is not None:
            rows = tuple(replace(row, test=test.id) for row in held.rows)
            found[test.id] = Residual(own.id, replace(held, rows=rows))
    return found
