"""`allan` and `psd` on the command line: what a newcomer reads, JSON, files, one clear message for bad input."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from inertialcal.cli.__main__ import main
from inertialcal.core.units import factor
from inertialcal.sensors.noise.simulate import simulate
from inertialcal.sensors.noise.terms import BiasInstability, RandomWalk
from typed_commands import call_json

N, INTERVAL = 6_000, 0.01
WALK = 0.24  # deg/sqrt(h)
STAMPS: NDArray[np.float64] = np.asarray(np.arange(N) * INTERVAL, dtype=np.float64)

Write = Callable[..., str]


def call(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as left:
        main(list(words))
    out, err = capsys.readouterr()
    assert "Traceback" not in out + err
    assert "internal error" not in out + err
    return int(left.value.code or 0), out, err


def rates(seed: int = 1) -> NDArray[np.float64]:
    """Return white noise [deg/s]."""
    size = WALK * factor("deg/sqrt(h)", "rad/sqrt(s)")
    return np.degrees(simulate(RandomWalk(size), N, INTERVAL, np.random.default_rng(seed)))


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def file(name: str, head: str, *columns: Any) -> str:
        cells = [["" if value != value else repr(value) for value in np.asarray(one).tolist()] for one in columns]  # noqa: PLR0124 - NaN
        text = "\n".join([head, *map(",".join, zip(*cells, strict=True))]) + "\n"
        (tmp_path / name).write_text(text, encoding="utf-8")
        return str(tmp_path / name)

    return file


@pytest.fixture
def good(write: Write) -> str:
    return write("imu.csv", "time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]", STAMPS, *map(rates, (1, 2, 3)))


# What a newcomer reads


def test_terms_stand_with_their_error_bars_and_how_long_to_record(
    capsys: pytest.CaptureFixture[str], good: str
) -> None:
    status, out, err = call(capsys, "allan", good)
    assert (status, err) == (0, "")
    lines = {tuple(line.split()[:2]): line for line in out.splitlines() if len(line.split()) > 2}
    walk = lines["angle_random_walk", "x"]
    assert float(walk.split()[2]) == pytest.approx(WALK, rel=0.05)
    assert "±" in walk
    assert "deg/sqrt(h)" in walk
    assert "rad/s/sqrt(Hz)" in walk
    assert "known to" in walk
    missing = re.sub(r"\s+", " ", out.partition("not found: ")[2].partition("\n\n")[0])
    assert re.search(r"x: record too short: .*bias_instability < \d\S* deg/h \(\d+ min\)", missing)
    assert missing.count("record too short") == 3  # one line an axis
    assert out.startswith("gyro: 60 s at 100 Hz")
    assert call(capsys, "allan", good, "--quiet") == (0, "", "")


def test_info_leads_to_allan(capsys: pytest.CaptureFixture[str], good: str) -> None:
    _, out, _ = call(capsys, "info", good)
    assert out.rstrip().endswith(f"next: inertialcal allan {good}")


def test_the_json_has_rows_curves_and_remarks(capsys: pytest.CaptureFixture[str], good: str) -> None:
    content = call_json(
        capsys, "allan", good, "--for", "kalibr", "--tau", "0.1 s", "--tau", "1 s", "--deviation", "hadamard"
    )
    rows = {(row["quantity"], row["axis"]): row for row in content["results"]}
    assert rows["angle_random_walk", "y"]["unit"] == "deg/sqrt(h)"
    assert rows["angle_random_walk", "y"]["test"] == "gyro"
    assert content["inputs"][0]["path"] == good
    assert "gyroscope_noise_density" in content["filters"]["kalibr"]["text"]
    assert content["verdicts"] == content["errors"] == []


def test_several_files_are_fitted_together(capsys: pytest.CaptureFixture[str], write: Write) -> None:
    head = "time [s],gyro_x [deg/s]"
    files = [write(f"{seed}.csv", head, STAMPS, rates(seed)) for seed in (1, 2)]
    status, out, _ = call(capsys, "allan", *files)
    assert status == 0
    assert "in 2 records" in out
    assert "the records agree" in out
    assert "alone" in out
    worse = write("3.csv", head, STAMPS, 2.0 * rates(3))
    _, out, _ = call(capsys, "allan", files[0], worse)
    assert "do not agree" in out


def test_settings_of_a_filter_can_be_pasted(capsys: pytest.CaptureFixture[str], good: str) -> None:
    status, out, err = call(capsys, "allan", good, "--column", "gyro_x [deg/s]", "--for", "kalibr", "--for", "px4")
    assert (status, err) == (0, "")
    assert "gyroscope_noise_density: " in out
    assert "param set EKF2_GYR_NOISE " in out


def test_a_horizon_makes_a_walk_of_what_wanders(capsys: pytest.CaptureFixture[str], write: Write) -> None:
    rng = np.random.default_rng(4)
    size = WALK * factor("deg/sqrt(h)", "rad/sqrt(s)")
    wander = np.degrees(simulate((RandomWalk(size), BiasInstability(10.0 * size)), N, INTERVAL, rng))
    file = write("wander.csv", "time [s],gyro_x [deg/s]", STAMPS, wander)
    words = ("allan", file, "--terms", "random_walk", "--terms", "bias_instability", "--for", "kalibr")
    said = []
    for horizon in ("10 s", "40 s"):
        status, out, _ = call(capsys, *words, "--horizon", horizon)
        assert status == 0
        said.append(float(out.partition("gyroscope_random_walk: ")[2].split()[0]))
    assert said[0] / said[1] == pytest.approx(2.0, rel=0.01)  # B is flat, a walk rises with the root of time
    assert call(capsys, *words, "--horizon", "soon")[0] == 2


def test_the_spectrum_names_lines_and_is_held_against_the_allan_deviation(
    capsys: pytest.CaptureFixture[str], write: Write
) -> None:
    humming = rates() + 0.02 * np.sin(2.0 * np.pi * 20.0 * STAMPS)
    file = write("hum.csv", "time [s],gyro_x [deg/s]", STAMPS, humming)
    status, out, err = call(capsys, "psd", file)
    assert (status, err) == (0, "")
    assert "spectrum (welch)" in out
    assert "20 Hz" in out
    assert "Allan deviation and spectrum agree" in out
    assert "angle_random_walk" in out
    content = call_json(capsys, "psd", file, "--spectrum", "multitaper", "--segment", "10 s")
    assert "line_amplitude" in {row["quantity"] for row in content["results"]}


# Files


def test_a_folder_takes_everything_and_a_file_one_figure(
    capsys: pytest.CaptureFixture[str], good: str, tmp_path: Path
) -> None:
    status, out, _ = call(capsys, "allan", good, "-o", str(tmp_path / "found"), "--for", "px4")
    assert status == 0
    names = {path.name for path in (tmp_path / "found").iterdir()}
    assert names == {"allan_gyro.png", "spectrum_gyro.png", "curves.csv", "terms.json", "px4.params"}
    assert out.count("written: ") == len(names)
    for words, name in ((("allan",), "a.svg"), (("allan", "--figure", "spectrum"), "b.svg"), (("psd",), "c.svg")):
        command, *more = words
        status, out, _ = call(capsys, command, good, *more, "-o", str(tmp_path / name))
        assert status == 0
        assert f"written: {tmp_path / name}" in out
        assert (tmp_path / name).read_text(encoding="utf-8").startswith("<?xml")
    content = call_json(capsys, "psd", good, "-o", str(tmp_path / "spectra"))
    assert str(tmp_path / "spectra" / "spectrum_gyro.png") in content["written"]


# Bad input


HEAD = "time [s],gyro_x [deg/s]"


def missing() -> NDArray[np.float64]:
    values = rates()
    values[np.random.default_rng(3).random(N) < 0.1] = np.nan
    return values


def stuck() -> NDArray[np.float64]:
    values = np.round(rates(), 3)
    values[2000:2600] = values[2000]
    return values


def late() -> NDArray[np.float64]:
    stamps = STAMPS.copy()
    stamps[3000:] -= INTERVAL
    return stamps


def swapped() -> NDArray[np.float64]:
    stamps = STAMPS.copy()
    stamps[[3000, 3001]] = stamps[[3001, 3000]]
    return stamps


SHUFFLED = np.random.default_rng(5).permutation(N)
SATURATED = np.clip(np.rint(32_700 + 600.0 * rates()), -32_768, 32_767).astype(int)


@pytest.mark.parametrize(
    ("head", "columns", "words"),
    [
        (HEAD, (STAMPS[:300], rates()[:300]), "gyro: 3 s at 100 Hz"),
        (HEAD, (STAMPS, missing()), "of 6000 samples are missing"),
        (HEAD, (STAMPS, stuck()), "bad.csv:2002: x: stuck at -0.007 deg/s for 6 s in all; left out"),
        (
            "time [s],gyro_x [count]",
            (STAMPS, SATURATED),
            "21 of 6000 samples lie at the end of the range, 32767 count; left out",
        ),
        ("time [s],gyro_x", (STAMPS, rates()), "unit not given, figures are in that of the file: gyro_x"),
        ("time [s],gyro_x [V]", (STAMPS, rates()), "V*sqrt(s)"),
        (
            f"{HEAD},gyro_y [deg/s]",
            (STAMPS, rates(), np.ones(N)),
            "no terms of y: the Allan deviation is zero throughout",
        ),
        (HEAD, (np.delete(STAMPS, slice(2000, 2500)), np.delete(rates(), slice(2000, 2500))), "500 of 6000 samples"),
    ],
)
def test_what_can_be_told_is_told_with_what_is_wrong(
    capsys: pytest.CaptureFixture[str], write: Write, head: str, columns: tuple[Any, ...], words: str
) -> None:
    file = write("bad.csv", head, *columns)
    status, out, err = call(capsys, "allan", file)
    assert (status, err) == (0, "")
    assert words in " ".join(out.split()), out
    content = call_json(capsys, "allan", file)
    numbers = [row[key] for row in content["results"] for key in ("value", "u") if row[key] is not None]
    assert numbers
    assert all(np.isfinite(numbers))
    assert call(capsys, "psd", file)[0] == 0


@pytest.mark.parametrize(
    ("head", "columns", "status", "words"),
    [
        (HEAD, (STAMPS, np.full(N, 0.25)), 3, "a constant channel has no noise"),
        (HEAD, (STAMPS, np.full(N, np.nan)), 3, "no valid sample"),
        (HEAD, (STAMPS[SHUFFLED], rates()[SHUFFLED]), 3, "50 % of its steps go backward"),
        (HEAD, (np.zeros(N), rates()), 3, "it stands still"),
        (HEAD, (swapped(), rates()), 3, "bad.csv:3003: 1 stamp(s) run backwards"),
        (HEAD, (late(), rates()), 3, "bad.csv:3002: 1 repeated stamp(s)"),
        (HEAD, (STAMPS, 1e300 * rates()), 3, "no sensor gives that"),
        ("gyro_x [deg/s]", (rates(),), 3, "--sample-rate HZ"),
        ("time [s],temp [degC]", (STAMPS, rates() + 20.0), 3, "no channel can be a gyro's"),
        ("time [s],angle_x [deg]", (STAMPS, np.cumsum(rates())), 2, "--quantity increment"),
    ],
)
def test_what_cannot_be_told_is_refused(
    capsys: pytest.CaptureFixture[str], write: Write, head: str, columns: tuple[Any, ...], status: int, words: str
) -> None:
    file = write("bad.csv", head, *columns)
    for command in ("allan", "psd"):
        found, out, err = call(capsys, command, file)
        assert (found, out) == (status, "")
        assert words in " ".join(err.split()), err
    content = call_json(capsys, "allan", file)
    assert content["exit"] == status
    assert content["errors"]
    assert [one["path"] for one in content["inputs"]] == [file]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--tau", "1"), "--tau"),
        (("--taus", "often"), "'octave', 'decade', 'all'"),
        (("--deviation", "theo1"), "'overlapping'"),
        (("--for", "rocket"), "--for = 'rocket': should be 'kalibr'"),
        (("--for", "gtsam", "--gravity", "down"), "gravity"),
        (("--scale-factor", "131"), "the readings are in deg/s already"),
        (("--quantity", "angle"), "a rate, not an angle"),
        (("--figure", "allan"), "no file for the figure is named"),
        (("--figure", "allan", "-o", "folder"), "a folder takes all figures"),
        (("-o", "figure.bmp"), "End the name with one of"),
        (("--averaging", "soon"), "Write a number and a unit"),
        (("--terms", "pink"), "should be 'quantization'"),
    ],
)
def test_a_wrong_option_is_told_before_anything_is_written(
    capsys: pytest.CaptureFixture[str], good: str, words: tuple[str, ...], told: str
) -> None:
    status, out, err = call(capsys, "allan", good, *words)
    assert (status, out) == (2, "")
    assert told in " ".join(err.split()), err


def test_a_file_given_twice_is_refused(capsys: pytest.CaptureFixture[str], good: str) -> None:
    assert call(capsys, "allan", good, good)[0] == 2
    assert call(capsys, "allan", "nowhere.csv")[0] == 3


def test_a_said_sample_rate_stands_in_for_bad_stamps(capsys: pytest.CaptureFixture[str], write: Write) -> None:
    file = write("bad.csv", HEAD, swapped(), rates())
    status, out, _ = call(capsys, "allan", file, "--sample-rate", "100")
    assert status == 0
    assert "time stamps not used" in " ".join(out.split())
