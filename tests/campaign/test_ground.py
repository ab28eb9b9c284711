"""Ground models in a campaign: polynomials, model files, what was done before; and what is refused, by its words."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.load import load
from inertialcal.campaign.file.recordings import RecordingEntry
from inertialcal.campaign.file.sensors import Sensor
from inertialcal.campaign.inputs.chains import build_chain
from inertialcal.campaign.inputs.ground import after_model, chain_model
from inertialcal.campaign.twins.score import score
from inertialcal.campaign.twins.twin import simulate
from inertialcal.core.errors import DataError, InertialcalError
from inertialcal.core.recording import Channel, Recording
from inertialcal.files.models.model_json import dump_model
from inertialcal.rigs import RIGS
from inertialcal.rigs.protocol import Rig
from inertialcal.rigs.sams_tsh.rig import Bench, build
from inertialcal.rigs.twin import Changes, Twin
from inertialcal.sensors.model.sensor_model import SensorModel

pytestmark = pytest.mark.usefixtures("undrawn")

UG = 9.80665e-6
BENCH = replace(Bench(), rate=5.0, ground="bias_first")
Edit = Callable[..., Path]

SENSOR: dict[str, Any] = {
    "kind": "accelerometer",
    "axes": ["x", "y"],
    "unit": "ug",
    "chain": {
        "kind": "none",
        "gain": {"x": 10.0, "y": 100.0},
        "scale_factor": "10 V/g",
        "ground": {
            "reference_temperature": "20 degC",
            "misalignment": {"xy": ["2 mrad", "0.1 mrad/degC"]},
            "gains": {
                "10": {"bias": {"x": ["900 ug", "5 ug/degC"]}, "scale_factor": {"x": ["10.1 V/g", "1 mV/g/degC"]}},
                "100": {"bias": {"y": ["0.0012 g"]}, "zero": "1 mV"},
            },
        },
    },
}


def one_twin(seed: int, changes: Changes) -> Twin:
    return build(BENCH, seed)


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(RIGS, "head_with_model", Rig("head_with_model", "", one_twin))
        yield simulate("head_with_model", tmp_path_factory.mktemp("ground") / "flip", 4).folder


@pytest.fixture
def edited(simulated: Path, tmp_path: Path) -> Edit:
    """The simulated campaign with some text replaced; its recordings are those of the first."""

    def make(*pairs: tuple[str, str]) -> Path:
        text = (simulated / "campaign.toml").read_text(encoding="utf-8")
        for old, new in pairs:
            assert old in text
            text = text.replace(old, new)
        target = tmp_path / "edited"
        target.mkdir()
        (target / "campaign.toml").write_text(text, encoding="utf-8")
        (target / "recordings").mkdir()
        (target / "recordings" / "flip.csv").hardlink_to(simulated / "recordings" / "flip.csv")
        return target

    return make


def refused(act: Callable[[], Any]) -> str:
    with pytest.raises(InertialcalError) as caught:
        act()
    return "\n".join(" ".join(filter(None, (p.where, p.what, p.why, p.do))) for p in caught.value.problems)


def sensor(**chain: Any) -> Sensor:
    return Sensor.model_validate(SENSOR | {"chain": SENSOR["chain"] | chain})


def test_the_polynomials_of_a_campaign_in_its_own_units() -> None:
    found = chain_model(sensor())
    assert found is not None
    at = found.model.at([10.0, 100.0])
    scale, bias, back = at.parts(np.array([22.0, 21.0])[None, :], 1, "jointly")
    assert scale[0] == pytest.approx([1.01 + 2e-4, 1.0])
    assert bias[0] == pytest.approx([910.0 * UG, 1200.0 * UG])
    assert back[0] == pytest.approx(np.array([[1.0, -2.2e-3], [0.0, 1.0]]))
    assert found.gains == {"x": 10.0, "y": 100.0}


def test_the_zero_of_a_gain_goes_before_that_of_the_chain() -> None:
    chain = build_chain(sensor(kind="adc", lsb="1 mV", counts=[-10, 10], zero="3 mV"))
    assert np.asarray(chain.zero) == pytest.approx([3e-3, 1e-3])
    assert chain.zero_at is not None
    assert chain.zero_at[100.0] == pytest.approx([1e-3, 1e-3])
    assert chain.zero_at[10.0] == pytest.approx([3e-3, 3e-3])


def head(**more: Any) -> tuple[Recording, RecordingEntry]:
    columns = [("x", 900.0 * UG), ("y", 1200.0 * UG), ("temperature", 20.0)]
    channels = tuple(Channel(name, np.array([value]), "degC" if "temp" in name else "m/s^2") for name, value in columns)
    entry = {"sensor": "head", "file": "a.csv", "channels": {"x": {"column": "x", "unit": "g"}}} | more
    return Recording(channels), RecordingEntry.model_validate(entry)


def test_what_the_file_says_was_applied_is_not_applied_again() -> None:
    model = chain_model(sensor())
    assert model is not None
    raw, entry = head()
    done = after_model(replace(raw, applied=("scale_factor", "misalignment")), entry, model, False)
    assert done.channel("y").data == pytest.approx([0.0], abs=1e-12)
    assert done.channel("x").data == pytest.approx([1200.0 * 2e-3 * UG])  # predicted: 900 - 2e-3 * 1200 ug
    said = {one.code: one.what for one in done.remarks}
    assert said["applied_before"].startswith("scale factor and misalignment of the ground model not applied")
    assert "ground_model" in said


def test_the_campaign_goes_before_the_file_and_a_difference_is_remarked() -> None:
    model = chain_model(sensor())
    assert model is not None
    raw, entry = head(applied=["scale_factor"])
    raw = replace(raw, applied=("bias", "scale_factor", "misalignment"))
    done = after_model(raw, entry, model, False)
    assert any(one.code == "applied_disagrees" and "the campaign was followed" in one.what for one in done.remarks)
    assert done.channel("y").data == pytest.approx([0.0], abs=1e-12)


def test_a_bias_that_is_off_already_cannot_be_left_in() -> None:
    model = chain_model(sensor())
    assert model is not None
    raw, entry = head(applied=["bias"])
    with pytest.raises(DataError, match="removed before"):
        after_model(raw, entry, model, True)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"gains": {"10": {"bias": {"z": ["1 ug"]}}}}, "the sensor has no axis 'z'"),
        ({"gains": {"10": {"bias": {"x": ["1 ug", "1 ug"]}}}}, "gains.10.bias.x, coefficient of (T - T_ref)^1: 'ug'"),
        ({"gains": {"10": {"bias": {"x": ["1 ug"]}, "scale_factor": {"y": ["1 V/g"]}}}}, "y has a scale_factor and no"),
        ({"gains": {"10": {"bias": {"x": ["1 ug"]}, "scale_factor": {"x": ["0 V/g"]}}}}, "scale_factor of x is zero"),
        ({"misalignment": {"xz": ["1 mrad"]}}, "misalignment.xz: the sensor has no axis 'z'"),
    ],
)
def test_polynomials_that_cannot_be(change: dict[str, Any], words: str) -> None:
    assert words in refused(lambda: chain_model(sensor(ground=SENSOR["chain"]["ground"] | change)))


def test_scale_factors_need_the_one_that_the_readings_were_made_with() -> None:
    assert "needs scale_factor in the chain" in refused(lambda: chain_model(sensor(scale_factor=None)))


# From files


def test_a_campaign_with_a_ground_model_finds_its_truth(simulated: Path) -> None:
    outcome = run(simulated)
    assert {one["test"] for one in outcome.results["results"]} >= {"flip", "corrected"}
    found = {(row["test"], row["quantity"], row["axis"]): row for row in score(simulated).rows}
    for test, name in (("flip", "bias"), ("flip", "bias_shift"), ("corrected", "model_bias_error"),
                       ("corrected", "corrected_bias")):  # fmt: skip
        for axis in "yz":
            row = found[test, name, axis]
            assert abs(row["value"] - row["truth"]) < 4.0 * row["u"]
    remarks = [one["what"] for one in outcome.results["remarks"]]
    assert any("ground model was applied, bias first, the bias left in" in what for what in remarks)


def test_a_model_file_gives_what_its_polynomials_give(simulated: Path, edited: Edit) -> None:
    known = chain_model(load(simulated).file.sensors["head"])
    assert known is not None
    at = known.model.at(list(known.gains.values()))
    matrix = np.zeros((5, 3, 3))
    matrix[: len(at.model.matrix)] = at.model.matrix
    whole = np.zeros((9, 3, 3))  # M = S/S0 (I + A), K0 = S/S0 b
    bias = np.zeros((9, 3))
    own = np.vstack([at.model.bias, np.asarray(at.model.bias_temperature)])
    for j, scale in enumerate(at.scale):
        whole[j : j + 5] += scale[:, None] * matrix
        bias[j : j + 5] += scale * own
    model = SensorModel("accelerometer", ("x", "y", "z"), np.ones(3), "m/s^2", whole, bias[0],
                        bias_temperature=bias[1:], reference_temperature=at.model.reference_temperature)  # fmt: skip
    text = (simulated / "campaign.toml").read_text(encoding="utf-8")
    start, stop = text.index("[sensors.head.chain.ground]"), text.index("[recordings.flip]")
    folder = edited((text[start:stop], ""), ('order = "bias_first"', 'order = "bias_first"\nmodel = "ground.json"'))
    (folder / "ground.json").write_text(dump_model(model), encoding="utf-8")
    outcome = run(folder, write=False)
    first, second = run(simulated, write=False).results, outcome.results
    for one, other in zip(first["results"], second["results"], strict=True):
        assert (one["quantity"], one["axis"], one["test"]) == (other["quantity"], other["axis"], other["test"])
        if one["value"] is not None:
            assert other["value"] == pytest.approx(one["value"], rel=1e-7, abs=1e-5)
    assert set(outcome.inputs) == {"campaign.toml", "ground.json", "recordings/flip.csv"}


@pytest.mark.parametrize(
    ("pair", "words"),
    [
        (('order = "bias_first"', 'order = "bias first"'), "should be 'jointly' or 'bias_first'"),
        (('order = "bias_first"', 'order = "jointly"\nmodel = "a.json"'), "ground and model: give one of them"),
        (("ground.gains.100]", "ground.gains.high]"), "gains.high"),
        (('reference_temperature = "18 degC"', 'reference_temperature = "18 m"'), "chain.ground"),
        (('\nxy = ["0.0', '\nxx = ["0.0'), "xx"),
        (('procedure = "flip"', 'procedure = "rate_table"'), "has a ground model in its chain"),
    ],
)
def test_a_campaign_that_is_refused(edited: Edit, pair: tuple[str, str], words: str) -> None:
    assert words in refused(lambda: load(edited(pair)))


def test_a_model_that_is_not_there_or_lies_outside(simulated: Path, edited: Edit) -> None:
    text = (simulated / "campaign.toml").read_text(encoding="utf-8")
    ground = text[text.index("[sensors.head.chain.ground]") : text.index("[recordings.flip]")]
    folder = edited((ground, ""), ('order = "bias_first"', 'model = "../ground.json"'))
    assert "lies outside the campaign folder" in refused(lambda: load(folder))
    path = folder / "campaign.toml"
    path.write_text(path.read_text(encoding="utf-8").replace("../ground", "ground"), encoding="utf-8")
    said = refused(lambda: load(folder))
    assert "campaign.toml:" in said
    assert "ground.json" in said
    one = SensorModel("gyro", ("x", "y", "z"), np.ones(3), "rad/s", np.eye(3), np.zeros(3))
    (folder / "ground.json").write_text(dump_model(one), encoding="utf-8")
    assert "is the model of a gyro" in refused(lambda: load(folder))


def test_a_gain_without_polynomials_is_refused_with_those_there_are(edited: Edit) -> None:
    said = refused(lambda: run(edited(("gain = { x = 100,", "gain = { x = 50,")), write=False))
    assert "no polynomials of x at gain 50" in said
    assert "1, 10, 100, 1000" in said


def test_without_the_temperature_a_model_in_temperature_is_refused(edited: Edit) -> None:
    channels = "".join(f'temperature_{a} = {{ column = "temperature_{a}", unit = "count" }}\n' for a in "xyz")
    assert "no temperature of the head" in refused(lambda: run(edited((channels, "")), write=False))
