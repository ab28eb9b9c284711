"""A model as plain values, and back: what ``model.json`` holds.

Floats keep all their digits (the shortest text that reads back to the same bits), so the way there and back is
exact. What a reader needs to apply the model without this package stands in the file in words: the equation, its
direction, the order of the matrix and the order of the steps of compensation. No number is ever NaN or infinite;
infinite degrees of freedom are null.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import groupby
from typing import Any, TypeVar

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array, Component, Estimate
from ...core.influence import Occasion, Selection, influence_fields, influence_read
from ...core.key import Key, Origin
from ...core.results import finite
from ...core.schema.checksum import text_checksum
from ...core.schema.content import check_content
from ...core.schema.json_text import Filled, Frame, Hole, json_texts
from ...core.schema.model import Model as OneModel
from ...core.schema.model import Models as ModelContent
from ..chain.converter import Chain, Thermometer
from .model_set import ModelSet
from .sensitivity import PARTS, Sensitivity
from .sensor_model import APPLY_ORDER, MATRIX_ORDER, Item, Provenance, SensorModel
from .terms import SHAPES, parameter_keys

T = TypeVar("T")
FORMAT = "inertialcal model"
SCHEMA_VERSION = 2
FIRST = 1  # version of files that hold one model, without condition, sensitivities and noise
OLD_WORDS: dict[str, Any] = {
    "format": FORMAT,
    "schema_version": FIRST,
    "direction": "forward: from the true input x to the output v",
    "equation": [
        "u = M(T) x",
        "v = S0 * { K0(T, p, t) + u + K1'/2 |u| + K2 u^2 + K3 u^3 + G f } + noise",
        "K0 = bias + sum_j bias_temperature[j-1] (T - T_ref)^j + bias_pressure (p - p_ref)"
        " + sum_m bias_warm_up[m] exp(-t / warm_up_time[m])"
        " + bias_temperature_rate dT/dt + bias_hysteresis sign(dT/dt) + run-to-run",
        "M(T) = sum_j matrix[j] (T - T_ref)^j",
        "K1' = scale_factor_asymmetry, K2 = second_order, K3 = third_order, G = g_sensitivity, S0 = scale_factor",
    ],
    "matrix_order": MATRIX_ORDER,
    "apply_order": list(APPLY_ORDER),
}
WORDS: dict[str, Any] = OLD_WORDS | {
    "schema_version": SCHEMA_VERSION,
    "equation": [
        *OLD_WORDS["equation"],
        "for each sensitivity, with d = channel - reference: K0 += bias d + bias_temperature d (T - T_ref),"
        " M_ii += scale_factor d",
    ],
    "models_by": "condition that the readings were made in; an empty name where none is told apart",
}
PLAIN = ("output_unit", "reference_pressure", "judged", "source")


def to_dict(models: ModelSet | SensorModel) -> dict[str, Any]:
    """Return models as plain values: words that fix the meaning of the numbers, and a model a condition."""
    found: dict[str, Any] = _plain_values(content_of(models))
    return found


def content_of(models: ModelSet | SensorModel) -> dict[str, Any]:
    """Return the same as ``json_texts`` takes it: arrays in place of lists, and frames of what units have alike."""
    return contents_of([models])[0]


def contents_of(every: Sequence[ModelSet | SensorModel]) -> list[dict[str, Any]]:
    """Return the same of many files; what they have alike is one object in all of them."""
    alike = _Alike()
    sets = [one if isinstance(one, ModelSet) else ModelSet((one,)) for one in every]
    return [
        {**WORDS, "models": {condition: _content(one, alike) for condition, one in models.items()}} for models in sets
    ]


class _Alike:
    """Plain values of what several models have: by the objects that they are made of, which the models hold."""

    def __init__(self) -> None:
        self.known: dict[tuple[object, ...], Any] = {}

    def of(self, key: tuple[object, ...], make: Callable[[], T]) -> T:
        """Return what was made for a key; make it where that is nothing yet."""
        if key not in self.known:
            self.known[key] = make()
        found: T = self.known[key]
        return found


def _plain_values(content: Any) -> Any:
    if isinstance(content, np.ndarray):
        return content.tolist()
    if isinstance(content, Filled):
        return _plain_values(content.content)
    if isinstance(content, dict):
        return {name: _plain_values(part) for name, part in content.items()}
    return [_plain_values(part) for part in content] if isinstance(content, list) else content


def _content(model: SensorModel, alike: _Alike) -> Filled:
    """Return the model as text, numbers, lists, arrays, and null for what is absent."""
    influences = sorted(model.influences.items())
    named = [*model.provenance.values()]
    item, chain, estimate, noise = model.item, model.chain, model.estimate, model.noise
    return Filled(
        MODEL,
        {
            "kind": model.kind,
            "axes": alike.of(("axes", model.axes), lambda: list(model.axes)),
            "unit": model.unit,
            "maker": item.maker,
            "part": item.part,
            "serial": item.serial,
            **{name: getattr(model, name) for name in PLAIN},
            **{f"term {name}": getattr(model, name) for name in SHAPES},
            "sensitivities": [
                {
                    "channel": one.channel,
                    "unit": one.unit,
                    "reference": float(one.reference),
                    **{part: _list(getattr(one, part)) for part in PARTS},
                    "range": _list(one.range),
                }
                for one in model.sensitivities
            ],
            "chain": None if chain is None else alike.of(("chain", id(chain)), lambda: _chain_to_dict(chain)),
            "temperature_range": _list(model.temperature_range),
            "pressure_range": _list(model.pressure_range),
            "estimate": None if estimate is None else _estimate_content(estimate, alike),
            "noise": None if noise is None else _noise_content(noise, alike),
            "not_estimated": alike.of(
                ("not_estimated", *model.not_estimated.items()), lambda: dict(model.not_estimated)
            ),
            "provenance": alike.of(
                ("provenance", *model.provenance, *_same(named)), lambda: _provenance_content(model.provenance)
            ),
            "influences": alike.of(
                ("influences", *[(name, id(one)) for name, one in influences]),
                lambda: {name: influence_fields(one) for name, one in influences},
            ),
            "occasion": alike.of(
                ("occasion", model.occasion, model.tests),
                lambda: model.occasion._asdict() | {"tests": list(model.tests)},
            ),
            "selections": [
                {
                    "sha256": list(one.sha256),
                    "groups": list(one.groups),
                    "windows": [list(pair) for pair in one.windows],
                }
                for one in model.selections
            ],
        },
    )


MODEL = Frame(
    {name: Hole(name) for name in ("kind", "axes", "unit")}
    | {"item": {name: Hole(name) for name in ("maker", "part", "serial")}}
    | {name: Hole(name) for name in PLAIN}
    | {"terms": {name: Hole(f"term {name}") for name in SHAPES}}
    | {
        name: Hole(name)
        for name in ("sensitivities", "chain", "temperature_range", "pressure_range", "estimate", "noise",
                     "not_estimated", "provenance", "influences", "occasion", "selections")
    }
)  # fmt: skip
ESTIMATE = Frame({name: Hole(name) for name in ("names", "values", "units", "components")})
NOISE = Frame({name: Hole(name) for name in ("names", "values", "units", "components", "keys")})


def _same(named: Sequence[Provenance]) -> list[tuple[Provenance, int]]:
    """Return each that is another one, and how many times it stands there."""
    return [(one, sum(1 for _ in group)) for one, group in groupby(named)]


def _provenance_content(provenance: Mapping[str, Provenance]) -> dict[str, dict[str, Any]]:
    sources: dict[Provenance, dict[str, Any]] = {}
    for made in provenance.values():
        if made not in sources:
            sources[made] = {"test": made.test, "recordings": list(made.recordings), "source": made.source}
    return {name: sources[one] for name, one in provenance.items()}


def _chain_to_dict(chain: Chain) -> dict[str, Any]:
    """Return a chain without what the model says: its axes and its input unit."""
    thermometer = chain.thermometer
    return {
        "step": float(chain.step),
        "codes": None if chain.codes is None else list(chain.codes),
        "output_unit": chain.output_unit,
        "scale_factor": np.broadcast_to(np.asarray(chain.scale_factor, dtype=float), len(chain.axes)).tolist(),
        "reference": chain.reference,
        "zero": _list(chain.zero),
        "gain": _list(chain.gain),
        "thermometer": None if thermometer is None else {
            name: _list(getattr(thermometer, name)) for name in ("slope", "voltage", "temperature")
        } | ({"own_reference": True} if thermometer.own_reference else {}),
        "validity_minimum": chain.validity_minimum,
        **({} if chain.input_unit == "count" else {"input_unit": chain.input_unit}),
    }  # fmt: skip


def _chain(content: Mapping[str, Any] | None, axes: Sequence[str], unit: str) -> Chain | None:
    if content is None:
        return None
    warm, codes = content["thermometer"], content["codes"]
    if isinstance(content["reference"], str) and content["reference"] != "channel":
        raise DataError(f'chain: reference {content["reference"]!r}, need "channel" or a voltage', code="schema")
    if codes is not None and len(codes) != 2:
        raise DataError(f"chain: codes {codes}, need the lowest and the highest", code="schema")
    return Chain(
        tuple(axes),
        float(content["step"]),
        None if codes is None else (int(codes[0]), int(codes[1])),
        unit,
        content["output_unit"],
        np.array(content["scale_factor"], dtype=float),
        content["reference"],
        _plain(content["zero"]),
        _plain(content["gain"]),
        thermometer=None
        if warm is None
        else Thermometer(
            *(_plain(warm[key]) for key in ("slope", "voltage", "temperature")),
            own_reference=warm.get("own_reference") is True,
        ),
        validity_minimum=content["validity_minimum"],
        input_unit=str(content.get("input_unit", "count")),
    )


def _plain(value: Any) -> Array | float:
    """Return one number for all, or an array."""
    return np.array(value, dtype=float) if isinstance(value, list) else float(value)


def model_checksum(model: SensorModel) -> str:
    """Return the checksum that a ``model.json`` with this model alone carries, as ``sha256:...``."""
    return text_checksum(json_texts(content_of(model))[1])


def from_dict(content: Mapping[str, Any]) -> ModelSet:
    """Return the models of plain values.

    Raises
    ------
    DataError
        ``schema_version`` for a version not known here; ``schema`` if a key is missing, unknown or of the wrong
        kind, or the words that fix the meaning of the numbers differ; and as `SensorModel`.
    """
    if content.get("format") != FORMAT:
        raise DataError("not a model: wrong or missing key format", do=f"Need {FORMAT!r}", code="schema")
    version = content.get("schema_version")
    if version not in {FIRST, SCHEMA_VERSION}:
        what = f"schema version {version!r} is not known"
        do = f"This version reads {FIRST} and {SCHEMA_VERSION}: use the version of inertialcal that wrote the file"
        raise DataError(what, do=do, code="schema_version")
    for key, words in (OLD_WORDS if version == FIRST else WORDS).items():
        if content.get(key) != words:
            raise DataError(f"{key} reads {content.get(key)!r}, need {words!r}", code="schema")
    check_content(OneModel if version == FIRST else ModelContent, content, do="Take the file as it was written")
    by_condition = {"": content} if version == FIRST else content["models"]
    try:
        return ModelSet(tuple(_model(one, condition) for condition, one in by_condition.items()))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise DataError(
            f"not a model: {type(error).__name__} {error}",
            why="a key is missing or holds another kind of value",
            do="Take the file as it was written",
            code="schema",
        ) from None


def _model(content: Mapping[str, Any], condition: str) -> SensorModel:
    terms = content["terms"]
    unknown = sorted(set(terms) - set(SHAPES))
    if unknown:
        raise DataError(f"unknown term(s): {', '.join(unknown)}", code="schema")
    arrays: dict[str, Any] = {
        name: None if terms[name] is None else np.array(terms[name], dtype=float) for name in SHAPES
    }
    sensitivities = tuple(_sensitivity(one) for one in content.get("sensitivities", ()))
    channels = [one.channel for one in sensitivities]
    noise = content.get("noise")
    model = SensorModel(
        kind=content["kind"],
        axes=tuple(content["axes"]),
        item=Item(**content["item"]),
        condition=condition,
        **{name: content[name] for name in PLAIN},
        **arrays,
        sensitivities=sensitivities,
        temperature_range=_pair(content["temperature_range"]),
        pressure_range=_pair(content["pressure_range"]),
        estimate=None if content["estimate"] is None else _estimate(content["estimate"], content["axes"], channels),
        noise=None if noise is None else _noise(noise),
        chain=_chain(content.get("chain"), content["axes"], content["unit"]),
        not_estimated=dict(content["not_estimated"]),
        provenance={
            name: Provenance(one["test"], tuple(one["recordings"]), one["source"])
            for name, one in content["provenance"].items()
        },
        **_shared(content),
    )
    if content["unit"] != model.unit:
        raise DataError(f"unit {content['unit']!r} for a {model.kind}, need {model.unit!r}", code="schema")
    return model


def _sensitivity(content: Mapping[str, Any]) -> Sensitivity:
    parts = {part: None if content[part] is None else np.array(content[part], dtype=float) for part in PARTS}
    return Sensitivity(
        content["channel"], content["unit"], float(content["reference"]), **parts, range=_pair(content["range"])
    )


def _shared(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return what another model can share with this one; nothing of a file from before it was stored."""
    occasion = content.get("occasion")
    if occasion is None:
        return {}
    return {
        "influences": {name: influence_read(one) for name, one in content["influences"].items()},
        "occasion": Occasion(*(occasion[name] for name in Occasion._fields)),
        "tests": tuple(occasion["tests"]),
        "selections": tuple(
            Selection(tuple(one["sha256"]), tuple(one["groups"]), tuple((a, b) for a, b in one["windows"]))
            for one in content["selections"]
        ),
    }


def _noise_content(noise: Estimate, alike: _Alike) -> Filled:
    """Return noise terms with what each is of: its name is no parameter's, so the key stands beside it."""
    keys = alike.of(
        ("keys", noise.keys),
        lambda: [{"quantity": key.quantity, "axis": key.axis, "power": key.power} for key in noise.keys],
    )
    return Filled(NOISE, _estimate_content(noise, alike).values | {"keys": keys})


def _noise(content: Mapping[str, Any]) -> Estimate:
    keys = tuple(Key(one["quantity"], one["axis"], power=one["power"]) for one in content["keys"])
    return replace(_estimate(content, ()), given=keys)


def _estimate_content(estimate: Estimate, alike: _Alike) -> Filled:
    values = {
        "names": alike.of(("list", estimate.names), lambda: list(estimate.names)),
        "values": estimate.values,
        "units": alike.of(("list", estimate.units), lambda: list(estimate.units)),
        "components": [_component_content(one) for one in estimate.components],
    }
    return Filled(ESTIMATE, values)


def _component_content(one: Component) -> Filled:
    dof = one.dof if isinstance(one.dof, np.ndarray) else finite(one.dof)
    values: dict[str, Any] = {"covariance": one.covariance, "dof": dof, "changes": one.changes}
    unit = None
    if one.stated is not None:
        values["u"], unit = float(one.stated[0]), one.stated[1]
    return Filled(_frame(one.given, one.kind, one.distribution, unit, one.unknowns, one.term), values)


@lru_cache(maxsize=256)
def _frame(
    given: Origin | str,
    kind: str,
    distribution: str,
    unit: str | None,
    unknowns: tuple[str, ...],
    term: str,
) -> Frame:
    """Return a source of uncertainty without its numbers."""
    return Frame(
        {
            "source": str(given),
            "kind": kind,
            "covariance": Hole("covariance"),
            "dof": Hole("dof"),
            "distribution": distribution,
            "stated": None if unit is None else {"u": Hole("u"), "unit": unit},
            "origin": (given if isinstance(given, Origin) else Origin(given))._asdict(),
            "unknowns": list(unknowns),
            "changes": Hole("changes"),
            "term": term,
        },
        endless=frozenset({"dof"}),
    )


def _estimate(content: Mapping[str, Any], axes: Sequence[str], channels: Sequence[str] = ()) -> Estimate:
    components = tuple(
        Component(
            Origin(**one["origin"]) if one.get("origin") else one["source"],
            one["kind"],
            np.array(one["covariance"], dtype=float),
            _dof(one["dof"]),
            one["distribution"],
            None if one.get("stated") is None else (float(one["stated"]["u"]), str(one["stated"]["unit"])),
            None if one.get("changes") is None else np.array(one["changes"], dtype=float),
            tuple(one.get("unknowns", ())),
            one.get("term", ""),
        )
        for one in content["components"]
    )
    values = np.array(content["values"], dtype=float)
    known = {str(key): key for key in parameter_keys(content["names"], axes, channels)} if axes else {}
    return Estimate(
        tuple(known.get(name, name) for name in content["names"]), values, tuple(content["units"]), components
    )


def _dof(plain: Any) -> Array | float:
    if isinstance(plain, list):
        return np.array([math.inf if one is None else one for one in plain], dtype=float)
    return math.inf if plain is None else float(plain)


def _list(value: Any) -> Any:
    return None if value is None else np.asarray(value, dtype=float).tolist()


def _pair(value: Any) -> tuple[float, float] | None:
    return None if value is None else (float(value[0]), float(value[1]))
