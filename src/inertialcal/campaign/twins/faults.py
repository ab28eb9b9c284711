"""What a campaign with a fault brought up, and whether that is what the entry of the fault expects."""

from __future__ import annotations

import tempfile
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from ...core.errors import InertialcalError, Problem
from ...core.recording import Source
from ...core.remarks import Remark
from ...rigs.twin import SEAL, SEED, Fault, Twin
from ...statistics.intervals import binomial_interval
from ..calls.call import campaign_of
from ..engine.run import run
from ..engine.whole import reduce_campaign
from ..file.load import Campaign
from ..inputs.sources import Memory
from .twin import write_twin

SHARE = 0.95  # of the campaigns in which a fault must be named: 57 of 60


@dataclass(frozen=True, eq=False)
class Brought:
    """What a campaign brought up: its results, or why it was refused."""

    results: Mapping[str, Any] | None
    problems: tuple[Problem, ...] = ()

    @property
    def remarks(self) -> list[Remark]:
        """Of its results."""
        return [] if self.results is None else [Remark(**one) for one in self.results["remarks"]]

    @property
    def reasons(self) -> list[tuple[str, str]]:
        """Codes and texts of the reasons why figures are not estimated."""
        rows = [] if self.results is None else self.results["results"]
        return [(row["reason"]["code"], row["reason"]["text"]) for row in rows if row["reason"] is not None]

    @property
    def codes(self) -> tuple[str, ...]:
        """All that it was refused with, else all that was remarked as a warning or an error."""
        if self.problems:
            return tuple(dict.fromkeys(one.code for one in self.problems))
        return tuple(dict.fromkeys(one.code for one in self.remarks if one.severity != "info"))


def brought_from(folder: Path) -> Brought:
    """Return what the campaign of a folder brings up, without writing anything."""
    try:
        return Brought(run(folder, write=False).results)
    except InertialcalError as error:
        return Brought(None, error.problems)


def brought_by(twin: Twin) -> Brought:
    """Return what a simulated campaign brings up, in memory; from files where these are not the usual ones."""
    if twin.texts:
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place) / "twin"
            write_twin(twin, folder)
            return brought_from(folder)
    named = {file: replace(one, source=Source(file), first_row=2) for file, one in twin.recordings.items()}
    store = Memory(named, {file: extra.content for file, extra in twin.extras.items()})
    try:
        return Brought(reduce_campaign(_campaign(twin.campaign), store).results)
    except InertialcalError as error:
        return Brought(None, error.problems)


@lru_cache(4)
def _campaign(text: str) -> Campaign:
    return campaign_of(tomllib.loads(text.replace(SEED, "0").replace(SEAL, "0")))


def names_fault(fault: Fault, spoiled: Sequence[str], brought: Brought) -> bool:
    """Whether a campaign was refused, or remarked on, as the entry of its fault expects.

    Parameters
    ----------
    fault : Fault
        Expected to be refused or named.
    spoiled : sequence of str
        Recordings, or files, of which one must be named; empty: the code alone counts.
    brought : Brought
        What the campaign brought up.
    """
    texts = [(one.code, f"{one.where} {one.what} {one.why}") for one in brought.problems]
    if fault.expects != "refused":
        texts += [(one.code, f"{one.where} {one.what} {one.subject}") for one in brought.remarks]
        texts += [] if spoiled else brought.reasons
    return any(code in fault.codes and (not spoiled or any(name in said for name in spoiled)) for code, said in texts)


def brought_text(brought: Brought) -> str:
    """Return what a campaign brought up, in a few words."""
    codes = ", ".join(brought.codes) or "nothing"
    return f"refused: {codes}" if brought.problems else f"remarks: {codes}"


@dataclass(frozen=True)
class Named:
    """How many campaigns were refused, or named a fault, as its entry expects.

    Parameters
    ----------
    hits, n : int
        Campaigns that did, and campaigns.
    others : mapping of str to int
        What the other campaigns brought up, and how often.
    """

    hits: int
    n: int
    others: Mapping[str, int]

    @property
    def verdict(self) -> str:
        """PASS where at least 95 % did."""
        return "PASS" if self.hits >= SHARE * self.n else "FAIL"

    @property
    def interval(self) -> tuple[float, float]:
        """Exact 95 % binomial interval of the rate."""
        return binomial_interval(self.hits, self.n, 0.95)
