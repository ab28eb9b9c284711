"""Budgets and settings of filters, from models, noise at rest, and how the sensor is used, each as it was said."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...core.errors import DataError, PlanError, UsageError
from ...core.key import Kind
from ...core.remarks import Remark
from ...core.units import factor, kind_of_unit, parse_quantity
from ...files.models.model_file import ModelFile
from ...files.source import load
from ...procedures import procedure_names, procedure_of
from ...procedures.given import READING, Said
from ...sensors.noise.filter_budget import PARTS, Budget, Use, filter_budget, settings_of, vibration_levels
from ...sensors.noise.terms import TERMS, Sinusoid, Term
from ...sensors.noise.to_filters import FilterBlock
from ...signals.spectrum.psd import psd
from ..calls.call import call
from ..calls.given import read_as_said

SAID = {  # what is said of the use -> unit inside; "reading" is that of the sensor
    "temperature_span": "degC", "temperature_time": "s", "temperature": "degC", "motion": "rad/s", "motion_time": "s",
    "force": "m/s^2", "force_time": "s", "steady_force": "m/s^2", "turn_on": "reading", "residual": "reading",
    "g_sensitivity": "(rad/s)/(m/s^2)", "rectification": "reading/(m/s^2)^2", "horizon": "s", "filter_rate": "Hz",
}  # fmt: skip
UNIT: dict[str, str] = {"gyro": "rad/s", "accelerometer": "m/s^2"}
Noise = dict[Kind, dict[str, tuple[Term, ...]]]


@dataclass(frozen=True, eq=False)
class FilterSettings:
    """What filters must carry, and their settings."""

    budgets: tuple[Budget, ...]  # One a sensor
    blocks: Mapping[str, FilterBlock]  # Filter -> its settings
    sample_rate: float | None  # Of the readings [Hz]
    inputs: tuple[dict[str, str], ...]  # Path and SHA-256 of each file
    remarks: tuple[Remark, ...]


def filter_settings(
    models: Sequence[ModelFile],
    targets: Sequence[str] = (),
    noise: str | Path | None = None,
    vibration: str | Path | None = None,
    said: Mapping[str, str] | None = None,
    without: Sequence[str] = (),
    reading: Said | None = None,
    take: Sequence[str] = (),
) -> FilterSettings:
    """Return what filters must carry of the sensors of some models.

    Parameters
    ----------
    models : sequence of ModelFile
        One a sensor.
    targets : sequence of str
        Filters whose settings are wanted.
    noise : path, optional
        Recording at rest, or terms.json of ``allan``; the noise of the models if not given.
    vibration : path, optional
        Recording of the vibration in use, faster than the readings of the filter.
    said : mapping of str to str, optional
        How the sensor is used: quantities with units, by the names of `SAID`.
    without : sequence of str
        Parts of the models that are not applied in use.
    reading : Said, optional
        How the files are read: columns, units, ...
    take : sequence of str
        Terms that are taken where the record cannot separate them from others; ``"upper_limit"`` of a random walk.

    Raises
    ------
    UsageError
        ``one_of_each`` for two models of a kind; ``wrong_value`` for a quantity that does not fit; ``unknown_name``.
    DataError
        As ``filter_budget``; as reading the files.
    """
    kinds = [one.model.kind for one in models]
    if len(set(kinds)) < len(kinds):
        raise UsageError(f"two models of a {kinds[0]}", do="Give one of each", code="one_of_each")
    wrong = [one for one in without if one not in PARTS]
    if wrong:
        raise UsageError(
            f"--without {wrong[0]}: no such part", do=f"There are: {', '.join(PARTS)}", code="unknown_name"
        )
    inputs = [{"path": one.path, "sha256": one.sha256} for one in models]
    remarks: list[Remark] = []
    stated = dict(said or {})
    horizon = _value("horizon", stated["horizon"], "s") if "horizon" in stated else None
    reading = reading or Said()
    rest, rate = _noise(noise, reading, horizon, take, inputs, remarks)
    sample_rate = _value("filter_rate", stated["filter_rate"], "Hz") if "filter_rate" in stated else rate
    shaken = _vibration(vibration, reading, sample_rate, inputs, remarks)
    budgets = []
    for one in models:
        kind = one.model.kind
        use = _use(kind, stated, without, sample_rate, shaken, alone=len(models) == 1)
        budgets.append(filter_budget(one.model, use, rest.get(kind)))
    by_kind = {one.kind: one for one in budgets}
    blocks = {
        target: settings_of(target, by_kind.get("gyro"), by_kind.get("accelerometer"), sample_rate)
        for target in dict.fromkeys(targets)
    }
    return FilterSettings(tuple(budgets), blocks, sample_rate, tuple(inputs), tuple(remarks))


def _use(
    kind: Kind, said: Mapping[str, str], without: Sequence[str], sample_rate: float | None,
    shaken: Mapping[str, tuple[float, float]], alone: bool,
) -> Use:  # fmt: skip
    values: dict[str, Any] = {}
    for name, text in said.items():
        if name == "filter_rate":
            continue
        unit = SAID[name]
        own = unit.replace("reading", UNIT[kind])
        if unit != own and not alone and not _fits(text, own):
            continue  # said of the other sensor
        values[name] = _value(name, text, own)
    values["sample_rate"] = sample_rate
    if "accelerometer" in shaken:
        values["vibration"] = shaken["accelerometer"][0]
    if kind in shaken:
        values["folded"] = shaken[kind][1]
    try:
        return Use(**values, without=tuple(one for one in PARTS if one in without))
    except PlanError as error:
        (problem,) = error.problems
        raise UsageError(problem.what, do=problem.do, code="wrong_value") from None


def _fits(text: str, unit: str) -> bool:
    try:
        parse_quantity(text).to(unit)
    except DataError:
        return False
    return True


def _value(name: str, text: str, unit: str) -> float:
    """Return what an option says, in a unit; the refusal names the option."""
    option = f"--{name.replace('_', '-')}"
    if name == "filter_rate":  # a bare number is in Hz, as the nouns take it
        with suppress(ValueError):
            text = f"{float(text)!r} Hz"
    try:
        return parse_quantity(text).to(unit, difference=name == "temperature_span")
    except DataError as error:
        (problem,) = error.problems
        what = f"{option} {text!r}: {problem.what}"
        raise UsageError(what, do=problem.do or f"Give a quantity in {unit}", code="wrong_value") from None


def _noise(
    path: str | Path | None, reading: Said, horizon: float | None, take: Sequence[str],
    inputs: list[dict[str, str]], remarks: list[Remark],
) -> tuple[Noise, float | None]:  # fmt: skip
    """Return terms at rest by kind and axis, and the sample rate of their record."""
    if path is None:
        return {}, None
    if str(path).lower().endswith(".json"):
        written, rate = _written_terms(path, inputs)
        remarks += [one for kind, axes in written.items() for one in _lines(kind, axes)]
        return {kind: {axis: tuple(t for t in own if not isinstance(t, Sinusoid)) for axis, own in axes.items()}
                for kind, axes in written.items()}, rate  # fmt: skip
    (name,) = (one for one in procedure_names() if procedure_of(one).gives == ("noise",))
    said = {one: value for one in READING if (value := getattr(reading, one)) not in (None, {}, [])}
    found = call(name, path, said, options=True)
    inputs += [{"path": one, "sha256": digest} for one, digest in found.inputs.items()]
    remarks += found.remarks
    rest: Noise = {}
    for one in found.tested:
        if one.facts.kind:
            each = {axis.axis: axis.for_filters(one.facts.kind, horizon, take) for axis in one.result.axes}
            rest[one.facts.kind] = {axis: terms for axis, (terms, _) in each.items()}
            remarks += [Remark("terms_taken", "info", line) for _, lines in each.values() for line in lines]
            remarks += _lines(one.facts.kind, {axis.axis: axis.terms for axis in one.result.axes})
    if not rest:
        what = "no sensor with a known unit: a filter needs rad/s and m/s^2"
        raise DataError(what, str(path), do="Give the unit: --unit gyro=UNIT --unit acc=UNIT", code="no_unit")
    return rest, 1.0 / found.tested[0].readings.records[0].interval


def _lines(kind: Kind, axes: Mapping[str, Sequence[Term]]) -> list[Remark]:
    """Return what to say of lines in a record, which no filter holds."""
    each = [(axis, [t.frequency for t in own if isinstance(t, Sinusoid)]) for axis, own in axes.items()]
    listed = "; ".join(f"{axis} {', '.join(f'{f:.4g}' for f in found)} Hz" for axis, found in each if found)
    what = f"{kind}: lines in the record: {listed}: no filter holds them, they are not in the budget"
    return [Remark("lines_left_out", "warning", what, do="Remove their cause, or filter them out")] if listed else []


def _written_terms(path: str | Path, inputs: list[dict[str, str]]) -> tuple[Noise, float | None]:
    """Return the terms of a ``terms.json``, as ``allan -o FOLDER`` writes it."""
    loaded = load(str(path), document=True)
    inputs.append({"path": str(path), "sha256": loaded.sha256})
    try:
        sensors = json.loads(loaded.data)["sensors"]
        rest: Noise = {
            one["kind"]: {
                axis["axis"]: tuple(
                    TERMS[term["term"]](**{name: float(term[name]) for name in TERMS[term["term"]].parameters})
                    for term in axis["terms"]
                )
                for axis in one["axes"]
            }
            for one in sensors
            if one["kind"] in UNIT
        }
        return rest, 1.0 / float(sensors[0]["sample_interval"])
    except (ValueError, KeyError, TypeError, IndexError, AttributeError, ZeroDivisionError, RecursionError):
        do = "Give a recording at rest, or terms.json of: inertialcal allan FILE -o FOLDER"
        raise DataError("no terms of noise", str(path), do=do, code="schema") from None


def _vibration(
    path: str | Path | None, reading: Said, sample_rate: float | None, inputs: list[dict[str, str]],
    remarks: list[Remark],
) -> dict[str, tuple[float, float]]:  # fmt: skip
    """Return rms and folded rms of a vibration by kind of sensor, SI."""
    if path is None:
        return {}
    if not sample_rate:
        do = "Add --filter-rate, that of the readings that the filter takes"
        raise UsageError("--vibration needs the sample rate of the filter", do=do, code="missing")
    recording = read_as_said(path, reading)
    inputs.append({"path": recording.source.path, "sha256": recording.source.sha256})
    if recording.sample_interval is None:
        do = "Give a recording with time"
        raise DataError("the vibration has no sample rate", str(path), do=do, code="no_interval")
    found = {}
    for kind, unit in UNIT.items():
        named = [one for one in recording.channels if one.unit and kind_of_unit(one.unit) == kind]
        if named:
            values = recording.array([one.name for one in named]) * [factor(str(one.unit), unit) for one in named]
            found[kind] = vibration_levels(psd(values, recording.sample_interval), sample_rate)
    if not found:
        do = "Give the unit: --unit acc=g"
        raise DataError("no acceleration or rate in the vibration", str(path), do=do, code="no_unit")
    if 0.5 / recording.sample_interval <= 0.5 * sample_rate:
        sampled = 1.0 / recording.sample_interval
        what = f"the vibration was sampled at {sampled:g} Hz: it shows nothing beyond half the filter's rate"
        do = "Record it faster than the filter's readings"
        remarks.append(Remark("vibration_too_slow", "warning", what, str(path), do=do))
    return found
