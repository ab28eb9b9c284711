"""Site and sensors as text that the campaign file takes back."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from inertialcal.campaign.file.load import load
from inertialcal.campaign.file.schema import Site
from inertialcal.campaign.file.sensors import Sensor
from inertialcal.campaign.outcome.contents import sensors_content, site_content
from ran_campaigns import Ran


def test_the_site_can_be_pasted_back() -> None:
    said = {"latitude": "36.6 deg", "height": "12 m", "gravity": "9.799 m/s2"}
    found = site_content(Site.model_validate(said))
    assert found == {"latitude": "36.6 deg", "height": "12 m", "gravity": "9.799 m/s^2"}
    again = Site.model_validate(found)
    assert again.latitude == pytest.approx(Site.model_validate(said).latitude, rel=1e-10)


def test_what_is_not_said_is_null(published: Ran) -> None:
    assert published.results["site"] == {"latitude": "36.6 deg", "height": None, "gravity": None}


def test_sensors_can_be_pasted_back(simulated: Ran, campaign: Callable[..., Path]) -> None:
    for file in (load(simulated.folder).file, load(campaign()).file):
        content = json.loads(json.dumps(sensors_content(file.sensors)))
        for name, sensor in file.sensors.items():
            assert Sensor.model_validate(content[name]) == sensor


def test_the_chain_is_told_with_its_units(simulated: Ran) -> None:
    suite = simulated.results["sensors"]["suite"]
    assert (suite["kind"], suite["axes"], suite["unit"]) == ("gyro", ["x", "y", "z"], "deg/s")
    assert suite["chain"]["validity_minimum"] == "2.4 V"
    assert suite["chain"]["counts"] == [0, 4095]
    assert suite["chain"]["lsb"] == f"{5.0 / 4095.0!r} V"
