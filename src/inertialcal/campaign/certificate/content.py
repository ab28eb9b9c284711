"""What a certificate says: figures of a run with their covariance, verdicts, standards; nothing is computed anew.

Figures come from ``results.json``, their covariance from the model of the same run. Before anything is made, both are
checked against ``campaign.toml`` and the recordings as they lie there now.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from ...core.errors import DataError
from ...core.estimate import Array, Estimate
from ...core.results import key_of
from ...core.show.rounding import settled_u
from ...core.show.rows import full_name
from ...core.show.tables import clean
from ...core.unit.d_si import CODE as NOT_IN_D_SI
from ...core.unit.d_si import d_si
from ...core.units import factor, si_unit
from ...files.models.model_file import load_model_file
from ...files.source import checked_path
from ...files.source import load as load_source
from ...sensors.model.sensor_model import SensorModel
from ...statistics.intervals import coverage_factor
from ..file.certificate import Certificate as Stated
from ..file.cross_checks import model_name
from ..file.load import Campaign, load
from ..outcome.publish import OUT, PROVENANCE, RESULTS, version_of_package
from ..outcome.results_file import edited_since, find_results
from ..twins.twin import TRUTH
from .missing import check_stated
from .periods import period_of

P = 0.95  # coverage probability of expanded uncertainties
SAME = 1e-9  # relative difference of a figure of the results to that of the model that is none
NO_STANDARD = "no standard is stated"
NO_CERTIFICATE = ("", "simulated")  # certificates of standards that are none


@dataclass(frozen=True, eq=False)
class Figures:
    """Figures that were found together: of a model in its condition, or of a test.

    Parameters
    ----------
    name, condition : str
        Of the model or test, as results have it; of the campaign, empty for none.
    what : str
        In words.
    labels, quantities : tuple of str
        A word without blanks for each figure, all different; what it is, with its axis.
    units : tuple of str
        Each of them can be said in the Digital System of Units.
    values, u, k : ndarray, shape (n,)
        Figures, standard uncertainties [units]; coverage factors for 95 %.
    lower, upper : ndarray, shape (n,)
        95 % intervals. [units]
    covariance : ndarray, shape (n, n), or None
        [products of units]; None where the test does not say it.
    matrix : tuple, or None
        Of a model: names of its axes, and the matrix at the reference temperature, shape (axes, axes); an entry that no
        test gave is no number.
    not_estimated : tuple of (str, str)
        What has no figure, and why.
    ranges : tuple of str
        Where and how it holds: frame, references, temperature, pressure; and that readings held out have not confirmed
        it.
    """

    name: str
    condition: str
    what: str
    labels: tuple[str, ...]
    quantities: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    u: Array
    k: Array
    lower: Array
    upper: Array
    covariance: Array | None
    matrix: tuple[tuple[str, ...], Array] | None = None
    not_estimated: tuple[tuple[str, str], ...] = ()
    ranges: tuple[str, ...] = ()

    @property
    def expanded(self) -> Array:
        """Expanded uncertainties, shape (n,), in ``units``."""
        return np.asarray(self.k * self.u)

    @property
    def is_symmetric(self) -> bool:
        """Whether every interval is value and expanded uncertainty."""
        half = np.maximum(
            np.abs(self.upper - self.values - self.expanded), np.abs(self.values - self.lower - self.expanded)
        )
        return bool((half <= SAME * np.maximum(self.expanded, np.abs(self.values))).all())


@dataclass(frozen=True)
class Standard:
    """A standard whose uncertainty is in the figures, or is missing there."""

    name: str
    u: str
    certificate: str
    valid: str
    traceable: bool
    why: str  # It is not traceable; empty where it is


@dataclass(frozen=True)
class Conformity:
    """A requirement, with the verdict on it and the rule that gave it."""

    requirement: str
    text: str
    verdict: str
    rule: str
    lean: (
        str  # Of one that is INCONCLUSIVE: ``Pass`` where every estimate is inside its limits, else ``Fail``, or empty
    )


@dataclass(frozen=True, eq=False)
class Content:
    """All that a certificate says."""

    stated: Stated
    item: tuple[str, str, str]  # Maker, part, serial
    campaign: str
    title: str
    figures: tuple[Figures, ...]
    standards: tuple[Standard, ...]
    conformity: tuple[Conformity, ...]
    procedures: tuple[str, ...]  # With the tests of each
    refuted: bool  # Whether readings held out refuted the model, so that none is delivered
    software: str  # Version
    results_checksum: str
    simulated: bool
    warnings: tuple[str, ...] = ()

    @property
    def is_traceable(self) -> bool:
        """Whether there are standards, and each has a certificate that was valid."""
        return bool(self.standards) and all(one.traceable for one in self.standards) and not self.simulated


def content_of(folder: str | os.PathLike[str]) -> Content:
    """Return what the certificate of a campaign says.

    Parameters
    ----------
    folder : path
        Of the campaign, which was run.

    Raises
    ------
    PlanError
        As ``campaign.file.load.load``; ``not_stated`` with all that the campaign does not state.
    DataError
        ``no_results``; ``old_results``, if campaign.toml, a recording or the version is another than that of the
        run; ``edited_results``; ``wrong_period``, if a test was recorded outside of the days stated;
        ``no_figures``; ``checksum``.
    """
    campaign = load(Path(checked_path(folder, "campaign")))
    check_stated(campaign)
    found = find_results(folder, of_campaign=True)
    if found is None:
        do = f"Type: inertialcal run {folder}"
        raise DataError("no results: the campaign was not run", str(folder), do=do, code="no_results")
    results = found.content
    version = _check_current(campaign, results)
    stated = campaign.file.certificate
    _check_period(stated, results)
    figures = tuple(_figures(campaign, results))
    if not figures:
        do = f"Look into {folder}/out/results.json: it says why each figure has none"
        raise DataError("no figure with an uncertainty to certify", str(folder), do=do, code="no_figures")
    standards = tuple(_standards(results, _last_day(stated), (stated.performed or [date.max])[0]))
    simulated = (campaign.folder / TRUTH).exists()
    warnings = [f"{one.name}: not traceable: {one.why}" for one in standards if not one.traceable]
    if not standards:
        warnings.append(f"not traceable: {NO_STANDARD}")
    if simulated:
        warnings.insert(0, "simulated data: the certificate says that no item was calibrated")
    item = campaign.file.item
    return Content(
        _cleaned(stated),
        (one_line(item.maker), one_line(item.part), one_line(item.serial)),
        campaign.file.campaign.id,
        clean(campaign.file.campaign.title),
        figures,
        standards,
        tuple(_conformity(results)),
        tuple(_procedures(results)),
        results["closed_loop"]["verdict"] == "FAIL",
        version,
        str(results["checksum"]),
        simulated,
        tuple(warnings),
    )


def one_line(text: str) -> str:
    """Return text that steers nothing and has no blanks around, as the schema wants it."""
    return " ".join(clean(" ".join(text.split())).split())


def _cleaned(stated: Stated) -> Stated:
    """Return what is stated without a character that steers, and without blanks around."""

    def of(value: Any) -> Any:
        if isinstance(value, str):
            return one_line(value)
        if isinstance(value, dict):
            return {name: of(one) for name, one in value.items()}
        return [of(one) for one in value] if isinstance(value, list) else value

    return Stated.model_validate(of(stated.model_dump()))


def _last_day(stated: Stated) -> date:
    return (stated.performed or [date.min])[-1]


def _check_current(campaign: Campaign, results: Mapping[str, Any]) -> str:
    """Refuse results that are not of the campaign and the recordings as they lie there; return their version."""
    folder = campaign.folder
    do = f"Type: inertialcal run {folder}"
    edited = edited_since(folder)
    if edited:
        raise DataError(edited[0].what, edited[0].where, "a certificate states what was measured", do, "edited_results")
    place = folder / OUT / PROVENANCE
    try:
        record = json.loads(load_source(place, document=True).data)
        inputs = {str(one["path"]): str(one["sha256"]) for one in record["inputs"]}
        version, of_campaign = str(record["versions"]["inertialcal"]), str(record["of_campaign"])
    except (ValueError, KeyError, TypeError, RecursionError):
        what = f"{PROVENANCE} does not say what the results were made of"
        raise DataError(what, str(place), do=do, code="old_results") from None
    if version != version_of_package():
        what = f"the results were made by version {version}, this is {version_of_package()}"
        raise DataError(what, str(folder / OUT), "figures may differ", do, "old_results")
    if of_campaign != campaign.digest():
        why = "the results are not of what it says now"
        raise DataError("changed since the last run", str(folder / "campaign.toml"), why, do, "old_results")
    if results["campaign"]["id"] != campaign.file.campaign.id:
        raise DataError("results of another campaign", str(folder / OUT / RESULTS), do=do, code="old_results")
    for path, digest in inputs.items():
        if path == "campaign.toml":
            continue
        file = folder / path
        now = load_source(file).sha256 if file.is_file() else ""
        if now != digest:
            what = "changed since the last run" if now else "no longer there: what the results were made of"
            raise DataError(what, str(file), "the certificate would not be of it", do, "old_results")
    return version


def _check_period(stated: Stated, results: Mapping[str, Any]) -> None:
    """Refuse days that a recording contradicts."""
    first, last = (stated.performed or [date.min])[0], _last_day(stated)
    for test, occasion in results["occasions"].items():
        try:
            day = date.fromisoformat(occasion["day"])
        except ValueError:
            continue  # a label
        if not first <= day <= last:
            raise DataError(
                f"test {test} was recorded on {day}, outside of performed = {first} to {last}",
                "campaign.toml",
                "the certificate would state days on which it was not measured",
                "Correct performed in [certificate]",
                "wrong_period",
            )


# Figures


def _figures(campaign: Campaign, results: Mapping[str, Any]) -> Iterator[Figures]:
    rows: dict[str, list[dict[str, Any]]] = {}
    for row in results["results"]:
        rows.setdefault(row["test"], []).append(row)
    modelled = [one for name in _sensors(campaign) for one in _of_models(campaign, name, rows)]
    if modelled:
        yield from modelled
        return
    stored = {one["test"]: one for one in results["covariances"]}
    for step in results["sequence"]:
        if step["use"] == "hold_out":
            continue
        test = step["test"]
        found = _of_test(step, rows.get(test, []), stored.get(test))
        if found is not None:
            yield found


def _sensors(campaign: Campaign) -> tuple[str, ...]:
    """Return what the files of models may be named after: nothing, and each sensor."""
    return ("", *campaign.file.sensors)


def _of_models(campaign: Campaign, sensor: str, rows: Mapping[str, Sequence[dict[str, Any]]]) -> Iterator[Figures]:
    path = campaign.folder / OUT / f"{model_name(sensor, '')}.json"
    if not path.is_file():
        return
    for condition, model in load_model_file(path).models.items():
        name = model_name(sensor, condition if model_name(sensor, condition) in rows else "")
        estimate = model.estimate
        if estimate is None:
            continue
        of_model = [one for one in rows.get(name, []) if one["condition"] == condition or not condition]
        what = f"{model.kind}, model" + (f", in {condition}" if condition else "")
        made = _joined(
            name, condition, what, of_model, estimate, str(path), _matrix(model, estimate), tuple(_ranges(model))
        )
        if made is not None:
            yield made
        if model.noise is not None:
            of_tests = [one for test in model.tests for one in rows.get(test, [])]
            what = f"{model.kind}, noise" + (f", in {condition}" if condition else "")
            made = _joined(f"{name}_noise", condition, what, of_tests, model.noise, str(path))
            if made is not None:
                yield made


def _matrix(model: SensorModel, estimate: Estimate) -> tuple[tuple[str, ...], Array]:
    """Return axes and matrix; an entry that no test gave is no number."""
    known = {(key.quantity, key.axis) for key in estimate.keys if not key.power}
    matrix = np.array(model.matrix[0], dtype=float)
    for i, row in enumerate(model.axes):
        for j, column in enumerate(model.axes):
            if (("scale_factor_error", row) if i == j else ("misalignment", row + column)) not in known:
                matrix[i, j] = np.nan
    return tuple(model.axes), matrix


def _ranges(model: SensorModel) -> Iterator[str]:
    """Yield where and how a model holds, and that readings held out have not confirmed it."""
    if model.source:
        yield clean(model.source)
    if model.reference_temperature is not None:
        every = dict.fromkeys(f"{one:.6g}" for one in model.reference_temperature)
        yield f"T_ref = {', '.join(every)} degC"
    if model.reference_pressure is not None:
        yield f"p_ref = {model.reference_pressure:.6g} Pa"
    if model.temperature_range is not None:
        yield "temperature {:.6g} degC to {:.6g} degC".format(*model.temperature_range)
    if model.pressure_range is not None:
        yield "pressure {:.6g} Pa to {:.6g} Pa".format(*model.pressure_range)
    if not model.judged:
        yield "not confirmed by readings held out"


def _joined(
    name: str,
    condition: str,
    what: str,
    rows: Sequence[dict[str, Any]],
    estimate: Estimate,
    path: str,
    matrix: tuple[tuple[str, ...], Array] | None = None,
    ranges: tuple[str, ...] = (),
) -> Figures | None:
    """Return rows of results with the covariance of the estimate that they are of."""
    place = {(key.quantity, key.axis, key.power, key.at): i for i, key in enumerate(estimate.keys)}
    chosen, at, without = [], [], []
    for row in rows:
        key = key_of(row)
        i = place.get((key.quantity, key.axis, key.power, key.at))
        if row["method"] != "result" or row["member"] is not None:
            continue
        if row["status"] == "estimated" and i is not None and row["u"] is not None:
            chosen.append(row)
            at.append(i)
            value = float(estimate.values[i]) * factor(estimate.units[i], row["unit"], difference=True)
            if not math.isclose(value, row["value"], rel_tol=SAME, abs_tol=SAME * row["u"]):
                raise DataError(
                    f"{full_name(row)} {row['axis']} is {value:.9g} {row['unit']}, {RESULTS} has {row['value']:.9g}",
                    path,
                    "the model is not of these results",
                    "Type again: inertialcal run DIR",
                    "old_results",
                )
        elif row["status"] != "estimated" and matrix is not None:
            without.append((_name(row), "" if row["reason"] is None else clean(row["reason"]["text"])))
    if not chosen:
        return None
    index = np.array(at)
    scales = np.array(
        [factor(estimate.units[i], row["unit"], difference=True) for i, row in zip(at, chosen, strict=True)]
    )
    covariance = estimate.covariance[np.ix_(index, index)] * np.outer(scales, scales)
    return _made(name, condition, what, chosen, covariance, matrix, tuple(without), ranges)


def _of_test(
    step: Mapping[str, Any], rows: Sequence[dict[str, Any]], stored: Mapping[str, Any] | None
) -> Figures | None:
    """Return the figures of a test: those with a common covariance, or all that are estimated."""
    own = [one for one in rows if one["method"] == "result" and one["member"] is None]
    estimated = [one for one in own if one["status"] == "estimated" and one["u"] is not None and _has_interval(one)]
    covariance = None
    if stored is not None:
        place = {key_of(one): i for i, one in enumerate(stored["keys"])}
        estimated = [one for one in estimated if key_of(one) in place]
        index = [place[key_of(one)] for one in estimated]
        whole = np.array(stored["matrix"], dtype=float)
        pairs = zip(index, estimated, strict=True)
        scales = np.array([factor(stored["units"][i], one["unit"], difference=True) for i, one in pairs])
        covariance = whole[np.ix_(index, index)] * np.outer(scales, scales) if index else None
    if not estimated:
        return None
    without = [
        (_name(one), clean(one["reason"]["text"])) for one in own if one["status"] != "estimated" and one["reason"]
    ]
    condition = str(step["condition"])
    what = f"test {step['test']} ({step['procedure'].replace('_', ' ')})" + (f", in {condition}" if condition else "")
    return _made(step["test"], condition, what, estimated, covariance, None, tuple(without), ())


def _has_interval(row: Mapping[str, Any]) -> bool:
    interval = row["interval"]
    return interval is not None and interval["lo"] is not None and interval["hi"] is not None


def _made(
    name: str,
    condition: str,
    what: str,
    rows: Sequence[dict[str, Any]],
    covariance: Array | None,
    matrix: tuple[tuple[str, ...], Array] | None,
    without: tuple[tuple[str, str], ...],
    ranges: tuple[str, ...],
) -> Figures:
    units = tuple(certified_unit(row["unit"]) for row in rows)
    scales = np.array([factor(row["unit"], unit, difference=True) for row, unit in zip(rows, units, strict=True)])

    def column(values: list[float]) -> Array:
        return np.asarray(np.array(values, dtype=float) * scales)

    dofs = [math.inf if row["dof"] is None else float(row["dof"]) for row in rows]
    k = np.array([coverage_factor(dof, P) for dof in dofs])
    u, values = column([row["u"] for row in rows]), column([row["value"] for row in rows])
    lower = [
        row["interval"]["lo"] if _has_interval(row) else row["value"] - kk * row["u"]
        for row, kk in zip(rows, k, strict=True)
    ]
    upper = [
        row["interval"]["hi"] if _has_interval(row) else row["value"] + kk * row["u"]
        for row, kk in zip(rows, k, strict=True)
    ]
    labels: list[str] = []
    for row in rows:
        key = key_of(row)
        label = "_".join(clean(f"{key}{'_' + key.sensor if key.sensor else ''}").split())
        labels.append(label if label not in labels else f"{label}_{len(labels) + 1}")
    return Figures(
        name,
        clean(condition),
        clean(what),
        tuple(labels),
        tuple(_name(row) for row in rows),
        units,
        values,
        u,
        k,
        column(lower),
        column(upper),
        None if covariance is None else covariance * np.outer(scales, scales),
        matrix,
        without,
        ranges,
    )


def _name(row: Mapping[str, Any]) -> str:
    name = key_of(row).name.replace("_", " ")
    at = key_of(row).at
    return clean(" ".join(filter(None, (name, row["axis"], f"at {at}" if at is not None else "", row["sensor"]))))


def certified_unit(unit: str) -> str:
    """Return the unit of a figure on a certificate: its own, or that of the SI where a DCC cannot say its own."""
    try:
        d_si(unit)
    except DataError as error:
        if error.problems[0].code != NOT_IN_D_SI:
            raise
        unit = si_unit(unit)
        d_si(unit)
    return unit


# Standards, verdicts, tests


def _standards(results: Mapping[str, Any], last: date, first: date) -> Iterator[Standard]:
    for name, one in results["influences"].items():
        u = "exact: " + clean(one["reason"]) if one.get("reason") else f"{settled_u(one['u'])} {one['unit']}"
        certificate, valid = one_line(one["certificate"]), one_line(one["valid"])
        why = "no certificate is stated"
        if certificate.strip() not in NO_CERTIFICATE:
            why = ""
            period = period_of(valid)
            if not valid.strip():
                why = "the period in which its certificate is valid is not stated"
            elif period is None:
                why = f"the period of its certificate is not given in days: {valid}"
            elif period[1] < last:
                why = f"its certificate had ended on {period[1]}, before the calibration on {last}"
            elif period[0] > first:
                why = f"its certificate begins on {period[0]}, after the calibration on {first}"
        elif certificate.strip():
            why = "it is simulated"
        yield Standard(name, u.removesuffix(" 1"), certificate, valid, not why, why)
    for one in results["standards"]:
        name = f"{one['standard']}.{one['influence']}"
        if not one["stated"]:
            yield Standard(
                name, "not stated", "", "", False, f"not stated, and not in the uncertainties ({clean(one['effect'])})"
            )


def _conformity(results: Mapping[str, Any]) -> Iterator[Conformity]:
    asked = {one["requirement"] for one in results["verdicts"]}
    for one in results["verification"]:
        name = one["requirement"]
        if name not in asked:
            continue  # the closed loop: it is said apart
        judged = [each for each in results["verdicts"] if each["requirement"] == name]
        inside = [_is_inside(each) for each in judged]
        lean = "" if None in inside else "Pass" if all(inside) else "Fail"
        yield Conformity(clean(name), clean(one["text"]), one["verdict"], clean(one["rule"]), lean)


def _is_inside(one: Mapping[str, Any]) -> bool | None:
    if one["value"] is None:
        return None
    lower, upper = one["lower"], one["upper"]
    return (lower is None or one["value"] >= lower) and (upper is None or one["value"] <= upper)


def _procedures(results: Mapping[str, Any]) -> Iterator[str]:
    tests: dict[str, list[str]] = {}
    for step in results["sequence"]:
        tests.setdefault(step["procedure"], []).append(step["test"])
    for name, every in tests.items():
        yield clean(f"{name.replace('_', ' ')}: {', '.join(every)}")
