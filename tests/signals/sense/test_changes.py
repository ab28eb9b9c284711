"""Changes of unit, sign, scale and axis inside a record: each is found where it is, and clean records have none."""

from typing import Any

import numpy as np
import pytest

from inertialcal.rigs.rate_table.rig import build
from inertialcal.rigs.rate_table.setup import Bench
from inertialcal.signals.sense import _kernels, jumps
from inertialcal.signals.sense.change import FACTORS, Change
from inertialcal.signals.sense.changes import _by_noise, changes
from inertialcal.signals.sense.noise import LEAST_NOISE, Noise
from inertialcal.signals.sense.response import exchanged_response

N, AT = 3000, 1234
DEG = 180.0 / np.pi
BIAS = np.array([0.02, -0.05, 0.03])


def still(seed: int = 1, bias: np.ndarray = BIAS, sigma: float = 0.003) -> np.ndarray:
    return bias + sigma * np.random.default_rng(seed).standard_normal((N, 3))


def by_hand(seed: int = 1) -> np.ndarray:
    """Return gravity in a body that is turned smoothly from rest to rest [m/s^2], shape (N, 3)."""
    rng = np.random.default_rng(seed)
    angles = np.zeros((N, 2))
    for first in range(200, N - 300, 500):
        s = np.clip((np.arange(N) - first) / 150.0, 0.0, 1.0)
        angles += rng.uniform(-2.0, 2.0, 2) * (s - np.sin(2 * np.pi * s) / (2 * np.pi))[:, None]
    a, b = angles.T + np.array([[0.7], [0.4]])
    up = np.column_stack([np.sin(a), -np.cos(a) * np.sin(b), np.cos(a) * np.cos(b)])
    return 9.81 * up + [0.1, -0.2, 0.1] + 0.01 * rng.standard_normal((N, 3))


def on_table(seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Return rates of a triad about x, and what was applied [rad/s]."""
    levels = np.repeat([0.0, -0.2, -0.1, 0.0, 0.1, 0.2], N // 6)
    applied = np.convolve(levels, np.ones(20) / 20, mode="same")
    return np.outer(applied, [1.0, 0.003, -0.002]) + 0.1 * still(seed), applied


def judged(x: np.ndarray, kind: str = "angular_rate", **more: Any) -> tuple[Change, ...]:
    return changes(list(x.T), "xyz"[: x.shape[1]], kind, 0.01, **more)


@pytest.mark.parametrize(
    ("factor", "units"),
    [(1 / DEG, ("deg/s", "rad/s")), (DEG, ("rad/s", "deg/s")), (1e-3, ("its thousandth", "a unit"))],
)
def test_unit_of_a_record_at_rest(factor: Any, units: Any) -> None:
    x = still()
    x[AT:] *= factor
    (found,) = judged(x)
    assert (found.code, found.units, found.channels) == ("unit_changed", units, ("x", "y", "z"))
    assert found.factor == pytest.approx(factor)
    assert abs(found.index - AT) < 20


def test_unit_without_a_level_shows_in_the_noise_of_two_channels() -> None:
    x = still(bias=np.zeros(3))
    x[AT:] /= DEG
    assert [one.code for one in judged(x)] == ["unit_changed"]
    assert judged(x[:, :1]) == ()  # one channel may be quieter for any reason


def test_a_scale_that_is_no_unit() -> None:
    x = still(bias=np.array([3.0, 1.0, -2.0]))
    x[AT:] *= 2.0
    (found,) = judged(x)
    assert (found.code, found.index) == ("scale_changed", AT)
    assert found.factor == pytest.approx(2.0, rel=0.01)


@pytest.mark.parametrize(("before", "after", "noise"), [(101_325.0, 1e-3, 2e-2), (4.85, 5.15, 4e-5), (4.85, 5.15, 0.0)])
def test_a_scale_that_changes_with_a_condition_is_none(before: float, after: float, noise: float) -> None:
    x = still(bias=np.array([3.0, 1.0, -2.0]))
    x[AT:] *= 2.0
    gauge = 1.0 + noise * np.random.default_rng(2).standard_normal(N)
    assert [one.code for one in judged(x, conditions=[before * gauge])] == ["scale_changed"]
    stepped = np.where(np.arange(N) < AT, before, after) * gauge
    assert judged(x, conditions=[stepped]) == ()
    slow = np.interp(np.arange(N), [AT - 200, AT + 200], [before, after]) * gauge
    assert [one.code for one in judged(x, conditions=[slow])] == ["scale_changed"]
    x[AT:] *= 0.5 * DEG
    assert [one.code for one in judged(x, conditions=[stepped])] == ["unit_changed"]


@pytest.mark.parametrize("record", [still, by_hand])
@pytest.mark.parametrize("axes", [[0, 1, 2], [2]])
def test_sign(record: Any, axes: Any) -> None:
    x, kind = record(), "angular_rate" if record is still else "acceleration"
    x[AT:, axes] *= -1.0
    (found,) = judged(x, kind)
    assert (found.code, found.index, found.channels) == ("sign_changed", AT, tuple("xyz"[i] for i in axes))


@pytest.mark.parametrize("order", [(1, 2, 0), (1, 0, 2)])
def test_axes(order: Any) -> None:
    x = by_hand()
    x[AT:] = x[AT:, list(order)]
    (found,) = judged(x, "acceleration")
    assert (found.code, found.index) == ("axes_changed", AT)
    assert found.sources == tuple("xyz"[i] for i in order)
    assert "x goes on as y" in found.remark("row {}".format).what


def test_axes_of_another_sensor_have_another_bias() -> None:
    x = still(sigma=0.001)
    x[AT:] = x[AT:, [1, 2, 0]] + 0.07
    (found,) = judged(x)
    assert (found.code, found.sources) == ("axes_changed", ("y", "z", "x"))


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda x: -x, "sign_changed"),
        (lambda x: x * DEG, "unit_changed"),
        (lambda x: x[:, [2, 0, 1]], "axes_changed"),
        (lambda x: 1.8 * x, "scale_changed"),
    ],
)
def test_response_to_an_applied_rate(change: Any, code: Any) -> None:
    x, applied = on_table()
    assert judged(x, applied=applied, at_rest=False) == ()
    x[AT:] = change(x[AT:])
    (found,) = judged(x, applied=applied, at_rest=False)
    assert found.code == code
    assert abs(found.index - AT) <= 20


def test_remark_says_where_and_what() -> None:
    x = still()
    x[AT:] /= DEG
    (found,) = judged(x)
    remark = found.remark(lambda index: f"file.csv:{index}")
    assert (remark.code, remark.severity, remark.where) == ("unit_changed", "error", f"file.csv:{found.index}")
    assert "from deg/s to rad/s" in remark.what


@pytest.mark.parametrize("kind", ["turn", "shake", "fall", "step", "spike", "gap", "quiet", "zeros", "coarse", "slow"])
def test_what_is_no_change_of_sense(kind: Any) -> None:
    rng = np.random.default_rng(3)
    x, unit, more = still(), "angular_rate", {}
    if kind == "turn":
        x, unit = by_hand(), "acceleration"
    elif kind == "shake":  # lies still, then is moved
        x[AT:] += 0.5 * rng.standard_normal((N - AT, 3)) * [1.0, 2.0, 0.7]
    elif kind == "fall":
        x, unit = by_hand(), "acceleration"
        x[AT:] = 0.01 * rng.standard_normal((N - AT, 3)) + [0.1, -0.2, 0.1]
    elif kind == "step":
        x[AT:] += [0.1, 0.0, 0.0]
    elif kind == "spike":
        x[AT] = -x[AT] * 100.0
    elif kind == "gap":  # laid on the other side meanwhile
        x, unit = by_hand(), "acceleration"
        x[AT:] *= -1.0
        more = {"breaks": np.array([AT])}
    elif kind == "quiet":  # the noise alone is less
        x[AT:] = BIAS + (x[AT:] - BIAS) / DEG
    elif kind == "zeros":
        x[AT:] = 0.0
    elif kind == "coarse":
        x = 0.05 * np.rint(x / 0.05)
    elif kind == "slow":  # an accelerometer of 1 Hz may be turned between two samples
        x, unit = by_hand(), "acceleration"
        x[AT:] *= -1.0
        assert changes(list(x.T), "xyz", unit, 1.0) == ()
        return
    assert judged(x, unit, **more) == ()


def test_a_long_record_is_averaged() -> None:
    n = 500_000
    rng = np.random.default_rng(5)
    x = [(b + 0.003 * rng.standard_normal(n)).astype(np.float32) for b in BIAS]
    for one in x:
        one[300_000:] *= -1.0
    (found,) = changes(x, "xyz", "angular_rate", 0.01)
    assert found.code == "sign_changed"
    assert abs(found.index - 300_000) < 40


def test_missing_samples_and_short_records() -> None:
    x = still()
    x[AT:] *= -1.0
    x[::7, 1] = np.nan
    (found,) = judged(x)
    assert found.code == "sign_changed"
    assert judged(x[:30]) == ()
    assert changes([], "") == ()


def exchanged(x: np.ndarray, first: int, second: int) -> np.ndarray:
    x = x.copy()
    x[AT:, [first, second]] = x[AT:, [second, first]]
    return x


@pytest.mark.parametrize("pair", [(0, 1), (0, 2)])
def test_an_exchange_on_a_table_names_no_more_axes_than_it_moves(pair: Any) -> None:
    x, applied = on_table()
    (found,) = judged(exchanged(x, *pair), applied=applied)
    moved = {a: b for a, b in zip(found.channels, found.sources, strict=True) if a != b}
    assert moved == {"xyz"[pair[0]]: "xyz"[pair[1]], "xyz"[pair[1]]: "xyz"[pair[0]]}


def test_an_exchange_of_axes_that_are_not_turned_shows_in_their_responses() -> None:
    x, applied = on_table()
    x[:, 1:] -= x[:, 1:].mean(axis=0)  # no jump
    at = int(np.flatnonzero(applied == 0.0)[-1])  # at rest
    x[at:, [1, 2]] = x[at:, [2, 1]]
    (found,) = judged(x, applied=applied)
    assert (found.code, found.sources) == ("axes_changed", ("x", "z", "y"))


def test_all_axes_change_places_on_a_table() -> None:
    x, applied = on_table()
    x[AT:] = x[AT:, [1, 2, 0]]
    (found,) = judged(x, applied=applied)
    assert found.sources == ("y", "z", "x")


def test_a_turned_sign_is_no_exchange_of_axes_of_opposite_bias() -> None:
    x, applied = on_table()
    x[:, 1:] += [0.01, -0.01] - x[:, 1:].mean(axis=0)
    x[AT:] *= -1.0
    assert [one.code for one in judged(x, applied=applied)] == ["sign_changed"]


@pytest.mark.parametrize("seed", range(1, 6))
def test_channels_that_drift_past_each_other_do_not_change_places(seed: Any) -> None:
    x, applied = on_table(seed)
    drift = 0.005 * np.tanh(np.linspace(-2.0, 2.0, N))
    assert judged(x + np.outer(drift, [0.0, 1.0, -1.0]), applied=applied) == ()


def test_a_small_jump_shows_beside_a_fast_turn() -> None:
    x = by_hand()
    x[:, 0] += 0.1 - x[AT - 20 : AT + 20, 0].mean()  # near zero at the change, while steps of a turn are larger
    x[AT:, 0] *= -1.0
    x[:, 1:] += 0.002 * np.arange(N)[:, None]
    assert np.abs(np.diff(by_hand(), axis=0)).max() > 0.1
    assert [one.code for one in judged(x, "acceleration")] == ["sign_changed"]


def test_gyros_at_rest_that_change_places_though_the_body_turns_later() -> None:
    x = still()
    x[200:400] += np.outer(np.sin(np.linspace(0.0, np.pi, 200)) ** 2, [0.0, 3.0, 0.0])
    assert judged(x, at_rest=False) == ()
    (found,) = judged(exchanged(x, 0, 1), at_rest=False)
    assert (found.code, found.sources) == ("axes_changed", ("y", "x", "z"))
    assert abs(found.index - AT) < 3


@pytest.mark.parametrize("seed", [1, 2, 3, 53, 77])
def test_dwells_that_scatter_are_no_exchange_of_axes(seed: int) -> None:
    """A stepped table: the last dwell is one draw of the scatter between dwells (53, 77: once taken for more)."""
    for name, recording in build(Bench(), seed).recordings.items():
        codes = np.column_stack([recording.channel(axis).data for axis in "xyz"])
        assert exchanged_response(codes, recording.channel("rate_dps").data, "xyz") is None, name


@pytest.mark.parametrize("kind", ["white", "steps", "codes", "walk", "level", "glitches"])
def test_no_jump_is_passed_over_unseen(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against the search itself, in records of any length."""
    seen = passed = 0
    for seed in range(1, 41):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(48, 6000))
        x = rng.standard_normal((n, int(rng.integers(1, 4)))) * 10.0 ** rng.integers(-6, 6)
        sigma = float(x.std())
        if kind == "steps":
            x[n // 2 :] += rng.choice([1.0, 3.0, 30.0]) * sigma
        x = np.rint(x / sigma) if kind == "codes" else np.cumsum(x, axis=0) if kind == "walk" else x
        x += 1e6 * sigma * (kind == "level")
        if kind == "glitches":
            x[rng.integers(0, n, 3)] *= rng.choice([5.0, 10.0, 1e3])
        found = []
        for own in (jumps.Loops, _kernels):
            monkeypatch.setattr(jumps, "loops_for", lambda _, own=own: own)
            found.append(jumps.candidates(x))
        assert found[0] == found[1]
        seen += len(found[0]) > 0
        given = 1, 4, 2, jumps.ABRUPT, jumps.LEAST, np.empty(1, dtype=np.int64)
        passed += not _kernels.fill_standing_out(np.ascontiguousarray(x.T), *given)
    assert seen or passed > 20


@pytest.mark.parametrize("kind", ["white", "step", "scale", "walk", "wave"])
def test_one_look_passes_no_change_over(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it sees nothing, the search finds neither a clear jump nor noise that changes as a unit does."""
    monkeypatch.setattr(jumps, "loops_for", lambda _: _kernels)
    passed = changed = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        n, k = int(rng.integers(60, 3000)), int(rng.integers(1, 4))
        x, at = rng.standard_normal((n, k)) * rng.uniform(0.1, 3.0, k), int(rng.integers(5, n - 5))
        x[at:] += rng.uniform(0.0, 10.0, k) * (kind == "step")
        x[at:] *= rng.choice([1.0, 2.9, DEG]) if kind == "scale" else 1.0
        x = np.cumsum(x, axis=0) if kind == "walk" else x
        x += (kind == "wave") * 20.0 * np.sin(0.03 * np.arange(n))[:, None]
        noise = Noise.of(x)
        columns, names = np.flatnonzero(noise.informative), "xyz"[:k]
        may = jumps.may_jump(x, noise.size, float(LEAST_NOISE))
        found = bool(
            jumps.jumps(x, np.zeros(n, dtype=bool), noise.size) or _by_noise(x, noise, names, FACTORS["angular_rate"])
        )
        assert len(columns) == k
        assert may or not found
        passed, changed = passed + (not may), changed + found
    assert changed > 5 if kind in ("step", "scale") else passed > 20 or kind == "walk"
