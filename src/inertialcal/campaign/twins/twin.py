"""Write a simulated campaign as a folder, with its truth beside it, sealed.

``.truth/truth.json`` is read by ``score`` alone. Its SHA-256 stands in ``campaign.source`` of campaign.toml, and so in
every result made from it: a truth that was changed, or belongs to another campaign, is told from the right one.
"""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path

from ...core.campaign_text import FILE
from ...core.errors import DataError, PlanError, UsageError
from ...core.key import At, Key
from ...core.recording import SECOND, Recording
from ...core.schema.json_text import json_text
from ...core.show.tables import Block, Table, html, text
from ...files.source import load as read_file
from ...files.write.atomic import write_folder
from ...rigs import RIGS
from ...rigs.twin import SEAL, SEED, DrawnError, TrueValue, Twin
from ..file.load import load

TRUTH = ".truth/truth.json"
Of = tuple[Key, str]  # which figure, of which test


@dataclass(frozen=True)
class Written:
    """A simulated campaign on disk: its folder, the recordings in it, SHA-256 of the truth, the fault and its size."""

    folder: Path
    recordings: tuple[str, ...]
    seal: str
    fault: str
    size: str = ""

    def parts(self) -> tuple[Block, ...]:
        """Return what is shown: the recordings, the seal of the truth, what to type next."""
        rows = [(name,) for name in self.recordings]
        mistake = f"mistake put in: {self.fault} {self.size}".rstrip() + "\n" if self.fault else ""
        said = f"{mistake}truth sealed, SHA-256 {self.seal}\nnext: ic.run({str(self.folder)!r}), then ic.score(...)"
        return (Table(("recording",), rows, f"simulated campaign in {self.folder}"), said)

    def __str__(self) -> str:
        """Return what is shown as text."""
        return text(self.parts())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """Return what is shown for a notebook."""
        return html(self.parts())


@dataclass(frozen=True)
class Truth:
    """The truth behind a campaign, SI, and where it comes from."""

    values: tuple[TrueValue, ...]
    rig: str
    seed: int
    fault: str
    seal: str
    size: str = ""  # Of the fault, with its unit
    spoiled: tuple[str, ...] = ()  # Recordings, or files of them, that the fault is in
    errors: tuple[DrawnError, ...] = ()  # Of the standards

    @cached_property
    def _by_key(self) -> dict[Of, TrueValue]:
        return truth_by_key(self.values)

    def of(self, which: Of) -> TrueValue | None:
        """Return the true value of a figure: of its test, else of all tests; None where it is not known."""
        return known_truth(self._by_key, which)


def truth_by_key(values: Iterable[TrueValue]) -> dict[Of, TrueValue]:
    """Return true values by key and test."""
    return {(one.key, one.test): one for one in values}


def known_truth(values: Mapping[Of, TrueValue], which: Of) -> TrueValue | None:
    """Return the true value of a figure: of its test, else of all tests; None where it is not known."""
    return values.get(which) or values.get((which[0], ""))


def simulate(rig: str, folder: str | Path, seed: int, fault: str = "") -> Written:
    """Write the recordings, the campaign file and the truth of a rig.

    Parameters
    ----------
    rig : str
        Name in the registry of rigs.
    folder : path
        New, or empty.
    seed : int
        All draws follow from it; 0 or more.
    fault : str
        Name of a mistake to put in, or name and size: ``"run_gain=5 %"``.

    Raises
    ------
    UsageError
        If there is no such rig or fault, the package that adds the rig is broken, the seed is negative, or something
        is in the folder.
    StoreError
        If the folder cannot be written; nothing is left behind.
    """
    made, target = RIGS.named(rig), Path(folder)
    if seed < 0:
        raise UsageError(f"seed {seed}: need 0 or more")
    if target.exists() and (not target.is_dir() or any(target.iterdir())):
        raise UsageError(f"{target} exists and is not empty", do="Name a new folder: -o DIR", code="exists")
    return write_twin(made.twin(seed, fault), target)


def write_twin(twin: Twin, folder: Path) -> Written:
    """Write a simulated campaign into a new folder, all or nothing."""
    truth = truth_text(twin)
    seal = hashlib.sha256(truth.encode()).hexdigest()
    texts = {
        FILE: twin.campaign.replace(SEED, str(twin.seed)).replace(SEAL, seal),
        TRUTH: truth,
        **{file: twin.texts.get(file, str)(csv_text(one, file)) for file, one in twin.recordings.items()},
        **{file: extra.text for file, extra in twin.extras.items()},
    }
    write_folder(folder, {name: text.encode() for name, text in texts.items()})
    return Written(folder, tuple(twin.recordings), seal, twin.fault, twin.size)


def truth_of(twin: Twin) -> Truth:
    """Return the truth behind a simulated campaign that is not written."""
    return Truth(
        twin.truth, twin.rig, twin.seed, twin.fault, "", twin.size, tuple(spoiled_names(twin)), twin.errors
    )  # fmt: skip


def truth_text(twin: Twin) -> str:
    """Return the content of ``truth.json``."""
    head = {"schema": 3, "rig": twin.rig, "seed": twin.seed, "fault": twin.fault, "size": twin.size}
    values = [asdict(one) | {"at": None if one.at is None else one.at._asdict()} for one in twin.truth]
    errors = [asdict(one) for one in twin.errors]
    return json_text(
        head | {"spoiled": spoiled_names(twin), "values": values, "errors": errors, "drawn": dict(twin.drawn)}
    )


def spoiled_names(twin: Twin) -> list[str]:
    """Return the recordings that a fault is in, and their files: a remark names one or the other."""
    recordings = tomllib.loads(twin.campaign)["recordings"] if twin.spoiled else {}
    return list(dict.fromkeys([*twin.spoiled, *(str(recordings[name]["file"]) for name in twin.spoiled)]))


def csv_text(recording: Recording, file: str = "") -> str:
    """Return a recording as CSV, the stamps first in UNIX seconds; reading it back gives the same numbers.

    Parameters
    ----------
    recording : Recording
        Of a rig.
    file : str
        Where it is going to stand, for the message.

    Raises
    ------
    DataError
        ``no_clock`` if its samples have no time.
    """
    if recording.time_ns is None:
        raise DataError("a simulated recording without a clock", file, do="Give it time_ns", code="no_clock")
    seconds, rest = divmod(recording.time_ns, SECOND)
    whole = not rest.any()
    stamps = [str(s) if whole else f"{s}.{r:09d}" for s, r in zip(seconds.tolist(), rest.tolist(), strict=True)]
    columns = [stamps, *(list(map(repr, channel.data.tolist())) for channel in recording.channels)]
    rows = map(",".join, zip(*columns, strict=True))
    return "\n".join([",".join(["unix_s", *recording.names]), *rows, ""])


def read_truth(folder: str | Path) -> Truth:
    """Return the truth behind a campaign, its seal checked against campaign.toml.

    Raises
    ------
    PlanError
        If there is no campaign in the folder.
    DataError
        ``no_truth`` if it is no simulated campaign, ``damaged_truth`` if the truth cannot be read,
        ``seal_broken`` if it is not the one that the campaign was written with.
    """
    source, path = _source(Path(folder)), Path(folder) / TRUTH
    if not path.exists():
        what, why = f"no truth: {path} does not exist", "only a simulated campaign can be scored"
        do = f"Try: inertialcal simulate {next(iter(RIGS))} -o DIR"
        raise DataError(what, why=why, do=do, code="no_truth")
    loaded = read_file(path, document=True)
    seal = loaded.sha256
    if seal not in source:
        what = f"the truth has SHA-256 {seal[:12]}..., campaign.source names another"
        why = "it was changed, or belongs to another campaign"
        raise DataError(what, TRUTH, why, "Simulate the campaign again from its seed", "seal_broken")
    try:
        content = json.loads(loaded.data)
        values = [TrueValue(**one | {"at": one["at"] and At(**one["at"])}) for one in content["values"]]
        errors = tuple(DrawnError(**one) for one in content["errors"])
        return Truth(
            tuple(values), str(content["rig"]), int(content["seed"]), str(content["fault"]), seal,
            str(content["size"]), tuple(map(str, content["spoiled"])), errors,
        )  # fmt: skip
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise DataError(f"not a truth: {error}", TRUTH, code="damaged_truth") from None


def _source(folder: Path) -> str:
    """Return where a campaign says that it comes from, though its file may be refused for other reasons."""
    try:
        return load(folder).file.campaign.source
    except PlanError as error:
        if any(problem.code in ("no_campaign", "empty_file", "not_toml") for problem in error.problems):
            raise
        text = (folder / FILE).read_text(encoding="utf-8")
        source = tomllib.loads(text).get("campaign", {}).get("source", "")
        if "truth sealed with SHA-256" not in source:
            raise
        return str(source)
