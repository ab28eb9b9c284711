"""What procedures say of their figures: limits, tables and the general rule of requirements read it, and name none."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from inertialcal.campaign.engine.engine import ReducedTest
from inertialcal.campaign.file.schema import Requirement
from inertialcal.campaign.file.schema import Test as Entry
from inertialcal.campaign.outcome.exclusions import LeftOut, exclusion_rows
from inertialcal.campaign.outcome.requirements import judge
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.judging import NAMES, Asked, Verdict
from inertialcal.core.key import At, Key
from inertialcal.core.remarks import Remark
from inertialcal.core.results import Interval, Row
from inertialcal.core.units import kind, normalise
from inertialcal.procedures import PROCEDURES, all_quantities, protocol
from inertialcal.procedures.display import display_unit
from inertialcal.procedures.flip.plan import Plan as FlipPlan
from inertialcal.procedures.protocol import Exclusion, Procedure, Quantity, budget_figures

OF_SENSORS = {"gyro": "deg/s", "accelerometer": "g"}
FINE = 1e-6  # m/s: half width of the toy's interval


class Ruler(Procedure[Any, Any, Any]):
    """A procedure of others: a length that is a size, and an error over temperature that it judges itself."""

    name = "ruler"

    def quantities(self) -> Mapping[str, Quantity]:
        return {
            "ruler_length": Quantity(("length",), size=True, shown="mm"),
            "ruler_error": Quantity(("length",), over="temperature", unit="m"),
        }

    def interval_at(self, result: Any, row: Row, p: float) -> Interval | None:
        return Interval(float(row.value or 0.0) - FINE, float(row.value or 0.0) + FINE, p)

    def doubt(self, result: Any, axis: str) -> str:
        return "it bent" if axis == "y" else ""

    def judge(self, asked: Asked, tests: Sequence[Any]) -> tuple[list[Verdict], list[Row]] | None:
        if asked.quantity != "ruler_error":
            return None
        limits = asked.limits("m")
        head = (asked.id, tests[0].id, "x", 20.0, asked.of, 0.0, 0.0, "m", None)
        return [Verdict(*head, *limits, "PASS", f"{len(tests)} tests", "degC")], [
            Row(Key("ruler_range"), 1.0, None, "m")
        ]


@pytest.fixture
def ruler() -> Iterator[None]:
    PROCEDURES["ruler"] = Ruler()
    yield
    del PROCEDURES["ruler"]


def requirement(**given: object) -> Requirement:
    return Requirement.model_validate({"id": "R", "quantity": "ruler_length", "limit": "1 mm"} | given)


def measured(axis: str = "x", value: float = 0.0005) -> ReducedTest:
    entry = Entry(id=f"of_{axis}", procedure="ruler", recordings=["a"])
    rows = [Row(Key("ruler_length", axis), value, 1e-9, "m", 9.0)]
    return ReducedTest(entry, protocol.Tested(entry.id, "", entry.use, None, None, None), rows)


def test_a_procedure_of_others_judges_its_own_figures_over_all_tests(ruler: None) -> None:
    asked = requirement(quantity="ruler_error", where="temperature > 0 degC")
    (verdict,), rows = judge(asked, [measured("x"), measured("y")])
    assert (verdict.verdict, verdict.reason, verdict.lower, verdict.upper) == ("PASS", "2 tests", -1e-3, 1e-3)
    assert [row.quantity for row in rows] == ["ruler_range"]


def test_a_size_has_one_limit_and_is_compared_by_its_own_interval(ruler: None) -> None:
    (verdict,), _ = judge(requirement(), [measured()])
    assert (verdict.lower, verdict.upper, verdict.verdict) == (None, 1e-3, "PASS")
    assert verdict.interval == Interval(0.0005 - FINE, 0.0005 + FINE, 0.9)
    (near,), _ = judge(requirement(), [measured(value=0.001 - 0.5 * FINE)])
    assert near.verdict == "INCONCLUSIVE"  # its u of 1 nm alone would pass it


def test_an_upper_limit_passes_only_where_nothing_is_asked_from_below(ruler: None) -> None:
    one = measured()
    limited = replace(one, rows=[replace(one.rows[0], status="upper_limit", u=None)])
    assert judge(requirement(), [limited])[0][0].verdict == "PASS"
    (asked_from_below,), _ = judge(requirement(limit=None, lower="0.1 mm", upper="1 mm"), [limited])
    assert asked_from_below.verdict == "INCONCLUSIVE"


def test_what_is_in_doubt_never_passes(ruler: None) -> None:
    (verdict,), _ = judge(requirement(), [measured("y")])
    assert (verdict.verdict, verdict.reason) == ("INCONCLUSIVE", "in doubt: it bent")


def test_limits_of_what_no_test_speaks_to_stand_in_the_declared_unit(ruler: None) -> None:
    (open_one,), _ = judge(requirement(quantity="ruler_error"), [])
    assert (open_one.verdict, open_one.lower, open_one.upper) == ("OPEN", -1e-3, 1e-3)
    (other,), _ = judge(requirement(), [])
    assert (other.verdict, other.lower, other.upper) == ("OPEN", None, None)


def test_tables_show_the_unit_that_was_declared(ruler: None) -> None:
    assert display_unit("ruler_length", "m", "deg/s") == "mm"
    assert display_unit("ruler_length", "s", "deg/s") == "s"  # not of that kind
    assert "ruler_length" in all_quantities()


def test_a_procedure_that_is_gone_says_no_more() -> None:
    assert "ruler_length" not in all_quantities()


@pytest.mark.parametrize("name", list(PROCEDURES))
def test_declared_units_exist_and_are_of_the_declared_kind(name: str) -> None:
    for quantity, said in PROCEDURES[name].quantities().items():
        assert said.kinds or said.shown_by_kind or PROCEDURES[name].inputs.bare, quantity  # in the unit of the file
        assert said.over in {"", *NAMES}
        for sensor, unit in said.shown_by_kind.items():
            assert normalise(unit) == unit
            assert display_unit(quantity, unit, OF_SENSORS[sensor]) == unit
        if said.shown and "{" not in said.shown:
            assert kind(said.shown) in said.kinds


def test_several_procedures_say_one_thing_together() -> None:
    found = all_quantities()["bias"]
    assert found.kinds == ("angular_rate", "acceleration")
    assert found.over == "temperature"
    first, other = Quantity(("time",), shown="h"), Quantity(("length",), over="rate", shown="mm", size=True)
    assert first.joined(other) == Quantity(("time", "length"), "rate", True, "", "h")


def test_values_at_a_place_have_no_budget_of_their_own() -> None:
    keys = (Key("bias", "x"), Key("bias", "x", at=At("temperature", 20.0, "degC")), Key("bias", "y"))
    estimate = Estimate(keys, np.zeros(3), ("rad/s",) * 3, (Component("scatter", "A", np.eye(3), 4.0),))
    assert [(one.key.axis, one.at) for one in budget_figures(estimate)] == [("x", 0), ("y", 2)]
    named = budget_figures(estimate, [key._replace(quantity="left") for key in keys])
    assert [one.key.quantity for one in named] == ["left", "left"]


def test_an_exclusion_is_written_in_the_unit_of_its_sensor() -> None:
    dwell = Exclusion("at_rail", "rule: r = 5", "why", "a.csv:3", "x", applied=np.radians(3.0), unit="rad/s")
    samples = Exclusion("edge", "rule: edge", "why", "a.csv", count=7, counts="sample")
    one, other = exclusion_rows([LeftOut("t", "deg/s", dwell), LeftOut("t", "deg/s", samples)])
    assert (one["applied"], one["unit"], one["count"], one["counts"]) == (3.0, "deg/s", 1, "dwell")
    assert (other["applied"], other["unit"], other["count"], other["counts"]) == (None, "", 7, "sample")


def test_a_flip_names_the_axis_that_it_did_not_read() -> None:
    said = Remark("gain_changed", "warning", "y is not read", axis="y")
    nothing = {axis: np.array([np.nan, 0.0]) for axis in "xy"}
    readings: Any = SimpleNamespace(remarks=(said,), outputs=nothing, where=("a: window 1", "a: window 2"))
    test: Any = SimpleNamespace(plan=FlipPlan(), readings=readings)
    (one,) = PROCEDURES["flip"].exclusions(test)
    assert (one.axis, one.place, one.rule, one.dwell) == ("y", "a: window 1", "gain_changed", True)


@pytest.mark.parametrize(("corrected", "quantity"), [(False, "bias"), (True, "model_bias_error")])
def test_what_a_ground_model_leaves_of_the_bias_is_its_error(corrected: bool, quantity: str) -> None:
    result: Any = SimpleNamespace(plan=FlipPlan(corrected=corrected))
    assert PROCEDURES["flip"].called(result, Key("bias", "x")) == Key(quantity, "x")
    assert PROCEDURES["flip"].called(result, Key("reading", "x")) == Key("reading", "x")


OPEN = {"second_order", "third_order", "scale_factor_error_temperature_1"}  # shown as the one procedure says that does


def test_procedures_that_give_a_figure_of_one_name_show_it_in_one_unit() -> None:
    """What one leaves open is as another has it: a new procedure could change the unit of a figure of all."""
    said: dict[str, set[tuple[str, str]]] = {}
    for one in PROCEDURES.values():
        for name, quantity in one.quantities().items():
            said.setdefault(name, set()).add((quantity.shown, str(quantity.shown_by_kind)))
    assert {name for name, units in said.items() if len(units) > 1} == OPEN
