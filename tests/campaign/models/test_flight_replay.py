"""Flight C of a campaign: compiled and replayed on power-ups held out, it gives what compensation gives."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.models.find import load_models
from inertialcal.campaign.models.flight_replay import flying, replay_flight_c
from inertialcal.campaign.twins.twin import write_twin
from inertialcal.cli.shown.model_text import flight_text
from inertialcal.files.models.model_json import write_model
from inertialcal.sensors.model.model_set import ModelSet
from npsat1_small import short_twin


@pytest.fixture(scope="module")
def suite(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("suite") / "campaign"
    write_twin(short_twin(4, parts=("thermal", "rate_table")), folder)
    run(folder)
    models = load_models(folder)  # as if confirmed: here it matters what the C gives, not how good the model is
    confirmed = ModelSet(tuple(replace(one, judged=True) for one in models.values()))
    (folder / "out/model.json").unlink()
    write_model(folder / "out/model.json", confirmed)
    return folder


def test_the_model_of_the_lowest_pressure_flies(suite: Path) -> None:
    models = load_models(suite)
    chosen = flying(models)
    assert chosen is not None
    assert chosen.condition == "vacuum"
    bare = ModelSet(tuple(replace(one, chain=None) for one in models.values()))
    assert flying(bare) is None
    unconfirmed = ModelSet(tuple(replace(one, judged=one.condition != "vacuum") for one in models.values()))
    air = flying(unconfirmed)
    assert air is not None
    assert air.condition == "air"


def test_c_gives_what_compensation_gives_within_the_proved_bound(suite: Path, need: Callable[[str], str]) -> None:
    need("cc")
    found = replay_flight_c(suite)
    assert found is not None
    assert (found.condition, found.recordings, found.reason) == ("vacuum", ("vacuum_6", "vacuum_7"), "")
    assert found.rows > 1000
    assert found.compensated is not None
    assert found.flown is not None
    assert found.largest is not None
    assert found.bound is not None
    assert np.all(found.largest <= found.bound + 1e-13)  # doubles of the compensation itself
    assert np.all(found.largest > 0.0)
    np.testing.assert_allclose(found.flown, found.compensated, atol=1e-8)
    assert json.loads(json.dumps(found.to_dict()))["rows"] == found.rows
    assert "vacuum_6, vacuum_7:" in flight_text(found)
    many = replace(found, recordings=tuple(f"x_run{i}" for i in range(7, 26)))
    assert "on x_run7, x_run8, x_run9 and 16 more:" in " ".join(flight_text(many).split())
    again = replay_flight_c(suite)
    assert again is not None
    assert again.to_dict() == found.to_dict()


def test_without_a_compiler_the_c_is_delivered_and_it_is_said(suite: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shutil.which", lambda name: None)
    found = replay_flight_c(suite)
    assert found is not None
    assert "no C compiler" in flight_text(found)
    assert (found.folder / "bound.json").is_file()


def test_a_campaign_without_a_model_has_none(tmp_path: Path) -> None:
    assert replay_flight_c(tmp_path) is None
