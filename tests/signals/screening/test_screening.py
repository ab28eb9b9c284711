"""Closed forms and symmetries of the screening: blocks and medians against numpy, faults where they were put."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import screening_records as records
from hypothesis import given
from hypothesis import settings as tried
from hypothesis import strategies as st
from numpy.typing import NDArray

from inertialcal.core.errors import DataError
from inertialcal.signals.remembered import forget
from inertialcal.signals.screening import _kernels
from inertialcal.signals.screening import screen as screen_module
from inertialcal.signals.screening.blocks import blocks_of, pieces
from inertialcal.signals.screening.glitches import ranks_of
from inertialcal.signals.screening.levels import level_steps, noise_changes, slow_wave
from inertialcal.signals.screening.loops import Loops, loops_for
from inertialcal.signals.screening.remarks import remarks_of
from inertialcal.signals.screening.resolution import Resolution, resolution_of
from inertialcal.signals.screening.screen import Screening, screen

KINDS = ("f8", ">f8", "f4", "i2", "i4", "u2", "i8", "i1")
NONE = np.empty(0, dtype=np.int64)


def rng(seed: int = 1) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize("kind", KINDS)
def test_blocks_are_those_of_numpy(kind: str) -> None:
    x = (30.0 * rng().standard_normal(1007) + 60.0 * (kind == "u2")).clip(0 if kind == "u2" else -120, 120).astype(kind)
    found = blocks_of(x)
    for k in range(len(found)):
        w = x[k * found.size : (k + 1) * found.size].astype(np.float64)
        step = np.diff(w)
        assert (found.lo[k], found.hi[k], found.count[k]) == (w.min(), w.max(), len(w))
        assert found.mean[k] == pytest.approx(w.mean(), rel=1e-12, abs=1e-12)
        assert found.rough[k] == pytest.approx(0.5 * np.mean(step**2), rel=1e-12)
        assert found.same[k] == np.count_nonzero(step == 0.0)


def test_missing_samples_are_left_out_of_blocks() -> None:
    x = rng().standard_normal(160)
    x[3:6], x[32:48], x[100] = np.nan, np.inf, -np.inf
    found = blocks_of(x)
    good = x[:16][np.isfinite(x[:16])]
    assert (found.count[0], found.lo[0], found.hi[0]) == (13, good.min(), good.max())
    assert found.mean[0] == pytest.approx(good.mean())
    assert found.count[2] == 0
    assert np.isnan([found.mean[2], found.lo[2], found.hi[2], found.rough[2]]).all()
    assert screen(x)["missing"].places.tolist() == [[3, 5], [32, 47], [100, 100]]
    assert screen(x)["missing"].count == 20


def test_blocks_without_some_samples_are_blocks_with_them_missing() -> None:
    x = rng().standard_normal(1000)
    skip = np.array([5, 17, 18, 500, 999])
    missing = x.copy()
    missing[skip] = np.nan
    one, other = blocks_of(x).without(skip), blocks_of(missing)
    for name in ("lo", "hi", "mean", "rough", "same", "count"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_blocks_of_a_long_record_are_small() -> None:
    x = np.zeros(3_000_000, dtype=np.float32)
    found = blocks_of(x)
    assert sum(part.nbytes for part in (found.lo, found.hi, found.mean, found.rough, found.same, found.count)) < (
        0.1 * x.nbytes
    )
    assert np.shares_memory(found.x, x)


@pytest.mark.parametrize(("first", "stop"), [(50, 250), (0, 300), (7, 20), (290, 300)])
@pytest.mark.parametrize("missing", [0, 40, 250])
def test_running_median_is_that_of_numpy(missing: int, first: int, stop: int) -> None:
    x = np.rint(3.0 * rng().standard_normal(300))
    x[rng(2).integers(0, 300, missing)] = np.nan
    off = np.empty(stop - first)
    _kernels.from_median(np.where(np.isnan(x), np.inf, x), first, stop, off)
    own = [x[i] - np.nanmedian(np.append(x[max(i - 15, 0) : i + 16], np.nan)) for i in range(first, stop)]
    np.testing.assert_array_equal(off, own)


def test_pieces_side_by_side_are_what_each_is_alone() -> None:
    x = rng().standard_normal(400)
    x[100] = np.nan
    first = np.array([0, 40, 80, 130, 170, 300, 340])
    off = np.empty((7, 40))
    _kernels.fill_pieces(x, first, off)
    for own, at in zip(off, first.tolist(), strict=True):
        alone = np.empty(40)
        _kernels.from_median(x, at, at + 40, alone)
        np.testing.assert_array_equal(own, alone)


@pytest.mark.parametrize("other", ["python", "numpy"])
def test_loops_say_the_same_without_the_compiler(other: str) -> None:
    x = np.abs(np.rint(8.0 * rng().standard_normal(300)))
    x[40], x[200:220] = np.nan, 3.0
    bits, which, skip = x.view(np.int64), np.arange(10), np.array([7, 90])
    flip, inf = np.int64(2**63 - 1), np.array(np.inf).view(np.int64)[()]

    def filled(by: str) -> list[Any]:
        def loop(name: str) -> Callable[..., Any]:
            if by == "numpy" and name != "from_median":
                return getattr(Loops, name)  # type: ignore[no-any-return]
            kernel = getattr(_kernels, name)
            return kernel.py_func if by == "python" else kernel  # type: ignore[no-any-return]

        lo, hi = np.zeros((2, 10), dtype=np.int64)
        mean, rough, far, off, apart, bent = np.zeros((6, 10))
        same, count, place = np.zeros((3, 10), dtype=np.int32)
        at, starts, stops = np.zeros((3, 10), dtype=np.int64)
        prints = np.zeros(10, dtype=np.uint64)
        parts = (lo, hi, mean, rough, same, count)
        found = [loop("fill_blocks")(x, bits, 32, flip, inf, *parts)]
        found += [part.copy() for part in parts]
        loop("fill_patched")(x, bits, 32, flip, which, skip, *parts)
        found += [loop("fill_far")(x, 32, which, 12.0, 10.0, at, far), loop("longest_equal")(bits, 180, 260)]
        found += [loop("fill_runs")(x, 32, which, 3.0, starts, stops)]
        loop("from_median")(x, 30, 40, off)
        loop("fill_apart")(np.arange(30.0) ** 2, 4, apart)
        loop("fill_bent")(np.arange(30.0) ** 2, 4, bent)
        with np.errstate(over="ignore"):
            loop("fill_prints")(bits, 32, prints, place)
        return [*found, *parts, at, far, starts, stops, off, apart, bent, prints, place]

    for one, same in zip(filled("compiler"), filled(other), strict=True):
        np.testing.assert_array_equal(one, same)


@pytest.mark.parametrize("kind", ["f8", "f4", "i4"])
def test_short_records_show_what_long_ones_do(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    draw = rng(9)
    for seed in range(6):
        x = np.rint(20.0 * draw.standard_normal(6_000))
        x[100 * seed] = 4_000.0
        x[2_000:2_030], x[4_000:4_600], x[5_000:] = 7.0, x[1_000:1_600], x[5_000:] + 40.0 * (seed % 2)
        x = np.minimum(x, 60.0 if seed > 3 else 1e4).astype(kind)
        if kind != "i4":
            x[3_000 : 3_000 + 5 * seed] = np.nan
        with monkeypatch.context() as patched:
            own = screen(x)
            patched.setattr(loops_for, "_short", 0)
            forget()
            compiled = screen(x)
        assert own.codes == compiled.codes
        assert own.codes
        for one, other in zip(own.findings, compiled.findings, strict=True):
            np.testing.assert_array_equal(one.places, other.places)
            np.testing.assert_array_equal(one.size, other.size)


@pytest.mark.parametrize("kind", ["white", "walk", "codes", "glitches", "drift", "heavy", "swings", "zeros"])
def test_ranks_of_distances_from_the_median_are_exact(kind: str) -> None:
    taken = 0
    for seed in range(1, 9):
        draw = rng(seed)
        n = int(draw.integers(64, 9_000))
        x, at = draw.standard_normal(n), np.arange(n)
        x[draw.integers(0, n, 5)] *= 1e4 if kind == "glitches" else 1.0
        x = {
            "walk": np.cumsum(x), "codes": np.rint(x * draw.choice([0.3, 3.0, 30.0])), "drift": x + 1e-3 * at,
            "heavy": draw.standard_t(2.0, n), "swings": 100.0 * np.sin(0.01 * at) + x,
            "zeros": np.where(draw.random(n) < 0.5, 0.0, x),
        }.get(kind, x).astype(draw.choice(["f8", "f4"]))  # fmt: skip
        first, rows = pieces(x)
        off = np.empty_like(rows)
        _kernels.fill_pieces(x, first, off)
        ranks = np.unique((np.array([0.6827, 0.95, 0.99, 0.999]) * rows.size).astype(np.int64))
        found = np.empty(len(ranks))
        if _kernels.fill_ranked(x, rows.size, ranks, found):
            taken += 1
            np.testing.assert_array_equal(found, np.sort(np.abs(off), axis=None)[ranks])
    x[n // 2] = np.nan
    assert not _kernels.fill_ranked(x, rows.size, ranks, found)
    assert taken >= 4


def test_every_rank_of_a_short_record_is_one_of_its_distances() -> None:
    for many in range(64, 200):
        ranks, _ = ranks_of(many)
        assert 0 <= ranks[0] < ranks[-1] < many


@pytest.mark.parametrize("seed", range(1, 5))
def test_what_is_not_looked_for_is_not_there(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against the search itself: of noise, walks, codes, steps, waves, louder halves and nothing."""
    draw, n = rng(seed), 6_000
    white = draw.standard_normal(n)
    half = np.arange(n) >= n // 2
    kinds = {
        "white": white, "walk": np.cumsum(white), "codes": np.rint(white), "constant": np.zeros(n),
        "step": white + 0.6 * half, "louder": white * (1.0 + 0.25 * half),
        "wave": white + 0.25 * np.sin(np.arange(n) / 60.0), "drift": white + 1e-3 * np.arange(n),
    }  # fmt: skip
    skipped = 0
    for x in kinds.values():
        blocks = blocks_of(x)
        found = []
        for own in (Loops, _kernels):
            monkeypatch.setattr("inertialcal.signals.screening.levels.loops_for", lambda _, own=own: own)
            none = np.empty(0, dtype=np.int64)
            found.append(
                (noise_changes(blocks.rough, 0.0), level_steps(blocks.mean, none, 0.0), slow_wave(blocks.mean, 0.0))
            )
        assert found[0] == found[1]
        skipped += sum(not one for one in found[1])
    assert 8 < skipped < 24


@pytest.mark.parametrize("kind", ["f8", "f4", "i4"])
def test_loops_are_equal_to_the_last_bit(kind: str) -> None:
    draw = rng(4)
    for _ in range(4):
        x = np.rint(30.0 * draw.standard_normal(3_001)).astype(kind)
        x[200:230], x[2_000:2_300] = 7, x[1_000:1_300]
        if kind != "i4":
            x[draw.integers(0, len(x), 60)] = np.nan
        bits = x.view(f"i{x.dtype.itemsize}") if kind != "i4" else x
        first, which = np.arange(0, 2_900, 97), np.arange(0, 94, 2)
        outs: list[list[np.ndarray[Any, Any]]] = []
        for loops in (Loops, _kernels):
            off = np.empty((len(first), 64))
            at, size, starts, stops = np.zeros((4, 500), dtype=np.int64)
            far = size.astype(float)
            prints, place = np.zeros(94, dtype=np.uint64), np.zeros(94, dtype=np.int32)
            loops.fill_pieces(x, first, off)
            counts = [loops.fill_far(x, 32, which, 60.0, 50.0, at, far)]
            counts += [loops.fill_runs(x, 32, which, 7.0, starts, stops), *loops.longest_equal(bits, 190, 240)]
            counts += [loops.squared_runs(bits)]
            loops.fill_prints(bits, 32, prints, place)
            outs.append([off, at, far, starts, stops, prints, place, np.array(counts)])
        for own, compiled in zip(*outs, strict=True):
            np.testing.assert_array_equal(own, compiled)


def test_a_step_contrast_shows_two_thirds_of_a_step_and_nothing_of_a_slope() -> None:
    out = np.empty(60 - 16 + 1)
    for y, expected in ((np.arange(60.0), 0.0), (np.where(np.arange(60) < 30, 0.0, 1.5), 1.0)):
        sums = np.concatenate(([0.0], np.cumsum(y)))
        _kernels.fill_bent(sums, 4, out)
        assert out[30 - 8] == pytest.approx(expected, abs=1e-12)


# Faults where they were put


def test_a_glitch_is_one_sample_and_its_size() -> None:
    x = rng().standard_normal(10_000)
    x[777] = 40.0
    found = screen(x)
    assert found.codes == ("glitch",)
    glitch = found["glitch"]
    assert (glitch.first, glitch.last, glitch.count) == (777, 777, 1)
    assert glitch.size[0] == pytest.approx(40.0, rel=0.1)
    assert found.noise == pytest.approx(1.0, rel=0.1)


def test_glitches_of_any_number_do_not_hide_themselves() -> None:
    x = rng().standard_normal(50_000)
    at = np.sort(rng(2).choice(50_000, 250, replace=False))
    x[at] += 60.0
    mask = screen(x).screened(x)
    assert mask[at].all()
    assert mask.sum() < 1.1 * len(at)


def test_more_than_ten_samples_are_a_disturbance() -> None:
    x = rng().standard_normal(10_000)
    x[5000:5014:2] += 60.0
    found = screen(x)
    assert found.codes == ("disturbed",)
    assert found["disturbed"].places.tolist() == [[5000, 5012]]


def test_a_stretch_that_is_stuck_is_the_stretch() -> None:
    x = np.rint(5.0 * rng().standard_normal(20_000)).astype(np.int16)
    x[5000:5400] = 3
    found = screen(x)
    assert found.codes == ("stuck",)
    stuck = found["stuck"]
    assert stuck.value.tolist() == [3.0]
    assert (stuck.first, stuck.last) == pytest.approx((5000, 5399), abs=2)


def test_the_end_of_a_converter_shows_from_two_samples() -> None:
    codes = rng(5).normal(0, 9000, 5000).round().astype(np.int64)
    codes = codes[np.abs(codes) < 32767]
    codes[[10, 20]] = 32767
    found = screen(codes, at_rest=False)
    assert found.codes == ("saturated",)
    assert (found["saturated"].value.tolist(), found["saturated"].count) == ([32767.0, 32767.0], 2)


def test_noise_switches_settings_and_slow_channels_hold_nothing() -> None:
    draw = rng(6)
    levels = np.repeat([0.0, 1.5, -1.5, 3.0, -3.0, 4.5, -4.5, 0.0], 30)
    slow = np.round(np.sin(np.arange(20_000) * 3e-4) * 10 + draw.normal(0, 0.05, 20_000))
    settings = np.concatenate([levels, np.linspace(-4, 4, 23)])
    coarse = np.rint(0.3 * draw.normal(size=20_000) + 0.2)
    for x in (draw.normal(0, 5, 5000).round(), draw.integers(0, 2, 500), settings, slow, coarse):
        assert not {"saturated", "stuck"} & {*screen(x, at_rest=False).codes}


def test_a_constant_channel_is_stuck() -> None:
    for x in (np.full(5000, 1.5), np.zeros(5000, dtype=np.int32)):
        assert screen(x).codes == ("stuck",)
        assert screen(x)["stuck"].count == 5000


def test_samples_at_the_end_of_the_range_are_counted() -> None:
    x = np.clip(rng().standard_normal(20_000), -2.0, 1.5)
    found = screen(x)
    assert found.codes == ("saturated",)
    assert set(found["saturated"].value) == {-2.0, 1.5}
    assert found["saturated"].count == np.count_nonzero((x == -2.0) | (x == 1.5)) == found.screened(x).sum()


def test_noise_that_touches_its_extremes_is_not_saturated() -> None:
    for seed in range(20):
        x = rng(seed).standard_normal(20_000)
        x[np.argmax(x)] = np.partition(x, -2)[-2]
        assert "saturated" not in screen(x).codes
        assert "saturated" not in screen(np.rint(20.0 * x)).codes
        assert "saturated" not in screen(np.rint(3.0 * x).astype(np.int8)).codes


def test_a_code_of_a_converter_in_noise_is_not_its_end() -> None:
    x = np.rint(20.0 * rng().standard_normal(20_000)).astype(np.int16)
    assert screen((x - x.max() + 255).astype(np.int16)).codes == ()
    x[100:103] = 32767
    x[4000] = 32767
    assert screen(x).codes == ("glitch",)  # far from all else: no end of the range


def test_a_copy_is_placed_with_its_lag() -> None:
    x = rng().standard_normal(20_000)
    x[15_000:15_300] = x[2_345:2_645]
    found = screen(x)
    assert found.codes == ("repeated",)
    assert found["repeated"].places.tolist() == [[15_000, 15_299]]
    assert found["repeated"].value.tolist() == [15_000 - 2_345]


def test_a_record_repeated_thrice_is_left_with_the_first() -> None:
    x = np.tile(rng().standard_normal(3_000), 4)
    mask = screen(x).screened(x)
    assert not mask[:3_000].any()
    assert mask[3_000:].all()


def test_a_step_is_placed_within_a_window_and_sized() -> None:
    y = 0.1 * rng().standard_normal(2000)
    y[800:] += 2.0
    (step,) = level_steps(y, NONE, 0.0)
    assert step.at == pytest.approx(800, abs=2)
    assert step.size == pytest.approx(2.0, rel=0.2)


def test_a_change_of_noise_is_sized_as_a_logarithm() -> None:
    variance = rng().chisquare(32, 2000) / 32
    variance[1200:] *= 4.0
    (change,) = noise_changes(variance, 0.0)
    assert change.at == pytest.approx(1200, abs=8)
    assert change.size == pytest.approx(np.log(4.0), abs=0.3)


def test_a_wave_has_its_period_and_amplitude() -> None:
    y = rng().standard_normal(2000) + 0.7 * np.sin(2.0 * np.pi * np.arange(2000) / 130.0)
    wave = slow_wave(y, 0.0)
    assert wave is not None
    assert wave.period == pytest.approx(130.0, rel=0.02)
    assert wave.amplitude == pytest.approx(0.7, rel=0.15)
    assert slow_wave(y, 1.0) is None


def test_a_step_is_no_change_of_noise_and_the_other_way_round() -> None:
    for seed in range(10):
        x = rng(seed).standard_normal(30_000)
        x[12_000:] += 3.0
        assert screen(x).codes == ("level_step",)
        y = rng(seed).standard_normal(30_000)
        y[12_000:] *= 3.0
        assert screen(y).codes == ("noise_change",)


def test_a_sensor_that_moves_is_not_judged_as_one_at_rest() -> None:
    t = np.arange(20_000) / 100.0
    x = np.sin(t) + np.sign(np.sin(0.3 * t)) + 0.003 * rng().standard_normal(len(t))
    assert screen(x, at_rest=False).codes == ()
    x[4321] = -30.0
    assert screen(x, at_rest=False)["glitch"].first == pytest.approx(4321, abs=2)


@pytest.mark.parametrize("n", [0, 1, 2, 5, 30, 70, 200])
def test_short_records_of_any_kind_are_looked_through(n: int) -> None:
    for x in (rng().standard_normal(n), np.zeros(n), np.full(n, np.nan), np.arange(n), np.full(n, np.inf)):
        assert isinstance(screen(x), Screening)


PARTS: dict[str, Callable[[np.random.Generator, int], NDArray[Any]]] = {
    "noise": lambda r, n: r.standard_normal(n),
    "codes": lambda r, n: r.integers(-2, 3, n).astype(np.float64),
    "cauchy": lambda r, n: r.standard_cauchy(n),
    "held": lambda r, n: np.full(n, 0.25),
    "lost": lambda r, n: np.full(n, np.nan),
    "gaps": lambda r, n: np.where(np.arange(n) % 2, np.nan, 1.0),
    "ramp": lambda r, n: 0.1 * np.arange(n),
    "saw": lambda r, n: np.arange(n) % 16.0,
    "infinite": lambda r, n: np.full(n, -np.inf),
}


@tried(max_examples=150)
@given(
    parts=st.lists(st.tuples(st.sampled_from(sorted(PARTS)), st.integers(1, 700)), min_size=1, max_size=6),
    seed=st.integers(0, 100),
    kind=st.sampled_from(["f8", "f4"]),
    at_rest=st.booleans(),
)
def test_anything_is_looked_through(parts: list[tuple[str, int]], seed: int, kind: str, at_rest: bool) -> None:
    x = np.concatenate([PARTS[name](rng(seed), n) for name, n in parts]).astype(kind)
    found = screen(x, at_rest)
    assert found.samples == len(x)
    for one in found.findings:
        assert one.count > 0
        assert 0 <= one.first <= one.last < len(x)
        assert (np.diff(one.places, axis=1) >= 0).all()
        assert len(one.places) == len(one.size) == len(one.value)
    remarks_of(found, "x")
    mask = found.screened(x)
    assert mask[~np.isfinite(x)].all()


@pytest.mark.parametrize("kind", ["i1", "i2", "u2", "i8", "u8"])
def test_whole_numbers_of_any_size_are_looked_through(kind: str) -> None:
    ends = np.iinfo(kind)
    x = rng().integers(ends.min, ends.max, 5000, dtype=kind, endpoint=True)
    assert screen(x).codes == ()
    x[700:1000] = x[700]
    assert "stuck" in screen(x)


def test_huge_and_tiny_numbers_are_looked_through() -> None:
    for scale in (1e300, 1e-300, 5e-324):
        assert isinstance(screen(scale * rng().standard_normal(3000).round(2)), Screening)


def test_what_is_no_channel_is_refused() -> None:
    for x in (np.zeros((3, 2)), np.array(["a", "b"]), np.zeros(9, dtype=complex)):
        with pytest.raises(DataError, match="channel"):
            screen(x)


# Symmetries


def faulty(seed: int) -> NDArray[np.float64]:
    """A record of 64 times 128 samples with a glitch, a stuck stretch, a copy and a step."""
    x = rng(seed).standard_normal(8192)
    x[6000:] += 4.0
    x[100 + seed % 50] += 50.0
    x[2000:2100] = x[2000]
    x[4000:4200] = x[3000:3200]
    return x


def shown(found: Screening) -> list[Any]:
    return [(one.code, one.places.tolist(), one.count) for one in found.findings]


@tried(max_examples=20)
@given(seed=st.integers(0, 10_000), power=st.integers(-40, 40), sign=st.sampled_from([-1.0, 1.0]))
def test_findings_do_not_hang_on_scale_and_sign(seed: int, power: int, sign: float) -> None:
    x = faulty(seed)
    one, other = screen(x), screen(x * sign * 2.0**power)
    assert {"glitch", "stuck", "repeated", "level_step"} <= set(one.codes)
    assert shown(one) == shown(other)
    assert other.noise == one.noise * 2.0**power


@tried(max_examples=20)
@given(seed=st.integers(0, 10_000), shift=st.integers(-(2**20), 2**20))
def test_findings_do_not_hang_on_the_level(seed: int, shift: int) -> None:
    x = np.rint(32.0 * faulty(seed)).astype(np.int64)
    found = screen(x + shift)
    assert shown(screen(x)) == shown(found)


@tried(max_examples=20)
@given(seed=st.integers(0, 10_000))
def test_findings_turn_round_with_time(seed: int) -> None:
    x = faulty(seed)
    one, other = screen(x), screen(x[::-1].copy())
    assert set(one.codes) == set(other.codes)
    for code in ("glitch", "stuck"):
        turned = len(x) - 1 - other[code].places[::-1, ::-1]
        assert turned.tolist() == one[code].places.tolist()
    assert other["repeated"].count == one["repeated"].count


# Remarks


def test_each_finding_has_a_remark_that_says_where_and_how_much() -> None:
    x = faulty(1)
    x[7000] = np.nan
    found = screen(x)
    remarks = remarks_of(found, "x", place=lambda i: f"row {i + 2}", interval=0.02)
    assert tuple(one.code for one in remarks) == found.codes
    text = {one.code: str(one) for one in remarks}
    assert "row 103: x: 1 of 8192 samples lies up to 5" in text["glitch"]
    assert "for 2 s in all" in text["stuck"]
    assert "200 of 8192 samples repeat those 20 s before" in text["repeated"]
    assert "steps by up to" in text["level_step"]
    assert "1 of 8192 samples is missing" in text["missing"]


@pytest.mark.parametrize("fault", records.FAULTS)
def test_every_kind_of_finding_can_be_said(fault: str) -> None:
    record, code, at_rest = records.FAULTS[fault]
    found = screen(record(rng(3)), at_rest)
    (remark,) = [one for one in remarks_of(found, "gyro z") if one.code == code]
    assert remark.what.startswith("gyro z: ")
    assert remark.index == found[code].first
    assert "nan" not in remark.what


# Resolution


def test_resolution_is_that_of_codes_digits_or_floats() -> None:
    x = rng().standard_normal(5000)
    assert resolution_of(np.rint(50.0 * x).astype(np.int16)).step == 1.0
    assert resolution_of(np.round(x, 2)).step == pytest.approx(0.01)
    largest = float(np.abs(x).max())
    assert resolution_of(x).step == np.spacing(largest)
    assert resolution_of(x.astype(np.float32).astype(np.float64)).step == np.spacing(np.float32(largest))


def test_a_line_below_a_step_counts_only_in_noise_that_hides_rounding() -> None:
    found = Resolution(step=1.0, swing=100.0)
    density = found.density(0.01)
    assert density == pytest.approx(2.0 * 0.01 / 12.0)
    quiet, loud = 2.0 * density, 20.0 * density
    assert found.hides([0.5, 2.0], quiet, 0.01).tolist() == [True, False]
    assert found.hides([0.5, 0.9e-4], loud, 0.01).tolist() == [False, True]


def test_the_continuum_is_the_same_to_the_bit_in_a_loop_and_in_numpy() -> None:
    rng = np.random.default_rng(4)
    k = np.arange(1.0, 300.0)
    part = np.array([k**power for power in (0.0, -1.0, -2.0)])
    values = (3.0 + 50.0 / k) * rng.exponential(size=len(k))
    values[40] *= 100.0
    found = []
    for fit in (_kernels.fit_powers, Loops.fit_powers):
        weight = np.ones(3)
        fit(part, values, 60, weight)
        found.append(weight)
    assert found[0].tolist() == found[1].tolist()
    level = found[0] @ part
    assert np.mean(np.minimum(values, 5.0 * level) / level) == pytest.approx(1.0, abs=0.01)  # as the likelihood asks


def test_nothing_is_passed_over_that_the_searches_find(monkeypatch: pytest.MonkeyPatch) -> None:
    n = 2000
    wave = np.sin(2.0 * np.pi * 8.0 * np.arange(n) / n)
    made = []
    for size in (0.0, 0.1, 0.3, 1.0, 3.0):
        x = rng(int(10.0 * size)).normal(size=(7, n))
        x[1, n // 2 :] += size
        x[2, n // 3 :] *= 1.0 + 0.3 * size
        x[3] += 0.3 * size * wave
        x[4, 700] += 4.0 * size
        x[5] = np.clip(x[5], -5.0, 4.0 - 0.5 * size)
        x[6] = np.round(x[6], int(4.0 - size))
        made += [*x]
    monkeypatch.setattr(loops_for, "_few", 0)  # compiled
    both = [(x.astype(kind), at_rest) for x in made for at_rest in (True, False) for kind in ("f8", "f4")]
    looked = [screen(*one) for one in both]
    passed = [screen_module._sound(*one) is not None for one in both]
    searched = [screen_module._searched(*one) for one in both]
    assert [shown(one) for one in looked] == [shown(one) for one in searched]
    for (x, _), own, one in zip(both, looked, searched, strict=True):
        assert (own.noise, own.step) == ((one.noise, one.step) if one.findings else (0.0, 0.0))
        assert one.findings or screen_module.noise_of(x) == one.noise
    assert sum(passed) > 0.8 * sum(not one.findings for one in searched) > 20


@pytest.mark.parametrize("kind", ["white", "walk", "drift", "glitches", "far"])
def test_samples_that_count_as_far_from_their_median_are(kind: str) -> None:
    for seed in range(8):
        draw, n = rng(seed), 1_000 + 37 * seed
        x = draw.standard_normal(n) + 1e6 * (kind == "far")
        x = np.cumsum(x) if kind == "walk" else x + 0.002 * np.arange(n) * (kind == "drift")
        if kind == "glitches":
            x[draw.integers(0, n, 20)] *= 1e3
        off = np.abs(x[15:-15] - np.median(np.lib.stride_tricks.sliding_window_view(x, 31), axis=1))
        mean, m = np.array([x[k : k + 16].mean() for k in range(0, n, 16)]), n // 64 * 64
        for apart in np.quantile(off, (0.1, 0.5, 0.68, 0.95)).tolist():
            found = _kernels._count_far(x, m, apart, mean)
            exact = int(np.count_nonzero(off[: m - 15] > apart))
            assert found <= exact
            assert found > 0.8 * exact - 10 or kind not in ("white", "far")


@pytest.mark.parametrize("kind", ["noise", "codes", "short", "zeros", "huge", "mostly codes"])
def test_resolution_is_the_same_in_a_loop_and_in_numpy(kind: str) -> None:
    for seed in range(10):
        draw = rng(seed)
        x = 10.0 ** draw.uniform(-6.0, 6.0) * draw.standard_normal((int(draw.integers(1, 40)), 64))
        x = {
            "codes": np.rint(3.0 * x), "short": x.astype(np.float32).astype(np.float64), "zeros": 0.0 * x,
            "huge": 1e60 * x, "mostly codes": np.where(draw.random(x.shape) < 0.08, x, np.rint(1e3 * x)),
        }.get(kind, x)  # fmt: skip
        for times in (1.0, 57.29577951308232):
            given = x / times, times, 0.05, 0.9, 4.0
            assert _kernels.resolved(*given) == Loops.resolved(*given)


def test_logarithms_that_are_taken_side_by_side() -> None:
    rng = np.random.default_rng(5)
    root = np.nextafter(np.sqrt(0.5), [0.0, 1.0])
    x = np.concatenate((10.0 ** rng.uniform(-299.0, 300.0, 1000), rng.uniform(0.1, 4.0, 1000), root, 2.0 * root, [1.0]))
    found = x.copy()
    _kernels._take_logs(found)
    np.testing.assert_allclose(found, np.log(x), rtol=4e-16, atol=4e-16)


def test_a_part_that_is_far_above_the_rest_has_its_logarithms_from_the_median() -> None:
    rng = np.random.default_rng(6)
    mean, rough = rng.normal(size=1250), rng.chisquare(15, 1250) / 15.0
    none = np.empty(0, dtype=np.int64), np.empty(0)
    limits = np.full(7, 8.0)
    assert not _kernels.may_differ(mean, rough, 0.37, limits, *none, 2048)
    rough[600:] *= 1e4
    assert _kernels.may_differ(mean, rough, 0.37, limits, *none, 2048)
    rough[:] = 0.0
    assert not _kernels.may_differ(mean, rough, 0.37, limits, *none, 2048)
