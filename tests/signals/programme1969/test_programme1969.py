"""The programme of 1969 against loops written from its description, and against what its report says of it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import slow_programme as slow
from numpy.typing import NDArray

import inertialcal as ic
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError
from inertialcal.core.key import Method
from inertialcal.signals.programme1969.cards import (
    MeasuredCase,
    SyntheticCase,
    closed_up_series,
    read_cards,
    series_with_gaps,
)
from inertialcal.signals.programme1969.programme import (
    adjusted_curve,
    analyse,
    run_case,
    scale_factor,
    straight_line,
    tilt_trace,
    without_harmonics,
)

Array = NDArray[np.float64]
TIGHT: dict[str, Any] = {"rtol": 0.0, "atol": 1e-9}
SINE = 23.0 * np.tile([0.0, 1.0, 0.0, -1.0], 25)


def card(*fields: tuple[int, int]) -> str:
    return "".join(f"{value:>{width}}" for value, width in fields)


def synthetic_card(LXS: int = 23, KXS: int = 2, LXC: int = 40, KXC: int = 50, LY: int = 7, KY: int = 3) -> str:
    four = [(100, 4), (100, 4), (60, 4), (50, 4)]
    return card(*four, (LXS, 8), (KXS, 4), (LXC, 8), (KXC, 4), (LY, 8), (KY, 4), (4, 4))


def drifting(seed: int) -> tuple[Array, Array]:
    """Whole impulses with a signal of 23, drift of hundreds and a tilt trace with a mean."""
    rng, i = np.random.default_rng(seed), np.arange(100)
    walk = np.cumsum(rng.normal(0.0, 20.0, 100)) + 300.0 * (i / 100.0) ** 2
    tilt = np.round(500.0 + np.cumsum(rng.normal(0.0, 30.0, 100)))
    return np.round(1700.0 + SINE + walk + 0.05 * tilt + rng.normal(0.0, 6.0, 100)), tilt


def deck(x: Array, tilt: Array, wrong: tuple[int, ...] = (), requests: str = "   1\n   6\n") -> str:
    values = [x.astype(int).tolist(), tilt.astype(int).tolist()]
    head = card(*[(v, 4) for v in (100, 100, len(x), 23, len(wrong), 60, 50, 4, 7, 12)])
    forms = ((3, 6, 1), (2, 8, 1))
    series = [
        "".join(" " * skip + f"{value:>{width}}" + " " * after for value in one[at : at + 5])
        for one, (skip, width, after) in zip(values, forms, strict=True)
        for at in range(0, len(one), 5)
    ]
    return "\n".join(["   0", head, *series, *[f"{at:4d}" for at in wrong], requests + "  -1\n"])


def check_analysis(X: list[float], Y: list[float], found: Any) -> None:
    """Every printed number of an analysis, by loops, to 1e-9 of the largest of its kind."""
    X, Y = slow.means_removed(X), slow.means_removed(Y)
    R = [slow.correlation(X, X, lag) for lag in range(61)]
    A, B = slow.fourier(X)
    raw = slow.density(R, 50, 100.0)
    smooth, bandwidth = slow.smoothed(raw), 1.0 / (50 * 100.0)
    pairs = {
        "x": X, "correlation_x": R, "cosine": A, "sine": B, "density": raw[1:], "smoothed": smooth,
        "correlation_y": [slow.correlation(Y, Y, lag) for lag in range(61)],
        "cross": [slow.correlation(X, Y, lag) for lag in range(61)],
        "amplitude": [(bandwidth * abs(g)) ** 0.5 for g in raw[1:]],
        "smoothed_amplitude": [(2.0 * bandwidth * abs(g)) ** 0.5 for g in smooth],
        "line": [float(np.hypot(a, b)) for a, b in zip(A, B, strict=True)],
        "normalised_x": [r / R[0] for r in R], "std_x": R[0] ** 0.5,
    }  # fmt: skip
    for name, wanted in pairs.items():
        size = float(np.max(np.abs(wanted)))
        atol = 1e-9 * size if name != "amplitude" else 1e-7 * size  # a root near zero
        np.testing.assert_allclose(getattr(found, name), wanted, rtol=0.0, atol=atol, err_msg=name)


def test_synthetic_mode_to_1e9_of_loops() -> None:
    (case,) = read_cards("   1\n" + synthetic_card() + "\n   1\n   2\n   3\n   4\n  10\n   5\n   3\n   6\n  -1\n")
    assert isinstance(case, SyntheticCase)
    x, tilt = series_with_gaps(case)
    i = np.arange(100)
    np.testing.assert_allclose(x, 23.0 * np.sin(np.pi / 2 * i) + 40.0 * np.cos(np.pi / 50 * i), **TIGHT)
    check_case(case, list(x), list(tilt))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_series_with_drift_to_1e9_of_loops(seed: int) -> None:
    x, tilt = drifting(seed)
    (case,) = read_cards(deck(x, tilt, requests="   1\n   2\n   3\n   4\n  10\n   5\n   3\n   6\n"))
    assert isinstance(case, MeasuredCase)
    check_case(case, list(x), list(tilt))


def check_case(case: SyntheticCase | MeasuredCase, x: list[float], tilt: list[float]) -> None:
    AX = slow.means_removed(x)
    line = slow.straight_line(AX)
    wanted = [AX, slow.tilt_trace(AX, tilt), line, slow.harmonics(slow.means_removed(line), 10),
              slow.adjusted_curve(AX, 3)]  # fmt: skip
    steps = run_case(case)
    assert [step.request.what for step in steps] == [1, 2, 3, 4, 5]
    for step, X in zip(steps, wanted, strict=True):
        check_analysis(X, tilt, step.analysis)


def test_a_sine_alone_has_its_amplitude_on_line_25_and_nothing_beside() -> None:
    """Closed form: G(25) is the amplitude, its neighbours are zero, B(25) too, A(25) is zero."""
    found = analyse(SINE, SINE, 100.0, 50, 50)
    assert found.amplitude[24] == pytest.approx(23.0, abs=1e-9)
    assert np.abs(found.density[[23, 25]]).max() < 1e-9 * found.density[24]
    assert (found.sine[24], found.cosine[24]) == pytest.approx((23.0, 0.0), abs=1e-9)
    scale = scale_factor(found, 23.0)
    assert scale.fourier == pytest.approx(1e9)
    assert (scale.spectrum, scale.std) == pytest.approx((1e9, 0.0), abs=1e-3)


def test_the_sign_of_the_sine_is_kept() -> None:
    assert analyse(-SINE, SINE, 100.0, 50, 50).sine[24] == pytest.approx(-23.0)


def test_error_of_the_scale_factor_is_the_scatter_of_the_data() -> None:
    """As the listing prints it: 5.59e-2 pps over 23 ng is 0.243e7 pps/g."""
    rest = 5.59e-2 * np.sqrt(2.0) * np.sin(2 * np.pi * 7 / 100 * np.arange(100))
    scale = scale_factor(analyse(0.01 * SINE + rest, SINE, 100.0, 50, 50), 23.0)
    assert (scale.std, scale.error) == pytest.approx((5.59e-2, 0.243e7), rel=1e-3)


def test_moving_mean_takes_some_of_the_line() -> None:
    """B(25) of a pure sine falls by 2/3 of 1/50, from the eight points at the ends: 22.693 of 23."""
    found = analyse(adjusted_curve(SINE, 3), SINE, 100.0, 50, 50)
    assert found.sine[24] == pytest.approx(23.0 * (1.0 - 2.0 / 150.0), abs=1e-9)
    assert found.sine[24] == pytest.approx(22.693, abs=6e-4)
    np.testing.assert_allclose(adjusted_curve(SINE, 3)[4:96], SINE[4:96], **TIGHT)


def test_the_highest_line_turns_its_sign() -> None:
    highest = np.tile([1.0, -1.0], 50)
    np.testing.assert_allclose(without_harmonics(highest, 10), -highest, **TIGHT)


def test_lines_and_tilt_are_taken_out() -> None:
    i = np.arange(100.0)
    np.testing.assert_allclose(straight_line(3.0 * i - 7.0), 0.0, **TIGHT)
    np.testing.assert_allclose(tilt_trace(2.5 * SINE, SINE), 0.0, **TIGHT)
    low = np.cos(2 * np.pi * 3 / 100 * i)
    np.testing.assert_allclose(without_harmonics(low + SINE, 10), SINE, **TIGHT)


def test_closing_up_shifts_what_follows() -> None:
    """Positions count in the series as shortened so far: 3 and then 3 are the third and the fourth value."""
    counting = np.arange(1.0, 105.0)
    for wrong in ((3, 3), (4, 3)):
        (case,) = read_cards(deck(counting, counting, wrong=wrong))
        np.testing.assert_array_equal(closed_up_series(case)[0], np.r_[1, 2, 5:103])
        gaps, tilt = series_with_gaps(case)
        np.testing.assert_array_equal(np.flatnonzero(np.isnan(gaps)), [2, 3])
        np.testing.assert_array_equal(tilt[4:], np.arange(5, 103))
    (case,) = read_cards(deck(1000.0 * np.tile([0.0, 1.0, 0.0, -1.0], 26), counting, wrong=(51,)))
    (step,) = run_case(case)
    assert step.analysis.sine[24] < 600.0  # half of the record is a quarter of a period ahead


def test_wrong_positions_of_a_deck_are_closed_up() -> None:
    x, tilt = drifting(4)
    with_wrong = [np.insert(one, (10, 40), 99999 if one is x else 0) for one in (x, tilt)]
    (case,) = read_cards(deck(with_wrong[0], with_wrong[1], wrong=(11, 41)))
    (step,) = run_case(case)
    check_analysis(list(x), list(tilt), step.analysis)


REQUESTS = "   1\n   2\n   3\n   4\n  10\n   5\n   3\n   6\n"


def test_a_deck_of_one_case_is_a_recording(tmp_path: Path) -> None:
    x, tilt = drifting(1)
    path = tmp_path / "run1.cards"
    path.write_text(deck(np.insert(x, 10, 99999), np.insert(tilt, 10, 0), wrong=(11,)))
    found = ic.read(path)
    np.testing.assert_array_equal(found.channel("accelerometer").data, np.insert(x, 10, np.nan))
    np.testing.assert_array_equal(found.channel("tilt").data, np.insert(tilt, 10, np.nan))
    assert (found.channel("accelerometer").unit, found.sample_interval) == ("count", 100.0)
    assert "wrong_values" in {one.code for one in found.remarks}
    path.write_text(deck(x, tilt).removesuffix("  -1\n") + "   1\n" + synthetic_card() + "\n   6\n  -1\n")
    with pytest.raises(DataError, match="2 cases in one deck"):
        ic.read(path)
    path.write_text("  0 \n")
    with pytest.raises(DataError, match=r"run1.cards:1: columns 1-4, KT: cannot read '  0 '"):
        ic.read(path)


def test_the_programme_and_the_same_reductions_done_right(tmp_path: Path) -> None:
    """A wrong value costs the programme most of the line; with the gap kept every interval holds it."""
    x, tilt = drifting(2)
    x, tilt = np.append(x + 9.0 * SINE, x[-1]), np.append(tilt, tilt[-1])
    x[50] = 99999
    path = tmp_path / "deck.txt"
    path.write_text(
        deck(x, tilt, (51,), REQUESTS).removesuffix("  -1\n") + f"   1\n{synthetic_card()}\n{REQUESTS}  -1\n"
    )
    found = ic.programme_1969(path)
    (case, own) = read_cards(path.read_text())
    printed = [row for row in found.rows if row.method is Method.TEXTBOOK and row.quantity == "amplitude"]
    steps = [*run_case(case), *run_case(own)]
    assert [row.value for row in printed] == pytest.approx([step.analysis.sine[24] for step in steps])
    right = {str(row.member): row for row in found.rows if row.method is Method.RESULT}
    assert right["case 1, harmonics 10"].reason.text == "1 of 101 samples are missing"
    for name in ("adjusted curve 3", "line and drift"):
        row = right[f"case 1, {name}"]
        assert row.value is not None
        assert row.u is not None
        assert abs(row.value - 230.0) < 4.0 * row.u
        assert row.u < 10.0
    assert all(value is not None and value < 140.0 for value in [row.value for row in printed[:5]])
    assert right["case 2, line and drift"].value == pytest.approx(23.0, abs=1e-4)
    assert len(found.curves()) == 4
    assert len(set(found.curves()[0].columns["step"].values)) == len(steps)
    assert [row.status for row in found.rows if row.quantity == "scale_factor"] == ["estimated"] * 5 + [
        "not_estimated"
    ] * 5
    assert "adjusted curve 3" in str(found)
    assert "<table" in found._repr_html_()
    assert len(found.to_frame()) == len(found.rows)


def test_curves_of_a_deck_are_the_analysis(tmp_path: Path) -> None:
    x, tilt = drifting(3)
    path = tmp_path / "deck.txt"
    path.write_text(deck(x, tilt))
    curves = {one.name.removeprefix("programme_1969_"): one.columns for one in ic.programme_1969(path).curves()}
    (step,) = run_case(read_cards(path.read_text())[0])
    cross = np.asarray(curves["correlation"]["cross"].values)
    assert cross == pytest.approx(step.analysis.cross / (step.analysis.std_x * step.analysis.std_y))
    assert np.asarray(curves["correlation"]["lag"].values)[[0, -1]] == pytest.approx([0.0, 6000.0])
    assert np.asarray(curves["spectrum"]["frequency"].values)[24] == pytest.approx(1.0 / 400.0)
    assert np.asarray(curves["lines"]["frequency"].values)[24] == pytest.approx(1.0 / 400.0)
    assert np.asarray(curves["lines"]["amplitude"].values) == pytest.approx(step.analysis.line)


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    x, tilt = drifting(1)
    path = tmp_path / "deck.txt"
    path.write_text(deck(x, tilt))

    def typed(*given: str) -> tuple[Any, str, str]:
        with pytest.raises(SystemExit) as left:
            main(["programme-1969", str(path), *given])
        return left.value.code, *capsys.readouterr()

    assert typed() == (0, f"{ic.programme_1969(path)}\n", "")
    status, printed, _ = typed("--json")
    assert (status, json.loads(printed)["results"]) == (0, [row.to_dict() for row in ic.programme_1969(path).rows])
    assert typed("--quiet") == (0, "", "")
    status, printed, _ = typed("-o", str(tmp_path / "out"))
    assert (status, printed.count("written: ")) == (0, 4)
    head, first, *rest = (tmp_path / "out" / "programme_1969_correlation.csv").read_text().splitlines()
    assert head == "step,lag [s],accelerometer [1],tilt [1],cross [1]"
    assert first.startswith('"case 1, none",0.0,1.0,1.0,')
    assert len(rest) == 60
    assert typed("-o", str(path))[0] == 3
    path.write_text("  -1\n")
    status, _, refused = typed()
    assert status == 3
    assert "the deck has no cases" in refused


def test_a_reduction_that_takes_the_line_away_has_no_amplitude(tmp_path: Path) -> None:
    x, tilt = drifting(1)
    path = tmp_path / "deck.txt"
    path.write_text(deck(x, tilt, requests="   4\n  24\n   5\n   2\n   6\n"))
    rows = [row for row in ic.programme_1969(path).rows if row.method is Method.RESULT]
    assert [row.status for row in rows] == ["not_estimated", "not_estimated", "estimated"]
    assert "no_line" in {row.reason.code for row in rows}
    assert rows[1].reason.text == "a moving mean over 6 samples, 4 samples a cycle"


@pytest.mark.parametrize(
    ("cards", "words"),
    [
        ("", "the deck ends where a card with KT is needed"),
        ("   0\n 100 100 601", "ML = 601. The programme takes 0 to 600"),
        ("   0\n  10 100   5", "5 values less 0 wrong ones are fewer than the 10 used"),
        ("   0\n   1 100   1\n      12.5", "columns 4-9, AX: cannot read '   12.'"),
        ("   0\n   1 100   1\n", "the deck ends where a card with values of AX is needed"),
        ("   1\n" + synthetic_card(KXS=0) + "\n", "KXS = 0: half period shorter than a sample"),
        ("   1\n" + synthetic_card() + "\n   7\n", "request 7. There are 1 to 6"),
        ("  -1\n", "the deck has no cases"),
    ],
)
def test_bad_decks(cards: str, words: str) -> None:
    with pytest.raises(DataError) as refused:
        read_cards(cards)
    assert words in str(refused.value)
    assert refused.value.problems[0].code == "bad_card"


def test_what_the_analysis_refuses() -> None:
    with pytest.raises(DataError, match="51 lines of 50 lags"):
        analyse(SINE, SINE, 100.0, 50, 51)
    with pytest.raises(DataError, match="the same even length"):
        analyse(SINE[:99], SINE[:99], 100.0, 50, 50)
    found = analyse(SINE[:98], SINE[:98], 100.0, 40, 40)
    with pytest.raises(DataError, match="98 samples and 40 lines, 4 samples a cycle"):
        scale_factor(found, 23.0)
    with pytest.raises(DataError, match="an input amplitude of 0"):
        scale_factor(analyse(SINE, SINE, 100.0, 50, 50), 0.0)
    with pytest.raises(DataError, match="zero throughout"):
        tilt_trace(SINE, np.zeros(100))
    with pytest.raises(DataError, match="half width 60"):
        adjusted_curve(SINE, 60)
    with pytest.raises(DataError, match="50 lines of 100 samples"):
        without_harmonics(SINE, 50)
