"""What all tests share: other people's recordings, which may be absent, and a small campaign to break."""

from __future__ import annotations

import gc
import os
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import settings

from figures_kept import keeping
from inertialcal.campaign.engine.run import run
from inertialcal.campaign.file.example import copy_example
from inertialcal.campaign.twins.twin import simulate
from inertialcal.cli.__main__ import SELDOM
from inertialcal.report import drawings
from inertialcal.report.drawings import of_campaign
from ran_campaigns import Ran, lossy_twin, ran

if TYPE_CHECKING:
    from playwright.sync_api import Browser


# Begun first, so that quick tests are left over for the end and no worker waits for the other's last one.
LONG = (
    "test_npsat1_campaign", "test_manual", "test_figures", "test_commands", "test_score", "test_browser_layout",
    "test_browser_use", "test_browser_injection", "test_page", "test_flip_noise", "test_rate_table", "test_fuzz",
    "test_flip_coverage", "test_figure_places", "test_thermal_coverage", "test_thermal_held_out", "test_closed_loop",
    "test_thermal_campaign", "test_noise_coverage", "test_flip_inputs", "test_requirements", "test_noise_campaign",
    "test_static_noise", "test_flip_bad_input", "test_noise_command", "test_plan_mass_attraction", "test_apply_code",
    "test_segments", "test_compensated_coverage", "test_positions_campaign", "test_positions_coverage",
)  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put long modules first, each whole; the others stay in order."""
    place = {name: number for number, name in enumerate(LONG)}
    items.sort(key=lambda item: place.get(item.path.stem, len(LONG)))


def pytest_collection_finish() -> None:
    """Look for garbage as seldom as the command line does, and not among thousands of collected tests."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(*SELDOM)


settings.register_profile("house", deadline=None)  # a busy machine is no failure
settings.load_profile("house")

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session", autouse=True)
def _default_signals() -> Iterator[None]:
    """Commands take signals also where the tests are a job in the background, for which the shell ignores them."""
    before = {signal.SIGINT: signal.signal(signal.SIGINT, signal.default_int_handler)}
    if hasattr(signal, "SIGHUP"):  # not on Windows
        before[signal.SIGHUP] = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    for number, former in before.items():
        signal.signal(number, former)


@pytest.fixture(scope="session", autouse=True)
def wide_tables() -> Iterator[None]:
    """Texts are as wide as they are, whatever terminal the tests run in; a test of widths sets its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", "400")
        yield


@pytest.fixture(scope="session")
def shared() -> Path:
    """Folder with ``data/`` and ``reference/``; the test is skipped, and says so, where it is absent."""
    folder = Path(os.environ.get("INERTIALCAL_SHARED", ROOT.parent / "shared"))
    if not folder.is_dir():
        pytest.skip(f"no recordings of others: {folder} is absent (set INERTIALCAL_SHARED)")
    return folder


@pytest.fixture(scope="session")
def need() -> Callable[[str], str]:
    """Path of a program that tests need; absent, the test is skipped, or fails if INERTIALCAL_REQUIRE names it."""
    required = os.environ.get("INERTIALCAL_REQUIRE", "").split(",")

    def find(part: str) -> str:
        path = shutil.which(part)
        if path is None:
            (pytest.fail if part in required else pytest.skip)(f"{part} is not installed")
        return path

    return find


CAMPAIGN = """\
schema = 2
[campaign]
id = "small"
[item]
serial = "7"
[standards.rate_table]
rate = { u = "0.05 %", certificate = "C-1" }
[sensors.suite]
kind = "gyro"
axes = ["x", "y", "z"]
unit = "deg/s"
range = ["-10 deg/s", "10 deg/s"]
chain = { kind = "adc", lsb = "5 V / 4095", counts = [0, 4095], reference = "2.5 V", scale_factor = "0.5 V/(deg/s)" }
[recordings.one]
sensor = "suite"
file = "one.csv"
rows = { applied = "rate", reading = "x", scatter = "std", group = "set", run = "run", unit = "deg/s" }
[[tests]]
id = "first"
procedure = "rate_table"
recordings = ["one"]
plan = { axis = "x", zero_reference = true }
[[requirements]]
id = "R1"
quantity = "rate_error"
limit = "5 %"
where = "abs(rate) >= 0.5 deg/s"
"""


def table() -> str:
    rng = np.random.default_rng(1)
    lines = ["rate,x,std,set,run"]
    for power_up in range(1, 7):
        offset = rng.normal(0.0, 0.002)
        for group in ("1", "2"):
            for rate in (-4.0, -2.0, -1.0, -0.5, 0.5, 1.0, 2.0, 4.0):
                reading = 1.01 * rate + 0.01 + offset + rng.normal(0.0, 0.001)
                lines.append(f"{rate},{reading:.6f},0.004,{group},{power_up}")
    return "\n".join(lines) + "\n"


@pytest.fixture
def campaign(tmp_path: Path) -> Callable[..., Path]:
    """Write the campaign, with some text replaced, and return its folder."""

    def write(*replacements: tuple[str, str], data: str | None = None) -> Path:
        text = CAMPAIGN
        for old, new in replacements:
            assert old in text, f"the campaign has no {old!r}"
            text = text.replace(old, new, 1)
        (tmp_path / "campaign.toml").write_text(text, encoding="utf-8")
        (tmp_path / "one.csv").write_text(table() if data is None else data, encoding="utf-8")
        return tmp_path

    return write


# Campaigns that were run: the published one, and a short simulated one with every kind of loss


@pytest.fixture(scope="session")
def published(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    folder = tmp_path_factory.mktemp("published") / "npsat2011"
    example = ROOT / "src/inertialcal/examples/npsat2011"
    shutil.copytree(example, folder, ignore=shutil.ignore_patterns("out"))
    return ran(folder)


@pytest.fixture(scope="session")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    return ran(lossy_twin(tmp_path_factory.mktemp("simulated")))


@pytest.fixture(params=["published", "simulated"])
def campaign_ran(request: pytest.FixtureRequest) -> Ran:
    """Each of the two in turn."""
    found: Ran = request.getfixturevalue(request.param)
    return found


@pytest.fixture(scope="module")
def undrawn() -> Iterator[None]:
    """Campaigns are run without their page, which takes half of the time: for modules that do not look at it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("inertialcal.report.page.report_html", lambda *parts: "")
        yield


# Figures of pages, drawn once


@pytest.fixture(scope="session", autouse=True)
def figures_kept(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "figures"
    folder.mkdir(exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(drawings, "of_campaign", keeping(of_campaign, folder))
        yield


@pytest.fixture
def drawn_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a test draw what was drawn before."""
    monkeypatch.setattr(drawings, "of_campaign", of_campaign)


# A server of PostgreSQL, on a socket in a folder of its own


@pytest.fixture(scope="session")
def postgres(need: Callable[[str], str], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[], str]]:
    """Give the address of an empty database, a new one with each call."""
    initdb, server = need("initdb"), need("postgres")
    from postgres_server import served

    with served(initdb, server) as made:
        yield made


# A browser, and the reports that it looks at: of the published campaign, and of two simulated ones with recordings


@pytest.fixture(scope="session")
def browser(need: Callable[[str], str]) -> Iterator[Browser]:
    program = need("chromium")
    from browsing import FLAGS
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        yield started
        started.close()


@pytest.fixture(scope="session")
def published_report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Report of the published campaign, its other results beside it."""
    folder = copy_example("npsat2011", tmp_path_factory.mktemp("report") / "published")
    run(folder)
    return folder / "out" / "report.html"


@pytest.fixture(scope="session")
def reports(published_report: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Report of each campaign, its other results beside it."""
    folder = tmp_path_factory.mktemp("reports")
    simulate("rate_table", folder / "simulated", seed=1)
    simulate("still_gyro", folder / "still", seed=1)
    for name in ("simulated", "still"):
        run(folder / name)
    simulated = {name: folder / name / "out" / "report.html" for name in ("simulated", "still")}
    return {"published": published_report} | simulated
