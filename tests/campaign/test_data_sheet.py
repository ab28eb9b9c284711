"""First campaign files with the data sheet of a published sensor."""

from __future__ import annotations

from pathlib import Path

import pytest

from inertialcal.campaign.file.load import load
from inertialcal.campaign.start.data_sheet import requirements
from inertialcal.campaign.start.starter import start
from inertialcal.core.errors import UsageError
from inertialcal.procedures import all_quantities
from inertialcal.sensors.catalogue import CATALOGUE, published_sensor

ROWS = "rate [deg/s],gyro_z [deg/s],std [deg/s],n,run\n-5,-5.02,0.02,100,1\n5,5.01,0.02,100,1\n"


@pytest.mark.parametrize("name", ["QRS11", "qrs11", "QRS-11", "QRS11-00005-565"])
def test_limits_of_the_data_sheet_become_requirements(tmp_path: Path, name: str) -> None:
    (tmp_path / "rates.csv").write_text(ROWS)
    path, _, _ = start(tmp_path, name)
    text = path.read_text().replace("  # FILL IN", "")
    path.write_text(text)
    file = load(tmp_path).file
    asked = {one.quantity: one for one in file.requirements}
    assert asked["bias"].limit == "0.131 deg/s"
    assert asked["angle_random_walk"].upper == "0.004 deg/s/sqrt(Hz)"
    assert "Appendix A" in asked["bias"].text
    assert file.item.part == "QRS11-00005-565"
    assert file.sensors["suite"].range == ["-5 deg/s", "5 deg/s"]
    assert file.sensors["suite"].chain.scale_factor == "0.5 V/(deg/s)"
    assert "#   shock at most 200 g, any axis" in text


def test_a_sensor_of_another_kind_is_remarked(tmp_path: Path) -> None:
    (tmp_path / "rates.csv").write_text(ROWS)
    _, _, remarks = start(tmp_path, "QA-2000")
    assert any(one.what == "QA-2000 is an accelerometer: no recording here is of one" for one in remarks)


def test_an_unknown_sensor_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    (tmp_path / "rates.csv").write_text(ROWS)
    with pytest.raises(UsageError, match="No published sensor 'BMI088'"):
        start(tmp_path, "BMI088")
    assert not (tmp_path / "campaign.toml").exists()


@pytest.mark.parametrize("name", CATALOGUE)
def test_every_figure_is_a_requirement_with_its_source_or_named_as_none(tmp_path: Path, name: str) -> None:
    (tmp_path / "rates.csv").write_text(ROWS)
    path, _, _ = start(tmp_path, name)
    text = path.read_text().replace("  # FILL IN", "")
    path.write_text(text)
    asked = load(tmp_path).file.requirements  # refuses a quantity that nothing gives, and a limit in a wrong unit
    sensor = published_sensor(name)
    assert all(not one.judged_by or one.judged_by in all_quantities() for one in sensor.figures)
    assert len(asked) == sum(bool(one.judged_by) for one in sensor.figures)
    for one in sensor.figures:
        source = one.source or sensor.source
        texts = [own.text for own in asked if own.quantity == one.judged_by]
        assert texts == [f"{one.said} ({source})"] if one.judged_by else f"#   {one.said}" in text


def test_the_suite_has_the_data_sheet_of_its_sensors_and_what_the_satellite_asks() -> None:
    asked = {one["quantity"]: one for one in requirements(published_sensor("flight_unit"))}
    assert asked["temperature_error_of_range"]["limit"] == "2 %"
    assert {one["quantity"] for one in requirements(published_sensor("QRS11"))} < set(asked)
    assert str(asked["bias"]["text"]).endswith("Appendix A)")
