"""The tests as they were run, and what each drew on: every row and sample is accounted for."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

from inertialcal.core.times import read_instant
from ran_campaigns import Ran, ran


def test_tests_stand_in_the_order_run_with_the_files_they_drew_on(campaign_ran: Ran) -> None:
    rows = campaign_ran.results["sequence"]
    assert [row["test"] for row in rows] == [one.test.id for one in campaign_ran.prepared]
    for row, one in zip(rows, campaign_ran.prepared, strict=True):
        assert [r["name"] for r in row["recordings"]] == list(one.test.recordings)
        for recording in row["recordings"]:
            raw = (campaign_ran.folder / recording["file"]).read_bytes()
            assert recording["sha256"] == hashlib.sha256(raw).hexdigest()
            lines = [line for line in raw.decode().splitlines() if line and not line.startswith("#")]
            assert recording["rows"] == len(lines) - 1  # the header


def test_rows_of_tables_are_dwells_or_counted_as_left_out(published: Ran) -> None:
    for row in published.results["sequence"]:
        mine = [one for one in published.results["exclusions"] if one["test"] == row["test"]]
        not_chosen = sum(one["count"] for one in mine if one["rule"] == "not_chosen")
        assert {recording["kind"] for recording in row["recordings"]} == {"table"}
        assert sum(recording["rows"] for recording in row["recordings"]) == row["dwells"] + not_chosen
        assert row["left_out"] == sum(one["count"] for one in mine if one["rule"] != "not_chosen")


def test_samples_of_recordings_are_those_of_the_remark(simulated: Ran) -> None:
    for row in simulated.results["sequence"]:
        said = next(r for r in simulated.results["remarks"] if (r["code"], r["where"]) == ("dwells", row["test"]))
        assert {recording["kind"] for recording in row["recordings"]} == {"recording"}
        samples = sum(recording["rows"] for recording in row["recordings"])
        assert f"{len(row['recordings'])} recordings, {samples} samples" in said["what"]
    fit, check = simulated.results["sequence"]
    assert (fit["use"], check["use"]) == ("fit", "hold_out")
    assert (fit["runs"], check["runs"]) == (3, 2)
    assert fit["dwells"] == 3 * 3 * 7
    incomplete = [r for r in simulated.results["exclusions"] if r["rule"] == "dwell_incomplete" and r["test"] == "fit"]
    assert fit["left_out"] == len(incomplete)


def test_groups_stand_there_and_nothing_else_is_null(published: Ran) -> None:
    rows = {row["test"]: row for row in published.results["sequence"]}
    assert rows["rate_x"]["groups"] is None
    assert rows["rate_x_set1"]["groups"] == ["1"]
    assert rows["rate_x"]["windows"] is None


def test_windows_come_out_as_instants_that_can_be_pasted_back(campaign: Callable[..., Path]) -> None:
    head, *rows = ["time,rate,x,std,set,run"] + [
        f"{1272467400 + 10 * i},{rate},{1.01 * rate},0.004,1,{run}"
        for i, (run, rate) in enumerate((run, rate) for run in range(1, 7) for rate in (-4, -2, -1, 1, 2, 4))
    ]
    window = '[["2010-04-28T15:10:00Z", "2010-04-28T15:15:00.5+00:00"]]'
    found = ran(
        campaign(
            ('run = "run", unit', 'run = "run", time = "time", unit'),
            ('recordings = ["one"]', f'recordings = ["one"]\nwindows = {window}'),
            data="\n".join([head, *rows, ""]),
        )
    )
    (row,) = found.results["sequence"]
    assert row["windows"] == [["2010-04-28T15:10:00Z", "2010-04-28T15:15:00.5Z"]]
    assert [read_instant(text) for text in row["windows"][0]] == list((found.prepared[0].test.windows or [])[0])
    assert row["dwells"] == 31  # 0 to 300 s in steps of 10 s
    (left,) = found.results["exclusions"]
    assert (left["decided_by"], left["count"]) == ("campaign: windows", 5)
