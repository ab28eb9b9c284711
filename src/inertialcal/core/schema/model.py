"""What ``model.json`` holds: the kind of value of each key. What the numbers mean, `sensors.model` checks."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict

from .content import Number, Numbers, Pair, StatedInfluence


class Part(BaseModel):
    """A JSON object; keys that a later version adds are let be."""

    model_config = ConfigDict(strict=True)


class Item(Part):
    """Which unit it is."""

    model_config = ConfigDict(extra="forbid")

    maker: str = ""
    part: str = ""
    serial: str = ""


class Stated(Part):
    """Uncertainty of a standard, as its certificate has it."""

    u: Number
    unit: str


class Origin(Part):
    """Where an uncertainty comes from."""

    what: str
    test: str
    standard: str
    quantity: str
    level: str


class Influence(StatedInfluence, Part):
    """Uncertainty of one quantity of a standard, as stated."""

    redrawn_by: str


class Occasion(Part):
    """What drew the errors of standards; empty where that is not known."""

    mounting: str
    power_up: str
    day: str
    site: str
    tests: list[str]


class Selection(Part):
    """What a test takes of recordings."""

    sha256: list[str]
    groups: list[str]
    windows: list[list[int]]


class Component(Part):
    """One source of the uncertainty."""

    source: str
    kind: str
    covariance: Numbers
    dof: Number | list[Number | None] | None
    distribution: str
    stated: Stated | None = None
    origin: Origin | None = None
    unknowns: list[str] = []
    changes: Numbers | None = None
    term: str = ""


class Estimate(Part):
    """Values with their covariance."""

    names: list[str]
    values: list[Number]
    units: list[str]
    components: list[Component]


class KeyOfNoise(Part):
    """What a noise term is of."""

    quantity: str
    axis: str
    power: int


class Noise(Estimate):
    """Noise terms with their covariance."""

    keys: list[KeyOfNoise]


class Sensitivity(Part):
    """Change of bias and scale factor with a channel."""

    channel: str
    unit: str
    reference: Number
    bias: Numbers | None
    bias_temperature: Numbers | None
    scale_factor: Numbers | None
    range: Pair | None


class Provenance(Part):
    """Where a parameter comes from."""

    test: str
    recordings: list[str]
    source: str


class Thermometer(Part):
    """Linear temperature channel."""

    slope: Numbers | Number
    voltage: Numbers | Number
    temperature: Numbers | Number
    own_reference: bool = False  # whether it was read against a reference recorded for it alone


class Chain(Part):
    """From codes to readings."""

    step: Number
    codes: list[int] | None
    output_unit: str
    scale_factor: Numbers
    reference: str | Number
    zero: Numbers | Number
    gain: Numbers | Number
    thermometer: Thermometer | None
    validity_minimum: Number | None
    input_unit: Literal["count", "V"] = "count"  # what it starts from


class Model(Part):
    """One model: all of a model.json of version 1."""

    kind: str
    axes: list[str]
    unit: str
    item: Item
    output_unit: str
    reference_pressure: Number | None
    judged: bool
    source: str
    terms: dict[str, Numbers | None]
    sensitivities: list[Sensitivity] = []
    chain: Chain | None = None
    temperature_range: Pair | None
    pressure_range: Pair | None
    estimate: Estimate | None
    noise: Noise | None = None
    not_estimated: dict[str, str]
    provenance: dict[str, Provenance]
    influences: dict[str, Influence] = {}
    occasion: Occasion | None = None
    selections: list[Selection] = []


class Models(Part):
    """Content of model.json: a model a condition."""

    models: dict[str, Model]
