"""Budgets: they add up to the uncertainty of their figure, and a sensitivity is what a change of the source does."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.outcome.contents import budget_rows
from inertialcal.core.estimate import Component, Estimate, joined_dof
from inertialcal.core.influence import Influence
from inertialcal.core.show.rows import case_name
from inertialcal.core.units import convert, divide, factor, multiply, normalise, same_dimension
from inertialcal.procedures.display import display_unit, stated_unit
from inertialcal.procedures.model_terms import ModelTerms, joined_terms
from inertialcal.procedures.rate_table.plan import Attitude
from inertialcal.procedures.rate_table.procedure import PROCEDURE
from inertialcal.procedures.rate_table.reduction import Plan, Readings, reduce
from ran_campaigns import Ran

SAME = 1e-12  # relative: rounding of sums and of units
QUANTITIES = (
    "bias",
    "residual_bias",
    "scale_factor",
    "scale_factor_error",
    "scale_factor_asymmetry",
    "cross_axis_sensitivity",
    "misalignment",
    "second_order",
    "third_order",
)
UNITS = ("%", "deg/s", "deg/h", "mdeg/s", "rad/s", "rad", "V/(deg/s)", "m/s^2", "ug", "1", "degC", "Torr")
SOURCES = ("%", "ppm", "1", "deg", "mrad", "arcsec", "rad", "deg/s", "rad/s", "degC", "K", "V", "ug", "mGal", "s")


def by_figure(results: Mapping[str, Any]) -> dict[tuple[str, str, str], list[dict[str, Any]]]:
    found = defaultdict(list)
    for row in results["budgets"]:
        found[row["test"], row["quantity"], row["axis"]].append(row)
    return dict(found)


def figures(results: Mapping[str, Any]) -> dict[tuple[str, str, str], dict[str, Any]]:
    return {
        (row["test"], row["quantity"], row["axis"]): row
        for row in results["results"]
        if row["status"] == "estimated" and row["quantity"] in QUANTITIES and not case_name(row)
    }


def test_every_figure_has_a_budget_and_every_budget_a_figure(campaign_ran: Ran) -> None:
    budgets, rows = by_figure(campaign_ran.results), figures(campaign_ran.results)
    assert set(budgets) == set(rows)
    assert {key[0] for key in rows} >= {"model"}


def test_budgets_recombine_to_uncertainty_and_degrees_of_freedom(campaign_ran: Ran) -> None:
    budgets = by_figure(campaign_ran.results)
    for key, row in figures(campaign_ran.results).items():
        mine = budgets[key]
        u = np.sqrt(sum(one["u"] ** 2 for one in mine))
        assert {one["unit"] for one in mine} == {row["unit"]}
        assert u == pytest.approx(row["u"], rel=SAME)
        if all(one["dof"] is None for one in mine):
            assert row["dof"] is None
        else:
            dof = joined_dof([np.array(one["u"] ** 2) for one in mine], [one["dof"] or np.inf for one in mine])
            assert dof == pytest.approx(row["dof"], rel=1e-9)


def test_shares_are_those_of_the_variance_and_add_up_to_one(campaign_ran: Ran) -> None:
    rows = figures(campaign_ran.results)
    for key, mine in by_figure(campaign_ran.results).items():
        assert sum(one["share"] for one in mine) == pytest.approx(1.0, rel=SAME)
        for one in mine:
            assert one["share"] == pytest.approx(one["u"] ** 2 / rows[key]["u"] ** 2, rel=SAME)


def test_sensitivity_times_what_is_stated_is_the_contribution(campaign_ran: Ran) -> None:
    for one in campaign_ran.results["budgets"]:
        assert one["sensitivity"] * one["stated_u"] == pytest.approx(one["u"], rel=SAME)
        assert factor(multiply(one["sensitivity_unit"], one["stated_unit"]), one["unit"], True) == pytest.approx(1.0)
        assert normalise(one["sensitivity_unit"]) == one["sensitivity_unit"]
        if one["kind"] == "A":
            assert (one["sensitivity"], one["sensitivity_unit"]) == (1.0, "1")


def test_sources_are_told_as_the_campaign_states_them(published: Ran, simulated: Ran) -> None:
    told = {
        (one["source"], one["stated_u"], one["stated_unit"], one["distribution"])
        for ran in (published, simulated)
        for one in ran.results["budgets"]
        if one["kind"] == "B"
    }
    assert ("earth rate: tilt of the table", 3.0, "deg", "normal") in told
    assert ("table rate", 0.03, "%", "normal") in told
    assert ("converter reference", 0.01, "%", "normal") in told
    assert {one[3] for one in told if "phase" in one[0]} == {"arcsine"}


def figure(rows: list[dict[str, Any]], quantity: str, axis: str, source: str) -> dict[str, Any]:
    return next(one for one in rows if (one["quantity"], one["axis"], one["source"]) == (quantity, axis, source))


@pytest.mark.parametrize(
    ("old", "new"), [('tilt = "-36.4 deg"', 'tilt = "-36.3 deg"'), ('latitude = "36.6 deg"', 'latitude = "36.7 deg"')]
)
def test_bias_follows_an_angle_as_its_sensitivity_says(published: Ran, tmp_path: Path, old: str, new: str) -> None:
    """Tilt and latitude shift the earth rate alike: the table axis stands in the meridian."""
    figures_of: list[float] = []
    for change in ((old, old), (old, new)):
        text = (published.folder / "campaign.toml").read_text().replace(*change)
        folder = tmp_path / str(len(figures_of))
        folder.mkdir()
        for path in published.folder.glob("*.csv"):
            (folder / path.name).write_bytes(path.read_bytes())
        (folder / "campaign.toml").write_text(text)
        rows = run(folder, write=False).results
        figures_of.append(figures(rows)["rate_x", "bias", "x"]["value"])
    said = figure(
        [one for one in published.results["budgets"] if one["test"] == "rate_x"],
        "bias",
        "x",
        "earth rate: tilt of the table",
    )
    step = 0.1  # deg
    assert abs(figures_of[1] - figures_of[0]) == pytest.approx(
        said["sensitivity"] * float(convert(step, "deg", said["stated_unit"])), rel=1e-3
    )


def dwells() -> tuple[Plan, Readings]:
    """Two sensors, two axes turned, five runs; errors of the standards as stated."""
    rng = np.random.default_rng(5)
    rates = np.radians([-4.0, -2.0, 0.0, 2.0, 4.0])
    applied, axis = np.tile(rates, 10), np.repeat(["x", "y"], 25)
    run_of = np.tile(np.repeat([str(i) for i in range(5)], 5), 2)
    own = {"x": (1.01, 0.003), "y": (-0.002, 0.99)}
    outputs = {
        s: 1e-4 + np.where(axis == "x", own[s][0], own[s][1]) * applied + rng.normal(0.0, 1e-6, 50) for s in "xy"
    }
    plan = Plan(
        asymmetry=False,
        scale_factor={"x": 28.6, "y": 28.6},
        attitude=Attitude(0.0, 0.01),
        latitude=0.6,
        standards={
            "rate_table.rate": Influence(5e-4, "1", 12.0, "normal", "", (0.05, "%")),
            "rate_table.mounting": Influence(1e-3, "rad", as_stated=(1.0, "mrad")),
            "converter.reference": Influence(2e-4),
            "site.latitude": Influence(1e-5, "rad", 7.0),
        },
    )
    return plan, Readings(applied, axis, outputs, run=run_of, sensors=("x", "y"))


def test_sensitivities_by_hand() -> None:
    plan, readings = dwells()
    result = reduce(plan, readings)
    assert result.estimate is not None
    rows = budget_rows("test", result.estimate, "deg/s", PROCEDURE.budgeted(result))
    entry = {name: result.estimate.value(f"misalignment_{name}") for name in ("xy", "yx")}
    m_xx = 1.0 + result.estimate.value("scale_factor_error_x")
    rate = figure(rows, "scale_factor_error", "x", "table rate")
    assert (rate["stated_u"], rate["stated_unit"], rate["dof"]) == (0.05, "%", 12.0)
    assert rate["sensitivity"] == pytest.approx(m_xx, rel=1e-9)  # M changes by -r M
    assert rate["sensitivity_unit"] == "1"
    volts = figure(rows, "scale_factor", "x", "converter reference")
    assert volts["stated_u"] == pytest.approx(0.02)
    assert volts["sensitivity"] == pytest.approx(np.radians(28.6) * m_xx / 100.0, rel=1e-9)  # V/(deg/s) for each %
    assert normalise(volts["sensitivity_unit"]) == volts["sensitivity_unit"] == divide("V/(deg/s)", "%")
    mounted = figure(rows, "misalignment", "xy", "mounting on the table")
    assert (mounted["stated_u"], mounted["stated_unit"]) == (1.0, "mrad")
    own_over_itself = float(factor("mrad", "rad"))  # 1 rad of misalignment for each rad: the entry M_xx / M_xx
    assert mounted["sensitivity"] == pytest.approx(own_over_itself, rel=3e-3)
    assert abs(entry["xy"] * m_xx - 0.003) < 1e-4
    latitude = [one for one in rows if one["source"] == "earth rate: latitude of the table"]
    assert {one["dof"] for one in latitude} == {7.0}
    assert {one["stated_unit"] for one in latitude} == {"deg"}


def test_readings_made_with_another_attitude_have_no_source_to_state() -> None:
    plan, readings = dwells()
    with_attitude = reduce(plan, readings).readings
    rows = budget_rows("test", reduce(replace(plan, attitude=None), with_attitude).estimate, "deg/s")
    tilt = figure(rows, "bias", "x", "earth rate: tilt of the table")
    assert (tilt["stated_u"], tilt["stated_unit"], tilt["sensitivity"], tilt["sensitivity_unit"]) == (
        None,
        "",
        None,
        "",
    )


def test_without_an_attitude_any_direction_of_the_earths_rotation_is_equally_likely() -> None:
    """A component of a vector in any direction is rectangular between -Omega and Omega."""
    plan, readings = dwells()
    plan = replace(plan, attitude=None)
    result = reduce(plan, readings)
    rows = budget_rows("test", result.estimate, "deg/h", PROCEDURE.budgeted(result))
    found = figure(rows, "bias", "x", "earth rate: direction unknown, x turned")
    assert found["distribution"] == "rectangular"
    assert found["stated_unit"] == "deg/h"
    assert found["stated_u"] == pytest.approx(15.04107 / np.sqrt(3.0), rel=1e-6)  # IERS: 7.292115e-5 rad/s


@given(st.sampled_from(UNITS), st.sampled_from(SOURCES))
def test_units_of_sensitivities_can_be_pasted_back(unit: str, source: str) -> None:
    printed = divide(unit, source)
    assert normalise(printed) == printed
    assert same_dimension(multiply(printed, source), unit)
    assert factor(multiply(printed, source), unit, True) == pytest.approx(1.0, rel=1e-9)


@given(
    st.floats(1e-9, 1e3), st.floats(1e-9, 1e3), st.sampled_from(["%", "1", "ppm", "deg", "rad", "mrad", "rad/s"]),
    st.sampled_from(["deg/s", "rad/s", "deg/h"]),
)  # fmt: skip
@settings(max_examples=60)
def test_a_contribution_does_not_depend_on_the_unit_of_its_source(
    u: float, own: float, unit: str, sensor_unit: str
) -> None:
    component = Component("source", "B", np.array([[u**2]]), stated=(own, unit))
    estimate = Estimate(("bias_x",), np.array([1.0]), ("rad/s",), (component,))
    (row,) = budget_rows("test", estimate, sensor_unit)
    shown = display_unit("bias", "rad/s", sensor_unit)
    assert row["u"] == pytest.approx(u * factor("rad/s", shown), rel=SAME)
    assert row["sensitivity"] * row["stated_u"] == pytest.approx(row["u"], rel=SAME)
    assert row["stated_u"] == pytest.approx(own * factor(unit, row["stated_unit"]), rel=1e-9)
    assert stated_unit(row["stated_unit"], sensor_unit) == row["stated_unit"]


def test_what_is_no_more_than_rounding_has_no_row() -> None:
    parts = (Component("scatter", "A", np.array([[1.0]]), 4.0), Component("dust", "B", np.array([[1e-32]])))
    rows = budget_rows("test", Estimate(("bias_x",), np.array([0.0]), ("rad/s",), parts), "rad/s")
    assert [row["source"] for row in rows] == ["scatter"]
    nothing = Estimate(("bias_x",), np.array([0.0]), ("rad/s",), (Component("none", "A", np.array([[0.0]])),))
    assert budget_rows("test", nothing, "rad/s") == []
    assert budget_rows("test", None, "rad/s") == []


def test_a_model_of_two_reductions_keeps_what_was_stated() -> None:
    plan, readings = dwells()
    estimate = reduce(plan, readings).estimate
    assert estimate is not None
    terms = ModelTerms(estimate, estimate.keys, ("x", "y", "z"), {})
    parts = [replace(terms.of_kinds([kind]), tests=(kind,)) for kind in ("scale_factor", "misalignment", "bias")]
    merged = joined_terms(parts).estimate
    assert merged is not None
    for name in ("bias_x", "misalignment_xy"):
        stated = [
            {(c.origin._replace(test=""), c.stated) for c in one.components if c.u[one.index(name)] > 0.0}
            for one in (estimate, merged)
        ]
        assert stated[0] == stated[1]


def test_the_campaigns_own_unit_survives(campaign: Callable[..., Path]) -> None:
    folder = campaign(('u = "0.05 %"', 'half_width = "866 ppm"'))
    rows = run(folder, write=False).results["budgets"]
    rate = figure(rows, "scale_factor_error", "x", "table rate")
    assert rate["stated_u"] == pytest.approx(866.0 / np.sqrt(3.0), rel=1e-12)
    assert (rate["stated_unit"], rate["sensitivity_unit"], rate["distribution"]) == ("ppm", "%/ppm", "rectangular")
