"""What ``compare`` takes: rows of a model or of results, and what may be shared between two of them."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from ...core.errors import DataError
from ...core.key import Method
from ...core.remarks import Remark
from ...core.results import Row
from ...files.models.model_file import load_model_file
from ...files.source import load
from ...procedures.display import displayed
from ...sensors.model.sensor_model import FIELD_UNIT
from ...sensors.model.serial import FORMAT
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
    influences: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # Of results
    site: Mapping[str, Any] = field(default_factory=dict)  # Of results


def load_both(first: str | os.PathLike[str], second: str | os.PathLike[str]) -> tuple[Kind, Compared, Compared]:
    """Return both sides, each a file or the folder of a campaign: models if one is a model file, else results.

    Raises
    ------
    DataError
        ``different_kinds`` for a model and results, or models of an accelerometer and a gyro;
        ``no_results`` for a folder that was never run;
        ``schema`` for a file that is neither; and as ``find_model``.
    """
    kinds = [_kind_of(Path(path)) for path in (first, second)]
    kind: Kind = "models" if "models" in kinds else "results"
    for path, own in zip((first, second), kinds, strict=True):
        if own not in {kind, "both"}:
            raise DataError(
                "one is a model, the other holds results",
                where=str(path),
                do="Name two models, two results, or the folders of two campaigns",
                code="different_kinds",
            )
    one, other = (_model(Path(path)) if kind == "models" else _results(Path(path)) for path in (first, second))
    if one.sensor != other.sensor:
        raise DataError(
            f"one is a model of the {one.sensor}, the other of the {other.sensor}",
            where=f"{one.path}, {other.path}",
            why="their figures have the same names, and are of two things",
            do="Name two models of one kind of sensor",
            code="different_kinds",
        )
    return kind, one, other


def shared_influences(one: Compared, other: Compared) -> list[str]:
    """Return the influences whose error is the same in both: one certificate, or one constant or site."""
    found = []
    for name, mine in one.influences.items():
        of_site = mine["standard"] in ("site", "gravity")
        same = mine == other.influences.get(name) and (not of_site or one.site == other.site)
        lasting = mine["redrawn_by"] == "never" or (mine["redrawn_by"] == "certificate" and mine["certificate"])
        if same and lasting:
            found.append(name)
    return found


def shared_remarks(one: Compared, other: Compared) -> tuple[Remark, ...]:
    """Return remarks on what two sides share, or may share."""
    remarks = []
    same = [path for digest, path in one.recordings.items() if digest in other.recordings]
    if one.sha256 == other.sha256:
        remarks.append(Remark("same_file", "warning", "both files have the same content: every difference is 0"))
    elif same:
        what = f"recordings that went into both: {', '.join(same)[:120]}: not independent, u of a difference is wrong"
        remarks.append(Remark("same_recordings", "warning", what, count=len(same), do="Compare separate recordings"))
    known = shared_influences(one, other)
    if known:
        what = f"one standard in both, so its error cancels in each difference: {', '.join(known)}"
        remarks.append(Remark("standards_shared", "info", what, count=len(known)))
    unknown = sorted((one.type_b & other.type_b) - set(known))
    if unknown:
        what = f"Type B in both ({', '.join(unknown)[:160]}): taken as independent. "
        what += "With one standard in both, u of a difference is smaller than stated"
        do = "Give both campaigns the certificate of the standard"
        remarks.append(Remark("standards_may_be_shared", "info", what, count=len(unknown), do=do))
    if one.serial and other.serial and one.serial != other.serial:
        what = f"two units: serial {one.serial!r} and {other.serial!r}"
        remarks.append(Remark("different_serials", "info", what))
    return tuple(remarks)


def _kind_of(path: Path) -> str:
    if path.is_dir():
        return "both"
    content = _content(path)[0]
    return "models" if content.get("format") == FORMAT else "results"


def _model(path: Path) -> Compared:
    source = find_model(path) if path.is_dir() else load_model_file(path)
    model = source.model
    components = () if model.estimate is None else model.estimate.components
    return Compared(
        source.path,
        source.sha256,
        tuple(displayed(row, FIELD_UNIT[model.kind]) for row in model_rows(model)),
        model.item.serial,
        frozenset(one.source for one in components if one.kind == "B"),
        _recordings(Path(source.path)),
        model.kind,
    )


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
    try:
        every = (Row.from_dict(row) for row in content["results"])
        rows = tuple(row for row in every if row.method is not Method.UNSCREENED)
        budgets = [b for b in content.get("budgets", []) if b["kind"] == "B"]
        type_b = frozenset(str(b.get("influence") or b["source"]) for b in budgets)
        serial = str(content.get("item", {}).get("serial", ""))
        influences, site = content.get("influences", {}), content.get("site", {})
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise DataError(
            f"neither a model nor results: {type(error).__name__} {error}",
            where=str(path),
            do="Name a model.json, a results.json, or the folder of a campaign",
            code="schema",
        ) from None
    return Compared(
        str(path), sha256, rows, serial, type_b, _recordings(path), influences=influences, site=site
    )  # fmt: skip


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
