"""The models that a campaign makes: one a sensor and condition, of all its tests with ``use = "fit"``.

A procedure says which terms its tests give, and what they do to readings held out; which tests each kind of term comes
from, ``[model]`` may decide. Here terms are joined with their covariance, and become a model with what the campaign
says of item, output and condition. It is judged on the readings of its condition that were held out, with one verdict.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, reduce
from typing import Any

import numpy as np

from ...core.errors import InertialcalError, PlanError
from ...core.estimate import Component, Estimate
from ...core.influence import Occasion, influence_of
from ...core.remarks import Remark
from ...core.results import changed
from ...core.units import kind
from ...files.models.model_json import dump_each
from ...procedures import procedure_names, procedure_of
from ...procedures.model_terms import HeldOut, ModelTerms, TermKind, joined_terms_many, kind_of
from ...procedures.protocol import Procedure, Tested
from ...sensors.model.assemble import models_from
from ...sensors.model.model_set import ModelSet
from ...sensors.model.sensor_model import Item, SensorModel
from ...statistics.closed_loop import AxisLoop, judged, overall
from ..engine.engine import computable, placed
from ..engine.together import Work, ask
from ..file.conditions import bias_before, chosen_tests, conditions_of, in_condition, on_sensor
from ..file.cross_checks import model_name
from ..file.load import Campaign
from ..file.schema import CampaignFile, Condition, Test
from ..file.sensors import Sensor
from ..inputs.chains import body_scale_factors, model_chain, output_unit
from ..inputs.channels import GAIN
from .judged import NOT_RUN, JudgedModel, Modelled, Residual, ResidualLoop

NOTHING = HeldOut()
PLAIN = ("scale_factor", "misalignment", "asymmetry", "bias")  # kinds that need no condition of the readings
LASTING = ("never", "certificate")  # what draws errors of standards that all tests of a campaign share
OF_ANOTHER = "term_of_another_condition"

Reduced = Mapping[str, Tested[Any, Any, Any]]
Errors = Mapping[str, Sequence[Remark]]  # By test


@dataclass(frozen=True, eq=False)
class Outline:
    """Which tests a model is of, by what the campaign says alone."""

    sensor: str
    condition: str
    chosen: Mapping[TermKind, Sequence[Test]]
    number: int  # Of its first test in the campaign
    behind: tuple[Test, ...]
    own: tuple[Test, ...]  # On its sensor and in its condition
    held: tuple[Test, ...]  # Held out for it


class _Deciding:
    """What of a campaign decides which tests its models are of: the same of all units of a lot."""

    def __init__(self, file: CampaignFile) -> None:
        self.file = file
        self.objects = file.tests, file.sensors, file.model
        self.names = tuple([(name, one.sensor) for name, one in file.recordings.items()]), procedure_names()

    def __hash__(self) -> int:
        return hash((*map(id, self.objects), self.names))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, _Deciding) or self.names != other.names:
            return False
        return all(mine is its for mine, its in zip(self.objects, other.objects, strict=True))


@lru_cache(maxsize=8)
def _outlines(deciding: _Deciding) -> tuple[Outline, ...]:
    file, found = deciding.file, []
    for name in file.sensors:
        for condition in conditions_of(file, name):
            chosen = chosen_tests(file, name, condition)
            number = min(file.tests.index(test) for tests in chosen.values() for test in tests)
            behind = [test for test in file.tests if any(test in tests for tests in chosen.values())]
            own = [
                test for test in file.tests if on_sensor(file, test, name) and in_condition(file, test, name, condition)
            ]
            used = {test.procedure for test in behind}
            judging = {one for one in procedure_names() if one in used or procedure_of(one).judged_alone}
            held = [test for test in own if test.use == "hold_out" and test.procedure in judging]
            found.append(Outline(name, condition, chosen, number, tuple(behind), tuple(own), tuple(held)))
    return tuple(found)


@dataclass(frozen=True, eq=False)
class Part:
    """What tests of one procedure give to a model, from one reduction."""

    procedure: Procedure[Any, Any, Any]
    tests: tuple[Test, ...]
    result: Any  # (Joint) of the procedure, about the kind of the sensor
    whole: ModelTerms  # All that it gives
    terms: ModelTerms  # What the model takes of it


@dataclass(frozen=True, eq=False)
class Made:
    """A model before its verdict."""

    judged: JudgedModel
    first: int  # Number of its first test in the campaign
    loops: tuple[AxisLoop, ...]  # Of tests held out together
    residuals: tuple[ResidualLoop, ...]  # Of tests held out that are judged one by one
    held: frozenset[str]  # Those


def build_models(
    campaign: Campaign, reduced: Reduced, residuals: Mapping[str, Residual], errors: Errors
) -> Work[Modelled | None]:
    """Work out the models of all sensors and conditions, with what was judged without one; None where there is neither.

    There is no model where a test behind it, or held out for it, has a remark that is an error.

    Raises
    ------
    PlanError
        If two tests give one term (``terms_twice``), or tests that belong together differ in their plan; problems
        get the place of the first test of each.
    DataError
        If they cannot be reduced together.
    """
    found: list[Made] = []
    for outline in _outlines(_Deciding(campaign.file)):
        try:
            with computable(campaign.file.tests[outline.number].id):
                made = yield from _build(campaign, outline, reduced, errors)
        except InertialcalError as error:
            raise type(error)([placed(problem, campaign, outline.number) for problem in error.problems]) from None
        if made is not None:
            found.append(made)
    found.sort(key=lambda one: one.first)
    of_models = frozenset(test for one in found for test in one.held)
    alone = tuple(
        ResidualLoop(test, one.against, loop)
        for test, one in residuals.items() if test not in of_models for loop in one.found.loops
    )  # fmt: skip
    families = sum(bool(one.loops or one.residuals) for one in found) + bool(alone)
    share = 1.0 / max(families, 1)
    models = tuple(_with_verdict(one, share, name) for one, name in zip(found, _names(found), strict=True))
    left = _judged_residuals(alone, share)
    return Modelled(models, left) if models or left else None


def _names(found: Sequence[Made]) -> list[str]:
    """Return what the rows of each model are named: the first of the campaign ``model``, and of each sensor by it."""
    known: list[tuple[str, str]] = []
    names = []
    for sensor, condition in ((one.judged.sensor, one.judged.condition) for one in found):
        first = not known or known[0][0] == sensor
        again = any(sensor == before for before, _ in known)
        names.append(model_name("" if first else sensor, condition if again else ""))
        known.append((sensor, condition))
    return names


def _with_verdict(made: Made, share: float, name: str) -> JudgedModel:
    """Return a model with its verdict, Holm once over all that was held out, and the name of its rows."""
    words = judged([*made.loops, *(one.loop for one in made.residuals)], share)
    loops, rest = words[: len(made.loops)], words[len(made.loops) :]
    residuals = tuple(replace(one, loop=loop) for one, loop in zip(made.residuals, rest, strict=True))
    verdict = overall(words) if words else NOT_RUN
    one = made.judged
    passed = verdict == "PASS"
    model = one.model if one.model is None or one.model.judged == passed else replace(one.model, judged=passed)
    remarks = one.remarks
    if one.condition:
        remarks = tuple(remark if remark.where else changed(remark, where=name) for remark in remarks)
    if verdict == "FAIL" and one.condition:
        what = f"the model in {one.condition} does worse on readings held out: it is left out of the model file"
        remarks = (*remarks, Remark("condition_left_out", "warning", what, name, subject=one.condition))
    return changed(one, name=name, model=model, loops=loops, residuals=residuals, verdict=verdict, remarks=remarks)


def _judged_residuals(alone: Sequence[ResidualLoop], share: float) -> tuple[ResidualLoop, ...]:
    words = judged([one.loop for one in alone], share)
    return tuple(replace(one, loop=loop) for one, loop in zip(alone, words, strict=True))


def _build(campaign: Campaign, outline: Outline, reduced: Reduced, errors: Errors) -> Work[Made | None]:
    """Make the model of a sensor in a condition; None where there is none."""
    name, condition, chosen = outline.sensor, outline.condition, outline.chosen
    behind, own, held = outline.behind, outline.own, outline.held
    file, sensor = campaign.file, campaign.file.sensors[name]
    if any(errors.get(test.id) for test in (*behind, *held)):
        return None
    procedures = dict.fromkeys(test.procedure for test in behind)
    every: list[Part] = []
    for one in procedures:
        every += yield from _parts(campaign, one, chosen, reduced, sensor.kind)
    parts = [part for part in every if part.terms.parameters or part.terms.noise is not None]
    if not any(part.terms.parameters for part in parts):
        return None
    matrix = [part for part in parts if any(kind_of(key) == "scale_factor" for key in part.terms.parameters)]
    parts = [*matrix, *(part for part in parts if part not in matrix)]
    for one in procedures:
        _check_alike(procedure_of(one), [test for test in (*behind, *held) if test.procedure == one], reduced)
    model = yield from _model(campaign, sensor, condition, parts, reduced)
    made = JudgedModel(name, condition, model, remarks=tuple(_of_others(file, name, condition, parts)))
    loops: list[AxisLoop] = []
    residuals: list[ResidualLoop] = []
    remarks, curves = list(made.remarks), list(made.curves)
    for one in dict.fromkeys(test.procedure for test in (*behind, *held)):
        procedure = procedure_of(one)
        unseen = [reduced[test.id] for test in held if test.procedure == one]
        mine = [part for part in parts if part.procedure is procedure]
        fitted = [reduced[id] for id in dict.fromkeys(test.id for part in mine for test in part.tests)]
        if procedure.judged_alone:
            # The model is judged, also where its bias is that of another procedure: a test of the condition then tells
            # how power-ups scatter. Accelerometers at rest read gravity too: their bias is not judged so
            has_bias = any(kind_of(key) == "bias" for part in parts for key in part.terms.parameters)
            others = [test for test in own if test.use == "fit" and test.procedure == one]
            fitted = fitted or [reduced[test.id] for test in others if has_bias and sensor.kind == "gyro"]
            for each in unseen if fitted else ():
                result = mine[0].result if mine else fitted[0].result
                found = procedure.held_out(result, fitted[:1], [each], model) or NOTHING
                residuals += [ResidualLoop(each.id, fitted[0].id, loop) for loop in found.loops]
                remarks += found.remarks
            continue
        if not unseen or not mine:
            continue
        local = yield from _before_corrections(campaign, sensor, condition, parts, mine, held, reduced)
        found = procedure.held_out(mine[0].result, fitted, unseen, local) or NOTHING
        loops += found.loops
        remarks += found.remarks
        curves += found.curves
    made = changed(made, remarks=tuple(remarks), curves=tuple(curves))
    alone = frozenset(one.test for one in residuals)
    return Made(made, outline.number, tuple(loops), tuple(residuals), alone)


def _parts(
    campaign: Campaign, name: str, chosen: Mapping[TermKind, Sequence[Test]], reduced: Reduced, kind: str
) -> Work[list[Part]]:
    """Work out what a procedure gives: tests that one or more kinds of terms come from are reduced together."""
    procedure, found = procedure_of(name), []
    together: dict[tuple[str, ...], list[TermKind]] = {}
    for term, tests in chosen.items():
        own = tuple(test.id for test in tests if test.procedure == name and term in procedure.gives)
        if own:
            together.setdefault(own, []).append(term)
    by_id = {test.id: test for test in campaign.file.tests}
    for ids, kinds in together.items():
        made = procedure.joined([reduced[one] for one in ids])
        groups = [ids] if made is not None or len(ids) == 1 else [(one,) for one in ids]
        for group in groups:
            done = [reduced[one] for one in group]
            parts = procedure.by_sensor(done[0].result if made is None else procedure.reduce(*made))
            result = parts.get(kind, parts.get(""))
            if result is None:
                continue
            terms = yield from ask(procedure.terms_many, (result, done))
            if terms is None:
                continue
            after = tuple(dict.fromkeys(before for one in group for before in bias_before(campaign.file, by_id[one])))
            terms = changed(terms, tests=group, after=after)
            found.append(Part(procedure, tuple(by_id[one] for one in group), result, terms, terms.of_kinds(kinds)))
    return found


def _check_alike(procedure: Procedure[Any, Any, Any], tests: Sequence[Test], reduced: Reduced) -> None:
    """Refuse tests of one procedure, behind a model or held out for it, whose terms mean different things.

    Raises
    ------
    PlanError
        ``plans_differ``.
    """
    if procedure.takes_corrections and len({tuple(one.after) for one in tests}) > 1:
        what = "tests that make one model, or judge it, differ in after: their biases mean different things"
        raise PlanError(what, do="Give them the same after", code="plans_differ")
    procedure.check_alike([reduced[test.id] for test in tests])


def _before_corrections(
    campaign: Campaign,
    sensor: Sensor,
    condition: str,
    parts: Sequence[Part],
    mine: Sequence[Part],
    held: Sequence[Test],
    reduced: Reduced,
) -> Work[SensorModel]:
    """Work out the model for readings of a procedure as it takes them: after the same corrections.

    What other tests add at every condition of the readings is in it where nothing was taken off; a bias that comes
    from elsewhere over temperature is not, and the readings then have that of their own test.
    """
    plain = not any(part.terms.after for part in mine)
    if plain and not any(kind_of(key) not in PLAIN or key.power for part in parts for key in part.terms.parameters):
        return (yield from _model(campaign, sensor, condition, parts, reduced))
    has_bias = any(kind_of(key) == "bias" for part in mine for key in part.terms.parameters)
    kinds: set[TermKind] = {kind_of(key) for key in mine[0].terms.parameters}
    own = list(mine) if has_bias else [replace(mine[0], terms=mine[0].whole.of_kinds({*kinds, "bias"})), *mine[1:]]
    return (yield from _model(campaign, sensor, condition, own, reduced))


def _of_others(file: CampaignFile, name: str, condition: str, parts: Sequence[Part]) -> Iterator[Remark]:
    """Yield a remark for terms that were found in another condition."""
    for part in parts:
        for test in part.tests:
            if not in_condition(file, test, name, condition):
                kinds = dict.fromkeys(kind_of(key).replace("_", " ") for key in part.terms.parameters)
                terms = ", ".join(kinds) or "noise"
                where = f"in {test.condition}" if test.condition else "in no stated condition"
                what = f"{terms} of the model in {condition}: from {test.id}, which was made {where}, as [model] says"
                yield Remark(OF_ANOTHER, "info", what, subject=condition)


def _model(
    campaign: Campaign, sensor: Sensor, condition: str, parts: Sequence[Part], reduced: Reduced
) -> Work[SensorModel]:
    """Work out the model for the output of the sensor: volts where its chain has them and its axes are the body's."""
    assert sensor.kind != "other"  # noqa: S101 - of which no procedure makes a model
    terms = yield from ask(joined_terms_many, _told_apart(campaign, parts, reduced))
    assert terms.estimate is not None  # noqa: S101 - the caller has looked
    scaled = tuple(axis for part in parts for axis in part.terms.axes
                   if any(kind_of(key) == "scale_factor" for key in part.terms.parameters))  # fmt: skip
    axes = tuple(axis for axis in sensor.axes if axis in (scaled or terms.axes)) or terms.axes
    keys = tuple(key for key in terms.parameters if key.quantity == "g_sensitivity" or set(key.axis) <= {*axes})
    counted = output_unit(sensor) != "V" or kind(sensor.unit) == "count"  # of a chain, or readings that stay so
    volts = None if counted or sensor.mounting is not None else body_scale_factors(sensor)
    item, own = campaign.file.item, campaign.file.conditions.get(condition, Condition())
    estimate = terms.estimate.select(keys)
    drawn_on = {influence_of(name) for one in estimate.components for name in one.named_changes}
    ids = list(dict.fromkeys(test.id for part in parts for test in part.tests))
    before = [name for name in dict.fromkeys(name for part in parts for name in part.terms.after) if name not in ids]
    temperature = terms.temperature_range or (None if own.temperature is None else tuple(own.temperature))
    at = [terms.axes.index(axis) for axis in axes]
    scale = _of_axes(terms.scale_factor, at) if volts is None else np.array([volts[axis] for axis in axes])
    output = terms.output_unit if volts is None else "V"
    given = {
        "estimate": estimate,
        "kind": sensor.kind,
        "axes": axes,
        "scale_factor": scale,
        "output_unit": output,
        "chain": model_chain(sensor, axes, _recorded(campaign, sensor), output, scale),
        "source": "" if sensor.mounting is None else f"readings in body axes, after mounting {sensor.mounting}",
        "item": Item(item.maker, item.part, item.serial),
        "input_range": None if terms.input_range is None else terms.input_range[at],
        "bias_run_to_run": None if terms.bias_run_to_run is None else terms.bias_run_to_run[at],
        "not_estimated": terms.not_estimated,
        "values": terms.values,
        "references": terms.references,
        "provenance": {str(key): one for key, one in terms.provenance.items()},
        "influences": {name: one for name, one in campaign.standards.items() if name in drawn_on},
        "occasion": reduce(Occasion.joined, [reduced[one].occasion for one in ids]),
        "tests": (*ids, *before),
        "selections": tuple(reduced[one].selection for one in (*ids, *before)),
        "temperature_range": temperature,
        "condition": condition,
        "noise": _noise_of(terms.noise, axes),
        **({} if own.pressure is None or "pressure" in terms.references else {"pressure_range": tuple(own.pressure)}),
        **({} if terms.reference_temperature is None else {"reference_temperature": terms.reference_temperature}),
    }
    return (yield from ask(models_from, given))


def _noise_of(noise: Estimate | None, axes: Sequence[str]) -> Estimate | None:
    """Return the noise terms of the axes that the model has."""
    keys = () if noise is None else tuple(key for key in noise.keys if key.axis in axes)
    return None if noise is None or not keys else noise.select(keys)


def _recorded(campaign: Campaign, sensor: Sensor) -> set[str]:
    """Return which of gain and reference of the temperature recordings of a sensor have as channels."""
    own = [one for one in campaign.file.recordings.values() if campaign.file.sensors.get(one.sensor) is sensor]
    return {
        what for what in (GAIN, "temperature_reference") for one in own
        if {what, *(f"{what}_{axis}" for axis in sensor.axes)} & set(one.channels or {})
    }  # fmt: skip


def _of_axes(given: Any, at: Sequence[int]) -> Any:
    """Return one number for all, or those of the axes that the model has."""
    return given if np.ndim(given) == 0 else np.asarray(given)[list(at)]


def _told_apart(campaign: Campaign, parts: Sequence[Part], reduced: Reduced) -> list[ModelTerms]:
    """Return the terms of parts; a standard whose error was drawn anew between two is another unknown in each."""
    found = []
    for part in parts:
        occasion = reduce(Occasion.joined, [reduced[test.id].occasion for test in part.tests])
        estimate = part.terms.estimate
        if estimate is None or len(parts) == 1:
            found.append(part.terms)
            continue
        components: list[Component] = []
        for one in estimate.components:
            origin = one.origin
            known = campaign.standards.get(f"{origin.standard}.{origin.quantity}")
            if origin.standard and not origin.test and known is not None and known.redrawn_by not in LASTING:
                others = [reduce(Occasion.joined, [reduced[test.id].occasion for test in each.tests])
                          for each in parts if each is not part]  # fmt: skip
                label = occasion.drew(known.redrawn_by)
                if not label or any(label != each.drew(known.redrawn_by) for each in others):
                    origin = origin._replace(test=", ".join(part.terms.tests))
            components.append(one.changed(given=origin) if origin != one.origin else one)
        same = all(mine is its for mine, its in zip(components, estimate.components, strict=True))
        found.append(
            part.terms if same else changed(part.terms, estimate=changed(estimate, components=tuple(components)))
        )
    return found


def model_files(modelled: Modelled) -> dict[str, str]:
    """Return the text of the model file of each sensor, by its name; it holds no model that is worse than none."""
    return model_files_many([modelled])[0]


def model_files_many(given: Sequence[Modelled]) -> list[dict[str, str]]:
    """Return the same of many units."""
    named: list[tuple[int, str, ModelSet]] = []
    for i, modelled in enumerate(given):
        models: dict[str, list[SensorModel]] = {}
        for one in modelled.delivered:
            assert one.model is not None  # noqa: S101 - it is delivered
            models.setdefault(one.sensor, []).append(one.model)
        first = modelled.every[0].sensor if modelled.every else ""
        named += [
            (i, f"{model_name('' if sensor == first else sensor, '')}.json", ModelSet(tuple(every)))
            for sensor, every in models.items()
        ]
    found: list[dict[str, str]] = [{} for _ in given]
    for (i, name, _), text in zip(named, dump_each([one for _, _, one in named]), strict=True):
        found[i][name] = text
    return found
