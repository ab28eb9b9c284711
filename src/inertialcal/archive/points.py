"""Figures of an archive with what they share: rows of tests in order of time, unknowns by their identity.

Two figures share an error where nothing has drawn it anew in between (``core.influence.Drawn``): one certificate and
period, one site, or one mounting, power-up or day that both state. What nobody stated counts as independent.
Only the newest version of each campaign counts.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import ColumnElement, Connection, Select, not_, select
from sqlalchemy import Row as Found

from ..core.influence import Drawn, Influence, Occasion, influence_of
from ..core.key import NO_REASON, At, Key, Member, Method, Reason
from ..core.results import Curvature, Interval, Row
from ..core.units import factor
from ..statistics.difference import Figure
from .tables import campaigns, items, results, standards, tests

SECONDS = 1e9  # [ns]


@dataclass(frozen=True, eq=False)
class Point:
    """One figure of a unit."""

    campaign: int  # Number in the archive
    name: str  # Of the campaign
    serial: str
    first_ns: int | None  # When, UTC; None where that is not known
    last_ns: int | None
    row: Row
    figure: Figure  # In the unit of the row, its unknowns by their identity

    @property
    def time_ns(self) -> int | None:
        """Middle of the test."""
        return None if self.first_ns is None or self.last_ns is None else (self.first_ns + self.last_ns) // 2


def newest() -> ColumnElement[bool]:
    """Return the condition that a campaign was not replaced."""
    return not_(campaigns.c.id.in_(select(campaigns.c.replaces).where(campaigns.c.replaces.is_not(None))))


def points(connection: Connection, *conditions: ColumnElement[bool]) -> list[Point]:
    """Return the estimated figures of newest campaigns that fulfil conditions, by time; without a time come last."""
    query: Select[Any] = (
        select(results, campaigns.c.name.label("campaign"), items.c.serial,
               tests.c.first_ns, tests.c.last_ns, tests.c.mounting, tests.c.power_up, tests.c.day, tests.c.site)
        .join(campaigns, campaigns.c.id == results.c.campaign_id)
        .join(items, items.c.id == campaigns.c.item_id)
        .join(tests, (tests.c.campaign_id == results.c.campaign_id) & (tests.c.name == results.c.test))
        .where(results.c.status == "estimated", results.c.method == Method.RESULT.value, results.c.member_kind == "",
               results.c.u.is_not(None), newest(), *conditions)
        .order_by(results.c.campaign_id, results.c.position)
    )  # fmt: skip
    found = connection.execute(query).all()
    known = _influences(connection, {one.campaign_id for one in found})
    drawn: dict[tuple[int, str, str], str] = {}
    made = [_point(one, known[one.campaign_id], drawn) for one in found]
    return sorted(made, key=lambda one: (one.time_ns is None, one.time_ns or 0))


def _influences(connection: Connection, numbers: Iterable[int]) -> dict[int, dict[str, Influence]]:
    """Return the influences that campaigns state, by number and name; campaigns that state the same share one."""
    known: dict[int, dict[str, Influence]] = {number: {} for number in numbers}
    made: dict[tuple[Any, ...], Influence] = {}
    query = select(standards).where(standards.c.campaign_id.in_(known)) if len(known) < 500 else select(standards)
    for one in connection.execute(query):
        if one.campaign_id in known:
            stated = one.standard, one.quantity, one.u, one.unit, one.certificate, one.valid, one.redrawn_by
            if stated not in made:
                made[stated] = Influence(one.u, one.unit, certificate=one.certificate, standard=one.standard,
                                         quantity=one.quantity, redrawn_by=one.redrawn_by, valid=one.valid)  # fmt: skip
            known[one.campaign_id][one.name] = made[stated]
    return known


def _point(one: Found[Any], known: Mapping[str, Influence], drawn: dict[tuple[int, str, str], str]) -> Point:
    row = _row(one)
    occasion = Occasion(one.mounting, one.power_up, one.day, one.site)
    changes = {}
    for unknown, change in row.shared.items():
        which = one.campaign_id, one.test, unknown
        if which not in drawn:
            drawn[which] = _identity(unknown, known.get(influence_of(unknown)), occasion, one.serial)
        if drawn[which]:
            changes[drawn[which]] = change
    figure = Figure(float(one.value), float(one.u), one.dof or math.inf, changes, (), row.curvature)
    return Point(one.campaign_id, one.campaign, one.serial, one.first_ns, one.last_ns, row, figure)


def _identity(unknown: str, influence: Influence | None, occasion: Occasion, serial: str) -> str:
    """Return what is equal for unknowns that are the same error; empty where no other test is known to share it."""
    if influence is None:
        return ""
    which = Drawn(influence, occasion.drew(influence.redrawn_by, influence.standard), serial).identity
    return "" if which is None else json.dumps([unknown, *which])


def _row(one: Found[Any]) -> Row:
    """Return a row of ``results`` as results have it."""
    at = At(one.at_what, one.at_value, one.at_unit) if one.at_what else None
    ends = None if one.coverage is None else Interval(one.lower, one.upper, one.coverage)
    curvature = {} if one.curvature == "{}" else json.loads(one.curvature)
    return Row(
        Key(one.quantity, one.axis, one.sensor, one.power, at), one.value, one.u, one.unit, one.dof, ends, one.status,
        Reason(one.reason_code, one.reason) if one.reason_code else NO_REASON, one.test, one.condition,
        Method(one.method), Member(one.member_kind, one.member) if one.member_kind else None,
        {} if one.shared == "{}" else json.loads(one.shared),
        {name: Curvature(term["change"], term["size"]) for name, term in curvature.items()},
    )  # fmt: skip


def in_unit(found: Sequence[Point], unit: str) -> list[Figure]:
    """Return the figures of points in one unit of their dimension."""
    made = []
    for one in found:
        scale, figure = factor(one.row.unit, unit, difference=True), one.figure
        made.append(
            figure if one.row.unit == unit else
            Figure(figure.value * scale, figure.u * scale, figure.dof,
                   {name: change * scale for name, change in figure.changes.items()}, (),
                   {name: term.times(scale) for name, term in figure.curvature.items()})
        )  # fmt: skip
    return made
