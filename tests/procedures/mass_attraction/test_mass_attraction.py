"""A moved mass: the line that was put in comes out, with its sign; Table 4 of 1969; what is wrong is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from inertialcal.core.constants import STANDARD_GRAVITY
from inertialcal.core.errors import DataError, PlanError
from inertialcal.core.estimate import Array
from inertialcal.core.influence import Influence
from inertialcal.core.recording import SECOND, Channel, Recording
from inertialcal.core.results import Row
from inertialcal.procedures.mass_attraction.agreement import agreement
from inertialcal.procedures.mass_attraction.line import shape_of
from inertialcal.procedures.mass_attraction.published import less_noise, published
from inertialcal.procedures.mass_attraction.reduction import (
    HighG,
    Line,
    Plan,
    Readings,
    Result,
    Run,
    Schedule,
    SourceMass,
    SourceMassRecording,
    readings_from,
    reduce,
    repeated,
    run_of_rows,
)
from inertialcal.procedures.mass_attraction.response import tilt_left
from inertialcal.statistics.intervals import contains, covers, t_interval
from sized import sized

G = STANDARD_GRAVITY.value
NG = 1e-9 * G
S = 10.21e6 / G  # [count/s/(m/s^2)]
EXACT = 1e-9
PLAN = Plan(nominal=S, tilt="ignored")


def schedule(cycles: int = 25, drive: str = "sine", u: float | None = 0.0087) -> Schedule:
    places, fields = ([0.29, 0.127, 0.29, 0.432], [44.5, 67.5, 44.5, 21.5])
    if drive == "ABAB":
        places, fields = places[1::2], fields[1::2]
    return repeated(places, np.array(fields) * NG, cycles=cycles, dwell=100.0, move=20.0, u_applied=u)


def noise(rng: np.random.Generator, n: int = 100) -> Array:
    slow = np.cumsum(rng.normal(0.0, 0.02, n))
    return np.asarray(173.0 + 0.1 * rng.standard_normal(n) + slow + rng.normal() * np.linspace(-1.0, 1.0, n) ** 3)


def run(rng: np.random.Generator, scale: float = S, name: str = "1", one: Schedule | None = None) -> Run:
    of = one or schedule()
    return Run(name, of, noise(rng, len(of)) + scale * of.applied)


def row(result: Result, quantity: str, condition: str = "") -> Row:
    (found,) = [one for one in result.rows() if (one.quantity, str(one.case)) == (quantity, condition)]
    return found


def codes(result: Result) -> list[str]:
    return [one.code for one in result.remarks]


# What was put in comes out


@pytest.mark.parametrize("drive", ["sine", "ABAB"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_line_without_noise_of_its_own_has_its_size_and_sign(drive: str, sign: float) -> None:
    of = schedule(25 if drive == "sine" else 50, drive)
    tiny = 1e-9 * np.random.default_rng(1).standard_normal(len(of))
    result = reduce(PLAN, Readings((Run("1", of, 170.0 + sign * S * of.applied + tiny),)))
    assert row(result, "scale_factor").value == pytest.approx(sign * S, rel=1e-6)
    assert ("wrong_sign" in codes(result)) == (sign < 0.0)


def test_gaps_shift_nothing() -> None:
    of = schedule()
    x = 170.0 + S * of.applied + 1e-9 * np.random.default_rng(1).standard_normal(100)
    x[[3, 17, 18, 60]] = np.nan
    result = reduce(PLAN, Readings((Run("1", of, x),)))
    assert row(result, "scale_factor").value == pytest.approx(S, rel=2e-4)
    assert row(result, "scale_factor", "as_published").status in ("estimated", "not_estimated")
    (said,) = [one for one in result.remarks if one.code == "missing_dwells"]
    assert "4 dwell(s)" in said.what


def test_a_known_tilt_in_phase_is_taken_off_with_its_sign_and_the_mercury_is_not_taken_for_one() -> None:
    of, rng = schedule(), np.random.default_rng(1)
    s, tau, mercury = shape_of(of), 3e-9, 1e-9
    x = 170.0 + S * (of.applied + G * tau * s) + 1e-6 * rng.standard_normal(100)
    meter = 5e-6 + (tau + mercury) * s + 1e-14 * rng.standard_normal(100)
    for plan, expected in (
        (Plan(nominal=S, tilt="known", mercury=mercury), S),
        (Plan(tilt="known", mercury=mercury), S),  # nor is one needed
        (Plan(nominal=1.1 * S, tilt="known", mercury=mercury), S),  # the nominal scale factor is not the answer
        (Plan(nominal=S, tilt="known"), S * (of.amplitude + G * tau) / (of.amplitude + G * (tau + mercury))),
        (Plan(nominal=S, tilt="ignored"), S * (1.0 + G * tau / of.amplitude)),
    ):  # fmt: skip
        result = reduce(plan, Readings((Run("1", of, x, meter),)))
        assert row(result, "scale_factor").value == pytest.approx(expected, rel=2e-4)
    other = Run("1", of, x, -meter + 2.0 * mercury * s)
    flipped = reduce(Plan(nominal=S, tilt="known", tilt_sign=-1, mercury=mercury), Readings((other,)))
    assert row(flipped, "scale_factor").value == pytest.approx(S, rel=2e-4)


def test_the_mercury_of_the_schedule_is_taken_off_dwell_by_dwell_and_not_beside_that_of_the_plan() -> None:
    of, rng = schedule(), np.random.default_rng(1)
    s, tau = shape_of(of), 3e-9
    mercury = 5e-9 + 1e-9 * s + 4e-10 * s**2  # not in proportion to what is applied
    x = 170.0 + S * (of.applied + G * tau * s) + 1e-6 * rng.standard_normal(100)
    tilted = replace(of, mercury=mercury)
    meter = 5e-6 + tau * s + mercury + 1e-14 * rng.standard_normal(100)
    result = reduce(Plan(nominal=S, tilt="known"), Readings((Run("1", tilted, x, meter),)))
    assert row(result, "scale_factor").value == pytest.approx(S, rel=2e-4)
    with pytest.raises(PlanError, match="a column mercury in the schedule"):
        reduce(Plan(nominal=S, tilt="known", mercury=1e-9), Readings((Run("1", tilted, x, meter),)))


def test_a_regressed_tilt_finds_its_share_from_the_readings() -> None:
    of, rng = schedule(), np.random.default_rng(2)
    own = 2e-8 * rng.standard_normal(100)
    tilt = own + 3e-9 * shape_of(of)
    x = 170.0 + S * (of.applied - 0.7 * G * tilt) + 1e-4 * rng.standard_normal(100)
    result = reduce(Plan(nominal=S, tilt="regressed"), Readings((Run("1", of, x, tilt),)))
    assert result.responses[0].coefficient == pytest.approx(-0.7 * G * S, rel=1e-2)
    assert row(result, "scale_factor").value == pytest.approx(S, rel=2e-3)


def test_the_coefficient_of_a_regressed_tilt_is_as_uncertain_as_noise_over_tilt_makes_it() -> None:
    """White readings of scatter s, white tilt of scatter w, n / 2 dwells left by drift: u(p) = s / (w sqrt(n / 2))."""
    of, parts = schedule(), []
    for seed in range(1, 31):
        rng = np.random.default_rng(seed)
        tilt = 1e-8 * rng.standard_normal(100) + 3e-8 * shape_of(of)
        x = 170.0 + S * (of.applied + G * tilt) + 0.1 * rng.standard_normal(100)
        (response,) = reduce(Plan(nominal=S, tilt="regressed"), Readings((Run("1", of, x, tilt),))).responses
        assert response.fitted is not None
        parts.append((response.u**2 - response.fitted.u**2) / response.tilt**2)
    assert np.sqrt(np.mean(parts)) == pytest.approx(0.1 / (1e-8 * np.sqrt(50.0)), rel=0.2)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_tilt_that_its_meter_drowns_in_noise_is_not_regressed_but_known_by_its_line(sense: float) -> None:
    """4e-9 rad in phase with the drive, 2e-9 rad noise of the meter, none off the drive."""
    of, runs = schedule(u=0.0), []
    for seed in range(1, 6):
        rng = np.random.default_rng(seed)
        pad = 4e-9 * shape_of(of)
        x = 170.0 + S * (of.applied + G * pad) + 0.01 * rng.standard_normal(100)
        runs.append(Run(str(seed), of, x, sense * pad + 2e-9 * rng.standard_normal(100)))
    with pytest.raises(DataError, match="do not show the tilt") as caught:
        reduce(Plan(nominal=S, tilt="regressed"), Readings(tuple(runs)))
    assert caught.value.problems[0].code == "tilt_not_regressed"
    for nominal in (1.1 * S, None):
        known = reduce(Plan(nominal=nominal, tilt="known", tilt_sign=int(sense)), Readings(tuple(runs)))  # type: ignore[arg-type]
        found = row(known, "scale_factor")
        assert found.u is not None
        assert found.value == pytest.approx(S, abs=3.0 * found.u)
        assert found.u < 0.02 * S


def test_a_sign_of_the_meter_that_the_readings_contradict_is_an_error() -> None:
    of, rng = schedule(), np.random.default_rng(3)
    pad = 3e-8 * rng.standard_normal(100) + 3e-9 * shape_of(of)
    x = 170.0 + S * (of.applied + G * pad) + 0.05 * rng.standard_normal(100)
    readings = Readings((Run("1", of, x, pad),))
    assert not agreement(Plan(nominal=S, tilt="known"), readings)
    remarks = agreement(Plan(nominal=S, tilt="known", tilt_sign=-1), readings)
    assert "tilt_sign_disagrees" in [one.code for one in remarks]


def test_the_doubt_about_the_high_g_scale_factor_is_in_the_difference_from_it() -> None:
    """Of ``S / H - 1`` the slope by H is ``-S / H^2``."""
    readings, high = Readings((run(np.random.default_rng(1)),)), 0.9 * S
    exact, doubtful = (row(reduce(replace(PLAN, high_g=HighG(high, u)), readings), "high_g_difference")
                       for u in (0.0, 0.02 * high))  # fmt: skip
    scale = row(reduce(PLAN, readings), "scale_factor").value
    assert exact.u is not None
    assert doubtful.u is not None
    assert scale is not None
    assert doubtful.u**2 - exact.u**2 == pytest.approx((0.02 * scale / high) ** 2, rel=1e-9)


def test_what_the_noise_of_the_meter_leaves_of_a_regressed_tilt_is_told_and_counted() -> None:
    """Half of the variance of the meter is noise: its coefficient lies between a half and all, whatever its sense."""
    of, tau = schedule(u=0.0), 3e-9
    for sense in (1.0, -1.0):
        off, told, runs = [], [], []
        for seed in range(1, 31):
            rng = np.random.default_rng(seed)
            pad = 1e-8 * rng.standard_normal(100) + tau * shape_of(of)
            x = 170.0 + S * (of.applied + G * pad) + 1e-4 * rng.standard_normal(100)
            runs.append(Run(str(seed), of, x, sense * (pad + 1e-8 * rng.standard_normal(100))))
            result = reduce(Plan(nominal=S), Readings((runs[-1],)))
            assert result.estimate is not None
            scale = float(result.estimate.values[0])
            off.append(scale / S - 1.0)
            told.append(tilt_left(result.responses) / scale)
        quarter = 0.25 * G * tau / of.amplitude
        assert np.mean(off) == pytest.approx(quarter, rel=0.5)
        assert np.mean(told) == pytest.approx(quarter / np.sqrt(2.0), rel=0.5)
        together = reduce(Plan(nominal=S), Readings(tuple(runs)))
        (said,) = [one for one in together.remarks if one.code == "tilt_in_phase"]
        assert "% to u" in said.what
        assert together.estimate is not None
        assert float(together.estimate.values[0]) == pytest.approx(S, abs=2.5 * float(together.estimate.u[0]))


# Table 4 of TM X-53857 [0.01 pulses/s]: G, B, GR, CR, GO, BO, XSD of experiments 1 to 6

TABLE_4 = (
    (28.07, 27.80, 4.70, 2.17, 23.27, 25.63, 5.59), (26.56, 26.80, 3.87, 3.41, 22.69, 23.39, 6.77),
    (29.72, 29.64, 5.02, 5.57, 24.70, 24.07, 11.90), (24.78, 25.62, 5.85, 5.30, 18.93, 20.32, 14.06),
    (2.02, 1.12, 2.14, 2.01, -1.2, -0.89, 4.90), (3.14, 2.08, 3.94, 4.13, -0.80, -2.05, 10.12),
)  # fmt: skip
MISPRINTS = {(0, "GO"), (4, "GO")}  # 23.37 and -0.12 follow from the same row
HALF_DIGIT = 0.0051


def table_4() -> tuple[Line, ...]:
    return tuple(
        Line(f"{i + 1}", 23.0 * NG, B / 100, CR / 100, u_applied=0.2 / 23.0, moved=i < 4, psd_response=GG / 100,
             psd_noise=GR / 100, scatter=XSD / 100)
        for i, (GG, B, GR, CR, _, _, XSD) in enumerate(TABLE_4)
    )  # fmt: skip


def test_the_identities_of_table_4_hold_but_for_two_misprints() -> None:
    off = set()
    for i, line in enumerate(table_4()):
        GO, BO = (100.0 * value for value in less_noise(line))
        off |= {(i, name) for name, found, printed in (("GO", GO, TABLE_4[i][4]), ("BO", BO, TABLE_4[i][5]))
                if abs(found - printed) > HALF_DIGIT}  # fmt: skip
    assert off == MISPRINTS


def test_the_published_scale_factor_follows_from_table_4() -> None:
    found = published([line for line in table_4() if line.name in "123"])
    assert found is not None
    assert (found.rounded, found.u_rounded) == pytest.approx((0.24, 0.02), rel=EXACT)
    assert found.scale_factor * G == pytest.approx(1.0435e7, rel=1e-4)
    assert found.u_scale_factor * G == pytest.approx(0.087e7, rel=6e-3)


def test_without_subtraction_table_4_disagrees_with_the_data_sheet() -> None:
    lines = tuple(line for line in table_4() if line.name in "12356")
    plan = Plan(nominal=S, tilt="ignored", high_g=HighG(S))
    result = reduce(plan, Readings((), lines))
    found = row(result, "scale_factor")
    noise_alone = result.joined.within if result.joined is not None else None
    assert noise_alone is not None
    assert (found.value or 0.0) * G == pytest.approx(1.205e7, rel=1e-3)
    assert noise_alone.u * G == pytest.approx(0.060e7, rel=1e-2)
    assert "disagrees_with_high_g" in codes(result)
    assert "normalised difference +3.0" in row(result, "high_g_difference").reason.text
    assert (row(result, "scale_factor", "as_published").value or 0.0) * G == pytest.approx(1.0435e7, rel=1e-4)
    assert "null_run_not_zero" not in codes(result)


# Several runs


def test_standards_do_not_shrink_with_runs_and_schedule_is_the_last_resort() -> None:
    rng = np.random.default_rng(3)
    runs = tuple(run(rng, name=str(i)) for i in range(5))
    stated = reduce(replace(PLAN, standards={"source_mass.density": Influence(0.05)}), Readings(runs))
    assert stated.estimate is not None
    parts = {one.source: float(one.u[0]) for one in stated.estimate.components}
    assert parts["density of the mass"] == pytest.approx(0.05 * stated.estimate.values[0])
    said = reduce(PLAN, Readings(runs)).estimate
    assert said is not None
    assert {one.source for one in said.components} - {"scatter between runs"} <= {
        "noise next to the line of each run",
        "acceleration applied",
    }
    bare = schedule(u=None)
    nothing = reduce(PLAN, Readings(tuple(replace(one, schedule=bare) for one in runs)))
    assert "relative_to_fixture" in codes(nothing)


# What is wrong is told


@pytest.mark.parametrize(("at", "by"), [(0, 1), (40, 1), (70, -1)])
def test_a_slip_of_the_schedule_is_refused_with_its_place(at: int, by: int) -> None:
    of, rng = schedule(), np.random.default_rng(4)
    late = np.concatenate([of.applied[:at], np.roll(of.applied, by)[at:]])
    with pytest.raises(DataError, match=r"one dwell (late|early)") as caught:
        reduce(PLAN, Readings((Run("7", of, noise(rng) + S * late, where="run7.csv"),)))
    assert caught.value.problems[0].code == "schedule_slip"


def test_a_response_below_the_floor_is_an_upper_limit_and_no_scale_factor() -> None:
    rng = np.random.default_rng(6)
    result = reduce(PLAN, Readings((run(rng, 0.02 * S),)))
    assert row(result, "scale_factor").status == "not_estimated"
    assert row(result, "scale_factor").reason.code == "not_told"
    limit = row(result, "response_amplitude", "run 1 alone")
    assert limit.status == "upper_limit"
    assert limit.value is not None
    assert limit.value > 0.02 * S * schedule().amplitude
    assert {"below_floor", "no_runs", "no_null_run"} <= set(codes(result))


def test_a_null_run_that_follows_the_schedule_is_remarked() -> None:
    rng = np.random.default_rng(7)
    null = replace(run(rng, name="null"), moved=False)
    assert "null_run_not_zero" in codes(reduce(PLAN, Readings((run(rng), null))))
    quiet = Run("null", schedule(), noise(rng), moved=False)
    found = reduce(PLAN, Readings((run(rng), quiet)))
    assert "null_run_not_zero" not in codes(found)
    assert row(found, "null_response", "run null alone").unit == "m/s^2"


def test_a_window_that_is_not_whole_cycles_has_no_published_figure() -> None:
    of = schedule()
    cut = Schedule(of.start[:98], 100.0, 20.0, of.position[:98], of.applied[:98], "sine", 4)
    result = reduce(PLAN, Readings((run(np.random.default_rng(8), one=cut),)))
    assert "not_whole_cycles" in codes(result)
    assert "not in whole cycles" in row(result, "scale_factor", "as_published").reason.text
    assert row(result, "scale_factor").value == pytest.approx(S, rel=0.3)


@pytest.mark.parametrize(
    ("source", "code"),
    [
        (SourceMass(1338.0, 11340.0, -0.01), "overlap"), (SourceMass(1338.0, 1.0, 0.076), "absurd_density"),
        (SourceMass(1338.0, 11340.0, 0.5), "too_attractive"),
    ],
)  # fmt: skip
def test_a_mass_that_cannot_be_is_refused(source: SourceMass, code: str) -> None:
    with pytest.raises(DataError) as caught:
        reduce(replace(PLAN, source=source), Readings((run(np.random.default_rng(9)),)))
    assert caught.value.problems[0].code == code
    reduce(replace(PLAN, source=SourceMass(1338.0, 11340.0, 0.076)), Readings((run(np.random.default_rng(9)),)))


def test_what_tells_nothing_is_refused() -> None:
    null = Run("0", schedule(), noise(np.random.default_rng(1)), moved=False)
    with pytest.raises(DataError, match="the mass moved in no run"):
        reduce(PLAN, Readings((null,)))
    short = replace(null, moved=True, reading=np.where(np.arange(100) < 8, null.reading, np.nan))
    with pytest.raises(DataError, match="8 of 100 dwells have a reading"):
        reduce(PLAN, Readings((short,)))


# From recordings


def recording(of: Schedule, gate: float = 100.0, per_dwell: int = 1) -> Recording:
    starts = (of.start[:, None] + gate * np.arange(per_dwell)).ravel()
    values = np.repeat(170.0 + S * of.applied, per_dwell) + 0.01 * np.tile(np.arange(per_dwell), len(of))
    time = np.rint((5e8 + starts + 0.5 * gate) * SECOND).astype(np.int64)
    return Recording((Channel("reading", values, "count/s"),), time, None, gate, "utc")


def test_a_table_a_row_a_dwell_gives_the_readings_of_the_recording() -> None:
    of = schedule()
    table = run_of_rows(of, 170.0 + S * of.applied)
    (one,) = readings_from(PLAN, [SourceMassRecording(recording(of), of)]).series
    np.testing.assert_allclose(one.reading, table.reading)
    (finer,) = readings_from(PLAN, [SourceMassRecording(recording(of, 10.0, 10), of, begin=5 * 10**8 * SECOND)]).series
    np.testing.assert_allclose(finer.reading, table.reading + 0.045)


def test_a_record_and_a_schedule_of_different_length_are_refused() -> None:
    of, longer = schedule(25), schedule(40)
    with pytest.raises(DataError, match=r"the record ends 60 dwells before its schedule of 160 dwells") as caught:
        readings_from(PLAN, [SourceMassRecording(recording(of), longer, name="1")])
    assert caught.value.problems[0].code == "length_differs"
    with pytest.raises(DataError, match=r"the record ends 60 dwells after its schedule of 100"):
        readings_from(PLAN, [SourceMassRecording(recording(longer), of, name="1")])
    with pytest.raises(DataError, match=r"99 rows, but the schedule has 100 dwells"):
        run_of_rows(of, np.zeros(99))


def test_a_gate_longer_than_a_dwell_and_a_record_without_clock_are_refused() -> None:
    of = schedule()
    with pytest.raises(DataError, match=r"a gate of 120 s, but the mass dwells for 100 s"):
        readings_from(PLAN, [SourceMassRecording(replace(recording(of), averaging_time=120.0), of)])
    with pytest.raises(DataError, match=r"averaging time"):
        readings_from(PLAN, [SourceMassRecording(replace(recording(of), averaging_time=None), of)])
    begin = (5 * 10**8 - 60) * SECOND
    with pytest.raises(DataError, match=r"samples lie in no dwell"):
        readings_from(PLAN, [SourceMassRecording(recording(of), of, begin)])


# Coverage


def hits(n: int, tilted: bool) -> int:
    """Return how many intervals of two runs each hold the truth."""
    of, held = schedule(u=0.0), 0
    for seed in range(1, n + 1):
        rng = np.random.default_rng(seed)
        runs = [run(rng, name=str(i), one=of) for i in range(2)]
        if tilted:
            tilts = [2e-8 * rng.standard_normal(100) + 1e-9 * shape_of(of) for _ in runs]
            pairs = zip(runs, tilts, strict=True)
            runs = [replace(one, reading=one.reading + S * G * tilt, tilt=tilt) for one, tilt in pairs]
        result = reduce(Plan(nominal=S, tilt="regressed" if tilted else "ignored"), Readings(tuple(runs)))
        assert result.estimate is not None
        value, u, dof = (float(one[0]) for one in (result.estimate.values, result.estimate.u, result.estimate.dof))
        held += contains(t_interval(value, u, dof), S)
    return held


def test_intervals_hold_the_truth_in_a_few_campaigns() -> None:
    assert covers(hits(60, False), 60)


@pytest.mark.slow
def test_intervals_with_a_regressed_tilt_hold_the_truth() -> None:
    n = sized(1000, 250)
    held = hits(n, True)
    assert covers(held, n, 0.93), held  # 906 of 1,000: with two runs a little too narrow, as it was before


def test_the_error_of_the_scale_factor_is_as_uncertain_as_the_scale_factor_relative_to_nominal() -> None:
    rng = np.random.default_rng(8)
    nominal = 1.2 * S
    result = reduce(Plan(nominal=nominal, tilt="ignored"), Readings(tuple(run(rng, name=name) for name in "123")))
    scale, error = row(result, "scale_factor"), row(result, "scale_factor_error")
    assert scale.u is not None
    assert error.value == pytest.approx((scale.value or 0.0) / nominal - 1.0)
    assert error.u == pytest.approx(scale.u / nominal)
