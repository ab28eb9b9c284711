"""What two results share: certificates, mountings, readings; and what compare makes of it."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from independent import rate_table
from independent.trial import called
from inertialcal.campaign.compare.common import common_of
from inertialcal.campaign.compare.compare import Comparison, compare
from inertialcal.campaign.compare.differences import differences
from inertialcal.campaign.compare.sources import Compared, load_both
from inertialcal.core.errors import UsageError
from inertialcal.core.influence import Drawn, Influence, Occasion, Selection
from inertialcal.core.key import Key
from inertialcal.core.results import Curvature, Row
from inertialcal.files.models.model_json import read_model, write_model
from inertialcal.sensors.model.serial import from_dict, to_dict

RATE = Influence(5e-4, "1", certificate="C-1", standard="rate_table", quantity="rate", redrawn_by="certificate")
LAID = Influence(2e-3, "rad", standard="rate_table", quantity="mounting", redrawn_by="mounting")
PLACE = Influence(1e-3, "m/s^2", standard="gravity", quantity="value", redrawn_by="never")
CONSTANT = Influence(2e-5, "1", standard="source_mass", quantity="gravitational_constant", redrawn_by="never")
CASES = [  # of two errors: why they differ, what is not known
    (Drawn(RATE), Drawn(RATE), "", ""),
    (Drawn(RATE), Drawn(replace(RATE, u=0.05, unit="%")), "", ""),
    (Drawn(RATE), Drawn(replace(RATE, certificate="C-2")), "certificate 'C-1' in the first, 'C-2' in the second", ""),
    (Drawn(replace(RATE, valid="2026")), Drawn(replace(RATE, valid="2027")), "valid '2026' in the first", ""),
    (Drawn(replace(RATE, valid="2026")), Drawn(RATE), "", "valid"),
    (Drawn(replace(RATE, certificate="")), Drawn(RATE), "", "certificate"),
    (Drawn(RATE), Drawn(replace(RATE, u=1e-3)), "u = 0.0005 in the first, 0.001 in the second", ""),
    (Drawn(LAID, "A"), Drawn(LAID, "A"), "", ""),
    (Drawn(LAID, "A"), Drawn(LAID, "B"), "mounting 'A' in the first, 'B' in the second", ""),
    (Drawn(LAID), Drawn(LAID, "B"), "", "mounting"),
    (Drawn(LAID, "A", "7"), Drawn(LAID, "A", "8"), "two units, each with its own mounting", ""),
    (Drawn(RATE, "", "7"), Drawn(RATE, "", "8"), "", ""),
    (Drawn(PLACE, "here"), Drawn(PLACE, "here"), "", ""),
    (Drawn(PLACE, "here"), Drawn(PLACE, "there"), "site 'here' in the first, 'there' in the second", ""),
    (Drawn(PLACE), Drawn(PLACE), "", "site"),
    (Drawn(CONSTANT), Drawn(CONSTANT), "", ""),
    (Drawn(replace(RATE, redrawn_by="dwell")), Drawn(replace(RATE, redrawn_by="dwell")), "drawn anew", ""),
]  # fmt: skip


@pytest.mark.parametrize(("one", "other", "differs", "unknown"), CASES)
def test_which_errors_are_the_same(one: Drawn, other: Drawn, differs: str, unknown: str) -> None:
    assert one.differs(other).startswith(differs)
    assert bool(one.differs(other)) == bool(differs)
    if not differs:
        assert one.unknown(other) == unknown
        assert other.unknown(one) == unknown


def test_an_occasion_says_what_drew_an_error() -> None:
    one = Occasion("laying 1", "run 3", "2026-11-20", "gravity 9.8 m/s^2")
    drew = [one.drew(by, "pad") for by in ("mounting", "power_up", "day", "certificate", "never")]
    assert drew == ["laying 1", "run 3", "2026-11-20", "", ""]
    assert one.drew("never", "gravity") == "gravity 9.8 m/s^2"
    assert one.joined(one._replace(day="2026-11-21")) == one._replace(day="")


def test_a_term_that_two_conditions_take_from_one_test_is_one_figure() -> None:
    """The model of vacuum has the scale factor that the table gave in air; the readings behind its bias are its own."""

    def side(own: str, bias: float) -> Compared:
        rows = (Row(Key("scale_factor_error", "x"), 0.01, 2e-4, "1", 4.0, test="rate_x"),
                Row(Key("bias", "x"), bias, 1e-3, "rad/s", 4.0, test=f"thermal_{own}"))  # fmt: skip
        selections = {"": (Selection(("table",)), Selection((own,)))}
        return Compared(f"{own}.json", own, rows, "", frozenset(), {}, selections=selections)

    first, second = side("air", 0.1), side("vacuum", 0.2)
    common = common_of(first, second)
    assert [common.identical(*pair) for pair in zip(first.rows, second.rows, strict=True)] == [True, False]
    other = replace(second, selections={"": (Selection(("another table",)), Selection(("vacuum",)))})
    assert not common_of(first, other).identical(first.rows[0], other.rows[0])


def test_readings_overlap_where_they_can() -> None:
    one = Selection(("a", "b"), ("1",))
    assert one.overlap(Selection(("b", "c"))) == {"b"}
    assert not one.overlap(Selection(("b",), ("2",)))
    assert not Selection(("b",), (), ((0, 5),)).overlap(Selection(("b",), (), ((5, 9),)))
    assert Selection(("b",), (), ((0, 5),)).overlap(Selection(("b",), (), ((4, 9),))) == {"b"}


CERTIFIED = {"rate_table.rate": {"u": "0.05 %", "certificate": "C-1"}, "rate_table.mounting": {"u": "2 mrad"}}
BARE = {"rate_table.rate": {"u": "0.05 %"}, "rate_table.mounting": {"u": "2 mrad"}}


def campaign(folder: Path, again: int, **protocol: Any) -> Path:
    """A small rate-table campaign that was run: one unit, ``again`` draws the noise."""
    gyros = rate_table.Gyros(turn_on=0.003, dwell=0.003, table_rate=5e-4, fixture=2e-3)
    given = rate_table.Protocol(runs=2, standards=protocol.pop("standards", CERTIFIED), **protocol)
    case = rate_table.reduced(1, gyros, given, again)
    assert called(case.write(folder), folder).exit == 0
    return folder


@pytest.fixture(scope="module")
def pairs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """One test a folder: a and b in one mounting, c in another; d without certificate and mounting."""
    root = tmp_path_factory.mktemp("pairs")
    for name, again, given in (
        ("a", 0, {"mounting": "laying 1"}), ("b", 1, {"mounting": "laying 1"}), ("c", 2, {"mounting": "laying 2"}),
        ("d", 3, {"standards": BARE}),
    ):  # fmt: skip
        campaign(root / name, again, **given)
    yield root
    shutil.rmtree(root)


def u_of(found: Comparison, quantity: str, axis: str) -> float:
    rows = (one.row for one in found.differences if one.row.case.plain)
    return next(row.u or 0.0 for row in rows if (row.quantity, row.axis) == (quantity, axis))


def remark(found: Comparison, code: str) -> str:
    return " ".join(one.what for one in found.remarks if one.code == code)


@pytest.mark.parametrize("file", ["", "out/model.json"], ids=["results", "models"])
def test_one_certificate_and_one_mounting_cancel(pairs: Path, file: str) -> None:
    same, remounted = (compare(pairs / "a" / file, pairs / name / file) for name in "bc")
    assert u_of(same, "scale_factor_error", "x") < 0.05  # %: the table alone has 0.07 in two independent results
    assert u_of(same, "misalignment", "xz") < 5e-4
    assert u_of(remounted, "scale_factor_error", "x") < 0.05
    assert u_of(remounted, "misalignment", "xz") == pytest.approx(2.0**0.5 * 2e-3, rel=0.05)
    assert "rate_table.rate: 0.07" in remark(same, "standards_shared")
    assert "rate_table.mounting: 0.0028 rad of misalignment" in remark(same, "standards_shared")
    assert "mounting 'laying 1' in the first, 'laying 2' in the second" in remark(remounted, "standards_redrawn")


@pytest.mark.parametrize("file", ["", "out/model.json"], ids=["results", "models"])
def test_what_is_not_stated_is_independent_unless_the_user_knows_it(pairs: Path, file: str) -> None:
    one, other = pairs / "a" / file, pairs / "d" / file
    found = compare(one, other)
    assert u_of(found, "scale_factor_error", "x") > 0.07
    assert "rate_table.mounting (the mounting is not stated in both)" in remark(found, "standards_may_be_shared")
    do = next(one.do for one in found.remarks if one.code == "standards_may_be_shared")
    assert "--shared rate_table.mounting --shared rate_table.rate" in do
    told = compare(one, other, shared=["rate_table.rate", "rate_table.mounting"])
    assert u_of(told, "scale_factor_error", "x") < 0.05
    assert u_of(told, "misalignment", "xz") < 5e-4
    assert "rate_table.rate (as --shared says)" in remark(told, "standards_shared")


def test_shared_takes_names_of_standards_in_both_that_do_not_differ(pairs: Path) -> None:
    with pytest.raises(UsageError, match=r"no standard of that name is in both.*rate_table.mounting, rate_table.rate"):
        compare(pairs / "a", pairs / "b", shared=["gravity.value"])
    other = json.loads((pairs / "b/out/model.json").read_text())
    assert other["models"][""]["influences"]["rate_table.rate"]["certificate"] == "C-1"
    model = read_model(pairs / "b/out/model.json")
    renewed = replace(model.influences["rate_table.rate"], certificate="C-2")
    influences = {**model.influences, "rate_table.rate": renewed}
    write_model(pairs / "renewed.json", replace(model, influences=influences))
    with pytest.raises(UsageError, match="certificate 'C-1' in the first, 'C-2' in the second"):
        compare(pairs / "a/out/model.json", pairs / "renewed.json", shared=["rate_table.rate"])
    found = compare(pairs / "a/out/model.json", pairs / "renewed.json")
    assert u_of(found, "scale_factor_error", "x") > 0.07


@pytest.mark.parametrize("file", ["", "out/results.json", "out/model.json"])
def test_compared_with_itself_every_difference_is_zero(pairs: Path, file: str) -> None:
    found = compare(pairs / "a" / file, pairs / "a" / file, ["0.1 %"])
    rows = [one for one in found.differences if one.word != "not compared"]
    assert rows
    assert all((one.row.value, one.row.u, one.word) == (0.0, 0.0, "not shown different") for one in rows)
    assert found.verdict == "PASS"
    codes = {one.code for one in found.remarks}
    assert "same_file" in codes
    assert not codes & {"taken_as_independent", "judged_by_quantity", "standards_may_be_shared"}


@pytest.mark.parametrize("file", ["", "out/model.json"], ids=["results", "models"])
def test_shared_is_refused_where_both_state_two_mountings(pairs: Path, file: str) -> None:
    with pytest.raises(UsageError, match="mounting 'laying 1' in the first, 'laying 2' in the second"):
        compare(pairs / "a" / file, pairs / "c" / file, shared=["rate_table.mounting"])


def test_the_same_readings_reduced_again_differ_by_nothing(pairs: Path, tmp_path: Path) -> None:
    """Another campaign file, the same recordings: files differ, figures do not."""
    shutil.copytree(pairs / "a", tmp_path / "again")
    text = (tmp_path / "again/campaign.toml").read_text()
    (tmp_path / "again/campaign.toml").write_text(text.replace('id = "gyros"', 'id = "again"'))
    assert called(["run", str(tmp_path / "again")], tmp_path).exit == 0
    for file in ("", "out/model.json"):
        found = compare(pairs / "a" / file, tmp_path / "again" / file)
        rows = [one.row for one in found.differences if one.word != "not compared"]
        assert rows
        assert all(row.value == row.u == 0.0 for row in rows)
        assert not remark(found, "standards_may_be_shared")
    assert "the same figure out of the same readings" in remark(
        compare(pairs / "a", tmp_path / "again"), "same_readings"
    )


def test_the_same_readings_reduced_another_way_are_not_independent(pairs: Path, tmp_path: Path) -> None:
    shutil.copytree(pairs / "a", tmp_path / "other")
    text = (tmp_path / "other/campaign.toml").read_text()
    text = text.replace('rate = { u = "0.05 %", certificate = "C-1" }\n', "").replace('id = "rates"', 'id = "less"')
    (tmp_path / "other/campaign.toml").write_text(text)
    assert called(["run", str(tmp_path / "other")], tmp_path).exit == 0
    found = compare(pairs / "a", tmp_path / "other")
    assert "table.csv: not independent" in remark(found, "same_recordings")


def test_a_model_keeps_what_it_shares(pairs: Path) -> None:
    model = read_model(pairs / "a/out/model.json")
    assert model.occasion.mounting == "laying 1"
    assert model.influences["rate_table.rate"].certificate == "C-1"
    assert len(model.selections) == 1
    assert model.estimate is not None
    shared = model.estimate.shared("misalignment_xz")
    assert abs(shared["rate_table.mounting[zx]"]) == pytest.approx(2e-3, rel=0.02)
    assert to_dict(from_dict(to_dict(model))) == to_dict(model)


def test_a_model_file_from_before_sensitivities_were_stored_is_read(pairs: Path) -> None:
    content = json.loads((pairs / "a/out/model.json").read_text())
    stored = content["models"][""]
    for name in ("influences", "occasion", "selections"):
        del stored[name]
    for one in stored["estimate"]["components"]:
        for name in ("origin", "unknowns", "changes"):
            del one[name]
    model = from_dict({name: value for name, value in content.items() if name != "checksum"}).only()
    assert model.estimate is not None
    assert not model.estimate.shared("misalignment_xz")
    assert model.occasion == Occasion()


@pytest.mark.parametrize(("mountings", "fails"), [(("laying 1", "laying 1"), True), (("laying 1", "laying 2"), False)])
def test_a_model_is_not_judged_by_another_mounting(tmp_path: Path, mountings: tuple[str, str], fails: bool) -> None:
    """The unit was laid anew before the readings held out: its angles differ, and where that is stated they are known.

    Of one mounting they would be a wrong model.
    """
    gyros = rate_table.Gyros(scale=(0.0, 0.0, 0.0), bias=(0.0, 0.0, 0.0), misalignment=0.0, dwell=1e-4, fixture=5e-3)
    given = rate_table.Protocol(standards={"rate_table.mounting": {"u": "5 mrad"}}, mounting=mountings[0])
    fit, held = rate_table.reduced(3, gyros, given), rate_table.reduced(3, gyros, given, 1, remounted=True)
    fit.tables["held.csv"] = held.tables["table.csv"]
    runs = fit.tables["held.csv"].columns["run"]
    fit.tables["held.csv"].columns["run"] = np.array([f"later {run}" for run in runs], dtype=object)
    folder = tmp_path / "campaign"
    words = fit.write(folder)
    path = folder / "campaign.toml"
    text = path.read_text()
    start = text.index("[recordings.table]")
    entry, test = text[start : text.index("[[tests]]")], text[text.index("[[tests]]") :]
    later = entry.replace(".table]", ".held]").replace("table.csv", "held.csv")
    held_out = test.replace('"rates"', '"judged"\nuse = "hold_out"').replace('["table"]', '["held"]')
    held_out = held_out.replace("laying 1", mountings[1])
    path.write_text(text[:start] + entry + later + test + held_out)
    called(words, folder)
    found = json.loads((folder / "out/results.json").read_text())["closed_loop"]
    assert (found["verdict"] == "FAIL") == fails


def side(serial: str, change: float, size: float) -> Compared:
    """Return a result of one scale factor, whose line lacks a third-order term."""
    row = Row(Key("scale_factor_error", "x"), 0.1, math.hypot(0.01, change * size), "%",
              curvature={"third_order_x": Curvature(change, size)})  # fmt: skip
    return Compared(f"{serial} {change} {size}", f"{change} {size}", (row,), serial, frozenset(), {})


@pytest.mark.parametrize(
    ("first", "second", "u", "code"),
    [
        (("", 5.0, 0.02), ("7", 5.0, 0.0), 2.0**0.5 * 0.01, "curvature_shared"),
        (("8", 5.0, 0.02), ("7", 5.0, 0.0), math.hypot(0.01, 0.01, 0.1), "different_serials"),
        (("7", 5.0, 0.02), ("7", 4.0, 0.01), math.hypot(0.01, 0.01, 0.02), "curvature_differs"),
        (("7", 0.0, 0.02), ("7", 5.0, 0.0), math.hypot(0.01, 0.01, 0.1), "curvature_differs"),
    ],
    ids=["one unit", "two units", "other rates", "seen in the first alone"],
)
def test_a_curvature_that_a_line_lacks_cancels_for_one_unit_at_one_set_of_rates(
    first: tuple[str, float, float], second: tuple[str, float, float], u: float, code: str
) -> None:
    common = common_of(side(*first), side(*second))
    pair = (common.first.rows[0], common.second.rows[0])
    assert differences([pair], common)[0].row.u == pytest.approx(u)
    assert [one.code for one in common.remarks([pair])] == [code]


@pytest.mark.parametrize("file", ["", "out/model.json"], ids=["results", "models"])
def test_curvatures_stand_in_results_and_models(pairs: Path, file: str) -> None:
    (sides,) = load_both(pairs / "a" / file, pairs / "b" / file)[1]
    scales = [row for one in sides for row in one.rows if str(row.key) == "scale_factor_error_x" and row.case.plain]
    terms = [row.curvature["third_order_x"] for row in scales]
    assert terms[0].change == pytest.approx(terms[1].change, rel=1e-6)
    assert terms[0].change > 0.0
