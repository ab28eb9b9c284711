"""A model out of the estimates of its parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array, Estimate
from ...core.key import Kind
from ...core.results import changed
from ...core.units import factor, normalise
from .sensitivity import PARTS, PRESSURE, ChannelReference, Sensitivity, quantity_of
from .sensor_model import INPUT_UNIT, SensorModel
from .terms import (
    FORCE_AXES,
    PER_AXIS,
    SHAPES,
    Parameter,
    are_plain,
    orders,
    parameter_keys,
    parameters,
    stacked_term,
    with_values,
)

NOT_ESTIMATED = "no test gives it: taken as 0"


def model_from(
    estimate: Estimate,
    kind: Kind,
    axes: tuple[str, ...],
    scale_factor: Array | float = 1.0,
    output_unit: str | None = None,
    references: Mapping[str, ChannelReference] | None = None,
    **rest: Any,
) -> SensorModel:
    """Return the model whose parameters an estimate holds.

    The names decide which terms the model has; a parameter of such a term that the estimate lacks is 0, and is
    listed in ``not_estimated``.

    Parameters
    ----------
    estimate : Estimate
        Names as ``terms.parameters`` gives them; units of the right dimension, converted here.
    kind, axes, scale_factor, output_unit
        As `SensorModel`; output and input unit are the same by default, with a scale factor of 1.
    references : mapping of str to ChannelReference, optional
        Channels that the estimate may have sensitivities to, by name: what these refer to. That of ``pressure`` is the
        reference pressure and the pressure range of the model, too, where ``rest`` gives none.
    **rest
        Further fields of `SensorModel`: condition, noise, ranges, references, item, provenance, reasons in
        ``not_estimated``; ``values`` of parameters that have no uncertainty, by their names, in the units of the model.

    Raises
    ------
    DataError
        If a name is no parameter of a model with these axes (``unknown_parameter``), or as `SensorModel`.
    """
    own = {"estimate": estimate, "kind": kind, "axes": axes, "scale_factor": scale_factor, "output_unit": output_unit}
    (found,) = models_from([{**own, "references": references, **rest}])
    if isinstance(found, DataError):
        raise found
    return found


def models_from(given: Sequence[Mapping[str, Any]]) -> list[SensorModel | DataError]:
    """Return the model of each of many units, or why there is none; those of one form are worked out at once.

    Parameters
    ----------
    given : sequence of mapping
        Of each: the arguments of `model_from`, by name.
    """
    given = [{"scale_factor": 1.0, **one} for one in given]
    alike: dict[tuple[object, ...], list[int]] = {}
    for i, one in enumerate(given):
        alike.setdefault(_form(one), []).append(i)
    found = dict[int, SensorModel | DataError]()
    for at in alike.values():
        found |= zip(at, _models_alike([given[i] for i in at]), strict=True)
    return [found[i] for i in range(len(given))]


def _form(one: Mapping[str, Any]) -> tuple[object, ...]:
    """Return what models that are worked out at once have in common."""
    estimate: Estimate = one["estimate"]
    shapes = tuple([(name, np.shape(one[name])) for name in SHAPES if one.get(name) is not None])
    names = tuple(one.get("values") or ())
    channels = tuple((name, ref.unit) for name, ref in (one.get("references") or {}).items())
    return estimate.names, estimate.units, one["kind"], one["axes"], one.get("output_unit"), shapes, names, channels


def _models_alike(given: Sequence[Mapping[str, Any]]) -> list[SensorModel | DataError]:
    try:
        return [*_models(given)]
    except DataError as error:  # of one of them: which, the units by themselves say
        return [error] if len(given) == 1 else [made for one in given for made in _models_alike([one])]


def _models(given: Sequence[Mapping[str, Any]]) -> list[SensorModel]:
    """Return the models of units of one form.

    Raises
    ------
    DataError
        If one is refused.
    """
    first = given[0]
    kind, axes, names = first["kind"], first["axes"], first["estimate"].names
    unit, count = INPUT_UNIT.get(kind, ""), len(given)
    blank = _blank_terms(names, axes)
    to_channels = [_blank_sensitivities(names, axes, one.get("references") or {}) for one in given]
    arrays = {
        name: stacked_term(name, [one[name] for one in given], len(axes))
        for name in SHAPES if first.get(name) is not None and name not in blank
    } | {name: np.broadcast_to(term, (count, *term.shape)) for name, term in blank.items()}  # fmt: skip
    arrays |= {name: np.broadcast_to(term, (count, *term.shape))
               for one in to_channels[0] for name, term in one.terms.items()}  # fmt: skip
    own = parameters(axes, unit, {name: array[0] for name, array in arrays.items()}, to_channels[0])
    known = {one.name: one for one in own}
    strangers = [name for name in names if name not in known]
    if strangers:
        raise DataError(
            f"{', '.join(strangers)}: no parameter of a {kind} with axes {', '.join(axes)}",
            do="Select the parameters of the model first",
            code="unknown_parameter",
        )
    units = tuple([known[name].unit for name in names])
    held = [in_units(one["estimate"], units) for one in given]
    columns = np.array([one.values for one in held]).T
    changes = {known[name]: column for name, column in zip(names, columns, strict=True)}
    changes |= {
        known[name]: np.array([one["values"][name] for one in given])
        for name in first.get("values") or () if name in known and name not in names
    }  # fmt: skip
    terms = with_values(arrays, changes)
    for array in terms.values():
        array.setflags(write=False)
    of_model = [name for name in SHAPES if name in terms]
    missing = [name for name in known if name not in names]
    output_unit = normalise(first.get("output_unit") or unit)
    plain = kind in INPUT_UNIT and not to_channels[0] and are_plain(axes, terms)
    found = []
    for i, (one, estimate) in enumerate(zip(given, held, strict=True)):
        fields = {name: value for name, value in one.items() if name not in ("references", "values")}
        refer = one.get("references") or {}
        if PRESSURE in refer:
            fields = {"reference_pressure": refer[PRESSURE].value, "pressure_range": refer[PRESSURE].range} | fields
        fields |= {name: terms[name][i] for name in of_model}
        reasons = one.get("not_estimated") or {}
        fields["not_estimated"] = {name: reasons.get(name, NOT_ESTIMATED) for name in missing}
        fields["output_unit"], fields["estimate"] = output_unit, estimate
        if plain and not ("bias_pressure" in terms and fields.get("reference_pressure") is None):
            found.append(SensorModel.of_own(fields, own))
        else:
            own_terms = {name: array[i] for name, array in terms.items()}
            found.append(SensorModel(**fields, sensitivities=tuple(o.with_terms(own_terms) for o in to_channels[i])))
    return found


@lru_cache(maxsize=64)
def parameters_of(names: tuple[str, ...], kind: Kind, axes: tuple[str, ...]) -> tuple[Parameter, ...]:
    """Return every parameter of the model that an estimate of these names gives, but sensitivities to channels."""
    return parameters(axes, INPUT_UNIT[kind], _blank_terms(names, axes))


def with_parameters(
    model: SensorModel, changes: Mapping[Parameter, float], estimate: Estimate | None = None, **rest: Any
) -> SensorModel:
    """Return a model with some parameters set, their estimate and other fields; other parameters keep their values."""
    arrays = with_values(model.terms, changes)
    terms: dict[str, Any] = {name: array for name, array in arrays.items() if name in SHAPES}
    sensitivities = tuple(one.with_terms(arrays) for one in model.sensitivities)
    return replace(model, estimate=estimate, sensitivities=sensitivities, **terms, **rest)


def in_units(estimate: Estimate, units: tuple[str, ...]) -> Estimate:
    """Return the estimate with its values, and all covariances, in other units.

    Raises
    ------
    DataError
        ``unit_mismatch``.
    """
    if units == estimate.units:
        return estimate
    factors = np.array([factor(own, other) for own, other in zip(estimate.units, units, strict=True)])
    grid = np.outer(factors, factors)
    components = tuple(
        one.changed(covariance=one.covariance * grid, changes=None if one.changes is None else one.changes * factors)
        for one in estimate.components
    )
    return changed(estimate, given=estimate.keys, values=estimate.values * factors, units=units, components=components)


@lru_cache(maxsize=64)
def _blank_terms(names: tuple[str, ...], axes: tuple[str, ...]) -> Mapping[str, Array]:
    """Terms that the names ask for, without effect: M = I, zeros, time constants of 1 s."""
    k, keys = len(axes), parameter_keys(names, axes)
    order = orders(keys)
    matrix = np.zeros((order["matrix"] + 1, k, k))
    matrix[0] = np.eye(k)
    terms: dict[str, Array] = {"matrix": matrix, "bias": np.zeros(k)}
    if order["bias_temperature"]:
        terms["bias_temperature"] = np.zeros((order["bias_temperature"], k))
    if order["bias_warm_up"]:
        terms["bias_warm_up"] = np.zeros((order["bias_warm_up"], k))
        terms["warm_up_time"] = np.ones(order["bias_warm_up"])
    for field, (quantity, _) in PER_AXIS.items():
        if field != "bias" and any(f"{quantity}_{axis}" in names for axis in axes):
            terms[field] = np.zeros(k)
    if any(key.quantity == "g_sensitivity" for key in keys):
        terms["g_sensitivity"] = np.zeros((k, len(FORCE_AXES)))
    return MappingProxyType(terms)


def _blank_sensitivities(
    names: tuple[str, ...], axes: tuple[str, ...], references: Mapping[str, ChannelReference]
) -> list[Sensitivity]:
    """Sensitivities to channels that the names ask for, without effect."""
    found, k = [], len(axes)
    for channel, one in references.items():
        wanted = {part: np.zeros(k) for part in PARTS if not (channel == PRESSURE and part == "bias")
                  and any(f"{quantity_of(part, channel)}_{axis}" in names for axis in axes)}  # fmt: skip
        if wanted:
            between = None if channel == PRESSURE else one.range
            found.append(Sensitivity(channel, one.unit, one.value, range=between, **wanted))
    return found
