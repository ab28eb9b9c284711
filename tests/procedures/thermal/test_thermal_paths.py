"""Warming against cooling: what one loop can say, and when hysteresis is told from lag and drift."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import polynomial
from thermal_sweeps import path, plan, sweep, way

from independent.thermal import Chamber, Unit, ramped
from inertialcal.core.estimate import Array
from inertialcal.core.key import Method
from inertialcal.procedures.thermal.reduction import Attitude, OfSensor, Readings, Result, reduce
from inertialcal.statistics.intervals import contains, covers
from sized import sized

CUBIC = (0.03, -3e-3, 1.6e-5, -2e-7)
LOOP = (23.0, -30.0, 67.0, 23.0)
NOISE = 2e-4


def readings(
    rates: tuple[float, ...], hysteresis: float = 0.0, lag: float = 0.0, drift: float = 0.0, loops: int = 1
) -> Readings:
    """Runs at rates [degC/s] with hysteresis, lag [s] and a drift of each run's own [1/s]."""
    rng = np.random.default_rng(4)
    sweeps = []
    for number, rate in enumerate(rates):
        points = LOOP[:1] + LOOP[1:] * loops
        t, T = path(*points, rate=rate, hold=1000.0)
        felt = np.interp(t - lag, t, T)
        y = polynomial.polyval(felt - 20.0, CUBIC) + 0.5 * hysteresis * way(T) + drift * rng.normal() * t
        sweeps.append(sweep(f"r{number}", t, T, y + rng.normal(0.0, NOISE, T.size) + rng.normal(0.0, 0.01)))
    return Readings(tuple(sweeps))


def reduced(found: Readings, **settings: object) -> OfSensor:
    return reduce(plan(**settings), found).sensors["x"]


def test_one_loop_states_its_path_difference_and_is_unclear_about_hysteresis() -> None:
    paths = reduced(readings((0.02,), hysteresis=0.005)).paths
    assert paths.difference.value == pytest.approx(0.005, abs=3e-4)
    assert paths.difference.u is not None
    assert paths.difference.value == pytest.approx(0.005, abs=4.0 * paths.difference.u)
    assert (paths.word, paths.loops) == ("unclear", 1)
    assert paths.hysteresis.value is None
    assert "one loop" in paths.hysteresis.reason


@pytest.mark.parametrize("lag", [0.0, 60.0])
def test_two_rates_tell_hysteresis_from_lag(lag: float) -> None:
    paths = reduced(readings((0.025, 0.0125, 0.025, 0.0125, 0.025), hysteresis=0.005, lag=lag)).paths
    assert paths.word == "yes"
    assert paths.hysteresis.value == pytest.approx(0.005, abs=1e-3)
    assert paths.lag.value == pytest.approx(lag, abs=12.0)


def test_lag_alone_is_no_hysteresis() -> None:
    paths = reduced(readings((0.025, 0.0125, 0.025, 0.0125, 0.025), lag=60.0), no_hysteresis=0.003).paths
    assert paths.difference.value is not None
    assert paths.difference.value > 0.005  # what one loop would call hysteresis
    assert paths.word == "no"


def test_at_one_rate_lag_and_hysteresis_look_the_same() -> None:
    paths = reduced(readings((0.02,) * 5, lag=60.0)).paths
    assert paths.word == "unclear"


def test_drift_of_the_runs_does_not_pass_for_hysteresis() -> None:
    paths = reduced(readings((0.025, 0.0125, 0.025, 0.0125, 0.025), drift=1e-6, loops=2)).paths
    assert paths.word == "unclear"
    assert paths.hysteresis.value == pytest.approx(0.0, abs=2e-3)


def test_without_time_nothing_is_said_of_lag() -> None:
    found = readings((0.02, 0.01), hysteresis=0.005)
    blind = replace(found, sweeps=tuple(replace(one, time=None) for one in found.sweeps))
    paths = reduced(blind).paths
    assert paths.word == "unclear"
    assert "no time column" in paths.hysteresis.reason
    assert paths.difference.value == pytest.approx(0.005, abs=5e-4)
    assert paths.rates == ()


def test_the_sign_is_that_of_warming_less_cooling() -> None:
    rates = (0.025, 0.0125, 0.025, 0.0125, 0.025)
    one, other = (reduced(readings(rates, hysteresis=h)).paths.difference.value for h in (0.004, -0.004))
    assert one is not None
    assert other is not None
    assert one == pytest.approx(0.004, abs=5e-4)
    assert other == pytest.approx(-0.004, abs=5e-4)


def test_the_gap_may_change_over_temperature() -> None:
    """A lens that closes at both ends: its mean is told, and the polynomial stays midway."""

    def lens(T: Array) -> Array:
        return np.asarray(0.004 * (1.0 - ((T - 18.5) / 48.5) ** 2))

    sweeps = []
    for number in range(4):
        t, T = path(*LOOP)
        y = polynomial.polyval(T - 20.0, CUBIC) + 0.5 * lens(T) * way(T)
        sweeps.append(sweep(f"r{number}", t, T, y))
    one = reduced(Readings(tuple(sweeps)))
    low, high = one.cells.both or (0.0, 0.0)
    mean = float(np.mean(lens(np.linspace(low, high, 500))))
    assert one.paths.difference.value == pytest.approx(mean, rel=0.02)
    at = np.array([-20.0, 20.0, 60.0])
    assert one.law.basis(at) @ one.law.coefficients == pytest.approx(polynomial.polyval(at - 20.0, CUBIC), abs=5e-5)


def slow_one_way(lag: float, runs: int = 5) -> Readings:
    """Runs that warm slowly and cool fast over one half of the range: midway, a lag does not cancel."""
    rng = np.random.default_rng(6)
    sweeps = []
    for number in range(runs):
        knots, levels = [0.0], [23.0]
        for level, rate in ((-30.0, 0.05), (67.0, 0.02), (-30.0, 0.05), (67.0, 0.01), (23.0, 0.05)):
            knots.append(knots[-1] + abs(level - levels[-1]) / rate)
            levels.append(level)
        t = np.arange(10.0, knots[-1], 20.0)
        behind, step = np.empty(int(knots[-1])), 1.0 - np.exp(-1.0 / lag)
        behind[0] = 23.0
        outside = np.interp(np.arange(behind.size), knots, levels)
        for i in range(1, behind.size):
            behind[i] = behind[i - 1] + step * (outside[i] - behind[i - 1])
        T = np.interp(t, knots, levels)
        y = polynomial.polyval(np.interp(t, np.arange(behind.size), behind) - 20.0, CUBIC)
        sweeps.append(sweep(f"r{number}", t, T, y + rng.normal(0.0, NOISE, T.size) + rng.normal(0.0, 1e-3)))
    return Readings(tuple(sweeps))


def test_a_lag_that_does_not_cancel_midway_is_taken_out_of_the_polynomial() -> None:
    found = reduce(plan(), slow_one_way(60.0))
    assert found.sensors["x"].paths.lag.value == pytest.approx(60.0, rel=0.05)
    slope = next(row for row in found.rows() if str(row.key) == "bias_temperature_1_x")
    assert slope.value == pytest.approx(CUBIC[1], abs=5e-6)  # 3e-5 off without the lag


def test_two_runs_of_one_loop_at_one_rate_are_unclear_whatever_the_order() -> None:
    paths = reduced(readings((0.02, 0.02), lag=60.0), order=5).paths
    assert paths.hysteresis.value is None
    assert "two rates" in paths.hysteresis.reason


UP, DOWN, BOTH = (-20.0, 60.0), (60.0, -20.0), (-20.0, 60.0, -20.0)
UNITS = {
    "neither": Unit(turn_on=0.0),
    "hysteresis": Unit(turn_on=0.0, hysteresis=0.002),
    "turn-on shifts": Unit(turn_on=0.001, slope_scatter=2e-6),
    "both": Unit(turn_on=0.001, slope_scatter=2e-6, hysteresis=0.002),
    "drift": Unit(turn_on=0.0, hysteresis=0.0005, walk=5e-6),
}
PROGRAMMES = {
    "one ramp each": (UP, DOWN),
    "two of one, one of the other": (UP, UP, DOWN),
    "one ramp, and a loop": (UP, BOTH),
}


def chambered(seed: int, unit: Unit, programme: tuple[tuple[float, ...], ...]) -> tuple[Result, dict[str, float]]:
    """Return what is made of power-ups of a simulator that shares no code with the package, and its truth."""
    chamber = Chamber(runs=len(programme), hold=0.0, in_turn=programme, interval=20.0)
    case = ramped(seed, unit, chamber)
    sweeps = []
    for name, table in case.tables.items():
        c = table.columns
        time = np.asarray(c["unix_s"], dtype=float)
        sweeps.append(sweep(name, time - time[0], c["temperature [degC]"], np.radians(c["gyro_x [deg/s]"])))
    pole = plan(at=[0.0, 40.0], latitude=0.5 * np.pi, attitude=Attitude(0.0, 0.0, 0.0, 0.0))  # x reads nothing of earth
    return reduce(pole, Readings(tuple(sweeps))), case.truth


def held(n: int, unit: Unit, programme: tuple[tuple[float, ...], ...]) -> dict[str, list[bool]]:
    """Return of each seed whether the interval of each figure holds the truth."""
    hits: dict[str, list[bool]] = {}
    for seed in range(1, n + 1):
        result, truth = chambered(seed, unit, programme)
        for row in result.rows():
            name = f"{row.quantity} {row.axis}" + (f" {row.key.at.value:g} degC" if row.key.at is not None else "")
            if row.interval is not None and row.method is Method.RESULT and name in truth:
                hits.setdefault(name, []).append(contains(row.interval, np.radians(truth[name])))
    return hits


@pytest.mark.parametrize("programme", PROGRAMMES)
def test_where_one_run_alone_saw_a_path_its_difference_is_in_the_uncertainty(programme: str) -> None:
    result, _ = chambered(1, UNITS["hysteresis"], PROGRAMMES[programme])
    assert "paths_or_runs" in {remark.code for remark in result.remarks}
    one, rows = result.sensors["x"], {str(row.key): row for row in result.rows() if row.method is Method.RESULT}
    assert one.law.level == "run"
    assert rows["path_difference_x"].status == rows["hysteresis_x"].status == "not_estimated"
    difference = rows["path_difference_x"].value
    assert difference is not None
    assert rows["bias_x"].u is not None
    assert 0.0 < rows["bias_x"].u < abs(difference)  # of the size of what was seen
    if programme == "one ramp each":
        assert rows["bias_x"].u == pytest.approx(0.5 * abs(difference), rel=0.1)


def test_two_runs_of_each_path_tell_what_the_paths_differ_by() -> None:
    result, truth = chambered(1, UNITS["both"], (UP, UP, DOWN, DOWN))
    assert "paths_or_runs" not in {remark.code for remark in result.remarks}
    difference = result.sensors["x"].paths.difference
    assert difference.u is not None
    assert difference.value == pytest.approx(np.radians(truth["path_difference x"]), abs=4.0 * difference.u)


def test_intervals_of_one_ramp_each_hold_the_truth() -> None:
    hits = held(40, UNITS["both"], PROGRAMMES["one ramp each"])
    assert {"bias x", "bias x 0 degC", "bias_temperature_1 x"} <= set(hits)
    assert all(covers(sum(one), len(one)) for one in hits.values()), hits


@pytest.mark.slow
@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("programme", PROGRAMMES)
def test_intervals_of_paths_in_runs_of_their_own_hold_the_truth(unit: str, programme: str) -> None:
    hits = held(sized(300, 60), UNITS[unit], PROGRAMMES[programme])
    assert all(covers(sum(one), len(one)) for one in hits.values()), hits
