"""How loops are compiled: from the cache of numba where there is one, and without it elsewhere.

Numba refuses to load a function where no folder for its cache can be written (a package that somebody else installed,
no home), and to call one whose cache is damaged or cannot be written. Neither is a reason to stop: the function is
compiled again, which takes seconds.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba.core import types
from numba.core.caching import FunctionCache
from numba.core.dispatcher import Dispatcher

from ..core.show.compiling import compiling

F = TypeVar("F", bound=Callable[..., Any])


class _Cache(FunctionCache):
    """Compiled code of a function on disk, where it can be read and written."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled code for a signature; None where there is none or it is damaged, and it is compiled."""
        try:
            found = super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except Exception:  # of unpickling: anything
            with suppress(OSError):
                self.flush()  # type: ignore[no-untyped-call]
            found = None
        if found is None:
            compiling.begin(self._name)
        else:
            compiling.started = True
        return found

    def holds(self, function: Any, types: tuple[Any, ...]) -> bool:
        """Return whether the compiled code of a function for types of arguments is on disk."""
        try:
            key = self._index_key(types, function.targetctx.codegen())  # type: ignore[no-untyped-call]
            return key in self._cache_file._load_index()  # type: ignore[no-untyped-call]
        except Exception:  # as above
            return False

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep the compiled code for a signature, where the folder takes it."""
        try:
            with suppress(OSError):
                super().save_overload(sig, data)  # type: ignore[no-untyped-call]
        finally:
            compiling.end()


def _compiler(**options: Any) -> Callable[[F], F]:
    def decorate(function: F) -> F:
        found = numba.njit(nogil=True, error_model="numpy", **options)(function)
        if isinstance(found, Dispatcher):  # which it is not under NUMBA_DISABLE_JIT
            with suppress(RuntimeError, OSError):  # no folder can be written
                found._cache = _Cache(function)  # type: ignore[attr-defined, no-untyped-call]
            # Numba compiles what another loop calls with True apart from what it calls with False: once does for both
            given = found.get_call_template
            found.get_call_template = lambda args, kws: given(tuple(map(types.unliteral, args)), kws)  # type: ignore[method-assign]
        return cast("F", found)

    return decorate


NO_C: dict[str, Any] = {"no_cfunc_wrapper": True}  # nothing calls loops from C
compiled = _compiler(**NO_C)
inlined = _compiler(inline="always", **NO_C)  # a part of one loop: it is compiled with it, not once more before
reordered = _compiler(
    fastmath={"reassoc", "contract", "nsz"}, **NO_C
)  # sums may be reordered; nan and infinity are kept


class AtHand:
    """Loops of a module of kernels where their compiled code for the arguments is at hand, else those in numpy.

    At hand is what this process has compiled or loaded, and what is on disk: nothing is compiled.
    """

    def __init__(self, kernels: object, others: object) -> None:
        self._kernels, self._others = kernels, others

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Return the loop of a name."""
        found = _chosen(getattr(self._kernels, name), getattr(self._others, name))
        setattr(self, name, found)
        return found


def _chosen(kernel: Callable[..., Any], other: Callable[..., Any]) -> Callable[..., Any]:
    if not isinstance(kernel, Dispatcher):
        return other
    known: dict[tuple[Any, ...], Callable[..., Any]] = {}
    cache: object = getattr(kernel, "_cache", None)

    def loop(*args: Any) -> Any:
        kinds = tuple(map(_kind, args))
        if kinds not in known:
            types = tuple(map(kernel.typeof_pyval, args))
            held = types in kernel.overloads or (isinstance(cache, _Cache) and cache.holds(kernel, types))
            known[kinds] = kernel if held else other
        return known[kinds](*args)

    return loop


def _kind(given: Any) -> Any:
    """Return what numba tells arguments apart by: it takes longer to name their types than a short loop takes."""
    if isinstance(given, np.ndarray):
        flags = given.flags
        return given.dtype, given.ndim, flags.c_contiguous, flags.f_contiguous, flags.writeable, flags.aligned
    return type(given)
