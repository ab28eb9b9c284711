"""Terms of the model that a thermal test gives: the bias over temperature, with what is not known of it.

Its unknowns are those of the correction that later tests take off their readings (module ``correction``): equal
origins are the same unknowns, so that a model of both tests knows how the two go together. Errors that the thermometer
and the converter have in the test and in the use of the model alike drop out. The constant of accelerometers at rest
holds what gravity adds: it is no bias, and only what changes with temperature is given.

Half of a hysteresis that is seen (``yes``) is ``bias_hysteresis``. Its error is taken as independent of that of the
polynomial, which lies midway between the paths. A model with it needs to know whether the sensor warms or cools.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.key import AXES, Key, Origin
from ...sensors.model.sensor_model import Provenance
from ..model_terms import ModelTerms
from ..protocol import Tested
from .correction import Known, ThermalCorrection, dof_of_sensors, sources_of_laws
from .reduction import Result

HYSTERESIS = "bias_hysteresis"


def model_terms(result: Result, tests: Sequence[Tested[Any, Any, Any]]) -> ModelTerms | None:
    """Return the bias over temperature; None where nothing of it has an uncertainty."""
    return model_terms_many([(result, tests)])[0]


def model_terms_many(given: Sequence[tuple[Result, Sequence[Tested[Any, Any, Any]]]]) -> list[ModelTerms | None]:
    """Return the same of each of many results, with the tests behind each."""
    known = sources_of_laws([result for result, _ in given])
    for one in known:
        if isinstance(one, DataError):
            raise one
    return [_terms(*one, own) for one, own in zip(given, known, strict=True) if not isinstance(own, DataError)]


def _terms(result: Result, tests: Sequence[Tested[Any, Any, Any]], known: Known) -> ModelTerms | None:
    bias, (found, sources) = ThermalCorrection(tests[0].id, result), known
    if found is None or not sources:
        return None
    every = np.arange(len(found.keys))
    of_sensor = [AXES.index(key.axis) for key in found.keys]
    parts = []
    for one, changes in sources:
        dof = one.dof if isinstance(one.dof, float) else dof_of_sensors(one, every, of_sensor)[of_sensor]
        parts.append(one.changed(given=one.origin._replace(test=bias.test), dof=dof, changes=changes))
    estimate = Estimate.of_own(found.keys, found.values, found.units, tuple(parts))
    estimate = _with_hysteresis(result, tests[0].id, estimate)
    sweeps = tuple(sweep.name for sweep in result.readings.sweeps)
    axes = tuple(axis for axis in tests[0].facts.axes if axis in {key.axis for key in found.keys})
    return ModelTerms(
        estimate,
        estimate.keys,
        axes,
        dict.fromkeys(estimate.keys, Provenance(tests[0].id, sweeps)),
        {
            str(Key(HYSTERESIS, axis)): f"{one.paths.word}: {one.paths.why}"
            for axis, one in result.sensors.items()
            if Key(HYSTERESIS, axis) not in estimate.keys
        },
        reference_temperature=result.plan.reference_temperature,
        temperature_range=bias.range,
        bias_run_to_run=_run_to_run(result, estimate, axes),
    )


def _run_to_run(result: Result, estimate: Estimate, axes: Sequence[str]) -> Array | None:
    """Return the scatter of the bias between power-ups, (k,): that of their mean, times the root of their number."""
    between = [one for one in estimate.components if isinstance(one.origin, Origin) and one.origin.level == "run"]
    places = [estimate.keys.index(Key("bias", axis)) for axis in axes if Key("bias", axis) in estimate.keys]
    if len(places) < len(axes) or not between:
        return None
    variance = np.sum([np.diag(one.covariance)[places] for one in between], axis=0)
    return np.asarray(np.sqrt(variance * result.readings.runs))


def _with_hysteresis(result: Result, test: str, estimate: Estimate) -> Estimate:
    """Return an estimate with half of the hysteresis of each axis that has one."""
    found: dict[Key, tuple[float, float, float]] = {}
    for axis, one in result.sensors.items():
        effect = one.paths.hysteresis
        if one.paths.word == "yes" and None not in (effect.value, effect.u, effect.dof):
            found[Key(HYSTERESIS, axis)] = 0.5 * (effect.value or 0.0), 0.5 * (effect.u or 0.0), effect.dof or 0.0
    if not found:
        return estimate
    values, u, behind = np.array(list(found.values())).T
    k, n = len(estimate.keys), len(found)
    origin = Origin("scatter between runs, hysteresis", test=test, level="run")
    covariance, free = np.zeros((k + n, k + n)), np.full(k + n, np.inf)
    covariance[k:, k:], free[k:] = np.diag(u**2), behind
    wider = []
    for part in estimate.components:
        dof = np.append(np.broadcast_to(part.dof, k), np.full(n, np.inf))
        changes = None if part.changes is None else np.pad(part.changes, ((0, 0), (0, n)))
        wider.append(part.changed(covariance=np.pad(part.covariance, (0, n)), dof=dof, changes=changes))
    return Estimate(
        (*estimate.keys, *found),
        np.append(estimate.values, values),
        (*estimate.units, *(result.readings.unit,) * n),
        (*wider, Component(origin, "A", covariance, free, "t")),
    )
