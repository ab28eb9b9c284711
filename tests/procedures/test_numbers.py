"""Readings, quantities, models and results with numbers that nothing has, and readings without any sense.

Each ends in figures, in figures that are not estimated with a reason, or in a refusal with a name: no fault of ours, no
warning of a library.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import inertialcal as ic
from inertialcal.campaign.engine import whole
from inertialcal.campaign.engine.engine import computable
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.models.compensation import compensate
from inertialcal.core.errors import DataError, InertialcalError
from inertialcal.core.key import Key
from inertialcal.core.recording import Channel, Recording
from inertialcal.core.results import Interval, Row
from inertialcal.core.schema.checksum import CHECKSUM
from inertialcal.core.unit.magnitudes import LARGEST, SMALLEST, check_readings, check_sample_rate, is_possible
from inertialcal.files import read, read_table
from inertialcal.files.models.model_json import dump_model, parse_models
from inertialcal.sensors.model.sensor_model import SensorModel
from typed_commands import call, call_json
from written_rows import results_text, sealed_text

Array = NDArray[np.float64]
CODE = "impossible_value"
N = 300


def noise(n: int, seed: int = 1) -> Array:
    return np.random.default_rng(seed).normal(0.0, 0.1, n)


def ramp(n: int) -> Array:
    return 20.0 + np.interp(np.linspace(0.0, 1.0, n), [0.0, 0.08, 0.33, 0.75, 1.0], [0.0, 0.0, -40.0, 40.0, 0.0])


RATES = np.repeat([0.0, 5.0, -5.0, 10.0, -10.0, 20.0, -20.0, 0.0], 40)
WINDOWS = {"windows": ["2..140=0 deg", "160..298=180 deg"]}
HEAD = {axis: (100.0 * noise(N, seed) + 50.0, "ug") for seed, axis in enumerate("xyz")}
FACES = np.vstack([np.tile(sign * row, (60, 1)) for row in np.eye(3) for sign in (9.8, -9.8)])
FACES = FACES + 0.05 * np.column_stack([noise(360, seed) for seed in range(3)])
FACES += np.where(np.arange(360) % 60 < 8, 30.0 * noise(360), 0.0)[:, None]  # moved by hand
NOUNS: dict[str, tuple[Callable[..., Any], dict[str, tuple[Array, str]], float, dict[str, Any]]] = {
    "allan": (ic.allan, {"x": (noise(N), "deg/s")}, 10.0, {}),
    "psd": (ic.psd, {"x": (noise(N), "deg/s")}, 10.0, {}),
    "thermal": (ic.thermal, {"x": (noise(N), "deg/s"), "temperature": (ramp(N), "degC")}, 0.05, {}),
    "thermal_3": (ic.thermal, {"x": (noise(N), "deg/s"), "temperature": (ramp(N), "degC")}, 0.05, {"order": 3}),
    "sine": (ic.sine, {"x": (np.sin(np.arange(N) / 3.0) + noise(N), "ug")}, 1.0, {"period": "18.85 s"}),
    "rate_table": (
        ic.rate_table,
        {"rate": (RATES, "deg/s"), "x": (1.01 * RATES + noise(len(RATES)), "deg/s")},
        2.0,
        {"axis": "x", "applied": "rate", "columns": {"x": "x"}},
    ),
    "flip": (ic.flip, HEAD, 1.0, WINDOWS),
    "positions": (
        ic.positions, {f"acc_{axis}": (FACES[:, i], "m/s^2") for i, axis in enumerate("xyz")}, 10.0,
        {"gravity": "9.8 m/s2", "orientations": "x+,x-,y+,y-,z+,z-"},
    ),
}  # fmt: skip
STRUCTURES: dict[str, Callable[[Array], Array]] = {
    "constant": lambda v: np.full_like(v, 1.5),
    "zero": np.zeros_like,
    "two_values": lambda v: np.where(np.arange(len(v)) < len(v) // 2, v.min(), v.max()),
    "alternating": lambda v: np.where(np.arange(len(v)) % 2, v.min(), v.max()),
    "two_of_three": lambda v: np.where(np.arange(len(v)) % 3, v.min(), v.max()),
    "shuffled": lambda v: np.random.default_rng(0).permutation(v),
    "sorted": np.sort,
    "outlier": lambda v: np.where(np.arange(len(v)) == len(v) // 3, 1e25, v),
    "one_differs": lambda v: np.where(np.arange(len(v)) == len(v) // 2, v.max() + 1.0, v[0]),
    "last_bit": lambda v: np.where(np.arange(len(v)) % 2, 1.0, np.nextafter(1.0, 2.0)),
    "rounded": np.round,
    "mostly_missing": lambda v: np.where(np.arange(len(v)) % 10, np.nan, v),
    "one_left": lambda v: np.where(np.arange(len(v)) != len(v) // 2, np.nan, v),
    "large": lambda v: 1e27 * v,
    "small": lambda v: 1e-27 * v,
    "mixed": lambda v: v * 10.0 ** np.random.default_rng(0).integers(-25, 25, len(v)),
    **{f"first_{n}": (lambda v, n=n: v[:n]) for n in (1, 2, 3, 5, 10, 20, 40)},  # type: ignore[misc]
    **{f"thinned_{n}": (lambda v, n=n: v[:: max(len(v) // n, 1)]) for n in (3, 8, 20)},  # type: ignore[misc]
}  # fmt: skip


def survives(function: Callable[..., Any], recording: Recording, options: dict[str, Any]) -> None:
    """Assert figures, each a finite number or with a reason, or a refusal with a name, before the last resort."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            found = function(recording, **options)
        except InertialcalError as error:
            assert {"not_computable", "internal"}.isdisjoint(one.code for one in error.problems), error  # noqa: PT017
            return
        for row in found.rows:
            assert row.status == "not_estimated" or math.isfinite(row.value), row
            assert row.status != "not_estimated" or row.reason, row
        str(found)
    json.dumps([row.to_dict() for row in found.rows], allow_nan=False)


def recording_of(noun: str, change: Callable[[Array], Array], chosen: list[str]) -> Recording:
    """Return the readings of a noun with some columns changed."""
    _, columns, sample_rate, _ = NOUNS[noun]
    channels = []
    for name, (data, unit) in columns.items():
        quantity = "acc" if name.startswith("acc") else "temperature" if name == "temperature" else ""
        values = change(data) if name in chosen else data
        channels.append(Channel(name, values, unit, "header", name[-1] if name[-1] in "xyz" else "", quantity))
    time = np.arange(len(channels[0].data), dtype=np.int64) * round(1e9 / sample_rate)
    return Recording(tuple(channels), time, 1.0 / sample_rate)


@pytest.mark.parametrize("noun", NOUNS)
def test_readings_that_make_sense_give_figures(noun: str) -> None:
    found = NOUNS[noun][0](recording_of(noun, np.array, []), **NOUNS[noun][3])
    assert any(row.status == "estimated" for row in found.rows)


@pytest.mark.parametrize("structure", STRUCTURES)
@pytest.mark.parametrize("noun", NOUNS)
def test_readings_without_any_sense(noun: str, structure: str) -> None:
    columns = list(NOUNS[noun][1])
    alone = [] if structure.startswith(("first", "thinned")) else [[name] for name in columns]
    for chosen in [*alone, columns]:
        survives(NOUNS[noun][0], recording_of(noun, STRUCTURES[structure], chosen), NOUNS[noun][3])


# Magnitudes


@pytest.mark.parametrize(("factor", "words"), [("e160", "larger than 1e\\+30"), ("e-160", "no reading larger than")])
def test_readings_that_no_sensor_gives_are_refused_with_their_row(tmp_path: Path, factor: str, words: str) -> None:
    path = tmp_path / "a.csv"
    rows = [f"{i / 10},{1.5 + i % 7}{factor}" for i in range(300)]
    path.write_text("\n".join(["t_s,gyro_x [deg/s]", *rows]) + "\n")
    with pytest.raises(DataError, match=words) as caught:
        ic.allan(path)
    assert caught.value.problems[0].code == CODE
    assert caught.value.problems[0].where == f"{path}:2"
    with pytest.raises(DataError) as caught:
        read_table(path).numbers("gyro_x")
    assert (caught.value.problems[0].code, caught.value.problems[0].where) == (CODE, f"{path}:2")
    assert len(read(path)) == 300  # looked at, and converted, it may be


def test_a_head_whose_turns_are_searched_is_judged_first(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = [f"{i}," + ",".join(f"{x[i]}e160" for x, _ in HEAD.values()) for i in range(N)]
    path.write_text("\n".join(["t_s,x [ug],y [ug],z [ug]", *rows]) + "\n")
    with pytest.raises(DataError, match="larger than 1e\\+30") as caught:
        ic.flip(path)
    assert (caught.value.problems[0].code, caught.value.problems[0].where) == (CODE, f"{path}:2")


def test_an_array_is_judged_too() -> None:
    with pytest.raises(DataError) as caught:
        ic.allan(1e160 * noise(N), sample_rate=10.0, units={"": "deg/s"})
    assert caught.value.problems[0].code == CODE


def test_readings_that_a_sensor_gives() -> None:
    kept = [np.array([2**63 - 1, -(2**63)]), np.array([2.0**63]), np.zeros(3), np.full(3, np.nan), np.array([]),
            np.array([np.inf, 1.0]), np.array([1e-40, 1e-9]), np.array([LARGEST, SMALLEST])]  # fmt: skip
    for values in kept:
        check_readings("x", values, "count", str)


@pytest.mark.parametrize("number", [0.0, -0.0, 2.0**63, 1e-23, LARGEST, SMALLEST])
def test_eighth_powers_of_a_thousand_million_numbers_are_finite(number: float) -> None:
    assert is_possible(number)
    assert math.isfinite(1e9 * number**8)
    assert not number or math.isfinite(number**-8)


@pytest.mark.parametrize("rate", [0.0, -1.0, 1e-300, 1e300, math.nan, math.inf, 1e10, 1e-11])
def test_sample_rates_beyond_our_time(rate: float, tmp_path: Path) -> None:
    assert check_sample_rate(rate)
    path = tmp_path / "a.csv"
    path.write_text("gyro_x [deg/s]\n" + "1\n2\n" * 50)
    for given in (path, noise(N)):
        with pytest.raises(InertialcalError, match="a sample rate of") as caught:
            ic.allan(given, sample_rate=rate)
        assert caught.value.problems[0].code == "sample_rate"


@pytest.mark.parametrize("option", ["--tau=1e29 s", "--averaging=1e-9 s", "--relative-error=1e-300", "--tau=1e206 s"])
def test_settings_that_nobody_can_mean(option: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["t_s,gyro_x [deg/s]", *(f"{i / 10},{x}" for i, x in enumerate(noise(N)))]) + "\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert call(capsys, "allan", str(path), option)[0] in (0, 2, 3)


@pytest.mark.parametrize(
    ("clock", "code"),
    [
        ('stamp = "end", averaging = "1e30 s"', "averaging_time"), ('averaging = "-1 s"', "averaging_time"),
        ('interval = "0 s"', "wrong_value"), ('interval = "-1e-30 s"', "wrong_value"),
        ('interval = "1e30 s"', "clock_disagrees"),
    ],
)  # fmt: skip
def test_clocks_that_nothing_has(clock: str, code: str, tmp_path: Path) -> None:
    folder, path = tmp_path / "campaign", tmp_path / "a.csv"
    path.write_text("\n".join(["t_s,gyro_x [deg/s]", *(f"{i / 10},{x}" for i, x in enumerate(noise(N)))]) + "\n")
    ic.allan(path).write_campaign(folder)
    file = folder / "campaign.toml"
    file.write_text(file.read_text().replace("channels = {", f"clock = {{ {clock} }}\nchannels = {{"))
    with pytest.raises(InertialcalError) as caught:
        run(folder)
    assert caught.value.problems[0].code == code


@pytest.mark.parametrize(("interval", "fits"), [("0.1 s", True), ("0.3 s", False)])
def test_dwells_with_long_pauses_between_them_have_the_interval_that_is_stated(
    interval: str, fits: bool, tmp_path: Path
) -> None:
    """Sixteen samples, then a pause of as long: by the stamps alone it might be packets that came late."""
    folder, path = tmp_path / "campaign", tmp_path / "a.csv"
    times = np.concatenate([np.arange(16) * 0.1 + 3.3 * k for k in range(30)])
    rows = [f"{t:.1f},{x}" for t, x in zip(times, noise(len(times)), strict=True)]
    path.write_text("\n".join(["t_s,gyro_x [deg/s]", *rows]) + "\n")
    ic.allan(path).write_campaign(folder)
    file = folder / "campaign.toml"
    file.write_text(file.read_text().replace("channels = {", f'clock = {{ interval = "{interval}" }}\nchannels = {{'))
    if fits:
        assert run(folder, write=False).results["results"]
        return
    with pytest.raises(InertialcalError) as caught:
        run(folder)
    assert caught.value.problems[0].code == "clock_disagrees"


def test_a_temperature_that_leaves_its_start_with_the_first_sample() -> None:
    n = 4000
    temperature = np.interp(np.arange(n), np.linspace(0, n, 5), [20.0, 20.0, -20.0, 60.0, 20.0])
    temperature[:3] = [60.0, 0.0, 0.0]
    channels = (Channel("x", noise(n), "deg/s", "header", "x"),
                Channel("temperature", temperature, "degC", "header", "", "temperature"))  # fmt: skip
    survives(ic.thermal, Recording(channels, np.arange(n, dtype=np.int64) * 20 * 10**9, 20.0), {})


# Models and results that are read back


def model() -> dict[str, Any]:
    made = SensorModel("gyro", ("x", "y", "z"), np.ones(3), "rad/s", np.eye(3), np.full(3, 0.1),
                       temperature_range=(0.0, 30.0))  # fmt: skip
    content: dict[str, Any] = json.loads(dump_model(made))
    return content


HUGE = "1e400"  # which JSON takes for infinity


@pytest.mark.parametrize(
    ("key", "value", "named"),
    [
        ("temperature_range", "cold", "temperature_range"), ("temperature_range", [1.0], "temperature_range"),
        ("temperature_range", [0.0, 1e206], "temperature_range.1"), ("reference_pressure", 1e300, "reference_pressure"),
        ("axes", "x", "axes"), ("judged", 1, "judged"), ("item", {"serial": 3}, "item.serial"),
        ("provenance", {"bias_x": {"test": 1, "recordings": [], "source": ""}}, "provenance.bias_x.test"),
        ("output_unit", None, "output_unit"),
    ],
)  # fmt: skip
def test_a_model_is_refused_with_its_key(
    key: str, value: Any, named: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "model.json"
    content = model()
    content["models"][""][key] = value
    path.write_text(sealed_text(content))
    with pytest.raises(DataError, match=f"^{path}: models.{named}") as caught:
        parse_models(path.read_text(), str(path))
    assert caught.value.problems[0].code == "schema"
    for words in (("show", path), ("compare", path, path), ("export", path, "--to", "c", "-o", tmp_path / "a.c")):
        assert call_json(capsys, *map(str, words))["exit"] == 3


@pytest.mark.parametrize("number", [HUGE, "1e206", "1e40", '"text"', "true", "null"])
def test_numbers_of_a_model(number: str) -> None:
    text = sealed_text(model()).replace("0.1,", f"{number},")
    content = {name: part for name, part in json.loads(text).items() if name != CHECKSUM}
    if number != HUGE:
        text = sealed_text(content)
    with pytest.raises(DataError) as caught:
        parse_models(text)
    assert caught.value.problems[0].code in {"schema", "checksum", CODE}


def test_an_uncertainty_that_nothing_has(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [Row(Key("bias", "x"), 1.0, u, "deg/s").to_dict() for u in (1e206,)]
    path = tmp_path / "results.json"
    path.write_text(results_text(results=rows))
    found = call_json(capsys, "compare", str(path), str(path))
    assert found["exit"] == 3
    assert found["errors"][0]["what"].startswith("results.0.u: 1e+206 is not a number from")


IMUCAL = {
    "K_a": np.eye(3).tolist(), "R_a": np.eye(3).tolist(), "b_a": [0.0] * 3, "K_g": np.eye(3).tolist(),
    "R_g": np.eye(3).tolist(), "b_g": [0.0] * 3, "K_ga": np.zeros((3, 3)).tolist(), "acc_unit": "m/s^2",
    "gyr_unit": "deg/s", "from_acc_unit": "a.u.", "from_gyr_unit": "a.u.", "cal_type": "Ferraris",
    "_format_version": "2.0",
}  # fmt: skip


@pytest.mark.parametrize(
    ("value", "code"), [(10**400, "schema"), (1e206, CODE), (-1e-206, CODE), ("text", "schema"), ([1.0], "schema")]
)
def test_numbers_of_the_models_of_others(
    value: Any, code: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "imucal.json"
    path.write_text(json.dumps(IMUCAL | {"b_g": [0.0, 0.0, value]}))
    found = call_json(capsys, "show", f"{path}#gyro")
    assert found["exit"] == 3
    assert (found["errors"][0]["code"], found["errors"][0]["what"][:3]) == (code, "b_g")
    words = ["1", "0", "0", "0", "1", "0", "0", "0", "1", "1", "0", "0", "0", "1", "0", "0", "0", "1", "0", "0"]
    text = tmp_path / "gyro.txt"
    text.write_text(" ".join([*words, "1e206"]))
    found = call_json(capsys, "show", str(text))
    assert found["errors"][0]["code"] == CODE


def test_a_time_offset_of_kalibr_that_is_no_number(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "kalibr.yaml"
    square = "[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]"
    path.write_text(
        f"imu0:\n  accelerometers: {{M: {square}}}\n  gyroscopes: {{M: {square}, A: {square}, C_gyro_i: {square}}}\n"
        "  time_offset: late\n"
    )
    assert call_json(capsys, "show", f"{path}#gyro")["exit"] == 0


@pytest.mark.parametrize(("order", "reference"), [(1, 1e30), (20, 25.0)])
def test_a_polynomial_far_away_from_its_data_leaves_cells_empty(order: int, reference: float) -> None:
    of_temperature = {"bias_temperature": np.full((order, 3), 1e10), "reference_temperature": np.full(3, reference)}
    made = SensorModel("gyro", ("x", "y", "z"), np.ones(3), "rad/s", np.eye(3), np.zeros(3), **of_temperature)  # type: ignore[arg-type]
    channels = [Channel(axis, noise(N), "rad/s", "header", axis, "gyro") for axis in "xyz"]
    hot = np.where(np.arange(N) < 10, 1e29, reference)
    raw = Recording((*channels, Channel("temperature", hot, "degC", "header", "", "temperature")),
                    np.arange(N, dtype=np.int64) * 10**9, 1.0)  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        done = compensate(made, raw, temperature="temperature")
    x = done.array(["x", "y", "z"])
    assert np.isnan(x[:10]).all()
    assert np.isfinite(x[10:]).all()
    assert [(one.code, one.index) for one in done.remarks if one.code == "no_inverse"] == [("no_inverse", 0)]


# Figures and the last resort


@pytest.mark.parametrize(("value", "u"), [(math.nan, 0.1), (math.inf, None), (1.0, math.nan), (1.0, math.inf)])
def test_a_figure_that_is_not_finite_is_not_estimated(value: float, u: float | None) -> None:
    row = Row(Key("bias", "x"), value, u, "deg/s", interval=Interval(0.0, 1.0))
    assert (row.value, row.u, row.interval, row.status) == (None, None, None, "not_estimated")
    assert row.reason.code == "not_computable"


@pytest.mark.parametrize("error", [ZeroDivisionError, OverflowError, FloatingPointError, np.linalg.LinAlgError])
def test_arithmetic_that_breaks_down_refuses_the_test(error: type[Exception]) -> None:
    with pytest.raises(DataError, match="test 'a': its figures cannot be computed") as caught, computable("a"):
        raise error("singular")
    assert caught.value.problems[0].code == "not_computable"
    with pytest.raises(ValueError, match="a fault of ours"), computable("a"):
        raise ValueError("a fault of ours")


@pytest.mark.parametrize("broken", ["build_models", "results_content", "hold_out_residuals"])
def test_arithmetic_that_breaks_down_after_the_tests_refuses_the_campaign(
    broken: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, path = tmp_path / "campaign", tmp_path / "a.csv"
    path.write_text("\n".join(["t_s,gyro_x [deg/s]", *(f"{i / 10},{x}" for i, x in enumerate(noise(N)))]) + "\n")
    ic.allan(path).write_campaign(folder)

    def breaks(*_: object) -> None:
        raise FloatingPointError("overflow")

    monkeypatch.setattr(whole, broken, breaks)
    with pytest.raises(DataError, match=r"^campaign '.*': its figures cannot be computed"):
        run(folder)


def test_warnings_of_libraries_stay_off_the_screen() -> None:
    code = (
        "import sys, warnings, inertialcal.cli.__main__ as m\n"
        "m._status = lambda given: warnings.warn('overflow', RuntimeWarning) or 0\n"
        "sys.argv = ['inertialcal']\nm.entry()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stderr == ""
