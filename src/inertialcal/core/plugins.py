"""Plug-ins: objects that other distributions register under one of our groups of entry points.

Free of numpy, and of a registry of its own: each registry loads its group when what is built in does not do, and
leaves out what is broken with a word to the user, never a traceback.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Plugin(Generic[T]):
    """An object of another distribution.

    Parameters
    ----------
    name : str
        Of its entry point.
    origin : str
        Distribution and version: ``"toy-reader 1.0"``.
    value : object
        What the entry point names.
    """

    name: str
    origin: str
    value: T


@dataclass(frozen=True)
class BrokenPlugin:
    """An entry point that gives no object of the kind that its group holds, and why."""

    name: str
    origin: str
    why: str


def load_plugins(group: str, kind: type[T]) -> tuple[tuple[Plugin[T], ...], tuple[BrokenPlugin, ...]]:
    """Return the objects of a group of entry points, and those that cannot be used; both by name.

    Parameters
    ----------
    group : str
        ``"inertialcal.readers"``.
    kind : type
        What each has to be.
    """
    from importlib.metadata import entry_points  # noqa: PLC0415 - starts slowly

    sound: list[Plugin[T]] = []
    broken: list[BrokenPlugin] = []
    for entry in sorted(entry_points(group=group), key=lambda entry: (entry.name, entry.value)):
        origin = f"{entry.dist.name} {entry.dist.version}" if entry.dist is not None else entry.value
        try:
            value = entry.load()
        except Exception as error:  # whatever the module of somebody else raises
            broken.append(BrokenPlugin(entry.name, origin, f"cannot be loaded: {fault(error)}"))
            continue
        if isinstance(value, kind):
            sound.append(Plugin(entry.name, origin, value))
        else:
            broken.append(BrokenPlugin(entry.name, origin, f"{entry.value} is no {kind.__name__}"))
    return tuple(sound), tuple(broken)


def fault(error: Exception, longest: int = 160) -> str:
    """Return an error of other people's code on one line: its class and what it says."""
    return f"{type(error).__name__}: {' '.join(str(error).split())}"[:longest].rstrip(": ")
