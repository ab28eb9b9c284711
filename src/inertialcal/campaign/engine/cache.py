"""What a run keeps for the next one, in ``out-cache/`` beside ``out/``: reductions and figures.

An entry is one file. Its name is a hash of the code and of all that the campaign says of it; inside stand the inputs
that were read for it with the SHA-256 of their content, and those that were looked for and were not there. An entry is
taken where all of that is as it was, and where the file has the checksum that stands in it; else the work is done
again, and its entry written anew. No clock is asked: a file counts as unchanged by its content alone.

The code is all of this package, that of packages which add procedures, readers or rigs, and the names and versions of
all packages that are installed, with Python and the machine.
"""

from __future__ import annotations

import json
import os
import platform
import secrets
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from hashlib import sha256
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

from ...files.budget import ceiling
from ...files.write.exchange import file_digest

FOLDER = "out-cache"
TAG = "CACHEDIR.TAG"
SIGNATURE = "Signature: 8a477f597d28d172789f06886806bc55"  # https://bford.info/cachedir/
ABOUT = f"""{SIGNATURE}
# Written by `inertialcal run`, so that the next run need not reduce again what has not changed.
# Delete this folder whenever you like: it changes no result.
"""
HEAD = b"inertialcal cache 1\n"
GROUPS = ("inertialcal.procedures", "inertialcal.readers", "inertialcal.rigs")
MISSING, UNKNOWN = "missing", ""  # in place of a SHA-256: no such file; content that cannot be told from outside
PART = ".part"
HEADER = ".header"
OURS = __name__.partition(".")[0]


@cache
def packages() -> tuple[str, ...]:
    """Return the packages whose code makes results: this one, and those that add to it."""
    others = {
        point.value.partition(":")[0].partition(".")[0] for group in GROUPS for point in entry_points(group=group)
    }
    return (OURS, *sorted(others - {OURS}))


@cache
def code_digest() -> str:
    """Return the SHA-256 of all that makes a result of inputs."""
    found = sha256()
    for part in (sys.version, platform.system(), platform.machine(), *_installed()):
        found.update(f"{part}\0".encode(errors="surrogateescape"))
    for name in packages():
        for path in _files(name):
            found.update(f"{name}\0{path}\0{file_digest(Path(path), follow=True)}\0".encode(errors="surrogateescape"))
    return found.hexdigest()


def _installed() -> Iterator[str]:
    """Yield name and version of each package that can be imported, as the folders of their metadata are called."""
    for place in dict.fromkeys(sys.path):
        with suppress(OSError):
            yield from sorted(one for one in os.listdir(place or ".") if one.endswith((".dist-info", ".egg-info")))


def _files(package: str) -> list[str]:
    """Return the files of a package, without what Python and the compiler make of them."""
    try:
        spec = find_spec(package)
    except (ImportError, ValueError):
        return []
    if spec is None:
        return []
    found = []
    for root in spec.submodule_search_locations or ():
        for folder, inside, names in os.walk(root):
            inside[:] = sorted(one for one in inside if one != "__pycache__")
            found += [os.path.join(folder, name) for name in sorted(names)]
    if not spec.submodule_search_locations and spec.origin:
        found.append(spec.origin)
    return found


class Contents:
    """What inputs hold, by path in the folder of a campaign: each is hashed once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._known: dict[str, str] = {}

    def of(self, path: str) -> str:
        """Return the SHA-256 of an input: a file with its header, where there is one, or all that a folder holds.

        A header without the usual ending says itself which file it belongs to: that is ``UNKNOWN`` here.
        """
        if path not in self._known:
            self._known[path] = self._look(self.folder / path)
        return self._known[path]

    def as_read(self, inputs: Mapping[str, str], absent: Iterable[str]) -> dict[str, str]:
        """Return what inputs hold that were read meanwhile; ``UNKNOWN`` for those that changed in between.

        Parameters
        ----------
        inputs : mapping of str to str
            SHA-256 by path, as the reader has it.
        absent : iterable of str
            Paths that were looked for and were not there.
        """
        found = dict.fromkeys(absent, MISSING)
        for path, digest in inputs.items():
            known = self._known.get(path)
            now = self.of(path)
            if now != digest and (known is None or self._look(self.folder / path) != known):
                now = UNKNOWN  # no file of its own: known only if it was looked at before it was read, and after
            found[path] = now
        return found

    def _look(self, path: Path) -> str:
        try:
            if path.is_dir():
                inside = sorted(one for one in path.rglob("*") if not one.is_dir())
                members = [(one.relative_to(path).as_posix(), file_digest(one, follow=True)) for one in inside]
                return sha256(json.dumps(members).encode()).hexdigest() if all(one for _, one in members) else UNKNOWN
            if not path.exists():
                return MISSING
            with open(path, "rb") as stream:
                if stream.read(64).lstrip().startswith(b"<"):
                    return UNKNOWN
        except (OSError, ValueError):
            return UNKNOWN
        own = file_digest(path, follow=True)
        partner = path.with_suffix("") if path.suffix == HEADER else path.with_name(f"{path.name}{HEADER}")
        if not own or not partner.is_file():
            return own
        return sha256(f"{own} {file_digest(partner, follow=True)}".encode()).hexdigest()


@dataclass(eq=False)
class Cache:
    """The entries of a campaign.

    Parameters
    ----------
    folder : Path
        Of the campaign.
    writes : bool
        Whether entries may be written.
    """

    folder: Path
    writes: bool = True
    taken: list[str] = field(default_factory=list[str])  # Names of entries that were found, in order
    read: dict[str, str] = field(default_factory=dict[str, str])  # Inputs of all that was found and kept
    _used: set[str] = field(default_factory=set[str])

    def __post_init__(self) -> None:
        self.contents = Contents(self.folder)
        self.place = self.folder / FOLDER

    def key(self, *parts: object) -> str:
        """Return the name of an entry: a hash of the code and of what it is of."""
        return sha256(json.dumps([code_digest(), ceiling(0), *parts], sort_keys=True).encode()).hexdigest()

    def get(self, kind: str, key: str) -> bytes | None:
        """Return what an entry holds; None where there is none that is whole, or an input is another now."""
        name = f"{kind}-{key}"
        self._used.add(name)
        if not self.is_ours:
            return None
        try:
            data = (self.place / name).read_bytes()
        except OSError:
            return None
        start = len(HEAD)
        digest, body = data[start : start + 64], memoryview(data)[start + 65 :]
        if not data.startswith(HEAD) or sha256(body).hexdigest().encode() != digest:
            return None
        end = data.index(b"\n", start + 65)
        inputs = json.loads(data[start + 65 : end])
        if any(self.contents.of(path) != was for path, was in inputs.items()):
            return None
        self.taken.append(name)
        self.read |= inputs
        return data[end + 1 :]

    def put(self, kind: str, key: str, inputs: Mapping[str, str], content: bytes | None) -> None:
        """Keep an entry, whole or not at all; where the folder cannot be written, nothing is kept.

        Parameters
        ----------
        kind, key : str
            Its name.
        inputs : mapping of str to str
            What was read for it, as ``Contents`` says it; it is not kept where that is not known.
        content : bytes or None
            What it holds; None for what cannot be kept.
        """
        self.read |= inputs
        if content is None or not self.writes or UNKNOWN in inputs.values():
            return
        name = f"{kind}-{key}"
        body = json.dumps(dict(inputs)).encode() + b"\n" + content
        aside = self.place / f".{name}-{secrets.token_hex(4)}{PART}"
        try:
            if not os.path.lexists(self.place):
                self.place.mkdir()
                (self.place / TAG).write_text(ABOUT, encoding="utf-8", newline="\n")
            if not self.is_ours:
                return
            try:
                with open(aside, "xb") as stream:
                    stream.writelines([HEAD, sha256(body).hexdigest().encode(), b"\n", body])
                os.replace(aside, self.place / name)
            finally:
                aside.unlink(missing_ok=True)
        except OSError:
            return
        self._used.add(name)

    @property
    def is_ours(self) -> bool:
        """Whether the folder is there, and is this tool's."""
        tag = self.place / TAG
        try:
            return not self.place.is_symlink() and tag.read_text(encoding="utf-8").startswith(SIGNATURE)
        except (OSError, ValueError):
            return False

    def sweep(self) -> None:
        """Remove the entries that this run had no use for."""
        if not (self.writes and self.is_ours):
            return
        with suppress(OSError):
            for name in os.listdir(self.place):
                if name != TAG and name not in self._used:
                    with suppress(OSError):
                        (self.place / name).unlink()


__all__ = ["FOLDER", "Cache", "Contents", "code_digest", "packages"]
