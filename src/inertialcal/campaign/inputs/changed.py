"""Inputs that change while they are read: what was read is compared with what is there in the end."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from ...core.campaign_text import FILE
from ...core.errors import DataError, Problem
from ...files.pad.pairs import pairs_of
from ...files.source import changed_input
from ...files.write.exchange import file_digest
from ..file.load import Campaign

Stamps = Mapping[str, tuple[tuple[int, ...], ...]]


def stamps(campaign: Campaign) -> Stamps:
    """Return when the members of each pair of the archive changed last, by input; other inputs are known by SHA-256."""
    return {one.file: _stamps(campaign.folder / one.file) for one in campaign.file.recordings.values()}


def _stamps(path: Path) -> tuple[tuple[int, ...], ...]:
    try:
        members = [member.stat() for pair in pairs_of(path) for member in (pair.data, pair.header)]
    except (OSError, DataError):  # the reader says it
        return ()
    return tuple((one.st_dev, one.st_ino, one.st_size, one.st_mtime_ns, one.st_ctime_ns) for one in members)


def check_unchanged(folder: Path, inputs: Mapping[str, str], before: Stamps) -> None:
    """Refuse inputs that are no longer what was read.

    Parameters
    ----------
    folder : Path
        Of the campaign.
    inputs : mapping of str to str
        SHA-256 of what was read, by path in the folder.
    before : Stamps
        Of the inputs before the first was read.

    Raises
    ------
    DataError
        ``input_changed``, with each of them.
    """
    changed = []
    for path, digest in inputs.items():
        earlier = before.get(path, ())
        same = earlier == _stamps(folder / path) if earlier else digest == file_digest(folder / path, follow=True)
        if not same:
            changed.append(path)
    if changed:
        raise DataError([_problem(path) for path in changed])


def one_digest(inputs: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Return SHA-256 by path of inputs, some of which were read several times.

    Raises
    ------
    DataError
        ``input_changed``, if one was not the same each time.
    """
    found: dict[str, str] = {}
    for path, digest in inputs:
        if found.setdefault(path, digest) != digest:
            raise DataError(_problem(path))
    return found


def _problem(path: str) -> Problem:
    return changed_input(path, "the file was edited during the run") if path == FILE else changed_input(path)
