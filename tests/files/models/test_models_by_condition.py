"""Several models in one file, and files of schema version 1."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import inertialcal as ic
from inertialcal.core.errors import DataError, InertialcalError, UsageError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.key import Key
from inertialcal.core.schema.checksum import CHECKSUM, checksum
from inertialcal.files.models.model_file import export, load_model_file
from inertialcal.files.models.model_json import dump_models, parse_models, read_models, write_model
from inertialcal.sensors.model.model_set import ModelSet
from inertialcal.sensors.model.sensitivity import Sensitivity
from inertialcal.sensors.model.sensor_model import Item, SensorModel
from inertialcal.sensors.model.serial import to_dict
from random_models import random_model

OLD = Path(__file__).with_name("model_schema_1.json")
NOISE = Estimate(
    (Key("angle_random_walk", "x"), Key("gauss_markov_sigma", "x")),
    np.array([1e-4, 2e-5]),
    ("rad/sqrt(s)", "rad/s"),
    (Component("fit", "A", np.diag([1e-12, 1e-14]), 12.0),),
)


def code(error: pytest.ExceptionInfo[InertialcalError]) -> str:
    return error.value.problems[0].code


def pair(judged: bool = True) -> ModelSet:
    """A gyro in air and in vacuum."""
    supply = Sensitivity("supply", "V", 5.0, np.array([0.01]), None, np.array([1e-3]), (4.85, 5.15))
    air = SensorModel("gyro", ("x",), np.ones(1), "V", np.eye(1), np.array([0.1]), condition="air", judged=judged,
                      sensitivities=(supply,), noise=NOISE, pressure_range=(9e4, 1.1e5))  # fmt: skip
    return ModelSet((air, replace(air, condition="vacuum", bias=np.array([0.3]), sensitivities=(), noise=None)))


def test_the_model_of_a_condition() -> None:
    models = pair()
    assert list(models) == ["air", "vacuum"]
    assert models.only("vacuum") is models["vacuum"]
    with pytest.raises(
        UsageError, match=r"several conditions: air, vacuum.*--condition air or --condition vacuum"
    ) as none:
        models.only()
    with pytest.raises(UsageError, match=r"no model for condition .orbit.. There is: air, vacuum") as other:
        models.only("orbit")
    assert [code(none), code(other)] == ["condition_needed", "no_such_condition"]
    alone = ModelSet((random_model(1),))
    assert alone.only() is alone[""]
    with pytest.raises(UsageError, match="names no condition"):
        alone.only("air")


def test_models_of_two_sensors_make_no_set() -> None:
    one = pair()["air"]
    with pytest.raises(DataError, match="not of one sensor"):
        ModelSet((one, replace(one, condition="vacuum", item=Item(serial="8"))))
    for models in ((), (one, one), (one, replace(one, condition=""))):
        with pytest.raises(DataError, match="one model a condition"):
            ModelSet(models)


def test_both_models_of_a_file(tmp_path: Path) -> None:
    write_model(tmp_path / "model.json", pair())
    again = ic.load_models(tmp_path / "model.json")
    assert to_dict(again) == to_dict(pair())
    assert again["air"].noise is not None
    assert again["air"].noise.keys == NOISE.keys
    assert again["air"].noise.u.tobytes() == NOISE.u.tobytes()
    assert again["air"].sensitivities[0].range == (4.85, 5.15)
    assert ic.load_model(tmp_path / "model.json", "vacuum").bias.tolist() == [0.3]
    with pytest.raises(UsageError, match=r"model.json.*several conditions") as caught:
        ic.load_model(tmp_path / "model.json")
    assert code(caught) == "condition_needed"
    with pytest.raises(UsageError) as caught:
        ic.load_model(tmp_path / "model.json", condition="orbit")
    assert code(caught) == "no_such_condition"


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_random_models_of_two_conditions_read_back_to_the_bit(seed: int) -> None:
    one = random_model(seed, estimated=True)
    models = ModelSet((replace(one, condition="air"), replace(one, condition="vacuum", judged=True)))
    assert dump_models(parse_models(dump_models(models))) == dump_models(models)


def test_the_model_of_a_condition_is_handed_out(tmp_path: Path) -> None:
    write_model(tmp_path / "model.json", pair())
    source = tmp_path / "model.json"
    export(load_model_file(source), "json", tmp_path / "both.json")
    assert (tmp_path / "both.json").read_bytes() == source.read_bytes()
    export(load_model_file(source, "vacuum"), "json", tmp_path / "one.json")
    assert list(read_models(tmp_path / "one.json")) == ["vacuum"]
    export(load_model_file(source, "air"), "c", tmp_path / "air.c")
    assert "Condition: air" in (tmp_path / "air.c").read_text()
    with pytest.raises(UsageError, match="several conditions"):
        export(load_model_file(source), "c", tmp_path / "any.c")
    assert not (tmp_path / "any.c").exists()


def test_every_model_of_a_file_must_have_been_judged(tmp_path: Path) -> None:
    one = pair()
    write_model(tmp_path / "model.json", ModelSet((one["air"], replace(one["vacuum"], judged=False))))
    with pytest.raises(DataError, match="have not confirmed"):
        export(load_model_file(tmp_path / "model.json"), "json", tmp_path / "out.json")
    export(load_model_file(tmp_path / "model.json", "air"), "json", tmp_path / "out.json")


def test_a_file_of_version_1_reads_as_before() -> None:
    """Written by the version before sensitivities and conditions."""
    content = json.loads(OLD.read_text())
    assert content["schema_version"] == 1
    model = ic.load_model(OLD)
    assert (model.condition, model.sensitivities, model.noise) == ("", (), None)
    assert model.judged
    for name, values in content["terms"].items():
        own = getattr(model, name)
        assert (own is None) == (values is None)
        assert own is None or own.tolist() == values
    assert model.estimate is not None
    assert list(model.estimate.names) == content["estimate"]["names"]
    assert model.estimate.values.tolist() == content["estimate"]["values"]
    components = [one.covariance.tolist() for one in model.estimate.components]
    assert components == [one["covariance"] for one in content["estimate"]["components"]]
    assert model.tests == ("rate",)
    assert parse_models(dump_models(model)).only().bias.tolist() == model.bias.tolist()


def test_a_file_of_version_1_that_was_edited_is_refused() -> None:
    text = OLD.read_text().replace("28.6", "28.7")
    with pytest.raises(DataError) as caught:
        parse_models(text)
    assert code(caught) == "checksum"


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"channel": "temperature"}, "another term has that name"),
        ({"channel": "temperature_2"}, "another term has that name"),
        ({"channel": "Supply voltage"}, "lower-case letters"),
        ({"channel": "pressure"}, "own term bias_pressure"),
        ({"unit": "sheep"}, "sheep"),
        ({"bias": [1.0, 2.0]}, r"bias_supply: shape \(2,\), need \(1,\)"),
        ({"bias": [1e101]}, "models.air.sensitivities.0.bias"),
        ({"bias": "much"}, "models.air.sensitivities.0.bias"),
        ({"bias_temperature": [1.0]}, "without reference_temperature"),
        ({"range": [5.15, 4.85]}, "supply_range: 5.15 to 4.85"),
    ],
)
def test_a_sensitivity_is_refused_with_its_reason(change: dict[str, object], text: str) -> None:
    content = to_dict(pair())
    content["models"]["air"]["sensitivities"][0] |= change
    with pytest.raises(DataError, match=text):
        parse_models(json.dumps({**content, CHECKSUM: checksum(content)}))


def test_two_terms_of_one_name_are_refused() -> None:
    one = pair()["air"]
    hidden = Sensitivity("supply_temperature", "degC", 20.0, np.array([0.1]))  # bias_supply_temperature
    both = replace(one.sensitivities[0], bias_temperature=np.array([0.1]))
    with pytest.raises(DataError, match="two terms of one name: bias_supply_temperature"):
        replace(one, reference_temperature=np.array([20.0]), sensitivities=(both, hidden))
    with pytest.raises(DataError, match="two sensitivities of one name: supply"):
        replace(one, sensitivities=one.sensitivities * 2)
    with pytest.raises(DataError, match="bias_run_to_run"):
        replace(one, sensitivities=(Sensitivity("run_to_run", "V", 0.0, np.array([0.1])),))
