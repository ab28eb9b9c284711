"""Which loops a record takes: compiled ones, or those in numpy that give the same.

Importing numba takes a quarter of a second, and compiling a loop longer: numpy takes less for a short record. Where
compiled loops are in use already, those that are at hand are taken, and after many calls all.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import cached_property
from typing import Generic, TypeVar, cast

from ..core.show.compiling import compiling

Loops = TypeVar("Loops")


class Choice(Generic[Loops]):
    """The loops of a package.

    Parameters
    ----------
    others : module or class
        The loops in numpy.
    kernels : callable
        Imports the module of the compiled ones, with the same names.
    short : int
        Samples up to which a record is short.
    few : int
        Calls after which compiled loops pay, however short the records.
    """

    def __init__(self, others: Loops, kernels: Callable[[], object], short: int, few: int) -> None:
        self._others, self._kernels, self._short, self._few = others, kernels, short, few
        self._calls = itertools.count()

    def __call__(self, samples: int) -> Loops:
        """Return the loops for a record of so many samples."""
        if samples > self._short or next(self._calls) >= self._few:
            return self.compiled
        return self.at_hand if compiling.started else self._others

    @cached_property
    def compiled(self) -> Loops:
        """The compiled ones."""
        return cast("Loops", self._kernels())

    @cached_property
    def at_hand(self) -> Loops:
        """Those that nothing need be compiled for."""
        from ..statistics._kernels import AtHand  # noqa: PLC0415 - starts slowly

        return cast("Loops", AtHand(self.compiled, self._others))
