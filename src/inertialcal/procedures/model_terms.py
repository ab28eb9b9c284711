"""What a procedure gives to the model of a sensor, and what it says of readings that the model has not seen.

The assembler of models (``campaign.models``) knows no procedure: it joins these, and adds what the campaign says of
item, output and verdicts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, TypeVar, get_args

import numpy as np

from ..core.curve import Curve
from ..core.estimate import Array, Component, Estimate, placed_changes
from ..core.key import Key, Origin
from ..core.remarks import Remark
from ..core.results import Row
from ..core.unknowns import Unknowns
from ..sensors.model.sensitivity import ChannelReference
from ..sensors.model.sensor_model import Provenance
from ..statistics.closed_loop import AxisLoop

T = TypeVar("T")
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
BIASES = ("bias", "bias_temperature")  # the other terms are entries of the matrix


def kind_of(key: Key) -> TermKind:
    """Return the kind of term that a parameter of the model is."""
    return KIND_OF.get(key.quantity, "sensitivity")


@dataclass(frozen=True, eq=False)
class ModelTerms:
    """Terms of the model of a sensor, from one joint reduction.

    Parameters
    ----------
    estimate : Estimate or None
        SI; it may hold more than the model takes. None where nothing could be estimated.
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
    taken_off : mapping of Origin to Unknowns
        Unknowns of corrections that the readings had before, by origin.
    changes : mapping of Origin to mapping of Key to ndarray, shape (s,)
        By origin: what one standard uncertainty of each of those unknowns changes in a value of the estimate.
    references : mapping of str to ChannelReference
        By channel (``"supply"``, ``"pressure"``): what sensitivities refer to, and where they hold.
    noise : Estimate or None
        Terms of the noise, by axis: keys as rows of static noise have them, SI. They are shown and exported with the
        model; no reading is compensated with them.
    test : str
        That they come from; the engine says it.
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
    taken_off: Mapping[Origin, Unknowns] = field(default_factory=dict[Origin, Unknowns])
    changes: Mapping[Origin, Mapping[Key, Array]] = field(default_factory=dict[Origin, Mapping[Key, Array]])
    references: Mapping[str, ChannelReference] = field(default_factory=dict[str, ChannelReference])
    noise: Estimate | None = None
    test: str = ""

    def with_bias_of(self, other: ModelTerms | None) -> ModelTerms:
        """Return these with the bias of another reduction, taken as independent; without bias where there is none."""
        if other is None:
            return replace(self, parameters=tuple(key for key in self.parameters if key.quantity not in BIASES))
        if self.estimate is None or other.estimate is None:
            known = other if self.estimate is None else self
            estimate, keys = known.estimate, known.parameters
        else:
            estimate = _merged(self.estimate, other.estimate)
            chosen = {key for key in self.parameters if key.quantity not in BIASES}
            chosen |= {key for key in other.parameters if key.quantity in BIASES}
            keys = tuple(key for key in estimate.keys if key in chosen)
        parameters = tuple(key for key in keys if set(key.axis) <= {*self.axes})
        parts = {origin: (self.changes.get(origin, {}), other.changes.get(origin, {}))
                 for origin in (*self.changes, *other.changes)}  # fmt: skip
        return replace(
            self,
            estimate=estimate,
            parameters=parameters,
            provenance=_of_each(self.provenance, other.provenance),
            referenced=other.referenced,
            taken_off={**self.taken_off, **other.taken_off},
            changes={origin: _of_each(*pair) for origin, pair in parts.items()},
        )


def _of_each(mine: Mapping[Key, T], its: Mapping[Key, T]) -> dict[Key, T]:
    """Return the matrix entries of one mapping by key, and the biases of the other."""
    entries = {key: one for key, one in mine.items() if key.quantity not in BIASES}
    return entries | {key: one for key, one in its.items() if key.quantity in BIASES}


def _merged(matrix: Estimate, bias: Estimate) -> Estimate:
    """Return the matrix entries of one estimate and the biases of another, taken as independent."""
    a = matrix.select([key for key in matrix.keys if key.quantity not in BIASES])
    b = bias.select([key for key in bias.keys if key.quantity in BIASES])
    na, n = len(a.keys), len(a.keys) + len(b.keys)
    components = (*(_placed(one, 0, n) for one in a.components), *(_placed(one, na, n) for one in b.components))
    return Estimate((*a.keys, *b.keys), np.concatenate([a.values, b.values]), (*a.units, *b.units), components)


def _placed(component: Component, start: int, size: int) -> Component:
    """Return a component of some of the values as one of all of them."""
    at = slice(start, start + len(component.covariance))
    covariance, dof = np.zeros((size, size)), np.full(size, np.inf)
    covariance[at, at] = component.covariance
    dof[at] = component.dof
    return replace(component, covariance=covariance, dof=dof, changes=placed_changes(component, start, size))


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
