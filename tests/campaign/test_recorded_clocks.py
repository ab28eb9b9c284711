"""What an acquisition found out about a clock reaches every noun and campaign, where nobody states it."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import inertialcal as ic
from inertialcal.campaign.file.load import clock_standard, load
from inertialcal.core.campaign_text import toml_text
from inertialcal.core.influence import Influence
from inertialcal.core.key import Key
from inertialcal.core.recording import SECOND, Channel, ClockRate, Recording
from inertialcal.core.results import Interval, Row
from inertialcal.files import read
from inertialcal.files.write.recording import write
from inertialcal.procedures.static_noise.rows import widened

CLOCK = ClockRate(0.002, 200.0, "acquire: clock of imu from 2026-11-30T02:00:00Z")
SIZE = 4000


def at_rest(path: Path, clock: ClockRate | None, seed: int = 1) -> Path:
    values = np.random.default_rng(seed).standard_normal(SIZE)
    channels = (Channel("gyro_x", 1e-3 * values, "rad/s", "header", "x", "gyro"),)
    write(
        path,
        Recording(channels, 1_700_000_000 * SECOND + np.arange(SIZE) * SECOND // 100, 0.01, epoch="utc", clock=clock),
    )
    return path


def walk_of(rows: tuple[Row, ...]) -> Row:
    return next(one for one in rows if one.key.quantity == "angle_random_walk")


def test_a_noun_uses_it_and_writes_it_into_its_campaign(tmp_path: Path) -> None:
    own, none = at_rest(tmp_path / "own.parquet", CLOCK), at_rest(tmp_path / "none.parquet", None)
    assert "rate of the clock known to 0.20 %" in str(ic.info(own))
    assert "rate of the clock" not in str(ic.info(none))
    found, without = ic.allan([own]), ic.allan([none])
    u, plain = walk_of(found.result.rows()).u, walk_of(without.result.rows())
    assert plain.u is not None
    assert u == pytest.approx(np.hypot(plain.u, 0.5 * CLOCK.u * (plain.value or 0.0)))  # N goes by the root of time
    stated = ic.allan([own], standards={"clock.rate": "5 %"})
    assert walk_of(stated.result.rows()).u == pytest.approx(np.hypot(plain.u, 0.025 * (plain.value or 0.0)))
    campaign = load(Path(found.write_campaign(tmp_path / "campaign")).parent)
    influence = campaign.standards["clock.rate"]
    assert influence.u == pytest.approx(CLOCK.u)
    assert (influence.dof, influence.certificate) == (CLOCK.dof, CLOCK.source)


def test_a_campaign_takes_it_from_its_recordings_where_it_states_nothing(tmp_path: Path) -> None:
    folder = tmp_path / "campaign"
    found = ic.allan([at_rest(tmp_path / "own.parquet", CLOCK)])
    path = Path(found.write_campaign(folder))
    document = tomllib.loads(path.read_text())
    assert document.pop("standards")["clock"]["rate"]["u"] == "2000 ppm"
    path.write_text(toml_text(document))
    (file,) = folder.rglob("*.parquet")
    assert read(file).clock == CLOCK
    assert load(folder).standards["clock.rate"].certificate == CLOCK.source
    outcome = ic.run(folder)
    assert [row["u"] for row in outcome.results["results"]] == [row.u for row in found.rows]
    shutil.copy(at_rest(tmp_path / "none.parquet", None), file)
    assert "clock.rate" not in load(folder).standards


def test_it_is_one_unknown_and_that_known_worst_and_nothing_where_one_does_not_say() -> None:
    worse = replace(CLOCK, u=0.003, dof=np.inf)
    assert clock_standard([CLOCK, worse]) == {"rate": {"u": "3000 ppm", "certificate": CLOCK.source}}
    assert clock_standard([CLOCK, None]) == clock_standard([]) == {}


POWERS = {"quantization": 1.0, "angle_random_walk": 0.5, "velocity_random_walk": 0.5, "bias_instability": 0.0,
          "rate_random_walk": -0.5, "acceleration_random_walk": -0.5, "rate_ramp": -1.0,
          "gauss_markov_correlation_time": 1.0, "gauss_markov_sigma": 0.0, "line_frequency": -1.0}  # fmt: skip


@pytest.mark.parametrize("quantity", POWERS)
def test_noise_follows_the_clock_by_its_power_of_time(quantity: str) -> None:
    """Deviations stand at averaging times that the clock counts: N is sigma times their root, K over their root."""
    standards: Mapping[str, Influence] = {"clock.rate": Influence(0.01, standard="clock", quantity="rate")}
    row = widened(Row(Key(quantity, "x"), 2.0, 0.01, "1", None, Interval(1.98, 2.02)), standards)
    assert row.u == pytest.approx(np.hypot(0.01, 2.0 * 0.01 * POWERS[quantity]))
