"""Linear algebra on one core: every call and every run asks for it, for as long as it takes.

OpenBLAS, which numpy and scipy each bring, shares out matrices from about a hundred columns. At a few hundred that
gains nothing on an idle machine, and costs tenfold on a busy one: each step waits for the slowest thread, and threads
that wait for the next step keep a core from those of ours. The last digits, too, depend on how many threads there are.
With another library of linear algebra nothing is changed.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib.machinery import PathFinder
from importlib.util import find_spec
from pathlib import Path
from threading import Lock

MODULES = (("numpy", "_umath_linalg"), ("scipy", "_fblas"))  # of their linalg; linked to the library of each
NAMES = ("scipy_openblas_{}_num_threads64_", "scipy_openblas_{}_num_threads", "openblas_{}_num_threads")

_lock = Lock()
_inside = 0  # callers that ask for one thread, of all threads of Python
_before: list[int] = []  # threads of each library, as the first of them met it


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let linear algebra use one thread, until the last of those that ask for it at the same time is done."""
    global _inside  # noqa: PLW0603 - the libraries, too, have one number for the process
    with _lock:
        if not _inside:
            _before[:] = [count() for count, _ in _libraries()]
            for _, limit in _libraries():
                limit(1)
        _inside += 1
    try:
        yield
    finally:
        with _lock:
            _inside -= 1
            if not _inside:
                for (_, limit), threads in zip(_libraries(), _before, strict=True):
                    limit(threads)


@cache
def _libraries() -> tuple[tuple[Callable[[], int], Callable[[int], None]], ...]:
    """Return what tells, and what sets, the number of threads of each library that can be told."""
    found = []
    for package, module in MODULES:  # without importing them: what is reduced already is not worth it
        folder = Path(getattr(find_spec(package), "origin", None) or package).parent / "linalg"
        try:
            library = ctypes.CDLL(getattr(PathFinder.find_spec(module, [str(folder)]), "origin", None) or module)
        except (ImportError, OSError):
            continue
        name = next((one for one in NAMES if hasattr(library, one.format("set"))), None)
        if name is not None:
            found.append((getattr(library, name.format("get")), getattr(library, name.format("set"))))
    return tuple(found)
