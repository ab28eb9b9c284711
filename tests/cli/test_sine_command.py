"""`sine` on the command line and in Python: figures, upper limit, schedule, figure, one clear message for bad input."""

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import inertialcal as ic
from drift_scenarios import AMPLITUDE, SCENARIOS, STEP, N, drawn
from inertialcal.campaign.calls.call import Reduced
from inertialcal.core.errors import UsageError
from inertialcal.core.results import Row
from inertialcal.core.show.rows import case_name, reason_text
from inertialcal.physics.motion.schedule import repeated
from inertialcal.procedures.mass_attraction.schedule_csv import write_schedule
from inertialcal.report.figures import figures, on_new_figure
from typed_commands import call, call_json

SINE = np.tile([0.0, 1.0, 0.0, -1.0], N // 4)
APPLIED = 2.256e-7  # [m/s^2]: 23 ng
PERIOD = ("--period", "480 s")


def written(path: Path, values: NDArray[np.float64], step: float = STEP, start: float = 50.0) -> str:
    times = start + step * np.arange(len(values))
    table = np.column_stack([times, values])
    np.savetxt(path, table, "%.9g", ",", header="time [s],rate [1/s]", comments="")
    return str(path)


@pytest.fixture
def pulses(tmp_path: Path) -> str:
    return written(tmp_path / "pulses.csv", drawn(SCENARIOS["S2"], SINE, 1)[:, 0])


def scheduled(path: Path, cycles: int = 25) -> str:
    order = [0.286, 0.127, 0.286, 0.432]
    applied = [0.0, APPLIED, 0.0, -APPLIED]
    schedule = repeated(order, applied, cycles=cycles, dwell=100.0, move=20.0, drive="sine", u_applied=0.01)
    write_schedule(path, schedule)
    return str(path)


def of(found: Reduced, quantity: str) -> Row:
    return next(row for row in found.rows if row.quantity == quantity and row.case.plain)


def test_what_is_printed(capsys: pytest.CaptureFixture[str], pulses: str) -> None:
    status, out, _ = call(capsys, "sine", pulses, *PERIOD, "--phase", "0 deg")
    assert status == 0
    assert "x: sine of 480 s, phase known, 100 readings, 25 cycles" in out
    for word in ("amplitude", "quadrature", "noise_density", "(differences)", "(generalised)", "degrees of freedom"):
        assert word in out


def test_json_has_rows_curves_and_the_hash(capsys: pytest.CaptureFixture[str], pulses: str) -> None:
    content = call_json(capsys, "sine", pulses, *PERIOD, "--phase", "0 deg")
    rows = {row["quantity"]: row for row in content["results"] if not case_name(row)}
    interval = rows["amplitude"]["interval"]
    assert interval["lo"] < AMPLITUDE < interval["hi"]
    assert rows["quadrature"]["interval"]["lo"] < 0.0 < rows["quadrature"]["interval"]["hi"]
    assert len(content["inputs"][0]["sha256"]) == 64
    series, curve = ic.sine(pulses, period="480 s", phase="0 deg").results["curves"]
    assert (series["name"], curve["name"]) == ("sine_series", "sine_lines")
    lines = curve["columns"]
    assert lines["frequency"]["values"][lines["role"]["values"].index("drive")] == pytest.approx(1.0 / 480.0)


def test_phase_is_told_where_it_is_free(pulses: str) -> None:
    found = ic.sine(pulses, period="480 s")
    phase = of(found, "phase")
    assert phase.interval is not None
    assert phase.interval.lo < 0.0 < phase.interval.hi  # type: ignore[operator]
    turned = of(ic.sine(pulses, period="480 s", phase="180 deg"), "amplitude")
    straight = of(ic.sine(pulses, period="480 s", phase="0 deg"), "amplitude")
    assert turned.value == pytest.approx(-straight.value)  # type: ignore[operator]


@pytest.mark.parametrize("phase", [(), ("--phase", "0 deg")])
def test_nothing_found_is_an_upper_limit(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, phase: tuple[str, ...]
) -> None:
    file = written(tmp_path / "null.csv", drawn(SCENARIOS["S2"], SINE, 1, amplitude=0.0)[:, 0])
    content = call_json(capsys, "sine", file, *PERIOD, *phase)
    row = next(row for row in content["results"] if row["quantity"] == "amplitude")
    assert (row["status"], row["u"], row["interval"]["lo"]) == ("upper_limit", None, 0.0)
    assert 0.0 < row["value"] < 4.0 * 0.0702 * AMPLITUDE
    assert "below 3 times" in reason_text(row)


def test_schedule_gives_the_scale_factor(tmp_path: Path, pulses: str) -> None:
    found = ic.sine(pulses, schedule=scheduled(tmp_path / "order.csv"))
    scale, amplitude = of(found, "scale_factor"), of(found, "amplitude")
    assert scale.unit == "1/s/(m/s^2)"
    assert scale.value == pytest.approx(amplitude.value / APPLIED)  # type: ignore[operator]
    assert scale.u == pytest.approx(np.hypot(amplitude.u / APPLIED, 0.01 * scale.value))  # type: ignore[operator]
    own = amplitude.dof * (scale.u / (amplitude.u / APPLIED)) ** 4  # type: ignore[operator]
    assert scale.dof == pytest.approx(own)  # Welch and Satterthwaite: what was applied is known in size


def test_samples_of_a_dwell_are_averaged_and_those_of_a_move_left_out(tmp_path: Path) -> None:
    """Ten seconds a sample: ten in a dwell, two while the mass moves, which read nonsense."""
    rng = np.random.default_rng(1)
    dwell = np.concatenate([np.zeros(10), [50.0, -30.0]])
    values = (0.2 * SINE[:, None] + dwell + 0.01 * rng.standard_normal((N, 12))).ravel()[:-2]
    file = written(tmp_path / "fast.csv", values, step=10.0, start=5.0)
    found = ic.sine(file, schedule=scheduled(tmp_path / "order.csv"))
    amplitude = of(found, "amplitude")
    assert amplitude.value == pytest.approx(0.2, abs=4.0 * amplitude.u)  # type: ignore[operator]
    assert amplitude.u < 0.001  # type: ignore[operator]


def test_averaging_of_a_sine_is_put_back(tmp_path: Path) -> None:
    fine = np.sin(2 * np.pi * np.arange(48_000) / 480.0).reshape(-1, 120).mean(axis=1)
    rng = np.random.default_rng(1)
    file = written(tmp_path / "means.csv", fine + 1e-3 * rng.standard_normal(len(fine)))
    assert of(ic.sine(file, period="480 s"), "amplitude").value == pytest.approx(0.9003, abs=1e-3)
    found = ic.sine(file, period="480 s", averaging="120 s")
    assert of(found, "amplitude").value == pytest.approx(1.0, abs=1e-3)
    assert "9.97 % less of the drive, which is corrected" in str(found.remarks[-1])


def test_phase_is_that_of_the_record_also_where_its_first_reading_is_missing(tmp_path: Path) -> None:
    values = drawn(SCENARIOS["S0"], SINE, 1)[:, 0]
    values[0] = np.nan
    found = ic.sine(written(tmp_path / "late.csv", values), period="480 s", phase="0 deg")
    assert of(found, "amplitude").value == pytest.approx(AMPLITUDE, abs=0.04)
    assert of(found, "quadrature").value == pytest.approx(0.0, abs=0.04)


def test_remarks(tmp_path: Path, pulses: str) -> None:
    codes = [one.code for one in ic.sine(pulses, period="480 s", phase="40 deg").remarks]
    assert "phase" in codes
    values = drawn(SCENARIOS["S0"], SINE, 1)[:99, 0]
    values[[7, 8, 50]] = np.nan
    found = ic.sine(written(tmp_path / "gappy.csv", values), period="480 s", phase="0 deg")
    assert {"gaps", "whole_cycles"} <= {one.code for one in found.remarks}
    short = ic.sine(written(tmp_path / "short.csv", drawn(SCENARIOS["S0"], SINE, 1)[:32, 0]), period="480 s")
    assert "few_cycles" in {one.code for one in short.remarks}


def test_figure_is_drawn(capsys: pytest.CaptureFixture[str], tmp_path: Path, pulses: str) -> None:
    status, out, _ = call(capsys, "sine", pulses, *PERIOD, "--phase", "0 deg", "-o", str(tmp_path / "f.svg"))
    assert (status, (tmp_path / "f.svg").stat().st_size > 10_000) == (0, True)
    assert "written: " in out
    found = ic.sine(pulses, period="480 s", phase="0 deg")
    (picture,) = figures()["sine"].pictures(found.results)
    assert picture.finding.startswith("x: amplitude 0.2")
    axes = on_new_figure(picture, titled=True).axes
    labels = [line.get_label() for line in axes[2].get_lines()]
    assert [name for name in labels if not str(name).startswith("_")] == [
        "other lines",
        "neighbours",
        "the drive",
    ]
    assert figures()["sine"].pictures({"curves": []}) == []


def test_a_long_record_is_thinned_in_curves(tmp_path: Path) -> None:
    x = np.sin(2 * np.pi * np.arange(20_000) / 50.0) + np.random.default_rng(1).standard_normal(20_000)
    found = ic.sine(x, period="50 s", sample_rate=1.0, units={"g": "g"})
    series = found.results["curves"][0]["columns"]
    assert len(series["time"]["values"]) <= 4000
    assert of(found, "amplitude").value == pytest.approx(1.0, abs=0.05)
    assert json.dumps(found.results)


def test_printed_in_python(pulses: str) -> None:
    found = ic.sine(pulses, period="480 s")
    assert "degrees of freedom" in str(found)
    assert list(found.to_frame()["quantity"])[:2] == ["amplitude", "phase"]
    assert "<table" in found._repr_html_()


BAD = {
    "neither": ((), 2, "neither is given"),
    "both": ((*PERIOD, "--schedule", "order.csv"), 2, "both are given"),
    "no unit": (("--period", "480"), 2, "no unit"),
    "phase and schedule": (("--schedule", "order.csv", "--phase", "0 deg"), 2, "the schedule has the phase"),
    "negative": (("--period", "-1 s"), 3, "It must be positive"),
    "too long": (("--period", "20000 s"), 3, "it is shorter than one period"),
    "few cycles": (("--period", "5000 s"), 3, "2.4 cycles"),
    "nyquist": (("--period", "240 s"), 3, "amplitude and phase cannot be separated"),
    "faster": (("--period", "150 s"), 3, "above half the sampling frequency"),
    "no column": ((*PERIOD, "--column", "wx"), 3, "no column 'wx'"),
    "schedule": (("--schedule", "short.csv"), 3, "they are not of one run"),
    "averaging": ((*PERIOD, "--averaging", "480 s"), 3, "samples are 120 s apart"),
}


@pytest.mark.parametrize("case", BAD)
def test_refused_with_one_clear_message(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, pulses: str, case: str
) -> None:
    monkeypatch.chdir(tmp_path)
    scheduled(Path("order.csv"))
    scheduled(Path("short.csv"), cycles=20)
    words, status, message = BAD[case]
    got, out, err = call(capsys, "sine", pulses, *words)
    assert (got, out) == (status, "")
    assert message in " ".join(err.split())


def test_other_files_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    values = drawn(SCENARIOS["S0"], SINE, 1)[:, 0]
    gone = np.where(np.arange(N) % 3 == 0, values, np.nan)
    assert "66 of 100 samples" in call(capsys, "sine", written(tmp_path / "g.csv", gone), *PERIOD)[2]
    (tmp_path / "two.csv").write_text("a [g],b [g]\n" + "1,2\n" * 30)
    assert "Add: --column x=COLUMN" in call(capsys, "sine", str(tmp_path / "two.csv"), *PERIOD)[2]
    assert "the file has no time" in call(capsys, "sine", str(tmp_path / "two.csv"), *PERIOD, "--column", "a")[2]
    with pytest.raises(UsageError, match="neither is given"):
        ic.sine(values, sample_rate=1.0)
