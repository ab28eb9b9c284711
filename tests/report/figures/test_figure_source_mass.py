"""Figures of a source mass: what they say, and what they draw."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import PolyCollection

import inertialcal as ic
from inertialcal.core.errors import InertialcalError
from inertialcal.procedures.mass_attraction.planning.planner import MassPlan
from inertialcal.report.figures import figures, on_new_figure, to_svg
from inertialcal.report.figures.drawing.data import curves, numbers

NAMES = ("mass_body", "mass_field", "mass_growth", "cube_as_point", "mass_forecast", "proof_mass")


@cache
def planned() -> MassPlan:
    return ic.plan_mass_attraction(
        body={"cube": "10 cm", "count": 50, "stand_off": "7.6 cm"}, uncertainty={"density": "0.3 %"},
        motion={"rig": ["0 cm", "60 cm"], "stroke": ["10 cm", "40 cm"]},
        noise={"velocity_random_walk": "55 ng/sqrt(Hz)"},
        proof_mass={"length": "2.9 cm", "inner_radius": "1.3 cm", "radius": "1.4 cm"},
    )  # fmt: skip


@pytest.fixture(scope="module")
def plan() -> MassPlan:
    return planned()


def test_each_has_a_finding_and_can_be_drawn_for_a_page_and_a_file(plan: MassPlan) -> None:
    for name in NAMES:
        (picture,) = figures()[name].pictures(plan.results)
        assert any(letter.isdigit() for letter in picture.finding), name
        figure = on_new_figure(picture, titled=True)
        figure.canvas.draw()
        assert "<svg" in to_svg(picture, "p")
        assert figures()[name].pictures({"curves": [], "results": []}) == []


def test_findings_say_what_the_rows_say(plan: MassPlan) -> None:
    rows = {row.quantity: row.value for row in reversed(plan.rows)}
    said = {name: figures()[name].pictures(plan.results)[0].finding for name in NAMES}
    assert f"{rows['mass']:.0f} kg" in said["mass_body"]
    assert f"amplitude of {rows['amplitude']:.3g} ng" in said["mass_field"]
    assert "from 10 to 40 cm" in said["mass_field"]
    assert "with sine" in said["mass_forecast"]


def test_the_body_is_drawn_right_of_the_proof_mass_each_open_face_once(plan: MassPlan) -> None:
    axes = np.ravel(ic.plot(plan, figure="mass_body"))[0]
    (faces,) = [one for one in axes.collections if isinstance(one, PolyCollection)]
    corners = np.concatenate([path.vertices for path in faces.get_paths()])
    assert corners[:, 0].min() > 0.0  # where the proof mass is
    (body,) = curves(plan.results, "mass_body")
    cells = {tuple(cell) for cell in np.rint(np.column_stack([numbers(body, name) for name in "xyz"]) / 5.0).tolist()}
    steps = ((2.0, 0.0, 0.0), (0.0, -2.0, 0.0), (0.0, 0.0, 2.0))
    seen = sum(tuple(np.add(cell, step)) not in cells for cell in cells for step in steps)
    assert len(faces.get_paths()) == seen


def test_a_cube_two_edges_away_is_as_far_from_a_point_as_worked_out_apart(plan: MassPlan) -> None:
    """Values of the source audit, row "figure 3 / text: cube against point at R/k = 2"."""
    (curve,) = curves(plan.results, "cube_as_point")
    ratio = numbers(curve, "ratio")
    for name, percent in {"face": -0.4361, "edge": 0.0897, "corner": 0.3346}.items():
        error = numbers(curve, name)
        there = np.isfinite(error)
        at = np.interp(np.log(2.0), np.log(ratio[there]), np.log(np.abs(error[there])))
        assert np.sign(error[there][-1]) * np.exp(at) == pytest.approx(percent, rel=0.01)


def test_growth_passes_the_body_and_the_best_is_above_the_sphere(plan: MassPlan) -> None:
    (curve,) = curves(plan.results, "mass_growth")
    mass, best, sphere, own = (numbers(curve, name) for name in ("mass", "best", "sphere", "body"))
    assert (best > sphere).all()
    (at,) = np.flatnonzero(np.isfinite(own))
    assert mass[at] == pytest.approx(plan.body.mass)  # type: ignore[union-attr]
    assert 0.97 * best[at] < own[at] < best[at]


def test_of_a_body_alone_there_is_no_field_to_draw() -> None:
    alone = ic.plan_mass_attraction(body={"cube": "10 cm", "count": 50, "stand_off": "7.6 cm"})
    with pytest.raises(InertialcalError, match="mass_field"):
        ic.plot(alone, figure="mass_field")


def test_a_figure_says_where_what_is_applied_limits(plan: MassPlan) -> None:
    axes: Any = np.ravel(ic.plot(plan, figure="mass_forecast"))[0]
    assert "uncertainty of what is applied" in [
        text.get_text().replace("\n", " ") for text in axes.get_legend().get_texts()
    ]
