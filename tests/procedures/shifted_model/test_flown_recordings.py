"""A ground model shifted by flips that were recorded: files alone, results of flips, tests of a campaign."""

from __future__ import annotations

import json
import math
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shifted_heads import UG

import inertialcal as ic
from independent.orbit.flown_head import FlownHead, head, recording, text
from inertialcal.campaign.engine.run import run
from inertialcal.core.constants import STANDARD_GRAVITY
from inertialcal.core.errors import DataError, InertialcalError, PlanError
from inertialcal.core.estimate import Component, Estimate
from inertialcal.core.influence import Influence
from inertialcal.core.key import AXES, Key, Origin
from inertialcal.files.models.model_json import dump_model
from inertialcal.procedures.corrections import BiasCorrection
from inertialcal.procedures.shifted_model.model import bias_at
from inertialcal.procedures.shifted_model.plan import Plan
from inertialcal.procedures.shifted_model.readings import Flip, Readings
from inertialcal.procedures.shifted_model.reduction import reduce
from inertialcal.sensors.model.assemble import model_from
from inertialcal.sensors.model.sensor_model import Item, SensorModel
from sized import sized

FLIGHTS = 3
DATE = "2018-05-01"


def ground_of(one: FlownHead) -> SensorModel:
    """The ground model of a head, which is right."""
    g = 1e-6 * STANDARD_GRAVITY.value
    pairs = [a + b for a in AXES for b in AXES if a != b]
    keys = [Key("bias", a) for a in AXES] + [Key("bias_temperature", a, power=1) for a in AXES]
    keys += [Key("scale_factor_error", a) for a in AXES] + [Key("misalignment", pair) for pair in pairs]
    of_matrix = [*np.diag(one.matrix) - 1.0, *(one.matrix[AXES.index(pair[0]), AXES.index(pair[1])] for pair in pairs)]
    values = np.array([*one.bias * g, *one.slope * g, *of_matrix])
    units = ("m/s^2",) * 3 + ("m/s^2/degC",) * 3 + ("1",) * 3 + ("rad",) * 6
    part = Component("ground test", "A", np.diag(np.square([10.0 * g] * 3 + [0.2 * g] * 3 + [1e-4] * 9)), 30.0, "t")
    return model_from(
        Estimate(tuple(keys), values, units, (part,)), "accelerometer", AXES, reference_temperature=20.0,
        temperature_range=(0.0, 40.0), item=Item("maker", "head", "7"),
    )  # fmt: skip


def flown(folder: Path, seed: int, flights: int = FLIGHTS) -> FlownHead:
    """Write the recordings of a head, and its ground model."""
    rng = np.random.default_rng(seed)
    one = head(rng, flights)
    (folder / "ground.json").write_text(dump_model(ground_of(one)), encoding="utf-8", newline="\n")
    for flight in range(flights):
        written = text(*recording(one, flight, rng))
        (folder / f"flight{flight + 1}.csv").write_text(written, encoding="utf-8", newline="\n")
    return one


def names(folder: Path, flights: int = FLIGHTS) -> list[str]:
    return [str(folder / f"flight{flight + 1}.csv") for flight in range(flights)]


@pytest.fixture(scope="module")
def records(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, FlownHead]:
    folder = tmp_path_factory.mktemp("flown")
    return folder, flown(folder, 1)


def inside(one: FlownHead, found: ic.Reduced) -> tuple[int, int]:
    """How many intervals of the shift of a flight hold it, and how many there are."""
    rows = [row for row in found.rows if row.quantity == "bias_shift" and row.member is not None]
    held = 0
    for row in rows:
        assert row.member is not None
        assert row.interval is not None
        true = one.shift[int(row.member.label.removeprefix("flight")) - 1, AXES.index(row.axis)]
        held += bool(row.interval.lo <= true <= row.interval.hi)
    return held, len(rows)


def test_recordings_alone_give_the_shift_of_each_flight_and_a_model(records: tuple[Path, FlownHead]) -> None:
    folder, one = records
    found = ic.shifted_model(names(folder), ground=str(folder / "ground.json"), ground_date=DATE)
    assert {row.test for row in found.rows} == {"shifted_model"}  # flips are its parts: their figures are in its own
    held, count = inside(one, found)
    assert count == 2 * FLIGHTS
    assert held >= count - 1
    flips = found.result.readings.flips
    assert [flip.temperature for flip in flips[::2]] == pytest.approx(one.temperature, abs=0.05)
    model = found.models["accelerometer"]
    value, u, _ = bias_at(model, found.result, "y", np.array([found.result.shifts["y"].temperature]))
    head_bias = np.linalg.solve(one.matrix, one.bias + one.slope * (found.result.shifts["y"].temperature - 20.0))
    assert abs(value / UG - head_bias[1] - one.shift[:, 1].mean()) < 4.0 * u / UG


@pytest.mark.slow
def test_intervals_of_the_shift_of_a_flight_hold_it(tmp_path: Path) -> None:
    """Noise is white with a little walk: its intervals hold 95 %, and not by much more."""
    heads, total, held = sized(12, 25), 0, 0
    for seed in range(1, heads + 1):
        folder = tmp_path / str(seed)
        folder.mkdir()
        try:
            own, count = inside(
                flown(folder, seed, 6),
                ic.shifted_model(names(folder, 6), ground=str(folder / "ground.json"), ground_date=DATE),
            )
        except InertialcalError:  # turns that the record does not show: asked for
            continue
        held, total = held + own, total + count
        shutil.rmtree(folder)
    assert total > 6 * heads
    assert 0.90 * total <= held <= 0.995 * total


@pytest.fixture(scope="module")
def printed(records: tuple[Path, FlownHead]) -> str:
    """What a flip of the first recording says, without the ground model."""
    return json.dumps(ic.flip(names(records[0])[0]).results, default=str)


def test_a_bias_of_the_sensors_is_not_that_of_the_head(
    printed: str, records: tuple[Path, FlownHead], tmp_path: Path
) -> None:
    folder, _ = records
    file = tmp_path / "flip.json"
    file.write_text(printed, encoding="utf-8")
    with pytest.raises(InertialcalError, match="the bias is that of the sensor") as refused:
        ic.shifted_model(str(file), ground=str(folder / "ground.json"))
    assert refused.value.problems[0].code == "frames_differ"
    taken = ic.shifted_model(str(file), ground=str(folder / "ground.json"), bias_of="sensor")
    assert taken.result.readings.runs == 1


@pytest.mark.parametrize(
    ("spoil", "code"),
    [
        (lambda text: text[:-400], "damaged_file"),
        (lambda text: text.replace('"quantity": "flip_temperature"', '"quantity": "other"'), "no_temperature"),
        (lambda text: text.replace('"quantity": "bias"', '"quantity": "reading"'), "no_flip"),
    ],
)  # fmt: skip
def test_a_results_file_that_cannot_be_meant_is_refused(
    spoil: object, code: str, printed: str, records: tuple[Path, FlownHead], tmp_path: Path
) -> None:
    assert callable(spoil)
    folder, _ = records
    file = tmp_path / "flip.json"
    file.write_text(spoil(printed), encoding="utf-8")
    with pytest.raises(DataError) as refused:
        ic.shifted_model(str(file), ground=str(folder / "ground.json"), bias_of="sensor")
    assert refused.value.problems[0].code == code


# ---- a campaign ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def campaign(records: tuple[Path, FlownHead], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder, _ = records
    made = tmp_path_factory.mktemp("campaign") / "c"
    ic.shifted_model(names(folder), ground=str(folder / "ground.json"), ground_date=DATE).write_campaign(made)
    return made


def test_a_campaign_of_flips_and_its_results_give_the_figures_of_the_recordings(
    campaign: Path, records: tuple[Path, FlownHead], tmp_path: Path
) -> None:
    folder, _ = records
    made = tmp_path / "c"
    shutil.copytree(campaign, made)
    found = run(made)
    ground = str(folder / "ground.json")
    alone = ic.shifted_model(names(folder), ground=ground, ground_date=DATE)
    own = {(row["quantity"], row["axis"]): row["value"] for row in found.results["results"]
           if row["test"] == "shifted_model" and row["member"] is None}  # fmt: skip
    same = {(row.quantity, row.axis): row.value for row in alone.rows if row.member is None}
    assert own == pytest.approx(same, nan_ok=True)
    assert "shifted_model" in (made / "out" / "model.json").read_text(encoding="utf-8")
    again = ic.shifted_model(str(made / "out" / "results.json"), ground=ground, ground_date=DATE)
    for one, other in zip(again.result.readings.flips, alone.result.readings.flips, strict=True):
        assert one.axis == other.axis
        assert abs(one.time - other.time) < 3600 * 10**9  # begin and middle of the record
        assert (one.temperature, one.bias, one.u) == pytest.approx((other.temperature, other.bias, other.u), rel=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ('after = ["flight1", "flight2", "flight3"]', "", "missing_key"),
        ('after = ["flight1", "flight2", "flight3"]', 'after = ["flight1", "flight1"]', "duplicate_id"),
        ('after = ["flight1", "flight2", "flight3"]', 'after = ["flight1", "nothing"]', "unknown_name"),
        ('after = ["flight1", "flight2", "flight3"]', 'after = ["flight1", "flight2"]', "no_flip"),
        ('recordings = ["flight1", "flight2", "flight3"]', 'recordings = ["flight1"]', "missing_key"),
        ("model = ", "#", "no_ground_model"),
    ],
)
def test_a_campaign_that_names_other_flips_is_refused(
    old: str, new: str, code: str, campaign: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "c"
    shutil.copytree(campaign, folder)
    file = folder / "campaign.toml"
    written = file.read_text(encoding="utf-8")
    if new == "#":
        at = written.index("chain = {")
        written = written[:at] + written[written.index("\n", at) :]
    else:
        assert old in written
        written = written.replace(old, new)
    file.write_text(written, encoding="utf-8", newline="\n")
    with pytest.raises((PlanError, DataError)) as refused:
        run(folder, write=False)
    assert code in {one.code for one in refused.value.problems}


# ---- the covariance of flips ------------------------------------------------------------------------------------


def flips(shared: float) -> tuple[Flip, ...]:
    """Five flights on a line, all off by one unknown of the electronics."""
    return tuple(
        Flip(str(i), (1_500_000_000 + i * 31_557_600) * 10**9, "y", 20.0, (1000.0 + 2.0 * i) * UG, 0.2 * UG, math.inf,
             shared={"converter.zero[y]": shared * UG}) for i in range(5)
    )  # fmt: skip


def test_what_all_flips_share_is_in_the_level_and_not_in_the_drift() -> None:
    keys = (Key("bias", "y"),)
    ground = model_from(
        Estimate(keys, np.array([1000.0]) * UG, ("m/s^2",), (Component("g", "A", np.eye(1) * (10.0 * UG) ** 2),)),
        "accelerometer", ("y",), temperature_range=(0.0, 40.0),
    )  # fmt: skip
    bare, off = (reduce(Plan(slope="none"), Readings(flips(size), ground)).estimate for size in (0.0, 3.0))
    assert off.u[0] ** 2 == pytest.approx(bare.u[0] ** 2 + (3.0 * UG) ** 2)
    assert off.u[1] == pytest.approx(bare.u[1])
    assert off.shared("bias_shift_y") == pytest.approx({"converter.zero[y]": 3.0 * UG})


def test_what_a_mounting_draws_anew_is_scatter_of_the_flights() -> None:
    from inertialcal.procedures.shifted_model.readings import _of_tests

    key = Key("bias", "y")
    parts = (
        Component("noise", "A", np.eye(1) * (0.3 * UG) ** 2, 20.0, "t"),
        Component(Origin("axis", standard="turn", quantity="axis"), "B", np.eye(1) * (0.4 * UG) ** 2,
                  changes=np.array([[0.4 * UG]]), unknowns=("along",)),
        Component(Origin("zero", standard="converter", quantity="zero"), "B", np.eye(1) * UG**2,
                  changes=np.array([[UG]]), unknowns=("y",)),
    )  # fmt: skip
    found = BiasCorrection("f", Estimate((key,), np.array([UG]), ("m/s^2",), parts), {"y": 20.0}, 1.5e9)
    standards = {
        "turn.axis": Influence(0.1, standard="turn", quantity="axis", redrawn_by="mounting"),
        "converter.zero": Influence(UG, standard="converter", quantity="zero", redrawn_by="certificate"),
    }
    (flip,) = _of_tests(Plan(standards=standards), [found], [])
    assert flip.u == pytest.approx(0.5 * UG)
    assert flip.shared == pytest.approx({"converter.zero[y]": UG})
    with pytest.raises(DataError, match="no date"):
        list(_of_tests(Plan(), [replace(found, time=None)], []))
    with pytest.raises(DataError, match="temperature of y not known"):
        list(_of_tests(Plan(), [replace(found, temperature={})], []))
