"""Drive, design and fit: exact where there is no noise, signs, what is refused, a million samples."""

import time

import numpy as np
import pytest
from scipy import stats

from inertialcal.core.errors import DataError
from inertialcal.signals.sine.amplitude import amplitude_of, most_likely
from inertialcal.signals.sine.cross_checks import CrossCheck, cross_checks, difference_weights, smoothing_remark
from inertialcal.signals.sine.drive import applied_drive, averaging_response, sine_drive
from inertialcal.signals.sine.fit import common_noise, design_of, fit_line
from inertialcal.signals.sine.noise import Noise, noise_of, same_noise

STEP = 120.0
TIMES = 50.0 + STEP * np.arange(100)
PERIOD = 4 * STEP
NOISE = 1e-6 * np.random.default_rng(1).standard_normal(100)


def test_amplitudes_are_signed_and_drift_is_none_of_them() -> None:
    drive = sine_drive(TIMES, 1.0 / PERIOD, 0.4)
    angle = 2 * np.pi * (TIMES - TIMES[0]) / PERIOD + 0.4
    drift = 1e3 + 5.0 * np.cos(np.pi * 3 * (np.arange(100) + 0.5) / 100)
    fit = fit_line(design_of(drive), -2.0 * np.sin(angle) + 0.5 * np.cos(angle) + drift + NOISE)
    assert fit.quadrature is not None
    assert (fit.in_phase[0], fit.quadrature[0]) == pytest.approx((-2.0, 0.5), abs=1e-5)
    line, slow = fit.fitted()
    np.testing.assert_allclose(slow, drift, atol=1e-5)
    np.testing.assert_allclose(line, -2.0 * np.sin(angle) + 0.5 * np.cos(angle), atol=1e-5)


def test_frequency_is_that_of_the_true_times() -> None:
    """100 s counted and 20 s to move: a period of 480 s. With the pauses left out there is nothing at 1/400 Hz."""
    x = np.tile([0.0, 1.0, 0.0, -1.0], 25) + NOISE
    right = fit_line(design_of(sine_drive(TIMES, 1.0 / 480.0, 0.0)), x)
    wrong = fit_line(design_of(sine_drive(TIMES, 1.0 / 400.0, 0.0)), x)
    assert right.in_phase[0] == pytest.approx(1.0, abs=1e-5)
    assert abs(wrong.in_phase[0]) < 0.1


def test_uncertainty_of_white_noise_is_a_twentieth_more_than_theory() -> None:
    """2 sigma^2 / N, the limit S(f0) / T, and what the unknown drift takes; the mean over its shares is 6 % more."""
    x = 0.3 * np.random.default_rng(1).standard_normal((100, 2000))
    fit = fit_line(design_of(sine_drive(TIMES, 1.0 / PERIOD, 0.0)), x)
    theory = 0.3 * np.sqrt(2.0 / 100.0)
    assert 0.3 * np.linalg.norm(fit.weights) == pytest.approx(1.048 * theory, rel=0.002)
    assert fit.in_phase.std() == pytest.approx(1.048 * theory, rel=0.05)
    assert np.median(fit.u_in_phase) == pytest.approx(1.11 * theory, rel=0.03)
    np.testing.assert_allclose(np.sqrt(fit.density), fit.u_in_phase / 0.3 / np.linalg.norm(fit.weights)
                               * 0.3 * np.sqrt(2.0 * STEP))  # fmt: skip


def test_weights_are_those_of_the_estimate() -> None:
    drive = sine_drive(TIMES, 1.0 / PERIOD, 0.0)
    x = np.random.default_rng(1).standard_normal(100)
    fit = fit_line(design_of(drive), x)
    weights = fit.weights
    assert weights @ x == pytest.approx(fit.in_phase[0])
    assert weights @ drive.in_phase == pytest.approx(1.0)


def test_any_applied_sequence() -> None:
    """A square wave of eight samples, a random order: reading over applied, in the unit applied."""
    for applied in (np.tile([23.0] * 4 + [-23.0] * 4, 12), np.random.default_rng(3).choice([0.0, 46.0], 96)):
        x = 0.01 * applied + 3.0 + 1e-3 * np.arange(96) + 1e-6 * np.random.default_rng(4).standard_normal(96)
        fit = fit_line(design_of(applied_drive(STEP * np.arange(96), applied, 1.0 / (8 * STEP))), x)
        assert fit.in_phase[0] == pytest.approx(0.01, abs=1e-6)
        assert fit.quadrature is None


def test_applied_steps_that_are_a_sine_have_a_quadrature() -> None:
    drive = applied_drive(TIMES, np.tile([0.0, 2.0, 0.0, -2.0], 25), 1.0 / PERIOD)
    np.testing.assert_allclose(drive.quadrature[:4], [2.0, 0.0, -2.0, 0.0], atol=1e-12)  # type: ignore[index]


def test_alternating_positions_have_no_quadrature() -> None:
    drive = applied_drive(TIMES, np.tile([1.0, -1.0], 50), 0.5 / STEP)
    assert drive.quadrature is None
    fit = fit_line(design_of(drive), -0.25 * np.tile([1.0, -1.0], 50) + 1e-3 * TIMES + NOISE)
    assert fit.in_phase[0] == pytest.approx(-0.25, abs=1e-3)


def test_means_over_a_time_show_less_of_a_sine() -> None:
    fine = np.arange(48_000) * 0.01
    means = np.sin(2 * np.pi * fine / 48.0).reshape(-1, 1000).mean(axis=1)
    at = fine.reshape(-1, 1000).mean(axis=1)
    fit = fit_line(design_of(sine_drive(at, 1.0 / 48.0)), means + 1e-7 * np.random.default_rng(1).standard_normal(48))
    length = np.hypot(fit.in_phase[0], fit.quadrature[0])  # type: ignore[index]
    assert length == pytest.approx(averaging_response(1.0 / 48.0, 10.0), rel=1e-4)
    with pytest.raises(DataError, match="averaging removes it"):
        averaging_response(0.1, 10.0)


def test_alternating_differences_by_hand() -> None:
    """Three points of + and -: (1, -2, 1) / 4 on four samples, mean of two sums; order 8 over 9 half periods."""
    drive = applied_drive(np.arange(4.0), [1.0, -1.0, 1.0, -1.0], 0.5)
    np.testing.assert_allclose(difference_weights(drive), [0.125, -0.375, 0.375, -0.125], atol=1e-15)
    drive = applied_drive(TIMES, np.tile([0.0, 1.0, 0.0, -1.0], 25), 1.0 / PERIOD)
    weights = difference_weights(drive)
    assert weights @ drive.in_phase == pytest.approx(1.0)
    assert weights @ (3.0 + 0.2 * TIMES) == pytest.approx(0.0, abs=1e-12)


def test_alternating_differences_leave_incomplete_halves_out() -> None:
    keep = np.arange(100) != 31
    drive = applied_drive(TIMES[keep], np.tile([0.0, 1.0, 0.0, -1.0], 25)[keep], 1.0 / PERIOD)
    weights = difference_weights(drive, 2)
    assert weights[30] == 0.0  # the other sample of that half
    assert abs(weights @ (3.0 + 0.2 * TIMES[keep])) < 1e-12
    assert weights @ drive.in_phase == pytest.approx(1.0, abs=0.01)


def test_checks_share_their_noise_with_the_fit() -> None:
    """Uncertainty of a difference: far less than that of either, in a short record and in a long one."""
    for n in (100, 800):
        applied = np.tile([0.0, 1.0, 0.0, -1.0], n // 4)
        x = applied + 0.1 * np.random.default_rng(1).standard_normal(n)
        fit = fit_line(design_of(applied_drive(STEP * np.arange(n), applied, 1.0 / PERIOD)), x)
        made = [one for one in cross_checks(fit, x) if one.value is not None]
        assert len(made) == (2 if n == 100 else 1)
        for one in made:
            assert one.u == pytest.approx(fit.u_in_phase[0], rel=0.35)
            assert 0.0 < one.u_difference < 0.4 * one.u  # type: ignore[operator]
            assert abs(one.difference) < 3.0 * one.u_difference  # type: ignore[arg-type, operator]


def test_checks_say_why_they_cannot_be_made() -> None:
    times = np.sort(np.random.default_rng(1).uniform(0.0, 12_000.0, 500))
    x = np.random.default_rng(2).standard_normal(500)
    made = cross_checks(fit_line(design_of(sine_drive(times, 1.0 / PERIOD, 0.0)), x), x)
    assert [one.value for one in made] == [None, None]
    assert "evenly spaced" in made[0].reason
    assert "500 samples" in made[1].reason


def test_a_difference_beyond_three_standard_deviations_is_remarked() -> None:
    assert not CrossCheck("alternating_differences", 1.0, 0.1, 0.2, 0.1).disagrees
    check = CrossCheck("alternating_differences", 1.0, 0.1, 0.4, 0.1)
    assert check.disagrees
    assert "alternating differences differ from the fit by 0.4, noise explains 0.1" in str(check.remark())


def test_generalised_fit_agrees_in_white_noise() -> None:
    drive = sine_drive(TIMES, 1.0 / PERIOD, 0.0)
    x = drive.in_phase + 0.1 * np.random.default_rng(1).standard_normal(100)
    found = cross_checks(fit_line(design_of(drive), x), x)[1]
    assert found.value == pytest.approx(1.0, abs=0.05)
    assert found.u == pytest.approx(0.1 * np.sqrt(0.02), rel=0.3)


PLACE = (np.arange(100) + 0.5) / 100
SMOOTH = {
    "T/3": np.exp(-3 * PLACE), "T/10": np.exp(-10 * PLACE), "T/30": np.exp(-30 * PLACE), "line": 10.0 * PLACE,
    "cubic": (PLACE - 0.4) ** 3 - 0.1 * PLACE, "3 periods": 0.5 * np.sin(np.arange(100) * np.pi / 6 + 0.7),
    "5 periods": 0.5 * np.sin(np.arange(100) * np.pi / 10 + 2.0),
}  # fmt: skip


@pytest.mark.parametrize("name", SMOOTH)
def test_no_smooth_drift_enters(name: str) -> None:
    """1000 times the response: less than 0.5 % of it; a line and 20 cosines let up to 143 % pass."""
    weights = fit_line(design_of(sine_drive(TIMES, 1.0 / PERIOD, 0.0)), NOISE).weights
    assert abs(1000.0 * weights @ SMOOTH[name]) < 0.002


@pytest.mark.parametrize(("period", "size", "seen"), [(3.0, 1e3, False), (1.675, 1e2, True), (1.25, 3.0, True)])
def test_a_sine_near_the_drive_is_seen_by_another_smoothing(period: float, size: float, seen: bool) -> None:
    drive = sine_drive(TIMES, 1.0 / PERIOD, 0.0)
    x = drive.in_phase + 0.1 * np.random.default_rng(1).standard_normal(100)
    x += 0.5 * size * np.sin(2 * np.pi * np.arange(100) / (4.0 * period) + 0.7)
    fit = fit_line(design_of(drive), x)
    shifts = [(one.length, float(one.value[0]), float(one.u[0]), float(one.dof[0])) for one in fit.shifts
              if not one.across]  # fmt: skip
    found = smoothing_remark(shifts, float(fit.in_phase[0]), float(fit.u_in_phase[0]))
    assert (found is not None) == seen


def test_runs_share_their_noise_unless_it_differs() -> None:
    rng, design = np.random.default_rng(1), design_of(sine_drive(TIMES, 1.0 / PERIOD, 0.0))
    alike = [fit_line(design, rng.standard_normal(100)) for _ in range(4)]
    joined = common_noise(alike)
    assert len({float(one.u_in_phase[0]) for one in joined}) == 1
    assert joined[0].dof[0] > 2.0 * np.mean([one.dof[0] for one in alike])
    apart = [*alike[:3], fit_line(design, 5.0 * rng.standard_normal(100))]
    assert [one.u_in_phase[0] for one in common_noise(apart)] == [one.u_in_phase[0] for one in apart]


def test_variance_of_weights_is_averaged_over_the_shares_of_the_walk() -> None:
    """White 1 with a chance of 1/4, walk 2 x 6 / 4 = 3 with 3/4; 2 V^2 / dof: of a chi-square, and between both."""
    noise = Noise(np.array([0.0, 1.0]), 4.0, np.array([[1.0], [2.0]]), np.array([[0.25], [0.75]]), 10)
    variance, dof = noise.of(1.0, 6.0)
    assert variance[0] == pytest.approx(2.5)
    assert dof[0] == pytest.approx(2.0 * 2.5**2 / (0.25 * (0.2 + 1.5**2) + 0.75 * (0.2 * 9.0 + 0.5**2)))


@pytest.mark.parametrize(("white", "walk"), [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
def test_white_noise_and_walk_are_found_from_contrasts(white: float, walk: float) -> None:
    d = np.geomspace(0.01, 100.0, 4000)
    z = np.sqrt(white + walk * d)[:, None] * np.random.default_rng(3).standard_normal((4000, 1))
    found = noise_of([z], [d])
    for weights in ((1.0, 0.1), (1.0, 1.0), (1.0, 20.0)):
        variance, dof = found.of(*weights)
        assert variance[0] == pytest.approx(white * weights[0] + walk * weights[1], rel=0.15)
        assert 200.0 < dof[0] < 4001.0
    halves = [z[::2, 0], z[1::2, 0]]
    assert same_noise(halves, [d[::2], d[1::2]], found)
    assert not same_noise([halves[0], 1.3 * halves[1]], [d[::2], d[1::2]], found)


def test_drift_is_smoother_than_the_noise_that_it_is_found_in() -> None:
    drift, noise = 30.0 * np.exp(-3 * PLACE), np.random.default_rng(4).standard_normal(100)
    found = fit_line(design_of(sine_drive(TIMES, 1.0 / PERIOD, 0.0)), drift + noise).fitted()[1]
    assert np.std(found - drift) < 0.8


def test_the_scatter_of_many_stretches_is_the_uncertainty() -> None:
    n = 12_000
    x = np.random.default_rng(2).standard_normal((n, 40))
    fit = fit_line(design_of(sine_drive(np.arange(1.0 * n), 0.25, 0.0)), x)
    assert len(fit.design.stretches) >= 30
    assert np.sqrt(np.mean(fit.u_in_phase**2)) == pytest.approx(np.sqrt(2.0 / n), rel=0.06)
    assert fit.dof[0] == len(fit.design.stretches) - 1


def test_a_million_samples_with_gaps_in_seconds() -> None:
    """Cost: a root of 300 readings for each stretch that is like no other."""
    rng, n = np.random.default_rng(1), 1_000_000
    times = np.arange(n) * 0.1
    keep = rng.random(n) > 0.02
    keep[200_000:250_000] = False
    x = (np.cumsum(0.01 * rng.standard_normal(n)) + rng.standard_normal(n) + 0.05 * np.sin(2 * np.pi * times / 100))[
        keep
    ]
    start = time.process_time()
    fit = fit_line(design_of(sine_drive(times[keep], 0.01, 0.0)), x)
    assert abs(fit.in_phase[0] - 0.05) < 4.0 * fit.u_in_phase[0]
    assert time.process_time() - start < 4.0


def refused(kind: type[Exception], words: str, code: str, **given: object) -> None:
    n, step = int(given.get("n", 100)), float(given.get("step", 1.0))  # type: ignore[call-overload, arg-type]
    with pytest.raises(kind) as error:  # noqa: PT012 - any of the three may refuse
        drive = sine_drive(step * np.arange(n), given.get("f", 0.25), given.get("phase"))  # type: ignore[arg-type]
        fit_line(design_of(drive), given.get("x", np.zeros(n)))  # type: ignore[arg-type]
    assert words in str(error.value)
    assert error.value.problems[0].code == code  # type: ignore[attr-defined]


def test_refused() -> None:
    refused(DataError, "a record of 100 s, a period of 200 s: 0.5 cycles (it is shorter", "too_few_cycles", f=0.005)
    refused(DataError, "2.5 cycles (drive and drift cannot be separated)", "too_few_cycles", f=0.025)
    refused(DataError, "above half the sampling frequency", "nyquist", f=0.7)
    refused(DataError, "two samples a period of 2 s (amplitude and phase", "nyquist", f=0.5)
    refused(DataError, "each falls on a zero", "nyquist", f=0.5, phase=0.0)
    refused(DataError, "a drive of -1", "bad_period", f=-1.0)
    refused(DataError, "100 samples of the drive, 99 readings", "different_length", x=np.zeros(99))
    refused(DataError, "1 readings are missing", "gaps", x=np.where(np.arange(100) == 5, np.nan, 1.0))
    refused(DataError, "nothing but drive and drift", "no_scatter", x=np.ones(100))
    with pytest.raises(DataError, match="100 samples, 99 applied values"):
        applied_drive(TIMES, np.ones(99), 1.0 / PERIOD)
    with pytest.raises(DataError, match="does not vary"):
        applied_drive(TIMES, np.ones(100), 1.0 / PERIOD)
    with pytest.raises(DataError, match="finite and ascending"):
        sine_drive([0.0, 0.0, 1.0], 0.1)


def test_a_drive_at_half_of_the_sampling_frequency_needs_its_phase() -> None:
    drive = sine_drive(np.arange(100.0), 0.5, 0.5 * np.pi)
    assert drive.quadrature is None
    fit = fit_line(design_of(drive), 2.0 * np.tile([1.0, -1.0], 50) + NOISE)
    assert fit.in_phase[0] == pytest.approx(2.0, abs=1e-5)


def test_a_window_that_is_no_whole_number_of_cycles_does_no_harm() -> None:
    times = np.arange(103.0)
    x = np.sin(2 * np.pi * 0.25 * times + 0.3) + 0.02 * times + 1e-6 * np.random.default_rng(1).standard_normal(103)
    fit = fit_line(design_of(sine_drive(times, 0.25, 0.3)), x)
    assert fit.in_phase[0] == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("dof", [3.0, 12.0, 1e9])
def test_chance_that_noise_makes_an_amplitude_is_rayleighs(dof: float) -> None:
    """exp(-C^2 / 2 s^2), and (1 + C^2 / nu s^2)^(-nu / 2) where s has nu degrees of freedom."""
    u, C = 0.2, np.hypot(0.3, 0.4)
    found = amplitude_of(0.3, 0.4, u, dof).chance[0]
    known = np.exp(-0.5 * (C / u) ** 2)
    assert found == pytest.approx(known if dof > 1e6 else (1.0 + (C / u) ** 2 / dof) ** (-0.5 * dof), rel=1e-5)


def test_the_most_likely_amplitude_leaves_zero_where_the_length_passes_root_two_of_its_noise() -> None:
    """Just above, the series of I1/I0 gives A^2 = 16 (C^2 / 2 - 1) / C^4; farther up A is where Rice's law peaks."""
    assert np.all(most_likely(np.array([0.0, 1.0, 1.414])) == 0.0)
    C = np.sqrt(2.0 + np.array([1e-4, 1e-3]))
    np.testing.assert_allclose(most_likely(C) ** 2, 16.0 * (0.5 * C**2 - 1.0) / C**4, rtol=1e-3)
    amplitudes = np.linspace(0.0, 6.0, 6001)
    for length in (1.6, 1.9, 2.5, 5.0):
        peak = amplitudes[np.argmax(stats.rice.logpdf(length, amplitudes))]
        assert most_likely(np.array([length]))[0] == pytest.approx(peak, abs=1e-3)
