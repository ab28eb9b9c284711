"""The procedure ``sensitivity``: what it takes, what it says of its tests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..entries import latitude_needed
from ..protocol import (
    READING,
    Command,
    Correction,
    Exclusion,
    Facts,
    InputSpec,
    Procedure,
    Quantity,
    Role,
    Source,
    Tested,
)
from .figures import FIGURES
from .plan import (
    APPLIED,
    INFLUENCES,
    OF_LEVELS,
    PRESSURE,
    REFERENCE,
    RESIDUALS,
    START_TEMPERATURE,
    SUPPLY,
    TEMPERATURE,
    WARM_UP,
    OfFile,
    Plan,
)

if TYPE_CHECKING:
    from ...core.errors import Problem
    from ...core.recording import Recording
    from ...core.results import WrittenRow
    from ...core.show.rows import Sentence
    from ...files.info.survey import Survey
    from ...sensors.model.sensor_model import SensorModel
    from ..entries import Entry, EntryKey, SaidTest
    from ..given import Described, GivenFile
    from ..model_terms import HeldOut, ModelTerms
    from ..suggestions import Suggestion
    from .readings import Readings
    from .reduction import Result

OF_CONDITION = {SUPPLY: "V", REFERENCE: "V", PRESSURE: "Pa"}


def _quantities() -> dict[str, Quantity]:
    found = {name: Quantity(READING) for name in ("scatter_level", "bias_warm_up", *RESIDUALS, *OF_LEVELS)}
    found |= {"pressure_constant_below": Quantity(("pressure",)), "pump_noise_ratio": Quantity(("dimensionless",)),
              "warm_up_time": Quantity(("time",)), START_TEMPERATURE: Quantity(("other",)),
              "scale_factor_error": Quantity(("dimensionless",), shown="%")}  # fmt: skip
    for name, unit in OF_CONDITION.items():
        found[f"bias_{name}"] = Quantity(("other",))
        found[f"bias_{name}_{TEMPERATURE}"] = Quantity(("other",))
        found[f"scale_factor_error_{name}"] = Quantity(("other",), shown=f"%/{unit}")
    found[f"scale_factor_error_{TEMPERATURE}_1"] = Quantity(("other",), shown="%/degC")
    return found


OF_ROLES = (*OF_CONDITION, TEMPERATURE, APPLIED, WARM_UP)  # conditions whose figures every test can give


class Sensitivity(Procedure[Plan, "Readings", "Result"]):
    """Bias and scale factor against conditions."""

    name, kind_of_test = "sensitivity", "sensitivity test"
    title = "Bias and scale factor against supply, temperature, pressure or any recorded condition, over power-ups."
    commands = (
        Command(
            "sensitivity",
            title,
            examples=(
                'run1.csv run2.csv run3.csv --to supply --nominal supply="5 V"',
                "run1.csv run2.csv --hold-out run3.csv --to supply -o model.json --quiet",
            ),
        ),
    )
    plan_type, said_type, influences = Plan, OfFile, INFLUENCES
    figures = FIGURES
    uses = frozenset({"fit", "hold_out", "report_only"})
    gives = ("sensitivity", "warm_up")
    counts_dwells = False
    takes_corrections = True
    inputs = InputSpec(
        ("gyro", "accelerometer"),
        (
            Role(TEMPERATURE, "temperature", "degC"),
            Role(PRESSURE, "pressure", "Pa", by_axis=False),
            Role(SUPPLY, "voltage", "V", by_axis=False),
            Role(APPLIED, "", "rad/s", by_axis=False),
        ),
        voltages=True,
        by_body=True,
    )

    def suggests(self, recording: Recording, survey: Survey) -> Suggestion | None:
        """Return the command to type next."""
        from .given import suggests

        return suggests(recording, survey)

    def split_label(self, given: str) -> tuple[str, str]:
        """Return the power-up that a file is named by, and the file: ``"A=level1.csv"``."""
        from .given import split_label

        return split_label(given)

    def described(self, given: GivenFile) -> Sequence[Described]:
        """Return a recording of channels, with those that it is set against."""
        from .given import described

        return [described(given, self.inputs)]

    def entry_keys(self) -> Sequence[EntryKey]:
        """Return its own keys of a recording's entry."""
        from .entry import KEYS

        return KEYS

    def plan_fields(self, facts: Facts) -> dict[str, Any]:
        """Return what site, sensor and standards say."""
        from ...core.units import same_dimension

        spoken = facts.unit if facts.unit and same_dimension(facts.unit, facts.si) else ""
        return super().plan_fields(facts) | {"unit": spoken}

    def readings(self, plan: Plan, sources: Sequence[Source], corrections: Sequence[Correction] = ()) -> Readings:
        """Return the means over the levels of all sources."""
        from .readings import readings_from, recorded

        return readings_from(plan, recorded(plan, sources, corrections), sources[0].facts.si)

    def reduce(self, plan: Plan, readings: Readings) -> Result:
        """Return the sensitivities."""
        from .reduction import reduce

        return reduce(plan, readings)

    def quantities(self) -> Mapping[str, Quantity]:
        """Return what there is to say of its figures."""
        return _quantities()

    def quantities_of(self, settings: Mapping[str, Any]) -> Mapping[str, Quantity]:
        """Return the terms of conditions that are no role; their unit is that of their column."""
        to = settings.get("to")
        others = [name for name in to if isinstance(name, str) and name not in OF_ROLES] if isinstance(to, list) else []
        stems = ("bias_{}", f"bias_{{}}_{TEMPERATURE}", "scale_factor_error_{}")
        return {stem.format(name): Quantity() for name in others for stem in stems}

    def exclusions(self, test: Tested[Plan, Readings, Result]) -> Iterator[Exclusion]:
        """Yield the samples between levels."""
        if test.readings.transients:
            decided = f"rule: settle = {test.plan.settle:g} s"
            yield Exclusion("settle", decided, "between two levels", count=test.readings.transients, counts="sample")

    def needs(self, influence: str, result: Result) -> bool:
        """Return whether an influence would change this result."""
        from .reduction import applies

        return applies(influence, result)

    def terms(self, result: Result, tests: Sequence[Tested[Plan, Readings, Result]]) -> ModelTerms | None:
        """Return the sensitivities as terms of the model."""
        from .terms import terms

        return terms(result, tests)

    def joined(self, tests: Sequence[Tested[Plan, Readings, Result]]) -> tuple[Plan, Readings] | None:
        """Return plan and readings of tests that find the same terms, to be reduced together."""
        from .held_out import joined

        return joined(tests)

    def held_out(
        self,
        result: Result,
        fitted: Sequence[Tested[Plan, Readings, Result]],
        held: Sequence[Tested[Plan, Readings, Result]],
        model: SensorModel | None,
    ) -> HeldOut:
        """Return what the terms leave of the levels of power-ups held out."""
        from .held_out import held_out

        return held_out(result, fitted, held)

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        """Return what a test found, as one sentence."""
        from .rows import finding

        return finding(rows)

    def check_recording(self, test: SaidTest, name: str, entry: Entry) -> Iterator[Problem]:
        """Yield an applied input along no axis."""
        from ...core.errors import Problem

        if APPLIED in (entry.channels or {}) and entry.axis is None:
            what = f"recordings.{name}: channel applied, but no axis that it is along"
            yield Problem(what, test.at("recordings", name), do='Say axis = "x"', code="missing_key")

    def check(self, test: SaidTest) -> Iterator[Problem]:
        """Yield an attitude without a latitude, and references and stated terms of nothing that is asked for."""
        from .said import problems

        yield from latitude_needed(test)
        yield from problems(test)


PROCEDURE = Sensitivity()
