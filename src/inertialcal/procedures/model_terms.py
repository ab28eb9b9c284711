"""What a procedure gives to the model of a sensor, and what it says of readings that the model has not seen.

The assembler of models (``campaign.models``) knows no procedure: it joins these, and adds what the campaign says of
item, output and verdicts.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import combinations
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ..core.curve import Curve
from ..core.errors import DataError, InertialcalError, PlanError
from ..core.estimate import Array, Component, Estimate, Sources
from ..core.key import Key, Origin
from ..core.remarks import Remark
from ..core.results import Row, changed
from ..core.units import factor
from ..sensors.model.sensitivity import ChannelReference
from ..sensors.model.sensor_model import Provenance
from ..statistics.closed_loop import AxisLoop

TermKind = Literal[
    "scale_factor", "misalignment", "asymmetry", "bias", "g_sensitivity", "hysteresis", "warm_up", "sensitivity",
    "noise",
]  # fmt: skip
KINDS: tuple[TermKind, ...] = get_args(TermKind)  # of terms: what [model] terms of a campaign decides on
KIND_OF: Mapping[str, TermKind] = {
    "scale_factor_error": "scale_factor",
    "misalignment": "misalignment",
    "scale_factor_asymmetry": "asymmetry",
    "second_order": "asymmetry",
    "third_order": "asymmetry",
    "bias": "bias",
    "bias_temperature": "bias",
    "g_sensitivity": "g_sensitivity",
    "bias_hysteresis": "hysteresis",
    "bias_temperature_rate": "hysteresis",
    "bias_warm_up": "warm_up",
    "warm_up_time": "warm_up",
}  # by quantity; every other parameter is a sensitivity to a recorded condition


def kind_of(key: Key) -> TermKind:
    """Return the kind of term that a parameter of the model is."""
    return KIND_OF.get(key.quantity, "sensitivity")


@dataclass(frozen=True, eq=False)
class ModelTerms:
    """Terms of the model of a sensor, from one joint reduction.

    Parameters
    ----------
    estimate : Estimate or None
        SI; it may hold more than the model takes. None where nothing could be estimated. Sources that another test
        can share have their ``changes``: those of standards, and those with the test that found them.
    parameters : tuple of Key
        Of the estimate: those that are parameters of the model.
    axes : tuple of str
        Of the model.
    provenance : mapping of Key to Provenance
        Of each parameter.
    not_estimated : mapping of str to str
        Reason by name.
    values : mapping of str to float
        By name: of parameters that have a value and no uncertainty.
    scale_factor : float or ndarray, shape (k,)
        Ideal scale factors that the estimate is relative to, where the sensor has no output in volts.
    output_unit : str or None
        Of the sensor, where that is neither its input's nor volts.
    input_range : ndarray, shape (k, 2), or None
        Inputs that each axis was tested at.
    bias_run_to_run : ndarray, shape (k,), or None
        Scatter of the bias between power-ups.
    referenced : bool
        Readings are relative to one at rest: there is no bias.
    reference_temperature : float or None
        That terms over temperature refer to [degC].
    temperature_range : (float, float) or None
        That they hold for [degC].
    references : mapping of str to ChannelReference
        By channel (``"supply"``, ``"pressure"``): what sensitivities refer to, and where they hold.
    noise : Estimate or None
        Terms of the noise, by axis: keys as rows of static noise have them, SI. They are shown and exported with the
        model; no reading is compensated with them.
    tests, after : tuple of str
        Where they come from, and whose findings were taken off the readings before; the engine says it.
    """

    estimate: Estimate | None
    parameters: tuple[Key, ...]
    axes: tuple[str, ...]
    provenance: Mapping[Key, Provenance]
    not_estimated: Mapping[str, str] = field(default_factory=dict[str, str])
    values: Mapping[str, float] = field(default_factory=dict[str, float])
    scale_factor: float | Array = 1.0
    output_unit: str | None = None
    input_range: Array | None = None
    bias_run_to_run: Array | None = None
    referenced: bool = False
    reference_temperature: float | None = None
    temperature_range: tuple[float, float] | None = None
    references: Mapping[str, ChannelReference] = field(default_factory=dict[str, ChannelReference])
    noise: Estimate | None = None
    tests: tuple[str, ...] = ()
    after: tuple[str, ...] = ()

    def of_kinds(self, kinds: Collection[TermKind]) -> ModelTerms:
        """Return the terms of some kinds alone."""
        keys = tuple(key for key in self.parameters if kind_of(key) in kinds)
        return replace(
            self,
            parameters=keys,
            provenance={key: one for key, one in self.provenance.items() if key in keys},
            noise=self.noise if "noise" in kinds else None,
            bias_run_to_run=self.bias_run_to_run if "bias" in kinds else None,
        )


def joined_terms(parts: Sequence[ModelTerms]) -> ModelTerms:
    """Return the terms of several reductions as those of one model, with their covariance.

    Equal origins are the same unknowns: what two parts share is correlated, and what one took off the readings of the
    other cancels in their sum. An origin without a test that found it belongs to its part, unless it is a standard.
    A parameter of two parts is their sum: the second was found after the first had been taken off (``after``).

    Parameters
    ----------
    parts : sequence of ModelTerms
        At least one; a sensor's axes come in the order of the first that has them.

    Raises
    ------
    PlanError
        ``terms_twice`` if two parts give one parameter, and neither was taken off before the other; ``plans_differ``
        if they refer to different temperatures, or ideal scale factors.
    """
    (found,) = joined_terms_many([parts])
    if isinstance(found, Exception):
        raise found
    return found


def joined_terms_many(given: Sequence[Sequence[ModelTerms]]) -> list[ModelTerms | InertialcalError]:
    """Return what `joined_terms` gives of the parts of each of many models, of many units, or why it is refused."""
    found: list[ModelTerms | InertialcalError | None] = [parts[0] if len(parts) == 1 else None for parts in given]
    alike: dict[tuple[object, ...], list[int]] = {}
    for i, parts in enumerate(given):
        try:
            for one, other in combinations(parts, 2):
                _check_once(one, other)
        except PlanError as error:
            found[i] = error
        if found[i] is None:
            alike.setdefault(tuple([_form(one) for one in parts]), []).append(i)
    for places in alike.values():
        for i, estimate in zip(places, _joint([given[i] for i in places]), strict=True):
            try:
                found[i] = estimate if isinstance(estimate, DataError) else _joined(given[i], estimate)
            except PlanError as error:
                found[i] = error
    return [one for one in found if one is not None]


def _form(one: ModelTerms) -> tuple[object, ...] | None:
    """Return what two units have alike if their terms are joined together: the sources of uncertainty."""
    if one.estimate is None or not one.parameters:
        return None
    sources = [
        (each.given, each.kind, each.distribution, each.unknowns, each.term,
         None if each.changes is None else len(each.changes) != 1)
        for each in one.estimate.components
    ]  # fmt: skip
    return (one.tests, *sources)


def _joined(parts: Sequence[ModelTerms], estimate: Estimate | None) -> ModelTerms:
    """Return terms of several reductions as those of one model, with their joint estimate."""
    keys = tuple(dict.fromkeys([key for one in parts for key in one.parameters]))
    axes = tuple(dict.fromkeys(axis for one in parts for axis in one.axes))
    scaled = next((one for one in parts if one.output_unit is not None or _is_scaled(one)), parts[0])
    origins: dict[tuple[int, ...], Provenance] = {}  # of terms that come from the same
    came: dict[Key, list[Provenance]] = {}
    for part in parts:
        for key, own in part.provenance.items():
            came.setdefault(key, []).append(own)
    provenance = {}
    for key in keys:
        found = came.get(key, [])
        same = tuple(map(id, found))
        provenance[key] = origins[same] if same in origins else origins.setdefault(same, _origins(found))
    return changed(
        scaled,
        estimate=estimate,
        parameters=keys,
        axes=axes,
        provenance=provenance,
        not_estimated={name: text for one in reversed(parts) for name, text in one.not_estimated.items()},
        values={name: value for one in parts for name, value in one.values.items()},
        input_range=_by_axis([(one.axes, one.input_range) for one in parts], axes),
        bias_run_to_run=_run_to_run(parts, axes),
        referenced=all(one.referenced for one in parts),
        reference_temperature=_one([one.reference_temperature for one in parts], "reference_temperature"),
        temperature_range=_common([one.temperature_range for one in parts]),
        references={name: one for part in parts for name, one in part.references.items()},
        noise=_joint_noise([one.noise for one in parts if one.noise is not None]),
        tests=tuple(dict.fromkeys(test for one in parts for test in one.tests)),
    )


def _is_scaled(one: ModelTerms) -> bool:
    given = one.scale_factor
    return bool((given != 1.0).any()) if isinstance(given, np.ndarray) else given != 1.0


def _check_once(one: ModelTerms, other: ModelTerms) -> None:
    """Refuse two parts that give one parameter; a value that was found after the other adds to it."""
    after = {*one.tests} & {*other.after} or {*other.tests} & {*one.after}
    noise = [() if part.noise is None else part.noise.keys for part in (one, other)]
    twice = [key for key in one.parameters if key in other.parameters and not after]
    twice += [key for key in noise[0] if key in noise[1]]
    if twice:
        kinds = list(dict.fromkeys("noise" if key in noise[0] else kind_of(key) for key in twice))
        mine, its = (", ".join(part.tests) for part in (one, other))
        terms = " and ".join(kinds).replace("_", " ")
        what = f"tests {mine} and {its} both give {terms} of one sensor in one condition ({twice[0]})"
        named = ", ".join(f'"{test}"' for test in one.tests)
        do = f'Decide in [model]: terms = {{ {kinds[0]} = [{named}] }}; or give one of them use = "report_only"'
        raise PlanError(what, why="a model has each term once", do=do, code="terms_twice")


Taken = tuple[tuple[Key, ...], tuple[Key | str, ...], tuple[str, ...]]  # Parameters of a part; its values and units


@lru_cache(maxsize=256)
def _layout(parts: tuple[Taken, ...]) -> tuple[tuple[Key, ...], tuple[str, ...], list[tuple[list[int], list[float]]]]:
    """Return keys and units of the values of several parts together, and of each part its value behind each of them.

    That is its place in the part, -1 where it has none, and the factor that takes it to the unit.
    """
    keys = tuple(dict.fromkeys(key for parameters, _, _ in parts for key in parameters))
    units: dict[Key, str] = {}
    found = []
    for parameters, given, its in parts:
        at = {key: i for i, key in enumerate(given)}
        places = [at[key] if key in parameters else -1 for key in keys]
        factors = [0.0 if place < 0 else factor(its[place], units.setdefault(key, its[place]), difference=True)
                   for key, place in zip(keys, places, strict=True)]  # fmt: skip
        found.append((places, factors))
    return keys, tuple([units[key] for key in keys]), found


def _joint(given: Sequence[Sequence[ModelTerms]]) -> Sequence[Estimate | DataError | None]:
    """Return the values of all parts of each of several models, with their covariance; those of one key add.

    The models have the same sources of uncertainty, part by part.
    """
    held = [[(one, one.estimate) for one in parts if one.estimate is not None and one.parameters] for parts in given]
    count = len(given)
    if not held[0]:
        return [None] * count
    layouts = [_layout(tuple([(part.parameters, own.keys, own.units) for part, own in parts])) for parts in held]
    n = max(len(keys) for keys, _, _ in layouts)
    values = np.zeros((count, n))
    whole: list[Sources] = []
    shared: dict[Origin, list[tuple[Sources, Sequence[str]]]] = {}
    for j, (part, first) in enumerate(held[0]):
        every = [parts[j][1] for parts in held]
        place, scale = np.full((count, n), -1), np.zeros((count, n))
        for i, (keys, _, taken) in enumerate(layouts):
            place[i, : len(keys)], scale[i, : len(keys)] = taken[j]
            values[i] += scale[i] * every[i].values[place[i]]
        for one, source in zip(first.components, _sources_of(every, place, scale), strict=True):
            names = _labels(one, 0 if source.changes is None else source.changes.shape[1])
            if names is None:
                origin = one.origin if one.origin.test else one.origin._replace(test=", ".join(part.tests))
                whole.append(replace(source, given=origin))
            else:
                shared.setdefault(one.origin, []).append((source, names))
    whole += [_together(origin, each) for origin, each in shared.items()]
    keys_of, units_of = [keys for keys, _, _ in layouts], [units for _, units, _ in layouts]
    if whole:
        return Estimate.of_each(keys_of, values, units_of, whole, checked=True)
    rows = zip(keys_of, values, units_of, strict=True)
    return [Estimate.of_own(keys, row[: len(keys)], units, ()) for keys, row, units in rows]


def _sources_of(every: Sequence[Estimate], place: NDArray[np.intp], scale: Array) -> list[Sources]:
    """Return the sources of several units, the same of all, each for the values at some places, times their scale.

    At -1 there is none.
    """
    first, count = every[0].components, len(every)
    k = max(len(one.values) for one in every) + 1  # the last is blank
    counts = [[0 if part.changes is None else len(part.changes) for part in one.components] for one in every]
    sizes = [max(column) for column in zip(*counts, strict=True)]
    starts = np.cumsum([0, *sizes]).tolist()
    square, dof = np.zeros((len(first), count, k, k)), np.full((len(first), count, k), np.inf)
    moved = np.zeros((starts[-1], count, k))
    for i, (one, its) in enumerate(zip(every, counts, strict=True)):
        own, n = one.components, len(one.values)
        if own:
            square[:, i, :n, :n] = [part.covariance for part in own]
        for row, part in zip(dof, own, strict=True):
            if part.dof is not np.inf:
                row[i, :n] = part.dof
        if len(moved):
            rows = [row for start, size in zip(starts, its, strict=False) for row in range(start, start + size)]
            moved[slice(None) if its == sizes else rows, i, :n] = np.concatenate(
                [part.changes for part in own if part.changes is not None]
            )
    unit = np.arange(count)[:, None]
    square, dof = square[:, unit[:, None], place[:, :, None], place[:, None]], dof[:, unit, place]
    moved = moved[:, unit, place].swapaxes(0, 1)
    if not np.all((scale == 1.0) | (place < 0)):
        square, moved = square * (scale[:, :, None] * scale[:, None]), moved * scale[:, None]
    return [
        Sources(
            one.given,
            one.kind,
            square[j],
            dof[j],
            one.distribution,
            [each.components[j].stated for each in every],
            None if one.changes is None else moved[:, start : start + size],
            one.unknowns,
            one.term,
            counts=None if min(column) == size else column,
        )
        for j, (one, start, size, column) in enumerate(
            zip(first, starts, sizes, zip(*counts, strict=True), strict=False)
        )
    ]


def _spread(
    given: Sequence[Array | None], taken: NDArray[np.intp], place: NDArray[np.intp], n: int
) -> list[Array | None]:
    """Return changes of some values, (s, k) each, as those of n values at their places, (s, n)."""
    sizes = [0 if one is None else len(one) for one in given]
    stops = np.cumsum([0, *sizes]).tolist()
    every = np.zeros((stops[-1], n))
    if stops[-1]:
        every[:, place] = np.concatenate([one for one in given if one is not None])[:, taken]
    return [
        None if one is None else every[start:stop]
        for one, start, stop in zip(given, stops, stops[1:], strict=False)
    ]  # fmt: skip


def _labels(one: Component, count: int) -> Sequence[str] | None:
    """Return what tells the unknowns of a source, so many of all units, apart, in all parts alike.

    None where another part cannot share it.
    """
    origin = one.origin
    if one.changes is None or not (origin.test or origin.standard):
        return None
    if one.unknowns:
        return one.unknowns
    if len(one.changes) == 1 or origin.test:  # unknowns of another test stand in their order
        return [str(i) for i in range(count)]
    return None


def _together(origin: Origin, each: Sequence[tuple[Sources, Sequence[str]]]) -> Sources:
    """Return sources of one origin, each with what tells its unknowns apart, as one."""
    first, names = each[0]
    if len(each) == 1:
        return replace(first, given=origin, unknowns=tuple(names) if first.unknowns else ())
    sums: dict[str, Array] = {}
    for one, labels in each:
        for label, row in zip(labels, () if one.changes is None else one.changes.swapaxes(0, 1), strict=True):
            sums[label] = sums[label] + row if label in sums else row
    joint = Sources.of_changes(origin, np.array([*sums.values()]).swapaxes(0, 1))
    dof = np.min(np.array([one.dof for one, _ in each]), axis=0)
    most = [[len(labels)] * len(dof) if one.counts is None else one.counts for one, labels in each]
    return replace(first, given=origin, covariance=joint.covariance, dof=dof, changes=joint.changes,
                   unknowns=tuple(sums) if first.unknowns else (),
                   counts=None if first.unknowns else [max(column) for column in zip(*most, strict=True)])  # fmt: skip


def _origins(found: Sequence[Provenance]) -> Provenance:
    """Return where a term of several tests comes from."""
    tests = dict.fromkeys(one.test for one in found if one.test)
    recordings = tuple(dict.fromkeys(name for one in found for name in one.recordings))
    return Provenance(", ".join(tests), recordings, next((one.source for one in found if one.source), ""))


def _run_to_run(parts: Sequence[ModelTerms], axes: Sequence[str]) -> Array | None:
    """Return the scatter between power-ups of each axis, by the first part that has it; None where an axis has none."""
    found: dict[str, float] = {}
    for part in parts:
        if part.bias_run_to_run is not None:
            found = {**dict(zip(part.axes, part.bias_run_to_run.tolist(), strict=True)), **found}
    return np.array([found[axis] for axis in axes]) if {*axes} <= {*found} else None


def _by_axis(parts: Sequence[tuple[tuple[str, ...], Array | None]], axes: tuple[str, ...]) -> Array | None:
    """Return the widest range of each axis that any part was tested over, shape (k, 2)."""
    rows: dict[str, Array] = {}
    for own, ranges in parts:
        for axis, row in zip(own, () if ranges is None else ranges, strict=False):
            known = rows.get(axis, row)
            rows[axis] = np.array([min(known[0], row[0]), max(known[1], row[1])])
    return np.array([rows.get(axis, np.zeros(2)) for axis in axes]) if rows else None


def _one(given: Sequence[float | None], name: str) -> float | None:
    known = sorted({one for one in given if one is not None})
    if len(known) > 1:
        what = f"tests that make one model differ in {name}: {', '.join(f'{one:g}' for one in known)} degC"
        raise PlanError(what, why="their terms mean different things", do="Give them the same", code="plans_differ")
    return known[0] if known else None


def _common(given: Sequence[tuple[float, float] | None]) -> tuple[float, float] | None:
    known = [one for one in given if one is not None]
    return (max(low for low, _ in known), min(high for _, high in known)) if known else None


def _joint_noise(parts: Sequence[Estimate]) -> Estimate | None:
    """Return noise terms of several reductions; they share nothing."""
    if not parts:
        return None
    keys = tuple(key for one in parts for key in one.keys)
    components, start = [], 0
    for one in parts:
        place = slice(start, start + len(one.keys))
        start += len(one.keys)
        for component in one.components:
            dof = np.full(len(keys), np.inf)
            dof[place] = component.dof
            covariance = np.zeros((len(keys), len(keys)))
            covariance[place, place] = component.covariance
            (changes,) = _spread([component.changes], np.arange(len(one.keys)), np.arange(len(keys))[place], len(keys))
            components.append(component.changed(covariance=covariance, dof=dof, changes=changes))
    values = np.concatenate([one.values for one in parts])
    return Estimate(keys, values, tuple(unit for one in parts for unit in one.units), tuple(components))


@dataclass(frozen=True, eq=False)
class HeldOut:
    """What a procedure says of readings that the model, or the fit, has not seen.

    Parameters
    ----------
    loops : tuple of AxisLoop
        Without verdicts: those are the engine's to give, over all axes that are judged.
    rows : tuple of Row
        Of the test held out, SI.
    curves : tuple of Curve
        SI.
    remarks : tuple of Remark
        Findings.
    """

    loops: tuple[AxisLoop, ...] = ()
    rows: tuple[Row, ...] = ()
    curves: tuple[Curve, ...] = ()
    remarks: tuple[Remark, ...] = ()
