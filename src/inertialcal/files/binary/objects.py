"""Frozen results as bytes and back: dataclasses, named tuples, enumerations, arrays and what Python holds them in.

What comes back equals what went in to the last bit: arrays keep their type and shape (and their order, where they are
in one piece), numbers all their digits, and what was one object in two places is one again. What a class works out of
its fields (``cached_property``) is left out, and worked out again.

The form is data alone, unlike pickle: a JSON text that names classes, and the bytes of the arrays. Reading it makes
instances of dataclasses, named tuples, enumerations and subclasses of ``str`` of the modules that the caller allows,
by their fields, and calls nothing.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import partial
from hashlib import sha256
from importlib import import_module
from types import FunctionType, MappingProxyType
from typing import Any, Literal

import numpy as np

ALIGNED = 64  # bytes
LENGTH = 8  # bytes of the length of the text
KINDS = "biufcMmSU"  # of arrays that are their bytes
SCALARS = (type(None), bool, int, float, str)
GROUPS: dict[type, str] = {tuple: "tuple", list: "list", set: "set", frozenset: "frozenset"}
SETS = (set, frozenset)
MAPPINGS: dict[type, str] = {dict: "dict", MappingProxyType: "proxy"}
HOUSE = (__name__.partition(".")[0],)


class NotStorableError(TypeError):
    """Something that has no such form: an open file, a function made in a call, an array of objects."""


def encode(thing: object, packages: Sequence[str] = HOUSE) -> bytes:
    """Return a thing as bytes; the same thing gives the same bytes.

    Parameters
    ----------
    thing : object
        What is to be kept.
    packages : sequence of str
        Whose classes may be in it.

    Raises
    ------
    NotStorableError
        If something in it cannot be kept.
    """
    return _Writer(packages).whole(thing)


def decode(data: bytes | bytearray | memoryview, packages: Sequence[str] = HOUSE) -> object:
    """Return the thing that bytes hold.

    Parameters
    ----------
    data : bytes
        As ``encode`` gives them.
    packages : sequence of str
        Whose classes may be in it.

    Raises
    ------
    ValueError
        If they are no such bytes, or name a class that is not allowed, is not there, or has other fields.
    """
    try:
        return _Reader(bytearray(data), packages).whole()
    except ValueError:
        raise
    except (KeyError, IndexError, TypeError, AttributeError, ImportError, OverflowError, RecursionError) as error:
        raise ValueError(f"not as it was written: {type(error).__name__} {error}") from None


def digest(thing: object, packages: Sequence[str] = HOUSE) -> str:
    """Return the SHA-256 of a thing; functions count by their name and by what they hold from where they were made.

    Raises
    ------
    NotStorableError
        If something in it has no fixed content.
    """
    return sha256(_Writer(packages, functions=True).whole(thing)).hexdigest()


def is_of(module: str, packages: Sequence[str]) -> bool:
    """Tell whether a module belongs to one of some packages."""
    return any(module == one or module.startswith(f"{one}.") for one in packages)


class _Writer:
    def __init__(self, packages: Sequence[str], functions: bool = False) -> None:
        self.packages, self.functions = packages, functions
        self.nodes: list[Any] = []
        self.classes: dict[tuple[str, str], int] = {}
        self.numbers: dict[int, int] = {}  # Of nodes by the id of their object
        self.held: list[object] = []  # So that no id is given twice
        self.blobs: dict[bytes, tuple[int, int]] = {}  # Offset and length by SHA-256
        self.parts: list[bytes] = []
        self.size = 0

    def whole(self, thing: object) -> bytes:
        root = self.value(thing)
        content = {"classes": list(self.classes), "nodes": self.nodes, "root": root}
        text = json.dumps(content, separators=(",", ":")).encode()
        head = len(text).to_bytes(LENGTH, "little") + text
        return b"".join([head, bytes(-len(head) % ALIGNED), *self.parts])

    def value(self, thing: object) -> Any:
        """Return a scalar as it is; the number of a node, in a list, for anything else."""
        if type(thing) in SCALARS:
            return thing
        number = self.numbers.get(id(thing))
        if number is None:
            node = self.node(thing)
            number = len(self.nodes)
            self.nodes.append(node)
            self.numbers[id(thing)] = number
            self.held.append(thing)
        return [number]

    def node(self, thing: Any) -> list[Any]:
        made = type(thing)
        if made in GROUPS:
            return [GROUPS[made], [self.value(one) for one in (sorted(thing, key=repr) if made in SETS else thing)]]
        if made in MAPPINGS:
            return [MAPPINGS[made], [[self.value(key), self.value(one)] for key, one in thing.items()]]
        if made is np.ndarray:
            return self.array(thing)
        if isinstance(thing, np.generic):
            return ["scalar", *self.array(np.asarray(thing))[1:]]
        return self.instance(thing)

    def instance(self, thing: Any) -> list[Any]:  # noqa: PLR0911 - a line a kind
        made = type(thing)
        if made is bytes:
            return ["bytes", *self.blob(thing)]
        if made is slice:
            return ["slice", [self.value(one) for one in (thing.start, thing.stop, thing.step)]]
        if isinstance(thing, Enum):
            return ["enum", self.named(made), thing.name]
        if isinstance(thing, tuple) and hasattr(made, "_fields"):
            return ["named", self.named(made), [self.value(one) for one in thing]]
        if is_dataclass(made):
            return ["object", self.named(made), [[f.name, self.value(getattr(thing, f.name))] for f in fields(made)]]
        if isinstance(thing, str):
            return ["text", self.named(made), str(thing)]
        if self.functions:
            return self.function(thing)
        raise NotStorableError(f"{made.__module__}.{made.__qualname__}")

    def array(self, thing: np.ndarray[Any, Any]) -> list[Any]:
        if thing.dtype.kind not in KINDS:
            raise NotStorableError(f"an array of {thing.dtype}")
        order: Literal["C", "F"] = "F" if thing.flags.f_contiguous and not thing.flags.c_contiguous else "C"
        blob = self.blob(thing.tobytes(order=order))
        return ["array", *blob, thing.dtype.str, list(thing.shape), order, bool(thing.flags.writeable)]

    def blob(self, data: bytes) -> tuple[int, int]:
        """Return where bytes stand; those that are there already are not written again."""
        known = sha256(data).digest()
        if known not in self.blobs:
            self.blobs[known] = (self.size, len(data))
            filled = -len(data) % ALIGNED
            self.parts += [data, bytes(filled)]
            self.size += len(data) + filled
        return self.blobs[known]

    def named(self, made: type) -> int:
        module, name = made.__module__, made.__qualname__
        if not is_of(module, self.packages) or _class(module, name) is not made:
            raise NotStorableError(f"{module}.{name}")
        return self.classes.setdefault((module, name), len(self.classes))

    def function(self, thing: Any) -> list[Any]:
        if isinstance(thing, partial):
            return ["partial", [self.value(one) for one in (thing.func, thing.args, dict(thing.keywords))]]
        if isinstance(thing, FunctionType) and is_of(thing.__module__, self.packages):
            cells = [cell.cell_contents for cell in thing.__closure__ or ()]
            held = (thing.__module__, thing.__qualname__, thing.__code__.co_firstlineno, cells,
                    thing.__defaults__, thing.__kwdefaults__)  # fmt: skip
            return ["function", [self.value(one) for one in held]]
        if isinstance(thing, type) and _class(thing.__module__, thing.__qualname__) is thing:
            return ["class", thing.__module__, thing.__qualname__]
        raise NotStorableError(f"{type(thing).__module__}.{type(thing).__qualname__}")


class _Reader:
    def __init__(self, data: bytearray, packages: Sequence[str]) -> None:
        length = int.from_bytes(data[:LENGTH], "little")
        end = LENGTH + length
        content = json.loads(bytes(data[LENGTH:end]))
        self.data, self.start = data, end + -end % ALIGNED
        self.classes = []
        for module, name in content["classes"]:
            made = _class(module, name) if is_of(module, packages) else None
            if made is None:
                raise ValueError(f"no class {module}.{name}")
            self.classes.append(made)
        self.nodes, self.root = content["nodes"], content["root"]
        self.things: list[Any] = []

    def whole(self) -> object:
        for kind, *rest in self.nodes:  # a node stands behind all that it holds
            self.things.append(getattr(self, f"_{kind}")(*rest))
        found: object = self.value(self.root)
        return found

    def value(self, one: Any) -> Any:
        return self.things[one[0]] if isinstance(one, list) else one

    def every(self, held: list[Any]) -> list[Any]:
        return [self.value(one) for one in held]

    def _tuple(self, held: list[Any]) -> tuple[Any, ...]:
        return tuple(self.every(held))

    def _list(self, held: list[Any]) -> list[Any]:
        return self.every(held)

    def _dict(self, pairs: list[Any]) -> dict[Any, Any]:
        return {self.value(key): self.value(one) for key, one in pairs}

    def _proxy(self, pairs: list[Any]) -> MappingProxyType[Any, Any]:
        return MappingProxyType(self._dict(pairs))

    def _set(self, held: list[Any]) -> set[Any]:
        return set(self.every(held))

    def _frozenset(self, held: list[Any]) -> frozenset[Any]:
        return frozenset(self.every(held))

    def _slice(self, held: list[Any]) -> slice:
        return slice(*self.every(held))

    def _bytes(self, offset: int, length: int) -> bytes:
        return bytes(self._blob(offset, length))

    def _blob(self, offset: int, length: int) -> memoryview:
        first = self.start + offset
        if offset < 0 or length < 0 or first + length > len(self.data):
            raise ValueError("it ends too early")
        return memoryview(self.data)[first : first + length]

    def _array(self, offset: int, length: int, dtype: str, shape: list[int], order: Any, writeable: bool) -> Any:
        made = np.dtype(dtype)
        if made.kind not in KINDS:
            raise ValueError(f"an array of {made}")
        flat: Any = np.frombuffer(self._blob(offset, length), made) if length else np.empty(0, made)
        found = flat.reshape(shape, order=order)
        shared = found if writeable else found.view()
        shared.flags.writeable = writeable
        return shared.copy(order="K") if writeable else shared  # Two that were equal must not change together

    def _scalar(self, *rest: Any) -> Any:
        return self._array(*rest)[()]

    def _enum(self, made: int, name: str) -> Any:
        return self._class(made, lambda one: issubclass(one, Enum))[name]

    def _named(self, made: int, held: list[Any]) -> Any:
        found = self._class(made, lambda one: issubclass(one, tuple) and hasattr(one, "_fields"))
        if len(held) != len(found._fields):
            raise ValueError(f"{found.__qualname__} has other fields")
        return tuple.__new__(found, self.every(held))

    def _object(self, made: int, held: list[Any]) -> Any:
        found = self._class(made, is_dataclass)
        if [name for name, _ in held] != [one.name for one in fields(found)]:
            raise ValueError(f"{found.__qualname__} has other fields")
        thing = object.__new__(found)
        for name, one in held:
            object.__setattr__(thing, name, self.value(one))
        return thing

    def _text(self, made: int, text: str) -> Any:
        return str.__new__(self._class(made, lambda one: issubclass(one, str)), text)

    def _class(self, number: int, fits: Callable[[type], bool]) -> Any:
        found = self.classes[number]
        if not fits(found):
            raise ValueError(f"{found.__qualname__} is of another kind")
        return found


def _class(module: str, path: str) -> type | None:
    """Return a class of a module, also one in a class; None where there is none."""
    found: Any = import_module(module)
    for part in path.split("."):
        found = getattr(found, part, None)
    return found if isinstance(found, type) else None
