"""The source mass: Tables 1 to 3."""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import polynomial

from . import lead_body as lead
from .figures import Figure, Section, Variant, figure
from .printed import Printed, Recomputed, printed, recompute
from .table_files import table

DOC = "reinel1969"
K = 2.0 * lead.INCH  # side of a small cube: lengths are whole inches, printed in cm
CUBE = 5.1  # the same as printed
MASS = lead.CELLS * CUBE**3 * lead.DENSITY / 1e3  # kg
NEIGHBOURS = 6
Told = dict[str, Printed]


def mass_sections(told: Told) -> tuple[Section, ...]:
    """Return Tables 1 to 3."""
    return (_table1(told), _table2(), _bound(told), _table3())


def _table1(told: Told) -> Section:
    gap = told["distance_table1"].value
    figures: list[Figure] = []
    for i, row in enumerate(table(DOC, "table1_lead_sphere"), start=1):
        level = float(row["acceleration_g"])
        for column, unit in (("mass_kg", "kg"), ("radius_cm", "cm")):
            readings = (
                Variant("the one without the distance to the surface", _sphere(level, 0.0, unit)),
                Variant("the one for that distance to the centre", _sphere_at(level, gap, unit)),
            )
            name = f"{unit} {i}"
            figures.append(
                figure(
                    name,
                    f"{column[:-3]} for {row['acceleration_g']} g",
                    row[column],
                    _sphere(level, gap, unit),
                    unit,
                    variants=readings,
                )
            )
    how = (
        "Sphere of lead (11.34 g/cm^3) whose surface is 10.2 cm from the proof mass, gamma = 6.67e-8 and g = "
        "981 as printed, for the acceleration of the row."
    )
    return Section("table 1", "Table 1, spheres of lead", how, tuple(figures))


def _sphere(level: float, gap: float, unit: str) -> Recomputed:
    density = printed("11.34")

    def solved(rho: float) -> float:
        radius = lead.sphere_radius(level, gap, rho)
        return radius if unit == "cm" else lead.sphere_mass(radius, rho)

    return recompute(solved, density)


def _sphere_at(level: float, distance: float, unit: str) -> Recomputed:
    mass = level / lead.point_attraction(1.0, distance)
    return Recomputed(mass if unit == "kg" else (mass * 1e3 / lead.DENSITY / (4.0 / 3.0 * math.pi)) ** (1.0 / 3.0))


def axial() -> list[tuple[Printed, Printed, float]]:
    """Return distance, attraction, and what the body of Table 2 gives there."""
    cells = lead.best_cells(4.0 * lead.INCH, K)
    found = []
    for row in table(DOC, "table2_lead_body_axial"):
        distance = printed(row["distance_cm"])
        shift = round(distance.value / lead.INCH) * lead.INCH - 4.0 * lead.INCH
        found.append((distance, printed(row["acceleration_ng"]), lead.cells_attraction(cells, K, (shift, 0.0))))
    return found


def _density_rounding(value: float) -> Recomputed:
    return recompute(lambda rho: value * rho / lead.DENSITY, printed("11.34"))


def _table2() -> Section:
    figures = tuple(
        figure(f"{d.text} cm", f"at {d.text} cm", shown, _density_rounding(found), "ng") for d, shown, found in axial()
    )
    how = (
        "The 900 most attracting of 20 x 20 x 10 cubes of 2 inches, chosen with the first face at 4 "
        "inches, then moved out; every "
        "distance of the table is a whole number of inches."
    )
    return Section("table 2", "Table 2, body moved along the input axis", how, figures)


def _bound(told: Told) -> Section:
    rows = {d.text: shown for d, shown, _ in axial()}
    zero = printed(table(DOC, "table3_lead_body_vertical")[0]["acceleration_ng"])
    figures = tuple(
        figure(
            name,
            f"{name}, {shown.text} ng",
            shown,
            _density_rounding(lead.largest_attraction(MASS, face)),
            "ng",
            "at most",
            why=f"it needs {_needed(shown.value, face):.0f} kg",
        )
        for name, shown, face in (
            ("Table 2 at 10.2 cm", rows["10.2"], told["surface_optimisation"].value),
            ("Table 3 at zero", zero, told["surface_zero"].value),
        )
    )
    how = (
        f"No body of {MASS:.0f} kg of lead (900 cubes of 5.1 cm) behind a plane attracts more than the one that fills "
        "x/r^3 >= c."
    )
    return Section("bound", "Tables 2 and 3 against the largest possible attraction", how, figures)


def _needed(attraction: float, face: float) -> float:
    masses = np.linspace(1000.0, 2000.0, 2001)
    return float(np.interp(attraction, [lead.largest_attraction(m, face) for m in masses], masses))


def profile() -> tuple[list[float], list[Printed]]:
    """Return the vertical positions of Table 3 on their grid of inches, and the attractions."""
    rows = table(DOC, "table3_lead_body_vertical")
    return [i * lead.INCH for i in range(len(rows))], [printed(row["acceleration_ng"]) for row in rows]


def _interpolated(at: float, x: list[float], y: list[Printed], keep: list[int]) -> Recomputed:
    """Return the polynomial through the nearest points, with the step to two fewer or more as its own doubt."""
    near = sorted(keep, key=lambda j: abs(x[j] - at))

    def through(n: int) -> Recomputed:
        chosen = near[:n]
        return recompute(lambda *v: lagrange(at, [x[j] for j in chosen], list(v)), *(y[j] for j in chosen))

    found = through(NEIGHBOURS)
    doubt = max(abs(found.value - through(n).value) for n in (NEIGHBOURS - 2, NEIGHBOURS + 2))
    return Recomputed(found.value, found.tolerance + doubt)


def lagrange(at: float, x: list[float], y: list[float]) -> float:
    """Return the polynomial through some points, at a place."""
    scale = max(abs(one - at) for one in x)
    series = polynomial.polyfit([(one - at) / scale for one in x], y, len(x) - 1)
    return float(series[0])


def _table3() -> Section:
    x, y = profile()
    keep = list(range(len(x)))
    bad: list[int] = []
    while True:
        misses = {
            i: abs(y[i].value - found.value) / (y[i].half + found.tolerance)
            for i in keep[1:-1]
            for found in [_interpolated(x[i], x, y, [j for j in keep if j != i])]
        }
        worst = max(misses, key=lambda i: misses[i])
        if misses[worst] <= 1.0 or len(bad) > 3:
            break
        keep.remove(worst)
        bad.append(worst)
    rows = table(DOC, "table3_lead_body_vertical")
    figures = [
        figure(
            f"{rows[i]['vertical_position_cm']} cm",
            f"at {rows[i]['vertical_position_cm']} cm",
            y[i],
            _interpolated(x[i], x, y, [j for j in keep if j != i]),
            "ng",
        )
        for i in range(1, len(x) - 1)
    ]
    figures.append(
        figure("level", "level of the profile", y[0], None, "ng", why="the shape of the stack is not in the document")
    )
    axis = [math.log(d.value) for d, _, _ in axial()][:4]
    at_zero = recompute(
        lambda *v: math.exp(lagrange(math.log(7.6), axis, [math.log(one) for one in v])),
        *(s for _, s, _ in axial()[:4]),
    )
    figures.append(figure("table 2", "at zero, from Table 2 at 7.6 cm", y[0], at_zero, "ng"))
    how = (
        "Each value by the polynomial through its six neighbours on the grid of inches; what four and "
        "eight give is its doubt; the value "
        "that fits worst is left out of the others. At zero: Table 2 interpolated (cubic, in logarithms)."
    )
    return Section("table 3", "Table 3, body moved vertically", how, tuple(figures))
