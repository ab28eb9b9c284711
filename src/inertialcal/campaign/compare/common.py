"""What two sides of a comparison have in common: errors of standards, and readings.

An error is the same in both where nothing has drawn it anew in between (``core.influence.Drawn``): one certificate and
period, one site, or one mounting, power-up or day that both state. Where nothing is stated it counts as independent,
unless the user says that it is shared; what is stated to differ is never shared.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import product

from ...core.errors import UsageError
from ...core.influence import Drawn, influence_of
from ...core.remarks import Remark
from ...core.results import Row
from ...statistics.difference import Figure
from .sources import Compared

SAME_DIGITS = 1e-12  # of a figure: two that came out of the same readings the same way differ by rounding alone
PART = 0.1  # of u of both figures: what a curvature leaves of a difference is worth a remark beyond
NAMED = 3  # recordings and standards that a remark names
MISSING = {
    "certificate": ("the certificate is not stated in both", 'certificate = "..." in [standards]'),
    "valid": ("the period of the certificate is not stated in both", 'valid = "..." in [standards]'),
    "site": ("the site is not stated in both", "latitude or gravity in [site]"),
    "mounting": ("the mounting is not stated in both", 'mounting = "..." in [[tests]]'),
    "power_up": ("the power-up is not stated in both", 'power_up = "..." in [[tests]]'),
    "day": ("the day is not known in both", 'day = "..." in [[tests]]'),
}  # what would have to be stated


@dataclass(frozen=True)
class Fate:
    """What becomes of the error of an influence in a difference."""

    shared: bool
    stated: bool = False  # By the user, for this comparison
    missing: str = ""  # What would have to be stated
    differs: str = ""  # Why it is drawn anew


@dataclass(frozen=True, eq=False)
class Common:
    """What two sides share."""

    first: Compared
    second: Compared
    stated: frozenset[str] = frozenset()  # Influences that are said to be shared
    stated_by: str = "as --shared says"
    _fates: dict[tuple[str, str, str], Fate | None] = field(default_factory=dict)

    def shared(self, one: Row, other: Row) -> list[str]:
        """Return the unknowns whose error is the same in two figures."""
        both = one.shared.keys() & other.shared.keys()
        found = {name for name in both if (fate := self.fate(name, one, other)) is not None and fate.shared}
        return sorted(found | self.curvature(one, other))

    def curvature(self, one: Row, other: Row) -> set[str]:
        """Return the terms that both figures know of: the same in both, as far as the unit is one."""
        return set() if self._two_units else one.curvature.keys() & other.curvature.keys()

    @property
    def _two_units(self) -> bool:
        return bool(self.first.serial and self.second.serial) and self.first.serial != self.second.serial

    def figures(self, one: Row, other: Row) -> tuple[Figure, Figure]:
        """Return both figures with what their uncertainty is made of."""
        return self.first.figure(one), self.second.figure(other)

    def fate(self, unknown: str, one: Row, other: Row) -> Fate | None:
        """Return what becomes of an unknown of both figures; None where it is not said which standard it is of."""
        key = (unknown, one.test, other.test)
        if key not in self._fates:
            self._fates[key] = self._judged(unknown, self.first.drawn(unknown, one), self.second.drawn(unknown, other))
        return self._fates[key]

    def _judged(self, unknown: str, mine: Drawn | None, its: Drawn | None) -> Fate | None:
        if mine is None or its is None:
            return None
        differs = mine.differs(its)
        if differs:
            return Fate(False, differs=differs)
        missing = mine.unknown(its)
        if missing and influence_of(unknown) in self.stated:
            return Fate(True, stated=True)
        return Fate(not missing, missing=missing)

    def identical(self, one: Row, other: Row) -> bool:
        """Whether two figures are one: the same number out of the same readings.

        A model says what went into it as a whole: two of other conditions that take a term from one test have it in
        common, whatever else went into each.
        """
        if self.first.sha256 == self.second.sha256 and one.test == other.test:
            return True
        mine, its = self.first.selected(one), self.second.selected(other)
        taken = one.test == other.test and bool(set(mine) & set(its))
        return (taken or (bool(mine) and sorted(mine) == sorted(its))) and all(
            _equal(*pair) for pair in ((one.value, other.value), (one.u, other.u), (one.dof, other.dof))
        )

    def recordings(self, one: Row, other: Row) -> set[str]:
        """Return the SHA-256 of recordings of which both figures may hold the same readings."""
        mine, its = self.first.selected(one), self.second.selected(other)
        if mine and its:
            return set().union(*(a.overlap(b) for a in mine for b in its))
        return set(self.first.recordings) & set(self.second.recordings)

    def remarks(self, pairs: Sequence[tuple[Row, Row]]) -> tuple[Remark, ...]:
        """Return remarks on what the figures of both sides share, or may share."""
        return (
            *self._on_readings(pairs), *self._on_standards(pairs), *self._on_curvature(pairs), *self._on_units()
        )  # fmt: skip

    def _on_curvature(self, pairs: Sequence[tuple[Row, Row]]) -> list[Remark]:
        gone, apart = dict[str, None](), dict[str, list[str]]()
        for one, other in pairs:
            if not all(row.status == "estimated" for row in (one, other)) or self.identical(one, other):
                continue
            for name in sorted(self.curvature(one, other)):
                mine, its = one.curvature[name], other.curvature[name]
                left = abs(its.change - mine.change) * max(mine.size, its.size)
                if left > PART * math.hypot(one.u or 0.0, other.u or 0.0):
                    apart.setdefault(name, []).append(f"{one.quantity} {one.axis}".strip())
                elif mine.share or its.share:
                    gone[name] = None
        remarks = []
        if gone:
            what = "curvatures of the unit that may be there and that no line has change both figures alike, and cancel"
            remarks.append(Remark("curvature_shared", "info", f"{what}: {', '.join(gone)}", count=len(gone)))
        for name, figures in apart.items():
            what = f"{name}: the lines of both take it otherwise (one has it, or the rates are others): "
            what += (
                f"{_listed(list(dict.fromkeys(figures)))} of both are not the same slope; what it changes counts in u"
            )
            do = 'Reduce both with one setting: nonlinearity = "always", or "none"'
            remarks.append(Remark("curvature_differs", "warning", what, count=len(figures), do=do))
        return remarks

    def _on_readings(self, pairs: Sequence[tuple[Row, Row]]) -> list[Remark]:
        if self.first.sha256 == self.second.sha256:
            return [Remark("same_file", "warning", "both files have the same content: every difference is 0")]
        estimated = [pair for pair in pairs if all(row.status == "estimated" for row in pair)]
        same = [pair for pair in estimated if self.identical(*pair)]
        part = [(pair, found) for pair in estimated if pair not in same and (found := self.recordings(*pair))]
        remarks = []
        if same:
            what = "the same figure out of the same readings: the difference is 0"
            remarks.append(Remark("same_readings", "warning", what, count=len(same), do="Compare separate recordings"))
        if part:
            hashes = dict.fromkeys(digest for _, found in part for digest in sorted(found))
            names = [self.first.recordings.get(digest, digest[:12]) for digest in hashes]
            what = f"recordings that went into both: {_listed(names)}: not independent, u of a difference is wrong"
            remarks.append(
                Remark("same_recordings", "warning", what, count=len(part), do="Compare separate recordings")
            )
        return remarks

    def _on_standards(self, pairs: Sequence[tuple[Row, Row]]) -> list[Remark]:
        fates: dict[str, dict[Fate, list[tuple[str, Row, Row]]]] = {}
        usable = [pair for pair in pairs if all(row.status == "estimated" for row in pair)]
        for one, other in usable:
            for name in sorted(one.shared.keys() & other.shared.keys()):
                if (fate := self.fate(name, one, other)) is not None and not self.identical(one, other):
                    fates.setdefault(influence_of(name), {}).setdefault(fate, []).append((name, one, other))
        remarks = []
        shared = {
            name: found for name, each in fates.items() if (found := [u for f in each if f.shared for u in each[f]])
        }
        if shared:
            what = "; ".join(f"{name}{self._said(name)}: {_most(found)}" for name, found in shared.items())
            what = f"one standard in both, so its error cancels in each difference: {what}"
            remarks.append(Remark("standards_shared", "info", what, count=len(shared)))
        missing = {name: fate.missing for name, each in fates.items() for fate in each if fate.missing}
        if missing:
            what = ", ".join(f"{name} ({MISSING[code][0]})" for name, code in missing.items())
            what = (
                f"standards in both: {what}: taken as independent. With one error in both, u of a difference is smaller"
            )
            how = ", ".join(dict.fromkeys(MISSING[code][1] for code in missing.values()))
            do = (
                f"State in both campaigns {how}; or, if you know it: {' '.join(f'--shared {name}' for name in missing)}"
            )
            remarks.append(Remark("standards_may_be_shared", "info", what, count=len(missing), do=do))
        redrawn = {name: fate.differs for name, each in fates.items() for fate in each if fate.differs}
        if redrawn:
            what = "; ".join(f"{name}: {why}" for name, why in redrawn.items())
            what = f"standards in both whose errors are not the same, taken as independent: {what}"
            remarks.append(Remark("standards_redrawn", "info", what, count=len(redrawn)))
        others = sorted((self.first.type_b & self.second.type_b) - fates.keys())
        if others and not all(self.identical(*pair) for pair in usable):
            what = f"Type B in both ({_listed(others)}): taken as independent. With one source in both, "
            what += "u of a difference is smaller than stated"
            remarks.append(Remark("standards_may_be_shared", "info", what, count=len(others)))
        return remarks

    def _said(self, name: str) -> str:
        return f" ({self.stated_by})" if name in self.stated and self.stated_by else ""

    def _on_units(self) -> list[Remark]:
        mine, its = self.first.serial, self.second.serial
        if not self._two_units:
            return []
        return [Remark("different_serials", "info", f"two units: serial {mine!r} and {its!r}")]


def common_of(first: Compared, second: Compared, stated: Iterable[str] = ()) -> Common:
    """Return what two sides share; `stated`: influences that are said to be shared, ``"rate_table.rate"``.

    Raises
    ------
    UsageError
        ``not_shared`` for one that is not in both, or that both state to be two.
    """
    names = frozenset(one.strip() for one in stated)
    both = sorted(first.influences.keys() & second.influences.keys())
    for name in sorted(names):
        if name not in both:
            what = f"--shared {name}: no standard of that name is in both"
            raise UsageError(what, do=f"There are: {', '.join(both) or 'none'}", code="not_shared")
        reasons = [mine.differs(its) for mine, its in product(first.drawings(name), second.drawings(name))]
        if all(reasons):
            raise UsageError(f"--shared {name}: {reasons[0]}", do="Leave it out: its errors are two", code="not_shared")
    return Common(first, second, names)


def _equal(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is other
    return math.isclose(one, other, rel_tol=SAME_DIGITS)


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:NAMED]) + (f" and {len(names) - NAMED} more" if len(names) > NAMED else "")


def _most(found: Sequence[tuple[str, Row, Row]]) -> str:
    """Say how much cancels, by the figure of which it is the largest part."""
    by_figure: dict[int, tuple[Row, float, float, float]] = {}
    for name, one, other in found:
        _, apart, left, _ = by_figure.get(id(one), (one, 0.0, 0.0, 0.0))
        a, b = one.shared[name], other.shared[name]
        whole = math.hypot(one.u or 0.0, other.u or 0.0)
        by_figure[id(one)] = (one, math.hypot(apart, a, b), math.hypot(left, b - a), whole)
    row, apart, left, _ = max(by_figure.values(), key=lambda each: (each[1] - each[2]) / (each[3] or 1.0))
    unit = "" if row.unit == "1" else f" {row.unit}"
    return f"{apart:.2g}{unit} of {row.quantity} {row.axis}".rstrip() + f", {left:.2g}{unit} left"
