"""A procedure of others brings its figures: declared as data, drawn by a module of its own, nothing of ours changed."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from types import ModuleType
from typing import Any

import pytest
from matplotlib.axes import Axes
from test_figures import results

import inertialcal as ic
from inertialcal.core.errors import PlanError
from inertialcal.core.figure import FigureSpec
from inertialcal.core.results import WrittenRow
from inertialcal.core.show.rows import Cited, Quoted, Sentence, estimated
from inertialcal.procedures import PROCEDURES, procedure_of_result
from inertialcal.procedures.protocol import Procedure
from inertialcal.report import drawings, findings
from inertialcal.report.figures import Picture, figures
from inertialcal.report.figures.drawing.data import curves, numbers
from inertialcal.report.numbers import wrap
from written_rows import fields

NAME = "toy"
SPEC = FigureSpec(
    "toy_spin", "toy_spin_figure", "Spin of {axis} as it was read{note}.", {"toy_spin": ""}, order=105, most=1
)
CURVE = {
    "name": "toy_spin", "test": "spun", "axis": "x", "recording": "a",
    "columns": {"time": {"unit": "s", "values": [0.0, 1.0]}, "spin": {"unit": "deg/s", "values": [1.0, 2.0]}},
}  # fmt: skip


def pictures(content: dict[str, Any]) -> list[Picture]:
    def picture(curve: Any) -> Picture:
        def paint(axes: Sequence[Axes], title: str) -> None:
            axes[0].plot(numbers(curve, "time"), numbers(curve, "spin"))

        note = (", requirement ", Quoted("<R1>"))
        return Picture("toy_spin", curve["test"], curve["axis"], "it spins", "spin", (1.0,), paint, note=note)

    return [picture(curve) for curve in curves(content, "toy_spin")]


class Spin(Procedure[Any, Any, Any]):
    name, title, figures = NAME, "Spin of a toy.", (SPEC,)

    def finding(self, rows: Sequence[WrittenRow]) -> Sentence:
        (row,) = estimated(rows, "spin")
        return ("It spins at ", Cited(row), ", on ", Quoted(row["axis"]))


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    module = ModuleType(SPEC.module)
    module.pictures = pictures  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, SPEC.module, module)
    PROCEDURES[NAME] = Spin()
    yield
    del PROCEDURES[NAME]


def test_every_procedure_of_ours_declares_its_figures_and_no_name_twice() -> None:
    declared = [spec.name for name in PROCEDURES for spec in PROCEDURES[name].figures]
    assert len(declared) == len(set(declared))
    assert set(figures()) == {
        *declared,
        "compensated",
        "changes",
        "matrix",
        "budget",
        "save_intervals",
        "plan_time",
        "archive_history",
        "archive_trend",
        "lot_distribution",
        "lot_stations",
        "lot_along",
        "lot_distance",
    }
    assert next(iter(figures())) == "compensated"
    assert list(figures())[-2:] == ["matrix", "budget"]


@pytest.mark.usefixtures("toy")
def test_a_curve_of_others_under_a_name_of_ours_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    taken = FigureSpec("toy_noise", "toy_spin_figure", "Noise of {axis}.", {"toy_spin": "", "allan": ""})
    monkeypatch.setattr(Spin, "figures", (SPEC, taken))
    with pytest.raises(PlanError, match="a curve 'allan' is one of procedure 'static_noise' already"):
        figures()


@pytest.mark.usefixtures("toy")
def test_a_figure_of_others_is_drawn_where_it_says() -> None:
    content = results() | {"curves": [CURVE, CURVE | {"recording": "b"}]}
    assert list(figures()).index("toy_spin") == list(figures()).index("input_output") + 1
    assert ic.plot({"curves": [CURVE]}).get_lines()
    (drawn,) = [one for one in drawings.of_campaign(content) if one.spec is SPEC]  # of two recordings the first
    assert findings.html(drawn.caption) == ("Spin of <bdi>x</bdi> as it was read, requirement <bdi>&lt;R1&gt;</bdi>.")
    assert [title for title, _ in drawn.data()] == ["toy spin", "toy spin"]
    assert drawn.data()[0][1].splitlines()[:2] == ["time [s],spin [deg/s]", "0.0,1.0"]


@pytest.mark.usefixtures("toy")
def test_a_procedure_of_others_says_what_it_found_and_each_number_knows_its_row() -> None:
    row = {"quantity": "spin", "axis": "x", "status": "estimated", **fields(), "value": 3.0, "u": 0.1, "unit": "1"}
    said = findings.html(findings.of_test(NAME, wrap([row], "/results"), []))
    assert said == (
        'It spins at <data value="3.0" data-at="/results/0/value">3.00</data> ± '
        '<data value="0.1" data-at="/results/0/u">0.10</data>, on <bdi>x</bdi>'
    )


@pytest.mark.usefixtures("toy")
def test_a_name_that_is_taken_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Spin, "figures", (FigureSpec("allan", "toy_spin_figure"),))
    with pytest.raises(PlanError, match="procedure 'toy': there is a figure 'allan' already"):
        figures()


def test_a_result_is_of_the_procedure_whose_package_its_type_stands_in() -> None:
    assert procedure_of_result(SPEC) is None
    assert procedure_of_result({}) is None
