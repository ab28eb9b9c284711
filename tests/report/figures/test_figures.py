"""Each figure draws what it is given, or is not there; its SVG is safe, the same every time, and of its own ids."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from archive_curves import CURVES as ARCHIVE_CURVES
from hypothesis import given, settings
from hypothesis import strategies as st
from lot_curves import CURVES as LOT_CURVES
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from test_figure_alignment import CURVES as ALIGNMENT_CURVES
from test_figure_flip import dwells as flip_dwells
from test_figure_flip import quiet as flip_quiet
from test_figure_heads import CURVES as HEADS_CURVES
from test_figure_magnetometer_bias import CURVES as FIELD_CURVES
from test_figure_mass import CURVES as MASS_CURVES
from test_figure_mass import ROWS as MASS_ROWS
from test_figure_microgravity import CURVES as STATION_CURVES
from test_figure_noise import allan as noise_allan
from test_figure_noise import allan_terms as noise_terms
from test_figure_noise import spectrum as noise_spectrum
from test_figure_plan_time import CURVES as PLAN_CURVES
from test_figure_positions import CURVES as POSITIONS_CURVES
from test_figure_sensitivity import CURVES as SENSITIVITY_CURVES
from test_figure_sensitivity import ROWS as SENSITIVITY_ROWS
from test_figure_shifted_model import CURVES as SHIFTED_CURVES
from test_figure_sine import curves_of as sine_curves
from test_figure_source_mass import planned
from test_figure_thermal import CURVES as THERMAL_CURVES
from test_figure_thermal import ROWS as THERMAL_ROWS
from test_figure_thermal import SEQUENCE as THERMAL_SEQUENCE
from test_figure_turned_mass import CURVES as TURNED_CURVES
from test_figure_vibration import CHANGES, JUDGED, vibration_curves

from inertialcal.core.errors import DataError
from inertialcal.report.figures import figures, on_new_figure, prefix, to_svg
from inertialcal.report.figures.campaign import budget, matrix
from inertialcal.report.figures.drawing import data
from inertialcal.report.figures.drawing.scales import signed_log
from inertialcal.report.figures.drawing.style import ROLES, plain, variables
from inertialcal.report.figures.rate_table import rate_error
from sized import sized
from written_rows import fields

RATES = [-4.0, -2.0, -0.5, 0.5, 2.0, 4.0]
LIMIT = 5.0
HOSTILE = (
    "<script>alert(1)</script>", '" onload="alert(1)', "$\\frac{1}{0}$", "$", "_hidden", "]]>", "&lt;b&gt;",
    "a\x00b\x1b[31m", "\u202eright to left", "x" * 500, "url(http://a.org/a.svg)", "漢字", "--><style>*{}</style>",
)  # fmt: skip


def column(values: list[Any], unit: str = "") -> dict[str, Any]:
    return {"unit": unit, "values": values}


def curve(name: str, axis: str = "x", test: str = "one", **columns: Any) -> dict[str, Any]:
    return {"name": name, "test": test, "axis": axis, "columns": columns}


def input_output(**changes: Any) -> dict[str, Any]:
    columns: dict[str, Any] = {
        "applied": column(RATES, "deg/s"),
        "reading": column([-4.1, -2.0, -0.4, 0.6, 2.1, None], "deg/s"),
        "residual": column([-0.5, 0.02, 0.01, -0.01, 0.03, None], "deg/s"),
        "run": column(["1"] * 3 + ["2"] * 3),
        "group": column([""] * 6),
        "used": column([False, True, True, True, True, False]),
        "reason": column(["at_rail", "", "", "", "", "not_read"]),
        "place": column([f"a.csv:{i}" for i in range(2, 8)]),
    }
    return curve("input_output", **columns | changes)


def linearity(**changes: Any) -> dict[str, Any]:
    columns: dict[str, Any] = {
        "rate": column(RATES, "deg/s"),
        "deviation": column([0.2, -0.1, 0.0, 0.0, -0.1, 0.2], "%"),
        "lo": column([0.1, -0.2, -0.1, -0.1, -0.2, 0.1], "%"),
        "hi": column([0.3, 0.0, 0.1, 0.1, 0.0, 0.3], "%"),
        "fitted": column([0.19, -0.1, 0.01, 0.01, -0.1, 0.19], "%"),
    }
    return curve("linearity", **columns | changes)


def errors(**changes: Any) -> dict[str, Any]:
    columns: dict[str, Any] = {
        "rate": column(RATES, "deg/s"),
        "error": column([0.1, 0.2, 40.0, -3.0, 6.0, 9.0], "%"),
        "u": column([0.1] * 6, "%"),
        "dof": column([4.0] * 6),
        "lo": column([0.0, 0.1, 10.0, -4.0, 4.0, 8.0], "%"),
        "hi": column([0.2, 0.3, 70.0, -2.0, 8.0, 10.0], "%"),
    }
    return curve("rate_error", **columns | changes) | {"of": "dwell_mean"}


def verdict(at: float, word: str, **changes: Any) -> dict[str, Any]:
    row = {
        "requirement": "R1", "test": "one", "axis": "x", "at": at, "at_unit": "deg/s", "of": "dwell_mean",
        "value": 0.0, "u": 0.1, "unit": "%", "interval": {"lo": -1.0, "hi": 1.0, "p": 0.95},
        "lower": -LIMIT, "upper": LIMIT, "verdict": word, "reason": "",
    }  # fmt: skip
    return row | changes


VERDICTS = [verdict(-4.0, "PASS"), verdict(-2.0, "PASS"), verdict(2.0, "INCONCLUSIVE"), verdict(4.0, "FAIL")]


def row(quantity: str, axis: str, value: float | None, unit: str, u: float | None = 0.01) -> dict[str, Any]:
    status = "not_estimated" if value is None else "estimated"
    return {
        "quantity": quantity, "axis": axis, "test": "model", **fields(), "value": value, "u": u, "unit": unit,
        "status": status,
    }  # fmt: skip


ROWS = [
    row("scale_factor_error", "x", 0.5, "%"), row("scale_factor_error", "y", -0.2, "%"),
    row("misalignment", "xy", 0.02, "rad", 0.001), row("misalignment", "yx", None, "rad", None),
]  # fmt: skip


def share(source: str, kind: str, size: float, quantity: str = "bias", axis: str = "x") -> dict[str, Any]:
    return {
        "test": "one",
        "quantity": quantity,
        **fields(),
        "axis": axis,
        "source": source,
        "kind": kind,
        "share": size,
    }


SHARES = [share("scatter", "A", 0.25), share("mounting", "B", 0.75), share("scatter", "A", 1.0, "bias", "y")]


def trace(**changes: Any) -> list[dict[str, Any]]:
    line: dict[str, Any] = {
        "time": column([0.0, 1.0, 2.0, 3.0, 4.0], "s"),
        "lo": column([1.0, 1.0, None, 2.0, 2.0], "deg/s"),
        "hi": column([1.5, 1.0, None, 2.5, 3.0], "deg/s"),
    }
    found: dict[str, Any] = {
        "start": column([0.0, 3.0], "s"), "stop": column([1.0, 4.0], "s"), "level": column([1.0, 2.0], "deg/s"),
        "applied": column([1.0, 2.0], "deg/s"), "used": column([True, False]), "reason": column(["", "odd_scatter"]),
    }  # fmt: skip
    return [
        {**curve("trace", **line | changes), "recording": "rec"},
        {**curve("dwells", **found | changes), "recording": "rec"},
    ]


def saved(name: str, lengths: list[float], counts: list[int]) -> dict[str, Any]:
    return {
        **curve("save_intervals", length=column(lengths, "s"), count=column(counts)), "axis": "", "recording": name
    }  # fmt: skip


def compensated(axis: str = "x", **changes: Any) -> dict[str, Any]:
    columns: dict[str, Any] = {
        "applied": column(RATES, "deg/s"),
        "raw_error": column([0.1, 0.2, 0.3, 0.4, 0.5, 0.6], "deg/s"),
        "compensated_error": column([0.0, 0.01, -0.01, 0.0, 0.02, None], "deg/s"),
        "run": column(["1"] * 6),
    }
    return curve("compensated", axis, "model", **columns | changes)


def beside(quantity: str, value: float, u: float | None, condition: str = "", axis: str = "y") -> dict[str, Any]:
    interval = None if u is None else {"lo": value - 2.0 * u, "hi": value + 2.0 * u, "p": 0.95}
    own = fields(condition) | {"test": "new", "interval": interval, "dof": None}
    return row(quantity, axis, value, "ug", u) | own


BESIDE = [  # two ground models: y nearer to zero, z not shown
    beside("model_bias_error", -17.0, 0.5), beside("other_model_bias_error", 37.0, 1.0),
    beside("model_bias_error_change", -54.0, 0.5), beside("model_bias_error_reduction", 20.0, 1.0),
    beside("model_bias_error", -17.2, None, "flip 2"), beside("other_model_bias_error", 36.8, None, "flip 2"),
    beside("model_bias_error_change", -54.0, None, "flip 2"),
    beside("model_bias_error", 37.0, 0.5, axis="z"), beside("other_model_bias_error", 30.0, 20.0, axis="z"),
    beside("model_bias_error_change", 7.0, 20.0, axis="z"),
    beside("model_bias_error_reduction", -7.0, None, axis="z"),
]  # fmt: skip
SEQUENCE = [{"test": "new", "against": "old"}]
LOOP = {"axes": [{"axis": "x", "raw_rms": 0.3891, "compensated_rms": 0.0123, "unit": "deg/s"}]}


def results() -> dict[str, Any]:
    return {
        "curves": [input_output(), errors(), linearity(), *trace(), compensated(), compensated("y"), flip_dwells("y"),
                   flip_quiet("y"), saved("rec", [2.0, 3.0, 6.0], [900, 17, 2]), saved("other", [2.0, 5.0], [100, 7]),
                   *copy.deepcopy([*THERMAL_CURVES, *MASS_CURVES, *POSITIONS_CURVES, *SENSITIVITY_CURVES,
                                 *planned().results["curves"], *vibration_curves(), *TURNED_CURVES,
                                 *FIELD_CURVES, *SHIFTED_CURVES, *STATION_CURVES, *PLAN_CURVES,
                                 *HEADS_CURVES, *ARCHIVE_CURVES, *ALIGNMENT_CURVES, *LOT_CURVES]),
                   noise_allan("z"), noise_terms("z"), noise_spectrum("z"), *sine_curves("z")],
        "sequence": SEQUENCE + THERMAL_SEQUENCE, "verdicts": [*VERDICTS, *JUDGED],
        "results": [*ROWS, *BESIDE, *CHANGES, *THERMAL_ROWS, *MASS_ROWS, *SENSITIVITY_ROWS,
                    *copy.deepcopy(planned().results["results"])],
        "budgets": SHARES, "closed_loop": LOOP,
    }  # fmt: skip


def drawn(name: str, content: dict[str, Any], titled: bool = False) -> Figure:
    figure = on_new_figure(figures()[name].pictures(content)[0], titled)
    figure.draw_without_rendering()
    return figure


def lines_of(ax: Axes, label: str) -> tuple[list[float], list[float]]:
    """Points of the line whose legend label begins like this."""
    line = next(one for one in ax.get_lines() if str(one.get_label()).startswith(label))
    return np.asarray(line.get_xdata()).tolist(), np.asarray(line.get_ydata()).tolist()


def legend_of(ax: Axes) -> list[str]:
    legend = ax.get_legend()
    return [] if legend is None else [text.get_text() for text in legend.get_texts()]


# Data drawn is data given


def test_save_intervals_are_those_of_all_recordings_of_the_test() -> None:
    (picture,) = figures()["save_intervals"].pictures(results())
    (ax,) = drawn("save_intervals", results()).axes
    assert [round(one.get_height()) for one in ax.patches if isinstance(one, Rectangle)] == [1000, 17, 7, 2]
    assert [one.get_text() for one in ax.get_xticklabels()] == ["2", "3", "5", "6"]
    assert picture.finding == "one: 26 of 1,026 saves later than after 2 s"
    assert picture.note == (" Two recordings.",)


def test_input_output_draws_every_dwell_and_names_the_rule_of_those_left_out() -> None:
    above, below = drawn("input_output", results()).axes
    assert lines_of(above, "dwells used") == ([-2.0, -0.5, 0.5, 2.0], [-2.0, -0.4, 0.6, 2.1])
    assert lines_of(below, "dwells used") == ([-2.0, -0.5, 0.5, 2.0], [0.02, 0.01, -0.01, 0.03])
    assert lines_of(above, "left out, at rail") == ([-4.0], [-4.1])
    assert legend_of(below) == [
        "fitted line", "dwells used (4)", "left out, at rail (1)", "left out, not read (1)",
        "outside the lower panel (1)",
    ]  # fmt: skip
    low, high = below.get_ylim()
    assert lines_of(below, "outside") == ([-4.0], [low])  # residual -0.5 against 0.03 of those used
    assert high == -low
    assert above.get_ylabel() == "reading [deg/s]"
    assert below.get_xlabel() == "applied [deg/s]"


def test_the_fitted_line_is_reading_minus_residual() -> None:
    above, _ = drawn("input_output", results()).axes
    x, y = lines_of(above, "fitted line")
    assert x == [-2.0, -0.5, 0.5, 2.0]
    np.testing.assert_allclose(y, [-2.02, -0.41, 0.61, 2.07])


@pytest.mark.parametrize(("runs", "joined"), [(2, 2), (60, 0)])
def test_few_runs_are_joined_and_many_are_not_a_rainbow(runs: int, joined: int) -> None:
    n = 240
    content = input_output(
        applied=column([float(i % 40) for i in range(n)], "deg/s"), reading=column([float(i % 40) for i in range(n)]),
        residual=column([0.01 * (i % 7) for i in range(n)]), run=column([str(i % runs) for i in range(n)]),
        used=column([True] * n), reason=column([""] * n), group=column([""] * n), place=column([""] * n),
    )  # fmt: skip
    _, below = drawn("input_output", {"curves": [content]}).axes
    lines = [one for one in below.get_lines() if len(np.asarray(one.get_xdata())) == n // runs]
    assert len(lines) == joined
    assert len({str(one.get_color()) for one in lines}) <= 1


def test_a_verdict_shows_in_shape_and_colour() -> None:
    (ax,) = drawn("rate_error", results()).axes
    by_word = {
        word: next(one for one in ax.get_lines() if str(one.get_label()).startswith(word))
        for word in ("PASS", "FAIL", "INCONCLUSIVE", "not judged")
    }
    assert len({(line.get_marker(), str(line.get_markerfacecolor())) for line in by_word.values()}) == 4
    assert len({line.get_marker() for word, line in by_word.items() if word != "not judged"}) == 3
    assert lines_of(ax, "PASS") == ([-4.0, -2.0], [0.1, 0.2])
    assert lines_of(ax, "FAIL") == ([4.0], [9.0])
    assert lines_of(ax, "not judged") == ([-0.5, 0.5], [40.0, -3.0])


def test_intervals_are_those_given() -> None:
    (ax,) = drawn("rate_error", results()).axes
    x, y = (np.reshape(values, (-1, 3)) for values in lines_of(ax, "95 % at this rate"))
    np.testing.assert_array_equal(x[:, 0], RATES)
    columns = errors()["columns"]
    np.testing.assert_array_equal(y[:, :2], np.transpose([columns["lo"]["values"], columns["hi"]["values"]]))
    x, y = (np.reshape(values, (-1, 3)) for values in lines_of(ax, "95 % for all rates together"))
    assert x[:, 0].tolist() == [-4.0, -2.0, 2.0, 4.0]
    assert set(y[:, 0].tolist()) == {-1.0}


def test_the_band_stands_only_where_the_requirement_holds() -> None:
    assert rate_error.stretches(np.array(RATES), [True, True, False, False, True, True]) == [(-4.0, -2.0), (2.0, 4.0)]
    assert rate_error.stretches(np.array([-1.0, 1.0, 2.0]), [True] * 3) == [(-1.0, -1.0), (1.0, 2.0)]
    (ax,) = drawn("rate_error", results()).axes
    ends = [path.vertices for band in ax.collections for path in band.get_paths()]
    assert len(ends) == 2
    for corners in map(np.asarray, ends):
        assert np.min(np.abs(corners[:, 0])) > 1.8  # not over the rates of 0.5 deg/s, nor over zero
        assert set(np.round(corners[:, 1], 9)) == {-LIMIT, LIMIT}


def test_another_error_than_the_curve_is_drawn_as_it_was_judged() -> None:
    judged = [verdict(4.0, "PASS", of="expected", value=0.5)]
    (one,) = rate_error.points(errors(), judged)
    assert one.error[-1] == 0.5
    assert np.isnan(one.lo[-1])
    assert one.wide_hi[-1] == 1.0
    assert one.error[0] == 0.1


def test_each_requirement_has_a_panel_and_others_tests_none() -> None:
    more = [*VERDICTS, verdict(4.0, "PASS", requirement="R2"), verdict(4.0, "FAIL", test="two", requirement="R3")]
    assert [one.requirement for one in rate_error.points(errors(), more)] == ["R1", "R2"]
    assert len(drawn("rate_error", results() | {"verdicts": more}).axes) == 2
    assert len(drawn("rate_error", results() | {"verdicts": []}).axes) == 1


def test_the_trace_goes_through_least_and_largest_and_stops_at_gaps() -> None:
    (ax,) = drawn("dwells", results()).axes
    line = ax.get_lines()[0]
    pairs = set(zip(np.asarray(line.get_xdata()).tolist(), np.asarray(line.get_ydata()).tolist(), strict=True))
    expected = {(0.0, 1.0), (0.0, 1.5), (1.0, 1.0), (3.0, 2.0), (3.0, 2.5), (4.0, 2.0), (4.0, 3.0)}
    assert {pair for pair in pairs if np.isfinite(pair[1])} == expected
    assert {x for x, y in pairs if np.isnan(y)} == {2.0}
    used, left = (np.asarray(one.get_paths()[0].vertices) for one in ax.collections)
    assert (used[:, 0].min(), used[:, 0].max()) == (0.0, 1.0)
    assert (left[:, 0].min(), left[:, 0].max()) == (3.0, 4.0)
    assert ax.collections[1].get_hatch()
    assert not ax.collections[0].get_hatch()
    assert legend_of(ax) == ["dwells used (1)", "left out, odd scatter (1)"]


def test_dwells_need_the_trace_of_their_own_recording() -> None:
    line, found = trace()
    assert figures()["dwells"].pictures({"curves": [line | {"recording": "other"}, found]}) == []
    assert figures()["dwells"].pictures({"curves": [found]}) == []


def test_the_envelope_joins_neighbours_at_one_end() -> None:
    at, values = data.envelope(np.array([0.0, 1.0]), np.array([1.0, 3.0]), np.array([2.0, 4.0]))
    assert (at.tolist(), values.tolist()) == ([0.0, 0.0, 1.0, 1.0], [1.0, 2.0, 4.0, 3.0])


def test_the_matrix_reads_along_rows_and_says_what_is_missing() -> None:
    (ax,) = drawn("matrix", results()).axes
    texts = {tuple(text.get_position()): text.get_text() for text in ax.texts}
    assert texts[0.5, 0.5] == "0.500\n± 0.010\n%"
    assert texts[1.5, 0.5] == "0.0200\n± 0.0010\nrad"  # xy: row x, column y
    assert texts[0.5, 1.5] == "not\nestimated"  # yx
    assert texts[1.5, 1.5].startswith("−0.200")
    assert ax.get_ylim() == (2.0, 0.0)  # x above y
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("input axis", "sensor")
    assert [label.get_text() for label in ax.get_yticklabels()] == ["x", "y"]


def test_strength_of_colour_is_size_and_sign_is_hue() -> None:
    (ax,) = drawn("matrix", results()).axes
    cells = {patch.get_xy(): patch for patch in ax.patches if patch.get_alpha() is not None}  # type: ignore[attr-defined]
    strongest = cells[1, 0]  # 0.02 rad is more than 0.5 %
    assert strongest.get_alpha() == pytest.approx(matrix.STRONGEST)
    assert cells[0, 0].get_alpha() == pytest.approx(matrix.STRONGEST * 0.005 / 0.02)
    assert cells[1, 1].get_facecolor()[:3] != cells[0, 0].get_facecolor()[:3]
    assert sum(bool(patch.get_hatch()) for patch in ax.patches) == 1


def test_budget_bars_are_the_shares_and_b_is_hatched() -> None:
    (ax,) = drawn("budget", results()).axes
    bars = [(round(p.get_x()), round(p.get_width()), bool(p.get_hatch())) for p in ax.patches]  # type: ignore[attr-defined]
    assert bars == [(0, 25, False), (25, 75, True), (0, 100, False)]
    assert [label.get_text() for label in ax.get_yticklabels()] == ["bias x", "bias y"]
    assert legend_of(ax) == ["scatter (A)", "mounting (B)"]


def test_many_sources_share_an_entry_that_counts_them() -> None:
    rows = [share(f"source {i}", "B", (20 - i) / 210) for i in range(20)]
    known = budget.sources(rows)
    assert (len(known), known[-1].label) == (8, "13 smaller sources (A, B)")
    (ax,) = drawn("budget", {"budgets": rows}).axes
    assert sum(p.get_width() for p in ax.patches) == pytest.approx(100.0 * sum(r["share"] for r in rows))  # type: ignore[attr-defined]


def test_raw_and_compensated_errors_are_those_given() -> None:
    figure = drawn("compensated", results())
    assert len(figure.axes) == 2
    x, y = lines_of(figure.axes[0], "raw")
    assert (x, y) == (RATES, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    assert lines_of(figure.axes[0], "compensated")[1][:5] == [0.0, 0.01, -0.01, 0.0, 0.02]


def test_side_by_side_draws_both_errors_their_difference_and_the_flips() -> None:
    above, below = drawn("side_by_side", results()).axes
    points = [np.asarray(line.get_xdata()).tolist() for line in above.get_lines()[1:]]
    assert points == [[-17.0], [-17.2], [37.0], [36.8], [-54.0], [-54.0]]
    segments = [
        np.asarray(one.get_segments()[0])[:, 0].tolist() for one in above.collections if isinstance(one, LineCollection)
    ]
    assert segments == [[-18.0, -16.0], [35.0, 39.0], [-55.0, -53.0]]
    assert [label.get_text() for label in below.get_yticklabels()] == ["new", "old", "difference"]
    assert below.get_xlabel() == "error [ug]"


# Titles


def test_titles_say_the_finding_with_numbers_of_the_results() -> None:
    found = {name: kind.pictures(results())[0].finding for name, kind in figures().items()}
    assert found["compensated"] == "rms error on hold-out dwells: x 0.39 → 0.012 deg/s"
    assert found["input_output"] == "x: 4 dwells within 0.03 deg/s of the line, 2 left out"
    assert found["linearity"] == "x: 2 of 6 rates off the straight line; largest deviation 0.2 %, at -4 deg/s"
    assert found["rate_error"] == "x: R1 FAIL at 1, INCONCLUSIVE at 1, PASS at 2 of 4 rates"
    assert found["dwells"] == "rec, x: 2 dwells found, 1 of them left out"
    expected = (
        "largest scale-factor error 0.5 % (x), largest misalignment 0.02 rad (x towards y), 1 entries not estimated"
    )
    assert found["matrix"] == expected
    assert found["side_by_side"] == "To zero, new against old: y 20.0 ± 1.0 ug nearer; z not shown nearer"
    assert found["budget"] == "mounting is the largest source in 1 of 2 quantities"


def test_a_title_stands_on_a_file_and_not_on_a_page() -> None:
    picture = figures()["rate_error"].pictures(results())[0]
    assert on_new_figure(picture, titled=True).get_suptitle().startswith("x: R1 FAIL")
    assert on_new_figure(picture, titled=False).get_suptitle() == ""


# Nothing to draw, little, much, large, small


def emptied(content: dict[str, Any], value: Callable[[list[Any]], list[Any]]) -> dict[str, Any]:
    curves = [
        one | {"columns": {name: c | {"values": value(c["values"])} for name, c in one["columns"].items()}}
        for one in content["curves"]
    ]
    return content | {"curves": curves}


@pytest.mark.parametrize("name", figures())
def test_absent_data_is_no_figure(name: str) -> None:
    nothing: dict[str, Any] = {"curves": [], "verdicts": [], "results": [], "budgets": [], "closed_loop": {"axes": []}}
    assert figures()[name].svg({}) is None
    assert figures()[name].svg(nothing) is None
    rowless = emptied(results(), lambda values: []) | {"results": [], "budgets": []}
    assert figures()[name].svg(rowless) is None
    blank = emptied(results(), lambda values: [None] * len(values)) | {"results": [], "budgets": []}
    assert figures()[name].svg(blank) is None
    assert figures()[name].svg(results(), test="nobody") is None


def test_an_empty_matrix_is_refused_in_words() -> None:
    with pytest.raises(DataError, match="no matrix to plot"):
        matrix.of_rows([])
    with pytest.raises(DataError, match="has no column 'residual'"):
        data.numbers(errors(), "residual")
    with pytest.raises(DataError, match="does not hold numbers"):
        data.numbers(input_output(), "reason")


@pytest.mark.parametrize("size", [1e-12, 1.0, 1e12])
@pytest.mark.parametrize("count", [1, 2, 400])
@pytest.mark.parametrize("name", ["compensated", "input_output", "rate_error", "linearity", "dwells"])
def test_one_point_and_many_of_any_size_are_drawn(name: str, count: int, size: float) -> None:
    def resized(values: list[Any]) -> list[Any]:
        grown = (values * (count // len(values) + 1))[:count]
        return [v * size * (1 + i) if isinstance(v, float) else v for i, v in enumerate(grown)]

    found = figures()[name].svg(emptied(results(), resized) | {"verdicts": []})
    assert found is not None
    assert len(found) < 150_000


@given(st.lists(st.one_of(st.none(), st.floats(-1e300, 1e300), st.just(0.0)), min_size=1, max_size=12))
@settings(max_examples=30, deadline=None)
def test_any_rates_and_errors_can_be_drawn(values: list[float | None]) -> None:
    n = len(values)
    content = errors(
        rate=column([float(i) - 3.0 for i in range(n)], "deg/s"), error=column(values, "%"), lo=column([None] * n),
        hi=column([None] * n), u=column([None] * n), dof=column([None] * n),
    )  # fmt: skip
    found = figures()["rate_error"].svg({"curves": [content], "verdicts": []})
    assert (found is None) == all(value is None for value in values)


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=3000), st.integers(2, 200))
def test_thinning_keeps_the_extremes(values: list[float], most: int) -> None:
    kept = data.thinned(np.array(values), most)
    assert len(kept) <= max(most, 2)
    assert len(values) > most or len(kept) == len(values)
    assert {min(values), max(values)} <= {values[i] for i in kept}


def test_thousands_of_dwells_stay_a_small_file_and_the_legend_counts_them() -> None:
    n = 20_000
    content = input_output(
        applied=column([float(i % 100) for i in range(n)], "deg/s"),
        reading=column([float(i % 100) for i in range(n)], "deg/s"),
        residual=column([0.001 * ((i * 7919) % 101) for i in range(n)], "deg/s"),
        run=column([""] * n), group=column([""] * n), used=column([True] * n), reason=column([""] * n),
        place=column([""] * n),
    )  # fmt: skip
    svg = figures()["input_output"].svg({"curves": [content]})
    assert svg is not None
    assert len(svg) < 600_000
    assert "dwells used (20000), 1200 drawn" in svg


def test_rates_over_decades_get_decades_and_others_a_plain_axis() -> None:
    ax = Figure().subplots()
    assert signed_log(ax, "x", np.array([-5.0, -0.006, 0.0, 0.006, 5.0]))
    assert ax.get_xscale() == "symlog"
    assert 0.0 in ax.get_xticks()
    plain_axes = Figure().subplots()
    assert not signed_log(plain_axes, "x", np.array([-4.5, -0.5, 2e-5, 0.5, 4.5]))  # 2e-5 is earth rate at rest
    assert not signed_log(plain_axes, "x", np.array([np.nan, 0.0]))


# SVG


def poisoned(text: str) -> dict[str, Any]:
    """Results with a text in every place that a campaign can name."""
    content = results()
    for one in content["curves"]:
        one |= {"test": text, "recording": text, "of": text}
        for name, c in one["columns"].items():
            if name in {"reason", "run", "group", "place"} and not isinstance(c["values"][0], float | int):
                c["values"] = [text] * len(c["values"])
            elif c["unit"]:
                c["unit"] = text
    content["results"] = [
        *ROWS,
        *(one | {"test": text, "unit": text} for one in [*BESIDE, *THERMAL_ROWS, *SENSITIVITY_ROWS, *CHANGES]),
    ]
    content["sequence"] = [{"test": text, "against": text}]
    content["verdicts"] = [one | {"test": text, "requirement": text} for one in [*VERDICTS, *JUDGED]]
    content["budgets"] = [one | {"source": text, "quantity": text} for one in SHARES]
    content["closed_loop"] = {"axes": [LOOP["axes"][0] | {"axis": text, "unit": text}]}
    return content


@pytest.mark.parametrize(
    "text",
    [pytest.param(one, marks=pytest.mark.slow if i else []) for i, one in enumerate(sized(HOSTILE, HOSTILE[::4]))],
)
def test_hostile_texts_stay_texts(text: str) -> None:
    content = poisoned(text)
    for name, kind in figures().items():
        svg = kind.svg(content)
        assert svg is not None, name
        root = ET.fromstring(svg)
        tags = {element.tag.rpartition("}")[2] for element in root.iter()}
        assert tags <= {"svg", "title", "defs", "g", "path", "use", "text", "clipPath", "rect", "pattern", "marker"}
        for element in root.iter():
            assert not any(key.startswith("on") for key in element.attrib)
            assert element.attrib.get("href", "#").startswith("#")
            assert all("url(" not in value or "url(#" in value for key, value in element.attrib.items()
                       if key != "aria-label")  # fmt: skip
        assert svg.replace("\n", "").replace("\t", "").isprintable()


def test_a_dollar_does_not_reach_mathtext() -> None:
    svg = figures()["budget"].svg(poisoned("$x_1$"))
    assert svg is not None
    assert "$x_1$ (B)" in svg


@pytest.mark.parametrize("name", figures())
def test_an_svg_is_the_same_every_time_and_loads_nothing(name: str) -> None:
    one, other = figures()[name].svg(results()), figures()[name].svg(results())
    assert one == other
    assert one is not None
    assert one.startswith("<svg ")
    assert "<script" not in one
    assert "<style" not in one
    assert "<?xml" not in one
    assert "metadata" not in one
    assert [*re.findall(r"https?://[^\"'\s<]*", one)] == ["http://www.w3.org/2000/svg"]
    assert 'role="img"' in one
    assert 'viewBox="0 0 360 ' in one
    root = ET.fromstring(one)
    picture = figures()[name].pictures(results())[0]
    assert root.attrib["aria-label"] == picture.label
    assert root.find("{*}title") is None  # browsers would show it over the values of the marks


def test_no_two_figures_share_an_id_and_every_reference_finds_its_own() -> None:
    seen: set[str] = set()
    for name, kind in figures().items():
        for number, picture in enumerate(kind.pictures(results() | {"curves": [*results()["curves"], errors(), *[]]})):
            svg = to_svg(picture, prefix(picture, number))
            ids = re.findall(r'\bid="([^"]+)"', svg)
            assert len(ids) == len(set(ids)), name
            assert not seen & set(ids), name
            assert set(re.findall(r'url\(#([^)]+)\)|href="#([^"]+)"', svg)) <= {
                pair for one in ids for pair in ((one, ""), ("", one))
            }
            seen |= set(ids)
    assert seen


@pytest.mark.parametrize("name", figures())
def test_every_colour_of_a_page_is_a_variable(name: str) -> None:
    svg = figures()[name].svg(results())
    assert svg is not None
    outside = re.sub(r"var\(--fig-\w+, #[0-9a-f]{6}\)", "", svg)
    assert not re.findall(r"#[0-9a-f]{6}\b", outside)
    assert variables().count("--fig-") == variables(dark=True).count("--fig-") == len(ROLES)
    assert len({light for light, _ in ROLES.values()}) == len(ROLES)


@pytest.mark.parametrize("name", figures())
def test_labels_of_ticks_are_plain_text(name: str) -> None:
    svg = figures()[name].svg(results())
    assert svg is not None
    assert "mathdefault" not in svg  # a report shows text as it stands: no markup of powers


def contrast(one: str, other: str) -> float:
    """WCAG 2.2, 1.4.3: ratio of relative luminances."""

    def luminance(colour: str) -> float:
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
        return float(np.dot(linear, (0.2126, 0.7152, 0.0722)))

    high, low = sorted((luminance(one), luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("dark", [False, True])
def test_texts_can_be_read_in_light_and_dark(dark: bool) -> None:
    paper = ROLES["paper"][dark]
    for role in ("ink", "quiet"):
        assert contrast(ROLES[role][dark], paper) >= 4.5
    for role in ("blue", "green", "vermilion"):
        assert contrast(ROLES[role][dark], paper) >= 3.0


def test_names_are_cut_and_cleaned() -> None:
    assert plain("a\x1b\u202eb") == "a\N{REPLACEMENT CHARACTER}\N{REPLACEMENT CHARACTER}b"
    assert len(plain("x" * 100)) == 40
