"""Registry of one kind of thing: what ships with the package, what installed packages add, what a program adds.

Names are known without loading anything. A thing is loaded when it is first asked for by name. Installed packages add
theirs by an entry point, whose name is that of the thing and whose value says where it stands::

    [project.entry-points."inertialcal.rigs"]
    centrifuge = "my_package.centrifuge:RIG"
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Protocol, TypeVar

from .errors import UsageError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


class Named(Protocol):
    """What a registry can hold: it says its own name."""

    @property
    def name(self) -> str:
        """As it is typed."""
        ...


T = TypeVar("T", bound=Named)


class Registry(MutableMapping[str, T]):
    """Things of one kind by name: built-in ones first, in their order, then those of others by the alphabet.

    Parameters
    ----------
    kind : str
        What one is called in messages: ``"rig"``.
    made : type
        What every one must be.
    group : str
        Group of the entry points: ``"inertialcal.rigs"``.
    built_in : mapping of str to str
        Name -> module and attribute: ``"inertialcal.rigs.mesa.rig:RIG"``. Nobody else can take such a name.
    """

    def __init__(self, kind: str, made: type[T], group: str, built_in: Mapping[str, str]):
        self.kind, self.made, self.group, self.built_in = kind, made, group, built_in
        self._names = tuple(built_in)
        self._loaded: dict[str, T] = {}
        self._added: dict[str, T] = {}

    @cached_property
    def installed(self) -> dict[str, tuple[EntryPoint, ...]]:
        """Entry points of installed packages by name; a name that is built in is none of theirs."""
        from importlib.metadata import entry_points  # noqa: PLC0415 - starts slowly

        found: dict[str, tuple[EntryPoint, ...]] = {}
        for one in sorted(entry_points(group=self.group), key=lambda point: (point.name, point.value)):
            if one.name not in self.built_in and one not in found.get(one.name, ()):
                found[one.name] = (*found.get(one.name, ()), one)
        return found

    @property
    def names(self) -> tuple[str, ...]:
        """All names, the built-in ones first."""
        more = self.installed or self._added
        return tuple(dict.fromkeys([*self._names, *self.installed, *self._added])) if more else self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __contains__(self, name: object) -> bool:
        return name in self.built_in or name in self._added or name in self.installed

    def __getitem__(self, name: str) -> T:
        if name in self._added:
            return self._added[name]
        if name not in self._loaded:
            self._loaded[name] = self._load(name)
        return self._loaded[name]

    def __setitem__(self, name: str, thing: T) -> None:
        if name in self.built_in:
            raise UsageError(f"{self.kind} {name!r} is built in", do="Give yours another name", code="exists")
        self._added[name] = thing

    def __delitem__(self, name: str) -> None:
        del self._added[name]

    def named(self, name: str) -> T:
        """Return the thing of a name.

        Raises
        ------
        UsageError
            ``unknown_name`` if there is none; ``broken_plugin`` if the package that adds it cannot be loaded, or gives
            something else.
        """
        known = self._added.get(name) or self._loaded.get(name)
        if known is not None:
            return known
        if name not in self:
            raise UsageError(f"no {self.kind} {name!r}", do=f"There are: {', '.join(self)}", code="unknown_name")
        return self[name]

    def packages(self) -> dict[str, str]:
        """Return which package adds each thing that is not built in, by name; nothing is loaded."""
        return {name: " and ".join(map(_package, points)) for name, points in self.installed.items()}

    def _load(self, name: str) -> T:
        if name in self.built_in:
            module, _, attribute = self.built_in[name].partition(":")
            thing = getattr(import_module(module), attribute)
            assert isinstance(thing, self.made), f"{self.kind} {name!r} is a {type(thing).__name__}"  # noqa: S101 - ours
            return thing
        points = self.installed[name]  # a KeyError, where there is none
        if len(points) > 1:
            what = f"{self.kind} {name!r} is added by {self.packages()[name]}"
            raise UsageError(what, do="Remove one of these packages", code="broken_plugin")
        (point,) = points
        try:
            thing = point.load()
        except Exception as error:
            raise self._broken(point, "cannot be loaded", fault(error)) from error
        if not isinstance(thing, self.made):
            raise self._broken(point, f"is a {type(thing).__name__}, not a {self.made.__name__}")
        if thing.name != name:
            raise self._broken(point, f"calls itself {thing.name!r}")
        return thing

    def _broken(self, point: EntryPoint, what: str, why: str = "") -> UsageError:
        text = f"{self.kind} {point.name!r} of {_package(point)} {what}"
        return UsageError(text, point.value, why, "Mend or remove that package", "broken_plugin")


def _package(point: EntryPoint) -> str:
    return f"{point.dist.name} {point.dist.version}" if point.dist is not None else "a package"


def fault(error: Exception, longest: int = 160) -> str:
    """Return an error of other people's code on one line: its class and what it says."""
    return f"{type(error).__name__}: {' '.join(str(error).split())}"[:longest].rstrip(": ")
