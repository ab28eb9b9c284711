"""Read campaign.toml: all that is wrong with it at once, each with the line of its key."""

from __future__ import annotations

import hashlib
import json
import math
import shlex
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ...core.campaign_text import FILE, MARK
from ...core.errors import DataError, PlanError, Problem
from ...core.influence import Influence, Standards
from ...core.recording import ClockRate
from ...core.schema.problems import model_problems
from ...core.schema.standards import STANDARDS, WRITTEN, StandardEntry
from ...core.schema.toml import At, key_lines, nearest_line, parse_toml
from ...core.schema.toml import Path as KeyPath
from ...files.binary.parquet import clock_in
from ...files.own import lot_in, own
from ...files.source import read_bytes
from .cross_checks import cross_checks
from .schema import CampaignFile

MOST = 100  # problems that are listed


@dataclass(frozen=True)
class Campaign:
    """A campaign that was read and judged."""

    folder: Path  # Holds campaign.toml and the recordings
    file: CampaignFile  # What it says, SI
    standards: Standards  # By ``"standard.quantity"``
    lines: dict[KeyPath, int] | None  # Line of each key; None for a campaign that is in no file
    sha256: str  # Of campaign.toml

    def digest(self) -> str:
        """SHA-256 over all that it says but [certificate], which no figure depends on."""
        said = self.file.model_dump(mode="json", by_alias=True, exclude={"certificate"})
        return hashlib.sha256(json.dumps(said, sort_keys=True).encode("utf-8", "surrogatepass")).hexdigest()

    def at(self, *path: str | int) -> str:
        """Place of a key, for messages: ``"campaign.toml:12"``."""
        return "" if self.lines is None else place(self.lines, path)


def place(lines: dict[KeyPath, int], path: KeyPath) -> str:
    """Return file and line of a key, or of the nearest table around it."""
    line = nearest_line(lines, path)
    return f"{FILE}:{line}" if line else FILE


def load(folder: str | Path, elsewhere: bool = False) -> Campaign:
    """Read the campaign of a folder.

    Parameters
    ----------
    folder : path
        Of the campaign.
    elsewhere : bool
        Its recordings lie in other places: it is the template of many units.

    Raises
    ------
    PlanError
        With every problem: no campaign there, text that is not TOML, unknown keys, wrong kinds of values,
        names that lead nowhere, files outside the folder or missing.
    """
    root = Path(folder)
    path = root / FILE
    if not path.is_file() and (known := own(root)) is not None:
        raise PlanError(f"{root} is {known.what}, no folder of a campaign", do=f"Try: {known.do}", code="no_campaign")
    if not root.is_dir() or not path.is_file():
        what = f"No campaign here: {path} does not exist"
        files = any(one.is_file() for one in root.glob("[!.]*"))
        made = (
            f"Make one of the files there: inertialcal init {shlex.quote(str(root))}. For an example: inertialcal demo"
        )
        raise PlanError(what, do=made if files else "Try: inertialcal demo", code="no_campaign")
    try:
        raw = read_bytes(path)
    except DataError as error:
        raise PlanError(list(error.problems)) from None
    if not raw:
        do = f"Delete the file, then type: inertialcal init {shlex.quote(str(root))}"
        raise PlanError("cannot be read: the file is empty", FILE, do=do, code="empty_file")
    return campaign_of(root, raw, elsewhere)


def campaign_of(
    root: Path, raw: bytes, elsewhere: bool = False, changes: Mapping[KeyPath, object] | None = None
) -> Campaign:
    """Return the campaign that the text of a campaign.toml says.

    Parameters
    ----------
    root : Path
        Its folder.
    raw : bytes
        The text.
    elsewhere : bool
        As `load` takes it.
    changes : mapping of key path to value, optional
        That stand in place of what the text says, or are added to it.

    Raises
    ------
    PlanError
        As `load`.
    """
    text, document = parse_toml(raw, FILE)
    for key, value in (changes or {}).items():
        table: Any = document
        for part in key[:-1]:
            table = table[part] if isinstance(part, int) else table.setdefault(part, {})
        table[key[-1]] = value
    lines = key_lines(text)
    marked = [number for number, line in enumerate(text.splitlines(), 1) if line.rstrip().endswith(MARK)]
    if marked:
        do = f"Fill the line in, then delete its mark ({MARK})"
        raise PlanError([Problem("not filled in", f"{FILE}:{number}", do=do, code="fill_in") for number in marked])
    if document.get("schema") == 1:
        raise PlanError(
            "schema 1 is no longer read",
            place(lines, ("schema",)),
            do="Set schema = 2; in requirements, replace zero_reference by the tests that are meant: tests = [...]",
            code="old_schema",
        )
    try:
        file = CampaignFile.model_validate(document)
    except ValidationError as error:
        problems = list(islice(model_problems(error, CampaignFile, document, lambda *key: place(lines, key)), MOST))
        if error.error_count() > MOST:
            problems.append(Problem(f"and {error.error_count() - MOST} more problems", FILE, do="Correct these first"))
        raise PlanError(problems) from None
    _, problems = standards_of(file, lambda *key: place(lines, key))
    problems += cross_checks(root, file, lambda *key: place(lines, key), elsewhere)
    if problems:
        raise PlanError(_of_template(root, file, problems))
    if not elsewhere:
        recordings = (root / one.file for one in file.recordings.values() if one.channels)
        file = with_clock(file, (clock_in(one) for one in recordings))
    standards, _ = standards_of(file, lambda *key: place(lines, key))
    return Campaign(root, file, standards, lines, hashlib.sha256(raw).hexdigest())


def _of_template(root: Path, file: CampaignFile, problems: list[Problem]) -> list[Problem]:
    """Return what is wrong: of the template of a lot not each of its files, which lie elsewhere."""
    files = {one.file for one in file.recordings.values()}
    if any(one.code != "missing_file" for one in problems) or any((root / one).exists() for one in files):
        return problems
    lot = lot_in(root, files)
    if lot is None:
        return problems
    what, why = "no recording of this campaign lies here", f"it is the template of {lot.what}"
    return [Problem(what, FILE, why, f"Try: {lot.do}", "missing_file")]


def clock_standard(clocks: Iterable[ClockRate | None]) -> dict[str, dict[str, Any]]:
    """Return the entry of ``clock.rate`` that recordings make who all say what the rate of their stamps is known to.

    It is one unknown of all: that of the recording where it is known worst. Empty where one of them does not say.
    """
    found = list(clocks)
    known = [one for one in found if one is not None]
    if not known or len(known) < len(found):
        return {}
    worst = max(known, key=lambda one: one.u)
    entry: dict[str, Any] = {"u": f"{1e6 * worst.u:g} ppm", "certificate": worst.source}
    return {"rate": entry if math.isinf(worst.dof) else entry | {"dof": float(f"{worst.dof:g}")}}


def with_clock(file: CampaignFile, clocks: Iterable[ClockRate | None]) -> CampaignFile:
    """Return what a campaign says, with what its recordings say of their clock where it says nothing of that."""
    if "rate" in file.standards.get("clock", {}) or not (said := clock_standard(clocks)):
        return file
    entries = {name: StandardEntry(**entry) for name, entry in said.items()}
    return file.model_copy(update={"standards": {**file.standards, "clock": entries}})


def standards_of(file: CampaignFile, at: At) -> tuple[dict[str, Influence], list[Problem]]:
    """Return the standards of a campaign by ``"standard.quantity"``, and what is wrong with them."""
    found, problems = {}, []
    for standard, quantities in file.standards.items():
        known = STANDARDS.get(standard, {})
        for name, entry in quantities.items():
            where = at("standards", standard, name)
            if name not in known:
                have = ", ".join(f"{one}.{two}" for one, inner in STANDARDS.items() for two in inner)
                what = f"unknown key standards.{standard}.{name}"
                problems.append(Problem(what, where, "it would have no effect", f"There are: {have}", "unknown_key"))
                continue
            try:
                influence = entry.influence(known[name], standard, name)
            except (DataError, ValueError) as error:
                what = error.problems[0].what if isinstance(error, DataError) else str(error)
                do = f'Write a number and a unit, like "{WRITTEN[known[name]]}"'
                problems.append(Problem(f"standards.{standard}.{name}: {what}", where, "", do, "wrong_value"))
                continue
            found[f"{standard}.{name}"] = influence
            if influence.u == 0.0 and not entry.reason.strip():
                what = f"standards.{standard}.{name}: an uncertainty of exactly zero"
                why = "no standard is exact, and zero hides that its uncertainty was not taken into account"
                do = f'State the uncertainty, or why it is zero: {name} = {{ u = "0", reason = "..." }}'
                problems.append(Problem(what, where, why, do, "zero_uncertainty"))
    return found, problems
