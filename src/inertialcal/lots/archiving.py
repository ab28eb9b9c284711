"""Units of a lot in an archive: each as `run --archive` adds a campaign, once however often the lot goes on."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from ..archive import open_archive
from ..archive.record import Record, record_of_results
from ..campaign.outcome.publish import OUT, RESULTS, version_of_package
from .ledger import Ledger, ToArchive

AT_ONCE = 25  # units in a transaction


class LotArchive:
    """An archive, and the folder of the lot whose units it keeps.

    Raises
    ------
    UsageError
        ``archive_url``; ``missing_package``.
    """

    def __init__(self, where: str, folder: Path) -> None:
        self._archive = open_archive(where)
        self._folder = str(folder.resolve())

    @property
    def name(self) -> str:
        """Address for messages, without a password."""
        return str(self._archive.database.name)

    def take(self, ledger: Ledger) -> int:
        """Add what waits in a ledger; return how many units were new.

        Raises
        ------
        StoreError
            As an archive.
        """
        new = 0
        while waiting := ledger.to_archive(AT_ONCE):
            added = self._archive.add_records([self._record(one) for one in waiting])
            ledger.archived([one.key for one in waiting], self.name)
            new += sum(one.new for one in added)
        return new

    def _record(self, one: ToArchive) -> Record:
        texts = {RESULTS: one.results} | {name: text.encode() for name, text in one.models}
        return record_of_results(
            json.loads(one.results),
            one.inputs,
            {f"{OUT}/{name}": data for name, data in texts.items()},
            {"folder": self._folder, "program": version_of_package(), "made_ns": one.at_ns,
             "results_sha256": hashlib.sha256(one.results).hexdigest()},
        )  # fmt: skip
