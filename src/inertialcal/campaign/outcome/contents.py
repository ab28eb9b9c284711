"""What ``results.json`` holds: set-up, sequence, rows, covariances, budgets, curves, verdicts, closed loop, matrix."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any, NamedTuple

from ...core.estimate import Component, Estimate
from ...core.influence import Influence, Standards, influence_fields, lasting, standard_of
from ...core.judging import Verdict
from ...core.key import Key, Method
from ...core.remarks import Remark, condensed
from ...core.results import SCHEMA, Row, finite, key_fields
from ...core.schema.standards import STANDARDS
from ...core.show.rounding import uncertainty
from ...core.times import instant_text
from ...core.units import Quantity, convert, divide, factor
from ...procedures import loaded_procedures, procedure_of
from ...procedures.display import (
    display_unit,
    displayed,
    displayed_curve,
    scaled,
    scaled_interval,
    stated_unit,
    ten_digits,
)
from ...procedures.protocol import BudgetFigure, Procedure, budget_figures
from ..engine.engine import Prepared, ReducedTest, sensor_of
from ..file.conditions import chosen_tests, conditions_of
from ..file.load import Campaign
from ..file.schema import CampaignFile, Site
from ..file.sensors import Sensor
from ..inputs.sources import Origin
from ..models.content import closed_loop_content, named_models, parameter_rows
from ..models.judged import NOT_RUN, Modelled
from .budget import advice, budgeted, deciding_u
from .compensated import Compensation
from .exclusions import LeftOut, exclusion_rows, left_out
from .requirements import judge, margin, rule_text, worst


def results_content(
    campaign: Campaign,
    prepared: Sequence[Prepared],
    tested: Sequence[ReducedTest],
    modelled: Modelled | None,
    remarks: Sequence[Remark],
    figures: Figures,
) -> dict[str, Any]:
    """Return the content of ``results.json``.

    Parameters
    ----------
    campaign : Campaign
        As read.
    prepared : sequence of Prepared
        Every test, ready to be reduced.
    tested : sequence of ReducedTest
        Every test, with its rows, SI; they come out in the units of the campaign.
    modelled : Modelled or None
        Model and closed loop.
    remarks : sequence of Remark
        Of all tests.
    figures : Figures
        Of `figures_and_verdicts`.
    """
    rows, judged = figures.rows, figures.judged
    judged_rows = [{**one} for one in figures.verdicts]
    verdicts = [verdict for verdict, _ in judged]
    unused = left_out(campaign, prepared, tested)
    general = campaign.file.decision.made()
    unit = campaign.file.sensors[next(iter(campaign.file.sensors))].unit
    results: dict[str, Any] = {
        "schema": SCHEMA,
        "campaign": campaign.file.campaign.model_dump(),
        "item": campaign.file.item.content(),
        "site": site_content(campaign.file.site),
        "sensors": sensors_content(campaign.file.sensors),
        "standards": standards_rows(campaign, tested),
        "influences": {name: influence_fields(one) for name, one in sorted(campaign.standards.items())},
        "occasions": _occasions(campaign, tested, modelled),
        "sequence": sequence_rows(campaign.file, prepared, unused),
        "exclusions": exclusion_rows(unused),
        "results": [row.to_dict() for row in rows],
        "covariances": [c for one in tested for kind in one.parts if (c := _covariance(one, kind)) is not None],
        "budgets": _budgets(campaign, tested, modelled),
        "curves": curves_content(campaign, tested, modelled),
        "remarks": [remark.to_dict() for remark in condensed(remarks)],
        "decision_rule": rule_text(general),
        "verdicts": judged_rows,
        "closed_loop": closed_loop_content(campaign, modelled, unit, [one for each in tested for one in each.errors]),
        "verification": _verification(campaign, verdicts, modelled),
    }
    _with_advice(judged_rows, results, [quantity for _, quantity in judged])
    return results


class Figure(NamedTuple):
    """A figure of a campaign before it is published: SI, with all that its published row is made of."""

    row: Row  # SI
    sensor_unit: str  # Of its sensor
    test: str  # Or model, whose name the row has
    condition: str
    # That it comes from, and its place there; None where the row itself says all that it shares
    estimate: Estimate | None = None
    at: int = 0

    def fields(self, standards: Standards) -> dict[str, Any]:
        """Return what its published row says beyond it, SI: whose it is, what it shares with other tests."""
        row, shared, curvature = self.row, self.row.shared, self.row.curvature
        if self.estimate is not None:
            shared = shared or self.estimate.shared_at(self.at)
            curvature = curvature or self.estimate.curvature_at(self.at)
        lasts = lasting(shared, row.u, standards)
        return {"test": self.test, "condition": self.condition, "shared": lasts, "curvature": curvature}

    def published(self, standards: Standards) -> Row:
        """Return its row in the unit of its sensor."""
        return displayed(self.row, self.sensor_unit, **self.fields(standards))


@dataclass(frozen=True, eq=False)
class Figures:
    """What a campaign found and what is said of it, without what explains it: budgets, curves, advice.

    Parameters
    ----------
    found : list of Figure
        Of tests and models.
    verdicts : list of dict
        Of ``results.json``, without advice.
    judged : list of (Verdict, str)
        Behind each of them its Verdict, and the quantity asked for.
    standards : mapping of Influence
        Of the campaign.
    """

    found: list[Figure]
    verdicts: list[dict[str, Any]]
    judged: list[tuple[Verdict, str]]
    standards: Standards

    @cached_property
    def rows(self) -> list[Row]:
        """Rows of ``results.json``."""
        return [one.published(self.standards) for one in self.found]


def figures_and_verdicts(campaign: Campaign, tested: Sequence[ReducedTest], modelled: Modelled | None) -> Figures:
    """Return the figures of a campaign, and the verdicts on them in the units of its sensors."""
    found = [figure for one in tested for figure in _of_test(campaign, one)]
    for name, (unit, one) in named_models(campaign, modelled).items():
        estimate = None if one.model is None else one.model.estimate
        rows, count = parameter_rows(one), 0 if estimate is None else len(estimate.keys)
        found += [Figure(row, unit, name, one.condition, estimate, at) for at, row in enumerate(rows[:count])]
        found += [Figure(row, unit, name, one.condition) for row in rows[count:]]
    judged: list[tuple[Verdict, str]] = []
    tests = {one.test.id: one.test for one in tested}
    unit = campaign.file.sensors[next(iter(campaign.file.sensors))].unit
    general = campaign.file.decision.made()
    compensation = Compensation(campaign.file, () if modelled is None else modelled.delivered)
    for requirement in campaign.file.requirements:
        verdicts, more = judge(requirement, tested, general, compensation)
        judged += [(verdict, requirement.quantity) for verdict in verdicts]
        stated = [(row, tests[row.test].condition if row.test in tests else row.condition) for row in more]
        known_rows = {(one.test, one.row.key, one.row.case._replace(condition=one.condition)) for one in found if more}
        found += [
            Figure(row, unit, row.test, condition) for row, condition in stated
            if (row.test, row.key, row.case._replace(condition=condition)) not in known_rows
        ]  # fmt: skip
    verdict_rows = [
        _verdict_row(
            verdict,
            sensor_of(campaign, tests[verdict.test], verdict.sensor).unit if verdict.test in tests else unit,
            asked,
        )
        for verdict, asked in judged
    ]
    return Figures(found, verdict_rows, judged, campaign.standards)


def displayed_rows(campaign: Campaign, tested: Sequence[ReducedTest]) -> list[Row]:
    """Return the rows of tests in the units of their sensors, each with its condition and what it shares."""
    return [one.published(campaign.standards) for each in tested for one in _of_test(campaign, each)]


def with_shared(campaign: Campaign, one: ReducedTest) -> list[Row]:
    """Return the rows of a test, SI, each with its condition and what it shares."""
    return [each.row.changed(**each.fields(campaign.standards)) for each in _of_test(campaign, one)]


def _of_test(campaign: Campaign, one: ReducedTest) -> list[Figure]:
    """Return the figures of a test."""
    name, condition, plain = one.test.id, one.test.condition, Method.RESULT
    kinds = dict.fromkeys([row.key.sensor for row in one.rows])
    units = {kind: sensor_of(campaign, one.test, kind).unit for kind in kinds}
    known = {kind: _known(one, kind) for kind in kinds if kind in one.parts}
    nothing: tuple[Estimate | None, Mapping[Key, int]] = None, {}
    found = []
    for row in one.rows:
        key = row.key
        if row.u is not None and row.method is plain and row.member is None:
            estimate, at = known.get(key.sensor, nothing)
            place = at.get(key)
            if place is not None:
                found.append(Figure(row, units[key.sensor], name, condition, estimate, place))
                continue
        found.append(Figure(row, units[key.sensor], name, condition))
    return found


def _known(one: ReducedTest, kind: str) -> tuple[Estimate | None, Mapping[Key, int]]:
    """Return the estimate of a sensor, and the place of each of its values by the key of its row."""
    part, procedure = one.parts[kind], one.procedure
    if part.estimate is None:
        return None, {}
    keys = part.estimate.keys
    if type(procedure).called is not Procedure.called:
        keys = tuple([procedure.called(part, key) for key in keys])
    return part.estimate, _places(keys, kind)


@lru_cache(maxsize=256)  # the same of all units that are tested alike
def _places(keys: tuple[Key, ...], kind: str) -> Mapping[Key, int]:
    own = {key._replace(sensor=kind): at for at, key in enumerate(keys)} if kind else {}
    return MappingProxyType(own | {key: at for at, key in enumerate(keys)})


def _occasions(
    campaign: Campaign, tested: Sequence[ReducedTest], modelled: Modelled | None
) -> dict[str, dict[str, Any]]:
    """Return what drew the errors of standards, by test, and by model with the tests that it is made of."""
    by_test = {one.test.id: (one.tested.occasion, [one.test.id]) for one in tested}
    models = {
        name: (one.model.occasion, list(one.model.tests))
        for name, (_, one) in named_models(campaign, modelled).items()
        if one.model is not None
    }
    return {name: occasion._asdict() | {"tests": tests} for name, (occasion, tests) in (by_test | models).items()}


def _budgets(campaign: Campaign, tested: Sequence[ReducedTest], modelled: Modelled | None) -> list[dict[str, Any]]:
    """Return the budgets of all tests, then those of the model that is delivered."""
    found = []
    exact = {name: one.reason for name, one in campaign.standards.items() if one.u == 0.0}
    for one in tested:
        for kind, part in one.parts.items():
            unit = sensor_of(campaign, one.test, kind).unit
            found += budget_rows(one.test.id, part.estimate, unit, one.procedure.budgeted(part), kind, exact)
    for name, (unit, made) in named_models(campaign, modelled).items():
        if made.model is not None:
            found += budget_rows(name, made.model.estimate, unit, exact=exact)
    return found


def _covariance(one: ReducedTest, kind: str) -> dict[str, Any] | None:
    estimate: Estimate | None = one.parts[kind].estimate
    if estimate is None:
        return None
    return {
        "test": one.test.id,
        "keys": [key_fields(key) | ({"sensor": kind} if kind else {}) for key in estimate.keys],
        "units": list(estimate.units),
        "matrix": estimate.covariance.tolist(),
    }


def _verdict_row(verdict: Verdict, sensor_unit: str, quantity: str) -> dict[str, Any]:
    relative = verdict.unit == "1"
    unit = "%" if relative else display_unit(quantity, verdict.unit, sensor_unit) if verdict.unit else ""
    scale = factor(verdict.unit, unit) if verdict.unit else 1.0
    interval = scaled_interval(verdict.interval, scale)
    lower, upper = scaled(verdict.lower, scale), scaled(verdict.upper, scale)
    basis, compared = verdict.basis, scaled_interval(verdict.basis.compared, scale)
    shown = sensor_unit if verdict.at_unit == "rad/s" else verdict.at_unit
    at = None if verdict.at is None else ten_digits(float(convert([verdict.at], verdict.at_unit, shown)[0]))
    return {
        "requirement": verdict.requirement, "quantity": quantity, "test": verdict.test, "axis": verdict.axis,
        "sensor": verdict.sensor, "at": at, "at_unit": shown if at is not None else "", "of": verdict.of,
        "value": finite(scaled(verdict.value, scale)), "u": finite(scaled(verdict.u, scale)), "unit": unit,
        "interval": None if interval is None else
        {"lo": finite(interval.lo), "hi": finite(interval.hi), "p": interval.p},
        "lower": lower, "upper": upper, "margin": margin(compared or interval, lower, upper),
        "deciding_u": _deciding_u(verdict, scale),
        "verdict": verdict.verdict, "reason": verdict.reason, "rule": basis.rule,
        "accept_lower": scaled(basis.accept_lower, scale), "accept_upper": scaled(basis.accept_upper, scale),
        "risk": basis.risk, "ratio": basis.ratio,
        "readings": verdict.readings,
        "as_read": None if verdict.as_read is None else _as_read(verdict.as_read, scale, lower, upper),
    }  # fmt: skip


def _as_read(verdict: Verdict, scale: float, lower: float | None, upper: float | None) -> dict[str, Any]:
    """Return what was read before compensation, in the unit of the verdict that it stands beside."""
    interval, compared = (scaled_interval(one, scale) for one in (verdict.interval, verdict.basis.compared))
    return {
        "value": finite(scaled(verdict.value, scale)), "u": finite(scaled(verdict.u, scale)),
        "interval": None if interval is None else
        {"lo": finite(interval.lo), "hi": finite(interval.hi), "p": interval.p},
        "margin": margin(compared or interval, lower, upper), "verdict": verdict.verdict,
    }  # fmt: skip


def _deciding_u(verdict: Verdict, scale: float) -> float | None:
    """Return what u would decide a single figure; None where u is not what keeps it from being decided."""
    undecided = verdict.verdict == "INCONCLUSIVE" and verdict.at is None and not verdict.basis.in_doubt
    compared = verdict.basis.compared if undecided else None
    return scaled(deciding_u(verdict.value, verdict.u, compared, verdict.lower, verdict.upper), scale)


def _with_advice(verdicts: list[dict[str, Any]], results: Mapping[str, Any], asked: Sequence[str]) -> None:
    """Add to the reason of what is not decided which u would decide, and what must improve for it."""
    known = {(one.row["test"], one.row["quantity"], one.row["axis"], one.row["sensor"]): one
             for one in budgeted(results) if one.row["at"] is None}  # fmt: skip
    for verdict, quantity in zip(verdicts, asked, strict=True):
        one = known.get((verdict["test"], quantity, verdict["axis"], verdict["sensor"]))
        if verdict["deciding_u"] is not None and one is not None:
            found = advice(one.sources, verdict["deciding_u"], verdict["unit"])
            size = f"{uncertainty(verdict['deciding_u'])} {verdict['unit']}".removesuffix(" 1")
            verdict["reason"] += f"; u = {size} would decide: {found}"


def _verification(campaign: Campaign, verdicts: Sequence[Verdict], modelled: Modelled | None) -> list[dict[str, Any]]:
    """Rows of the verification matrix: requirement, method, evidence, verdict; untested requirements are OPEN."""
    rows: list[dict[str, Any]] = []
    for requirement in campaign.file.requirements:
        mine = [one for one in verdicts if one.requirement == requirement.id]
        is_open = all(one.verdict == "OPEN" for one in mine)
        rows.append(
            {
                "requirement": requirement.id, "text": requirement.text, "method": "" if is_open else "test",
                "evidence": list(dict.fromkeys(one.test for one in mine if one.test)),
                "verdict": "OPEN" if is_open else worst(mine),
                "rule": mine[0].basis.rule,
                "decision": (requirement.decision or campaign.file.decision).model_dump(exclude_none=True),
            }
        )  # fmt: skip
    if modelled is not None and modelled.whole_verdict != NOT_RUN:
        held = [test.id for test in campaign.file.tests if test.use == "hold_out"]
        text = "compensation improves readings that the model has not seen"
        row = {
            "requirement": "closed loop",
            "text": text,
            "method": "test",
            "evidence": held,
            "verdict": modelled.whole_verdict,
            "rule": "",
            "decision": {},
        }
        rows.append(row)
    return rows


SITE = {"latitude": ("rad", "deg"), "height": ("m", "m"), "gravity": ("m/s^2", "m/s^2")}


CHAIN = {"lsb": "V", "reference": "V", "validity_minimum": "V", "gate": "s"}


def site_content(site: Site) -> dict[str, str | None]:
    """Return latitude, height and gravity as text; null where the campaign does not say them."""
    return {name: _text(getattr(site, name), *units) for name, units in SITE.items()}


def sensors_content(sensors: dict[str, Sensor]) -> dict[str, Any]:
    """Return kind, axes, unit, range, mounting and signal chain of each sensor."""
    return {name: sensor.model_dump() | {"chain": _chain(sensor)} for name, sensor in sensors.items()}


def _chain(sensor: Sensor) -> dict[str, Any]:
    said = sensor.chain.model_dump()
    pair = said["counts"]
    given = {name: _text(said[name], unit, unit) for name, unit in CHAIN.items() if isinstance(said[name], float)}
    return said | given | {"counts": None if pair is None else list(pair)}


def _text(value: float | None, unit: str, shown: str) -> str | None:
    if value is None or unit == shown:
        return None if value is None else str(Quantity(value, unit))
    return str(Quantity(ten_digits(float(convert(value, unit, shown))), shown))


def curves_content(
    campaign: Campaign, tested: Sequence[ReducedTest], modelled: Modelled | None
) -> list[dict[str, Any]]:
    """Return the curves of all tests, and those of the closed loop, as ``results.json`` holds them.

    Parameters
    ----------
    campaign : Campaign
        As read.
    tested : sequence of ReducedTest
        Every test.
    modelled : Modelled or None
        Model and closed loop.
    """
    found = []
    for one in tested:
        for kind, part in one.parts.items():
            unit = sensor_of(campaign, one.test, kind).unit
            found += [displayed_curve(curve, unit).to_dict(one.test.id) for curve in one.procedure.curves(part)]
    for one in tested:
        unit = sensor_of(campaign, one.test).unit
        found += [displayed_curve(curve, unit).to_dict(one.test.id) for curve in (*one.curves, *one.saves)]
    for name, (unit, made) in named_models(campaign, modelled).items():
        found += [displayed_curve(curve, unit).to_dict(name) for curve in made.curves]
    return found


def sequence_rows(
    file: CampaignFile, prepared: Sequence[Prepared], exclusions: Sequence[LeftOut]
) -> list[dict[str, Any]]:
    """Return one row a test, in the order run.

    Parameters
    ----------
    file : CampaignFile
        What the campaign says.
    prepared : sequence of Prepared
        Every test.
    exclusions : sequence of LeftOut
        Of all tests; a dwell that several sensors leave out counts once.
    """
    return [_step(file, one, exclusions) for one in prepared]


def _step(file: CampaignFile, one: Prepared, exclusions: Sequence[LeftOut]) -> dict[str, Any]:
    test = one.test
    out = {left.what.place for left in exclusions if left.test == test.id and left.what.dwell}
    windows = [[instant_text(start), instant_text(stop)] for start, stop in test.windows or []]
    sensors = list(dict.fromkeys(file.recordings[name].sensor for name in test.recordings))
    terms: dict[str, list[str]] = {}
    for sensor in sensors:
        for condition in conditions_of(file, sensor):
            for kind, tests in chosen_tests(file, sensor, condition).items():
                if test.id in {each.id for each in tests} and kind not in terms.setdefault(condition, []):
                    terms[condition].append(kind)
    terms = {condition: kinds for condition, kinds in terms.items() if kinds}
    return {
        "test": test.id, "procedure": test.procedure, "use": test.use, "condition": test.condition,
        "sensors": sensors, "terms": terms, "source": test.source, "against": test.against, "after": list(test.after),
        "groups": test.groups, "windows": windows or None,
        "recordings": [_recording(origin) for origin in one.origins],
        "dwells": len(one.readings) if procedure_of(test.procedure).counts_dwells else None,
        "runs": getattr(one.readings, "runs", None), "left_out": len(out),
    } | ({} if one.span is None else {"time": [instant_text(end) for end in one.span]})  # fmt: skip


def _recording(origin: Origin) -> dict[str, Any]:
    return {
        "name": origin.name, "file": origin.file, "sha256": origin.sha256, "kind": origin.kind, "rows": origin.rows,
    }  # fmt: skip


def standards_rows(campaign: Campaign, tested: Sequence[ReducedTest]) -> list[dict[str, Any]]:
    """Return all influences that are stated, as stated, and those that are not and would change the result of a test.

    Parameters
    ----------
    campaign : Campaign
        As read.
    tested : sequence of ReducedTest
        Every test.
    """
    names = [f"{standard}.{influence}" for standard, inner in STANDARDS.items() for influence in inner]
    stated = [(name, campaign.standards.get(name)) for name in names]
    return [
        _standard(name, one, _effect(name, tested))
        for name, one in stated
        if one is not None or any(t.procedure.needs(name, t.result) for t in tested)
    ]


def _effect(name: str, tested: Sequence[ReducedTest]) -> str:
    """Say what an influence changes in the tests that were run; of none of them, what it changes at all."""
    found = [one.procedure.effects().get(name, "") for one in tested]
    every = (one.effects()[name] for one in loaded_procedures() if name in one.effects())
    return "; ".join(dict.fromkeys(effect for effect in found if effect)) or next(every, "")


def _standard(name: str, influence: Influence | None, effect: str) -> dict[str, Any]:
    standard, quantity = standard_of(name)
    head = {"standard": standard, "influence": quantity, "effect": effect}
    if influence is None:
        return head | {
            "u": None, "unit": "", "dof": None, "distribution": "", "certificate": "", "reason": "", "stated": False,
        }  # fmt: skip
    u, unit = influence.stated
    return head | {
        "u": u, "unit": unit, "dof": finite(influence.dof),
        "distribution": influence.distribution, "certificate": influence.certificate, "reason": influence.reason,
        "stated": True,
    }  # fmt: skip


ROUNDING = 1e-20  # share of a variance that cannot be told from none: 1e-10 of u


def budget_rows(
    test: str,
    estimate: Estimate | None,
    sensor_unit: str,
    figures: Sequence[BudgetFigure] | None = None,
    sensor: str = "",
    exact: Mapping[str, str] | None = None,
) -> list[dict[str, Any]]:
    """Return the sources of uncertainty of each figure, in the units of the campaign.

    Parameters
    ----------
    test : str
        Name of the test, or ``"model"``.
    estimate : Estimate or None
        SI.
    sensor_unit : str
        As the campaign has it: ``"deg/s"``.
    figures : sequence of BudgetFigure, optional
        Those that have a budget; all values of the estimate by default.
    sensor : str
        Kind of sensor, where the test has several.
    exact : mapping of str to str, optional
        Why the uncertainty of an influence is zero, by its name: those stand in the budget, too.
    """
    exact = exact or {}
    if estimate is None:
        return []
    found = []
    for figure in budget_figures(estimate) if figures is None else figures:
        total = float(estimate.covariance[figure.at, figure.at])
        for component in estimate.components:
            share = float(component.covariance[figure.at, figure.at]) / total if total > 0.0 else 0.0
            reason = exact.get(component.influence, "")
            if share > ROUNDING or reason:
                key = key_fields(figure.key) | ({"sensor": sensor} if sensor else {})
                row = {"test": test} | key | _contribution(figure, component, sensor_unit) | {"share": share}
                found.append(row | ({"source": f"{component.source} (exact: {reason})"} if reason else {}))
    return found


def _contribution(figure: BudgetFigure, component: Component, sensor_unit: str) -> dict[str, Any]:
    unit = display_unit(figure.key.name, figure.unit, sensor_unit)
    u = float(component.u[figure.at]) * figure.times * factor(figure.unit, unit, difference=True)
    dof = component.dof if isinstance(component.dof, float) else float(component.dof[figure.at])
    return {
        "source": component.source, "influence": component.influence, "kind": component.kind,
        "level": component.origin.level,
        "distribution": component.distribution,
        **_sensitivity(component, u, unit, sensor_unit), "u": u, "unit": unit, "dof": finite(dof),
    }  # fmt: skip


def _sensitivity(component: Component, u: float, unit: str, sensor_unit: str) -> dict[str, Any]:
    """Return what the source itself has, and how the figure follows it."""
    if component.stated is not None:
        own, own_unit = component.stated
        shown = stated_unit(own_unit, sensor_unit)
        if shown != own_unit:  # 3 deg went through radians and shall come out as 3
            own = ten_digits(own * factor(own_unit, shown, difference=True))
        return {
            "stated_u": own, "stated_unit": shown,
            "sensitivity": u / own if own else None, "sensitivity_unit": divide(unit, shown),
        }  # fmt: skip
    if component.kind == "A":
        return {"stated_u": u, "stated_unit": unit, "sensitivity": 1.0, "sensitivity_unit": "1"}
    return {"stated_u": None, "stated_unit": "", "sensitivity": None, "sensitivity_unit": ""}
