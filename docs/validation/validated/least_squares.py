"""The statistical reference data sets of NIST for linear least squares, and the thermometer of the GUM."""

from __future__ import annotations

import numpy as np
from test_least_squares import CERTIFIED, THERMOMETER, digits, line, problem

from inertialcal.statistics.least_squares import fit
from inertialcal.statistics.polynomial import fit_polynomial

from .found import Line, Table


def tables() -> list[Table]:
    """Return digits that agree with the certified ones, beside those of a peer, and a worked example of the GUM."""
    return [_strd(), _thermometer()]


def _strd() -> Table:
    lines = []
    for one in CERTIFIED:
        design, y = problem(one["dataset"], one["powers"])
        found = fit(design, y)
        by_peer = np.linalg.lstsq(design, y, rcond=None)[0]
        series = None
        if one["powers"] is not None and 0 in one["powers"] and len(one["powers"]) > 2:
            x = design[:, 1]
            series = digits(fit_polynomial(x, y, max(one["powers"])).monomials()[0], one["estimates"])
        own = digits(found.coefficients, one["estimates"])
        spread = digits(found.u, one["standard_deviations"])
        cells = (
            one["dataset"],
            one["difficulty"],
            own,
            series,
            spread,
            digits(by_peer, one["estimates"]),
            one["digits"],
        )
        lines.append(Line(cells, max(own, series or 0.0) >= one["digits"]))
    text = (
        "Digits that agree with the certified value, in the worst coefficient of each of the eleven linear sets of "
        "the [Statistical Reference Datasets](https://www.itl.nist.gov/div898/strd/). *By powers* is the fit of the "
        "columns as NIST gives them; *by the series* the Chebyshev series that every polynomial of the tool is "
        "fitted by, then turned into powers. The peer is `numpy.linalg.lstsq`."
    )
    heads = ("data set", "difficulty", "by powers", "by the series", "standard deviations", "numpy", "asked")
    return Table("Certified least squares of NIST", text, heads, (0, 0, 3, 3, 3, 3, 0), tuple(lines))


def _thermometer() -> Table:
    t, b = THERMOMETER.T
    found = fit(line(t - 20.0), b)
    u, at_30 = found.u, np.array([1.0, 10.0])
    covariance = found.need_covariance()
    printed = (
        ("correction at 20 degC", "degC", -0.1712, float(found.coefficients[0]), 5e-5 + 6e-6),
        ("its standard uncertainty", "degC", 0.0029, float(u[0]), 5e-5),
        ("slope", "1", 0.00218, float(found.coefficients[1]), 5e-6),
        ("its standard uncertainty", "1", 0.00067, float(u[1]), 5e-6),
        ("their correlation", "1", -0.930, float(covariance[0, 1] / u.prod()), 5e-4),
        ("scatter", "degC", 0.0035, float(found.scatter), 5e-5),
        ("correction at 30 degC", "degC", -0.1494, float(at_30 @ found.coefficients), 5e-5),
        ("its standard uncertainty", "degC", 0.0041, float(np.sqrt(at_30 @ covariance @ at_30)), 5e-5),
    )
    lines = tuple(
        Line((what, unit, value, own), abs(own - value) <= allowed) for what, unit, value, own, allowed in printed
    )
    text = "JCGM 100:2008, H.3: a thermometer, fitted by a line. A line holds if it rounds to what is printed."
    return Table("The thermometer of the GUM", text, ("figure", "unit", "printed", "inertialcal"), (0, 0, 0, 5), lines)
