"""What the campaign files of all rigs have in common, and the errors of their standards."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...core.campaign_text import SCHEMA, Noted
from ...core.influence import Influence, influence_of
from ...core.key import AXES
from ...core.schema.standards import STANDARDS
from ...core.units import factor
from ..twin import SEAL, SEED, DrawnError

Content = dict[str, object]  # of a table

PLACES = {f"{standard}.{name}": (standard, name) for standard, names in STANDARDS.items() for name in names}
TRUTH = (
    "The true values are in .truth/. Only `inertialcal score` reads them; `run` gives the same results without them."
)
CERTIFIED = "What a certificate states beside the figures, here invented: inertialcal certificate DIR -o FILE.pdf"
LABORATORY: Content = {  # of an example
    "number": "EXAMPLE-1",
    "issued": "2011-01-10",
    "received": "2010-04-20",
    "performed": ["2010-04-28", "2010-12-31"],
    "laboratory": {"name": "Example laboratory", "city": "Monterey", "country": "US"},
    "customer": {"name": "Example customer", "city": "Monterey", "country": "US"},
    "item_condition": "simulated",
    "methods": ["IEEE Std 1431-2004, 12.9 to 12.12"],
    "environment": "simulated; each result says its range",
    "deviations": "none",
    "signatures": [{"name": "A. Person", "function": "head of laboratory"}],
}
EACH_ERROR = "Each standard has one unknown error for the whole campaign."


def drawn_error(influence: Influence | None, rng: np.random.Generator) -> float:
    """Return the unknown error of a standard, drawn as its certificate says [its unit]; 0 where there is none."""
    if influence is None:
        return 0.0
    if influence.distribution == "rectangular":
        half = influence.u * np.sqrt(3.0)
        return float(rng.uniform(-half, half))
    return float(rng.normal(0.0, influence.u))


def drawn_errors(standards: Mapping[str, Influence], errors: Mapping[str, float]) -> tuple[DrawnError, ...]:
    """Return errors of standards in their standard uncertainties, for the score of the campaign.

    Parameters
    ----------
    standards : mapping of str to Influence
        By ``"rate_table.rate"``.
    errors : mapping of str to float
        What is stated of the standard, or read, less what is true, by its name, with the axis where there are several:
        ``"converter.zero[y]"`` [its unit].
    """
    stated = {name: standards[influence_of(name)] for name in errors if influence_of(name) in standards}
    return tuple(
        DrawnError(name, errors[name] / one.u, one.distribution) for name, one in stated.items() if one.u > 0.0
    )


def campaign_head(rig: str, item: str, title: str, about: str) -> Content:
    """Return the first tables of a simulated campaign, with the marks for the seed and for the seal of the truth.

    Parameters
    ----------
    rig, item, title : str
        Name of the rig, the part under test, title of the campaign.
    about : str
        One line on the campaign, for the comment at its head.
    """
    source = f"simulated: rig {rig}, seed {SEED}; truth sealed with SHA-256 {SEAL}"
    return {
        "schema": Noted(SCHEMA, above=f"A simulated campaign: {about}.\n{TRUTH}"),
        "campaign": {"id": f"{rig}-{SEED}", "title": title, "source": source},
        "item": {"maker": "inertialcal", "part": item, "serial": SEED},
    }


def standard_tables(standards: Mapping[str, Influence], units: Mapping[str, str] | None = None) -> dict[str, Content]:
    """Return the tables of the standards.

    Parameters
    ----------
    standards : mapping of str to Influence
        By ``"rate_table.mounting"``, in order.
    units : mapping of str to str, optional
        Unit to write for a unit of the standards; ratios are written in percent by default.
    """
    tables: dict[str, Content] = {}
    for name, influence in standards.items():
        standard, quantity = PLACES[name]
        unit = ({"1": "%"} | dict(units or {})).get(influence.unit, influence.unit)
        rectangular = influence.distribution == "rectangular"
        size = influence.u * factor(influence.unit, unit) * (np.sqrt(3.0) if rectangular else 1.0)
        entry: Content = {"half_width" if rectangular else "u": f"{size:.12g} {unit}"}
        if np.isfinite(influence.dof):
            entry["dof"] = int(influence.dof) if float(influence.dof).is_integer() else influence.dof
        if influence.u == 0.0:
            entry["reason"] = influence.reason or "simulated without an error"
        tables.setdefault(standard, {})[quantity] = entry | {"certificate": influence.certificate}
    return tables


def channel_entries(columns: Mapping[str, str], unit: str) -> dict[str, Content]:
    """Return the entries of channels that share a unit: channel -> column."""
    return {channel: {"column": column, "unit": unit} for channel, column in columns.items()}


def attitude(tilt: float, u_tilt: float, azimuth: float, u_azimuth: float) -> Content:
    """Return the setting ``attitude`` of a plan, from angles [deg]."""
    angles = {"tilt": tilt, "u": u_tilt, "azimuth": azimuth, "u_azimuth": u_azimuth}
    return {name: f"{angle:g} deg" for name, angle in angles.items()}


def by_axis(texts: list[str]) -> dict[str, str]:
    """Return a text for each of the axes x, y, z."""
    return dict(zip(AXES, texts, strict=True))
