"""A campaign with a test of noise: units of data sheets, verdicts by intervals of their own, what was left out."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inertialcal.campaign.engine.run import Outcome, run
from inertialcal.campaign.engine.whole import check
from inertialcal.campaign.start.starter import start
from inertialcal.cli.shown.summary import results_text
from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.show.rows import case_name, reason_text
from inertialcal.core.units import factor
from inertialcal.sensors.noise.simulate import simulate
from inertialcal.sensors.noise.terms import RandomWalk, RateRandomWalk, Sinusoid, Term

SAMPLES, INTERVAL = 6_000, 0.02
WALK, RATE_WALK = 7e-5, 4e-5  # rad/sqrt(s), rad/s/sqrt(s)
BEGIN = 1_300_000_000  # [s]
CAMPAIGN = """\
schema = 2
[campaign]
id = "still"
[sensors.suite]
kind = "gyro"
axes = ["x", "y"]
unit = "deg/s"
[recordings.one]
sensor = "suite"
file = "one.csv"
clock = { column = "unix_s" }
channels = { x = { column = "x", unit = "deg/s" }, y = { column = "y", unit = "deg/s" } }
[[tests]]
id = "noise"
procedure = "static_noise"
recordings = ["one"]
plan = { relative_error = 0.1 }
[[requirements]]
id = "R1"
quantity = "angle_random_walk"
upper = "0.3 deg/sqrt(h)"
"""

Make = Callable[..., Path]


def rates(seed: int = 1) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    terms: dict[str, tuple[Term, ...]] = {
        "x": (RandomWalk(WALK), Sinusoid(2e-3, 9.97)), "y": (RandomWalk(WALK), RateRandomWalk(RATE_WALK))
    }  # fmt: skip
    found = {axis: np.degrees(simulate(own, SAMPLES, INTERVAL, rng)) for axis, own in terms.items()}
    found["y"][3000:3100] += 2.0 * np.sin(np.arange(100) / 3.0)  # a knock
    return found


def csv(columns: dict[str, Any]) -> str:
    stamps = [f"{BEGIN + i * INTERVAL:.2f}" for i in range(len(next(iter(columns.values()))))]
    rows = zip(stamps, *([f"{value:.7g}" for value in one] for one in columns.values()), strict=True)
    return "\n".join([",".join(["unix_s", *columns]), *map(",".join, rows)]) + "\n"


@pytest.fixture(scope="module")
def data() -> str:
    return csv(rates())


@pytest.fixture
def still(tmp_path: Path, data: str) -> Make:
    def write(*replacements: tuple[str, str], content: str | None = None, files: dict[str, str] | None = None) -> Path:
        text = CAMPAIGN
        for old, new in replacements:
            assert old in text, f"the campaign has no {old!r}"
            text = text.replace(old, new, 1)
        for name, lines in {"campaign.toml": text, "one.csv": content or data, **(files or {})}.items():
            (tmp_path / name).write_text(lines, encoding="utf-8")
        return tmp_path

    return write


def row(outcome: Outcome, quantity: str, axis: str, condition: str = "") -> dict[str, Any]:
    rows = outcome.results["results"]
    key = (quantity, axis, condition)
    return next(r for r in rows if (r["quantity"], r["axis"], case_name(r)) == key)


def verdicts(outcome: Outcome) -> dict[tuple[str, str], str]:
    return {(one["requirement"], one["axis"]): one["verdict"] for one in outcome.results["verdicts"]}


# Results


def test_terms_come_in_units_of_data_sheets_with_intervals_of_their_own(still: Make) -> None:
    outcome = run(still(), write=False)
    walk = row(outcome, "angle_random_walk", "x")
    assert walk["unit"] == "deg/sqrt(h)"
    assert walk["value"] == pytest.approx(WALK * factor("rad/sqrt(s)", "deg/sqrt(h)"), rel=0.05)
    assert row(outcome, "rate_random_walk", "y")["unit"] == "deg/h/sqrt(h)"
    limit = row(outcome, "quantization", "x")
    assert (limit["status"], limit["unit"]) == ("upper_limit", "arcsec")
    assert limit["interval"] == {"lo": 0.0, "hi": limit["value"], "p": 0.95}
    assert limit["reason"]
    line = row(outcome, "line_frequency", "x", "line at 9.97 Hz")
    assert line["value"] == pytest.approx(9.97, abs=0.01)
    names = [(one["quantity"], one["axis"]) for one in outcome.results["covariances"][0]["keys"]]
    assert names[:1] == [("angle_random_walk", "x")]


def test_curves_come_in_units_of_the_sensor_and_lengths_in_hours(still: Make) -> None:
    curves = {(one["name"], one["axis"]): one["columns"] for one in run(still(), write=False).results["curves"]}
    assert curves["allan", "x"]["deviation"]["unit"] == "deg/s"
    assert curves["allan", "x"]["tau"]["unit"] == "s"
    assert curves["spectrum", "x"]["density"]["unit"] == "(deg/s)^2/Hz"
    length = curves["record_length", "x"]
    assert length["record"]["unit"] == "h"
    assert length["record"]["values"][0] == pytest.approx(SAMPLES * INTERVAL / 3600.0)
    assert length["relative_error"]["unit"] == "%"


def test_what_was_left_out_is_listed_with_its_rule(still: Make) -> None:
    plan = 'plan = { warm_up = "10 s" }'
    outcome = run(still(("plan = { relative_error = 0.1 }", plan)), write=False)
    rows = {one["rule"]: one for one in outcome.results["exclusions"]}
    assert rows["warm_up"]["count"] == 500
    assert rows["warm_up"]["decided_by"] == "campaign: warm_up = 10 s"
    disturbed = rows["screened"]
    assert (disturbed["axis"], disturbed["decided_by"]) == ("y", "screening: disturbed")
    assert 90 <= disturbed["count"] <= 130
    assert disturbed["counts"] == "sample"
    (step,) = outcome.results["sequence"]
    assert (step["dwells"], step["runs"]) == (1, 1)


def test_the_scale_factor_is_missing_or_part_of_the_uncertainty(still: Make) -> None:
    without = run(still(), write=False)
    (missing,) = without.results["standards"]
    assert (missing["influence"], missing["stated"]) == ("scale_factor", False)
    assert missing["effect"] == "all noise terms in proportion"
    assert without.results["budgets"] == []
    stated = ("[sensors.suite]", '[standards.sensor]\nscale_factor = { u = "10 %" }\n[sensors.suite]')
    found = run(still(stated), write=False)
    assert row(found, "angle_random_walk", "x")["u"] > 2.0 * row(without, "angle_random_walk", "x")["u"]
    sources = {one["source"] for one in found.results["budgets"] if one["quantity"] == "angle_random_walk"}
    assert sources == {"scatter of the noise itself", "scale factor of the sensor"}


def test_counts_go_through_the_chain_and_those_at_the_rail_are_left_out(still: Make) -> None:
    volts = {axis: np.clip(np.rint(2048 + 819 * rate), 0, 4095) for axis, rate in rates().items()}
    volts["x"][1000:1040] = 4095
    chain = (
        "[recordings.one]",
        'chain = { kind = "adc", lsb = "5 V / 4095", counts = [0, 4095], reference = "2.5 V", '
        'scale_factor = "1 V/(deg/s)" }\n[recordings.one]',
    )
    counts = ("x = { column = \"x\", unit = \"deg/s\" }, y = { column = \"y\", unit = \"deg/s\" }",
              "x = { column = \"x\", unit = \"count\" }, y = { column = \"y\", unit = \"count\" }")  # fmt: skip
    outcome = run(still(chain, counts, content=csv(volts)), write=False)
    assert any(one["rule"] == "rail" and one["count"] >= 40 for one in outcome.results["exclusions"])
    assert any(one["code"] == "gaps" and "x: 40 of 6000" in one["what"] for one in outcome.results["remarks"])


def test_an_accelerometer_is_tested_by_the_same_word(still: Make) -> None:
    outcome = run(
        still(
            ('kind = "gyro"', 'kind = "accelerometer"'),
            ('unit = "deg/s"\n', 'unit = "g"\n'),
            ('x = { column = "x", unit = "deg/s" }', 'x = { column = "x", unit = "g" }'),
            ('y = { column = "y", unit = "deg/s" }', 'y = { column = "y", unit = "g" }'),
            ('quantity = "angle_random_walk"', 'quantity = "velocity_random_walk"'),
            ('upper = "0.3 deg/sqrt(h)"', 'upper = "1 g/sqrt(Hz)"'),
        ),
        write=False,
    )
    assert row(outcome, "velocity_random_walk", "x")["unit"] == "ug/sqrt(Hz)"
    assert verdicts(outcome) == {("R1", "x"): "PASS", ("R1", "y"): "PASS"}


def test_windows_are_records_of_their_own(still: Make) -> None:
    windows = [[BEGIN, BEGIN + 40], [BEGIN + 70, BEGIN + 120]]
    outcome = run(still(("plan = {", f"windows = {json.dumps(windows)}\nplan = {{")), write=False)
    conditions = {case_name(r) for r in outcome.results["results"] if case_name(r).startswith("run")}
    assert conditions == {"run one, window 1 alone", "run one, window 2 alone"}
    (step,) = outcome.results["sequence"]
    assert step["dwells"] == 2
    (not_chosen,) = (one for one in outcome.results["exclusions"] if one["rule"] == "not_chosen")
    assert not_chosen["count"] == 1500


def test_an_oblique_mounting_is_said_to_mix_the_sensors(still: Make) -> None:
    mounting = "mounting = [[0.8, 0.6, 0], [-0.6, 0.8, 0], [0, 0, 1]]\n[recordings.one]"
    outcome = run(still(("[recordings.one]", mounting)), write=False)
    assert any(one["code"] == "axes_mixed" for one in outcome.results["remarks"])
    turned = "mounting = [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]\n[recordings.one]"
    outcome = run(still(("[recordings.one]", turned)), write=False)
    assert not any(one["code"] == "axes_mixed" for one in outcome.results["remarks"])
    assert row(outcome, "line_frequency", "y", "line at 9.97 Hz")


@pytest.mark.parametrize("stated", ["5 Hz", "2 Hz"])
def test_a_sensor_states_its_cut_off_and_a_test_goes_before_it(still: Make, stated: str) -> None:
    own = ('cut_off = "5 Hz"\n[recordings.one]', f'plan = {{ cut_off = "{stated}", ')
    replacements = [("[recordings.one]", own[0]), *([("plan = { ", own[1])] if stated != "5 Hz" else [])]
    outcome = run(still(*replacements), write=False)
    remarks = [one["what"] for one in outcome.results["remarks"] if one["code"] == "cut_off_disagrees"]
    assert remarks
    assert all(f"cut-off stated at {stated}" in one for one in remarks)


def test_a_cut_off_that_is_none_is_refused(still: Make) -> None:
    with pytest.raises(PlanError, match="above 0 Hz"):
        run(still(("[recordings.one]", 'cut_off = "0 Hz"\n[recordings.one]')), write=False)


# Verdicts


JUDGED = [
    ("angle_random_walk", 'upper = "0.3 deg/sqrt(h)"', "PASS", "PASS"),
    ("angle_random_walk", 'upper = "0.005 deg/s/sqrt(Hz)"', "PASS", "PASS"),
    ("angle_random_walk", 'upper = "0.2 deg/sqrt(h)"', "FAIL", "FAIL"),
    ("angle_random_walk", 'lower = "0.2 deg/sqrt(h)"\nupper = "0.3 deg/sqrt(h)"', "PASS", "PASS"),
    ("rate_random_walk", 'upper = "1 deg/h/sqrt(h)"', "INCONCLUSIVE", "FAIL"),
    ("rate_random_walk", 'upper = "1e5 deg/h/sqrt(h)"', "PASS", "PASS"),  # by its limit, by its interval
    ("bias_instability", 'upper = "0.1 deg/h"', "INCONCLUSIVE", "INCONCLUSIVE"),
    ("gauss_markov_correlation_time", 'lower = "1 s"', "INCONCLUSIVE", "INCONCLUSIVE"),
]


def test_a_requirement_is_judged_by_the_interval_or_the_upper_limit(still: Make) -> None:
    begin = CAMPAIGN[CAMPAIGN.index("[[requirements]]") :]
    each = [f'[[requirements]]\nid = "R{i}"\nquantity = "{q}"\n{limit}' for i, (q, limit, _, _) in enumerate(JUDGED)]
    outcome = run(still((begin, "\n".join(each) + "\n")), write=False)
    expected = {(f"R{i}", axis): word for i, (_, _, x, y) in enumerate(JUDGED) for axis, word in (("x", x), ("y", y))}
    assert verdicts(outcome) == expected
    assert all(one["reason"] for one in outcome.results["verdicts"])
    for one in outcome.results["verdicts"]:
        quantity = JUDGED[int(one["requirement"][1:])][0]
        assert one["unit"] == row(outcome, quantity, one["axis"])["unit"]


def test_with_one_limit_the_bound_is_one_sided(still: Make) -> None:
    outcome = run(still(), write=False)
    one = next(v for v in outcome.results["verdicts"] if v["axis"] == "y")
    own = row(outcome, "angle_random_walk", "y")
    assert one["interval"]["p"] == 0.9
    assert own["interval"]["lo"] < one["interval"]["lo"]
    assert one["interval"]["hi"] < own["interval"]["hi"]


def stuck() -> str:
    """Return the records with x stuck for 10 s."""
    columns = {axis: np.round(rate, 3) for axis, rate in rates().items()}
    columns["x"][1_000:1_500] = columns["x"][1_000]
    return csv(columns)


def test_stuck_samples_are_left_out_counted_and_told_in_the_unit_of_the_sensor(still: Make) -> None:
    outcome = run(still(content=stuck()), write=False)
    screened = {one["decided_by"]: one for one in outcome.results["exclusions"] if one["rule"] == "screened"}
    one = screened["screening: stuck"]
    assert (one["axis"], one["count"], one["counts"]) == ("x", 500, "sample")
    (remark,) = (one for one in outcome.remarks if one.code == "stuck")
    assert re.match(r"x: stuck at -?0\.\d+ deg/s for 10 s in all; left out", remark.what), remark.what
    assert remark.where == "noise: one.csv:1002"
    assert remark.what in [one.what for one in check(still(content=stuck())).remarks]


def test_a_figure_in_doubt_is_no_pass(still: Make) -> None:
    """Stuck samples that are kept in make noise too small: what then lies inside its limit says nothing."""
    plan = ("plan = { relative_error = 0.1 }", 'plan = { disturbed = "keep", terms = ["random_walk"] }')
    outcome = run(still(plan, ('upper = "0.3 deg/sqrt(h)"', 'limit = "30 deg/sqrt(h)"'), content=stuck()), write=False)
    (x,) = (one for one in outcome.results["verdicts"] if one["axis"] == "x")
    assert x["verdict"] == "INCONCLUSIVE"
    assert x["reason"].startswith("in doubt: ")
    assert reason_text(row(outcome, "angle_random_walk", "x")) == x["reason"]
    assert f"{x['reason']} (x" in results_text(outcome.results)
    assert x["lower"] is None  # a size has no limit below zero
    assert x["margin"] == pytest.approx(30.0 - x["interval"]["hi"])


def test_a_size_by_each_rule(still: Make) -> None:
    """Its own interval, stretched by the factor or of the risk; no specific risk, which takes a distribution."""
    rules = {
        "simple": '{ rule = "simple_acceptance" }',
        "guard": '{ rule = "guard_factor", factor = 2 }',
        "risk": '{ rule = "false_accept_risk", risk = "2 %" }',
    }
    asked = 'quantity = "angle_random_walk"\naxis = "x"\nlimit = "30 deg/sqrt(h)"'
    head = f'[[requirements]]\nid = "{{}}"\n{asked}\ndecision = {{}}\n'
    more = "".join(head.format(*one) for one in rules.items())
    rows = run(still(('[[requirements]]\nid = "R1"', f'{more}[[requirements]]\nid = "R1"')), write=False).results[
        "verdicts"
    ]
    found = {one["requirement"]: one for one in rows if one["axis"] == "x"}
    simple, guard, risk = (found[name] for name in rules)
    assert simple["accept_upper"] == 30.0
    assert guard["accept_upper"] == pytest.approx(30.0 - 2.0 * (guard["interval"]["hi"] - guard["value"]))
    assert simple["accept_upper"] > risk["accept_upper"] > guard["accept_upper"]
    assert {one["verdict"] for one in (simple, guard, risk)} == {"PASS"}
    assert {one["risk"] for one in (simple, guard, risk)} == {None}


# Bytes and report


def test_the_same_inputs_give_the_same_bytes(still: Make) -> None:
    folder = still()
    run(folder)
    first = (folder / "out" / "results.json").read_bytes()
    run(folder)
    assert (folder / "out" / "results.json").read_bytes() == first
    assert str(folder).encode() not in first


def test_the_report_has_figures_terms_and_how_long_to_record(still: Make) -> None:
    folder = still()
    run(folder)
    page = (folder / "out" / "report.html").read_text(encoding="utf-8")
    for words in (
        'id="noise"',
        "fig-allan",
        "fig-spectrum",
        "angle random walk",
    ):
        assert words in page, words
    assert not (folder / "out" / "model.json").exists()


# Refused


@pytest.mark.parametrize(
    ("replacements", "words"),
    [
        ([("plan = { relative_error = 0.1 }", 'use = "hold_out"')], "no model is made of a static_noise"),
        ([("plan = { relative_error = 0.1 }", 'groups = ["1"]')], "names no column of groups.*Choose by windows"),
        ([("relative_error = 0.1", 'terms = ["pink"]')], "plan.terms"),
        ([("relative_error = 0.1", 'warmup = "10 s"')], "unknown key plan.warmup.*Did you mean warm_up"),
        ([('upper = "0.3 deg/sqrt(h)"', 'upper = "0.3 deg/h"')], "cannot be compared.*limit in deg/sqrt"),
        ([('quantity = "angle_random_walk"', 'quantity = "angel_random_walk"')], "Did you mean angle_random_walk"),
        (
            [('channels = { x = { column = "x", unit = "deg/s" }, y = { column = "y", unit = "deg/s" } }',
              'rows = { applied = "x", reading = "y", unit = "deg/s" }'), ('clock = { column = "unix_s" }', "")],
            "recording 'one' has rows, a static_noise needs channels",
        ),
    ],
)  # fmt: skip
def test_a_campaign_that_makes_no_sense_is_refused(
    still: Make, replacements: list[tuple[str, str]], words: str
) -> None:
    with pytest.raises(PlanError, match=words):
        check(still(*replacements))


def test_bad_records_are_refused_with_their_place(still: Make, data: str) -> None:
    lines = data.splitlines()
    swapped = "\n".join([*lines[:101], lines[102], lines[101], *lines[103:]]) + "\n"
    with pytest.raises(DataError, match=r"one.csv:10[23]: 1 stamp\(s\) run backwards"):
        run(still(content=swapped), write=False)
    twice = "\n".join([*lines[:101], lines[100], *lines[101:]]) + "\n"
    with pytest.raises(DataError, match=r"one.csv:102: 1 repeated stamp"):
        run(still(content=twice), write=False)
    constant = csv({axis: np.full(2000, 0.1) for axis in "xy"})
    for judged in (check, partial(run, write=False)):
        with pytest.raises(DataError, match="no noise terms of x, y: the Allan deviation is zero"):
            judged(still(content=constant))
        with pytest.raises(DataError, match="without noise"):
            judged(still(("relative_error = 0.1", 'terms = ["rate_ramp"]')))
        with pytest.raises(DataError, match=r"averaging over 0\.03 s, but samples are 0\.02 s apart"):
            judged(still(('clock = { column = "unix_s" }', 'clock = { column = "unix_s", averaging = "0.03 s" }')))
    with pytest.raises(DataError, match="a warm-up of 600 s, the record is 120 s long"):
        run(still(("relative_error = 0.1", 'warm_up = "10 min"')), write=False)


def test_cells_without_a_number_are_missing_samples(still: Make, data: str) -> None:
    lines = data.splitlines()
    for i in range(200, 260):
        stamp, _, y = lines[i].split(",")
        lines[i] = f"{stamp},{'nan' if i % 2 else ''},{y}"
    outcome = run(still(content="\n".join(lines) + "\n"), write=False)
    assert any("x: 60 of 6000 samples are missing" in one["what"] for one in outcome.results["remarks"])


def still_file(path: Path, seed: int, level: float = 0.0) -> None:
    """Write a record of gyros and accelerometers at rest."""
    values = np.random.default_rng(seed).normal(0.0, 0.05, (2_000, 2))
    lines = [f"{i * 0.01:.2f},{x + level:.5f},{9.81 + y:.5f}" for i, (x, y) in enumerate(values)]
    path.write_text("t [s],gyro_x [deg/s],acc_z [m/s^2]\n" + "\n".join(lines) + "\n", encoding="utf-8")


def test_init_makes_a_test_of_noise_of_what_stands_still(tmp_path: Path) -> None:
    still_file(tmp_path / "a.csv", 1)
    still_file(tmp_path / "b.csv", 2, 0.1)
    path, marked, remarks = start(tmp_path)
    text = path.read_text(encoding="utf-8")
    assert not remarks
    assert [text.splitlines()[number - 1].partition(" ")[0] for number in marked] == ["maker", "part", "serial"]
    assert 'recordings = ["gyros1", "gyros2"]' in text
    path.write_text(text.replace("# FILL IN", ""), encoding="utf-8")
    rows = {(r["test"], r["quantity"], r["axis"], case_name(r)): r for r in run(tmp_path).results["results"]}
    walk = rows["noise_gyros", "angle_random_walk", "x", ""]
    assert walk["value"] == pytest.approx(0.05 * 0.1 * 60.0, rel=0.05)  # deg/sqrt(h)
    assert rows["noise_accelerometers", "velocity_random_walk", "z", ""]["value"] > 0.0


def test_init_takes_a_matlab_file_whose_channels_have_no_axes_and_no_unit(shared: Path, tmp_path: Path) -> None:
    folder = shared / "data/sunsided_mpu6050_static/set-1__unmoved-x-pointing-forward"
    for name in ("mpu6050_gyroscope.mat", "sensor-stats.csv"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    path, marked, remarks = start(tmp_path)
    text = path.read_text(encoding="utf-8")
    assert [one.where for one in remarks] == ["sensor-stats.csv"]  # "sensor" holds text: no table of readings
    assert len(marked) == 3 + 3 + 1  # item, channels, unit
    assert "the axes are taken in the order of the columns; the numbers suggest deg/s: step 0.00763359" in text
    path.write_text(text.replace("# FILL IN", "").replace('"?"', '"deg/s"'), encoding="utf-8")
    assert len(check(tmp_path).inputs) == 2


def test_init_makes_a_test_of_each_set_of_axes(tmp_path: Path) -> None:
    still_file(tmp_path / "a.csv", 1)
    still_file(tmp_path / "b.csv", 2)
    (tmp_path / "b.csv").write_text((tmp_path / "b.csv").read_text().replace("gyro_x", "gyro_y"), encoding="utf-8")
    path, _, _ = start(tmp_path)
    text = path.read_text(encoding="utf-8")
    assert 'id = "noise_gyros_x"' in text
    assert 'id = "noise_gyros_y"' in text
    path.write_text(text.replace("# FILL IN", ""), encoding="utf-8")
    assert len(check(tmp_path).campaign.file.tests) == 3


@pytest.mark.parametrize("levels", [(0.0, 30.0), (-30.0, 30.0)])
def test_dwells_at_rates_of_their_own_are_no_test_of_noise(levels: tuple[float, float], tmp_path: Path) -> None:
    for number, level in enumerate(levels):
        still_file(tmp_path / f"{number}.csv", number, level)
    text = start(tmp_path)[0].read_text(encoding="utf-8")
    assert "static_noise" not in text
    assert 'procedure = "rate_table"' in text
