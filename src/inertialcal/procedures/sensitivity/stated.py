"""Terms that are known from elsewhere: a data sheet, another test. Type B, taken off before the fit."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass

from ...core.errors import DataError, PlanError
from ...core.key import Key
from ...core.units import parse_quantity
from .design import Column, Design
from .plan import Plan

NEEDED = ("value", "u", "source")


@dataclass(frozen=True, eq=False)
class Stated:
    """A term that was stated: value and standard uncertainty [unit of its column]."""

    key: Key
    value: float
    u: float
    source: str
    column: Column


def stated_terms(plan: Plan, design: Design) -> tuple[Stated, ...]:
    """Return the terms of one sensor that are stated, by the name of the quantity or with the axis: ``bias_supply_x``.

    Raises
    ------
    PlanError
        ``wrong_value`` if one is not said with value, u and source, in a unit of its kind.
    """
    found = []
    for one in design.columns:
        names = () if one.key is None else (str(one.key), one.key.name)
        name = next((name for name in names if name in plan.stated), None)
        if name is None or one.key is None:
            continue
        said = stated_table(name, plan.stated[name])
        try:
            value, u = (parse_quantity(said[part]).to(one.unit) for part in ("value", "u"))
        except DataError as error:
            one_problem = error.problems[0]
            what = f"stated.{name}: {one_problem.what}"
            raise PlanError(what, why=one_problem.why, do=one_problem.do, code=one_problem.code) from None
        found.append(Stated(one.key, value, u, said["source"], one))
    return tuple(found)


def stated_table(name: str, said: object) -> Mapping[str, str]:
    """Return what is said of a term, from a table or its text.

    Raises
    ------
    PlanError
        ``wrong_value``, ``not_toml``.
    """
    if isinstance(said, str):
        try:
            said = tomllib.loads(f"said = {said}")["said"]
        except tomllib.TOMLDecodeError as error:
            raise PlanError(f"stated.{name}: not a TOML table: {error}", code="not_toml") from None
    if not isinstance(said, Mapping) or set(said) != set(NEEDED) or not all(isinstance(v, str) for v in said.values()):
        do = f'Write {name} = {{ value = "0.01 deg/s/V", u = "0.002 deg/s/V", source = "data sheet" }}'
        raise PlanError(f"stated.{name}: needs value, u and source, as text", do=do, code="wrong_value")
    return {str(key): str(value) for key, value in said.items()}
