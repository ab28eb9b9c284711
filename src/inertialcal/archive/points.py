"""Figures of an archive with what they share: rows of tests in order of time, unknowns by their identity.

Two figures share an error where nothing has drawn it anew in between (``core.influence.Drawn``): one certificate and
period, one site, or one mounting, power-up or day that both state. What nobody stated counts as independent.
Only the newest version of each campaign counts.
"""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from operator import itemgetter
from typing import Any

from sqlalchemy import ColumnElement, Connection, Select, func, not_, select
from sqlalchemy import Row as Found

from ..core.influence import OF_UNIT, Drawn, Influence, Occasion, influence_of
from ..core.key import NO_REASON, At, Key, Method
from ..core.results import Curvature, Interval, Row
from ..core.units import factor
from ..statistics.difference import Figure
from .tables import campaigns, items, results, standards, tests

FoundRow = Found[Any]  # of the query of `points`
# Of a row, that make a figure
PARTS = ("campaign_id", "serial", "value", "u", "dof", "shared", "curvature", "first_ns", "last_ns",
         *Occasion._fields)  # fmt: skip
AT_ONCE = 5_000  # campaigns that one query names


@dataclass(frozen=True, eq=False)
class Point:
    """One figure of a unit."""

    found: FoundRow  # As the archive has it
    figure: Figure  # In its unit, its unknowns by their identity
    time_ns: int | None  # Middle of the test, UTC; None where that is not known

    @property
    def campaign(self) -> int:
        """Number of the campaign in the archive."""
        return int(self.found.campaign_id)

    @property
    def name(self) -> str:
        """Name of the campaign."""
        return str(self.found.campaign)

    @property
    def item(self) -> int:
        """Number of the unit in the archive."""
        return int(self.found.item_id)

    @property
    def serial(self) -> str:
        """Serial number of the unit."""
        return str(self.found.serial)

    @property
    def lot(self) -> str:
        """Lot of the unit, as the campaign states it."""
        return str(self.found.lot)

    @cached_property
    def row(self) -> Row:
        """As results have it."""
        return _row(self.found)


def newest() -> ColumnElement[bool]:
    """Return the condition that a campaign was not replaced."""
    return not_(campaigns.c.id.in_(select(campaigns.c.replaces).where(campaigns.c.replaces.is_not(None))))


def points(connection: Connection, *conditions: ColumnElement[bool], last: bool = False) -> list[Point]:
    """Return the estimated figures of newest campaigns that fulfil conditions, by time; without a time come last.

    Parameters
    ----------
    connection : Connection
        That reads.
    conditions : ColumnElement
        Of ``results``, ``campaigns``, ``items`` and ``tests``.
    last : bool
        Of each unit the last figure of a kind alone.
    """
    columns = [
        *(one for one in results.c if one.name not in ("position", "reason_code", "reason")),
        campaigns.c.name.label("campaign"),
        campaigns.c.lot,
        campaigns.c.item_id,
        items.c.serial,
        tests.c.first_ns,
        tests.c.last_ns,
        tests.c.mounting,
        tests.c.power_up,
        tests.c.day,
        tests.c.site,
    ]
    alike = (
        campaigns.c.item_id,
        results.c.quantity,
        results.c.axis,
        results.c.sensor,
        results.c.power,
        results.c.at_what,
        results.c.at_value,
        results.c.test,
        results.c.condition,
    )
    newer = func.row_number().over(partition_by=alike, order_by=(tests.c.first_ns.desc(), campaigns.c.id.desc()))
    query: Select[Any] = (
        select(*columns, *([newer.label("newer")] if last else []))
        .join(campaigns, campaigns.c.id == results.c.campaign_id)
        .join(items, items.c.id == campaigns.c.item_id)
        .join(tests, (tests.c.campaign_id == results.c.campaign_id) & (tests.c.name == results.c.test))
        .where(results.c.status == "estimated", results.c.method == Method.RESULT.value, results.c.member_kind == "",
               results.c.u.is_not(None), newest(), *conditions)
    )  # fmt: skip
    if last:
        inner = query.where(tests.c.first_ns.is_not(None)).subquery()
        query = select(inner).where(inner.c.newer == 1)
    else:
        query = query.order_by(results.c.campaign_id, results.c.position)
    found = connection.execute(query).all()
    known = _influences(connection, {one.campaign_id for one in found})
    made = _made(found, known)
    return sorted(made, key=lambda one: (one.time_ns is None, one.time_ns or 0))


def _made(found: Sequence[FoundRow], known: Mapping[int, Mapping[str, Influence]]) -> list[Point]:
    """Return rows as points; what is equal for many is worked out once."""
    if not found:
        return []
    parts = itemgetter(*(found[0]._fields.index(name) for name in PARTS))
    identities: dict[tuple[str, int, Occasion, str], str] = {}
    made = []
    for row in found:
        number, serial, value, u, dof, shared, curvature, first, last, *occasion = parts(row)
        changes = {}
        for unknown, change in () if shared == "{}" else json.loads(shared).items():
            influence = known[number].get(influence_of(unknown))
            if influence is None:
                continue
            own = serial if influence.redrawn_by in OF_UNIT else ""
            which = unknown, id(influence), Occasion(*occasion), own
            if which not in identities:
                identities[which] = _identity(unknown, influence, which[2], own)
            if identities[which]:
                changes[identities[which]] = change
        time_ns = None if first is None or last is None else (first + last) // 2
        made.append(Point(row, Figure(value, u, dof or math.inf, changes, (), _curvature(curvature)), time_ns))
    return made


def _influences(connection: Connection, numbers: Collection[int]) -> dict[int, dict[str, Influence]]:
    """Return the influences that campaigns state, by number and name; campaigns that state the same share one."""
    known: dict[int, dict[str, Influence]] = {number: {} for number in numbers}
    made: dict[tuple[Any, ...], Influence] = {}
    of = standards.c
    query = select(of.campaign_id, of.name, of.standard, of.quantity, of.u, of.unit, of.certificate, of.valid,
                   of.redrawn_by)  # fmt: skip
    if len(known) <= AT_ONCE:
        query = query.where(of.campaign_id.in_(known))
    for number, name, *stated in connection.execute(query):
        if number in known:
            which = tuple(stated)
            if which not in made:
                standard, quantity, u, unit, certificate, valid, redrawn_by = stated
                made[which] = Influence(u, unit, certificate=certificate, standard=standard, quantity=quantity,
                                        redrawn_by=redrawn_by, valid=valid)  # fmt: skip
            known[number][name] = made[which]
    return known


def _curvature(text: str) -> dict[str, Curvature]:
    content = {} if text == "{}" else json.loads(text)
    return {name: Curvature(term["change"], term["size"]) for name, term in content.items()}


def _identity(unknown: str, influence: Influence, occasion: Occasion, serial: str) -> str:
    """Return what is equal for unknowns that are the same error; empty where no other test is known to share it."""
    which = Drawn(influence, occasion.drew(influence.redrawn_by, influence.standard), serial).identity
    return "" if which is None else json.dumps([unknown, *which])


def _row(one: FoundRow) -> Row:
    """Return a row of ``results`` as results have it."""
    at = At(one.at_what, one.at_value, one.at_unit) if one.at_what else None
    ends = None if one.coverage is None else Interval(one.lower, one.upper, one.coverage)
    return Row(
        Key(one.quantity, one.axis, one.sensor, one.power, at), one.value, one.u, one.unit, one.dof, ends, one.status,
        NO_REASON, one.test, one.condition, Method(one.method), None, json.loads(one.shared), _curvature(one.curvature),
    )  # fmt: skip


def in_unit(found: Sequence[Point], unit: str) -> list[Figure]:
    """Return the figures of points in one unit of their dimension."""
    made = []
    for one in found:
        if one.found.unit == unit:
            made.append(one.figure)
            continue
        scale, figure = factor(one.found.unit, unit, difference=True), one.figure
        changes = {name: change * scale for name, change in figure.changes.items()}
        curvature = {name: term.times(scale) for name, term in figure.curvature.items()}
        made.append(Figure(figure.value * scale, figure.u * scale, figure.dof, changes, (), curvature))
    return made
