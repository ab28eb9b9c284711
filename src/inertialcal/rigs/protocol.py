"""Rig: a simulated test bench, which makes a twin of each seed.

A rig of your own is one object, named by an entry point of your package::

    RIG = Rig("centrifuge", "an accelerometer on a centrifuge", on_bench(build, Bench()), FAULTS)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from .twin import Bench, Changes, Fault, Twin, parse_fault, size_text

DEMONSTRATION_SEED = 1


@dataclass(frozen=True)
class Rig:
    """A test bench that can be simulated.

    Parameters
    ----------
    name : str
        As it is typed: ``"rate_table"``.
    title : str
        One line on it.
    make : callable
        Seed of all draws, and settings of the bench that differ -> `Twin`.
    faults : mapping of str to Fault
        Mistakes of its own that it can simulate, by name.
    demonstration_seed : int
        Seed of its demonstration.
    tests : tuple of str
        Procedures of its campaign, and ``"faces"`` where a protocol names them: it takes the general mistakes for them.
    """

    name: str
    title: str
    make: Callable[[int, Changes], Twin]
    faults: Mapping[str, Fault] = field(default_factory=dict)
    demonstration_seed: int = DEMONSTRATION_SEED
    tests: tuple[str, ...] = ()

    @property
    def every_fault(self) -> dict[str, Fault]:
        """Mistakes of its own, then the general ones that make sense for it."""
        from .faults import FAULTS  # noqa: PLC0415 - numpy

        fitting = {name: one for name, one in FAULTS.items() if set(one.tests) & set(self.tests)}
        return {**self.faults, **{name: one for name, one in fitting.items() if name not in self.faults}}

    def twin(self, seed: int, fault: str = "") -> Twin:
        """Return the campaign of a seed, with one mistake in it where a fault is named.

        Parameters
        ----------
        seed : int
            Of all draws.
        fault : str
            Name of the mistake, or name and size: ``"run_gain=5 %"``; empty: none.

        Raises
        ------
        UsageError
            If there is no mistake of that name, or its size is wrong.
        """
        if not fault:
            return replace(self.make(seed, {}), rig=self.name, seed=seed)
        known = self.every_fault
        name, size = parse_fault(fault, known)
        one = known[name]
        made = replace(self.make(seed, one.change), rig=self.name, seed=seed, fault=name)
        made = replace(made, size="" if size is None else size_text(size, one.unit))
        if one.spoil is None:
            return made
        from .faults.scene import spoiled  # noqa: PLC0415 - numpy

        return spoiled(made, one, size or 0.0)


def on_bench(build: Callable[[Bench, int], Twin], bench: Bench) -> Callable[[int, Changes], Twin]:
    """Return the function that makes the twins of a rig whose settings are a frozen dataclass.

    Parameters
    ----------
    build : callable
        Bench and seed -> twin.
    bench : dataclass
        The bench without a mistake.
    """
    return lambda seed, changes: build(replace(bench, **changes), seed)
