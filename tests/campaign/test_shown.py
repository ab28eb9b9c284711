"""Everything that the public functions return prints as a table, in a terminal and in a notebook."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping
from dataclasses import replace
from html import escape
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inertialcal as ic
from independent.shaking.shaker import Mode, Run, recorded
from inertialcal.campaign.calls.call import Reduced
from inertialcal.campaign.twins.score import Score
from inertialcal.campaign.twins.twin import read_truth
from inertialcal.core.key import Method
from inertialcal.core.recording import Channel, Recording, Source
from inertialcal.core.remarks import Remark
from inertialcal.core.show.rounding import with_uncertainty
from inertialcal.core.show.rows import case_name
from inertialcal.core.show.tables import WIDTH, Table
from inertialcal.procedures.mass_attraction.reduction import repeated
from inertialcal.procedures.mass_attraction.schedule_csv import write_schedule
from inertialcal.rigs.alignment.rig import Bench as AlignmentBench
from inertialcal.rigs.alignment.rig import build as build_alignment
from inertialcal.rigs.flights.rig import Bench as Flights
from inertialcal.rigs.flights.rig import build as flights
from inertialcal.rigs.heads.rig import Bench as HeadsBench
from inertialcal.rigs.heads.rig import build as build_heads
from inertialcal.rigs.satellite.rig import Bench, build
from inertialcal.rigs.station import rig as station
from inertialcal.sensors.model.sensor_model import Item, SensorModel

EXAMPLE = Path(__file__).parents[2] / "src/inertialcal/examples/npsat2011"
FLIPS = EXAMPLE.with_name("sams1996")
DRIVE = np.sin(2.0 * np.pi * np.arange(3000) / 100.0)
EVIL = "<script>alert('x')</script>"


def over_temperature(folder: Path) -> Path:
    """A record of a gyro while it was cooled and warmed."""
    time = np.arange(0.0, 8000.0, 20.0)
    T = 20.0 - 0.02 * np.minimum(time, 8000.0 - time)
    rate = 1e-4 * T + np.random.default_rng(1).normal(0.0, 1e-3, time.size)
    path, head = folder / "ramp.csv", "unix_s,temperature [degC],gyro_x [deg/s]"
    np.savetxt(path, np.column_stack([1.7e9 + time, T, rate]), fmt="%.6f", delimiter=",", header=head, comments="")
    return path


def moved(folder: Path) -> Reduced:
    """What a record of pulses in the gates of a schedule gives."""
    plan = repeated([0.1, 0.4], [7e-7, 2e-7], cycles=40, dwell=100.0, move=20.0, drive="abab")
    path, schedule = folder / "pulses.csv", folder / "schedule.csv"
    pulses = np.rint(1e5 + 1e8 * plan.applied + np.random.default_rng(1).normal(0.0, 3.0, len(plan)))
    table = np.column_stack([1.7e9 + plan.middle, pulses])
    np.savetxt(path, table, fmt="%.6f", delimiter=",", header="unix_s,pulses [count]", comments="")
    write_schedule(schedule, plan)
    return ic.mass_attraction(path, schedule=str(schedule), gate="100 s")


def satellite(folder: Path) -> Reduced:
    """What half an orbit of a gyro and a magnetometer gives."""
    pytest.importorskip("ppigrf")
    (made,) = build(Bench(seconds=2100), 1).recordings.values()
    ic.write(folder / "orbit.csv", made)
    return ic.magnetometer_bias(folder / "orbit.csv")


def in_station(folder: Path) -> Reduced:
    """What ten minutes of a head in a station give."""
    twin = station.build(station.Bench(seconds=600.0, gap=(0.0, 0.0)), 1)
    (made,) = twin.recordings.values()
    ic.write(folder / "record.csv", made)
    (folder / "curve.csv").write_text(station.CURVE_TEXT, encoding="utf-8")
    return ic.microgravity(folder / "record.csv", curve=str(folder / "curve.csv"), cut_off="5 Hz")


def shifted(folder: Path) -> Reduced:
    """What flips of two flights make of a ground model."""
    extras = flights(Flights(flights=2), 1).extras
    for file, one in extras.items():
        (folder / file).write_text(one.text, encoding="utf-8")
    return ic.shifted_model(folder / "flips.csv", ground=str(folder / "ground.json"))


def heads(folder: Path) -> Reduced:
    """What three heads on a line give."""
    twin = build_heads(HeadsBench(seconds=600), 1)
    for file, made in twin.recordings.items():
        ic.write(folder / Path(file).name, made)
    (folder / "body.toml").write_text(twin.extras["body.toml"].text, encoding="utf-8")
    return ic.heads([folder / f"tsh{n}.csv" for n in (1, 2, 3)], body=str(folder / "body.toml"))


def aligned(folder: Path) -> Reduced:
    """What two positions of a unit at rest give."""
    bench = AlignmentBench(seconds=100.0)
    for made in build_alignment(bench, 1).recordings.values():
        ic.write(folder / "imu.csv", made)
    return ic.alignment(folder / "imu.csv", latitude="36.6 deg", turns="180 deg")


def turned(folder: Path) -> Reduced:
    """What records of pulses give while a mass turns at an hour a turn, in both senses."""
    runs = []
    for name, sign in (("ahead", 1.0), ("back", -1.0)):
        times = np.arange(50.0, 43_200.0, 100.0)
        rate = 177.0 + (0.002 - 0.003 * sign) * np.cos(2.0 * np.pi / 3600.0 * times)
        pulses = np.diff(np.floor(100.0 * np.cumsum(np.append(0.0, rate + _noise(len(times))))))
        runs.append(folder / f"{name}.csv")
        np.savetxt(runs[-1], np.column_stack([1.7e9 + times, pulses]), fmt="%.6f", delimiter=",",
                   header="unix_s,pulses [count]", comments="")  # fmt: skip
    schedule = folder / "schedule.csv"
    rows = "ahead,0,43200,0.1,0\nback,50000,93200,-0.1,0\n"
    schedule.write_text(f"run,start [s],stop [s],rate [deg/s],angle [deg]\n{rows}", encoding="utf-8")
    return ic.turned_mass(runs, schedule=str(schedule), gate="100 s", mass="4 kg", radius="0.2 m", altitude="560 km")


def _noise(n: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.random.default_rng(n).normal(0.0, 3e-3, n)


def shaken(folder: Path) -> Path:
    """A record of a gyro between two rests, vibrated at two levels."""
    rng = np.random.default_rng(1)
    control = np.repeat([0.0, 1.0, 2.0, 0.0], 1000) * rng.standard_normal(4000)
    reading = 1e-3 * control**2 + 0.01 * rng.standard_normal(4000)
    path, head = folder / "shaken.csv", "time [s],gyro_x [deg/s],control [g]"
    table = np.column_stack([np.arange(4000) / 100.0, reading, control])
    np.savetxt(path, table, fmt="%.6f", delimiter=",", header=head, comments="")
    return path


def shaken_at_random(folder: Path) -> tuple[Path, str]:
    """A record of a control accelerometer at random, and the profile of the run."""
    path, profile = folder / "random.csv", folder / "profile.csv"
    rows = np.column_stack([np.arange(20_000) / 1000.0, np.random.default_rng(1).standard_normal(20_000)])
    np.savetxt(path, rows, fmt="%.6f", delimiter=",", header="time [s],control [g]", comments="")
    profile.write_text("frequency [Hz],density [g2/Hz]\n20,0.002\n300,0.002\n")
    return path, str(profile)


def over_supply(folder: Path) -> list[Path]:
    """Records of three power-ups of a gyro at rest at three supply voltages."""
    rng = np.random.default_rng(1)
    volts = np.repeat([5.0, 4.85, 5.15], 40)
    paths = [folder / f"run{i}.csv" for i in range(3)]
    for i, path in enumerate(paths):
        rate = rng.normal(0.0, 0.01) + 0.02 * volts + rng.normal(0.0, 5e-4, volts.size)
        columns = [1.7e9 + 1e5 * i + 5.0 * np.arange(volts.size), 20.0 + 0.0 * volts, volts, rate]
        head = "unix_s,temperature [degC],supply [V],gyro_x [deg/s]"
        np.savetxt(path, np.column_stack(columns), fmt="%.6f", delimiter=",", header=head, comments="")
    return paths


def readings(units: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """What accelerometers of several units read in 20 positions."""
    rng = np.random.default_rng(1)
    up = rng.normal(size=(units, 20, 3))
    up /= np.linalg.norm(up, axis=2, keepdims=True)
    return 9.81 * up * 1.01 + 0.1 + rng.normal(0.0, 0.002, up.shape)


def swept(folder: Path) -> Path:
    """An item of one mode on a shaker."""
    path, run = folder / "swept.csv", Run(50.0, 200.0, 40.0, sample_rate=1000.0, quiet=0.2)
    both = recorded((Mode(100.0, 20.0),), run, np.random.default_rng(1))
    time = np.arange(len(both[0])) / run.sample_rate
    head = "time [s],control [g],acc_x [g]"
    np.savetxt(path, np.column_stack([time, *both]), fmt="%.6f", delimiter=",", header=head, comments="")
    return path


def laid(folder: Path) -> Path:
    """A table of one unit, a row a position."""
    path, head = folder / "positions.csv", "acc_x [m/s2],acc_y [m/s2],acc_z [m/s2]"
    np.savetxt(path, readings(1)[0], fmt="%.6f", delimiter=",", header=head, comments="")
    return path


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Any]:
    folder = tmp_path_factory.mktemp("shown") / EXAMPLE.name
    shutil.copytree(EXAMPLE, folder, ignore=shutil.ignore_patterns("out"))
    table, model = folder / "table10_x.csv", folder / "out/model.json"
    twin = tmp_path_factory.mktemp("twin") / "new"
    written = ic.simulate("rate_table", twin, 3)
    run = ic.run(folder)
    known = [dict(row) | {"truth": row["value"], "inside": True} for row in run.results["results"] if row["interval"]]
    lost = {**known[0], "inside": None}
    one = ic.rate_table(table, reading="reading_minus_ref_dps", axis="x", zero_reference=True, input_range="5 deg/s")
    still = np.random.default_rng(1).normal(0.0, 1e-3, (3000, 2))
    random, profile = shaken_at_random(tmp_path_factory.mktemp("random"))
    return {
        "read": ic.read(table),
        "clock": ic.read(twin / written.recordings[0]),
        "read_table": ic.read_table(table),
        "info": ic.info(twin / written.recordings[0]),
        "rate_table": one,
        "flip": ic.flip(FLIPS / "table03_semiprocessed.csv", positions={"forward": "0 deg", "reverse": "180 deg"}),
        "thermal": ic.thermal(over_temperature(tmp_path_factory.mktemp("thermal"))),
        "sensitivity": ic.sensitivity(over_supply(tmp_path_factory.mktemp("supply")), to="supply"),
        "allan": ic.allan(still, sample_rate=100.0, units="rad/s"),
        "psd": ic.psd(still, sample_rate=100.0, units="rad/s"),
        "sine": ic.sine(still[:, 0] + 1e-3 * DRIVE, period="1 s", sample_rate=100.0, units="rad/s"),
        "vibration": ic.vibration(random, profile=profile, control="control"),
        "vibration_profile": ic.vibration_profile(profile),
        "magnetometer_bias": satellite(tmp_path_factory.mktemp("satellite")),
        "microgravity": in_station(tmp_path_factory.mktemp("station")),
        "shifted_model": shifted(tmp_path_factory.mktemp("shifted")),
        "heads": heads(tmp_path_factory.mktemp("heads")),
        "alignment": aligned(tmp_path_factory.mktemp("aligned")),
        "turned_mass": turned(tmp_path_factory.mktemp("turned")),
        "plan_turned_mass": ic.plan_turned_mass(hours="12 h", trials=0),
        "plan_rate_table": ic.plan_rate_table(noise="0.2 deg/sqrt(h)", fastest="100 deg/s", wanted=TO_BIAS, simulate=0),
        "plan_thermal": ic.plan_thermal(
            noise="0.2 deg/sqrt(h)",
            coldest="-20 degC",
            hottest="60 degC",
            wanted=TO_BIAS,
            latitude="36.6 deg",
            simulate=0,
        ),
        "plan_magnetometer_bias": ic.plan_magnetometer_bias(
            noise="0.2 deg/sqrt(h)", interval="10 s", wanted=TO_BIAS, most_orbits=1, simulate=0
        ),
        "plan_flip": ic.plan_flip(noise="5 ug/sqrt(Hz)", wanted={"bias": "0.5 ug"}, simulate=0),
        "plan_allan": ic.plan_allan(
            noise="0.2 deg/sqrt(h)", instability="5 deg/h", wanted={"noise": "1 %"}, simulate=0
        ),
        "plan_vibration": ic.plan_vibration(profile=profile),
        "plan_vibration_survey": ic.plan_vibration_survey(rate="4 oct/min"),
        "vibration_effects": ic.vibration_effects(shaken(tmp_path_factory.mktemp("shaken")), axis="z"),
        "vibration_survey": ic.vibration_survey(swept(tmp_path_factory.mktemp("swept"))),
        "mass_attraction": moved(tmp_path_factory.mktemp("moved")),
        "plan_mass_attraction": ic.plan_mass_attraction(body={"cube": "5 cm", "count": 40, "stand_off": "8 cm"}),
        "positions": ic.positions(laid(tmp_path_factory.mktemp("laid")), units={"acc": "m/s2"}, gravity="9.81 m/s2"),
        "positions_batch": ic.positions_batch(readings(20), 9.81),
        "plan_positions": ic.plan_positions(scatter="0.1 mg", have="faces", following=3),
        "result": one.result,
        "estimate": one.result.estimate,
        "check": ic.check(folder),
        "run": run,
        "budget": ic.budget(folder),
        "model": ic.load_model(model),
        "compare": ic.compare(folder, folder),
        "judged": ic.compare(model, model, ["1 %"]),
        "simulate": written,
        "score": Score(read_truth(twin), (*known, lost)),
    }


TO_BIAS = {"bias": "0.01 deg/s"}
NAMES = ("read", "clock", "read_table", "info", "rate_table", "flip", "thermal", "sensitivity", "allan", "psd", "sine",
         "mass_attraction", "plan_mass_attraction", "positions", "positions_batch", "plan_positions",
         "vibration", "vibration_profile", "plan_vibration", "plan_vibration_survey", "vibration_survey",
         "vibration_effects", "magnetometer_bias", "microgravity", "shifted_model", "turned_mass", "heads", "alignment",
         "plan_turned_mass", "plan_magnetometer_bias",
         "plan_rate_table", "plan_thermal", "plan_flip", "plan_allan",
         "result", "estimate",
         "check", "run", "budget", "model", "compare", "judged", "simulate", "score")  # fmt: skip


class Cells(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.cells: list[str] = []
        self.inside = False
        self.tags: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.inside = tag in {"td", "th"}
        if self.inside:
            self.cells.append("")

    def handle_endtag(self, tag: str) -> None:
        self.inside = False

    def handle_data(self, data: str) -> None:
        if self.inside:
            self.cells[-1] += data


def cells(value: Any) -> Cells:
    found = Cells()
    found.feed(value._repr_html_())
    return found


@pytest.mark.parametrize("name", NAMES)
def test_a_terminal_and_a_notebook_show_the_same(name: str, shown: Mapping[str, Any]) -> None:
    value = shown[name]
    said = str(value)
    assert max(map(len, said.split("\n"))) <= WIDTH
    assert repr(value) == said
    grids = [part for part in value.parts() if isinstance(part, Table)]
    assert grids
    assert cells(value).cells == [cell for grid in grids for row in (grid.heads, *grid.rows) for cell in row]
    for grid in grids:
        for row in grid.rows:
            assert all(row[i] in said for i in grid.right)


@pytest.mark.parametrize("name", ["run", "rate_table", "flip", "thermal", "allan", "psd", "sine", "positions", "model"])
def test_a_notebook_shows_the_first_figure_of_a_result(name: str, shown: Mapping[str, Any]) -> None:
    from inertialcal.report.plot import pictures

    (drawn,) = re.findall(r"<svg .*?</svg>", shown[name]._repr_html_(), re.DOTALL)
    assert f'aria-label="{escape(pictures(shown[name])[0].label)}"' in drawn
    assert "<path" in drawn
    assert not re.search(r"https?://(?!www\.w3\.org)", drawn)


def test_a_campaign_is_short_in_a_notebook(shown: Mapping[str, Any]) -> None:
    """The requirements stand open, before all else; the figures of each test are one line that opens."""
    whole = shown["run"]._repr_html_()
    at_once = re.sub(r"<details.*?</details>", "", whole, flags=re.DOTALL)
    assert at_once.count("<tr>") <= 25 < whole.count("<tr>")
    assert at_once.index("requirements at a glance") < at_once.index("verdict: ")
    for name in dict.fromkeys(row["test"] for row in shown["run"].results["results"] if row["status"] == "estimated"):
        assert re.search(rf"<summary>{name}: \d+ rows?</summary>", whole)


def test_a_result_that_cannot_be_drawn_is_tables_alone(shown: Mapping[str, Any]) -> None:
    bare = replace(
        shown["run"], content={**shown["run"].results, "curves": [], "results": [], "verdicts": [], "budgets": []}
    )
    assert "<table" in bare._repr_html_()
    assert "<svg" not in bare._repr_html_()


def test_every_public_function_that_returns_an_object_is_covered() -> None:
    assert {name for name in ic.__all__ if not isinstance(getattr(ic, name), type)} - {
        "load_model",
        "load_models",
        "max_memory",
        "lot",  # in tests/lots
        "open_archive",  # what it gives is in tests/archive
        "write",
        "compensate",
        "plot",
        "programme_1969",
        "certificate",
        "read_certificate",  # both in tests/campaign/certificate
    } <= set(NAMES)


def test_figures_are_those_of_the_results(shown: Mapping[str, Any]) -> None:
    outcome = shown["run"]
    said = str(outcome)
    for row in outcome.results["results"]:
        if row["status"] == "estimated" and not case_name(row):
            assert with_uncertainty(row["value"], row["u"]) in said
    for value, u in zip(shown["estimate"].values, shown["estimate"].u, strict=True):
        assert with_uncertainty(value, u) in str(shown["estimate"])
    assert said.endswith("verdict: INCONCLUSIVE")


def test_requirements_are_counted(shown: Mapping[str, Any]) -> None:
    outcome = shown["run"]
    verdicts = [one["verdict"] for one in outcome.results["verdicts"]]
    (grid,) = (part for part in outcome.parts() if isinstance(part, Table) and part.heads[0] == "requirement")
    for at, word in enumerate(("PASS", "FAIL", "INCONCLUSIVE", "OPEN"), 3):
        assert sum(int(row[at]) for row in grid.rows) == verdicts.count(word)


def test_a_score_counts_what_it_holds(shown: Mapping[str, Any]) -> None:
    n = len(shown["score"].rows) - 1
    lo, hi = shown["score"].expected
    said = " ".join(str(shown["score"]).split())
    assert (
        f"{n} of {n} stated 95 % intervals hold the truth; {lo} to {hi} expected, with errors that figures share"
        in said
    )
    assert f"counted once: {'more than' if n > hi else 'as'} expected 1 not estimated" in said


def test_a_check_is_still_three_things(shown: Mapping[str, Any]) -> None:
    campaign, inputs, remarks = shown["check"]
    assert campaign.file.campaign.id in str(shown["check"])
    assert all(len(sha) == 64 and sha in str(shown["check"]) for sha in inputs.values())
    assert remarks == shown["check"].remarks


def evil_recording() -> Recording:
    channels = (
        Channel(EVIL, np.array([1.0, np.nan, 3.0]), EVIL, axis=EVIL, quantity=EVIL),
        Channel("empty", np.full(3, np.nan)),
        Channel("words", np.array(["a", "b", "c"])),
        Channel("flag", np.array([True, False, True])),
        Channel("\x1b[31m" + "w" * 300, np.array([1, 2, 3], dtype=np.int16)),
    )
    time = np.array([0, 10**9, 2 * 10**9], dtype=np.int64) + 1_272_467_401 * 10**9
    remark = Remark(EVIL, "warning", EVIL, EVIL, do=EVIL)
    return Recording(channels, time, 1.0, 0.5, "utc", "column", Source(EVIL, "", EVIL), (remark,))


def test_a_recording_says_its_clock_and_what_is_missing() -> None:
    said = str(evil_recording())
    assert "1 Hz" in said
    assert "each the mean of 0.5 s" in said
    assert "2 s from 2010-04-28T15:10:01.000Z" in said
    assert re.search(r"empty .* float64 +- +- +3$", said, re.MULTILINE)
    assert re.search(r"flag .* bool +0 +1 +0$", said, re.MULTILINE)
    assert "remarks: 1 warning" in said


def hostile(model: SensorModel) -> dict[str, Any]:
    axes = (EVIL, "\n*/\u202e", "z" * 300)
    bare = replace(model, axes=axes, item=Item(EVIL, EVIL, EVIL), source=EVIL, estimate=None, provenance={},
                   not_estimated={})  # fmt: skip
    return {"recording": evil_recording(), "model": bare}


@pytest.mark.parametrize("name", ["recording", "model"])
def test_names_are_escaped(name: str, shown: Mapping[str, Any]) -> None:
    value = hostile(shown["model"])[name]
    found = cells(value)
    assert "script" not in found.tags
    assert "<script" not in value._repr_html_()
    assert all(c.isprintable() or c == "\n" for c in str(value))


def evil(value: Any) -> Any:
    """The results with every name replaced, numbers and the words that the tool itself sets left."""
    words = {
        "estimated",
        "not_estimated",
        "upper_limit",
        "PASS",
        "FAIL",
        "INCONCLUSIVE",
        "OPEN",
        "info",
        "warning",
        "",
        *Method,
    }
    if isinstance(value, dict):
        return {name: evil(one) for name, one in value.items()}
    if isinstance(value, list):
        return [evil(one) for one in value]
    return EVIL if isinstance(value, str) and value not in words else value


def test_names_in_results_are_escaped(shown: Mapping[str, Any]) -> None:
    outcome = replace(shown["run"], content=evil(shown["run"].results))
    assert "script" not in cells(outcome).tags
    assert "<script" not in outcome._repr_html_()
    assert EVIL in cells(outcome).cells
