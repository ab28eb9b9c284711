"""Settings of a Plan: one list, from its fields."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from typing import Literal

import pytest

from inertialcal.core.settings import fact, setting, settings_of
from inertialcal.procedures.flip import plan as flip
from inertialcal.procedures.sensitivity import plan as sensitivity


@dataclass(frozen=True)
class Inner:
    """Settings of its own."""

    tilt: float = setting("Of the axis.", unit="rad", example="1 deg")


@dataclass(frozen=True)
class Plan:
    """All kinds of settings."""

    order: int | None = setting("Of the law.", None, above=0, most=9, example="3")
    at: list[float] | None = setting("Where.", None, unit="degC", example="20 degC")
    range: float = setting("That is needed.", 10.0, difference="degC", least=0.0, example="10 K")
    level: Literal["one", "two"] = setting("Which.", "one")
    lines: bool = setting("Whether.", True)
    inner: Inner | None = setting("How it lies.", None, example='{ tilt = "1 deg" }')
    latitude: float | None = fact("Of the site.", "site", None)


def test_settings_say_unit_limits_and_choices_and_leave_facts_out() -> None:
    found = {one.name: one for one in settings_of(Plan)}
    assert list(found) == ["order", "at", "range", "level", "lines", "inner"]
    assert (found["order"].number, found["order"].above, found["order"].most) == (int, 0, 9)
    assert (found["at"].unit, found["at"].many, found["at"].number) == ("degC", True, None)
    assert (found["range"].difference, found["range"].least, found["range"].default) == (True, 0.0, 10.0)
    assert found["level"].choices == ("one", "two")
    assert found["lines"].flag
    assert found["inner"].table is Inner
    assert not any(one.needed for one in found.values())


def test_a_setting_without_default_is_needed() -> None:
    (tilt,) = settings_of(Inner)
    assert tilt.needed
    assert tilt.default is None
    with pytest.raises(TypeError):
        Inner()


def test_lists_and_named_values_are_written_as_toml_takes_them() -> None:
    for kind in (sensitivity.Plan, flip.Plan):
        for one in settings_of(kind):
            if one.example and one.table is None:
                assert one.name in tomllib.loads(one.written)
    found = {one.name: one.written for one in settings_of(sensitivity.Plan)}
    assert found["to"] == 'to = ["supply"]'
    assert found["references"] == 'references = { supply = "5 V" }'
