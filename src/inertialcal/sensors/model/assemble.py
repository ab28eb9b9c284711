"""A model out of the estimates of its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array, Estimate
from ...core.key import Kind
from ...core.results import changed
from ...core.units import factor
from .sensitivity import PARTS, PRESSURE, ChannelReference, Sensitivity, quantity_of
from .sensor_model import INPUT_UNIT, SensorModel
from .terms import (
    FORCE_AXES,
    PER_AXIS,
    SHAPES,
    Parameter,
    orders,
    parameter_keys,
    parameters,
    read_only_term,
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
    unit = {"gyro": "rad/s", "accelerometer": "m/s^2"}.get(kind, "")
    fields = {"kind": kind, "axes": axes, "scale_factor": scale_factor, "output_unit": output_unit or unit, **rest}
    reasons = fields.pop("not_estimated", {})
    without = fields.pop("values", {})
    refer = references or {}
    if PRESSURE in refer:
        fields = {"reference_pressure": refer[PRESSURE].value, "pressure_range": refer[PRESSURE].range} | fields
    blank = _blank_terms(estimate.names, axes, refer)
    sensitivities = blank.pop("sensitivities")
    arrays = {
        name: read_only_term(name, array, len(axes))
        for name, array in fields.items() if name in SHAPES and array is not None and name not in blank
    } | blank  # fmt: skip
    arrays |= {name: array for one in sensitivities for name, array in one.terms.items()}
    known = {one.name: one for one in parameters(axes, unit, arrays, sensitivities)}
    names = estimate.names
    strangers = [name for name in names if name not in known]
    if strangers:
        raise DataError(
            f"{', '.join(strangers)}: no parameter of a {kind} with axes {', '.join(axes)}",
            do="Select the parameters of the model first",
            code="unknown_parameter",
        )
    held = in_units(estimate, tuple([known[name].unit for name in names]))
    changes = {known[name]: value for name, value in zip(names, held.values.tolist(), strict=True)}
    changes |= {known[name]: value for name, value in without.items() if name in known and name not in names}
    missing = {name: reasons.get(name, NOT_ESTIMATED) for name in known if name not in names}
    terms = with_values(arrays, changes)
    fields |= {name: array for name, array in terms.items() if name in SHAPES}
    made = tuple(one.with_terms(terms) for one in sensitivities)
    return SensorModel(**fields, sensitivities=made, estimate=held, not_estimated=missing)


@lru_cache(maxsize=64)
def parameters_of(names: tuple[str, ...], kind: Kind, axes: tuple[str, ...]) -> tuple[Parameter, ...]:
    """Return every parameter of the model that an estimate of these names gives, but sensitivities to channels."""
    blank = _blank_terms(names, axes, {})
    blank.pop("sensitivities")
    return parameters(axes, INPUT_UNIT[kind], blank)


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


def _blank_terms(
    names: tuple[str, ...], axes: tuple[str, ...], references: Mapping[str, ChannelReference]
) -> dict[str, Any]:
    """Terms that the names ask for, without effect: M = I, zeros, time constants of 1 s."""
    k, order = len(axes), orders(parameter_keys(names, axes))
    matrix = np.zeros((order["matrix"] + 1, k, k))
    matrix[0] = np.eye(k)
    terms: dict[str, Any] = {"matrix": matrix, "bias": np.zeros(k)}
    if order["bias_temperature"]:
        terms["bias_temperature"] = np.zeros((order["bias_temperature"], k))
    if order["bias_warm_up"]:
        terms["bias_warm_up"] = np.zeros((order["bias_warm_up"], k))
        terms["warm_up_time"] = np.ones(order["bias_warm_up"])
    for field, (quantity, _) in PER_AXIS.items():
        if field != "bias" and any(f"{quantity}_{axis}" in names for axis in axes):
            terms[field] = np.zeros(k)
    if any(key.quantity == "g_sensitivity" for key in parameter_keys(names, axes)):
        terms["g_sensitivity"] = np.zeros((k, len(FORCE_AXES)))
    sensitivities = []
    for channel, one in references.items():
        wanted = {part: np.zeros(k) for part in PARTS if not (channel == PRESSURE and part == "bias")
                  and any(f"{quantity_of(part, channel)}_{axis}" in names for axis in axes)}  # fmt: skip
        if wanted:
            between = None if channel == PRESSURE else one.range
            sensitivities.append(Sensitivity(channel, one.unit, one.value, range=between, **wanted))
    return terms | {"sensitivities": tuple(sensitivities)}
