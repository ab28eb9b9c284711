"""survey: what info shows of recordings that were made for it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.campaign.start.info import info as survey
from inertialcal.core.estimate import Array
from inertialcal.files.info.survey import Survey

N = 4000
RNG = np.random.default_rng(21)
STEP = 1 / 131


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "a recording.csv"


def write(path: Path, **columns: Any) -> Path:
    rows = zip(*columns.values(), strict=True)
    path.write_text(",".join(columns) + "\n" + "\n".join(",".join(f"{v!s}" for v in row) for row in rows))
    return path


def rest(n: int = N) -> dict[str, Array]:
    """Gyro at rest in codes of 1/131, accelerometer in g."""
    gyro = {f"gyro_{axis}": np.round(RNG.normal(0.3, 0.1, n) / STEP) * STEP for axis in "xyz"}
    acc = {f"acc_{axis}": RNG.normal(level, 0.004, n) for axis, level in zip("xyz", (0.02, -0.01, 1.01), strict=True)}
    return gyro | acc


def codes(found: Survey) -> list[str]:
    return [remark.code for remark in found.remarks]


def test_a_sound_recording(file: Path) -> None:
    columns = rest()
    found = survey(write(file, **{"t_s": np.arange(N) / 100}, **columns), units={"gyro": "deg/s", "acc": "g"})
    assert found.rows == N
    assert found.time.sample_rate == pytest.approx(100.0)
    assert found.time.start == "0 s"
    assert codes(found) == []
    assert found.hints == ()
    assert found.next is None
    for channel in found.channels:
        values = columns[channel.name]
        assert (channel.minimum, channel.maximum) == (values.min(), values.max())
        assert channel.mean == pytest.approx(values.mean(), abs=1e-12)
        assert channel.std == pytest.approx(values.std(ddof=1))
        assert channel.missing == 0
        assert channel.screening.codes == ()
    assert found.channels[0].resolution == pytest.approx(STEP)
    assert found.channels[3].resolution is None


def test_the_next_command_is_one_of_those_there_are(file: Path) -> None:
    write(file, **{"t_s": np.arange(N) / 100}, **rest())
    known = {"gyro": "deg/s", "acc": "g"}
    path, said = f"'{file}'", "--unit gyro=deg/s --unit acc=g"
    assert survey(file, units=known, commands=["info", "allan", "psd"]).next == f"inertialcal allan {path} {said}"
    assert survey(file, units=known, commands=["info", "psd"]).next == f"inertialcal psd {path} {said}"
    assert survey(file, units=known, commands=["init"]).next == f"inertialcal init {file.parent}"
    asked = f"inertialcal info {path} {said}"
    assert survey(file, commands=["info", "allan"]).next == asked
    assert survey(file, commands=["allan"]).next is None


def test_a_recording_of_a_campaign_leads_to_its_run(tmp_path: Path) -> None:
    """Its campaign file says the units: `info` need not be told them."""
    (tmp_path / "recordings").mkdir()
    path = write(tmp_path / "recordings/one.csv", **{"t_s": np.arange(N) / 100}, **rest())
    assert survey(path, commands=["info", "run"]).next != f"inertialcal run {tmp_path}"
    (tmp_path / "campaign.toml").write_text("", encoding="utf-8")
    assert survey(path, commands=["info", "run"]).next == f"inertialcal run {tmp_path}"


def test_what_a_flip_takes_leads_to_it(tmp_path: Path) -> None:
    means = write(tmp_path / "means.csv", **{
        "axis": "yz", "orientation": ["forward"] * 2, "time": [1, 1], "mean [ug]": [973.77, -1249.69]})  # fmt: skip
    assert survey(means, commands=["info", "flip"]).next == f"inertialcal flip {means}"
    assert survey(means, commands=["info"]).next != f"inertialcal flip {means}"
    time = {"t_s": np.arange(N) / 100}
    floats = {f"{axis} [g]": RNG.normal(1e-3, 1e-6, N) for axis in "xyz"}
    head = write(tmp_path / "head.csv", **time, **floats)
    assert survey(head, commands=["info", "flip", "microgravity"]).next == f"inertialcal microgravity {head}"
    ground = write(tmp_path / "ground.csv", **time, **floats | {"z [g]": RNG.normal(1.0, 1e-6, N)})
    assert survey(ground, commands=["info", "flip"]).next is None


def test_a_swing_of_the_temperature_leads_to_thermal(tmp_path: Path) -> None:
    def led(name: str, swing: float, **columns: np.ndarray) -> str | None:
        time = {"t_s": np.arange(N) * 10.0, "temperature [degC]": np.linspace(20.0, 20.0 + swing, N)}
        return survey(write(tmp_path / name, **time, **columns), commands=["info", "thermal"]).next

    rates = {"gyro_x [deg/s]": RNG.normal(0.0, 1e-3, N)}
    assert led("swing.csv", -40.0, **rates) == f"inertialcal thermal {tmp_path / 'swing.csv'}"
    assert led("room.csv", 3.0, **rates) is None
    chain = '--lsb "NUMBER V" --reference "NUMBER V" --scale-factor "NUMBER V/(UNIT)"'
    counts = led("counts.csv", -40.0, **{"gyro_x [count]": RNG.normal(0.0, 9.0, N)})
    assert counts == f"inertialcal thermal {tmp_path / 'counts.csv'} {chain}"
    assert led("alone.csv", -40.0, **{"pressure [Pa]": RNG.normal(0.0, 9.0, N)}) is None


def test_steps_of_a_supply_or_a_pressure_lead_to_sensitivity(tmp_path: Path) -> None:
    """A thermal test whose chamber is pumped out once has two levels, and is none."""

    def led(name: str, column: str, levels: list[float], noise: float) -> str | None:
        values = np.repeat(levels, N // len(levels))
        n = len(values)
        columns = {"t_s": np.arange(n) * 10.0, column: values * (1.0 + noise * RNG.standard_normal(n))}
        columns |= {"temperature [degC]": np.linspace(20.0, 60.0, n), "gyro_x [deg/s]": RNG.normal(0.0, 1e-3, n)}
        commands = ["info", "thermal", "sensitivity"]
        return survey(write(tmp_path / name, **columns), commands=commands).next

    path = tmp_path / "supply.csv"
    supply = [5.0, 4.85, 5.15, 5.0]
    assert led("supply.csv", "supply [V]", supply, 1e-4) == f"inertialcal sensitivity {path} --to supply"
    path = tmp_path / "pump.csv"
    decades = [1e5, 1e3, 10.0, 0.1]
    assert led("pump.csv", "pressure [Pa]", decades, 0.02) == f"inertialcal sensitivity {path} --to pressure"
    for column, levels, noise in (
        ("pressure [Pa]", [1e5, 0.1], 0.02),
        ("supply [V]", [5.0, 5.0], 1e-4),
        ("supply [V]", supply, 0.1),
    ):
        assert led("none.csv", column, levels, noise) == f"inertialcal thermal {tmp_path / 'none.csv'}"


def test_numbers_beyond_all_squares_are_shown_without_a_word_of_rest(file: Path) -> None:
    columns = rest()
    columns["gyro_x"][5] = 1e300
    found = survey(write(file, **{"t_s": np.arange(N) / 100}, **columns))
    assert found.channels[0].maximum == 1e300


def test_hints_are_questions_with_a_reason(file: Path) -> None:
    found = survey(write(file, **{"t_s": np.arange(N) / 100}, **rest()))
    assert [str(hint) for hint in found.hints] == [
        "step 0.00763359, as InvenSense MPU: --unit gyro=deg/s?",
        "median |acc| 1.01: --unit acc=g?",
    ]
    assert [channel.unit for channel in found.channels] == [None] * 6  # asked, not answered


@pytest.mark.parametrize(("scale", "unit"), [(9.80665, "m/s2"), (1000.0, "mg")])
def test_gravity_gives_the_unit_away(file: Path, scale: float, unit: str) -> None:
    acc = {name: values * scale for name, values in rest().items() if name.startswith("acc")}
    (hint,) = survey(write(file, **acc)).hints
    assert (hint.target, hint.unit) == ("acc", unit)


def test_counts_and_temperatures_give_their_unit_away(file: Path) -> None:
    found = survey(
        write(
            file,
            acc_x=RNG.integers(-20000, 20000, N),
            temp=RNG.normal(25.0, 1.0, N),
            gyro_x=RNG.normal(0.0, 1.0, N),
        )
    )
    assert [str(hint) for hint in found.hints] == [
        "gyro has no unit, and its values do not give it away: add deg/s or rad/s",
        f"whole numbers up to {max(abs(found.channels[0].minimum or 0), found.channels[0].maximum or 0):g}: "
        "--unit acc=count?",
        f"temperature from {found.channels[1].minimum:.4g} to {found.channels[1].maximum:.4g}: "
        "--unit temperature=degC?",
    ]
    assert found.next == (
        f"inertialcal info '{file}' --unit gyro=UNIT --unit acc=count --unit temperature=degC --sample-rate HZ"
    )


def test_stuck_saturated_and_constant_channels(file: Path) -> None:
    columns = rest()
    columns["gyro_x"][1000:1100] = columns["gyro_x"][1000]
    columns["gyro_y"] = np.clip(columns["gyro_y"], -10.0, 25 * STEP)
    columns["gyro_z"][:] = 0.25
    found = survey(write(file, **columns, status=np.ones(N)))
    by_code = {remark.code: remark for remark in found.remarks if remark.severity == "warning"}
    held = f"{columns['gyro_x'][1000]:.6g}"
    assert by_code["stuck"].what == f"'gyro_x': stuck at {held} for 100 samples in all"
    assert by_code["stuck"].where == f"{file}:1002"
    ends = np.flatnonzero(columns["gyro_y"] == 25 * STEP)
    lie = f"{len(ends)} of 4000 samples lie at the end of the range, 0.19084"
    assert by_code["saturated"].what == f"'gyro_y': {lie}"
    assert by_code["saturated"].where == f"{file}:{ends[0] + 2}"
    assert by_code["constant_channel"].what == "'gyro_z' is 0.25 throughout"
    status = [remark for remark in found.remarks if "'status'" in remark.what]
    assert [remark.severity for remark in status] == ["info"]


def test_places_count_the_samples_that_are_missing(file: Path) -> None:
    values = [f"{value:.2f}" for value in RNG.normal(size=N)]
    values[:300] = [""] * 300
    values[1000:1100] = ["1.11"] * 100
    (channel,) = survey(write(file, n=range(N), gyro_x=values)).channels[1:]
    assert channel.missing == 300
    assert channel.screening["stuck"].places.tolist() == [[1000, 1099]]


def test_rows_with_comments_between_them_are_named_by_sample(file: Path) -> None:
    file.write_text("gyro_x\n" + "1.5\n" * 20 + "# pause\n" + "1.5\n" * 20)
    (remark,) = [r for r in survey(file).remarks if r.code == "constant_channel"]
    assert remark.where == f"{file}: sample 1"


def test_the_end_of_a_converter(file: Path) -> None:
    counts = RNG.normal(0, 12000, N).round().clip(-32768, 32767).astype(int)
    found = survey(write(file, acc_x=counts))
    (remark,) = [r for r in found.remarks if r.code == "saturated"]
    count = int(np.count_nonzero((counts == 32767) | (counts == -32768)))
    assert remark.what == f"'acc_x': {count} of 4000 samples lie at the end of the range, -32768 and 32767"
    (plain,) = (one for one in found.to_dict()["channels"][0]["findings"])
    assert (plain["code"], plain["count"], plain["values"]) == ("saturated", count, [-32768.0, 32767.0])


def test_a_step_a_glitch_and_a_slow_channel(file: Path) -> None:
    """Of a sensor at rest the level is looked at, of others what is held or missing."""
    columns = rest(20_000)
    columns["gyro_x"][500] = -30.0
    columns["acc_x"][9_000:] += 0.008
    slow = np.round(np.sin(np.arange(20_000) * 3e-4) * 10)
    found = survey(write(file, **columns, temp=slow, temperature_2=25.0 + (np.arange(20_000) > 9_000)))
    assert {(r.code, r.subject) for r in found.remarks} == {("glitch", "gyro_x"), ("level_step", "acc_x")}


def test_a_disturbance_is_placed_in_time(file: Path) -> None:
    columns = rest()
    columns["gyro_x"][2000:2080] += 8 * np.sin(np.arange(80))
    found = survey(write(file, **{"t_s": np.arange(N) / 100}, **columns))
    (remark,) = [r for r in found.remarks if r.code == "disturbance"]
    assert remark.what.startswith("not stationary: a disturbance or step from 20")
    assert " s in gyro_x, up to " in remark.what
    without_time = survey(write(file, **columns))
    assert "from sample 20" in next(r.what for r in without_time.remarks if r.code == "disturbance")
    with_rate = survey(file, sample_rate=10.0)
    assert " from 200" in next(r.what for r in with_rate.remarks if r.code == "disturbance")


def test_a_sensor_that_moves(file: Path) -> None:
    columns = rest()
    columns["acc_x"] += np.repeat(RNG.normal(size=40), N // 40)
    found = survey(
        write(file, **{"t_s": np.arange(N) / 100}, **columns), units={"gyro": "deg/s", "acc": "g"},
        commands=["allan", "positions"],
    )  # fmt: skip
    assert codes(found) == ["not_at_rest"]
    assert found.next is None  # moved, but not laid into positions


def test_a_temperature_that_swings_faster_than_anything_can(file: Path) -> None:
    temperature = 25 + 45 * np.sin(np.arange(N) * 2e-3)
    micro = write(file, timestamp=np.arange(N) * 500_000 + 10**14, temp=temperature, gyro_x=rest()["gyro_x"])
    found = survey(micro)
    (remark,) = [r for r in found.remarks if r.code == "time_axis_implausible"]
    assert " if 'timestamp' is in ns: no sensor changes faster than 1 K/s" in remark.what
    assert found.next is not None
    assert found.next.endswith("--unit timestamp=UNIT")
    told = survey(file, units={"timestamp": "ns"})
    assert "time_axis_implausible" in codes(told)
    assert "time_axis_implausible" not in codes(survey(file, units={"timestamp": "us"}))


def test_temperatures_that_can_be(file: Path) -> None:
    for swing in (40.0, 1.0):
        temperature = swing * np.sin(np.arange(N) * 1e-3)
        write(file, t_s=np.arange(N) / (10 if swing > 5 else 1000), temp=temperature)
        assert "time_axis_implausible" not in codes(survey(file))


def test_a_reduced_table_leads_to_init(file: Path) -> None:
    write(file, rate_dps=[-5, 0, 5], x_dps=[-5.01, 0.0, 5.02])
    assert survey(file, commands=["info", "init"]).next == f"inertialcal init {file.parent}"
    assert survey(file).next is None


def test_a_file_of_a_campaign_leads_to_run(file: Path) -> None:
    """``init`` refuses a folder that has a campaign file already."""
    write(file, rate_dps=[-5, 0, 5], x_dps=[-5.01, 0.0, 5.02])
    (file.parent / "campaign.toml").write_text("schema = 1\n")
    assert survey(file, commands=["info", "init", "run"]).next == f"inertialcal run {file.parent}"
    assert survey(file, commands=["info", "init"]).next is None


def test_the_time_axis(file: Path) -> None:
    stamps = 1_283_358_139 + np.delete(np.arange(0, 400, 2), [50, 51])
    found = survey(write(file, unix_s=stamps, x=RNG.normal(size=198)))
    time = found.time.to_dict()
    assert time["start"] == "2010-09-01T16:22:19.000000000Z"
    assert (time["sample_interval"], time["gaps"], time["missing_samples"]) == (2.0, 1, 2)
    assert time["steps"] == [{"step": 2.0, "count": 196}, {"step": 6.0, "count": 1}]
    assert time["interval_from"] == "time column 'unix_s'"


def test_everything_goes_into_json(file: Path) -> None:
    file.write_text("t,x,gone\n0.0,1,\n0.5,nan,\n1.0,2,\n")
    content = survey(file).to_dict()
    assert json.loads(json.dumps(content, allow_nan=False)) == content
    parts = {"path", "sha256", "format", "rows", "compensated_by", "channels", "time", "hints", "remarks", "do", "next"}
    assert set(content) == parts
    assert content["channels"][1]["missing"] == 3
    assert content["channels"][1]["mean"] is None


def test_numbers_near_the_end_of_float64(file: Path) -> None:
    file.write_text("x\n1.7e308\n1.7e308\n-1.7e308\n5e-324\n")
    content = survey(file).to_dict()
    assert content["channels"][0]["std"] is None  # overflows
    json.dumps(content, allow_nan=False)


def test_the_last_line_says_which_channels_to_look_at(file: Path) -> None:
    rng = np.random.default_rng(7)
    x, y = rng.normal(size=(2, 3000))
    y[1234] = -32768.0
    temperature = np.round(20.0 + 5.0 * np.sin(np.arange(3000) / 300.0) + 0.02 * rng.normal(size=3000), 3)
    temperature[1500:] = temperature[1500]
    values = np.column_stack((0.01 * np.arange(3000), x, y, temperature))
    np.savetxt(file, values, "%.4f", ",", header="t_s,gyro_x_dps,gyro_y_dps,temp_degC", comments="")
    found = survey(file)
    said = {one.code: one for one in found.remarks}
    assert (said["glitch"].subject, said["glitch"].where) == ("gyro_y_dps", f"{file}:1236")
    assert (said["stuck"].subject, said["stuck"].where) == ("temp_degC", f"{file}:1502")
    assert found.do == (
        "look at 'gyro_y_dps', 'temp_degC' first; "
        "tests leave out the samples that are no readings, and give figures with and without them"
    )
    assert found.to_dict()["do"] == found.do
    np.savetxt(file, values[:, :2], "%.4f", ",", header="t_s,gyro_x_dps", comments="")
    assert survey(file).do == ""


def test_errors_are_to_be_corrected_first(file: Path) -> None:
    file.write_text("t_s,x\n" + "".join(f"{0.1 * i:.1f},{i % 7}\n" for i in range(40)))
    assert survey(file, sample_rate=0.1).do.startswith("correct the error first")
