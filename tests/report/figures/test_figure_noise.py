"""Figures of noise: the deviations and densities given, their intervals, every term, lines; decades on both axes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from inertialcal.report.figures import figures, on_new_figure
from inertialcal.report.figures.drawing.scales import label, log_axis
from inertialcal.report.figures.drawing.style import LINE
from inertialcal.report.figures.static_noise.spectrum import OVER
from written_rows import fields

TAU = [0.01 * 2.0**k for k in range(12)]
FREQUENCY = [0.1 * 2.0**k for k in range(9)]
WHITE, FLAT = 4e-3, 1e-3  # deg/s at 1 s; deg/s


def column(values: Any, unit: str = "") -> dict[str, Any]:
    return {"unit": unit, "values": list(values)}


def allan(axis: str, recording: str = "one", **changes: Any) -> dict[str, Any]:
    white = [WHITE / np.sqrt(tau) for tau in TAU]
    columns = {
        "tau": column(TAU, "s"), "deviation": column(white, "deg/s"), "lo": column([0.9 * d for d in white], "deg/s"),
        "hi": column([1.1 * d for d in white], "deg/s"), "edf": column([100.0] * 12), "noise": column([0.0] * 12),
        "expected": column(white, "deg/s"),
    }  # fmt: skip
    columns |= changes
    return {"name": "allan", "test": "still", "axis": axis, "of": "overlapping", "recording": recording,
            "columns": columns}  # fmt: skip


def allan_terms(axis: str) -> dict[str, Any]:
    white = [WHITE / np.sqrt(tau) for tau in TAU]
    columns = {
        "tau": column(TAU, "s"), "angle_random_walk": column(white, "deg/s"),
        "bias_instability": column([FLAT] * 12, "deg/s"),
        "all": column([float(np.hypot(d, FLAT)) for d in white], "deg/s"),
    }  # fmt: skip
    return {"name": "allan_terms", "test": "still", "axis": axis, "of": "overlapping", "columns": columns}


def spectrum(axis: str, recording: str = "one") -> dict[str, Any]:
    unit = "(deg/s)^2/Hz"
    columns = {
        "frequency": column(FREQUENCY, "Hz"), "density": column([3e-5] * 7 + [2e-3, 3e-5], unit),
        "lo": column([2e-5] * 9, unit), "hi": column([5e-5] * 9, unit), "line": column([False] * 7 + [True, False]),
        "angle_random_walk": column([3e-5] * 9, unit), "all": column([3e-5] * 9, unit),
    }  # fmt: skip
    return {"name": "spectrum", "test": "still", "axis": axis, "of": "welch", "recording": recording,
            "columns": columns}  # fmt: skip


def row(quantity: str, value: float, u: float, unit: str, condition: str = "") -> dict[str, Any]:
    return {"quantity": quantity, "axis": "z", "test": "still", **fields(condition), "value": value, "u": u,
            "unit": unit, "status": "estimated"}  # fmt: skip


ROWS = [
    row("angle_random_walk", 0.24, 0.01, "deg/sqrt(h)"), row("bias_instability", 9.3, 0.4, "deg/h"),
    row("angle_random_walk", 0.3, 0.02, "deg/sqrt(h)", "run one alone"),
    row("line_frequency", 12.8, 0.01, "Hz", "line at 12.8 Hz"),
]  # fmt: skip


def drawn(name: str, *curves: dict[str, Any]) -> tuple[Axes, str]:
    (picture,) = figures()[name].pictures({"curves": list(curves), "results": ROWS})
    return on_new_figure(picture, titled=False).axes[0], picture.finding


def lines_of(ax: Axes) -> dict[str, list[float]]:
    return {str(line.get_label()): np.asarray(line.get_ydata()).tolist() for line in ax.get_lines() if line.get_label()}


def test_the_allan_figure_draws_each_deviation_and_each_term() -> None:
    ax, finding = drawn("allan", allan("z"), allan_terms("z"))
    found = lines_of(ax)
    assert found["measured"] == allan("z")["columns"]["deviation"]["values"]
    assert found["angle random walk"] == allan_terms("z")["columns"]["angle_random_walk"]["values"]
    assert found["bias instability"] == [FLAT] * 12
    assert found["all terms"] == allan_terms("z")["columns"]["all"]["values"]
    assert finding == "z: angle random walk 0.240 ± 0.010 deg/sqrt(h), bias instability 9.30 ± 0.40 deg/h"
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    band = ax.collections[0].get_paths()[0].vertices
    assert np.isclose(np.max(np.asarray(band)[:, 1]), 1.1 * WHITE / np.sqrt(TAU[0]))


def test_several_records_have_marks_and_names_of_their_own() -> None:
    ax, _ = drawn("allan", allan("z"), allan("z", "two"), allan_terms("z"))
    assert {"one", "two"} <= set(lines_of(ax))
    markers = {line.get_marker() for line in ax.get_lines() if line.get_label() in ("one", "two")}
    assert len(markers) == 2


def test_terms_far_below_the_data_do_not_stretch_the_axis() -> None:
    terms = allan_terms("z")
    terms["columns"]["bias_instability"] = column([1e-12] * 12, "deg/s")
    ax, _ = drawn("allan", allan("z"), terms)
    assert ax.get_ylim()[0] > 1e-4


def test_the_spectrum_marks_lines_and_names_them() -> None:
    ax, finding = drawn("spectrum", spectrum("z"))
    found = lines_of(ax)
    assert found["measured"] == spectrum("z")["columns"]["density"]["values"]
    assert found["line"] == [pytest.approx(OVER * 2e-3)]
    assert finding == "z: line at 12.8 Hz"
    (other,) = figures()["spectrum"].pictures({"curves": [spectrum("x")], "results": ROWS})
    band = [spectrum("x")["columns"]["frequency"]["values"][at] for at in (0, -1)]
    assert other.finding == f"x: no line found from {band[0]:g} to {band[1]:g} Hz"


def test_a_line_is_marked_at_its_frequency_and_a_broad_peak_once() -> None:
    """Bands are wide: their centres are not where lines are, and a peak takes several."""
    marked = spectrum("z")
    marked["columns"]["line"] = column([False, False, True, True, True, False, False, True, False])
    marked["columns"]["density"] = column([3e-5, 3e-5, 4e-5, 9e-5, 5e-5, 3e-5, 3e-5, 2e-3, 3e-5], "(deg/s)^2/Hz")
    rows = [
        row("line_frequency", 13.4, 0.01, "Hz", "line at 13.4 Hz"),
        row("line_frequency", 20.0, 0.1, "Hz", "line at 20 Hz"),
    ]
    (picture,) = figures()["spectrum"].pictures({"curves": [marked], "results": rows})
    ax = on_new_figure(picture, titled=False).axes[0]
    places = {str(line.get_label()): np.asarray(line.get_xdata()).tolist() for line in ax.get_lines()}
    assert places["line"] == [13.4, 20.0]
    assert places["broad peak"] == [FREQUENCY[3]]
    assert picture.finding == "z: lines at 13.4 and 20 Hz"


def ringing(axis: str, *frequencies: float) -> list[dict[str, Any]]:
    """Terms with lines: the Allan deviation of a sine of amplitude a is a sin^2(pi f tau) / (pi f tau)."""
    terms = allan_terms(axis)
    tau = np.geomspace(TAU[0], TAU[-1], 400)
    columns = {"tau": column(tau.tolist(), "s"), "angle_random_walk": column((WHITE / np.sqrt(tau)).tolist(), "deg/s")}
    lines = []
    for f in frequencies:
        deviation = (0.02 * np.sin(np.pi * f * tau) ** 2 / (np.pi * f * tau)).tolist()
        line = {"tau": columns["tau"], "deviation": column(deviation, "deg/s"), "frequency": column([f] * 400, "Hz")}
        lines.append(terms | {"name": "allan_line", "columns": line})
    return [terms | {"columns": columns | {"all": column(columns["angle_random_walk"]["values"], "deg/s")}}, *lines]


def test_of_lines_the_peaks_are_drawn_as_one_curve_that_does_not_ring() -> None:
    f = 9.97
    ax, _ = drawn("allan", allan("z"), *ringing("z", f))
    found = lines_of(ax)
    peaks = np.array(found["peaks of the 9.97 Hz line"])
    tau = np.geomspace(TAU[0], TAU[-1], 400)
    late = (tau > 1.0 / f) & (tau < 5.0 / f)
    np.testing.assert_allclose(peaks[late], 0.02 / (np.pi * f * tau[late]), rtol=0.03)
    assert np.all(np.diff(peaks[np.argmax(peaks) :]) < 0.0)
    assert found["all terms"] == allan("z")["columns"]["expected"]["values"]  # where it is compared with the data
    ax, _ = drawn("allan", allan("z"), *ringing("z", f, 20.61))
    assert "peaks of the lines" in lines_of(ax)


def test_a_single_term_is_drawn_once() -> None:
    terms = allan_terms("z")
    del terms["columns"]["bias_instability"]
    ax, _ = drawn("allan", allan("z"), terms)
    assert list(lines_of(ax)) == ["measured", "angle random walk"]


def test_a_finding_of_many_terms_takes_two_lines() -> None:
    more = [*ROWS, row("rate_random_walk", 29.1, 8.9, "deg/h/sqrt(h)"), row("gauss_markov_sigma", 60.9, 1.4, "deg/h")]
    (picture,) = figures()["allan"].pictures({"curves": [allan("z")], "results": more})
    assert picture.finding.endswith("bias instability 9.30 ± 0.40 deg/h, rate random walk, Gauss-Markov")
    assert len(picture.finding) <= 2 * LINE


def test_terms_that_do_not_hold_are_no_finding() -> None:
    doubt = "the terms do not explain the Allan deviation"
    rows = [one | {"reason": {"code": "in_doubt", "text": doubt}} for one in ROWS[:2]]
    (picture,) = figures()["allan"].pictures({"curves": [allan("z")], "results": rows})
    assert picture.finding == f"z: {doubt}"


def test_deviations_without_intervals_or_terms_are_drawn_alone() -> None:
    absent = column([None] * 12, "deg/s")
    ax, _ = drawn("allan", allan("z", lo=absent, hi=absent))
    assert list(lines_of(ax)) == ["measured"]
    assert not ax.collections
    assert figures()["allan"].pictures({"curves": [allan("z", deviation=column([0.0] * 12, "deg/s"))]}) == []


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (0.01, 1000.0, ["0.01", "0.1", "1", "10", "100", "1000"]),
        (0.9, 12.0, ["1", "2", "5", "10"]),
        (0.0012, 0.05, ["0.003", "0.01", "0.03"]),
        (0.011, 0.9, ["0.03", "0.1", "0.3"]),
        (5.1, 5.9, ["5.2", "5.4", "5.6", "5.8"]),
        (5.1e-6, 5.9e-6, ["5.2e−6", "5.4e−6", "5.6e−6", "5.8e−6"]),
        (1e-12, 1e-2, ["1e−12", "1e−10", "1e−8", "1e−6", "1e−4", "0.01"]),
    ],
)
def test_decades_are_labelled_and_where_there_are_few_what_lies_between(
    low: float, high: float, expected: list[str]
) -> None:
    ax = Figure().subplots()
    assert log_axis(ax, "x", np.array([low, high, np.nan, 0.0]))
    ticks = [tick for tick in ax.xaxis.get_majorticklocs() if low <= tick <= high * (1.0 + 1e-9)]
    assert [label(tick) for tick in ticks] == expected
    assert not log_axis(ax, "y", np.array([np.nan, 0.0]))


def test_every_axis_has_at_least_two_ticks() -> None:
    rng = np.random.default_rng(1)
    ax = Figure().subplots()
    for low, width in zip(10.0 ** rng.uniform(-9, 4, 60), 10.0 ** rng.uniform(-2, 1, 60), strict=True):
        log_axis(ax, "y", np.array([low, low * 10.0**width]))
        ticks = ax.yaxis.get_majorticklocs()
        assert 2 <= len(ticks) <= 9
        assert len({label(tick) for tick in ticks}) == len(ticks)


def test_equal_values_get_an_axis_around_them() -> None:
    ax = Figure().subplots()
    assert log_axis(ax, "y", np.array([3.0, 3.0]))
    low, high = ax.get_ylim()
    assert low < 3.0 < high
