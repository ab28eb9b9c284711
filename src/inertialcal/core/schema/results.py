"""What ``results.json`` and ``--json`` hold, schema 2: models of which ``results.schema.json`` is made.

``python -m inertialcal.core.schema.results`` writes the file again; a test holds it fresh.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from ..key import Method
from ..results import Status
from .content import Number, StatedInfluence

FILE = Path(__file__).with_name("results.schema.json")
DRAFT = "https://json-schema.org/draft/2020-12/schema"
Words = Literal["PASS", "FAIL", "INCONCLUSIVE", "OPEN"]


class Part(BaseModel):
    """A JSON object of which every member is known, and every number finite."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


class At(Part):
    """Where a figure holds: temperature, -20, degC."""

    what: str
    value: Number
    unit: str


class Member(Part):
    """A part of the readings: one flip, one run."""

    kind: str
    label: str


class Reason(Part):
    """Why there is no figure, or what limits it: programs read the code, people the text."""

    code: str
    text: str


class Interval(Part):
    """Two-sided interval with probability p; an open side is null."""

    lo: Number | None
    hi: Number | None
    p: Number


class Key(Part):
    """What a figure is of."""

    quantity: str
    axis: str
    sensor: str
    power: int
    at: At | None


class Curvature(Part):
    """What one unit of a curvature changes of a figure, in the unit of the figure, and how large it may be, in SI."""

    change: Number
    size: Number


class Figure(Key):
    """One published figure."""

    test: str
    condition: str
    method: Method = Field(strict=False)
    member: Member | None
    value: Number | None
    u: Number | None
    unit: str
    dof: Number | None = Field(description="Degrees of freedom of u; null is infinite.")
    interval: Interval | None
    status: Status
    reason: Reason | None
    shared: dict[str, Number] = Field(
        description="Signed change of the value, in its unit, for one standard uncertainty of an influence that "
        "another test can share; several unknowns of one influence are named: rate_table.mounting[xz]."
    )
    curvature: dict[str, Curvature] = Field(
        description="What a second- or third-order term of the unit does to the value where its line does not have it."
    )


class Influence(StatedInfluence, Part):
    """Uncertainty of one quantity of a standard, as stated."""

    reason: str = Field("", description="Why the uncertainty is zero, where it is.")
    redrawn_by: Literal["never", "certificate", "day", "mounting", "power_up", "dwell"]


class Occasion(Part):
    """What drew the errors of standards in a test, or in the tests of a model; empty where that is not known."""

    mounting: str
    power_up: str
    day: str
    site: str
    tests: list[str]


class Standard(Part):
    """An influence that is stated, or that would change a result and is not stated."""

    standard: str
    influence: str
    effect: str
    u: Number | None
    unit: str
    dof: Number | None
    distribution: str
    certificate: str
    reason: str = Field("", description="Why the uncertainty is zero, where it is.")
    stated: bool


class Input(Part):
    """A recording that a test drew on."""

    name: str
    file: str
    sha256: str
    kind: str
    rows: int


class Step(Part):
    """A test, in the order run."""

    test: str
    procedure: str
    use: Literal["fit", "hold_out", "report_only"]
    condition: str
    sensors: list[str] = Field(description="Names of the sensors that it reads.")
    terms: dict[str, list[str]] = Field(
        description="By the condition of a model: the kinds of its terms that come from this test."
    )
    source: str
    against: str | None
    after: list[str]
    groups: list[str] | None
    windows: list[list[str]] | None
    recordings: list[Input]
    dwells: int | None
    runs: int | None
    left_out: int
    time: list[str] | None = Field(
        None, description="First and last instant (UTC) of its readings, where its recordings say it."
    )


class Excluded(Part):
    """What a test did not use, and who or which rule decided so."""

    test: str
    axis: str
    place: str
    applied: Number | None
    unit: str
    rule: str
    decided_by: str
    reason: str
    count: int
    counts: str


class Covariance(Part):
    """Covariance of the values of a test, SI."""

    test: str
    keys: list[Key]
    units: list[str]
    matrix: list[list[Number]]


class Budget(Key):
    """One source of the uncertainty of one figure."""

    test: str
    source: str
    influence: str = Field(description="Name under [standards]; empty for other sources.")
    kind: Literal["A", "B"]
    level: str = Field(description="What was repeated, of scatter: run, dwell, sample, ...; empty for a standard.")
    distribution: str
    stated_u: Number | None
    stated_unit: str
    sensitivity: Number | None
    sensitivity_unit: str
    u: Number
    unit: str
    dof: Number | None
    share: Number


class Remark(Part):
    """Something usable but suspicious in the data."""

    code: str
    severity: Literal["info", "warning", "error"]
    what: str
    where: str
    count: int
    do: str


class AsRead(Part):
    """Beside a verdict on compensated readings: the same readings without compensation, by the same rule."""

    value: Number | None
    u: Number | None
    interval: Interval | None
    margin: Number | None
    verdict: Words


class Verdict(Part):
    """A requirement judged at one place."""

    requirement: str
    quantity: str = Field("", description="That it is about; not in files of version 0.2.0.")
    test: str
    axis: str
    sensor: str
    at: Number | None
    at_unit: str
    of: str
    value: Number | None
    u: Number | None
    unit: str
    interval: Interval | None
    lower: Number | None
    upper: Number | None
    margin: Number | None
    deciding_u: Number | None = Field(description="u that would decide at this value; null where u does not matter.")
    verdict: Words
    reason: str
    rule: str = Field(description="Decision rule in words.")
    accept_lower: Number | None = Field(description="Values from here on PASS; null without limit, or where none can.")
    accept_upper: Number | None
    risk: Number | None = Field(
        description="Of a PASS, probability that the true value lies outside the limits; of a FAIL, inside."
    )
    ratio: Number | None = Field(description="Test uncertainty ratio: span of two limits over 2 U.")
    readings: Literal["as_read", "compensated"]
    as_read: AsRead | None = Field(description="Of compensated readings: the same as they were read.")


class LoopAxis(Part):
    """Closed loop of one axis: rms error of readings held out, raw and compensated."""

    condition: str = Field("", description="Of the campaign, whose model is judged; empty where no test states one.")
    axis: str
    dwells: int
    runs: int
    unit: str
    raw_rms: Number
    compensated_rms: Number
    mean_square_gain: Number
    u: Number | None  # none where no power-up could be compared with another
    dof: Number | None
    allowed: Number
    verdict: str
    reason: str


class LoopOverTemperature(Part):
    """Closed loop of the bias over temperature, on power-ups held out."""

    condition: str = Field("", description="Of the campaign, whose model is judged; empty where no test states one.")
    test: str
    against: str
    axis: str
    cells: int
    runs: int
    unit: str
    raw_rms: Number
    compensated_rms: Number
    verdict: str
    reason: str


class ClosedLoop(Part):
    """Whether compensation improves readings that the model has not seen."""

    verdict: str
    reason: str
    axes: list[LoopAxis]
    over_temperature: list[LoopOverTemperature]


class Verified(Part):
    """A row of the verification matrix."""

    requirement: str
    text: str
    method: str
    evidence: list[str]
    verdict: Words
    rule: str = Field(description="Decision rule in words.")
    decision: dict[str, Any] = Field(description="Decision rule as campaign.toml states it.")


class Results(Part):
    """Content of results.json; its curves stand in curves.parquet."""

    schema_version: Literal[2] = Field(alias="schema")
    campaign: dict[str, Any]
    item: dict[str, str]
    site: dict[str, str | None]
    sensors: dict[str, dict[str, Any]]
    standards: list[Standard]
    influences: dict[str, Influence]
    occasions: dict[str, Occasion] = Field(description="By test, and by model.")
    sequence: list[Step]
    exclusions: list[Excluded]
    results: list[Figure]
    covariances: list[Covariance]
    budgets: list[Budget]
    remarks: list[Remark]
    decision_rule: str
    verdicts: list[Verdict]
    closed_loop: ClosedLoop
    verification: list[Verified]
    verdict: Words | None
    curves_sha256: str = Field(description="SHA-256 of the curves.parquet that belongs to these results.")
    checksum: str = Field(
        description="SHA-256 over this content without the checksum: keys sorted, no blanks, UTF-8; sha256:..."
    )


class Side(Part):
    """A figure that was compared."""

    value: Number | None
    u: Number | None
    dof: Number | None
    test: str


class Compared(Figure):
    """Difference of two figures, as ``compare`` prints it."""

    first: Side
    second: Side
    p_value: Number | None
    verdict: str
    ratio: Figure | None = Field(None, description="Second over first, of sizes.")


class Scored(Figure):
    """A figure of a simulated campaign, as ``score`` prints it."""

    truth: Number
    inside: bool | None
    inside_apart: bool | None  # Once the errors of the standards are taken off


class Covered(Key):
    """How often intervals held the truth, as ``score --rig`` prints it."""

    test: str
    hits: int
    n: int
    missing: int
    rate: Number | None
    interval: Interval | None
    verdict: Words


class Surveyed(Part):
    """What is in a file, as ``info`` prints it."""

    path: str
    sha256: str
    format: str
    rows: int
    compensated_by: str
    channels: list[dict[str, Any]]
    time: dict[str, Any]
    hints: list[str]
    remarks: list[Remark]
    do: str = Field("", description="What to do before figures of this file are used; empty where nothing is wrong.")
    next: str | None


class Printed(BaseModel):
    """What a command prints with --json: the same rows; a command adds members of its own."""

    model_config = ConfigDict(extra="allow", strict=True)

    command: str
    version: str
    schema_version: Literal[2] = Field(alias="schema")
    inputs: list[dict[str, Any]]
    results: list[Figure | Compared | Scored | Covered | Surveyed]
    remarks: list[Remark]
    verdicts: list[dict[str, Any]]
    errors: list[dict[str, Any]]
    exit: int


def schema_text() -> str:
    """Return the JSON Schema of ``results.json``, with that of ``--json`` under ``$defs/Printed``."""
    content = Results.model_json_schema()
    printed = Printed.model_json_schema()
    inner = content.pop("$defs") | printed.pop("$defs") | {"Printed": printed}
    whole = {"$schema": DRAFT, "title": content.pop("title"), **content, "$defs": dict(sorted(inner.items()))}
    return json.dumps(whole, indent=1) + "\n"


if __name__ == "__main__":
    FILE.write_text(schema_text(), encoding="utf-8", newline="\n")
