"""The figures of a campaign: each from plain curves and rows of ``results.json``, or none where there is no data.

``FIGURES`` names them. ``FIGURES["rate_error"].svg(results, test, axis)`` gives one for a page, ``.pictures(results)``
all of them, to be drawn anywhere (``picture.on_new_figure``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

from .campaign import budget, compensated, matrix
from .drawing.picture import Picture, on_new_figure
from .drawing.style import variables
from .drawing.svg import to_svg
from .flip import conditions, flip, side_by_side
from .mass_attraction import (
    cube_as_point,
    mass_body,
    mass_field,
    mass_forecast,
    mass_growth,
    mass_line,
    mass_runs,
    mass_series,
    proof_mass,
)
from .positions import positions_residuals, positions_sphere, transitions
from .rate_table import dwells, input_output, rate_error, reference_voltage
from .sine import sine
from .static_noise import allan, spectrum
from .thermal import overlay, start_up, thermal, thermal_order


@dataclass(frozen=True)
class Kind:
    """One kind of figure.

    Parameters
    ----------
    name : str
        ``"rate_error"``.
    pictures : callable
        Takes the content of ``results.json``, returns every picture of this kind that it has data for.
    """

    name: str
    pictures: Callable[[Mapping[str, Any]], list[Picture]]

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


FIGURES: dict[str, Kind] = {
    module.NAME: Kind(module.NAME, module.pictures)
    for module in (
        compensated,
        input_output,
        rate_error,
        dwells,
        side_by_side,
        flip,
        conditions,
        overlay,
        thermal,
        thermal_order,
        start_up,
        reference_voltage,
        mass_runs,
        mass_series,
        mass_line,
        sine,
        positions_residuals,
        positions_sphere,
        transitions,
        allan,
        spectrum,
        mass_body,
        mass_field,
        mass_growth,
        proof_mass,
        cube_as_point,
        mass_forecast,
        matrix,
        budget,
    )
}

__all__ = ["FIGURES", "Kind", "Picture", "on_new_figure", "prefix", "to_svg", "variables"]
