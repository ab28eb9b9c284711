"""Run a campaign: every test, every requirement, one ``out/``.

Where nothing has changed since the last run, ``out/`` stays as it is, and this is known without reading a recording:
this module imports nothing that starts slowly.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...core.campaign_text import FILE
from ...core.remarks import Remark
from ...files.source import checked_path
from ...files.write.exchange import MANIFEST, Manifest, file_digest
from ..outcome.publish import OUT, PROVENANCE, RESERVED, RESULTS, check_writable, kept_remarks, restore
from .cache import Cache
from .status import EXIT, Progress

if TYPE_CHECKING:
    from pandas import DataFrame

    from ...core.show.tables import Block
    from ..file.load import Campaign


LAST = "run"

KEPT = re.compile(r"kept-\d+")
PAPER = {(False, False): "", (False, True): "", (True, False): " pdf", (True, True): " pdf, appendices"}


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a run gave.

    Parameters
    ----------
    folder : Path
        Of the campaign.
    content : dict
        Of ``results.json``.
    inputs : dict of str to str
        SHA-256 of each input, by path in the campaign folder.
    verdict : {"PASS", "FAIL", "INCONCLUSIVE", ""}
        Over all requirements, INCONCLUSIVE where a test has a remark that is an error; else empty where none is stated.
    changed : list of str
        What differs from the last run.
    notes : tuple of Remark
        Files that were kept in ``out/``.
    curves_text : bytes
        Curves of ``curves.parquet`` as JSON, where they were not made now.
    """

    folder: Path
    content: dict[str, Any]
    inputs: dict[str, str]
    verdict: str
    changed: list[str]
    notes: tuple[Remark, ...] = ()
    curves_text: bytes = b""

    @cached_property
    def campaign(self) -> Campaign:
        """As read."""
        from ..file.load import load  # noqa: PLC0415 - starts slowly

        return load(self.folder)

    @cached_property
    def results(self) -> dict[str, Any]:
        """Content of ``results.json``, and the ``curves`` of ``curves.parquet``."""
        if not self.curves_text:
            return self.content
        found: dict[str, Any] = {}
        for name, part in self.content.items():
            if name == "remarks":
                found["curves"] = json.loads(self.curves_text)
            found[name] = part
        return found

    @property
    def remarks(self) -> tuple[Remark, ...]:
        """What the campaign brought up, and the files that were kept in ``out/``."""
        return (*(Remark(**one) for one in self.content["remarks"]), *self.notes)

    def to_frame(self) -> DataFrame:
        """Return a pandas DataFrame, a row a figure, as ``results.csv`` has them."""
        from ...core.results import COLUMNS, flat  # noqa: PLC0415
        from ...core.show.frames import frame  # noqa: PLC0415 - starts slowly

        rows = [flat(row) for row in self.content["results"]]
        return frame({name: [row[name] for row in rows] for name in COLUMNS})

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: figures test by test, requirements, closed loop, how many remarks."""
        from ..outcome.tables import outcome_parts  # noqa: PLC0415 - starts slowly

        return outcome_parts(self.content, self.verdict, self.remarks)

    def __str__(self) -> str:
        """Return what is shown as text."""
        from ...core.show.tables import text  # noqa: PLC0415 - starts slowly

        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook, with the first figure."""
        from ...core.show.tables import html  # noqa: PLC0415 - starts slowly
        from ...report.plot import markup  # noqa: PLC0415 - draws, which starts slowly

        return html(self.parts(), markup(self))

    @property
    def exit_status(self) -> int:
        """0 PASS or no requirement, 1 FAIL, 4 INCONCLUSIVE, or recordings that disagree."""
        return EXIT[self.verdict] if self.verdict else 0


def run(
    folder: str | Path,
    progress: Progress | None = None,
    write: bool = True,
    pdf: bool = False,
    appendices: bool = False,
) -> Outcome:
    """Reduce every test of a campaign, judge its requirements, write ``out/``.

    What has not changed since the last run is not reduced again: see ``cache``.

    Parameters
    ----------
    folder : path
        With campaign.toml.
    progress : callable, optional
        Called with (tests done, tests in all, what comes next).
    write : bool
        Write ``out/``.
    pdf : bool
        Write the report as ``out/report.pdf`` too.
    appendices : bool
        With every quantity, verdict and input at the end of that.

    Raises
    ------
    UsageError
        If a PDF is wanted and typst, the extra ``pdf``, is not installed.
    PlanError, DataError
        If the campaign or a recording is refused, or changes meanwhile (``input_changed``); ``out/`` stays as it was.
    StoreError
        If ``out/`` cannot be written.
    """
    root = Path(checked_path(folder, "campaign"))
    given = os.fsencode(folder).decode("utf-8", "replace")
    cache = Cache(root, write)
    paper = PAPER[pdf, appendices]
    if write and (same := _unchanged(root, given + paper, cache)) is not None:
        return same
    from ..file.load import load  # noqa: PLC0415 - starts slowly
    from .whole import work  # noqa: PLC0415 - starts slowly

    campaign = load(folder)
    whole, results, files, changed, notes = work(campaign, given, progress, write, cache, paper)
    outcome = Outcome(root, results, whole.inputs, whole.verdict, changed, notes)
    outcome.__dict__["campaign"] = campaign
    if write:
        _keep(outcome, given + paper, files, cache)
    return outcome


def _key(folder: Path, given: str, cache: Cache) -> str:
    """Return the name of the entry of a whole run; empty where there is no campaign."""
    digest = file_digest(folder / FILE, follow=True)
    return cache.key(digest, given) if digest else ""


def _unchanged(folder: Path, given: str, cache: Cache) -> Outcome | None:
    """Return what the last run gave, where a run now would write the same; None where anything is another."""
    key = _key(folder, given, cache)
    kept = cache.get(LAST, key) if key else None
    if kept is None:
        return None
    head, _, curves = kept.partition(b"\n")
    last = json.loads(head)
    check_writable(folder)
    notes = restore(folder)
    out = folder / OUT
    manifest = Manifest.read(out)
    if manifest is None or manifest.files.keys() != {*last["files"], PROVENANCE}:
        return None
    if any(manifest.files[name] != digest for name, digest in last["files"].items()):
        return None
    if not all(manifest.lists(out / name) for name in manifest.files):
        return None
    others = [one for one in os.listdir(out) if one != MANIFEST and one not in manifest.files]
    if any(RESERVED.fullmatch(one) for one in others):
        return None
    content = json.loads((out / RESULTS).read_bytes())
    notes += kept_remarks([one for one in others if not KEPT.fullmatch(one)])
    return Outcome(folder, content, last["inputs"], last["verdict"], [], notes, curves)


def _keep(outcome: Outcome, given: str, files: Mapping[str, str | bytes], cache: Cache) -> None:
    """Note what a whole run read and wrote, and forget what it had no use for."""
    written = {name: one if isinstance(one, bytes) else one.encode() for name, one in files.items()}
    digests = {name: sha256(one).hexdigest() for name, one in written.items() if name != PROVENANCE}
    last = {"files": digests, "inputs": outcome.inputs, "verdict": outcome.verdict}
    head, curves = json.dumps(last).encode(), json.dumps(outcome.results["curves"]).encode()
    key = _key(outcome.folder, given, cache)
    if key and outcome.inputs.get(FILE) == file_digest(outcome.folder / FILE, follow=True):
        cache.put(LAST, key, cache.read, head + b"\n" + curves)
    cache.sweep()
