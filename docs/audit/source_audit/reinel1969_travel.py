"""Travel of the source mass, and what the text says of it."""

from __future__ import annotations

import math

import numpy as np

from . import lead_body as lead
from .figures import Section, figure
from .printed import Recomputed, printed, recompute
from .reinel1969_mass import CUBE, DOC, MASS, Told, axial, lagrange, profile
from .table_files import table


def _curve(position: float) -> float:
    x, y = profile()
    near = sorted(range(len(x)), key=lambda j: abs(x[j] - position))[:4]
    return lagrange(position, [x[j] for j in near], [y[j].value for j in near])


def travel_sections(told: Told) -> tuple[Section, ...]:
    """Return the travel, the statements on the source mass, and masses taken as points."""
    return (_travel(told), _statements(told), _points(told))


def best_travel() -> tuple[float, float]:
    """Return where the travel of 12 inches with the largest change starts, and that change."""
    starts = np.arange(8.0, 20.0, 0.01)
    changes = [_curve(s) - _curve(s + 12.0 * lead.INCH) for s in starts]
    best = int(np.argmax(changes))
    return float(starts[best]), float(changes[best])


def _travel(told: Told) -> Section:
    rows = {
        row["vertical_position_cm"]: printed(row["acceleration_ng"]) for row in table(DOC, "table3_lead_body_vertical")
    }
    high, low = rows["12.7"], rows["43.2"]
    start, change = best_travel()
    middle = 0.5 * (high.value + low.value)
    x, y = profile()
    at = float(np.interp(-middle, [-one.value for one in y], x))
    figures = (
        figure("amplitude", "amplitude", told["amplitude"], recompute(lambda a, b: 0.5 * (a - b), high, low), "ng"),
        figure(
            "possible",
            "amplitude with more than 100 cm",
            told["possible_amplitude"],
            recompute(lambda a: 0.5 * a, rows["0"]),
            "ng",
        ),
        figure("middle", "middle position", told["middle"], Recomputed(at), "cm"),
        figure(
            "start",
            "start of the travel with the largest change",
            told["travel_start"],
            Recomputed(start),
            "cm",
            why=f"from there the change is {change:.2f} ng, from 12.7 cm {high.value - low.value:.2f} ng",
        ),
    )
    how = (
        "Half the change from 12.7 to 43.2 cm in Table 3; half of its first value; where the mean of the two "
        "is reached; the best 12 inches of the table."
    )
    return Section("travel", "Text: travel of the mass", how, figures)


def _statements(told: Told) -> Section:
    limit = told["mass_limit"].value
    rows = {d.text: shown for d, shown, _ in axial()}
    figures = (
        figure("cells", "cells of 100 large and 100 small cubes", told["cells"], Recomputed(100.0 * 8.0 + 100.0)),
        figure("mass", "mass used, about", told["mass_used"], Recomputed(MASS), "kg"),
        figure(
            "75",
            "attraction of less than 1500 kg at 7.6 cm",
            told["attraction_under_limit"],
            Recomputed(lead.largest_attraction(limit, told["surface_zero"].value)),
            "ng",
            relation="at most",
        ),
        figure(
            "70",
            "change on moving away by about 76.2 cm",
            told["shift_70_ng"],
            recompute(lambda a, b: a - b, rows["5.1"], rows["76.2"]),
            "ng",
        ),
        figure(
            "tilt",
            "75 ng as a tilt",
            told["tilt_of_75_ng"],
            recompute(lambda a: math.degrees(a * 1e-9) * 3600.0, told["attraction_under_limit"]),
            "arcsec",
        ),
        figure(
            "nearest",
            "distance of the nearest cube centre, from Table 3",
            told["nearest_cube_centre"],
            recompute(lambda d: d + 0.5 * CUBE, told["surface_zero"]),
            "cm",
        ),
        figure(
            "surface",
            "distance of the surface in figure 4, from Table 3",
            told["surface_optimisation"],
            recompute(lambda d: d, told["surface_zero"]),
            "cm",
            why="two meanings of one distance",
        ),
    )
    how = (
        "900 cubes of 5.1 cm; the largest attraction of 1500 kg; Table 2 from 5.1 to 76.2 cm; a tilt is a/g; "
        "surface and half a cube."
    )
    return Section("source mass", "Text: source mass", how, figures)


def _points(told: Told) -> Section:
    length, diameter, nearest = 2.915, 1.268, told["nearest_cube_centre"].value
    figures = (
        figure(
            "cube",
            "cube as a point at twice its side, error",
            told["cube_error"],
            Recomputed(lead.cube_error(2.0)),
            relation="at least",
            why="0.001 needs 2.9 times the side; over the whole body the errors cancel",
        ),
        figure(
            "proof mass",
            "proof mass as a point for every cube, error at the nearest",
            told["proof_mass_error"],
            Recomputed(lead.shell_error(nearest, length, diameter)),
            relation="at least",
            why="thin-walled cylinder, 2.915 cm long, 1.268 cm wide",
        ),
    )
    how = (
        "The text has both errors below 1e-3: attraction of a cube on its face axis; attraction on a "
        "thin-walled cylinder along the axis."
    )
    return Section("points", "Text: masses taken as points", how, figures)
