"""The registry of figures: name -> figure; a result is drawn as the first of them that it has data for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from importlib import import_module
from typing import Any

from ...core.errors import PlanError
from ...core.figure import FigureSpec
from ...procedures import loaded_procedures
from .campaign.specs import FIGURES as OF_A_CAMPAIGN
from .drawing.picture import Picture
from .drawing.svg import to_svg


@dataclass(frozen=True)
class Figure:
    """One kind of figure.

    Parameters
    ----------
    spec : FigureSpec
        As declared.
    """

    spec: FigureSpec

    def pictures(self, results: Mapping[str, Any]) -> list[Picture]:
        """Return every picture of this kind that the content of ``results.json`` has data for."""
        there = {curve.get("name") for curve in results.get("curves", [])}
        if self.spec.curves and there.isdisjoint(self.spec.curves):
            return []
        found: list[Picture] = import_module(self.spec.module).pictures(results)
        return [one for one in found if one.name == self.spec.name]  # a module may draw several kinds

    def chosen(self, results: Mapping[str, Any], test: str | None = None, axis: str | None = None) -> list[Picture]:
        """Return the pictures of a test and of an axis; all where they are not said.

        A picture of all axes at once, or of all tests, is chosen with every axis, or test, that is not its own.
        """
        return [
            one
            for one in self.pictures(results)
            if test in (None, one.test) and (axis in (None, one.axis) or not one.axis)
        ]

    def svg(
        self, results: Mapping[str, Any], test: str | None = None, axis: str | None = None, number: int = 0
    ) -> str | None:
        """Return one picture as an ``<svg>`` element; None where there is no data for it.

        Parameters
        ----------
        results : mapping
            Content of ``results.json``.
        test, axis : str, optional
            Of which; the first that there is where not said.
        number : int
            Which of those chosen, from 0: the dwells of a test have one a recording.
        """
        found = self.chosen(results, test, axis)
        return to_svg(found[number], prefix(found[number], number)) if number < len(found) else None


def prefix(picture: Picture, number: int = 0) -> str:
    """Return what every id of a picture on a page begins with; it differs from picture to picture."""
    which = sha256("\0".join((picture.test, picture.axis)).encode(errors="replace")).hexdigest()[:8]
    return f"fig-{picture.name}-{which}-{number}"


def figures() -> dict[str, Figure]:
    """Return all figures by name, in their order.

    Raises
    ------
    PlanError
        ``broken_plugin`` if a procedure of others declares a figure, or draws it from curves, under a name that is
        taken: the figures of both would be drawn from the curves of either.
    """
    found: dict[str, FigureSpec] = {one.name: one for one in OF_A_CAMPAIGN}
    drawn: dict[str, str] = {}  # curve -> its procedure
    for procedure in loaded_procedures():
        for spec in procedure.figures:
            if spec.name in found:
                what = f"procedure {procedure.name!r}: there is a figure {spec.name!r} already"
                raise PlanError(what, do="Give it another name", code="broken_plugin")
            found[spec.name] = spec
            for curve in spec.curves:
                if drawn.setdefault(curve, procedure.name) != procedure.name:
                    what = (
                        f"procedure {procedure.name!r}: a curve {curve!r} is one of procedure {drawn[curve]!r} already"
                    )
                    raise PlanError(what, do="Give it another name", code="broken_plugin")
    return {one.name: Figure(one) for one in sorted(found.values(), key=lambda one: one.order)}
