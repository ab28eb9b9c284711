"""A run planned: the chance of a PASS by theory is what simulated runs have; durations grow as they should."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from vibration_runs import PLAN, SHORT, lines_verdict, readings_of

import inertialcal as ic
from independent.coverage import binomial
from independent.vibration.random_run import Run, simulate
from inertialcal.core.errors import InertialcalError, UsageError
from inertialcal.procedures.vibration.plan import PlannedRun
from inertialcal.procedures.vibration.planning import degrees_of_freedom, pass_chance
from inertialcal.procedures.vibration.reduction import reduce
from inertialcal.signals.vibration.profile import Profile
from typed_commands import call, call_json

HEAD = "frequency [Hz],density [g2/Hz]\n"
WORKMANSHIP = HEAD + "20,0.01\n80,0.04\n500,0.04\n2000,0.01\n"
PROFILE = Profile(*np.array(SHORT).T)


@pytest.fixture
def profile(tmp_path: Path) -> str:
    path = tmp_path / "profile.csv"
    path.write_text(WORKMANSHIP, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("n", [60, pytest.param(300, marks=pytest.mark.slow)])
@pytest.mark.parametrize("duration", [8.0, 12.0])
def test_the_chance_of_a_pass_is_that_of_simulated_runs(n: int, duration: float) -> None:
    """The controller's error is spread evenly over the lines, as the forecast says it takes it."""
    wanted = PlannedRun(tolerance=3.0, control_error=1.0)
    expected = pass_chance(wanted, PROFILE, 5.0, duration)
    assert 0.05 < expected < 0.995
    run = Run(nodes=SHORT, rate=1280.0, duration=duration, error=0.0)
    passed = 0
    for seed in range(1, n + 1):
        x = simulate(run, seed)[0]
        f = np.fft.rfftfreq(len(x), 1.0 / run.rate)
        slow = 2.0 * np.abs((f / 160.0) % 1.0 - 0.5)  # a triangle between 0 and 1: evenly spread, smooth for a line
        shaped = np.fft.rfft(x, axis=0) * 10.0 ** ((2.0 * slow - 1.0) / 20.0)[:, None]
        result = reduce(PLAN, readings_of(run, seed, control=np.fft.irfft(shaped, len(x), axis=0)))
        passed += lines_verdict(result, "3 dB").verdict == "PASS"
    low, high = binomial(passed, n)
    assert low <= expected + 0.03  # neighbours are correlated: in truth somewhat more pass
    assert high >= expected - 0.03


def test_degrees_of_freedom_are_those_of_the_estimate() -> None:
    for duration in (10.0, 20.0):
        result = reduce(PLAN, readings_of(Run(nodes=SHORT, rate=1280.0, duration=duration, error=0.0), 1))
        assert result.spectra.edf == pytest.approx(degrees_of_freedom(duration, 5.0), rel=0.03)


def test_longer_and_coarser_help_and_a_large_error_does_not(profile: str) -> None:
    wanted = PlannedRun(tolerance=3.0, control_error=1.0)
    chances = [pass_chance(wanted, PROFILE, 5.0, t) for t in (4.0, 8.0, 16.0, 60.0)]
    assert chances == sorted(chances)
    assert pass_chance(wanted, PROFILE, 10.0, 8.0) > pass_chance(wanted, PROFILE, 5.0, 8.0)
    assert pass_chance(replace(wanted, u=0.05), PROFILE, 5.0, 16.0) < chances[2]
    never = ic.plan_vibration(profile=profile, tolerance="1 dB", control_error="1.5 dB")
    assert all(one.needed is None for one in never.forecasts)
    assert "never" in {one.code for one in never.remarks}
    enough = ic.plan_vibration(profile=profile, tolerance="3 dB", overall="10 %", u="1 %", power=0.9)
    for one in enough.forecasts:
        assert one.needed is not None
        assert pass_chance(enough.wanted, enough.profile, one.resolution, one.needed) == pytest.approx(0.9, abs=0.02)


def test_command_says_what_the_call_says(profile: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["plan", "vibration", "--profile", profile, "--resolution", "5 Hz", "--duration", "60 s"]
    said = call_json(capsys, *words)
    found = ic.plan_vibration(profile=profile, resolution="5 Hz", duration="60 s")
    assert said["results"] == found.results["results"]
    assert "scatter" in str(found)
    assert call(capsys, *words, "-q", "-o", str(tmp_path / "plan.svg"))[0] == 0
    assert (tmp_path / "plan.svg").stat().st_size > 1000


@pytest.mark.parametrize(
    "settings", [{}, {"tolerance": "-3 dB"}, {"resolution": "1500 Hz"}, {"power": 2}, {"tolerance": "3 Hz"}, {"no": 1}]
)
def test_what_cannot_be_planned_is_refused(profile: str, settings: dict[str, object]) -> None:
    given = {"profile": profile, **settings} if settings else {}
    with pytest.raises(InertialcalError):
        ic.plan_vibration(**given)


def test_only_resolutions_that_a_run_takes_are_planned(tmp_path: Path) -> None:
    """A run needs four lines inside of its profile."""
    path = tmp_path / "narrow.csv"
    path.write_text("frequency [Hz],density [g2/Hz]\n20,0.01\n50,0.04\n")
    assert all(one.lines >= 4 for one in ic.plan_vibration(profile=str(path)).forecasts)
    with pytest.raises(InertialcalError, match="need 4"):
        ic.plan_vibration(profile=str(path), resolution="8 Hz")


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ({"control_error": "3 dB"}, {"control_error", "tolerance"}),
        ({"control_error": "50 dB"}, {"control_error", "tolerance"}),
        ({"tolerance": "1e-6 dB"}, {"tolerance"}),
        ({"u": "50 %"}, {"u", "tolerance"}),
        ({"overall": "0.1 %"}, {"overall"}),
        ({"overall": "5 %", "u": "5 %"}, {"u", "overall"}),
        ({"resolution": "0.001 Hz"}, {"resolution", "tolerance"}),
    ],
)
def test_what_no_duration_gives_is_advised_by_what_alone_gives_it(
    profile: str, settings: dict[str, str], named: set[str]
) -> None:
    def never(given: dict[str, str]) -> str:
        found = [one.do for one in ic.plan_vibration(profile=profile, **given).remarks if one.code == "never"]
        return found[0] if found else ""

    base = {"u": "1 %", **settings}
    advised = dict(re.findall(r'(\w+)="([^"]+)"', never(base)))
    assert set(advised) == named
    for name, value in advised.items():
        assert not never({**base, name: value}), (name, value)


def test_all_at_once_is_said_where_nothing_alone_helps(profile: str) -> None:
    plan = ic.plan_vibration(profile=profile, control_error="3 dB", overall="1 %", u="5 %")
    (one,) = [remark for remark in plan.remarks if remark.code == "never"]
    assert one.do.startswith("Change more than one of")


def test_a_duration_that_holds_no_spectrum_is_refused_and_finer_resolutions_are_left_out(profile: str) -> None:
    with pytest.raises(UsageError) as short:
        ic.plan_vibration(profile=profile, u="1 %", duration="0.1 s")
    assert "0.15 s at 10 Hz" in short.value.problems[0].what
    found = ic.plan_vibration(profile=profile, u="1 %", duration="0.4 s").forecasts
    assert [one.resolution for one in found] == [5.0, 10.0]
