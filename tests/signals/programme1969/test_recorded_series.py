"""The programme of 1969 on a series of a file: the figures of a deck of the same values; refusals."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_programme1969 import deck, drifting

import inertialcal as ic
from inertialcal.cli.__main__ import main
from inertialcal.core.errors import DataError, UsageError
from inertialcal.core.key import Method

REQUESTS = "   1\n   2\n   3\n   4\n  10\n   5\n   3\n   6\n"
WRONG = 41


def files(folder: Path) -> tuple[Path, Path]:
    """Write the same series as a deck and as a table, a wrong value in each."""
    x, tilt = drifting(1)
    x, tilt = np.insert(x, WRONG - 1, 99999), np.insert(tilt, WRONG - 1, 0)
    (folder / "deck.txt").write_text(deck(x, tilt, (WRONG,), REQUESTS))
    table = np.column_stack([100.0 * np.arange(len(x)), x, tilt])
    np.savetxt(folder / "run.csv", table, "%.6f", ",", header="time [s],pulses [count],tilt [uV]", comments="")
    return folder / "deck.txt", folder / "run.csv"


def figures(found: Any) -> list[tuple[str, float | None, str]]:
    return [(row.quantity, row.value, row.unit) for row in found.rows]


def test_a_table_gives_the_figures_of_a_deck(tmp_path: Path) -> None:
    cards, table = files(tmp_path)
    own: dict[str, Any] = {"column": "pulses", "tilt": "tilt", "amplitude": "23 ng", "wrong": [WRONG]}
    wanted = ic.programme_1969(cards)
    given: dict[str, Any]
    for given in ({"period": "400 s"}, {"half_period": 2}, {"sample_time": "100 s", "half_period": 2}):
        found = ic.programme_1969(table, **own, **given)
        assert figures(found) == figures(wanted)
        assert [c.columns["step"].values[0] for c in found.curves()] == ["pulses, none"] * 4


def test_an_array_and_a_recording(tmp_path: Path) -> None:
    _, table = files(tmp_path)
    recording = ic.read(table)
    one = ic.programme_1969(recording, column="pulses", wrong=[WRONG], half_period=2)
    values = np.asarray(recording.channel("pulses [count]").data, dtype=float)
    other = ic.programme_1969(values, sample_time="100 s", wrong=[WRONG], half_period=2)
    assert [row.value for row in one.rows] == [row.value for row in other.rows]
    assert other.rows[0].unit == "file unit"


def test_the_four_reductions_and_their_errors_are_named(tmp_path: Path) -> None:
    _, table = files(tmp_path)
    found = ic.programme_1969(table, column="pulses", period="400 s", wrong=[WRONG])
    names = [step.reduction for step in found.cases[0].steps]
    assert names == ["none", "straight line", "harmonics 10", "adjusted curve 3", "line and drift"]
    printed = " ".join(str(found).split())
    for words in ("here 1, are closed up", "has twice its amplitude", "takes 1.3 % of the line", "over the input amp"):
        assert words in printed
    assert len(found.cases[0].errors) == 4
    assert found.content()["programme_errors"]["case 1"] == list(found.cases[0].errors)


def test_the_centred_mean_is_what_the_adjusted_curve_removes(tmp_path: Path) -> None:
    x, _ = drifting(2)
    found = ic.programme_1969(x, sample_time="1 s", half_period=2, reductions=["adjusted curve 3"])
    removed = np.asarray(found.curves()[0].columns["removed"].values)
    weights = np.r_[0.5, np.ones(7), 0.5] / 8.0
    mean = np.convolve(x, weights, mode="valid")  # of the 92 samples whose window is full
    level = removed[4:96] - mean  # the mean that the analysis takes away as well
    assert np.ptp(level) < 1e-9
    assert abs(float(level[0])) < 5.0


def test_other_samples_a_cycle(tmp_path: Path) -> None:
    """A line of 3 in 6 samples a cycle, 240 samples: its amplitude by Fourier and by spectrum."""
    x = 3.0 * np.sin(2.0 * np.pi * np.arange(243) / 6.0)
    found = ic.programme_1969(x, sample_time="1 s", period="6 s", amplitude="2 ng", reductions=["none"])
    by_name = {row.quantity: row.value for row in found.rows if row.method is Method.TEXTBOOK}
    assert by_name["amplitude"] == pytest.approx(3.0, rel=1e-9)
    assert by_name["spectrum_amplitude"] == pytest.approx(3.0, rel=1e-2)
    assert by_name["scale_factor"] == pytest.approx(1.5e9, rel=1e-9)
    assert {one.code for one in found.remarks} == {"whole_cycles"}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"column": "pulses", "period": "450 s"}, "4.5 samples of 100 s"),
        ({"period": "400 s"}, "2 columns of numbers"),
        ({"column": "pulses", "period": "400 s", "half_period": 2}, "both are given"),
        ({"column": "pulses", "reductions": ["spline"]}, "There are: none, tilt trace"),
        ({"column": "pulses", "reductions": ["tilt trace"]}, "--tilt COLUMN"),
        ({"column": "pulses", "samples": 98}, "a multiple of 4"),
        ({"column": "pulses", "lags": 20, "lines": 40}, "no more lines than lags"),
        ({"column": "pulses", "wrong": [200]}, "The series has 1 to 101"),
        ({"column": "pulses", "amplitude": "0 ng"}, "above zero"),
        ({"column": "nothing"}, "no column 'nothing'"),
    ],
)
def test_refused(tmp_path: Path, given: dict[str, Any], message: str) -> None:
    _, table = files(tmp_path)
    with pytest.raises((DataError, UsageError), match=message):
        ic.programme_1969(table, **given)


def test_uneven_and_long_series_are_refused() -> None:
    rng = np.random.default_rng(1)
    with pytest.raises(DataError, match="4000 at most"):
        ic.programme_1969(rng.standard_normal(5000), sample_time="1 s")
    with pytest.raises(DataError, match="no sample time"):
        ic.programme_1969(rng.standard_normal(50), half_period=2)


def test_uneven_stamps(tmp_path: Path) -> None:
    t = np.arange(40.0) + 0.3 * (np.arange(40) % 2)
    np.savetxt(tmp_path / "a.csv", np.column_stack([t, t]), "%.3f", ",", header="time [s],a [ug]", comments="")
    with pytest.raises(DataError, match="inertialcal sine"):
        ic.programme_1969(tmp_path / "a.csv", column="a", half_period=2)


def test_intervals_of_the_right_column_hold_the_truth() -> None:
    """Drift that a reduction leaves counts: of 30 drifting series, each reduction holds 23 in 26 or more."""
    held: dict[str, int] = {}
    for seed in range(30):
        rng, i = np.random.default_rng(seed), np.arange(100)
        drift = 1700.0 + np.cumsum(rng.normal(0.0, 3.0, 100)) + 300.0 * (i / 100.0) ** 2
        x = np.round(drift + 23.0 * np.sin(np.pi / 2.0 * i) + rng.normal(0.0, 3.0, 100))
        for step in ic.programme_1969(x, sample_time="100 s", half_period=2).cases[0].steps:
            assert step.right.interval
            assert step.right.interval.lo is not None
            assert step.right.interval.hi is not None
            inside = step.right.interval.lo <= 23.0 <= step.right.interval.hi
            held[step.reduction] = held.get(step.reduction, 0) + inside
    assert len(held) == 5
    assert min(held.values()) >= 26


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, table = files(tmp_path)
    words = ["--column", "pulses", "--period", "400 s", "--amplitude", "23 ng", "--wrong", "41", "--reduction", "none"]

    def typed(*given: str) -> tuple[Any, str, str]:
        with pytest.raises(SystemExit) as left:
            main(["programme-1969", str(table), *given])
        return left.value.code, *capsys.readouterr()

    status, printed, _ = typed(*words, "--json")
    found = ic.programme_1969(
        table, column="pulses", period="400 s", amplitude="23 ng", wrong=[41], reductions=["none"]
    )
    assert (status, json.loads(printed)["results"]) == (0, [row.to_dict() for row in found.rows])
    assert typed(*words, "-o", str(tmp_path / "out"))[0] == 0
    assert (tmp_path / "out" / "programme_1969_correlation.csv").exists()
    status, _, error = typed()
    assert status == 3
    assert "--column COLUMN --half-period SAMPLES" in " ".join(error.split())
