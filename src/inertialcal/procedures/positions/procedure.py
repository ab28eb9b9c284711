"""The procedure ``positions``: what it takes, what it says of its tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..protocol import READING, RELATIVE, Command, Correction, Facts, InputSpec, Procedure, Quantity, Source
from .figures import FIGURES
from .plan import INFLUENCES, Plan

if TYPE_CHECKING:
    from .of_sensor import OfSensor
    from .readings import Readings
    from .reduction import Result

QUANTITIES = {
    "bias": Quantity(READING),
    "scale_factor": Quantity(("other",)),
    "scale_factor_error": Quantity(RELATIVE, shown="%"),
    "cross_axis_sensitivity": Quantity(RELATIVE, shown="%"),
    "g_sensitivity": Quantity(("other",), shown="({unit})/g"),  # of readings in counts it stays in counts
    "scatter_position": Quantity(READING),
    "scatter_rotation": Quantity(("angle",), shown="deg"),
    "transition_error": Quantity(("angle",), shown="deg"),
}


class Positions(Procedure[Plan, "Readings", "Result"]):
    """Accelerometers and gyros from static positions and the rotations between them."""

    name = "positions"
    title = "Accelerometers and gyros from static positions and the rotations between them, without a turntable."
    commands = (
        Command(
            "positions",
            "Scale factors, misalignment, bias and g-sensitivity from static positions and rotations by hand.",
        ),
    )
    planner = Command(
        "positions", "Positions of accelerometers to take, one after another, and the uncertainty to expect of them."
    )
    plan_type, influences = Plan, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "hold_out", "report_only"})
    inputs = InputSpec(("accelerometer", "gyro"), several_sensors=True)

    def plan(self, values: Mapping[str, Any], facts: Facts) -> Plan:
        """Return the plan: gravity and height of the site, where the plan says none."""
        from ...core.errors import PlanError
        from .orientations.site import site_problems

        place = {"gravity": facts.gravity, "height": facts.height or 0.0} | dict(values)
        plan = Plan(**place, latitude=facts.latitude, standards=facts.standards)
        problems = site_problems(plan)
        if problems:
            raise PlanError(problems)
        return plan

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return static intervals and the rotations between them."""
        from .inputs import readings_of

        return readings_of(plan, sources)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return what positions and rotations tell of both triads."""
        from .reduction import reduce

        return reduce(plan, readings)

    def of_sensor(self, result: Result, facts: Facts) -> OfSensor:
        """Return what it says of the sensor that the test is about."""
        from .of_sensor import OfSensor

        return OfSensor(result, facts.kind or "accelerometer")

    def quantities(self) -> Mapping[str, Quantity]:
        """Return what there is to say of its figures."""
        return QUANTITIES

    def needs(self, influence: str, result: Any) -> bool:
        """Return whether the test is subject to an influence that is not stated."""
        from .rows import missing

        return influence in missing(result.whole)


PROCEDURE = Positions()
