"""Readings that would count twice are refused, by what they are."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from inertialcal.campaign.engine.run import run
from inertialcal.campaign.engine.whole import check
from inertialcal.campaign.inputs.duplicates import Content, duplicates
from inertialcal.core.errors import DataError
from inertialcal.signals.fingerprints import fingerprints

Write = Callable[..., Path]


def rows(runs: int, digits: int = 6, seed: int = 1) -> list[list[str]]:
    rng = np.random.default_rng(seed)
    rates = (-4.0, -2.0, -1.0, -0.5, 0.5, 1.0, 2.0, 4.0)
    return [
        [f"{rate},{1.01 * rate + rng.normal(0.0, 0.002):.{digits}f},0.004,1" for rate in rates] for _ in range(runs)
    ]


def table(runs: list[list[str]]) -> str:
    lines = [f"{row},{number}" for number, own in enumerate(runs, 1) for row in own]
    return "\n".join(["rate,x,std,set,run", *lines]) + "\n"


def codes(folder: Path) -> list[tuple[str, str]]:
    with pytest.raises(DataError) as error:
        run(folder, write=False)
    return [(one.code, one.what) for one in error.value.problems]


def test_runs_that_are_equal_in_every_reading_are_refused(campaign: Write) -> None:
    runs = rows(6)
    runs[3] = runs[1]
    ((code, what),) = codes(campaign(data=table(runs)))
    assert code == "duplicate_recording"
    assert "runs 2 and 4 hold 8 rows that are equal in every reading" in what


def test_a_table_that_is_appended_to_itself_is_refused(campaign: Write) -> None:
    runs = [[line for own in rows(3) for line in own] * 2]
    ((code, what),) = codes(campaign(data=table(runs)))
    assert (code, "one.csv:2 on" in what) == ("repeated", True)


def test_coarse_readings_are_no_copies(campaign: Write) -> None:
    for seed in range(3):
        folder = campaign(data=table(rows(6, digits=2, seed=seed)))
        assert not {one.code for one in check(folder).remarks} & {"repeated", "duplicate_recording"}


def recording(seed: int) -> str:
    """Write three axes at 10 samples/s: turned about x at six rates, a minute each."""
    rng = np.random.default_rng(seed)
    rate = np.repeat([0.0, 1.0, -1.0, 2.0, -2.0, 0.0], 100)
    lines = ["time [s],rate [deg/s],x [deg/s],y [deg/s],z [deg/s]"]
    for i, one in enumerate(rate):
        x, y, z = np.array([one, 0.0, 0.0]) + rng.normal(0.0, 0.01, 3)
        lines.append(f"{0.1 * i:.1f},{one},{x:.6f},{y:.6f},{z:.6f}")
    return "\n".join(lines) + "\n"


@pytest.fixture
def fit_and_held_out(tmp_path: Path) -> Path:
    axes = "".join(f'{axis} = {{ column = "{axis} [deg/s]", unit = "deg/s" }}\n' for axis in "xyz")
    axes += 'applied = { column = "rate [deg/s]", unit = "deg/s" }\n'
    text = (
        'schema = 2\n[campaign]\nid = "two"\n[sensors.suite]\nkind = "gyro"\nunit = "deg/s"\naxes = ["x", "y", "z"]\n'
    )
    for name in ("a", "b"):
        text += f'[recordings.{name}]\nsensor = "suite"\nfile = "{name}.csv"\naxis = "x"\nrun = "{name}"\n'
        text += f"[recordings.{name}.channels]\n{axes}"
    for name, use in (("a", "fit"), ("b", "hold_out")):
        text += f'[[tests]]\nid = "{use}"\nprocedure = "rate_table"\nrecordings = ["{name}"]\nuse = "{use}"\n'
        text += "plan = { zero_reference = true }\n"
    (tmp_path / "campaign.toml").write_text(text)
    (tmp_path / "a.csv").write_text(recording(1))
    return tmp_path


@pytest.mark.parametrize("what", [run, check])
def test_a_hold_out_that_is_a_copy_of_the_fit_is_refused(
    fit_and_held_out: Path, what: Callable[[Path], object]
) -> None:
    (fit_and_held_out / "b.csv").write_text(recording(1))
    with pytest.raises(DataError) as error:
        what(fit_and_held_out)
    (problem,) = (one for one in error.value.problems if one.code == "duplicate_recording")
    assert problem.what == "recordings a (a.csv) and b (b.csv) hold the same samples"
    assert problem.where == "b.csv"


def test_a_stretch_of_the_fit_in_the_hold_out_is_refused(fit_and_held_out: Path) -> None:
    own, other = recording(1).splitlines(), recording(2).splitlines()
    for row in range(300):  # the readings, not the time
        other[201 + row] = ",".join([other[201 + row].split(",")[0], *own[101 + row].split(",")[1:]])
    (fit_and_held_out / "b.csv").write_text("\n".join(other) + "\n")
    with pytest.raises(DataError, match=r"hold the same 2.. samples, from"):
        check(fit_and_held_out)


def test_columns_are_named_with_or_without_the_unit_in_brackets(fit_and_held_out: Path) -> None:
    (fit_and_held_out / "b.csv").write_text(recording(2))
    full = run(fit_and_held_out, write=False).results["results"]
    file = fit_and_held_out / "campaign.toml"
    file.write_text(file.read_text().replace(' [deg/s]"', '"'))
    assert run(fit_and_held_out, write=False).results["results"] == full
    rows = (fit_and_held_out / "a.csv").read_text().splitlines()
    rows[50] = rows[50].rpartition(",")[0] + ",nan"
    (fit_and_held_out / "a.csv").write_text("\n".join(rows) + "\n")
    with pytest.raises(DataError, match="literal 'NaN' in required column"):
        check(fit_and_held_out)


def test_each_copy_is_named_once_with_the_first() -> None:
    x, y = (np.random.default_rng(seed).normal(size=2000) for seed in (1, 2))
    held = {"a": x, "b": x, "other": y, "c": x, "d": x}
    contents = [Content(name, f"{name}.csv", fingerprints([one])) for name, one in held.items()]
    found = [problem.what for problem in duplicates(contents)]
    assert found == [f"recordings a (a.csv) and {name} ({name}.csv) hold the same samples" for name in "bcd"]
