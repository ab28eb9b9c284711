"""What commands print fits the terminal: 60 and 80 columns, and 80 where nothing says how many there are."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from inertialcal.cli.__main__ import main

TYPED = re.compile(r"\b([Nn]ext|then): |inertialcal |[0-9a-f]{64}| = ")  # to be copied: stays whole
NARROW = (60, 80)


def typed_in(folder: Path, *commands: str) -> None:
    """Type commands in a folder; their campaigns are run without the page, which takes half of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr("inertialcal.report.page.report_html", lambda *parts: "")
        for typed in commands:
            with pytest.raises(SystemExit):
                main(typed.split())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recordings, and a campaign that was run: short names, so that no path is long."""
    here = tmp_path_factory.mktemp("w")
    rng, t = np.random.default_rng(5), np.arange(4000.0) * 0.1
    noise = np.cumsum(rng.normal(0.0, 0.0002, (len(t), 3)), axis=0) + rng.normal(0.0, 0.02, (len(t), 3))
    head = "time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s],temperature [degC]"
    warm = 20.0 + 15.0 * np.sin(2 * np.pi * t / t[-1])
    rows = np.column_stack([t, noise + 0.01 * warm[:, None], warm])
    for name, step in (("s.csv", 1), ("t.csv", 10), ("e/s.csv", 10)):
        (here / name).parent.mkdir(exist_ok=True)
        np.savetxt(here / name, rows[::step], "%.6f", ",", header=head, comments="")
    typed_in(here, "demo npsat2011 -o p --quiet")
    return here


@pytest.fixture(scope="module")
def simulated_too(folder: Path) -> None:
    """Two simulated campaigns beside it: of a head that turns over, of a unit laid by hand."""
    typed_in(folder, "simulate sams_tsh_model -o f --quiet", "run f --quiet", "simulate hand_held -o h --quiet")


QUICK = ("show p", "show flight_unit", "check p", "thermal t.csv", "certificate p -o c.pdf")
COMMANDS = (
    "run p", "show p/out/results.json", "show p --tables", "info s.csv", "info p/table10_x.csv", "check f", "score f",
    "run f", "budget p", "compare p p", "allan s.csv --for kalibr", "psd s.csv",
    "positions h/recordings/hand1.csv --unit acc=m/s2 --unit gyro=rad/s",
    "simulate six_faces --faults", "convert s.csv c.parquet", "compensate p s.csv -o o.csv", "init e --yes",
    "plan positions --scatter 1mg --next 3", "simulate still_gyro -o n{columns}", "demo sams1996 -o d{columns}",
)  # fmt: skip


def long_lines(text: str, columns: int) -> list[str]:
    """Return lines that do not fit; commands to type, checksums, files shown as they are ("# kalibr") excepted."""
    text = text.partition("\n# kalibr\n")[0]
    return [line for line in text.split("\n") if len(line) > columns and not TYPED.search(line)]


@pytest.mark.parametrize("columns", NARROW)
@pytest.mark.parametrize("typed", QUICK)
def test_a_result_fits_the_terminal(
    typed: str, columns: int, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    (folder / "e/campaign.toml").unlink(missing_ok=True)
    monkeypatch.setenv("COLUMNS", str(columns))
    with pytest.raises(SystemExit):
        main(typed.format(columns=columns).split())
    printed, refused = capsys.readouterr()
    assert printed or "not stated" in refused, refused
    assert not long_lines(printed, columns)
    assert not long_lines(refused, columns)


@pytest.mark.slow
@pytest.mark.usefixtures("simulated_too")
@pytest.mark.parametrize("columns", NARROW)
@pytest.mark.parametrize("typed", COMMANDS)
def test_other_results_fit_it_too(
    typed: str, columns: int, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    test_a_result_fits_the_terminal(typed, columns, folder, monkeypatch, capsys)
