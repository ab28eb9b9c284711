"""What ``compare`` takes: rows of a model or of results, and what may be shared between two of them."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ...core.errors import DataError, UsageError
from ...core.estimate import AFTER, Component, Estimate
from ...core.influence import Drawn, Influence, Occasion, Selection, influence_of, influence_read
from ...core.key import Key, Method
from ...core.results import Row, key_of
from ...core.times import read_instant
from ...files.models.model_file import ModelFile, load_model_file
from ...files.source import load
from ...procedures.display import displayed
from ...sensors.model.sensor_model import FIELD_UNIT
from ...sensors.model.serial import FORMAT
from ...statistics.difference import Figure, Part
from ..models.compensation import model_rows
from ..models.find import find_model
from ..outcome.publish import OUT, RESULTS, restore
from ..outcome.results_file import check_results, own_curves

Kind = Literal["models", "results"]
CAMPAIGN_FILE = "campaign.toml"


@dataclass(frozen=True, eq=False)
class Compared:
    """One side."""

    path: str  # The file that was read
    sha256: str  # The file that was read
    rows: tuple[Row, ...]  # All its figures
    serial: str  # Of the unit; empty where not told
    type_b: frozenset[str]  # Sources of Type B uncertainty
    # SHA-256 -> path of each recording that went in, as far as ``provenance.json`` lies beside
    recordings: Mapping[str, str]
    sensor: str = ""  # What a model senses: ``"accelerometer"``, ``"gyro"``; empty for results
    condition: str = ""  # Of a model
    influences: Mapping[str, Influence] = field(default_factory=dict)  # By name, as stated
    # By test, of a model under no name: what drew the errors of standards, and what went in
    occasions: Mapping[str, Occasion] = field(default_factory=dict)
    selections: Mapping[str, tuple[Selection, ...]] = field(default_factory=dict)
    # By test and key: sources of the uncertainty of a figure that are not known in size
    parts: Mapping[tuple[str, Key], tuple[Part, ...]] = field(default_factory=dict)

    def figure(self, row: Row) -> Figure:
        """Return a figure with what its uncertainty is made of."""
        plain = row.method is Method.RESULT and row.member is None
        parts = self.parts.get((row.test, row.key), ()) if plain else ()
        return Figure(
            float(row.value or 0.0), float(row.u or 0.0), row.dof or math.inf, row.shared, parts, row.curvature
        )

    def drawn(self, unknown: str, row: Row) -> Drawn | None:
        """Return which error an unknown of a figure is; None where its standard is not stated."""
        one = self.influences.get(influence_of(unknown))
        if one is None:
            return None
        occasion = self.occasions.get(row.test, self.occasions.get("", Occasion()))
        drew = occasion.drew(one.redrawn_by, one.standard)
        before = unknown.partition("[")[2].startswith(AFTER) and one.redrawn_by not in ("never", "certificate")
        return Drawn(one, "" if before else drew, self.serial)  # of what was taken off nobody said when it was drawn

    def drawings(self, name: str) -> list[Drawn]:
        """Return which errors a stated influence has, over the tests."""
        one = self.influences[name]
        labels = dict.fromkeys(occasion.drew(one.redrawn_by, one.standard) for occasion in self.occasions.values())
        return [Drawn(one, label, self.serial) for label in labels or ("",)]

    def selected(self, row: Row) -> tuple[Selection, ...]:
        """Return what went into a figure; nothing where that is not known."""
        return self.selections.get(row.test, self.selections.get("", ()))


def load_both(
    first: str | os.PathLike[str], second: str | os.PathLike[str], condition: str | None = None
) -> tuple[Kind, tuple[tuple[Compared, Compared], ...], tuple[str, ...]]:
    """Return both sides, each a file or the folder of a campaign.

    They are models if one is a model file, or if a condition is given for the folders of two campaigns; else results.

    Parameters
    ----------
    condition : str, optional
        Of which models are compared; those that both files have, where not given.

    Returns
    -------
    Kind
        What they are.
    tuple of (Compared, Compared)
        A pair for the results, or for the models of each condition.
    tuple of str
        Conditions of which only one file has a model.

    Raises
    ------
    UsageError
        ``condition_of_results``; ``condition_needed`` where one file has a model for every condition, and the other
        several; ``no_such_condition``.
    DataError
        ``different_kinds`` for a model and results, or models of an accelerometer and a gyro;
        ``no_results`` for a folder that was never run;
        ``schema`` for a file that is neither; and as ``find_model``.
    """
    kinds = [_kind_of(Path(path)) for path in (first, second)]
    of_models = condition is not None and kinds == ["both", "both"]
    kind: Kind = "models" if "models" in kinds or of_models else "results"
    for path, own in zip((first, second), kinds, strict=True):
        if own not in {kind, "both"}:
            raise DataError(
                "one is a model, the other holds results",
                where=str(path),
                do="Name two models, two results, or the folders of two campaigns",
                code="different_kinds",
            )
    if kind == "results":
        if condition is not None:
            do = "Leave it out: results are compared test by test, each in its condition"
            raise UsageError("--condition is for models", do=do, code="condition_of_results")
        return kind, ((_results(Path(first)), _results(Path(second))),), ()
    one_file, other_file = _models(Path(first)), _models(Path(second))
    both = [name for name in one_file.models if name in other_file.models]
    single = len(one_file.models) == len(other_file.models) == 1
    wanted: list[str | None] = [condition] if condition is not None or single or not both else [*both]
    gone = [name for name in dict.fromkeys((*one_file.models, *other_file.models)) if name not in both]
    pairs = tuple((_model(one_file, name, not single), _model(other_file, name, not single)) for name in wanted)
    one, other = pairs[0]
    if one.sensor != other.sensor:
        raise DataError(
            f"one is a model of the {one.sensor}, the other of the {other.sensor}",
            where=f"{one.path}, {other.path}",
            why="their figures have the same names, and are of two things",
            do="Name two models of one kind of sensor",
            code="different_kinds",
        )
    return kind, pairs, () if condition is not None or single else tuple(gone)


def _kind_of(path: Path) -> str:
    if path.is_dir():
        return "both"
    content = _content(path)[0]
    return "models" if content.get("format") == FORMAT else "results"


def _models(path: Path) -> ModelFile:
    return find_model(path) if path.is_dir() else load_model_file(path)


def _model(source: ModelFile, condition: str | None, said: bool) -> Compared:
    """Return one side; the condition stands in its rows where it is said."""
    model = source.models.only(condition, source.path)
    label = model.condition if said else ""
    rows = [replace(row, condition=label) for row in model_rows(model)]
    components = () if model.estimate is None else model.estimate.components
    return Compared(
        source.path,
        source.sha256,
        tuple(displayed(row, FIELD_UNIT[model.kind]) for row in rows),
        model.item.serial,
        frozenset(_source(one) for one in components if one.kind == "B" and one.u.any()),
        _recordings(Path(source.path)),
        model.kind,
        model.condition,
        model.influences,
        {"": model.occasion},
        {"": model.selections},
        {} if model.estimate is None else _parts_of_model(model.estimate, rows),
    )


def _parts_of_model(estimate: Estimate, rows: Sequence[Row]) -> dict[tuple[str, Key], tuple[Part, ...]]:
    """Return the sources that are not known in size, by test and key of a row."""
    found = {}
    for row in rows:
        if row.u:
            at = estimate.index(row.key)
            shares = [(one, float(one.u[at]) / row.u, float(np.broadcast_to(one.dof, len(one.u))[at])) for one in
                      estimate.components]  # fmt: skip
            found[row.test, row.key] = tuple(
                Part(_source(one) if one.origin.standard else "", share, dof)
                for one, share, dof in shares
                if share and math.isfinite(dof)
            )
    return found


def _parts_of_results(
    budgets: Sequence[Mapping[str, Any]], rows: Sequence[Row]
) -> dict[tuple[str, Key], tuple[Part, ...]]:
    """Return the sources that are not known in size, by test and key of a row."""
    figures = {(row.test, row.key): row.u for row in rows if row.case.plain and row.u}
    found: dict[tuple[str, Key], tuple[Part, ...]] = {}
    for one in budgets:
        of = str(one["test"]), key_of(one)
        u = figures.get(of)
        if u and one["dof"] is not None:
            found[of] = (*found.get(of, ()), Part(str(one["influence"]), float(one["u"]) / u, float(one["dof"])))
    return found


def _source(component: Component) -> str:
    """Return the influence that a source is of; in words where it is of none."""
    origin = component.origin
    return f"{origin.standard}.{origin.quantity}" if origin.standard else component.source


def _results(given: Path) -> Compared:
    if given.is_dir():
        restore(given)
    path = given / OUT / RESULTS if given.is_dir() else given
    if given.is_dir() and not path.is_file():
        raise DataError("no results here", where=str(given), do=f"Type: inertialcal run {given}", code="no_results")
    content, sha256 = _content(path)
    if "results" in content:
        check_results(content, str(path))
        own_curves(content, path)
    return results_side(content, sha256, str(path), _recordings(path))


def results_side(content: Mapping[str, Any], sha256: str, path: str, recordings: Mapping[str, str]) -> Compared:
    """Return one side: the content of a ``results.json``.

    Parameters
    ----------
    content : mapping
        As read.
    sha256, path : str
        Of the file; the path is for messages.
    recordings : mapping of str to str
        SHA-256 -> path of each recording that went in.

    Raises
    ------
    DataError
        ``schema``.
    """
    try:
        every = (Row.from_dict(row) for row in content["results"])
        rows = tuple(row for row in every if row.method is not Method.UNSCREENED)
        budgets = [b for b in content.get("budgets", []) if b["kind"] == "B"]
        type_b = frozenset(str(b.get("influence") or b["source"]) for b in budgets)
        serial = str(content.get("item", {}).get("serial", ""))
        influences = {name: influence_read(one) for name, one in content.get("influences", {}).items()}
        occasions, selections = _tests(content)
        parts = _parts_of_results(content.get("budgets", []), rows)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise DataError(
            f"neither a model nor results: {type(error).__name__} {error}",
            where=path,
            do="Name a model.json, a results.json, or the folder of a campaign",
            code="schema",
        ) from None
    return Compared(
        path, sha256, rows, serial, type_b, recordings, "", "", influences, occasions, selections, parts
    )  # fmt: skip


def _tests(content: Mapping[str, Any]) -> tuple[dict[str, Occasion], dict[str, tuple[Selection, ...]]]:
    """Return what drew errors in each test and model, and what went into its figures."""
    steps = {one["test"]: one for one in content.get("sequence", [])}
    known = content.get("occasions", {})
    occasions = {name: Occasion(*(one[field] for field in Occasion._fields)) for name, one in known.items()}
    selections = {}
    for name, one in known.items():
        behind = [steps[test] for test in one["tests"] if test in steps]
        more = [steps[test] for step in behind for test in (*step["after"], step["against"]) if test in steps]
        selections[name] = tuple(
            _selection(step) for step in {step["test"]: step for step in (*behind, *more)}.values()
        )
    return occasions, selections


def _selection(step: Mapping[str, Any]) -> Selection:
    windows = tuple((read_instant(start), read_instant(stop)) for start, stop in step["windows"] or ())
    return Selection(tuple(one["sha256"] for one in step["recordings"]), tuple(step["groups"] or ()), windows)


def _content(path: Path) -> tuple[dict[str, Any], str]:
    loaded = load(path, document=True)
    try:
        content = json.loads(loaded.data)
    except (ValueError, RecursionError) as error:
        raise DataError(f"no JSON: {error}", where=str(path), code="not_json") from None
    if not isinstance(content, dict):
        raise DataError("neither a model nor results: no object", where=str(path), code="schema")
    return content, loaded.sha256


def _recordings(path: Path) -> dict[str, str]:
    """Hashes of what went in, from the provenance beside a file of a run; empty where there is none."""
    try:
        content = json.loads(load(path.parent / "provenance.json", document=True).data)
        return {one["sha256"]: one["path"] for one in content["inputs"] if one["path"] != CAMPAIGN_FILE}
    except (DataError, ValueError, RecursionError, KeyError, TypeError):
        return {}
